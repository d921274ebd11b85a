//! The soft sheets, their stiff references, and the distances between them.

use crate::methods::Choice;
use crate::run::Simulation;
use crate::studies::post_correction::facts::Mesh;
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::studies::stepper::Stepper;
use crate::{HarnessError, system_hash};
use drape_model::{DampingLaw, Effect, SpringSpec, State, System, SystemSpec, Vec3};
use drape_oracle::Random;

/// Particles along each edge.
pub(super) const SIDE: u32 = 20;
/// Stiffness over mass, 1/s².
pub(super) const SOFT: f64 = 1e4;
pub(super) const STIFF: f64 = 1e7;
/// Damping over mass, 1/s.
const DAMPING: f64 = 10.0;
/// Step of the stiff sheet, s.
pub(super) const REFERENCE_STEP: f64 = 5e-5;
/// Times of comparison, s.
pub(super) const TIMES: [f64; 4] = [0.25, 0.5, 1.0, 2.0];
const JITTER: f64 = 0.2;
const SEED: u64 = 1;

/// The mesh of the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Grid,
    Triangles,
}

impl Kind {
    pub(super) const ALL: [Self; 2] = [Self::Grid, Self::Triangles];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Triangles => "triangles",
        }
    }

    /// A hanging sheet, or a free one without gravity and damping. `stiffness` is k/m, 1/s².
    pub(super) fn spec(self, stiffness: f64, hangs: bool) -> Result<SystemSpec, HarnessError> {
        let sheet = Sheet {
            side: SIDE,
            tension: stiffness,
            shear: 0.1 * stiffness,
            damping: if hangs { DAMPING } else { 0.0 },
            law: DampingLaw::Full,
            gravity: if hangs { GRAVITY } else { [0.0; 3] },
            is_pinned: hangs,
        };
        match self {
            Self::Grid => sheet.spec(),
            Self::Triangles => sheet.triangulated(JITTER, SEED),
        }
    }
}

/// The same system with its springs in an order that `seed` gives.
pub(super) fn permuted(mut spec: SystemSpec, seed: u64) -> SystemSpec {
    let mut random = Random::new(seed);
    let springs: &mut [SpringSpec] = &mut spec.springs;
    for last in (1..springs.len()).rev() {
        springs.swap(last, random.below(last + 1));
    }
    spec
}

/// Greatest elongation of a spring over its rest length; 0 if no spring is elongated.
pub(super) fn elongation(system: &System, x: &[Vec3]) -> f64 {
    let mut greatest = 0.0_f64;
    for split in system.effects().filter_map(Effect::split) {
        split.visit_rest_lengths(&mut |i, j, rest| {
            greatest = greatest.max((x[i] - x[j]).norm() / rest - 1.0);
        });
    }
    greatest
}

/// `‖x − y‖_M`, √kg m.
fn distance(system: &System, x: &[Vec3], y: &[Vec3]) -> f64 {
    let pairs = system.mass().iter().zip(x.iter().zip(y));
    pairs.map(|(m, (x, y))| m * (x - y).norm_squared()).sum::<f64>().sqrt()
}

/// Positions at the [`TIMES`].
pub(super) type Course = Vec<Vec<Vec3>>;

/// Number of steps of `step_s` to each of the [`TIMES`].
pub(super) fn marks(step_s: f64) -> Vec<u64> {
    TIMES.iter().map(|time| (time / step_s).round() as u64).collect()
}

/// A run without correction: its positions, its greatest elongation, and the energy that it sets
/// free, J.
struct Plain {
    course: Course,
    elongation: f64,
    released: f64,
}

fn plain(simulation: &Simulation, step_s: f64) -> Result<Plain, HarnessError> {
    let Simulation { system, state } = simulation;
    let mut state = state.clone();
    let mut stepper = Stepper::new(&Choice::parse("symplectic-euler", &[])?, system, step_s)?;
    let marks = marks(step_s);
    let start = system.total_energy(&state);
    let mut run = Plain { course: Vec::new(), elongation: 0.0, released: 0.0 };
    // The steps are far shorter than the times in which energy and elongation change.
    let look = (1e-3 / step_s).round().max(1.0) as u64;
    for step in 1..=marks[marks.len() - 1] {
        if stepper.step(system, &mut state)?.is_none() {
            break;
        }
        if step % look == 0 {
            run.elongation = run.elongation.max(elongation(system, &state.x));
            run.released = run.released.max(start - system.potential_energy(&state.x));
        }
        if marks.contains(&step) {
            run.course.push(state.x.clone());
        }
    }
    Ok(run)
}

/// A mesh with the courses with which corrected runs are compared.
pub(super) struct Setting {
    pub(super) spec: SystemSpec,
    pub(super) simulation: Simulation,
    pub(super) mesh: Mesh,
    pub(super) hash: String,
    reference: Course,
}

impl Setting {
    pub(super) fn new(kind: Kind, step_s: f64) -> Result<Self, HarnessError> {
        let simulation = |spec: &SystemSpec| -> Result<Simulation, HarnessError> {
            let (system, state) = spec.build()?;
            Ok(Simulation { system, state })
        };
        let spec = kind.spec(SOFT, true)?;
        let soft = simulation(&spec)?;
        let stiff = simulation(&kind.spec(STIFF, true)?)?;
        let reference = plain(&stiff, REFERENCE_STEP)?;
        let coarse = plain(&stiff, 2.0 * REFERENCE_STEP)?;
        let uncorrected = plain(&soft, step_s)?;
        let system = &soft.system;
        let mass: f64 = system.mass().iter().sum();
        let motion = |x: &Vec<Vec3>| distance(system, x, &soft.state.x);
        let mut setting = Self {
            mesh: Mesh {
                id: kind.name().to_owned(),
                particles: system.len(),
                springs: spec.springs.len(),
                stiffness_over_mass_per_s2: SOFT,
                reference_stiffness_over_mass_per_s2: STIFF,
                damping_over_mass_per_s: DAMPING,
                time_s: TIMES.to_vec(),
                motion_m: reference.course.iter().map(|x| motion(x) / mass.sqrt()).collect(),
                reference_error: Vec::new(),
                uncorrected_distance: Vec::new(),
                uncorrected_elongation: uncorrected.elongation,
                reference_elongation: reference.elongation,
                released_j: reference.released,
                portable: true,
            },
            hash: system_hash(&spec),
            spec,
            simulation: soft,
            reference: reference.course,
        };
        setting.mesh.reference_error = setting.distances(&coarse.course);
        setting.mesh.uncorrected_distance = setting.distances(&uncorrected.course);
        Ok(setting)
    }

    /// Distances of a course from the stiff sheet, over its motion.
    pub(super) fn distances(&self, course: &Course) -> Vec<f64> {
        self.between(course, &self.reference)
    }

    /// Distances between two courses, over the motion of the stiff sheet.
    pub(super) fn between(&self, a: &Course, b: &Course) -> Vec<f64> {
        let Simulation { system, state } = &self.simulation;
        let compared = a.iter().zip(b).zip(&self.reference);
        compared
            .map(|((a, b), reference)| {
                distance(system, a, b) / distance(system, reference, &state.x)
            })
            .collect()
    }
}

/// The soft sheet, free and undamped, spinning in its plane with `spin` (1/s).
pub(super) fn spinning(kind: Kind, spin: f64) -> Result<Simulation, HarnessError> {
    let (system, mut state): (System, State) = kind.spec(SOFT, false)?.build()?;
    for (v, x) in state.v.iter_mut().zip(&state.x) {
        *v = (Vec3::z() * spin).cross(x);
    }
    Ok(Simulation { system, state })
}
