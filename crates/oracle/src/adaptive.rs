//! Explicit Runge–Kutta methods that choose their steps: [`Pair::Dop853`], which computes the true
//! motions, and [`Pair::Tsit5`].
//!
//! A pair is a method with a second set of weights, and the difference of both estimates the error
//! of a step. A step counts if the estimate meets the tolerance; the next step is as long as the
//! estimate allows. The control is that of Hairer, Nørsett and Wanner, *Solving Ordinary
//! Differential Equations I* (2nd edition, 1993), sections II.4 and II.10. On forces that do not
//! change with time, DOP853 takes the steps of the library `ode_solvers` bit by bit.
//!
//! All vectors are allocated once. A stage is one pass over the slopes before it
//! ([`weighted_sum`]), and forces are written where the slope of a stage lies.

mod tableau;
#[cfg(test)]
mod tests;

use drape_kernels::vector::weighted_sum;
use drape_model::{Level, State, System, Vec3};
use tableau::{Estimate, Tableau};

/// A Runge–Kutta method with an estimate of its own error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// Dormand and Prince's method of order 8 with two estimates: twelve evaluations a step.
    Dop853,
    /// Tsitouras's method of order 5 with an estimate of order 4: six evaluations a step.
    Tsit5,
}

impl Pair {
    fn tableau(self) -> &'static Tableau {
        match self {
            Self::Dop853 => &tableau::DOP853,
            Self::Tsit5 => &tableau::TSIT5,
        }
    }
}

/// Tolerance and step limit of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveSettings {
    /// Tolerance of each step, both relative and absolute (in m and m/s).
    pub tolerance: f64,
    /// Largest number of steps in all.
    pub max_steps: u32,
}

impl Default for AdaptiveSettings {
    fn default() -> Self {
        Self { tolerance: 1e-12, max_steps: 1_000_000 }
    }
}

/// Why there is no run.
#[derive(Debug, thiserror::Error)]
pub enum AdaptiveError {
    /// The scene has obstacles.
    #[error("the scene has {0} obstacle(s); contacts have no reference trajectory: leave them out")]
    Contact(usize),
    /// Pins of the scene follow paths.
    #[error(
        "{0} pin(s) of the scene follow paths; such a motion has no reference trajectory: hold them"
    )]
    MovingPins(usize),
    /// The state does not fit the system.
    #[error("the state has {found} particles, the system {expected}")]
    SizeMismatch {
        /// Particles of the system.
        expected: usize,
        /// Particles of the state.
        found: usize,
    },
    /// The times do not increase from the start.
    #[error("time {next} s follows {last} s; expected finite and rising times after the start")]
    Times {
        /// A time, s.
        last: f64,
        /// The time after it, s.
        next: f64,
    },
    /// The tolerance is out of range.
    #[error("the tolerance is {0}; expected a number from 1e-15 to 0.1")]
    Tolerance(f64),
    /// The step limit was reached.
    #[error("{steps} steps reach only {time} s; allow more steps or ask for less time")]
    StepLimit {
        /// Number of steps taken.
        steps: u32,
        /// Time reached, s.
        time: f64,
    },
    /// No step is small enough, because the motion or a force is not finite.
    #[error("no step is small enough at {time} s; the motion or a force is not finite there")]
    NotFinite {
        /// Time reached, s.
        time: f64,
    },
}

/// Refuses what no pair can run.
pub(crate) fn check(system: &System, start: &State, tolerance: f64) -> Result<(), AdaptiveError> {
    if !system.obstacles().is_empty() {
        return Err(AdaptiveError::Contact(system.obstacles().len()));
    }
    if !system.moving_pins().is_empty() {
        return Err(AdaptiveError::MovingPins(system.moving_pins().len()));
    }
    if [start.x.len(), start.v.len()] != [system.len(); 2] {
        let found = start.v.len().min(start.x.len());
        return Err(AdaptiveError::SizeMismatch { expected: system.len(), found });
    }
    if !(1e-15..=0.1).contains(&tolerance) {
        return Err(AdaptiveError::Tolerance(tolerance));
    }
    Ok(())
}

/// One run of an adaptive method, as a user of a library would make it.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveRun {
    /// The last state.
    pub state: State,
    /// Number of steps taken, including rejected ones.
    pub steps: u32,
    /// Number of evaluations of all forces.
    pub evaluations: u64,
}

/// One run of a pair over `duration` seconds with the tolerance of `settings`, both relative and
/// absolute (in m and m/s). The error of the run is not computed.
///
/// # Errors
/// [`AdaptiveError`] if the scene has contacts or moving pins, if the start or the duration does not
/// fit, if there are too many steps, or if the motion blows up.
pub fn adaptive(
    pair: Pair,
    system: &System,
    start: &State,
    duration: f64,
    settings: AdaptiveSettings,
) -> Result<AdaptiveRun, AdaptiveError> {
    check(system, start, settings.tolerance)?;
    let end = start.t + duration;
    if !(duration > 0.0 && end.is_finite()) {
        return Err(AdaptiveError::Times { last: start.t, next: end });
    }
    let mut run = Stepper::new(pair, system, start, settings);
    run.advance(end)?;
    Ok(AdaptiveRun { state: run.state(), steps: run.steps, evaluations: run.evaluations })
}

