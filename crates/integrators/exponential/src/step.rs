//! The step.

use crate::jacobian::Jacobian;
use crate::krylov::Krylov;
use crate::settings::{EXPONENTIAL, ExponentialSettings};
use drape_integrator::{
    Method, Phase, PhaseClock, PrepareError, Registration, Scheme, StepError, StepReport, Stepper,
};
use drape_model::{State, System, Vec3};
use drape_solvers::SolveStatus;

/// The exponential Rosenbrock-Euler method.
#[doc(alias = "ERE")]
#[doc(alias = "exponential integrator")]
pub type Exponential = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&EXPONENTIAL);

/// Most parts into which a step is divided.
const MAX_SUBSTEPS: u32 = 32;

/// Memory of a step.
#[derive(Debug)]
pub struct Workspace {
    jacobian: Jacobian,
    krylov: Krylov,
    /// `a = M⁻¹ f`, m/s².
    acceleration: Vec<Vec3>,
    /// `J F`, in the units of [`Jacobian`].
    flow: Vec<Vec3>,
    /// The state before the step, for a step that fails.
    before: State,
}

impl Scheme for Workspace {
    type Settings = ExponentialSettings;

    fn method(_settings: &ExponentialSettings) -> &'static Method {
        &EXPONENTIAL
    }

    fn new(system: &System, settings: &ExponentialSettings, _h: f64) -> Result<Self, PrepareError> {
        let zeros = |n: usize| vec![Vec3::zeros(); n];
        let n = system.len();
        Ok(Self {
            jacobian: Jacobian::new(system),
            krylov: Krylov::new(2 * n, settings.max_dim),
            acceleration: zeros(n),
            flow: zeros(2 * n),
            before: State { t: 0.0, x: zeros(n), v: zeros(n) },
        })
    }

    fn step(
        &mut self,
        settings: &ExponentialSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport { substeps: 0, ..StepReport::default() };
        self.before.copy_from(state);
        let (mut left, mut longest) = (h, h);
        while left > 0.0 {
            let wanted = longest.min(left);
            self.linearise(system, state, clock, &mut report);
            clock.switch(Phase::Solve);
            let Self { jacobian, krylov, .. } = self;
            let least = h / f64::from(MAX_SUBSTEPS);
            let product = |u: &[Vec3], out: &mut [Vec3]| jacobian.multiply(system, u, out);
            let served = krylov.serve(wanted, least, settings.krylov_tol, product);
            // Orthogonalising m vectors takes the operations of m²/16 products.
            let m = krylov.dimension() as u32;
            report.matvecs += m + m * m / 16;
            clock.switch(Phase::Update);
            let Some(tau) = served else {
                if self.is_finite() {
                    state.copy_from(&self.before);
                    let (needed, most) = (MAX_SUBSTEPS.saturating_mul(2), MAX_SUBSTEPS);
                    return Err(StepError::TooManySubsteps { needed, most });
                }
                self.blow_up(left, state);
                report.solve = SolveStatus::Stagnated;
                report.substeps += 1;
                break;
            };
            self.advance(tau, state);
            report.substeps += 1;
            // A substep that took at most half of the dimensions lets the next be twice as long.
            let is_easy = 2 * self.krylov.dimension() <= settings.max_dim;
            longest = if is_easy { 2.0 * tau } else { tau };
            left = if tau >= left { 0.0 } else { left - tau };
            state.t = self.before.t + (h - left);
        }
        state.t = self.before.t + h;
        Ok(report)
    }

    fn restart(&mut self) {}

    fn is_portable(_settings: &ExponentialSettings) -> bool {
        true
    }
}

/// The equations of a step.
impl Workspace {
    /// `F = (v_n, a)`, `J` and `g = J F`.
    fn linearise(
        &mut self,
        system: &System,
        state: &State,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) {
        clock.switch(Phase::Forces);
        let Self { jacobian, krylov, acceleration, flow, .. } = self;
        system.forces(state.level(), acceleration);
        report.force_evaluations += 1;
        for (a, m) in acceleration.iter_mut().zip(system.mass()) {
            *a /= *m;
        }
        system.clear_pinned(acceleration);
        clock.switch(Phase::MatrixSetup);
        jacobian.linearise(system, state);
        jacobian.apply_to_flow(system, acceleration, flow);
        report.matvecs += 1;
        krylov.begin(flow);
    }

    /// `y ← y + τ F + τ² φ₂(τJ) J F`, which is `y + τ φ₁(τJ) F`, (1).
    fn advance(&mut self, tau: f64, state: &mut State) {
        let Self { krylov, acceleration, flow, jacobian, .. } = self;
        let n = acceleration.len();
        flow.fill(Vec3::zeros());
        krylov.combine(|c, u| flow.iter_mut().zip(u).for_each(|(sum, u)| *sum += u * c));
        let (x, v) = flow.split_at(n);
        for i in 0..n {
            state.x[i] += (state.v[i] + x[i] * (tau * jacobian.scale)) * tau;
            state.v[i] += (acceleration[i] + v[i] * tau) * tau;
        }
    }

    fn is_finite(&self) -> bool {
        self.flow.iter().chain(&self.acceleration).all(|a| a.norm_squared().is_finite())
    }

    /// A step that cannot be computed, because numbers overflow: `φ₂ ≈ ½`.
    fn blow_up(&self, tau: f64, state: &mut State) {
        let n = self.acceleration.len();
        for i in 0..n {
            let x = self.flow[i] * (0.5 * tau * self.jacobian.scale);
            state.x[i] += (state.v[i] + x) * tau;
            state.v[i] += (self.acceleration[i] + self.flow[n + i] * (0.5 * tau)) * tau;
        }
    }
}

#[cfg(test)]
mod tests;
