//! Tests of the scenes, and of one case from end to end.

#![allow(clippy::unwrap_used, reason = "tests")]

use super::*;
use crate::studies::regret::facts::Outcome;

#[test]
fn every_scene_builds_has_its_size_and_moves() {
    let questions = questions();
    assert_eq!(questions.len(), 20);
    for question in &questions {
        let scene = question.scene;
        let spec = scene.spec().unwrap();
        let (system, state) = spec.build().unwrap();
        assert!(spec.pins.len() < spec.particles.mass_kg.len(), "{}", scene.name);
        let mut force = vec![drape_model::Vec3::zeros(); system.len()];
        system.forces(state.level(), &mut force);
        assert!(force.iter().any(|force| force.norm() > 1e-6), "{}", scene.name);
    }
    // No scene may be bundled or start another study, since it serves for judging only.
    let ours: Vec<_> =
        questions.iter().map(|question| system_hash(&question.scene.spec().unwrap())).collect();
    for name in drape_model::bundled::names() {
        let input = drape_model::load(name).unwrap();
        assert!(!ours.contains(&system_hash(input.spec())), "{name}");
    }
}

/// A pushed cloth differs from its scene only in the velocities of its free particles.
#[test]
fn every_scene_has_a_pushed_start_beside_it() {
    let starts = starts();
    let mut seen = 0;
    for start in &starts {
        let Some(name) = start.name().strip_suffix(", pushed") else { continue };
        let plain = match starts.iter().find(|other| other.name() == name) {
            Some(plain) => plain.system().unwrap(),
            None => drape_model::load(name).unwrap().spec().clone(),
        };
        let mut found = start.system().unwrap();
        assert_ne!(found, plain, "{name}");
        assert_eq!(found, pushed(&plain), "{name}");
        found.particles.velocity_m_s = plain.particles.velocity_m_s.clone();
        assert_eq!(found, plain, "{name}");
        seen += 1;
    }
    let own = starts.len() - seen;
    assert_eq!(seen, own + drape_model::bundled::names().count());
}

/// The scenes by measured time: all bundled ones, those of the facts, and at least ten with other
/// forces. The last belong to no other study.
#[test]
fn the_clock_sees_every_bundled_scene_and_other_forces() {
    let bundled: Vec<_> = drape_model::bundled::names().collect();
    let mut hashes: Vec<String> = bundled
        .iter()
        .map(|name| system_hash(drape_model::load(name).unwrap().spec()))
        .chain(questions().iter().map(|question| system_hash(&question.scene.spec().unwrap())))
        .collect();
    assert!(forces::SCENES.len() >= 10);
    let mut kinds = std::collections::BTreeSet::new();
    for (name, make) in forces::SCENES {
        let spec = make().unwrap_or_else(|error| panic!("{name}: {error}"));
        let (system, state) = spec.build().unwrap();
        let mut force = vec![drape_model::Vec3::zeros(); system.len()];
        system.forces(state.level(), &mut force);
        assert!(force.iter().any(|force| force.norm() > 1e-6), "{name}");
        kinds.extend(system.effects().map(|effect| effect.name()));
        kinds.extend((!spec.obstacles.is_empty()).then_some("obstacle"));
        let hash = system_hash(&spec);
        assert!(!hashes.contains(&hash), "{name}");
        hashes.push(hash);
    }
    for kind in ["obstacle", "air", "bending_hinge", "shear_angle", "bending_angle", "bending"] {
        assert!(kinds.contains(kind), "{kind}: {kinds:?}");
    }
    let all = clock::trials(&[], &[]);
    assert_eq!(all.len(), bundled.len() + forces::SCENES.len());
}

/// The advice of the quick case is the exhaustive search's best run, and the facts have the same
/// bits in a second run.
#[test]
fn a_case_is_a_fact() {
    let question = questions().into_iter().find(|question| question.is_quick).unwrap();
    let case = question.case().unwrap();
    assert!(case.is_trusted && case.best.is_some(), "{case:?}");
    let regret = case.regret.unwrap();
    assert!((1.0..1.5).contains(&regret), "{case:?}");
    assert!(case.effort < 0.7, "the race is shorter than the search: {case:?}");
    assert_eq!(case.outcome(), Some(Outcome::Met), "{case:?}");
}
