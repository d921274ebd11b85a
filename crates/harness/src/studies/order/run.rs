//! Experiment `order`: observed order of accuracy and error constant of every method.

use crate::facts::{Fact, fact};
use crate::methods::Choice;
use crate::run::{Options, Simulation, simulate};
use crate::studies::order::facts::{Facts, Row, Run, Scene};
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::studies::variant::{Variant, of_registry};
use crate::studies::{Account, Context, cells, prepared, short};
use crate::{HarnessError, system_hash};
use drape_integrator::Order;
use drape_model::{DampingLaw, State, TimeSpan};
use drape_oracle::order::{Sample, observed_order, position_error};
use drape_oracle::reference::{Reference, ReferenceSettings, reference};
use drape_report::Record;
use std::path::PathBuf;
use super::STUDY;

/// Particles along each edge of the sheet.
const SIDE: u32 = 6;
/// Damping over mass of the tension springs, 1/s.
const DAMPING: f64 = 2.0;
/// Greatest displacement of the start out of the plane in which springs across are without force, m.
const AMPLITUDE: f64 = 0.02;
/// Simulated time after which the error is taken, s.
const SPAN: f64 = 0.25;
/// Each step size is half the one before.
const SIZES: u32 = 4;
/// Greatest accepted distance of the observed order from theory.
const ACCEPTED: f64 = 0.15;
/// An error as large as the motion counts as diverged: it says nothing about an order.
const DIVERGED: f64 = 1.0;
/// Fewest runs that make an order.
const FEWEST: usize = 3;
/// A method that is off by so much of the motion at its finest step does not follow it.
const LOST: f64 = 0.5;

/// Solves tight enough for the error of the step to show, and variants of another order.
const VARIANTS: [Variant; 22] = [
    Variant::new("symplectic-euler", "symplectic-euler"),
    Variant::new("symplectic-euler, implicit damping", "symplectic-euler:damping=implicit"),
    Variant::new(LIMITED, "provot"),
    Variant::new("provot, limit out of reach", "provot:limit=10"),
    Variant::new("backward-euler", "backward-euler:residual=1e-12"),
    Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-12"),
    Variant::new("kang", "kang"),
    Variant::new("kang, 8 sweeps", "kang:sweeps=8"),
    Variant::new("terzopoulos-fleischer", "terzopoulos-fleischer"),
    Variant::new(CLAMPED, "terzopoulos-fleischer:clamp=true"),
    Variant::new("adams-bashforth2", "adams-bashforth2"),
    Variant::new(ADAMS_BASHFORTH_3, "adams-bashforth2:steps=3"),
    Variant::new("bdf2", "bdf2:residual=1e-12"),
    Variant::new(BDF_3, "bdf2:steps=3,residual=1e-12"),
    Variant::new("imex-euler", "imex-euler:forcing_term=1e-10"),
    Variant::new("imex-euler, all springs", "imex-euler:forcing_term=1e-10,implicit=springs"),
    Variant::new("imex-updated", "imex-updated:forcing_term=1e-9"),
    Variant::new("imex-updated, as printed", "imex-updated:forcing_term=1e-9,safeguard=paper"),
    Variant::new("imex-sbdf2", "imex-sbdf2:forcing_term=1e-12"),
    Variant::new("imex-cnab2", "imex-cnab2:forcing_term=1e-12"),
    Variant::new("imex-mcnab2", "imex-mcnab2:forcing_term=1e-12"),
    Variant::new("imex-cnlf", "imex-cnlf:forcing_term=1e-12"),
];

const LIMITED: &str = "provot";
const CLAMPED: &str = "terzopoulos-fleischer, clamped";
const ADAMS_BASHFORTH_3: &str = "adams-bashforth, 3 steps";
const BDF_3: &str = "bdf, 3 steps";

