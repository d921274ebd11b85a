//! The table of coefficients, from the conditions that define it.

use super::*;
use drape_oracle::recurrence::Multistep;

fn oracle(c: Coefficients) -> Multistep {
    Multistep { a: c.a.to_vec(), b: c.b.to_vec(), c: vec![0.0, c.c[0], c.c[1]] }
}

/// Inserting `t^q` for `q ≤ 2` into the formula leaves nothing, for the implicit part as for the explicit
/// one, at every ratio of steps.
#[test]
fn every_row_has_order_two_at_every_ratio_of_steps() {
    for (scheme, omega) in
        SCHEMES.into_iter().flat_map(|s| (0..=30).map(move |k| (s, 0.5 + 0.05 * f64::from(k))))
    {
        let Some(c) = scheme.coefficients(omega) else {
            assert!(scheme == Scheme::Cnlf && omega != 1.0, "{scheme:?} at ω = {omega}");
            continue;
        };
        // Times of the levels in units of the new step.
        let times = [1.0, 0.0, -1.0 / omega];
        let sum = |weights: &[f64], times: &[f64], f: &dyn Fn(f64) -> f64| -> f64 {
            weights.iter().zip(times).map(|(w, &t)| w * f(t)).sum()
        };
        for q in 0..=2 {
            let slope = |t: f64| if q == 0 { 0.0 } else { f64::from(q) * t.powi(q - 1) };
            let left = sum(&c.a, &times, &|t| t.powi(q));
            for right in [sum(&c.b, &times, &slope), sum(&c.c, &times[1..], &slope)] {
                assert!(
                    (left - right).abs() < 1e-14,
                    "{scheme:?}, ω = {omega}, t^{q}: {left} {right}"
                );
            }
        }
    }
}

/// Of the two that order 2 leaves open: SBDF2 takes the implicit force at the new level only, the others
/// difference over one step; CNLF does both over two.
#[test]
fn the_rows_are_those_that_the_oracle_derives_by_interpolation() {
    for omega in [0.5, 0.8, 1.0, 1.7, 2.0] {
        for (scheme, expected) in [
            (Scheme::Sbdf2, Multistep::sbdf2(omega)),
            (Scheme::Cnab2, Multistep::cnab2(omega)),
            (Scheme::Mcnab2, Multistep::mcnab2(omega)),
        ] {
            let found = oracle(scheme.coefficients(omega).unwrap());
            let pairs = [(&found.a, &expected.a), (&found.b, &expected.b), (&found.c, &expected.c)];
            for (found, expected) in pairs.into_iter().flat_map(|(a, b)| a.iter().zip(b)) {
                assert!((found - expected).abs() < 1e-14, "{scheme:?} at ω = {omega}");
            }
        }
    }
    assert_eq!(oracle(Scheme::Cnlf.at_constant_step()), Multistep::cnlf());
}

#[test]
fn the_new_velocity_acts_for_the_time_of_the_table() {
    let share = |scheme: Scheme, omega| scheme.coefficients(omega).unwrap().tau(1.0);
    let found = SCHEMES.map(|scheme| share(scheme, 1.0));
    for (found, expected) in found.into_iter().zip([2.0 / 3.0, 0.5, 9.0 / 16.0, 1.0]) {
        assert!((found - expected).abs() < 1e-15, "{found}, not {expected}");
    }
    assert!((share(Scheme::Sbdf2, 0.5) - 0.75).abs() < 1e-15);
}

#[test]
fn a_jump_of_the_step_by_more_than_two_is_a_new_beginning() {
    for scheme in VARIABLE {
        let known =
            [0.499, 0.5, 2.0, 2.001, f64::NAN].map(|omega| scheme.coefficients(omega).is_some());
        assert_eq!(known, [false, true, true, false, false], "{scheme:?}");
    }
}

