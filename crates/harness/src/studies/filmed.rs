//! The common part of studies whose runs are filmed: the loop over forms and timings, and the
//! counters of a run.

use super::{Context, Recorded, cells, timed};
use crate::HarnessError;
use crate::methods::runs::Film;
use crate::run::Outcome;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Counts of work over all steps of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Counters {
    /// Number of sweeps over all springs that evaluated forces or energies.
    pub force_evaluations: u64,
    /// Number of products of a matrix with a block vector, triangular solves included.
    pub matvecs: u64,
    /// Number of factorisations of Newton's matrix.
    pub factorisations: u64,
    /// Number of Newton iterations.
    pub newton_iterations: u64,
    /// Number of CG iterations.
    pub cg_iterations: u64,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
}

impl Counters {
    pub(super) fn of(outcome: &Outcome) -> Self {
        let totals = &outcome.totals;
        Self {
            force_evaluations: totals.force_evaluations,
            matvecs: totals.matvecs,
            factorisations: totals.factorisations,
            newton_iterations: totals.newton_iterations,
            cg_iterations: totals.cg_iterations,
            unconverged_steps: outcome.unconverged,
        }
    }
}

/// A scene that is ready to be filmed.
pub(super) trait Stage: Sync {
    /// The result of one form with one number of steps.
    type Run: Serialize + DeserializeOwned + Send + Sync;
    /// The times of a run.
    type Row: Serialize + DeserializeOwned;

    /// SHA-256 of the scene.
    fn hash(&self) -> &str;
    /// The forms to run.
    fn films(&self) -> Vec<Film>;
    /// All runs of a form.
    fn runs(&self, film: &Film) -> Result<Vec<Self::Run>, HarnessError>;
    /// Key of the scene of a run.
    fn scene(run: &Self::Run) -> &str;
    /// Whether a run is timed.
    fn is_timed(run: &Self::Run) -> bool;
    /// Times a run.
    fn time(&self, run: &Self::Run) -> Result<Self::Row, HarnessError>;
    /// The seconds of a timing.
    fn seconds(row: &Self::Row) -> f64;
}

/// Runs every form on every scene: a list of runs for each scene.
pub(super) fn shoot<S: Stage>(
    context: &Context<'_>,
    stages: &[S],
) -> Result<Vec<Vec<S::Run>>, HarnessError> {
    let of = |(n, stage): (usize, &S)| stage.films().into_iter().map(move |film| (n, film));
    let films: Vec<_> = stages.iter().enumerate().flat_map(of).collect();
    let all = cells(context, "methods", &films, |(n, film)| stages[*n].runs(film))?.all()?;
    let mut runs: Vec<Vec<S::Run>> = stages.iter().map(|_| Vec::new()).collect();
    for ((n, _), own) in films.iter().zip(all) {
        runs[*n].extend(own);
    }
    Ok(runs)
}

/// Times the runs that [`Stage::is_timed`] selects. `runs` has a list for each scene. Returns
/// `None` in the quick subset, which times nothing.
pub(super) fn clock<S: Stage>(
    context: &Context<'_>,
    stages: &[S],
    runs: &[Vec<S::Run>],
) -> Result<Option<Vec<S::Row>>, HarnessError> {
    if context.quick {
        return Ok(None);
    }
    let mut all = Vec::new();
    for (stage, own) in stages.iter().zip(runs) {
        all.extend(own.iter().filter(|run| S::is_timed(run)).map(|run| (stage, run)));
    }
    Ok(Some(timed(context, "timings", &all, |(stage, run)| stage.time(run))?.all()?))
}

/// A timed run of more seconds is not repeated.
pub(super) const LONG_S: f64 = 0.05;

/// Times the runs of a record on its scenes. `stage` makes a scene by its key, and returns `None`
/// for an unknown one.
pub(super) fn clock_again<S: Stage>(
    context: &Context<'_>,
    recorded: &Recorded<'_>,
    runs: &[S::Run],
    stage: impl Fn(&str) -> Result<Option<S>, HarnessError>,
) -> Result<Vec<S::Row>, HarnessError> {
    let mut stages = BTreeMap::new();
    for run in runs {
        if let Entry::Vacant(place) = stages.entry(S::scene(run)) {
            place.insert(recorded.same(S::scene(run), stage(S::scene(run))?, S::hash)?);
        }
    }
    let all: Vec<_> = runs.iter().filter(|run| S::is_timed(run)).collect();
    let time = |run: &&S::Run| stages[S::scene(run)].time(run);
    recorded.timed(context, &runs, &all, (time, S::seconds))
}
