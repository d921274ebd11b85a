//! Scenes that are judged by the clock: the bundled ones, and those with contact, wind or hinges.

use super::{PUSH, REPETITIONS, SEED, again, in_turns, pick, pushed, scenes};
use crate::HarnessError;
use crate::compare::facts::{End, Facts as Record, TIE};
use crate::compare::{DOMINATED, Options, Search, advise, compare, lines};
use crate::scenes::time_span;
use crate::studies::regret::facts::{Clocked, Pick};
use drape_model::SystemSpec;
use std::time::Duration;

/// Wall time of the comparison, and of the search for the best run.
const BUDGET: Duration = Duration::from_secs(30);
const SEARCH: Duration = Duration::from_secs(240);
/// Runs of the search that are timed again.
const FINALISTS: usize = 4;

/// How they are judged.
pub(super) fn method() -> String {
    format!(
        "Bundled scenes, over their own time, and scenes with contact, friction, wind or hinges: \
         `drape compare` with its default options and a budget of {} s. The search takes at most \
         {} s: it runs every form with rising numbers of steps until it meets the target, foresees \
         nothing, and ends a run that has taken {DOMINATED} times as long as the whole of the best \
         one. The advised run and the fastest {FINALISTS} of the search, if they are within \
         {TIE} times the fastest, are timed in turns, {REPETITIONS} times each; the least time \
         counts. Regret is the time of the advised run over the least of these, so it is never \
         below 1. The advised form is then run again where all free particles are pushed by \
         {PUSH:?} m/s, against a true motion found anew.",
        BUDGET.as_secs(),
        SEARCH.as_secs()
    )
}

/// A scene with the time that it lasts.
pub(super) struct Scene {
    pub(super) name: String,
    description: String,
    is_bundled: bool,
    pub(super) spec: SystemSpec,
    duration_s: f64,
}

/// All of them: the bundled ones first.
pub(super) fn scenes() -> Result<Vec<Scene>, HarnessError> {
    let bundled = |name: &str| {
        let input = drape_model::load(name)?;
        let scene = input.scene().map(|scene| scene.description.clone());
        Ok(Scene {
            name: name.to_owned(),
            description: scene.unwrap_or_default(),
            is_bundled: true,
            duration_s: time_span(None, None, &input)?.duration_s,
            spec: input.spec().clone(),
        })
    };
    let own = |scene: scenes::Scene| {
        Ok(Scene {
            name: scene.name.to_owned(),
            description: scene.description.to_owned(),
            is_bundled: false,
            duration_s: scenes::DURATION_S,
            spec: scene.spec()?,
        })
    };
    let bundled = drape_model::bundled::names().map(bundled);
    bundled.chain(scenes::with_effects().into_iter().map(own)).collect()
}

impl Scene {
    /// A comparison by the clock.
    fn asked(&self, spec: &SystemSpec, options: &Options) -> Result<Record, HarnessError> {
        Ok(compare(&self.name, spec, self.duration_s, options, &|_| ())?.facts)
    }

    /// The advice beside the search.
    pub(super) fn judge(&self) -> Result<Clocked, HarnessError> {
        let options = Options { budget: BUDGET, seed: SEED, ..Options::default() };
        let record = self.asked(&self.spec, &options)?;
        let search = Options { budget: SEARCH, search: Search::Bounded, ..options.clone() };
        let found = self.asked(&self.spec, &search)?;
        let mut advice = pick(&record);
        let mut best = None;
        let mut again_m = (None, None);
        if let Some(advice) = &mut advice {
            best = Some(self.fastest(advice, &found, &options)?);
            let methods = Some(advice.method.clone());
            let options = Options { methods, ..search.clone() };
            let pushed = self.asked(&pushed(&self.spec), &options)?;
            if pushed.truth.is_trusted {
                again_m = (again(&pushed, advice.substeps), Some(pushed.good_m()));
            }
        }
        let admitted = found.forms.iter().filter(|form| form.end != End::Refused);
        let is_whole = |end: End| end != End::OutOfTime;
        Ok(Clocked {
            scene: self.name.clone(),
            description: self.description.clone(),
            is_bundled: self.is_bundled,
            particles: record.scene.particles,
            frames: record.scene.frames,
            target_m: record.scene.target_m,
            good_m: record.good_m(),
            budget_s: record.scene.budget_s,
            seconds: record.seconds,
            lines: lines(&record, &advise(&record)).len(),
            untrusted: (!record.truth.is_trusted)
                .then(|| record.truth.remark.clone().unwrap_or_default()),
            regret: advice
                .as_ref()
                .zip(best.as_ref())
                .filter(|_| record.truth.is_trusted && found.truth.is_trusted)
                .map(|(advice, best)| advice.frame_s / best.frame_s),
            advice,
            best,
            searched: (admitted.clone().filter(|f| is_whole(f.end)).count(), admitted.count()),
            again_m: again_m.0,
            again_good_m: again_m.1,
        })
    }

    /// The fastest of the advised run and the best of a search; the times of both are those in
    /// turns.
    fn fastest(
        &self,
        advice: &mut Pick,
        found: &Record,
        options: &Options,
    ) -> Result<Pick, HarnessError> {
        let first = advise(found);
        let near = first.take.into_iter().chain(first.ties).take(FINALISTS);
        let near = near.filter_map(|place| super::picked(found, place.run));
        let mut picks: Vec<Pick> = std::iter::once(advice.clone()).chain(near).collect();
        let runs: Vec<_> = picks.iter().map(|pick| (pick.method.as_str(), pick.substeps)).collect();
        let scene = (self.name.as_str(), &self.spec, self.duration_s);
        let times = in_turns(scene, options, &runs)?;
        picks.iter_mut().zip(times).for_each(|(pick, time)| pick.frame_s = time);
        advice.frame_s = picks[0].frame_s;
        let least = picks.into_iter().reduce(|a, b| if b.frame_s < a.frame_s { b } else { a });
        Ok(least.unwrap_or_else(|| advice.clone()))
    }
}
