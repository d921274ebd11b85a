//! Records of the experiment `post-correction`: springs that are shortened by hand after a step.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// [`Row::order`] to whose positions those of the other orders are compared.
pub const FORWARD: &str = "forward";

/// [`Row::order`] of a forward run whose start is disturbed by a ten-thousandth of a mesh width:
/// the distance that comes from the sensitivity of the motion alone.
pub const PERTURBED: &str = "disturbed start";

/// What the correction does to a hanging sheet, to a spinning one, and to a stretched one at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The meshes.
    pub meshes: Vec<Mesh>,
    /// Hanging sheets: one a mesh, method, limit, number of sweeps, order and step size.
    pub rows: Vec<Row>,
    /// Free sheets that spin.
    pub spins: Vec<Spin>,
    /// Sweeps over a sheet that was stretched.
    pub sweeps: Vec<Sweeps>,
}

/// A sheet of soft springs that hangs from two corners, beside a stiff one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// Key: `grid` or `triangles`.
    pub id: String,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Stiffness over mass of the soft tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Stiffness over mass of the stiff sheet, the reference, 1/s².
    pub reference_stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs of both, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Times at which positions are compared, s.
    pub time_s: Vec<f64>,
    /// Motion of the stiff sheet, `‖x_ref − x_0‖_M/√M` at the times of the mesh, m.
    pub motion_m: Vec<f64>,
    /// Difference of the stiff sheet to itself with twice the step, over its motion.
    pub reference_error: Vec<f64>,
    /// Distance of the soft sheet without correction to the stiff one, over the motion.
    pub uncorrected_distance: Vec<f64>,
    /// Greatest elongation of a spring of the soft sheet without correction in the run, over its
    /// rest length.
    pub uncorrected_elongation: f64,
    /// Greatest elongation of a spring of the stiff sheet in the run, over its rest length.
    pub reference_elongation: f64,
    /// Energy that the fall of the stiff sheet sets free, J.
    pub released_j: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One corrected hanging sheet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// As in [`Mesh::id`].
    pub mesh: String,
    /// `provot` or `desbrun`.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Greatest elongation that is left to a spring, over its rest length.
    pub limit: f64,
    /// Sweeps a step.
    pub sweeps: u32,
    /// [`FORWARD`], `backward`, `alternating`, `shuffled`, or a permutation of the list of springs,
    /// `list 1` and `list 2`; or [`PERTURBED`].
    pub order: String,
    /// Step size, s.
    pub step_s: f64,
    /// `‖x − x_ref‖_M/‖x_ref − x_0‖_M` at the times of the mesh, for the stiff sheet `x_ref`.
    pub distance: Vec<f64>,
    /// Distance over the motion to the run with forward sweeps, at the times of the mesh; empty for
    /// that run itself.
    pub order_distance: Vec<f64>,
    /// Energy that corrections took, summed, over that which the fall sets free.
    pub energy_taken: f64,
    /// Energy that corrections gave, summed, over that which the fall sets free.
    pub energy_given: f64,
    /// Vertical momentum that corrections gave over that which gravity gave: the share of the
    /// weight which they hold.
    pub weight_held: f64,
    /// `‖M a − f‖/‖f‖` of the trajectory over free particles, root of the mean square over the
    /// steps; `f` at the start of a step.
    pub residual: f64,
    /// The residual where each step is taken without its correction.
    pub uncorrected_residual: f64,
    /// Greatest elongation of a spring at the end of a step, over its rest length.
    pub elongation: f64,
    /// `completed` or `diverged`.
    pub verdict: Verdict,
    /// Same bits on every machine.
    pub portable: bool,
}

/// One free sheet that spins in its plane, undamped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spin {
    /// As in [`Mesh::id`].
    pub mesh: String,
    /// `provot` or `desbrun`.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// As in [`Row::limit`]; `None` without correction.
    pub limit: Option<f64>,
    /// Greatest change of the momentum by a correction, over mass and speed of the edge.
    pub momentum_change: f64,
    /// Angular momentum at the end over that at the start.
    pub angular_momentum_left: f64,
    /// Part of the angular momentum that the corrections took, summed; negative where they gave.
    pub angular_momentum_taken: f64,
    /// Total energy at the end over that at the start.
    pub energy_left: f64,
    /// Same bits on every machine.
    pub portable: bool,
}

/// What is left of the stretch after more and more sweeps over one and the same sheet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sweeps {
    /// As in [`Mesh::id`].
    pub mesh: String,
    /// As in [`Row::limit`].
    pub limit: f64,
    /// Order of the sweeps.
    pub order: String,
    /// Greatest elongation before, over the rest length.
    pub before: f64,
    /// Numbers of sweeps.
    pub sweeps: Vec<u32>,
    /// Greatest elongation after so many sweeps, over the rest length.
    pub elongation: Vec<f64>,
    /// Same bits on every machine.
    pub portable: bool,
}

/// Positions that differ by more than this share of the motion depend on the order.
pub(super) const DEPENDS: f64 = 0.01;

/// Forward sweeps at the usual step.
pub(super) fn forward(facts: &Facts) -> impl Iterator<Item = &Row> {
    let step = usual_step(facts);
    facts.rows.iter().filter(move |row| row.order == FORWARD && row.step_s == step)
}

impl Sweeps {
    /// Sweeps after which the limit is met within 1 %.
    pub(super) fn met(&self) -> Option<u32> {
        let met = self.elongation.iter().position(|left| *left <= self.limit * 1.01)?;
        self.sweeps.get(met).copied()
    }
}

/// Mesh, label, limit and sweeps of the groups of rows that differ in their order.
pub(super) type Key<'a> = (&'a str, &'a str, f64, u32);

pub(super) fn key(row: &Row) -> Key<'_> {
    (&row.mesh, &row.label, row.limit, row.sweeps)
}

/// The step size of most rows: the longest.
pub(super) fn usual_step(facts: &Facts) -> f64 {
    facts.rows.iter().map(|row| row.step_s).fold(0.0, f64::max)
}

/// Groups in the order of the record, each with the rows of its orders, at the usual step.
pub(super) fn groups(facts: &Facts) -> Vec<(Key<'_>, Vec<&Row>)> {
    let step = usual_step(facts);
    let mut groups: Vec<(Key<'_>, Vec<&Row>)> = Vec::new();
    for row in facts.rows.iter().filter(|row| row.step_s == step) {
        match groups.iter_mut().find(|(of, _)| *of == key(row)) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((key(row), vec![row])),
        }
    }
    groups
}

/// Greatest distance to the forward run at each time.
pub(super) fn spread(rows: &[&Row]) -> Vec<f64> {
    let mut spread: Vec<f64> = Vec::new();
    for row in rows.iter().filter(|row| row.order != PERTURBED) {
        for (n, distance) in row.order_distance.iter().enumerate() {
            match spread.get_mut(n) {
                Some(greatest) => *greatest = greatest.max(*distance),
                None => spread.push(*distance),
            }
        }
    }
    spread
}