/// Variants whose order is not the one that the method states for its defaults. Where springs are shortened that are
/// too long, or where weights are cut off in compression, another equation is solved, so that no order is claimed.
const THEORY: [(&str, Option<u32>); 4] =
    [(LIMITED, None), (CLAMPED, None), (ADAMS_BASHFORTH_3, Some(3)), (BDF_3, Some(3))];

/// A scene before it is built.
#[derive(Clone, Copy, Debug)]
struct Case {
    id: &'static str,
    /// In prose.
    title: &'static str,
    stiffness: f64,
    law: DampingLaw,
    /// Number of the coarsest steps.
    steps: u32,
    /// Whether the quick subset has it.
    is_quick: bool,
}

const fn case(
    id: &'static str,
    title: &'static str,
    stiffness: f64,
    law: DampingLaw,
    steps: u32,
    is_quick: bool,
) -> Case {
    Case { id, title, stiffness, law, steps, is_quick }
}

const CASES: [Case; 4] = [
    case("smooth", "the smooth scene with full damping", 400.0, DampingLaw::Full, 40, true),
    case(
        "smooth-projected",
        "the smooth scene with projected damping",
        400.0,
        DampingLaw::Projected,
        40,
        false,
    ),
    case("stiff-1e4", "k/m = 1e4", 1e4, DampingLaw::Full, 25, true),
    case("stiff-1e6", "k/m = 1e6", 1e6, DampingLaw::Full, 25, false),
];

/// A scene with its exact solution.
struct Setting {
    case: Case,
    simulation: Simulation,
    exact: Reference,
    hash: String,
    scene: Scene,
}

impl Setting {
    fn new(case: &Case) -> Result<Self, HarnessError> {
        let sheet = Sheet {
            side: SIDE,
            tension: case.stiffness,
            shear: 0.25 * case.stiffness,
            damping: DAMPING,
            law: case.law,
            gravity: GRAVITY,
            is_pinned: true,
        };
        let mut spec = sheet.spec()?;
        for (i, position) in spec.particles.position_m.iter_mut().enumerate() {
            position[2] += AMPLITUDE * libm::sin(i as f64);
        }
        let (system, state) = spec.build()?;
        let exact = reference(&system, &state, &[SPAN], ReferenceSettings::default())?;
        let greatest_frequency = sheet.greatest_frequency(1.0);
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
        let outcome = simulate(&mut simulation, choice, time, Options::default(), |_, _, _| {})?;
        let start = &self.simulation.state.x;
        let error = position_error(&simulation.system, start, &self.end().x, &simulation.state.x);
        let error = Some(error).filter(|e| outcome.divergence.is_none() && *e < DIVERGED);
        Ok(Run {
            step_s: time.step_s,
            error,
            verdict: if error.is_some() { "completed" } else { "diverged" }.to_owned(),
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
            // The reference passes through a library.
            portable: false,
        })
    }
}

/// The order that theory gives for a variant of a method that states `order`.
fn theory(label: &str, order: Order) -> Option<u32> {
    let stated = match order {
        Order::One => 1,
        Order::Two => 2,
    };
    let exception = THEORY.iter().find(|(known, _)| *known == label);
    exception.map_or(Some(stated), |(_, order)| *order)
}

/// What the errors at several step sizes say.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Observed {
    order: Option<f64>,
    /// Number of runs behind it.
    fitted: usize,
    /// Whether it is the one that theory gives.
    agrees: bool,
    error_constant: Option<f64>,
}

