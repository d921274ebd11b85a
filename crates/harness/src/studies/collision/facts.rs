//! Records of the experiment `collision`: cloth that falls on a table, a sphere and a plane.

use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// [`Row::way_out`] of EEH section 6: the solve prescribes the normal velocity.
pub const VELOCITY: &str = "velocity";
/// [`Row::way_out`] of Baraff and Witkin: the step alters positions, and the solve takes that into
/// account.
pub const POSITION: &str = "position";
/// [`Row::way_out`] that moves particles after the step, unknown to the solve.
pub const TELEPORT: &str = "teleport";

/// All methods with all ways out on all scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// The scenes of [`Facts::rows`].
    pub scenes: Vec<Scene>,
    /// One row for each scene, method and way out.
    pub rows: Vec<Row>,
    /// Rebounds of a particle and of a flat sheet.
    pub bounces: Vec<Bounce>,
}

/// A rippled sheet that falls on an obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key: the obstacle, the speed and k/m. A step size other than 0.01 s follows, and `no-shear`
    /// for a sheet without shear springs.
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
    /// Energy to which gains are compared, J: the kinetic energy at the start, and the potential
    /// energy of the drop and of the sag of a draped sheet (0.25 m).
    pub available_j: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One method with one way out on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Short name of the method, as in legends.
    pub label: String,
    /// [`VELOCITY`], [`POSITION`] or [`TELEPORT`].
    pub way_out: String,
    /// Method id with all settings.
    pub method: String,
    /// Number of steps before the first contact.
    pub steps_before: u64,
    /// Number of steps from the first contact to the end.
    pub steps_after: u64,
    /// Linear iterations in the steps before contact: of conjugate gradients, or Newton's if each
    /// of those factorises a matrix.
    pub iterations_before: u64,
    /// Linear iterations in the steps from the first contact on.
    pub iterations_after: u64,
    /// Iterations of each step in the scenes whose iterations are plotted; otherwise empty.
    pub iterations_by_step: Vec<u32>,
    /// Number of moves of a particle to the surface by hand, over all steps. Moves by the method
    /// itself are not counted.
    pub teleports: u64,
    /// Greatest depth of a particle inside the obstacle at the end of a step, before a move by
    /// hand, m.
    pub depth_m: f64,
    /// Greatest depth, over the distance that the fastest particle of the run covers in a step.
    pub depth_over_reach: f64,
    /// Greatest displayed depth, m. A particle inside is displayed as an auxiliary particle on the
    /// surface.
    pub displayed_depth_m: f64,
    /// Sum of the rises of the total energy in steps in which particles leave the obstacle, J.
    pub release_j: f64,
    /// Greatest rise of the total energy above its least value before, J.
    pub climb_j: f64,
    /// Greatest rise of the total energy above its start, over [`Scene::available_j`].
    pub gain: f64,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// `stable`, `marginal` or `unstable` by the gain, or `diverged`.
    pub verdict: Verdict,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// One rebound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bounce {
    /// `particle` or `sheet`. The sheet is flat, so that its springs exert no force.
    pub body: String,
    /// `plane`, `table`, or `sphere`, which is hit off its top.
    pub obstacle: String,
    /// Short name of the method.
    pub label: String,
    /// [`VELOCITY`], [`POSITION`] or [`TELEPORT`].
    pub way_out: String,
    /// Method id with all settings.
    pub method: String,
    /// Vertical speed at the start, m/s.
    pub speed_m_s: f64,
    /// Restitution `e` of the obstacle.
    pub restitution: f64,
    /// Normal speed of the centre of mass after the first contact, over that before it; `None`
    /// without contact.
    pub measured: Option<f64>,
    /// Height that the centre of mass reaches again, m; `None` if the surface is not horizontal.
    pub height_m: Option<f64>,
    /// The height in theory, m: `e²` times the height of a fall that ends with the speed of the
    /// contact.
    pub height_theory_m: Option<f64>,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

