//! The same question by measured time, on every bundled scene, the scenes of this study, and scenes
//! with other forces.

use super::forces;
use super::scenes::{self, Question};
use super::{SEED, measured, pick, pushed, ratio};
use crate::HarnessError;
use crate::compare::facts::{End, Facts as Record, TIE};
use crate::compare::{DOMINATED, Options, check_run, compare, frame_seconds};
use crate::methods::Choice;
use crate::studies::regret::facts::{Case, Origin, Pick, TimingRow};
use drape_model::{SystemSpec, bundled};
use std::time::{Duration, Instant};

/// Wall time of a comparison.
const BUDGET: Duration = Duration::from_secs(60);
/// Wall time of the search, and of measuring the advice on the pushed cloth. The true motion takes
/// at most three tenths of it.
const SEARCH: Duration = Duration::from_secs(360);
/// The search stops a form once it takes this many times as long as the best. The factor is twice
/// that of the comparison.
const WIDER: f64 = 2.0 * DOMINATED;
/// Simulated time of a bundled scene that does not give one, s: 30 frames.
const USUAL_S: f64 = 0.5;
/// The bundled scene that has the frames of a film, and their number a second.
const CURTAIN: &str = "curtain";
const FILM: f64 = 24.0;
/// Largest number of the search's forms that are timed in turns with the advice.
const RIVALS: usize = 4;
/// Least and largest number of turns. After this many seconds no further turn begins.
const TURNS: [u32; 2] = [2, 7];
const TURNS_S: f64 = 3.0;

/// A question to be answered by measured time.
pub(super) struct Trial<'a> {
    name: String,
    origin: Origin,
    make: Box<dyn Fn() -> Result<SystemSpec, HarnessError> + 'a>,
    duration_s: f64,
    target_m: Option<f64>,
    /// The best run by modelled time.
    modelled: Option<&'a Pick>,
}

/// How the timings are taken.
pub(in crate::studies::regret) fn timing() -> String {
    let [fewest, most] = TURNS;
    format!(
        "`drape compare` runs with its default options, so it has {} s; only the bundled `{CURTAIN}` \
         has {FILM} frames a second. It runs on every bundled \
         scene, on the scenes above with their two targets, and on scenes with contact, friction, \
         wind and bending by angles. No scene with these was used for tuning either. The target \
         is a hundredth of the cloth's longest side unless another is named. The search is the \
         same comparison with {} s, which stops a form only once it takes {WIDER} times as long \
         as the best. If it could not run all forms to their end, it is no proof. Then runs are \
         timed in turns: the advised one, and the fastest run of each form that met the target in \
         the search. Up to {RIVALS} such forms take part, if the search took them to be at most \
         {TIE} times as slow as its fastest. Each is timed {fewest} to {most} times, by runs that \
         are repeated for at least a fiftieth of a second; after {TURNS_S} s no third or later \
         turn begins. The least time counts. The best is the fastest of these runs that met the \
         target in the search. Regret is the time of the advised run over that of the best. It is \
         below 1 if the comparison found a faster run than the search. It has no value without a \
         best run, without advice, or without a true motion for the search. The best run by \
         modelled time is timed beside them and compared only with its modelled time. The advised \
         run is measured again on the pushed cloth, with another true motion; both together have \
         {} s. It meets the target, misses it, or was not measured because the time did not \
         suffice. If the search finds a run that meets the target and the comparison none, the \
         target is missed.",
        BUDGET.as_secs(),
        SEARCH.as_secs(),
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

/// Simulated time of a bundled scene, s.
fn duration(name: &str) -> f64 {
    let input = drape_model::load(name).ok();
    let whole = input.as_ref().and_then(|input| input.scene()).map(|scene| scene.time.duration_s);
    whole.unwrap_or(USUAL_S)
}

/// A run that is timed in turns with others.
struct Rival {
    pick: Pick,
    choice: Choice,
    /// Its least time a frame, s. The time is positive; `None` before the first valid turn.
    least_s: Option<f64>,
}

impl Rival {
    /// Takes the time of one turn, s. A time that is not positive and finite is ignored.
    fn took(&mut self, time: Option<f64>) {
        if let Some(time) = time.filter(|time| time.is_finite() && *time > 0.0) {
            self.least_s = Some(self.least_s.map_or(time, |least| least.min(time)));
        }
    }
}

/// The judgement from the times of the turns.
#[derive(Debug, PartialEq)]
struct Judged<'a> {
    /// The fastest of the runs that met the target in the search.
    best: Option<&'a Pick>,
    regret: Option<f64>,
    over_model: Option<f64>,
}

/// Judges the times. Only a run in `met`, i.e. one that met the target in the search, can be best.
fn judged<'a>(
    rivals: &[Rival],
    met: &'a [Pick],
    advice: Option<&Pick>,
    modelled: Option<&Pick>,
) -> Judged<'a> {
    let time = |pick: &Pick| rivals.iter().find(|rival| is_same(&rival.pick, pick))?.least_s;
    let timed = met.iter().filter_map(|pick| Some((pick, time(pick)?)));
    let best = timed.min_by(|a, b| a.1.total_cmp(&b.1));
    let advised = advice.and_then(time);
    Judged {
        best: best.map(|(pick, _)| pick),
        regret: best.zip(advised).and_then(|((_, best), advised)| ratio(advised, best)),
        over_model: modelled.and_then(|pick| ratio(time(pick)?, pick.frame_s)),
    }
}

