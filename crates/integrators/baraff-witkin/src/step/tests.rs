//! The step against the unreduced system, and its settings.

mod contact;

use super::*;
use crate::settings::BaraffWitkinSettings;
use crate::test_support::rough_sheet;
use drape_integrator::SolveStatus;
use drape_model::{DampingLaw, SpringEffect, SystemSpec};
use drape_oracle::scenes::{build, particles, spring};
use drape_oracle::{Run, apart};
use nalgebra::{DMatrix, DVector};

const H: f64 = 0.01;
const MASS: f64 = 0.7;
const DIRECT: &str = "solver=cholesky";
/// `θ = h²k/m` and `η = hc/m`.
const GROUPS: [(f64, f64); 4] = [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0)];

/// Settings from `key=value,…`.
fn settings(text: &str) -> BaraffWitkinSettings {
    let pairs = text.split(',').filter_map(|pair| pair.split_once('='));
    BaraffWitkinSettings::from_pairs(pairs).unwrap_or_else(|error| panic!("{error}"))
}

fn prepared(text: &str, start: (System, State), h: f64) -> Run {
    Run::new(Box::new(BaraffWitkin::new(settings(text))), start, h)
}

/// `(k, c)` for `θ = h²k/m` and `η = hc/m`.
fn coefficients(theta: f64, eta: f64) -> (f64, f64) {
    (theta * MASS / (H * H), eta * MASS / H)
}

/// Across the spring the matrix has `1 + η + θ max(0, 1 − ℓ/L_n)`, and the spring pulls along it.
/// So `d_{n+1} × v_{n+1} = d_n × v_n` over that number. The raw matrix has no maximum.
#[test]
fn spin_is_divided_by_a_number_that_the_length_before_the_step_decides() {
    let (mut stretched, mut squeezed) = (0, 0);
    for (theta, eta) in GROUPS {
        for (length, law) in
            [(1.3, DampingLaw::Full), (0.98, DampingLaw::Full), (0.98, DampingLaw::Projected)]
        {
            let (k, c) = coefficients(0.5 * theta, 0.5 * eta); // of the relative motion
            let x = [Vec3::zeros(), Vec3::new(0.6, 0.8, 0.0) * length];
            let v = [Vec3::new(0.2, 0.1, -0.3), Vec3::new(-3.0, 4.0, 2.0)];
            let mut spec = particles(&[MASS; 2], &x, &v);
            spec.springs = vec![spring(SpringEffect::Bending, (0, 1), 1.0, k, c)];
            spec.damping = law;
            for (text, least) in [(DIRECT, 0.0), ("solver=cholesky,hessian=raw", -1.0)] {
                let mut run = prepared(text, build(&spec), H);
                for step in 0..20 {
                    let spin =
                        |state: &State| (state.x[1] - state.x[0]).cross(&(state.v[1] - state.v[0]));
                    let before = spin(&run.state);
                    let strain = 1.0 - 1.0 / (run.state.x[1] - run.state.x[0]).norm();
                    let across = if law == DampingLaw::Full { eta } else { 0.0 };
                    let divisor = 1.0 + across + theta * f64::max(least, strain);
                    stretched += usize::from(strain > 0.0);
                    squeezed += usize::from(strain < 0.0);
                    if divisor.abs() < 0.1 {
                        break; // raw, and nearly singular
                    }
                    run.step();
                    let error = (spin(&run.state) - before / divisor).norm();
                    let scale = before.norm() * f64::max(1.0, 1.0 / divisor.abs());
                    assert!(error < 1e-11 * scale, "θ={theta}, {text}, step {step}: {error:e}");
                }
            }
        }
    }
    assert!(stretched > 50 && squeezed > 50, "{stretched} and {squeezed}");
}

