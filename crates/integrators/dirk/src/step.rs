//! The step.

use crate::settings::{DIRK, DirkSettings};
use crate::tableau::Coefficients;
use crate::workspace::{Past, Workspace};
use drape_integrator::{
    ContactSet, Method, Order, Phase, PhaseClock, PrepareError, Registration, Rewind, Scheme,
    SolveStatus, Stage, StageMemory, StepError, StepReport, Stepper,
};
use drape_model::{Level, State, System};

/// A diagonally implicit Runge–Kutta method with Newton's method.
#[doc(alias = "TR-BDF2")]
#[doc(alias = "SDIRK")]
#[doc(alias = "ESDIRK")]
#[doc(alias = "Alexander 1977")]
#[doc(alias = "Hosea-Shampine 1996")]
pub type Dirk = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::controlled::<Workspace>(&DIRK);

impl Scheme for Workspace {
    type Settings = DirkSettings;

    fn method(_settings: &DirkSettings) -> &'static Method {
        &DIRK
    }

    fn new(system: &System, settings: &DirkSettings, _h: f64) -> Result<Self, PrepareError> {
        Self::allocate(system, settings)
    }

    fn step(
        &mut self,
        settings: &DirkSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        let tableau = settings.tableau.coefficients();
        let tau = tableau.gamma * h;
        self.begin(system, state, h, clock);
        for i in 0..tableau.rows.len() {
            clock.switch(Phase::Forces);
            if i == 0 && tableau.is_first_explicit {
                self.first_stage(system, state, &mut report); // w₁ = v_n, a₁ = M⁻¹f(x_n, v_n), (1)
                continue;
            }
            for particle in 0..state.len() {
                let (mut x, mut v) = (state.x[particle], state.v[particle]);
                for (j, a) in tableau.rows[i].iter().enumerate() {
                    x += self.w[j][particle] * (h * a); // X* = x_n + h Σ_{j<i} a_ij w_j, (2)
                    v += self.a[j][particle] * (h * a); // V* = v_n + h Σ_{j<i} a_ij a_j, (2)
                }
                self.memory.x_star[particle] = x;
                self.memory.v_star[particle] = v;
            }
            self.predict(tableau, i, state, h);
            for pass in 0..self.passes {
                self.again(system, i, pass);
                // M (w_i − V*) = τ f(X* + τ w_i, w_i), τ = γh, (3)
                self.solve(settings, system, state.t, (tableau, i, h), clock, &mut report)?;
            }
            clock.switch(Phase::Update);
            self.w[i].copy_from_slice(self.memory.stage.velocity());
            self.memory.unload(system, tau, &mut self.a[i], &mut report); // a_i = (w_i − V*)/τ, (4)
        }
        let last = tableau.rows.len() - 1;
        self.memory.lead(system, &state.x, h);
        state.x.copy_from_slice(self.memory.stage.positions()); // x_{n+1} = X_s: b is the last row, (5)
        state.v.copy_from_slice(&self.w[last]); // v_{n+1} = w_s, (5)
        self.finish(system, state, last);
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {
        self.past.known = None;
        self.memory.restart();
    }

    fn is_portable(settings: &DirkSettings) -> bool {
        settings.linear.is_portable()
    }
}

impl Workspace {
    /// Solves stage `i` of a step of `h` seconds; a stage that did not converge stays in the
    /// report.
    ///
    /// # Errors
    /// See [`drape_integrator::ImplicitStage::solve`].
    fn solve(
        &mut self,
        settings: &DirkSettings,
        system: &System,
        t: f64,
        (tableau, i, h): (&Coefficients, usize, f64),
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let Self { memory, w, .. } = self;
        let StageMemory { stage, x_star, v_star, ahead, contacts, constraints, first, .. } = memory;
        let end = t + tableau.time(i) * h;
        let lagged = Level { t: end, x: &ahead.0, v: &ahead.1 };
        let velocity: &[_] = if i > 0 { &w[i - 1] } else { first };
        let from = (&x_star[..], &v_star[..]);
        let input = Stage { tau: (tableau.gamma * h).into(), end, from, lagged, velocity };
        let (before, residual) = (report.solve, report.relative_residual);
        let how = settings.stage();
        stage.solve_constrained(
            system,
            input,
            Some(&ahead.1),
            contacts,
            constraints,
            how,
            clock,
            report,
        )?;
        report.relative_residual = report.relative_residual.max(residual);
        if before != SolveStatus::Converged {
            report.solve = before;
        }
        Ok(())
    }
}

impl Rewind for Workspace {
    type Past = Past;

    fn past(&mut self) -> (&mut Past, &mut ContactSet) {
        (&mut self.past, &mut self.memory.contacts)
    }

    fn tolerance(settings: &DirkSettings) -> f64 {
        settings.tolerance
    }

    fn order(settings: &DirkSettings) -> Order {
        settings.tableau.order()
    }

    /// `(√2 − 1)/2 − 1/6`, from the stability function that tr-bdf2 and sdirk2 share.
    fn error_constant(_settings: &DirkSettings, _omega: f64) -> f64 {
        0.5 * (std::f64::consts::SQRT_2 - 1.0) - 1.0 / 6.0
    }
}

#[cfg(test)]
mod tests;
