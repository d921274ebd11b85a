//! Checks that the tests of many integrators share.
//!
//! A check runs an integrator on a small scene and compares the motion with a law. It panics at the
//! first number that deviates, and its message begins with the name of the case. The caller
//! supplies everything that differs between methods, such as bounds and recurrences.

pub mod contact;

use crate::adaptive::AdaptiveSettings;
use crate::laws::{Drift, free_fall};
use crate::order::{ObservedOrder, of_method, position_error};
use crate::reference::{Reference, reference};
use crate::scenes::{GRAVITY, Sheet, anchored, build, in_a_gust, rotor, stir};
use crate::{Run, apart, order_of};
use drape_integrator::{Integrator, StepReport};
use drape_model::{SpringEffect, State, System, Vec3};
use nalgebra::{Matrix2, Vector2};
use std::fmt::Debug;

/// Step size of the checks, s: a power of two, so that multiples of it are exact.
pub const H: f64 = 1.0 / 64.0;

/// Mass of each particle on a spring, kg.
pub const MASS: f64 = 0.25;

/// Pairs `(θ, η)`: smooth, stiff and damped, stiff, at an edge, overdamped.
pub const PARAMETERS: [(f64, f64); 5] =
    [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0), (2.0, 30.0)];

/// Step sizes in units of [`H`], for methods that allow any sequence of sizes.
pub const SIZES: [f64; 5] = [1.0, 2.0, 0.75, 0.5, 1.5];

/// Stiffness, N/m, and damping, N s/m, of a spring on a particle of [`MASS`] that has `theta` and
/// `eta` at the step size `h`, s.
pub fn coefficients(theta: f64, eta: f64, h: f64) -> (f64, f64) {
    (theta * MASS / (h * h), eta * MASS / h)
}

