//! Experiment `momentum`: drift of linear and angular momentum of every method.

use crate::facts::{Fact, fact};
use crate::methods::runs::{Keeps, Variant};
use crate::methods::{self, Choice};
use crate::run::{Runner, Simulation};
use crate::studies::momentum::facts::{Facts, Row, Scene};
use crate::studies::sheet::{GRAVITY, Sheet, pair};
use crate::studies::variant::{is_explicit, or_defaults};
use crate::studies::{Context, Measured, Start, prepared, taken};
use crate::theory::{self, SpinLaw};
use crate::{HarnessError, system_hash};
use drape_integrator::{Method, Quantity};
use drape_model::{DampingLaw, State, System, SystemSpec, TimeSpan, Vec3};
use drape_report::Verdict;

/// Particles along each edge of the sheets.
const SIDE: u32 = 20;
/// Angular velocity of the start, 1/s.
const SPIN: f64 = 2.0;
const DURATION: f64 = 1.0;
/// Step size of all methods except explicit ones, s.
const STEP: f64 = 0.01;
/// Number of steps of [`STEP`] between samples.
const STRIDE: u64 = 10;
/// Largest `h ω_max` of explicit methods. It is so far below their limits that even weakly unstable
/// methods complete the run.
const EXPLICIT: f64 = 0.1;
/// Share by which one side of a falling sheet is heavier and the other lighter.
const UNEVEN: f64 = 0.5;
/// A run is unstable if it gains more than this many times the energy of the spin.
const GAINED: f64 = 1.0;

/// The moving body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Body {
    /// A sheet that turns over and over, about an axis in its plane.
    Spinning,
    /// A sheet, heavier on one side, that falls and spins like a disc.
    Falling,
    /// Two particles on a spring.
    Pair,
}

/// A scene, before its system is built.
#[derive(Clone, Copy, Debug)]
struct Case {
    id: &'static str,
    body: Body,
    stiffness: f64,
    /// Whether the quick subset has this case.
    is_quick: bool,
}

const fn case(id: &'static str, body: Body, stiffness: f64, is_quick: bool) -> Case {
    Case { id, body, stiffness, is_quick }
}

const CASES: [Case; 6] = [
    case("spin-1e4", Body::Spinning, 1e4, true),
    case("spin-1e6", Body::Spinning, 1e6, false),
    case("fall-1e4", Body::Falling, 1e4, false),
    case("fall-1e6", Body::Falling, 1e6, false),
    case("pair-1e4", Body::Pair, 1e4, true),
    case("pair-1e6", Body::Pair, 1e6, true),
];

/// Centre of mass, m.
fn center(system: &System, x: &[Vec3]) -> Vec3 {
    let mass: f64 = system.mass().iter().sum();
    let sum = system.mass().iter().zip(x).fold(Vec3::zeros(), |sum, (&m, x)| sum + x * m);
    sum / mass
}

/// Angular momentum about the centre of mass, kg m²/s.
fn spin_of(system: &System, state: &State) -> Vec3 {
    system.angular_momentum(state) - center(system, &state.x).cross(&system.momentum(state))
}

/// A scene at its start.
struct Setting {
    case: Case,
    simulation: Simulation,
    hash: String,
    scene: Scene,
}

impl Case {
    fn gravity(&self) -> [f64; 3] {
        if self.body == Body::Falling { GRAVITY } else { [0.0; 3] }
    }

    fn sheet(&self) -> Sheet {
        Sheet {
            side: SIDE,
            tension: self.stiffness,
            shear: 0.1 * self.stiffness,
            damping: 0.0,
            law: DampingLaw::Full,
            gravity: self.gravity(),
            is_pinned: false,
        }
    }

    fn axis(&self) -> Vec3 {
        if self.body == Body::Spinning { Vec3::x() } else { Vec3::z() }
    }

    /// The system at its start, with its spin.
    fn spec(&self) -> Result<SystemSpec, HarnessError> {
        let is_pair = self.body == Body::Pair;
        let mut spec = if is_pair { pair(self.stiffness) } else { self.sheet().spec()? };
        if self.body == Body::Falling {
            let SystemSpec { particles, .. } = &mut spec;
            for (mass, position) in particles.mass_kg.iter_mut().zip(&particles.position_m) {
                *mass *= 1.0 + 2.0 * UNEVEN * position[0];
            }
        }
        let (system, mut state) = spec.build()?;
        let middle = center(&system, &state.x);
        for (v, x) in state.v.iter_mut().zip(&state.x) {
            *v = (self.axis() * SPIN).cross(&(x - middle));
        }
        Ok(spec.with_state(&state))
    }
}

