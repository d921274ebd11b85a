//! Experiment `order`: observed order of accuracy and error constant of every method.

use crate::facts::{Fact, fact};
use crate::methods::Choice;
use crate::methods::runs::Variant;
use crate::run::{Runner, Simulation};
use crate::studies::order::facts::{ACCEPTED, Facts, Row, Run, Scene};
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::studies::variant::of_registry;
use crate::studies::{Context, Measured, Start, prepared, taken};
use crate::{HarnessError, system_hash};
use drape_integrator::Order;
use drape_model::{DampingLaw, State, SystemSpec, TimeSpan};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::order::{Sample, observed_order, position_error};
use drape_oracle::reference::{Reference, reference};
use drape_report::Verdict;

/// Particles along each edge of the sheet.
const SIDE: u32 = 6;
/// Damping over mass of the tension springs, 1/s.
const DAMPING: f64 = 2.0;
/// Greatest displacement of a particle out of the plane at the start, m. In a flat sheet no spring
/// exerts a force across the plane.
const AMPLITUDE: f64 = 0.02;
/// Simulated time, s. Errors are taken at its end.
const SPAN: f64 = 0.25;
/// Number of step sizes. Each is half of the one before.
const SIZES: u32 = 4;
/// An error of at least this counts as diverged: it contains nothing about an order.
const BEYOND: f64 = 1.0;
/// Least number of runs for an order.
const FEWEST: usize = 3;

/// A scene, before its system is built.
#[derive(Clone, Copy, Debug)]
struct Case {
    id: &'static str,
    stiffness: f64,
    law: DampingLaw,
    /// Number of steps of the coarsest run.
    steps: u32,
    /// Whether the quick subset has this case.
    is_quick: bool,
}

const fn case(
    id: &'static str,
    stiffness: f64,
    law: DampingLaw,
    steps: u32,
    is_quick: bool,
) -> Case {
    Case { id, stiffness, law, steps, is_quick }
}

const CASES: [Case; 4] = [
    case("smooth", 400.0, DampingLaw::Full, 40, true),
    case("smooth-projected", 400.0, DampingLaw::Projected, 40, false),
    case("stiff-1e4", 1e4, DampingLaw::Full, 25, true),
    case("stiff-1e6", 1e6, DampingLaw::Full, 25, false),
];

/// A scene with its reference solution.
struct Setting {
    case: Case,
    simulation: Simulation,
    exact: Reference,
    hash: String,
    scene: Scene,
}

impl Case {
    fn sheet(&self) -> Sheet {
        Sheet {
            side: SIDE,
            tension: self.stiffness,
            shear: 0.25 * self.stiffness,
            damping: DAMPING,
            law: self.law,
            gravity: GRAVITY,
            is_pinned: true,
        }
    }

    fn spec(&self) -> Result<SystemSpec, HarnessError> {
        let mut spec = self.sheet().spec()?;
        for (i, position) in spec.particles.position_m.iter_mut().enumerate() {
            position[2] += AMPLITUDE * libm::sin(i as f64);
        }
        Ok(spec)
    }
}

impl Setting {
    fn new(case: &Case) -> Result<Self, HarnessError> {
        let spec = case.spec()?;
        let (system, state) = spec.build()?;
        let exact = reference(&system, &state, &[SPAN], AdaptiveSettings::default())?;
        let greatest_frequency = case.sheet().greatest_frequency(1.0);
        let scene = Scene {
            id: case.id.to_owned(),
            resolved: SPAN / f64::from(case.steps) * greatest_frequency < 0.5,
            stiffness_over_mass_per_s2: case.stiffness,
            damping_over_mass_per_s: DAMPING,
            damping: if case.law == DampingLaw::Full { "full" } else { "projected" }.to_owned(),
            greatest_frequency_per_s: greatest_frequency,
            span_s: SPAN,
            reference_error_m: exact.position_error,
            portable: false,
        };
        let hash = system_hash(&spec);
        Ok(Self { case: *case, simulation: Simulation { system, state }, exact, hash, scene })
    }

    /// The last state of the reference.
    fn end(&self) -> &State {
        self.exact.states.last().unwrap_or(&self.simulation.state)
    }

    fn run(&self, choice: &Choice, steps: u32) -> Result<Run, HarnessError> {
        let mut simulation = self.simulation.clone();
        let time = TimeSpan { step_s: SPAN / f64::from(steps), duration_s: SPAN };
        let outcome = Runner::new(choice, time).go(&mut simulation)?;
        let start = &self.simulation.state.x;
        let error = position_error(&simulation.system, start, &self.end().x, &simulation.state.x);
        let error = Some(error).filter(|e| outcome.divergence.is_none() && *e < BEYOND);
        Ok(Run {
            step_s: time.step_s,
            error,
            verdict: if error.is_some() { Verdict::Completed } else { Verdict::Diverged },
            unconverged_steps: outcome.unconverged,
        })
    }

