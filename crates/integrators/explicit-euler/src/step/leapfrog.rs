//! Leapfrog.

use crate::settings::{LEAPFROG, LeapfrogSettings};
use crate::workspace::{Damping, LeapfrogWorkspace};
use drape_integrator::{
    EnergyLedger, Method, MultistepMotion, Phase, PhaseClock, PrepareError, Registration, Scheme,
    SolveStatus, SolverKind, StepError, StepReport, Stepper, Taken, drift, kick,
};
use drape_model::{Level, Part, State, System, Vec3};

/// Leapfrog (velocity Verlet) with Crank–Nicolson damping.
pub type Leapfrog = Stepper<LeapfrogWorkspace>;

/// For the registry.
pub static VERLET: Registration = Registration::new::<LeapfrogWorkspace>(&LEAPFROG);

impl Scheme for LeapfrogWorkspace {
    type Settings = LeapfrogSettings;

    fn method(_settings: &LeapfrogSettings) -> &'static Method {
        &LEAPFROG
    }

    fn new(system: &System, settings: &LeapfrogSettings, h: f64) -> Result<Self, PrepareError> {
        Self::allocate(system, settings, h)
    }

    fn step(
        &mut self,
        _settings: &LeapfrogSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        clock.switch(Phase::MatrixSetup);
        report.substeps = self.substeps(system, &state.x, h, &mut report);
        let substep = h / f64::from(report.substeps);
        self.refresh(system, substep, &mut report)?; // M + h/2 L_c
        clock.switch(Phase::Forces);
        if !self.remembers(system, &state.x) {
            self.evaluate_force(system, &state.x, &mut report); // F_0
        }
        let start = state.t;
        for part in 0..report.substeps {
            state.t = start + f64::from(part) * substep;
            self.kick_drift_kick(system, state, substep, clock, &mut report);
        }
        self.remember(system, &state.x);
        self.last_substeps = report.substeps;
        state.t = start + h;
        Ok(report)
    }

    fn restart(&mut self) {
        self.forget();
    }

    /// The parts of a divided step are not kept.
    fn ledger(&mut self, _: &LeapfrogSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        (self.last_substeps == 1).then(|| self.energy_ledger(taken))
    }

    fn is_portable(settings: &LeapfrogSettings) -> bool {
        settings.solver == SolverKind::Cg
    }
}

impl LeapfrogWorkspace {
    /// One step of `h` seconds.
    fn kick_drift_kick(
        &mut self,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) {
        let State { t, x, v } = state;
        let (t, half) = (*t, 0.5 * h);
        clock.switch(Phase::Contact);
        self.lead_pins(system, t, h, x, v);
        // A rebound moves by the mean of the velocities before and after it, as befits order 2.
        let motion = MultistepMotion { from: (x, v), h, end: t + h, x_star: x, tau: h };
        self.contacts.detect_multistep(system, motion, &mut self.constraints);
        clock.switch(Phase::Forces);
        self.old_velocity.copy_from_slice(v);
        kick(system, half, &self.force, v); // v½ = v_n + h/2 M⁻¹ (F_n …
        if let Some(Damping { force, .. }) = &mut self.damping {
            let damped = system.effects().filter(|effect| effect.has_damping());
            let at = Level { t, x, v: &self.old_velocity };
            system.write_forces(damped.map(|effect| (effect, Part::Damping)), at, force);
            kick(system, half, force, v); // … − D_n v_n)
        }
        clock.switch(Phase::Contact);
        let Self { free_velocity, impulse, contacts, constraints, .. } = self;
        free_velocity.copy_from_slice(v);
        contacts.project(system, constraints, free_velocity, v, impulse);
        clock.switch(Phase::Update);
        drift(h, v, x); // x_{n+1} = x_n + h v½
        clock.switch(Phase::Forces);
        self.evaluate_force(system, x, report); // F_{n+1}
        if self.damping.is_some() {
            clock.switch(Phase::Solve);
            self.damped_kick(system, (t + h, x), half, v, report);
        } else {
            clock.switch(Phase::Update);
            kick(system, half, &self.force, v); // v_{n+1} = v½ + h/2 M⁻¹ F_{n+1}
            self.pins.impose(v);
        }
        if !self.contacts.is_empty() {
            self.unsettled.copy_from_slice(v);
        }
        self.contacts.settle(v, |_| ());
        self.contacts.stop(v);
    }

    /// `v½` to `v_{n+1}`: `(M + h/2 L_c) v_{n+1} = M v½ + h/2 (F_{n+1} + R(x_{n+1}, v_{n+1}))`.
    ///
    /// `R = L_c v − D v` is the part of full damping that projected damping lacks. It is taken first at `v_n`, then at the
    /// velocity that this gives, which is right to second order: `2 v½ − v_n` and `2 v_n − v_{n−1}` are too, and would
    /// save a solve, but are unstable on modes that `L_c` damps and `D` does not.
    fn damped_kick(
        &mut self,
        system: &System,
        (t, x): (f64, &[Vec3]),
        half: f64,
        v: &mut [Vec3],
        report: &mut StepReport,
    ) {
        let Some(Damping { solver, force: remainder, right_hand_side: b }) = &mut self.damping
        else {
            return;
        };
        let momentum = &mut self.free_velocity;
        for i in 0..v.len() {
            momentum[i] = v[i] * system.mass()[i] + self.force[i] * half; // M v½ + h/2 F_{n+1}
        }
        v.copy_from_slice(&self.old_velocity);
        let mut is_linear = true;
        for prediction in [true, false] {
            remainder.fill(Vec3::zeros());
            for effect in system.effects() {
                match effect.split() {
                    Some(split) => split.add_damping_remainder(x, v, remainder), // R = L_c v − D v
                    None => effect.add_damping_force(Level { t, x, v }, remainder), // L_c has no part of it
                }
            }
            is_linear &= remainder.iter().all(|r| *r == Vec3::zeros());
            if is_linear && !prediction {
                return;
            }
            for i in 0..v.len() {
                b[i] = momentum[i] + remainder[i] * half;
            }
            let before = report.solve;
            *report += solver.solve(&self.pins, b, v); // (M + h/2 L_c) v_{n+1} = b
            if before != SolveStatus::Converged {
                report.solve = before; // one bad solve of a step must not hide behind a good one
            }
        }
        report.force_evaluations += 1; // two sweeps for R, as one with force and damping
    }

    /// `F(x)`.
    fn evaluate_force(&mut self, system: &System, x: &[Vec3], report: &mut StepReport) {
        let at = Level { t: 0.0, x, v: x }; // Part::Force takes only the positions
        let effects = system.effects().map(|effect| (effect, Part::Force));
        system.write_forces(effects, at, &mut self.force);
        report.force_evaluations += 1;
    }
}

#[cfg(test)]
mod tests;
