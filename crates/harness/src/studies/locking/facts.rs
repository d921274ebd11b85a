//! Records of the experiment `locking`: how much of the motion a stiff cloth keeps.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The stiffness over mass at which the step varies, 1/s².
pub const BASE_STIFFNESS: f64 = 1e6;
/// The step at which the stiffness varies, s.
pub const BASE_STEP: f64 = 0.01;
/// Label of backward Euler, whose damping is that of an implicit step.
pub const BACKWARD_EULER: &str = "backward-euler";
/// Label of plain IMEX Euler, the method that locks.
pub const IMEX_EULER: &str = "imex-euler";
/// Label of updated, safeguarded CG.
pub(super) const UPDATED: &str = "imex-updated";
/// Greatest relative difference to the prototype, and half of its last digit, m, that confirm it.
const CONFIRMED: (f64, f64) = (0.01, 0.0006);

/// All methods on the hanging sheet, and single springs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The hanging sheets, with the true motion of each.
    pub sheets: Vec<Sheet>,
    /// One a method, sheet and step size.
    pub runs: Vec<Run>,
    /// Single springs loaded across.
    pub springs: Vec<Spring>,
}

/// One sheet, hanging by two corners from a horizontal start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// Key: stiffness over mass of the tension springs, 1/s²; shear springs have a tenth.
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s; shear springs have a tenth.
    pub damping_over_mass_per_s: f64,
    /// Particles along each edge.
    pub side: u32,
    /// Path of the midpoint of the free edge in the first second of the true motion, m.
    pub path_m: f64,
    /// How far the path changes, m, when the step of the reference is doubled.
    pub path_error_m: f64,
    /// When the midpoint has fallen half as far as it falls at most within the first second, s.
    pub half_fall_s: f64,
    /// Step size of the reference, s.
    pub reference_step_s: f64,
    /// `u` at the midpoint, where `L_k u = k 1` with the pins at 0: the terminal speed of the law
    /// is `a u/(h k/m)`.
    pub lever: f64,
    /// Lever of the lowest swing of a sheet that is held along a whole edge: `1/λ`,
    /// `λ = (π/2N)²`.
    pub swing_lever: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One method on one sheet, for one second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Short name for legends.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Key of the sheet, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Step size, s.
    pub step_s: f64,
    /// Path of the midpoint of the free edge, m, through its positions every 0.01 s; `None` for a
    /// run that did not reach the end.
    pub path_m: Option<f64>,
    /// Retained motion `R`: the path over that of the true motion.
    pub retained: Option<f64>,
    /// The path over that of backward Euler at the same step, where that was run.
    pub retained_beside_backward_euler: Option<f64>,
    /// `R_fall`: how far the midpoint has fallen when half of the true fall is over, over how far
    /// it should have.
    pub retained_fall: Option<f64>,
    /// Height of the midpoint at 0.3 s, above that of the start, m.
    pub height_m: Option<f64>,
    /// The path in an independent prototype, m, where it has one.
    pub prototype_path_m: Option<f64>,
    /// Mean speed of fall of the midpoint from 0.5 s to 1 s, m/s.
    pub late_speed_m_s: Option<f64>,
    /// Terminal speed that the law of locking gives for IMEX Euler on this sheet, m/s.
    pub law_m_s: f64,
    /// `stable`, `locked`, `marginal`, `unstable`, `diverged` or `over budget`.
    pub verdict: Verdict,
    /// Greatest rise of the energy above its start over the energy that the true motion sets free.
    pub gain: f64,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One particle on an anchored spring, at rest and at rest length, loaded across the spring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// Short name of the method.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// `along x`, where the exact Hessian of the spring is diagonal, or `oblique`, where it couples
    /// all coordinates.
    pub direction: String,
    /// `θ = h²k/m`.
    pub theta: f64,
    /// Step size, s.
    pub step_s: f64,
    /// Number of steps.
    pub steps: u64,
    /// Load over mass, m/s².
    pub load_m_s2: f64,
    /// Angular momentum over mass and length of the spring at the end, m/s: the speed across it.
    pub speed_m_s: f64,
    /// Speed by the closed form of the method, m/s, to first order in the deflection over the
    /// length.
    pub law_m_s: f64,
    /// Greatest relative deviation, over all steps, from the recurrence that the angular momentum
    /// obeys at any amplitude; `None` where the recurrence holds only for small deflections.
    pub recurrence_error: Option<f64>,
    /// Speed of free fall, m/s.
    pub free_m_s: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// The first locked run of each variant at the base step: the softest sheet first, then the one
/// that keeps the least.
pub(super) fn first_locked(facts: &Facts) -> Vec<&Run> {
    let mut firsts: Vec<&Run> = Vec::new();
    for run in facts.runs.iter().filter(|run| run.step_s == BASE_STEP) {
        if run.verdict != Verdict::Locked {
            continue;
        }
        let softer =
            |first: &Run| first.stiffness_over_mass_per_s2 <= run.stiffness_over_mass_per_s2;
        match firsts.iter_mut().find(|first| first.label == run.label) {
            Some(first) if softer(first) => {}
            Some(first) => *first = run,
            None => firsts.push(run),
        }
    }
    firsts.sort_by(|a, b| {
        let order = a.stiffness_over_mass_per_s2.total_cmp(&b.stiffness_over_mass_per_s2);
        order.then(a.retained.unwrap_or_default().total_cmp(&b.retained.unwrap_or_default()))
    });
    firsts
}

/// Whether a path is that of the prototype; `None` where one of the two is missing.
pub(super) fn agrees_with_prototype(run: &Run) -> Option<bool> {
    let (path, expected) = run.path_m.zip(run.prototype_path_m)?;
    Some((path - expected).abs() <= (CONFIRMED.0 * expected).max(CONFIRMED.1))
}
