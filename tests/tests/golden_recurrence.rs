//! Every method steps as its own amplification matrix says, over 100 steps.

use drape_model::{SpringEffect, State, System, Vec3};
use drape_oracle::recurrence::{self, Amplification, Multistep, Recurrence};
use drape_tests::{Run, build, particles, pin, spring};
use nalgebra::{Matrix2, Vector2};

const STEPS: usize = 100;
/// A power of two, so that `θ = h²k/m` and `η = hc/m` are met exactly.
const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;

/// `(θ, η)`: smooth, stiff and damped, stiff, and at the edge.
const PARAMETERS: [(f64, f64); 4] = [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0)];

const EXACT: f64 = 1e-12;
/// Where the unknown is the change of velocity, which cancels most of a velocity that decays fast: a digit more is
/// lost over 100 steps.
const CANCELLING: f64 = 1e-11;
const ITERATIVE: f64 = 1e-9;

/// A method with its rule for a step from as many levels as are known, as a function of `(θ, η)`.
#[derive(Clone, Copy)]
struct Case {
    id: &'static str,
    rule: fn(usize, f64, f64) -> Recurrence,
    tolerance: f64,
}

macro_rules! one_step {
    ($id:expr, $matrix:expr, $tolerance:expr) => {
        Case {
            id: $id,
            rule: |_, theta, eta| Recurrence::from($matrix(theta, eta)),
            tolerance: $tolerance,
        }
    };
}

/// `h` times the matrix of the differential equation of `(x, hv)`.
fn slope(theta: f64, eta: f64) -> Matrix2<f64> {
    Matrix2::new(0.0, 1.0, -theta, -eta)
}

/// Adams–Bashforth with up to `steps` levels, the first step by Heun's method.
fn adams_bashforth(steps: usize, known: usize, theta: f64, eta: f64) -> Recurrence {
    let j = slope(theta, eta);
    match known.min(steps) {
        1 => (Matrix2::identity() + j + j * j * 0.5).into(),
        k => recurrence::adams_bashforth(k, theta, eta),
    }
}

/// BDF of three levels, of two where only two are known; the first step by Alexander's two-stage method.
fn bdf3(known: usize, theta: f64, eta: f64) -> Recurrence {
    let (one, j, gamma) = (Matrix2::identity(), slope(theta, eta), 1.0 - 0.5_f64.sqrt());
    let inverse = || (one - j * gamma).try_inverse().expect("regular");
    match known {
        1 => (inverse() * inverse() * (one + j * (1.0 - 2.0 * gamma))).into(),
        k => recurrence::bdf(k, theta, eta),
    }
}

/// A two-step method after a first step of backward Euler.
fn after_backward_euler(known: usize, theta: f64, eta: f64, rule: Recurrence) -> Recurrence {
    if known == 1 { recurrence::backward_euler(theta, eta).into() } else { rule }
}

/// Kang's step on a particle with one pinned neighbour.
fn kang(theta: f64, eta: f64) -> Amplification {
    recurrence::kang_anchored(theta, eta, 1)
}

fn imex(method: Multistep, known: usize, theta: f64, eta: f64) -> Recurrence {
    after_backward_euler(known, theta, eta, method.recurrence(theta, 0.0, eta))
}

