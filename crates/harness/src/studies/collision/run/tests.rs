//! Tests of moves by hand, of what runs measure, and of the findings.

use super::super::words::words;
use super::fall::{Stage, row, teleport};
use super::*;
use crate::studies::collision::facts::{Bounce, Row, factors};
use drape_model::{Obstacle, Shape, State, Vec3};
use drape_report::Verdict;

fn ball(restitution: f64) -> Obstacle {
    let shape = Shape::Sphere { center: Vec3::zeros(), radius: 1.0 };
    Obstacle { restitution, ..Obstacle::from(shape) }
}

#[test]
fn a_teleported_particle_lies_on_the_surface_and_leaves_it_by_the_restitution() {
    for (e, along) in [(0.0, -2.0), (0.5, -2.0), (1.0, -2.0), (0.5, 3.0)] {
        let mut state = State {
            t: 0.0,
            x: vec![Vec3::new(0.0, 0.6, 0.0), Vec3::new(0.0, 1.1, 0.0)],
            v: vec![Vec3::new(0.3, along, 0.1); 2],
        };
        assert_eq!(teleport(&ball(e), &mut state), 1, "the other one is outside");
        assert!((state.x[0] - Vec3::y()).norm() < 1e-15);
        let left = if along < 0.0 { -e * along } else { along };
        assert!((state.v[0] - Vec3::new(0.3, left, 0.1)).norm() < 1e-15, "e = {e}: {:?}", state.v);
        assert_eq!(state.v[1], Vec3::new(0.3, along, 0.1));
    }
}

fn middle() -> Stage {
    let case =
        Case { target: Target::Table, speed: 3.0, stiffness: 1e4, step: STEP, has_shear: true };
    Stage::new(&case).expect("a valid scene")
}

#[test]
fn every_way_out_meets_the_table_and_none_goes_deeper_than_a_step_leads() {
    let stage = middle();
    for form in FORMS.iter().filter(|form| form.label == "baraff-witkin") {
        let row = row(form, &stage).expect("runs");
        assert!(row.steps_before >= 5 && row.steps_after > 40, "{row:?}");
        assert!(row.depth_m > 1e-3 && row.depth_over_reach <= 1.0, "{row:?}");
        assert!(row.displayed_depth_m < 1e-12, "{row:?}");
        assert_eq!(row.teleports > 0, form.way_out == TELEPORT);
        assert_eq!(row.iterations_by_step.len() as u64, row.steps_before + row.steps_after);
        let iterations: u32 = row.iterations_by_step.iter().sum();
        assert_eq!(u64::from(iterations), row.iterations_before + row.iterations_after);
        assert_eq!(row.verdict, Verdict::Stable);
    }
}

#[test]
fn a_particle_leaves_with_its_restitution_however_it_gets_out() {
    for form in FORMS.iter().filter(|form| form.label.starts_with("ba")) {
        for target in [Target::Plane, Target::Sphere] {
            let case = bounce::Case { is_sheet: false, target, speed: 3.0, restitution: 0.5 };
            let bounce = bounce::bounce(form, &case).expect("runs");
            let measured = bounce.measured.expect("a contact");
            assert!((measured - 0.5).abs() < 1e-12, "{bounce:?}");
            assert_eq!(bounce.height_m.is_some(), target == Target::Plane);
        }
    }
}

fn synthetic(scene: &str, way_out: &str, iterations: u64) -> Row {
    Row {
        scene: scene.to_owned(),
        label: "some".to_owned(),
        way_out: way_out.to_owned(),
        method: "some".to_owned(),
        steps_before: 10,
        steps_after: 10,
        iterations_before: 10,
        iterations_after: iterations,
        iterations_by_step: Vec::new(),
        teleports: 0,
        depth_m: 0.01,
        depth_over_reach: 0.5,
        displayed_depth_m: 0.0,
        release_j: 0.0,
        climb_j: 0.0,
        gain: 0.0,
        unconverged_steps: 0,
        verdict: Verdict::Stable,
        portable: true,
    }
}

#[test]
fn factors_compare_a_way_out_with_the_constraint_on_the_same_scene() {
    let rows = vec![
        synthetic("a", VELOCITY, 20),
        synthetic("a", POSITION, 50),
        synthetic("b", VELOCITY, 40),
        synthetic("b", POSITION, 30),
        synthetic("c", POSITION, 1000),
    ];
    let unstable = Row { verdict: Verdict::Unstable, ..synthetic("d", POSITION, 1000) };
    let rows = rows.into_iter().chain([synthetic("d", VELOCITY, 20), unstable]).collect();
    let facts = Facts { scenes: Vec::new(), rows, bounces: Vec::new() };
    let factors = factors(&facts);
    assert_eq!(factors.len(), 1);
    assert_eq!((factors[0].label, factors[0].way_out, factors[0].unstable), ("some", POSITION, 1));
    assert_eq!(factors[0].by_scene, [(0.75, "b"), (2.5, "a")]);
    let said = words(&facts);
    let (conclusion, text) = (&said.conclusion, said.observations.join(" "));
    assert!(conclusion.contains("at least doubles the iterations"), "{conclusion}");
    assert!(conclusion.contains("constraint in 50 % of the runs"), "{conclusion}");
    assert!(text.contains("within the step takes 0.75 to 2.50 times"), "{text}");
    assert!(text.contains("takes 2.7 (some) to 2.7 times (some)"), "{text}");
    assert!(said.caveats[0].starts_with("1 run is not compared"), "{said:?}");
    let few = facts.rows.iter().filter(|row| row.scene == "b").cloned().collect();
    let few = Facts { scenes: Vec::new(), rows: few, bounces: Vec::new() };
    let conclusion = words(&few).conclusion;
    assert!(conclusion.contains("positions nowhere doubles the iterations"), "{conclusion}");
}

#[test]
fn words_tell_who_gains_energy_gets_deep_and_misses_the_restitution() {
    let wild = Row { verdict: Verdict::Unstable, ..synthetic("a", TELEPORT, 20) };
    let rows = vec![synthetic("a", VELOCITY, 20), wild];
    let bounce = Bounce {
        body: "particle".to_owned(),
        obstacle: "plane".to_owned(),
        label: "some".to_owned(),
        way_out: VELOCITY.to_owned(),
        method: "some".to_owned(),
        speed_m_s: 1.0,
        restitution: 0.5,
        measured: Some(0.5),
        height_m: Some(0.9),
        height_theory_m: Some(1.0),
        portable: true,
    };
    let mut facts = Facts { scenes: Vec::new(), rows, bounces: vec![bounce] };
    let said = words(&facts);
    let gained = "adds energy: 100 % of those runs gain some, against 0 % with the constraint";
    assert!(said.conclusion.contains(gained), "{said:?}");
    let text = said.observations.join(" ");
    for part in [
        "No particle penetrates",
        "no depth is visible",
        "1 of 1 rebounds meet",
        "off by up to 10 %",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    facts.rows[0].verdict = Verdict::Unstable;
    facts.rows[0].depth_over_reach = 1.5;
    facts.rows[0].displayed_depth_m = 0.25;
    facts.bounces[0].measured = Some(0.75);
    let said = words(&facts);
    assert!(said.conclusion.contains("adds energy no more often than the constraint"), "{said:?}");
    let text = said.observations.join(" ");
    for part in ["In 1 of 2 runs, a particle", "up to 0.25 m is visible", "1 of 1 rebounds misses"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
}
