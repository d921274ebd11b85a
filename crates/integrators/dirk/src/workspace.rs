//! The memory of a step, and what the step does beside its equations.

use crate::settings::DirkSettings;
use crate::tableau::Coefficients;
use drape_integrator::{
    ContactSet, ImplicitStage, MultistepMotion, Order, Phase, PhaseClock, PrepareError, StepReport,
};
use drape_model::{Effect, Level, Part, Revisions, State, System, Vec3};
use drape_solvers::Constraints;

/// What a step leaves to the next one.
#[derive(Clone, Debug)]
pub struct Past {
    /// System of the last step; `None` where there is none.
    pub(crate) known: Option<Revisions>,
    /// `a_s` of its last stage, m/s².
    acceleration: Vec<Vec3>,
    /// `w_s`, the velocity that `a_s` belongs to, m/s.
    velocity: Vec<Vec3>,
}

impl drape_integrator::Past for Past {
    fn copy_from(&mut self, other: &Self) {
        self.known = other.known;
        self.acceleration.copy_from_slice(&other.acceleration);
        self.velocity.copy_from_slice(&other.velocity);
    }
}

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) stage: ImplicitStage,
    /// `w_i` and `a_i` of each stage, m/s and m/s².
    pub(crate) w: Vec<Vec<Vec3>>,
    pub(crate) a: Vec<Vec<Vec3>>,
    /// `X*` and `V*` of the present stage, m and m/s.
    pub(crate) x_star: Vec<Vec3>,
    pub(crate) v_star: Vec<Vec3>,
    /// Prediction of its end, m and m/s.
    pub(crate) ahead: (Vec<Vec3>, Vec<Vec3>),
    /// Velocity with which the step begins, m/s: `v_n` after impacts and with pins that are led.
    pub(crate) first: Vec<Vec3>,
    scratch: Vec<Vec3>,
    pub(crate) past: Past,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    /// Solves of each stage: a second one where order 3 or 4 needs better directions of damping.
    pub(crate) passes: usize,
}

impl Workspace {
    pub(crate) fn allocate(system: &System, settings: &DirkSettings) -> Result<Self, PrepareError> {
        let n = system.len();
        let zeros = || vec![Vec3::zeros(); n];
        let stages = settings.tableau.coefficients().rows.len();
        let lags = |effect: &dyn Effect| {
            effect.has_damping() && effect.pass(system.mass(), Part::Damping).is_none()
        };
        let is_low = settings.tableau.order() == Order::Two;
        let passes = if is_low || !system.effects().any(lags) { 1 } else { 2 };
        Ok(Self {
            stage: ImplicitStage::with_linear(system, settings.linear)?,
            w: (0..stages).map(|_| zeros()).collect(),
            a: (0..stages).map(|_| zeros()).collect(),
            x_star: zeros(),
            v_star: zeros(),
            ahead: (zeros(), zeros()),
            first: zeros(),
            scratch: zeros(),
            past: Past { known: None, acceleration: zeros(), velocity: zeros() },
            contacts: ContactSet::new(system),
            constraints: Constraints::free(n),
            passes,
        })
    }

    /// Finds the contacts of the step, once for all stages. A particle in contact, or led by a pin,
    /// has the same mean velocity along its constraint in every stage, so that
    /// `x_n + h Σ b_i w_i` ends where the constraint wants it.
    pub(crate) fn begin(&mut self, system: &System, state: &State, h: f64, clock: &mut PhaseClock) {
        let Self { first, past, contacts, constraints, .. } = self;
        clock.switch(Phase::Contact);
        if past.known != Some(system.revisions()) {
            past.known = None;
        }
        let (from, end) = ((&state.x[..], &state.v[..]), state.t + h);
        let motion = MultistepMotion { from, h, end, x_star: &state.x, tau: h };
        contacts.detect_multistep(system, motion, constraints);
        contacts.strike(system, constraints, &state.v, first);
    }

