//! What the panes say.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_harness::record::Judged;
use drape_lab::{Pane, Phase, Runs, Session, Setup};
use std::time::{Duration, Instant};

/// A busy machine may need this long.
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