const CASES: [Case; 29] = [
    one_step!("explicit-euler", recurrence::explicit_euler, EXACT),
    one_step!("adams-bashforth2:steps=1", recurrence::explicit_euler, EXACT),
    one_step!("symplectic-euler", recurrence::symplectic_euler, EXACT),
    one_step!(
        "symplectic-euler:damping=implicit",
        recurrence::symplectic_euler_implicit_damping,
        EXACT
    ),
    one_step!("provot:limit=10", recurrence::symplectic_euler, EXACT),
    one_step!("leapfrog:solver=cholesky", recurrence::leapfrog, EXACT),
    one_step!("leapfrog:solver=cg", recurrence::leapfrog, ITERATIVE),
    one_step!("backward-euler:residual=1e-16", recurrence::backward_euler, ITERATIVE),
    one_step!("bdf2:steps=1,residual=1e-16", recurrence::backward_euler, ITERATIVE),
    one_step!("baraff-witkin:solver=cholesky", recurrence::backward_euler, CANCELLING),
    one_step!("baraff-witkin:forcing_term=1e-14", recurrence::backward_euler, ITERATIVE),
    one_step!(
        "baraff-witkin:hessian=raw,implicit=tension,forcing_term=1e-14,preconditioner=none",
        recurrence::backward_euler,
        ITERATIVE
    ),
    one_step!("desbrun:torque=none", recurrence::desbrun, CANCELLING),
    one_step!("desbrun:torque=none,inverse=dense", recurrence::desbrun, CANCELLING),
    one_step!("kang", kang, EXACT),
    one_step!("imex-euler:solver=cholesky", recurrence::backward_euler, EXACT),
    one_step!("imex-euler:forcing_term=1e-14", recurrence::backward_euler, ITERATIVE),
    one_step!(
        "imex-updated:forcing_term=1e-16,max_outer=1000",
        recurrence::backward_euler,
        ITERATIVE
    ),
    one_step!(
        "imex-updated:forcing_term=1e-14,max_outer=1000,safeguard=paper",
        recurrence::backward_euler,
        ITERATIVE
    ),
    one_step!("terzopoulos-fleischer", recurrence::terzopoulos_fleischer, EXACT),
    one_step!("terzopoulos-fleischer:clamp=true", recurrence::terzopoulos_fleischer, EXACT),
    Case {
        id: "adams-bashforth2",
        rule: |known, theta, eta| adams_bashforth(2, known, theta, eta),
        tolerance: EXACT,
    },
    Case {
        id: "adams-bashforth2:steps=3",
        rule: |known, theta, eta| adams_bashforth(3, known, theta, eta),
        tolerance: EXACT,
    },
    Case {
        id: "bdf2:residual=1e-16",
        rule: |known, theta, eta| {
            after_backward_euler(known, theta, eta, recurrence::bdf(2, theta, eta))
        },
        tolerance: ITERATIVE,
    },
    Case {
        id: "bdf2:steps=3,residual=1e-16",
        rule: |known, theta, eta| bdf3(known.min(3), theta, eta),
        tolerance: ITERATIVE,
    },
    Case {
        id: "imex-sbdf2:forcing_term=1e-14",
        rule: |known, theta, eta| imex(Multistep::sbdf2(1.0), known, theta, eta),
        tolerance: ITERATIVE,
    },
    Case {
        id: "imex-cnab2:forcing_term=1e-14",
        rule: |known, theta, eta| imex(Multistep::cnab2(1.0), known, theta, eta),
        tolerance: ITERATIVE,
    },
    Case {
        id: "imex-mcnab2:solver=cholesky",
        rule: |known, theta, eta| imex(Multistep::mcnab2(1.0), known, theta, eta),
        tolerance: ITERATIVE,
    },
    Case {
        id: "imex-cnlf:solver=cholesky",
        rule: |known, theta, eta| imex(Multistep::cnlf(), known, theta, eta),
        tolerance: ITERATIVE,
    },
];

/// No method is left out.
#[test]
fn every_method_has_a_recurrence() {
    for method in drape_harness::methods::all() {
        let named = |case: &Case| case.id.split(':').next() == Some(method.id);
        assert!(CASES.iter().any(named), "{} has no recurrence", method.id);
    }
}

/// `k` and `c` of an anchored spring with the given `θ` and `η`.
fn coefficients(theta: f64, eta: f64) -> (f64, f64) {
    (theta * MASS / (H * H), eta * MASS / H)
}

/// Most levels that a rule looks at.
const DEPTH: usize = 3;

/// Exact levels `(x, hv)`, newest first.
struct Exact<R> {
    levels: Vec<Vector2<f64>>,
    rule: R,
}

impl<R: Fn(usize) -> Recurrence> Exact<R> {
    fn step(&mut self) -> Vector2<f64> {
        let next = (self.rule)(self.levels.len()).next(&self.levels);
        self.levels.insert(0, next);
        self.levels.truncate(DEPTH);
        next
    }
}

/// Steps a run and its recurrence side by side while `in_range` holds for the exact `x`; returns the
/// number of steps and the worst deviation of `(x, hv)`, relative to the solution at that step and those that it
/// follows from or, where it is larger, to `floor`.
fn worst_deviation(
    run: &mut Run,
    case: &Case,
    (theta, eta): (f64, f64),
    floor: f64,
    coordinate: impl Fn(&State) -> (f64, f64),
    in_range: impl Fn(f64) -> bool,
) -> (usize, f64) {
    let rule = |known| (case.rule)(known, theta, eta);
    side_by_side(run, rule, floor, coordinate, in_range)
}

