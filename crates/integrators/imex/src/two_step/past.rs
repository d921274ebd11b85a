//! Level `n − 1`, and what may spoil it.

use super::split_forces::SplitForces;
use drape_integrator::{History, Implicit};
use drape_model::{Level, Revisions, State, System, Vec3};
use drape_solvers::Filter;

/// What a two-step method remembers of level `n − 1`.
#[derive(Clone, Debug)]
pub struct Past {
    /// Time of the level, s.
    time: f64,
    /// Positions and velocities.
    level: History<2>,
    pub(crate) forces: SplitForces,
    /// Whether `forces` are those of the level as it stands.
    forces_fit: bool,
    /// Of the system that the level belongs to.
    revisions: Option<Revisions>,
}

impl drape_integrator::Past for Past {
    fn copy_from(&mut self, other: &Self) {
        self.time = other.time;
        self.level.copy_from(&other.level);
        self.forces.copy_from(&other.forces);
        (self.forces_fit, self.revisions) = (other.forces_fit, other.revisions);
    }
}

impl Past {
    pub(crate) fn new(n: usize) -> Self {
        let (level, forces) = (History::new(n, 1), SplitForces::new(n));
        Self { time: 0.0, level, forces, forces_fit: false, revisions: None }
    }

    pub(crate) fn restart(&mut self) {
        self.level.restart();
    }

    /// `ω = h_n/h_{n−1}` for a step of `h` seconds; `None` where there is no past, or that of a system
    /// with other masses, stiffnesses, damping coefficients or pins.
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

    /// Brings the forces up to date; returns the number of sweeps over the springs that this took.
    pub(crate) fn update_forces(&mut self, system: &System, implicit: Implicit) -> u32 {
        if std::mem::replace(&mut self.forces_fit, true) {
            return 0;
        }
        let Self { time: t, level, forces, .. } = self;
        let at = Level { t: *t, x: level.field(0, 0), v: level.field(0, 1) };
        forces.evaluate(system, implicit, at);
        SplitForces::SWEEPS
    }

    /// Remembers the level that a step of length `h` is about to leave, with its forces if they are known.
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

    /// Rewrites the past of a particle whose contact changed. In the constrained directions it has been on
    /// its way to `(x, v)` with the acceleration `a`, in the free ones where it was. Forces follow, else
    /// the force across a stiff spring would be extrapolated along another path than the positions.
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
