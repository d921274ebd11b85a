//! Cloth that is no grid: triangle meshes and random meshes, as particles and springs.

use super::scenes::hanging;
use crate::HarnessError;
use crate::studies::sheet::{GRAVITY, MASS};
use drape_model::{
    DampingLaw, EffectsSpec, GravitySpec, ParticlesSpec, PinSpec, SpringEffect, SpringSpec,
    SystemSpec,
};
use drape_oracle::Random;
use std::collections::BTreeSet;

/// How the particles of a hanging sheet of 1 m × 1 m are connected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mesh {
    /// Warp and weft: four neighbours.
    Grid,
    /// Rows of equilateral triangles: six neighbours.
    Triangles,
    /// The Delaunay triangulation of random points, numbered in the order in which they were drawn.
    Random(u64),
}

type Point = [f64; 2];
type Triangle = [usize; 3];

impl Mesh {
    /// Its name in prose.
    pub(super) fn name(self) -> String {
        match self {
            Self::Grid => "grid".to_owned(),
            Self::Triangles => "triangles".to_owned(),
            Self::Random(seed) => format!("random mesh {seed}"),
        }
    }

    /// About `side²` particles that hang by two corners; stiffness and damping of all springs over
    /// the mean mass, 1/s² and 1/s. The mass is 1 g a particle on the mean, by area on a random
    /// mesh.
    pub(super) fn hanging(
        self,
        side: u32,
        tension: f64,
        damping: f64,
    ) -> Result<SystemSpec, HarnessError> {
        let (points, triangles) = match self {
            Self::Grid => return hanging(side, tension, damping).spec(),
            Self::Triangles => rows_of_triangles(side as usize),
            Self::Random(seed) => {
                let points = random_points(side as usize, &mut Random::new(seed));
                let triangles = delaunay(&points);
                (points, triangles)
            }
        };
        let mut mass = vec![MASS; points.len()];
        if matches!(self, Self::Random(_)) {
            let all: f64 = triangles.iter().map(|t| area(&points, t)).sum();
            let density = MASS * points.len() as f64 / all;
            mass.fill(0.0);
            for triangle in &triangles {
                triangle.iter().for_each(|&i| mass[i] += density * area(&points, triangle) / 3.0);
            }
        }
        Ok(cloth(&points, mass, &triangles, tension * MASS, damping * MASS))
    }
}

/// The sheet with a spring along each edge of the triangles, at rest, pinned at the two corners
/// with the least y.
fn cloth(
    points: &[Point],
    mass: Vec<f64>,
    triangles: &[Triangle],
    stiffness: f64,
    damping: f64,
) -> SystemSpec {
    let edges: BTreeSet<_> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    let spring = |&(i, j): &(usize, usize)| SpringSpec {
        effect: SpringEffect::Tension,
        i: i as u32,
        j: j as u32,
        rest_length_m: distance(points[i], points[j]),
        stiffness_n_per_m: stiffness,
        damping_n_s_per_m: damping,
        ..SpringSpec::default()
    };
    let corner = |x: f64| {
        let off = |i: &usize| distance(points[*i], [x, -0.5]);
        let nearest = (0..points.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
        PinSpec::still(nearest.unwrap_or_default() as u32)
    };
    SystemSpec {
        format: "drape-system/1".to_owned(),
        name: "mesh".to_owned(),
        particles: ParticlesSpec {
            mass_kg: mass,
            position_m: points.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
            velocity_m_s: Vec::new(),
        },
        springs: edges.iter().map(spring).collect(),
        angles: Vec::new(),
        hinges: Vec::new(),
        damping: DampingLaw::Full,
        triangles: triangles.iter().map(|t| t.map(|i| i as u32)).collect(),
        pins: vec![corner(-0.5), corner(0.5)],
        effects: EffectsSpec {
            gravity: Some(GravitySpec { m_s2: GRAVITY }),
            ..EffectsSpec::default()
        },
        obstacles: Vec::new(),
    }
}

fn distance(a: Point, b: Point) -> f64 {
    ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt()
}

/// Rows of equilateral triangles; every other row is shifted by half a mesh width.
fn rows_of_triangles(side: usize) -> (Vec<Point>, Vec<Triangle>) {
    let width = 1.0 / (side as f64 - 0.5);
    let height = 0.5 * 3.0_f64.sqrt() * width;
    let rows = (1.0 / height).round() as usize + 1;
    let mut points = Vec::new();
    for row in 0..rows {
        for column in 0..side {
            let x = (column as f64 + 0.5 * (row % 2) as f64) * width - 0.5;
            points.push([x, row as f64 * height - 0.5]);
        }
    }
    let mut triangles = Vec::new();
    for row in 0..rows - 1 {
        for column in 0..side - 1 {
            let (a, c) = (row * side + column, (row + 1) * side + column);
            let halves = if row % 2 == 0 {
                [[a, a + 1, c], [a + 1, c + 1, c]]
            } else {
                [[a, a + 1, c + 1], [a, c + 1, c]]
            };
            triangles.extend(halves);
        }
    }
    (points, triangles)
}

/// The corners and edges of the square at even distances, the inside at random, no two nearer than
/// 0.7 mesh widths.
fn random_points(side: usize, random: &mut Random) -> Vec<Point> {
    let last = side - 1;
    let width = 1.0 / last as f64;
    let on_edge = |i: usize| i as f64 * width - 0.5;
    let mut points = vec![[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]];
    for i in 1..last {
        let x = on_edge(i);
        points.extend([[x, -0.5], [x, 0.5], [-0.5, x], [0.5, x]]);
    }
    // A square of this many points is not yet full; the bound on the draws only makes sure of an
    // end.
    for _ in 0..1000 * side * side {
        if points.len() == side * side {
            break;
        }
        let point = [random.between(-0.5, 0.5), random.between(-0.5, 0.5)];
        if points.iter().all(|&other| distance(point, other) > 0.7 * width) {
            points.push(point);
        }
    }
    // Those of the rim last: many of them lie on common circles, which the random ones break up.
    points.rotate_left(4 * last);
    points
}

/// Twice the area of `a`, `b`, `c`, positive if they turn left.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn area(points: &[Point], &[a, b, c]: &Triangle) -> f64 {
    0.5 * turn(points[a], points[b], points[c]).abs()
}

