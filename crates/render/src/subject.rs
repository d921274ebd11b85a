//! What a scene shows besides positions: triangles, lines, obstacles.

use crate::surface::{area_normal, edges};
use drape_model::{ClosedMesh, Obstacle, Path, Shape, SpringEffect, SystemSpec, Vec3};
use std::borrow::Cow;

/// Cells of a sphere's surface around its axis; half as many from pole to pole.
const AROUND: u32 = 64;
/// Cells of the tile along each side that stands for a plane.
const TILES: u32 = 10;
/// Radius of the edges of a box in pictures over the length of a typical line on the cloth: the least that hides the edge
/// below a line that bends over it is 1.21.
const SOFTNESS: f64 = 1.3;
/// Depth by which meshes are smaller in pictures over the length of a typical line on the cloth: a line over a sharp edge
/// cuts in by 0.354 of its length, and some lines are longer than most.
const DEPTH: f64 = 0.36;
/// Least cosine between the normal of a corner and that of a face by which a corner is moved farther than the face.
const STEEPEST: f64 = 0.5;
/// Tries of half the depth each where a mesh is thin.
const HALVINGS: usize = 6;
/// Cells of a softened face along each side.
const FACE: u32 = 40;
/// Side of that tile over the size of the scene.
const TILE: f64 = 1.6;

/// Size of an obstacle, over that of the cloth, up to which a picture shows it whole.
const LARGEST: f64 = 4.0;

/// The surface of an obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// What it is called in files: `plane`, `box`, `sphere`, with its number.
    pub name: String,
    /// Corners at the start, m.
    pub points: Vec<Vec3>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Lines that are drawn: the edges of a box, the squares of a plane.
    pub lines: Vec<[u32; 2]>,
    /// The surface of pictures, where it is another one, so that a cloth of straight pieces that bends over an edge does not
    /// cut through it: boxes have round edges there, within the true box, meshes are smaller by some depth. Points, m, and
    /// triangles.
    pub softened: Option<(Vec<Vec3>, Vec<[u32; 3]>)>,
    /// Whether it stands for something without an end, which a camera need not show whole.
    pub is_endless: bool,
    /// How it moves, if it does.
    pub path: Option<Path>,
}

/// What a scene shows besides positions.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// Triangles of the cloth, as indices of particles.
    pub triangles: Vec<[u32; 3]>,
    /// Lines on the cloth: its tension springs, or all edges where there are none; without triangles all springs.
    pub lines: Vec<[u32; 2]>,
    /// The obstacles, where they start.
    pub solids: Vec<Solid>,
}

