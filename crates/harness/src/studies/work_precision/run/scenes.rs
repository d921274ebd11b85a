//! The scenes: how the sheet is held and starts, its stiffness, damping and size.

use super::runs::KeptRuns;
use super::truth::Truth;
use crate::run::Simulation;
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::studies::work_precision::facts::{
    FEWEST, FIXED_MATERIAL, FIXED_QUOTIENT, STIFFNESS, Scene,
};
use crate::{HarnessError, system_hash};
use drape_model::{DampingLaw, PinSpec, State, System, SystemSpec, Vec3};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::adaptive::{Pair, adaptive};
use drape_oracle::order::position_error;
use std::sync::Arc;

/// How a sheet is held and starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::studies) enum Shape {
    /// Held by two corners of one edge, it swings down.
    Hanging,
    /// Free, it turns, folds and falls.
    Thrown,
    /// Held by four corners, it sags.
    Spread,
}

/// A scene before it is built.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::studies) struct Case {
    pub(in crate::studies) shape: Shape,
    /// Whether damping is heavy: `d/m = √(k/m)`.
    pub(in crate::studies) is_heavy: bool,
    /// k/m, 1/s².
    pub(in crate::studies) stiffness: f64,
    /// Particles along each edge.
    pub(in crate::studies) side: u32,
    /// Damping over mass with light damping, 1/s.
    pub(in crate::studies) light: f64,
    pub(in crate::studies) series: Vec<&'static str>,
    /// Largest effort of a run, in visits of a spring.
    pub(in crate::studies) budget: f64,
}

/// Simulated time, s.
pub(in crate::studies) const SPAN: f64 = 0.25;
/// Light damping over mass of the sheet of [`SIDE`]² particles, 1/s.
const LIGHT: f64 = 10.0;
/// Particles along each edge of the usual sheet.
const SIDE: u32 = 20;
/// Particles along each edge where the reference would take too long.
const SMALL_SIDE: u32 = 10;
/// Radius of the cylinder on which the sheet starts, m. Every spring starts at its rest length, so
/// that a stiff sheet does not ring.
const RADIUS: f64 = 1.5;
/// Spin of the thrown sheet, rad/s.
const SPIN: [f64; 3] = [4.0, 3.0, 2.0];
/// Strength of the fold of the thrown sheet, 1/(m s): this times the square of the distance from
/// the middle line is a particle's extra speed.
const FOLD: f64 = 4.0;
/// Largest effort of a run on a lightly damped hanging sheet from [`STIFF`] on, in visits of a
/// spring. The headline figure shows these runs.
const BUDGET: f64 = 1.2e8;
const STIFF: f64 = 1e6;
/// Largest effort of other runs on up to [`SIDE`]² particles. It grows in proportion to the
/// particles beyond.
const SMALL_BUDGET: f64 = 3e7;
/// No finer run is made after one with a smaller error than this.
const ENOUGH: f64 = 1e-5;
/// Tolerance of the reference solution.
pub(in crate::studies) const TOLERANCE: f64 = 1e-10;

/// The scenes form a star around one hanging sheet. Its arms vary the stiffness with light and with
/// heavy damping, the way the sheet is held, and the size in two ways. At k/m = 100 s⁻² heavy damping
/// is as strong as light damping, so only the light scene is there.
pub(super) fn cases() -> Vec<Case> {
    let base = Case {
        shape: Shape::Hanging,
        is_heavy: false,
        stiffness: 1e6,
        side: SIDE,
        light: LIGHT,
        series: Vec::new(),
        budget: SMALL_BUDGET,
    };
    let mut cases = Vec::new();
    for is_heavy in [false, true] {
        let softest = usize::from(is_heavy);
        for stiffness in [1e2, 1e4, 1e6, 1e8, 1e10].into_iter().skip(softest) {
            let side = if stiffness > 1e9 { SMALL_SIDE } else { SIDE };
            let is_dear = !is_heavy && stiffness >= STIFF;
            let budget = if is_dear { BUDGET } else { SMALL_BUDGET };
            let is_middle = !is_heavy && stiffness == base.stiffness;
            let mut series = vec![STIFFNESS];
            series.extend(
                is_middle.then_some([FIXED_QUOTIENT, FIXED_MATERIAL]).into_iter().flatten(),
            );
            cases.push(Case { is_heavy, stiffness, side, budget, series, ..base.clone() });
        }
    }
    for shape in [Shape::Thrown, Shape::Spread] {
        cases.extend([1e4, 1e6, 1e8].map(|stiffness| Case {
            shape,
            stiffness,
            series: vec![STIFFNESS],
            ..base.clone()
        }));
    }
    for side in [10, 40] {
        let refinement = f64::from(side * side) / f64::from(SIDE * SIDE);
        let budget = SMALL_BUDGET * refinement.max(1.0);
        cases.push(Case { side, budget, series: vec![FIXED_QUOTIENT], ..base.clone() });
        cases.push(Case {
            side,
            budget,
            stiffness: base.stiffness * refinement,
            light: LIGHT * refinement,
            series: vec![FIXED_MATERIAL],
            ..base.clone()
        });
    }
    cases
}