impl Trial<'_> {
    fn options(&self, budget: Duration) -> Options {
        let usual = Options::default();
        let film = self.origin == Origin::Bundled && self.name == CURTAIN;
        let rate = if film { FILM } else { usual.rate };
        Options { target_m: self.target_m, rate, budget, seed: SEED, ..usual }
    }

    fn asked(&self, spec: &SystemSpec, options: &Options) -> Result<Record, HarnessError> {
        Ok(compare(&self.name, spec, self.duration_s, options, &|_| ())?.facts)
    }

    /// Runs the comparison and the search on this machine, and times their best runs.
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
            frames_per_s: self.options(BUDGET).rate,
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
            let met = best_of(&all);
            let rivals = self.in_turns(&spec, advice.as_ref(), &met)?;
            let judged = judged(&rivals, &met, advice.as_ref(), self.modelled);
            // The search found a run, even if none could be timed again.
            let best = judged.best.or(met.first());
            row.best = best.map(|best| best.label.clone());
            row.best_substeps = best.map_or(0, |best| best.substeps);
            (row.regret, row.over_model) = (judged.regret, judged.over_model);
        }
        if let Some(advice) = &advice {
            let run = (&Choice::parse(&advice.method, &[])?, advice.substeps);
            let options = self.options(SEARCH);
            let again = check_run(&self.name, &pushed(&spec), self.duration_s, &options, run)?;
            (row.again_m, row.again_good_m) = measured(Some(again));
        }
        Ok(row)
    }

    /// Times the advised run and the best runs of the search in turns. `met` are the search's runs
    /// that met the target, fastest first.
    fn in_turns(
        &self,
        spec: &SystemSpec,
        advice: Option<&Pick>,
        met: &[Pick],
    ) -> Result<Vec<Rival>, HarnessError> {
        let near = met.first().map_or(0.0, |best| TIE * best.frame_s);
        let fast = met.iter().filter(|pick| pick.frame_s <= near).take(RIVALS);
        // The best run by modelled time need not be among the fastest on this machine.
        let mut rivals: Vec<Rival> = Vec::new();
        for pick in advice.into_iter().chain(fast).chain(self.modelled) {
            if !rivals.iter().any(|known| is_same(&known.pick, pick)) {
                let choice = Choice::parse(&pick.method, &[])?;
                rivals.push(Rival { pick: pick.clone(), choice, least_s: None });
            }
        }
        let options = self.options(SEARCH);
        let begin = Instant::now();
        let [fewest, most] = TURNS;
        for turn in 0..most {
            if turn >= fewest && begin.elapsed().as_secs_f64() > TURNS_S {
                break;
            }
            for rival in &mut rivals {
                let run = (&rival.choice, rival.pick.substeps);
                rival.took(frame_seconds(&self.name, spec, self.duration_s, &options, run)?);
            }
        }
        Ok(rivals)
    }
}

