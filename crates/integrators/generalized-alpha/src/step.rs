//! The step.

use crate::settings::{Coefficients, GENERALIZED_ALPHA, GeneralizedAlphaSettings};
use crate::workspace::Workspace;
use drape_integrator::{
    Method, Phase, PhaseClock, PrepareError, Registration, Scheme, Stage, StageMemory, StepError,
    StepReport, Stepper, Tau,
};
use drape_model::{Level, State, System};

/// The generalized-α family with Newton's method.
#[doc(alias = "Newmark 1959")]
#[doc(alias = "HHT-alpha")]
#[doc(alias = "Chung-Hulbert 1993")]
pub type GeneralizedAlpha = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&GENERALIZED_ALPHA);

impl Scheme for Workspace {
    type Settings = GeneralizedAlphaSettings;

    fn method(_settings: &GeneralizedAlphaSettings) -> &'static Method {
        &GENERALIZED_ALPHA
    }

    fn new(
        system: &System,
        settings: &GeneralizedAlphaSettings,
        _h: f64,
    ) -> Result<Self, PrepareError> {
        Self::allocate(system, settings)
    }

    fn step(
        &mut self,
        settings: &GeneralizedAlphaSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        let Coefficients { alpha_m, alpha_f, beta, gamma } = settings.coefficients();
        let (kick, end) = (h * gamma / (1.0 - alpha_m), state.t + h);
        // x_{n+1} = X* + τ_x v_{n+1},  M (v_{n+1} − V*) = τ_v f_{n+1}, (3)
        let tau = Tau { x: h * beta / gamma, v: kick * (1.0 - alpha_f) };
        self.begin(system, state, h, clock, &mut report); // a_n and g_n = M⁻¹f_n
        for i in 0..state.len() {
            let (x, v, a, g) = (state.x[i], state.v[i], self.a[i], self.g[i]);
            let (first, free) = (self.memory.first[i], self.along(i, a));
            let change = a * (h * (1.0 - gamma));
            // X* = x_n + h v_n + h² (½ − β) a_n − τ_x (v_n + h (1 − γ) a_n), (4)
            let bend = h * h * (0.5 - beta) - tau.x * (h * (1.0 - gamma));
            self.memory.x_star[i] = x + first * (h - tau.x) + free * bend;
            // V* = v_n + h (1 − γ) a_n + hγ/(1 − α_m) (α_f M⁻¹f_n − α_m a_n), (4)
            self.memory.v_star[i] = v + change + (g * alpha_f - a * alpha_m) * kick;
            // The new level as a_n sees it: start of Newton's method, directions of damping.
            self.memory.ahead.1[i] = first + free * h;
            self.memory.ahead.0[i] = x + (first + free * (0.5 * h)) * h;
        }
        let StageMemory { stage, x_star, v_star, ahead, contacts, constraints, .. } =
            &mut self.memory;
        let lagged = Level { t: end, x: &ahead.0, v: &ahead.1 };
        let from = (&x_star[..], &v_star[..]);
        let input = Stage { tau, end, from, lagged, velocity: &state.v };
        stage.solve_constrained(
            system,
            input,
            Some(&ahead.1),
            contacts,
            constraints,
            settings.stage,
            clock,
            &mut report,
        )?;
        clock.switch(Phase::Update);
        // g_{n+1} = (v_{n+1} − V*)/τ_v = M⁻¹f_{n+1}, (5)
        self.memory.unload(system, tau.v, &mut self.g_new, &mut report);
        for i in 0..state.len() {
            let mixed = self.g_new[i] * (1.0 - alpha_f) + self.g[i] * alpha_f - self.a[i] * alpha_m;
            self.a[i] = mixed / (1.0 - alpha_m); // a_{n+1}, (1)
        }
        std::mem::swap(&mut self.g, &mut self.g_new);
        self.memory.lead(system, &state.x, h);
        state.v.copy_from_slice(self.memory.stage.velocity());
        state.x.copy_from_slice(self.memory.stage.positions());
        self.finish(system, state);
        state.t = end;
        Ok(report)
    }

    fn restart(&mut self) {
        self.known = None;
        self.memory.restart();
    }

    fn is_portable(settings: &GeneralizedAlphaSettings) -> bool {
        settings.stage.linear.is_portable()
    }
}

#[cfg(test)]
mod tests;