/// Dense `K = −∂f/∂x` and `D = −∂f/∂v` from the list of springs.
fn dense(spec: &SystemSpec, state: &State, clamped: bool) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = 3 * state.len();
    let (mut k, mut d) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for s in &spec.springs {
        let (i, j) = (s.i as usize, s.j as usize);
        let length = (state.x[i] - state.x[j]).norm();
        let u = (state.x[i] - state.x[j]) / length;
        let along = u * u.transpose();
        let across = drape_model::Mat3::identity() - along;
        let strain = 1.0 - s.rest_length_m / length;
        let strain = if clamped { strain.max(0.0) } else { strain };
        let stiffness = (along + across * strain) * s.stiffness_n_per_m;
        let damping = match spec.damping {
            DampingLaw::Full => (along + across) * s.damping_n_s_per_m,
            DampingLaw::Projected => along * s.damping_n_s_per_m,
        };
        for (matrix, block) in [(&mut k, stiffness), (&mut d, damping)] {
            for (row, column, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                let mut view = matrix.fixed_view_mut::<3, 3>(3 * row, 3 * column);
                view += block * sign;
            }
        }
    }
    (k, d)
}

fn flat(vectors: &[Vec3]) -> DVector<f64> {
    DVector::from_iterator(3 * vectors.len(), vectors.iter().flat_map(|v| [v.x, v.y, v.z]))
}

/// `(Δx, Δv) = h (v_0 + Δv, M⁻¹ (f_0 + ∂f/∂x Δx + ∂f/∂v Δv))`, Baraff-Witkin (4), (5), as one
/// system of `6n` unknowns in which the pinned particles do not move.
fn unreduced(spec: &SystemSpec, run: &Run, clamped: bool) -> (DVector<f64>, DVector<f64>) {
    let (state, h) = (&run.state, run.h);
    let n = 3 * state.len();
    let (k, d) = dense(spec, state, clamped);
    let mut force = vec![Vec3::zeros(); state.len()];
    run.system.forces(state.level(), &mut force);
    let (force, v) = (flat(&force), flat(&state.v));
    let mut matrix = DMatrix::identity(2 * n, 2 * n);
    let mut rhs = DVector::zeros(2 * n);
    for row in 0..n {
        matrix[(row, n + row)] = -h;
        rhs[row] = h * v[row];
        if run.system.pinned()[row / 3] {
            rhs[n + row] = -v[row];
            continue;
        }
        let per_mass = h / run.system.mass()[row / 3];
        for column in 0..n {
            matrix[(n + row, column)] = per_mass * k[(row, column)];
            matrix[(n + row, n + column)] += per_mass * d[(row, column)];
        }
        rhs[n + row] = per_mass * force[row];
    }
    let solution = matrix.lu().solve(&rhs).unwrap_or_else(|| panic!("a singular system"));
    (flat(&state.x) + solution.rows(0, n), v + solution.rows(n, n))
}

#[test]
fn the_reduced_system_has_the_solution_of_the_unreduced_one() {
    for (law, disorder) in [(DampingLaw::Full, 0.3), (DampingLaw::Projected, 0.3)] {
        for stiffness in [1e3, 1e5] {
            let spec = rough_sheet(4, stiffness, disorder, law);
            for hessian in ["clamped", "raw"] {
                let text = format!("solver=cholesky,hessian={hessian}");
                let mut run = prepared(&text, build(&spec), H);
                for _ in 0..5 {
                    let (x, v) = unreduced(&spec, &run, hessian == "clamped");
                    run.step();
                    let error = (flat(&run.state.v) - &v).norm() / v.norm();
                    assert!(error < 1e-12, "{text}, k/m = {stiffness}: {error:e} in v");
                    let error = (flat(&run.state.x) - &x).norm() / x.norm();
                    assert!(error < 1e-12, "{text}, k/m = {stiffness}: {error:e} in x");
                }
            }
        }
    }
}

/// `(M + hD + h²K) v_{n+1} = M v_n + h (f_n + D v_n)` with the clamped `K` on the left and none on
/// the right.
#[test]
fn the_change_and_the_velocity_itself_solve_the_same_system() {
    let spec = rough_sheet(5, 1e5, 0.3, DampingLaw::Full);
    let mut run = prepared(DIRECT, build(&spec), H);
    let (k, d) = dense(&spec, &run.state, true);
    let mut force = vec![Vec3::zeros(); run.state.len()];
    run.system.forces(run.state.level(), &mut force);
    let v = flat(&run.state.v);
    let mass = DVector::from_fn(v.len(), |row, _| run.system.mass()[row / 3]);
    let mut matrix = DMatrix::from_diagonal(&mass) + &d * H + &k * (H * H);
    let mut rhs = mass.component_mul(&v) + (flat(&force) + &d * &v) * H;
    for row in (0..v.len()).filter(|row| run.system.pinned()[row / 3]) {
        matrix.row_mut(row).fill(0.0);
        matrix[(row, row)] = 1.0;
        rhs[row] = 0.0;
    }
    run.step();
    let expected = matrix.lu().solve(&rhs).unwrap_or_else(|| panic!("a singular system"));
    let error = (flat(&run.state.v) - &expected).norm() / expected.norm();
    assert!(error < 1e-12, "{error:e}");
}

