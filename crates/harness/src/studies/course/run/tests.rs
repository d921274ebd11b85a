//! Tests that the lessons agree with their measurements.

use super::*;
use drape_report::Verdict;

fn setting() -> Result<Setting, HarnessError> {
    Setting::new(&QUICK)
}

fn plan(id: &str) -> &'static Plan {
    LESSONS.iter().find(|plan| plan.id() == id).expect("a lesson")
}

fn scene() -> Scene {
    Scene {
        id: "sheet".to_owned(),
        stiffness_over_mass_per_s2: 1e4,
        particles: 4,
        step_s: STEP,
        duration_s: DURATION,
        compared_s: COMPARED,
        released_energy_j: 1.0,
        time_s: vec![0.0],
        height_m: vec![0.0],
        path_m: 3.0,
        energy_change: -0.5,
        greatest_stretch: 0.1,
        reference_step_s: 1e-4,
        reference_error_m: 1e-5,
        portable: true,
    }
}

fn stable_run() -> Run {
    Run {
        scene: "sheet".to_owned(),
        settings: "method".to_owned(),
        verdict: Verdict::Stable,
        reached_s: 2.0,
        steps: 200,
        retained_motion: Some(1.0),
        height_error_m: Some(0.01),
        energy_gain: Some(0.0),
        energy_change: Some(-0.5),
        greatest_stretch: Some(0.1),
        force_evaluations: 200,
        matvecs: 0,
        cg_iterations: 0,
        newton_iterations: 0,
        factorisations: 0,
        modelled_s: 1e-3,
        height_m: vec![0.0],
        portable: true,
    }
}

/// The shortcoming that the next lesson finds in a lesson with this run.
fn said_of(run: Run) -> String {
    let scenes = [scene()];
    let first = super::super::words::lesson(plan("explicit-euler"), "", vec![run], &scenes, None);
    assert_eq!(first.before, None);
    let next =
        super::super::words::lesson(plan("provot"), "", vec![stable_run()], &scenes, Some(&first));
    next.before.unwrap_or_default()
}

#[test]
fn the_gravest_shortcoming_is_named_first() {
    let good = stable_run;
    assert!(said_of(good()).contains("lacks nothing"));
    let off = Run { height_error_m: Some(0.2), ..good() };
    assert!(said_of(off.clone()).contains("0.200 m off its true height"));
    let dear = Run { factorisations: 400, ..off };
    assert!(said_of(dear.clone()).contains("400 factorisations"));
    let slack = Run { greatest_stretch: Some(0.5), ..dear };
    assert!(said_of(slack.clone()).contains("stretch by 50.0 % (truly 10.0 %)"));
    let locked = Run { retained_motion: Some(0.08), ..slack };
    assert!(said_of(locked).contains("all but stands still (only 8.00 %"));
    let diverged = Run {
        verdict: Verdict::Diverged,
        reached_s: 0.37,
        retained_motion: None,
        height_error_m: None,
        greatest_stretch: None,
        ..good()
    };
    assert!(said_of(diverged).contains("it diverged after 0.370 s at k/m = 1e4/s²"));
}

#[test]
fn every_method_of_the_headline_has_a_lesson_and_no_method_has_two() -> Result<(), HarnessError> {
    let mut ids = Vec::new();
    for plan in &LESSONS {
        ids.push(Choice::parse(plan.method, &[])?.method().id);
    }
    assert!(HEADLINE.iter().all(|id| ids.contains(id)), "{ids:?}");
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), LESSONS.len());
    Ok(())
}

#[test]
fn every_support_that_a_method_states_stands_in_the_matrix() {
    let rows = support();
    assert_eq!(rows.len(), methods::all().count());
    for (method, row) in methods::all().zip(&rows) {
        let stated = row.effects.iter().filter(|(_, treatment)| treatment != "refused").count();
        assert_eq!((row.method.as_str(), stated), (method.id, method.supports().count()));
    }
}

#[test]
fn leapfrog_follows_the_true_motion_and_explicit_euler_diverges() -> Result<(), HarnessError> {
    let setting = setting()?;
    assert!(setting.scene.reference_error_m < 2e-3, "{}", setting.scene.reference_error_m);
    let run = setting.run(plan("leapfrog"))?;
    assert_eq!(run.verdict, Verdict::Stable);
    assert!((run.retained_motion.unwrap_or_default() - 1.0).abs() < 1e-3, "{run:?}");
    assert_eq!(run.height_m.len(), setting.scene.time_s.len());
    let run = setting.run(plan("explicit-euler"))?;
    assert_eq!((run.verdict, run.retained_motion), (Verdict::Diverged, None));
    assert!(run.reached_s < 1.0 && run.height_m.iter().all(|z| z.is_finite()), "{run:?}");
    Ok(())
}
