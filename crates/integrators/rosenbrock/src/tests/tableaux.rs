//! Order conditions, and the recurrences of the oscillator.

use crate::{STAGES, Scheme, Tableau};
use drape_integrator::Order;
use drape_oracle::recurrence::{RosenbrockTableau, rosenbrock, spectral_radius};

type Row = [f64; STAGES];

pub(super) fn definition(scheme: Scheme) -> RosenbrockTableau<STAGES> {
    let (alpha, gamma, weights) = scheme.tableau().definition();
    RosenbrockTableau { alpha, gamma, weights }
}

fn sum(a: &Row, b: &Row) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn times(a: &[Row; STAGES], b: &Row) -> Row {
    a.map(|row| sum(&row, b))
}

fn product(a: &Row, b: &Row) -> Row {
    std::array::from_fn(|i| a[i] * b[i])
}

/// The conditions of a Rosenbrock method with the exact Jacobian up to an order. With `β = α + Γ`,
/// a vertex of a rooted tree with one child has `β`, with several children `α`.
fn residuals(scheme: Scheme, order: u32) -> Vec<f64> {
    let RosenbrockTableau { alpha, gamma, weights: b } = definition(scheme);
    let beta: [Row; STAGES] =
        std::array::from_fn(|i| std::array::from_fn(|j| alpha[i][j] + gamma[i][j]));
    let one = [1.0; STAGES];
    let (a1, b1) = (times(&alpha, &one), times(&beta, &one));
    let square = product(&a1, &a1);
    let conditions = [
        (1, sum(&b, &one) - 1.0),
        (2, sum(&b, &b1) - 1.0 / 2.0),
        (3, sum(&b, &square) - 1.0 / 3.0),
        (3, sum(&b, &times(&beta, &b1)) - 1.0 / 6.0),
        (4, sum(&b, &product(&square, &a1)) - 1.0 / 4.0),
        (4, sum(&b, &product(&a1, &times(&alpha, &b1))) - 1.0 / 8.0),
        (4, sum(&b, &times(&beta, &square)) - 1.0 / 12.0),
        (4, sum(&b, &times(&beta, &times(&beta, &b1))) - 1.0 / 24.0),
    ];
    conditions.into_iter().filter(|(p, _)| *p <= order).map(|(_, residual)| residual).collect()
}

/// The further conditions under which any matrix may stand in place of the Jacobian: products of
/// `α` alone meet those of a Runge–Kutta method, and a product with a factor `Γ` vanishes.
fn residuals_of_any_matrix(scheme: Scheme, order: u32) -> Vec<f64> {
    let RosenbrockTableau { alpha, gamma, weights: b } = definition(scheme);
    let one = [1.0; STAGES];
    let (a1, g1) = (times(&alpha, &one), times(&gamma, &one));
    let conditions = [
        (2, sum(&b, &a1) - 1.0 / 2.0),
        (2, sum(&b, &g1)),
        (3, sum(&b, &times(&alpha, &a1)) - 1.0 / 6.0),
        (3, sum(&b, &times(&alpha, &g1))),
        (3, sum(&b, &times(&gamma, &a1))),
        (3, sum(&b, &times(&gamma, &g1))),
    ];
    conditions.into_iter().filter(|(p, _)| *p <= order).map(|(_, residual)| residual).collect()
}

fn worst(residuals: &[f64]) -> f64 {
    residuals.iter().fold(0.0, |worst: f64, r| worst.max(r.abs()))
}

