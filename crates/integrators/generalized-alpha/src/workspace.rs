//! The memory of a step, and what the step does beside its equations.

use crate::settings::GeneralizedAlphaSettings;
use drape_integrator::{
    ContactSet, ImplicitStage, MultistepMotion, Phase, PhaseClock, PrepareError, StepReport,
};
use drape_model::{Level, Revisions, State, System, Vec3};
use drape_solvers::{Constraints, Filter};

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) stage: ImplicitStage,
    /// System of the last step; `None` where there is none.
    pub(crate) known: Option<Revisions>,
    /// `a_n`, the acceleration that the method carries, m/s².
    pub(crate) a: Vec<Vec3>,
    /// `g_n = M⁻¹f_n`, without impulses of pins and contacts, m/s².
    pub(crate) g: Vec<Vec3>,
    /// `g_{n+1}`.
    pub(crate) g_new: Vec<Vec3>,
    /// The velocity that `g_n` belongs to, m/s.
    velocity: Vec<Vec3>,
    /// `X*` and `V*`, m and m/s.
    pub(crate) x_star: Vec<Vec3>,
    pub(crate) v_star: Vec<Vec3>,
    /// Prediction of the new level, m and m/s.
    pub(crate) ahead: (Vec<Vec3>, Vec<Vec3>),
    /// Velocity with which the step begins, m/s: `v_n` after impacts and with pins that are led.
    pub(crate) first: Vec<Vec3>,
    /// Pins and contacts of the step as they were found.
    found: Vec<Filter>,
    scratch: Vec<Vec3>,
    pub(crate) contacts: ContactSet,
    pub(crate) constraints: Constraints,
}

impl Workspace {
    pub(crate) fn allocate(
        system: &System,
        settings: &GeneralizedAlphaSettings,
    ) -> Result<Self, PrepareError> {
        let n = system.len();
        let zeros = || vec![Vec3::zeros(); n];
        Ok(Self {
            stage: ImplicitStage::with_linear(system, settings.stage.linear)?,
            known: None,
            a: zeros(),
            g: zeros(),
            g_new: zeros(),
            velocity: zeros(),
            x_star: zeros(),
            v_star: zeros(),
            ahead: (zeros(), zeros()),
            first: zeros(),
            found: vec![Filter::Free; n],
            scratch: zeros(),
            contacts: ContactSet::new(system),
            constraints: Constraints::free(n),
        })
    }

    /// Finds the contacts, and brings `a_n` and `g_n` to the velocity with which the step begins.
    /// Along its constraint a particle in contact, or led by a pin, moves at one velocity through
    /// the whole step, so that it ends where the constraint wants it.
    pub(crate) fn begin(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        clock: &mut PhaseClock,
        report: &mut StepReport,
    ) {
        clock.switch(Phase::Contact);
        let Self { contacts, constraints, first, found, .. } = self;
        let (from, end) = ((&state.x[..], &state.v[..]), state.t + h);
        let motion = MultistepMotion { from, h, end, x_star: &state.x, tau: h };
        contacts.detect_multistep(system, motion, constraints);
        contacts.strike(system, constraints, &state.v, first);
        found.iter_mut().enumerate().for_each(|(i, filter)| *filter = constraints.filter(i));
        clock.switch(Phase::Forces);
        let Self { known, a, g, velocity, first, scratch, .. } = self;
        let (x, t, mass) = (&state.x[..], state.t, system.mass());
        if *known != Some(system.revisions()) {
            system.forces(Level { t, x, v: first }, g);
            report.force_evaluations += 1;
            for (i, m) in mass.iter().enumerate() {
                g[i] = if system.pinned()[i] { Vec3::zeros() } else { g[i] / *m };
            }
            a.copy_from_slice(g); // a_0 = M⁻¹f_0
            return;
        }
        if *first != *velocity {
            // Damping of the velocities that impacts or pins have changed.
            for (v, sign) in [(&*first, 1.0), (&*velocity, -1.0)] {
                scratch.fill(Vec3::zeros());
                for effect in system.effects() {
                    effect.add_damping_force(Level { t, x, v }, scratch);
                }
                for (i, m) in mass.iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
                    let change = scratch[i] * (sign / m);
                    a[i] += change;
                    g[i] += change;
                }
            }
            report.force_evaluations += 1;
        }
        for i in 0..a.len() {
            if self.found[i] != Filter::Free {
                self.a[i] = self.g[i]; // in contact: no memory of the free flight
            }
        }
    }

    /// The part of an acceleration in the free directions of a particle: the others are
    /// constrained.
    pub(crate) fn along(&self, particle: usize, a: Vec3) -> Vec3 {
        self.found[particle].apply(a)
    }

    /// `M⁻¹f_{n+1} = (v_{n+1} − V*)/τ_v`, without the impulses of pins and contacts. Evaluating the
    /// force again would multiply the residual of the solve by `h²k/m`.
    pub(crate) fn unload(&mut self, system: &System, tau: f64, report: &mut StepReport) {
        let Self { stage, g_new, v_star, scratch, contacts, constraints, .. } = self;
        for (i, v) in stage.velocity().iter().enumerate() {
            let rate = (v - v_star[i]) / tau;
            g_new[i] = if system.pinned()[i] { Vec3::zeros() } else { rate };
        }
        if !contacts.is_empty() {
            scratch.copy_from_slice(stage.gradient(system));
            report.force_evaluations += 1;
            for (i, m) in system.mass().iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
                g_new[i] -= constraints.filter(i).complement(scratch[i]) / (m * tau);
            }
        }
    }

    /// Where the pins on paths end a step of `h` seconds from `x`. Taken from `X*`, their way would
    /// be off by round-off, which they would follow in the next step.
    pub(crate) fn lead(&mut self, system: &System, x: &[Vec3], h: f64) {
        for i in system.moving_pins().iter().map(|pin| pin.particle) {
            self.x_star[i] = x[i] + self.first[i] * h;
        }
    }

    /// Ends the step. A particle whose contact began, ended or cut its velocity forgets the
    /// acceleration that the method carries.
    pub(crate) fn finish(&mut self, system: &System, state: &mut State) {
        let Self { known, a, g, velocity, x_star, contacts, .. } = self;
        for i in system.moving_pins().iter().map(|pin| pin.particle) {
            state.x[i] = x_star[i];
        }
        *known = Some(system.revisions());
        velocity.copy_from_slice(&state.v);
        contacts.settle(&mut state.v, |change| a[change.particle] = g[change.particle]);
    }
}
