//! The step.

use super::past::Past;
use super::split_forces::SplitForces;
use super::workspace::Workspace;
use super::{
    Coefficients, IMEX_CNAB2, IMEX_CNLF, IMEX_MCNAB2, IMEX_SBDF2, ImexTwoStepSettings, Scheme,
};
use drape_integrator::{
    Change, ContactSet, Method, MultistepMotion, Phase, PhaseClock, PrepareError, Registration,
    Rewind, Stage, StageSettings, Start, StepError, StepReport, Stepper, drift,
};
use drape_model::{Level, State, System, Vec3};

/// A two-step implicit-explicit method of order 2: SBDF2, CNAB2, MCNAB2 or CNLF.
pub type ImexTwoStep = Stepper<Workspace>;

/// The four methods differ in their formula only. Their first step is one of backward Euler, which factorises.
const TWO_STEP: Registration = Registration {
    method: &IMEX_SBDF2,
    build: |s| Ok(ImexTwoStep::controlled(ImexTwoStepSettings::of(Scheme::Sbdf2, s))),
    is_portable: |_| false,
    follows_springs: |_| false,
};

/// SBDF2, for the registry.
pub static SBDF2: Registration = TWO_STEP;

/// CNAB2, for the registry.
pub static CNAB2: Registration = Registration {
    method: &IMEX_CNAB2,
    build: |s| Ok(ImexTwoStep::controlled(ImexTwoStepSettings::of(Scheme::Cnab2, s))),
    ..TWO_STEP
};

/// MCNAB2, for the registry.
pub static MCNAB2: Registration = Registration {
    method: &IMEX_MCNAB2,
    build: |s| Ok(ImexTwoStep::controlled(ImexTwoStepSettings::of(Scheme::Mcnab2, s))),
    ..TWO_STEP
};

/// CNLF, for the registry.
pub static CNLF: Registration = Registration {
    method: &IMEX_CNLF,
    build: |s| Ok(ImexTwoStep::controlled(ImexTwoStepSettings::of(Scheme::Cnlf, s))),
    ..TWO_STEP
};

/// A particle that arrives by less than this within a step, m, makes no impact.
const TOUCHING: f64 = 1e-9;

/// Round-off of a force over `k |x|`, and of a momentum over `m |v|`.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

impl drape_integrator::Scheme for Workspace {
    type Settings = ImexTwoStepSettings;

    fn method(settings: &ImexTwoStepSettings) -> &'static Method {
        settings.scheme.method()
    }

    fn new(system: &System, settings: &ImexTwoStepSettings, h: f64) -> Result<Self, PrepareError> {
        let tau = settings.scheme.at_constant_step().tau(h);
        Self::allocate(system, settings, tau)
    }

    fn step(
        &mut self,
        settings: &ImexTwoStepSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let omega = self.past.step_ratio(system, h);
        let continued = omega.and_then(|omega| settings.scheme.coefficients(omega));
        let tau = continued.unwrap_or(settings.scheme.at_constant_step()).tau(h);
        clock.switch(Phase::MatrixSetup);
        let mut report = StepReport::after_setup(self.linear.refresh(system, tau)?); // M + τ² L_k + τ L_c
        self.external.fill(Vec3::zeros());
        for effect in system.effects().filter(|effect| !effect.has_jacobian()) {
            effect.add_force(system.mass(), &state.x, &mut self.external);
        }
        self.splitting.expect_nothing();
        match continued {
            Some(c) => self.proceed(system, settings, state, h, c, clock, &mut report)?,
            None => self.start(system, state, h, clock, &mut report)?,
        }
        clock.switch(Phase::Update);
        let Self { contacts, constraints, past, present, velocity, position, external, .. } = self;
        past.remember(system, state, h, continued.map(|_| present));
        state.v.swap_with_slice(velocity);
        state.x.copy_from_slice(position); // x_{n+1} = X* + τ v_{n+1}
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
        Ok(report)
    }

    fn restart(&mut self) {
        self.past.restart();
        self.contacts.restart();
    }

    fn is_portable(_settings: &ImexTwoStepSettings) -> bool {
        false
    }
}