#[test]
fn every_tableau_meets_the_conditions_of_its_order_and_no_more() {
    for scheme in Scheme::ALL {
        let order = scheme.tableau().order.number();
        let found = worst(&residuals(scheme, order));
        // The coefficients of RODAS are of the order of 30, with 16 digits.
        let bound = if scheme == Scheme::Rodas4 { 1e-13 } else { 1e-14 };
        assert!(found < bound, "{scheme:?}: {found:e}");
        let next = worst(&residuals(scheme, order + 1));
        assert!(order == 4 || next > 1e-3, "{scheme:?}: {next:e}");
        let any = worst(&residuals_of_any_matrix(scheme, order));
        let is_w = any < 1e-14;
        assert_eq!(is_w, scheme.tableau().is_w_method(), "{scheme:?}: {any:e}");
        let first = worst(&residuals_of_any_matrix(scheme, 2));
        assert!(is_w || first > 1e-3, "{scheme:?}: order 1 only, {first:e}");
    }
    assert_eq!(Scheme::Ros2.tableau().order_of_any_matrix, Some(Order::Two));
    assert_eq!(Scheme::Ros34pw2.tableau().order_of_any_matrix, Some(Order::Three));
}

#[test]
fn the_form_of_the_step_is_that_of_the_definition() {
    for scheme in Scheme::ALL {
        let t: &Tableau = scheme.tableau();
        let RosenbrockTableau { alpha, gamma, weights } = definition(scheme);
        for i in 0..t.stages {
            assert!((gamma[i][i] - t.gamma).abs() < 1e-15, "{scheme:?}: {}", gamma[i][i]);
            let node: f64 = alpha[i].iter().sum();
            assert!((node - t.nodes[i]).abs() < 1e-13, "{scheme:?}, stage {i}: {node}");
        }
        let repeated: Vec<_> = (0..t.stages).filter(|&i| t.repeats_forces(i)).collect();
        let expected = match scheme {
            Scheme::Ros3p => vec![2],
            Scheme::Rodas3 => vec![1],
            _ => vec![],
        };
        assert_eq!(repeated, expected, "{scheme:?}");
        if scheme == Scheme::Ros34pw2 {
            assert!((weights[3] - 0.435866521508459).abs() < 1e-14, "{weights:?}");
            assert!((alpha[2][1] + 0.11299064236484185).abs() < 1e-14, "{alpha:?}");
        }
    }
}

/// `(θ, η)` and the spectral radius of each tableau, from an independent computation.
#[test]
fn spectral_radii_match_the_golden_table() {
    #[rustfmt::skip]
    let golden = [
        ((0.36, 0.06), [0.9712269931, 0.9640776428, 0.9682030409, 0.9679229704, 0.9704557917]),
        ((1.0, 0.0), [0.9968739365, 0.9652722442, 0.9834180754, 0.9824427735, 0.9999367557]),
        ((100.0, 0.4), [0.4374729687, 0.7365099344, 0.2574436912, 0.2748246532, 0.688652319]),
        ((100.0, 0.0), [0.44485806, 0.7419358183, 0.2613454095, 0.2790632364, 0.7146044688]),
        ((1e4, 0.0), [0.04824210515, 0.7321526997, 0.02666133333, 0.0286928077, 0.08820551143]),
        // A double root: its square root of the round-off shows.
        ((1e4, 200.0), [0.0440587103, 0.7046261209, 0.02462094869, 0.02645452144, 0.07184919252]),
    ];
    for ((theta, eta), radii) in golden {
        for (scheme, expected) in Scheme::ALL.into_iter().zip(radii) {
            let found = rosenbrock(&definition(scheme), (theta, eta), (theta, eta));
            let off = (spectral_radius(&found) - expected).abs() / expected;
            let bound = if eta == 200.0 { 1e-6 } else { 1e-9 };
            assert!(off < bound, "{scheme:?}, {theta}, {eta}: {off:e}");
        }
    }
}

/// `|R(∞)|`: 0, or `√3 − 1` with ROS3P.
#[test]
fn infinitely_stiff_modes_vanish_in_a_step_except_with_ros3p() {
    for scheme in Scheme::ALL {
        let found = spectral_radius(&rosenbrock(&definition(scheme), (1e14, 0.0), (1e14, 0.0)));
        let expected = if scheme == Scheme::Ros3p { 3.0_f64.sqrt() - 1.0 } else { 0.0 };
        assert!((found - expected).abs() < 1e-5, "{scheme:?}: {found}");
    }
}
