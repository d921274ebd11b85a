//! Experiment `animation`: what a good frame costs.

mod long;
mod scenes;
#[cfg(test)]
mod tests;

use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::methods;
use crate::methods::runs::{Film, Inside, Runs, Substeps};
use crate::studies::animation::facts::{
    FINE, Facts, HEAVY, LIVELY, Missing, NEARLY, Run, Scene, TimingRow,
};
use crate::studies::clocked::{REPETITIONS, about_probe, disturbance};
use crate::studies::filmed::{LONG_S, clock, clock_again, shoot};
use crate::studies::variant::{is_explicit, or_defaults};
use crate::studies::{Context, Measured, Recorded, Start, Timing, prepared};
pub(super) use long::run as long;
use scenes::{Case, Setting};

/// Frames a second: in most scenes, and in the scene with the rate of a film.
pub(super) const FRAMES_PER_S: u32 = 60;
pub(super) const FILM: u32 = 24;
/// Numbers of substeps of a frame for methods that stiffness does not limit.
const LADDER: [u32; 5] = [1, 2, 4, 8, 16];
/// The same on cloth of 2500 particles and more, where more would take hours.
const LARGE_LADDER: [u32; 3] = [1, 2, 4];
/// The calls a frame with which a form is tried that stiffness does not limit, cheapest first. The
/// number is the value of its setting, where a setting fixes the work in a call.
fn rungs(film: &Film, ladder: &[u32]) -> Vec<(u32, Option<(&'static Inside, u32)>)> {
    match Inside::of(film.form.method, film.form.label) {
        Some(inside) => {
            let rungs = inside.rungs.iter();
            rungs.map(|&(calls, number)| (calls, Some((inside, number)))).collect()
        }
        None => ladder.iter().map(|&calls| (calls, None)).collect(),
    }
}

/// Numbers of substeps of a frame for explicit methods. Runs go up to the first two sound ones, and
/// further until one is good, except in the dearest scenes of the long study.
const EXPLICIT: [u32; 16] =
    [8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536];
/// Number of sweeps of forces a frame from which on more calls of a form are not tried, on the usual
/// mesh. It grows with the budget.
const DEAR: f64 = 100.0;

/// The forms of every method of the registry, method by method.
fn of_registry() -> impl Iterator<Item = Vec<Film>> {
    let of = |runs: &Runs| runs.animation;
    methods::runs().map(move |(method, runs)| {
        let substeps = if is_explicit(method) { Substeps::Limit } else { Substeps::Ladder };
        or_defaults(method, of(runs), |form| Film { form, substeps })
    })
}

/// Every method of the registry in its forms.
pub(in crate::studies) fn forms() -> Vec<Film> {
    of_registry().flatten().collect()
}

/// The first form of every method, for scenes on which all forms would be too expensive.
fn first_forms() -> Vec<Film> {
    of_registry().filter_map(|forms| forms.into_iter().next()).collect()
}

/// How the facts are measured.
pub(super) fn method() -> String {
    let more = format!(
        "The study `animation-long` has larger cloth and longer motions. Here the cloth may also \
         hang from an upper edge that goes to and fro across it, filmed at {FILM} frames a second \
         with ten keys of its path in each; there the budget of a frame grows like its length. \
         Methods that stiffness does not limit \
         run with {LADDER:?} substeps of a frame. On all scenes an explicit method runs on until \
         one of its runs is also good, as the figures count it."
    );
    format!("{} {more}", common())
}

/// How the facts of the long study are measured.
pub(super) fn long_method() -> String {
    let more = format!(
        "The scenes of this study last 5 s, or have 2500 to 40 000 particles, or both. They run \
         only the first form of each method, which was chosen after the small scenes of \
         `animation` had been run. On the first two scenes an explicit method runs on until one of \
         its runs is also good, as the figures count it. One more cloth is held in its middle while \
         the rest falls over the ball, and so stays on it. Methods that stiffness does not limit \
         run with {LADDER:?} substeps of a frame, and with {LARGE_LADDER:?} on 2500 particles and \
         more. Beyond {} particles along an edge the sweeps of a frame grow no further, and an \
         explicit method is not tried with more calls after a sound run that is off by at most {} \
         mm or the noise. The true motion of the largest cloth over 5 s has steps of half the \
         limit, and the energy that is set free is that at its looks, every 0.1 s; there the first \
         good run of a form is its last, and forms are left out that over 0.4 s have no sound run \
         and exceed the budget. A record may lack forms or scenes: it names them, and the \
         next run adds them. The quick subset has none of these scenes.",
        scenes::FINEST,
        1e3 * FINE
    );
    format!("The set-up is that of the study `animation`. {} {more}", common())
}

fn common() -> String {
    format!(
        "The scenes use bundled fabrics with measured constants, equally stiff on every mesh: a \
         firm one (cotton-blend), one that is firm along its weft (denim), and a soft knit \
         (ponte). A square metre of cloth is damped by c = βk along each spring. Light damping is \
         β = {:e} s; heavy damping is {:e} s, a loss factor of 0.1 at 16 Hz. Films show \
         {FRAMES_PER_S} frames a second. The cloth either hangs by two corners, let go from the \
         horizontal; or falls, 8 cm off its centre, on a ball of 30 cm radius with a coefficient \
         of friction of 0.3; or is a flag in a wind of 6 m/s. All springs and hinges begin at \
         rest. Leapfrog at a quarter of its limit computes the true motion. Further true motions \
         start 1 µm off, out of the plane (seeded); they measure the noise, the mean distance of a \
         true motion from the nearest of the others. A run is compared with the nearest true \
         motion, too. Shape ranks the runs where pins hold the cloth and no wind \
         blows: the mean distance from the particles of each surface to the triangles of the \
         other, about every 0.1 s. On the ball without pins and in the wind two starts soon move \
         apart, so there the distance of the particles at 0.3 s ranks the runs. Where a setting \
         fixes the work in a call (substeps, sweeps or iterations), the method's file lists up to \
         {} pairs of calls and values, and the form runs with these. A form that stiffness does \
         not limit tries no more after a sound run that is off by at most {} mm or the noise and \
         keeps its kinetic energy within a factor of {:.2}, after a run that took {DEAR} sweeps \
         of forces a frame (on finer meshes more, as in the budget below), or after one whose \
         factorisations used up its budget. An explicit \
         method runs with rising numbers from {EXPLICIT:?} until two runs are sound, that is, \
         neither gain energy nor stand still, or until one exceeds its budget; the last failure \
         before the first sound run is kept. A run is locked if its energy is stable and the \
         middle of the free edge moves less than half of the true path. It has lost contact if at \
         the end fewer than half as many particles lie on the ball as in the true motion, to {} \
         mm. Where rings or wind supply energy, a gain is what exceeds the energy at the start and \
         their work, compared with the greatest kinetic energy of the true motion. In each step \
         the greater of the work by the forces at its start and at its end counts, so a small gain \
         may be missed. A run has gained energy, too, if its mean kinetic energy is more than {} \
         times the true one. A run ends over budget after the work of {} sweeps of forces a frame, \
         or after {:e} visits of a spring if that is more. On meshes finer than 20 particles along \
         an edge, the number of sweeps grows with the number along the edge.",
        scenes::LIGHT,
        HEAVY,
        EXPLICIT.len(),
        1e3 * FINE,
        LIVELY / NEARLY,
        1e3 * scenes::NEAR_M,
        scenes::RESTLESS,
        scenes::SWEEPS_A_FRAME,
        scenes::BUDGET
    )
}

/// The timings of both studies.
pub(super) const TIMING: Timing<Facts, TimingRow> = Timing {
    method: timing,
    about: |rows| disturbance(rows.iter().map(|row| row.probe_s)),
    again: Some(again),
};

/// How the timings are taken.
fn timing() -> String {
    format!(
        "One run of a whole scene at a time, on one thread. The median of {REPETITIONS} \
         repetitions counts; a run of more than {LONG_S} s is timed once. The time is the \
         processor time in the calls of the method if the system reports it, else the wall time; \
         other programs disturb processor time less. {} Only runs that neither gain energy nor \
         stand still are timed. The time excludes set-up.",
        about_probe()
    )
}

/// Takes the timings of a record anew.
fn again(
    context: &Context<'_>,
    mut facts: Facts,
    recorded: &Recorded<'_>,
) -> Result<(Facts, Vec<TimingRow>), HarnessError> {
    let rows = clock_again(context, recorded, &facts.runs, |scene| {
        let mut cases = scenes::cases().into_iter().chain(scenes::long());
        cases.find(|case| case.id() == scene).map(|case| Setting::staged(&case)).transpose()
    })?;
    facts.missing.iter_mut().for_each(|missing| missing.not_timed.clear());
    facts.missing.retain(Missing::names_any);
    Ok((facts, rows))
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    starts_of(scenes::cases())
}

/// The systems from which runs of the long study start.
pub(super) fn long_starts() -> Vec<Start> {
    starts_of(scenes::long())
}

fn starts_of(cases: Vec<Case>) -> Vec<Start> {
    cases.into_iter().map(|case| Start::new(case.id(), move || case.spec())).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let mut cases = scenes::cases();
    cases.retain(|case| !context.quick || case.is_quick());
    let settings = prepared(context, "true motion", &cases, Setting::new)?;
    let runs = shoot(context, &settings)?;
    let timings = clock(context, &settings, &runs)?;
    let scenes = settings.iter().map(|s| (s.scene.id.clone(), s.hash.clone())).collect();
    let facts = Facts {
        scenes: settings.into_iter().map(|s| s.scene).collect(),
        runs: runs.concat(),
        missing: Vec::new(),
    };
    Ok(Measured { facts, timings, scenes, seed: Some(scenes::SEED) })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let scenes = facts.scenes.iter().map(|scene| {
        let scene = Scene { computed: None, ..scene.clone() };
        fact(scene.id.clone(), scene.portable, &scene)
    });
    let runs = facts.runs.iter().map(|run| {
        let inside = run.inside.map_or_else(String::new, |number| format!(" of {number}"));
        let key = format!("{}, {}, ×{}{inside}", run.scene, run.label, run.substeps);
        let mut fact = fact(key, run.portable, run);
        if !run.portable
            && let serde_json::Value::Object(values) = &mut fact.values
        {
            // If a library's functions rounded, the motion of folding cloth is not repeatable. Its
            // verdict is, unless it is close to a limit.
            values.retain(|key, value| value.is_string() && (key != "verdict" || run.is_clear()));
        }
        fact
    });
    scenes.chain(runs).collect()
}

impl Run {
    /// Whether the verdict is far from the limits between verdicts.
    fn is_clear(&self) -> bool {
        let near_locked = self.retained.is_some_and(|retained| (0.45..0.55).contains(&retained));
        let near = |limit: f64| (0.5 * limit..2.0 * limit).contains(&self.gain);
        !near_locked && !near(0.02) && !near(0.5)
    }
}
