//! `drape compare`: which method to take for the user's own scene.
//!
//! 1. The *true motion* is built in at most three tenths of the time. The true motion of the pushed
//!    cloth is built before four tenths have passed (`truth`).
//! 2. Each form of each method runs with rising numbers of steps a frame (`race`). The run that is
//!    predicted to be the cheapest goes first. A form stops once it takes more than three times as
//!    long as another form that meets the target. A form that the user names runs at least once.
//!    Before a run leads, it must meet the target from pushed starts, too. In three directions it
//!    may gain no energy; a step at the edge of stability does. In one direction it is compared
//!    with the true motion of the pushed cloth.
//! 3. The best runs are timed again, and [`advise`] reads the advice from the record.
//!
//! The budget is wall time. It counts from [`Options::began`], such as the start of the program,
//! and keeps [`Options::reserve`] for the work after the comparison, such as the page. Which runs
//! fit into the budget depends on the machine. The result of a run does not, its times aside. An
//! interrupted comparison goes on from its journal (`memory`).
//!
//! ```
//! use drape_harness::compare::{Options, advise, compare};
//! use std::time::Duration;
//!
//! let input = drape_model::parse("drop", r#"{ "format": "drape-system/1",
//!     "particles": { "mass_kg": [1, 1], "position_m": [[0, 0, 0], [1, 0, 0]] },
//!     "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 0.9,
//!         "stiffness_n_per_m": 100 }], "pins": [{ "particle": 0 }] }"#)?;
//! let methods = Some("leapfrog,midpoint".to_owned());
//! let options = Options { methods, budget: Duration::from_secs(20), ..Options::default() };
//! let comparison = compare("drop", input.spec(), 0.5, &options, &|_| ())?;
//! let advice = advise(&comparison.facts);
//! assert!(advice.take.is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod advice;
mod balance;
mod deadline;
pub mod facts;
mod forms;
mod memory;
mod pace;
mod page;
mod race;
mod stage;
#[cfg(test)]
mod tests;
mod truth;

pub use advice::{Advice, Pick, advise, lines, quoted};
pub use page::{NAME, PageError, Request, page_time, record, write};
pub use race::DOMINATED;

use crate::film::Seen;
use crate::journal::Journal;
use crate::methods::Choice;
use crate::run::{Counts, Moment};
use crate::studies::finite;
use crate::{HarnessError, Shard, Verdict, sha256, system_hash};
use deadline::Deadline;
use drape_integrator::{PrepareError, StepError};
use drape_model::{SystemSpec, Vec3, Violation};
use drape_report::number::median;
use facts::{End, Facts, Form, Metric, Run};
use forms::Entry;
use memory::{Memory, Pushed, Ran};
use pace::Pace;
use race::{Entrant, Lap, Limits, Track, race};
use stage::{PUSHES, Stage, Start};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use truth::{Found, find, verdict};

/// Shares of the time without the reserve by which the true motion, the true motion of the pushed
/// cloth, the race and the timing of the best runs must end. The rest is for a last step that runs
/// over its share.
const TRUTH_SHARE: f64 = 0.3;
const PUSHED_SHARE: f64 = 0.4;
const RACE_SHARE: f64 = 0.85;
const TIMING_SHARE: f64 = 0.95;
/// Share of the time until the end of the race that may go to probes. Forms without a probe by then
/// are not run, so that the others have their runs.
const PROBES_SHARE: f64 = 0.5;
/// Share of a film after which a run may be stopped as dominated.
const EARLY: f64 = 0.1;
/// Most forms that are timed again, and the number of turns in which they are.
const FINALISTS: usize = 6;
const REPETITIONS: u32 = 5;
/// A frame counts at most this many times the median frame.
const SPIKE: f64 = 5.0;
/// Forms up to this many times as slow as the best, by one timing, are timed again. After the first
/// turn only [ties](facts::TIE) are.
const NEAR: f64 = 2.0;
/// Greatest share of the budget that may be kept in reserve.
const MOST_RESERVED: f64 = 0.5;
/// Share of the budget that a program may take for one answer.
const MOST_ANSWER: f64 = 0.1;

/// The time by which runs are ranked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clock {
    /// The time that their steps take on this machine.
    #[default]
    Wall,
    /// Their counted work at recorded [prices](crate::cost), which is the same on every machine.
    /// Forms are not timed again, and a registered form without prices of its own takes no part.
    Modelled,
}

