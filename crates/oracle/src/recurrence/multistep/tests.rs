//! Coefficients, roots and stability limits of the multistep methods.

use super::*;
use crate::Random;
use crate::recurrence::{backward_euler, explicit_euler, imex_euler, spectral_radius};

/// The methods of one to three steps at a constant step size; of those with both parts only the
/// last four and IMEX Euler are used as such.
fn methods() -> Vec<(&'static str, Multistep)> {
    vec![
        ("AB1", Multistep::adams_bashforth(&[])),
        ("AB2", Multistep::adams_bashforth(&[1.0])),
        ("AB3", Multistep::adams_bashforth(&[1.0, 1.0])),
        ("BDF3", Multistep::bdf(&[1.0, 1.0])),
        ("IMEX1", Multistep::imex_euler()),
        ("SBDF2", Multistep::sbdf2(1.0)),
        ("CNAB2", Multistep::cnab2(1.0)),
        ("MCNAB2", Multistep::mcnab2(1.0)),
        ("CNLF", Multistep::cnlf()),
    ]
}

fn two_step() -> Vec<(&'static str, Multistep)> {
    methods().split_off(5)
}

fn assert_close(found: &[f64], expected: &[f64], case: &str) {
    assert_eq!(found.len(), expected.len(), "{case}");
    let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14 * (1.0 + b.abs()));
    assert!(close, "{case}: {found:?}, not {expected:?}");
}

#[test]
fn coefficients_at_a_constant_step_size_are_the_published_ones() {
    let twelfth = |numbers: [f64; 4]| numbers.map(|n| n / 12.0);
    let ab3 = Multistep::adams_bashforth(&[1.0, 1.0]);
    assert_close(&ab3.b, &twelfth([0.0, 23.0, -16.0, 5.0]), "AB3");
    assert_close(&ab3.a, &[1.0, -1.0, 0.0, 0.0], "AB3");
    assert_eq!(ab3.b, ab3.c, "an explicit method treats both parts alike");
    let bdf3 = Multistep::bdf(&[1.0, 1.0]);
    assert_close(&bdf3.a, &[11.0 / 6.0, -3.0, 1.5, -1.0 / 3.0], "BDF3");
    assert_close(&bdf3.b, &[1.0, 0.0, 0.0, 0.0], "BDF3");
    assert_close(&bdf3.c, &[0.0, 3.0, -3.0, 1.0], "SBDF3");
    let euler = Multistep::imex_euler();
    assert_eq!((euler.a, euler.b, euler.c), (vec![1.0, -1.0], vec![1.0, 0.0], vec![0.0, 1.0]));
}

#[test]
fn coefficients_of_the_two_step_methods_depend_on_the_step_ratio_as_published() {
    for omega in [0.5, 0.8, 1.0, 1.5, 2.0] {
        let (name, sum) = (format!("ω={omega}"), 1.0 + omega);
        let sbdf2 = Multistep::sbdf2(omega);
        assert_close(&sbdf2.a, &[(1.0 + 2.0 * omega) / sum, -sum, omega * omega / sum], &name);
        assert_close(&sbdf2.b, &[1.0, 0.0, 0.0], &name);
        assert_close(&sbdf2.c, &[0.0, sum, -omega], &name);
        let (cnab2, mcnab2) = (Multistep::cnab2(omega), Multistep::mcnab2(omega));
        let inverse = 1.0 / omega;
        let sixteenth = [8.0 + inverse, 7.0 - inverse, 1.0].map(|b| b / 16.0);
        for (method, b) in [(cnab2, [0.5, 0.5, 0.0]), (mcnab2, sixteenth)] {
            assert_close(&method.a, &[1.0, -1.0, 0.0], &name);
            assert_close(&method.b, &b, &name);
            assert_close(&method.c, &[0.0, 1.0 + 0.5 * omega, -0.5 * omega], &name);
        }
    }
}

