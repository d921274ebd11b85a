//! Step size control around a method.

use crate::{
    ContactSet, Integrator, LocalError, Method, Past, PhaseClock, PrepareError, Rewind, Scratch,
    SolveStatus, StepController, StepError, StepReport, Stepper, TimeStep, mesh_width,
};
use drape_model::{Revisions, State, System, Vec3};

/// The least substep, over the time asked for.
const LEAST_SHARE: f64 = 1e-9;
/// Most attempts in a call.
const MAX_ATTEMPTS: u32 = 10_000;
/// Round-off in the division of a time span into steps.
const ROUND_OFF: f64 = 1e-9;
/// Error that the first step aims at, over the allowed one.
const FIRST_SHARE: f64 = 0.25;

/// A method under step size control. A call of [`step`](Integrator::step) advances by exactly the
/// given time, in substeps whose local errors stay below the tolerance.
///
/// * **Landing.** The rest of the call is divided into equal substeps that are not longer than
///   the controller allows. So the last substep ends exactly at the end of the call and is not
///   tiny. The step size is carried over to the next call.
/// * **Rejection.** Positions, velocities, time, history, predictor and contacts return to the
///   same bits as before the substep. A substep whose solver does not converge is also rejected.
/// * **Events.** Particles that met an obstacle have no error in that substep and no past
///   afterwards. After a change of stiffness, damping, masses or pins all particles lose their
///   past.
/// * **Limit.** If a substep shorter than 1e-9 of the call fails, or the ten-thousandth attempt
///   fails, the rest is taken in one step. The report then says that the call did not converge.
#[derive(Debug)]
pub struct Adaptive<S: Rewind> {
    method: Stepper<S>,
    tolerance: f64,
    scratch: Scratch<Workspace<S::Past>>,
}

#[derive(Debug)]
struct Workspace<P> {
    past: (P, ContactSet),
    /// The state at the start of the call.
    begin: State,
    /// The state at the start of the substep.
    kept: State,
    error: LocalError,
    controller: StepController,
    /// Size of the next substep, s; `None` before the first.
    proposal: Option<f64>,
    /// The tolerance, m.
    allowed: f64,
    revisions: Revisions,
}

impl<P> Workspace<P> {
    fn restart(&mut self) {
        self.error.restart();
        self.controller = StepController::new();
        self.proposal = None;
    }

    /// A first step that the present acceleration moves by a quarter of the allowed error:
    /// `√(2·¼·allowed/|a|)`.
    fn first_step(&mut self, system: &System, state: &State, most: f64) -> f64 {
        let force = self.error.vectors();
        system.forces(state.level(), force);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for (i, m) in system.mass().iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
            sum += force[i].norm_squared() / (m * m);
            count += 1.0;
        }
        let acceleration = (sum / count.max(1.0)).sqrt();
        let h = (2.0 * FIRST_SHARE * self.allowed / acceleration).sqrt();
        if h.is_finite() { h.min(most).max(most * ROUND_OFF) } else { most }
    }
}

/// The remaining substeps.
#[derive(Clone, Copy, Debug)]
struct Plan {
    h: f64,
    left: u32,
}

impl Plan {
    /// Equal substeps of at most `most` seconds over `rest` seconds.
    fn new(rest: f64, most: f64) -> Self {
        let left = (rest / most - ROUND_OFF).ceil().clamp(1.0, f64::from(u32::MAX));
        Self { h: rest / left, left: left as u32 }
    }

    /// Plans anew where the number of substeps changes. Else it keeps the step size, since another
    /// one costs a set-up.
    fn replace(&mut self, rest: f64, most: f64) {
        let other = Self::new(rest, most);
        if other.left != self.left {
            *self = other;
        }
    }
}

impl<S: Rewind> Stepper<S> {
    /// Copies the present past, without allocating.
    fn keep(&mut self, (past, contacts): &mut (S::Past, ContactSet)) {
        if let Some((present, touching)) = self.prepared().map(S::past) {
            past.copy_from(present);
            contacts.copy_from(touching);
        }
    }

    /// Brings a past back, without allocating.
    fn recall(&mut self, (past, contacts): &(S::Past, ContactSet)) {
        if let Some((present, touching)) = self.prepared().map(S::past) {
            present.copy_from(past);
            touching.copy_from(contacts);
        }
    }

    /// The contacts of the last step.
    fn contacts(&mut self) -> Option<&ContactSet> {
        self.prepared().map(|scheme| &*scheme.past().1)
    }
}

