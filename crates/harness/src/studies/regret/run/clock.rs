//! The same question by the clock: every bundled scene, the scenes of this study, and scenes with
//! other forces.

use super::forces;
use super::scenes::{self, Question};
use super::{SEED, pick, pushed};
use crate::HarnessError;
use crate::compare::facts::{End, Facts as Record, TIE};
use crate::compare::{DOMINATED, Options, check_run, compare, frame_seconds};
use crate::methods::Choice;
use crate::studies::regret::facts::{Case, Origin, Pick, TimingRow};
use drape_model::{SystemSpec, bundled};
use std::time::{Duration, Instant};

/// Wall time of a comparison.
const BUDGET: Duration = Duration::from_secs(6);
/// Wall time of the search, and of the true motion on the pushed cloth, which takes at most three
/// tenths.
const SEARCH: Duration = Duration::from_secs(9);
/// A form ends in the search once it takes this many times as long as the best: twice as many as
/// in the comparison.
const WIDER: f64 = 2.0 * DOMINATED;
/// Longest simulated time of a bundled scene, s: 30 frames.
const LONGEST_S: f64 = 0.5;
/// Forms of the search that are timed in turns with the advice.
const RIVALS: usize = 4;
/// How often each is timed, and for how long all of them at most.
const TURNS: u32 = 7;
const TURNS_S: f64 = 3.0;

/// A scene to be asked about.
pub(super) struct Trial<'a> {
    name: String,
    origin: Origin,
    make: Box<dyn Fn() -> Result<SystemSpec, HarnessError> + 'a>,
    duration_s: f64,
    target_m: Option<f64>,
    /// What was found by modelled time.
    modelled: Option<&'a Pick>,
}

/// How the timings are taken.
pub(in crate::studies::regret) fn timing() -> String {
    format!(
        "`drape compare` with its default options and a budget of {} s: on the first {LONGEST_S} s \
         of every bundled scene, on the scenes above, and on scenes with contact, friction, wind, \
         hinges and angles on which nothing was tuned either. The target is a hundredth of the \
         cloth's longest side where no other is named. The search has {} s and stops a form only \
         once it takes {WIDER} times as long as the best. The advised run and the {RIVALS} fastest \
         forms of the search that meet the target, each with its fewest steps, are then timed in \
         turns, up to {TURNS} times each; the least time counts. Regret is the time of the advised \
         run over the least of them. The advised run is measured again on the pushed cloth, with \
         another true motion.",
        BUDGET.as_secs(),
        SEARCH.as_secs()
    )
}

/// All scenes: bundled ones, those of the facts, and those with other forces.
pub(super) fn trials<'a>(questions: &'a [Question], cases: &'a [Case]) -> Vec<Trial<'a>> {
    let mut trials: Vec<Trial<'a>> = bundled::names()
        .map(|name| Trial {
            name: name.to_owned(),
            origin: Origin::Bundled,
            make: Box::new(move || Ok(drape_model::load(name)?.spec().clone())),
            duration_s: duration(name),
            target_m: None,
            modelled: None,
        })
        .collect();
    trials.extend(questions.iter().zip(cases).map(|(question, case)| Trial {
        name: question.scene.name.to_owned(),
        origin: Origin::Springs,
        make: Box::new(|| question.scene.spec()),
        duration_s: scenes::DURATION_S,
        target_m: Some(question.target_m),
        modelled: case.best.as_ref(),
    }));
    trials.extend(forces::SCENES.iter().map(|(name, make)| Trial {
        name: (*name).to_owned(),
        origin: Origin::Forces,
        make: Box::new(make),
        duration_s: scenes::DURATION_S,
        target_m: None,
        modelled: None,
    }));
    trials
}

/// The part of a bundled scene that is run, s.
fn duration(name: &str) -> f64 {
    let input = drape_model::load(name).ok();
    let whole = input.as_ref().and_then(|input| input.scene()).map(|scene| scene.time.duration_s);
    whole.map_or(LONGEST_S, |whole| whole.min(LONGEST_S))
}

/// A run that is timed in turns, and its least time a frame, s.
struct Rival {
    pick: Pick,
    choice: Choice,
    least_s: f64,
}

