//! Records of the experiment `work-precision`: what accuracy costs.

use crate::film::HALF;
use crate::stability::STABLE;
use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Number of steps of the coarsest run of a method whose step stiffness does not limit.
pub const FEWEST: u32 = 8;
/// Time from one picture of a film to the next, s. Who follows a motion has a state for each.
pub const PICTURE_S: f64 = 1.0 / 24.0;
/// Series of scenes in which the stiffness varies.
pub const STIFFNESS: &str = "stiffness";
/// Series of scenes with different numbers of particles and the same stiffness over mass.
pub const FIXED_QUOTIENT: &str = "size, k/m fixed";
/// Series of scenes with different numbers of particles and the same material.
pub const FIXED_MATERIAL: &str = "size, material fixed";

/// A lead below this factor is a tie: steps are powers of two, and modelled times may be off by as
/// much.
pub const LEAD: f64 = 2.0;

/// All scenes and methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Scenes with stiffness, damping and size, and the errors of their reference solutions.
    pub scenes: Vec<Scene>,
    /// One row for each scene and method.
    pub rows: Vec<Row>,
    /// The cheapest run by modelled time for each scene and level of error.
    pub winners: Vec<Winner>,
}

/// One scene at one stiffness, damping and size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Key, e.g. `hanging light 1e6 n=400`.
    pub id: String,
    /// `hanging`, `thrown` or `spread`.
    pub scene: String,
    /// `light` (10/s at 400 particles) or `heavy` (`d/m = √(k/m)`).
    pub damping: String,
    /// Series that the scene belongs to: `stiffness`, `size, k/m fixed`, `size, material fixed`.
    pub series: Vec<String>,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Bound on the largest angular frequency, `√(8 (k + k_s)/m)`, 1/s.
    pub greatest_frequency_per_s: f64,
    /// Simulated time, s. Errors are taken at its end.
    pub span_s: f64,
    /// Distance that the particles move in that time: the root of the mass-weighted mean square, m.
    pub motion_m: f64,
    /// Error of the reference in the same norm as all other errors: the distance of two solutions
    /// whose tolerances differ tenfold, over the motion.
    pub reference_error: f64,
    /// The tighter of the two tolerances of the reference.
    pub reference_tolerance: f64,
    /// Mean error of eight motions whose starts differ by up to 1 µm along the normal of the sheet,
    /// against the motion without this noise. A smaller error means nothing.
    #[serde(default)]
    pub floor: f64,
    /// Mean error of the energy at the end of these motions, over the energy that the scene sets
    /// free.
    #[serde(default)]
    pub energy_floor: f64,
    /// Largest effort of a run, in visits of a spring.
    pub budget: f64,
}

impl Scene {
    /// Whether an error is large enough to rank: at least twice the noise. Noise alone sets two
    /// true motions apart, and a run may err by as much again.
    pub fn ranks(&self, level: f64) -> bool {
        level >= 2.0 * self.floor
    }
}

/// One method on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Short name for legends: the method's id, and what sets this row apart from the method's
    /// others.
    pub label: String,
    /// Method id with the settings that are the same in all runs; `dop853` for the adaptive method
    /// of the references.
    pub method: String,
    /// What differs from run to run: `steps`, `tolerance` or another setting of the method.
    pub knob: String,
    /// Whether the row stands in the headline figure.
    pub is_headline: bool,
    /// One run for each value of the knob, coarsest first.
    pub runs: Vec<Run>,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Value of the knob: number of steps, tolerance, or another setting.
    pub value: f64,
    /// Step that the method is asked for, s; `None` for DOP853, which chooses its own.
    pub step_s: Option<f64>,
    /// `completed`, `diverged` or `over budget`.
    pub verdict: Verdict,
    /// `‖x − x_ref‖_M / ‖x_ref − x_0‖_M` at the end; `None` unless completed.
    pub error: Option<f64>,
    /// The run's other errors, where the study measures them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside: Option<Beside>,
    /// Why the run may not win, however small its error is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flaw: Option<Flaw>,
    /// Modelled time of the run, s: its counts times the prices of its form. The prices were
    /// measured once and are part of the source. Runs are ranked by this time.
    pub modelled_s: f64,
    /// Visits of a spring, the unit of the budget. A run over budget has its effort when it was
    /// given up, or 0 if it was not begun.
    pub effort: f64,
    /// Number of steps taken.
    pub steps: u64,
    /// Sweeps over all springs that evaluated forces or energies.
    pub force_evaluations: u64,
    /// Products of a matrix with a block vector, triangular solves included.
    pub matvecs: u64,
    /// Factorisations of Newton's matrix.
    pub factorisations: u64,
    /// Set-ups of cached operators.
    pub setups: u64,
    /// Iterations of conjugate gradients.
    pub cg_iterations: u64,
    /// Steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// Whether no run without a flaw, of any method on this scene, has at most this error for less
    /// modelled time.
    pub is_on_front: bool,
    /// Whether the counts have the same bits on every machine. Errors never have: the reference
    /// calls a library's functions.
    pub portable: bool,
}

