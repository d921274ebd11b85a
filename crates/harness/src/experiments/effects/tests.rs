use super::additions::{all, scene};
use super::*;
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
fn an_addition_that_no_scene_knows_is_an_error_that_names_the_key() {
    let error = scene("x", &json!({ "effects": { "magic": 1 } })).expect_err("unknown").to_string();
    assert!(error.contains("effects.magic"), "{error}");
}

#[test]
fn nothing_more_changes_nothing_and_a_sphere_in_the_way_moves_the_sheet() {
    let (nothing, sphere) = (variant(NOTHING), variant("sphere"));
    let imex = methods::all().find(|method| method.id == "imex-euler").expect("known");
    let cell = nothing.cell(&nothing, imex).expect("a run");
    assert_eq!((cell.verdict.as_str(), cell.steps, cell.change_m), ("completed", 50, Some(0.0)));
    let cell = sphere.cell(&nothing, imex).expect("a run");
    assert!(cell.change_m.expect("completed") > 0.01, "{cell:?}");
}

#[test]
fn an_obstacle_out_of_reach_changes_no_bit_and_no_count() {
    let (nothing, far) = (variant(NOTHING), variant("obstacle out of reach"));
    for id in TIMED {
        let method = methods::all().find(|method| method.id == id).expect("known");
        let (bare, with) = (nothing.cell(&nothing, method), far.cell(&nothing, method));
        let (bare, with) = (bare.expect("a run"), with.expect("a run"));
        assert_eq!(with.change_m, Some(0.0), "{id}");
        assert_eq!((with.cg_iterations, with.matvecs), (bare.cg_iterations, bare.matvecs), "{id}");
    }
}

#[test]
fn what_names_no_spring_leaves_both_matrices_as_they_are() {
    let nothing = variant(NOTHING).effect;
    for name in ["full damping", "projected damping", "obstacle out of reach", "sphere"] {
        let effect = variant(name).effect;
        assert_eq!(
            (effect.objects, effect.springs, effect.coupled_pairs),
            (nothing.objects, nothing.springs, nothing.coupled_pairs),
            "{name}"
        );
    }
    let shear = variant("shear springs").effect;
    assert_eq!(shear.objects, nothing.objects + 1);
    assert_eq!(shear.springs, nothing.springs + 2 * 19 * 19);
}