impl Subject {
    /// What a system with these obstacles shows.
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
        Self { triangles: spec.triangles.clone(), lines, solids }
    }

    /// What a sheet of rows and columns of particles shows, row by row; `x` are positions at any time, m.
    pub fn grid(rows: u32, columns: u32, obstacles: &[Obstacle], x: &[Vec3]) -> Self {
        let (triangles, lines) = grid(rows, columns);
        let solids = solids(obstacles, x, &lines);
        Self { triangles, lines, solids }
    }

    /// Whether an obstacle moves.
    pub fn moves(&self) -> bool {
        self.solids.iter().any(|solid| solid.path.is_some())
    }

    /// As it is at `t` seconds: with the obstacles where they are then, at rest.
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

    /// The points that a picture of the cloth at positions `x`, m, must show: the cloth, and the obstacles that are not much
    /// larger than it. Particles that are nowhere are left out.
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
fn grid(rows: u32, columns: u32) -> (Vec<[u32; 3]>, Vec<[u32; 2]>) {
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

/// The surfaces of obstacles around a cloth.
fn solids(obstacles: &[Obstacle], cloth: &[Vec3], lines: &[[u32; 2]]) -> Vec<Solid> {
    let softness = SOFTNESS * typical_length(cloth, lines);
    let all = obstacles.iter().enumerate();
    all.map(|(number, obstacle)| Solid {
        path: obstacle.path.clone(),
        ..solid(obstacle, number, cloth, softness)
    })
    .collect()
}

/// Length of the line that is in the middle of all, m.
fn typical_length(x: &[Vec3], lines: &[[u32; 2]]) -> f64 {
    let length = |[a, b]: &[u32; 2]| Some((x.get(*a as usize)? - x.get(*b as usize)?).norm());
    let lengths = lines.iter().filter_map(length).filter(|length| length.is_finite());
    let mut lengths: Vec<f64> = lengths.collect();
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied().unwrap_or(0.0)
}

fn solid(obstacle: &Obstacle, number: usize, cloth: &[Vec3], softness: f64) -> Solid {
    let named = |kind: &str| format!("{kind}-{number}");
    match &obstacle.shape {
        &Shape::Plane { point, normal } => {
            let (low, high) = bounds(cloth);
            let size = (high - low).norm();
            let size = if size > 0.0 && size.is_finite() { size } else { 1.0 };
            let middle = (low + high) * 0.5;
            let middle = middle - normal * normal.dot(&(middle - point));
            // A direction within the plane, along x where that is possible.
            let along = if normal.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
            let along = (along - normal * normal.dot(&along)).normalize();
            let across = normal.cross(&along);
            let side = f64::from(TILES);
            let at = |n: u32| (f64::from(n) / side - 0.5) * TILE * size;
            let points = (0..=TILES)
                .flat_map(|row| (0..=TILES).map(move |column| (row, column)))
                .map(|(row, column)| middle + across * at(row) + along * at(column))
                .collect();
            let (triangles, lines) = grid(TILES + 1, TILES + 1);
            Solid {
                name: named("plane"),
                points,
                triangles,
                lines,
                softened: None,
                is_endless: true,
                path: None,
            }
        }
        &Shape::Box { center, half_extents } => {
            let corner = |n: u32| {
                let sign = |bit: u32| if n & bit == 0 { -1.0 } else { 1.0 };
                center + half_extents.component_mul(&Vec3::new(sign(1), sign(2), sign(4)))
            };
            let faces = [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ];
            let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
            let lines = (0..8_u32)
                .flat_map(|a| [1, 2, 4].map(|bit| [a, a | bit]))
                .filter(|[a, b]| a != b)
                .collect();
            let points = (0..8).map(corner).collect();
            let softened = Some(rounded_box(center, half_extents, softness));
            Solid {
                name: named("box"),
                points,
                triangles,
                lines,
                softened,
                is_endless: false,
                path: None,
            }
        }
        Shape::Mesh(mesh) => Solid {
            name: named("mesh"),
            points: mesh.vertices().to_vec(),
            triangles: mesh.triangles().to_vec(),
            lines: Vec::new(),
            softened: Some((
                shrunk(obstacle, mesh, DEPTH / SOFTNESS * softness),
                mesh.triangles().to_vec(),
            )),
            is_endless: false,
            path: None,
        },
        &Shape::Sphere { center, radius } => {
            let (points, triangles) = sphere(center, radius);
            Solid {
                name: named("sphere"),
                points,
                triangles,
                lines: Vec::new(),
                softened: None,
                is_endless: false,
                path: None,
            }
        }
    }
}

/// Unit normals of the points of a mesh, weighted by the angles around them: those of a corner of a box are the same to all
/// three faces, however they are divided.
fn normals_by_angle(x: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); x.len()];
    for &triangle in triangles {
        let [a, b, c] = triangle;
        let Some(face) = area_normal(x, triangle).try_normalize(0.0) else { continue };
        for [i, j, k] in [[a, b, c], [b, c, a], [c, a, b]].map(|t| t.map(|i| i as usize)) {
            let (u, v) = (x[j] - x[i], x[k] - x[i]);
            normals[i] += face * libm::atan2(u.cross(&v).norm(), u.dot(&v));
        }
    }
    normals.iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vec3::z)).collect()
}

