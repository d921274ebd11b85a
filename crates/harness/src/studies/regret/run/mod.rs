//! Experiment `regret`: whether the advice of `drape compare` is as good as exhaustive search.

mod scenes;
#[cfg(test)]
mod tests;

use crate::compare::facts::Facts as Record;
use crate::compare::{Clock, Options, advise, compare, frame_seconds};
use crate::facts::{Fact, fact};
use crate::methods::Choice;
use crate::studies::regret::facts::{Case, Facts, Pick, TimingRow};
use crate::studies::{Context, Measured, Start, cells, timed};
use crate::{HarnessError, system_hash};
use drape_model::SystemSpec;
use scenes::{Question, questions};
use std::time::Duration;

/// Seed of the noise.
const SEED: u64 = 20;
/// Velocity that the whole cloth gets besides where the advice is measured again, m/s.
const PUSH: [f64; 3] = [0.07, -0.05, 0.05];
/// Wall time that never ends: what runs is decided by counted work alone.
const ENDLESS: Duration = Duration::from_secs(1_000_000);
/// Wall time of a comparison by the clock.
const BUDGET: Duration = Duration::from_secs(20);
/// How often the advised and the best run are timed in turns.
const REPETITIONS: usize = 3;

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "Scenes of springs, gravity and pins on which neither the rules of the comparison nor the forms and settings of a method \
         were tuned, each for {} s at 60 frames a second and for two targets: a hundredth of the \
         cloth's longest side, and a quarter of that. The comparison is that of `drape compare` \
         with its default options, but ranked by modelled time, without an end of its time, and \
         without forms that have no prices of their own. The \
         exhaustive search runs every form with rising numbers of steps until it meets the target, \
         whatever others do. Regret is the modelled time of the advised run over that of the best \
         run of the exhaustive search. The advised form is then run again on another motion: all free \
         particles of the scene are pushed by {PUSH:?} m/s, and the true motion is found anew.",
        scenes::DURATION_S
    )
}

/// How the timings are taken.
pub(super) fn timing() -> String {
    format!(
        "`drape compare` with its default options and a budget of {} s. The run that it advises and \
         the best one of the exhaustive search are timed in turns, {REPETITIONS} times each; the \
         least time counts.",
        BUDGET.as_secs()
    )
}

/// The systems from which its runs start.
pub(super) fn starts() -> Vec<Start> {
    let mut names = Vec::new();
    let mut all = questions();
    all.retain(|question| {
        let is_new = !names.contains(&question.scene.name);
        names.push(question.scene.name);
        is_new
    });
    let start = |question: Question| Start::new(question.scene.name, move || question.scene.spec());
    all.into_iter().map(start).collect()
}

impl Question {
    fn options(&self) -> Options {
        Options {
            target_m: Some(self.target_m),
            budget: ENDLESS,
            seed: SEED,
            clock: Clock::Modelled,
            ..Options::default()
        }
    }

    fn asked(&self, spec: &SystemSpec, options: &Options) -> Result<Record, HarnessError> {
        let duration = scenes::DURATION_S;
        Ok(compare(self.scene.name, spec, duration, options, &|_| ())?.facts)
    }

    fn case(&self) -> Result<Case, HarnessError> {
        let spec = self.scene.spec()?;
        let raced = self.asked(&spec, &self.options())?;
        let all = self.asked(&spec, &Options { exhaustive: true, ..self.options() })?;
        let (best, advice) = (pick(&all), pick(&raced));
        let again = match &advice {
            None => None,
            Some(advice) => {
                let methods = Some(advice.method.clone());
                let options = Options { methods, exhaustive: true, ..self.options() };
                let found = self.asked(&pushed(&spec), &options)?;
                // It stops once it meets the target, with as many steps or fewer.
                let fits = |run: &&crate::compare::facts::Run| {
                    run.is_sound() && run.substeps <= advice.substeps
                };
                let last = found.runs.iter().filter(fits).max_by_key(|run| run.substeps);
                Some((last.and_then(|run| run.error_m), found.good_m()))
            }
        };
        let (again_m, again_good_m) = again.unwrap_or((None, raced.good_m()));
        let regret = best.as_ref().zip(advice.as_ref()).map(|(b, a)| a.frame_s / b.frame_s);
        Ok(Case {
            scene: self.scene.name.to_owned(),
            description: self.scene.description.to_owned(),
            particles: raced.scene.particles,
            target_m: self.target_m,
            good_m: raced.good_m(),
            is_trusted: raced.truth.is_trusted && all.truth.is_trusted,
            best,
            advice,
            regret,
            effort: work(&raced) / work(&all),
            again_m,
            again_good_m,
            portable: false,
        })
    }

