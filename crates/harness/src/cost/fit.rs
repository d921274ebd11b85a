//! Fits prices to measured times: the least relative errors without negative prices.

use super::{Counted, KINDS, Price, Prices};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A run and the time that it took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// Its counted work.
    pub work: Counted,
    /// Its measured time, s.
    pub seconds: f64,
}

/// The timed runs to which a table of prices is fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Samples {
    /// Processor that measured.
    pub cpu: String,
    /// Commit of the program that measured.
    pub commit: String,
    /// The runs of each form, by its method id with settings.
    pub forms: BTreeMap<String, Vec<Sample>>,
}

impl Samples {
    /// The table of prices, rounded as it is committed.
    #[must_use]
    pub fn prices(&self) -> Prices {
        let mut forms: Vec<_> =
            self.forms.iter().filter_map(|(method, samples)| fit(method, samples)).collect();
        for price in &mut forms {
            let samples = self.forms.get(&price.method);
            let left_out = samples.and_then(|samples| left_out(&price.method, samples));
            price.left_out = left_out.map(|factor| rounded(factor, 1e3));
            price.ns_a_visit = price.ns_a_visit.map(|ns| rounded(ns, 1e4));
            price.least_ns_a_visit = rounded(price.least_ns_a_visit, 1e4);
            price.within = rounded(price.within, 1e3);
        }
        Prices { cpu: self.cpu.clone(), commit: self.commit.clone(), forms }
    }
}

fn rounded(value: f64, scale: f64) -> f64 {
    (scale * value).round() / scale
}

/// Number of reweighted rounds, and the relative error below which all runs have one weight.
const ROUNDS: usize = 8;
const SMALL: f64 = 0.02;
/// From this kind on, visits do not grow with the length of a sweep. Where the runs do not tell
/// such an overhead from sweeps, the fit gives the time to the sweeps, since longer sweeps take
/// longer.
const OVERHEAD: usize = 4;
const RELUCTANCE: f64 = 0.01;
/// Least number of samples on which the model is tried by leaving one out.
const ENOUGH: usize = 10;
/// Sets of kinds whose errors are within this share of the least error explain the runs equally
/// well. The fit takes the first of them in the order of the kinds.
const ALIKE: f64 = 1e-3;

/// The prices with the least `Σ |p·w/t − 1|` among all `p ≥ 0`: for each run, `w` are its visits by
/// kind and `t` is its measured time. Absolute errors give a run that the machine disturbed little
/// weight. Reweighted least squares find the prices; each round tries every set of kinds, so that
/// no price is negative. Returns `None` without samples.
#[must_use]
pub fn fit(method: &str, samples: &[Sample]) -> Option<Price> {
    // Visits over the time in nanoseconds, so that relative errors have equal weights.
    let rows: Vec<[f64; KINDS]> = samples
        .iter()
        .map(|sample| sample.work.visits_by_kind().map(|count| count / (1e9 * sample.seconds)))
        .collect();
    let mut weights = vec![1.0; rows.len()];
    let mut ns_a_visit = [0.0; KINDS];
    for _ in 0..ROUNDS {
        ns_a_visit = nearest(&rows, &weights)?;
        for (weight, row) in weights.iter_mut().zip(&rows) {
            *weight = 1.0 / (modelled(row, &ns_a_visit) - 1.0).abs().max(SMALL);
        }
    }
    let mut factors: Vec<f64> = rows
        .iter()
        .map(|row| modelled(row, &ns_a_visit))
        .map(|ratio| ratio.max(1.0 / ratio))
        .collect();
    factors.sort_by(f64::total_cmp);
    let runs = rows.len();
    let within = factors[(9 * factors.len()).div_ceil(10) - 1];
    let mut price = Price {
        method: method.to_owned(),
        ns_a_visit,
        least_ns_a_visit: 0.0,
        runs,
        within,
        left_out: None,
    };
    let each = samples.iter().map(|s| 1e9 * s.work.seconds(&price) / s.work.visits());
    price.least_ns_a_visit = each.fold(f64::INFINITY, f64::min);
    Some(price)
}

/// The greatest factor, in nine of ten runs, between the time of a run and a model that was fitted
/// to all other runs. `None` below [`ENOUGH`] samples: there the price of a kind may rest on one
/// run.
fn left_out(method: &str, samples: &[Sample]) -> Option<f64> {
    if samples.len() < ENOUGH {
        return None;
    }
    let off = |n: usize| {
        let others = [&samples[..n], &samples[n + 1..]].concat();
        let ratio = samples[n].work.seconds(&fit(method, &others)?) / samples[n].seconds;
        Some(ratio.max(1.0 / ratio))
    };
    let mut factors = (0..samples.len()).map(off).collect::<Option<Vec<_>>>()?;
    factors.sort_by(f64::total_cmp);
    factors.get((9 * factors.len()).div_ceil(10) - 1).copied()
}

fn modelled(row: &[f64; KINDS], prices: &[f64; KINDS]) -> f64 {
    row.iter().zip(prices).map(|(visits, price)| visits * price).sum()
}

