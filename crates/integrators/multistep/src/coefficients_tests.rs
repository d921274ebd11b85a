//! Values at equal steps, order conditions, roots.

use super::*;
use drape_oracle::Random;
use drape_oracle::recurrence::Multistep;
use nalgebra::Complex;

const FAMILIES: [fn(&[f64]) -> LinearMultistep; 2] =
    [LinearMultistep::adams_bashforth, LinearMultistep::bdf];

fn close(found: &[f64], expected: &[f64]) -> bool {
    found.len() == expected.len()
        && found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-15 * b.abs().max(1.0))
}

#[test]
fn equal_steps_give_the_printed_coefficients() {
    let h = 0.1;
    let beta: [&[f64]; 3] =
        [&[1.0, 0.0], &[-0.5, 1.5, 0.0], &[5.0 / 12.0, -16.0 / 12.0, 23.0 / 12.0, 0.0]];
    let alpha: [&[f64]; 3] =
        [&[-1.0, 1.0], &[0.5, -2.0, 1.5], &[-1.0 / 3.0, 1.5, -3.0, 11.0 / 6.0]];
    let ahead: [&[f64]; 3] = [&[1.0, 0.0, 0.0], &[-1.0, 2.0, 0.0], &[1.0, -3.0, 3.0]];
    for k in 1..=MAX_STEPS {
        let steps = &[h; MAX_STEPS][..k];
        let (adams, bdf) = FAMILIES.map(|family| family(steps)).into();
        assert_eq!((adams.steps(), bdf.steps()), (k, k));
        assert!(close(adams.beta(), beta[k - 1]), "{adams:?}");
        assert!(close(bdf.alpha(), alpha[k - 1]), "{bdf:?}");
        let unit = |at: usize| (0..=k).map(|j| f64::from(u8::from(j == at))).collect::<Vec<_>>();
        let difference: Vec<f64> = unit(k).iter().zip(unit(k - 1)).map(|(a, b)| a - b).collect();
        assert_eq!((adams.alpha(), bdf.beta()), (&difference[..], &unit(k)[..]));
        assert!(close(&extrapolation(steps), ahead[k - 1]));
        assert_eq!((adams.tau(h), bdf.tau(h)), (0.0, h / bdf.alpha()[k]));
    }
}

/// Times of the levels, oldest first, the new one last.
fn level_times(steps: &[f64]) -> Vec<f64> {
    let mut times = vec![0.7];
    for h in steps.iter().rev() {
        times.push(times[times.len() - 1] + h);
    }
    times
}

fn random_steps(random: &mut Random, k: usize) -> Vec<f64> {
    (0..k).map(|_| random.power_of_ten(-0.5, 0.5)).collect()
}

/// `Σ α_j p(t_j) − h Σ β_j p'(t_j)` for `p = (t − t_0)^degree`.
fn defect(method: &LinearMultistep, steps: &[f64], degree: i32) -> f64 {
    let times = level_times(steps);
    let mut defect = 0.0;
    for (j, t) in times.iter().enumerate() {
        let t = t - times[0];
        let slope = if degree == 0 { 0.0 } else { f64::from(degree) * t.powi(degree - 1) };
        defect += method.alpha()[j] * t.powi(degree) - steps[0] * method.beta()[j] * slope;
    }
    defect / (times[times.len() - 1] - times[0]).powi(degree)
}

#[test]
fn on_any_steps_polynomials_up_to_the_order_are_met_exactly_and_no_further() {
    let mut random = Random::new(1);
    for (family, k) in FAMILIES.iter().flat_map(|family| [1, 2, 3].map(|k| (family, k))) {
        for _ in 0..200 {
            let steps = random_steps(&mut random, k);
            let method = family(&steps);
            for degree in 0..=k as i32 {
                let defect = defect(&method, &steps, degree);
                assert!(defect.abs() < 1e-12, "k = {k}, degree {degree}, {steps:?}: {defect:e}");
            }
            let beyond = defect(&method, &steps, k as i32 + 1);
            assert!(beyond.abs() > 1e-4, "k = {k}, {steps:?}: {beyond:e}");
        }
    }
}

