use super::additions::{all, scene};
use super::*;
use crate::studies::effects::facts::holds;
use drape_report::Verdict;
use serde_json::json;

fn variant(name: &str) -> Variant {
    let addition = all().into_iter().find(|addition| addition.name == name);
    Variant::new(&addition.expect("a known addition")).expect("a valid scene")
}

#[test]
fn every_addition_is_a_valid_scene_that_differs_from_the_bare_one() {
    let hashes: Vec<_> = all()
        .iter()
        .map(|addition| system_hash(&scene(addition.name, &addition.adds).expect("a valid scene")))
        .collect();
    for (n, hash) in hashes.iter().enumerate() {
        assert!(!hashes[..n].contains(hash), "{}", all()[n].name);
    }
}

#[test]
fn all_together_is_every_addition_but_those_whose_place_another_holds() {
    let all = all();
    let everything = &all.last().expect("some").adds;
    for addition in &all[1..all.len() - 1] {
        let found = holds(everything, &addition.adds);
        // A gusting wind has both keys.
        let is_part = addition.holder.is_none()
            || ["drag in still air", "steady wind"].contains(&addition.name);
        assert_eq!(found, is_part, "{}", addition.name);
        let holder = addition.holder.filter(|holder| *holder != "tension springs");
        assert!(holder.is_none_or(|holder| all.iter().any(|a| a.name == holder)), "{holder:?}");
    }
}

#[test]
fn an_addition_that_no_scene_knows_is_an_error_that_names_the_key() {
    let error = scene("x", &json!({ "effects": { "magic": 1 } })).expect_err("unknown").to_string();
    assert!(error.contains("effects.magic"), "{error}");
}

#[test]
fn nothing_more_changes_nothing_and_a_sphere_in_the_way_moves_the_sheet() {
    let (nothing, sphere) = (variant(NOTHING), variant("sphere"));
    let imex = methods::all().find(|method| method.id == "imex-euler").expect("known");
    let cell = nothing.cell(&nothing, imex).expect("a run");
    assert_eq!((cell.verdict, cell.steps, cell.change_m), (Verdict::Completed, 50, Some(0.0)));
    let cell = sphere.cell(&nothing, imex).expect("a run");
    assert!(cell.change_m.expect("completed") > 0.01, "{cell:?}");
}

#[test]
fn an_obstacle_out_of_reach_changes_no_bit_and_no_count() {
    let (nothing, far) = (variant(NOTHING), variant("obstacle out of reach"));
    for id in timed_methods() {
        let method = methods::all().find(|method| method.id == id).expect("known");
        let (bare, with) = (nothing.cell(&nothing, method), far.cell(&nothing, method));
        let (bare, with) = (bare.expect("a run"), with.expect("a run"));
        assert_eq!(with.change_m, Some(0.0), "{id}");
        assert_eq!((with.cg_iterations, with.matvecs), (bare.cg_iterations, bare.matvecs), "{id}");
    }
}

#[test]
fn only_springs_enter_the_scalar_matrix_and_only_forces_between_particles_any() {
    let nothing = variant(NOTHING).effect;
    let bare = (nothing.objects, nothing.springs, nothing.coupled_pairs);
    for addition in all() {
        let effect = variant(addition.name).effect;
        let more = (effect.objects, effect.springs, effect.coupled_pairs);
        let keys = addition.adds["effects"].as_object();
        let new = keys.into_iter().flatten().filter(|(key, _)| *key != "tension");
        let new: Vec<_> = new.map(|(key, _)| key.as_str()).collect();
        // Air couples the corners of triangles. These are neighbours or lie across a cell.
        let objects = bare.0 + new.len();
        let springs = match addition.name {
            "shear springs" => bare.1 + 2 * 19 * 19,
            "bending springs" | "bending springs that buckle" => bare.1 + 2 * 18 * 20,
            EVERYTHING => bare.1 + 2 * 19 * 19 + 2 * 18 * 20,
            _ => bare.1,
        };
        assert_eq!((more.0, more.1), (objects, springs), "{}", addition.name);
        assert_eq!(more.2 > bare.2, !new.is_empty(), "{}", addition.name);
    }
}

#[test]
fn an_unnamed_effect_is_not_in_the_system_at_all() {
    let system = |name: &str| {
        let addition = all().into_iter().find(|addition| addition.name == name);
        let spec = scene(name, &addition.expect("a known addition").adds).expect("a valid scene");
        spec.build().expect("a valid system").0
    };
    let names = |name: &str| -> Vec<&str> {
        system(name).effects().map(drape_model::Effect::name).collect()
    };
    assert_eq!(names(NOTHING), ["tension", "gravity"]);
    assert_eq!(names("sphere"), ["tension", "gravity"]);
    assert_eq!(names("gusting wind"), ["tension", "gravity", "air"]);
    assert_eq!(names("bending over hinges"), ["tension", "bending_hinge", "gravity"]);
    assert!(system(NOTHING).obstacles().is_empty() && system(NOTHING).moving_pins().is_empty());
}
