//! Every lesson, run on its own scene: theory and runs give the same answer.

use drape_harness::lessons::{Lesson, Question, Trap, lessons};
use drape_harness::{methods, studies};
use drape_lab::Stage;
use drape_lab::lessons::setups;
use drape_model::{State, System, TimeSpan, Vec3};
use drape_oracle::{Run, seconds};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// An oscillation whose energy exceeds that of the start by this factor has grown. Below its limit
/// that of leapfrog swings, by less than this up to 0.5 % beside the limit.
const GROWN: f64 = 100.0;
/// Steps in which a growth must show.
const STEPS: u64 = 20_000;
/// The particle that moves.
const FREE: usize = 1;

fn stage(lesson: &Lesson) -> Stage {
    let setup = setups(&lesson.setting).into_iter().next();
    let stage = setup.expect("a lesson opens a pane").stage();
    stage.unwrap_or_else(|error| panic!("{}: {error}", lesson.title))
}

/// A run of the first pane of a lesson in steps of `h` seconds.
fn run(lesson: &Lesson, h: f64) -> Run {
    let stage = stage(lesson);
    let start: (System, State) = stage.spec.build().expect("a valid scene");
    Run::new(stage.choice.build().expect("a method"), start, h)
}

/// Energy at the end over that of the start.
fn left(lesson: &Lesson, h: f64) -> f64 {
    let mut run = run(lesson, h);
    let start = run.energy();
    run.steps((lesson.setting.duration / h).round() as usize);
    run.energy() / start
}

/// Whether no oscillation grows. With damping it must have lost energy by the end: what grows may be
/// held at a finite size where the spring turns over.
fn is_stable(lesson: &Lesson, h: f64) -> bool {
    let mut run = run(lesson, h);
    let start = run.energy();
    for _ in 0..STEPS {
        // A step that cannot be computed has left all bounds.
        let has_failed = run.try_step().is_err();
        let energy = run.energy();
        // The motion may die out altogether: then nothing is left that could grow.
        if energy < 1e-12 * start {
            return true;
        }
        if has_failed || !energy.is_finite() || energy > GROWN * start {
            return false;
        }
    }
    lesson.setting.damping == 0.0 || run.energy() < start
}

/// The longest stable step, by bisection between a third of the expected one and half as much again; NaN
/// if it is not there.
fn longest_step(lesson: &Lesson) -> f64 {
    let (mut stable, mut unstable) = (lesson.answer() / 3.0, lesson.answer() * 1.5);
    if !is_stable(lesson, stable) || is_stable(lesson, unstable) {
        return f64::NAN;
    }
    for _ in 0..12 {
        let middle = 0.5 * (stable + unstable);
        if is_stable(lesson, middle) { stable = middle } else { unstable = middle }
    }
    stable
}

/// Elongation of the spring, m. Its rest length is 1 m.
fn elongation(state: &State) -> f64 {
    (state.x[FREE] - state.x[0]).norm() - 1.0
}

/// The period by the angle in the plane of elongation and velocity, over many turns.
fn period(lesson: &Lesson) -> f64 {
    const TURNS: u32 = 500;
    let h = lesson.setting.step;
    let omega = lesson.setting.stiffness.sqrt();
    let mut run = run(lesson, h);
    let angle = |state: &State| (omega * elongation(state)).atan2(state.v[FREE].x);
    let (mut last, mut turned) = (angle(&run.state), 0.0);
    for _ in 0..TURNS {
        run.step();
        let now = angle(&run.state);
        turned += (now - last).rem_euclid(TAU);
        last = now;
    }
    TAU * h * f64::from(TURNS) / turned
}

/// What drape finds, in the unit of the question.
fn found(lesson: &Lesson) -> f64 {
    let h = lesson.setting.step;
    match lesson.question {
        Question::LongestStep => longest_step(lesson),
        Question::EnergyLeft => 100.0 * left(lesson, h),
        Question::LossRatio => (1.0 - left(lesson, h)) / (1.0 - left(lesson, 0.5 * h)),
        Question::Period => period(lesson),
        Question::GreatestStretch => {
            let mut run = run(lesson, h);
            let steps = 0..lesson.setting.steps();
            let stretches = steps.map(|_| {
                run.step();
                elongation(&run.state)
            });
            100.0 * stretches.fold(0.0, f64::max)
        }
        Question::Speed => {
            let mut run = run(lesson, h);
            run.steps(lesson.setting.steps() as usize);
            1e3 * run.state.v[FREE].norm()
        }
    }
}

/// What a person reads in the lab for the speed and the share of the energy rests on these.
#[test]
fn the_scenes_start_with_one_joule_and_with_two_kilograms() {
    let (mut oscillators, mut loads) = (0, 0);
    for (method, lesson) in lessons() {
        let Run { system, state, .. } = run(lesson, lesson.setting.step);
        let asks_speed = lesson.question == Question::Speed;
        if asks_speed {
            assert_eq!(system.mass()[FREE], 2.0, "{}", method.id);
            assert_eq!(state.v[FREE], Vec3::zeros(), "{}", method.id);
            loads += 1;
        } else {
            assert!((system.total_energy(&state) - 1.0).abs() < 1e-12, "{}", method.id);
            oscillators += 1;
        }
    }
    assert!(oscillators > 20 && loads > 2, "{oscillators} {loads}");
}

