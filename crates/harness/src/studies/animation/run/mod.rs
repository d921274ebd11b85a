//! Experiment `animation`: what a frame costs that is good enough.

mod scenes;
#[cfg(test)]
mod tests;

use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::methods;
use crate::methods::runs::{Film, Runs, Substeps};
use crate::studies::animation::facts::{Facts, HEAVY, Run, TimingRow};
use crate::studies::variant::{is_explicit, or_defaults};
use crate::studies::{Context, Measured, Start, cells, prepared, timed};
use scenes::Setting;

/// Frames a second, in most scenes and in a film.
pub(super) const FRAMES_PER_S: u32 = 60;
pub(super) const FILM: u32 = 24;
/// Substeps of a frame of methods that stiffness does not limit.
const LADDER: [u32; 3] = [1, 2, 4];
/// Substeps of a frame for explicit methods: the least that hold, and those after it.
const EXPLICIT: [u32; 16] =
    [8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536];
/// Frames that are timed, and how often.
const TIMED: u32 = 6;
const REPETITIONS: usize = 3;

/// Every method of the registry in its forms.
pub(in crate::studies) fn forms() -> Vec<Film> {
    let of = |runs: &Runs| runs.animation;
    methods::runs()
        .flat_map(|(method, runs)| {
            let substeps = if is_explicit(method) { Substeps::Limit } else { Substeps::Ladder };
            or_defaults(method, of(runs), |form| Film { form, substeps })
        })
        .collect()
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "Bundled fabrics, by measured constants and as stiff on every mesh: a firm one \
         (cotton-blend), one firm along its weft (denim), a soft knit (ponte). A square metre, \
         damped by c = βk along each spring (light: β = {:e} s; heavy: {:e} s, a loss factor of \
         0.1 at 16 Hz), is shown at {FRAMES_PER_S} frames a second, in one scene at {FILM}. It \
         hangs by two corners, let go from the horizontal; hangs from an upper edge that goes \
         to and fro across it; falls, 8 cm off its centre, on a ball of 30 cm radius with a \
         coefficient of friction of 0.3; or is a flag in a wind of 6 m/s. All springs and \
         hinges begin at rest. The true motion is that of leapfrog at a quarter of its limit; \
         starts that differ by 1 µm out of the plane (seeded) tell its noise, and a run is held \
         against the nearest of them. Runs are ranked by shape where the cloth hangs: the mean \
         distance from the particles of each surface to the triangles of the other, about every \
         0.1 s. On the ball and in the wind two starts soon move apart, so there the distance \
         of the particles at 0.3 s ranks. Every method is run in each of its forms, with \
         {LADDER:?} substeps of a frame; an explicit one with rising numbers out of \
         {EXPLICIT:?} until two neither gain energy nor stand still; the last failure before \
         the first of these is kept. A run is locked if its energy is stable and the middle of \
         the free edge moves less than half of the true path. Where rings or wind supply \
         energy, a run counts as gaining some by itself if its mean kinetic energy is more than \
         {} times the true one. The work of {} sweeps of forces a frame, or {:e} visits of a \
         spring if that is more, ends a run over budget.",
        scenes::LIGHT,
        HEAVY,
        scenes::RESTLESS,
        scenes::SWEEPS_A_FRAME,
        scenes::BUDGET
    )
}

/// How the timings are taken.
pub(super) fn timing() -> String {
    format!(
        "One run at a time on one thread: the first {TIMED} frames, {REPETITIONS} times; the median \
         counts. It is the time of the processor in the calls of the method, where the system tells \
         it, else that of the clock: other programs disturb it less. Only runs that neither gain energy nor stand still are timed. Set-up \
         is not among the frames."
    )
}

/// The systems from which its runs start.
pub(super) fn starts() -> Vec<Start> {
    scenes::cases().into_iter().map(|case| Start::new(case.id(), move || case.spec())).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let mut cases = scenes::cases();
    cases.retain(|case| !context.quick || case.is_quick());
    let settings = prepared(context, "true motion", &cases, Setting::new)?;
    let forms = forms();
    let pairs: Vec<_> =
        settings.iter().flat_map(|s| forms.iter().map(move |form| (s, form))).collect();
    let all = cells(context, "methods", &pairs, |&(setting, form)| setting.runs(form))?;
    let runs: Vec<Run> = all.all()?.concat();
    let mut timings = None;
    if !context.quick {
        let sound: Vec<_> = runs
            .iter()
            .filter(|run| run.is_sound())
            .filter_map(|run| Some((settings.iter().find(|s| s.scene.id == run.scene)?, run)))
            .collect();
        timings =
            Some(timed(context, "timings", &sound, |&(setting, run)| setting.time(run))?.all()?);
    }
    let scenes = settings.iter().map(|s| (s.scene.id.clone(), s.hash.clone())).collect();
    let facts = Facts { scenes: settings.into_iter().map(|s| s.scene).collect(), runs };
    Ok(Measured { facts, timings, scenes, seed: Some(scenes::SEED) })
}

/// Its facts, as they are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let scenes = facts.scenes.iter().map(|scene| fact(scene.id.clone(), scene.portable, scene));
    let runs = facts.runs.iter().map(|run| {
        let mut fact =
            fact(format!("{}, {}, ×{}", run.scene, run.label, run.substeps), run.portable, run);
        if !run.portable
            && let serde_json::Value::Object(values) = &mut fact.values
        {
            // Cloth that folds is not repeatable after a library has rounded: its verdict is,
            // unless it stands near a limit.
            values.retain(|key, value| value.is_string() && (key != "verdict" || run.is_clear()));
        }
        fact
    });
    scenes.chain(runs).collect()
}

impl Run {
    /// Whether its verdict is far from the limits between verdicts.
    fn is_clear(&self) -> bool {
        let near_locked = self.retained.is_some_and(|retained| (0.45..0.55).contains(&retained));
        let near = |limit: f64| (0.5 * limit..2.0 * limit).contains(&self.gain);
        !near_locked && !near(0.02) && !near(0.5)
    }
}
