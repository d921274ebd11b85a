//! The journal of a comparison, from which an interrupted one goes on.
//!
//! Every result that took time is a cell: the true motion, the cost of a step of each form, and
//! each run with the cloth at its end. A run that stopped because the time was over has no cell. A
//! comparison that finds such cells repeats the decisions at once, and goes on where it was
//! interrupted. Each cell carries the time at which it was done, so that all processes together
//! share one budget.
//!
//! A search without a true motion counts for its budget only: with another budget the search starts
//! again. A run that was compared with its own form has another cell than a run that was compared
//! with the true motion.

use super::facts::{End, Run, Truth};
use super::truth::Found;
use crate::HarnessError;
use crate::film::{Look, Seen};
use crate::journal::Journal;
use drape_model::Vec3;
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// The journal of a comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct Memory<'a> {
    journal: &'a Journal,
    /// When the comparison would have begun, had it run without an interruption.
    begin: Instant,
}

/// A finding, with the seconds that the comparison had taken by then.
#[derive(Serialize, Deserialize)]
struct Cell<T> {
    at_s: f64,
    found: T,
}

/// A look whose positions stand in one list.
#[derive(Serialize, Deserialize)]
struct Picture {
    x: Vec<f64>,
    kinetic: f64,
    strain: f64,
}

/// The result of a run in which the cloth is pushed at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Pushed {
    /// Whether it gains no energy in any direction.
    pub(super) holds: bool,
    /// Its distance from the true motion there, m, where that is known.
    pub(super) error_m: Option<f64>,
}

/// A motion.
#[derive(Serialize, Deserialize)]
struct Motion {
    looks: Vec<Picture>,
    path: f64,
}

/// A run of the race.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Ran {
    pub(super) run: Run,
    /// Seconds of its steps at the end of each frame.
    pub(super) clock: Vec<f64>,
    /// Why it was stopped.
    pub(super) end: Option<End>,
    /// The cloth at the last look, m.
    last: Option<Vec<f64>>,
}

impl Ran {
    pub(super) fn new(
        run: Run,
        clock: Vec<f64>,
        end: Option<End>,
        last: Option<&Vec<Vec3>>,
    ) -> Self {
        Self { run, clock, end, last: last.map(|x| flat(x)) }
    }

    /// The cloth at the last look, m.
    pub(super) fn last(&self) -> Option<Vec<Vec3>> {
        self.last.as_deref().map(points)
    }
}

fn flat(x: &[Vec3]) -> Vec<f64> {
    x.iter().flat_map(|x| [x.x, x.y, x.z]).collect()
}

fn points(flat: &[f64]) -> Vec<Vec3> {
    flat.chunks_exact(3).map(|x| Vec3::new(x[0], x[1], x[2])).collect()
}

const TRUTH: &str = "true motion";

/// The part of the journal for a search that found no true motion within this budget.
fn no_truth(budget: Duration) -> String {
    format!("no {TRUTH} within {} s", budget.as_secs_f64())
}

/// The part of the journal for the pushes of a form.
fn pushes(form: &str, is_held: bool) -> String {
    if is_held { format!("push of {form}") } else { format!("push of {form} alone") }
}

/// The part of the journal for the runs of a form.
fn runs(form: &str, is_trusted: bool) -> String {
    let held = if is_trusted { "" } else { ", held against themselves" };
    format!("runs of {form}{held}")
}

impl<'a> Memory<'a> {
    /// Reads the journal. The time of this process began at `began`, or begins now.
    pub(super) fn new(journal: &'a Journal, began: Option<Instant>) -> Self {
        let at = |cell: &serde_json::Value| cell.get("at_s").and_then(serde_json::Value::as_f64);
        let spent = journal.results().filter_map(at).fold(0.0, f64::max);
        let now = began.unwrap_or_else(Instant::now);
        let spent = Duration::try_from_secs_f64(spent).unwrap_or_default();
        Self { journal, begin: now.checked_sub(spent).unwrap_or(now) }
    }