impl Setting {
    fn new(case: &Case) -> Result<Self, HarnessError> {
        let Case { id, body, stiffness, .. } = *case;
        let (gravity, sheet, axis) = (case.gravity(), case.sheet(), case.axis());
        let greatest_frequency = match body {
            Body::Pair => (2.0 * stiffness).sqrt(),
            Body::Spinning => sheet.greatest_frequency(1.0),
            Body::Falling => sheet.greatest_frequency(1.0 - UNEVEN),
        };
        let spec = case.spec()?;
        let (system, state) = spec.build()?;
        let (low, high) = state
            .x
            .iter()
            .fold((state.x[0], state.x[0]), |(low, high), x| (low.inf(x), high.sup(x)));
        let edge = state.v.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let steps = (DURATION / STEP).round() as u64;
        let scene = Scene {
            id: id.to_owned(),
            particles: system.len(),
            stiffness_over_mass_per_s2: stiffness,
            spin_per_s: (axis * SPIN).into(),
            gravity_m_s2: gravity,
            duration_s: DURATION,
            step_s: STEP,
            greatest_frequency_per_s: greatest_frequency,
            mass_kg: system.mass().iter().sum(),
            size_m: (high - low).norm(),
            speed_m_s: edge + Vec3::from(gravity).norm() * DURATION,
            time_s: (0..=steps / STRIDE).map(|n| (n * STRIDE) as f64 * STEP).collect(),
            portable: true,
        };
        let hash = system_hash(&spec);
        Ok(Self { case: *case, simulation: Simulation { system, state }, hash, scene })
    }

    /// Number of steps into which a method divides [`STEP`].
    fn division(&self, method: &Method) -> u64 {
        if !is_explicit(method) {
            return 1;
        }
        let least = STEP * self.scene.greatest_frequency_per_s / EXPLICIT;
        (least.ceil() as u64).next_power_of_two()
    }

    fn row(&self, (variant, keeps): &(Variant, Keeps)) -> Result<Row, HarnessError> {
        let choice = Choice::parse(variant.method, &[])?;
        let division = self.division(choice.method());
        let time = TimeSpan { step_s: STEP / division as f64, duration_s: DURATION };
        let law = theory::form_of(variant.label).and_then(|form| form.spin);
        let law = law.filter(|_| self.case.body == Body::Pair);
        let mut watch = Watch::new(self, law, time.step_s);
        let mut simulation = self.simulation.clone();
        let runner = Runner::new(&choice, time).observe(|moment| {
            let (step, system, state) = (moment.step, moment.system, moment.state);
            watch.follow(state);
            if step % division == 0 {
                watch.look(system, state, step % (STRIDE * division) == 0);
            }
        });
        let outcome = runner.go(&mut simulation)?;
        let completed = outcome.divergence.is_none() && watch.energy_gain <= GAINED;
        let is_meant = *keeps == Keeps::AsStated;
        let states = |quantity| is_meant && choice.method().conserves.contains(&quantity);
        Ok(Row {
            scene: self.case.id.to_owned(),
            label: variant.label.to_owned(),
            method: choice.full_id(),
            step_s: time.step_s,
            momentum_drift: completed.then_some(watch.momentum_drift),
            angular_momentum_drift: completed.then_some(watch.angular_momentum_drift),
            final_spin: watch.spin.last().copied().filter(|_| completed),
            law: law.filter(|_| completed).map(|_| watch.law_product.abs()),
            spin: watch.spin,
            energy_gain: completed.then_some(watch.energy_gain),
            states_momentum: states(Quantity::Momentum),
            states_angular_momentum: states(Quantity::AngularMomentum),
            verdict: if completed { Verdict::Completed } else { Verdict::Unstable },
            unconverged_steps: outcome.unconverged,
            portable: choice.is_portable(),
        })
    }
}

/// Records the momenta of a run.
struct Watch<'a> {
    scene: &'a Scene,
    gravity: Vec3,
    momentum: Vec3,
    angular_momentum: Vec3,
    energy: f64,
    kinetic_energy: f64,
    momentum_drift: f64,
    angular_momentum_drift: f64,
    /// Greatest rise of the energy, over the kinetic energy of the start.
    energy_gain: f64,
    spin: Vec<f64>,
    /// The law of the method with its `θ`. The fields below are the length of the spring after the
    /// last step, m, and the product of the law's factors so far.
    law: Option<(SpinLaw, f64)>,
    length: f64,
    law_product: f64,
}

/// Length of the first spring of a pair, m; its rest length is 1 m.
fn length(state: &State) -> f64 {
    (state.x[1] - state.x[0]).norm()
}

