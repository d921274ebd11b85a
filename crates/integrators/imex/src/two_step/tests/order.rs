//! Order 2 against the solution of the differential equation.

use super::*;
use drape_oracle::order::{ObservedOrder, Sample, observed_order, position_error};
use drape_oracle::reference::{Reference, ReferenceSettings, reference};

const SPAN: f64 = 0.25;

/// Nine particles, `ω_max h < 0.5` at the longest step.
fn scene(law: DampingLaw) -> (System, State, Reference) {
    let (system, start) = stir(&sheet(3, 100.0, 2.0, law));
    let exact = reference(&system, &start, &[SPAN], ReferenceSettings::default()).unwrap();
    assert!(exact.position_error < 1e-9, "{:e}", exact.position_error);
    (system, start, exact)
}

/// Steps whose lengths have the given pattern, `count` patterns over the span.
fn observe(
    scheme: Scheme,
    text: &str,
    (system, start, exact): &(System, State, Reference),
    pattern: &[f64],
    counts: [u32; 4],
) -> ObservedOrder {
    let sample = |count: u32| {
        let unit = SPAN / (f64::from(count) * pattern.iter().sum::<f64>());
        let mut run = Run::new(scheme, text, (system.clone(), start.clone()), unit);
        for share in (0..count).flat_map(|_| pattern) {
            run.h = seconds(unit * share);
            run.step();
        }
        let error = position_error(system, &start.x, &exact.states[0].x, &run.state.x);
        Sample { step: unit, error }
    };
    observed_order(&counts.map(sample)).unwrap()
}

const TIGHT: [&str; 3] =
    ["solver=cholesky", "forcing_term=1e-10", "forcing_term=1e-10,implicit=tension"];

#[test]
fn the_error_falls_with_the_square_of_the_step() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let scene = scene(law);
        for (scheme, text) in SCHEMES.into_iter().flat_map(|s| TIGHT.map(|t| (s, t))) {
            let found = observe(scheme, text, &scene, &[1.0], [40, 80, 160, 320]);
            assert!((found.order - 2.0).abs() < 0.15, "{scheme:?}, {law:?}, {text}: {found:?}");
        }
    }
}

/// Steps that double and halve all the time; with the coefficients of a constant step the order would
/// be 1.
#[test]
fn the_order_survives_alternating_steps() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let scene = scene(law);
        for (scheme, text) in VARIABLE.into_iter().flat_map(|s| TIGHT.map(|t| (s, t))) {
            for pattern in [&[1.0, 2.0][..], &[1.0, 1.5, 0.75, 1.25]] {
                let found = observe(scheme, text, &scene, pattern, [20, 40, 80, 160]);
                assert!((found.order - 2.0).abs() < 0.15, "{scheme:?}, {law:?}, {text}: {found:?}");
            }
        }
    }
}
