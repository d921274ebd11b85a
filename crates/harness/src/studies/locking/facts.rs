//! Records of the experiment `locking`: how much of the motion a stiff cloth keeps.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The stiffness over mass at which the step varies, 1/s².
pub const BASE_STIFFNESS: f64 = 1e6;
/// The step at which the stiffness varies, s.
pub const BASE_STEP: f64 = 0.01;
/// Label of backward Euler, the implicit step with which others are compared.
pub const BACKWARD_EULER: &str = "backward-euler";
/// Label of plain IMEX Euler, the method that locks.
pub const IMEX_EULER: &str = "imex-euler";
/// Label of updated, safeguarded CG.
pub(super) const UPDATED: &str = "imex-updated";
/// Greatest relative difference from the prototype's path, or absolute difference (half of its last
/// digit, m), that confirms it.
const CONFIRMED: (f64, f64) = (0.01, 0.0006);

/// All methods on the hanging sheet, and single springs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The hanging sheets, with the true motion of each.
    pub sheets: Vec<Sheet>,
    /// One run for each method, sheet and step size.
    pub runs: Vec<Run>,
    /// Single springs with a load across them.
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
    /// Length of the path of the free edge's midpoint in the first second of the true motion, m.
    pub path_m: f64,
    /// Change of that path if the step of the reference is doubled, m.
    pub path_error_m: f64,
    /// Time at which the midpoint has fallen half of its greatest fall in the first second, s.
    pub half_fall_s: f64,
    /// Step size of the reference, s.
    pub reference_step_s: f64,
    /// Value of `u` at the midpoint, where `L_k u = k 1` and `u = 0` at the pins. The law's
    /// terminal speed is `a u/(h k/m)`.
    pub lever: f64,
    /// `1/λ` of the lowest swing of a sheet that is held along a whole edge, `λ = (π/2N)²`.
    pub swing_lever: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One method on one sheet for one second.
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
    /// Length of the path of the free edge's midpoint through its positions every 0.01 s, m. `None`
    /// if the run did not reach the end.
    pub path_m: Option<f64>,
    /// Retained motion `R`: the path, over that of the true motion.
    pub retained: Option<f64>,
    /// The path, over that of backward Euler at the same step, if that was run.
    pub retained_beside_backward_euler: Option<f64>,
    /// Retained fall `R_fall`: the fall of the midpoint at [`Sheet::half_fall_s`], over the true
    /// fall then.
    pub retained_fall: Option<f64>,
    /// Height of the midpoint at 0.3 s above its start, m.
    pub height_m: Option<f64>,
    /// The path in an independent prototype, m, if it ran this case.
    pub prototype_path_m: Option<f64>,
    /// Mean speed of fall of the midpoint from 0.5 s to 1 s, m/s.
    pub late_speed_m_s: Option<f64>,
    /// Terminal speed by the law of locking for IMEX Euler on this sheet, m/s.
    pub law_m_s: f64,
    /// `stable`, `locked`, `marginal`, `unstable`, `diverged` or `over budget`.
    pub verdict: Verdict,
    /// Greatest rise of the energy above its start, over the energy that the true motion sets free.
    pub gain: f64,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One particle on an anchored spring, starting at rest and at rest length, with a load across the
/// spring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// Short name of the method.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// `along x`, for which the exact Hessian of the spring is diagonal, or `oblique`, for which it
    /// couples all coordinates.
    pub direction: String,
    /// `θ = h²k/m`.
    pub theta: f64,
    /// Step size, s.
    pub step_s: f64,
    /// Number of steps.
    pub steps: u64,
    /// Load over mass, m/s².
    pub load_m_s2: f64,
    /// Speed across the spring at the end, m/s: the angular momentum over mass and length.
    pub speed_m_s: f64,
    /// Speed by the closed form of the method, m/s. It is of first order in the deflection over the
    /// length.
    pub law_m_s: f64,
    /// Greatest relative deviation, over all steps, from the recurrence of the angular momentum.
    /// `None` if the recurrence holds only for small deflections.
    pub recurrence_error: Option<f64>,
    /// Speed of free fall, m/s.
    pub free_m_s: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// The softest locked run of each variant at the base step. Runs on the softest sheets come first,
/// and on the same sheet those with the least motion.
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

/// Whether a path agrees with that of the prototype; `None` if one of the two is missing.
pub(super) fn agrees_with_prototype(run: &Run) -> Option<bool> {
    let (path, expected) = run.path_m.zip(run.prototype_path_m)?;
    Some((path - expected).abs() <= (CONFIRMED.0 * expected).max(CONFIRMED.1))
}
