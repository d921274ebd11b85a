//! Solids bounded by meshes against shapes with a formula.

use super::*;
use crate::error::Violation;

/// The box with these half extents, each face two triangles.
fn cuboid(half: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    let vertices = (0..8)
        .map(|i| Vec3::new(sign(i & 1), sign(i & 2), sign(i & 4)).component_mul(&half))
        .collect();
    let quads: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    (vertices, quads.into_iter().flat_map(halves).collect())
}

/// A ball of radius 1 from an octahedron whose triangles are cut in four `levels` times.
fn ball(levels: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (x, y, z) = (Vec3::x(), Vec3::y(), Vec3::z());
    let mut vertices = vec![x, -x, y, -y, z, -z];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut cut = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    vertices.push((vertices[i as usize] + vertices[j as usize]).normalize());
                    vertices.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            cut.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = cut;
    }
    (vertices, triangles)
}

fn closed((vertices, triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> Result<ClosedMesh, Violation> {
    ClosedMesh::check("mesh", vertices, &triangles)
}

/// Points all over a cube of the given half edge, in no order.
fn points(count: u64, half: f64) -> impl Iterator<Item = Vec3> {
    let fraction = |i: u64, by: f64| (i as f64 * by).fract() * 2.0 - 1.0;
    (1..=count).map(move |i| {
        let [a, b, c] =
            [0.754_877_666_2, 0.569_840_290_9, 0.438_579_021_3].map(|by| fraction(i, by));
        Vec3::new(a, b, c) * half
    })
}

#[test]
fn a_box_of_triangles_has_the_distances_and_normals_of_the_box() {
    let half = Vec3::new(0.5, 0.3, 0.2);
    let mesh = closed(cuboid(half)).expect("valid");
    let shape = Shape::Box { center: Vec3::zeros(), half_extents: half };
    let analytic = Obstacle::from(shape);
    for x in points(5000, 1.0) {
        let (expected, along) = analytic.distance(&x);
        let (found, normal) = mesh.distance(&x);
        assert!((found - expected).abs() < 1e-14, "{x:?}: {found}, not {expected}");
        assert!((normal - along).norm() < 1e-9, "{x:?}: {normal:?}, not {along:?}");
    }
    // On faces, edges and corners normals point out and distances are 0.
    for x in points(500, 1.0) {
        let on = x.zip_map(&half, |x, half| x.clamp(-half, half));
        if on.iter().zip(&half).all(|(x, half)| x.abs() < *half) {
            continue;
        }
        let (found, normal) = mesh.distance(&on);
        assert!(found.abs() < 1e-15 && (normal.norm() - 1.0).abs() < 1e-12);
        assert!(analytic.distance(&(on + normal * 1e-3)).0 > 5e-4, "{on:?}: {normal:?}");
    }
}

/// However many triangles its faces have at a corner, they share its normal equally.
#[test]
fn the_normal_at_a_corner_of_a_cube_is_its_diagonal() {
    let (vertices, triangles) = cuboid(Vec3::repeat(1.0));
    let mesh = closed((vertices.clone(), triangles)).expect("valid");
    for corner in vertices {
        let (distance, normal) = mesh.distance(&corner);
        assert!(distance == 0.0 && (normal - corner.normalize()).norm() < 1e-12, "{normal:?}");
    }
}

/// The tree finds the nearest triangle, and edges and corners tell inside from outside.
#[test]
fn a_ball_of_many_triangles_is_a_ball_up_to_their_size() {
    let mesh = closed(ball(4)).expect("valid");
    for x in points(3000, 1.5) {
        let (found, normal) = mesh.distance(&x);
        let expected = x.norm() - 1.0;
        assert!((found - expected).abs() < 5e-3, "{x:?}: {found}, not {expected}");
        if expected.abs() < 0.5 {
            assert!(normal.dot(&x.normalize()) > 0.98, "{x:?}: {normal:?}");
        }
        assert!(expected > 5e-3 || mesh.is_near(&x, 0.0));
    }
    assert!(!mesh.is_near(&Vec3::new(1.2, 0.0, 0.0), 0.1));
}

#[test]
fn a_mesh_that_bounds_nothing_is_refused_with_the_triangle_that_shows_it() {
    let whole = cuboid(Vec3::repeat(1.0));
    let refused = |change: fn(&mut Vec<Vec3>, &mut Vec<[u32; 3]>)| {
        let (mut vertices, mut triangles) = whole.clone();
        change(&mut vertices, &mut triangles);
        let violation = closed((vertices, triangles)).expect_err("refused");
        (violation.path.clone(), violation.to_string())
    };
    let check = |(path, message): (String, String), at: &str, what: &str| {
        assert!(path == at && message.contains(what), "{path}: {message}");
    };
    check(refused(|_, t| t.truncate(11)), "mesh.triangles[0]", "no triangle has the edge");
    check(refused(|_, t| t[3].swap(0, 1)), "mesh.triangles[3]", "is one of triangle");
    check(refused(|_, t| t.iter_mut().for_each(|t| t.swap(0, 1))), "mesh.triangles[0]", "volume");
    check(refused(|_, t| t[2][1] = 8), "mesh.triangles[2][1]", "below 8");
    check(refused(|_, t| t[5] = [3, 3, 1]), "mesh.triangles[5]", "an area");
    check(refused(|_, t| t.clear()), "mesh.triangles", "4 to");
    // Two boxes that touch in one vertex.
    let twice = refused(|vertices, triangles| {
        let shifted: Vec<_> = vertices.iter().map(|v| v + Vec3::repeat(2.0)).collect();
        let index = |i: u32| if i == 0 { 7 } else { i + 7 };
        vertices.extend(&shifted[1..]);
        let others: Vec<_> = triangles.iter().map(|t| t.map(index)).collect();
        triangles.extend(others);
    });
    check(twice, "mesh.triangles[2]", "one fan");
}

/// Both meshes as one: the second moved, and turned inside out if `is_turned`.
fn together(
    (mut vertices, mut triangles): (Vec<Vec3>, Vec<[u32; 3]>),
    (others, more): (Vec<Vec3>, Vec<[u32; 3]>),
    shift: Vec3,
    is_turned: bool,
) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let offset = vertices.len() as u32;
    vertices.extend(others.iter().map(|x| x + shift));
    triangles.extend(more.into_iter().map(|t| {
        let [a, b, c] = t.map(|i| i + offset);
        if is_turned { [a, c, b] } else { [a, b, c] }
    }));
    (vertices, triangles)
}

#[test]
fn a_ball_with_a_cavity_is_hollow() {
    let small = || {
        let (x, t) = ball(3);
        (x.into_iter().map(|x| x * 0.5).collect(), t)
    };
    let mesh = closed(together(ball(3), small(), Vec3::zeros(), true)).expect("valid");
    for x in points(1000, 1.2) {
        let expected = (x.norm() - 1.0).max(0.5 - x.norm());
        let (found, _) = mesh.distance(&x);
        assert!((found - expected).abs() < 0.02, "{x:?}: {found}, not {expected}");
    }
    // A ball in the cavity is solid again.
    let core = || (ball(2).0.into_iter().map(|x| x * 0.2).collect(), ball(2).1);
    let hollow = || together(ball(3), small(), Vec3::zeros(), true);
    let mesh = closed(together(hollow(), core(), Vec3::zeros(), false)).expect("valid");
    assert!(mesh.distance(&Vec3::new(0.05, 0.0, 0.0)).0 < 0.0);
    let refused = closed(together(hollow(), core(), Vec3::zeros(), true)).expect_err("turned");
    assert!(refused.expected.contains("counter-clockwise"), "{refused}");
}

#[test]
fn parts_that_are_turned_the_wrong_way_are_refused() {
    let unit = || cuboid(Vec3::repeat(1.0));
    let small = || cuboid(Vec3::repeat(0.5));
    let aside = Vec3::new(5.0, 0.0, 0.0);
    assert!(closed(together(unit(), small(), aside, false)).is_ok());
    // Side by side with a common wall, and on top of a corner of another.
    assert!(closed(together(unit(), unit(), Vec3::new(2.0, 0.0, 0.0), false)).is_ok());
    assert!(closed(together(unit(), small(), Vec3::new(1.0, 1.0, 1.5), false)).is_ok());
    // The whole has a volume above 0 in both cases.
    let message = |mesh| closed(mesh).expect_err("refused").to_string();
    let beside = message(together(unit(), small(), aside, true));
    assert!(beside.contains("mesh.triangles[12]") && beside.contains("counter-clock"), "{beside}");
    let inside = message(together(unit(), small(), Vec3::zeros(), false));
    assert!(inside.contains("mesh.triangles[12]") && inside.contains("cavity"), "{inside}");
    let many = (0..120).map(|k| Vec3::new(3.0 * f64::from(k), 0.0, 0.0));
    let many = many.fold(unit(), |all, shift| together(all, unit(), shift + aside, false));
    assert!(message(many).contains("at most 100 parts"));
}

/// Corners of the upper block lie on faces of the lower one, where a solid angle jumps: only its
/// other points tell the side.
#[test]
fn a_block_may_stand_on_a_bigger_one_or_fill_a_cavity() {
    // The bottom, the sides, the top, as editors of meshes list them: most triangles begin at the
    // bottom, the middle of which is `base`.
    let block = |side: f64, height: f64, base: Vec3| {
        let corner = |i: usize| [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]][i % 4];
        let vertex = |i: usize| {
            let [x, y] = corner(i).map(|x| x * side);
            base + Vec3::new(x, y, if i < 4 { 0.0 } else { height })
        };
        let triangles: Vec<[u32; 3]> = vec![
            [0, 2, 1],
            [0, 3, 2],
            [0, 1, 5],
            [0, 5, 4],
            [1, 2, 6],
            [1, 6, 5],
            [2, 3, 7],
            [2, 7, 6],
            [3, 0, 4],
            [3, 4, 7],
            [4, 5, 6],
            [4, 6, 7],
        ];
        ((0..8).map(vertex).collect::<Vec<_>>(), triangles)
    };
    let up = |z: f64| Vec3::new(0.0, 0.0, z);
    // Also where heights are rounded, and off the middle.
    for (height, place) in [(0.5, up(0.5)), (0.1 + 0.2, up(0.3)), (0.3, Vec3::new(0.2, -0.1, 0.3))]
    {
        let big = || block(1.0, height, Vec3::zeros());
        let small = || block(0.4, 0.4, place);
        assert!(closed(together(big(), small(), Vec3::zeros(), false)).is_ok(), "{place:?}");
        assert!(closed(together(small(), big(), Vec3::zeros(), false)).is_ok(), "{place:?}");
        for (first, second) in [(big(), small()), (small(), big())] {
            let turned = closed(together(first, second, Vec3::zeros(), true)).expect_err("turned");
            assert_eq!(turned.path, "mesh.triangles[12]", "{place:?}: {turned}");
        }
    }
    // A cavity down to the floor, and a block that fills one: nothing of it is off its wall.
    let big = || block(1.0, 1.0, Vec3::zeros());
    let small = || block(0.5, 0.5, Vec3::zeros());
    assert!(closed(together(big(), small(), Vec3::zeros(), true)).is_ok());
    let inside = closed(together(big(), small(), Vec3::zeros(), false)).expect_err("in a solid");
    assert!(inside.expected.contains("cavity"), "{inside}");
    let hollow = together(big(), small(), up(0.25), true);
    assert!(closed(together(hollow, small(), up(0.25), false)).is_ok());
}
