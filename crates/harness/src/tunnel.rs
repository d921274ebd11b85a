//! Particles that may pass through an obstacle between two steps: contacts are found at the ends of
//! steps alone.

use crate::run::Moment;
use drape_model::{Obstacle, State, System, Vec3};

/// A particle and an obstacle that moved past each other by more than the obstacle is thick.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// End of the step, s.
    pub time: f64,
    /// Length of the step, s.
    pub step: f64,
    /// Index of the particle in the specification.
    pub particle: usize,
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Its shape.
    pub shape: &'static str,
    /// Their way past each other in the step, m.
    pub way: f64,
    /// Its least extent, m.
    pub thickness: f64,
}

/// Finds the first passage of a run.
#[derive(Clone, Debug)]
pub struct Tunnels {
    /// `None` where no obstacle is thin.
    before: Option<State>,
    first: Option<Passage>,
}

fn is_thin(obstacle: &Obstacle) -> bool {
    obstacle.thickness().is_finite()
}

impl Tunnels {
    /// Begins at the start of a run.
    pub fn new(system: &System, state: &State) -> Self {
        let is_possible = system.obstacles().iter().any(is_thin);
        Self { before: is_possible.then(|| state.clone()), first: None }
    }

    /// Looks at the end of a step.
    pub fn look(&mut self, moment: &Moment<'_>) {
        let Some(before) = self.before.as_mut().filter(|_| self.first.is_none()) else { return };
        let Moment { system, state, numbering, .. } = *moment;
        let obstacles = system.obstacles().iter().enumerate();
        for (index, obstacle) in obstacles.filter(|(_, obstacle)| is_thin(obstacle)) {
            let offsets = [before.t, state.t].map(|t| obstacle.offset(t));
            let places = before.x.iter().zip(&state.x).enumerate();
            let passage = |(i, (from, to)): (usize, (&Vec3, &Vec3))| {
                let (from, to) = (from - offsets[0], to - offsets[1]);
                let is_through = !system.pinned()[i] && passes(obstacle, from, to);
                is_through.then(|| (numbering.given(i), (to - from).norm()))
            };
            if let Some((particle, way)) = places.filter_map(passage).min_by_key(|found| found.0) {
                self.first = Some(Passage {
                    time: state.t,
                    step: state.t - before.t,
                    particle,
                    obstacle: index,
                    shape: obstacle.shape.name(),
                    way,
                    thickness: obstacle.thickness(),
                });
                return;
            }
        }
        before.copy_from(state);
    }

    /// The first passage, if there was one.
    pub fn first(&self) -> Option<&Passage> {
        self.first.as_ref()
    }
}

/// Whether the way from one place to another, as the obstacle sees it, is longer than the obstacle
/// is thick, and leads through the ball around it.
fn passes(obstacle: &Obstacle, from: Vec3, to: Vec3) -> bool {
    let Some((center, radius)) = obstacle.bounding_ball() else { return false };
    let way = to - from;
    let length = way.norm_squared();
    if length.sqrt() <= obstacle.thickness() || !length.is_finite() {
        return false;
    }
    let nearest = ((center - from).dot(&way) / length).clamp(0.0, 1.0);
    (from + way * nearest - center).norm() < radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::Shape;

    #[test]
    fn a_way_through_a_ball_passes_if_it_is_longer_than_the_ball_is_thick() {
        let ball = Obstacle::from(Shape::Sphere { center: Vec3::x(), radius: 0.1 });
        let along_x = |from: f64, to: f64, y: f64| {
            passes(&ball, Vec3::new(from, y, 0.0), Vec3::new(to, y, 0.0))
        };
        assert!(along_x(0.0, 2.0, 0.0) && along_x(2.0, 0.0, 0.09));
        assert!(!along_x(0.0, 2.0, 0.11), "past it");
        assert!(!along_x(0.0, 0.89, 0.0), "not yet there");
        assert!(!along_x(0.91, 1.09, 0.0), "shorter than the ball is thick");
        assert!(!along_x(0.0, f64::INFINITY, 0.0));
        let plane = Obstacle::from(Shape::Plane { point: Vec3::zeros(), normal: Vec3::x() });
        assert!(!passes(&plane, Vec3::x(), -Vec3::x()), "a plane has no other side");
    }
}