/// Whether two picks name the same run.
fn is_same(a: &Pick, b: &Pick) -> bool {
    a.method == b.method && a.substeps == b.substeps
}

/// The fastest run of each form that meets the target, fastest form first.
fn best_of(record: &Record) -> Vec<Pick> {
    let mut best: Vec<Pick> = Vec::new();
    for (form, named) in record.forms.iter().enumerate() {
        let own = record.runs.iter().filter(|run| run.form == form && record.is_met(run));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn pick(label: &str, frame_s: f64) -> Pick {
        Pick {
            label: label.to_owned(),
            method: label.to_owned(),
            substeps: 4,
            error_m: 0.008,
            frame_s,
        }
    }

    fn rival(pick: &Pick, times: &[Option<f64>]) -> Rival {
        let choice = Choice::parse("bdf2", &[]).expect("a method");
        let mut rival = Rival { pick: pick.clone(), choice, least_s: None };
        times.iter().for_each(|time| rival.took(*time));
        rival
    }

    /// A search that found nothing cannot show that the advice is the best.
    #[test]
    fn without_a_run_that_meets_the_target_in_the_search_there_is_no_regret() {
        let advice = pick("advised", 1.0);
        let rivals = [rival(&advice, &[Some(2.0)])];
        let found = judged(&rivals, &[], Some(&advice), None);
        assert_eq!(found, Judged { best: None, regret: None, over_model: None });
        // The best run by modelled time is timed, but it is not the best here either.
        let modelled = pick("modelled", 0.5);
        let rivals = [rival(&advice, &[Some(2.0)]), rival(&modelled, &[Some(1.0)])];
        let found = judged(&rivals, &[], Some(&advice), Some(&modelled));
        assert_eq!(found, Judged { best: None, regret: None, over_model: Some(2.0) });
    }

    #[test]
    fn the_best_is_the_fastest_that_met_the_target_whatever_else_is_faster() {
        let (advice, modelled) = (pick("advised", 1.0), pick("modelled", 0.25));
        let met = [pick("first", 1.0), pick("second", 1.1)];
        let rivals = [
            rival(&advice, &[Some(3.0), Some(2.5)]),
            rival(&met[0], &[Some(2.0)]),
            rival(&met[1], &[Some(1.25), Some(9.0)]),
            rival(&modelled, &[Some(0.5)]),
        ];
        let found = judged(&rivals, &met, Some(&advice), Some(&modelled));
        assert_eq!(found.best, Some(&met[1]));
        assert_eq!((found.regret, found.over_model), (Some(2.0), Some(2.0)));
        // An advised run that the search does not have may be faster than all of the search's.
        let rivals = [rival(&advice, &[Some(1.0)]), rival(&met[0], &[Some(2.0)])];
        assert_eq!(judged(&rivals, &met, Some(&advice), None).regret, Some(0.5));
        assert_eq!(judged(&rivals, &met, None, None).regret, None);
    }

    #[test]
    fn only_numbers_are_times() {
        let advice = pick("advised", 0.0);
        let wrong = [None, Some(f64::INFINITY), Some(f64::NAN), Some(0.0), Some(-1.0)];
        let lost = rival(&advice, &wrong);
        assert_eq!(lost.least_s, None);
        let met = [pick("first", 1.0)];
        let found = judged(&[lost, rival(&met[0], &[Some(1.0)])], &met, Some(&advice), None);
        assert_eq!((found.best, found.regret), (Some(&met[0]), None));
        // A lost time of the best or a modelled time of zero gives no ratio.
        let rivals = [rival(&advice, &[Some(1.0)]), rival(&met[0], &wrong)];
        let found = judged(&rivals, &met, Some(&advice), Some(&advice));
        assert_eq!(found, Judged { best: None, regret: None, over_model: None });
        assert_eq!(
            rival(&advice, &[Some(f64::NAN), Some(2.0), None, Some(3.0)]).least_s,
            Some(2.0)
        );
    }
}
