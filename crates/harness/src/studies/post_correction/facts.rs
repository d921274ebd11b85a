//! Records of the experiment `post-correction`: springs that a method shortens after each step.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The [`Row::order`] with whose positions other orders are compared.
pub const FORWARD: &str = "forward";

/// The [`Row::order`] of a forward run whose start is moved by a ten-thousandth of a mesh width.
/// Its distance comes from the sensitivity of the motion alone.
pub const PERTURBED: &str = "disturbed start";

/// Effects of the correction on a hanging sheet, on a spinning one, and on a sheet at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The meshes.
    pub meshes: Vec<Mesh>,
    /// Hanging sheets: one for each mesh, method, limit, number of sweeps, order and step size.
    pub rows: Vec<Row>,
    /// Free sheets that spin.
    pub spins: Vec<Spin>,
    /// Repeated sweeps over a sheet that was stretched.
    pub sweeps: Vec<Sweeps>,
}

/// A hanging sheet of soft springs, and the stiff sheet with which it is compared.
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
    /// Motion of the stiff sheet, `‖x_ref − x_0‖_M/√M`, at the times of the mesh, m.
    pub motion_m: Vec<f64>,
    /// Distance of the stiff sheet from the same sheet with twice the step, over its motion.
    pub reference_error: Vec<f64>,
    /// Distance of the soft sheet without correction from the stiff one, over the motion.
    pub uncorrected_distance: Vec<f64>,
    /// Greatest elongation of a spring of the soft sheet without correction, over its rest length.
    pub uncorrected_elongation: f64,
    /// Greatest elongation of a spring of the stiff sheet, over its rest length.
    pub reference_elongation: f64,
    /// Energy that the fall of the stiff sheet sets free, J.
    pub released_j: f64,
    /// Whether the record has the same bits on every machine.
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
    /// Greatest elongation that the correction leaves, over the rest length.
    pub limit: f64,
    /// Number of sweeps a step.
    pub sweeps: u32,
    /// [`FORWARD`], `backward`, `alternating` or `shuffled`; `list 1` or `list 2` for a permuted
    /// list of springs; or [`PERTURBED`].
    pub order: String,
    /// Step size, s.
    pub step_s: f64,
    /// Distance from the stiff sheet, `‖x − x_ref‖_M/‖x_ref − x_0‖_M`, at the times of the mesh.
    pub distance: Vec<f64>,
    /// Distance from the run with forward sweeps, over the motion, at the times of the mesh. It is
    /// empty for that run itself.
    pub order_distance: Vec<f64>,
    /// Sum of the energy that corrections took, over the energy that the fall sets free.
    pub energy_taken: f64,
    /// Sum of the energy that corrections gave, over the energy that the fall sets free.
    pub energy_given: f64,
    /// Vertical momentum from the corrections over that from gravity: the share of the weight that
    /// corrections hold.
    pub weight_held: f64,
    /// `‖M a − f‖/‖f‖` of the trajectory over free particles: root of the mean square over the
    /// steps. `f` is taken at the start of a step.
    pub residual: f64,
    /// The residual of steps without their corrections, measured like that of corrected steps.
    pub uncorrected_residual: f64,
    /// Greatest elongation of a spring at the end of a step, over its rest length.
    pub elongation: f64,
    /// `completed` or `diverged`.
    pub verdict: Verdict,
    /// Whether the record has the same bits on every machine.
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
    /// As in [`Row::limit`]; `None` for a run without correction.
    pub limit: Option<f64>,
    /// Greatest change of the momentum by a correction, over the mass and the speed of the edge.
    pub momentum_change: f64,
    /// Angular momentum at the end, over that at the start.
    pub angular_momentum_left: f64,
    /// Sum of the angular momentum that corrections took, over that at the start. It is negative if
    /// they gave some.
    pub angular_momentum_taken: f64,
    /// Total energy at the end, over that at the start.
    pub energy_left: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// The stretch that repeated sweeps leave of one sheet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sweeps {
    /// As in [`Mesh::id`].
    pub mesh: String,
    /// As in [`Row::limit`].
    pub limit: f64,
    /// Order of the sweeps.
    pub order: String,
    /// Greatest elongation before the sweeps, over the rest length.
    pub before: f64,
    /// Numbers of sweeps.
    pub sweeps: Vec<u32>,
    /// Greatest elongation after each number of sweeps, over the rest length.
    pub elongation: Vec<f64>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// Positions depend on the order if they differ by more than this share of the motion.
pub(super) const DEPENDS: f64 = 0.01;

/// Rows of forward sweeps at the usual step.
pub(super) fn forward(facts: &Facts) -> impl Iterator<Item = &Row> {
    let step = usual_step(facts);
    facts.rows.iter().filter(move |row| row.order == FORWARD && row.step_s == step)
}

impl Sweeps {
    /// Least number of sweeps after which the limit is met within 1 %; `None` if none suffices.
    pub(super) fn met(&self) -> Option<u32> {
        let met = self.elongation.iter().position(|left| *left <= self.limit * 1.01)?;
        self.sweeps.get(met).copied()
    }
}

/// Mesh, label, limit and number of sweeps of a group of rows that differ only in their order.
pub(super) type Key<'a> = (&'a str, &'a str, f64, u32);

pub(super) fn key(row: &Row) -> Key<'_> {
    (&row.mesh, &row.label, row.limit, row.sweeps)
}

/// The step size of most rows: the longest.
pub(super) fn usual_step(facts: &Facts) -> f64 {
    facts.rows.iter().map(|row| row.step_s).fold(0.0, f64::max)
}

/// The groups at the usual step in the record's order, each with one row for each order.
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

/// Greatest distance of the rows from the forward run at each time.
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
