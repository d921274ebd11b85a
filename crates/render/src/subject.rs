//! The constant parts of a picture: triangles, lines, obstacles.

use crate::Ground;
use crate::solid::{Solid, solids};
use crate::surface::edges;
use drape_model::{Obstacle, SpringEffect, SystemSpec, Vec3};
use std::borrow::Cow;

/// Greatest size of an obstacle over the size of the cloth at which a picture shows all of it.
const LARGEST: f64 = 4.0;

/// The constant parts of pictures. Positions come with each picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Subject {
    /// Triangles of the cloth, as indices of particles.
    pub triangles: Vec<[u32; 3]>,
    /// Lines on the cloth: its tension springs, or all edges if it has none. Without triangles: all
    /// springs.
    pub lines: Vec<[u32; 2]>,
    /// The obstacles, at their places at the start.
    pub solids: Vec<Solid>,
    /// Particles that are drawn as pins.
    pub pins: Vec<u32>,
    /// Number of the group of each particle, which gives the cloth its colour there. If empty, the
    /// cloth has two colours, one for each side.
    pub groups: Vec<usize>,
    /// Particles that are drawn as dots, each with the number of its colour.
    pub marks: Vec<(u32, usize)>,
    /// The ground on which shadows fall.
    pub ground: Option<Ground>,
}

impl Subject {
    /// The subject of a system with these obstacles.
    pub fn new(spec: &SystemSpec, obstacles: &[Obstacle]) -> Self {
        let x: Vec<Vec3> = spec.particles.position_m.iter().map(|&x| x.into()).collect();
        let springs = spec.springs.iter();
        let lines = if spec.triangles.is_empty() {
            springs.map(|spring| [spring.i, spring.j]).collect()
        } else {
            let edges = edges(&spec.triangles);
            let tension: Vec<[u32; 2]> = springs
                .filter(|spring| spring.effect == SpringEffect::Tension)
                .map(|spring| [spring.i.min(spring.j), spring.i.max(spring.j)])
                .filter(|line| edges.contains_key(line))
                .collect();
            if tension.is_empty() { edges.into_keys().collect() } else { tension }
        };
        let solids = solids(obstacles, &x, &lines);
        let pins = spec.pins.iter().map(|pin| pin.particle).collect();
        Self { triangles: spec.triangles.clone(), lines, solids, pins, ..Self::default() }
    }

    /// The subject of a sheet of particles, numbered row by row; `x` are positions at any time, m.
    pub fn grid(rows: u32, columns: u32, obstacles: &[Obstacle], x: &[Vec3]) -> Self {
        let (triangles, lines) = grid(rows, columns);
        let solids = solids(obstacles, x, &lines);
        Self { triangles, lines, solids, ..Self::default() }
    }

    /// The subject with a ground below these points, m, and the points that a picture of it must
    /// show, m. It gets no ground if one of its obstacles is a plane.
    pub fn on_ground(mut self, mut points: Vec<Vec3>) -> (Self, Vec<Vec3>) {
        let has_plane = self.solids.iter().any(|solid| solid.is_endless);
        self.ground = if has_plane { None } else { Ground::under(&points) };
        points.extend(self.ground.iter().flat_map(Ground::points));
        (self, points)
    }

    /// Whether an obstacle moves.
    pub fn moves(&self) -> bool {
        self.solids.iter().any(|solid| solid.path.is_some())
    }

