//! Bands against compressed rows bit by bit, springs against their readable form bit by bit and
//! against compressed rows, and compressed rows against dense matrices.

use super::*;
use crate::test_support::{dense_blocks, dense_filter, flat, graph, random_blocks, random_filter};
use crate::{BlockJacobi, Norm, PcgSettings, PcgWorkspace, Reference, SolveStatus, filtered_pcg};
use drape_kernels::blocks::{SpringBlock, SpringBlocks};
use drape_kernels::testing::{Random, assert_same_bits};
use proptest::prelude::*;

type Edges = [(usize, usize)];

/// The same random blocks in compressed rows and in another layout.
fn both(n: usize, edges: &Edges, other: &Coupling, random: &mut Random) -> [BlockMatrix; 2] {
    let mut both = [&Coupling::Rows, other].map(|c| BlockMatrix::new(n, c, edges.iter().copied()));
    // Twice: the values before a clearing must not matter.
    for _ in 0..2 {
        both.iter_mut().for_each(BlockMatrix::clear);
        for i in 0..n {
            let d = random.vector();
            let block = Mat3::identity() + d * d.transpose();
            both.iter_mut().for_each(|a| a.add_diagonal(i, &block));
        }
        for &(i, j) in edges {
            let d = random.vector();
            let (i, j) = if random.unit() < 0.0 { (i, j) } else { (j, i) };
            both.iter_mut().for_each(|a| a.add_pair(i, j, &(d * d.transpose())));
        }
    }
    both
}

fn product(a: &BlockMatrix, x: &[Vec3]) -> Vec<Vec3> {
    let mut y = vec![Vec3::repeat(f64::NAN); x.len()];
    a.multiply(x, &mut y);
    y
}

/// Compares all operations of a matrix in compressed rows and in another layout.
fn assert_same_matrix(n: usize, edges: &Edges, coupling: &Coupling, seed: u64) {
    let mut random = Random::new(seed);
    let [rows, fast] = both(n, edges, coupling, &mut random);
    assert_eq!((fast.n(), fast.coupling()), (n, coupling.clone()));
    let x = random.vectors(n);
    let reference = product(&rows, &x);
    assert_same_bits("product", &reference, &product(&fast, &x));
    assert_same_bits("a copy's", &reference, &product(&fast.clone(), &x));
    if let Layout::Bands(bands) = &fast.layout {
        let mut y = random.vectors(n);
        bands.multiply_reference(0..n, &x, &mut y);
        assert_same_bits("row by row", &reference, &y);
        let taken: Vec<_> = bands.windows.iter().map(|window| window.lock()).collect();
        assert_same_bits("while another thread multiplies", &reference, &product(&fast, &x));
        drop(taken);
    }
    for (i, j) in (0..n).flat_map(|i| [(i, i), (i, (i * 7 + 1) % n), (i, (i + 1) % n)]) {
        assert_eq!(rows.get(i, j), fast.get(i, j), "({i}, {j})");
    }
    assert_same_bits("as rows", &reference, &product(&fast.rows().into_owned().into(), &x));

    // Held particles keep the layout; particles on planes and lines change it.
    let (mut held, mut any) = (Constraints::free(n), Constraints::free(n));
    for i in (0..n).filter(|i| i % 5 == 2) {
        held.set(i, Filter::Fixed, Vec3::zeros());
        any.set(i, random_filter(&mut random), Vec3::zeros());
    }
    for constraints in [held, any] {
        let [mut rows, mut fast] = [&rows, &fast].map(BlockMatrix::clone);
        rows.project(&constraints);
        fast.project(&constraints);
        assert_same_bits("projected", &product(&rows, &x), &product(&fast, &x));
        let constrained = constraints.constrained().iter().map(|&i| constraints.filter(i as usize));
        let are_held = constrained.into_iter().all(|filter| filter == Filter::Fixed);
        assert_eq!(fast.coupling() == *coupling, are_held);
    }
}

/// `κ` of blocks of springs.
const UNIT: f64 = 1.7;

/// Writes the blocks of the springs at all edges.
fn write_springs(a: &mut BlockMatrix, blocks: &[SpringBlock]) {
    let Some(BlockLayout::Pairs(matrix)) = a.fast_layout() else { panic!("no matrix of springs") };
    assert_eq!(matrix.slots.len(), blocks.len());
    *matrix.unit = UNIT;
    for (&slot, block) in matrix.slots.iter().zip(blocks) {
        if let Some(place) = matrix.springs.get_mut(slot as usize) {
            *place = *block;
        }
    }
}

