//! Experiment `pictures`: pictures of the cloth (EEH figure 4).

use crate::facts::{Fact, fact};
use crate::methods::{self, Choice};
use crate::run::Runner;
use crate::scenes::{build, bundled};
use crate::studies::pictures::facts::{Facts, METHODS, PAPER, REFERENCE, STEP, Scene, Shot, Table};
use crate::studies::{Context, Measured, Start, cells, prepared};
use crate::{HarnessError, system_hash};
use drape_model::{Cloth, ObstacleSpec, SpringLaw, State, System, TimeSpan};
use std::collections::BTreeMap;

const TABLE: &str = "square-table-2704-1e6";
const HANGING: &str = "hanging-textile-sheared-1e4";
const STIFF: &str = "hanging-textile-1e6";
/// Stiffness over mass, 1/s², and damping over mass, 1/s, of the shear springs that the tablecloth
/// gets. With springs along warp and weft alone, its corners would collapse into strips.
const SHEAR: [f64; 2] = [1e4, 4.0];
const BENDING: [f64; 2] = [2e3, 1.0];
/// Step of leapfrog for pictures of the true motion, s: well below its limit.
const FINE: f64 = 2e-4;
const FINE_METHOD: &str = "leapfrog";
/// Positions are rounded to this fraction of a metre.
const PARTS: f64 = 1e5;
/// Time by which the sum of the steps may fall short of a picture's time by round-off, s.
const EARLY: f64 = 1e-9;

/// A run whose pictures are taken at some times, s.
#[derive(Clone, Debug)]
struct Case {
    series: &'static str,
    scene: &'static str,
    label: String,
    method: String,
    step: f64,
    times: &'static [f64],
}

fn cases(is_quick: bool) -> Vec<Case> {
    let fine = |series, scene, label: &str, times| Case {
        series,
        scene,
        label: label.to_owned(),
        method: FINE_METHOD.to_owned(),
        step: FINE,
        times,
    };
    let hanging = fine(PAPER, HANGING, "hanging textile", &[1.0]);
    if is_quick {
        return vec![hanging];
    }
    let times = &[0.2, 0.4, 0.6, 1.0];
    let mut cases = vec![
        fine(PAPER, TABLE, "square table", &[0.1, 0.25, 1.0]),
        hanging,
        fine(METHODS, STIFF, REFERENCE, times),
    ];
    cases.extend(methods::all().map(|method| Case {
        series: METHODS,
        scene: STIFF,
        label: method.id.to_owned(),
        method: method.id.to_owned(),
        step: STEP,
        times,
    }));
    cases
}

/// The scene that is drawn, by the name of its bundled scene.
fn stage(name: &str) -> Result<drape_model::Scene, HarnessError> {
    let mut scene = bundled(name)?;
    if name == TABLE {
        let law = |[stiffness, damping]: [f64; 2]| SpringLaw {
            stiffness_over_mass_per_s2: Some(stiffness),
            damping_over_mass_per_s: Some(damping),
            ..SpringLaw::default()
        };
        scene.effects.shear = Some(law(SHEAR));
        scene.effects.bending = Some(law(BENDING));
    }
    Ok(scene)
}

/// The record of a scene, with the scene's hash.
fn scene(name: &str) -> Result<(Scene, String), HarnessError> {
    let scene = stage(name)?;
    let (spec, _) = build(&scene)?;
    let (rows, columns) = match &scene.cloth {
        Cloth::Grid(grid) => (grid.rows, grid.columns),
        Cloth::Mesh(_) | Cloth::Particles(_) => (1, spec.particles.mass_kg.len() as u32),
    };
    let table = scene.obstacles.iter().find_map(|obstacle| match *obstacle {
        ObstacleSpec::Box { center_m, size_m, .. } => Some(Table { center_m, size_m }),
        _ => None,
    });
    let tension = scene.effects.tension.as_ref();
    let stiffness = tension.and_then(|law| law.stiffness_over_mass_per_s2).unwrap_or_default();
    let record = Scene {
        id: name.to_owned(),
        rows,
        columns,
        stiffness_over_mass_per_s2: stiffness,
        table,
        portable: true,
    };
    Ok((record, system_hash(&spec)))
}

/// Positions to draw, rounded.
fn rounded(system: &System, state: &State) -> Vec<f64> {
    let shown = system.display_positions(&state.x, state.t);
    let coordinates = shown.iter().flat_map(|x| [x.x, x.y, x.z]);
    // Adding 0 turns a negative zero into a positive one.
    coordinates.map(|c| (c * PARTS).round() / PARTS + 0.0).collect()
}

