//! The state of a system, which an integrator advances.

use crate::Vec3;

/// What a force may depend on; only gusts use `t`.
#[derive(Clone, Copy, Debug)]
pub struct Level<'a> {
    /// Time, s.
    pub t: f64,
    /// Positions, m; one per particle.
    pub x: &'a [Vec3],
    /// Velocities, m/s; one per particle.
    pub v: &'a [Vec3],
}

/// Time, positions and velocities. The history of past levels belongs to the integrator.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time, s.
    pub t: f64,
    /// Positions, m; one per particle.
    pub x: Vec<Vec3>,
    /// Velocities, m/s; one per particle.
    pub v: Vec<Vec3>,
}

impl State {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// The state as an argument of force evaluations.
    pub fn level(&self) -> Level<'_> {
        Level { t: self.t, x: &self.x, v: &self.v }
    }

    /// Whether the state has no particles.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Whether every coordinate of every position and velocity is a finite number.
    pub fn is_finite(&self) -> bool {
        let finite = |vectors: &[Vec3]| vectors.iter().all(|a| a.iter().all(|c| c.is_finite()));
        finite(&self.x) && finite(&self.v)
    }

    /// Copies another state of the same size without allocating.
    pub fn copy_from(&mut self, other: &State) {
        self.t = other.t;
        self.x.copy_from_slice(&other.x);
        self.v.copy_from_slice(&other.v);
    }
}
