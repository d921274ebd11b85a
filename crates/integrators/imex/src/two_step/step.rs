//! The step.

use super::past::Past;
use super::workspace::Workspace;
use super::{Coefficients, ImexTwoStepSettings, Scheme};
use drape_integrator::{
    Adaptive, Change, ContactSet, Integrator, Method, MultistepMotion, Phase, PhaseClock,
    PrepareError, Rewind, Scratch, Stage, StageSettings, Start, StepError, StepReport, TimeStep,
    drift,
};
use drape_model::{State, System, Vec3};

/// What arrives by less than this within a step, m, is no impact.
const TOUCHING: f64 = 1e-9;

/// A two-step implicit-explicit method of order 2: SBDF2, CNAB2, MCNAB2 or CNLF.
#[derive(Debug)]
pub struct ImexTwoStep {
    settings: ImexTwoStepSettings,
    scratch: Scratch<Workspace>,
}

impl ImexTwoStep {
    /// The method with its settings.
    pub fn new(settings: ImexTwoStepSettings) -> Self {
        Self { settings, scratch: Scratch::default() }
    }

    /// The method, under step size control where the settings ask for it.
    pub fn controlled(settings: ImexTwoStepSettings) -> Box<dyn Integrator> {
        Adaptive::boxed(Self::new(settings), settings.tolerance)
    }

    #[cfg(test)]
    pub(crate) fn workspace(&mut self) -> &mut Workspace {
        self.scratch.get_mut().expect("prepared")
    }
}

impl Workspace {
    /// The step without a usable past: backward Euler, converged. IMEX Euler would not do: it multiplies
    /// velocities across springs by `1/(1+θ)`, and two-step methods keep what they start with.
    fn start(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let Self { starter, contacts, constraints, velocity, position, .. } = self;
        let from = (&state.x[..], &state.v[..]);
        let (end, lagged) = (state.t + h, state.level());
        let stage = Stage { tau: h, end, from, lagged, velocity: &state.v };
        let settings = StageSettings::default();
        starter.solve(system, stage, &state.v, contacts, constraints, settings, clock, report)?;
        velocity.copy_from_slice(starter.velocity());
        position.copy_from_slice(starter.positions());
        Ok(())
    }

    /// The step with a past: `(M + τ² L_k + τ L_c) v_{n+1} = b`, `x_{n+1} = X* + τ v_{n+1}`, which is EEH (9)
    /// after the reduction of section 2.3.
    #[doc(alias = "EEH 9")]
    #[expect(clippy::too_many_arguments, reason = "each is owned by the step that calls")]
    fn proceed(
        &mut self,
        system: &System,
        settings: &ImexTwoStepSettings,
        state: &State,
        h: f64,
        coefficients: Coefficients,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let tau = coefficients.tau(h);
        clock.switch(Phase::Forces);
        report.force_evaluations = self.assemble(system, settings, state, h, &coefficients); // EEH (8)
        if settings.tolerance > 0.0 && settings.sees_splitting {
            let Self { splitting, past, present, .. } = self;
            let omega = past.step_ratio(system, h).unwrap_or(1.0);
            splitting.expect_extrapolated(omega, &present.explicit, &past.forces.explicit);
        }
        clock.switch(Phase::Contact);
        let from = (&state.x[..], &state.v[..]);
        let motion = MultistepMotion { from, h, end: state.t + h, x_star: &self.position, tau };
        self.contacts.detect_multistep(system, motion, &mut self.constraints);
        clock.switch(Phase::Solve);
        let reference = self.reference(system, state, tau, settings.linear.forcing_term);
        self.velocity.copy_from_slice(&state.v);
        if settings.start == Start::Extrapolated {
            self.past.extrapolate(h, &mut self.velocity); // EEH (22)
        }
        let Self { linear, contacts, constraints, b, velocity: v, impulse, .. } = self;
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            *report += linear.solve_relative_to(constraints, b, v, reference); // EEH (9)
            wanted.fill(v, |impulse| {
                linear.constraint_impulse(b, v, impulse);
                report.matvecs += 1;
            });
            Ok::<(), StepError>(())
        })?;
        drift(tau, v, &mut self.position); // x_{n+1} = X* + τ v_{n+1}
        Ok(())
    }
}

