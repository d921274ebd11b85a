//! Obstacles as data.

use super::{ClosedMesh, MAX_TRIANGLES, Obstacle, Shape};
use crate::bounds::{Length, MAX_COORDINATE, direction, is_zero, positive, vector, within};
use crate::error::Violation;
use crate::path::{Extent, MAX_KEYFRAMES, in_range, offset_of, rest_of};
use crate::{KeyframeSpec, Path, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Greatest coefficient of friction.
const MAX_FRICTION: f64 = 100.0;

/// Adds to each shape the keys that all of them have.
macro_rules! obstacles {
    ($($(#[$about:meta])* $name:literal $Shape:ident {
        $($(#[$field:meta])* $key:ident: $Value:ty,)+
    })+) => {
        /// A rigid obstacle, at rest or on a path.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case", deny_unknown_fields)]
        pub enum ObstacleSpec {
            $(
                $(#[$about])*
                $Shape {
                    $($(#[$field])* $key: $Value,)+
                    /// Coefficient of restitution, 0 to 1.
                    #[serde(default)]
                    #[schemars(range(min = 0.0, max = 1.0))]
                    restitution: f64,
                    /// Coefficient of Coulomb friction; 0 if absent.
                    #[serde(default, skip_serializing_if = "is_zero")]
                    #[schemars(range(min = 0.0, max = MAX_FRICTION))]
                    friction: f64,
                    /// Path, as displacements from the starting place. Without keyframes the
                    /// obstacle rests.
                    #[serde(default, skip_serializing_if = "Vec::is_empty")]
                    #[schemars(length(max = MAX_KEYFRAMES))]
                    path: Vec<KeyframeSpec>,
                },
            )+
        }

        impl ObstacleSpec {
            /// Its name in a file, restitution, friction and path.
            fn common(&self) -> (&'static str, f64, f64, &[KeyframeSpec]) {
                match self {
                    $(Self::$Shape { restitution, friction, path, .. } => {
                        ($name, *restitution, *friction, path)
                    })+
                }
            }
        }
    };
}

obstacles! {
    /// Half-space below a plane.
    "plane" Plane {
        /// A point of the plane, m.
        #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
        point_m: [f64; 3],
        /// Outward normal; any vector but 0.
        #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
        normal: [f64; 3],
    }
    /// Box with edges along the axes.
    "box" Box {
        /// Centre, m.
        #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
        center_m: [f64; 3],
        /// Edge lengths, m.
        #[schemars(with = "[Length; 3]")]
        size_m: [f64; 3],
    }
    /// Ball.
    "sphere" Sphere {
        /// Centre, m.
        #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
        center_m: [f64; 3],
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COORDINATE))]
        radius_m: f64,
    }
    /// Solid bounded by a closed triangle mesh.
    "mesh" Mesh {
        /// Vertices, m.
        #[schemars(inner(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE))))]
        vertices_m: Vec<[f64; 3]>,
        /// Triangles as vertex indices, counter-clockwise seen from outside.
        #[schemars(length(min = 4, max = MAX_TRIANGLES), inner(inner(range(max = u32::MAX))))]
        triangles: Vec<[u32; 3]>,
    }
}

impl ObstacleSpec {
    /// A plane at rest, without friction, given by a point, m, an outward normal and a coefficient
    /// of restitution.
    pub const fn plane(point_m: [f64; 3], normal: [f64; 3], restitution: f64) -> Self {
        Self::Plane { point_m, normal, restitution, friction: 0.0, path: Vec::new() }
    }

    /// A box at rest, without friction, given by centre and edge lengths, m, and a coefficient of
    /// restitution.
    pub const fn cuboid(center_m: [f64; 3], size_m: [f64; 3], restitution: f64) -> Self {
        Self::Box { center_m, size_m, restitution, friction: 0.0, path: Vec::new() }
    }

    /// A ball at rest, without friction, given by centre and radius, m, and a coefficient of
    /// restitution.
    pub const fn sphere(center_m: [f64; 3], radius_m: f64, restitution: f64) -> Self {
        Self::Sphere { center_m, radius_m, restitution, friction: 0.0, path: Vec::new() }
    }

    /// The points, m, that a displacement moves.
    fn places(&self) -> &[[f64; 3]] {
        match self {
            Self::Plane { point_m: place, .. }
            | Self::Box { center_m: place, .. }
            | Self::Sphere { center_m: place, .. } => std::slice::from_ref(place),
            Self::Mesh { vertices_m, .. } => vertices_m,
        }
    }

    /// Moves it to its place at `t` seconds and keeps the rest of its path.
    pub(crate) fn advance(&mut self, t: f64) {
        let (places, path) = match self {
            Self::Plane { point_m: place, path, .. }
            | Self::Box { center_m: place, path, .. }
            | Self::Sphere { center_m: place, path, .. } => (std::slice::from_mut(place), path),
            Self::Mesh { vertices_m, path, .. } => (&mut vertices_m[..], path),
        };
        if !path.is_empty() {
            let offset = offset_of(path, t);
            for place in places {
                *place = in_range(Vec3::from(*place) + offset).into();
            }
            *path = rest_of(path, t);
        }
    }

    /// Checks every value, for the obstacle at `position` of the list.
    pub(crate) fn check(&self, position: usize) -> Result<Obstacle, Violation> {
        let (name, restitution, friction, frames) = self.common();
        let path = |key: &str| format!("obstacles[{position}].{name}.{key}");
        let shape = match self {
            Self::Plane { point_m, normal, .. } => {
                let normal = direction(path("normal"), *normal)?;
                Shape::Plane { point: vector(path("point_m"), *point_m)?, normal }
            }
            Self::Box { center_m, size_m, .. } => {
                for (axis, &edge) in size_m.iter().enumerate() {
                    positive(path(&format!("size_m[{axis}]")), edge, MAX_COORDINATE)?;
                }
                let center = vector(path("center_m"), *center_m)?;
                Shape::Box { center, half_extents: Vec3::from(*size_m) * 0.5 }
            }
            Self::Sphere { center_m, radius_m, .. } => {
                let radius = positive(path("radius_m"), *radius_m, MAX_COORDINATE)?;
                Shape::Sphere { center: vector(path("center_m"), *center_m)?, radius }
            }
            Self::Mesh { vertices_m, triangles, .. } => {
                let vertices = vertices_m.iter().enumerate();
                let vertices = vertices
                    .map(|(k, &at)| vector(path(&format!("vertices_m[{k}]")), at))
                    .collect::<Result<Vec<_>, _>>()?;
                let at = format!("obstacles[{position}].{name}");
                Shape::Mesh(Arc::new(ClosedMesh::check(&at, vertices, triangles)?))
            }
        };
        let restitution = within(path("restitution"), restitution, 0.0, 1.0)?;
        let friction = within(path("friction"), friction, 0.0, MAX_FRICTION)?;
        let led = Extent::of(self.places().iter().map(|&place| Vec3::from(place)));
        let motion = Path::check(&path("path"), frames, led)?;
        Ok(Obstacle { shape, restitution, friction, path: motion })
    }
}
