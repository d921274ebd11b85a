//! Tests of the scenes, of their noise, and of errors that fall with the step.

use super::cases::{Case, Damping, Stage, cases};
use super::*;
use crate::studies::trajectory::facts::{Flaw, PICTURE_S, Run};
use drape_model::Vec3;
use drape_report::Verdict;

fn stage(stiffness: f64, damping: Damping) -> Stage {
    Stage::new(&Case { stiffness, damping }).expect("a valid scene")
}

#[test]
fn every_stiffness_has_every_damping_once_and_one_is_quick() {
    let cases = cases();
    assert_eq!(cases.len(), 30);
    for (n, case) in cases.iter().enumerate() {
        assert!(!cases[..n].contains(case), "{case:?}");
    }
    assert_eq!(cases.iter().filter(|case| case.is_quick()).count(), 1);
}

/// At the start, power iteration on the springs gives the stiffest mode of a sheet. Its damping
/// ratio is the one in the scene's name.
#[test]
fn the_damping_ratio_is_that_of_the_stiffest_mode() {
    for (stiffness, ratio) in [(1e2, 0.01), (1e6, 0.1), (1e10, 1.0)] {
        let case = Case { stiffness, damping: Damping::Ratio(ratio) };
        let spec = case.spec().expect("a valid scene");
        let (system, state) = spec.build().expect("a valid scene");
        let masses = &spec.particles.mass_kg;
        let apply = |x: &[Vec3], along: bool| {
            let mut y = vec![Vec3::zeros(); x.len()];
            for spring in &spec.springs {
                let (i, j) = (spring.i as usize, spring.j as usize);
                let n = (state.x[i] - state.x[j]).normalize();
                let apart = x[i] - x[j];
                let force = if along {
                    n * (spring.stiffness_n_per_m * n.dot(&apart))
                } else {
                    apart * spring.damping_n_s_per_m
                };
                y[i] += force / masses[i];
                y[j] -= force / masses[j];
            }
            for (y, is_pinned) in y.iter_mut().zip(system.pinned()) {
                if *is_pinned {
                    *y = Vec3::zeros();
                }
            }
            y
        };
        let dot = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
        let mut random = drape_oracle::Random::new(1);
        let mut draw = || random.between(-1.0, 1.0);
        let mut mode: Vec<Vec3> =
            state.x.iter().map(|_| Vec3::new(draw(), draw(), draw())).collect();
        for _ in 0..2000 {
            let next = apply(&mode, true);
            let length = dot(&next, &next).sqrt();
            mode = next.iter().map(|y| y / length).collect();
        }
        let square = dot(&mode, &apply(&mode, true));
        let damping = dot(&mode, &apply(&mode, false));
        let measured = damping / (2.0 * square.sqrt());
        assert!((measured / ratio - 1.0).abs() < 0.05, "{case:?}: {measured}");
    }
}

/// Noise comes from the starts. Damping removes it, and on a soft sheet it is far below the motion.
#[test]
fn noise_is_small_on_soft_sheets_and_errors_of_all_kinds_fall_with_the_step() {
    let Stage { scene, setting } = stage(1e2, Damping::Ratio(1.0));
    assert!(scene.floor > 1e-7 && scene.floor < 1e-4, "{scene:?}");
    assert!(scene.reference_error < 0.01 * scene.floor, "{scene:?}");
    assert!(scene.dissipated > 0.0 && scene.released_j > 0.0, "{scene:?}");
    assert!(scene.ranks(1e-3) && !scene.ranks(scene.floor));
    let form = |label: &str| forms().find(|form| form.label == label).expect("a known form");
    for label in ["symplectic-euler", "baraff-witkin"] {
        let row = setting.row(form(label), Some(QUICK)).expect("runs");
        let runs: Vec<&Run> = row.runs.iter().filter(|run| run.beside.is_some()).collect();
        let (first, last) = (runs[0], runs[runs.len() - 1]);
        assert!(runs.len() > 2 && last.verdict == Verdict::Completed, "{label}: {row:?}");
        let errors = |run: &Run| {
            let beside = run.beside.expect("errors");
            [run.error.expect("an error"), beside.shape_m, beside.energy.abs()]
        };
        for (n, (coarse, fine)) in errors(first).into_iter().zip(errors(last)).enumerate() {
            assert!(fine < 0.5 * coarse, "{label} {n}: {coarse} {fine}");
        }
        let kept = last.beside.expect("errors").retained;
        assert!((kept - 1.0).abs() < 0.05, "{label}: {kept}");
        // Linearised backward Euler dissipates energy.
        assert!(label != "baraff-witkin" || last.beside.expect("errors").energy < 0.0, "{last:?}");
    }
}

