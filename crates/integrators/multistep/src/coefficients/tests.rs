//! Values at equal steps, agreement with the oracle at uneven ones, and decay of past errors.

use super::*;
use drape_oracle::Random;
use drape_oracle::recurrence::Multistep;

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

/// The oracle derives the same methods from the coefficients of the polynomials, not their values.
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

/// Mean growth of `d_j = y_j − y_{j−1}` a step over periodic sequences of step ratios, from
/// `α_3 d_3 + (α_3 + α_2) d_2 + (α_3 + α_2 + α_1) d_1 = 0`.
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