    /// The subject with its obstacles at rest at their places after `t` seconds.
    pub fn at(&self, t: f64) -> Cow<'_, Self> {
        if !self.moves() {
            return Cow::Borrowed(self);
        }
        let mut subject = self.clone();
        for solid in &mut subject.solids {
            let Some(path) = solid.path.take() else { continue };
            let softened = solid.softened.iter_mut().flat_map(|(points, _)| points);
            solid.points.iter_mut().chain(softened).for_each(|x| *x += path.offset(t));
        }
        Cow::Owned(subject)
    }

    /// The points, m, that a picture of the cloth at positions `x`, m, must show: the cloth, and
    /// obstacles that are not much larger than it. Leaves out positions that are not finite.
    pub fn points(&self, x: &[Vec3]) -> Vec<Vec3> {
        let is_finite = |x: &&Vec3| x.iter().all(|c| c.is_finite());
        let mut points: Vec<Vec3> = x.iter().filter(is_finite).copied().collect();
        let size = |points: &[Vec3]| {
            let (low, high) = bounds(points);
            (high - low).norm()
        };
        let most = LARGEST * size(&points);
        for solid in &self.solids {
            if !solid.is_endless && size(&solid.points) <= most {
                points.extend(&solid.points);
            }
        }
        points
    }
}

/// Triangles and lines of a grid of points, row by row.
pub(crate) fn grid(rows: u32, columns: u32) -> (Vec<[u32; 3]>, Vec<[u32; 2]>) {
    let (mut triangles, mut lines) = (Vec::new(), Vec::new());
    for row in 0..rows {
        for column in 0..columns {
            let a = row * columns + column;
            let (right, below) = (column + 1 < columns, row + 1 < rows);
            if right {
                lines.push([a, a + 1]);
            }
            if below {
                lines.push([a, a + columns]);
            }
            if right && below {
                let [b, c, d] = [a + 1, a + columns, a + columns + 1];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    (triangles, lines)
}

/// The corners of the box around points.
pub(crate) fn bounds(x: &[Vec3]) -> (Vec3, Vec3) {
    let first = x.first().copied().unwrap_or_else(Vec3::zeros);
    x.iter().fold((first, first), |(low, high), x| (low.inf(x), high.sup(x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_shows_the_triangles_of_the_scene_and_its_warp_and_weft() {
        let input = drape_model::load("hanging-textile-sheared-1e4").expect("valid");
        let spec = input.spec();
        let (_, state) = spec.build().expect("valid");
        let (mut of_spec, of_grid) =
            (Subject::new(spec, &[]), Subject::grid(20, 20, &[], &state.x));
        assert_eq!(of_spec.triangles, of_grid.triangles);
        let mut lines = of_grid.lines.clone();
        lines.sort_unstable();
        of_spec.lines.sort_unstable();
        assert_eq!(of_spec.lines, lines, "no shear spring, no diagonal");
    }

    #[test]
    fn a_moving_obstacle_is_where_it_is_at_the_time() {
        let text = r#"{ "format": "drape-system/1",
            "particles": { "mass_kg": [1, 1], "position_m": [[0, 0, 0], [1, 0, 0]] },
            "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
                "stiffness_n_per_m": 1 }],
            "obstacles": [{ "box": { "center_m": [0, 0, -1], "size_m": [1, 1, 1],
                "path": [{ "time_s": 2, "offset_m": [0, 4, 2] }] } },
                { "sphere": { "center_m": [0, 0, -1], "radius_m": 0.5 } }] }"#;
        let input = drape_model::parse("text", text).expect("valid");
        let (system, _) = input.spec().build().expect("valid");
        let subject = Subject::new(input.spec(), system.obstacles());
        let later = subject.at(1.0);
        let offset = Vec3::new(0.0, 2.0, 1.0);
        let [cube, ball] = [0, 1].map(|n| (&subject.solids[n], &later.solids[n]));
        for (x, moved) in cube.0.points.iter().zip(&cube.1.points) {
            assert_eq!(x + offset, *moved);
        }
        let softened = |solid: &Solid| solid.softened.as_ref().map(|(x, _)| x[0]).expect("a box");
        assert_eq!(softened(cube.0) + offset, softened(cube.1));
        assert_eq!(ball.0, ball.1);
        let obstacles = [Obstacle { path: None, ..system.obstacles()[0].clone() }];
        let still = Subject::new(input.spec(), &obstacles);
        assert!(subject.moves() && !still.moves());
        assert!(matches!(still.at(1.0), Cow::Borrowed(_)));
    }
}