/// The question of a comparison and the limits within which it answers.
#[derive(Clone, Debug)]
pub struct Options {
    /// Methods separated by commas, as `--methods` takes them; `None`: all.
    pub methods: Option<String>,
    /// How errors are measured.
    pub metric: Metric,
    /// Greatest error, m; `None`: a hundredth of the longest side of the cloth.
    pub target_m: Option<f64>,
    /// Frames a second.
    pub rate: f64,
    /// Wall time of the whole comparison.
    pub budget: Duration,
    /// When that time began; `None`: at the call.
    pub began: Option<Instant>,
    /// How much of it is kept for what follows the comparison; at most half.
    pub reserve: Duration,
    /// Seed of the perturbed starts and of the directions of pushes.
    pub seed: u64,
    /// Whether every form runs until it meets the target, however slow it is beside the others.
    pub exhaustive: bool,
    /// A form that takes this many times as long a frame as the best stops, unless `exhaustive`.
    pub dominated: f64,
    /// The time by which runs are ranked.
    pub clock: Clock,
    /// The shard whose forms are run; `None`: all forms.
    pub shard: Option<Shard>,
    /// Once this flag is set, the comparison ends with the results that it has.
    pub interrupt: Option<&'static AtomicBool>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            methods: None,
            metric: Metric::Shape,
            target_m: None,
            rate: 60.0,
            budget: Duration::from_secs(60),
            began: None,
            reserve: Duration::ZERO,
            seed: 20,
            exhaustive: false,
            dominated: DOMINATED,
            clock: Clock::Wall,
            shard: None,
            interrupt: None,
        }
    }
}

/// The progress of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Tick<'a> {
    /// The part that is under way: `true motion`, `probes`, `race`, `pushes` or `timings`.
    pub part: &'static str,
    /// Time since the start.
    pub elapsed: Duration,
    /// Label of the form that leads.
    pub leads: Option<&'a str>,
}

/// What a comparison found, with the cloth at the end of some runs.
#[derive(Debug)]
pub struct Comparison {
    /// The record.
    pub facts: Facts,
    /// SHA-256 of the system.
    pub hash: String,
    /// Positions at the last look, m: of the true motion, where there is one.
    pub true_end: Option<Vec<Vec3>>,
    /// The same for each form: of its last run that met the target, or else of its last run.
    pub ends: Vec<Option<Vec<Vec3>>>,
}

/// The name of the journal of a comparison. It stands for the system and the question, apart from
/// the budget and the methods.
pub fn journal_name(spec: &SystemSpec, duration_s: f64, options: &Options) -> String {
    let Options { metric, target_m, rate, seed, exhaustive, clock, .. } = options;
    let hash = system_hash(spec);
    let asked =
        format!("{hash} {duration_s} {metric:?} {target_m:?} {rate} {seed} {exhaustive} {clock:?}");
    let sum = sha256(asked.as_bytes());
    format!("compare-{}", &sum[..12])
}