impl Row {
    /// Number of iterations a step from the first contact on.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.iterations_after as f64 / self.steps_after.max(1) as f64
    }
}

impl Bounce {
    /// Absolute difference between the measured restitution and the obstacle's; infinite without a
    /// contact.
    pub(super) fn miss(&self) -> f64 {
        self.measured.map_or(f64::INFINITY, |measured| (measured - self.restitution).abs())
    }

    /// Relative error of the height.
    pub(super) fn height_error(&self) -> Option<f64> {
        let theory = self.height_theory_m.filter(|height| *height > 0.0)?;
        Some((self.height_m? - theory) / theory)
    }
}

/// Factor of the iterations that counts as the paper's severe increase.
pub(super) const SEVERE: f64 = 2.0;

/// A way out compared with the velocity constraint of the same method.
pub(super) struct Increase<'a> {
    pub(super) label: &'a str,
    pub(super) way_out: &'a str,
    /// The factor of the iterations a step in contact and the scene, in ascending order of the
    /// factor. Scenes in which one of the two runs gains energy are left out.
    pub(super) by_scene: Vec<(f64, &'a str)>,
    /// Number of the scenes that are left out. The iterations of a run that blows the sheet away
    /// cannot be compared.
    pub(super) unstable: usize,
}

/// All other ways out, each compared with the velocity constraint of the same method.
pub(super) fn factors(facts: &Facts) -> Vec<Increase<'_>> {
    increases(&facts.rows)
}

/// The factors of the iterations in all scenes in which neither run gains energy.
pub(in crate::studies) fn ratios(rows: &[Row]) -> Vec<f64> {
    let of = |increase: &Increase<'_>| -> Vec<f64> {
        increase.by_scene.iter().map(|(factor, _)| *factor).collect()
    };
    increases(rows).iter().flat_map(of).collect()
}

fn increases(rows: &[Row]) -> Vec<Increase<'_>> {
    let mut found: Vec<Increase<'_>> = Vec::new();
    for row in rows.iter().filter(|row| row.way_out != VELOCITY) {
        let same = |other: &&Row| {
            other.scene == row.scene && other.label == row.label && other.way_out == VELOCITY
        };
        let Some(velocity) = rows.iter().find(same) else { continue };
        if velocity.iterations_after == 0 {
            continue;
        }
        let (label, way_out) = (row.label.as_str(), row.way_out.as_str());
        let place = found.iter().position(|f| f.label == label && f.way_out == way_out);
        let place = place.unwrap_or_else(|| {
            found.push(Increase { label, way_out, by_scene: Vec::new(), unstable: 0 });
            found.len() - 1
        });
        if row.verdict == Verdict::Stable && velocity.verdict == Verdict::Stable {
            found[place].by_scene.push((row.rate() / velocity.rate(), &row.scene));
        } else {
            found[place].unstable += 1;
        }
    }
    for increase in &mut found {
        increase.by_scene.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    found
}

impl Facts {
    /// Iterations a step from the first contact on, over those before it: with the constraint, for
    /// each method over all scenes.
    pub(super) fn onsets(&self) -> Vec<(&str, f64)> {
        let mut sums: Vec<(&str, [u64; 4])> = Vec::new();
        let own = |row: &&Row| row.way_out == VELOCITY && row.iterations_after > 0;
        for row in self.rows.iter().filter(own) {
            let counts =
                [row.iterations_before, row.steps_before, row.iterations_after, row.steps_after];
            match sums.iter_mut().find(|(label, _)| *label == row.label) {
                Some((_, sum)) => sum.iter_mut().zip(counts).for_each(|(sum, n)| *sum += n),
                None => sums.push((&row.label, counts)),
            }
        }
        let rate = |iterations: u64, steps: u64| iterations as f64 / steps.max(1) as f64;
        let rises = sums.into_iter().map(|(label, [before, steps_before, after, steps_after])| {
            (label, rate(after, steps_after) / rate(before, steps_before))
        });
        rises.filter(|(_, rise)| rise.is_finite()).collect()
    }
}