/// A method of order `p` integrates `y' = q t^{q−1}` exactly for `q ≤ p`, in either part.
#[test]
fn order_conditions_hold_at_any_step_sizes() {
    let mut random = Random::new(5);
    for _ in 0..100 {
        let earlier = [random.between(0.4, 2.5), random.between(0.4, 2.5)];
        let omega = 1.0 / earlier[0];
        let methods = [
            (1, Multistep::adams_bashforth(&[]), earlier),
            (2, Multistep::adams_bashforth(&earlier[..1]), earlier),
            (3, Multistep::adams_bashforth(&earlier), earlier),
            (1, Multistep::imex_euler(), earlier),
            (2, Multistep::sbdf2(omega), earlier),
            (3, Multistep::bdf(&earlier), earlier),
            (2, Multistep::cnab2(omega), earlier),
            (2, Multistep::mcnab2(omega), earlier),
            (2, Multistep::cnlf(), [1.0; 2]),
        ];
        for (order, method, earlier) in methods {
            let times = times(&earlier);
            let sum = |weights: &[f64], power: i32| -> f64 {
                weights.iter().zip(&times).map(|(weight, t)| weight * t.powi(power)).sum()
            };
            for q in 0..=order {
                let left = sum(&method.a, q);
                for part in [&method.b, &method.c] {
                    let right = if q == 0 { 0.0 } else { f64::from(q) * sum(part, q - 1) };
                    assert!((left - right).abs() < 1e-12, "q={q}, {method:?}: {left} {right}");
                }
            }
        }
    }
}

#[test]
fn one_step_members_are_the_euler_methods() {
    for (theta, extra, eta) in [(0.36, 0.2, 0.06), (100.0, -50.0, 0.4), (1.0, 3.0, 0.0)] {
        let imex = Multistep::imex_euler().recurrence(theta, extra, eta);
        for (found, expected) in [
            (adams_bashforth(1, theta, eta), explicit_euler(theta, eta)),
            (bdf(1, theta, eta), backward_euler(theta, eta)),
            (imex, imex_euler(theta, extra, eta)),
        ] {
            assert_eq!(found.blocks().len(), 1);
            assert!((found.blocks()[0] - expected).norm() < 1e-14 * (1.0 + theta), "{found:?}");
            let radius = Recurrence::from(expected).spectral_radius();
            assert!((found.spectral_radius() - radius).abs() < 1e-13 * radius);
            assert!((spectral_radius(&expected) - radius).abs() < 1e-13 * radius);
        }
    }
}