impl<S: Rewind> Adaptive<S> {
    /// A method under control. `tolerance` bounds the local error of positions in a substep, in
    /// mesh widths.
    pub fn new(method: Stepper<S>, tolerance: f64) -> Self {
        Self { method, tolerance, scratch: Scratch::default() }
    }
}

impl<S: Rewind> Integrator for Adaptive<S> {
    fn method(&self) -> &'static Method {
        self.method.method()
    }

    fn prepare(&mut self, system: &System, h: TimeStep) -> Result<(), PrepareError> {
        self.method.prepare(system, h)?;
        let Some(scheme) = self.method.prepared() else { return Ok(()) };
        let (past, contacts) = scheme.past();
        let past = (past.clone(), contacts.clone());
        let zeros = || vec![Vec3::zeros(); system.len()];
        let state = || State { t: 0.0, x: zeros(), v: zeros() };
        let workspace = Workspace {
            past,
            begin: state(),
            kept: state(),
            error: LocalError::new(system.len()),
            controller: StepController::new(),
            proposal: None,
            allowed: self.tolerance * mesh_width(system),
            revisions: system.revisions(),
        };
        self.scratch.set(system, workspace);
        Ok(())
    }

    fn step(
        &mut self,
        system: &System,
        state: &mut State,
        h: TimeStep,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        let Self { method, scratch, .. } = self;
        let w = scratch.ready(system, state, h)?;
        let (order, span, end) = (S::order(method.settings()), h.seconds(), state.t + h.seconds());
        let mut report = StepReport { substeps: 0, ..StepReport::default() };
        if std::mem::replace(&mut w.revisions, system.revisions()) != system.revisions() {
            w.error.restart();
        }
        w.begin.copy_from(state);
        let first = match w.proposal {
            Some(h) => h,
            None => {
                report.force_evaluations += 1;
                w.first_step(system, state, span)
            }
        };
        let (mut plan, mut elapsed) = (Plan::new(span, first), 0.0);
        let mut attempts = 0;
        loop {
            w.kept.copy_from(state);
            method.keep(&mut w.past);
            let is_last_resort = plan.h < LEAST_SHARE * span || attempts >= MAX_ATTEMPTS;
            if is_last_resort {
                plan = Plan { h: span - elapsed, left: 1 };
            }
            attempts += 1;
            let mut attempt = match method.step(system, state, h.part(plan.h), clock) {
                Ok(attempt) => attempt,
                // A shorter step may have a matrix that can be factorised.
                Err(StepError::Solver(_)) if !is_last_resort => {
                    report.rejected += 1;
                    state.copy_from(&w.kept);
                    method.recall(&w.past);
                    plan = Plan::new(span - elapsed, 0.5 * plan.h);
                    continue;
                }
                Err(error) => {
                    state.copy_from(&w.begin);
                    method.restart(state);
                    w.restart();
                    return Err(error);
                }
            };
            let constant = |omega| S::error_constant(method.settings(), omega);
            w.error.measure(order, constant, &w.kept, &state.x, plan.h);
            let settings = method.settings().clone();
            if let Some(scheme) = method.prepared() {
                let vectors = w.error.vectors();
                scheme.add_splitting_error(&settings, system, state, plan.h, vectors, &mut attempt);
            }
            let error = w.error.norm(system, method.contacts()) / w.allowed;
            if is_last_resort {
                attempt.solve = SolveStatus::IterationLimit;
            }
            let solved = matches!(attempt.solve, SolveStatus::Converged | SolveStatus::Stagnated);
            let decision = w.controller.judge(order, error, solved);
            if !decision.accepted && !is_last_resort {
                report.add_rejected(&attempt);
                state.copy_from(&w.kept);
                method.recall(&w.past);
                plan = Plan::new(span - elapsed, plan.h * decision.factor);
                continue;
            }
            report.add_substep(&attempt, error);
            w.error.accept(&w.kept, plan.h, method.contacts());
            let next = plan.h * decision.factor;
            w.proposal = Some(next);
            plan.left -= 1;
            if plan.left == 0 {
                break;
            }
            elapsed += plan.h;
            if decision.factor != 1.0 {
                plan.replace(span - elapsed, next);
            }
        }
        state.t = end;
        report.next_step = w.proposal.unwrap_or(span);
        if report.solve == SolveStatus::IterationLimit {
            w.restart(); // a forced step is no past to estimate from
        }
        Ok(report)
    }

    fn restart(&mut self, state: &State) {
        self.method.restart(state);
        if let Some(w) = self.scratch.get_mut() {
            w.restart();
        }
    }
}

#[cfg(test)]
mod tests;