/// The non-negative prices with the least sum of weighted squares of relative errors.
fn nearest(rows: &[[f64; KINDS]], weights: &[f64]) -> Option<[f64; KINDS]> {
    let off = |prices: &[f64; KINDS]| -> f64 {
        let error = |(row, weight): (_, &f64)| weight * (modelled(row, prices) - 1.0).powi(2);
        let errors: f64 = rows.iter().zip(weights).map(error).sum();
        let total: f64 = weights.iter().sum();
        let share = |kind: usize| {
            prices[kind] * rows.iter().map(|row| row[kind]).sum::<f64>() / rows.len() as f64
        };
        errors + RELUCTANCE * total * (OVERHEAD..KINDS).map(|kind| share(kind).powi(2)).sum::<f64>()
    };
    let candidates = (1..1_u32 << KINDS).filter_map(|set| {
        let kinds: Vec<usize> = (0..KINDS).filter(|kind| set >> kind & 1 == 1).collect();
        let prices = least_squares(rows, weights, &kinds)?;
        let is_valid = prices.iter().all(|price| *price >= 0.0 && price.is_finite());
        is_valid.then(|| (off(&prices), prices))
    });
    let candidates: Vec<_> = candidates.collect();
    let least = candidates.iter().map(|(off, _)| *off).reduce(f64::min)?;
    let alike = |(off, _): &&(f64, _)| *off <= (1.0 + ALIKE) * least;
    candidates.iter().find(alike).map(|(_, prices)| *prices)
}

/// Prices of some kinds by least squares, of either sign; `None` if the counts do not tell the
/// kinds apart.
fn least_squares(rows: &[[f64; KINDS]], weights: &[f64], kinds: &[usize]) -> Option<[f64; KINDS]> {
    if rows.len() < kinds.len() {
        return None;
    }
    let scale = |kind: usize| rows.iter().map(|row| row[kind]).fold(0.0, f64::max);
    let scales: Vec<f64> = kinds.iter().map(|kind| scale(*kind)).collect();
    if scales.contains(&0.0) {
        return None;
    }
    let roots: Vec<f64> = weights.iter().map(|weight| weight.sqrt()).collect();
    let total: f64 = weights.iter().sum();
    // Below the runs stands a row for each kind of overhead, whose share of the time should be small.
    let entry = |i: usize, j: usize| {
        let kind = kinds[j];
        match i.checked_sub(rows.len()) {
            None => roots[i] * rows[i][kind] / scales[j],
            Some(overhead) if overhead == j && kind >= OVERHEAD => {
                let mean = rows.iter().map(|row| row[kind]).sum::<f64>() / rows.len() as f64;
                (RELUCTANCE * total).sqrt() * mean / scales[j]
            }
            Some(_) => 0.0,
        }
    };
    let matrix = DMatrix::from_fn(rows.len() + kinds.len(), kinds.len(), entry);
    let svd = matrix.svd(true, true);
    let least = svd.singular_values.iter().copied().fold(f64::INFINITY, f64::min);
    if least < 1e-9 {
        return None;
    }
    let times = roots.into_iter().chain(kinds.iter().map(|_| 0.0));
    let times = DVector::from_iterator(rows.len() + kinds.len(), times);
    let solution = svd.solve(&times, 0.0).ok()?;
    let mut prices = [0.0; KINDS];
    for (j, kind) in kinds.iter().enumerate() {
        prices[*kind] = solution[j] / scales[j];
    }
    Some(prices)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(prices: [f64; KINDS], noise: impl Fn(u64) -> f64) -> Vec<Sample> {
        let price = Price {
            method: String::new(),
            ns_a_visit: prices,
            least_ns_a_visit: 0.0,
            runs: 0,
            within: 1.0,
            left_out: None,
        };
        let work = |n: u64| Counted {
            steps: 8 << (n % 5),
            force_evaluations: 3 * (8 << (n % 5)) + n,
            matvecs: 40 * (n % 7) * (n % 3),
            factorisations: 0,
            setups: 0,
            particles: if n.is_multiple_of(2) { 400 } else { 100 },
            springs: if n.is_multiple_of(2) { 1482 } else { 342 },
        };
        let sample = |n| {
            let work = work(n);
            Sample { work, seconds: noise(n) * work.seconds(&price) }
        };
        (1..20).map(sample).collect()
    }

    #[test]
    fn undisturbed_times_are_given_back() {
        let prices = [1.5, 0.75, 0.0, 0.0, 3.0, 0.25, 0.0, 0.0];
        let price = fit("a", &samples(prices, |_| 1.0)).expect("samples");
        assert!((price.within - 1.0).abs() < 0.03 && price.runs == 19, "{price:?}");
    }

    #[test]
    fn noise_makes_no_price_negative_and_is_told() {
        let noise = |n: u64| if n.is_multiple_of(2) { 1.2 } else { 0.8 };
        let price =
            fit("a", &samples([1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], noise)).expect("samples");
        assert!(price.ns_a_visit.iter().all(|ns| *ns >= 0.0), "{price:?}");
        assert!((1.1..1.6).contains(&price.within), "{price:?}");
    }

    #[test]
    fn a_disturbed_run_moves_no_price() {
        let prices = [1.5, 0.75, 0.0, 0.0, 3.0, 0.25, 0.0, 0.0];
        let price =
            fit("a", &samples(prices, |n| if n == 7 { 3.0 } else { 1.0 })).expect("samples");
        assert!(price.within < 1.1, "{price:?}");
        for (n, sample) in samples(prices, |_| 1.0).iter().enumerate() {
            let ratio = sample.work.seconds(&price) / sample.seconds;
            assert!((0.9..1.1).contains(&ratio), "{n}: {ratio}");
        }
    }

    #[test]
    fn without_samples_there_is_no_price() {
        assert_eq!(fit("a", &[]), None);
    }
}
