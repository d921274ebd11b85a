//! Records of the experiment `collision`: cloth that falls on a table, a sphere and a plane.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// [`Row::way_out`] of EEH section 6: the normal velocity is prescribed in the solve.
pub const VELOCITY: &str = "velocity";
/// [`Row::way_out`] of Baraff and Witkin: positions are altered within the step, and the solve knows of it.
pub const POSITION: &str = "position";
/// [`Row::way_out`] of moving particles after the step, of which the solve knows nothing.
pub const TELEPORT: &str = "teleport";

/// All methods and ways out on all scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes of [`Facts::rows`].
    pub scenes: Vec<Scene>,
    /// One a scene, a method and a way out.
    pub rows: Vec<Row>,
    /// Rebounds of a particle and of a flat sheet.
    pub bounces: Vec<Bounce>,
}

/// A rippled sheet that falls on an obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: obstacle, speed, k/m, the step size where it is not 0.01 s, `no-shear` without shear springs.
    pub id: String,
    /// `table`, `sphere` or `plane`.
    pub obstacle: String,
    /// Vertical speed at the start, m/s.
    pub speed_m_s: f64,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Step size, s.
    pub step_s: f64,
    /// Number of steps.
    pub steps: u64,
    /// Number of particles.
    pub particles: usize,
    /// Height of the sheet above the obstacle at the start, m.
    pub drop_m: f64,
    /// Energy to which gains refer, J: kinetic at the start, and potential of the drop and of a quarter of a metre more, by which
    /// a draped sheet sags.
    pub available_j: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One method with one way out on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Method, short, as in legends.
    pub label: String,
    /// [`VELOCITY`], [`POSITION`] or [`TELEPORT`].
    pub way_out: String,
    /// Method id with all settings.
    pub method: String,
    /// Steps that began without contact before the first contact.
    pub steps_before: u64,
    /// Steps from the first contact to the end.
    pub steps_after: u64,
    /// Linear iterations in the former: of conjugate gradients, and Newton's where each of them factorises.
    pub iterations_before: u64,
    /// Linear iterations in the latter.
    pub iterations_after: u64,
    /// Iterations of each step, in the scenes whose course is drawn; else empty.
    pub iterations_by_step: Vec<u32>,
    /// Particles moved to the surface by hand, summed over the steps; by the method itself they are not counted.
    pub teleports: u64,
    /// Greatest depth of a particle inside the obstacle at the end of a step (before it is teleported), m.
    pub depth_m: f64,
    /// That over what the fastest particle of the run covers in a step.
    pub depth_over_reach: f64,
    /// Greatest depth of what is displayed, where particles inside are replaced by auxiliary ones, m.
    pub displayed_depth_m: f64,
    /// Sum of the rises of the total energy in steps in which particles leave the obstacle, J.
    pub release_j: f64,
    /// Greatest rise of the total energy above the least before, J.
    pub climb_j: f64,
    /// Greatest rise of the total energy above its start, over that of the scene, [`Scene::available_j`].
    pub gain: f64,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// `stable`, `marginal` or `unstable` by the gain, or `diverged`.
    pub verdict: Verdict,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One rebound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bounce {
    /// `particle` or `sheet`: a flat one, in which no spring has anything to do.
    pub body: String,
    /// `plane`, `table`, or `sphere`, which is hit off its top.
    pub obstacle: String,
    /// Method, short.
    pub label: String,
    /// [`VELOCITY`], [`POSITION`] or [`TELEPORT`].
    pub way_out: String,
    /// Method id with all settings.
    pub method: String,
    /// Vertical speed at the start, m/s.
    pub speed_m_s: f64,
    /// Restitution `e` of the obstacle.
    pub restitution: f64,
    /// Normal speed of the centre of mass after the first contact over that before it; `None` without any contact.
    pub measured: Option<f64>,
    /// Height that the centre of mass reaches again, m; where it hits a horizontal surface.
    pub height_m: Option<f64>,
    /// What theory gives for it: `e²` times the height from which it would have had to fall for its speed.
    pub height_theory_m: Option<f64>,
    /// Same bits on every machine.
    pub portable: bool,
}

impl Row {
    /// Iterations a step from the first contact on.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.iterations_after as f64 / self.steps_after.max(1) as f64
    }
}
