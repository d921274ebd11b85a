//! Order conditions, stability, and spectral radii that were computed elsewhere.

use super::*;
use crate::recurrence::{implicit_midpoint, spectral_radius};
use nalgebra::Matrix2;

fn all() -> [(&'static str, RungeKutta, u32); 6] {
    [
        ("midpoint", RungeKutta::midpoint(), 2),
        ("TR-BDF2", RungeKutta::tr_bdf2(), 2),
        ("SDIRK2", RungeKutta::sdirk2(), 2),
        ("SDIRK3", RungeKutta::sdirk3(), 3),
        ("ESDIRK3", RungeKutta::esdirk3(), 3),
        ("SDIRK4", RungeKutta::sdirk4(), 4),
    ]
}

/// The eight conditions of order up to 4.
#[test]
fn the_tableaux_satisfy_their_order_conditions() {
    for (name, method, order) in all() {
        let (a, b) = (method.matrix(), DVector::from_row_slice(&method.b));
        let one = DVector::from_element(b.len(), 1.0);
        let c = &a * &one;
        let c2 = c.component_mul(&c);
        let conditions = [
            (1, b.sum(), 1.0),
            (2, b.dot(&c), 1.0 / 2.0),
            (3, b.dot(&c2), 1.0 / 3.0),
            (3, b.dot(&(&a * &c)), 1.0 / 6.0),
            (4, b.dot(&c2.component_mul(&c)), 1.0 / 4.0),
            (4, b.dot(&c.component_mul(&(&a * &c))), 1.0 / 8.0),
            (4, b.dot(&(&a * &c2)), 1.0 / 12.0),
            (4, b.dot(&(&a * (&a * &c))), 1.0 / 24.0),
        ];
        for (of, found, expected) in conditions {
            let holds = (found - expected).abs() < 1e-14;
            assert!(holds || of > order, "{name}, order {of}: {found}, not {expected}");
        }
        let misses = conditions
            .iter()
            .any(|(of, found, expected)| *of == order + 1 && (found - expected).abs() > 1e-4);
        assert!(misses || order == 4, "{name} has a higher order than {order}");
        let last = a.row(b.len() - 1).transpose();
        assert!(name == "midpoint" || last == b, "{name} is stiffly accurate");
    }
}

#[test]
fn midpoint_as_a_tableau_is_midpoint_as_a_matrix() {
    for (theta, eta) in [(0.36, 0.06), (100.0, 0.4), (1e4, 200.0)] {
        let difference =
            RungeKutta::midpoint().amplification(theta, eta) - implicit_midpoint(theta, eta);
        assert!(difference.norm() < 1e-13 * (1.0 + theta), "{difference}");
    }
}

#[test]
fn spectral_radii_match_the_golden_table() {
    const POINTS: [(f64, f64); 6] =
        [(0.36, 0.06), (1.0, 0.0), (100.0, 0.4), (100.0, 0.0), (1e4, 0.0), (1e4, 200.0)];
    let second =
        [0.9712269931, 0.9968739365, 0.4374729687, 0.44485806, 0.04824210515, 0.0440587103];
    let third =
        [0.9679229704, 0.9824427735, 0.2748246532, 0.2790632364, 0.0286928077, 0.02645452144];
    let fourth =
        [0.9704600629, 0.9999821185, 0.71789919, 0.7450069504, 0.09309472579, 0.07573345601];
    let midpoint = [0.9728456051, 1.0, 0.9923370518, 1.0, 1.0, 0.9607843137];
    for ((name, method, _), radii) in
        all().into_iter().zip([midpoint, second, second, third, third, fourth])
    {
        for ((theta, eta), expected) in POINTS.into_iter().zip(radii) {
            let found = spectral_radius(&method.amplification(theta, eta));
            // At (10⁴, 200) both eigenvalues are one: round-off enters by its square root.
            let close = if eta == 200.0 { 3e-7 } else { 1.01e-10 };
            assert!((found - expected).abs() < close, "{name}, θ={theta} η={eta}: {found}");
        }
    }
}

/// `|R(iy)| ≤ 1`, and `R(∞) = 0` for all but midpoint.
#[test]
fn all_are_stable_on_the_imaginary_axis_and_vanish_at_infinity() {
    for (name, method, _) in all() {
        for power in -30..=50 {
            let y = 10.0_f64.powf(0.1 * f64::from(power));
            let radius = spectral_radius(&method.amplification(y * y, 0.0));
            assert!(radius <= 1.0 + 1e-9, "{name}, y = {y}: {radius}");
        }
        let far = spectral_radius(&method.amplification(1e14, 0.0));
        assert!(name == "midpoint" || far < 1e-5, "{name}: {far}");
    }
}

#[test]
fn a_step_follows_the_exact_motion_up_to_its_order() {
    for (name, method, order) in all() {
        let error = |h: f64| {
            let exact = Matrix2::new(0.0, 1.0, -h * h, -0.2 * h).exp();
            let wrong = method.amplification(h * h, 0.2 * h) - exact;
            let wrong = wrong * nalgebra::Vector2::new(1.0, 0.7 * h);
            wrong.x.hypot(wrong.y / h)
        };
        let slope = (error(0.08) / error(0.04)).log2();
        assert!((slope - f64::from(order + 1)).abs() < 0.15, "{name}: {slope}");
    }
}
