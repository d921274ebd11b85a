use super::sweeps::Sweeps;
use super::*;
use crate::test_support::{Random, dense_blocks, flat, graph, random_blocks, random_filter};
use crate::{
    BlockJacobi, Constraints, Coupling, Filter, LinearOperator, Mat3, Norm, PcgSettings,
    PcgWorkspace, Reference, SolveStatus, filtered_pcg, vector::dot,
};
use drape_kernels::blocks::BlockLayout;
use drape_kernels::testing::mesh_edges;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// The springs of a graph, all alike.
fn springs(n: usize, edges: &[(usize, usize)]) -> ScalarMatrix {
    let mut a = ScalarMatrix::with_pattern(n, edges.iter().copied());
    edges.iter().for_each(|&(i, j)| a.add_edge(i, j, 1.0));
    a
}

/// Structural and shear springs of a sheet, `M + h² K` with `h² k/m = theta`, a little wrinkled and
/// stretched.
fn sheet(side: usize, theta: f64) -> (BlockMatrix, ScalarMatrix) {
    let mut random = Random::new(3);
    let at = |i: usize| Vec3::new((i % side) as f64, (i / side) as f64, 0.0);
    let x: Vec<Vec3> = (0..side * side).map(|i| at(i) * 1.01 + random.vector() * 0.05).collect();
    let edges: Vec<_> = [(0, 1, 1.0), (1, 0, 1.0), (1, 1, 0.1), (1, -1, 0.1)]
        .into_iter()
        .flat_map(|(down, right, stiffness)| {
            let edges = mesh_edges(side, side, &[(down, right)]);
            edges.into_iter().map(move |(i, j)| (i, j, stiffness))
        })
        .collect();
    let pairs = || edges.iter().map(|&(i, j, _)| (i, j));
    let mut a = BlockMatrix::with_pattern(side * side, pairs());
    let mut springs = ScalarMatrix::with_pattern(side * side, pairs());
    (0..side * side).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
    for &(i, j, stiffness) in &edges {
        let (d, rest) = (x[i] - x[j], (at(i) - at(j)).norm());
        let u = d.normalize();
        let across = (1.0 - rest / d.norm()).max(0.0);
        let block = u * u.transpose() * (1.0 - across) + Mat3::identity() * across;
        a.add_pair(i, j, &(block * (theta * stiffness)));
        springs.add_edge(i, j, stiffness);
    }
    (a, springs)
}

#[test]
fn a_cycle_costs_a_few_products_and_its_set_up_some_more() {
    for (side, cycle, update) in [(20, 3..=8, 5..=30), (60, 3..=4, 5..=15)] {
        let (a, springs) = sheet(side, 1e4);
        let products = Multigrid::new(&a, &springs).unwrap().products();
        assert!(cycle.contains(&products.cycle), "{products:?}");
        assert!(update.contains(&products.update), "{products:?}");
    }
}

/// Random constraints, which give blocks that are not symmetric.
fn constrain(a: &mut BlockMatrix, random: &mut Random) {
    let mut constraints = Constraints::free(a.n());
    (0..a.n()).for_each(|i| constraints.set(i, random_filter(random), Vec3::zeros()));
    a.project(&constraints);
}

fn dense(p: &Prolongation) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(p.rows(), p.columns());
    for i in 0..p.rows() {
        p.row(i).iter().for_each(|&(j, weight)| dense[(i, j as usize)] = weight);
    }
    dense
}