impl<'a> Watch<'a> {
    fn new(setting: &'a Setting, law: Option<SpinLaw>, h: f64) -> Self {
        let Setting { scene, simulation: Simulation { system, state }, .. } = setting;
        let theta = 2.0 * h * h * scene.stiffness_over_mass_per_s2;
        Self {
            scene,
            gravity: Vec3::from(scene.gravity_m_s2),
            momentum: system.momentum(state),
            angular_momentum: spin_of(system, state),
            energy: system.total_energy(state),
            kinetic_energy: system.kinetic_energy(&state.v),
            momentum_drift: 0.0,
            angular_momentum_drift: 0.0,
            energy_gain: 0.0,
            spin: vec![1.0],
            law: law.map(|law| (law, theta)),
            length: length(state),
            law_product: 1.0,
        }
    }

    /// Multiplies the product by the law's factor for the step that led to `state`.
    fn follow(&mut self, state: &State) {
        if let Some((law, theta)) = self.law {
            let after = length(state);
            self.law_product *= law(theta, 1.0 / self.length, 1.0 / after);
            self.length = after;
        }
    }

    /// Records the momenta and the energy after a step.
    fn look(&mut self, system: &System, state: &State, is_sample: bool) {
        let Scene { mass_kg, size_m, speed_m_s, .. } = *self.scene;
        let spin = spin_of(system, state);
        let gained = self.gravity * (mass_kg * state.t);
        let drift = (system.momentum(state) - self.momentum - gained).norm();
        self.momentum_drift = self.momentum_drift.max(drift / (mass_kg * speed_m_s));
        let drift = (spin - self.angular_momentum).norm();
        self.angular_momentum_drift =
            self.angular_momentum_drift.max(drift / (mass_kg * size_m * speed_m_s));
        let gain = (system.total_energy(state) - self.energy) / self.kinetic_energy;
        // A gain that is not a number counts as infinite.
        self.energy_gain = if gain.is_nan() { f64::INFINITY } else { self.energy_gain.max(gain) };
        if is_sample && self.energy_gain <= GAINED {
            self.spin.push(spin.norm() / self.angular_momentum.norm());
        }
    }
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "Nothing is pinned and nothing is damped; k/m = 10⁴ and 10⁶ s⁻², h = 0.01 s, one second. \
     Spinning sheet: 20 × 20 particles, 1 m × 1 m, structural springs, and shear springs of a \
     tenth of the stiffness; it turns over and over at 2 rad/s without gravity. Falling sheet: \
     the same sheet under gravity, spinning in its plane; its mass rises from half of the mean on \
     one side to one and a half times the mean on the other. Pair: two particles on a spring of 1 \
     m, at 2 rad/s. Angular momentum is taken about the centre of mass, where gravity has no \
     torque. Drift of momentum: the greatest |P − P₀ − M g t|, over the mass and the greatest \
     speed of the rigid motion. Drift of angular momentum: the greatest |L − L₀|, over the mass, \
     the diagonal and that speed. Explicit methods divide the step by a power of 2 until h ω_max \
     ≤ 0.1. Solvers have tight tolerances unless a tolerance ε is named."
        .to_owned()
}

/// Every method in its forms or at its defaults, with the quantities that it keeps.
fn forms() -> Vec<(Variant, Keeps)> {
    let as_stated = |form| (form, Keeps::AsStated);
    methods::runs()
        .flat_map(|(method, runs)| or_defaults(method, runs.momentum, as_stated))
        .collect()
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    CASES.map(|case| Start::new(case.id, move || case.spec())).into()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let chosen: Vec<_> = CASES.into_iter().filter(|case| !context.quick || case.is_quick).collect();
    let settings = prepared(context, "scenes", &chosen, Setting::new)?;
    let forms = forms();
    let pairs: Vec<_> =
        settings.iter().flat_map(|setting| forms.iter().map(move |form| (setting, form))).collect();
    let rows = taken(context, "methods", &pairs, |(setting, form)| setting.row(form))?.all()?;
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
    let rows = facts.rows.iter().map(|row| {
        // An unstable run magnifies round-off. Its values are comparable only if its round-off is
        // the same everywhere.
        let is_comparable = row.portable || row.verdict != Verdict::Unstable;
        let spin = if is_comparable { row.spin.clone() } else { Vec::new() };
        let row = Row { spin, ..row.clone() };
        fact(format!("{} {}", row.scene, row.label), row.portable, &row)
    });
    scenes.chain(rows).collect()
}

#[cfg(test)]
mod tests;
