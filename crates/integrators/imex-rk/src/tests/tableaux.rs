//! Order conditions, and the recurrences of the oscillator.

use super::NAMES;
use crate::{Pair, STAGES, Tableau};
use drape_integrator::Order;
use drape_oracle::recurrence::{AdditiveTableau, additive_runge_kutta, spectral_radius};

type Row = [f64; STAGES];

pub(super) fn additive(pair: Pair) -> AdditiveTableau<STAGES> {
    let &Tableau { explicit, implicit, explicit_weights, implicit_weights, .. } = pair.tableau();
    AdditiveTableau { explicit, implicit, explicit_weights, implicit_weights }
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

/// The conditions of a partitioned method whose parts have the same nodes: every vertex of a rooted
/// tree may belong to either part.
fn residuals(t: &Tableau, order: Order) -> Vec<f64> {
    let (c, one) = (t.nodes, [1.0; STAGES]);
    let weights = [t.explicit_weights, t.implicit_weights];
    let matrices = [t.explicit, t.implicit];
    let mut found = Vec::new();
    let mut check = |b: &Row, phi: &Row, value: f64| found.push(sum(b, phi) - value);
    for b in &weights {
        check(b, &one, 1.0);
        check(b, &c, 1.0 / 2.0);
        if order.number() < 3 {
            continue;
        }
        check(b, &product(&c, &c), 1.0 / 3.0);
        for a in &matrices {
            check(b, &times(a, &c), 1.0 / 6.0);
        }
        if order.number() < 4 {
            continue;
        }
        check(b, &product(&c, &product(&c, &c)), 1.0 / 4.0);
        for a in &matrices {
            check(b, &product(&c, &times(a, &c)), 1.0 / 8.0);
            check(b, &times(a, &product(&c, &c)), 1.0 / 12.0);
            for inner in &matrices {
                check(b, &times(a, &times(inner, &c)), 1.0 / 24.0);
            }
        }
    }
    found
}

#[test]
fn every_tableau_meets_the_conditions_of_its_order_and_no_more() {
    for pair in Pair::ALL {
        let t = pair.tableau();
        let worst =
            |order| residuals(t, order).iter().fold(0.0, |worst: f64, r| worst.max(r.abs()));
        assert!(worst(t.order) < 1e-14, "{pair:?}: {:e}", worst(t.order));
        let next = match t.order {
            Order::Two => Order::Three,
            _ => Order::Four,
        };
        assert!(next == t.order || worst(next) > 1e-3, "{pair:?}: {:e}", worst(next));
    }
}

#[test]
fn both_parts_have_the_same_nodes_and_one_matrix_serves_all_stages() {
    for pair in Pair::ALL {
        let t = pair.tableau();
        for i in 0..t.stages {
            let row: f64 = t.implicit[i].iter().sum();
            assert!((row - t.nodes[i]).abs() < 1e-14, "{pair:?}, stage {i}: {row}");
            let diagonal = if i == 0 { 0.0 } else { t.gamma() };
            assert_eq!(t.implicit[i][i], diagonal, "{pair:?}, stage {i}");
            assert!(t.implicit[i][i + 1..].iter().all(|a| *a == 0.0), "{pair:?}, stage {i}");
            assert!(t.explicit[i][i..].iter().all(|a| *a == 0.0), "{pair:?}, stage {i}");
        }
        let ends = matches!(pair, Pair::Ars222 | Pair::Ars443);
        assert_eq!(t.corrections() == [0.0; STAGES], ends, "{pair:?}");
        assert_eq!(t.takes_first_slope(), !ends, "{pair:?}");
        assert_eq!(t.implicit_weights, t.implicit[t.stages - 1], "{pair:?}: stiffly accurate");
    }
}

/// `(θ_I, θ_E, η)` and the spectral radius of each tableau, from an independent computation.
#[test]
fn spectral_radii_match_the_golden_table() {
    #[rustfmt::skip]
    let golden = [
        ((1.0, 0.0, 0.0), [0.9968739365, 0.9834180754, 0.9824427735, 0.9999821185]),
        ((0.36, 0.0, 0.06), [0.9712269931, 0.9682030409, 0.9679229704, 0.9704600629]),
        ((100.0, -50.0, 0.0), [0.5691414244, 0.439036327, 0.3703962007, 0.6475729784]),
        ((1.0, 0.5, 0.1), [0.9533754441, 0.9331606515, 0.9399407659, 0.9522203144]),
        ((100.0, -99.0, 0.0), [0.9168497928, 0.937103789, 0.9839843499, 0.9962953856]),
        ((100.0, -100.0, 0.0), [1.0, 1.0, 1.0, 1.0]),
        ((100.0, -110.0, 0.0), [1.790843064, 1.685942041, 2.288051847, 5.41344297]),
        ((100.0, 50.0, 0.0), [1.753242716, 0.2477448468, 1.305791432, 1.849929269]),
    ];
    for ((implicit, explicit, eta), radii) in golden {
        for (pair, expected) in Pair::ALL.into_iter().zip(radii) {
            let found = additive_runge_kutta(&additive(pair), implicit, explicit, eta);
            let off = (spectral_radius(&found) - expected).abs() / expected;
            assert!(off < 1e-9, "{pair:?}, {implicit}, {explicit}, {eta}: {off:e}");
        }
    }
}

/// Across a spring at its rest length a step is `[[1, c], [0, g]]`: it keeps the share `g` of the
/// velocity and moves by `c h v`. These are `c(100)`, `c(10⁴)`, `g(100)`.
#[test]
fn a_stiff_spring_locks_the_displacement_apart_from_the_velocity() {
    let golden = [
        (Pair::Ars222, 0.13178436, 0.00150495, 0.19789869),
        (Pair::Ars443, 0.06864334, 0.00069988, 0.04208743),
        (Pair::Ark3, 0.04888280, 0.00048564, 1.0),
        (Pair::Ark4, 0.27566745, 0.00279437, 1.0),
    ];
    for (pair, c_stiff, c_stiffer, g_stiff) in golden {
        let at = |theta: f64| additive_runge_kutta(&additive(pair), theta, -theta, 0.0);
        for theta in [1e-3, 1.0, 100.0, 1e4, 1e8] {
            let r = at(theta);
            let scale = 1e-15 * theta;
            assert!((r.m11 - 1.0).abs() + r.m21.abs() < 1e-13 + scale, "{pair:?}, {theta}: {r}");
        }
        assert!((at(100.0).m12 - c_stiff).abs() < 1e-8, "{pair:?}: c {}", at(100.0).m12);
        assert!((at(1e4).m12 - c_stiffer).abs() < 1e-8, "{pair:?}: c {}", at(1e4).m12);
        assert!((at(100.0).m22 - g_stiff).abs() < 1e-8, "{pair:?}: g {}", at(100.0).m22);
        assert!((at(0.0).m12 - 1.0).abs() < 1e-14 && (at(0.0).m22 - 1.0).abs() < 1e-14);
    }
    // The limits θ c and θ g, which tell how fast a stiffer sheet stands still.
    let limits = [
        (Pair::Ars222, 15.07, 23.3),
        (Pair::Ars443, 7.00, 3.78),
        (Pair::Ark3, 4.86, f64::INFINITY),
        (Pair::Ark4, 27.9, f64::INFINITY),
    ];
    for (pair, c, g) in limits {
        let (theta, r) = (1e8, additive_runge_kutta(&additive(pair), 1e8, -1e8, 0.0));
        assert!((theta * r.m12 / c - 1.0).abs() < 5e-3, "{pair:?}: {}", theta * r.m12);
        if g.is_finite() {
            assert!((theta * r.m22 / g - 1.0).abs() < 5e-3, "{pair:?}: {}", theta * r.m22);
        } else {
            assert!((r.m22 - 1.0).abs() < 1e-7, "{pair:?}: {}", r.m22);
        }
    }
}

/// The greatest and the least `r = θ_E/θ_I` at which a step is stable for every `θ_I`.
#[test]
fn explicit_stiffness_beside_the_implicit_one_has_a_limit() {
    let stable = |pair, ratio: f64| {
        (-40..=140).all(|power| {
            let theta = 10_f64.powf(0.05 * f64::from(power));
            let r = additive_runge_kutta(&additive(pair), theta, ratio * theta, 0.0);
            spectral_radius(&r) <= 1.0 + 1e-9
        })
    };
    let golden = [
        (Pair::Ars222, 0.17, -1.0),
        (Pair::Ars443, 0.57, -0.49),
        (Pair::Ark3, 0.25, -1.0),
        (Pair::Ark4, 0.05, -0.08),
    ];
    for (pair, most, least) in golden {
        let limit = |sign: f64| {
            let steps = (1..=220).take_while(|k| stable(pair, sign * 0.005 * f64::from(*k)));
            0.005 * sign * f64::from(steps.last().unwrap_or(0))
        };
        let (found_most, found_least) = (limit(1.0), limit(-1.0));
        assert!((found_most - most).abs() < 0.0151, "{pair:?}: {found_most}");
        assert!((found_least - least).abs() < 0.0151, "{pair:?}: {found_least}");
    }
    assert_eq!(NAMES.map(|(_, pair)| pair), Pair::ALL);
}