/// Compares methods on a scene of `duration_s` seconds; `name` is what messages call it.
///
/// # Errors
/// [`HarnessError`] when the scene, a method or an option is refused. What a method cannot do with
/// the scene is a result.
pub fn compare(
    name: &str,
    spec: &SystemSpec,
    duration_s: f64,
    options: &Options,
    progress: &dyn Fn(&Tick<'_>),
) -> Result<Comparison, HarnessError> {
    resume(name, spec, duration_s, options, &Journal::none(), progress)
}

/// As [`compare`], but goes on from the journal of an interrupted comparison. All processes
/// together share one budget.
///
/// # Errors
/// As [`compare`], and [`HarnessError::Record`] when the journal cannot be written.
pub fn resume(
    name: &str,
    spec: &SystemSpec,
    duration_s: f64,
    options: &Options,
    journal: &Journal,
    progress: &dyn Fn(&Tick<'_>),
) -> Result<Comparison, HarnessError> {
    let memory = Memory::new(journal, options.began);
    let begin = memory.begin();
    check(options)?;
    // A program that hangs must not take the time of the others.
    let _limit = crate::methods::programs_answer_within(options.budget.mul_f64(MOST_ANSWER));
    let mut entries = forms::chosen(options.methods.as_deref())?;
    if options.clock == Clock::Modelled && options.methods.is_none() {
        let prices = crate::cost::prices();
        entries.retain(|entry| prices.own(&entry.choice.full_id()).is_some());
    }
    if let Some(shard) = options.shard {
        entries.retain(|entry| shard.has("compare", &entry.choice.full_id(), 0, false));
    }
    let stage = Stage::new(name, spec, duration_s, options)?;
    if stage.free() == 0 {
        return Err(Violation {
            path: "pins".to_owned(),
            value: "all particles".to_owned(),
            expected: "at least one particle that is free to move".to_owned(),
        }
        .into());
    }
    let span = options.budget - options.reserve.min(options.budget.mul_f64(MOST_RESERVED));
    let until = |share: f64| Deadline::new(begin + span.mul_f64(share), options.interrupt);
    let tick = |part: &'static str, leads: Option<&str>| {
        progress(&Tick { part, elapsed: begin.elapsed(), leads });
    };
    tick("true motion", None);
    let found = match memory.truth(options.budget) {
        Some(found) => found,
        None => {
            let mut found = find(&stage, until(TRUTH_SHARE))?;
            truth::push(&stage, &mut found, until(PUSHED_SHARE))?;
            if !is_interrupted(options) {
                memory.keep_truth(&found, options.budget)?;
            }
            found
        }
    };
    tick("probes", None);
    let mut course = Course::new((&stage, &entries), &found, memory, until(RACE_SHARE), &tick);
    (course.clock, course.exhaustive) = (options.clock, options.exhaustive);
    course.is_named = options.methods.is_some();
    let mut entrants = course.entrants()?;
    let factor = if options.exhaustive { f64::INFINITY } else { options.dominated };
    race(&mut entrants, &mut course, factor)?;
    course.deadline = until(TIMING_SHARE);
    course.push_the_best()?;
    if options.clock == Clock::Wall {
        course.time_again()?;
    }
    let Course { runs, ends, refusals, .. } = course;
    let forms =
        entries.iter().zip(entrants).zip(refusals).map(|((entry, entrant), refusal)| Form {
            label: entry.label.clone(),
            method: entry.choice.full_id(),
            end: entrant.end.unwrap_or(End::OutOfTime),
            refusal,
        });
    let forms = forms.collect();
    let Found { truth, members, .. } = found;
    let moves = truth.moves;
    let hash = stage.hash.clone();
    let true_end = members.first().and_then(|seen| Some(seen.looks.last()?.x.clone()));
    let seconds = begin.elapsed().as_secs_f64();
    let scene = stage.scene.clone();
    let mut facts = Facts { scene, truth, forms, runs, seconds };
    let advice = advise(&facts);
    // Only the advised run is asked for what theory says: it takes a thousand steps of a small system.
    if let Some(pick) = advice.take.or(advice.closest).filter(|_| moves) {
        let run = &mut facts.runs[pick.run];
        run.foreseen = stage.foreseen(&entries[run.form].choice, run.substeps);
    }
    Ok(Comparison { facts, hash, true_end, ends })
}

/// The result of one run that is to be compared with a true motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Checked {
    /// It was compared.
    Held {
        /// Its error, m; `None` where it was not sound.
        error_m: Option<f64>,
        /// Error that counts as met, m.
        good_m: f64,
    },
    /// The time did not suffice for a true motion or for the run. This is no verdict on the run.
    NotMeasured,
}

/// Runs one form with so many steps a frame, and compares it with a true motion. The true motion
/// may take three tenths of the budget.
///
/// # Errors
/// As [`compare`].
pub(crate) fn check_run(
    name: &str,
    spec: &SystemSpec,
    duration_s: f64,
    options: &Options,
    run: (&Choice, u32),
) -> Result<Checked, HarnessError> {
    check(options)?;
    let stage = Stage::new(name, spec, duration_s, options)?;
    let begin = Instant::now();
    let until = |share: f64| Deadline::new(begin + options.budget.mul_f64(share), None);
    let found = find(&stage, until(TRUTH_SHARE))?;
    held(&stage, &found, run, options.clock, until(1.0))
}

