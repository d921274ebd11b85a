//! Tests of filtered conjugate gradients.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::*;
use crate::test_support::{
    Random, dense, dense_blocks, dense_filter, diagonal, flat, graph, grid_edges, laplacian,
    random_blocks, random_filter,
};
use crate::vector::norm;
use crate::{CompleteCholesky, Filter, Identity, IncompleteCholesky, Jacobi, Mat3, ScalarMatrix};

const NORMS: [Norm; 2] = [Norm::Euclid, Norm::Preconditioned];

fn settings(forcing_term: f64, norm: Norm, max_iterations: usize) -> PcgSettings {
    PcgSettings { forcing_term, norm, max_iterations }
}

/// Solves from `x`, with the residual measured against the filtered right-hand side.
fn solve(
    a: &dyn LinearOperator,
    p: &dyn Preconditioner,
    constraints: &Constraints,
    b: &[Vec3],
    x: &mut [Vec3],
    settings: &PcgSettings,
) -> PcgReport {
    let reference = Reference::FilteredRightHandSide;
    let workspace = &mut PcgWorkspace::new(b.len());
    filtered_pcg(a, p, constraints, b, x, reference, settings, workspace)
}

/// Solves without constraints and preconditioner, from zero.
fn plain(a: &ScalarMatrix, b: &[Vec3], settings: &PcgSettings) -> (Vec<Vec3>, PcgReport) {
    let n = b.len();
    let mut x = vec![Vec3::zeros(); n];
    let report = solve(a, &Identity, &Constraints::free(n), b, &mut x, settings);
    (x, report)
}

#[test]
fn k_distinct_eigenvalues_take_k_iterations() {
    let b = Random::new(30).vectors(60);
    for k in 1..=8 {
        let values: Vec<f64> = (0..60).map(|i| 1.0 + (i % k) as f64).collect();
        for norm in NORMS {
            let (x, report) = plain(&diagonal(&values), &b, &settings(1e-10, norm, 100));
            assert_eq!((report.iterations, report.status), (k, SolveStatus::Converged));
            assert!((0..60).all(|i| (x[i] * values[i] - b[i]).norm() < 1e-8));
        }
    }
}

#[test]
fn the_error_obeys_the_chebyshev_bound() {
    let n = 200;
    let values: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
    let a = diagonal(&values);
    let b = Random::new(31).vectors(n);
    let energy = |x: &[Vec3]| -> f64 {
        (0..n).map(|i| values[i] * (x[i] - b[i] / values[i]).norm_squared()).sum::<f64>().sqrt()
    };
    let start = energy(&vec![Vec3::zeros(); n]);
    let root = (n as f64).sqrt();
    for k in 1..60 {
        let (x, report) = plain(&a, &b, &settings(0.0, Norm::Euclid, k));
        assert_eq!((report.iterations, report.status), (k, SolveStatus::IterationLimit));
        let bound = 2.0 * ((root - 1.0) / (root + 1.0)).powi(k as i32);
        assert!(energy(&x) <= bound * start);
    }
}

#[test]
fn one_solve_over_all_coordinates_is_not_three_solves() {
    // Each coordinate alone meets one eigenvalue; together they meet three.
    let a = diagonal(&[1.0, 2.0, 3.0]);
    let b = [Vec3::x(), Vec3::y(), Vec3::z()];
    let precise = settings(1e-10, Norm::Euclid, 100);
    for k in 0..3 {
        let mut alone = [Vec3::zeros(); 3];
        alone[k] = b[k];
        assert_eq!(plain(&a, &alone, &precise).1.iterations, 1);
    }
    assert_eq!(plain(&a, &b, &precise).1.iterations, 3);
}

#[test]
fn a_complete_factor_needs_one_iteration_and_better_preconditioners_need_fewer() {
    let n = 400;
    let edges = grid_edges(20);
    let mut random = Random::new(32);
    // Stiffness varies by two orders, so the diagonal helps.
    let a = laplacian(n, &edges, 0.01, || 10_f64.powf(random.unit()));
    let mut jacobi = Jacobi::new(&a);
    let mut incomplete = IncompleteCholesky::new(&a);
    let mut complete = CompleteCholesky::new(&a).unwrap();
    jacobi.update(&a).unwrap();
    incomplete.update(&a, None).unwrap();
    complete.update(&a, None).unwrap();
    let b = random.vectors(n);
    let preconditioners: [&dyn Preconditioner; 4] = [&Identity, &jacobi, &incomplete, &complete];
    let mut counts = Vec::new();
    for p in preconditioners {
        let mut x = vec![Vec3::zeros(); n];
        let report =
            solve(&a, p, &Constraints::free(n), &b, &mut x, &settings(1e-8, Norm::Euclid, 1000));
        assert_eq!(report.status, SolveStatus::Converged);
        let mut impulse = x.clone();
        constraint_impulse(&a, &b, &x, &mut impulse);
        assert!(norm(&impulse) <= 1.001e-8 * norm(&b));
        counts.push(report.iterations);
    }
    assert!(counts.is_sorted_by(|more, fewer| more > fewer), "{counts:?}");
    assert_eq!(counts[3], 1);
}

