//! The step.

use super::old_level::OldLevel;
use super::split_forces::SplitForces;
use super::workspace::Workspace;
use super::{
    Coefficients, IMEX_CNAB2, IMEX_CNLF, IMEX_MCNAB2, IMEX_SBDF2, ImexTwoStepSettings, TwoStep,
};
use drape_integrator::{
    Change, ContactSet, Method, MultistepMotion, Phase, PhaseClock, PrepareError, Registration,
    Rewind, Scheme, Stage, StageSettings, Start, StepError, StepReport, StepStart, Stepper, drift,
};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::StartValue;

/// A two-step implicit-explicit method of order 2: SBDF2, CNAB2, MCNAB2 or CNLF.
pub type ImexTwoStep = Stepper<Workspace>;

/// The four methods differ in their coefficients only. Their first step is backward Euler, which
/// factorises.
const TWO_STEP: Registration = Registration {
    method: &IMEX_SBDF2,
    build: |s| Ok(ImexTwoStep::controlled(ImexTwoStepSettings::of(TwoStep::Sbdf2, s))),
    is_portable: |_| false,
    follows_springs: |_| false,
};

/// SBDF2, for the registry.
pub static SBDF2: Registration = TWO_STEP;

/// CNAB2, for the registry.
pub static CNAB2: Registration = Registration {
    method: &IMEX_CNAB2,
    build: |s| Ok(ImexTwoStep::controlled(ImexTwoStepSettings::of(TwoStep::Cnab2, s))),
    ..TWO_STEP
};

/// MCNAB2, for the registry.
pub static MCNAB2: Registration = Registration {
    method: &IMEX_MCNAB2,
    build: |s| Ok(ImexTwoStep::controlled(ImexTwoStepSettings::of(TwoStep::Mcnab2, s))),
    ..TWO_STEP
};

/// CNLF, for the registry.
pub static CNLF: Registration = Registration {
    method: &IMEX_CNLF,
    build: |s| Ok(ImexTwoStep::controlled(ImexTwoStepSettings::of(TwoStep::Cnlf, s))),
    ..TWO_STEP
};

/// A particle that approaches by less than this within a step, m, makes no impact.
const TOUCHING: f64 = 1e-9;

impl Scheme for Workspace {
    type Settings = ImexTwoStepSettings;