/// The same for a rule of one step.
fn deviation_from(
    run: &mut Run,
    rule: Recurrence,
    floor: f64,
    coordinate: impl Fn(&State) -> (f64, f64),
    in_range: impl Fn(f64) -> bool,
) -> (usize, f64) {
    side_by_side(run, |_| rule.clone(), floor, coordinate, in_range)
}

fn side_by_side(
    run: &mut Run,
    rule: impl Fn(usize) -> Recurrence,
    floor: f64,
    coordinate: impl Fn(&State) -> (f64, f64),
    in_range: impl Fn(f64) -> bool,
) -> (usize, f64) {
    let pair = |state: &State| {
        let (x, v) = coordinate(state);
        Vector2::new(x, H * v)
    };
    let mut exact = Exact { levels: vec![pair(&run.state)], rule };
    let mut worst: f64 = 0.0;
    for step in 0..STEPS {
        let before = exact.levels.iter().skip(1).fold(0.0, |a: f64, y| a.max(y.norm()));
        let expected = exact.step();
        if !in_range(expected.x) {
            return (step, worst);
        }
        run.step();
        let deviation = (pair(&run.state) - expected).norm();
        worst = worst.max(deviation / expected.norm().max(before).max(floor));
    }
    (STEPS, worst)
}

/// One particle on springs (effect, stiffness, damping) whose other end is pinned at the origin.
fn anchored(
    rest_length: f64,
    springs: &[(SpringEffect, f64, f64)],
    x: Vec3,
    v: Vec3,
) -> (System, State) {
    let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), x], &[Vec3::zeros(), v]);
    spec.pins = vec![pin(0)];
    spec.springs = springs.iter().map(|&(e, k, c)| spring(e, (0, 1), rest_length, k, c)).collect();
    build(&spec)
}