/// The solution of the filtered problem by dense algebra.
fn dense_filtered(a: &DMatrix<f64>, constraints: &Constraints, b: &[Vec3]) -> DVector<f64> {
    let s = dense_filter(constraints);
    let rest = DMatrix::identity(s.nrows(), s.nrows()) - &s;
    let mut prescribed = b.to_vec();
    constraints.prescribed_only(&mut prescribed);
    let z = flat(&prescribed);
    let system = &s * a * &s + &rest;
    let free = system.lu().solve(&(&s * (flat(b) - a * &z))).unwrap();
    s * free + z
}

proptest! {
    #[test]
    fn constrained_problems_are_solved_as_by_dense_projection((n, edges) in graph(10), seed in 0_u64..1000) {
        let mut random = Random::new(seed);
        let blocks = random_blocks(n, &edges, &mut random);
        let scalars = laplacian(n, &edges, 1.0, || random.unit().abs());
        let scalars_as_blocks = dense(&scalars).kronecker(&DMatrix::identity(3, 3));
        let mut jacobi = Jacobi::new(&scalars);
        jacobi.update(&scalars).unwrap();
        let mut constraints = Constraints::free(n);
        let z = random.vectors(n);
        for i in 0..n {
            constraints.set(i, random_filter(&mut random), z[i]);
        }
        let b = random.vectors(n);
        let start = random.vectors(n);
        let cases: [(&dyn LinearOperator, &DMatrix<f64>); 2] =
            [(&blocks, &dense_blocks(&blocks)), (&scalars, &scalars_as_blocks)];
        for (a, a_dense) in cases {
            let expected = dense_filtered(a_dense, &constraints, &b);
            let preconditioners: [&dyn Preconditioner; 2] = [&Identity, &jacobi];
            for (p, norm_used) in preconditioners.into_iter().zip(NORMS) {
                let mut x = start.clone();
                let mut workspace = PcgWorkspace::new(n);
                let report = filtered_pcg(
                    a,
                    p,
                    &constraints,
                    &b,
                    &mut x,
                    Reference::FilteredRightHandSide,
                    &settings(1e-11, norm_used, 500),
                    &mut workspace,
                );
                prop_assert_eq!(report.status, SolveStatus::Converged);
                prop_assert!((flat(&x) - &expected).norm() < 1e-8);
                // Prescribed values hold although the start did not know them.
                for i in 0..n {
                    let held = constraints.filter(i).complement(x[i]);
                    prop_assert!((held - constraints.prescribed(i)).norm() < 1e-13);
                }
                // The impulse acts in constrained directions only, and r is its free part.
                let mut impulse = x.clone();
                constraint_impulse(a, &b, &x, &mut impulse);
                let mut free = impulse.clone();
                constraints.project(&mut free);
                prop_assert!(norm(&free) < 1e-8);
                prop_assert!((flat(&free) + flat(workspace.residual())).norm() < 1e-12);
            }
        }
    }
}

#[test]
fn factors_of_the_free_rows_precondition_a_pinned_problem() {
    let n = 100;
    let a = laplacian(n, &grid_edges(10), 0.1, || 1.0);
    let mut constraints = Constraints::free(n);
    for i in [0, 9, 44] {
        constraints.set(i, Filter::Fixed, Vec3::new(0.0, 1.0, i as f64));
    }
    let free: Vec<bool> = (0..n).map(|i| constraints.filter(i) == Filter::Free).collect();
    let mut p = CompleteCholesky::new(&a).unwrap();
    p.update(&a, Some(&free)).unwrap();
    let b = Random::new(33).vectors(n);
    let mut x = vec![Vec3::zeros(); n];
    let report = solve(&a, &p, &constraints, &b, &mut x, &settings(1e-9, Norm::Preconditioned, 10));
    assert_eq!((report.iterations, report.status), (1, SolveStatus::Converged));
    let expected = dense_filtered(&dense(&a).kronecker(&DMatrix::identity(3, 3)), &constraints, &b);
    assert!((flat(&x) - expected).norm() < 1e-10);
}

