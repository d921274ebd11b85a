//! Control of the step size: an estimate of the local error of positions, and a PI controller.

use crate::{ContactSet, Declared, History, Order, declare};
use drape_model::{State, System, Vec3};

/// The setting `tolerance`.
pub const TOLERANCE: Declared<f64> = declare!(
    tolerance: f64 off or in 1e-8..=1.0 = 0,
    "local error of positions that a step may make, in mesh widths; the method then divides each \
     step. 0: it takes steps as given"
);

/// Factors of the step size in this range keep it, since a new one costs a set-up.
const DEAD_BAND: std::ops::RangeInclusive<f64> = 0.9..=1.3;
const SAFETY: f64 = 0.9;
const LEAST_FACTOR: f64 = 0.2;
const GREATEST_FACTOR: f64 = 2.0;
/// Exponents of the present and the last error, over the order plus 1.
const PRESENT: f64 = 0.7;
const LAST: f64 = 0.4;
/// Smaller errors count as this much; the factor is at its bound there.
const LEAST_ERROR: f64 = 1e-6;
/// Factor after a step whose solver failed.
const AFTER_FAILURE: f64 = 0.5;

/// A decision about a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Whether the step is accepted.
    pub accepted: bool,
    /// Factor for the step size of the next attempt; 1 inside the dead band.
    pub factor: f64,
}

/// A proportional–integral controller with a dead band.
///
/// ```text
/// h ← h · clamp(0.9 e_n^{−0.7/(p+1)} e_{n−1}^{0.4/(p+1)}, 0.2, 2)
/// ```
///
/// with the errors `e` over the tolerance. The controller rejects steps with `e > 1`. After a
/// rejection the factor depends on the last error alone, and the next step does not grow.
///
/// ```
/// use drape_integrator::{Order, StepController};
/// let mut controller = StepController::new();
/// assert_eq!(controller.judge(Order::One, 0.7, true).factor, 1.0); // inside the dead band
/// assert_eq!(controller.judge(Order::One, 1e-9, true).factor, 2.0);
/// assert!(!controller.judge(Order::One, 1.1, true).accepted);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct StepController {
    last: f64,
    was_rejected: bool,
}

impl StepController {
    /// A controller without a past.
    pub fn new() -> Self {
        Self { last: 1.0, was_rejected: false }
    }

    /// Judges a step of a method of this order by its error over the tolerance; `solved` is false
    /// if the solver of the step failed.
    pub fn judge(&mut self, order: Order, error: f64, solved: bool) -> Decision {
        let exponent = 1.0 / f64::from(order.number() + 1);
        if !solved || !error.is_finite() {
            self.was_rejected = true;
            let factor = if solved { LEAST_FACTOR } else { AFTER_FAILURE };
            return Decision { accepted: false, factor };
        }
        let error = error.max(LEAST_ERROR);
        if error > 1.0 {
            self.was_rejected = true;
            let factor = (SAFETY * libm::pow(error, -exponent)).max(LEAST_FACTOR);
            return Decision { accepted: false, factor };
        }
        let growth =
            SAFETY * libm::pow(error, -PRESENT * exponent) * libm::pow(self.last, LAST * exponent);
        let most = if std::mem::take(&mut self.was_rejected) { 1.0 } else { GREATEST_FACTOR };
        let factor = growth.clamp(LEAST_FACTOR, most);
        self.last = error;
        Decision { accepted: true, factor: if DEAD_BAND.contains(&factor) { 1.0 } else { factor } }
    }
}

impl Default for StepController {
    fn default() -> Self {
        Self::new()
    }
}

