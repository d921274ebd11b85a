//! Records of the experiment `trajectory`: which methods follow a smooth motion.

pub(super) use crate::film::HALF;
pub use crate::studies::work_precision::facts::{
    Beside, Flaw, LEAD, PICTURE_S, Row, Run, Tied, Winner,
};
pub(super) use crate::studies::work_precision::facts::{Kind, overtaken, saved, tally};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Levels of error at which winners are named.
pub(super) const LEVELS: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// Number of steps of the coarsest run of a method whose step stiffness does not limit.
pub const FEWEST: u32 = 1;

/// All scenes and methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes, each with its true motions.
    pub scenes: Vec<Scene>,
    /// One row for each scene and form of a method. [`Run::error`] is the error of the trajectory.
    pub rows: Vec<Row>,
    /// The cheapest run without a flaw by modelled time, for each scene and each error that its noise
    /// lets rank.
    pub winners: Vec<Winner>,
}

/// The hanging sheet at one stiffness and damping.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key, e.g. `k/m = 1e6, d/m = 40`.
    pub id: String,
    /// The damping in the scene's own terms: `d/m = 40` (1/s), or `ζ = 0.1` of the stiffest mode.
    pub damping: String,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Damping ratio of the stiffest mode of a sheet without edges: ω² = 4 (k + k_s)/m, with a
    /// damping of (4 d + 8 d_s)/m.
    pub damping_ratio: f64,
    /// Simulated time, s.
    pub span_s: f64,
    /// Distance that the particles move in that time: the root of the mass-weighted mean square, m.
    pub motion_m: f64,
    /// Energy that the scene sets free, J: the potential energy at the start, less its least value
    /// at the end of a frame.
    pub released_j: f64,
    /// Energy that the true motion loses, over the energy that the scene sets free.
    pub dissipated: f64,
    /// 99th percentile of the strain of the true motion: a mean over time.
    pub strain: f64,
    /// Distance of two true motions whose tolerances differ tenfold, over the motion.
    pub reference_error: f64,
    /// The tighter of the two tolerances of the reference.
    pub reference_tolerance: f64,
    /// Number of true motions: one without noise, and others whose particles start up to 1 µm away
    /// along the normal of the sheet. A run is compared with the nearest.
    pub members: usize,
    /// Mean error of the motions with noise against the one without. A smaller error means nothing.
    pub floor: f64,
    /// Mean distance of the surfaces of the motions with noise from the one without, m.
    pub shape_floor_m: f64,
    /// Mean error of the strain of the motions with noise against the one without.
    pub strain_floor: f64,
    /// Mean error of the energy at the end of the motions with noise against the one without, over
    /// the energy that the scene sets free.
    pub energy_floor: f64,
    /// Modelled time that a run may take, s: it ends at the visits that take at least this time at
    /// its prices.
    pub budget_s: f64,
}

impl Scene {
    /// Whether the sheet is damped. The prices of work were fitted to damped sheets, so modelled
    /// times without damping are guesses.
    pub fn is_damped(&self) -> bool {
        self.damping_over_mass_per_s > 0.0
    }

    /// Whether an error is large enough to rank: at least twice the noise. Noise alone sets two
    /// true motions apart, and a run may err by as much again.
    pub fn ranks(&self, level: f64) -> bool {
        level >= 2.0 * self.floor
    }
}