/// A spring of rest length 0 is linear: each coordinate obeys the recurrence by itself.
#[test]
fn an_anchored_spring_of_rest_length_zero_moves_by_the_recurrence() {
    let (x, v) = (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    for case in CASES {
        for (theta, eta) in PARAMETERS {
            let (k, c) = coefficients(theta, eta);
            for axis in 0..3 {
                let system = anchored(0.0, &[(SpringEffect::Tension, k, c)], x, v);
                let mut run = Run::new(case.id, system, H);
                let at = |state: &State| (state.x[1][axis], state.v[1][axis]);
                // Squares of what is unstable must not overflow.
                let in_range = |x: f64| x.abs() < 1e100;
                let (steps, worst) =
                    worst_deviation(&mut run, &case, (theta, eta), 0.0, at, in_range);
                assert!(steps >= 50, "{steps} steps");
                let Case { id, tolerance, .. } = case;
                assert!(worst < tolerance, "{id}, θ={theta} η={eta} axis {axis}: {worst:e}");
            }
        }
    }
}

/// Along a spring with a rest length the motion is the same, offset by it, as long as the spring
/// does not turn round.
#[test]
fn motion_along_a_spring_with_a_rest_length_obeys_the_same_recurrence() {
    let (rest, amplitude) = (4.0, 1.0 / 256.0);
    let direction = Vec3::new(0.0, 0.6, -0.8);
    // The secant stiffness changes along a spring with a rest length.
    let linear = |case: &&Case| !case.id.starts_with("terzopoulos-fleischer");
    for case in CASES.iter().filter(linear) {
        for (theta, eta) in PARAMETERS {
            let (k, c) = coefficients(theta, eta);
            let x = direction * (rest + amplitude);
            let system = anchored(rest, &[(SpringEffect::Tension, k, c)], x, Vec3::zeros());
            let mut run = Run::new(case.id, system, H);
            let at =
                |state: &State| (direction.dot(&state.x[1]) - rest, direction.dot(&state.v[1]));
            let in_range = |x: f64| x.abs() < 0.5 * rest;
            let (steps, worst) = worst_deviation(&mut run, case, (theta, eta), rest, at, in_range);
            let Case { id, tolerance, .. } = *case;
            assert!(steps > 0 && worst < tolerance, "{id}, θ={theta} η={eta}: {worst:e}");
        }
    }
}

/// Shear springs stay explicit under `implicit=tension`, tension springs and their damping are
/// implicit: `x'' = −(κ_I + κ_E)x − δx'`.
#[test]
fn imex_euler_with_an_explicit_spring_moves_by_the_test_equation() {
    let methods = [
        ("imex-euler:implicit=tension,solver=cholesky", EXACT),
        ("imex-euler:implicit=tension,forcing_term=1e-14", ITERATIVE),
    ];
    let (x, v) = (Vec3::new(1.0, -0.5, 2.0), Vec3::new(0.0, 40.0, 7.0));
    let parameters =
        [(1.0, 0.5, 0.1), (100.0, 50.0, 0.0), (0.36, 3.0, 0.06), (0.0, 1.0, 0.0), (1.0, 7.0, 0.0)];
    for (id, tolerance) in methods {
        for (implicit, explicit, eta) in parameters {
            let ((k, c), (shear, _)) = (coefficients(implicit, eta), coefficients(explicit, 0.0));
            let springs = [(SpringEffect::Tension, k, c), (SpringEffect::Shear, shear, 0.0)];
            let mut run = Run::new(id, anchored(0.0, &springs, x, v), H);
            let rule = recurrence::imex_euler(implicit, explicit, eta).into();
            let at = |state: &State| (state.x[1].y, state.v[1].y);
            let worst = deviation_from(&mut run, rule, 0.0, at, |_| true).1;
            assert!(worst < tolerance, "{id}, θ=({implicit}, {explicit}) η={eta}: {worst:e}");
        }
    }
}

/// The damping of an explicit spring is explicit too.
#[test]
fn imex_euler_with_explicit_springs_only_is_symplectic_euler() {
    let ((k, c), x) = (coefficients(1.0, 0.2), Vec3::new(1.0, 0.5, 0.0));
    let system = anchored(0.0, &[(SpringEffect::Shear, k, c)], x, Vec3::zeros());
    let mut run = Run::new("imex-euler:implicit=tension,solver=cholesky", system, H);
    let at = |state: &State| (state.x[1].x, state.v[1].x);
    let rule = recurrence::symplectic_euler(1.0, 0.2).into();
    let worst = deviation_from(&mut run, rule, 0.0, at, |_| true).1;
    assert!(worst < EXACT, "{worst:e}");
}

/// Explicit springs beside implicit ones are stable exactly while `θ_E < 4 + θ_I`.
#[test]
fn explicit_springs_are_stable_while_the_implicit_ones_outweigh_them() {
    for (implicit, explicit, stable) in
        [(10.0, 13.9, true), (10.0, 14.1, false), (0.0, 3.9, true), (0.0, 4.1, false)]
    {
        let springs = [(SpringEffect::Tension, implicit), (SpringEffect::Shear, explicit)];
        let springs = springs.map(|(effect, theta)| (effect, coefficients(theta, 0.0).0, 0.0));
        let system = anchored(0.0, &springs, Vec3::x(), Vec3::zeros());
        let mut run = Run::new("imex-euler:implicit=tension,solver=cholesky", system, H);
        for _ in 0..2000 {
            run.step();
        }
        let size = run.state.x[1].norm();
        assert_eq!(size < 100.0, stable, "θ_I={implicit} θ_E={explicit}: {size:e}");
    }
}

/// A particle between two pinned ones moves across both springs by a small amount: the stiffness
/// is `θ(1 − ℓ/L)`, of which IMEX Euler takes `θ` implicitly and `−θℓ/L` explicitly.
#[test]
fn motion_across_a_spring_obeys_the_recurrence_of_its_reduced_stiffness() {
    let across = |id: &str, theta: f64, ratio: f64, matrix: &Amplification| {
        // Small enough that the neglected square is round-off; where Newton stops at the round-off of
        // the force along the springs, that must stay small beside the motion across them.
        let newton = id.starts_with("backward-euler");
        let (amplitude, tolerance) = if newton { (1e-5, 1e-7) } else { (1e-9, ITERATIVE) };
        let floor = if newton { amplitude } else { 0.0 };
        let (k, _) = coefficients(0.5 * theta, 0.0);
        let [left, right] = [-1.0, 1.0].map(|x| Vec3::new(x, 0.0, 0.0));
        let middle = Vec3::new(0.0, amplitude, -0.5 * amplitude);
        let positions = [left, right, middle];
        let mut spec = particles(&[MASS; 3], &positions, &[Vec3::zeros(), Vec3::zeros(), -middle]);
        spec.pins = vec![pin(0), pin(1)];
        spec.springs =
            (0..2).map(|end| spring(SpringEffect::Tension, (end, 2), ratio, k, 0.0)).collect();
        let mut run = Run::new(id, build(&spec), H);
        let at = |state: &State| (state.x[2].z, state.v[2].z);
        let in_range = |x: f64| x.abs() < 1e3 * amplitude;
        let (steps, worst) = deviation_from(&mut run, (*matrix).into(), floor, at, in_range);
        assert!(steps > 0 && worst < tolerance, "{id}, θ={theta} ℓ/L={ratio}: {worst:e}");
    };
    for (theta, ratio) in [(100.0, 0.5), (100.0, 0.99), (100.0, 1.0), (100.0, 1.1), (0.36, 0.3)] {
        let matrix = recurrence::imex_euler(theta, -ratio * theta, 0.0);
        across("imex-euler:solver=cholesky", theta, ratio, &matrix);
        let reduced = theta * (1.0 - ratio);
        across("symplectic-euler", theta, ratio, &recurrence::symplectic_euler(reduced, 0.0));
        across("explicit-euler", theta, ratio, &recurrence::explicit_euler(reduced, 0.0));
        if ratio <= 1.0 {
            let matrix = recurrence::backward_euler(reduced, 0.0);
            across("backward-euler:residual=1e-16", theta, ratio, &matrix);
        }
    }
}

/// A string of zero-length springs between two pins: each of its modes is an oscillator of its own.
#[test]
fn every_mode_of_a_string_moves_by_its_own_recurrence() {
    const FREE: usize = 7;
    let (theta, eta) = (25.0, 0.1);
    let (k, c) = coefficients(theta, eta);
    let mut random = drape_oracle::Random::new(11);
    let mut vectors = |size: f64| -> Vec<Vec3> {
        let free = |i: usize| f64::from(u8::from(i > 0 && i <= FREE));
        (0..FREE + 2).map(|i| random.vector() * (size * free(i))).collect()
    };
    let mut spec = particles(&[MASS; FREE + 2], &vectors(1.0), &vectors(30.0));
    spec.pins = vec![pin(0), pin(FREE + 1)];
    spec.springs =
        (0..=FREE).map(|i| spring(SpringEffect::Tension, (i, i + 1), 0.0, k, c)).collect();
    let phase = |mode: usize| std::f64::consts::PI * mode as f64 / (FREE + 1) as f64;
    let modal = |mode: usize, state: &State| {
        let shape = |vectors: &[Vec3]| -> f64 {
            (0..FREE + 2).map(|i| (phase(mode) * i as f64).sin() * vectors[i].x).sum()
        };
        Vector2::new(shape(&state.x), H * shape(&state.v))
    };
    let kangs: Vec<_> = [1, 2, 5].map(|sweeps| (format!("kang:sweeps={sweeps}"), sweeps)).into();
    let others = CASES.iter().filter(|case| case.id != "kang").map(|case| (case.id, Some(case), 0));
    let kangs = kangs.iter().map(|(id, sweeps)| (id.as_str(), None, *sweeps));
    for (id, case, sweeps) in others.chain(kangs) {
        let tolerance = case.map_or(EXACT, |case| case.tolerance);
        let mut run = Run::new(id, build(&spec), H);
        let mut exact: Vec<_> = (1..=FREE)
            .map(|mode| {
                let factor = 4.0 * (0.5 * phase(mode)).sin().powi(2);
                let (theta, eta) = (theta * factor, eta * factor);
                let levels = vec![modal(mode, &run.state)];
                // The part of the diagonal that both neighbours have, and the mode's eigenvalue of their mean.
                let both = 2.0 * (theta + eta) / factor;
                let jacobi = both / (1.0 + both) * phase(mode).cos();
                let kang = recurrence::kang_mode(theta, eta, jacobi, sweeps);
                let rule = move |known: usize| {
                    case.map_or_else(|| kang.into(), |case| (case.rule)(known, theta, eta))
                };
                Exact { levels, rule }
            })
            .collect();
        let mut largest: f64 = 0.0;
        for step in 0..STEPS {
            if largest > 1e100 {
                break; // before squares of an unstable solution overflow
            }
            run.step();
            for (mode, exact) in exact.iter_mut().enumerate() {
                let expected = exact.step();
                // Modes are told apart to round-off of the largest amplitude so far.
                largest = largest.max(expected.norm());
                let deviation = (modal(mode + 1, &run.state) - expected).norm() / largest;
                assert!(deviation < tolerance, "{id}, mode {mode}, step {step}: {deviation:e}");
            }
        }
    }
}