impl Case {
    /// Whether this is the lightly damped hanging sheet in the series over stiffness.
    pub(super) fn is_base(&self) -> bool {
        self.shape == Shape::Hanging && !self.is_heavy && self.series.contains(&STIFFNESS)
    }

    /// Whether this is the finest sheet of the series with fixed material.
    pub(super) fn is_finest(&self) -> bool {
        self.side > SIDE && self.series.contains(&FIXED_MATERIAL)
    }

    /// Whether its runs are timed.
    pub(super) fn is_timed(&self) -> bool {
        self.is_base() || self.is_finest() || (self.is_heavy && self.stiffness >= 1e6)
    }

    /// The particle whose path is measured: the middle of the edge across from the pins. Where both
    /// edges are pinned, it is the middle of the sheet.
    pub(super) fn tracked(&self) -> usize {
        let side = self.side as usize;
        let row = if self.shape == Shape::Spread { side / 2 } else { side - 1 };
        row * side + side / 2
    }

    /// Whether the quick subset has it.
    pub(super) fn is_quick(&self) -> bool {
        self.is_base() && self.stiffness == 1e4
    }

    fn damping(&self) -> f64 {
        if self.is_heavy { self.stiffness.sqrt() } else { self.light }
    }

    fn name(&self) -> &'static str {
        match self.shape {
            Shape::Hanging => "hanging",
            Shape::Thrown => "thrown",
            Shape::Spread => "spread",
        }
    }

    fn damping_name(&self) -> &'static str {
        if self.is_heavy { "heavy" } else { "light" }
    }

    pub(super) fn id(&self) -> String {
        let (scene, damping) = (self.name(), self.damping_name());
        format!("{scene} {damping} {:e} n={}", self.stiffness, self.side * self.side)
    }

    /// Of the fastest oscillation, 1/s.
    pub(in crate::studies) fn greatest_frequency(&self) -> f64 {
        self.sheet().greatest_frequency(1.0)
    }

    fn sheet(&self) -> Sheet {
        Sheet {
            side: self.side,
            tension: self.stiffness,
            shear: 0.25 * self.stiffness,
            damping: self.damping(),
            law: DampingLaw::Full,
            gravity: GRAVITY,
            is_pinned: self.shape != Shape::Thrown,
        }
    }

    /// The system of the sheet at its start.
    pub(in crate::studies) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        let mut spec = self.sheet().spec()?;
        for position in &mut spec.particles.position_m {
            let angle = position[0] / RADIUS;
            position[0] = RADIUS * libm::sin(angle);
            position[2] = RADIUS * (1.0 - libm::cos(angle));
        }
        // A chord is shorter than its arc. With the rest lengths of the flat sheet every spring
        // would start compressed, and at k/m = 1e10 that energy would outweigh the fall.
        let x = &spec.particles.position_m;
        for spring in &mut spec.springs {
            let [a, b] = [spring.i, spring.j].map(|i| Vec3::from(x[i as usize]));
            spring.rest_length_m = (a - b).norm();
        }
        if self.shape == Shape::Thrown {
            let center = spec.particles.position_m.iter().map(|x| Vec3::from(*x)).sum::<Vec3>()
                / spec.particles.position_m.len() as f64;
            let velocity = |x: &[f64; 3]| {
                let fold = Vec3::new(0.0, 0.0, FOLD * x[0] * x[0]);
                (Vec3::from(SPIN).cross(&(Vec3::from(*x) - center)) + fold).into()
            };
            spec.particles.velocity_m_s = spec.particles.position_m.iter().map(velocity).collect();
        }
        if self.shape == Shape::Spread {
            let last = self.side * (self.side - 1);
            let corners = [last, last + self.side - 1];
            spec.pins.extend(corners.map(PinSpec::still));
        }
        Ok(spec)
    }
}

