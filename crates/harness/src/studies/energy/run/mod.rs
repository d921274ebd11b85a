//! Experiment `energy`: gains and losses of a cloth's energy, by method and cause.

mod watch;

use crate::facts::{Fact, fact};
use crate::methods::Choice;
use crate::methods::runs::Variant;
use crate::run::{Runner, Simulation};
use crate::schedule::Schedule;
use crate::stability::reference;
use crate::studies::energy::facts::{Facts, Row, Scene};
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::studies::variant::{is_explicit, of_registry};
use crate::studies::{Context, Measured, Start, prepared, taken};
use crate::{HarnessError, system_hash};
use drape_integrator::Method;
use drape_model::{DampingLaw, ObstacleSpec, SystemSpec, TimeSpan, Vec3};
use drape_report::Verdict;
use watch::Flow;

/// Step size of all methods except explicit ones, s.
const STEP: f64 = 0.01;
/// Largest `h ω_max` of explicit methods: well below 2, the limit of symplectic Euler and leapfrog.
const EXPLICIT: f64 = 0.5;
/// Number of samples of the energy in a run.
const SAMPLES: u64 = 100;
/// Damping over the mass of a particle in the damped scenes, 1/s.
const DAMPING: f64 = 40.0;
/// Angular velocity of the spinning sheet, 1/s.
const SPIN: f64 = 2.0;

/// How the sheet moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Body {
    /// It hangs from two corners, horizontal at first.
    Hanging,
    /// It turns over and over, without gravity.
    Spinning,
    /// It falls on a ball.
    Sphere,
}

/// A scene, before its system is built.
#[derive(Clone, Copy, Debug)]
struct Case {
    name: &'static str,
    body: Body,
    /// Particles along each edge.
    side: u32,
    stiffness: f64,
    duration: f64,
    /// Whether the quick subset has this case.
    is_quick: bool,
}

const CASES: [Case; 4] = [
    Case {
        name: "hanging-1e4",
        body: Body::Hanging,
        side: 20,
        stiffness: 1e4,
        duration: 2.0,
        is_quick: false,
    },
    Case {
        name: "hanging-1e6",
        body: Body::Hanging,
        side: 20,
        stiffness: 1e6,
        duration: 2.0,
        is_quick: false,
    },
    Case {
        name: "spinning-1e4",
        body: Body::Spinning,
        side: 10,
        stiffness: 1e4,
        duration: 1.0,
        is_quick: true,
    },
    Case {
        name: "sphere-1e4",
        body: Body::Sphere,
        side: 12,
        stiffness: 1e4,
        duration: 1.0,
        is_quick: true,
    },
];

/// A scene, undamped or damped, that is ready to run.
struct Setting {
    simulation: Simulation,
    hash: String,
    scene: Scene,
    /// Bound on the largest angular frequency, 1/s.
    greatest_frequency: f64,
}

/// Damping over mass of a scene, 1/s.
fn damping(is_damped: bool) -> f64 {
    if is_damped { DAMPING } else { 0.0 }
}

impl Case {
    fn id(&self, is_damped: bool) -> String {
        format!("{} {}", self.name, if is_damped { "damped" } else { "undamped" })
    }

    fn sheet(&self, is_damped: bool) -> Sheet {
        Sheet {
            side: self.side,
            tension: self.stiffness,
            shear: 0.1 * self.stiffness,
            damping: damping(is_damped),
            law: DampingLaw::Full,
            gravity: if self.body == Body::Spinning { [0.0; 3] } else { GRAVITY },
            is_pinned: self.body == Body::Hanging,
        }
    }

    /// The system of the sheet at its start, with its spin if it has one.
    fn spec(&self, is_damped: bool) -> Result<SystemSpec, HarnessError> {
        let mut spec = self.sheet(is_damped).spec()?;
        if self.body == Body::Sphere {
            // A little off the middle, so that nothing depends on a symmetry.
            let (center_m, radius_m) = ([0.03, 0.01, -0.4], 0.35);
            spec.obstacles.push(ObstacleSpec::sphere(center_m, radius_m, 0.0));
        }
        let (_, mut state) = spec.build()?;
        if self.body == Body::Spinning {
            for (v, x) in state.v.iter_mut().zip(&state.x) {
                *v = (Vec3::x() * SPIN).cross(x); // the centre of mass is the origin
            }
        }
        Ok(spec.with_state(&state))
    }
}

impl Setting {
    fn new((case, is_damped): &(Case, bool)) -> Result<Self, HarnessError> {
        let Case { name, stiffness, duration, .. } = *case;
        let (sheet, damping) = (case.sheet(*is_damped), damping(*is_damped));
        let spec = case.spec(*is_damped)?;
        let (system, state) = spec.build()?;
        let hash = system_hash(&spec);
        let simulation = Simulation { system, state };
        let time = TimeSpan { step_s: STEP, duration_s: duration };
        let reference = reference(&simulation, &Schedule::steady(time))?;
        let scene = Scene {
            id: case.id(*is_damped),
            scene: name.to_owned(),
            is_damped: *is_damped,
            particles: simulation.system.len(),
            stiffness_over_mass_per_s2: stiffness,
            damping_over_mass_per_s: damping,
            duration_s: duration,
            step_s: STEP,
            reference_energy_j: reference.energy,
            start_energy_j: simulation.system.total_energy(&simulation.state),
            time_s: (0..=SAMPLES).map(|n| n as f64 * duration / SAMPLES as f64).collect(),
            portable: true,
        };
        Ok(Self { simulation, hash, scene, greatest_frequency: sheet.greatest_frequency(1.0) })
    }