impl Workspace {
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
        report.force_evaluations = self.assemble(system, settings, state, h, &coefficients); // X* and b, EEH (8)
        if settings.sees_splitting() {
            let Self { splitting, past, present, .. } = self;
            let omega = past.step_ratio(system, h).unwrap_or(1.0);
            splitting.expect_extrapolated(omega, &present.explicit, &past.forces.explicit);
        }
        clock.switch(Phase::Contact);
        let from = (&state.x[..], &state.v[..]);
        let motion = MultistepMotion { from, h, end: state.t + h, x_star: &self.position, tau };
        self.contacts.detect_multistep(system, motion, &mut self.constraints);
        clock.switch(Phase::Solve);
        let reference = self.reference(system, state, tau, settings.forcing_term);
        self.velocity.copy_from_slice(&state.v);
        if settings.start == Start::Extrapolated {
            self.past.extrapolate(h, &mut self.velocity); // EEH (22)
        }
        let Self { linear, contacts, constraints, b, velocity: v, impulse, .. } = self;
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            *report += linear.solve_relative_to(constraints, b, v, reference); // (M + τ² L_k + τ L_c) v_{n+1} = b, EEH (9)
            wanted.fill(v, |impulse| {
                linear.constraint_impulse(b, v, impulse);
                report.matvecs += 1;
            });
            Ok::<(), StepError>(())
        })?;
        drift(tau, v, &mut self.position); // x_{n+1} = X* + τ v_{n+1}
        Ok(())
    }

    /// What is known of the new level, `−γ̄_n` of EEH (8): its part in the positions, `X*`, and, after the
    /// positions are eliminated, its part in the velocities, `b`. Returns the number of sweeps over the springs.
    ///
    /// ```text
    /// X* = (1/a_0) [−a_1 x_n − a_2 x_{n−1} + h (b_1 v_n + b_2 v_{n−1})]
    /// b  = −(1/a_0) M (a_1 v_n + a_2 v_{n−1})
    ///      + (h/a_0) [c_1 F_n + c_2 F_{n−1} + b_1 G_n + b_2 G_{n−1}] − τ L_k X*
    /// ```
    #[doc(alias = "EEH 8")]
    fn assemble(
        &mut self,
        system: &System,
        settings: &ImexTwoStepSettings,
        state: &State,
        h: f64,
        coefficients: &Coefficients,
    ) -> u32 {
        let Coefficients { a: [a0, _, a2], b: [_, b1, b2], c: [c1, c2] } = *coefficients;
        let (implicit, tau, n) = (settings.implicit, coefficients.tau(h), state.len());
        let sweeps = self.past.update_forces(system, implicit);
        self.present.evaluate(system, implicit, state.level());
        let (x, v) = (&state.x, &state.v);
        let Level { x: x_old, v: v_old, .. } = self.past.level();
        // With a_1 = −a_0 − a_2, so that what does not move stays to the last bit.
        for i in 0..n {
            let drift = v[i] * b1 + v_old[i] * b2;
            self.position[i] = x[i] + (x[i] - x_old[i]) * (a2 / a0) + drift * (h / a0); // X*
        }
        self.scratch.fill(Vec3::zeros());
        implicit.add_linear_spring_forces(system, &self.position, &mut self.scratch); // −L_k X*
        let (now, old) = (&self.present, &self.past.forces);
        for (i, &m) in system.mass().iter().enumerate() {
            let inertia = v[i] + (v[i] - v_old[i]) * (a2 / a0);
            let force = now.explicit[i] * c1
                + old.explicit[i] * c2
                + now.linear[i] * b1
                + old.linear[i] * b2;
            self.b[i] = inertia * m + force * (h / a0) + self.scratch[i] * tau;
        }
        sweeps + SplitForces::SWEEPS + 1
    }

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

    /// What residuals are compared with, kg m/s: the change of momentum that the forces of level `n`, or the
    /// external ones alone if those are larger, would make within `τ`; at least so much that `ε` times
    /// it is not below round-off.
    ///
    /// `|b|` would not do. It grows with the speed of the sheet as a whole, so that a sheet would be solved
    /// the more loosely the faster it flies, and across the springs like `θ`: `b = A v` there, and `A` has
    /// the whole stiffness in directions in which the springs have none.
    ///
    /// What friction holds counts as free along the surface: where it turns out to slide, the same reference serves, and
    /// a reference without the forces along the surface would be nil for what wholly lies on it.
    fn reference(&mut self, system: &System, state: &State, tau: f64, forcing_term: f64) -> f64 {
        let Self { linear, contacts, constraints, scratch, present, external, .. } = self;
        for ((s, f), g) in scratch.iter_mut().zip(&present.explicit).zip(&present.linear) {
            *s = (f + g) * tau;
        }
        let (total, external) = contacts.without_friction(system, constraints, |constraints| {
            let total = linear.filtered_norm(constraints, scratch);
            (total, tau * linear.filtered_norm(constraints, external))
        });
        let reach = state.x.iter().fold(0.0, |a: f64, x| a.max(x.amax()));
        for (i, s) in scratch.iter_mut().enumerate() {
            let m = system.mass()[i];
            let springs = (linear.matrix().diagonal(i) - m) * (reach / tau);
            s.fill(ROUND_OFF * (springs + m * state.v[i].amax()));
        }
        let round_off = contacts.without_friction(system, constraints, |constraints| {
            linear.filtered_norm(constraints, scratch)
        });
        total.max(external).max(round_off / forcing_term)
    }
}

impl Rewind for Workspace {
    type Past = Past;

    fn past(&mut self) -> (&mut Past, &mut ContactSet) {
        (&mut self.past, &mut self.contacts)
    }

    fn tolerance(settings: &ImexTwoStepSettings) -> f64 {
        settings.tolerance
    }

    /// The Adams–Bashforth part of the Crank–Nicolson methods has the greater constant of their two parts.
    fn error_constant(settings: &ImexTwoStepSettings, omega: f64) -> f64 {
        match settings.scheme {
            Scheme::Sbdf2 => (1.0 + omega) * (1.0 + omega) / (6.0 * omega * (1.0 + 2.0 * omega)),
            Scheme::Cnab2 | Scheme::Mcnab2 | Scheme::Cnlf => 1.0 / 6.0 + 1.0 / (4.0 * omega),
        }
    }

    fn add_splitting_error(
        &mut self,
        settings: &ImexTwoStepSettings,
        system: &System,
        to: &State,
        h: f64,
        error: &mut [Vec3],
        report: &mut StepReport,
    ) {
        let ImexTwoStepSettings { scheme, .. } = settings;
        let implicit = settings.implicit;
        let Self { splitting, linear, constraints, .. } = self;
        let tau = scheme.at_constant_step().tau(h);
        let force = |_: &_, out: &mut [Vec3]| implicit.forces_but_linear(system, to.level(), out);
        splitting.add(system, force, tau, linear, constraints, error, report);
    }
}
