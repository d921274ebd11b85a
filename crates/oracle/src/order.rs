//! Observed order of accuracy and error constant.
//!
//! The error of a method of order `p` is `C h^p` in the limit of small steps. The observed order is
//! the slope of `log e` over `log h`. If it differs from theory by more than about 0.15, the method
//! is wrong or the steps are too large for the limit.

use crate::reference::Reference;
use drape_integrator::{
    Integrator, InvalidTimeStep, PhaseClock, PrepareError, StepError, TimeStep,
};
use drape_model::{State, System, Vec3};

/// Error at one step size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Step size, s.
    pub step: f64,
    /// Error, in whatever unit it was measured.
    pub error: f64,
}

/// A straight line through `log e` over `log h`.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedOrder {
    /// Slope by least squares.
    pub order: f64,
    /// Slopes between neighbours, from the coarsest pair to the finest.
    pub pairwise: Vec<f64>,
    /// The sample with the smallest step.
    pub finest: Sample,
}

impl ObservedOrder {
    /// `C = e/h^p` at the finest step, for the order `p` that theory gives.
    pub fn error_constant(&self, order: i32) -> f64 {
        self.finest.error / self.finest.step.powi(order)
    }
}

/// Why no order can be observed.
#[derive(Debug, thiserror::Error)]
pub enum OrderError {
    /// There are fewer than two samples.
    #[error("{0} step size(s); an order needs at least 2")]
    TooFew(usize),
    /// A step size or an error is not positive and finite.
    #[error("the error at step size {step} s is {error}; expected both positive and finite")]
    NotPositive {
        /// Step size, s.
        step: f64,
        /// Error.
        error: f64,
    },
    /// The step sizes do not decrease.
    #[error("step size {next} s follows {last} s; expected each smaller than the one before")]
    NotFalling {
        /// Step size, s.
        last: f64,
        /// The step size after it, s.
        next: f64,
    },
    /// The step size cannot be used.
    #[error(transparent)]
    Step(#[from] InvalidTimeStep),
    /// The method refused the system.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// A step was refused.
    #[error(transparent)]
    Integration(#[from] StepError),
}

/// Observed order from errors at decreasing step sizes.
///
/// # Errors
/// [`OrderError`] if there are fewer than two samples, or if a sample is not valid.
///
/// ```
/// use drape_oracle::order::{Sample, observed_order};
/// let samples = [0.1, 0.05, 0.025].map(|h: f64| Sample { step: h, error: 3.0 * h * h });
/// let observed = observed_order(&samples)?;
/// assert!((observed.order - 2.0).abs() < 1e-12);
/// assert!((observed.error_constant(2) - 3.0).abs() < 1e-12);
/// # Ok::<(), drape_oracle::order::OrderError>(())
/// ```
pub fn observed_order(samples: &[Sample]) -> Result<ObservedOrder, OrderError> {
    let [.., finest] = samples else { return Err(OrderError::TooFew(0)) };
    if samples.len() < 2 {
        return Err(OrderError::TooFew(samples.len()));
    }
    for &Sample { step, error } in samples {
        if ![step, error].iter().all(|a| *a > 0.0 && a.is_finite()) {
            return Err(OrderError::NotPositive { step, error });
        }
    }
    let log = |sample: &Sample| (sample.step.ln(), sample.error.ln());
    let mut pairwise = Vec::new();
    for pair in samples.windows(2) {
        if pair[1].step >= pair[0].step {
            return Err(OrderError::NotFalling { last: pair[0].step, next: pair[1].step });
        }
        let ((h0, e0), (h1, e1)) = (log(&pair[0]), log(&pair[1]));
        pairwise.push((e0 - e1) / (h0 - h1));
    }
    let count = samples.len() as f64;
    let sum = |f: &dyn Fn((f64, f64)) -> f64| samples.iter().map(log).map(f).sum::<f64>();
    let (mean_h, mean_e) = (sum(&|(h, _)| h) / count, sum(&|(_, e)| e) / count);
    let covariance = sum(&|(h, e)| (h - mean_h) * (e - mean_e));
    let variance = sum(&|(h, _)| (h - mean_h) * (h - mean_h));
    Ok(ObservedOrder { order: covariance / variance, pairwise, finest: *finest })
}

/// `‖x − x_ref‖_M / ‖x_ref − x_0‖_M`: the error of the positions relative to the displacement of
/// the cloth.
pub fn position_error(system: &System, start: &[Vec3], reference: &[Vec3], x: &[Vec3]) -> f64 {
    let distance = |a: &[Vec3], b: &[Vec3]| {
        let terms = system.mass().iter().zip(a.iter().zip(b));
        terms.map(|(m, (a, b))| m * (a - b).norm_squared()).sum::<f64>().sqrt()
    };
    distance(x, reference) / distance(reference, start)
}

/// Observed order of a method against the last state of a reference, from one run with a new
/// integrator for each number of steps.
///
/// # Errors
/// [`OrderError`] if a run is refused, or if the errors give no order.
pub fn of_method(
    mut integrator: impl FnMut() -> Box<dyn Integrator>,
    system: &System,
    start: &State,
    reference: &Reference,
    steps: &[u32],
) -> Result<ObservedOrder, OrderError> {
    let Some(end) = reference.states.last() else { return Err(OrderError::TooFew(0)) };
    let run = |&steps: &u32| {
        let h = TimeStep::new((end.t - start.t) / f64::from(steps))?;
        let mut state = start.clone();
        let mut integrator = integrator();
        integrator.prepare(system, h)?;
        for _ in 0..steps {
            integrator.step(system, &mut state, h, &mut PhaseClock::off())?;
        }
        let error = position_error(system, &start.x, &end.x, &state.x);
        Ok(Sample { step: h.seconds(), error })
    };
    observed_order(&steps.iter().map(run).collect::<Result<Vec<_>, OrderError>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_order_is_refused_by_name() {
        let sample = |step, error| Sample { step, error };
        let refuse =
            |samples: &[Sample]| observed_order(samples).expect_err("no order").to_string();
        assert!(refuse(&[sample(0.1, 1.0)]).contains("at least 2"));
        assert!(refuse(&[sample(0.1, 1.0), sample(0.05, 0.0)]).contains("positive and finite"));
        assert!(refuse(&[sample(0.1, f64::NAN), sample(0.05, 1.0)]).contains("NaN"));
        assert!(refuse(&[sample(0.1, 1.0), sample(0.1, 0.5)]).contains("smaller"));
    }

    #[test]
    fn the_error_weighs_each_particle_by_its_mass() {
        let (system, state) = crate::scenes::parse(
            r#"{ "format": "drape-system/1", "particles": { "mass_kg": [1, 3],
                "position_m": [[0, 0, 0], [1, 0, 0]] } }"#,
        );
        let moved = |by: [f64; 2]| [0, 1].map(|i| state.x[i] + Vec3::y() * by[i]);
        let error = |by| position_error(&system, &state.x, &moved([1.0, 1.0]), &moved(by));
        assert_eq!([error([2.0, 1.0]), error([1.0, 2.0])], [0.5, 0.75_f64.sqrt()]);
    }

    #[test]
    fn the_order_is_a_fit_over_all_samples_and_the_pairs_are_kept() {
        let errors = [(0.4, 1.6), (0.2, 0.4), (0.1, 0.2)];
        let samples = errors.map(|(step, error)| Sample { step, error });
        let observed = observed_order(&samples).expect("positive errors at falling steps");
        assert!((observed.pairwise[0] - 2.0).abs() < 1e-12);
        assert!((observed.pairwise[1] - 1.0).abs() < 1e-12);
        assert!((observed.order - 1.5).abs() < 1e-12, "{}", observed.order);
    }
}