/// `(x, v)' = (v, M⁻¹ f)`, with pinned particles at rest.
struct Motion<'a> {
    system: &'a System,
    pinned: Vec<usize>,
}

impl Motion<'_> {
    /// Writes the slope at `y`, positions and then velocities, to `slope`.
    fn slope(&self, t: f64, y: &[Vec3], slope: &mut [Vec3]) {
        let n = self.system.len();
        let ((x, v), (dx, dv)) = (y.split_at(n), slope.split_at_mut(n));
        self.system.forces(Level { t, x, v }, dv);
        dx.copy_from_slice(v);
        for (force, mass) in dv.iter_mut().zip(self.system.mass()) {
            *force /= *mass;
        }
        for &i in &self.pinned {
            (dx[i], dv[i]) = (Vec3::zeros(), Vec3::zeros());
        }
    }
}

/// Share of the step that the estimate allows.
const SAFETY: f64 = 0.9;

/// A run on its way.
pub(crate) struct Stepper<'a> {
    motion: Motion<'a>,
    tableau: &'static Tableau,
    settings: AdaptiveSettings,
    t: f64,
    /// Positions and then velocities at `t`, and at the stage at hand or the end of the step.
    y: Vec<Vec3>,
    next: Vec<Vec3>,
    /// The slopes of the stages, and at the end of the step.
    slopes: Vec<Vec<Vec3>>,
    /// The mean slope of a step, and what its estimates make of the slopes.
    mean: Vec<Vec3>,
    estimates: [Vec<Vec3>; 2],
    pub(crate) steps: u32,
    evaluations: u64,
}

impl<'a> Stepper<'a> {
    /// A run from `start`, with pinned particles at rest.
    pub(crate) fn new(
        pair: Pair,
        system: &'a System,
        start: &State,
        settings: AdaptiveSettings,
    ) -> Self {
        let pinned = system.pinned().iter().enumerate();
        let pinned = pinned.filter_map(|(i, is_pinned)| is_pinned.then_some(i)).collect();
        let mut v = start.v.clone();
        system.clear_pinned(&mut v);
        let zeros = || vec![Vec3::zeros(); 2 * system.len()];
        let tableau = pair.tableau();
        Self {
            motion: Motion { system, pinned },
            tableau,
            settings,
            t: start.t,
            y: [start.x.clone(), v].concat(),
            next: zeros(),
            slopes: (0..=tableau.stages()).map(|_| zeros()).collect(),
            mean: zeros(),
            estimates: [zeros(), zeros()],
            steps: 0,
            evaluations: 0,
        }
    }

    pub(crate) fn state(&self) -> State {
        let (x, v) = self.y.split_at(self.motion.system.len());
        State { t: self.t, x: x.to_vec(), v: v.to_vec() }
    }

    /// Steps to the time `end`. The first step is chosen anew.
    pub(crate) fn advance(&mut self, end: f64) -> Result<(), AdaptiveError> {
        let longest = end - self.t;
        let mut h = self.first_step(longest);
        let mut was_rejected = false;
        loop {
            if self.steps >= self.settings.max_steps {
                return Err(AdaptiveError::StepLimit { steps: self.steps, time: self.t });
            }
            if 0.1 * h <= f64::EPSILON * self.t.abs() || h.is_nan() {
                return Err(AdaptiveError::NotFinite { time: self.t });
            }
            let is_last = self.t + 1.01 * h - end > 0.0;
            if is_last {
                h = end - self.t;
            }
            self.steps += 1;
            let error = self.try_step(h);
            let is_accepted = error <= 1.0;
            let next = self.next_step(h, error, is_accepted).min(longest);
            if is_accepted {
                self.accept(h);
                if is_last {
                    self.t = end;
                    return Ok(());
                }
            }
            h = if is_accepted && was_rejected { next.min(h) } else { next };
            was_rejected = !is_accepted;
        }
    }

    /// The step after one of `h`, by its error in tolerances.
    fn next_step(&self, h: f64, error: f64, is_accepted: bool) -> f64 {
        let [least, greatest] = self.tableau.factors;
        let shrink = (error.powf(self.tableau.exponent) / SAFETY).min(1.0 / least);
        h / if is_accepted { shrink.max(1.0 / greatest) } else { shrink }
    }

    fn slope(&mut self, stage: usize, t: f64) {
        self.motion.slope(t, &self.next, &mut self.slopes[stage]);
        self.evaluations += 1;
    }

