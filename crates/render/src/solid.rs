//! Obstacles as surfaces.

use crate::subject::{bounds, grid};
use crate::surface::area_normal;
use drape_model::{ClosedMesh, Obstacle, Path, Shape, Vec3};

/// Number of cells of a sphere's surface around its axis; half as many run from pole to pole.
const AROUND: u32 = 64;
/// Number of cells along each side of the tile that stands for a plane.
const TILES: u32 = 10;
/// Radius of the edges of a box in pictures, over the length of a typical line on the cloth. A
/// radius of 1.21 just hides the edge below a line that bends over it.
const SOFTNESS: f64 = 1.3;
/// Depth by which meshes shrink in pictures, over the length of a typical line on the cloth. A line
/// over a sharp edge cuts in by 0.354 of its length, and some lines are longer than a typical one.
const DEPTH: f64 = 0.36;
/// Least cosine between the normals of a corner and a face that counts. It limits how much farther
/// the corner moves than the face.
const STEEPEST: f64 = 0.5;
/// How often the depth is halved where a mesh is thin.
const HALVINGS: usize = 6;
/// Cells of a softened face along each side.
const FACE: u32 = 40;
/// Side of the tile of a plane over the size of the scene.
const TILE: f64 = 1.6;

/// The surface of an obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Name in files: the kind `plane`, `box`, `sphere` or `mesh`, with a number.
    pub name: String,
    /// Corners at the start, m.
    pub points: Vec<Vec3>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Lines that are drawn: the edges of a box, the squares of a plane.
    pub lines: Vec<[u32; 2]>,
    /// The surface in pictures, if it differs: points, m, and triangles. A cloth of straight pieces
    /// that bends over an edge would cut through the true surface. So boxes get round edges that
    /// lie within the box, and meshes shrink by some depth.
    pub softened: Option<(Vec<Vec3>, Vec<[u32; 3]>)>,
    /// Whether the obstacle has no end, so that a camera need not show all of it.
    pub is_endless: bool,
    /// Its path, if it moves.
    pub path: Option<Path>,
}

/// The surfaces of obstacles around a cloth.
pub(crate) fn solids(obstacles: &[Obstacle], cloth: &[Vec3], lines: &[[u32; 2]]) -> Vec<Solid> {
    let softness = SOFTNESS * typical_length(cloth, lines);
    let all = obstacles.iter().enumerate();
    all.map(|(number, obstacle)| solid(obstacle, number, cloth, softness)).collect()
}

/// Median length of the lines, m.
fn typical_length(x: &[Vec3], lines: &[[u32; 2]]) -> f64 {
    let length = |[a, b]: &[u32; 2]| Some((x.get(*a as usize)? - x.get(*b as usize)?).norm());
    let lengths = lines.iter().filter_map(length).filter(|length| length.is_finite());
    let mut lengths: Vec<f64> = lengths.collect();
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied().unwrap_or(0.0)
}

fn solid(obstacle: &Obstacle, number: usize, cloth: &[Vec3], softness: f64) -> Solid {
    let (points, triangles, lines, softened) = match &obstacle.shape {
        Shape::Plane { point, normal } => {
            let (triangles, lines) = grid(TILES + 1, TILES + 1);
            (tiles(point, normal, cloth), triangles, lines, None)
        }
        Shape::Box { center, half_extents } => {
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
            let edges = (0..8_u32).flat_map(|a| [1, 2, 4].map(|bit| [a, a | bit]));
            let lines = edges.filter(|[a, b]| a != b).collect();
            let softened = rounded_box(*center, *half_extents, softness);
            ((0..8).map(corner).collect(), triangles, lines, Some(softened))
        }
        Shape::Mesh(mesh) => {
            let triangles = mesh.triangles().to_vec();
            let shrunk = shrunk(obstacle, mesh, DEPTH / SOFTNESS * softness);
            let softened = Some((shrunk, triangles.clone()));
            (mesh.vertices().to_vec(), triangles, Vec::new(), softened)
        }
        Shape::Sphere { center, radius } => {
            let (points, triangles) = sphere(*center, *radius);
            (points, triangles, Vec::new(), None)
        }
    };
    Solid {
        name: format!("{}-{number}", obstacle.shape.name()),
        points,
        triangles,
        lines,
        softened,
        is_endless: matches!(obstacle.shape, Shape::Plane { .. }),
        path: obstacle.path.clone(),
    }
}

/// The points of a tile that stands for a plane, below or above the middle of the cloth.
fn tiles(point: &Vec3, normal: &Vec3, cloth: &[Vec3]) -> Vec<Vec3> {
    let (low, high) = bounds(cloth);
    let size = (high - low).norm();
    let size = if size > 0.0 && size.is_finite() { size } else { 1.0 };
    let middle = (low + high) * 0.5;
    let middle = middle - normal * normal.dot(&(middle - point));
    // A direction within the plane, along the projection of x unless the normal is near x.
    let along = if normal.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
    let along = (along - normal * normal.dot(&along)).normalize();
    let across = normal.cross(&along);
    let side = f64::from(TILES);
    let at = |n: u32| (f64::from(n) / side - 0.5) * TILE * size;
    let places = (0..=TILES).flat_map(|row| (0..=TILES).map(move |column| (row, column)));
    places.map(|(row, column)| middle + across * at(row) + along * at(column)).collect()
}

/// Unit normals of the points of a mesh, weighted by the angles around them. At a corner of a box
/// the normal makes the same angle with all three faces, however they are divided.
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

/// The corners of a mesh, m, moved so that its faces lie `depth` m within the mesh, or less where
/// the mesh is too thin.
fn shrunk(obstacle: &Obstacle, mesh: &ClosedMesh, depth: f64) -> Vec<Vec3> {
    let (x, triangles) = (mesh.vertices(), mesh.triangles());
    let outward = normals_by_angle(x, triangles);
    // The least cosine of the angles with the faces around a corner: it moves farther than they do.
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
            // The mesh must be thick enough behind the corner.
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
    // More cells lie where the edge is round.
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

/// A sphere from circles of latitude; each pole is one point.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{edges, normals};

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
    fn normals_are_unit_vectors_also_where_the_cloth_has_no_area() {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::x()];
        for normal in normals(&x, &[[0, 1, 2], [0, 1, 3]]) {
            assert!((normal.norm() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_mesh_is_smaller_in_pictures_by_the_depth_and_a_thin_one_by_less() {
        let boxed = Shape::Box { center: Vec3::zeros(), half_extents: Vec3::repeat(0.5) };
        let cube = solid(&Obstacle::from(boxed), 0, &[], 0.0);
        for (thickness, depth, expected) in [(1.0, 0.1, 0.1), (0.12, 0.1, 0.025)] {
            let points: Vec<_> = cube.points.iter().map(|x| [x.x, x.y, x.z * thickness]).collect();
            let text = format!(
                r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [1],
                    "position_m": [[0, 0, 9]] }},
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