impl Trial<'_> {
    fn options(&self, budget: Duration) -> Options {
        Options { target_m: self.target_m, budget, seed: SEED, ..Options::default() }
    }

    fn asked(&self, spec: &SystemSpec, options: &Options) -> Result<Record, HarnessError> {
        Ok(compare(&self.name, spec, self.duration_s, options, &|_| ())?.facts)
    }

    /// What the clock of this machine says.
    pub(super) fn time(&self) -> Result<TimingRow, HarnessError> {
        let spec = (self.make)()?;
        let found = self.asked(&spec, &self.options(BUDGET))?;
        let advice = pick(&found);
        let search = Options { dominated: WIDER, ..self.options(SEARCH) };
        let all = self.asked(&spec, &search)?;
        let is_judged = all.truth.is_trusted;
        let mut row = TimingRow {
            scene: self.name.clone(),
            origin: self.origin,
            particles: found.scene.particles,
            duration_s: self.duration_s,
            target_m: found.scene.target_m,
            budget_s: BUDGET.as_secs_f64(),
            seconds: found.seconds,
            is_trusted: found.truth.is_trusted,
            label: advice.as_ref().map(|pick| pick.label.clone()),
            substeps: advice.as_ref().map_or(0, |pick| pick.substeps),
            search_s: all.seconds,
            is_judged,
            left: all.forms.iter().filter(|form| form.end == End::OutOfTime).count(),
            best: None,
            best_substeps: 0,
            regret: None,
            again_m: None,
            again_good_m: None,
            over_model: None,
        };
        if is_judged {
            let times = self.in_turns(&spec, advice.as_ref(), &all)?;
            let best = times.iter().min_by(|a, b| a.least_s.total_cmp(&b.least_s));
            let of = |pick: &Pick| times.iter().find(|rival| is_same(&rival.pick, pick));
            row.best = best.map(|best| best.pick.label.clone());
            row.best_substeps = best.map_or(0, |best| best.pick.substeps);
            row.regret = best.zip(advice.as_ref().and_then(of)).map(|(b, a)| a.least_s / b.least_s);
            row.over_model = self.modelled.and_then(|m| Some(of(m)?.least_s / m.frame_s));
        }
        if let Some(advice) = &advice {
            let run = (&Choice::parse(&advice.method, &[])?, advice.substeps);
            let options = self.options(SEARCH);
            let again = check_run(&self.name, &pushed(&spec), self.duration_s, &options, run)?;
            row.again_m = again.error_m.filter(|_| again.is_trusted);
            row.again_good_m = again.is_trusted.then_some(again.good_m);
        }
        Ok(row)
    }

    /// The advised run and the best ones of the search, timed in turns.
    fn in_turns(
        &self,
        spec: &SystemSpec,
        advice: Option<&Pick>,
        all: &Record,
    ) -> Result<Vec<Rival>, HarnessError> {
        let mut picks: Vec<Pick> = Vec::new();
        let found = best_of(all);
        let near = found.first().map_or(0.0, |best| TIE * best.frame_s);
        let rivals = found.into_iter().filter(|pick| pick.frame_s <= near).take(RIVALS);
        for pick in advice.into_iter().cloned().chain(rivals).chain(self.modelled.cloned()) {
            if !picks.iter().any(|known| is_same(known, &pick)) {
                picks.push(pick);
            }
        }
        let mut rivals = Vec::new();
        for pick in picks {
            let choice = Choice::parse(&pick.method, &[])?;
            rivals.push(Rival { pick, choice, least_s: f64::INFINITY });
        }
        let options = self.options(SEARCH);
        let begin = Instant::now();
        for turn in 0..TURNS {
            if turn > 1 && begin.elapsed().as_secs_f64() > TURNS_S {
                break;
            }
            for rival in &mut rivals {
                let run = (&rival.choice, rival.pick.substeps);
                let time = frame_seconds(&self.name, spec, self.duration_s, &options, run)?;
                rival.least_s = rival.least_s.min(time.unwrap_or(f64::INFINITY));
            }
        }
        // The best form of another machine need not be among the best here.
        Ok(rivals)
    }
}

/// Whether two picks name the same run.
fn is_same(a: &Pick, b: &Pick) -> bool {
    a.method == b.method && a.substeps == b.substeps
}

/// The fastest run of each form that meets the target, the fastest form first.
fn best_of(record: &Record) -> Vec<Pick> {
    let good = record.good_m();
    let mut best: Vec<Pick> = Vec::new();
    for (form, named) in record.forms.iter().enumerate() {
        let own = record.runs.iter().filter(|run| run.form == form && run.meets(good));
        let Some(run) = own.min_by(|a, b| a.frame_s.total_cmp(&b.frame_s)) else { continue };
        let Some(error_m) = run.error_m else { continue };
        best.push(Pick {
            label: named.label.clone(),
            method: named.method.clone(),
            substeps: run.substeps,
            error_m,
            frame_s: run.frame_s,
        });
    }
    best.sort_by(|a, b| a.frame_s.total_cmp(&b.frame_s));
    best
}
