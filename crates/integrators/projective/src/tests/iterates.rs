//! Each iterate is the one that the formulas give.

use super::{ALL, run, settings};
use crate::Projective;
use drape_integrator::{
    Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, SolveStatus, SolverKind, Weights,
};
use drape_model::{DampingLaw, SpringEffect, State, System, Vec3};
use drape_oracle::recurrence::{
    Amplification, backward_euler, chebyshev_left, projective, projective_rate,
};
use drape_oracle::scenes::{
    Sheet, anchored, build, particles, pin, stiffening, stir, tension, uneven,
};
use drape_oracle::{Run, apart, largest};
use drape_solvers::{Constraints, Filter};
use nalgebra::Vector2;

const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;

/// A spring of rest length 0 has no turning part: one iteration solves the step.
#[test]
fn on_an_oscillator_one_iteration_of_any_kind_is_backward_euler() {
    let (x, v) = (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    for (theta, eta) in [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0), (2.0, 30.0)] {
        for acceleration in ALL {
            for iterations in [1, 10] {
                let spring = (SpringEffect::Tension, 0.0, theta * MASS / (H * H), eta * MASS / H);
                let start = build(&anchored(MASS, &[spring], x, v));
                let text = format!("acceleration={acceleration},iterations={iterations}");
                let mut run = run(&text, start, H);
                let mut exact = Vector2::new(x.y, H * v.y);
                for step in 0..30 {
                    exact = backward_euler(theta, eta) * exact;
                    run.step();
                    let found = Vector2::new(run.state.x[1].y, H * run.state.v[1].y);
                    let off = (found - exact).norm() / exact.norm();
                    assert!(off < 1e-12, "{text}, θ={theta} η={eta}, step {step}: {off:e}");
                }
            }
        }
    }
}

/// A particle between two pins; the ratio of rest length to length is `σ`.
fn between_pins(theta: f64, sigma: f64, amplitude: f64) -> (System, State) {
    let middle = Vec3::new(0.0, amplitude, -0.5 * amplitude);
    let positions = [-Vec3::x(), Vec3::x(), middle];
    let velocities = [Vec3::zeros(), Vec3::zeros(), -middle];
    let mut spec = particles(&[MASS; 3], &positions, &velocities);
    spec.pins = vec![pin(0), pin(1)];
    let k = 0.5 * theta * MASS / (H * H);
    spec.springs = (0..2).map(|end| tension((end, 2), sigma, k, 0.0)).collect();
    build(&spec)
}

/// Across a spring an iteration leaves the factor `q` of the error, and Chebyshev's method its
/// polynomial.
#[test]
fn across_a_spring_each_iteration_shrinks_the_error_by_its_rate() {
    let amplitude = 1e-5;
    for (theta, sigma) in [(100.0, 0.5), (100.0, 0.99), (1e4, 0.9), (0.36, 0.3), (100.0, 1.0)] {
        let rate = projective_rate(theta, -sigma * theta, 0.0);
        assert!((0.0..1.0).contains(&rate));
        for iterations in [1, 2, 5, 10, 11, 12, 20, 40] {
            for (acceleration, left) in [
                ("none", rate.powi(iterations)),
                ("chebyshev,rho=0.9", chebyshev_left(rate, 0.9, 10, iterations as u32)),
            ] {
                let text = format!("acceleration={acceleration},iterations={iterations}");
                let matrix: Amplification = projective(theta * (1.0 - sigma), 0.0, left);
                let mut run = run(&text, between_pins(theta, sigma, amplitude), H);
                let at = |run: &Run| Vector2::new(run.state.x[2].z, H * run.state.v[2].z);
                let mut exact = at(&run);
                for step in 0..20 {
                    exact = matrix * exact;
                    run.step();
                    let off = (at(&run) - exact).norm() / exact.norm().max(amplitude);
                    assert!(off < 1e-6, "{text}, θ={theta} σ={sigma}, step {step}: {off:e}");
                }
            }
        }
    }
}