    /// The explicit stage. `a₁` is `a_s` of the last step; evaluating the force again would
    /// multiply the residual of that stage by `h²k/m`. Where impacts or pins have changed
    /// velocities since, their damping forces are added.
    pub(crate) fn first_stage(&mut self, system: &System, state: &State, report: &mut StepReport) {
        let Self { w, a, first, scratch, past, .. } = self;
        let (Some(w), Some(a)) = (w.first_mut(), a.first_mut()) else { return };
        w.copy_from_slice(first);
        let (x, t) = (&state.x[..], state.t);
        if past.known.is_none() {
            system.forces(Level { t, x, v: first }, a);
            report.force_evaluations += 1;
            for (i, m) in system.mass().iter().enumerate() {
                a[i] = if system.pinned()[i] { Vec3::zeros() } else { a[i] / *m };
            }
            return;
        }
        a.copy_from_slice(&past.acceleration);
        if *first == past.velocity {
            return;
        }
        let damping = |v: &[Vec3], out: &mut [Vec3]| {
            out.fill(Vec3::zeros());
            for effect in system.effects() {
                effect.add_damping_force(Level { t, x, v }, out);
            }
        };
        for (v, sign) in [(&*first, 1.0), (&past.velocity, -1.0)] {
            damping(v, scratch);
            for (i, m) in system.mass().iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
                a[i] += scratch[i] * (sign / m);
            }
        }
        report.force_evaluations += 1;
    }

    /// Predicts the end of stage `i` from the acceleration of the stage before it.
    pub(crate) fn predict(&mut self, tableau: &Coefficients, i: usize, state: &State, h: f64) {
        let Self { w, a, x_star, ahead: (x_hat, v_hat), first, past, .. } = self;
        let since = tableau.time(i) - if i > 0 { tableau.time(i - 1) } else { 0.0 };
        let (v, a, way) = match i.checked_sub(1) {
            Some(before) => (&w[before], &a[before], since * h),
            None => {
                (&*first, &past.acceleration, if past.known.is_some() { since * h } else { 0.0 })
            }
        };
        let tau = tableau.gamma * h;
        for k in 0..state.len() {
            v_hat[k] = v[k] + a[k] * way;
            x_hat[k] = x_star[k] + v_hat[k] * tau;
        }
    }

    /// Keeps `w_i`, and `a_i` without the impulses of pins and contacts: each stage finds these
    /// anew. The coefficients of the method would turn an impact round.
    pub(crate) fn remember_stage(
        &mut self,
        system: &System,
        i: usize,
        tau: f64,
        report: &mut StepReport,
    ) {
        let Self { stage, w, a, v_star, scratch, contacts, constraints, .. } = self;
        let (w, a) = (&mut w[i], &mut a[i]);
        w.copy_from_slice(stage.velocity());
        for k in 0..w.len() {
            let rate = (w[k] - v_star[k]) / tau;
            a[k] = if system.pinned()[k] { Vec3::zeros() } else { rate };
        }
        if !contacts.is_empty() {
            scratch.copy_from_slice(stage.gradient(system));
            report.force_evaluations += 1;
            for (k, m) in system.mass().iter().enumerate().filter(|(k, _)| !system.pinned()[*k]) {
                a[k] -= constraints.filter(k).complement(scratch[k]) / (m * tau);
            }
        }
    }

    /// Prepares a solve after the first of the step: friction holds again where it can. A second
    /// pass of a stage lags its damping at the solution of the first.
    pub(crate) fn again(&mut self, system: &System, i: usize, pass: usize) {
        if i + pass > 0 {
            self.contacts.write(system, &mut self.constraints);
        }
        if pass > 0 {
            self.ahead.0.copy_from_slice(self.stage.positions());
            self.ahead.1.copy_from_slice(self.stage.velocity());
        }
    }

    /// Where the pins on paths end a step of `h` seconds from `x`. Summed over the stages, their way
    /// would be off by round-off, which they would follow in the next step.
    pub(crate) fn lead(&mut self, system: &System, x: &[Vec3], h: f64) {
        for i in system.moving_pins().iter().map(|pin| pin.particle) {
            self.x_star[i] = x[i] + self.first[i] * h;
        }
    }

    /// Ends the step, whose last stage was number `last`.
    pub(crate) fn finish(&mut self, system: &System, state: &mut State, last: usize) {
        let Self { w, a, x_star, past, contacts, .. } = self;
        past.acceleration.copy_from_slice(&a[last]);
        past.velocity.copy_from_slice(&w[last]);
        past.known = Some(system.revisions());
        for i in system.moving_pins().iter().map(|pin| pin.particle) {
            state.x[i] = x_star[i];
        }
        contacts.settle(&mut state.v, |_| ());
    }
}
