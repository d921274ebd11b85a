//! The fast kernels against the readable ones, bit for bit.

use super::*;
use crate::test_support::{Random, graph, laplacian, random_filter};
use crate::vector::{extrapolate, norm, subtract_from};
use crate::{
    Filter, Identity, IncompleteCholesky, Jacobi, Norm, PcgWorkspace, Preconditioner, SolveStatus,
    Vec3, filtered_pcg,
};
use drape_kernels::testing::{Bits, assert_same_bits, mesh_edges};
use proptest::prelude::*;

const STRUCTURE: [(usize, isize); 2] = [(0, 1), (1, 0)];
const SHEAR: [(usize, isize); 4] = [(0, 1), (1, 0), (1, 1), (1, -1)];
const BENDING: [(usize, isize); 6] = [(0, 1), (1, 0), (1, 1), (1, -1), (0, 2), (2, 0)];

#[derive(Clone, Debug)]
struct Case {
    rows: usize,
    columns: usize,
    springs: usize,
    seed: u64,
    /// Constrained particles in a thousand.
    constrained: usize,
    moving: bool,
    /// 0: none, 1: Jacobi, 2: IC(0).
    preconditioner: usize,
    norm: Norm,
    absolute: bool,
    digits: i32,
    max_iterations: usize,
}

fn cases() -> impl Strategy<Value = Case> {
    let shape = (1_usize..40, 3_usize..40, 0_usize..3, any::<u64>());
    let norm = prop_oneof![Just(Norm::Euclid), Just(Norm::Preconditioned)];
    let constraints = (prop_oneof![Just(0), Just(3), Just(200), Just(1000)], any::<bool>());
    let solve = (0_usize..3, norm, any::<bool>(), 0..18, prop_oneof![Just(0), Just(3), Just(400)]);
    (shape, constraints, solve).prop_map(
        |(
            (rows, columns, springs, seed),
            (constrained, moving),
            (preconditioner, norm, absolute, digits, max_iterations),
        )| Case {
            rows,
            columns,
            springs,
            seed,
            constrained,
            moving,
            preconditioner,
            norm,
            absolute,
            digits,
            max_iterations,
        },
    )
}

/// By diagonals, in this many bands.
fn banded(a: &ScalarMatrix, bands: usize) -> Option<ScalarPcg> {
    let mut solver = ScalarPcg::with_layout(a, true, ScalarLayout::Diagonals)?;
    if let Layout::Diagonals(fused) = &mut solver.0 {
        fused.set_bands(bands);
    }
    Some(solver)
}

/// Solves twice in each layout that suits, with several numbers of bands: the memory of the first
/// solve must not matter.
fn compare(a: &ScalarMatrix, case: &Case) -> PcgReport {
    let mut random = Random::new(case.seed);
    let n = a.n();
    let mut constraints = Constraints::free(n);
    for i in 0..n {
        if 500.0 * (1.0 + random.unit()) < case.constrained as f64 {
            let value = if case.moving { random.vector() } else { Vec3::zeros() };
            constraints.set(i, random_filter(&mut random), value);
        }
    }
    let (mut jacobi, mut factor) = (Jacobi::new(a), IncompleteCholesky::new(a));
    jacobi.update(a).unwrap();
    factor.update(a, None).unwrap();
    let (p, fast_p): (&dyn Preconditioner, _) = match case.preconditioner {
        0 => (&Identity, ScalarPreconditioner::Identity),
        1 => (&jacobi, ScalarPreconditioner::Jacobi(&jacobi)),
        _ => (&factor, ScalarPreconditioner::Ic0(&factor)),
    };
    let settings = PcgSettings {
        forcing_term: 10_f64.powi(-case.digits),
        norm: case.norm,
        max_iterations: case.max_iterations,
    };
    let reference =
        if case.absolute { Reference::Absolute(3.0) } else { Reference::FilteredRightHandSide };
    let mut solvers: Vec<_> = [ScalarLayout::Diagonals, ScalarLayout::Rows]
        .into_iter()
        .filter_map(|layout| ScalarPcg::with_layout(a, case.preconditioner < 2, layout))
        .collect();
    if case.preconditioner < 2 {
        solvers.extend([2, 3, 5].into_iter().filter_map(|bands| banded(a, bands)));
    }
    solvers.iter_mut().for_each(|solver| solver.update(a, fast_p));
    let mut workspace = PcgWorkspace::new(n);
    let mut last = None;
    for _ in 0..2 {
        let (b, last_term, before) = (random.vectors(n), random.vectors(n), random.vectors(n));
        let mut given = random.vectors(n);
        extrapolate(&last_term, &before, &mut given);
        let mut x = given.clone();
        let expected =
            filtered_pcg(a, p, &constraints, &b, &mut x, reference, &settings, &mut workspace);
        let starts = [
            (StartValue::Given, &given),
            (StartValue::At(&given), &b),
            (StartValue::Extrapolated { last: &last_term, before: &before }, &b),
        ];
        for (start, held) in starts {
            for solver in &mut solvers {
                let mut y = held.clone();
                let report =
                    solver.solve(a, fast_p, &constraints, &b, start, &mut y, reference, &settings);
                let layout = solver.layout();
                let residuals = [expected, report].map(|r| r.relative_residual);
                assert_same_bits((layout, report), &residuals[0], &residuals[1]);
                // The rest, apart from that number: it may be NaN, which equals nothing.
                let [ours, theirs] =
                    [report, expected].map(|report| PcgReport { relative_residual: 0.0, ..report });
                assert_eq!(ours, theirs, "{layout:?}");
                assert_same_bits(layout, &x, &y);
            }
        }
        compare_residuals(a, &constraints, &b, &x, &mut solvers);
        last = Some(expected);
    }
    last.unwrap()
}

