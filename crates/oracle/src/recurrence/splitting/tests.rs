//! Kicks and drifts against values computed elsewhere with 40 digits, their orders and limits.

use super::*;
use crate::recurrence::spectral_radius;

/// So many terms that the kick is the exact one.
const EXACT: u32 = 40;

#[test]
fn spectral_radii_match_the_golden_table() {
    let table = [
        ((0.36, 0.06), 0.970_445_533_5),
        ((1.0, 0.0), 1.0),
        ((100.0, 0.4), 3_471.974_007),
        ((100.0, 0.0), 4_234.752_762),
    ];
    for ((theta, eta), expected) in table {
        let found = spectral_radius(&srkn4(theta, eta, EXACT));
        assert!((found / expected - 1.0).abs() < 1e-9, "{found}, not {expected}");
    }
    // Far beyond its limits. There the series of a kick cancels; the closed form does not.
    let undamped = spectral_radius(&srkn4(1e4, 0.0, EXACT));
    assert!((undamped / 1.271_236_594e16 - 1.0).abs() < 1e-9, "{undamped:e}");
    let damped = spectral_radius(&with_exact_kicks(1e4, 200.0));
    assert!((damped / 2.165_925_48e14 - 1.0).abs() < 1e-9, "{damped:e}");
    let same = with_exact_kicks(0.36, 0.06) - srkn4(0.36, 0.06, EXACT);
    assert!(same.norm() < 1e-14, "{same}");
}

/// The method with kicks in closed form.
fn with_exact_kicks(theta: f64, eta: f64) -> Amplification {
    let ([b1, b2, b3], [a1, a2]) = BLANES_MOAN;
    let kick = |share: f64| {
        let keep = libm::exp(-share * eta);
        Amplification::new(1.0, 0.0, -theta * (1.0 - keep) / eta, keep)
    };
    let (b4, a3) = (1.0 - 2.0 * (b1 + b2 + b3), 0.5 - a1 - a2);
    let rest = [(a1, b2), (a2, b3), (a3, b4), (a3, b3), (a2, b2), (a1, b1)];
    rest.into_iter().fold(kick(b1), |step, (a, b)| kick(b) * drift(a) * step)
}

/// The local error against the exact solution falls like `h^{p+1}`.
#[test]
fn the_orders_are_four_with_five_terms_and_two_with_two() {
    type Rule = fn(f64, f64) -> Amplification;
    let rules: [(Rule, i32); 3] = [
        (|t, e| srkn4(t, e, 5), 4),
        (leapfrog_explicit_damping, 2),
        (|t, e| impulse(0.7 * t, 0.3 * t, e, 3), 2),
    ];
    for (place, (rule, order)) in rules.into_iter().enumerate() {
        let error = |h: f64| {
            let (theta, eta) = (h * h, 0.4 * h);
            let flow = Matrix2::new(0.0, 1.0, -theta, -eta).exp();
            let error = rule(theta, eta) - flow;
            // On (x, v): w = hv.
            Matrix2::new(error.m11, error.m12 * h, error.m21 / h, error.m22).norm()
        };
        let observed = (error(0.2) / error(0.1)).log2();
        assert!((observed - f64::from(order + 1)).abs() < 0.15, "rule {place}: {observed}");
    }
}

/// A hairline of instability at `ωh = π`, and the limit.
#[test]
fn undamped_srkn4_is_stable_below_five_but_for_a_hairline_at_pi() {
    let growth = |omega: f64| spectral_radius(&srkn4(omega * omega, 0.0, 5)) - 1.0;
    for step in 1..5026 {
        let omega = 1e-3 * f64::from(step);
        let is_hairline = (3.1635..3.1687).contains(&omega);
        let most = if is_hairline { 2.4e-3 } else { 1e-9 };
        assert!(growth(omega) < most, "{omega}: {:e}", growth(omega));
    }
    assert!(growth(3.166) > 2e-3 && growth(5.028) > 1e-3);
}

#[test]
fn leapfrog_with_explicit_damping_is_stable_where_its_rule_says() {
    for k in 0..90 {
        let eta = 0.05 * f64::from(k) + 0.01;
        let p = 1.0 - 0.5 * eta + 0.125 * eta * eta;
        let limit = 4.0 * (1.0 + p * p) / ((1.0 + p) * (1.0 - 0.25 * eta));
        for theta in [0.5 * limit, 0.999 * limit, 1.001 * limit, 3.999] {
            let stable = spectral_radius(&leapfrog_explicit_damping(theta, eta)) <= 1.0 + 1e-9;
            assert_eq!(stable, eta < 4.0 && theta < limit, "θ={theta} η={eta}");
        }
        assert!(eta >= 4.0 || limit >= 4.0, "η={eta}: {limit}");
    }
}

/// The slow stiffness excites the fast mode where half of its period is a little less than the
/// step.
#[test]
fn the_impulse_method_is_unstable_in_resonance() {
    let growth = |fast: f64, slow: f64| spectral_radius(&impulse(fast, slow, 0.0, 64)) - 1.0;
    let pi = std::f64::consts::PI;
    assert!(growth(3.06 * 3.06, 0.5) > 0.05, "{}", growth(3.06 * 3.06, 0.5));
    assert!(growth(3.12 * 3.12, 0.1) > 0.01, "also where the slow stiffness is small");
    assert!(growth(0.25 * pi * pi, 0.5) < 1e-9, "half of it is safe");
    assert!(growth(2.25 * pi * pi, 0.5) < 1e-9, "between two resonances, too");
}
