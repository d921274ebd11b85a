//! Scratch memory, history and contacts of BDF.

use super::step_sizes;
use crate::coefficients::{LinearMultistep, extrapolation};
use crate::settings::Steps;
use drape_integrator::{
    Change, ContactSet, History, ImplicitStage, MultistepMotion, NewtonLinear, Phase, PhaseClock,
    PrepareError, SolveStatus, Stage, StageSettings, StepError, StepReport,
};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::Constraints;

const POSITION: usize = 0;
const VELOCITY: usize = 1;

#[derive(Debug)]
pub(crate) struct BdfWorkspace {
    /// Positions and velocities.
    pub(crate) history: History<2>,
    stage: ImplicitStage,
    /// `x* = −Σ_{j<k} α_j x_{n+j} / α_k`, and `v*` likewise.
    mean: (Vec<Vec3>, Vec<Vec3>),
    /// Positions and velocities at the new time, by extrapolation.
    extrapolated: (Vec<Vec3>, Vec<Vec3>),
    /// Time for which that is, s.
    ahead: f64,
    /// What goes on after an impact, for the history.
    acceleration: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pins_alone: ContactSet,
    constraints: Constraints,
}

/// `γ` of the L-stable singly diagonally implicit Runge–Kutta method of two stages and order 2
/// (Alexander 1977): `1 − 1/√2`.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

impl BdfWorkspace {
    pub(crate) fn new(
        system: &System,
        steps: Steps,
        linear: NewtonLinear,
    ) -> Result<Self, PrepareError> {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Ok(Self {
            history: History::new(system.len(), steps.count() - 1),
            stage: ImplicitStage::with_linear(system, linear)?,
            mean: (zeros(), zeros()),
            extrapolated: (zeros(), zeros()),
            ahead: 0.0,
            acceleration: zeros(),
            contacts: ContactSet::new(system),
            pins_alone: ContactSet::for_pins(system),
            constraints: Constraints::free(system.len()),
        })
    }

    /// EEH (3) over as many levels as are known: sets the means and extrapolations, returns `τ`.
    pub(crate) fn differentiate(&mut self, state: &State, h: f64) -> f64 {
        let (steps, k) = step_sizes(&self.history, h);
        let formula = LinearMultistep::bdf(&steps[..k]);
        let (weights, ahead) = (formula.past_weights(), extrapolation(&steps[..k]));
        self.history.mean(POSITION, &state.x, &weights[..k], &mut self.mean.0);
        self.history.mean(VELOCITY, &state.v, &weights[..k], &mut self.mean.1);
        self.history.mean(POSITION, &state.x, &ahead[..k], &mut self.extrapolated.0);
        self.history.mean(VELOCITY, &state.v, &ahead[..k], &mut self.extrapolated.1);
        self.ahead = state.t + h;
        formula.tau(h)
    }

    /// Where the first of three steps has no past: the first stage `v₁` of Alexander's method, which is of order 2,
    /// then
    ///
    /// ```text
    /// τ = γ h     x* = x_n + (1 − γ) h v₁     v* = v_n + (1 − γ) h a₁     a₁ = (v₁ − v_n)/(γ h)
    /// ```
    ///
    /// Its second stage ends at `t_{n+1}`, so that contacts constrain it as any other step (those of a
    /// midpoint stage would have to be reflected to the end). The first stage ignores obstacles: what enters
    /// one there is led out by the second. What friction holds slips by `(1 − γ) γ h² a` in it. Returns `τ`.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub(crate) fn start(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        settings: StageSettings,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        let tau = GAMMA * h;
        for i in 0..state.len() {
            let (x, v) = (state.x[i], state.v[i]);
            (self.mean.0[i], self.mean.1[i]) = (x, v);
            (self.extrapolated.0[i], self.extrapolated.1[i]) = (x + v * tau, v);
        }
        self.ahead = state.t + tau;
        self.solve(system, state, (h, tau), Obstacles::Ignored, settings, clock, report)?;
        self.ahead = state.t + h;
        for (i, v_1) in self.stage.velocity().iter().enumerate() {
            let (x, v) = (self.mean.0[i], self.mean.1[i]);
            let change = (v_1 - v) / GAMMA; // h a₁
            self.mean.0[i] = x + v_1 * (h - tau);
            self.mean.1[i] = v + change * (1.0 - GAMMA);
            (self.extrapolated.0[i], self.extrapolated.1[i]) = (x + v_1 * h, v + change);
        }
        Ok(tau)
    }

    /// Solves `M (v − v*) = τ f(x* + τ v, v)`; the solution is in `stage`. A failure to converge in an
    /// earlier stage stays in the report.
    ///
    /// # Errors
    /// As [`ImplicitStage::solve`].
    #[expect(clippy::too_many_arguments, reason = "each is owned by the step that calls")]
    pub(crate) fn solve(
        &mut self,
        system: &System,
        state: &State,
        (h, tau): (f64, f64),
        obstacles: Obstacles,
        settings: StageSettings,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let Self { mean, extrapolated, ahead, constraints, .. } = self;
        let from = (&state.x[..], &state.v[..]);
        // A stage without obstacles ends at `t_n + τ`.
        let (contacts, span) = match obstacles {
            Obstacles::Met => (&mut self.contacts, h),
            Obstacles::Ignored => (&mut self.pins_alone, tau),
        };
        let end = state.t + span;
        clock.switch(Phase::Contact);
        let motion = MultistepMotion { from, h: span, end, x_star: &mean.0, tau };
        contacts.detect_multistep(system, motion, constraints);
        let stage = Stage {
            tau,
            end,
            from: (&mean.0, &mean.1),
            lagged: Level { t: *ahead, x: &extrapolated.0, v: &extrapolated.1 },
            velocity: &state.v,
        };
        let before = report.solve;
        let start = &extrapolated.1;
        self.stage.solve_constrained(
            system,
            stage,
            start,
            contacts,
            constraints,
            settings,
            clock,
            report,
        )?;
        if before != SolveStatus::Converged {
            report.solve = before;
        }
        Ok(())
    }

    /// Moves the state to the solution of the stage and ends the contacts, with a past of constant acceleration for
    /// each particle whose contact changed.
    pub(crate) fn advance(&mut self, system: &System, state: &mut State, h: f64, tau: f64) {
        let Self { stage, mean, acceleration: a, contacts, constraints, history, .. } = self;
        for (i, m) in system.mass().iter().enumerate() {
            let inverse_mass = if system.pinned()[i] { 0.0 } else { 1.0 / m };
            let explicit = stage.explicit_force()[i] * inverse_mass;
            let change = (stage.velocity()[i] - mean.1[i]) / tau;
            // Along the normals the impulse hides the force; what is not stiff goes on.
            a[i] = explicit + constraints.filter(i).apply(change - explicit);
        }
        contacts.support(h, a);
        history.push(h, [&state.x, &state.v]);
        state.v.copy_from_slice(stage.velocity());
        state.x.copy_from_slice(stage.positions()); // x_{n+k} = x* + τ v_{n+k}
        let State { x, v, .. } = state;
        contacts.settle(v, |Change { particle: i, velocity: v, .. }| {
            history.rewrite(i, |age| [x[i] - (v - a[i] * (0.5 * age)) * age, v - a[i] * age]);
        });
    }

    /// Forgets the past.
    pub(crate) fn restart(&mut self) {
        self.history.restart();
        self.contacts.restart();
        self.stage.restart();
    }
}

/// Whether a stage is constrained by obstacles; pins always hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Obstacles {
    Met,
    Ignored,
}