/// A run that equals one of the noisy motions has no error, although it differs from the motion
/// without noise.
#[test]
fn a_run_is_held_against_the_nearest_true_motion() {
    let Stage { scene, setting } = stage(1e4, Damping::OverMass(0.0));
    let ends = setting.true_ends();
    assert_eq!(ends.len(), scene.members);
    for end in ends {
        assert_eq!(setting.error(end), 0.0);
    }
    let start = setting.simulation.state.x.clone();
    assert!((setting.error(&start) - 1.0).abs() < 1e-3);
}

/// On a soft sheet the cubic through the states at the ends of long steps shows the true motion: the
/// pictures come in their order and at their time.
#[test]
fn pictures_within_long_steps_are_those_of_the_motion() {
    let Stage { scene, mut setting } = stage(1e2, Damping::OverMass(10.0));
    (setting.enough, setting.fewest) = (0.0, 1);
    let form = forms().find(|form| form.label == "midpoint").expect("a known form");
    let row = setting.row(form, Some(QUICK)).expect("runs");
    for (steps, most) in [(1.0, 3e-3), (2.0, 6e-4), (4.0, 2e-4), (8.0, 5e-5)] {
        let run = row.runs.iter().find(|run| run.value == steps).expect("a run");
        let beside = run.beside.expect("errors");
        assert!(beside.shape_m < most * scene.motion_m, "{steps}: {beside:?}");
        assert!((beside.retained - 1.0).abs() < 1e-6, "{steps}: {beside:?}");
        let skips = (steps < 8.0).then_some(Flaw::SkipsPictures);
        assert_eq!(run.flaw, skips, "{steps}");
    }
}

/// `rkc` is explicit and stable at any step, so it begins where implicit methods do.
#[test]
fn stabilised_methods_begin_like_implicit_ones() {
    let Stage { setting, .. } = stage(1e4, Damping::OverMass(40.0));
    let first = |label: &str| {
        let form = forms().find(|form| form.label == label).expect("a known form");
        setting.row(form, Some(QUICK)).expect("runs").runs[0].value
    };
    assert_eq!((first("rkc"), first("bdf2")), (1.0, 1.0));
    assert!(first("symplectic-euler") > 8.0);
}

/// A row with one run of these steps, counts of sweeps and modelled time.
fn row(scene: &str, method: &str, steps: u32, sweeps: u64, modelled_s: f64) -> Row {
    let step_s = 0.25 / f64::from(steps);
    let run = Run {
        // Equal runs of two methods are not ranked.
        error: Some(1e-3 + 1e-9 * modelled_s),
        flaw: (step_s > PICTURE_S).then_some(Flaw::SkipsPictures),
        modelled_s,
        effort: 1.0,
        steps: u64::from(steps),
        force_evaluations: sweeps,
        ..Run::uncounted(f64::from(steps), Some(step_s), Verdict::Completed)
    };
    Row {
        scene: scene.to_owned(),
        label: method.to_owned(),
        method: method.to_owned(),
        knob: "steps".to_owned(),
        is_headline: false,
        runs: vec![run],
    }
}

/// One sheet where a long step is cheapest; by price, one where the sweeps that cost least are not
/// those with the least modelled time in the record.
#[test]
fn winners_are_compared_with_those_of_other_rules() {
    let Stage { scene, .. } = stage(1e2, Damping::OverMass(10.0));
    let mut other = scene.clone();
    other.id = "other".to_owned();
    let rows = vec![
        row(&scene.id, "bdf2", 1, 1, 1e-4),
        row(&scene.id, "symplectic-euler", 16, 16, 1e-3),
        row(&scene.id, "bdf2", 16, 40, 1.5e-3),
        row(&other.id, "symplectic-euler", 64, 1000, 1e-3),
        row(&other.id, "bdf2", 16, 16, 5e-3),
    ];
    let winners = [&scene.id, &other.id].map(|id| front::winner(id, &rows, 1e-2)).to_vec();
    let named: Vec<_> = winners.iter().map(|winner| winner.label.as_deref()).collect();
    assert_eq!(named, [Some("symplectic-euler"); 2]);
    let facts = Facts { scenes: vec![scene, other], rows, winners };
    // With longer steps the first sheet has another winner, which tied; the second has the same.
    assert_eq!(with_longer_steps(&facts), Agreement { winners: 2, same: 1, tied: 1 });
    // By their counts the second sheet is won by the other method, which did not tie.
    let agreement = by_other_prices(&facts, crate::cost::prices());
    assert_eq!((agreement.winners, agreement.tied), (2, 0), "{agreement:?}");
    assert!(agreement.same < 2, "{agreement:?}");
}