/// Errors of a run other than the error of its positions, against the nearest true motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beside {
    /// Mean distance of the two surfaces, both ways, m: a mean over time.
    pub shape_m: f64,
    /// 99th percentile of the strain less the true one: a mean over time.
    pub strain: f64,
    /// Energy at the end less the true one, over the energy that the scene sets free. It is
    /// negative where the method dissipates.
    pub energy: f64,
    /// Length of the path of the free edge's midpoint, over the true length.
    pub retained: f64,
}

impl Beside {
    /// What is wrong with the run, although its error may be small. `floor` is the noise of the
    /// energy. A run that ends with too much energy is unstable and is near the true motion by
    /// chance. The limit is that of a stable run. A loss of energy is no flaw: it shows in the error
    /// and in the motion kept.
    pub(super) fn flaw(&self, floor: f64) -> Option<Flaw> {
        if self.energy > STABLE.max(2.0 * floor) {
            Some(Flaw::GainsEnergy)
        } else if self.retained < HALF {
            Some(Flaw::Locked)
        } else {
            None
        }
    }
}

/// Why a run may not win.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Flaw {
    /// At the end it has more energy than a stable run may have.
    #[serde(rename = "gains energy")]
    GainsEnergy,
    /// It keeps less than half of the motion.
    #[serde(rename = "locked")]
    Locked,
    /// Its steps are longer than a [picture](PICTURE_S), so it shows the end and not the motion.
    #[serde(rename = "skips pictures")]
    SkipsPictures,
}

/// The cheapest run without a flaw at one scene and level of error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Winner {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// Level of error: the error of the winner is at most this.
    pub level: f64,
    /// As in [`Row::label`]; `None` if no run reaches the level.
    pub label: Option<String>,
    /// Whether the winner is explicit, i.e. stiffness limits its step.
    pub is_explicit: Option<bool>,
    /// Value of the winner's knob, as in [`Run::value`].
    pub value: Option<f64>,
    /// Modelled time of the winner, s.
    pub modelled_s: Option<f64>,
    /// The winner's error of the energy, as in [`Beside::energy`].
    #[serde(default)]
    pub energy: Option<f64>,
    /// The share of the motion that the winner keeps, as in [`Beside::retained`].
    #[serde(default)]
    pub retained: Option<f64>,
    /// Label of the cheapest row of another method.
    pub runner_up: Option<String>,
    /// Modelled time of the runner-up over that of the winner.
    pub ratio: Option<f64>,
    /// Rows of other methods that tie: their modelled times are too near for an order.
    pub tied: Vec<Tied>,
    /// Whether no method ties, but one would at errors that are a tenth larger. Steps are powers of
    /// two, so this lead may come from the steps alone.
    #[serde(default)]
    pub is_narrow: bool,
}

/// A method whose modelled time ties with the winner's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tied {
    /// As in [`Row::label`].
    pub label: String,
    /// As in [`Winner::is_explicit`].
    pub is_explicit: bool,
    /// Modelled time of the tied row over that of the winner, below [`LEAD`].
    pub ratio: f64,
}

/// Times of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimingRow {
    /// Key of the scene, as in [`Scene::id`].
    pub scene: String,
    /// As in [`Row::label`].
    pub label: String,
    /// Value of the knob, as in [`Run::value`].
    pub value: f64,
    /// Nanoseconds of the whole run, set-up and all steps: one entry for each repetition.
    pub samples_ns: Vec<u64>,
    /// Median of the samples, s.
    pub seconds: f64,
    /// Error of the run that was timed, as in [`Run::error`].
    pub error: f64,
    /// Whether this error equals the error in the facts to the last bit. If not, the run is not
    /// ranked.
    pub is_verified: bool,
    /// Seconds of a fixed loop before or after the samples, whichever is longer; more than
    /// elsewhere in the file if another program disturbed the machine. `None` in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe_s: Option<f64>,
}

/// The rows of a scene.
pub(super) fn rows_of<'a>(
    facts: &'a Facts,
    scene: &'a str,
) -> impl Iterator<Item = &'a Row> + Clone {
    facts.rows.iter().filter(move |row| row.scene == scene)
}

impl Row {
    /// Whether the method spends the budget without reaching an error of `level`.
    pub(super) fn misses(&self, level: f64) -> bool {
        let is_cut = self.runs.last().is_some_and(|run| run.verdict == Verdict::OverBudget);
        is_cut && !self.runs.iter().any(|run| run.is_within(level))
    }
}

