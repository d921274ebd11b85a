//! The pairs against the library, against each other and against motions in closed form.

use super::*;
use crate::reference::reference;
use crate::scenes::{Sheet, anchored, build, bundled, in_a_gust, waving};
use drape_model::SpringEffect;
use nalgebra::DVector;
use ode_solvers::{Dop853, OutputType};
use std::cell::Cell;

const PAIRS: [Pair; 2] = [Pair::Dop853, Pair::Tsit5];

fn settings(tolerance: f64) -> AdaptiveSettings {
    AdaptiveSettings { tolerance, ..AdaptiveSettings::default() }
}

fn run_for(
    pair: Pair,
    (system, start): &(System, State),
    tolerance: f64,
    span: f64,
) -> AdaptiveRun {
    adaptive(pair, system, start, span, settings(tolerance)).expect("smooth")
}

/// The motion for the library.
struct Library<'a> {
    motion: Motion<'a>,
    evaluations: &'a Cell<u64>,
}

impl ode_solvers::System<f64, DVector<f64>> for Library<'_> {
    fn system(&self, t: f64, y: &DVector<f64>, dy: &mut DVector<f64>) {
        let y: Vec<Vec3> = y.as_slice().chunks_exact(3).map(Vec3::from_column_slice).collect();
        let mut slope = y.clone();
        self.motion.slope(t, &y, &mut slope);
        let numbers = slope.iter().flat_map(|a| a.iter());
        dy.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
        self.evaluations.set(self.evaluations.get() + 1);
    }
}

/// The last state of the library's method, number by number, and its evaluations and steps.
fn library((system, start): &(System, State), tolerance: f64, span: f64) -> (Vec<f64>, [u64; 2]) {
    let stepper = Stepper::new(Pair::Dop853, system, start, settings(tolerance));
    let numbers: Vec<f64> = stepper.y.iter().flat_map(|a| a.iter().copied()).collect();
    let evaluations = Cell::new(0);
    let motion = Library { motion: stepper.motion, evaluations: &evaluations };
    let mut solver = Dop853::from_param(
        motion,
        0.0,
        span,
        span,
        DVector::from_vec(numbers),
        tolerance,
        tolerance,
        0.9,
        0.0,
        0.333,
        6.0,
        span,
        0.0,
        100_000,
        u32::MAX,
        OutputType::Sparse,
    );
    let stats = solver.integrate().expect("smooth");
    let end = solver.y_out().last().expect("an end").as_slice().to_vec();
    let steps = u64::from(stats.accepted_steps + stats.rejected_steps);
    (end, [evaluations.get(), steps])
}

/// The library evaluates the slope at the start twice.
#[test]
fn dop853_takes_the_steps_of_the_library_bit_by_bit() {
    let hanging = build(&bundled("hanging-textile-sheared-1e4"));
    let stiff = build(&bundled("hanging-textile-sheared-1e6"));
    let mut rejections = 0;
    for (scene, span) in [(&hanging, 0.1), (&stiff, 0.02)] {
        for tolerance in [1e-2, 1e-4, 1e-7, 1e-10, 1e-12] {
            let ours = run_for(Pair::Dop853, scene, tolerance, span);
            let (end, [evaluations, steps]) = library(scene, tolerance, span);
            let numbers = ours.state.x.iter().chain(&ours.state.v).flat_map(|a| a.iter());
            assert!(numbers.eq(&end), "the end at tolerance {tolerance}");
            assert_eq!(ours.evaluations + 1, evaluations, "at tolerance {tolerance}");
            // The library does not count what is rejected before the first step.
            assert!(u64::from(ours.steps) >= steps, "at tolerance {tolerance}");
            rejections += 12 * u64::from(ours.steps) + 2 - ours.evaluations;
        }
    }
    assert!(rejections > 10, "{rejections} rejected steps show nothing of the control");
}

/// Each tableau meets the conditions of order that have a simple form.
#[test]
fn the_tableaus_are_consistent() {
    for (pair, order, accuracy) in [(Pair::Dop853, 8, 2e-14), (Pair::Tsit5, 5, 1e-13)] {
        let Tableau { a, b, c, error, .. } = pair.tableau();
        assert_eq!([a.len() + 1, b.len()], [c.len(); 2]);
        for (row, c) in a.iter().zip(&c[1..]) {
            let sum: f64 = row.iter().sum();
            assert!((sum - c).abs() < accuracy, "{pair:?}: {sum} for {c}");
        }
        for power in 0..order {
            let sum: f64 = b.iter().zip(*c).map(|(b, c)| b * c.powi(power)).sum();
            let exact = 1.0 / f64::from(power + 1);
            assert!((sum - exact).abs() < accuracy, "{pair:?}: {sum} for {exact}");
        }
        let estimate = match error {
            Estimate::WithEnd(weights) | Estimate::Two { fifth: weights, .. } => weights,
        };
        assert!(estimate.iter().sum::<f64>().abs() < accuracy, "{pair:?}: a constant slope");
    }
}