/// The fast product against the readable one.
fn compare_products(a: &ScalarMatrix, seed: u64) {
    let mut random = Random::new(seed);
    let x = random.vectors(a.n());
    let mut expected = x.clone();
    a.multiply(&x, &mut expected);
    for bands in 1..4 {
        let padded = ScalarPcg::with_layout(a, true, ScalarLayout::Rows);
        for mut fast in banded(a, bands).into_iter().chain(padded) {
            let mut out = random.vectors(a.n());
            fast.update(a, ScalarPreconditioner::Identity);
            fast.multiply(a, &x, &mut out);
            assert_same_bits(bands, &expected, &out);
        }
    }
}

/// The residual of `x` and its norms against their definitions, for particles that are free or
/// held: a plane would filter twice and round twice.
fn compare_residuals(
    a: &ScalarMatrix,
    constraints: &Constraints,
    b: &[Vec3],
    x: &[Vec3],
    solvers: &mut [ScalarPcg],
) {
    let mut held = Constraints::free(x.len());
    for &i in constraints.constrained() {
        held.set(i as usize, Filter::Fixed, constraints.prescribed(i as usize));
    }
    let constraints = &held;
    let mut x = x.to_vec();
    constraints.impose(&mut x);
    let residual_of = |x: &[Vec3]| {
        let mut r = vec![Vec3::zeros(); x.len()];
        a.multiply(x, &mut r);
        subtract_from(b, &mut r);
        constraints.project(&mut r);
        r
    };
    let residual = residual_of(&x);
    let mut prescribed = x.clone();
    constraints.prescribed_only(&mut prescribed);
    let reference = norm(&residual_of(&prescribed));
    for solver in solvers {
        for with_reference in [false, true] {
            let mut y = x.clone();
            let norms = solver.residual_norms(a, constraints, b, &mut y, with_reference);
            assert_same_bits("residual", &norm(&residual), &norms.residual);
            assert_same_bits("reference", &with_reference.then_some(reference), &norms.reference);
            let mut out = vec![Vec3::repeat(f64::NAN); x.len()];
            solver.residual(&mut out);
            assert_same_bits("r, x", &(&residual, &x), &(&out, &y));
        }
    }
}

proptest! {
    #[test]
    fn solves_on_meshes_have_the_bits_of_the_readable_kernels(case in cases()) {
        let steps: &[_] = [&STRUCTURE[..], &SHEAR, &BENDING][case.springs];
        let edges = mesh_edges(case.rows, case.columns, steps);
        let mut random = Random::new(case.seed ^ 1);
        let a = laplacian(case.rows * case.columns, &edges, 0.5, || 10_f64.powf(random.unit()));
        compare(&a, &case);
        compare_products(&a, case.seed);
    }

    #[test]
    fn solves_on_any_graph_have_the_bits_of_the_readable_kernels(
        (n, edges) in graph(600),
        case in cases(),
    ) {
        let mut random = Random::new(case.seed ^ 2);
        let a = laplacian(n, &edges, 0.5, || 10_f64.powf(random.unit()));
        compare(&a, &case);
        compare_products(&a, case.seed);
    }
}