/// Largest root of `A² + ηAB + θ_I B² + θ_E BC`, golden numbers to the printed digit.
#[test]
fn spectral_radii_are_the_golden_ones() {
    let table = [
        ((1.0, 0.0, 0.0), [0.933321058436, 1.0, 0.983522325952, 1.0], 12),
        ((0.36, 0.0, 0.06), [0.960430687463, 0.972845605134, 0.971270146751, 0.978168677648], 12),
        ((100.0, -50.0, 0.0), [0.713325935937, 0.924612366832, 0.756893822811, 1.0], 12),
        ((1.0, 0.5, 0.1), [0.915603673259, 1.021848644729, 0.979882987471, 0.979552267598], 12),
        ((100.0, -99.0, 0.0), [0.995086, 0.995183, 0.995700, 1.000000], 6),
        ((100.0, -110.0, 0.0), [1.427991, 1.611801, 1.567649, 1.551864], 6),
        ((100.0, 50.0, 0.0), [1.252958, 2.378987, 1.964596, 1.000000], 6),
    ];
    for ((implicit, explicit, eta), radii, digits) in table {
        for (scheme, expected) in SCHEMES.into_iter().zip(radii) {
            let recurrence = oracle(scheme.at_constant_step()).recurrence(implicit, explicit, eta);
            let found = recurrence.spectral_radius();
            let error = (found - expected).abs();
            // A double root on the unit circle is known to the root of round-off.
            let tolerance = if expected == 1.0 { 1e-7 } else { 0.51 * 10f64.powi(-digits) };
            assert!(
                error < tolerance,
                "{scheme:?} ({implicit}, {explicit}, {eta}): {found}, not {expected}"
            );
        }
    }
}

/// Sideways motion at rest length has `θ_E = −θ_I`: the polynomial and its derivative vanish at 1 for every
/// stiffness, so that velocities across springs are kept. What else there is is parasitic.
#[test]
fn free_rotation_is_a_double_root_at_one_at_any_stiffness() {
    for (scheme, theta) in
        SCHEMES.into_iter().flat_map(|s| [0.01, 1.0, 100.0, 1e4_f64].map(|t| (s, t)))
    {
        let Coefficients { a, b, c } = scheme.at_constant_step();
        // (value, derivative) at 1 of a polynomial with the newest coefficient first.
        let at_one = |p: [f64; 3]| (p[0] + p[1] + p[2], 2.0 * p[0] + p[1]);
        let (value_a, _) = at_one(a);
        let ((value_b, slope_b), (value_c, slope_c)) = (at_one(b), at_one([0.0, c[0], c[1]]));
        assert_eq!((value_a, value_b, value_c), (0.0, 1.0, 1.0), "{scheme:?}");
        assert_eq!(slope_b, slope_c, "{scheme:?}: extrapolation and interpolation meet");
        let s = 3.0 / 16.0 * theta.sqrt();
        let parasites = match scheme {
            Scheme::Sbdf2 => [0.5 / (2.25 + theta).sqrt(); 2],
            Scheme::Cnab2 => [0.0, theta / (4.0 + theta)], // alternating
            Scheme::Mcnab2 => [s / (1.0 + 9.0 * s * s).sqrt(); 2],
            Scheme::Cnlf => [1.0; 2],
        };
        let recurrence = oracle(scheme.at_constant_step()).recurrence(theta, -theta, 0.0);
        let roots = recurrence.eigenvalues().unwrap();
        let mut moduli: Vec<f64> =
            roots.iter().filter(|z| (*z - 1.0).norm() > 1e-4).map(|z| z.norm()).collect();
        moduli.sort_by(f64::total_cmp);
        assert_eq!(moduli.len(), 2, "{scheme:?}, θ = {theta}: {roots:?}");
        for (found, expected) in moduli.iter().zip(parasites) {
            assert!((found - expected).abs() < 1e-6, "{scheme:?}, θ = {theta}: {roots:?}");
        }
    }
}