/// Whether `p` lies inside the circle through the corners of a triangle that turns left.
fn is_inside([a, b, c]: [Point; 3], p: Point) -> bool {
    let [a, b, c] = [a, b, c].map(|q| {
        let (x, y) = (q[0] - p[0], q[1] - p[1]);
        [x, y, x * x + y * y]
    });
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    a[0] * minor(1, 2) - a[1] * minor(0, 2) + a[2] * minor(0, 1) > 0.0
}

/// Delaunay triangulation of points in the unit square around the origin, by Bowyer and Watson:
/// each point replaces the triangles whose circles it lies in by a fan.
fn delaunay(points: &[Point]) -> Vec<Triangle> {
    let n = points.len();
    let mut all = points.to_vec();
    all.extend([[-100.0, -90.0], [110.0, -80.0], [-5.0, 120.0]]);
    let mut triangles = vec![[n, n + 1, n + 2]];
    for p in 0..n {
        let (hit, kept): (Vec<_>, Vec<_>) =
            triangles.into_iter().partition(|t: &Triangle| is_inside(t.map(|i| all[i]), all[p]));
        triangles = kept;
        let edges = |&[a, b, c]: &Triangle| [(a, b), (b, c), (c, a)];
        let cavity: Vec<_> = hit.iter().flat_map(edges).collect();
        let rim = cavity.iter().filter(|(a, b)| !cavity.contains(&(*b, *a)));
        triangles.extend(rim.map(|&(a, b)| [a, b, p]));
    }
    triangles.retain(|t| t.iter().all(|&i| i < n));
    triangles
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn a_random_mesh_is_the_delaunay_triangulation_of_the_square() {
        for seed in 1..4 {
            let points = random_points(12, &mut Random::new(seed));
            let triangles = delaunay(&points);
            assert_eq!(points.len(), 144);
            // Euler: t = 2n − 2 − (points on the rim).
            assert_eq!(triangles.len(), 2 * 144 - 2 - 44);
            let all: f64 = triangles.iter().map(|t| area(&points, t)).sum();
            assert!((all - 1.0).abs() < 1e-12, "{all}");
            for t in &triangles {
                let [a, b, c] = t.map(|i| points[i]);
                assert!(turn(a, b, c) > 0.0);
                let inside =
                    (0..144).filter(|i| !t.contains(i) && is_inside([a, b, c], points[*i]));
                assert_eq!(inside.count(), 0);
            }
        }
    }

    #[test]
    fn meshes_have_the_mass_the_pins_and_the_valence_that_they_should() {
        for (mesh, valence) in [(Mesh::Grid, 4.0), (Mesh::Triangles, 6.0), (Mesh::Random(1), 6.0)] {
            let spec = mesh.hanging(12, 1e4, 40.0).unwrap();
            let n = spec.particles.mass_kg.len() as f64;
            let mass: f64 = spec.particles.mass_kg.iter().sum();
            assert!((mass / n / MASS - 1.0).abs() < 1e-12, "{mesh:?}");
            let mean = 2.0 * spec.springs.len() as f64 / n;
            assert!(mean < valence && mean > 0.85 * valence, "{mesh:?}: {mean}");
            assert_eq!(spec.pins.len(), 2);
            assert_ne!(spec.pins[0], spec.pins[1]);
            let free = super::super::runs::free_edge(&spec);
            assert!(spec.particles.position_m[free][1] > 0.45, "{mesh:?}");
            let (_, state) = spec.build().unwrap();
            assert!(state.is_finite());
        }
    }
}