#[test]
fn a_squeezed_sheet_has_an_indefinite_raw_matrix_and_a_definite_clamped_one() {
    let mut spec = rough_sheet(6, 1e6, 0.02, DampingLaw::Full);
    spec.particles.position_m.iter_mut().for_each(|x| (x[0], x[1]) = (0.8 * x[0], 0.8 * x[1]));
    for preconditioner in ["none", "block-jacobi"] {
        let text = format!("hessian=raw,preconditioner={preconditioner}");
        let mut run = prepared(&text, build(&spec), H);
        let report = run.step();
        assert_eq!(report.solve, SolveStatus::Indefinite, "{text}: {report:?}");
        assert!(run.state.is_finite(), "{text}");
    }
    let mut run = prepared("hessian=raw,solver=cholesky", build(&spec), H);
    let report = run.step();
    assert_eq!(report.solve, SolveStatus::Indefinite, "{report:?}");
    assert!(report.relative_residual < 1e-9, "LDLᵀ solves it all the same: {report:?}");
    for text in ["", "preconditioner=none", DIRECT] {
        let mut run = prepared(text, build(&spec), H);
        for step in 0..50 {
            let report = run.step();
            assert_ne!(report.solve, SolveStatus::Indefinite, "{text}, step {step}: {report:?}");
        }
    }
}

#[test]
fn without_compression_the_raw_matrix_is_the_clamped_one() {
    let mut spec = rough_sheet(5, 1e4, 0.05, DampingLaw::Full);
    spec.particles.position_m.iter_mut().for_each(|x| (x[0], x[1]) = (1.5 * x[0], 1.5 * x[1]));
    let mut states = ["clamped", "raw"].map(|hessian| {
        let mut run = prepared(&format!("hessian={hessian}"), build(&spec), H);
        let report = run.step();
        assert_eq!(report.solve, SolveStatus::Converged);
        run.state
    });
    assert_eq!(states[0], states[1]);
    spec.particles.position_m.iter_mut().for_each(|x| (x[0], x[1]) = (0.5 * x[0], 0.5 * x[1]));
    states = ["clamped", "raw"].map(|hessian| {
        let mut run = prepared(&format!("hessian={hessian}"), build(&spec), 1e-3);
        run.step();
        run.state
    });
    assert_ne!(states[0], states[1]);
}

#[test]
fn a_smaller_forcing_term_takes_more_iterations_and_comes_closer_to_the_direct_solution() {
    let spec = rough_sheet(8, 1e5, 0.2, DampingLaw::Full);
    let mut exact = prepared(DIRECT, build(&spec), H);
    let report = exact.step();
    assert_eq!((report.cg_iterations, report.factorisations), (0, 1));
    for norm in ["euclid", "preconditioned"] {
        let (mut iterations, mut error) = (0, f64::INFINITY);
        for forcing_term in ["0.5", "1e-2", "1e-4", "1e-8", "1e-12"] {
            let text = format!("norm={norm},forcing_term={forcing_term}");
            let mut run = prepared(&text, build(&spec), H);
            let report = run.step();
            assert_eq!(report.solve, SolveStatus::Converged, "{text}");
            assert!(report.relative_residual <= settings(&text).forcing_term, "{text}: {report:?}");
            // One product for the right-hand side, one for the first residual, one a refresh.
            assert!(report.matvecs >= report.cg_iterations + 2, "{text}: {report:?}");
            assert!(report.cg_iterations > iterations, "{text}: {report:?}");
            iterations = report.cg_iterations;
            let distance = (flat(&run.state.v) - flat(&exact.state.v)).norm();
            assert!(distance < 0.5 * error, "{text}: {distance:e}");
            error = distance;
        }
        assert!(error < 1e-9, "{norm}: {error:e}");
    }
}

