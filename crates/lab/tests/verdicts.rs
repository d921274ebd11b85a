//! The verdicts and messages of panes.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

use drape_harness::record::Judged;
use drape_lab::{Out, Pane, Phase, Runs, Session, Setup, Touch};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Longest wait. A busy machine may need so long.
const PATIENCE: Duration = Duration::from_secs(120);

fn setup(method: &str) -> Setup {
    Setup {
        scene: "hanging-textile-1e6".to_owned(),
        method: method.to_owned(),
        step: Some(0.01),
        duration: Some(0.5),
        ..Setup::default()
    }
}

/// Waits until a pane is over.
fn finish(pane: &Pane) -> (Phase, drape_lab::engine::Snapshot) {
    pane.go_until(f64::INFINITY);
    let begin = Instant::now();
    loop {
        let (_, phase, snapshot) = pane.look();
        if phase.is_over() {
            return (phase, (*snapshot).clone());
        }
        assert!(begin.elapsed() < PATIENCE, "{phase:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn explicit_euler_explodes_plain_imex_locks_and_updated_cg_falls() {
    let runs = Runs::default();
    for (method, phase, kind, said) in [
        ("explicit-euler", Phase::Diverged, Judged::Diverged, "times as long"),
        ("imex-euler", Phase::Ended, Judged::Locked, "will lock"),
        ("imex-updated", Phase::Ended, Judged::Stable, "lets the cloth move"),
    ] {
        let pane = Pane::start(setup(method), &runs).unwrap();
        let (found, snapshot) = finish(&pane);
        assert_eq!(found, phase, "{method}");
        let opinion = snapshot.opinion.unwrap();
        assert!(opinion.is_final, "{method}");
        assert_eq!(opinion.kind, kind, "{method}: {opinion:?}");
        assert!(opinion.why.contains(said), "{method}: {opinion:?}");
        assert!(opinion.why.ends_with('.'), "{method}: {opinion:?}");
        assert_eq!(snapshot.shown.len(), 400);
    }
}

#[test]
fn a_locked_run_is_called_so_before_it_ends() {
    let pane = Pane::start(setup("imex-euler"), &Runs::default()).unwrap();
    let begin = Instant::now();
    while pane.look().1 == Phase::Preparing {
        assert!(begin.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(2));
    }
    let opinion = pane.look().2.opinion.clone().unwrap();
    assert_eq!((opinion.kind, opinion.is_final), (Judged::Locked, false));
}

#[test]
fn a_pane_takes_the_steps_that_it_may_and_no_more() {
    let pane = Pane::start(setup("imex-updated"), &Runs::default()).unwrap();
    for (until, steps) in [(0.025, 2), (0.04, 4), (0.0499, 4), (0.1, 10)] {
        pane.go_until(until);
        let begin = Instant::now();
        while pane.look().2.numbers.step < steps {
            assert!(begin.elapsed() < PATIENCE);
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(pane.look().2.numbers.step, steps);
    }
}

#[test]
fn a_method_that_refuses_a_scene_says_so_in_its_pane() {
    let mut refused = setup("rosenbrock");
    refused.scene = "sheet-on-sphere".to_owned();
    let pane = Pane::start(refused, &Runs::default()).unwrap();
    let (phase, _) = finish(&pane);
    let Phase::Refused(sentence) = phase else { panic!("{phase:?}") };
    assert!(sentence.contains("contact") || sentence.contains("friction"), "{sentence}");
}

/// Every scene opens with every method: it takes a step, or says in its pane why it cannot.
#[test]
fn every_scene_opens_with_every_method() {
    let runs = Runs::default();
    let mut refused = BTreeSet::new();
    let mut count = 0;
    for scene in drape_model::bundled::names() {
        let opened = drape_harness::methods::all().map(|method| {
            let mut setup = setup(method.id);
            // One step of the scene's own length.
            (setup.scene, setup.step) = (scene.to_owned(), None);
            setup.duration = Some(setup.stage().unwrap().time.step_s);
            (method.id, Pane::start(setup, &runs).unwrap())
        });
        for (id, pane) in opened.collect::<Vec<_>>() {
            let (phase, snapshot) = finish(&pane);
            count += 1;
            match phase {
                Phase::Refused(sentence) => {
                    let pair = format!("{id} on {scene}: {sentence}");
                    assert!(sentence.len() > 20 && !sentence.contains("bug"), "{pair}");
                    refused.insert(id);
                }
                Phase::Ended | Phase::Diverged => {
                    assert_eq!(snapshot.numbers.step, 1, "{id} on {scene}");
                    assert!(!snapshot.shown.is_empty(), "{id} on {scene}");
                    assert!(snapshot.opinion.is_some_and(|o| o.is_final), "{id} on {scene}");
                }
                Phase::Preparing | Phase::Ready => panic!("{id} on {scene}: {phase:?}"),
            }
        }
    }
    assert_eq!(
        count,
        drape_model::bundled::names().count() * drape_harness::methods::all().count()
    );
    println!("{count} pairs; some scene is refused by {refused:?}");
    assert!(refused.len() < 20, "{refused:?}");
}

/// Numbers and phases of all panes, once each is ready, has taken `steps` steps or is over.
fn reached(session: &mut Session, steps: &[u64]) -> Vec<(Phase, f64)> {
    let begin = Instant::now();
    loop {
        session.tick(Duration::ZERO);
        let looks: Vec<_> = session.panes().map(Pane::look).collect();
        let is_there = |((_, phase, snapshot), steps): (&(_, Phase, Arc<_>), &u64)| {
            let snapshot: &drape_lab::engine::Snapshot = snapshot;
            phase.is_over() || *phase == Phase::Ready && snapshot.numbers.step == *steps
        };
        if looks.len() == steps.len() && looks.iter().zip(steps).all(is_there) {
            return looks.into_iter().map(|(_, phase, s)| (phase, s.numbers.time)).collect();
        }
        assert!(begin.elapsed() < PATIENCE, "{steps:?}: {looks:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn panes_go_on_after_a_change_where_all_of_them_can() {
    let pane = |method: &str, change: Value| {
        let mut pane = json!({ "scene": "hanging-textile-1e6", "method": method, "step": 0.01,
            "duration": 0.5 });
        pane.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        pane
    };
    let mut session = Session::new(Runs::default());
    let open = |session: &mut Session, panes: &[Value], keep: bool| {
        let request = json!({ "do": "open", "panes": panes, "keep": keep });
        assert!(session.receive(&request.to_string()).is_empty());
    };
    let [a, b] = ["imex-updated", "baraff-witkin"].map(|method| pane(method, json!({})));
    open(&mut session, &[a.clone(), b.clone()], true);
    reached(&mut session, &[0, 0]);
    for n in 1..=3 {
        session.receive(r#"{"do":"step"}"#);
        reached(&mut session, &[n, n]);
    }
    // One pane changes, the other stays; both are where they were.
    let a = pane("imex-updated", json!({ "stiffness": 1e4 }));
    open(&mut session, &[a.clone(), b.clone()], true);
    reached(&mut session, &[3, 3]);
    let touches = |session: &Session| -> Vec<_> {
        session.panes().map(|pane| pane.scenery().unwrap().stage.touch()).collect()
    };
    assert_eq!(touches(&session), [Some(Touch::Knob), None]);
    session.receive(r#"{"do":"step"}"#);
    let there = reached(&mut session, &[4, 4]);
    assert!(there.iter().all(|(_, time)| (time - 0.04).abs() < 1e-12), "{there:?}");
    // The pane takes another method, which its reference does not cover.
    let a = pane("xpbd", json!({ "stiffness": 1e4 }));
    session.receive(r#"{"do":"ghost","on":true}"#);
    open(&mut session, &[a.clone(), b.clone()], true);
    let told = {
        reached(&mut session, &[4, 4]);
        session.receive(r#"{"do":"step"}"#);
        let begin = Instant::now();
        loop {
            let told: Vec<_> = session.tick(Duration::ZERO).into_iter().filter_map(text).collect();
            let is_told = |text: &String| text.contains("a knob turned on the way");
            if let Some(text) = told.into_iter().find(is_told) {
                break text;
            }
            assert!(begin.elapsed() < PATIENCE);
        }
    };
    assert!(told.contains("press Restart"), "{told}");
    reached(&mut session, &[5, 5]);
    // A hand lets go before a change.
    session.receive(r#"{"do":"lead","particle":210,"by":[0.1,0,0]}"#);
    session.receive(r#"{"do":"pause"}"#);
    reached(&mut session, &[5, 5]);
    let a = pane("xpbd", json!({ "stiffness": 2e4 }));
    open(&mut session, &[a.clone(), b.clone()], true);
    reached(&mut session, &[5, 5]);
    assert_eq!(touches(&session), [Some(Touch::Knob), Some(Touch::Knob)]);
    assert!(session.panes().all(|pane| !pane.scenery().unwrap().stage.is_led()));
    // Without `keep`, with another number of panes, another scene, other particles, or a step that
    // is refused, all begin again.
    let wrong = pane("xpbd", json!({ "step": 1e9 }));
    let small = pane("xpbd", json!({ "particles": 5 }));
    let other = json!({ "scene": "flag", "method": "xpbd" });
    for (panes, keep) in [
        (vec![a.clone(), b.clone()], false),
        (vec![a.clone(), b.clone(), b.clone()], true),
        (vec![a.clone(), other], true),
        (vec![a.clone(), small], true),
        (vec![a.clone(), wrong], true),
    ] {
        open(&mut session, &[a.clone(), b.clone()], false);
        reached(&mut session, &[0, 0]);
        session.receive(r#"{"do":"step"}"#);
        reached(&mut session, &[1, 1]);
        open(&mut session, &panes, keep);
        let there = reached(&mut session, &vec![0; panes.len()]);
        assert!(there.iter().all(|(_, time)| *time == 0.0), "{panes:?}: {there:?}");
    }
}

/// The text of a message.
fn text(out: Out) -> Option<String> {
    match out {
        Out::Text(text) => Some(text),
        Out::Binary(_) => None,
    }
}

#[test]
fn more_runs_than_allowed_are_refused_and_closed_ones_make_room() {
    let runs = Runs::default();
    let mut panes: Vec<_> = (0..drape_lab::limits::RUNS)
        .map(|_| Pane::start(setup("imex-euler"), &runs).unwrap())
        .collect();
    assert!(Pane::start(setup("imex-euler"), &runs).is_none());
    panes.clear();
    let begin = Instant::now();
    while runs.count() > 0 {
        assert!(begin.elapsed() < PATIENCE, "{} runs", runs.count());
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(Pane::start(setup("imex-euler"), &runs).is_some());
}

/// A slow pane holds the others, if they wait for it.
#[test]
fn panes_that_wait_show_the_same_time() {
    let mut session = Session::new(Runs::default());
    let panes = serde_json::json!([
        { "scene": "hanging-textile-1e6", "method": "imex-euler", "step": 0.01, "duration": 0.2 },
        { "scene": "hanging-textile-1e6", "method": "backward-euler", "step": 0.01,
          "duration": 0.2, "particles": 30 },
    ]);
    session.receive(&serde_json::json!({ "do": "open", "panes": panes }).to_string());
    session.receive(r#"{"do":"play"}"#);
    let begin = Instant::now();
    let mut most: f64 = 0.0;
    loop {
        session.tick(Duration::from_millis(20));
        let looks: Vec<_> = session.panes().map(Pane::look).collect();
        if looks.iter().all(|(_, phase, _)| phase.is_over()) {
            break;
        }
        if looks.iter().all(|(_, phase, _)| *phase == Phase::Ready) {
            let [a, b] = [0, 1].map(|n: usize| looks[n].2.numbers.time);
            most = most.max((a - b).abs());
        }
        assert!(begin.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(most < 0.035, "the panes were {most} s apart");
}

/// The page learns that every run is over before it learns that the clock stands still.
#[test]
fn the_clock_stops_after_the_ends_of_all_runs_are_told() {
    let mut session = Session::new(Runs::default());
    let pane = |method| {
        json!({ "scene": "hanging-textile-1e6", "method": method, "step": 0.01, "duration": 0.1,
                "particles": 4 })
    };
    for _ in 0..200 {
        let panes = [pane("explicit-euler"), pane("imex-euler"), pane("imex-updated")];
        session.receive(&json!({ "do": "open", "panes": panes }).to_string());
        session.receive(r#"{"do":"play"}"#);
        let mut over = BTreeSet::new();
        let begin = Instant::now();
        let mut has_stopped = false;
        while !has_stopped {
            assert!(begin.elapsed() < PATIENCE);
            for message in session.tick(Duration::from_millis(20)).into_iter().filter_map(text) {
                let message: Value = serde_json::from_str(&message).unwrap();
                let phase = message["phase"]["kind"].as_str().unwrap_or_default();
                if ["ended", "diverged"].contains(&phase) {
                    over.insert(message["pane"].as_u64());
                }
                has_stopped |= message["tell"] == "clock" && message["playing"] == false;
            }
        }
        assert_eq!(over.len(), panes.len(), "{over:?} were told");
    }
}
