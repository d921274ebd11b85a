//! C04: one linearised Newton step suffers at high stiffness.

use super::meshes::Mesh;
use super::runs::{free_edge, true_motion};
use super::scenes::{build, error, hanging, run};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::studies::sheet::Sheet;
use crate::studies::short;
use rayon::prelude::*;

pub(super) const CLAIM: Claim = Claim {
    id: "C04",
    section: "3",
    says: "one linearised Newton step suffers at high stiffness",
    criterion: "error of one step / error of the converged method grows with k/m by > 2 from 1e4 to 1e8",
    is_quick: false,
    test,
    seconds: None,
};

const GROWTH: f64 = 2.0;
const STIFFNESSES: [f64; 3] = [1e4, 1e6, 1e8];
const STEPS: [f64; 2] = [0.01, 0.0025];
const DURATION: f64 = 0.3;
const ONE: &str = "baraff-witkin:solver=cholesky";
const CONVERGED: &str = "backward-euler";

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

fn test() -> Result<Finding, HarnessError> {
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
    Ok(judge(&series))
}

fn judge(series: &[Series]) -> Finding {
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
    let growing: Vec<_> = series.iter().filter(|line| line.growth() > GROWTH).collect();
    let worst = series.iter().map(Series::growth).fold(0.0, f64::max);
    let smallest = series.iter().map(Series::growth).fold(f64::INFINITY, f64::min);
    Finding {
        verdict: match growing.len() {
            0 => Verdict::Refuted,
            count if count == series.len() => Verdict::Confirmed,
            _ => Verdict::Undecided,
        },
        numbers,
        reason: format!(
            "From k/m = 1e4 to 1e8 the quotient of the errors grows by a factor of {} to {}, by more than 2 in {} of {} series of \
             one scene and step size. A single linearisation keeps the direction of every spring of the old level; what a turn of \
             the springs stretches is seen a step late, and a converged step, whose error stays about the same, does not make this \
             error.",
            short(smallest),
            short(worst),
            growing.len(),
            series.len()
        ),
        repair: None,
        scenes: format!(
            "hanging sheets ({}), d/m = 10/s, k/m = 1e4, 1e6, 1e8/s², h = 0.01 and 0.0025 s, positions after {DURATION} s; one Newton \
             step: {ONE}; converged: {CONVERGED}; truth: symplectic Euler at a quarter of its limit",
            SCENES.join(", ")
        ),
        see: "work-precision.svg",
        portable: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(ratios: [f64; 3]) -> Series {
        let errors = ratios.iter().map(|ratio| (0.1 * ratio, 0.1)).collect();
        Series { name: "a scene".to_owned(), errors }
    }

    #[test]
    fn all_series_must_agree() {
        let verdict = |a, b| judge(&[series(a), series(b)]).verdict;
        assert_eq!(verdict([1.0, 2.0, 4.0], [1.0, 1.0, 3.0]), Verdict::Confirmed);
        assert_eq!(verdict([1.0, 1.0, 1.1], [2.0, 9.0, 3.0]), Verdict::Refuted);
        assert_eq!(verdict([1.0, 1.0, 1.1], [1.0, 1.0, 3.0]), Verdict::Undecided);
    }
}
