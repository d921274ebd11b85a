//! Experiment `rest`: which methods bring a cloth to rest, in which shape, and at what cost.

mod scenes;
#[cfg(test)]
mod tests;

use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::studies::clocked::{REPETITIONS, about_probe, disturbance};
use crate::studies::filmed::{LONG_S, clock, clock_again, shoot};
use crate::studies::rest::facts::{Facts, RIGHT, THERE, TimingRow};
use crate::studies::{Context, Measured, Recorded, Start, Timing, prepared};
use scenes::Setting;

/// Number of looks at the cloth a second.
const LOOKS_PER_S: u32 = 10;
/// Numbers of steps between looks for methods that stiffness does not limit. The first [`ALWAYS`]
/// are always run, the others until one run ends in a right shape.
const STEPS: [u32; 5] = [1, 3, 10, 30, 100];
/// How many of [`STEPS`] every form runs.
const ALWAYS: usize = 2;
/// Numbers of steps of explicit methods, over the number within the limit. The first run that
/// arrives counts.
const SHARES: [f64; 6] = [0.5, 0.75, 1.0, 1.5, 2.0, 4.0];

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "Round table: the drape test of BS 5058. A disc of a bundled material, 30 cm across, lies \
         on a table of 18 cm; its mesh is 8 or 12 squares across. Its springs are damped along \
         themselves by c = {:e} s × k, and air damps motion along the normal by {}/s. Square \
         table: a sheet of 1 m × 1 m, 0.4 kg and 20 × 20 particles, with k/m = {:e} s⁻² and d/m = \
         {}/s along the threads and full damping; shear springs have a tenth of both, bending \
         springs a hundredth. The table holds the part of the cloth that lies on it. The cloth \
         starts flat and without stress; vertical speeds of up to {} m/s (seeded) break its \
         symmetry. A run is at rest when the greatest force on a particle is at most {RESIDUAL} \
         of the weight of the heaviest one and the root mean square speed is at most {SPEED} m/s. \
         A run ends when it is at rest, when its time is over, or after {BUDGET:e} visits of a \
         spring. Newton's method on the energy, with a line search and without a time step, then \
         starts from the last surface. It finds the rest shape of the run. The surface is \
         observed ten times a second. The run has arrived at the first observation from which on \
         the surface stays within {} mm of the rest shape; a run that did not end at rest must \
         stay there for at least {} observations. Its work until then is its cost. The shape is \
         right if its energy is within {} of the released energy of an accepted minimum. Accepted \
         are the least known minimum and every minimum in which a true motion ends. The least \
         known energy is the lowest of two sets: rest shapes that Newton's method finds \
         from starts with {:?} waves, and minima that runs reached. Runs that the rounding of a \
         library affects are left out of the second set. The true motions are runs of `{TRUE}` \
         with {FINE:?} times the steps of its limit. One begins at the start of the runs; {NOISY} \
         more begin with noise of up to {NOISE:e} m along each axis. A true motion counts if both \
         steps lead to the same energy, within the same tolerance. A run that does not arrive is locked if \
         it has covered less than {} of its way at its end; otherwise it is open. Every method \
         runs in the forms of the study `animation`, with {FIRST:?} steps in 0.1 s and, until one \
         arrives, with {MORE:?}. An explicit method takes {SHARES:?} times the steps of its limit \
         until it arrives.",
        scenes::RETARDATION,
        scenes::AIR,
        scenes::STIFFNESS,
        scenes::DAMPING,
        scenes::NUDGE,
        1e3 * THERE,
        scenes::SETTLED,
        RIGHT,
        scenes::WAVES,
        scenes::LOCKED,
        RESIDUAL = scenes::RESIDUAL,
        SPEED = scenes::SPEED,
        BUDGET = scenes::BUDGET,
        TRUE = scenes::TRUE,
        FINE = scenes::FINE,
        NOISY = scenes::NOISY.len(),
        NOISE = scenes::NOISE,
        FIRST = &STEPS[..ALWAYS],
        MORE = &STEPS[ALWAYS..],
    )
}

pub(super) const TIMING: Timing<Facts, TimingRow> = Timing {
    method: timing,
    about: |rows| disturbance(rows.iter().map(|row| row.probe_s)),
    again: Some(again),
};

/// How the timings are taken.
fn timing() -> String {
    format!(
        "One run at a time on one thread, from the start until the cloth has arrived. The median \
         of {REPETITIONS} repetitions counts; a run beyond {LONG_S} s is timed once. The time is \
         the processor time in the calls of the method if the system reports it, else the wall \
         time. {} Only runs that arrive in a right shape are timed. The time excludes set-up.",
        about_probe()
    )
}

/// Takes the timings of a record anew.
fn again(
    context: &Context<'_>,
    facts: Facts,
    recorded: &Recorded<'_>,
) -> Result<(Facts, Vec<TimingRow>), HarnessError> {
    let rows = clock_again(context, recorded, &facts.runs, |scene| {
        let mut cases = scenes::cases().into_iter();
        cases.find(|case| case.id() == scene).map(|case| Setting::staged(&case)).transpose()
    })?;
    Ok((facts, rows))
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    scenes::cases().into_iter().map(|case| Start::new(case.id(), move || case.spec())).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let mut cases = scenes::cases();
    cases.retain(|case| !context.quick || case.is_quick());
    let mut settings = prepared(context, "rest shapes", &cases, Setting::new)?;
    let mut runs = shoot(context, &settings)?;
    for (setting, runs) in settings.iter_mut().zip(&mut runs) {
        setting.learn(runs);
    }
    let timings = clock(context, &settings, &runs)?;
    let runs = runs.concat();
    let scenes = settings.iter().map(|s| (s.scene.id.clone(), s.hash.clone())).collect();
    let facts = Facts { scenes: settings.into_iter().map(|s| s.scene).collect(), runs };
    Ok(Measured { facts, timings, scenes, seed: Some(scenes::SEED) })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let scenes = facts.scenes.iter().map(|scene| fact(scene.id.clone(), scene.portable, scene));
    let runs = facts.runs.iter().map(|run| {
        let key = format!("{}, {}, ×{}", run.scene, run.label, run.steps);
        let mut fact = fact(key, run.portable, run);
        if !run.portable
            && let serde_json::Value::Object(values) = &mut fact.values
        {
            // If a library's functions rounded, it is not repeatable where cloth buckles.
            values.retain(|key, value| value.is_string() && key != "verdict");
        }
        fact
    });
    scenes.chain(runs).collect()
}