/// Iterations of CG to `1e-8`.
fn iterations(a: &BlockMatrix, p: &dyn Preconditioner, b: &[Vec3]) -> usize {
    let mut x = vec![Vec3::zeros(); a.n()];
    let settings = PcgSettings { forcing_term: 1e-8, norm: Norm::Euclid, max_iterations: 10_000 };
    let (none, mut workspace) = (Constraints::free(a.n()), PcgWorkspace::new(a.n()));
    let reference = Reference::FilteredRightHandSide;
    let solve = filtered_pcg(a, p, &none, b, &mut x, reference, &settings, &mut workspace);
    assert_eq!(solve.status, SolveStatus::Converged);
    let mut left = x.clone();
    a.multiply(&x, &mut left);
    left.iter_mut().zip(b).for_each(|(left, b)| *left -= b);
    assert!(dot(&left, &left) <= 1.1e-16 * dot(b, b));
    solve.iterations
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_cycle_is_a_symmetric_positive_definite_approximation_of_the_inverse(
        (n, edges) in graph(400),
        constrained in any::<bool>(),
    ) {
        let mut random = Random::new(11);
        let mut a = random_blocks(n, &edges, &mut random);
        if constrained {
            constrain(&mut a, &mut random);
        }
        let mut multigrid = Multigrid::new(&a, &springs(n, &edges)).unwrap();
        multigrid.update(&a).unwrap();
        let cycle = &multigrid;
        let (b, c) = (random.vectors(n), random.vectors(n));
        let (mut pb, mut pc) = (b.clone(), c.clone());
        cycle.apply(&b, &mut pb);
        cycle.apply(&c, &mut pc);
        prop_assert!((dot(&pb, &c) - dot(&b, &pc)).abs() < 1e-10 * dot(&b, &b));
        prop_assert!(dot(&pb, &b) > 0.0);
        iterations(&a, cycle, &b);
    }

    #[test]
    fn coarse_matrices_are_galerkins_and_constants_are_kept((n, edges) in graph(300)) {
        let mut random = Random::new(12);
        let a = random_blocks(n, &edges, &mut random);
        let couplings = springs(n, &edges);
        let prolongation = smoothed(&couplings);
        for i in 0..n {
            let sum: f64 = prolongation.row(i).iter().map(|entry| entry.1).sum();
            prop_assert!((sum - 1.0).abs() < 1e-14);
        }
        let p = dense(&prolongation);
        let scalar = prolongation.galerkin(&couplings);
        let expected = p.transpose() * crate::test_support::dense(&couplings) * &p;
        prop_assert!((crate::test_support::dense(&scalar) - expected).norm() < 1e-11);
        let mut level = Level::new(a.rows().pattern(), prolongation);
        level.coarsen(&a.rows());
        level.coarsen(&a.rows()); // the values before do not matter
        let p = p.kronecker(&DMatrix::<f64>::identity(3, 3));
        let expected = p.transpose() * dense_blocks(&a) * p;
        let coarse = dense_blocks(&BlockMatrix::from(level.coarse().clone()));
        prop_assert!((&coarse - expected).norm() < 1e-11 * (1.0 + coarse.norm()));
        prop_assert_eq!(&coarse, &coarse.transpose());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// `(D + L) z = r` with the residual `−Lᵀ z`, then `(D + Lᵀ) z = r − L z`. Constraints give
    /// blocks that are not symmetric.
    #[test]
    fn sweeps_solve_with_the_triangles_of_the_matrix(
        (n, edges) in graph(60),
        constrained in any::<bool>(),
    ) {
        let mut random = Random::new(13);
        let mut a = random_blocks(n, &edges, &mut random);
        if constrained {
            constrain(&mut a, &mut random);
        }
        let mut sweeps = Sweeps::new(a.rows().pattern());
        sweeps.read(&a).unwrap();
        let dense = dense_blocks(&a);
        let lower = DMatrix::from_fn(3 * n, 3 * n, |i, j| {
            if i / 3 > j / 3 { dense[(i, j)] } else { 0.0 }
        });
        let diagonal = &dense - &lower - lower.transpose();
        let lanes = |x: &[Vec3]| -> Vec<Lanes> { x.iter().map(|x| [x.x, x.y, x.z, 7.0]).collect() };
        let numbers = |x: &[Lanes]| {
            DVector::from_iterator(3 * n, x.iter().flat_map(|x| [x[0], x[1], x[2]]))
        };
        let (mut r, mut left) = (lanes(&random.vectors(n)), lanes(&random.vectors(n)));
        let mut z = left.clone();
        sweeps.forward(&r, &mut z, &mut left);
        let (first, right) = (numbers(&z), numbers(&r));
        prop_assert!(((&diagonal + &lower) * &first - &right).norm() < 1e-11);
        prop_assert!((&right - &dense * &first - numbers(&left)).norm() < 1e-11);
        sweeps.backward(&mut r, &mut z);
        let second = (&diagonal + lower.transpose()) * numbers(&z);
        prop_assert!((second + &lower * first - right).norm() < 1e-11);
    }
}

/// A cycle for a matrix, and one after its coarse matrices have been kept.
fn cycles(a: &BlockMatrix, edges: &[(usize, usize)], b: &[Vec3]) -> [Vec<Vec3>; 2] {
    let mut multigrid = Multigrid::new(a, &springs(a.n(), edges)).unwrap();
    [Multigrid::update, Multigrid::keep].map(|read| {
        read(&mut multigrid, a).unwrap();
        let mut z = b.to_vec();
        multigrid.apply(b, &mut z);
        z
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn bands_have_the_cycles_of_compressed_rows(
        n in 1_usize..300,
        offsets in prop::collection::vec(1_usize..40, 1..4),
    ) {
        let mut random = Random::new(14);
        let edges: Vec<_> = offsets
            .iter()
            .flat_map(|o| (0..n.saturating_sub(*o)).map(move |i| (i, i + o)))
            .collect();
        let rows = Coupling::Rows;
        let mut matrices = [rows, Coupling::Bands(offsets)]
            .map(|coupling| BlockMatrix::new(n, &coupling, edges.iter().copied()));
        for a in &mut matrices {
            let mut random = random.clone();
            (0..n).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
            for &(i, j) in &edges {
                let d = random.vector();
                a.add_pair(i, j, &(d * d.transpose()));
            }
        }
        let b = random.vectors(n);
        let [expected, found] = matrices.map(|a| cycles(&a, &edges, &b));
        prop_assert_eq!(&expected[0], &expected[1]);
        prop_assert_eq!(expected, found);
    }

    /// Two springs may join the same particles, and one may join a particle to itself.
    #[test]
    fn springs_in_any_order_have_the_cycles_of_compressed_rows((n, edges) in graph(300)) {
        let mut random = Random::new(15);
        let unit = 3.0;
        let mut rows = BlockMatrix::with_pattern(n, edges.iter().copied());
        let mut pairs = BlockMatrix::new(n, &Coupling::Pairs, edges.iter().copied());
        (0..n).for_each(|i| rows.add_diagonal(i, &Mat3::identity()));
        let Some(BlockLayout::Pairs(layout)) = pairs.fast_layout() else {
            panic!("springs in any order have a fast layout");
        };
        layout.own.fill(1.0);
        *layout.unit = unit;
        for (&(i, j), &slot) in edges.iter().zip(layout.slots) {
            let (w, a) = (random.vector(), random.unit().abs());
            rows.add_pair(i, j, &(Mat3::from_diagonal_element(a) + unit * w * w.transpose()));
            if i != j {
                layout.springs[slot as usize] = [w.x, w.y, w.z, a];
            }
        }
        let b = random.vectors(n);
        let [expected, found] = [rows, pairs].map(|a| cycles(&a, &edges, &b));
        for (expected, found) in expected.iter().zip(&found) {
            prop_assert!((flat(expected) - flat(found)).norm() < 1e-10 * flat(expected).norm());
        }
    }
}

#[test]
fn iterations_hardly_grow_with_the_sheet_and_are_far_fewer_than_with_diagonal_blocks() {
    let mut counts = Vec::new();
    for side in [20, 40] {
        let (a, springs) = sheet(side, 1e4);
        let mut multigrid = Multigrid::new(&a, &springs).unwrap();
        assert!(multigrid.sizes().count() > 1);
        multigrid.update(&a).unwrap();
        let b = Random::new(4).vectors(a.n());
        let mut jacobi = BlockJacobi::new(&a);
        jacobi.update(&a).unwrap();
        let (with, without) = (iterations(&a, &multigrid, &b), iterations(&a, &jacobi, &b));
        assert!(5 * with < without, "{with}, {without}");
        counts.push(with);
    }
    assert!(2 * counts[1] < 3 * counts[0], "{counts:?}");
}

#[test]
fn levels_shrink_down_to_the_coarsest() {
    let (a, couplings) = sheet(40, 1.0);
    let multigrid = Multigrid::new(&a, &couplings).unwrap();
    let sizes: Vec<usize> = multigrid.sizes().collect();
    assert_eq!(sizes[0], 1600);
    assert!(sizes.windows(2).all(|pair| 3 * pair[1] < pair[0]), "{sizes:?}");
    assert!(*sizes.last().unwrap() <= COARSEST);
    // Many equal neighbours, and one particle that all others are coupled to.
    let near =
        |i: usize, j: usize| (i % 40).abs_diff(j % 40) <= 2 && (i / 40).abs_diff(j / 40) <= 2;
    let wide: Vec<(usize, usize)> = (0..1600)
        .flat_map(|i| (i + 1..1600.min(i + 90)).map(move |j| (i, j)))
        .filter(|&(i, j)| near(i, j))
        .collect();
    let star: Vec<(usize, usize)> = (1..1600).map(|i| (0, i)).collect();
    for edges in [wide, star] {
        let a = BlockMatrix::with_pattern(1600, edges.iter().copied());
        let multigrid = Multigrid::new(&a, &springs(1600, &edges)).unwrap();
        let sizes: Vec<usize> = multigrid.sizes().collect();
        assert!(*sizes.last().unwrap() <= COARSEST, "{sizes:?}");
    }
}

#[test]
fn constrained_directions_stay_out() {
    let (mut a, springs) = sheet(12, 1e3);
    let mut random = Random::new(6);
    let mut constraints = Constraints::free(a.n());
    constraints.set(0, Filter::Fixed, Vec3::zeros());
    for i in [5, 60, 143] {
        constraints.set(i, random_filter(&mut random), Vec3::zeros());
    }
    a.project(&constraints);
    let mut multigrid = Multigrid::new(&a, &springs).unwrap();
    multigrid.update(&a).unwrap();
    let mut b = random.vectors(a.n());
    constraints.project(&mut b);
    let mut z = b.clone();
    multigrid.apply(&b, &mut z);
    let mut projected = z.clone();
    constraints.project(&mut projected);
    assert!((flat(&z) - flat(&projected)).norm() < 1e-14 * flat(&z).norm());
    iterations(&a, &multigrid, &b);
}

#[test]
fn without_a_matrix_it_is_the_identity_and_an_indefinite_one_is_refused() {
    let (a, springs) = sheet(12, 1e3);
    let mut multigrid = Multigrid::new(&a, &springs).unwrap();
    let b = Random::new(5).vectors(a.n());
    let mut z = vec![Vec3::zeros(); a.n()];
    multigrid.apply(&b, &mut z);
    assert_eq!(z, b);
    multigrid.update(&a).unwrap();
    let mut bad = a.clone();
    bad.add_diagonal(77, &Mat3::from_diagonal_element(-1e6));
    let error = multigrid.update(&bad).unwrap_err();
    assert!(
        matches!(error, SolverError::NotPositiveDefinite { row: 231, pivot: Some(_) }),
        "{error:?}"
    );
    multigrid.apply(&b, &mut z);
    assert_eq!(z, b);
    let other = sheet(13, 1.0).0;
    assert!(matches!(multigrid.update(&other), Err(SolverError::PatternChanged { .. })));
    multigrid.update(&a).unwrap();
    multigrid.apply(&b, &mut z);
    assert_ne!(z, b);
}

/// The coarse matrices stay, and the finest one is smoothed by its own diagonal blocks.
#[test]
fn kept_coarse_matrices_serve_a_matrix_that_is_alike() {
    let ((a, springs), mut random) = (sheet(24, 1e4), Random::new(8));
    let alike = {
        let mut alike = a.clone();
        (0..a.n()).for_each(|i| alike.add_diagonal(i, &Mat3::from_diagonal_element(0.5)));
        let couples = (1..a.n()).filter(|i| i % 24 > 0);
        couples.for_each(|i| alike.add_pair(i - 1, i, &Mat3::from_diagonal_element(0.5)));
        alike
    };
    let b = random.vectors(a.n());
    let cycle = |multigrid: &Multigrid| {
        let mut z = b.clone();
        multigrid.apply(&b, &mut z);
        z
    };
    let coarse = |multigrid: &Multigrid| -> Vec<DMatrix<f64>> {
        let levels = multigrid.levels.iter();
        levels.map(|level| dense_blocks(&BlockMatrix::from(level.coarse().clone()))).collect()
    };
    let [mut kept, mut renewed] = [(); 2].map(|()| Multigrid::new(&a, &springs).unwrap());
    // Without an update before, there is nothing to keep.
    kept.keep(&a).unwrap();
    renewed.update(&a).unwrap();
    assert_eq!(cycle(&kept), cycle(&renewed));
    // The same matrix once more changes nothing.
    kept.keep(&a).unwrap();
    assert_eq!(cycle(&kept), cycle(&renewed));
    let before = coarse(&kept);
    kept.keep(&alike).unwrap();
    renewed.update(&alike).unwrap();
    assert_eq!(coarse(&kept), before);
    assert_ne!(coarse(&renewed), before);
    let [expected, own] = [&renewed, &kept].map(|m| m.levels[0].sweeps().inverse());
    assert_eq!(own, expected, "the finest level is smoothed by its own blocks");
    let [expected, own] = [&renewed, &kept].map(|m| m.levels[0].lower());
    assert_eq!(own, expected, "on the diagonal and beside it");
    assert_ne!(cycle(&kept), cycle(&renewed));
    let c = random.vectors(a.n());
    let (pb, mut pc) = (cycle(&kept), c.clone());
    kept.apply(&c, &mut pc);
    assert!((dot(&pb, &c) - dot(&b, &pc)).abs() < 1e-10 * dot(&b, &b), "it stays symmetric");
    let counts = [&kept, &renewed].map(|m| iterations(&alike, m, &b));
    assert!(counts[0] <= counts[1] + 4, "{counts:?}");
}

#[test]
fn a_matrix_that_cannot_be_kept_for_is_refused() {
    // On 7 × 7 particles there is one level, which is factorised anew.
    for side in [7, 12] {
        let (a, springs) = sheet(side, 1e3);
        let mut multigrid = Multigrid::new(&a, &springs).unwrap();
        assert_eq!(multigrid.levels.is_empty(), side == 7);
        multigrid.update(&a).unwrap();
        let b = Random::new(5).vectors(a.n());
        let mut bad = a.clone();
        bad.add_diagonal(30, &Mat3::from_diagonal_element(-1e6));
        let error = multigrid.keep(&bad).unwrap_err();
        assert!(matches!(error, SolverError::NotPositiveDefinite { .. }), "{error:?}");
        let mut z = vec![Vec3::zeros(); a.n()];
        multigrid.apply(&b, &mut z);
        assert_eq!(z, b, "the identity");
        let other = sheet(side + 1, 1.0).0;
        multigrid.update(&a).unwrap();
        assert!(matches!(multigrid.keep(&other), Err(SolverError::PatternChanged { .. })));
        // After a failure everything is made anew.
        let mut fresh = Multigrid::new(&a, &springs).unwrap();
        fresh.update(&a).unwrap();
        multigrid.keep(&a).unwrap();
        let mut expected = z.clone();
        fresh.apply(&b, &mut expected);
        multigrid.apply(&b, &mut z);
        assert_eq!(z, expected);
    }
}

/// As many couplings, but other ones, in every layout.
#[test]
fn another_pattern_is_refused() {
    let n = 90;
    let chain: Vec<_> = (1..n).map(|i| (i - 1, i)).collect();
    let star: Vec<_> = (1..n).map(|i| (0, i)).collect();
    let matrix = |edges: &[(usize, usize)], coupling: &Coupling| {
        let mut a = BlockMatrix::new(n, coupling, edges.iter().copied());
        (0..n).for_each(|i| a.add_diagonal(i, &Mat3::identity()));
        a
    };
    let bands = |offset| Coupling::Bands(vec![offset]);
    for coupling in [Coupling::Rows, Coupling::Pairs, bands(1)] {
        let a = matrix(&chain, &coupling);
        let mut multigrid = Multigrid::new(&a, &springs(n, &chain)).unwrap();
        for layout in [Coupling::Rows, Coupling::Pairs, bands(1)] {
            multigrid.update(&matrix(&chain, &layout)).unwrap();
            multigrid.keep(&matrix(&chain, &layout)).unwrap();
        }
        let others = [Coupling::Rows, Coupling::Pairs].map(|layout| matrix(&star, &layout));
        for other in others.into_iter().chain([matrix(&chain, &bands(2))]) {
            let error = multigrid.update(&other).unwrap_err();
            assert!(matches!(error, SolverError::PatternChanged { .. }), "{coupling:?}");
            assert!(multigrid.keep(&other).is_err());
        }
    }
}

#[test]
fn particles_without_springs_and_empty_systems_are_no_trouble() {
    let mut a = BlockMatrix::with_pattern(200, []);
    (0..200).for_each(|i| a.add_diagonal(i, &Mat3::from_diagonal_element(2.0)));
    let mut multigrid = Multigrid::new(&a, &springs(200, &[])).unwrap();
    multigrid.update(&a).unwrap();
    let b = Random::new(5).vectors(200);
    let mut z = b.clone();
    multigrid.apply(&b, &mut z);
    assert!((flat(&z) * 2.0 - flat(&b)).norm() < 1e-14);
    let empty = BlockMatrix::with_pattern(0, []);
    let mut multigrid = Multigrid::new(&empty, &springs(0, &[])).unwrap();
    assert!(multigrid.sizes().eq([0]));
    multigrid.update(&empty).unwrap();
    multigrid.apply(&[], &mut []);
}
