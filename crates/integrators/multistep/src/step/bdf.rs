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

/// Entry of this method in the registry.
pub static BACKWARD_DIFFERENTIATION: Registration = Registration::controlled::<BdfWorkspace>(&BDF2);

/// `γ = 1 − 1/√2` of the L-stable Runge–Kutta method of two singly diagonally implicit stages and
/// order 2 (Alexander 1977).
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

impl Scheme for BdfWorkspace {
    type Settings = BdfSettings;

    fn method(_settings: &BdfSettings) -> &'static Method {
        &BDF2
    }

    fn new(system: &System, settings: &BdfSettings, _h: f64) -> Result<Self, PrepareError> {
        Self::allocate(system, settings.steps, settings.stage.linear)
    }

    #[doc(alias = "EEH 3")]
    fn step(
        &mut self,
        settings: &BdfSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        clock.switch(Phase::Update);
        self.history.refresh(system, h, settings.ratios());
        let (x, v, n, end) = (&state.x, &state.v, state.len(), state.t + h);
        let tau = if settings.steps == Steps::Three && self.history.is_empty() {
            let tau = GAMMA * h;
            for i in 0..n {
                (self.mean.0[i], self.mean.1[i]) = (x[i], v[i]); // x* = x_n, v* = v_n, (A1)
                (self.extrapolated.0[i], self.extrapolated.1[i]) = (x[i] + v[i] * tau, v[i]);
            }
            self.ahead = state.t + tau;
            let alone = (tau, Obstacles::Ignored);
            self.solve(system, state, tau, alone, settings.stage, clock, &mut report)?; // v₁, (A1)
            for (i, v_1) in self.stage.velocity().iter().enumerate() {
                let change = (v_1 - v[i]) / GAMMA; // h a₁ = (v₁ − v_n)/γ, (A2)
                self.mean.0[i] = x[i] + v_1 * (h - tau); // x* = x_n + (1 − γ) h v₁, (A2)
                self.mean.1[i] = v[i] + change * (1.0 - GAMMA); // v* = v_n + (1 − γ) h a₁, (A2)
                (self.extrapolated.0[i], self.extrapolated.1[i]) = (x[i] + v_1 * h, v[i] + change);
            }
            tau
        } else {
            let Self { history, mean: (x_star, v_star), extrapolated: (x_hat, v_hat), .. } = self;
            let (steps, k) = step_sizes(history, h);
            let formula = LinearMultistep::bdf(&steps[..k]); // α_j and β_k of EEH (3)
            let (weights, ahead) = (formula.past_weights(), extrapolation(&steps[..k]));
            history.mean(POSITION, x, &weights[..k], x_star); // x* = −Σ_{j<k} α_j x_{n+j} / α_k
            history.mean(VELOCITY, v, &weights[..k], v_star); // v* = −Σ_{j<k} α_j v_{n+j} / α_k
            history.mean(POSITION, x, &ahead[..k], x_hat); // x̂, v̂: extrapolated to the new time
            history.mean(VELOCITY, v, &ahead[..k], v_hat);
            formula.tau(h) // τ = h β_k/α_k
        };
        self.ahead = end;
        let all = (h, Obstacles::Met);
        // M (v_{n+k} − v*) = τ f(x* + τ v_{n+k}, v_{n+k}), EEH (4), by the iteration (5)
        self.solve(system, state, tau, all, settings.stage, clock, &mut report)?;
        clock.switch(Phase::Update);
        self.remember(system, state, h, tau);
        state.v.copy_from_slice(self.stage.velocity());
        state.x.copy_from_slice(self.stage.positions()); // x_{n+k} = x* + τ v_{n+k}, EEH (4)
        self.settle(state);
        state.t = end;
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
    /// Solves `M (v − v*) = τ f(x* + τ v, v)` for a stage that ends `span` seconds after `t_n`; the
    /// solution is in `stage`. A first stage that did not converge stays in the report.
    ///
    /// The first stage of Alexander's method, (A1), ignores obstacles: the second leads out the
    /// particles that enter one there. A particle that friction holds slips by `(1 − γ) γ h² a` in
    /// it.
    ///
    /// # Errors
    /// See [`drape_integrator::ImplicitStage::solve`].
    #[expect(clippy::too_many_arguments, reason = "each is owned by the step that calls")]
    fn solve(
        &mut self,
        system: &System,
        state: &State,
        tau: f64,
        (span, obstacles): (f64, Obstacles),
        settings: StageSettings,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let Self { mean, extrapolated, ahead, constraints, .. } = self;
        let from = (&state.x[..], &state.v[..]);
        let contacts = match obstacles {
            Obstacles::Met => &mut self.contacts,
            Obstacles::Ignored => &mut self.pins_alone,
        };
        let end = state.t + span;
        clock.switch(Phase::Contact);
        let motion = MultistepMotion { from, h: span, end, x_star: &mean.0, tau };
        contacts.detect_multistep(system, motion, constraints);
        let lagged = Level { t: *ahead, x: &extrapolated.0, v: &extrapolated.1 };
        let from = (&mean.0[..], &mean.1[..]);
        let stage = Stage { tau: tau.into(), end, from, lagged, velocity: &state.v };
        let (before, start) = (report.solve, &extrapolated.1);
        self.stage.solve_constrained(
            system,
            stage,
            Some(start),
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

    /// Pushes level `n` to the history, and computes the acceleration for the past of particles
    /// whose contact changes.
    fn remember(&mut self, system: &System, state: &State, h: f64, tau: f64) {
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
    }

    /// Ends the contacts. A particle whose contact changed gets a past of constant acceleration.
    fn settle(&mut self, State { x, v, .. }: &mut State) {
        let Self { acceleration: a, contacts, history, .. } = self;
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