/// On a linear problem with one unknown a secant finds the root.
#[test]
fn across_a_spring_secants_need_two_iterations() {
    for acceleration in ["anderson", "lbfgs"] {
        let (theta, sigma, amplitude) = (100.0, 0.99, 1e-4);
        let mut run = run(
            &format!("acceleration={acceleration},iterations=2"),
            between_pins(theta, sigma, amplitude),
            H,
        );
        let mut exact = Vector2::new(run.state.x[2].z, H * run.state.v[2].z);
        for step in 0..20 {
            exact = backward_euler(theta * (1.0 - sigma), 0.0) * exact;
            run.step();
            let found = Vector2::new(run.state.x[2].z, H * run.state.v[2].z);
            let off = (found - exact).norm() / amplitude;
            assert!(off < 1e-6, "{acceleration}, step {step}: {off:e}");
        }
    }
}

/// A stirred sheet with unequal masses, of springs with one slope or two.
fn sheet(law: DampingLaw, steep: Option<f64>) -> (System, State) {
    let spec = Sheet { side: 6, tension: 1e5, shear: 1e4, damping: 8.0, law, ..Sheet::default() };
    let spec = steep.map_or(spec.spec(), |ratio| stiffening(spec.spec(), ratio));
    stir(uneven(build(&spec)), 0.05, 1.0)
}

/// `A v^{k+1} = M v_n + h [F_frozen − L_k x_n + F2(x_n + h v^k) + (L_c − D) v^k]`, written out with
/// the split of the implicit-explicit methods: the plain iteration of updated CG from `v̂`.
#[test]
fn the_plain_iterates_are_those_of_the_updated_right_hand_side() {
    let (implicit, h) = (Implicit::Springs, 0.01);
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for steep in [None, Some(0.1), Some(10.0)] {
            let (system, state) = sheet(law, steep);
            let n = state.len();
            let kept = LinearSettings::kept(1e-15, PreconditionerKind::Ic0, SolverKind::Cholesky);
            let weights = Weights::StiffnessAndDamping;
            let mut linear = LaplacianSolver::new(&system, implicit, weights, kept, h)
                .unwrap_or_else(|error| panic!("{error}"));
            let mut constraints = Constraints::free(n);
            for i in (0..n).filter(|&i| system.pinned()[i]) {
                constraints.set(i, Filter::Fixed, Vec3::zeros());
            }
            let mut frozen = vec![Vec3::zeros(); n];
            implicit.add_explicit_forces(&system, state.level(), &mut frozen);
            let mut v: Vec<Vec3> =
                (0..n).map(|i| state.v[i] + frozen[i] * (h / system.mass()[i])).collect();
            implicit.add_linear_spring_forces(&system, &state.x, &mut frozen);
            constraints.impose(&mut v);
            for iterations in 1..=6 {
                let x: Vec<Vec3> = (0..n).map(|i| state.x[i] + v[i] * h).collect();
                let mut force = frozen.clone();
                implicit.add_nonlinear_forces(&system, &x, &mut force);
                implicit.add_damping_remainders(&system, &state.x, &v, &mut force);
                let b: Vec<Vec3> =
                    (0..n).map(|i| state.v[i] * system.mass()[i] + force[i] * h).collect();
                linear.solve(&constraints, &b, &mut v);
                let mut run =
                    run(&format!("iterations={iterations}"), (system.clone(), state.clone()), h);
                let report = run.step();
                assert_eq!(
                    (report.outer_passes, report.solve),
                    (iterations, SolveStatus::Converged)
                );
                let off = apart(&run.state.v, &v) / largest(&v);
                assert!(off < 1e-12, "{law:?}, {steep:?}, {iterations} iterations: {off:e}");
            }
        }
    }
}

