//! Tests of each branch of the words, with small facts.

use super::*;

fn scene(id: &str, stiffness_over_mass_per_s2: f64) -> Scene {
    Scene {
        id: id.to_owned(),
        stiffness_over_mass_per_s2,
        particles: 4,
        step_s: 0.01,
        duration_s: 2.0,
        compared_s: 1.0,
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

fn run(scene: &str, motion: Option<f64>, modelled_s: f64) -> Run {
    Run {
        scene: scene.to_owned(),
        settings: String::new(),
        verdict: if motion.is_some() { Verdict::Stable } else { Verdict::Diverged },
        reached_s: 2.0,
        steps: 200,
        retained_motion: motion,
        height_error_m: None,
        energy_gain: None,
        energy_change: None,
        greatest_stretch: None,
        force_evaluations: 200,
        matvecs: 0,
        cg_iterations: 0,
        newton_iterations: 0,
        factorisations: 0,
        modelled_s,
        height_m: vec![0.0],
        portable: true,
    }
}

/// A lesson with its motion and its work on a soft and on a stiff sheet.
fn lesson(id: &str, soft: (Option<f64>, f64), stiff: (Option<f64>, f64)) -> Lesson {
    Lesson {
        id: id.to_owned(),
        title: id.to_owned(),
        method: id.to_owned(),
        docs: String::new(),
        idea: String::new(),
        before: None,
        finding: String::new(),
        runs: vec![run("soft", soft.0, soft.1), run("stiff", stiff.0, stiff.1)],
    }
}

fn facts(lessons: Vec<Lesson>) -> Facts {
    let scenes = vec![scene("soft", 1e4), scene("stiff", 1e6)];
    Facts { scenes, lessons, headline: Vec::new(), support: Vec::new() }
}

#[test]
fn no_facts_still_conclude_something() {
    let facts = Facts { scenes: Vec::new(), ..facts(Vec::new()) };
    let words = words(&facts);
    assert!(words.conclusion.contains("no run") && words.observations.is_empty());
}

#[test]
fn words_and_the_table_name_who_is_stable_who_moves_and_what_it_costs() {
    let divided = Lesson {
        method: "divided:step=bound".to_owned(),
        ..lesson("divided", (Some(1.0), 3e-3), (Some(1.0), 4e-3))
    };
    let facts = facts(vec![
        lesson("wild", (Some(1.0), 1e-3), (None, 1e-3)),
        lesson("still", (Some(0.95), 2e-3), (Some(0.08), 1e-3)),
        lesson("dear", (Some(1.0), 5e-3), (Some(0.9), 9e-3)),
        divided,
    ]);
    let words = words(&facts);
    let said = words.conclusion;
    for part in [
        "With steps of 0.01 s, 3 of 4 methods are stable at k/m = 10⁴ and 10⁶ s⁻².",
        "Of these, 2 keep at least 90 % of the motion: dear, divided.",
        "On the stiffest sheet, divided keeps this much with the least work.",
    ] {
        assert!(said.contains(part), "`{part}` is not in\n{said}");
    }
    let said = words.observations.join("\n");
    for part in [
        "1 method is not stable at every stiffness: wild.",
        "still keeps only 8.0 % of the motion",
        "At k/m = 10⁴ s⁻², methods that move take from 1.00 ms (wild) to 5.00 ms (dear)",
        "At k/m = 10⁶ s⁻², methods that move take from 4.00 ms (divided) to 9.00 ms (dear)",
    ] {
        assert!(said.contains(part), "`{part}` is not in\n{said}");
    }
    let said = words.caveats.join("\n");
    assert!(said.contains("the steps of divided are") && said.contains("1.0·10⁻⁵ m"), "{said}");

    let input = super::super::plates::Input { facts, timings: None };
    let tables = super::super::plates::tables(&input);
    let work = tables.iter().find(|table| table.title.contains("**Work of")).expect("a table");
    let order: Vec<_> = work.rows.iter().map(|row| row[1].as_str()).collect();
    assert_eq!(order, ["wild", "still", "divided", "dear", "divided", "dear"]);
}

#[test]
fn the_conclusion_says_where_no_method_moves() {
    let words = words(&facts(vec![lesson("still", (Some(0.95), 2e-3), (Some(0.08), 1e-3))]));
    assert!(words.conclusion.contains("None keeps at least 90 %"), "{}", words.conclusion);
    assert!(!words.conclusion.contains("least work"));
    let six = ["a", "b", "c", "d", "e", "f"];
    let six = six.map(|id| lesson(id, (Some(1.0), 1e-3), (Some(1.0), 1e-3)));
    let said = super::words(&facts(six.into())).conclusion;
    assert!(said.contains("Of these, 6 keep at least 90 % of the motion."), "{said}");
}
