//! The step.

use crate::settings::{MIDPOINT, MidpointSettings};
use drape_integrator::{
    ContactSet, EnergyLedger, ImplicitStage, Method, MultistepMotion, Phase, PhaseClock, Predictor,
    PrepareError, Registration, Rewind, Scheme, Stage, Start, StepError, StepReport, Stepper,
    Taken,
};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::Constraints;
use drape_solvers::bands::bands;

/// Implicit midpoint with Newton's method.
#[doc(alias = "Gauss-Legendre")]
#[doc(alias = "Volino-Magnenat-Thalmann 2005")]
pub type Midpoint = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::controlled::<Workspace>(&MIDPOINT);

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) stage: ImplicitStage,
    /// `(x̂, v̂)`: the middle of the step, predicted, m and m/s.
    pub(crate) ahead: (Vec<Vec3>, Vec<Vec3>),
    /// `∇Φ(w)`, kg m/s; filled where there are contacts.
    impulse: Vec<Vec3>,
    /// `v_{n+1}` before contacts cut it, m/s.
    pub(crate) unsettled: Vec<Vec3>,
    /// Remembers `w`, the velocity in the middle of the last step.
    predictor: Predictor,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl Scheme for Workspace {
    type Settings = MidpointSettings;

    fn method(_settings: &MidpointSettings) -> &'static Method {
        &MIDPOINT
    }

    fn new(system: &System, settings: &MidpointSettings, _h: f64) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            stage: ImplicitStage::with_linear(system, settings.stage.linear)?,
            ahead: (zeros(), zeros()),
            impulse: ContactSet::impulse(system),
            unsettled: zeros(),
            predictor: Predictor::new(system.len()),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
        })
    }

    fn step(
        &mut self,
        settings: &MidpointSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        let half = 0.5 * h;
        clock.switch(Phase::Contact);
        let (from, end) = ((&state.x[..], &state.v[..]), state.t + h);
        // x_{n+1} = x_n + h w, so the contacts of the whole step are those of w.
        let motion = MultistepMotion { from, h, end, x_star: &state.x, tau: h };
        self.contacts.detect_multistep(system, motion, &mut self.constraints);
        self.look_ahead(system, state, h);
        let Self { stage, ahead: (x_hat, v_hat), contacts, constraints, .. } = self;
        let lagged = Level { t: state.t + half, x: x_hat, v: v_hat };
        let (tau, end) = (half.into(), state.t + half);
        let input = Stage { tau, end, from, lagged, velocity: &state.v };
        let how = settings.stage;
        let start = (settings.start == Start::Best).then_some(&v_hat[..]);
        // M (w − v_n) = h/2 f(x_n + h/2 w, w), (1)
        stage.solve_constrained(
            system,
            input,
            start,
            contacts,
            constraints,
            how,
            clock,
            &mut report,
        )?;
        clock.switch(Phase::Update);
        self.finish(system, state, h, &mut report);
        Ok(report)
    }

    fn restart(&mut self) {
        self.predictor.restart();
        self.contacts.restart();
        self.stage.restart();
    }

    fn ledger(&mut self, _: &MidpointSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(settings: &MidpointSettings) -> bool {
        settings.stage.linear.is_portable()
    }
}

impl Workspace {
    /// Predicts the middle of the step: `v̂ = 2 v_n − w` of the last step, `x̂ = x_n + h/2 v̂`.
    /// Both are within `O(h²)`, so the lagged parts of damping and drag keep order 2.
    fn look_ahead(&mut self, system: &System, state: &State, h: f64) {
        let (x_hat, v_hat) = &mut self.ahead;
        let bands = bands(system.threads(), system.len());
        self.predictor.extrapolate(&state.v, h, bands, v_hat);
        self.constraints.impose(v_hat);
        for i in 0..x_hat.len() {
            x_hat[i] = state.x[i] + v_hat[i] * (0.5 * h);
        }
    }

    /// Moves the state to the end of the step.
    fn finish(&mut self, system: &System, state: &mut State, h: f64, report: &mut StepReport) {
        let Self { stage, impulse, unsettled, predictor, contacts, constraints, .. } = self;
        if !contacts.is_empty() {
            impulse.copy_from_slice(stage.gradient(system));
            report.force_evaluations += 1;
        }
        let w = stage.velocity();
        for i in 0..w.len() {
            state.x[i] += w[i] * h; // x_{n+1} = x_n + h w, (2)
            state.v[i] = if system.pinned()[i] {
                w[i]
            } else {
                w[i] + (w[i] - state.v[i]) // v_{n+1} = 2 w − v_n, (2)
            };
        }
        // Obstacles act on w; the second half of the step takes the forces alone, (3).
        if !contacts.is_empty() {
            for (i, m) in system.mass().iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
                state.v[i] -= constraints.filter(i).complement(impulse[i]) / *m;
            }
        }
        unsettled.copy_from_slice(&state.v);
        predictor.remember(w, h);
        contacts.settle(&mut state.v, |c| predictor.forget(c.particle, c.velocity));
        contacts.stop(&mut state.v);
        state.t += h;
    }
}

impl Rewind for Workspace {
    type Past = Predictor;

    fn past(&mut self) -> (&mut Predictor, &mut ContactSet) {
        (&mut self.predictor, &mut self.contacts)
    }

    fn tolerance(settings: &MidpointSettings) -> f64 {
        settings.tolerance
    }

    /// `1/12`, from `R(z) = 1 + z + z²/2 + z³/4 + …`.
    fn error_constant(_settings: &MidpointSettings, _omega: f64) -> f64 {
        1.0 / 12.0
    }
}

#[cfg(test)]
mod tests;
