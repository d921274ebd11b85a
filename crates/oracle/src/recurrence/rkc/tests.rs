//! RKC2 against values computed elsewhere with 40 digits, and its limits.

use super::*;
use crate::recurrence::spectral_radius;

#[test]
fn spectral_radii_match_the_golden_table() {
    #[rustfmt::skip]
    let table = [
        (3, [0.975_255_803_3, 1.061_887_348, 71.361_931_76, 72.323_189_24, 63_292.122_2]),
        (6, [0.973_328_994, 1.040_178_683, 55.402_713_39, 57.733_717_98, 4_632_539.136]),
        (20, [0.972_922_164_4, 1.035_057_669, 39.671_780_84, 41.852_287, 15_458_565.27]),
    ];
    for (stages, expected) in table {
        let arguments = [(0.36, 0.06), (1.0, 0.0), (100.0, 0.4), (100.0, 0.0), (1e4, 0.0)];
        for ((theta, eta), expected) in arguments.into_iter().zip(expected) {
            let found = spectral_radius(&rkc2(stages, theta, eta));
            let error = (found / expected - 1.0).abs();
            assert!(error < 1e-9, "s={stages} θ={theta} η={eta}: {found}, not {expected}");
        }
    }
    // At θ = 10⁴, η = 200 both eigenvalues are one, `z = −100`: there the polynomial tells.
    for (stages, expected) in [(3, 58_293.395_41), (6, 2_054_160.608), (20, 0.639_056_578_8)] {
        let found = rkc2_polynomial(stages, Complex::new(-100.0, 0.0)).norm();
        assert!((found / expected - 1.0).abs() < 1e-9, "s={stages}: {found}, not {expected}");
    }
}

#[test]
fn the_polynomial_agrees_with_the_exponential_to_second_order() {
    for stages in [2, 3, 7, 50, 200] {
        for z in [Complex::new(-1e-3, 0.0), Complex::new(-3e-4, 1e-3), Complex::new(0.0, 1e-3)] {
            let error = (rkc2_polynomial(stages, z) - z.exp()).norm();
            assert!(error < 0.2 * z.norm().powi(3), "s={stages}, {z}: {error:e}");
        }
    }
}

/// `β(s)`, the extent on the negative real axis.
#[test]
fn the_real_interval_grows_with_the_square_of_the_stages() {
    for (stages, beta) in [(3, 6.18), (6, 22.92), (10, 64.7), (20, 260.8), (50, 1632.9)] {
        let size = |z: f64| rkc2_polynomial(stages, Complex::new(-z, 0.0)).norm();
        for part in 1..1000 {
            assert!(size(1e-3 * f64::from(part) * beta) < 1.0, "s={stages}");
        }
        assert!(size(1.005 * beta) > 1.0, "s={stages}");
    }
}

/// With damping in proportion to the stiffness, `δ = rκ`, a mode has `|z| = 2ζ h/r`: some mode of a
/// mesh is unstable for `h > 2.6 r`, whatever the stages.
#[test]
fn damping_in_proportion_to_the_stiffness_limits_the_step_to_two_and_a_half_of_its_ratio() {
    for (stages, expected) in [(6, 2.34), (10, 2.49), (20, 2.56), (50, 2.58), (200, 2.58)] {
        let is_stable = |ratio: f64| {
            (1..200).all(|k| {
                let zeta = 0.005 * f64::from(k);
                let z = Complex::new(-zeta, (1.0 - zeta * zeta).sqrt()) * (2.0 * zeta * ratio);
                rkc2_polynomial(stages, z).norm() <= 1.0 + 1e-9
            })
        };
        let limit = (1..).map(|k| 0.01 * f64::from(k)).find(|ratio| !is_stable(*ratio));
        let limit = limit.expect("a limit");
        assert!((limit - expected).abs() < 0.02, "s={stages}: {limit}");
    }
}

/// Complex pairs with the damping ratio ζ: the radius hardly depends on the stages. These are the
/// radii for `s = 6` and for `s = 20` and more.
#[test]
fn the_radius_of_a_complex_pair_does_not_grow_with_the_stages() {
    let radius = |stages: u32, zeta: f64| {
        let z = |r: f64| Complex::new(-zeta, (1.0 - zeta * zeta).sqrt()) * r;
        let outside = (1..).find(|k| rkc2_polynomial(stages, z(0.01 * f64::from(*k))).norm() > 1.0);
        0.01 * f64::from(outside.expect("bounded"))
    };
    let table = [
        (0.9, 4.24, 4.7),
        (0.7, 3.5, 3.78),
        (0.5, 2.99, 3.18),
        (0.3, 2.39, 2.53),
        (0.1, 1.52, 1.6),
    ];
    for (zeta, six, many) in table {
        assert!((radius(6, zeta) - six).abs() < 0.02, "{zeta}: {}", radius(6, zeta));
        for stages in [20, 50, 200] {
            assert!((radius(stages, zeta) - many).abs() < 0.04, "{zeta}: {}", radius(stages, zeta));
        }
    }
}