/// Runs one form before `deadline` and compares it with the true motions that were found.
fn held(
    stage: &Stage,
    found: &Found,
    (choice, substeps): (&Choice, u32),
    clock: Clock,
    deadline: Deadline,
) -> Result<Checked, HarnessError> {
    if !found.truth.is_trusted {
        return Ok(Checked::NotMeasured);
    }
    let entries = [Entry::of(choice)];
    let journal = Journal::none();
    let memory = Memory::new(&journal, None);
    let mut course = Course::new((stage, &entries), found, memory, deadline, &|_, _| ());
    (course.clock, course.is_pushing) = (clock, false);
    let lap = course.lap(0, substeps, Limits::NONE)?;
    if lap.end == Some(End::OutOfTime) {
        return Ok(Checked::NotMeasured);
    }
    let error_m = course.runs.first().filter(|run| run.is_sound()).and_then(|run| run.error_m);
    Ok(Checked::Held { error_m, good_m: found.truth.good_m(stage.scene.target_m) })
}

/// Wall time a frame of the steps alone, s, of a run with so many steps a frame. `None` where the
/// run does not reach the end.
///
/// # Errors
/// As [`compare`].
pub(crate) fn frame_seconds(
    name: &str,
    spec: &SystemSpec,
    duration_s: f64,
    options: &Options,
    (choice, substeps): (&Choice, u32),
) -> Result<Option<f64>, HarnessError> {
    let stage = Stage::new(name, spec, duration_s, options)?;
    let time = stage.time(choice, substeps, |_| false)?;
    Ok(time.map(|time| time / f64::from(stage.scene.frames)))
}

/// Whether the user has ended the comparison.
fn is_interrupted(options: &Options) -> bool {
    options.interrupt.is_some_and(|flag| flag.load(std::sync::atomic::Ordering::Relaxed))
}

/// Refuses options outside their ranges.
fn check(options: &Options) -> Result<(), Violation> {
    let refuse = |path: &str, value: String, expected: &str| {
        Err(Violation { path: path.to_owned(), value, expected: expected.to_owned() })
    };
    let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
    if let Some(target) = options.target_m
        && !within(target, 1e-12, 1e6)
    {
        return refuse("--target", format!("{target}"), "an error from 1e-12 to 1e6 m");
    }
    if !within(options.rate, 1e-3, 1e5) {
        let frame = format!("{} s", 1.0 / options.rate);
        return refuse("--frame", frame, "a length from 1e-5 to 1000 s");
    }
    if !within(options.budget.as_secs_f64(), 1.0, 1e6) {
        let value = format!("{} s", options.budget.as_secs_f64());
        return refuse("--budget", value, "a time from 1 s to 1e6 s");
    }
    Ok(())
}

/// The run that leads.
struct Best {
    form: usize,
    /// Time a frame, s.
    frame_s: f64,
    /// Time of all its steps up to the end of each frame, s.
    clock: Vec<f64>,
}

/// Makes the runs of a race.
struct Course<'a> {
    stage: &'a Stage,
    entries: &'a [Entry],
    truth: &'a facts::Truth,
    members: &'a [Seen],
    /// True motions of the pushed cloth.
    pushed: &'a [Seen],
    memory: Memory<'a>,
    clock: Clock,
    exhaustive: bool,
    /// Whether the user named the forms.
    is_named: bool,
    /// Whether runs that lead are pushed.
    is_pushing: bool,
    deadline: Deadline,
    /// The previous run of each form, where runs are compared with it.
    before: Vec<Option<Seen>>,
    /// Steps a frame of each form's last run, where that run was made before an interruption.
    replayed: Vec<Option<u32>>,
    ends: Vec<Option<Vec<Vec3>>>,
    refusals: Vec<Option<String>>,
    runs: Vec<Run>,
    best: Option<Best>,
    tick: &'a dyn Fn(&'static str, Option<&str>),
}

/// Time of a run, s, from the times at the end of each frame. A frame that takes more than five
/// times the median counts as five medians: another process had the processor.
fn steady(clock: &[f64]) -> f64 {
    let before = std::iter::once(&0.0).chain(clock);
    let frames: Vec<f64> = clock.iter().zip(before).map(|(end, begin)| end - begin).collect();
    let median = median(frames.iter().copied()).unwrap_or(0.0);
    frames.iter().map(|time| time.min(SPIKE * median)).sum()
}