/// The tensions that the multipliers' step asks for are the forces.
#[test]
fn tensions_are_the_forces_of_the_springs() {
    for steep in [None, Some(0.1), Some(10.0)] {
        let (system, state) = sheet(DampingLaw::Full, steep);
        let zeros = || vec![Vec3::zeros(); state.len()];
        let (mut force, mut tensions) = (zeros(), zeros());
        Implicit::Springs.add_implicit_forces(&system, &state.x, &mut force);
        let mut weights = Vec::new();
        Implicit::Springs.visit_weights(&system, &mut |i, j, k, _| weights.push((i, j, k)));
        let mut visited = Vec::new();
        for split in system.effects().filter_map(|effect| effect.split()) {
            split.visit_tensions(&mut |i, j, k, tension| {
                let d = state.x[i] - state.x[j];
                let f = d * (tension(d.norm()) / d.norm());
                tensions[i] -= f;
                tensions[j] += f;
                visited.push((i, j, k));
            });
        }
        assert!(apart(&force, &tensions) < 1e-12 * largest(&force), "{steep:?}");
        assert_eq!(weights, visited);
    }
}

/// With one iteration nothing is there yet to accelerate, and the multipliers are 0.
#[test]
fn the_first_iteration_of_every_kind_is_the_plain_one() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for acceleration in ALL {
            let text = format!("acceleration={acceleration},iterations=1");
            let mut accelerated = run(&text, sheet(law, None), 0.01);
            let mut plain = run("iterations=1", sheet(law, None), 0.01);
            accelerated.step();
            plain.step();
            let off = apart(&accelerated.state.v, &plain.state.v) / largest(&plain.state.v);
            assert!(off < 1e-12, "{acceleration}, {law:?}: {off:e}");
        }
    }
    let mut chebyshev = run("acceleration=chebyshev", sheet(DampingLaw::Full, None), 0.01);
    let mut plain = run("acceleration=none", sheet(DampingLaw::Full, None), 0.01);
    chebyshev.step();
    plain.step();
    assert_eq!(chebyshev.state.v, plain.state.v, "ten iterations are plain");
}

/// A tolerance that is missed is told; a fixed number of iterations has none to miss.
#[test]
fn the_report_tells_residual_costs_and_how_the_iteration_ended() {
    let step = |text: &str| run(text, sheet(DampingLaw::Full, None), 0.01).step();
    let fixed = step("iterations=10");
    assert_eq!((fixed.solve, fixed.outer_passes), (SolveStatus::Converged, 10));
    assert!(fixed.relative_residual > 1e-3, "{fixed:?}");
    // F_frozen, scale, ten gradients and the one of the report.
    assert_eq!(fixed.force_evaluations, 1 + 1 + 10 + 1);
    let missed = step("iterations=10,residual=1e-6");
    assert_eq!(missed.solve, SolveStatus::IterationLimit);
    assert_eq!(missed.relative_residual, fixed.relative_residual);
    let met = step("iterations=1000,residual=1e-6,acceleration=lbfgs");
    assert!(met.solve == SolveStatus::Converged && met.relative_residual <= 1e-6, "{met:?}");
    assert!(met.outer_passes < 200, "{met:?}");
    let cg = step("iterations=10,solver=cg,forcing_term=1e-3");
    assert!(cg.cg_iterations > 10 && cg.solve == SolveStatus::Converged, "{cg:?}");
    let apart = (cg.relative_residual / fixed.relative_residual - 1.0).abs();
    assert!(apart < 0.05, "{cg:?}, {fixed:?}");
}

/// `new` allocates, later changes do not need a new integrator: the factor follows the system.
#[test]
fn a_change_of_the_system_renews_the_factor() {
    let mut changed =
        Run::new(Box::new(Projective::new(settings(""))), sheet(DampingLaw::Full, None), 0.01);
    changed.steps(3);
    assert!(changed.system.scale_stiffness(drape_model::EffectKind::Tension, 3.0));
    assert_eq!(changed.step().setups.stiffness, 1);
    let mut new = run("", (changed.system.clone(), changed.state.clone()), 0.005);
    changed.h = 0.005;
    assert_eq!(changed.step().setups.step_size, 1);
    new.step();
    assert_eq!(changed.state, new.state);
}
