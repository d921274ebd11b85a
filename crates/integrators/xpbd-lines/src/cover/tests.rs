//! Lines of grids, rings, crossings and random graphs.

use super::*;
use crate::chains::springs_of;
use drape_oracle::Random;
use drape_oracle::scenes::{build, bundled};
use std::collections::BTreeSet;

/// Springs of a grid of `side` × `side` particles, one step along each of `steps`.
fn grid(side: i32, steps: &[(i32, i32)]) -> Vec<([u32; 2], f64)> {
    let mut springs = Vec::new();
    for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
        for (down, right) in steps {
            let (r, c) = (row + down, column + right);
            if (0..side).contains(&r) && (0..side).contains(&c) {
                let rest = f64::from(down * down + right * right).sqrt();
                springs.push(([(row * side + column) as u32, (r * side + c) as u32], rest));
            }
        }
    }
    springs
}

fn cover(particles: usize, effects: &[Vec<([u32; 2], f64)>]) -> Vec<Cover> {
    let graph = Graph::new(particles, effects.iter().flatten().copied());
    let ends = |effect: &Vec<([u32; 2], f64)>| -> Vec<_> { effect.iter().map(|s| s.0).collect() };
    let covers: Vec<_> =
        effects.iter().map(|effect| Cover::new(&graph, particles, &ends(effect))).collect();
    for (cover, effect) in covers.iter().zip(effects) {
        check(cover, &ends(effect));
    }
    covers
}

/// Each spring stands in one line, between its ends; no line meets itself; no family either.
fn check(cover: &Cover, ends: &[[u32; 2]]) {
    let mut springs = cover.springs.clone();
    springs.sort_unstable();
    assert_eq!(springs, (0..ends.len() as u32).collect::<Vec<_>>());
    for line in &cover.lines {
        let members = &cover.particles[line.particles.clone()];
        assert_eq!(members.len(), line.springs.len() + 1);
        for (pair, &spring) in members.windows(2).zip(&cover.springs[line.springs.clone()]) {
            let [i, j] = ends[spring as usize];
            assert!([[i, j], [j, i]].contains(&[pair[0], pair[1]]), "{pair:?} of {spring}");
        }
    }
    let mut start = 0;
    for family in &cover.families {
        assert_eq!(family.start, start);
        start = family.end;
        let lines = &cover.lines[family.clone()];
        let members: Vec<_> =
            lines.iter().flat_map(|line| &cover.particles[line.particles.clone()]).collect();
        let distinct: BTreeSet<_> = members.iter().collect();
        assert_eq!(distinct.len(), members.len());
    }
    assert_eq!(start, cover.lines.len());
}

const WARP_AND_WEFT: [(i32, i32); 2] = [(0, 1), (1, 0)];
const DIAGONALS: [(i32, i32); 2] = [(1, 1), (1, -1)];
const BENDING: [(i32, i32); 2] = [(0, 2), (2, 0)];

fn lengths(cover: &Cover) -> Vec<Vec<usize>> {
    let of = |family: &Range<usize>| {
        cover.lines[family.clone()].iter().map(|line| line.springs.len()).collect()
    };
    cover.families.iter().map(of).collect()
}

/// With and without the other springs a sheet has `2 n` lines of warp and weft in two families.
#[test]
fn a_grid_has_its_rows_columns_and_diagonals_as_lines() {
    for side in [2, 3, 5, 8_i32] {
        let n = side as usize;
        let steps: [&[_]; 3] = [&WARP_AND_WEFT, &DIAGONALS, &BENDING];
        for count in 1..=3 {
            let effects: Vec<_> = steps[..count].iter().map(|steps| grid(side, steps)).collect();
            let covers = cover(n * n, &effects);
            assert_eq!(lengths(&covers[0]), vec![vec![n - 1; n]; 2], "{side}, {count}");
            if count > 1 {
                let shear = lengths(&covers[1]);
                let mut all = shear.concat();
                all.sort_unstable();
                let mut expected: Vec<_> = (1..n).chain(1..n - 1).collect();
                expected.extend(expected.clone());
                expected.sort_unstable();
                let families = if n == 2 { 1 } else { 2 };
                assert_eq!((shear.len(), all), (families, expected), "{side}, {count}");
            }
            if count > 2 && n > 3 {
                let bending = lengths(&covers[2]);
                assert_eq!(bending.len(), 2, "even and odd lines share no particle");
                assert_eq!(bending[0].len(), 2 * n, "{side}");
            }
        }
    }
}

/// A ring is cut once; at a crossing of three straight lines all go on.
#[test]
fn rings_and_crossings() {
    let ring: Vec<_> = (0..7).map(|i| ([i, (i + 1) % 7], 1.0)).collect();
    let [ring] = &cover(7, &[ring])[..] else { panic!("one effect") };
    assert_eq!(lengths(ring), [vec![6], vec![1]]);
    // Six equal triangles around particle 0.
    let spokes = (1..7).map(|i| ([0, i], 1.0));
    let rim = (1..7).map(|i| ([i, i % 6 + 1], 1.0));
    let [star] = &cover(7, &[spokes.chain(rim).collect()])[..] else { panic!("one effect") };
    let through: Vec<_> = star
        .lines
        .iter()
        .map(|line| &star.particles[line.particles.clone()])
        .filter(|members| members.contains(&0))
        .collect();
    assert_eq!(through, [[4, 0, 1], [5, 0, 2], [6, 0, 3]].map(|line| line.to_vec()));
}

/// A tablecloth of 2070 edges of triangles that are not alike.
#[test]
fn a_mesh_of_triangles_has_long_lines_in_few_families() {
    let (system, _) = build(&bundled("round-table"));
    let springs: Vec<_> = system.effects().flat_map(springs_of).collect();
    let [mesh] = &cover(system.len(), &[springs])[..] else { panic!("one effect") };
    assert_eq!((mesh.springs.len(), mesh.lines.len(), mesh.families.len()), (2070, 89, 4));
}

#[test]
fn any_graph_is_covered_once_and_always_alike() {
    let mut random = Random::new(5);
    for n in [1, 2, 5, 30] {
        for chance in [0.1, 0.5, 1.0] {
            let mut springs = Vec::new();
            for (j, i) in (0..n).flat_map(|i| (0..i).map(move |j| (j, i))) {
                if random.chance(chance) {
                    springs.push(([i as u32, j as u32], random.between(0.0, 2.0)));
                }
            }
            // Springs between the same two particles, and of length 0.
            springs.extend(springs.first().copied());
            springs.extend(springs.first().map(|(ends, _)| (*ends, 0.0)));
            assert_eq!(cover(n, &[springs.clone()]), cover(n, &[springs]));
        }
    }
}
