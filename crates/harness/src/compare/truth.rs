//! The true motion that runs are held against.
//!
//! A method of the registry runs with more and more steps a frame. It stops once doubling the steps
//! changes the motion by less than a tenth of the target, or by no more than noise does. Starts
//! that are perturbed by a millionth of the cloth's size measure the noise. A run is compared with
//! the nearest of these motions. The same motions of the pushed cloth show whether a run is right
//! there, too.

use super::Clock;
use super::deadline::Deadline;
use super::facts::Truth;
use super::pace::Pace;
use super::stage::{Stage, Start};
use crate::HarnessError;
use crate::film::{Seen, noise};
use crate::methods::Choice;
use crate::run::Counts;
use crate::studies::variant::is_explicit;
use drape_report::Verdict;
use rayon::prelude::*;
use std::time::Instant;

/// Methods of the true motion, in the order in which they are tried.
const CANDIDATES: [&str; 4] = [
    "leapfrog:damping=explicit",
    "dirk:solver=cholesky",
    "bdf2:solver=cholesky",
    "backward-euler:solver=cholesky",
];
/// Steps a frame of the coarsest implicit run.
const IMPLICIT: u32 = 8;
/// Steps a frame of the coarsest explicit run, over those within the limit at the start.
const WITHIN: f64 = 1.1;
/// An error of the true motion up to this share of the target is small.
const SMALL: f64 = 0.1;
/// A true motion whose error exceeds this share of the target is not trusted.
const TRUSTED: f64 = 0.5;
/// Two motions whose distance is at most this many times the noise count as equal up to noise.
const NOISY: f64 = 2.0;
/// Share of the remaining time that one method may take.
const FIRST: f64 = 0.6;
/// Number of perturbed starts.
const PERTURBED: usize = 3;
/// How often the first step is halved when a run gains energy.
const RETRIES: usize = 3;
/// Share of the size of the cloth below which a mean path is round-off.
const STILL: f64 = 1e-9;
/// Time of a filmed run over the time of its steps, at most: the energy is measured after each
/// step.
const OVERHEAD: f64 = 2.5;

/// The true motions, and what is recorded of them.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) truth: Truth,
    /// True motions, the first from the unperturbed start. Empty where none was found.
    pub(super) members: Vec<Seen>,
    /// True motions of the pushed cloth, in the same order. Empty where none was found.
    pub(super) pushed: Vec<Seen>,
    /// Time of the first motion and of a comparison with it, s; 0 where a journal gave the motion.
    pub(super) seconds: f64,
}

impl Found {
    /// The result of a search that found no true motion, with the reason.
    pub(super) fn none(remark: Option<String>) -> Self {
        Self { truth: none(remark), members: Vec::new(), pushed: Vec::new(), seconds: 0.0 }
    }
}

/// The finest motion of one candidate.
struct Candidate {
    choice: Choice,
    substeps: u32,
    counts: Counts,
    seen: Seen,
    /// Distance from the motion with half the steps, m.
    error: f64,
    /// Distance of one perturbed motion, where one was made, m.
    noise: f64,
    /// Seconds of the run, and of a comparison of two films.
    seconds: f64,
    apart_s: f64,
}

/// Whether a run reached its end, and its energy gives no reason to doubt it.
fn is_usable(counts: &Counts) -> bool {
    let released = counts.energy.released;
    let is_whole = !counts.outcome.is_over_budget && counts.outcome.divergence.is_none();
    // Contacts may add energy. An explosion gains more than the scene sets free.
    is_whole && (counts.energy.is_open || counts.energy.gain <= released)
}