/// The pictures of a run.
fn shots(case: &Case) -> Result<Vec<Shot>, HarnessError> {
    let (_, mut simulation) = build(&stage(case.scene)?)?;
    let choice = Choice::parse(&case.method, &[])?;
    let duration_s = case.times.iter().copied().fold(0.0, f64::max);
    let time = TimeSpan { step_s: case.step, duration_s };
    let mut taken: Vec<Option<Vec<f64>>> = vec![None; case.times.len()];
    let runner = Runner::new(&choice, time).observe(|moment| {
        let (system, state) = (moment.system, moment.state);
        for (taken, &due) in taken.iter_mut().zip(case.times) {
            if taken.is_none() && state.t >= due - EARLY && state.is_finite() {
                *taken = Some(rounded(system, state));
            }
        }
    });
    let outcome = runner.go(&mut simulation)?;
    let diverged_at_s = outcome.divergence.map(|divergence| divergence.time);
    let shots = case.times.iter().zip(taken).map(|(&time_s, taken)| {
        let is_lost = diverged_at_s.is_some_and(|t| time_s >= t - EARLY);
        Shot {
            series: case.series.to_owned(),
            scene: case.scene.to_owned(),
            label: case.label.clone(),
            method: choice.full_id(),
            step_s: case.step,
            time_s,
            diverged_at_s,
            position_m: taken.filter(|_| !is_lost).unwrap_or_default(),
            portable: choice.is_portable(),
        }
    });
    Ok(shots.collect())
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "The paper shows a table cloth that drapes over a square table and a textile held at two \
         corners, without sizes and times. Here the bundled scenes `{TABLE}` (row 4 of table 2, \
         with shear springs of k/m = {} s⁻² and bending springs of {} s⁻² added) and `{HANGING}` \
         move by {FINE_METHOD} with h = {FINE} s, well below its limit. These two pictures show \
         the equations, not a method. The methods move the sheet of `{STIFF}` (20 × 20 particles, \
         k/m = 10⁶ s⁻², d/m = 40 s⁻¹, released flat) at their default settings. Their step is h = \
         {STEP} s, ten times the step of the paper's table; the reference is {FINE_METHOD} with h \
         = {FINE} s. Pictures show the displayed positions, which lie outside of obstacles, \
         rounded to 1e-5 m.",
        SHEAR[0], BENDING[0]
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let start = |name: &'static str| Start::new(name, move || Ok(stage(name)?.discretise()?));
    [TABLE, HANGING, STIFF].map(start).into()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let cases = cases(context.quick);
    let mut names: Vec<&str> = cases.iter().map(|case| case.scene).collect();
    names.dedup();
    let scenes = prepared(context, "scenes", &names, |name| scene(name))?;
    let shots = cells(context, "runs", &cases, shots)?.all()?.concat();
    let hashes: BTreeMap<_, _> =
        scenes.iter().map(|(scene, hash)| (scene.id.clone(), hash.clone())).collect();
    let facts = Facts { scenes: scenes.into_iter().map(|(scene, _)| scene).collect(), shots };
    let (facts, scenes, seed) = (facts, hashes, None);
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// The part of a run that is compared if its bits depend on the machine. Round-off may change a
/// rounded position.
#[derive(serde::Serialize)]
struct Verdict {
    has_diverged: bool,
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let Facts { scenes, shots } = facts;
    let scenes = scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), scene.portable, scene));
    let shots = shots.iter().map(|shot| {
        let key = format!("{} {} {} at {} s", shot.series, shot.scene, shot.label, shot.time_s);
        if shot.portable {
            return fact(key, true, shot);
        }
        fact(key, false, &Verdict { has_diverged: shot.diverged_at_s.is_some() })
    });
    scenes.chain(shots).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::super::facts::fall;
    use super::*;

    #[test]
    fn a_run_that_diverges_has_no_picture_from_then_on_and_others_have_all() {
        let case = |method: &str| Case {
            series: METHODS,
            scene: STIFF,
            label: method.to_owned(),
            method: method.to_owned(),
            step: STEP,
            times: &[0.01, 0.1],
        };
        let good = shots(&case("imex-euler")).unwrap();
        assert!(good.iter().all(|shot| shot.position_m.len() == 3 * 400));
        assert!(fall(&good[1]).unwrap() > fall(&good[0]).unwrap());
        let bad = shots(&case("explicit-euler")).unwrap();
        let at = bad[1].diverged_at_s.unwrap();
        assert!(at > 0.01 && at <= 0.1, "{at}");
        assert_eq!([bad[0].position_m.len(), bad[1].position_m.len()], [1200, 0]);
    }

    #[test]
    fn recorded_positions_are_rounded_and_read_back() {
        let (_, simulation) = build(&stage(TABLE).unwrap()).unwrap();
        let rounded = rounded(&simulation.system, &simulation.state);
        let exact = simulation.state.x.iter().flat_map(|x| [x.x, x.y, x.z]);
        for (rounded, exact) in rounded.iter().zip(exact) {
            assert!((rounded - exact).abs() <= 0.5001e-5 && rounded.to_string().len() <= 8);
        }
    }
}
