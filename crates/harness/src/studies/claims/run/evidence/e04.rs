//! What is run for claim C04.

use super::meshes::Mesh;
use super::runs::{free_edge, true_motion};
use super::scenes::{build, error, hanging, run};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c04::GROWTH;
use crate::studies::sheet::Sheet;
use rayon::prelude::*;

pub(super) const TRIAL: Trial = Trial {
    id: "C04",
    scenes: || {
        format!(
            "hanging sheets ({}), d/m = 10/s, k/m = 1e4, 1e6, 1e8/s², h = 0.01 and 0.0025 s, \
             positions after {DURATION} s; one Newton step: {ONE}; converged: {CONVERGED}; truth: \
             symplectic Euler at a quarter of its limit",
            SCENES.join(", ")
        )
    },
    portable: false,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const STIFFNESSES: [f64; 3] = [1e4, 1e6, 1e8];
const STEPS: [f64; 2] = [0.01, 0.0025];
const DURATION: f64 = 0.3;
const ONE: &str = "baraff-witkin:solver=cholesky";
const CONVERGED: &str = "backward-euler:solver=cholesky";

/// One scene and step size: errors over the stiffnesses.
#[derive(Clone, Debug)]
struct Series {
    name: String,
    /// `(error of one Newton step, error of the converged method)`.
    errors: Vec<(f64, f64)>,
}

impl Series {
    fn ratio(&self, n: usize) -> f64 {
        self.errors.get(n).map_or(f64::NAN, |(one, converged)| one / converged)
    }

    /// The last ratio over the first.
    fn growth(&self) -> f64 {
        self.ratio(self.errors.len().saturating_sub(1)) / self.ratio(0)
    }
}

const SCENES: [&str; 3] = ["grid of 6 × 6", "grid of 8 × 8 with shear", "triangles"];

/// Errors of both methods at all step sizes.
fn errors(scene: usize, stiffness: f64) -> Result<Vec<(f64, f64)>, HarnessError> {
    let spec = match scene {
        0 => hanging(6, stiffness, 10.0).spec()?,
        1 => Sheet { shear: 0.1 * stiffness, ..hanging(8, stiffness, 10.0) }.spec()?,
        _ => Mesh::Triangles.hanging(6, stiffness, 10.0)?,
    };
    let start = build(&spec)?;
    let truth = true_motion(&start, DURATION, free_edge(&spec))?.state;
    let of = |method: &str, step: f64| -> Result<f64, HarnessError> {
        Ok(error(&start, &truth, &run(&start, method, step, DURATION, None)?.state))
    };
    STEPS.iter().map(|&step| Ok((of(ONE, step)?, of(CONVERGED, step)?))).collect()
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let places: Vec<_> =
        (0..SCENES.len()).flat_map(|scene| STIFFNESSES.map(|k| (scene, k))).collect();
    let found: Vec<Vec<(f64, f64)>> = places
        .par_iter()
        .with_max_len(1)
        .map(|&(scene, k)| errors(scene, k))
        .collect::<Result<_, _>>()?;
    let mut series = Vec::new();
    for (scene, name) in SCENES.iter().enumerate() {
        for (n, step) in STEPS.iter().enumerate() {
            let rows = &found[STIFFNESSES.len() * scene..][..STIFFNESSES.len()];
            let errors = rows.iter().map(|row| row[n]).collect();
            series.push(Series { name: format!("{name}, h = {step} s"), errors });
        }
    }
    Ok(numbers(&series))
}

fn numbers(series: &[Series]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for line in series {
        for (k, (one, converged)) in STIFFNESSES.iter().zip(&line.errors) {
            let at = format!("{}, k/m = {k:.0e}", line.name);
            numbers.push(
                Number::new(format!("error of one Newton step, {at}"), *one, "").of_machine(),
            );
            let what = format!("error of the converged method, {at}");
            numbers.push(Number::new(what, *converged, "").of_machine());
        }
        let what = format!("growth of their quotient, {}", line.name);
        numbers.push(Number::new(what, line.growth(), "").against(GROWTH).of_machine());
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(ratios: [f64; 3]) -> Series {
        let errors = ratios.iter().map(|ratio| (0.1 * ratio, 0.1)).collect();
        Series { name: "a scene".to_owned(), errors }
    }

    #[test]
    fn growth_is_the_last_quotient_over_the_first() {
        let numbers = numbers(&[series([1.0, 9.0, 4.0])]);
        let growth = numbers.last().map(|number| number.value).unwrap_or_default();
        assert!((growth - 4.0).abs() < 1e-12, "{growth}");
    }
}