    /// What the clock of this machine says.
    fn time(&self, case: &Case) -> Result<TimingRow, HarnessError> {
        let spec = self.scene.spec()?;
        let options = Options { budget: BUDGET, clock: Clock::Wall, ..self.options() };
        let found = self.asked(&spec, &options)?;
        let advice = pick(&found);
        let (regret, over_model) = match case.best.as_ref().zip(advice.as_ref()) {
            Some((best, advice)) => {
                let both = [best, advice].map(|pick| (pick.method.as_str(), pick.substeps));
                let [best_s, advice_s] = self.in_turns(&spec, both)?;
                (Some(advice_s / best_s), Some(best_s / best.frame_s))
            }
            None => (None, None),
        };
        Ok(TimingRow {
            scene: self.scene.name.to_owned(),
            target_m: self.target_m,
            budget_s: BUDGET.as_secs_f64(),
            seconds: found.seconds,
            substeps: advice.as_ref().map_or(0, |pick| pick.substeps),
            label: advice.map(|pick| pick.label),
            regret,
            over_model,
        })
    }

    /// Seconds a frame of two runs, timed in turns.
    fn in_turns(
        &self,
        spec: &SystemSpec,
        runs: [(&str, u32); 2],
    ) -> Result<[f64; 2], HarnessError> {
        let mut least = [f64::INFINITY; 2];
        for _ in 0..REPETITIONS {
            for (least, (method, substeps)) in least.iter_mut().zip(runs) {
                let choice = Choice::parse(method, &[])?;
                let (name, duration) = (self.scene.name, scenes::DURATION_S);
                let options = self.options();
                let time = frame_seconds(name, spec, duration, &options, (&choice, substeps))?;
                *least = least.min(time.unwrap_or(f64::INFINITY));
            }
        }
        Ok(least)
    }
}

/// The scene with all free particles pushed.
fn pushed(spec: &SystemSpec) -> SystemSpec {
    let mut spec = spec.clone();
    let count = spec.particles.mass_kg.len();
    spec.particles.velocity_m_s.resize(count, [0.0; 3]);
    for (n, velocity) in (0..).zip(&mut spec.particles.velocity_m_s) {
        if !spec.pins.iter().any(|pin| pin.particle == n) {
            velocity.iter_mut().zip(PUSH).for_each(|(v, push)| *v += push);
        }
    }
    spec
}

/// What a record advises.
fn pick(record: &Record) -> Option<Pick> {
    let run = &record.runs[advise(record).take?.run];
    let form = record.form_of(run);
    Some(Pick {
        label: form.label.clone(),
        method: form.method.clone(),
        substeps: run.substeps,
        error_m: run.error_m?,
        frame_s: run.frame_s,
    })
}

/// Modelled time a frame of all runs, s.
fn work(record: &Record) -> f64 {
    record.runs.iter().map(|run| run.frame_s).sum()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let mut questions = questions();
    questions.retain(|question| !context.quick || question.is_quick);
    let cases = cells(context, "advice", &questions, Question::case)?.all()?;
    let mut timings = None;
    if !context.quick {
        let both: Vec<_> = questions.iter().zip(&cases).collect();
        timings =
            Some(timed(context, "timings", &both, |(question, case)| question.time(case))?.all()?);
    }
    let hash = |question: &Question| {
        Ok((question.scene.name.to_owned(), system_hash(&question.scene.spec()?)))
    };
    let scenes = questions.iter().map(hash).collect::<Result<_, HarnessError>>()?;
    Ok(Measured { facts: Facts { cases }, timings, scenes, seed: Some(SEED) })
}

/// Its facts, as they are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let case =
        |case: &Case| fact(format!("{}, {} m", case.scene, case.target_m), case.portable, case);
    facts.cases.iter().map(case).collect()
}