#[test]
fn means_and_extrapolations_have_weights_of_sum_one_and_the_right_order() {
    let mut random = Random::new(2);
    for k in 1..=MAX_STEPS {
        for _ in 0..100 {
            let steps = random_steps(&mut random, k);
            let times = level_times(&steps);
            let sum = |weights: [f64; MAX_STEPS], degree: i32| -> f64 {
                weights[..k].iter().zip(&times).map(|(w, t)| w * t.powi(degree)).sum()
            };
            assert!((sum(LinearMultistep::bdf(&steps).past_weights(), 0) - 1.0).abs() < 1e-13);
            for degree in 0..k as i32 {
                let ahead = sum(extrapolation(&steps), degree) / times[k].powi(degree);
                assert!((ahead - 1.0).abs() < 1e-11, "k = {k}, degree {degree}: {ahead}");
            }
        }
    }
}

/// The oracle derives the same methods from the coefficients of the polynomials instead of their values.
#[test]
fn the_oracle_has_the_same_coefficients() {
    let mut random = Random::new(3);
    for k in 1..=MAX_STEPS {
        for _ in 0..50 {
            let steps = random_steps(&mut random, k);
            let earlier: Vec<f64> = steps[1..].iter().map(|h| h / steps[0]).collect();
            let oldest_first =
                |newest_first: Vec<f64>| -> Vec<f64> { newest_first.into_iter().rev().collect() };
            let oracle = [Multistep::adams_bashforth(&earlier), Multistep::bdf(&earlier)];
            for (family, oracle) in FAMILIES.iter().zip(oracle) {
                let method = family(&steps);
                for (found, expected) in [(method.alpha(), oracle.a), (method.beta(), oracle.b)] {
                    let pairs = found.iter().zip(oldest_first(expected));
                    for (a, b) in pairs {
                        assert!((a - b).abs() < 1e-11 * b.abs().max(1.0), "k = {k}: {a}, {b}");
                    }
                }
            }
        }
    }
}

/// Roots of a polynomial with the leading coefficient first (Durand and Kerner).
fn roots(coefficients: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let degree = coefficients.len() - 1;
    let mut roots: Vec<_> = (0..degree as i32).map(|k| Complex::new(0.4, 0.9).powi(k)).collect();
    for _ in 0..500 {
        for i in 0..degree {
            let value = coefficients.iter().fold(Complex::new(0.0, 0.0), |p, c| p * roots[i] + c);
            let others = (0..degree).filter(|&j| j != i);
            let scale = others.fold(coefficients[0], |q, j| q * (roots[i] - roots[j]));
            roots[i] -= value / scale;
        }
    }
    roots
}

/// Largest modulus of the roots of `ρ² + ηρσ + θσ² = 0`, which are those of `ρ = λσ` with `λ² + ηλ + θ = 0`.
fn spectral_radius(method: &LinearMultistep, theta: f64, eta: f64) -> f64 {
    let discriminant = Complex::new(0.25 * eta * eta - theta, 0.0).sqrt();
    let mut radius: f64 = 0.0;
    for lambda in [discriminant - 0.5 * eta, -discriminant - 0.5 * eta] {
        let terms = method.alpha().iter().zip(method.beta()).rev();
        let polynomial: Vec<_> = terms.map(|(&a, &b)| Complex::from(a) - lambda * b).collect();
        radius = roots(&polynomial).iter().map(|root| root.norm()).fold(radius, f64::max);
    }
    radius
}

#[test]
fn spectral_radii_on_the_oscillator_are_the_golden_ones() {
    let golden = [
        ((0.36, 0.06), 1.022636719997, 0.960430687463),
        ((100.0, 0.4), 14.986654277395, 0.299261781144),
        ((100.0, 0.0), 15.000014689889, 0.300749568269),
        ((1.0, 0.0), 1.522339130833, 0.933321058436),
    ];
    for ((theta, eta), adams, bdf) in golden {
        for (family, expected) in FAMILIES.iter().zip([adams, bdf]) {
            let found = spectral_radius(&family(&[1.0, 1.0]), theta, eta);
            assert!((found - expected).abs() < 1e-10, "({theta}, {eta}): {found:.12}");
        }
    }
}

/// Greatest and least `hω` from 0.05 to 3 at which the undamped oscillator grows.
fn growing(method: &LinearMultistep) -> Option<(f64, f64)> {
    let grows = |y: &f64| spectral_radius(method, y * y, 0.0) > 1.0 + 1e-9;
    let mut growing = (10..=600).map(|y| 0.005 * f64::from(y)).filter(grows);
    let first = growing.next()?;
    Some((first, growing.next_back().unwrap_or(first)))
}

