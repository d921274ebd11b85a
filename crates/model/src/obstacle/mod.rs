//! Rigid obstacles: signed distance and outward normal.

mod mesh;
#[cfg(test)]
mod mesh_tests;
mod shells;
mod spec;

pub use mesh::ClosedMesh;
use mesh::MAX_TRIANGLES;
pub use spec::ObstacleSpec;

use crate::{Path, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The surface of an obstacle. The solid lies where the signed distance is negative.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Half-space below the plane through `point` with unit normal `normal`.
    Plane {
        /// A point of the plane, m.
        point: Vec3,
        /// Outward unit normal.
        normal: Vec3,
    },
    /// Box with edges along the axes.
    Box {
        /// Centre, m.
        center: Vec3,
        /// Half the edge lengths, m.
        half_extents: Vec3,
    },
    /// Ball.
    Sphere {
        /// Centre, m.
        center: Vec3,
        /// Radius, m.
        radius: f64,
    },
    /// Solid bounded by triangles.
    Mesh(Arc<ClosedMesh>),
}

impl Shape {
    /// Name of the shape in a file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Plane { .. } => "plane",
            Self::Box { .. } => "box",
            Self::Sphere { .. } => "sphere",
            Self::Mesh(_) => "mesh",
        }
    }
}

/// A rigid obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Surface at time 0.
    pub shape: Shape,
    /// Coefficient of restitution in [0, 1]: normal speed after over normal speed before.
    pub restitution: f64,
    /// Coefficient of Coulomb friction, at least 0.
    pub friction: f64,
    /// Path, if the obstacle moves.
    pub path: Option<Path>,
}

impl From<Shape> for Obstacle {
    /// At rest, without restitution or friction.
    fn from(shape: Shape) -> Self {
        Self { shape, restitution: 0.0, friction: 0.0, path: None }
    }
}

/// When a contact between a particle and an obstacle becomes active.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Detection {
    /// When the particle is inside the obstacle: `φ(x_n) < 0` (EEH section 6).
    #[default]
    Penetration,
    /// When the particle would be inside after a step at its present velocity:
    /// `φ(x_n) + h n·v_n < 0`.
    Speculative,
}

impl Obstacle {
    /// Signed distance `φ`, m (negative inside), and outward unit normal `∇φ` at `x`, with the
    /// obstacle at its starting place. For an obstacle displaced by `d`, its
    /// [`offset`](Self::offset), pass `x − d`.
    ///
    /// Where the normal is not unique (the centre of a ball, the ridges inside a box), the function
    /// returns one of the candidates; it prefers the upward one (+z).
    ///
    /// ```
    /// use drape_model::{Obstacle, Shape, Vec3};
    /// let ball = Obstacle::from(Shape::Sphere { center: Vec3::zeros(), radius: 2.0 });
    /// assert_eq!(ball.distance(&Vec3::new(0.0, 3.0, 0.0)), (1.0, Vec3::y()));
    /// ```
    pub fn distance(&self, x: &Vec3) -> (f64, Vec3) {
        match &self.shape {
            Shape::Plane { point, normal } => (normal.dot(&(x - point)), *normal),
            Shape::Sphere { center, radius } => {
                let r = x - center;
                let length = r.norm();
                let normal = if length > 0.0 { r / length } else { Vec3::z() };
                (length - radius, normal)
            }
            Shape::Box { center, half_extents } => box_distance(&(x - center), half_extents),
            Shape::Mesh(mesh) => mesh.distance(x),
        }
    }

    /// Least extent of the obstacle, m; infinite for a plane, which has no other side. A particle
    /// that moves farther in one step may pass through the obstacle undetected. For a mesh this is
    /// the least extent of its bounding box, an upper bound.
    pub fn thickness(&self) -> f64 {
        match &self.shape {
            Shape::Plane { .. } => f64::INFINITY,
            Shape::Sphere { radius, .. } => 2.0 * radius,
            Shape::Box { half_extents, .. } => 2.0 * half_extents.min(),
            Shape::Mesh(mesh) => {
                let (low, high) = bounding_box(mesh.vertices());
                (high - low).min()
            }
        }
    }

    /// Centre and radius, m, of a ball around the obstacle at its starting place; `None` for a
    /// plane.
    pub fn bounding_ball(&self) -> Option<(Vec3, f64)> {
        match &self.shape {
            Shape::Plane { .. } => None,
            Shape::Sphere { center, radius } => Some((*center, *radius)),
            Shape::Box { center, half_extents } => Some((*center, half_extents.norm())),
            Shape::Mesh(mesh) => {
                let (low, high) = bounding_box(mesh.vertices());
                Some(((low + high) * 0.5, 0.5 * (high - low).norm()))
            }
        }
    }