/// `ρ² + ηρσ + θσ² = 0` and `A² + ηAB + θ_I B² + θ_E BC = 0`: the polynomials know nothing of
/// matrices.
#[test]
fn eigenvalues_are_roots_of_the_characteristic_polynomial() {
    let value = |coefficients: &[f64], z: Complex<f64>| {
        coefficients.iter().fold(Complex::new(0.0, 0.0), |sum, a| sum * z + a)
    };
    let size = |coefficients: &[f64], z: Complex<f64>| {
        coefficients.iter().fold(0.0, |sum, a| sum * (1.0 + z.norm()) + a.abs())
    };
    let mut random = Random::new(6);
    let mut checked = 0;
    for _ in 0..100 {
        let theta = random.power_of_ten(-2.0, 4.0);
        let (extra, eta) = (theta * random.between(-2.0, 2.0), random.power_of_ten(-2.0, 2.0));
        for (name, Multistep { a, b, c }) in &methods() {
            let method = Multistep { a: a.clone(), b: b.clone(), c: c.clone() };
            let splits = [(theta, 0.0), (theta, extra), (theta, -theta), (0.0, theta)];
            for (implicit, explicit) in splits {
                let recurrence = method.recurrence(implicit, explicit, eta);
                let roots = recurrence.eigenvalues().expect("finite entries");
                assert_eq!(roots.len(), 2 * (a.len() - 1), "{name}");
                for z in roots {
                    let [p, q, r] = [a, b, c].map(|part| value(part, z));
                    let polynomial = p * p + p * q * eta + q * q * implicit + q * r * explicit;
                    let [p, q, r] = [a, b, c].map(|part| size(part, z));
                    let scale = p * p + p * q * eta + q * q * implicit + q * r * explicit.abs();
                    let case = format!("{name}, θ_I={implicit} θ_E={explicit} η={eta}, ζ={z}");
                    assert!(polynomial.norm() < 1e-10 * scale, "{case}: {polynomial}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 5000);
}

/// The rotation of a spring at rest length has `θ_E = −θ_I`: it goes on for ever.
#[test]
fn two_step_methods_do_not_lock_a_rotation() {
    for (name, method) in two_step() {
        for theta in [0.01, 1.0, 100.0, 1e4, 1e8] {
            let recurrence = method.recurrence(theta, -theta, 0.0);
            let radius = recurrence.spectral_radius();
            // 1 is a double eigenvalue.
            assert!((radius - 1.0).abs() < 1e-6, "{name}, θ={theta}: {radius}");
            let drift = |n: f64| Vector2::new(n, 1.0);
            let next = recurrence.next(&[drift(1.0), drift(0.0)]);
            assert!((next - drift(2.0)).norm() < 1e-14, "{name}, θ={theta}: {next}");
        }
    }
}

/// Parasitic roots of that rotation.
#[test]
fn parasitic_roots_of_a_rotation_are_known() {
    type Root = fn(f64) -> f64;
    let known: [Root; 4] = [
        |theta| 0.5 / (2.25 + theta).sqrt(),
        |theta| theta / (4.0 + theta),
        |_| 1.0 / 3.0,
        |_| 1.0,
    ];
    for ((name, method), known) in two_step().into_iter().zip(known) {
        let theta = if name == "MCNAB2" { 1e12 } else { 7.0 };
        let recurrence = method.recurrence(theta, -theta, 0.0);
        let roots = recurrence.eigenvalues().expect("finite entries");
        let others = roots.iter().filter(|z| (*z - Complex::new(1.0, 0.0)).norm() > 1e-3);
        let largest = others.map(|z| z.norm()).fold(0.0, f64::max);
        assert!((largest - known(theta)).abs() < 1e-5, "{name}: {largest}");
    }
}

/// The smallest `x` in `[low, high]` from which on `unstable` holds, by bisection.
fn limit(mut low: f64, mut high: f64, unstable: impl Fn(f64) -> bool) -> f64 {
    assert!(!unstable(low) && unstable(high), "the limit lies between {low} and {high}");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if unstable(middle) { &mut high } else { &mut low }) = middle;
    }
    low
}

/// More than round-off, also of a double eigenvalue.
const GROWS: f64 = 1.0 + 1e-7;

#[test]
fn extra_explicit_stiffness_is_stable_up_to_the_known_limits() {
    let find = |method: &Multistep, implicit: f64, eta: f64| {
        limit(0.0, 20.0 * (1.0 + implicit), |explicit| {
            method.recurrence(implicit, explicit, eta).spectral_radius() > GROWS
        })
    };
    type Limit = fn(f64, f64) -> f64;
    let cases: [(&str, Multistep, Limit); 4] = [
        ("IMEX1", Multistep::imex_euler(), |theta, eta| 4.0 + theta + 2.0 * eta),
        ("SBDF2", Multistep::sbdf2(1.0), |theta, eta| (16.0 + 4.0 * eta + theta) / 3.0),
        ("MCNAB2", Multistep::mcnab2(1.0), |theta, eta| 8.0 + eta + theta / 8.0),
        ("CNLF", Multistep::cnlf(), |theta, _| theta),
    ];
    for (name, method, expected) in &cases {
        for implicit in [100.0, 1e4, 1e6] {
            for eta in [0.0, 0.1] {
                let (found, expected) = (find(method, implicit, eta), expected(implicit, eta));
                let case = format!("{name}, θ_I={implicit} η={eta}: {found}, not {expected}");
                assert!((found / expected - 1.0).abs() < 1e-5, "{case}");
                for explicit in [-0.99 * implicit, 0.02 * expected, 0.5 * expected, 0.98 * expected]
                {
                    let radius = method.recurrence(implicit, explicit, eta).spectral_radius();
                    assert!(radius <= GROWS, "{case}; at {explicit}: {radius}");
                }
            }
        }
    }
    for implicit in [0.1_f64, 1.0, 1.9, 3.0] {
        let found = find(&cases[1].1, implicit, 0.0);
        let expected = (implicit * (1.0 + implicit)).min((16.0 + implicit) / 3.0);
        assert!((found / expected - 1.0).abs() < 1e-4, "SBDF2, θ_I={implicit}: {found}");
    }
    // In the limit: a third, an eighth, all of it.
    for ((name, method, _), share) in cases[1..].iter().zip([1.0 / 3.0, 1.0 / 8.0, 1.0]) {
        let found = find(method, 1e9, 0.0) / 1e9;
        assert!((found - share).abs() < 1e-5, "{name}: {found} of θ_I");
    }
}

#[test]
fn cnab2_bears_no_extra_explicit_stiffness_without_damping() {
    let cnab2 = Multistep::cnab2(1.0);
    for implicit in [0.01, 1.0, 100.0, 1e6] {
        for share in [0.01, 0.1, 1.0] {
            let radius = cnab2.recurrence(implicit, share * implicit, 0.0).spectral_radius();
            assert!(radius > 1.0 + 1e-9, "θ_I={implicit}, {share} of it explicit: {radius}");
        }
    }
    for eta in [0.05, 0.1] {
        let found = limit(0.0, 1.0, |explicit| {
            cnab2.recurrence(1e4, explicit, eta).spectral_radius() > 1.0 + 1e-11
        });
        assert!((found / eta - 1.0).abs() < 0.001, "η={eta}: {found}");
    }
}

/// A compressed spring, `θ_E = −σθ_I`, buckles by `σ + √(σ² − σ)` a step of SBDF2.
#[test]
fn sbdf2_buckles_a_stiff_compressed_spring_at_the_known_rate() {
    for sigma in [1.1, 1.5, 3.0_f64] {
        let radius = Multistep::sbdf2(1.0).recurrence(1e9, -sigma * 1e9, 0.0).spectral_radius();
        let expected = sigma + (sigma * sigma - sigma).sqrt();
        assert!((radius / expected - 1.0).abs() < 1e-6, "σ={sigma}: {radius}, not {expected}");
    }
}

#[test]
fn limits_of_adams_and_bdf_are_where_theory_puts_them() {
    for theta in [1e-3, 0.02, 0.1] {
        let growth = adams_bashforth(2, theta, 0.0).spectral_radius() - 1.0;
        assert!((growth / (0.25 * theta * theta) - 1.0).abs() < 3.0 * theta, "{theta}: {growth}");
    }
    let ab3 = limit(0.1, 1.0, |theta| adams_bashforth(3, theta, 0.0).spectral_radius() > GROWS);
    assert!((ab3 - 144.0 / 275.0).abs() < 1e-5, "AB3: {ab3}");
    let bdf3 = limit(-8.0, -0.1, |minus| bdf(3, -minus, 0.0).spectral_radius() > GROWS);
    assert!((-bdf3 - 3.75).abs() < 1e-5, "BDF3 becomes stable at θ = {}", -bdf3);
    let mut random = Random::new(8);
    for _ in 0..1000 {
        let (theta, eta) = (random.power_of_ten(-6.0, 10.0), random.power_of_ten(-8.0, 5.0));
        let radius = bdf(2, theta, eta).spectral_radius();
        assert!(radius <= 1.0 + 1e-10, "BDF2, θ={theta} η={eta}: {radius}");
    }
}

/// Steps that grow too fast are unstable without any force: `ω < 1 + √2`.
#[test]
fn bdf2_forgets_its_start_up_to_the_known_step_ratio() {
    // On y' = 0 alone: the roots of a.
    let parasite = |omega: f64| {
        let a = Multistep::sbdf2(omega).a;
        a[2] / a[0]
    };
    let found = limit(1.0, 4.0, |omega| parasite(omega) > 1.0);
    assert!((found - (1.0 + 2.0_f64.sqrt())).abs() < 1e-10, "{found}");
}

/// `x'' = −4x − x'/2`, exactly.
fn exact(t: f64) -> (f64, f64) {
    let omega = (4.0 - 0.0625_f64).sqrt();
    let (sine, cosine) = (omega * t).sin_cos();
    let decay = (-0.25 * t).exp();
    (decay * cosine, -decay * (0.25 * cosine + omega * sine))
}

/// Uneven steps, exact starts: errors fall with the order when all steps are halved. The split
/// takes half of the stiffness explicitly.
#[test]
fn uneven_steps_keep_the_order() {
    type Make = fn(&[f64]) -> Multistep;
    let methods: [(&str, i32, Make); 6] = [
        ("AB2", 2, |earlier| Multistep::adams_bashforth(&earlier[..1])),
        ("AB3", 3, |earlier| Multistep::adams_bashforth(earlier)),
        ("SBDF2", 2, |earlier| Multistep::sbdf2(1.0 / earlier[0])),
        ("SBDF3", 3, |earlier| Multistep::bdf(earlier)),
        ("CNAB2", 2, |earlier| Multistep::cnab2(1.0 / earlier[0])),
        ("MCNAB2", 2, |earlier| Multistep::mcnab2(1.0 / earlier[0])),
    ];
    for (name, order, make) in methods {
        let error = |steps: usize| {
            // Sizes repeat 1, 1.4, 0.8, 0.8: their sum is the same however they are halved.
            let size = |n: usize| [1.0, 1.4, 0.8, 0.8][n % 4] / steps as f64;
            let mut times = vec![0.0];
            for n in 0..steps {
                times.push(times[n] + size(n));
            }
            let mut levels: Vec<(f64, f64)> = times[..3].iter().map(|t| exact(*t)).collect();
            for n in 2..steps {
                let h = size(n);
                let earlier = [size(n - 1) / h, size(n - 2) / h];
                let recurrence = make(&earlier).recurrence(2.0 * h * h, 2.0 * h * h, 0.5 * h);
                let history = [n, n - 1, n - 2].map(|i| Vector2::new(levels[i].0, h * levels[i].1));
                let next = recurrence.next(&history);
                levels.push((next.x, next.y / h));
            }
            let (x, v) = exact(times[steps]);
            (levels[steps].0 - x).hypot(levels[steps].1 - v)
        };
        let slope = (error(800) / error(1600)).log2();
        assert!((slope - f64::from(order)).abs() < 0.1, "{name}: {slope}");
    }
}

/// QR iterations converge over the whole range of parameters.
#[test]
fn eigenvalues_are_found_for_every_parameter() {
    let mut random = Random::new(9);
    for (name, method) in methods() {
        for i in 0..2000 {
            let theta = random.power_of_ten(-12.0, 12.0);
            let extra = [0.0, -theta, theta, theta * random.between(-3.0, 3.0)][i % 4];
            let eta = [0.0, random.power_of_ten(-12.0, 12.0)][i % 2];
            let radius = method.recurrence(theta, extra, eta).spectral_radius();
            assert!(radius.is_finite(), "{name}, θ_I={theta} θ_E={extra} η={eta}");
        }
        assert!(method.recurrence(0.0, 0.0, 0.0).spectral_radius().is_finite(), "{name}");
        assert!(method.recurrence(f64::NAN, 0.0, 0.0).spectral_radius().is_nan(), "{name}");
    }
}