impl Run {
    /// A run of which nothing is counted and no error is known.
    #[must_use]
    pub fn uncounted(value: f64, step_s: Option<f64>, verdict: Verdict) -> Self {
        Self {
            value,
            step_s,
            verdict,
            error: None,
            beside: None,
            flaw: None,
            modelled_s: 0.0,
            effort: 0.0,
            steps: 0,
            force_evaluations: 0,
            matvecs: 0,
            factorisations: 0,
            setups: 0,
            cg_iterations: 0,
            unconverged_steps: 0,
            is_on_front: false,
            portable: true,
        }
    }

    /// Whether its steps are longer than a picture, and nothing else is wrong with it.
    pub(in crate::studies) fn skips_pictures(&self) -> bool {
        self.flaw == Some(Flaw::SkipsPictures)
    }

    /// Whether the error is at most `level`.
    pub(in crate::studies) fn is_within(&self, level: f64) -> bool {
        self.error.is_some_and(|error| error <= level)
    }

    /// Whether the run may win at an error of `level`.
    pub(crate) fn is_good(&self, level: f64) -> bool {
        self.flaw.is_none() && self.is_within(level)
    }
}

/// The kind of methods that leads by at least [`LEAD`], or a tie of both kinds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::studies) enum Kind {
    Explicit,
    Implicit,
    Tie,
}

impl Winner {
    /// The run that won, of the rows of its record; `None` if no run did.
    pub fn run<'a>(&self, rows: &'a [Row]) -> Option<&'a Run> {
        let is_its =
            |row: &&Row| row.scene == self.scene && Some(&row.label) == self.label.as_ref();
        rows.iter().find(is_its)?.runs.iter().find(|run| Some(run.value) == self.value)
    }

    /// The kind that leads; `None` if no run reaches the error.
    pub(in crate::studies) fn kind(&self) -> Option<Kind> {
        let is_explicit = self.is_explicit?;
        let is_tie = self.tied.iter().any(|tied| tied.is_explicit != is_explicit);
        Some(match is_explicit {
            _ if is_tie => Kind::Tie,
            true => Kind::Explicit,
            false => Kind::Implicit,
        })
    }
}

/// How many scenes explicit methods lead, how many implicit ones lead, and on how many they tie.
pub(in crate::studies) fn tally(kinds: impl Iterator<Item = Kind> + Clone) -> [usize; 3] {
    let of = |kind: Kind| kinds.clone().filter(|other| *other == kind).count();
    [Kind::Explicit, Kind::Implicit, Kind::Tie].map(of)
}

/// How many winners would be others if a run that gains energy or hardly moves could win.
pub(in crate::studies) fn saved<'a>(
    winners: impl Iterator<Item = &'a Winner>,
    rows: &[Row],
) -> usize {
    overtaken(winners, rows, |flaw| flaw != Flaw::SkipsPictures)
}

/// How many winners would be others if runs with some flaws could win.
pub(in crate::studies) fn overtaken<'a>(
    winners: impl Iterator<Item = &'a Winner>,
    rows: &[Row],
    may_win: fn(Flaw) -> bool,
) -> usize {
    let is_overtaken = |winner: &&Winner| {
        let most = winner.modelled_s.unwrap_or(f64::INFINITY);
        let own = rows.iter().filter(|row| row.scene == winner.scene).flat_map(|row| &row.runs);
        let mut flawed = own.filter(|run| run.flaw.is_some_and(may_win));
        flawed.any(|run| run.is_within(winner.level) && run.modelled_s < most)
    };
    winners.filter(is_overtaken).count()
}

/// The run with the least modelled time among those without a flaw and with an error of at most
/// `level`. Of equally cheap runs it is the more accurate.
pub(in crate::studies) fn cheapest<'a>(
    rows: impl Iterator<Item = &'a Row>,
    level: f64,
) -> Option<(&'a Row, &'a Run)> {
    cheapest_of(rows.flat_map(|row| row.runs.iter().map(move |run| (row, run))), level)
}

/// As [`cheapest`], but among given runs.
pub(super) fn cheapest_of<'a>(
    runs: impl Iterator<Item = (&'a Row, &'a Run)>,
    level: f64,
) -> Option<(&'a Row, &'a Run)> {
    let good = runs.filter(|(_, run)| run.is_good(level));
    good.min_by(|(_, a), (_, b)| {
        let by_error = || a.error.unwrap_or(f64::NAN).total_cmp(&b.error.unwrap_or(f64::NAN));
        a.modelled_s.total_cmp(&b.modelled_s).then_with(by_error)
    })
}
