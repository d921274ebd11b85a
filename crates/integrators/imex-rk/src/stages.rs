//! What the stages of a step hand to later ones.

use crate::tableau::STAGES;
use drape_integrator::Implicit;
use drape_model::{Level, State, System, Vec3};

/// Velocities and accelerations of the stages of a step.
#[derive(Debug)]
pub(crate) struct Stages {
    stages: Vec<Stage>,
}

#[derive(Debug)]
struct Stage {
    /// `v_i`, the implicit slope of the positions, m/s.
    velocity: Vec<Vec3>,
    /// `g_i`, the implicit slope of the velocities, m/s².
    implicit: Vec<Vec3>,
    /// `e_i`, the explicit slope of the velocities, m/s².
    explicit: Vec<Vec3>,
}

impl Stages {
    pub(crate) fn new(n: usize, count: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        let stage = || Stage { velocity: zeros(), implicit: zeros(), explicit: zeros() };
        Self { stages: (0..count).map(|_| stage()).collect() }
    }

    /// Writes `x = x_n + h Σ_{j<count} a^I_j v_j` and `v = v_n + h Σ_{j<count} (a^I_j g_j + a^E_j
    /// e_j)`.
    pub(crate) fn combine(
        &self,
        from: &State,
        h: f64,
        (implicit, explicit): (&[f64; STAGES], &[f64; STAGES]),
        count: usize,
        x: &mut [Vec3],
        v: &mut [Vec3],
    ) {
        x.copy_from_slice(&from.x);
        v.copy_from_slice(&from.v);
        for (stage, (a, e)) in self.stages[..count].iter().zip(implicit.iter().zip(explicit)) {
            let (a, e) = (h * a, h * e);
            if a != 0.0 {
                for (i, (x, v)) in x.iter_mut().zip(&mut *v).enumerate() {
                    *x += stage.velocity[i] * a;
                    *v += stage.implicit[i] * a;
                }
            }
            if e != 0.0 {
                v.iter_mut().zip(&stage.explicit).for_each(|(v, slope)| *v += slope * e);
            }
        }
    }

    /// `v ← v + h Σ w_i e_i`.
    pub(crate) fn finish(&self, h: f64, weights: &[f64; STAGES], v: &mut [Vec3]) {
        for (stage, weight) in self.stages.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            let weight = h * weight;
            v.iter_mut().zip(&stage.explicit).for_each(|(v, slope)| *v += slope * weight);
        }
    }

    pub(crate) fn set_velocity(&mut self, stage: usize, v: &[Vec3]) {
        self.stages[stage].velocity.copy_from_slice(v);
    }

    /// `g_1 = −M⁻¹ (L_k x_n + L_d v_n)`, 0 for pinned particles.
    pub(crate) fn set_first_slope(&mut self, system: &System, implicit: Implicit, at: Level<'_>) {
        let slope = &mut self.stages[0].implicit;
        implicit.linear_forces(system, at, slope);
        accelerate(system, slope);
    }

    /// `g_i = (v_i − V*)/τ`. The solve has made it consistent: forces at `x_i` would carry its
    /// residual times the stiffness.
    pub(crate) fn set_slope(&mut self, stage: usize, tau: f64, v: &[Vec3], start: &[Vec3]) {
        for ((slope, v), start) in self.stages[stage].implicit.iter_mut().zip(v).zip(start) {
            *slope = (v - start) / tau;
        }
    }

    /// `e_i`: all forces but `−L_k x − L_d v` of the implicit springs, over the masses; 0 for
    /// pinned particles.
    pub(crate) fn set_force(
        &mut self,
        stage: usize,
        system: &System,
        implicit: Implicit,
        at: Level<'_>,
    ) {
        let slope = &mut self.stages[stage].explicit;
        implicit.forces_but_linear(system, at, slope);
        accelerate(system, slope);
    }

    /// Acceleration of a particle at the start of the step, m/s².
    pub(crate) fn first_acceleration(&self, particle: usize) -> Vec3 {
        let Stage { implicit, explicit, .. } = &self.stages[0];
        implicit[particle] + explicit[particle]
    }
}

/// Divides forces by the masses; pinned particles have no acceleration.
fn accelerate(system: &System, force: &mut [Vec3]) {
    for (force, m) in force.iter_mut().zip(system.mass()) {
        *force /= *m;
    }
    system.clear_pinned(force);
}