    /// Displacement from the starting place at `t` seconds, m; 0 without a path.
    pub fn offset(&self, t: f64) -> Vec3 {
        self.path.as_ref().map_or(Vec3::zeros(), |path| path.offset(t))
    }

    /// [`distance`](Self::distance), or `None` if a quick test shows that it is at least `reach`,
    /// m. Only a mesh, whose distance is costly, is tested, by its bounding box.
    pub fn distance_within(&self, x: &Vec3, reach: f64) -> Option<(f64, Vec3)> {
        match &self.shape {
            Shape::Mesh(mesh) if !mesh.is_near(x, reach) => None,
            _ => Some(self.distance(x)),
        }
    }
}

fn bounding_box(points: &[Vec3]) -> (Vec3, Vec3) {
    let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    points.iter().fold(none, |(low, high), x| (low.inf(x), high.sup(x)))
}

fn box_distance(r: &Vec3, half: &Vec3) -> (f64, Vec3) {
    let q = r.abs() - half;
    let outside = q.sup(&Vec3::zeros());
    let distance = outside.norm();
    if distance > 0.0 {
        let normal = Vec3::from_fn(|axis, _| outside[axis].copysign(r[axis])) / distance;
        return (distance, normal);
    }
    // Inside: the nearest face; on a tie the later axis, so that the top of a table wins.
    let mut nearest = 0;
    for axis in 1..3 {
        if q[axis] >= q[nearest] {
            nearest = axis;
        }
    }
    let mut normal = Vec3::zeros();
    normal[nearest] = 1.0_f64.copysign(r[nearest]);
    (q[nearest], normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_gradient(obstacle: &Obstacle, x: Vec3) {
        let (_, normal) = obstacle.distance(&x);
        assert!((normal.norm() - 1.0).abs() < 1e-12);
        for axis in 0..3 {
            let mut step = Vec3::zeros();
            step[axis] = 1e-6;
            let slope =
                (obstacle.distance(&(x + step)).0 - obstacle.distance(&(x - step)).0) / 2e-6;
            assert!((slope - normal[axis]).abs() < 1e-6, "{obstacle:?} at {x:?}: {slope}");
        }
    }

    #[test]
    fn normals_are_the_gradients_of_the_distances() {
        let shapes = [
            Shape::Plane { point: Vec3::new(0.0, 0.1, 0.2), normal: Vec3::new(0.6, 0.0, 0.8) },
            Shape::Box {
                center: Vec3::new(0.1, 0.0, -0.2),
                half_extents: Vec3::new(0.5, 0.3, 0.4),
            },
            Shape::Sphere { center: Vec3::new(0.3, 0.2, 0.1), radius: 0.7 },
        ];
        let points = [(0.2, 0.11, 0.05), (0.9, 0.7, 0.8), (-0.3, 1.0, 0.1), (0.57, 0.03, -0.3)];
        for shape in shapes {
            for (a, b, c) in points {
                check_gradient(&Obstacle::from(shape.clone()), Vec3::new(a, b, c));
            }
        }
    }

    #[test]
    fn thickness_is_the_least_extent() {
        let half_extents = Vec3::new(1.0, 0.2, 0.5);
        let table = Obstacle::from(Shape::Box { center: Vec3::x(), half_extents });
        assert_eq!(table.thickness(), 0.4);
        assert_eq!(table.bounding_ball(), Some((Vec3::x(), half_extents.norm())));
        let ball = Obstacle::from(Shape::Sphere { center: Vec3::y(), radius: 0.3 });
        assert_eq!((ball.thickness(), ball.bounding_ball()), (0.6, Some((Vec3::y(), 0.3))));
        let plane = Obstacle::from(Shape::Plane { point: Vec3::zeros(), normal: Vec3::z() });
        assert_eq!((plane.thickness(), plane.bounding_ball()), (f64::INFINITY, None));
    }

    #[test]
    fn the_inside_of_a_box_is_negative_and_points_to_the_nearest_face() {
        let half_extents = Vec3::new(1.0, 1.0, 0.5);
        let table = Obstacle::from(Shape::Box { center: Vec3::zeros(), half_extents });
        assert_eq!(table.distance(&Vec3::new(0.2, 0.0, 0.4)), (-0.09999999999999998, Vec3::z()));
        assert_eq!(table.distance(&Vec3::zeros()), (-0.5, Vec3::z()));
        // Of faces equally near the later axis wins.
        let half_extents = Vec3::repeat(1.0);
        let cube = Obstacle::from(Shape::Box { center: Vec3::zeros(), half_extents });
        assert_eq!(cube.distance(&Vec3::repeat(0.5)), (-0.5, Vec3::z()));
        assert_eq!(cube.distance(&Vec3::new(0.5, 0.5, 0.0)), (-0.5, Vec3::y()));
    }
}