impl Integrator for ImexTwoStep {
    fn method(&self) -> &'static Method {
        self.settings.scheme.method()
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        self.method().check(system)?;
        let tau = self.settings.scheme.at_constant_step().tau(h.seconds());
        self.scratch.set(system, Workspace::new(system, &self.settings, tau)?);
        Ok(())
    }

    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let w = self.scratch.ready(system, state, h)?;
        let (h, settings) = (h.seconds(), &self.settings);
        let omega = w.past.step_ratio(system, h);
        let continued = omega.and_then(|omega| settings.scheme.coefficients(omega));
        let tau = continued.unwrap_or(settings.scheme.at_constant_step()).tau(h);
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(w.linear.refresh(system, tau)?); // M + τ² L_k + τ L_c
        w.evaluate_external(system, state);
        w.splitting.expect_nothing();
        match continued {
            Some(c) => w.proceed(system, settings, state, h, c, clock, &mut report)?,
            None => w.start(system, state, h, clock, &mut report)?,
        }
        clock.switch(Phase::Update);
        let Workspace {
            contacts, constraints, past, present, velocity, position, external, ..
        } = w;
        past.remember(system, state, h, continued.map(|_| present));
        state.v.swap_with_slice(velocity);
        state.x.copy_from_slice(position);
        let (x, v_n, mass) = (&state.x, velocity, system.mass());
        contacts.settle(&mut state.v, |Change { particle: i, velocity: v, filter, surface }| {
            // After a rebound it flies, else it rests.
            let flies = filter.complement(v - surface).dot(&(v_n[i] - surface)) < 0.0;
            let a = if flies { external[i] / mass[i] } else { Vec3::zeros() };
            // The friction of an impact changes the velocity along the surface, too; that of a contact which begins at rest
            // is a force as any other.
            let arrives = filter.complement(v_n[i] - surface).norm() * h > TOUCHING;
            let rewritten = if arrives { constraints.filter(i) } else { filter };
            past.meet(i, rewritten, (x[i], *v), a);
        });
        state.t += h;
        clock.stop();
        Ok(report)
    }

    fn restart(&mut self, _state: &State) {
        if let Some(w) = self.scratch.get_mut() {
            w.restart();
        }
    }
}

impl Rewind for ImexTwoStep {
    type Past = (Past, ContactSet);

    fn new_past(&self) -> Option<Self::Past> {
        self.scratch.get().map(|w| (w.past.clone(), w.contacts.clone()))
    }

    fn keep(&self, (past, contacts): &mut Self::Past) {
        if let Some(w) = self.scratch.get() {
            past.copy_from(&w.past);
            contacts.copy_from(&w.contacts);
        }
    }

    fn recall(&mut self, (past, contacts): &Self::Past) {
        if let Some(w) = self.scratch.get_mut() {
            w.past.copy_from(past);
            w.contacts.copy_from(contacts);
        }
    }

    fn contacts(&self) -> Option<&ContactSet> {
        self.scratch.get().map(|w| &w.contacts)
    }

    /// The Adams–Bashforth part of the Crank–Nicolson methods has the greater constant of their two parts.
    fn error_constant(&self, omega: f64) -> f64 {
        match self.settings.scheme {
            Scheme::Sbdf2 => (1.0 + omega) * (1.0 + omega) / (6.0 * omega * (1.0 + 2.0 * omega)),
            _ => 1.0 / 6.0 + 1.0 / (4.0 * omega),
        }
    }

    fn add_splitting_error(
        &mut self,
        system: &System,
        to: &State,
        h: f64,
        error: &mut [Vec3],
        report: &mut StepReport,
    ) {
        let ImexTwoStepSettings { scheme, implicit, .. } = self.settings;
        if let Some(w) = self.scratch.get_mut() {
            let Workspace { splitting, linear, constraints, .. } = w;
            let tau = scheme.at_constant_step().tau(h);
            let force =
                |_: &_, out: &mut [Vec3]| implicit.forces_but_linear(system, to.level(), out);
            splitting.add(system, force, tau, linear, constraints, error, report);
        }
    }
}
