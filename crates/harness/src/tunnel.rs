//! Finds particles that may have passed through an obstacle within a step. Methods find contacts
//! only at the ends of steps.

use crate::run::Moment;
use drape_model::{Obstacle, State, System, Vec3};

/// Greatest distance outside the surface at which a particle still touches it, m.
const TOUCHING: f64 = 1e-9;

/// A particle and an obstacle that moved past each other by more than the obstacle's thickness.
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
    /// Shape of the obstacle.
    pub shape: &'static str,
    /// Length of their relative motion in the step, m.
    pub way: f64,
    /// Least extent of the obstacle, m.
    pub thickness: f64,
}

/// Finds the first passage of a run.
#[derive(Clone, Debug)]
pub struct Tunnels {
    /// The state at the end of the last step; `None` where no obstacle has a finite thickness.
    before: Option<State>,
    first: Option<Passage>,
}

fn is_thin(obstacle: &Obstacle) -> bool {
    obstacle.thickness().is_finite()
}

impl Tunnels {
    /// Starts to watch a run, at its start.
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

/// Most steps of the march along a way. Only ways that graze a surface need more than a few dozen.
const MOST_STEPS: usize = 1000;
/// Least step of the march, over the length of the way.
const LEAST_STEP: f64 = 1e-6;

/// Whether a particle passes through an obstacle unseen on the way between two places, relative to
/// the obstacle. The way is longer than the obstacle is thick, and begins outside it. It ends
/// outside again, behind the obstacle, or inside it where the nearest surface lies ahead.
fn passes(obstacle: &Obstacle, from: Vec3, to: Vec3) -> bool {
    let Some((center, radius)) = obstacle.bounding_ball() else { return false };
    let way = to - from;
    let length = way.norm();
    if length <= obstacle.thickness() || !length.is_finite() {
        return false;
    }
    let nearest = ((center - from).dot(&way) / (length * length)).clamp(0.0, 1.0);
    if (from + way * nearest - center).norm() >= radius {
        return false;
    }
    let (outside, _) = obstacle.distance(&from);
    let (end, normal) = obstacle.distance(&to);
    if outside <= TOUCHING {
        return false; // the method finds this contact
    }
    if end <= 0.0 {
        return normal.dot(&way) > 0.0; // the contact will push it out on the other side
    }
    enters(obstacle, from, way / length, length, outside)
}

/// Whether a way of this length enters the obstacle. No surface is nearer than the distance from
/// the obstacle, so the march steps by this distance.
fn enters(obstacle: &Obstacle, from: Vec3, along: Vec3, length: f64, outside: f64) -> bool {
    let mut place = outside;
    for _ in 0..MOST_STEPS {
        if place >= length {
            return false;
        }
        let (distance, _) = obstacle.distance(&(from + along * place));
        if distance <= 0.0 {
            return true;
        }
        place += distance.max(LEAST_STEP * length);
    }
    false
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
        assert!(!along_x(0.0, 0.99, 0.0) && along_x(0.0, 1.01, 0.0), "it is led back, or on");
        assert!(!along_x(1.01, 2.0, 0.0), "the contact is known");
        let plane = Obstacle::from(Shape::Plane { point: Vec3::zeros(), normal: Vec3::x() });
        assert!(!passes(&plane, Vec3::x(), -Vec3::x()), "a plane has no other side");
    }

    /// A plate of 2 m by 2 m, 2 cm thick, as a box and as triangles.
    fn plates() -> [Obstacle; 2] {
        let half_extents = Vec3::new(1.0, 1.0, 0.01);
        let plate = Obstacle::from(Shape::Box { center: Vec3::zeros(), half_extents });
        let corner = |i: usize| [0, 1, 2].map(|a| [-1.0, 1.0][i >> a & 1] * half_extents[a]);
        let corners: Vec<_> = (0..8).map(corner).collect();
        let faces = [
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
            [0, 1, 5],
            [0, 5, 4],
            [2, 6, 7],
            [2, 7, 3],
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
        ];
        let scene = serde_json::json!({
            "format": "drape-system/1", "particles": { "mass_kg": [1], "position_m": [[0, 0, 9]] },
            "obstacles": [{ "mesh": { "vertices_m": corners, "triangles": faces } }]
        });
        let file = drape_model::parse("plate", &scene.to_string()).expect("valid");
        let (system, _) = file.spec().build().expect("valid");
        [plate, system.obstacles()[0].clone()]
    }

    #[test]
    fn a_way_past_a_plate_is_no_passage() {
        for plate in plates() {
            let way = |from: [f64; 3], to: [f64; 3]| passes(&plate, from.into(), to.into());
            assert!(way([0.3, 0.2, 0.5], [0.3, 0.2, -0.5]), "through it");
            assert!(way([0.9, 0.0, 0.1], [1.4, 0.0, -0.4]), "through it, near its edge");
            assert!(!way([0.3, 0.2, 0.5], [0.3, 0.2, 0.1]), "towards it");
            assert!(!way([-0.9, 0.0, 0.5], [0.9, 0.0, 0.5]), "along it, within the ball around it");
            assert!(!way([-0.9, 0.0, 0.012], [0.9, 0.0, 0.012]), "close along it");
            assert!(!way([1.0, 0.0, 0.4], [1.1, 0.0, -0.4]), "past its edge");
            assert!(!way([0.0, 0.0, 0.3], [0.0, 0.0, 0.005]), "in at the top: it is led back");
            assert!(way([0.0, 0.0, 0.3], [0.0, 0.0, -0.005]), "in beyond the middle");
            assert!(!way([0.0, 0.0, 0.01], [0.0, 0.0, -0.4]), "it lay on the plate");
        }
    }

    /// In one step a ball jumps over a particle that rests.
    #[test]
    fn a_ball_that_is_led_through_a_particle_is_seen() {
        let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [1],
            "position_m": [[0, 0, 0]] }, "obstacles": [{ "sphere": { "center_m": [-1, 0, 0],
                "radius_m": 0.1, "path": [{ "time_s": 0.1, "offset_m": [2, 0, 0] }] } }] }"#;
        let file = drape_model::parse("ball", text).expect("valid");
        let (system, state) = file.spec().build().expect("valid");
        let mut tunnels = Tunnels::new(&system, &state);
        let mut simulation = crate::Simulation { system, state };
        let choice = crate::methods::Choice::parse("imex-euler", &[]).expect("a method");
        let time = drape_model::TimeSpan { step_s: 0.1, duration_s: 0.1 };
        let runner = crate::Runner::new(&choice, time).observe(|moment| tunnels.look(moment));
        runner.go(&mut simulation).expect("runs");
        let found = tunnels.first().map(|passage| (passage.particle, passage.way));
        assert_eq!(found, Some((0, 2.0)));
    }
}