#[test]
fn meshes_are_kept_by_diagonals_and_other_graphs_by_rows() {
    let layout = |n, edges: &[(usize, usize)]| {
        ScalarPcg::new(&laplacian(n, edges, 1.0, || 1.0), true).layout()
    };
    for steps in [&STRUCTURE[..], &SHEAR, &BENDING] {
        assert_eq!(layout(400, &mesh_edges(20, 20, steps)), ScalarLayout::Diagonals);
    }
    let star: Vec<_> = (1..50).map(|i| (0, i)).collect();
    assert_eq!(layout(50, &star), ScalarLayout::Rows);
    assert_eq!(layout(50, &[(0, 49), (3, 9)]), ScalarLayout::Rows);
    let mesh = laplacian(400, &mesh_edges(20, 20, &STRUCTURE), 1.0, || 1.0);
    assert_eq!(ScalarPcg::new(&mesh, false).layout(), ScalarLayout::Rows);
}

#[test]
fn residuals_that_part_are_refreshed_alike() {
    let edges = mesh_edges(20, 20, &STRUCTURE);
    for weight in [1.0, 1e6] {
        let a = laplacian(400, &edges, 1.0, || weight);
        for (norm, preconditioner) in
            [(Norm::Euclid, 1), (Norm::Preconditioned, 0), (Norm::Euclid, 2)]
        {
            let case = Case {
                rows: 20,
                columns: 20,
                springs: 0,
                seed: 5,
                constrained: 3,
                moving: true,
                preconditioner,
                norm,
                absolute: false,
                digits: 18,
                max_iterations: 100_000,
            };
            let report = compare(&a, &case);
            assert!(report.iterations > 20 && report.multiplications > report.iterations + 3);
            assert_ne!(report.status, SolveStatus::IterationLimit);
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    // Above the size from which threads are used.
    let (rows, columns) = (131, 137);
    let n = rows * columns;
    let mut random = Random::new(11);
    let a = laplacian(n, &mesh_edges(rows, columns, &BENDING), 0.5, || 10_f64.powf(random.unit()));
    let mut jacobi = Jacobi::new(&a);
    jacobi.update(&a).unwrap();
    let p = ScalarPreconditioner::Jacobi(&jacobi);
    let mut constraints = Constraints::free(n);
    for i in (0..n).step_by(31) {
        constraints.set(i, random_filter(&mut random), random.vector());
    }
    // So small that the residual is computed anew on the way.
    let settings = PcgSettings { forcing_term: 1e-9, norm: Norm::Euclid, max_iterations: 400 };
    let (b, start) = (random.vectors(n), random.vectors(n));
    let solve = |threads| {
        let mut solver = ScalarPcg::new(&a, true);
        solver.update(&a, p);
        solver.set_threads(threads);
        let mut x = start.clone();
        let reference = Reference::FilteredRightHandSide;
        let report =
            solver.solve(&a, p, &constraints, &b, StartValue::Given, &mut x, reference, &settings);
        (report, x.bits())
    };
    let alone = solve(1);
    assert!(alone.0.multiplications > alone.0.iterations + 2);
    for threads in [2, 3, 5, 1000] {
        assert!(solve(threads) == alone, "{threads} threads");
    }
}

#[test]
fn a_solution_that_is_prescribed_is_taken() {
    let a = laplacian(9, &mesh_edges(3, 3, &STRUCTURE), 1.0, || 1.0);
    let p = ScalarPreconditioner::Identity;
    let mut constraints = Constraints::free(9);
    (0..9).for_each(|i| constraints.set(i, Filter::Fixed, Vec3::x() * i as f64));
    let settings = PcgSettings { forcing_term: 1e-3, norm: Norm::Euclid, max_iterations: 9 };
    let reference = Reference::FilteredRightHandSide;
    for layout in [ScalarLayout::Diagonals, ScalarLayout::Rows] {
        let mut fast = ScalarPcg::with_layout(&a, true, layout).unwrap();
        fast.update(&a, p);
        let mut x = Random::new(3).vectors(9);
        let b = [Vec3::y(); 9];
        let report =
            fast.solve(&a, p, &constraints, &b, StartValue::Given, &mut x, reference, &settings);
        assert_eq!((report.iterations, report.status), (0, SolveStatus::Converged));
        assert_eq!(x[8], Vec3::x() * 8.0);
    }
}