/// Builds the true motion before `deadline`.
pub(super) fn find(stage: &Stage, deadline: Deadline) -> Result<Found, HarnessError> {
    let mut best: Option<Candidate> = None;
    let mut remark = None;
    for id in CANDIDATES {
        let choice = Choice::parse(id, &[])?;
        // Leave time for the next candidate, in case this one does not finish.
        match candidate(stage, &choice, 1, deadline.after(FIRST))? {
            Ok(found) if best.as_ref().is_none_or(|best| found.error < best.error) => {
                best = Some(found);
            }
            Ok(_) => {}
            // Keep the first reason: that method usually finds the motion.
            Err(reason) => {
                remark.get_or_insert(format!("{}: {reason}", choice.method().id));
            }
        }
        let target = stage.scene.target_m;
        if best.as_ref().is_some_and(|best| best.error <= TRUSTED * target.max(NOISY * best.noise))
        {
            break;
        }
        if deadline.is_over() {
            break;
        }
    }
    // The shares of the time did not suffice, or the first steps gained energy. Try once more with
    // half of the first step and all of the remaining time.
    if best.is_none() && !deadline.is_over() {
        let choice = Choice::parse(CANDIDATES[0], &[])?;
        best = candidate(stage, &choice, 2, deadline)?.ok();
    }
    let Some(best) = best else {
        let remark = remark.or_else(|| Some("no method could make it".to_owned()));
        return Ok(Found::none(remark));
    };
    let threads = rayon::current_num_threads().max(1);
    // Of four motions there are six distances, two for each film that follows.
    let seconds = best.seconds / threads as f64 + 2.0 * best.apart_s;
    let starts = (1..=PERTURBED).map(|member| Start { member, push: None });
    let mut members = vec![best.seen];
    members.extend(films(stage, (&best.choice, best.substeps), starts, (seconds, deadline))?);
    let floor_m = noise(&members, |a, b| stage.apart(a, b));
    let path = members[0].path;
    let energy = best.counts.energy;
    let released = energy.released.max(50.0 * stage.round_off());
    let mut truth = Truth {
        method: Some(best.choice.full_id()),
        substeps: best.substeps,
        error_m: Some(best.error),
        members: members.len(),
        floor_m,
        pushed_floor_m: None,
        path_m: Some(path),
        moves: path > STILL * stage.scene.size_m,
        released_j: (!energy.is_open).then_some(released),
        gain_j: if energy.is_open { 0.0 } else { energy.gain.max(0.0) },
        is_trusted: true,
        remark: None,
    };
    let good = truth.good_m(stage.scene.target_m);
    truth.is_trusted = best.error <= TRUSTED * good;
    if !truth.is_trusted {
        truth.remark = Some("the time did not suffice for a smaller error".to_owned());
    } else if floor_m.is_none() {
        truth.remark = Some("the time did not suffice for perturbed starts".to_owned());
    }
    Ok(Found { truth, members, pushed: Vec::new(), seconds })
}

/// Makes the true motions of the pushed cloth before `deadline`, with the method and the steps of
/// the true motion. There are as many as true motions, or none where the time does not suffice.
pub(super) fn push(
    stage: &Stage,
    found: &mut Found,
    deadline: Deadline,
) -> Result<(), HarnessError> {
    let Some(method) = found.truth.method.as_deref().filter(|_| found.truth.is_trusted) else {
        return Ok(());
    };
    let needed = found.seconds * found.members.len() as f64;
    if needed > deadline.left().as_secs_f64() {
        return Ok(());
    }
    let run = (&Choice::parse(method, &[])?, found.truth.substeps);
    let starts = (0..found.members.len()).map(|member| Start { member, push: Some(0) });
    let pushed = films(stage, run, starts, (found.seconds, deadline))?;
    // One motion alone does not measure the noise.
    if pushed.len() == found.members.len() {
        found.truth.pushed_floor_m = noise(&pushed, |a, b| stage.apart(a, b));
        found.pushed = pushed;
    }
    Ok(())
}

/// Motions from several starts. Leaves out motions that gain energy, and those for which the time
/// before `deadline` does not suffice. Each takes about `each` seconds.
fn films(
    stage: &Stage,
    (choice, substeps): (&Choice, u32),
    starts: impl Iterator<Item = Start>,
    (each, deadline): (f64, Deadline),
) -> Result<Vec<Seen>, HarnessError> {
    let count = (deadline.left().as_secs_f64() / each.max(1e-9)).floor();
    let starts: Vec<Start> = starts.take(count as usize).collect();
    let runs: Vec<_> = starts
        .into_par_iter()
        .map(|start| stage.film(choice, substeps, start, |_| deadline.is_over()))
        .collect();
    let mut seen = Vec::new();
    for run in runs {
        let (counts, film) = match run {
            Err(HarnessError::Step(_)) => continue,
            other => other?,
        };
        seen.extend(is_usable(&counts).then_some(film));
    }
    Ok(seen)
}

/// The record of a search that found no true motion, with the reason.
pub(super) fn none(remark: Option<String>) -> Truth {
    Truth {
        method: None,
        substeps: 0,
        error_m: None,
        members: 0,
        floor_m: None,
        pushed_floor_m: None,
        path_m: None,
        moves: true,
        released_j: None,
        gain_j: 0.0,
        is_trusted: false,
        remark,
    }
}

