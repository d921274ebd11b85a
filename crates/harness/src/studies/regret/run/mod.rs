//! Experiment `regret`: whether the advice of `drape compare` is as good as exhaustive search.

mod clock;
mod forces;
mod scenes;
#[cfg(test)]
mod tests;

use crate::compare::facts::Facts as Record;
use crate::compare::{Checked, Clock, Options, advise, check_run, compare};
use crate::facts::{Fact, fact};
use crate::methods::Choice;
use crate::studies::regret::facts::{Case, Facts, Pick, TimingRow};
use crate::studies::{Context, Measured, Start, cells, timed};
use crate::{HarnessError, system_hash};
use drape_model::SystemSpec;
use scenes::{Question, questions};
use std::time::Duration;

/// Seed of the random numbers of the noise.
const SEED: u64 = 20;
/// Velocity that is added to all free particles when the advice is measured again, m/s.
const PUSH: [f64; 3] = [0.07, -0.05, 0.05];
/// A wall time that never ends, so that counted work alone decides which runs are made.
const ENDLESS: Duration = Duration::from_secs(1_000_000);

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "The scenes have springs, gravity and pins. No form or setting of a method was tuned \
         on them; four rules of the comparison were (see below). Each runs for {} s at 60 frames a \
         second with two targets: a hundredth of the cloth's longest side, and a quarter of that. \
         The comparison is `drape compare` with its default options, with three differences: it \
         ranks by modelled time, has no time limit, and leaves out forms without prices of their \
         own. The exhaustive search runs every form with rising numbers of steps until it meets \
         the target, whatever others do. Regret is the modelled time of the advised run over that \
         of the best run of the exhaustive search that meets the target. The advised form then \
         runs again on another motion: all free particles of the scene are pushed by {PUSH:?} \
         m/s, and the true motion is computed anew. If the search finds a form and the comparison \
         none, the target counts as missed. Effort is the modelled time a frame of all runs of \
         the comparison over that of the search; it leaves out runs that were put off. Four rules \
         of the comparison were made after scenes by the clock had failed. Long runs are put off \
         (a regret of 21). Short runs are timed longer (a regret of 1.8). A run that gains some \
         energy when pushed is not advised (two targets missed). A run must meet the target on a \
         pushed cloth, too, and gain no energy in three directions of the push (three missed). \
         The push of the comparison differs from the push that tests its advice here. Three of \
         the scenes were made after the first two rules, and three with the fourth; the advised \
         runs met the target there the first time.",
        scenes::DURATION_S
    )
}

pub(super) use clock::timing;

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let mut names = Vec::new();
    let mut all = questions();
    all.retain(|question| {
        let is_new = !names.contains(&question.scene.name);
        names.push(question.scene.name);
        is_new
    });
    let springs =
        all.into_iter().map(|Question { scene, .. }| both(scene.name, move || scene.spec()));
    let others = forces::SCENES.iter().map(|&(name, make)| both(name, make));
    // Bundled scenes have their own names; only their pushed starts belong to this study.
    let bundled = drape_model::bundled::names()
        .map(|name| pushed_start(name, move || Ok(drape_model::load(name)?.spec().clone())));
    springs.chain(others).flatten().chain(bundled).collect()
}

/// The starts of a scene: as it is, and with all free particles pushed.
fn both(
    name: &str,
    make: impl Fn() -> Result<SystemSpec, HarnessError> + Copy + 'static,
) -> [Start; 2] {
    [Start::new(name, make), pushed_start(name, make)]
}

/// The start of a scene with all free particles pushed.
fn pushed_start(
    name: &str,
    make: impl Fn() -> Result<SystemSpec, HarnessError> + 'static,
) -> Start {
    Start::new(format!("{name}, pushed"), move || Ok(pushed(&make()?)))
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
                let run = (&Choice::parse(&advice.method, &[])?, advice.substeps);
                let (name, duration) = (self.scene.name, scenes::DURATION_S);
                Some(check_run(name, &pushed(&spec), duration, &self.options(), run)?)
            }
        };
        let (again_m, again_good_m) = measured(again);
        let regret =
            best.as_ref().zip(advice.as_ref()).and_then(|(b, a)| ratio(a.frame_s, b.frame_s));
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
}

/// The error of a run on the pushed cloth and the largest error that meets the target, m. An entry
/// is `None` if it was not measured.
fn measured(again: Option<Checked>) -> (Option<f64>, Option<f64>) {
    match again {
        Some(Checked::Held { error_m, good_m }) => (error_m, Some(good_m)),
        Some(Checked::NotMeasured) | None => (None, None),
    }
}

/// The ratio of two times, or `None` if it is not finite: a record holds numbers only.
fn ratio(time: f64, other: f64) -> Option<f64> {
    Some(time / other).filter(|ratio| ratio.is_finite())
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

/// The run that a record advises.
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

/// Sum of the modelled times a frame of all runs, s.
fn work(record: &Record) -> f64 {
    record.runs.iter().map(|run| run.frame_s).sum()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let mut questions = questions();
    questions.retain(|question| !context.quick || question.is_quick);
    let cases = cells(context, "advice", &questions, Question::case)?.all()?;
    let mut timings = None;
    if context.long && !context.quick {
        let trials = clock::trials(&questions, &cases);
        timings = Some(timed(context, "clock", &trials, clock::Trial::time)?.all()?);
    }
    let hash = |question: &Question| {
        Ok((question.scene.name.to_owned(), system_hash(&question.scene.spec()?)))
    };
    let mut scenes = questions
        .iter()
        .map(hash)
        .collect::<Result<std::collections::BTreeMap<_, _>, HarnessError>>()?;
    if timings.is_some() {
        for (name, make) in forces::SCENES {
            scenes.insert((*name).to_owned(), system_hash(&make()?));
        }
    }
    Ok(Measured { facts: Facts { cases }, timings, scenes, seed: Some(SEED) })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let case =
        |case: &Case| fact(format!("{}, {} m", case.scene, case.target_m), case.portable, case);
    facts.cases.iter().map(case).collect()
}