    /// When the comparison began.
    pub(super) fn begin(&self) -> Instant {
        self.begin
    }

    fn keep<T: Serialize>(&self, part: &str, number: u32, found: T) -> Result<(), HarnessError> {
        let cell = Cell { at_s: self.begin.elapsed().as_secs_f64(), found };
        self.journal.keep(part, number as usize, &cell)
    }

    fn kept<T: for<'de> Deserialize<'de>>(&self, part: &str, number: u32) -> Option<T> {
        self.journal.kept::<Cell<T>>(part, number as usize).map(|cell| cell.found)
    }

    /// The true motion, or the record of a search that found none within this budget.
    pub(super) fn truth(&self, budget: Duration) -> Option<Found> {
        let kept = self.kept(TRUTH, 0).or_else(|| self.kept(&no_truth(budget), 0));
        let (truth, motions, pushed): (Truth, Vec<Motion>, Vec<Motion>) = kept?;
        let look =
            |look: Picture| Look { x: points(&look.x), kinetic: look.kinetic, strain: look.strain };
        let seen = |motion: Motion| Seen {
            looks: motion.looks.into_iter().map(look).collect(),
            path: motion.path,
        };
        let of = |motions: Vec<Motion>| motions.into_iter().map(seen).collect();
        Some(Found { truth, members: of(motions), pushed: of(pushed), seconds: 0.0 })
    }

    pub(super) fn keep_truth(&self, found: &Found, budget: Duration) -> Result<(), HarnessError> {
        let look =
            |look: &Look| Picture { x: flat(&look.x), kinetic: look.kinetic, strain: look.strain };
        let motion =
            |seen: &Seen| Motion { looks: seen.looks.iter().map(look).collect(), path: seen.path };
        let of = |films: &[Seen]| films.iter().map(motion).collect::<Vec<Motion>>();
        let part = if found.truth.is_trusted { TRUTH.to_owned() } else { no_truth(budget) };
        self.keep(&part, 0, (&found.truth, of(&found.members), of(&found.pushed)))
    }

    /// Seconds of a step of a form, or why it is refused.
    pub(super) fn probe(&self, form: &str) -> Option<Result<f64, String>> {
        self.kept(&format!("probe of {form}"), 0)
    }

    pub(super) fn keep_probe(
        &self,
        form: &str,
        step_s: &Result<f64, String>,
    ) -> Result<(), HarnessError> {
        self.keep(&format!("probe of {form}"), 0, step_s)
    }

    /// A run that was compared with the true motion if `truth` is trusted, else with its own form.
    pub(super) fn run(&self, form: &str, substeps: u32, truth: &Truth) -> Option<Ran> {
        self.kept(&runs(form, truth.is_trusted), substeps)
    }

    pub(super) fn keep_run(
        &self,
        form: &str,
        ran: &Ran,
        truth: &Truth,
    ) -> Result<(), HarnessError> {
        self.keep(&runs(form, truth.is_trusted), ran.run.substeps, ran)
    }

    /// The result of a run in which the cloth is pushed at the start. `is_held` says whether there
    /// is a true motion of the pushed cloth.
    pub(super) fn push(&self, form: &str, substeps: u32, is_held: bool) -> Option<Pushed> {
        self.kept(&pushes(form, is_held), substeps)
    }

    pub(super) fn keep_push(
        &self,
        form: &str,
        substeps: u32,
        pushed: &Pushed,
        is_held: bool,
    ) -> Result<(), HarnessError> {
        self.keep(&pushes(form, is_held), substeps, pushed)
    }

    /// Seconds of a run that was timed again.
    pub(super) fn time(&self, form: &str, substeps: u32, repetition: u32) -> Option<Option<f64>> {
        self.kept(&format!("time {repetition} of {form}"), substeps)
    }

    pub(super) fn keep_time(
        &self,
        form: &str,
        substeps: u32,
        repetition: u32,
        time: Option<f64>,
    ) -> Result<(), HarnessError> {
        self.keep(&format!("time {repetition} of {form}"), substeps, time)
    }
}