/// The outward normal of the cylinder at a point `x` of it. Every sheet starts on the cylinder.
pub(super) fn normal(x: &Vec3) -> Vec3 {
    Vec3::new(-x.x, 0.0, RADIUS - x.z) / RADIUS
}

/// A scene with its reference solution.
#[derive(Clone)]
pub(in crate::studies) struct Setting {
    pub(in crate::studies) case: Case,
    pub(in crate::studies) simulation: Simulation,
    /// No finer run is made after one with a smaller error than this.
    pub(in crate::studies) enough: f64,
    /// Number of steps of the coarsest run of a method whose step stiffness does not limit: a power
    /// of two.
    pub(in crate::studies) fewest: u32,
    /// Whether explicit methods that are stable at any step begin like implicit ones. In
    /// `work-precision`, whose runs were timed, they begin beyond the limit of the others.
    pub(in crate::studies) stabilised_begin_coarse: bool,
    /// Modelled time that a run may take, s, beside the budget of the scene: it ends at the visits
    /// that take at least this time at its prices.
    pub(in crate::studies) most_s: f64,
    /// The positions of the reference at the end, m.
    pub(super) exact: Vec<Vec3>,
    pub(in crate::studies) hash: String,
    pub(in crate::studies) scene: Scene,
    /// The true motions, for studies that judge more than the positions at the end. A run is
    /// compared with the nearest.
    pub(super) truth: Option<Truth>,
    /// Keeps the runs for other rows on the same scene; `None` where no other row has the same.
    pub(in crate::studies) kept: Option<Arc<KeptRuns>>,
}

impl Setting {
    pub(in crate::studies) fn new(case: &Case) -> Result<Self, HarnessError> {
        Self::of(case, &case.spec()?, TOLERANCE, |system, state| {
            Ok([at_end(system, state, TOLERANCE)?, at_end(system, state, 10.0 * TOLERANCE)?])
        })
    }

    /// A scene with its own reference. `ends` gives the last states of two runs, the better one
    /// first; `tolerance` belongs to the better one.
    pub(in crate::studies) fn of(
        case: &Case,
        spec: &SystemSpec,
        tolerance: f64,
        ends: impl FnOnce(&System, &State) -> Result<[State; 2], HarnessError>,
    ) -> Result<Self, HarnessError> {
        let (system, state) = spec.build()?;
        let [tight, loose] = ends(&system, &state)?;
        let mass: f64 = system.mass().iter().sum();
        let moved = system.mass().iter().zip(tight.x.iter().zip(&state.x));
        let moved: f64 = moved.map(|(m, (a, b))| m * (a - b).norm_squared()).sum();
        let scene = Scene {
            id: case.id(),
            scene: case.name().to_owned(),
            damping: case.damping_name().to_owned(),
            series: case.series.iter().map(|series| (*series).to_owned()).collect(),
            particles: system.len(),
            springs: spec.springs.len(),
            stiffness_over_mass_per_s2: case.stiffness,
            damping_over_mass_per_s: case.damping(),
            greatest_frequency_per_s: case.greatest_frequency(),
            span_s: SPAN,
            motion_m: (moved / mass).sqrt(),
            reference_error: position_error(&system, &state.x, &tight.x, &loose.x),
            reference_tolerance: tolerance,
            floor: 0.0,
            energy_floor: 0.0,
            budget: case.budget,
        };
        let hash = system_hash(spec);
        let simulation = Simulation { system, state };
        Ok(Self {
            case: case.clone(),
            simulation,
            enough: ENOUGH,
            fewest: FEWEST,
            stabilised_begin_coarse: false,
            most_s: f64::INFINITY,
            exact: tight.x,
            hash,
            scene,
            truth: None,
            kept: None,
        })
    }

    /// Error of the positions `x` at the end, against the nearest true motion.
    pub(in crate::studies) fn error(&self, x: &[Vec3]) -> f64 {
        let Simulation { system, state } = &self.simulation;
        match &self.truth {
            Some(truth) => truth.error(system, x),
            None => position_error(system, &state.x, &self.exact, x),
        }
    }
}

pub(in crate::studies) fn at_end(
    system: &System,
    state: &State,
    tolerance: f64,
) -> Result<State, HarnessError> {
    let settings = AdaptiveSettings { tolerance, max_steps: 4_000_000 };
    Ok(adaptive(Pair::Dop853, system, state, SPAN, settings)?.state)
}
