//! What an interrupted comparison has found, in a journal.
//!
//! Everything that took time is a cell: the true motion, what a step of each form costs, and each
//! run with the cloth at its end. A run that was stopped because the time was over is none. A
//! comparison that finds such cells makes the same decisions again, at once, and goes on where it
//! was interrupted. Cells carry the time at which they were done, so the budget is that of all
//! processes together.
//!
//! That no true motion was found holds for one budget only: with another one it is looked for again.
//! A run that was held against itself is no run that is held against a true motion: it is a cell of
//! its own.

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
    /// When the comparison began, if no process had interrupted it.
    begin: Instant,
}

/// A finding with the seconds that had passed then.
#[derive(Serialize, Deserialize)]
struct Cell<T> {
    at_s: f64,
    found: T,
}

/// A look with its positions in one list.
#[derive(Serialize, Deserialize)]
struct Picture {
    x: Vec<f64>,
    kinetic: f64,
    strain: f64,
}

/// What came of a run where the cloth is pushed at the start.
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

/// The cell of what was not found in so much time.
fn no_truth(budget: Duration) -> String {
    format!("no {TRUTH} within {} s", budget.as_secs_f64())
}

/// Where the pushes of a form are kept.
fn pushes(form: &str, is_held: bool) -> String {
    if is_held { format!("push of {form}") } else { format!("push of {form} alone") }
}

/// The cells of the runs of a form.
fn runs(form: &str, is_trusted: bool) -> String {
    let held = if is_trusted { "" } else { ", held against themselves" };
    format!("runs of {form}{held}")
}

impl<'a> Memory<'a> {
    /// What the journal holds. The time of this process began at `began`, or begins now.
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

    /// The true motion, or what is known where none was found in this time.
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

    /// A run that was held against what `truth` holds runs against.
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

    /// What came of a run where the cloth is pushed at the start, with or without a true motion there.
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