/// What the method cannot do, or how its step failed; `Err` where the method is not at fault.
fn refusal(error: HarnessError) -> Result<String, HarnessError> {
    match error {
        HarnessError::Prepare(PrepareError::Unsupported { what, key, .. }) => {
            Ok(format!("{what} (`{key}`)"))
        }
        HarnessError::Prepare(_)
        | HarnessError::Step(StepError::TooManySubsteps { .. } | StepError::Solver(_)) => {
            Ok(error.to_string())
        }
        other => Err(other),
    }
}

/// Whether a run ended because a program of the user failed.
fn is_outside(counts: &Counts) -> bool {
    counts.outcome.divergence.as_ref().is_some_and(|end| end.is_outside)
}

impl<'a> Course<'a> {
    /// A course without runs, ranked by wall time.
    fn new(
        (stage, entries): (&'a Stage, &'a [Entry]),
        Found { truth, members, pushed, .. }: &'a Found,
        memory: Memory<'a>,
        deadline: Deadline,
        tick: &'a dyn Fn(&'static str, Option<&str>),
    ) -> Self {
        let count = entries.len();
        Self {
            stage,
            entries,
            truth,
            members,
            pushed,
            memory,
            clock: Clock::Wall,
            exhaustive: false,
            is_named: false,
            is_pushing: true,
            deadline,
            before: vec![None; count],
            replayed: vec![None; count],
            ends: vec![None; count],
            refusals: vec![None; count],
            runs: Vec::new(),
            best: None,
            tick,
        }
    }

    /// All forms with their ladders. A few steps of each show what a step costs, and whether the
    /// method refuses the scene.
    fn entrants(&mut self) -> Result<Vec<Entrant>, HarnessError> {
        let mut entrants = Vec::new();
        let deadline = self.deadline.after(PROBES_SHARE);
        for (form, entry) in self.entries.iter().enumerate() {
            let ladder = forms::ladder(entry.substeps, self.stage.scene.limit_substeps);
            let first = ladder.first().copied().unwrap_or(1);
            if deadline.is_over() && self.memory.probe(&entry.choice.full_id()).is_none() {
                let mut entrant = Entrant::new(ladder, f64::INFINITY);
                entrant.end = Some(End::OutOfTime);
                entrants.push(entrant);
                continue;
            }
            (self.tick)("probes", None);
            match self.probe(entry, first)? {
                Ok(step_s) => {
                    let mut entrant = Entrant::new(ladder, step_s);
                    entrant.is_owed = self.is_named;
                    entrants.push(entrant);
                }
                Err(refusal) => {
                    self.refusals[form] = Some(refusal);
                    let mut entrant = Entrant::new(ladder, f64::INFINITY);
                    entrant.end = Some(End::Refused);
                    entrants.push(entrant);
                }
            }
        }
        Ok(entrants)
    }

    /// Seconds of a step of a form, or why it is refused.
    fn probe(&self, entry: &Entry, substeps: u32) -> Result<Result<f64, String>, HarnessError> {
        let id = entry.choice.full_id();
        if let Some(known) = self.memory.probe(&id) {
            return Ok(known);
        }
        let pace = Pace::of(self.clock, &entry.choice);
        let step_s = match self.stage.probe(&entry.choice, substeps, &pace, self.deadline) {
            Ok(step_s) => Ok(step_s),
            Err(error) => Err(refusal(error)?),
        };
        self.memory.keep_probe(&id, &step_s)?;
        Ok(step_s)
    }

    /// Repeats the previous run of a form where it was made before an interruption, so its film is
    /// not at hand.
    fn recall(&mut self, form: usize) -> Result<(), HarnessError> {
        let is_needed = !self.truth.is_trusted && self.before[form].is_none();
        let Some(substeps) = self.replayed[form].take().filter(|_| is_needed) else {
            return Ok(());
        };
        let deadline = self.deadline;
        let stop = |_: &Moment<'_>| deadline.is_over();
        let (counts, seen) =
            self.stage.film(&self.entries[form].choice, substeps, Start::default(), stop)?;
        self.before[form] = (!counts.outcome.is_over_budget).then_some(seen);
        Ok(())
    }

    /// Takes over a run that was made before an interruption.
    fn replay(&mut self, form: usize, mut ran: Ran) -> Result<Lap, HarnessError> {
        ran.run.form = form;
        if ran.end.is_none() && !ran.run.explodes() {
            self.replayed[form] = Some(ran.run.substeps);
        }
        self.finish(ran)
    }

    /// Records a run. Before the run may lead, it is repeated from pushed starts. A run that fails
    /// there has not met the target.
    fn finish(&mut self, ran: Ran) -> Result<Lap, HarnessError> {
        let last = ran.last();
        let Ran { run, clock, end, .. } = ran;
        let (form, frame_s, n) = (run.form, run.frame_s, self.runs.len());
        if end.is_none() && !run.explodes() {
            self.ends[form] = last;
        }
        self.runs.push(run);
        let would_lead = self.best.as_ref().is_none_or(|best| frame_s < best.frame_s);
        if self.is_pushing && would_lead && self.is_met(&self.runs[n]) {
            self.push(n)?;
        }
        let is_good = self.is_met(&self.runs[n]);
        if is_good && would_lead {
            self.best = Some(Best { form, frame_s, clock });
        }
        Ok(Lap { frame_s, is_good, end, is_late: false })
    }

    /// Distance of a film from the true motion, or from the form's previous run, m.
    fn error(&mut self, form: usize, seen: &Seen) -> Option<f64> {
        if self.truth.is_trusted {
            return self.nearest(seen, self.members, self.truth.floor_m);
        }
        let before = self.before[form].replace(seen.clone());
        before.map(|before| self.stage.apart(seen, &before))
    }

    /// Distance of a film from the nearest of the true motions `members`, m. `floor_m` is their
    /// noise, m.
    fn nearest(&self, seen: &Seen, members: &[Seen], floor_m: Option<f64>) -> Option<f64> {
        let (first, others) = members.split_first()?;
        let mut error = self.stage.apart(seen, first);
        // Where the noise is small, all members are near the first.
        if floor_m.is_some_and(|floor| 10.0 * floor > self.stage.scene.target_m) {
            for other in others {
                error = error.min(self.stage.apart(seen, other));
            }
        }
        Some(error)
    }

    fn is_met(&self, run: &Run) -> bool {
        self.truth.is_met(self.stage.scene.target_m, run)
    }

    /// The runs that may be advised, the fastest first.
    fn finalists(&self) -> Vec<usize> {
        let mut finalists =
            advice::ranking(self.stage.scene.target_m, (&self.stage.scene, self.truth), &self.runs);
        let least = finalists.first().map_or(0.0, |&n| self.runs[n].frame_s);
        finalists.retain(|&n| self.runs[n].frame_s <= NEAR * least);
        finalists.truncate(FINALISTS);
        finalists
    }

    /// Repeats from pushed starts the best runs that did not lead in the race.
    fn push_the_best(&mut self) -> Result<(), HarnessError> {
        let is_new = |run: &Run| run.holds_when_pushed.is_none();
        while let Some(n) = self.finalists().into_iter().find(|&n| is_new(&self.runs[n])) {
            if !self.push(n)? {
                break;
            }
        }
        Ok(())
    }

    /// Repeats a run from pushed starts. Returns whether the time sufficed.
    fn push(&mut self, n: usize) -> Result<bool, HarnessError> {
        let pushed = self.pushed(n)?;
        self.runs[n].holds_when_pushed = pushed.map(|pushed| pushed.holds);
        self.runs[n].pushed_m = pushed.and_then(|pushed| pushed.error_m);
        Ok(pushed.is_some())
    }

    /// The result of a run from pushed starts; `None` where the time does not suffice.
    fn pushed(&self, n: usize) -> Result<Option<Pushed>, HarnessError> {
        let (run, is_held) = (&self.runs[n], !self.pushed.is_empty());
        let choice = &self.entries[run.form].choice;
        let known = self.memory.push(&choice.full_id(), run.substeps, is_held);
        if known.is_some() {
            return Ok(known);
        }
        (self.tick)("pushes", Some(&self.entries[run.form].label));
        let mut pushed = Pushed { holds: true, error_m: None };
        // The push sets free its own energy, too.
        let released_j = self.truth.released_j.map(|released| released + self.stage.push_energy());
        let truth = facts::Truth { released_j, ..self.truth.clone() };
        for direction in 0..PUSHES {
            let from = Start { member: 0, push: Some(direction) };
            let mut watch = self.stage.watch(choice, from);
            let look = |moment: &Moment<'_>| watch.iter_mut().for_each(|watch| watch.look(moment));
            let (counts, film) = match self.pushed_once(choice, run.substeps, direction, look) {
                Ok((counts, _)) if counts.outcome.is_over_budget => {
                    return Ok((direction > 0).then_some(pushed));
                }
                // A program of the user failed: that is no verdict on its method.
                Ok((counts, _)) if is_outside(&counts) => return Ok(None),
                Ok(found) => found,
                // A step that fails there is no better than one that explodes.
                Err(error) => {
                    refusal(error)?;
                    pushed.holds = false;
                    break;
                }
            };
            let beyond_work = watch.map(|watch| watch.verdict());
            let mut verdicts = [verdict(&truth, &counts, None)].into_iter().chain(beyond_work);
            pushed.holds = !verdicts.any(Verdict::gains_energy);
            if !pushed.holds {
                break;
            }
            if let Some(film) = film {
                let error = self.nearest(&film, self.pushed, self.truth.pushed_floor_m);
                pushed.error_m = error.filter(|error| error.is_finite());
            }
        }
        self.memory.keep_push(&choice.full_id(), run.substeps, &pushed, is_held)?;
        Ok(Some(pushed))
    }

    /// A run from a pushed start, with its film where there is a true motion.
    fn pushed_once(
        &self,
        choice: &Choice,
        substeps: u32,
        direction: usize,
        mut look: impl FnMut(&Moment<'_>),
    ) -> Result<(Counts, Option<Seen>), HarnessError> {
        let deadline = self.deadline;
        let stop = |moment: &Moment<'_>| {
            look(moment);
            deadline.is_over()
        };
        if direction > 0 || self.pushed.is_empty() {
            return Ok((self.stage.pushed(choice, substeps, direction, stop)?, None));
        }
        let from = Start { member: 0, push: Some(direction) };
        let (counts, seen) = self.stage.film(choice, substeps, from, stop)?;
        Ok((counts, Some(seen)))
    }

    /// Times the best runs again; the least time of each counts.
    fn time_again(&mut self) -> Result<(), HarnessError> {
        let mut finalists = self.finalists();
        let frames = f64::from(self.stage.scene.frames);
        for repetition in 0..REPETITIONS {
            if repetition > 0 {
                let times = || finalists.iter().map(|&n| self.runs[n].frame_s);
                let least = times().fold(f64::INFINITY, f64::min);
                finalists.retain(|&n| self.runs[n].frame_s <= facts::TIE * least);
            }
            for &n in &finalists {
                let (form, substeps) = (self.runs[n].form, self.runs[n].substeps);
                let choice = &self.entries[form].choice;
                let known = self.memory.time(&choice.full_id(), substeps, repetition);
                let needed = self.runs[n].frame_s * frames;
                if known.is_none() && needed > self.deadline.left().as_secs_f64() {
                    return Ok(());
                }
                (self.tick)("timings", Some(&self.entries[form].label));
                let deadline = self.deadline;
                let stop = |_: &Moment<'_>| deadline.is_over();
                let time = match known {
                    Some(time) => time,
                    None => self.stage.time(choice, substeps, stop)?,
                };
                if known.is_none() && !deadline.is_over() {
                    self.memory.keep_time(&choice.full_id(), substeps, repetition, time)?;
                }
                if let Some(time) = time {
                    self.runs[n].frame_s = self.runs[n].frame_s.min(time / frames);
                    self.runs[n].repetitions += 1;
                }
            }
        }
        Ok(())
    }
}

