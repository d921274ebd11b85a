//! The step.

use crate::newton::{MeanVelocity, Starts};
use crate::past::MeanVelocities;
use crate::settings::{ENERGY_MOMENTUM, EnergyMomentumSettings, OnFailure};
use drape_integrator::{
    ContactSet, EnergyLedger, Implicit, Method, MultistepMotion, Phase, PhaseClock, PrepareError,
    Registration, Scheme, StepError, StepReport, Stepper, Taken, lead_pins,
};
use drape_model::{State, System, Vec3};
use drape_solvers::{Constraints, SolveStatus};

/// The energy-momentum method.
#[doc(alias = "discrete gradient")]
#[doc(alias = "LaBudde-Greenspan 1974")]
#[doc(alias = "Gonzalez 1996")]
pub type EnergyMomentum = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&ENERGY_MOMENTUM);

/// How often a step may be halved.
const MAX_DEPTH: u32 = 6;
/// The shortest parts of a step.
const PARTS: u32 = 1 << MAX_DEPTH;

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) equation: MeanVelocity,
    /// `v̄`, m/s.
    pub(crate) mean: Vec<Vec3>,
    guess: Vec<Vec3>,
    pub(crate) explicit: Vec<Vec3>,
    impulse: Vec<Vec3>,
    past: MeanVelocities,
    contacts: ContactSet,
    pub(crate) constraints: Constraints,
    /// The state before the step, for a step that fails.
    before: State,
    /// Number of substeps of the last step.
    substeps: u32,
}

impl Scheme for Workspace {
    type Settings = EnergyMomentumSettings;

    fn method(_settings: &EnergyMomentumSettings) -> &'static Method {
        &ENERGY_MOMENTUM
    }

    fn new(system: &System, _: &EnergyMomentumSettings, _h: f64) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            equation: MeanVelocity::new(system)?,
            mean: zeros(),
            guess: zeros(),
            explicit: zeros(),
            impulse: ContactSet::impulse(system),
            past: MeanVelocities::new(system.len()),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(system.len()),
            before: State { t: 0.0, x: zeros(), v: zeros() },
            substeps: 0,
        })
    }

    fn step(
        &mut self,
        settings: &EnergyMomentumSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport { substeps: 0, ..StepReport::default() };
        self.before.copy_from(state);
        self.equation.refill();
        let (mut done, mut depth) = (0, 0);
        while done < PARTS {
            let parts = PARTS >> depth;
            let tau = h * (f64::from(parts) / f64::from(PARTS));
            if depth > 0 {
                lead_pins(system, state.t, tau, &state.x, &mut state.v);
            }
            let outcome = self.solve(settings, system, state, tau, clock, &mut report);
            let status = outcome.inspect_err(|_| state.copy_from(&self.before))?;
            let may_halve = depth < MAX_DEPTH && !self.equation.is_spent();
            let halves = settings.on_failure == OnFailure::Halve && may_halve;
            if status != SolveStatus::Converged && halves {
                (depth, report.rejected) = (depth + 1, report.rejected + 1);
                continue;
            }
            if status != SolveStatus::Converged {
                report.solve = status;
            }
            clock.switch(Phase::Update);
            self.advance(system, state, tau);
            done += parts;
            report.substeps += 1;
            state.t = self.before.t + h * (f64::from(done) / f64::from(PARTS));
            while depth > 0 && done % (PARTS >> (depth - 1)) == 0 {
                depth -= 1;
            }
        }
        self.substeps = report.substeps;
        Ok(report)
    }

    fn restart(&mut self) {
        self.past.restart();
        self.contacts.restart();
    }

    /// `None` after a divided step, whose parts are not kept.
    fn ledger(&mut self, _: &EnergyMomentumSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        (self.substeps == 1).then(|| self.energy_ledger(taken))
    }

    fn is_portable(_settings: &EnergyMomentumSettings) -> bool {
        true
    }
}

/// The equations of a step of `h` seconds.
impl Workspace {
    /// Solves `M (v̄ − v_n) = h/2 (F̄ − D v̄ + f)` for `v̄`, (2).
    fn solve(
        &mut self,
        settings: &EnergyMomentumSettings,
        system: &System,
        state: &State,
        h: f64,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<SolveStatus, StepError> {
        let Self { equation, mean, guess, explicit, impulse, contacts, constraints, .. } = self;
        let State { t, x, v } = state;
        clock.switch(Phase::Contact);
        // v̄ leads contacts to the surface; a rebound moves by the mean of its two velocities.
        let motion = MultistepMotion { from: (x, v), h, end: t + h, x_star: x, tau: h };
        contacts.detect_multistep(system, motion, constraints);
        clock.switch(Phase::Forces);
        explicit.fill(Vec3::zeros());
        Implicit::Springs.add_explicit_forces(system, state.level(), explicit);
        equation.begin(system, h, state.level(), explicit);
        report.force_evaluations += 1;
        clock.switch(Phase::Solve);
        self.past.extrapolate(v, h, guess);
        let starts = Starts { old: v, guess };
        let mut worst = SolveStatus::Converged;
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            let status = equation.solve(system, constraints, settings, starts, mean, report)?;
            worst = if status == SolveStatus::Converged { worst } else { status };
            wanted.fill(mean, |impulse| impulse.copy_from_slice(&equation.residual));
            Ok::<(), StepError>(())
        })?;
        Ok(worst)
    }

    /// `x₊ = x_n + h v̄`, `v₊ = 2 v̄ − v_n`, (1).
    fn advance(&mut self, system: &System, state: &mut State, h: f64) {
        let Self { equation, mean, past, contacts, constraints, .. } = self;
        let State { x, v, .. } = state;
        for i in 0..x.len() {
            x[i] = equation.start[i] + mean[i] * h;
            v[i] = mean[i] * 2.0 - v[i];
        }
        past.remember(mean, h);
        if contacts.is_empty() {
            contacts.settle(v, |_| ());
            return;
        }
        // The second half of the step has its forces, but not the impulse of the first one's
        // contacts: what these bear is taken from the velocity afterwards.
        for &i in constraints.constrained() {
            let i = i as usize;
            if !system.pinned()[i] {
                v[i] -= constraints.filter(i).complement(equation.residual[i]) / system.mass()[i];
            }
        }
        contacts.settle(v, |c| past.forget(c.particle, c.velocity));
        contacts.stop(v);
    }
}

#[cfg(test)]
mod tests;
