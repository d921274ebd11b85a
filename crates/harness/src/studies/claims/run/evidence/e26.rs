//! What is run for claim C26.

use super::runs::track;
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::run::Simulation;
use crate::scenes::{bundled, with_stiffness};
use crate::{HarnessError, reference_energy};

pub(super) const TRIAL: Trial = Trial {
    id: "C26",
    scenes: || {
        "the hanging sheet and the square table of 400 particles; k/m = 1e2 to 1e8 at h = 0.01 s \
         (updated, as printed, to 1e6, where it gains energy), h = 0.001 to 0.05 s at k/m = 1e4 \
         and 1e6; IC(0) unless said, extrapolated start, 1 s"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const STIFFNESSES: [f64; 7] = [1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8];
const STEPS: [f64; 6] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05];
const STEP: f64 = 0.01;
/// The last of the 400 particles, a free corner.
const LAST: usize = 399;
/// Greatest stiffness over mass at which the updated form, as printed, is followed: there it gains
/// energy, and beyond it counts nothing but that.
const UPDATED_LIMIT: f64 = 1e6;

fn scene(name: &str, stiffness: f64) -> Result<Simulation, HarnessError> {
    if name == "hanging" {
        return build(&hanging(20, stiffness, 40.0).spec()?);
    }
    Ok(crate::scenes::build(&with_stiffness(bundled("square-table-1e4")?, stiffness))?.1)
}

/// Counts of one scene with one form of the method.
struct Series {
    label: String,
    /// Iterations a step, from the softest to the stiffest.
    by_stiffness: Vec<f64>,
    /// Way of a free corner at the stiffest over that at the softest.
    way: f64,
    /// Iterations in one second of the runs that gain no energy, from the smallest step to the
    /// largest, at k/m = 1e4 and 1e6.
    by_step: [Vec<f64>; 2],
}

impl Series {
    fn new(name: &str, form: &str, method: &str) -> Result<Self, HarnessError> {
        let limit = if form == "updated" { UPDATED_LIMIT } else { f64::INFINITY };
        let of = |stiffness: f64| track(&scene(name, stiffness)?, method, STEP, 1.0, LAST);
        let (mut by_stiffness, mut ways) = (Vec::new(), Vec::new());
        for stiffness in STIFFNESSES.into_iter().filter(|k| *k <= limit) {
            let run = of(stiffness)?;
            by_stiffness.push(run.per_step());
            ways.push(run.path);
        }
        let mut by_step = [Vec::new(), Vec::new()];
        for (totals, stiffness) in by_step.iter_mut().zip([1e4, 1e6]) {
            let start = scene(name, stiffness)?;
            let released = reference_energy(&start, 1.0)?;
            for step in STEPS {
                let run = track(&start, method, step, 1.0, LAST)?;
                // What gains energy iterates for a motion that is not there.
                totals.extend(run.is_stable(released).then_some(run.iterations as f64));
            }
        }
        let way = ways[ways.len() - 1] / ways[0];
        Ok(Self { label: format!("{name}, {form}"), by_stiffness, way, by_step })
    }

    /// Largest stiffness up to which the counts grow.
    fn grows_to(&self) -> f64 {
        let rising = self.by_stiffness.windows(2).take_while(|pair| pair[0] <= pair[1]).count();
        STIFFNESSES[rising]
    }

    /// Whether the total over a second rises and falls with the step somewhere: a smaller step may
    /// take fewer.
    fn is_not_monotone(&self) -> bool {
        let falls = |totals: &Vec<f64>| totals.windows(2).all(|pair| pair[0] >= pair[1]);
        let rises = |totals: &Vec<f64>| totals.windows(2).all(|pair| pair[0] <= pair[1]);
        self.by_step.iter().any(|totals| !falls(totals) && !rises(totals))
    }
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut series = Vec::new();
    for name in ["hanging", "table"] {
        for (form, method) in [
            ("plain, ε = 0.05", "imex-euler:norm=euclid,forcing_term=0.05"),
            ("plain, ε = 1e-3", "imex-euler:norm=euclid,forcing_term=1e-3"),
            (
                "plain, ε = 1e-3, no preconditioner",
                "imex-euler:norm=euclid,forcing_term=1e-3,preconditioner=none",
            ),
            ("updated", "imex-updated:norm=euclid,forcing_term=0.05,safeguard=paper"),
        ] {
            series.push(Series::new(name, form, method)?);
        }
    }
    Ok(numbers(&series))
}

fn numbers(series: &[Series]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for one in series {
        let of = |what: &str| format!("{what}, {}", one.label);
        let last = one.by_stiffness.len() - 1;
        numbers.push(Number::new(of("iterations a step at k/m = 1e2"), one.by_stiffness[0], ""));
        let what = format!("iterations a step at k/m = {:e}", STIFFNESSES[last]);
        numbers.push(Number::new(of(&what), one.by_stiffness[last], ""));
        numbers.push(
            Number::new(of("they grow up to k/m"), one.grows_to(), "1/s²")
                .against(STIFFNESSES[last]),
        );
        numbers.push(Number::new(of("way of a corner, stiffest over softest"), one.way, ""));
        let kinds = f64::from(u8::from(one.is_not_monotone()));
        numbers.push(Number::new(of("total not monotone in h (1: yes)"), kinds, ""));
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_ends_at_the_first_fall_and_one_exception_in_the_step_is_enough() {
        let series = |by_stiffness: [f64; 3], totals: [f64; 3]| Series {
            label: String::new(),
            by_stiffness: by_stiffness.to_vec(),
            way: 1.0,
            by_step: [totals.to_vec(), vec![3.0, 2.0, 1.0]],
        };
        let growing = series([1.0, 2.0, 3.0], [3.0, 1.0, 2.0]);
        let one_way = series([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]);
        let peaked = series([1.0, 3.0, 2.0], [3.0, 1.0, 2.0]);
        assert_eq!([growing.grows_to(), peaked.grows_to()], [1e4, 1e3]);
        assert!(growing.is_not_monotone() && !one_way.is_not_monotone());
    }
}