#[test]
fn a_good_start_takes_no_iteration_and_counts_are_exact() {
    let n = 25;
    let a = laplacian(n, &grid_edges(5), 1.0, || 1.0);
    let x = Random::new(34).vectors(n);
    let mut b = x.clone();
    a.multiply(&x, &mut b);
    let mut constraints = Constraints::free(n);
    constraints.set(3, Filter::Fixed, Vec3::zeros());
    let solve = |constraints: &Constraints, start: &[Vec3], reference, forcing_term| {
        let mut solution = start.to_vec();
        filtered_pcg(
            &a,
            &Identity,
            constraints,
            &b,
            &mut solution,
            reference,
            &settings(forcing_term, Norm::Euclid, 200),
            &mut PcgWorkspace::new(n),
        )
    };
    let counts = |report: PcgReport| (report.iterations, report.multiplications, report.status);
    let filtered = Reference::FilteredRightHandSide;
    let converged = SolveStatus::Converged;

    let report = solve(&Constraints::free(n), &x, filtered, 1e-12);
    assert_eq!(counts(report), (0, 1, converged));
    let report = solve(&constraints, &x, Reference::Absolute(1e3), 1.0);
    assert_eq!(counts(report), (0, 1, converged));
    // Loose tolerances believe the recursion: one product an iteration, one for the start.
    let zero = vec![Vec3::zeros(); n];
    let report = solve(&constraints, &zero, filtered, 1e-3);
    assert!(report.iterations > 3);
    assert_eq!(report.multiplications, report.iterations + 1);
    // Prescribed motion costs one for the reference; a tight tolerance, one to be sure.
    constraints.set(3, Filter::Fixed, Vec3::x());
    let report = solve(&constraints, &zero, filtered, 1e-3);
    assert_eq!(report.multiplications, report.iterations + 2);
    let report = solve(&constraints, &zero, filtered, 1e-12);
    assert_eq!(report.multiplications, report.iterations + 3);
    assert_eq!(report.status, converged);
}

#[test]
fn the_reference_leaves_out_the_reactions_of_the_supports() {
    // The pinned particle carries a huge load that must not loosen the tolerance of the other one.
    let mut a = ScalarMatrix::with_pattern(3, [(0, 1), (1, 2)]);
    for i in 0..3 {
        a.add_diagonal(i, 1.0);
    }
    a.add_edge(0, 1, 1.0);
    a.add_edge(1, 2, 1.0);
    let mut constraints = Constraints::free(3);
    constraints.set(0, Filter::Fixed, Vec3::zeros());
    let b = [Vec3::z() * 1e12, Vec3::z(), Vec3::zeros()];
    let mut x = [Vec3::zeros(); 3];
    let report = solve(&a, &Identity, &constraints, &b, &mut x, &settings(1e-6, Norm::Euclid, 100));
    assert_eq!(report.status, SolveStatus::Converged);
    assert!((x[1].z - 0.4).abs() < 1e-6 && (x[2].z - 0.2).abs() < 1e-6);
}

#[test]
fn zero_right_hand_sides_give_the_prescribed_values() {
    let a = laplacian(4, &grid_edges(2), 1.0, || 1.0);
    let mut constraints = Constraints::free(4);
    for norm in NORMS {
        let mut x = Random::new(35).vectors(4);
        let mut workspace = PcgWorkspace::new(4);
        let mut solve = |constraints: &Constraints, b: &[Vec3], x: &mut [Vec3]| {
            filtered_pcg(
                &a,
                &Identity,
                constraints,
                b,
                x,
                Reference::FilteredRightHandSide,
                &settings(1e-3, norm, 100),
                &mut workspace,
            )
        };
        let report = solve(&constraints, &[Vec3::zeros(); 4], &mut x);
        assert_eq!(report.status, SolveStatus::Converged);
        assert_eq!(report.relative_residual, 0.0);
        assert_eq!(x, [Vec3::zeros(); 4]);
        // All are held, so no unknown is left.
        for i in 0..4 {
            constraints.set(i, Filter::Fixed, Vec3::x() * i as f64);
        }
        let report = solve(&constraints, &[Vec3::y(); 4], &mut x);
        assert_eq!((report.iterations, report.status), (0, SolveStatus::Converged));
        assert_eq!(x[3], Vec3::x() * 3.0);
        constraints.clear();
    }
}

