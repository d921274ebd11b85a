#![allow(clippy::unwrap_used, reason = "tests")]

use super::*;

fn spec(scene: &str) -> SystemSpec {
    drape_model::load(scene).unwrap().spec().clone()
}

fn wish(error: f64) -> Wish {
    Wish { error, step_s: None, frame_s: 0.01 }
}

#[test]
fn every_form_of_the_table_is_a_method_of_the_registry() {
    let table = table();
    assert!(table.scenes.len() >= 10);
    for scene in &table.scenes {
        assert!(scene.forms.len() > 30, "{}", scene.id);
        for form in &scene.forms {
            let choice = Choice::parse(&form.method, &[]);
            assert!(choice.is_ok(), "{}: {choice:?}", form.method);
            assert_eq!(form.reached.len(), LEVELS.len());
        }
    }
}

/// A sheet like one of the study has nearly the place of that scene.
#[test]
fn a_system_has_the_place_of_its_like_in_the_study() {
    let (system, _) = spec("hanging-textile-1e6").build().unwrap();
    let place = Place::of(&system).unwrap();
    let like = table().scenes.iter().find(|scene| scene.id == "hanging light 1e6 n=400").unwrap();
    assert_eq!((place.particles, place.is_held), (400, true));
    // This sheet lacks the shear springs of the study's: its ω² is 8 k/m in place of 10 k/m.
    let ratio = place.frequency_per_s / like.place.frequency_per_s;
    assert!((ratio - 0.8_f64.sqrt()).abs() < 0.05, "{ratio}");
    assert!(place.distance(&like.place) < 1.0, "{}", place.distance(&like.place));
}

/// On a scene of the study, the rule chooses a form that is among the fastest there.
#[test]
fn a_scene_of_the_study_gets_a_form_that_is_among_its_fastest() {
    let table = table();
    for scene in &table.scenes {
        let ranked = ranking(table, &scene.place, 1, None, f64::INFINITY);
        let best = ranked.first().unwrap();
        assert!(ranked.is_sorted_by(|a, b| a.score <= b.score));
        assert!(best.score < 1.5 && best.value.is_some_and(|h| h > 0.0), "{}", scene.id);
    }
}

#[test]
fn a_choice_runs_and_its_step_is_part_of_a_frame() {
    for scene in ["hanging-textile-1e4", "hanging-textile-1e6", "flag", "skirt"] {
        for error in [1.0, 0.1, 0.01, 1e-4] {
            let pick = choose(&spec(scene), wish(error)).unwrap();
            let mut method = Choice::parse(&pick.method, &[]).unwrap().build().unwrap();
            let (system, _) = spec(scene).build().unwrap();
            method.prepare(&system, TimeStep::new(pick.step_s).unwrap()).unwrap();
            let parts = 0.01 / pick.step_s;
            assert!((parts - parts.round()).abs() < 1e-6 && parts > 0.9, "{pick:?}");
            assert!(pick.reason.contains(&pick.method) && pick.is_met, "{pick:?}");
        }
    }
}

/// Tighter errors never take longer steps of the same form.
#[test]
fn tighter_errors_take_shorter_steps() {
    let steps = |error| choose(&spec("hanging-textile-1e6"), wish(error)).unwrap();
    let (coarse, fine) = (steps(0.1), steps(1e-4));
    assert!(fine.step_s < coarse.step_s || fine.method != coarse.method, "{coarse:?} {fine:?}");
}

/// A form that divides frames by itself serves any step.
#[test]
fn a_given_step_is_kept() {
    let scene = spec("hanging-textile-1e6");
    let at = |step_s| choose(&scene, Wish { step_s: Some(step_s), ..wish(1e-4) }).unwrap();
    let (short, long) = (at(1e-5), at(0.05));
    assert_eq!((short.step_s, long.step_s), (1e-5, 0.05));
    assert!(short.is_met && long.is_met);
    assert!(long.method.contains("safety=") && !long.reason.contains("No form"), "{long:?}");
}

#[test]
fn where_no_form_keeps_the_error_the_longest_step_comes_nearest() {
    let place = Place { frequency_per_s: 10.0, damping_per_s: 1.0, particles: 100, is_held: true };
    let known = |method: &str, value, modelled_s| Known {
        method: method.to_owned(),
        is_divided: false,
        reached: vec![Some(Reached { value, modelled_s }); 4],
    };
    let forms = vec![known("imex-euler", 0.01, 1.0), known("backward-euler", 0.02, 3.0)];
    let table = Table {
        commit: String::new(),
        scenes: vec![Studied { id: "one".to_owned(), place, forms }],
    };
    let all = ranking(&table, &place, 0, None, 0.01);
    let of = |step| first(&all, Some(step)).map(|(c, is_met)| (c.form.method.as_str(), is_met));
    assert_eq!(of(0.01), Some(("imex-euler", true)));
    assert_eq!(of(0.015), Some(("backward-euler", true)));
    assert_eq!(of(0.03), Some(("backward-euler", false)));
    assert_eq!(first(&[], None), None);
}

#[test]
fn settings_of_the_choice_are_read_and_refused() {
    assert_eq!(wanted("imex-euler", &[]), Ok(None));
    assert_eq!(wanted("auto", &[]), Ok(Some(USUAL_ERROR)));
    assert_eq!(wanted("auto:error=0.003", &[]), Ok(Some(0.003)));
    assert_eq!(wanted("auto", &["error = 0.2".to_owned()]), Ok(Some(0.2)));
    for wrong in ["auto:error=1e-9", "auto:error=x", "auto:step=1", "auto:fast", "auto:error=NaN"] {
        let error = wanted(wrong, &[]).unwrap_err();
        assert!(error.expected.contains("from 0.0001 to 1"), "{error:?}");
    }
}

/// The digest keeps four digits.
#[test]
fn numbers_are_rounded_to_four_digits() {
    assert_eq!(
        [0.0, 123_456.0, 1.234_56e-9, 9.9999e3].map(rounded),
        [0.0, 123_500.0, 1.235e-9, 1e4]
    );
}

/// A form that never gets to the error is not chosen where another form does.
#[test]
fn what_never_gets_there_is_not_chosen() {
    let known = |method: &str, reached| Known {
        method: method.to_owned(),
        is_divided: false,
        reached: vec![reached; 4],
    };
    let place = Place { frequency_per_s: 10.0, damping_per_s: 1.0, particles: 100, is_held: true };
    let slow = Some(Reached { value: 0.01, modelled_s: 1.0 });
    let forms = vec![known("explicit-euler", None), known("imex-euler", slow)];
    let scenes = vec![Studied { id: "one".to_owned(), place, forms }];
    let table = Table { commit: String::new(), scenes };
    let ranked = ranking(&table, &place, 0, None, 1.0);
    assert_eq!(ranked[0].form.method, "imex-euler");
    assert_eq!((ranked[0].score, ranked[1].score), (0.0, NEVER));
    // The longest allowed step is half of the form's own one: twice the price.
    let capped = ranking(&table, &place, 0, None, 0.005);
    assert!((capped[0].score - 2.0_f64.ln()).abs() < 1e-12, "{}", capped[0].score);
}

/// `frame / (frame/27)` is rounded to a little more than 27.
#[test]
fn round_off_adds_no_step_to_a_frame() {
    for parts in 1..400 {
        let step = 0.01 / f64::from(parts);
        assert!((part_of(0.01, step) / step - 1.0).abs() < 1e-12, "{parts}");
    }
}