#[test]
fn without_damping_three_steps_of_bdf_grow_for_moderate_steps_and_two_do_not() {
    assert_eq!(growing(&LinearMultistep::bdf(&[1.0; 2])), None);
    let bdf3 = LinearMultistep::bdf(&[1.0; 3]);
    // Up to √15/2.
    assert_eq!(growing(&bdf3), Some((0.05, 1.935)));
    let radius = |y: f64| spectral_radius(&bdf3, y * y, 0.0);
    let end = 15.0_f64.sqrt() / 2.0;
    assert!(radius(end - 1e-6) > 1.0 && radius(end + 1e-6) < 1.0);
    let largest = (1..200).map(|y| radius(0.01 * f64::from(y))).fold(0.0, f64::max);
    assert!((largest - 1.0456).abs() < 5e-5, "{largest}");
    // Stable within 86° of the negative axis: from about 7 % of critical damping on, η = 0.138 √θ.
    assert!(spectral_radius(&bdf3, 1.0, 0.15) < 1.0 && spectral_radius(&bdf3, 1.0, 0.1) > 1.0);
}

#[test]
fn without_damping_two_steps_of_adams_grow_and_three_only_beyond_a_limit() {
    let [two, three] = [2, 3].map(|k| LinearMultistep::adams_bashforth(&[1.0; 3][..k]));
    for y in [0.1_f64, 0.2] {
        let growth = spectral_radius(&two, y * y, 0.0) - 1.0;
        assert!((growth / (0.25 * y.powi(4)) - 1.0).abs() < 0.1, "{growth:e}");
    }
    let radius = |y: f64| spectral_radius(&three, y * y, 0.0);
    assert!(radius(0.7236) < 1.0 && radius(0.7237) > 1.0);
}

/// With `d_j = y_j − y_{j−1}` the old levels enter as `α_3 d_3 + (α_3 + α_2) d_2 + (α_3 + α_2 + α_1) d_1 = 0`.
/// The mean growth of `d` a step over periodic sequences of step ratios.
fn error_growth(ratios: &[f64]) -> f64 {
    let period = ratios.len();
    let mut product = nalgebra::Matrix2::identity();
    for i in 0..period {
        let (last, before) = (ratios[i], ratios[(i + period - 1) % period]);
        let bdf3 = LinearMultistep::bdf(&[1.0, 1.0 / last, 1.0 / (last * before)]);
        let [_, a1, a2, a3] = [0, 1, 2, 3].map(|j| bdf3.alpha()[j]);
        let companion = nalgebra::Matrix2::new(-(a3 + a2) / a3, -(a3 + a2 + a1) / a3, 1.0, 0.0);
        product = companion * product;
    }
    let (half_trace, determinant) = (0.5 * product.trace(), product.determinant());
    let discriminant: f64 = half_trace * half_trace - determinant;
    let radius = match discriminant < 0.0 {
        true => determinant.sqrt(),
        false => half_trace.abs() + discriminant.sqrt(),
    };
    radius.powf(1.0 / period as f64)
}

fn worst_growth(ratios: &[f64]) -> f64 {
    let mut worst: f64 = 0.0;
    for period in 1..=7 {
        let count = ratios.len().pow(period);
        for number in 0..count {
            let digit = |place: u32| ratios[number / ratios.len().pow(place) % ratios.len()];
            let sequence: Vec<f64> = (0..period).map(digit).collect();
            worst = worst.max(error_growth(&sequence));
        }
    }
    worst
}

#[test]
fn errors_of_the_past_die_out_at_the_step_ratios_that_bdf_bridges() {
    // Two steps: d_2 = ω²/(1 + 2ω) d_1, which grows from 1 + √2 on.
    for (omega, dies_out) in [(0.5, true), (2.0, true), (2.414, true), (2.415, false)] {
        let bdf2 = LinearMultistep::bdf(&[omega, 1.0]);
        let [oldest, _, newest] = [0, 1, 2].map(|j| bdf2.alpha()[j]);
        assert!((oldest / newest - omega * omega / (1.0 + 2.0 * omega)).abs() < 1e-14);
        assert_eq!(oldest / newest < 1.0, dies_out, "ω = {omega}");
    }
    // Three steps: no mixture is worse than a steady growth.
    let worst = worst_growth(&[0.5, 1.0, 1.5]);
    assert!(worst < 0.88, "{worst}");
    assert!((error_growth(&[1.5]) - worst).abs() < 1e-12);
    let golden_ratio = 0.5 * (1.0 + 5.0_f64.sqrt());
    assert!((error_growth(&[golden_ratio]) - 1.0).abs() < 1e-12);
}