#[test]
fn each_norm_stops_by_its_own_residual() {
    let mut spec = rough_sheet(8, 1e4, 0.2, DampingLaw::Full);
    spec.particles.mass_kg[30] *= 1e4;
    let [euclid, preconditioned] = ["euclid", "preconditioned"].map(|norm| {
        let mut run = prepared(&format!("norm={norm}"), build(&spec), H);
        let report = run.step();
        (report.cg_iterations, report.relative_residual)
    });
    assert_ne!(euclid.1, preconditioned.1);
}

/// The lightest mass stands for all: by its own weight one particle would hide the residuals of the
/// others.
#[test]
fn a_heavy_particle_hides_no_residual() {
    for norm in ["euclid", "preconditioned"] {
        let off = |factor: f64| {
            let mut spec = rough_sheet(8, 1e4, 0.2, DampingLaw::Full);
            spec.particles.mass_kg[30] *= factor;
            let [found, exact] =
                [format!("norm={norm}"), "solver=cholesky".to_owned()].map(|text| {
                    let mut run = prepared(&text, build(&spec), H);
                    run.step();
                    run.state.v
                });
            drape_oracle::apart(&found, &exact)
        };
        let (even, heavy) = (off(1.0), off(1e6));
        assert!(heavy < 3.0 * even, "{norm}: {heavy:e} m/s off, {even:e} with equal masses");
    }
}

#[test]
fn preconditioning_saves_iterations_where_masses_differ() {
    let mut spec = rough_sheet(8, 1e4, 0.2, DampingLaw::Full);
    let masses = &mut spec.particles.mass_kg;
    masses.iter_mut().enumerate().for_each(|(i, m)| *m *= if i % 3 == 0 { 100.0 } else { 1.0 });
    let [none, block_jacobi] = ["none", "block-jacobi"].map(|preconditioner| {
        let text = format!("forcing_term=1e-8,preconditioner={preconditioner}");
        prepared(&text, build(&spec), H).step().cg_iterations
    });
    assert!(2 * block_jacobi < none, "{block_jacobi} against {none}");
}

#[test]
fn starting_from_the_last_change_saves_iterations_and_changes_no_solution() {
    let sheet = || build(&rough_sheet(9, 1e4, 0.05, DampingLaw::Full));
    let mut tight = ["start=zero", "start=last"]
        .map(|start| prepared(&format!("forcing_term=1e-12,{start}"), sheet(), 1e-3));
    let mut iterations = [0, 0];
    for _ in 0..20 {
        for (run, sum) in tight.iter_mut().zip(&mut iterations) {
            *sum += run.step().cg_iterations;
        }
    }
    let [zero, last] = &tight;
    assert!(apart(&zero.state.x, &last.state.x) < 1e-9);
    assert!(iterations[1] < iterations[0], "{iterations:?}");
    // A restart forgets the last change.
    let mut again = prepared("start=last", sheet(), 1e-3);
    again.step();
    let (system, state) = sheet();
    again.state = state;
    again.restart();
    let mut first = prepared("start=last", (system, again.state.clone()), 1e-3);
    assert_eq!(again.step().cg_iterations, first.step().cg_iterations);
    assert_eq!(again.state, first.state);
}

#[test]
fn settings_out_of_range_and_unknown_ones_are_refused() {
    for (key, value) in [
        ("forcing_term", "0.6"),
        ("forcing_term", "0"),
        ("forcing_term", "nan"),
        ("preconditioner", "ic0"),
        ("norm", "energy"),
        ("hessian", "clamp"),
        ("implicit", "springs"),
        ("contact", "force"),
        ("solver", "ldlt"),
        ("start", "middle"),
    ] {
        let outcome = BaraffWitkinSettings::from_pairs([(key, value)]);
        let error = outcome.err().unwrap_or_else(|| panic!("{key}={value} was accepted"));
        let text = error.to_string();
        assert!(text.contains("baraff-witkin") && text.contains(key), "{text}");
    }
    for setting in BARAFF_WITKIN.settings {
        let given = settings(&format!("{}={}", setting.key, setting.default));
        assert_eq!(given, settings(""), "{}", setting.key);
    }
}