    /// Takes a step of `h` to `next` and returns its error in tolerances.
    fn try_step(&mut self, h: f64) -> f64 {
        for (stage, (a, c)) in (1..).zip(self.tableau.a.iter().zip(&self.tableau.c[1..])) {
            weighted_sum(Some(&self.y), &terms(a, h, &self.slopes), &mut self.next);
            self.slope(stage, self.t + h * c);
        }
        weighted_sum(None, &terms(self.tableau.b, 1.0, &self.slopes), &mut self.mean);
        weighted_sum(Some(&self.y), &[(h, &self.mean)], &mut self.next);
        match &self.tableau.error {
            Estimate::WithEnd(weights) => {
                self.slope(self.tableau.stages(), self.t + h);
                weighted_sum(None, &terms(weights, 1.0, &self.slopes), &mut self.estimates[0]);
                h * (self.squares(0) / self.numbers()).sqrt()
            }
            Estimate::Two { fifth, third: [first, ninth, twelfth] } => {
                let slopes = &self.slopes;
                weighted_sum(None, &terms(fifth, 1.0, slopes), &mut self.estimates[0]);
                let third = [
                    (-first, slopes[0].as_slice()),
                    (-ninth, slopes[8].as_slice()),
                    (-twelfth, slopes[11].as_slice()),
                ];
                weighted_sum(Some(&self.mean), &third, &mut self.estimates[1]);
                let (fifth, third) = (self.squares(0), self.squares(1));
                let both = fifth + 0.01 * third;
                let both = if both <= 0.0 { 1.0 } else { both };
                h * fifth * (1.0 / (both * self.numbers())).sqrt()
            }
        }
    }

    /// Makes `next` the present state.
    fn accept(&mut self, h: f64) {
        let end = self.tableau.stages();
        if let Estimate::Two { .. } = self.tableau.error {
            self.slope(end, self.t + h);
        }
        std::mem::swap(&mut self.y, &mut self.next);
        self.slopes.swap(0, end);
        self.t += h;
    }

    /// Writes the slope at the start and returns the first step: Hairer, Nørsett and Wanner, section
    /// II.4.
    fn first_step(&mut self, longest: f64) -> f64 {
        self.next.copy_from_slice(&self.y);
        self.slope(0, self.t);
        let (of_y, of_slope) = (self.scaled(&self.y), self.scaled(&self.slopes[0]));
        let guess =
            if of_y < 1e-10 || of_slope < 1e-10 { 1e-6 } else { 0.01 * (of_y / of_slope).sqrt() };
        let guess = guess.min(longest);
        weighted_sum(Some(&self.y), &[(guess, &self.slopes[0])], &mut self.next);
        self.slope(1, self.t + guess);
        weighted_sum(Some(&self.slopes[1]), &[(-1.0, &self.slopes[0])], &mut self.mean);
        let of_change = self.scaled(&self.mean).sqrt() / guess;
        let greater = of_slope.sqrt().max(of_change);
        let step = if greater <= 1e-15 {
            (guess * 1e-3).max(1e-6)
        } else {
            (0.01 / greater).powf(self.tableau.exponent)
        };
        (100.0 * guess).min(step.min(longest))
    }

    /// Number of unknowns.
    fn numbers(&self) -> f64 {
        (3 * self.y.len()) as f64
    }

    /// Σ (aᵢ / sᵢ)² with the scale `s` of the present state.
    fn scaled(&self, a: &[Vec3]) -> f64 {
        sum_of_squares(a, &self.y, &self.y, self.settings.tolerance)
    }

    /// Σ (eᵢ / sᵢ)² of an estimate, with the scale `s` of both ends of the step.
    fn squares(&self, estimate: usize) -> f64 {
        sum_of_squares(&self.estimates[estimate], &self.y, &self.next, self.settings.tolerance)
    }
}

/// The factors `h aⱼ` that are not 0, with their slopes.
fn terms<'a>(a: &[f64], h: f64, slopes: &'a [Vec<Vec3>]) -> Vec<(f64, &'a [Vec3])> {
    let terms = a.iter().zip(slopes).filter(|(a, _)| **a != 0.0);
    terms.map(|(a, slope)| (h * a, slope.as_slice())).collect()
}

/// Σ (aᵢ / sᵢ)² with `sᵢ = tolerance (1 + max(|yᵢ|, |zᵢ|))`, number by number. A chunk at a time is
/// divided before it is summed, because divisions need not wait for each other, but sums do.
fn sum_of_squares(a: &[Vec3], y: &[Vec3], z: &[Vec3], tolerance: f64) -> f64 {
    const CHUNK: usize = 32;
    let mut sum = 0.0;
    let mut squares = [[0.0; 3]; CHUNK];
    for ((a, y), z) in a.chunks(CHUNK).zip(y.chunks(CHUNK)).zip(z.chunks(CHUNK)) {
        for ((square, a), (y, z)) in squares.iter_mut().zip(a).zip(y.iter().zip(z)) {
            for k in 0..3 {
                let scale = tolerance + y[k].abs().max(z[k].abs()) * tolerance;
                let scaled = a[k] / scale;
                square[k] = scaled * scaled;
            }
        }
        for square in squares[..a.len()].as_flattened() {
            sum += square;
        }
    }
    sum
}