#[test]
fn indefinite_matrices_and_bad_numbers_end_the_solve() {
    let good = diagonal(&[1.0, 2.0, 3.0]);
    let b = [Vec3::new(1.0, 1.0, 1.0); 3];
    for norm in NORMS {
        let tight = settings(1e-10, norm, 1_000_000);
        for bad in [-2.0, f64::NAN, f64::INFINITY] {
            let report = plain(&diagonal(&[1.0, bad, 3.0]), &b, &tight).1;
            assert_eq!(report.status, SolveStatus::Indefinite, "{bad} in the matrix");
            assert!(report.iterations < 10);
        }
        for bad in [f64::NAN, f64::INFINITY] {
            let mut b = b;
            b[1].y = bad;
            let report = plain(&good, &b, &tight).1;
            assert_eq!(report.status, SolveStatus::Indefinite, "{bad} in b");
            assert_eq!(report.iterations, 0);
        }
        for bad in [f64::NAN, -1.0] {
            let report = plain(&good, &b, &settings(bad, norm, 1_000_000)).1;
            assert_eq!(report.status, SolveStatus::Stagnated, "forcing term {bad}");
        }
    }
}

#[test]
fn an_unreachable_tolerance_ends_stagnated_with_the_best_solution() {
    let n = 400;
    let mut random = Random::new(36);
    for weight in [1.0, 1e3, 1e6] {
        let a = laplacian(n, &grid_edges(20), 1.0, || weight);
        let mut incomplete = IncompleteCholesky::new(&a);
        incomplete.update(&a, None).unwrap();
        let b = random.vectors(n);
        let preconditioners: [&dyn Preconditioner; 2] = [&Identity, &incomplete];
        for p in preconditioners {
            for norm_used in NORMS {
                let mut x = vec![Vec3::zeros(); n];
                let report = solve(
                    &a,
                    p,
                    &Constraints::free(n),
                    &b,
                    &mut x,
                    &settings(1e-18, norm_used, 1_000_000),
                );
                assert_eq!(report.status, SolveStatus::Stagnated);
                assert!(report.iterations < 3000, "{report:?}");
                // Backward stable: the residual is round-off of A x.
                let mut residual = x.clone();
                constraint_impulse(&a, &b, &x, &mut residual);
                let round_off = f64::EPSILON * 8.0 * weight * norm(&x) + f64::EPSILON * norm(&b);
                assert!(norm(&residual) < 10.0 * round_off, "{report:?}");
            }
        }
    }
}

#[test]
fn ill_conditioned_problems_are_not_given_up_early() {
    // The residual's norm humps and plateaus for longer than the refresh interval.
    let n = 300;
    let values: Vec<f64> = (0..n).map(|i| 10_f64.powf(7.0 * i as f64 / n as f64)).collect();
    let b = Random::new(37).vectors(n);
    let (x, report) = plain(&diagonal(&values), &b, &settings(1e-7, Norm::Euclid, 1_000_000));
    assert_eq!(report.status, SolveStatus::Converged);
    assert!(report.iterations > 300, "{report:?}");
    let error: Vec<Vec3> = (0..n).map(|i| x[i] * values[i] - b[i]).collect();
    assert!(norm(&error) < 1.01e-7 * norm(&b));
}

#[test]
fn the_default_limit_grows_with_the_root_of_the_unknowns() {
    assert_eq!(PcgSettings::default_max(1), 100);
    assert_eq!(PcgSettings::default_max(400), 347);
}

#[test]
fn a_block_operator_behind_a_reference_is_accepted() {
    let mut a = crate::BlockMatrix::with_pattern(1, []);
    a.add_diagonal(0, &Mat3::from_diagonal(&Vec3::new(1.0, 2.0, 4.0)));
    let operator: &dyn LinearOperator = &a;
    let mut x = [Vec3::zeros()];
    let report = filtered_pcg(
        operator,
        &Identity,
        &Constraints::free(1),
        &[Vec3::new(1.0, 1.0, 1.0)],
        &mut x,
        Reference::FilteredRightHandSide,
        &settings(1e-12, Norm::Euclid, 10),
        &mut PcgWorkspace::new(1),
    );
    assert_eq!(report.iterations, 3);
    assert!((x[0] - Vec3::new(1.0, 0.5, 0.25)).norm() < 1e-12);
}