/// The corners of a mesh, moved so that its faces lie `depth` m within it; less where it is thinner than twice that.
fn shrunk(obstacle: &Obstacle, mesh: &ClosedMesh, depth: f64) -> Vec<Vec3> {
    let (x, triangles) = (mesh.vertices(), mesh.triangles());
    let outward = normals_by_angle(x, triangles);
    // The least cosine of the angles with the faces around: a corner moves farther than they do.
    let mut cosines = vec![1.0_f64; x.len()];
    for &triangle in triangles {
        let face = area_normal(x, triangle);
        for i in triangle.map(|i| i as usize).into_iter().filter(|_| face.norm() > 0.0) {
            cosines[i] = cosines[i].min(outward[i].dot(&face) / face.norm());
        }
    }
    let corner = |((x, outward), cosine): ((&Vec3, &Vec3), &f64)| {
        let mut way = depth / cosine.max(STEEPEST);
        for _ in 0..HALVINGS {
            // There must be as much behind.
            if obstacle.distance(&(x - outward * (3.0 * way))).0 <= -way * cosine.max(STEEPEST) {
                return x - outward * way;
            }
            way *= 0.5;
        }
        *x
    };
    x.iter().zip(&outward).zip(&cosines).map(corner).collect()
}

/// A box whose edges and corners are round, within the box.
fn rounded_box(center: Vec3, half_extents: Vec3, radius: f64) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let radius = radius.min(0.4 * half_extents.min());
    let core = half_extents - Vec3::repeat(radius);
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let (face, _) = grid(FACE + 1, FACE + 1);
    // More cells where the edge is round.
    let at = |n: u32| libm::sin((f64::from(n) / f64::from(FACE) - 0.5) * std::f64::consts::PI);
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let first = points.len() as u32;
            for (row, column) in (0..=FACE).flat_map(|row| (0..=FACE).map(move |c| (row, c))) {
                let mut r = Vec3::zeros();
                r[axis] = sign;
                r[(axis + 1) % 3] = at(column) * sign;
                r[(axis + 2) % 3] = at(row);
                let r = r.component_mul(&half_extents);
                let inner = r.sup(&-core).inf(&core);
                let out = r - inner;
                let length = out.norm();
                let out = if length > 0.0 { out * (radius / length) } else { out };
                points.push(center + inner + out);
            }
            triangles.extend(face.iter().map(|triangle| triangle.map(|i| first + i)));
        }
    }
    (points, triangles)
}

/// A sphere by circles of latitude, the poles one point each.
fn sphere(center: Vec3, radius: f64) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let rows = AROUND / 2;
    let turn = std::f64::consts::TAU / f64::from(AROUND);
    let mut points = vec![center + Vec3::z() * radius];
    for row in 1..rows {
        let (sin, cos) = libm::sincos(f64::from(row) * turn);
        for column in 0..AROUND {
            let (y, x) = libm::sincos(f64::from(column) * turn);
            points.push(center + Vec3::new(x * sin, y * sin, cos) * radius);
        }
    }
    points.push(center - Vec3::z() * radius);
    let last = (rows - 1) * AROUND + 1;
    let at = |row: u32, column: u32| match row {
        0 => 0,
        row if row == rows => last,
        row => 1 + (row - 1) * AROUND + column % AROUND,
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..AROUND {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            triangles.extend(
                [[a, c, d], [a, d, b]].iter().filter(|[a, b, c]| a != b && b != c && c != a),
            );
        }
    }
    (points, triangles)
}