impl Observed {
    /// From the finest run up to the first that diverged. `runs` have falling steps.
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

pub(super) fn run(context: &Context<'_>) -> Result<Vec<PathBuf>, HarnessError> {
    let chosen: Vec<_> = CASES.into_iter().filter(|case| !context.quick || case.is_quick).collect();
    let settings = prepared(context, "references", &chosen, Setting::new)?;
    let variants = of_registry(&VARIANTS);
    let pairs: Vec<_> = settings
        .iter()
        .flat_map(|setting| variants.iter().map(move |variant| (setting, variant)))
        .collect();
    let rows = cells(context, "methods", &pairs, |(setting, variant)| setting.row(variant))?;
    let scenes = settings.iter().map(|setting| setting.scene.clone()).collect();
    let facts = Facts { scenes, rows };
    let hashes = settings.iter().map(|s| (s.case.id.to_owned(), s.hash.clone())).collect();
    let findings = findings(&facts);
    let account = Account {
        method: "A sheet of 6 × 6 particles (1 m × 1 m, 1 g each, structural springs and shear springs of a quarter \
                 of the stiffness, d/m = 2/s, two corners pinned, 0.02 m out of its plane at the start) falls for \
                 0.25 s. The error is the mass-weighted distance of the positions at the end from those of the \
                 differential equation, over how far the sheet has moved. The equation is solved by DOP853 \
                 (adaptive, order 8) at tolerance 1e-12, and again at 1e-11, which tells the error of the \
                 reference. Four step sizes, each half the one before; the observed order is the slope of log e \
                 over log h by least squares, C = e/h^p the constant at the finest step. Solvers are set so tight \
                 that their residuals do not show. Smooth: k/m = 400/s², h from 0.00625 s, h ω_max < 0.4, where \
                 theory holds; an order is accepted within 0.15. Stiff: k/m = 1e4/s² and 1e6/s², h from 0.01 s; \
                 runs that diverge, which includes those that end farther from the reference than it is from the \
                 start, are recorded as such and left out of the slope, for which at least three runs are needed."
            .to_owned(),
        findings,
        facts,
        scenes: hashes,
        seed: None,
    };
    Ok(vec![context.write(&STUDY, account)?])
}

/// Its facts, as they are compared.
pub(crate) fn comparable(record: &Record<Facts>) -> Vec<Fact> {
    let scenes = record.facts.scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), scene.portable, scene));
    let rows = record.facts.rows.iter().flat_map(|row| {
        let key = format!("{} {}", row.scene, row.label);
        let bare = Row { runs: Vec::new(), ..row.clone() };
        let bare = fact(key.clone(), row.portable, &bare);
        let runs = row.runs.iter();
        let runs = runs.map(move |run| fact(format!("{key} h={}", run.step_s), row.portable, run));
        std::iter::once(bare).chain(runs)
    });
    scenes.chain(rows).collect()
}

/// What the numbers say.
fn findings(facts: &Facts) -> Vec<String> {
    let mut findings = Vec::new();
    for scene in &facts.scenes {
        let rows: Vec<_> = facts.rows.iter().filter(|row| row.scene == scene.id).collect();
        if scene.resolved {
            findings.push(acceptance(scene, &rows));
            findings.extend(rows.iter().copied().filter_map(|row| unclaimed(scene, row)));
        } else {
            findings.push(stiffness(scene, &rows));
        }
    }
    let smooth = facts.scenes.iter().find(|scene| scene.resolved);
    findings.extend(smooth.and_then(|scene| constants(scene, &facts.rows)));
    let error = facts.scenes.iter().map(|scene| scene.reference_error_m).fold(0.0, f64::max);
    findings.push(format!("The references are off by at most {} m.", short(error)));
    findings
}

fn title(scene: &Scene) -> &'static str {
    CASES.iter().find(|case| case.id == scene.id).map_or("another scene", |case| case.title)
}

/// How many methods show their order, and which do not.
fn acceptance(scene: &Scene, rows: &[&Row]) -> String {
    let claiming: Vec<_> = rows.iter().filter(|row| row.accepted.is_some()).collect();
    let failing: Vec<_> = claiming
        .iter()
        .filter(|row| row.accepted == Some(false))
        .map(|row| {
            let theory = row.theory.unwrap_or_default();
            let order = row.order.map_or("none".to_owned(), |order| format!("{order:.2}"));
            format!("{} ({order}, theory {theory})", row.label)
        })
        .collect();
    let all = claiming.len();
    let title = title(scene);
    if failing.is_empty() {
        format!("On {title} all {all} variants that claim an order show it within {ACCEPTED}.")
    } else {
        format!(
            "On {title} {} of {all} variants that claim an order show it within {ACCEPTED}; not so: {}.",
            all - failing.len(),
            failing.join(", ")
        )
    }
}

