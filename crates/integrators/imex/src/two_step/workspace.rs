//! Scratch memory, cached operators and history, and the right-hand side.

use super::past::Past;
use super::split_forces::SplitForces;
use super::{Coefficients, ImexTwoStepSettings};
use crate::splitting::SplittingError;
use drape_integrator::{ContactSet, ImplicitStage, LaplacianSolver, PrepareError, Weights};
use drape_model::{Level, State, System, Vec3};
use drape_solvers::Constraints;

#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) linear: LaplacianSolver,
    pub(crate) starter: ImplicitStage,
    pub(crate) past: Past,
    /// Forces of level `n`.
    pub(crate) present: SplitForces,
    /// `X*`, and at the end of the step `x_{n+1}`, m.
    pub(crate) position: Vec<Vec3>,
    pub(crate) velocity: Vec<Vec3>,
    /// Right-hand side, kg m/s.
    pub(crate) b: Vec<Vec3>,
    pub(crate) impulse: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
    pub(crate) splitting: SplittingError,
    /// Force of the effects without a Jacobian, such as gravity, N.
    pub(crate) external: Vec<Vec3>,
    scratch: Vec<Vec3>,
}

/// Round-off of a force over `k |x|`, and of a momentum over `m |v|`.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

impl Workspace {
    pub(crate) fn new(
        system: &System,
        settings: &ImexTwoStepSettings,
        tau: f64,
    ) -> Result<Self, PrepareError> {
        let ImexTwoStepSettings { linear, implicit, .. } = *settings;
        let zeros = || vec![Vec3::zeros(); system.len()];
        let weights = Weights::StiffnessAndDamping;
        Ok(Self {
            linear: LaplacianSolver::new(system, implicit, weights, linear, tau)?,
            starter: ImplicitStage::new(system)?,
            past: Past::new(system.len()),
            present: SplitForces::new(system.len()),
            position: zeros(),
            velocity: zeros(),
            b: zeros(),
            impulse: zeros(),
            contacts: ContactSet::new(system),
            constraints: ContactSet::constraints(system),
            splitting: SplittingError::new(system.len()),
            external: zeros(),
            scratch: zeros(),
        })
    }

    pub(crate) fn restart(&mut self) {
        self.past.restart();
        self.contacts.restart();
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
    pub(crate) fn assemble(
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

    /// Evaluates the external forces of level `n`.
    pub(crate) fn evaluate_external(&mut self, system: &System, state: &State) {
        self.external.fill(Vec3::zeros());
        for effect in system.effects().filter(|effect| !effect.has_jacobian()) {
            effect.add_force(system.mass(), &state.x, &mut self.external);
        }
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
    pub(crate) fn reference(
        &mut self,
        system: &System,
        state: &State,
        tau: f64,
        forcing_term: f64,
    ) -> f64 {
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
