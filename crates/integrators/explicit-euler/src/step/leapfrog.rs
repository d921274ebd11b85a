//! Leapfrog.

use crate::settings::{LEAPFROG, LeapfrogDamping, LeapfrogSettings};
use crate::workspace::{Damping, LeapfrogWorkspace};
use drape_integrator::{
    EnergyLedger, Method, MultistepMotion, Phase, PhaseClock, PrepareError, Registration, Scheme,
    SolverKind, StepError, StepReport, Stepper, Taken, drift, each_particle, kick, lead_pins,
};
use drape_model::{Level, Part, State, System, Vec3};
use drape_solvers::Filter;

/// Leapfrog (velocity Verlet) with Crank–Nicolson or explicit damping.
pub type Leapfrog = Stepper<LeapfrogWorkspace>;

/// Entry of this method in the registry.
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
        report.substeps = self.substeps(system, &state.x, h, &mut report)?;
        let (start, end, mass) = (state.t, state.t + h, system.mass());
        let h = h / f64::from(report.substeps);
        let half = 0.5 * h;
        self.refresh(system, h, &mut report)?; // M + h/2 L_c, (L3)
        clock.switch(Phase::Forces);
        self.kept.begin(system, &state.x, &mut report); // F(x_n)
        for substep in 0..report.substeps {
            state.t = start + f64::from(substep) * h;
            self.find_contacts(system, state, h, clock);
            clock.switch(Phase::Forces);
            each_particle(system, &mut self.old_velocity, |i| state.v[i]);
            if let Some([early, _]) = &mut self.explicit {
                early.kick(system, half, self.kept.force(), state, &self.pins, &mut report); // (L4)
            } else {
                kick(system, half, self.kept.force(), &mut state.v); // v½ = v_n + h/2 M⁻¹ (F(x_n) …
            }
            if let Some(damping) = &mut self.damping {
                damping.evaluate(system, Level { v: &self.old_velocity, ..state.level() });
                kick(system, half, &damping.force, &mut state.v); // … − D(x_n) v_n), (L1)
            }
            self.constrain(system, &mut state.v, clock);
            drift(system, h, &state.v, &mut state.x); // x_{n+1} = x_n + h v½, (L2)
            clock.switch(Phase::Forces);
            self.kept.evaluate(system, &state.x, &mut report); // F(x_{n+1})
            state.t += h;
            let State { t, x, v } = &mut *state;
            if let Some(Damping { solver, force: r, right_hand_side: b }) = &mut self.damping {
                clock.switch(Phase::Solve);
                let momentum = &mut self.free_velocity;
                let force = self.kept.force();
                // M v½ + h/2 F(x_{n+1})
                each_particle(system, momentum, |i| v[i] * mass[i] + force[i] * half);
                v.copy_from_slice(&self.old_velocity);
                let mut has_remainder = false;
                for is_prediction in [true, false] {
                    // R(x_{n+1}, v)
                    has_remainder |= evaluate_remainder(system, Level { t: *t, x, v }, r);
                    if !has_remainder && !is_prediction {
                        break; // the first solve was exact
                    }
                    // … + h/2 R(x_{n+1}, v_{n+1})
                    each_particle(system, b, |i| momentum[i] + r[i] * half);
                    // (M + h/2 L_c) v_{n+1} = b, (L3)
                    report.add_stage(solver.solve(&self.pins, b, v));
                }
                report.force_evaluations += u32::from(has_remainder);
            } else if let Some([_, late]) = &mut self.explicit {
                late.kick(system, half, self.kept.force(), state, &self.pins, &mut report); // (L4)
                self.pins.impose(&mut state.v);
            } else {
                clock.switch(Phase::Update);
                kick(system, half, self.kept.force(), v); // v_{n+1} = v½ + h/2 M⁻¹ F(x_{n+1}), (L3)
                self.pins.impose(v);
            }
            self.settle(&mut state.v);
        }
        self.kept.keep(system, &state.x);
        self.last_substeps = report.substeps;
        state.t = end;
        Ok(report)
    }

    fn restart(&mut self) {
        self.forget();
    }

    /// `None` after a divided step, whose parts are not kept.
    fn ledger(&mut self, _: &LeapfrogSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        (self.last_substeps == 1).then(|| self.energy_ledger(taken))
    }

    fn is_portable(settings: &LeapfrogSettings) -> bool {
        settings.solver == SolverKind::Cg || settings.damping == LeapfrogDamping::Explicit
    }
}

/// What the step does beside its equations.
impl LeapfrogWorkspace {
    /// Leads the pins on paths, and finds the contacts of the next `h` seconds.
    fn find_contacts(
        &mut self,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) {
        clock.switch(Phase::Contact);
        let State { t, x, v } = state;
        lead_pins(system, *t, h, x, v);
        for pin in system.moving_pins() {
            self.pins.set(pin.particle, Filter::Fixed, v[pin.particle]);
        }
        // Order 2 asks that a rebound moves by the mean of the velocities before and after it.
        let motion = MultistepMotion { from: (x, v), h, end: *t + h, x_star: x, tau: h };
        self.contacts.detect_multistep(system, motion, &mut self.constraints);
    }

    /// Imposes pins and contacts on `v½`.
    fn constrain(&mut self, system: &System, v: &mut [Vec3], clock: &mut PhaseClock) {
        clock.switch(Phase::Contact);
        let Self { free_velocity, impulse, contacts, constraints, .. } = self;
        contacts.project_in_place(system, constraints, free_velocity, v, impulse);
        clock.switch(Phase::Update);
    }

    /// Ends the contacts of a substep.
    fn settle(&mut self, v: &mut [Vec3]) {
        if !self.contacts.is_empty() {
            self.unsettled.copy_from_slice(v);
        }
        self.contacts.settle(v, |_| ());
        self.contacts.stop(v);
    }
}

impl Damping {
    /// `−D(x) v`, N.
    fn evaluate(&mut self, system: &System, at: Level<'_>) {
        let damped = system.effects().filter(|effect| effect.has_damping());
        let terms = damped.map(|effect| (effect, Part::Damping));
        system.write_forces(terms, at, &mut self.force);
    }
}

/// `R(x, v) = L_c v − D(x) v`, N: the part of full damping that projected damping lacks. Returns
/// whether any of it is not zero.
///
/// The step takes `R` first at `v_n`, then at the velocity that this gives, which keeps order 2.
/// The extrapolations `2 v½ − v_n` and `2 v_n − v_{n−1}` would save a solve, but they are unstable
/// on modes that `L_c` damps and `D` does not.
fn evaluate_remainder(system: &System, at: Level<'_>, remainder: &mut [Vec3]) -> bool {
    remainder.fill(Vec3::zeros());
    for effect in system.effects() {
        match effect.split() {
            Some(split) => split.add_damping_remainder(at.x, at.v, remainder),
            None => effect.add_damping_force(at, remainder), // L_c has no part of it
        }
    }
    remainder.iter().any(|r| *r != Vec3::zeros())
}

#[cfg(test)]
mod tests;
