//! Spectral radii that were computed elsewhere, relations between the members, order.

use super::*;
use crate::recurrence::implicit_midpoint;
use nalgebra::{Matrix2, Vector2};

#[test]
fn spectral_radii_match_the_golden_table() {
    const POINTS: [(f64, f64); 6] =
        [(0.36, 0.06), (1.0, 0.0), (100.0, 0.4), (100.0, 0.0), (1e4, 0.0), (1e4, 200.0)];
    let table = [
        (
            GeneralizedAlpha::chung_hulbert(1.0),
            [0.9728456051, 1.0, 0.9923370518, 1.0, 1.0, 0.9607843163],
        ),
        (
            GeneralizedAlpha::chung_hulbert(0.8),
            [0.9729075792, 0.999474614, 0.9231329368, 0.9297917672, 0.8346376088, 0.784790821],
        ),
        (
            GeneralizedAlpha::chung_hulbert(0.5),
            [0.972098134, 0.989312786, 0.6773079925, 0.6825284215, 0.5371736239, 0.4944681764],
        ),
        (
            GeneralizedAlpha::chung_hulbert(0.0),
            [0.9523300975, 0.9065633333, 0.2427674957, 0.242535625, 0.04783128168, 0.0990147543],
        ),
        (
            GeneralizedAlpha::hht(0.1),
            [0.9724814179, 0.9938473293, 0.8316232339, 0.837802834, 0.8184023292, 0.7866466095],
        ),
    ];
    for (method, radii) in table {
        for ((theta, eta), expected) in POINTS.into_iter().zip(radii) {
            let found = method.spectral_radius(theta, eta);
            // The last column has double roots; the table knows them to seven digits.
            let close = if eta == 200.0 { 3e-7 } else { 1.01e-10 };
            assert!((found - expected).abs() < close, "{method:?}, θ={theta} η={eta}: {found}");
        }
    }
}

#[test]
fn the_radius_at_infinite_stiffness_is_the_one_that_was_asked_for() {
    for rho in [0.0, 0.3, 0.5, 0.8, 1.0] {
        for method in [GeneralizedAlpha::chung_hulbert(rho), GeneralizedAlpha::newmark(rho)] {
            let found = method.spectral_radius(1e12, 0.0);
            // Roots that meet at infinity part like the cube root of 1/θ.
            assert!((found - rho).abs() < 2e-3, "{method:?}: {found}");
        }
        let alpha = (1.0 - rho) / (1.0 + rho);
        if rho >= 0.5 {
            let found = GeneralizedAlpha::hht(alpha).spectral_radius(1e12, 0.0);
            assert!((found - rho).abs() < 2e-3, "{rho}: {found}");
        }
    }
    assert_eq!(GeneralizedAlpha::hht(0.0), GeneralizedAlpha::newmark(1.0));
}

/// HHT with α = ⅓ and Chung-Hulbert with ρ = ½ have the same matrix.
#[test]
fn the_most_damped_hht_is_chung_hulberts_method() {
    let (hht, ch) = (GeneralizedAlpha::hht(1.0 / 3.0), GeneralizedAlpha::chung_hulbert(0.5));
    for (theta, eta) in [(0.36, 0.06), (100.0, 0.4)] {
        let difference = hht.matrix(theta, eta) - ch.matrix(theta, eta);
        assert!(difference.norm() < 1e-13, "{difference}");
    }
}

#[test]
fn newmarks_trapezoid_from_a_consistent_start_is_midpoint_on_linear_springs() {
    let method = GeneralizedAlpha::newmark(1.0);
    for (theta, eta) in [(0.36, 0.06), (100.0, 0.4), (1e4, 200.0)] {
        let (x, w) = (0.7, -0.3);
        let next = method.matrix(theta, eta) * GeneralizedAlpha::start(x, w, theta, eta);
        let expected = implicit_midpoint(theta, eta) * Vector2::new(x, w);
        let error = (next.xy() - expected).norm() / (1.0 + theta);
        assert!(error < 1e-14, "θ={theta} η={eta}: {error:e}");
        let consistent = GeneralizedAlpha::start(next.x, next.y, theta, eta).z;
        assert!((next.z - consistent).abs() < 1e-13 * (1.0 + theta), "{next}");
    }
}

#[test]
fn the_members_have_their_order() {
    for (method, order) in [
        (GeneralizedAlpha::chung_hulbert(1.0), 2.0),
        (GeneralizedAlpha::chung_hulbert(0.5), 2.0),
        (GeneralizedAlpha::chung_hulbert(0.0), 2.0),
        (GeneralizedAlpha::hht(0.1), 2.0),
        (GeneralizedAlpha::newmark(1.0), 2.0),
        (GeneralizedAlpha::newmark(0.5), 1.0),
    ] {
        let error = |steps: u32| {
            let h = 1.0 / f64::from(steps);
            let (theta, eta) = (h * h, 0.2 * h);
            let mut y = GeneralizedAlpha::start(1.0, 0.7 * h, theta, eta);
            for _ in 0..steps {
                y = method.matrix(theta, eta) * y;
            }
            let exact = Matrix2::new(0.0, 1.0, -1.0, -0.2).exp() * Vector2::new(1.0, 0.7);
            (y.x - exact.x).hypot(y.y / h - exact.y)
        };
        let slope = (error(100) / error(200)).log2();
        assert!((slope - order).abs() < 0.05, "{method:?}: {slope}");
    }
}