/// The corners of the box around points.
pub(crate) fn bounds(x: &[Vec3]) -> (Vec3, Vec3) {
    let first = x.first().copied().unwrap_or_else(Vec3::zeros);
    x.iter().fold((first, first), |(low, high), x| (low.inf(x), high.sup(x)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::normals;

    fn obstacles() -> [Obstacle; 3] {
        [
            Shape::Plane { point: Vec3::new(0.0, 0.0, -1.0), normal: Vec3::new(0.6, 0.0, 0.8) },
            Shape::Box { center: Vec3::new(0.1, 0.2, 0.3), half_extents: Vec3::new(0.5, 0.4, 0.3) },
            Shape::Sphere { center: Vec3::new(-0.1, 0.0, 0.4), radius: 0.7 },
        ]
        .map(Obstacle::from)
    }

    #[test]
    fn the_surface_of_every_obstacle_lies_on_it_and_faces_outward() {
        let obstacles = obstacles();
        let cloth = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 0.5)];
        for (obstacle, solid) in obstacles.iter().zip(solids(&obstacles, &cloth, &[[0, 1]])) {
            for point in &solid.points {
                assert!(obstacle.distance(point).0.abs() < 1e-12, "{}", solid.name);
            }
            for &triangle in &solid.triangles {
                let normal = area_normal(&solid.points, triangle);
                let middle = triangle.iter().map(|&i| solid.points[i as usize]).sum::<Vec3>() / 3.0;
                let (_, outward) = obstacle.distance(&(middle + normal * 1e-3));
                assert!(normal.dot(&outward) > 0.0, "{} {triangle:?}", solid.name);
            }
        }
    }

    #[test]
    fn closed_surfaces_have_two_triangles_at_every_edge() {
        for solid in &solids(&obstacles(), &[Vec3::zeros(), Vec3::x()], &[])[1..] {
            assert!(
                edges(&solid.triangles).values().all(|sides| sides.len() == 2),
                "{}",
                solid.name
            );
        }
    }

    #[test]
    fn a_softened_box_lies_within_the_box_and_hides_from_every_line_over_its_edges() {
        let (half, length) = (Vec3::new(0.5, 0.4, 0.3), 0.05);
        let radius = SOFTNESS * length;
        let (points, triangles) = rounded_box(Vec3::zeros(), half, radius);
        let sharp = Obstacle::from(Shape::Box { center: Vec3::zeros(), half_extents: half });
        let core = half - Vec3::repeat(radius);
        let distance = |x: &Vec3| (x - x.sup(&-core).inf(&core)).norm() - radius;
        for point in &points {
            assert!(sharp.distance(point).0 < 1e-12 && distance(point).abs() < 1e-12);
        }
        for &triangle in &triangles {
            let normal = area_normal(&points, triangle);
            assert!(normal.dot(&points[triangle[0] as usize]) > -1e-15, "it faces outward");
        }
        for n in 0..=100 {
            let (sin, cos) = libm::sincos(f64::from(n) * std::f64::consts::FRAC_PI_2 / 100.0);
            let [a, b] =
                [Vec3::new(sin, 0.0, 0.0), Vec3::new(0.0, 0.0, cos)].map(|r| half - r * length);
            for part in 0..=20 {
                let x = a.lerp(&b, f64::from(part) / 20.0);
                assert!(distance(&Vec3::new(x.x, 0.0, x.z)) > -1e-12, "{n} {part}");
            }
        }
    }

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
            "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1, "stiffness_n_per_m": 1 }],
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

    #[test]
    fn normals_are_unit_vectors_also_where_the_cloth_has_no_area() {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::x()];
        for normal in normals(&x, &[[0, 1, 2], [0, 1, 3]]) {
            assert!((normal.norm() - 1.0).abs() < 1e-12);
        }
    }

    /// A box as a mesh, one unit cube and one slab that is thinner than the depth.
    #[test]
    fn a_mesh_is_smaller_in_pictures_by_the_depth_and_a_thin_one_by_less() {
        let boxed = Shape::Box { center: Vec3::zeros(), half_extents: Vec3::repeat(0.5) };
        let cube = solid(&Obstacle::from(boxed), 0, &[], 0.0);
        for (thickness, depth, expected) in [(1.0, 0.1, 0.1), (0.12, 0.1, 0.025)] {
            let points: Vec<_> = cube.points.iter().map(|x| [x.x, x.y, x.z * thickness]).collect();
            let text = format!(
                r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [1], "position_m": [[0, 0, 9]] }},
                "obstacles": [{{ "mesh": {{ "vertices_m": {points:?}, "triangles": {:?} }} }}] }}"#,
                cube.triangles
            );
            let input = drape_model::parse("box", &text).expect("valid");
            let (system, _) = input.spec().build().expect("closed");
            let obstacle = &system.obstacles()[0];
            let softness = depth * SOFTNESS / DEPTH;
            let (points, triangles) =
                solid(obstacle, 0, &[], softness).softened.expect("another surface");
            assert_eq!(triangles, cube.triangles);
            for point in &points {
                let inside = -obstacle.distance(point).0;
                assert!((inside - expected).abs() < 1e-9, "{thickness}: {inside}");
            }
        }
    }
}