impl Track for Course<'_> {
    fn lap(&mut self, form: usize, substeps: u32, limits: Limits) -> Result<Lap, HarnessError> {
        let entries = self.entries;
        let choice: &Choice = &entries[form].choice;
        if let Some(ran) = self.memory.run(&choice.full_id(), substeps, self.truth) {
            return self.replay(form, ran);
        }
        self.recall(form)?;
        let best = self.best.take();
        let leader = best.as_ref().map(|best| entries[best.form].label.as_str());
        (self.tick)("race", leader);
        let pace = Pace::of(self.clock, choice);
        let frames = self.stage.scene.frames;
        let early = (EARLY * f64::from(frames)).ceil().max(1.0) as usize;
        let (mut clock, mut reason) = (Vec::with_capacity(frames as usize), None);
        let mut spent = 0.0;
        let mut check = self.stage.motion_check(choice, substeps);
        let mut watch = self.stage.watch(choice, Start::default());
        let deadline = self.deadline;
        let ratio = best.as_ref().map_or(f64::INFINITY, |best| limits.most / best.frame_s);
        let mut is_late = false;
        let stop = |moment: &Moment<'_>| {
            spent = pace.seconds(moment);
            check.look(moment);
            watch.iter_mut().for_each(|watch| watch.look(moment));
            if moment.step.is_multiple_of(u64::from(substeps)) {
                clock.push(spent);
                let place = clock.len();
                let lead = best.as_ref().and_then(|best| best.clock.get(..place));
                let is_due = place.is_multiple_of(early);
                if is_due {
                    let so_far = steady(&clock);
                    // A first step sets up, and one moment of another process is no sign.
                    is_late = place > 1 && so_far > limits.late * f64::from(frames);
                    if lead.is_some_and(|lead| so_far > ratio * steady(lead)) {
                        reason = Some(End::Dominated);
                    }
                }
            }
            if reason.is_none() && deadline.is_over() {
                reason = Some(End::OutOfTime);
            }
            is_late &= reason.is_none();
            reason.is_some() || is_late
        };
        let film = self.stage.film(choice, substeps, Start::default(), stop);
        self.best = best;
        let (counts, seen) = match film {
            Ok(film) => film,
            Err(error) => {
                self.refusals[form] = Some(refusal(error)?);
                return Ok(Lap::refused());
            }
        };
        let outcome = &counts.outcome;
        if is_late && outcome.is_over_budget {
            let frame_s = steady(&clock) / clock.len() as f64;
            return Ok(Lap { frame_s, is_good: false, end: None, is_late });
        }
        if let Some(failure) = outcome.divergence.as_ref().filter(|end| end.is_outside) {
            // A program of the user failed: that is no verdict on its method.
            self.refusals[form] = Some(failure.criterion.clone());
            return Ok(Lap::refused());
        }
        let step_s = spent / outcome.steps.max(1) as f64;
        let mut run = Run {
            form,
            substeps,
            verdict: Verdict::OverBudget,
            error_m: None,
            retained: None,
            gain: None,
            force_evaluations: outcome.totals.force_evaluations,
            matvecs: outcome.totals.matvecs,
            factorisations: outcome.totals.factorisations,
            cg_iterations: outcome.totals.cg_iterations,
            unconverged_steps: outcome.unconverged,
            frame_s: match clock.len() {
                0 => step_s * f64::from(substeps),
                frames => steady(&clock) / frames as f64,
            },
            repetitions: 1,
            holds_when_pushed: None,
            pushed_m: None,
            foreseen: None,
        };
        let end = if outcome.is_over_budget { reason } else { None };
        if end.is_none() {
            let truth = self.truth;
            let is_moving = truth.moves.then_some(truth.path_m).flatten();
            run.retained = is_moving.map(|path| seen.path / path);
            run.gain = truth.released_j.map(|released| {
                finite((counts.energy.gain - truth.gain_j).max(0.0) / released.max(1e-300))
            });
            run.verdict = verdict(truth, &counts, run.retained);
            if let Some(watch) = watch.filter(|_| run.is_sound()) {
                watch.judge(&mut run);
            }
            if run.is_sound() {
                let effort = counts.outcome.effort;
                let still = self.stage.stands_still(choice, substeps, (&check, effort), truth);
                run.retained = run.retained.or(still.share);
                if still.is_locked {
                    run.verdict = Verdict::Locked;
                }
            }
            if run.explodes() {
                run.retained = None;
            } else {
                run.error_m = self.error(form, &seen).filter(|error| error.is_finite());
            }
        }
        let last = seen.looks.last().filter(|_| end.is_none() && !run.explodes());
        let ran = Ran::new(run, clock, end, last.map(|look| &look.x));
        if end != Some(End::OutOfTime) {
            self.memory.keep_run(&choice.full_id(), &ran, self.truth)?;
        }
        self.finish(ran)
    }

    fn has_time(&self, form: usize, substeps: u32, frame_s: f64) -> bool {
        let id = self.entries[form].choice.full_id();
        if self.memory.run(&id, substeps, self.truth).is_some() {
            return true;
        }
        let left = self.deadline.left().as_secs_f64();
        let needed = frame_s * f64::from(self.stage.scene.frames);
        left > 0.0 && (needed <= left || (self.exhaustive && self.best.is_none()))
    }
}
