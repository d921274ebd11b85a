//! A synthetic course of three lessons.

use super::record;
use drape_harness::studies::course::facts::{Facts, Lesson, Run, Scene, Support};
use drape_report::Record;
use drape_report::Verdict;

const LESSONS: [(&str, Verdict); 3] = [
    ("explicit-euler", Verdict::Diverged),
    ("leapfrog", Verdict::Stable),
    ("provot", Verdict::Unstable),
];

fn scene(id: &str, k_over_m: f64) -> Scene {
    let time_s: Vec<f64> = (0..=40).map(|n| 0.05 * f64::from(n)).collect();
    Scene {
        id: id.to_owned(),
        stiffness_over_mass_per_s2: k_over_m,
        particles: 400,
        step_s: 0.01,
        duration_s: 2.0,
        compared_s: 1.0,
        released_energy_j: 2.0,
        height_m: time_s.iter().map(|t| -0.5 + 0.5 * (3.0 * t).cos()).collect(),
        time_s,
        path_m: 2.7,
        energy_change: -0.5,
        greatest_stretch: 0.12,
        reference_step_s: 1e-4,
        reference_error_m: 1e-4,
        portable: true,
    }
}

fn run(scene: &Scene, verdict: Verdict) -> Run {
    let stable = |value: f64| (verdict == Verdict::Stable).then_some(value);
    let whole = |value: f64| (verdict != Verdict::Diverged).then_some(value);
    let heights = if verdict == Verdict::Diverged { 4 } else { 41 };
    Run {
        scene: scene.id.clone(),
        settings: "method".to_owned(),
        verdict,
        reached_s: 2.0,
        steps: 200,
        retained_motion: stable(0.95),
        height_error_m: stable(0.01),
        energy_gain: whole(0.1),
        energy_change: whole(-0.6),
        greatest_stretch: stable(0.11),
        force_evaluations: 200,
        matvecs: 0,
        cg_iterations: 12,
        newton_iterations: 0,
        factorisations: 0,
        modelled_s: 1.5e-3,
        height_m: scene.height_m.iter().take(heights).map(|z| 1.1 * z).collect(),
        portable: true,
    }
}

/// Three lessons, one of which is stable, on two scenes; `quick`: on one.
pub(crate) fn course(quick: bool) -> Record<Facts> {
    let mut scenes = vec![scene("soft", 1e4), scene("stiff", 1e6)];
    scenes.truncate(if quick { 1 } else { 2 });
    let lesson = |n: usize| Lesson {
        id: LESSONS[n].0.to_owned(),
        title: format!("{} <by name> & more", LESSONS[n].0),
        method: LESSONS[n].0.to_owned(),
        docs: "drape-explicit-euler".to_owned(),
        idea: "Forces at the old positions.".to_owned(),
        before: (n > 0).then(|| "It diverged.".to_owned()),
        finding: "At k/m = 1e4/s² it is measured.".to_owned(),
        runs: scenes.iter().map(|scene| run(scene, LESSONS[n].1)).collect(),
    };
    let lessons = (0..3).map(lesson).collect();
    let support = Support {
        method: "explicit-euler".to_owned(),
        effects: [("tension", "explicit"), ("wind", "refused")]
            .map(|(effect, treatment)| (effect.to_owned(), treatment.to_owned()))
            .into(),
    };
    let headline = vec!["explicit-euler".to_owned()];
    record("course", quick, Facts { scenes, lessons, headline, support: vec![support] })
}
