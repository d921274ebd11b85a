//! Tests of each branch of the words, with small facts.

use super::*;

/// A picture of one particle at a height (m).
fn shot(label: &str, time_s: f64, height: Option<f64>) -> Shot {
    Shot {
        series: METHODS.to_owned(),
        scene: "sheet".to_owned(),
        label: label.to_owned(),
        method: label.to_owned(),
        step_s: STEP,
        time_s,
        diverged_at_s: if height.is_none() { Some(0.06) } else { None },
        position_m: height.map_or_else(Vec::new, |height| vec![0.0, 0.0, height]),
        portable: true,
    }
}

fn facts(shots: Vec<Shot>) -> Facts {
    let scene = Scene {
        id: "sheet".to_owned(),
        rows: 1,
        columns: 1,
        stiffness_over_mass_per_s2: 1e6,
        table: None,
        portable: true,
    };
    Facts { scenes: vec![scene], shots }
}

#[test]
fn a_record_without_methods_still_concludes_something() {
    let paper = Shot { series: PAPER.to_owned(), ..shot("textile", 1.0, Some(-1.0)) };
    for shots in [Vec::new(), vec![paper]] {
        let words = words(&facts(shots));
        assert!(words.conclusion.contains("compares no methods"), "{}", words.conclusion);
        assert!(words.observations.is_empty() && words.caveats.len() == 1);
    }
}

#[test]
fn words_and_the_table_tell_who_diverges_who_falls_and_who_hangs() {
    let facts = facts(vec![
        shot(REFERENCE, 0.2, Some(-0.2)),
        shot(REFERENCE, 1.0, Some(-0.3)),
        shot("wild", 0.2, None),
        shot("wild", 1.0, None),
        shot("still", 0.2, Some(-0.02)),
        shot("still", 1.0, Some(-0.1)),
        shot("timely", 0.2, Some(-0.2)),
        shot("timely", 1.0, Some(-0.3)),
        shot("loose", 0.2, Some(-0.22)),
        shot("loose", 1.0, Some(-2.7)),
    ]);
    let words = words(&facts);
    let said = words.conclusion;
    assert!(
        said.contains("1 of 4 methods diverges within 1 s on a sheet of k/m = 10⁶ s⁻²"),
        "{said}"
    );
    assert!(said.contains("After 0.2 s, 2 other methods have fallen at least 90 %"), "{said}");
    assert!(said.contains("1 less than 50 %, and"), "{said}");
    let said = words.observations.join("\n");
    for part in
        ["diverge: `wild`.", "the reference: `still`.", "at 1 s, `loose` has fallen 9.0 times"]
    {
        assert!(said.contains(part), "`{part}` is not in\n{said}");
    }
    let input = super::super::plates::Input { facts, timings: None };
    let falls = &super::super::plates::tables(&input)[0];
    let lines: Vec<_> = falls.rows.iter().map(|row| row.join("; ")).collect();
    assert_eq!(lines, ["loose; 110; 900", "timely; 100; 100", "still; 10.0; 33.3", "wild; ✗; ✗"]);
}