/// The finest motion of a method that the time allows, or the reason why there is none. The method
/// begins with `times` as many steps a frame as usual.
fn candidate(
    stage: &Stage,
    choice: &Choice,
    times: u32,
    deadline: Deadline,
) -> Result<Result<Candidate, String>, HarnessError> {
    let mut substeps = times
        * match is_explicit(choice.method()) {
            // The limit at the start. Where the motion lowers it, the run gains energy, and its step is
            // halved.
            true => (WITHIN * f64::from(stage.scene.limit_substeps)).ceil() as u32,
            false => IMPLICIT,
        };
    let pace = Pace::of(Clock::Wall, choice);
    let step_s = match stage.probe(choice, substeps, &pace, deadline) {
        Ok(step_s) => step_s,
        Err(error @ (HarnessError::Prepare(_) | HarnessError::Step(_))) => {
            return Ok(Err(error.to_string()));
        }
        Err(error) => return Err(error),
    };
    let seconds =
        |substeps: u32| OVERHEAD * step_s * f64::from(substeps) * f64::from(stage.scene.frames);
    let left = || deadline.left().as_secs_f64();
    if seconds(3 * substeps) > left() {
        return Ok(Err("the time does not suffice".to_owned()));
    }
    let film = |substeps: u32, member: usize| {
        let begin = Instant::now();
        let from = Start { member, push: None };
        let (counts, seen) = stage.film(choice, substeps, from, |_| deadline.is_over())?;
        Ok::<_, HarnessError>((counts, seen, begin.elapsed().as_secs_f64()))
    };
    let (mut retries, mut coarse) = (0, None);
    let mut best: Option<Candidate> = None;
    let target = stage.scene.target_m;
    loop {
        let pair = match coarse.take() {
            None => rayon::join(|| film(substeps, 0), || film(2 * substeps, 0)),
            Some(coarse) => (Ok(coarse), film(2 * substeps, 0)),
        };
        let (before, after) = match pair {
            (Ok(before), Ok(after)) => (before, after),
            // A step that cannot be taken ends the candidate, not the comparison.
            (Err(HarnessError::Step(error)), _) | (_, Err(HarnessError::Step(error))) => {
                return Ok(best.ok_or_else(|| error.to_string()));
            }
            (Err(error), _) | (_, Err(error)) => return Err(error),
        };
        if !is_usable(&before.0) || !is_usable(&after.0) {
            retries += 1;
            substeps *= 2;
            // The time of a usable finer run is measured, and only the next run is left to make.
            let needed = if is_usable(&after.0) { 2.0 * after.2 } else { seconds(3 * substeps) };
            if best.is_none() && retries <= RETRIES && needed <= left() {
                coarse = is_usable(&after.0).then_some(after);
                continue;
            }
            let is_late = after.0.outcome.is_over_budget || needed > left();
            let reason = match is_late {
                true => "the time does not suffice for steps that gain no energy",
                false => "it gains energy, also with the shortest steps tried",
            };
            return Ok(best.ok_or_else(|| reason.to_owned()));
        }
        let begin = Instant::now();
        let error = stage.apart(&before.1, &after.1);
        let apart_s = begin.elapsed().as_secs_f64();
        let (counts, seen, seconds) = after;
        let mut found = Candidate {
            choice: choice.clone(),
            substeps: 2 * substeps,
            counts: counts.clone(),
            seen: seen.clone(),
            error,
            noise: 0.0,
            seconds,
            apart_s,
        };
        if error > SMALL * target && seconds + apart_s <= left() {
            // Is it the step, or noise?
            let (counts, other, _) = film(2 * substeps, 1)?;
            if is_usable(&counts) {
                found.noise = stage.apart(&found.seen, &other);
            }
        }
        let is_done = error <= SMALL * target || error <= NOISY * found.noise;
        best = Some(found);
        // The next run takes twice as long, and so do the perturbed runs after it.
        if is_done || 4.0 * (seconds + apart_s) > left() {
            return Ok(best.ok_or_else(String::new));
        }
        substeps *= 2;
        coarse = Some((counts, seen, seconds));
    }
}

/// The verdict on a run that was not stopped, held against the true motion.
pub(super) fn verdict(truth: &Truth, counts: &Counts, retained: Option<f64>) -> Verdict {
    let mut counts = counts.clone();
    counts.energy.gain -= truth.gain_j;
    let verdict = match truth.released_j {
        Some(released) => counts.verdict(released),
        None if counts.outcome.divergence.is_some() => Verdict::Diverged,
        None if counts.energy.is_open => Verdict::Open,
        // Without a true motion, the energy that the run itself sets free is the measure.
        None => counts.verdict(counts.energy.released),
    };
    let is_sound = matches!(verdict, Verdict::Stable | Verdict::Open);
    let stands_still = truth.moves && retained.is_some_and(|share| share < crate::film::HALF);
    if is_sound && stands_still { Verdict::Locked } else { verdict }
}