#[test]
fn every_method_has_a_lesson() {
    let taught: BTreeSet<_> = lessons().map(|(method, _)| method.id).collect();
    for method in methods::all() {
        assert!(taught.contains(method.id), "{}: write its lesson", method.id);
    }
    let titles: BTreeSet<_> = lessons().map(|(_, lesson)| lesson.title).collect();
    assert_eq!(titles.len(), taught.len(), "each title stands once");
}

/// What a run finds would be accepted with a fifth of the tolerance.
#[test]
fn theory_says_what_runs_find() {
    let mut table = Vec::new();
    let mut are_all_near = true;
    for (method, lesson) in lessons() {
        let (theory, found) = (lesson.answer(), found(lesson));
        let apart = (theory - found).abs() / theory.abs();
        // NaN must not pass.
        let is_near = apart <= 0.2 * lesson.question.tolerance();
        are_all_near &= is_near;
        let word = if is_near { "" } else { " WRONG" };
        let (id, question) = (method.id, lesson.question);
        table.push(format!("{id}, {question:?}: {theory:.6} by theory, {found:.6} found{word}"));
    }
    assert!(are_all_near, "\n{}\n", table.join("\n"));
}

#[test]
fn right_answers_are_accepted_and_wrong_ones_get_their_hint() {
    for (method, lesson) in lessons() {
        let (id, answer) = (method.id, lesson.answer());
        let tolerance = lesson.question.tolerance();
        let mark = |value: f64| lesson.mark(value).unwrap_or_else(|error| panic!("{error}"));
        for right in [answer, answer * (1.0 + 0.9 * tolerance), answer * (1.0 - 0.9 * tolerance)] {
            assert!(mark(right).is_right, "{id}: {right}");
        }
        // Factors that lead to no trap.
        for (wrong, hint) in [(answer * 7e4, lesson.high), (answer * 1.3e-5, lesson.low)] {
            let mark = mark(wrong);
            assert!(!mark.is_right && mark.sentence.contains(hint), "{id}, {wrong}: {mark:?}");
        }
        for factor in [1.0 + 1.1 * tolerance, 1.0 - 1.1 * tolerance] {
            assert!(!mark(answer * factor).is_right, "{id}: {factor}");
        }
        for Trap { value, hint } in lesson.traps {
            let value = value(&lesson.setting);
            let mark = mark(value);
            assert!(!mark.is_right, "{id}: the trap {value} is near the answer {answer}");
            assert!(mark.sentence.contains(hint), "{id}, {value}: {mark:?}, not {hint}");
        }
        assert!(lesson.low != lesson.high, "{id}");
        for value in [f64::NAN, f64::INFINITY] {
            assert!(lesson.mark(value).is_err_and(|error| error.contains("finite")), "{id}");
        }
    }
}

/// Equations and code are in the crate of the method; a lesson shows no more than a screen.
#[test]
fn excerpts_are_found_in_the_sources() {
    let root = drape_tests::equations::root().join("crates/integrators");
    for (method, lesson) in lessons() {
        let id = method.id;
        let equation = lesson.equation().unwrap_or_else(|| panic!("{id}: no equation"));
        let code = lesson.code().unwrap_or_else(|| panic!("{id}: no code"));
        assert!(equation.contains(['=', '←']), "{id}: {equation}");
        assert!(code.contains([';', ',']) && code.lines().count() <= 40, "{id}: {code}");
        let folder = lesson.docs.strip_prefix("drape-").unwrap_or_default();
        for (excerpt, text) in [(lesson.equation, &equation), (lesson.code, &code)] {
            let file = root.join(folder).join(excerpt.file);
            let source = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{file:?}: {e}"));
            for line in text.lines() {
                assert!(source.contains(line.trim()), "{id}: {file:?} has no line {line}");
            }
        }
    }
}

#[test]
fn lessons_lead_to_studies_and_open_panes_that_the_lab_accepts() {
    for (method, lesson) in lessons() {
        let id = method.id;
        assert!(studies::find(lesson.study).is_ok(), "{id}: {}", lesson.study);
        let setups = setups(&lesson.setting);
        assert!((1..=drape_lab::limits::PANES).contains(&setups.len()), "{id}");
        for setup in &setups {
            let stage = setup.stage().unwrap_or_else(|error| panic!("{id}: {error}"));
            let TimeSpan { step_s, duration_s } = stage.time;
            assert_eq!((step_s, duration_s), (lesson.setting.step, lesson.setting.duration));
            let start = stage.spec.build().expect("a valid scene");
            let mut integrator = stage.choice.build().expect("a method");
            assert!(integrator.prepare(&start.0, seconds(step_s)).is_ok(), "{id}");
        }
        let asked = lesson.setting.methods.first().copied().unwrap_or_default();
        assert_eq!(drape_tests::name(asked), id, "the question is about the method of the lesson");
    }
}

/// The curve is that of the question's answer: it crosses 1 where the longest stable step is.
#[test]
fn curves_cross_one_at_the_longest_stable_step() {
    for (method, lesson) in lessons() {
        let radii = lesson.radii();
        assert!(radii.len() > 20, "{}", method.id);
        assert!(radii.windows(2).all(|two| two[0].0 < two[1].0), "{}", method.id);
        if lesson.question != Question::LongestStep {
            continue;
        }
        let first = radii.iter().position(|(_, radius)| *radius > 1.0 + 1e-6);
        let first = first.unwrap_or_else(|| panic!("{}: nothing grows", method.id));
        let (below, above) = (radii[first - 1].0, radii[first].0);
        let answer = lesson.answer();
        assert!(below <= answer && answer <= above, "{}: {below} {answer} {above}", method.id);
    }
}