    fn row(&self, variant: &Variant) -> Result<Row, HarnessError> {
        let choice = Choice::parse(variant.method, &[])?;
        let runs = (0..SIZES).map(|n| self.run(&choice, self.case.steps << n));
        let runs = runs.collect::<Result<Vec<_>, _>>()?;
        let theory = theory(variant.label, choice.method().order);
        let observed = Observed::of(&runs, theory);
        let complete = observed.fitted == runs.len();
        Ok(Row {
            scene: self.case.id.to_owned(),
            label: variant.label.to_owned(),
            method: choice.full_id(),
            theory,
            order: observed.order,
            fitted: observed.fitted,
            accepted: theory.filter(|_| self.scene.resolved).map(|_| complete && observed.agrees),
            error_constant: observed.error_constant,
            runs,
            // The reference calls a library's functions.
            portable: false,
        })
    }
}

/// The order in theory of a variant, if its method states `order`.
fn theory(label: &str, order: Order) -> Option<u32> {
    let exception = crate::theory::form_of(label).and_then(|form| form.order);
    exception.unwrap_or(Some(order.number()))
}

/// Result of the errors at several step sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Observed {
    order: Option<f64>,
    /// Number of runs in the fit.
    fitted: usize,
    /// Whether the order is that of theory.
    agrees: bool,
    error_constant: Option<f64>,
}

impl Observed {
    /// Fits the runs from the finest up to the first that diverged. `runs` have descending step
    /// sizes.
    fn of(runs: &[Run], theory: Option<u32>) -> Self {
        let sample = |run: &Run| run.error.map(|error| Sample { step: run.step_s, error });
        let mut samples: Vec<_> = runs.iter().rev().map_while(sample).collect();
        samples.reverse();
        let fitted = samples.len();
        let fit = observed_order(&samples).ok().filter(|_| fitted >= FEWEST);
        let order = fit.as_ref().map(|fit| fit.order);
        let agrees = order
            .zip(theory)
            .is_some_and(|(order, theory)| (order - f64::from(theory)).abs() < ACCEPTED);
        let constant = |theory: u32| fit.map(|fit| fit.error_constant(theory as i32));
        let error_constant = theory.filter(|_| agrees).and_then(constant);
        Self { order, fitted, agrees, error_constant }
    }
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "A sheet of 6 × 6 particles (1 m × 1 m, 1 g each, structural springs, shear springs of a \
     quarter of the stiffness, d/m = 2 s⁻¹, two corners pinned, 0.02 m out of its plane at the \
     start) falls for 0.25 s. The error is the mass-weighted distance of the final positions from \
     the reference, over the distance that the sheet has moved. The reference is DOP853 \
     (adaptive, order 8) at tolerance 1e-12; a run at 1e-11 measures its error. Each of four \
     steps is half of the one before. The observed order is the slope of log e over log h by \
     least squares; C = e/hᵖ is taken at the finest step. Smooth: k/m = 400 s⁻², h from 0.00625 \
     s, h ω_max < 0.4; an order is accepted within 0.15. Stiff: k/m = 10⁴ and 10⁶ s⁻², h from \
     0.01 s. A run counts as diverged if it ends farther from the reference than the sheet has \
     moved. It is left out of the slope, which needs three runs."
        .to_owned()
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    CASES.map(|case| Start::new(case.id, move || case.spec())).into()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let chosen: Vec<_> = CASES.into_iter().filter(|case| !context.quick || case.is_quick).collect();
    let settings = prepared(context, "references", &chosen, Setting::new)?;
    let variants = of_registry(|runs| runs.order);
    let pairs: Vec<_> = settings
        .iter()
        .flat_map(|setting| variants.iter().map(move |variant| (setting, variant)))
        .collect();
    let rows =
        taken(context, "methods", &pairs, |(setting, variant)| setting.row(variant))?.all()?;
    let scenes = settings.iter().map(|setting| setting.scene.clone()).collect();
    let facts = Facts { scenes, rows };
    let hashes = settings.iter().map(|s| (s.case.id.to_owned(), s.hash.clone())).collect();
    let (facts, scenes, seed) = (facts, hashes, None);
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let scenes = facts.scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), scene.portable, scene));
    let rows = facts.rows.iter().flat_map(|row| {
        let key = format!("{} {}", row.scene, row.label);
        let bare = Row { runs: Vec::new(), ..row.clone() };
        let bare = fact(key.clone(), row.portable, &bare);
        let runs = row.runs.iter();
        let runs = runs.map(move |run| fact(format!("{key} h={}", run.step_s), row.portable, run));
        std::iter::once(bare).chain(runs)
    });
    scenes.chain(rows).collect()
}

#[cfg(test)]
mod tests;
