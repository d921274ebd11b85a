//! Spectral radii against independent values: roots of the characteristic polynomials, computed
//! elsewhere with 40 digits.

use super::*;

/// A printed number holds to half of its last digit; a whole one is exact.
fn assert_printed(printed: &str, found: f64, case: &str) {
    let expected: f64 = printed.parse().expect("a number");
    let decimals = printed.split_once('.').map(|(_, decimals)| decimals.len());
    let tolerance = decimals.map_or(1e-12, |n| 0.51 * 0.1_f64.powi(n as i32));
    assert!((found - expected).abs() <= tolerance, "{case}: {found}, not {printed}");
}

#[test]
fn spectral_radii_on_the_oscillator_match_the_golden_table() {
    let names = ["FE", "SE", "SEi", "BE", "midpoint", "BDF2", "AB2", "TF88"];
    #[rustfmt::skip]
    let table = [
        ((0.36, 0.06), ["1.140175425099", "0.969535971483", "0.971285862357", "0.839181358297",
                        "0.972845605134", "0.960430687463", "1.022636719997", "0.835369215748"]),
        ((100.0, 0.4), ["10.029955134496", "98.393902061129", "69.704038306364", "0.099307265287",
                        "0.992337051826", "0.299261781144", "14.986654277395", "0.088910844895"]),
        ((100.0, 0.0), ["10.049875621121", "97.989794855664", "97.989794855664", "0.099503719021",
                        "1", "0.300749568269", "15.000014689889", "0.099503719021"]),
        ((1.0, 0.0), ["1.414213562373", "1", "1", "0.707106781187",
                      "1", "0.933321058436", "1.522339130833", "0.707106781187"]),
    ];
    for ((theta, eta), printed) in table {
        let found = [
            spectral_radius(&explicit_euler(theta, eta)),
            spectral_radius(&symplectic_euler(theta, eta)),
            spectral_radius(&symplectic_euler_implicit_damping(theta, eta)),
            spectral_radius(&backward_euler(theta, eta)),
            spectral_radius(&implicit_midpoint(theta, eta)),
            bdf(2, theta, eta).spectral_radius(),
            adams_bashforth(2, theta, eta).spectral_radius(),
            spectral_radius(&terzopoulos_fleischer(theta, eta)),
        ];
        for ((name, printed), found) in names.into_iter().zip(printed).zip(found) {
            assert_printed(printed, found, &format!("{name}, θ={theta} η={eta}"));
        }
    }
}

#[test]
fn spectral_radii_with_a_split_stiffness_match_the_golden_table() {
    let methods = [
        ("IMEX1", Multistep::imex_euler()),
        ("SBDF2", Multistep::sbdf2(1.0)),
        ("CNAB2", Multistep::cnab2(1.0)),
        ("MCNAB2", Multistep::mcnab2(1.0)),
        ("CNLF", Multistep::cnlf()),
    ];
    #[rustfmt::skip]
    let table = [
        ((1.0, 0.0, 0.0),
            ["0.707106781187", "0.933321058436", "1", "0.983522325952", "1"]),
        ((0.36, 0.0, 0.06),
            ["0.839181358297", "0.960430687463", "0.972845605134", "0.971270146751", "0.978168677648"]),
        ((100.0, -50.0, 0.0),
            ["0.494843144718", "0.713325935937", "0.924612366832", "0.756893822811", "1"]),
        ((1.0, 0.5, 0.1),
            ["0.690065559342", "0.915603673259", "1.021848644729", "0.979882987471", "0.979552267598"]),
        ((100.0, -99.0, 0.0), ["0.989999", "0.995086", "0.995183", "0.995700", "1.000000"]),
        ((100.0, -110.0, 0.0), ["1.099909", "1.427991", "1.611801", "1.567649", "1.551864"]),
        ((100.0, 50.0, 0.0), ["0.453411", "1.252958", "2.378987", "1.964596", "1.000000"]),
    ];
    for ((implicit, explicit, eta), printed) in table {
        for ((name, method), printed) in methods.iter().zip(printed) {
            let found = method.recurrence(implicit, explicit, eta).spectral_radius();
            let case = format!("{name}, θ_I={implicit} θ_E={explicit} η={eta}");
            assert_printed(printed, found, &case);
        }
        let found = spectral_radius(&imex_euler(implicit, explicit, eta));
        assert_printed(printed[0], found, "IMEX1 as a matrix");
    }
}

/// At a rate within `(0, ρ)` Chebyshev's polynomials shrink the error as fast as theory says:
/// `ρ^k/(1 + √(1 − ρ²))^k`, up to a factor 2.
#[test]
fn chebyshev_iterations_reach_their_asymptotic_rate() {
    let (rho, count) = (0.95_f64, 60);
    let each = rho / (1.0 + (1.0 - rho * rho).sqrt());
    for rate in [0.3, 0.7, 0.9, 0.95] {
        let left = chebyshev_left(rate, rho, 1, count).abs();
        assert!(left <= 2.01 * each.powi(count as i32), "{rate}: {left:e}");
    }
    assert!(chebyshev_left(0.99, rho, 1, count) > 0.01, "a guess too low helps little");
}

/// What is left of the start lets the step run on without a force.
#[test]
fn projective_dynamics_lies_between_free_flight_and_backward_euler() {
    let (theta, eta) = (100.0, 0.4);
    assert_eq!(projective(theta, eta, 0.0), backward_euler_of(theta, eta));
    assert_eq!(projective(theta, eta, 1.0), Amplification::new(1.0, 1.0, 0.0, 1.0));
    let radius = spectral_radius(&projective(theta, eta, projective_rate(100.0, -50.0, 0.4)));
    assert!(radius > spectral_radius(&backward_euler(theta, eta)), "{radius}");
}

/// Backward Euler in the order of operations of [`projective`].
fn backward_euler_of(theta: f64, eta: f64) -> Amplification {
    let d = 1.0 + theta + eta;
    let found = Amplification::new(1.0 - theta / d, 1.0 / d, -theta / d, 1.0 / d);
    assert!((found - backward_euler(theta, eta)).norm() < 1e-15);
    found
}