/// What a method that claims no order does.
fn unclaimed(scene: &Scene, row: &Row) -> Option<String> {
    let order = row.order.filter(|_| row.theory.is_none())?;
    let error = row.runs.last()?.error?;
    Some(format!(
        "{} claims no order: on {} its observed order is {order:.2}, and {} % of the motion is wrong at the finest \
         step.",
        row.label,
        title(scene),
        short(100.0 * error)
    ))
}

/// Where the springs are stiff: who keeps the order, who loses it, who does not move, who diverges.
fn stiffness(scene: &Scene, rows: &[&Row]) -> String {
    let mut kept = Vec::new();
    let mut reduced = Vec::new();
    let mut unclaimed = Vec::new();
    let mut lost = Vec::new();
    let mut few = Vec::new();
    let mut failed = Vec::new();
    for row in rows {
        let finest = row.runs.last().and_then(|run| run.error);
        let error = || finest.map_or(String::new(), |error| format!(" ({})", short(error)));
        let order = |order: f64| format!("{} {order:.2}", row.label);
        match (finest, row.order) {
            (None, _) => failed.push(row.label.clone()),
            (Some(e), _) if e >= LOST => lost.push(format!("{}{}", row.label, error())),
            (_, Some(p)) if row.theory.is_none() => unclaimed.push(order(p)),
            (_, Some(p)) if row.error_constant.is_some() => kept.push(order(p)),
            (_, Some(p)) => reduced.push(order(p)),
            (_, None) => few.push(format!("{} ({})", row.label, row.fitted)),
        }
    }
    let lines: Vec<_> = [
        ("the order of theory is seen with", kept),
        ("another order with", reduced),
        ("an order where none is claimed:", unclaimed),
        ("off by half the motion or more at the finest step (error in brackets):", lost),
        ("too few runs for an order (their number in brackets):", few),
        ("diverged even at the finest step:", failed),
    ]
    .into_iter()
    .filter(|(_, labels)| !labels.is_empty())
    .map(|(what, labels)| format!("{what} {}", labels.join(", ")))
    .collect();
    let steps = |pick: fn(&[Run]) -> Option<&Run>| {
        rows.first().and_then(|row| pick(&row.runs)).map_or(0.0, |run| run.step_s)
    };
    let (first, last) = (steps(<[Run]>::first), steps(<[Run]>::last));
    format!(
        "At {} with h from {first} s to {last} s (h ω_max from {} to {}): {}.",
        title(scene),
        short(first * scene.greatest_frequency_per_s),
        short(last * scene.greatest_frequency_per_s),
        lines.join("; ")
    )
}

/// Least and greatest constants of each order on a scene.
fn constants(scene: &Scene, rows: &[Row]) -> Option<String> {
    let of_order = |theory: u32| {
        let mut found: Vec<_> = rows
            .iter()
            .filter(|row| row.scene == scene.id && row.theory == Some(theory))
            .filter_map(|row| Some((row.error_constant?, row.label.as_str())))
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (least, greatest) = (found.first()?, found.last()?);
        let value = |(constant, label): &(f64, &str)| format!("{} ({label})", short(*constant));
        Some(if found.len() == 1 {
            format!("order {theory}: {}", value(least))
        } else {
            format!("order {theory}: {} to {}", value(least), value(greatest))
        })
    };
    let lines: Vec<_> = (1..=3).filter_map(of_order).collect();
    (!lines.is_empty()).then(|| {
        format!("Error constants C = e/h^p on {}, in 1/s^p: {}.", title(scene), lines.join("; "))
    })
}

#[cfg(test)]
mod tests;
