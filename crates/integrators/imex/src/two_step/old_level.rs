//! Level `n − 1`, and the changes that make it useless.

use super::split_forces::SplitForces;
use drape_integrator::{History, Implicit, Past};
use drape_model::{Level, Revisions, State, System, Vec3};
use drape_solvers::Filter;

/// Memory of level `n − 1` in a two-step method.
#[derive(Clone, Debug)]
pub struct OldLevel {
    /// Time of the level, s.
    time: f64,
    /// Positions and velocities.
    level: History<2>,
    pub(crate) forces: SplitForces,
    /// Whether `forces` belong to the level as it is now.
    forces_fit: bool,
    /// Revisions of the system that the level belongs to.
    revisions: Option<Revisions>,
}

impl Past for OldLevel {
    fn copy_from(&mut self, other: &Self) {
        self.time = other.time;
        self.level.copy_from(&other.level);
        self.forces.copy_from(&other.forces);
        (self.forces_fit, self.revisions) = (other.forces_fit, other.revisions);
    }
}

impl OldLevel {
    pub(crate) fn new(n: usize) -> Self {
        let (level, forces) = (History::new(n, 1), SplitForces::new(n));
        Self { time: 0.0, level, forces, forces_fit: false, revisions: None }
    }

    pub(crate) fn restart(&mut self) {
        self.level.restart();
    }

    /// `ω = h_n/h_{n−1}` for a step of `h` seconds. `None` without a past, or where masses,
    /// stiffnesses, damping coefficients or pins have changed.
    pub(crate) fn step_ratio(&self, system: &System, h: f64) -> Option<f64> {
        let fits = !self.level.is_empty() && self.revisions == Some(system.revisions());
        fits.then(|| h / self.level.step(0))
    }

    /// `(t_{n−1}, x_{n−1}, v_{n−1})`.
    pub(crate) fn level(&self) -> Level<'_> {
        Level { t: self.time, x: self.level.field(0, 0), v: self.level.field(0, 1) }
    }

    /// Extrapolates `v_n` to the end of a step of `h` seconds, `v_n + ω (v_n − v_{n−1})`.
    pub(crate) fn extrapolate(&self, h: f64, v: &mut [Vec3]) {
        let omega = h / self.level.step(0);
        for (v, old) in v.iter_mut().zip(self.level.field(0, 1)) {
            *v += (*v - old) * omega;
        }
    }

    /// Brings the forces up to date; returns the number of sweeps over the springs.
    pub(crate) fn update_forces(&mut self, system: &System, implicit: Implicit) -> u32 {
        if std::mem::replace(&mut self.forces_fit, true) {
            return 0;
        }
        let Self { time: t, level, forces, .. } = self;
        let at = Level { t: *t, x: level.field(0, 0), v: level.field(0, 1) };
        forces.evaluate(system, implicit, at);
        SplitForces::SWEEPS
    }

    /// Remembers the level that a step of `h` seconds is about to leave, with its forces if they
    /// are known.
    pub(crate) fn remember(
        &mut self,
        system: &System,
        state: &State,
        h: f64,
        forces: Option<&mut SplitForces>,
    ) {
        self.revisions = Some(system.revisions());
        self.time = state.t;
        self.level.push(h, [&state.x, &state.v]);
        self.forces_fit = forces.is_some();
        if let Some(forces) = forces {
            std::mem::swap(&mut self.forces, forces);
        }
    }

    /// Rewrites the past of a particle whose contact changed. In the constrained directions it came
    /// to `(x, v)` with the acceleration `a`; in the free ones its past stays. Forces are evaluated
    /// anew, so that a force across a stiff spring is extrapolated along the same path as the
    /// positions.
    pub(crate) fn meet(&mut self, particle: usize, filter: Filter, (x, v): (Vec3, Vec3), a: Vec3) {
        if filter == Filter::Free {
            return; // a contact that ends changes no velocity
        }
        let (old_x, old_v) = (self.level.field(0, 0)[particle], self.level.field(0, 1)[particle]);
        self.level.rewrite(particle, |age| {
            let (past_x, past_v) = (x - v * age + a * (0.5 * age * age), v - a * age);
            [old_x + filter.complement(past_x - old_x), old_v + filter.complement(past_v - old_v)]
        });
        self.forces_fit = false;
    }
}