/// Random springs in compressed rows and in blocks of their own.
fn springs(n: usize, edges: &Edges, random: &mut Random) -> [BlockMatrix; 2] {
    let mut both = [Coupling::Rows, Coupling::Pairs]
        .map(|coupling| BlockMatrix::new(n, &coupling, edges.iter().copied()));
    for i in 0..n {
        let own = Mat3::from_diagonal_element(1.5 + random.unit());
        both.iter_mut().for_each(|a| a.add_diagonal(i, &own));
    }
    let block = |random: &mut Random| {
        let w = random.vector();
        [w.x, w.y, w.z, random.unit()]
    };
    let blocks: Vec<_> = edges.iter().map(|_| block(random)).collect();
    for (&(i, j), [wx, wy, wz, a]) in edges.iter().zip(&blocks) {
        let w = Vec3::new(*wx, *wy, *wz);
        both[0].add_pair(i, j, &(w * w.transpose() * UNIT + Mat3::from_diagonal_element(*a)));
    }
    write_springs(&mut both[1], &blocks);
    both
}

fn assert_close(case: &str, a: &[Vec3], b: &[Vec3]) {
    let distance = a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(distance < 1e-11, "{case}: {distance}");
}

/// Compares all operations of a matrix of springs with its readable form and with compressed rows.
fn assert_same_springs(n: usize, edges: &Edges, seed: u64) {
    let mut random = Random::new(seed);
    let [rows, fast] = springs(n, edges, &mut random);
    let x = random.vectors(n);
    let assert_same = |case: &str, rows: &BlockMatrix, fast: &BlockMatrix| {
        assert_close(case, &product(rows, &x), &product(fast, &x));
        let Layout::Pairs(pairs) = &fast.layout else { panic!("{case}: another layout") };
        let mut y = vec![Vec3::repeat(f64::NAN); n];
        pairs.multiply_reference(&x, &mut y);
        assert_same_bits(case, &y, &product(fast, &x));
        for (i, j) in (0..n).flat_map(|i| [(i, i), (i, (i * 7 + 1) % n), (i, (i + 1) % n)]) {
            let distance = (rows.get(i, j) - fast.get(i, j)).norm();
            assert!(distance < 1e-12, "{case}, ({i}, {j}): {distance}");
            assert_eq!(fast.get(i, j), fast.get(j, i).transpose());
        }
        assert_close(case, &product(&fast.rows().into_owned().into(), &x), &product(fast, &x));
    };
    assert_same("springs", &rows, &fast);

    // Held particles keep the layout; particles on planes and lines change it.
    let (mut held, mut any) = (Constraints::free(n), Constraints::free(n));
    for i in (0..n).filter(|i| i % 5 < 2) {
        held.set(i, Filter::Fixed, Vec3::zeros());
        any.set(i, Filter::Plane { normal: Vec3::x() }, Vec3::zeros());
    }
    let [mut rows_held, mut fast_held] = [&rows, &fast].map(BlockMatrix::clone);
    rows_held.project(&held);
    fast_held.project(&held);
    assert_same("held", &rows_held, &fast_held);
    let [mut rows_any, mut fast_any] = [&rows, &fast].map(BlockMatrix::clone);
    rows_any.project(&any);
    fast_any.project(&any);
    assert_eq!(fast_any.coupling(), Coupling::Rows);
    assert_close("projected", &product(&rows_any, &x), &product(&fast_any, &x));
    // Any block between rows changes it, too.
    if let Some(&(i, j)) = edges.iter().find(|(i, j)| i != j) {
        let [mut rows, mut fast] = [rows, fast];
        let block = Mat3::identity() - x[0] * x[0].transpose();
        [&mut rows, &mut fast].into_iter().for_each(|a| a.add_pair(i, j, &block));
        assert_eq!(fast.coupling(), Coupling::Rows);
        assert_close("another block", &product(&rows, &x), &product(&fast, &x));
        // The values before a clearing do not matter.
        fast_held.clear();
        assert_eq!(product(&fast_held, &x), vec![Vec3::zeros(); n]);
    }
}