/// A particle of [`MASS`] on a spring of rest length 0 that is anchored at the origin. Each
/// coordinate is a damped oscillator with `θ` and `η` at the step size [`H`].
pub fn oscillator(theta: f64, eta: f64) -> (System, State) {
    let (k, c) = coefficients(theta, eta, H);
    let (x, v) = (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    build(&anchored(MASS, &[(SpringEffect::Tension, 0.0, k, c)], x, v))
}

/// Takes 100 steps of a particle on anchored springs of rest length 0. The step sizes repeat
/// `sizes`, in units of [`H`].
///
/// Each step must equal the step of `matrix` from the state before it, up to `tolerance`. `matrix`
/// receives the step size and acts on `(x, hv)` of each axis. Returns the reports of the steps.
pub fn follows(
    case: impl Debug,
    integrator: Box<dyn Integrator>,
    start: (System, State),
    sizes: &[f64],
    tolerance: f64,
    matrix: impl Fn(f64) -> Matrix2<f64>,
) -> Vec<StepReport> {
    let mut run = Run::new(integrator, start, H);
    let one = |step: usize| {
        let size = sizes[step % sizes.len()];
        let (matrix, before) = (matrix(size), run.state.clone());
        let report = run.step_by(size * H);
        for axis in 0..3 {
            let at = |s: &State| Vector2::new(s.x[1][axis], size * H * s.v[1][axis]);
            let (expected, found) = (matrix * at(&before), at(&run.state));
            let scale = expected.norm().max(at(&before).norm()).max(1e-100);
            let off = (found - expected).norm() / scale;
            assert!(off < tolerance, "{case:?}, step {step}, axis {axis}: {off:e}");
        }
        report
    };
    (0..100).map(one).collect()
}

/// Takes steps of a particle [across](crate::scenes::across) two springs. Each step must equal the
/// step of `matrix` up to 1e-9. The check stops when the motion is so large that quadratic terms
/// matter.
pub fn moves_across(
    case: impl Debug,
    integrator: Box<dyn Integrator>,
    start: (System, State),
    matrix: Matrix2<f64>,
    steps: usize,
) {
    let mut run = Run::new(integrator, start, H);
    let at = |s: &State| Vector2::new(s.x[2].y, H * s.v[2].y);
    let amplitude = at(&run.state).norm();
    for step in 0..steps {
        let expected = matrix * at(&run.state);
        if expected.norm() > 1e3 * amplitude {
            break;
        }
        run.step();
        let off = (at(&run.state) - expected).norm() / expected.norm().max(amplitude);
        assert!(off < 1e-9, "{case:?}, step {step}: {off:e}");
    }
}

/// Takes 50 steps of a particle that moves along its spring of rest length `rest`. The elongation
/// must follow `matrix` up to 1e-9. `matrix` receives the step size in units of [`H`].
pub fn moves_along(
    case: impl Debug,
    integrator: Box<dyn Integrator>,
    (theta, eta): (f64, f64),
    rest: f64,
    sizes: &[f64],
    matrix: impl Fn(f64) -> Matrix2<f64>,
) {
    let direction = Vec3::new(0.0, 0.6, -0.8);
    let (k, c) = coefficients(theta, eta, H);
    let law = (SpringEffect::Tension, rest, k, c);
    let spec = anchored(MASS, &[law], direction * (rest + 0.25), Vec3::zeros());
    let mut run = Run::new(integrator, build(&spec), H);
    let (mut x, mut v) = (0.25, 0.0);
    for step in 0..50 {
        let size = sizes[step % sizes.len()];
        let h = size * H;
        let scale = libm::hypot(x, h * v).max(rest).max(0.25);
        run.step_by(h);
        let next = matrix(size) * Vector2::new(x, h * v);
        (x, v) = (next.x, next.y / h);
        let found = (direction.dot(&run.state.x[1]) - rest, direction.dot(&run.state.v[1]));
        let error = libm::hypot(found.0 - x, h * (found.1 - v));
        assert!(error < 1e-9 * scale, "{case:?}, θ={theta} η={eta} ℓ={rest}, {step}: {error:e}");
    }
}

/// Relative position and velocity of two particles, m and m/s.
pub fn pair(state: &State) -> (Vec3, Vec3) {
    (state.x[1] - state.x[0], state.v[1] - state.v[0])
}

/// The result of 100 steps of 0.01 s of a [`rotor`]. It should turn by 2 rad and conserve
/// everything else.
#[derive(Clone, Copy, Debug)]
pub struct Turned {
    /// Final spin over initial spin.
    pub spin: f64,
    /// Angle of rotation, rad.
    pub angle: f64,
    /// Final energy over initial energy.
    pub energy: f64,
    /// Final length over initial length.
    pub length: f64,
    /// Magnitude of the final momentum, kg m/s; the initial momentum is 0.
    pub momentum: f64,
}

/// Runs a [`rotor`] of this `theta` for a second.
pub fn turn(integrator: Box<dyn Integrator>, theta: f64) -> Turned {
    let mut run = Run::new(integrator, rotor(theta, 0.01), 0.01);
    let spin = |run: &Run| run.system.angular_momentum(&run.state).z;
    let (before, energy, first) = (spin(&run), run.energy(), pair(&run.state).0);
    let (mut angle, mut last) = (0.0, first);
    for _ in 0..100 {
        run.step();
        let now = pair(&run.state).0;
        angle += libm::atan2(last.cross(&now).z, last.dot(&now));
        last = now;
    }
    Turned {
        spin: spin(&run) / before,
        angle,
        energy: run.energy() / energy,
        length: last.norm() / first.norm(),
        momentum: run.system.momentum(&run.state).norm(),
    }
}

/// Drops a stiff sheet with a uniform velocity, so that no spring is strained. For 20 steps each
/// particle must move on the parabola of `drift`, with its velocity. Returns the reports of the
/// steps.
pub fn falls_freely(
    case: impl Debug,
    integrator: Box<dyn Integrator>,
    drift: Drift,
    bound: f64,
) -> Vec<StepReport> {
    let velocity = Vec3::new(1.0, -2.0, 3.0);
    let sheet = Sheet { side: 9, tension: 1e6, shear: 1e5, pinned: false, ..Sheet::default() };
    let (system, mut state) = sheet.build();
    state.v.fill(velocity);
    let start = state.clone();
    let mut run = Run::new(integrator, (system, state), H);
    let one = |step| {
        let report = run.step();
        for i in 0..start.len() {
            let (x, v) = free_fall(drift, start.x[i], velocity, GRAVITY, H, step);
            let off = (run.state.x[i] - x).norm() + (run.state.v[i] - v).norm();
            assert!(off < bound, "{case:?}, step {step}, particle {i}: {off:e}");
        }
        report
    };
    (1..=20).map(one).collect()
}

/// Takes 50 steps of a sheet that nothing holds. Returns the drift of its momentum, kg m/s.
pub fn momentum_drift(integrator: Box<dyn Integrator>, start: (System, State), h: f64) -> f64 {
    let mut run = Run::new(integrator, start, h);
    let before = run.system.momentum(&run.state);
    run.steps(50);
    (run.system.momentum(&run.state) - before).norm()
}

/// Takes three steps of a sheet, changes its pins and masses, and takes two more steps: once with
/// the integrator that saw the change, once with a new integrator.
pub fn after_a_change(new: impl Fn() -> Box<dyn Integrator>, h: f64) -> [Run; 2] {
    let mut kept = Run::new(new(), stir(Sheet::default().build(), 0.0, 0.3), h);
    kept.steps(3);
    assert!(kept.system.set_pinned(12, true) && kept.system.set_pinned(0, false), "particles");
    let heavier: Vec<f64> = kept.system.mass().iter().map(|m| 2.0 * m).collect();
    assert!(kept.system.set_mass(&heavier), "one mass a particle");
    let mut fresh = kept.fresh(new());
    kept.steps(2);
    fresh.steps(2);
    [kept, fresh]
}

/// Observed order in a [gust](in_a_gust), over runs with these numbers of equal steps. Each run is
/// compared with one of twice as many steps.
///
/// # Panics
/// If a run is refused, or if the distances give no order.
pub fn order_in_a_gust(new: impl Fn() -> Box<dyn Integrator>, steps: &[u32]) -> ObservedOrder {
    let span = 0.25;
    let end = |steps: u32| {
        let mut run = Run::new(new(), in_a_gust(), span / f64::from(steps));
        run.steps(steps as usize);
        run.state.x
    };
    order_of(span, steps, |steps| apart(&end(steps), &end(2 * steps)))
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The result of a run of the [hanging](Sheet::hanging) sheet.
#[derive(Clone, Copy, Debug)]
pub struct Hung {
    /// Relative error of the positions.
    pub error: f64,
    /// Length of the path of the middle of the free edge, m.
    pub path: f64,
    /// Height lost by that point, over the height that it loses in the exact motion.
    pub fall: f64,
}

/// The middle of the free edge of 20 × 20 particles.
fn middle(x: &[Vec3]) -> Vec3 {
    (x[389] + x[390]) * 0.5
}

/// A motion whose end is known, for measuring orders.
#[derive(Debug)]
pub struct Known {
    /// The system.
    pub system: System,
    /// The start.
    pub start: State,
    /// The exact end, with its error.
    pub exact: Reference,
    span: f64,
}

impl Known {
    /// The motion over `span` seconds, with the default reference.
    ///
    /// # Panics
    /// If no reference can be computed.
    pub fn new(start: (System, State), span: f64) -> Self {
        Self::with(start, span, AdaptiveSettings::default())
    }

    /// The motion over `span` seconds, with the reference that `settings` request.
    ///
    /// # Panics
    /// If no reference can be computed.
    pub fn with((system, start): (System, State), span: f64, settings: AdaptiveSettings) -> Self {
        let exact =
            reference(&system, &start, &[span], settings).unwrap_or_else(|error| panic!("{error}"));
        Self { system, start, exact, span }
    }

    /// A run from the start, in steps of `h` seconds.
    pub fn run(&self, integrator: Box<dyn Integrator>, h: f64) -> Run {
        Run::new(integrator, (self.system.clone(), self.start.clone()), h)
    }

    /// Relative error of the positions of a run that has reached the end.
    pub fn error(&self, run: &Run) -> f64 {
        position_error(&self.system, &self.start.x, &self.exact.states[0].x, &run.state.x)
    }

    /// Runs the [hanging](Sheet::hanging) sheet by steps of `h` seconds.
    pub fn hang(&self, integrator: Box<dyn Integrator>, h: f64) -> Hung {
        let mut run = self.run(integrator, h);
        let mut path = 0.0;
        for _ in 0..(self.span / h).round() as usize {
            let before = middle(&run.state.x);
            run.step();
            path += (middle(&run.state.x) - before).norm();
        }
        let fall = middle(&run.state.x).z / self.middle().z;
        Hung { error: self.error(&run), path, fall }
    }

    /// Position of the middle of the free edge of the [hanging](Sheet::hanging) sheet at the end,
    /// m.
    pub fn middle(&self) -> Vec3 {
        middle(&self.exact.states[0].x)
    }

    /// Observed order over runs with these numbers of equal steps.
    ///
    /// # Panics
    /// If a run is refused, or if its errors give no order.
    pub fn order(&self, new: impl FnMut() -> Box<dyn Integrator>, steps: &[u32]) -> ObservedOrder {
        of_method(new, &self.system, &self.start, &self.exact, steps)
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// Observed order over runs whose step sizes repeat `pattern` the given numbers of times.
    ///
    /// # Panics
    /// As [`order`](Self::order).
    pub fn order_by(
        &self,
        new: impl Fn() -> Box<dyn Integrator>,
        pattern: &[f64],
        counts: &[u32],
    ) -> ObservedOrder {
        let error = |count: u32| {
            let unit = self.span / (f64::from(count) * pattern.iter().sum::<f64>());
            let mut run = self.run(new(), unit);
            for size in (0..count).flat_map(|_| pattern) {
                run.step_by(unit * size);
            }
            self.error(&run)
        };
        order_of(self.span, counts, error).unwrap_or_else(|error| panic!("{error}"))
    }
}

/// Greatest rise of the total energy above its start, J, in `seconds` seconds of steps of 0.01 s.
/// It is negative if the energy falls from the first step on.
pub fn rise(integrator: Box<dyn Integrator>, start: (System, State), seconds: f64) -> f64 {
    let mut run = Run::new(integrator, start, 0.01);
    let before = run.energy();
    let steps = (0..(seconds * 100.0).round() as usize).map(|_| {
        run.step();
        run.energy() - before
    });
    steps.fold(f64::NEG_INFINITY, f64::max)
}