    fn method(settings: &ImexTwoStepSettings) -> &'static Method {
        settings.scheme.method()
    }

    fn new(system: &System, settings: &ImexTwoStepSettings, h: f64) -> Result<Self, PrepareError> {
        let tau = settings.scheme.at_constant_step().tau(h);
        Self::allocate(system, settings, tau)
    }

    #[doc(alias = "EEH 8")]
    #[doc(alias = "EEH 9")]
    fn step(
        &mut self,
        settings: &ImexTwoStepSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let omega = self.past.step_ratio(system, h);
        let continued = omega.and_then(|omega| settings.scheme.coefficients(omega)); // EEH (7)
        let tau = continued.unwrap_or(settings.scheme.at_constant_step()).tau(h); // τ = h b_0/a_0
        let (end, implicit) = (state.t + h, settings.implicit);
        clock.switch(Phase::MatrixSetup);
        // M + τ² L_k + τ L_c, EEH (9)
        let mut report = StepReport::after_setup(self.linear.refresh(system, tau)?);
        self.evaluate_external(system, &state.x);
        self.splitting.expect_nothing();
        if let Some(Coefficients { a: [a0, _, a2], b: [_, b1, b2], c: [c1, c2] }) = continued {
            clock.switch(Phase::Forces);
            let sweeps = self.past.update_forces(system, implicit); // F_{n−1} and G_{n−1}
            self.present.evaluate(system, implicit, state.level()); // F_n and G_n, EEH (6)
            report.force_evaluations = sweeps + SplitForces::SWEEPS + 1;
            let (x, v, now, old) = (&state.x, &state.v, &self.present, &self.past.forces);
            let Level { x: x_old, v: v_old, .. } = self.past.level();
            // X* = (1/a_0) [−a_1 x_n − a_2 x_{n−1} + h (b_1 v_n + b_2 v_{n−1})], EEH (8). Written
            // with a_1 = −a_0 − a_2, here and below, a particle at rest keeps its bits.
            for i in 0..state.len() {
                let drift = v[i] * b1 + v_old[i] * b2;
                self.position[i] = x[i] + (x[i] - x_old[i]) * (a2 / a0) + drift * (h / a0);
            }
            self.scratch.fill(Vec3::zeros());
            implicit.add_linear_spring_forces(system, &self.position, &mut self.scratch); // −L_k X*
            // b = −(1/a_0) M (a_1 v_n + a_2 v_{n−1}) + (h/a_0) [c_1 F_n + c_2 F_{n−1} + b_1 G_n
            //     + b_2 G_{n−1}] − τ L_k X*, EEH (8)
            for (i, &m) in system.mass().iter().enumerate() {
                let inertia = v[i] + (v[i] - v_old[i]) * (a2 / a0);
                let force = now.explicit[i] * c1
                    + old.explicit[i] * c2
                    + now.linear[i] * b1
                    + old.linear[i] * b2;
                self.b[i] = inertia * m + force * (h / a0) + self.scratch[i] * tau;
            }
            self.prepare_solve(settings, system, state, (h, tau), clock);
            let Self { linear, contacts, constraints, b, velocity: v, impulse, .. } = self;
            // τ (F_n + G_n), the impulse of the forces of level n
            let forces = |i: usize| (self.present.explicit[i] + self.present.linear[i]) * tau;
            let begin = StepStart { system, state, tau, rounds_positions: true };
            let reference = self.reference.of(begin, linear, contacts, constraints, forces);
            contacts.solve(system, constraints, impulse, |constraints, wanted| {
                // (M + τ² L_k + τ L_c) v_{n+1} = b, EEH (9)
                report += linear.solve_from(StartValue::Given, constraints, b, v, reference);
                wanted.fill(v, |impulse| {
                    linear.constraint_impulse(b, v, impulse);
                    report.matvecs += 1;
                });
                Ok::<(), StepError>(())
            })?;
            drift(system, tau, v, &mut self.position); // x_{n+1} = X* + τ v_{n+1}, EEH (8)
        } else {
            self.start(system, state, h, clock, &mut report)?; // backward Euler, EEH (3)
        }
        clock.switch(Phase::Update);
        self.finish(system, state, h, continued.is_some());
        state.t = end;
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

/// What the step does beside its equations.
impl Workspace {
    /// Force of the effects without a Jacobian, such as gravity, N.
    fn evaluate_external(&mut self, system: &System, x: &[Vec3]) {
        self.external.fill(Vec3::zeros());
        for effect in system.effects().filter(|effect| !effect.has_jacobian()) {
            effect.add_force(system.mass(), x, &mut self.external);
        }
    }

    /// What the linear solve needs beside `b`: contacts, the start value, and for step size control
    /// the extrapolated force.
    fn prepare_solve(
        &mut self,
        settings: &ImexTwoStepSettings,
        system: &System,
        state: &State,
        (h, tau): (f64, f64),
        clock: &mut PhaseClock,
    ) {
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
        self.velocity.copy_from_slice(&state.v);
        if settings.start == Start::Extrapolated {
            self.past.extrapolate(h, &mut self.velocity); // EEH (22)
        }
    }

    /// Moves the state to the new level, ends the contacts, and rewrites the past of the particles
    /// whose contact changed.
    fn finish(&mut self, system: &System, state: &mut State, h: f64, has_forces: bool) {
        let Self { contacts, constraints, past, present, velocity, position, external, .. } = self;
        past.remember(system, state, h, has_forces.then_some(present));
        state.v.swap_with_slice(velocity);
        state.x.copy_from_slice(position);
        let (x, v_n, mass) = (&state.x, velocity, system.mass());
        contacts.settle(&mut state.v, |Change { particle: i, velocity: v, filter, surface }| {
            // After a rebound the particle flies, else it rests.
            let flies = filter.complement(v - surface).dot(&(v_n[i] - surface)) < 0.0;
            let a = if flies { external[i] / mass[i] } else { Vec3::zeros() };
            // The friction of an impact changes the velocity along the surface, too. The friction
            // of a contact that begins at rest is a force like any other.
            let arrives = filter.complement(v_n[i] - surface).norm() * h > TOUCHING;
            let rewritten = if arrives { constraints.filter(i) } else { filter };
            past.meet(i, rewritten, (x[i], *v), a);
        });
    }

    /// A step of converged backward Euler, where there is no usable past. IMEX Euler would not do:
    /// it multiplies velocities across springs by `1/(1 + θ)`, and two-step methods keep their
    /// start.
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
        let stage = Stage { tau: h.into(), end, from, lagged, velocity: &state.v };
        let settings = StageSettings::default();
        starter.solve(system, stage, &state.v, contacts, constraints, settings, clock, report)?;
        velocity.copy_from_slice(starter.velocity());
        position.copy_from_slice(starter.positions());
        Ok(())
    }
}

impl Rewind for Workspace {
    type Past = OldLevel;

    fn past(&mut self) -> (&mut OldLevel, &mut ContactSet) {
        (&mut self.past, &mut self.contacts)
    }

    fn tolerance(settings: &ImexTwoStepSettings) -> f64 {
        settings.tolerance
    }

    /// For the Crank–Nicolson methods the constant of the Adams–Bashforth part, which is the
    /// greater one.
    fn error_constant(settings: &ImexTwoStepSettings, omega: f64) -> f64 {
        match settings.scheme {
            TwoStep::Sbdf2 => (1.0 + omega) * (1.0 + omega) / (6.0 * omega * (1.0 + 2.0 * omega)),
            TwoStep::Cnab2 | TwoStep::Mcnab2 | TwoStep::Cnlf => 1.0 / 6.0 + 1.0 / (4.0 * omega),
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