/// However many threads share a product, and solves with it, the bits are the same: on sheets whose
/// last block, group and register are full or not.
#[test]
fn threads_change_no_bit() {
    let settings =
        |forcing_term| PcgSettings { forcing_term, norm: Norm::Euclid, max_iterations: 500 };
    let offsets = [1, 69, 70, 71];
    for n in [300, 513, 2000, 4999] {
        let mut random = Random::new(4);
        let edges: Vec<_> =
            offsets.into_iter().flat_map(|o| (o..n).map(move |j| (j - o, j))).collect();
        let blocks: Vec<_> = edges.iter().map(|_| random.vector()).collect();
        let (x, b) = (random.vectors(n), random.vectors(n));
        let mut constraints = Constraints::free(n);
        constraints.set(n / 3, Filter::Fixed, Vec3::x());
        for coupling in [Coupling::Rows, Coupling::Pairs, bands(&offsets)] {
            let mut a = BlockMatrix::new(n, &coupling, edges.iter().copied());
            (0..n).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
            if coupling == Coupling::Pairs {
                let blocks: Vec<_> = blocks.iter().map(|d| [d.x, d.y, d.z, 0.1]).collect();
                write_springs(&mut a, &blocks);
            } else {
                for (&(i, j), d) in edges.iter().zip(&blocks) {
                    a.add_pair(i, j, &(d * d.transpose()));
                }
            }
            assert_eq!(a.coupling(), coupling);
            let mut diagonal = BlockJacobi::new(&a);
            diagonal.update(&a).unwrap();
            let [one, several @ ..] = [1, 2, 3, 7].map(|bands| {
                a.set_bands(bands);
                let mut solution = x.clone();
                let report = filtered_pcg(
                    &a,
                    &diagonal,
                    &constraints,
                    &b,
                    &mut solution,
                    Reference::FilteredRightHandSide,
                    &settings(1e-9),
                    &mut PcgWorkspace::new(n),
                );
                assert_eq!(report.status, SolveStatus::Converged);
                let single = SinglePcg::new(&a).map(|mut single| {
                    let mut x = x.clone();
                    let report = single.solve(&a, &diagonal, &b, &mut x, &settings(1e-3)).unwrap();
                    assert_eq!(report.status, SolveStatus::Converged);
                    x
                });
                [Some(product(&a, &x)), Some(solution), single]
            });
            assert_eq!(one[2].is_some(), matches!(coupling, Coupling::Bands(_)));
            for other in several {
                assert_same_bits((n, &coupling), &one, &other);
            }
        }
    }
}

/// Some of the pairs along bands.
fn along(n: usize, offsets: &[usize], seed: u64) -> Vec<(usize, usize)> {
    let mut random = Random::new(seed);
    let pairs = (0..n).flat_map(|i| offsets.iter().map(move |o| (i, i + o)));
    pairs.filter(|&(_, j)| j < n && random.unit() < 0.2).collect()
}

fn bands(offsets: &[usize]) -> Coupling {
    let mut offsets = offsets.to_vec();
    offsets.sort_unstable();
    offsets.dedup();
    Coupling::Bands(offsets)
}

#[test]
fn bands_of_grids_are_compressed_rows() {
    for side in [1, 2, 4, 8, 20, 33, 52] {
        let offsets = [1, side, side - 1, side + 1, 2, 2 * side].map(|o| o.max(1));
        let (n, seed) = (side * side, side as u64);
        assert_same_matrix(n, &along(n, &offsets, seed), &bands(&offsets), seed);
    }
    // Longer than a window.
    for (n, offsets) in [(5000, &[1, 3, 70][..]), (3000, &[1, 2, 299, 300, 301, 600])] {
        assert_same_matrix(n, &along(n, offsets, 3), &bands(offsets), 3);
    }
}

proptest! {
    #[test]
    fn any_bands_are_compressed_rows(
        n in 1_usize..1500,
        offsets in prop::collection::vec(1_usize..400, 0..7),
        seed in any::<u64>(),
    ) {
        assert_same_matrix(n, &along(n, &offsets, seed), &bands(&offsets), seed);
    }

    #[test]
    fn any_springs_are_compressed_rows((n, edges) in graph(60), seed in any::<u64>()) {
        assert_same_springs(n, &edges, seed);
        let all = |coupling| BlockMatrix::new(n, &coupling, edges.iter().copied()).nonzeros();
        prop_assert_eq!(all(Coupling::Pairs), all(Coupling::Rows));
    }

    /// A block written to the place of an edge is the block of that edge, which no other edge
    /// shares.
    #[test]
    fn every_edge_remembers_its_spring((n, edges) in graph(30)) {
        let mut pairs = Pairs::new(n, edges.iter().copied());
        let SpringBlocks { own, springs, ends, slots, .. } = pairs.blocks_mut();
        prop_assert_eq!((own.len(), springs.len(), slots.len()), (n, ends.len(), edges.len()));
        for (&(i, j), &slot) in edges.iter().zip(slots).filter(|((i, j), _)| i != j) {
            prop_assert_eq!(ends[slot as usize], [i.min(j) as u32, i.max(j) as u32]);
            prop_assert_eq!(springs[slot as usize], [0.0; 4]);
            springs[slot as usize] = [0.0, 1.0, 2.0, 3.0];
        }
        prop_assert!(springs.iter().all(|spring| *spring == [0.0, 1.0, 2.0, 3.0]));
        let block = Mat3::new(3.0, 0.0, 0.0, 0.0, 4.0, 2.0, 0.0, 2.0, 7.0);
        for &(i, j) in edges.iter().filter(|(i, j)| i != j) {
            let count = edges.iter().filter(|edge| [(i, j), (j, i)].contains(edge)).count();
            prop_assert_eq!(pairs.get(i, j), -block * count as f64);
            prop_assert_eq!(pairs.get(j, i), -block * count as f64);
        }
    }

    #[test]
    fn products_match_the_dense_matrix((n, edges) in graph(8)) {
        let mut random = Random::new(6);
        let a = random_blocks(n, &edges, &mut random);
        let dense = dense_blocks(&a);
        prop_assert!((&dense - dense.transpose()).norm() < 1e-13);
        let x = random.vectors(n);
        prop_assert!((flat(&product(&a, &x)) - dense * flat(&x)).norm() < 1e-12);
    }

    #[test]
    fn projection_keeps_the_matrix_definite_and_cuts_all_couplings((n, edges) in graph(8)) {
        let mut random = Random::new(7);
        let mut a = random_blocks(n, &edges, &mut random);
        let before = dense_blocks(&a);
        let mut constraints = Constraints::free(n);
        for i in 0..n {
            constraints.set(i, random_filter(&mut random), Vec3::zeros());
        }
        a.project(&constraints);
        let after = dense_blocks(&a);
        let s = dense_filter(&constraints);
        let rest = nalgebra::DMatrix::identity(3 * n, 3 * n) - &s;
        prop_assert!((&s * &after * &s - &s * before * &s).norm() < 1e-11);
        prop_assert!((&s * &after * &rest).norm() < 1e-12);
        prop_assert!((&after - after.transpose()).norm() < 1e-12);
        prop_assert!(after.symmetric_eigenvalues().min() > 0.1);
    }
}