    /// Number of steps into which a method divides [`STEP`]. Damped explicit Euler is stable for
    /// `h ≤ c/k`, undamped never.
    fn division(&self, method: &Method) -> u64 {
        if !is_explicit(method) {
            return 1;
        }
        let Scene { stiffness_over_mass_per_s2: k, damping_over_mass_per_s: c, .. } = self.scene;
        let mut least = STEP * self.greatest_frequency / EXPLICIT;
        if method.id == "explicit-euler" && c > 0.0 {
            least = least.max(STEP * k / c);
        }
        (least.ceil() as u64).next_power_of_two()
    }

    fn row(&self, variant: &Variant) -> Result<Row, HarnessError> {
        let Self { scene, simulation, .. } = self;
        let choice = Choice::parse(variant.method, &[])?;
        let division = self.division(choice.method());
        let time = TimeSpan { step_s: STEP / division as f64, duration_s: scene.duration_s };
        let stride = (Schedule::steady(time).steps() / SAMPLES).max(1);
        let mut flow = Flow::new(simulation, scene.reference_energy_j);
        let runner = Runner::new(&choice, time).ledger();
        let runner = runner.observe(|moment| flow.look(moment, moment.step % stride == 0));
        let counts = runner.count(simulation)?;
        let verdict = counts.verdict(scene.reference_energy_j);
        let lasted = matches!(verdict, Verdict::Stable | Verdict::Marginal);
        Ok(Row {
            scene: scene.id.clone(),
            label: variant.label.to_owned(),
            method: choice.full_id(),
            step_s: time.step_s,
            steps: counts.outcome.steps,
            verdict,
            drift: lasted.then(|| flow.drift()),
            gain: lasted.then(|| counts.energy.gain / scene.reference_energy_j),
            excess_dissipation: lasted.then(|| flow.excess_dissipation()),
            ledger: flow.ledger().filter(|_| lasted),
            closure_defect: flow.closure_defect().filter(|_| lasted),
            energy: flow.energy,
            unconverged_steps: counts.outcome.unconverged,
            portable: choice.is_portable(),
        })
    }
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "Sheets of 1 m × 1 m have structural springs, shear springs of a tenth of the stiffness, and \
     either no damping or full damping of d/m = 40 s⁻¹. The hanging sheet is released \
     horizontally from two corners. The spinning sheet turns over and over at 2 rad/s without \
     gravity. The third sheet falls on an inelastic ball. The table of scenes lists sizes, \
     stiffness and duration. The step is h = 0.01 s. Explicit methods divide it by a power of 2 \
     until h ω_max ≤ 0.5; damped explicit Euler also until h ≤ d/k. Energies are relative to \
     E_ref, the energy that the scene sets free: the larger of H₀ − U and the kinetic energy, \
     over the true motion. After each step the method reports the forces that it used and the \
     residual of its solve. From these the study computes each cause of the change of energy \
     separately, none as the remainder, and compares their sum with the change. Numerical damping \
     is the sum of inertia and gaps. Excess dissipation is (H₀ − H_N − ∫vᵀDv dt)/E_ref, by the \
     trapezoidal rule."
        .to_owned()
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let both = |case: Case| [false, true].map(|is_damped| (case, is_damped));
    let start = |(case, is_damped): (Case, bool)| {
        Start::new(case.id(is_damped), move || case.spec(is_damped))
    };
    CASES.into_iter().flat_map(both).map(start).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let chosen: Vec<_> = CASES
        .into_iter()
        .filter(|case| !context.quick || case.is_quick)
        .flat_map(|case| [(case, false), (case, true)])
        .collect();
    let settings = prepared(context, "scenes", &chosen, Setting::new)?;
    let variants = of_registry(|runs| runs.energy);
    let pairs: Vec<_> = settings
        .iter()
        .flat_map(|setting| variants.iter().map(move |variant| (setting, variant)))
        .collect();
    let rows =
        taken(context, "methods", &pairs, |(setting, variant)| setting.row(variant))?.all()?;
    let unattributed = unattributed(&rows);
    let scenes = settings.iter().map(|setting| setting.scene.clone()).collect();
    let facts = Facts { scenes, rows, unattributed };
    let (facts, scenes, seed) =
        (facts, settings.iter().map(|s| (s.scene.id.clone(), s.hash.clone())).collect(), None);
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// Labels of the methods with a run that lasted but has no ledger.
fn unattributed(rows: &[Row]) -> Vec<String> {
    let mut labels: Vec<String> = Vec::new();
    for row in rows.iter().filter(|row| row.drift.is_some() && row.ledger.is_none()) {
        if !labels.contains(&row.label) {
            labels.push(row.label.clone());
        }
    }
    labels
}

/// The study's facts in the form in which two records are compared. Long runs magnify the round-off
/// of a library's factorisation. Then only the verdict is the same everywhere.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let scenes = facts.scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), scene.portable, scene));
    let rows = facts.rows.iter().map(|row| {
        let key = format!("{} {}", row.scene, row.label);
        if row.portable {
            return fact(key, true, row);
        }
        // Round-off may decide whether an unstable run also leaves the scene.
        let verdict = if row.drift.is_some() { row.verdict } else { Verdict::Unstable };
        let verdict = [("method", row.method.as_str()), ("verdict", verdict.name())];
        fact(key, false, &verdict.into_iter().collect::<std::collections::BTreeMap<_, _>>())
    });
    scenes.chain(rows).collect()
}

#[cfg(test)]
mod tests;
