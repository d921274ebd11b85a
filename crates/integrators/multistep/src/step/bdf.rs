//! The step of BDF.

use crate::coefficients::{LinearMultistep, extrapolation};
use crate::settings::{BDF2, BdfSettings, Steps};
use crate::workspace::{BdfWorkspace, POSITION, VELOCITY, step_sizes};
use drape_integrator::{
    Change, ContactSet, History, Method, MultistepMotion, Order, Phase, PhaseClock, PrepareError,
    Registration, Rewind, Scheme, SolveStatus, Stage, StageSettings, StepError, StepReport,
    Stepper,
};
use drape_model::{Level, State, System};

/// Backward differentiation of one to three steps, with Newton's method.
pub type Bdf = Stepper<BdfWorkspace>;

/// For the registry.
pub static BACKWARD_DIFFERENTIATION: Registration = Registration::controlled::<BdfWorkspace>(&BDF2);

/// `γ` of the L-stable singly diagonally implicit Runge–Kutta method of two stages and order 2
/// (Alexander 1977): `1 − 1/√2`.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

impl Scheme for BdfWorkspace {
    type Settings = BdfSettings;

    fn method(_settings: &BdfSettings) -> &'static Method {
        &BDF2
    }

    fn new(system: &System, settings: &BdfSettings, _h: f64) -> Result<Self, PrepareError> {
        Self::allocate(system, settings.steps, settings.stage.linear)
    }

    fn step(
        &mut self,
        settings: &BdfSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let how = settings.stage;
        let mut report = StepReport::default();
        clock.switch(Phase::Update);
        self.history.refresh(system, h, settings.ratios());
        let tau = if settings.steps == Steps::Three && self.history.is_empty() {
            self.start(system, state, h, how, clock, &mut report)?
        } else {
            self.differentiate(state, h)
        };
        // M (α_k v_{n+k} + γ_n) = h β_k f(x_{n+k}, v_{n+k}), EEH (4), by the iteration (5)
        self.solve(system, state, (h, tau), Obstacles::Met, how, clock, &mut report)?;
        clock.switch(Phase::Update);
        self.advance(system, state, h, tau); // x_{n+k} = x* + τ v_{n+k}
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {
        self.history.restart();
        self.contacts.restart();
        self.stage.restart();
    }

    fn is_portable(settings: &BdfSettings) -> bool {
        settings.stage.linear.is_portable()
    }
}

impl BdfWorkspace {
    /// The means `(x*, v*) = −γ_n/α_k` of EEH (4) over as many levels as are known, and the extrapolations to the new time.
    /// Returns `τ = h β_k/α_k`.
    fn differentiate(&mut self, state: &State, h: f64) -> f64 {
        let Self { history, mean, extrapolated, ahead, .. } = self;
        let (steps, k) = step_sizes(history, h);
        let formula = LinearMultistep::bdf(&steps[..k]); // α_j and β_k of EEH (3)
        let (weights, weights_ahead) = (formula.past_weights(), extrapolation(&steps[..k]));
        history.mean(POSITION, &state.x, &weights[..k], &mut mean.0); // x* = −Σ_{j<k} α_j x_{n+j} / α_k
        history.mean(VELOCITY, &state.v, &weights[..k], &mut mean.1); // v* = −Σ_{j<k} α_j v_{n+j} / α_k
        history.mean(POSITION, &state.x, &weights_ahead[..k], &mut extrapolated.0);
        history.mean(VELOCITY, &state.v, &weights_ahead[..k], &mut extrapolated.1);
        *ahead = state.t + h;
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
    /// midpoint stage would have to be reflected to the end). The first stage ignores obstacles: the second leads out the
    /// particles that enter one there. A particle that friction holds slips by `(1 − γ) γ h² a` in it. Returns `τ`.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn start(
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
        self.solve(system, state, (h, tau), Obstacles::Ignored, settings, clock, report)?; // v₁
        self.ahead = state.t + h;
        for (i, v_1) in self.stage.velocity().iter().enumerate() {
            let (x, v) = (self.mean.0[i], self.mean.1[i]);
            let change = (v_1 - v) / GAMMA; // h a₁
            self.mean.0[i] = x + v_1 * (h - tau); // x* = x_n + (1 − γ) h v₁
            self.mean.1[i] = v + change * (1.0 - GAMMA); // v* = v_n + (1 − γ) h a₁
            (self.extrapolated.0[i], self.extrapolated.1[i]) = (x + v_1 * h, v + change);
        }
        Ok(tau)
    }

    /// Solves `M (v − v*) = τ f(x* + τ v, v)`; the solution is in `stage`. A failure to converge in an
    /// earlier stage stays in the report.
    ///
    /// # Errors
    /// As [`drape_integrator::ImplicitStage::solve`].
    #[expect(clippy::too_many_arguments, reason = "each is owned by the step that calls")]
    fn solve(
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
        let lagged = Level { t: *ahead, x: &extrapolated.0, v: &extrapolated.1 };
        let from = (&mean.0[..], &mean.1[..]);
        let stage = Stage { tau, end, from, lagged, velocity: &state.v };
        let (before, start) = (report.solve, &extrapolated.1);
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
    fn advance(&mut self, system: &System, state: &mut State, h: f64, tau: f64) {
        let Self { stage, mean, acceleration: a, contacts, constraints, history, .. } = self;
        for (i, m) in system.mass().iter().enumerate() {
            let inverse_mass = if system.pinned()[i] { 0.0 } else { 1.0 / m };
            let explicit = stage.explicit_force()[i] * inverse_mass;
            let change = (stage.velocity()[i] - mean.1[i]) / tau;
            // Along the normals the impulse hides the stiff forces; the explicit ones go on.
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
}

/// Whether a stage is constrained by obstacles; pins always hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Obstacles {
    Met,
    Ignored,
}

impl Rewind for BdfWorkspace {
    type Past = History<2>;

    fn past(&mut self) -> (&mut History<2>, &mut ContactSet) {
        (&mut self.history, &mut self.contacts)
    }

    fn tolerance(settings: &BdfSettings) -> f64 {
        settings.tolerance
    }

    fn order(settings: &BdfSettings) -> Order {
        match settings.steps {
            Steps::One => Order::One,
            Steps::Two | Steps::Three => Order::Two,
        }
    }
}