/// Estimates the local error of positions from the last positions, particle by particle.
///
/// With the present step `h_n` and `ω = h_n/h_{n−1}`:
///
/// ```text
/// order 1:  e = h_n/(h_n + h_{n−1}) · (x_{n+1} − x_n − ω (x_n − x_{n−1}))            ≈ h²/2 x''
/// order 2:  e = C/(C + P) · (x_{n+1} − quadratic extrapolation of the last three)      ≈ C h³ x'''
///           P = (1 + 1/ω)(1 + 1/ω + h_{n−2}/h_n)/6
/// ```
///
/// The method's error is `C h³ x'''`, the error of the extrapolation is `P h³ x'''`. With equal
/// steps of BDF (`C = 2/9`) the factor is `2/11`. A particle with one past level less uses the
/// formula of order 1, and a particle without a past uses `e = ½ (x_{n+1} − x_n − h v_n)`.
#[derive(Debug)]
pub struct LocalError {
    levels: History<1>,
    /// Number of usable past levels of each particle.
    known: Vec<u8>,
    error: Vec<Vec3>,
}

impl LocalError {
    /// Memory for `n` particles, without a past.
    pub fn new(n: usize) -> Self {
        Self { levels: History::new(n, 2), known: vec![0; n], error: vec![Vec3::zeros(); n] }
    }

    /// Forgets the past.
    pub fn restart(&mut self) {
        self.levels.restart();
        self.known.fill(0);
    }

    /// Estimates the error of a step of `h` seconds; `constant` is the error constant `C(ω)` of a
    /// method of order 2.
    pub fn measure(
        &mut self,
        order: Order,
        constant: impl Fn(f64) -> f64,
        from: &State,
        to: &[Vec3],
        h: f64,
    ) {
        let Self { levels, known, error } = self;
        let step = |age: usize| if levels.len() > age { levels.step(age) } else { h };
        let (h1, h2) = (step(0), step(1));
        let omega = h / h1;
        let distance = (1.0 + 1.0 / omega) * (1.0 + 1.0 / omega + h2 / h) / 6.0;
        let c = constant(omega);
        for i in 0..to.len() {
            let x = from.x[i];
            let moved = to[i] - x;
            let usable = if order == Order::One { known[i].min(1) } else { known[i] };
            error[i] = match usable {
                0 => (moved - from.v[i] * h) * 0.5,
                1 => (moved - (x - levels.field(0, 0)[i]) * omega) * (h / (h + h1)),
                _ => {
                    let (x1, x2) = (levels.field(0, 0)[i], levels.field(1, 0)[i]);
                    // Newton's form: slope, and bend over the two steps.
                    let (slope, older) = ((x - x1) / h1, (x1 - x2) / h2);
                    let bend = (slope - older) / (h1 + h2);
                    let ahead = (slope + bend * (h + h1)) * h;
                    (moved - ahead) * (c / (c + distance))
                }
            };
        }
    }

    /// The estimates per particle, m, for methods that add a further part of their error.
    pub fn vectors(&mut self) -> &mut [Vec3] {
        &mut self.error
    }

    /// Root mean square of the errors over the free particles, m. Particles that met an obstacle in
    /// the step count as 0, because their velocity jumped.
    pub fn norm(&self, system: &System, contacts: Option<&ContactSet>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for (i, error) in self.error.iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
            count += 1.0;
            if !contacts.is_some_and(|contacts| contacts.changed(i)) {
                sum += error.norm_squared();
            }
        }
        (sum / count.max(1.0)).sqrt()
    }

    /// Stores the level before an accepted step of `h` seconds.
    pub fn accept(&mut self, from: &State, h: f64, contacts: Option<&ContactSet>) {
        self.levels.push(h, [&from.x]);
        for (i, known) in self.known.iter_mut().enumerate() {
            let fits = !contacts.is_some_and(|contacts| contacts.changed(i));
            *known = if fits { known.saturating_add(1) } else { 0 };
        }
    }
}

/// Mean rest length of the tension springs, m. Without them it is the mean of all springs, and
/// without springs 1 m.
pub fn mesh_width(system: &System) -> f64 {
    let mean = |tension: bool| {
        let (mut sum, mut count) = (0.0, 0.0);
        for effect in system.effects().filter(|effect| !tension || effect.name() == "tension") {
            if let Some(split) = effect.split() {
                split.visit_rest_lengths(&mut |_, _, rest| {
                    sum += rest;
                    count += 1.0;
                });
            }
        }
        (sum > 0.0).then(|| sum / count)
    };
    mean(true).or_else(|| mean(false)).unwrap_or(1.0)
}

#[cfg(test)]
mod tests;