const LAYOUTS: fn() -> [Coupling; 3] = || [Coupling::Rows, Coupling::Pairs, bands(&[1])];

#[test]
fn pairs_annihilate_translations_and_general_ones_stay_symmetric() {
    let v = Random::new(8).vector();
    let b = Mat3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0);
    for coupling in LAYOUTS() {
        let mut a = BlockMatrix::new(2, &coupling, [(0, 1)]);
        a.add_pair(0, 1, &(v * v.transpose()));
        a.add_pair(1, 1, &Mat3::identity());
        let y = product(&a, &[Vec3::new(1.0, 2.0, 3.0); 2]);
        assert!(y[0].norm() < 1e-14 && y[1].norm() < 1e-14);
        a.clear();
        a.add_general_pair(1, 1, &b);
        a.add_general_pair(1, 0, &b);
        assert_eq!((a.get(1, 0), a.get(0, 1)), (-b, -b.transpose()));
        assert_eq!((a.get(1, 1), a.get(0, 0)), (b, b.transpose()));
        assert_eq!(a.coupling(), Coupling::Rows);
    }
}

#[test]
fn a_matrix_without_pairs_is_its_diagonal() {
    for coupling in LAYOUTS() {
        let mut a = BlockMatrix::new(2, &coupling, [(1, 1)]);
        a.add_pair(1, 1, &Mat3::identity());
        a.add_diagonal(1, &Mat3::from_diagonal_element(2.0));
        let y = product(&a, &[Vec3::x(), Vec3::new(1.0, 2.0, 3.0)]);
        assert_eq!(y, [Vec3::zeros(), Vec3::new(2.0, 4.0, 6.0)]);
        assert_eq!(a.get(0, 1), Mat3::zeros());
        a.clear();
        assert_eq!(product(&a, &[Vec3::x(); 2]), [Vec3::zeros(); 2]);
    }
}

#[test]
fn pairs_are_found_in_any_order() {
    let mut random = Random::new(9);
    let edges = [(0, 1), (1, 2), (2, 0), (3, 1), (1, 0)];
    let block = |k: usize| Mat3::from_diagonal_element((1 << k) as f64);
    let mut a = Rows::new(4, edges);
    for round in 0..40 {
        let mut fresh = Rows::new(4, edges);
        a.clear();
        let (count, twist) = (1 + round % 7, (5.0 * (random.unit() + 1.0)) as usize);
        for k in 0..count {
            let (i, j) = edges[if round % 3 == 0 { k } else { k * twist + round } % 5];
            for matrix in [&mut a, &mut fresh] {
                matrix.add_pair(i, j, &block(k));
                matrix.add_general_pair(j, i, &block(k + 9));
            }
        }
        assert_eq!(a.blocks(), fresh.blocks(), "{round}");
    }
}

#[test]
fn a_pair_outside_the_pattern_stops_debug_builds_and_is_left_out_of_others() {
    for coupling in LAYOUTS() {
        let mut a = BlockMatrix::new(3, &coupling, [(0, 1)]);
        let add = std::panic::AssertUnwindSafe(|| a.add_pair(2, 0, &Mat3::identity()));
        assert_eq!(std::panic::catch_unwind(add).is_err(), cfg!(debug_assertions), "{coupling:?}");
        assert_eq!(dense_blocks(&a).norm(), 0.0);
    }
}