/// On a smooth motion the error falls in step with the tolerance: a method whose estimate or whose
/// weights were wrong would be stuck.
#[test]
fn both_pairs_meet_the_reference() {
    let scene = waving(Sheet { shear: 0.0, ..Sheet::default() }.build());
    let exact = reference(&scene.0, &scene.1, &[0.5], AdaptiveSettings::default()).expect("smooth");
    for pair in PAIRS {
        let mut last = f64::INFINITY;
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let run = run_for(pair, &scene, tolerance, 0.5);
            let error = crate::apart(&run.state.x, &exact.states[0].x);
            assert!(error < tolerance && error < 0.1 * last, "{pair:?} {tolerance}: {error}");
            last = error;
        }
    }
}

/// With steps of a fixed number, the error of a step falls by its order: half a step, so many times
/// less error.
#[test]
fn the_pairs_have_their_order() {
    let spring = (SpringEffect::Tension, 0.4, 20.0, 0.1);
    let (x, v) = (Vec3::new(0.5, 0.1, 0.0), Vec3::new(0.0, 1.0, -1.0));
    let scene = build(&anchored(0.5, &[spring], x, v));
    for (pair, order, h) in [(Pair::Dop853, 8.0, 0.1), (Pair::Tsit5, 5.0, 0.025)] {
        let exact = run_for(Pair::Dop853, &scene, 1e-14, 1.6).state;
        let error = |h: f64| {
            let mut run = Stepper::new(pair, &scene.0, &scene.1, settings(1e-3));
            run.first_step(h);
            for _ in 0..(1.6 / h).round() as u32 {
                run.try_step(h);
                run.accept(h);
            }
            crate::apart(&run.state().x, &exact.x)
        };
        let observed = (error(h) / error(0.5 * h)).log2();
        assert!((observed - order).abs() < 0.5, "{pair:?}: {observed}, {}", error(h));
    }
}

#[test]
fn a_run_ends_where_the_reference_does_and_counts_its_evaluations() {
    let scene = build(&bundled("hanging-textile-sheared-1e4"));
    let exact = reference(&scene.0, &scene.1, &[0.1], AdaptiveSettings::default()).expect("smooth");
    assert_eq!(run_for(Pair::Dop853, &scene, 1e-12, 0.1).state, exact.states[0]);
    // Evaluations a step and to begin with; a step that is rejected may save one.
    for (pair, stages) in [(Pair::Dop853, 12), (Pair::Tsit5, 6)] {
        let (loose, tight) = (run_for(pair, &scene, 1e-4, 0.1), run_for(pair, &scene, 1e-10, 0.1));
        assert!(loose.evaluations < tight.evaluations && loose.steps < tight.steps);
        for run in [loose, tight] {
            assert!(run.evaluations <= stages * u64::from(run.steps) + 2);
            assert!(run.evaluations >= (stages - 1) * u64::from(run.steps) + 2);
        }
    }
    let settings = AdaptiveSettings { max_steps: 1, tolerance: 1e-12 };
    let stopped = adaptive(Pair::Dop853, &scene.0, &scene.1, 0.1, settings);
    assert!(matches!(stopped, Err(AdaptiveError::StepLimit { steps: 1, .. })));
}

/// The error falls with the tolerance, in few steps, only if every stage takes the forces of its
/// time. The library's last stage does not (`c₁₂` is 0 in version 0.6.2).
#[test]
fn a_gust_is_followed_with_the_full_order() {
    let scene = in_a_gust();
    let finest = run_for(Pair::Dop853, &scene, 1e-12, 0.25);
    for pair in PAIRS {
        for (tolerance, most) in [(1e-6, 1e-5), (1e-9, 1e-8)] {
            let run = run_for(pair, &scene, tolerance, 0.25);
            let error = crate::apart(&run.state.x, &finest.state.x);
            assert!(error < most, "{pair:?} at {tolerance}: {error}");
        }
    }
    assert!(finest.steps < 500, "{} steps", finest.steps);
}
