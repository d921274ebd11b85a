//! Every method steps as its own amplification matrices say, at any step sizes.

use drape_model::{DampingLaw, SpringEffect, State, System, Vec3};
use drape_oracle::recurrence::{self, Multistep, Recurrence};
use drape_tests::{
    Random, Run, anchored, assert_covers, build, has, name, particles, pin, prepared, takes,
    tension,
};
use nalgebra::{Matrix2, Vector2};

const STEPS: usize = 100;
/// A power of two, so that `θ = h²k/m` and `η = hc/m` are met exactly.
const H: f64 = 1.0 / 64.0;
const MASS: f64 = 0.25;

const EXACT: f64 = 1e-12;
/// Where the unknown is the change of velocity, which cancels most of a velocity that decays fast.
const CANCELLING: f64 = 1e-11;
const ITERATIVE: f64 = 1e-9;

/// What decides a step: `θ_I`, `θ_E` of implicit and explicit stiffness, and `η`.
///
/// A method that does not split its springs is asked with `θ_E = 0`.
#[derive(Clone, Copy, Debug)]
struct Springs {
    implicit: f64,
    explicit: f64,
    eta: f64,
}

impl Springs {
    fn whole(theta: f64, eta: f64) -> Self {
        Self { implicit: theta, explicit: 0.0, eta }
    }

    /// The same springs at another step size.
    fn at(self, h: f64) -> Self {
        let ratio = h / H;
        let square = ratio * ratio;
        let (implicit, explicit) = (self.implicit * square, self.explicit * square);
        Self { implicit, explicit, eta: self.eta * ratio }
    }
}

/// The rule of a step, given the sizes of the steps between the known levels, newest first, in
/// units of this step.
type Rule = fn(&[f64], Springs) -> Recurrence;

/// How a method sees the stiffness `θ (1 − σ)` across a spring that is stretched by `1/σ`.
#[derive(Clone, Copy, PartialEq)]
enum Across {
    /// As one stiffness.
    Reduced,
    /// `θ` implicitly, `−σθ` explicitly.
    Split,
    /// Implicitly as far as it is positive.
    Clamped,
    /// Not tested: the method moves neighbours by rules of its own, or its instability enlarges
    /// round-off.
    Unknown,
}

use Across::{Clamped, Reduced, Split, Unknown};

#[derive(Clone, Copy)]
struct Row {
    id: &'static str,
    rule: Rule,
    tolerance: f64,
    across: Across,
    /// Ratios of a step to the one before it at which the method keeps its history.
    keeps: (f64, f64),
    /// Whether a first step is solved by Newton's method to 1e-8 only, so that the rule goes on
    /// from what it found.
    adopts_start: bool,
}

const fn row(id: &'static str, tolerance: f64, across: Across, rule: Rule) -> Row {
    Row { id, rule, tolerance, across, keeps: (0.0, f64::INFINITY), adopts_start: false }
}

impl Row {
    const fn keeping(self, least: f64, most: f64) -> Self {
        Self { keeps: (least, most), ..self }
    }

    const fn adopting_its_start(self) -> Self {
        Self { adopts_start: true, ..self }
    }
}

/// `h` times the matrix of the differential equation of `(x, hv)`.
fn slope(s: Springs) -> Matrix2<f64> {
    Matrix2::new(0.0, 1.0, -s.implicit, -s.eta)
}

/// Adams–Bashforth with up to `steps` levels, the first step by Heun's method.
fn adams(steps: usize, earlier: &[f64], s: Springs) -> Recurrence {
    let j = slope(s);
    match earlier.len() {
        0 => (Matrix2::identity() + j + j * j * 0.5).into(),
        known => fully(&Multistep::adams_bashforth(&earlier[..known.min(steps - 1)]), s),
    }
}

fn fully(method: &Multistep, s: Springs) -> Recurrence {
    method.recurrence(s.implicit, 0.0, s.eta)
}

/// Damping first, on the motion that springs as in the step before would leave, then the springs.
fn factored(earlier: &[f64], s: Springs, is_second: bool) -> Recurrence {
    match earlier.first() {
        None => recurrence::factored_start(s.implicit, s.eta).into(),
        Some(last) if is_second => recurrence::factored_bdf2(1.0 / last, s.implicit, s.eta),
        Some(_) => recurrence::factored_backward_euler(s.implicit, s.eta).into(),
    }
}

/// BDF of up to `steps` steps after a step of backward Euler.
fn bdf(steps: usize, earlier: &[f64], s: Springs) -> Recurrence {
    fully(&Multistep::bdf(&earlier[..earlier.len().min(steps - 1)]), s)
}

/// BDF of three steps, of two where two levels are known; the first step by Alexander's two-stage
/// method.
fn bdf3(earlier: &[f64], s: Springs) -> Recurrence {
    let (one, j, gamma) = (Matrix2::identity(), slope(s), 1.0 - 0.5_f64.sqrt());
    let inverse = || (one - j * gamma).try_inverse().expect("regular");
    match earlier.len() {
        0 => (inverse() * inverse() * (one + j * (1.0 - 2.0 * gamma))).into(),
        _ => bdf(3, earlier, s),
    }
}

/// An implicit-explicit two-step method after a step of backward Euler of all springs.
fn two_step(method: fn(f64) -> Multistep, earlier: &[f64], s: Springs) -> Recurrence {
    match earlier.first() {
        None => recurrence::backward_euler(s.implicit + s.explicit, s.eta).into(),
        Some(last) => method(1.0 / last).recurrence(s.implicit, s.explicit, s.eta),
    }
}

fn tr_bdf2(theta: f64, eta: f64) -> Matrix2<f64> {
    recurrence::RungeKutta::tr_bdf2().amplification(theta, eta)
}

fn sdirk4(theta: f64, eta: f64) -> Matrix2<f64> {
    recurrence::RungeKutta::sdirk4().amplification(theta, eta)
}

fn imex(_: &[f64], s: Springs) -> Recurrence {
    recurrence::imex_euler(s.implicit, s.explicit, s.eta).into()
}

/// `γ` of ARS(2,2,2) and of ROS2.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// ARS(2,2,2). The other tableaux are tested beside the method.
fn ars222(_: &[f64], s: Springs) -> Recurrence {
    let delta = 1.0 - 0.5 / GAMMA;
    let (zeros, last) = ([0.0; 3], [0.0, 1.0 - GAMMA, GAMMA]);
    let tableau = recurrence::AdditiveTableau {
        explicit: [zeros, [GAMMA, 0.0, 0.0], [delta, 1.0 - delta, 0.0]],
        implicit: [zeros, [0.0, GAMMA, 0.0], last],
        explicit_weights: [delta, 1.0 - delta, 0.0],
        implicit_weights: last,
    };
    recurrence::additive_runge_kutta(&tableau, s.implicit, s.explicit, s.eta).into()
}

/// ROS2. The other tableaux are tested beside the method.
fn ros2(_: &[f64], s: Springs) -> Recurrence {
    let tableau = recurrence::RosenbrockTableau {
        alpha: [[0.0, 0.0], [1.0, 0.0]],
        gamma: [[GAMMA, 0.0], [-2.0 * GAMMA, GAMMA]],
        weights: [0.5, 0.5],
    };
    recurrence::rosenbrock(&tableau, (s.implicit, s.eta), (s.implicit, s.eta)).into()
}

/// Projective dynamics with its ten plain iterations. Chebyshev's method begins after them.
fn projective(_: &[f64], s: Springs) -> Recurrence {
    let left = recurrence::projective_rate(s.implicit, s.explicit, s.eta).powi(10);
    recurrence::projective(s.implicit + s.explicit, s.eta, left).into()
}

/// A method of one step as a row.
macro_rules! one_step {
    ($id:expr, $matrix:expr, $tolerance:expr, $across:expr) => {
        row($id, $tolerance, $across, |_, s| Recurrence::from($matrix(s.implicit, s.eta)))
    };
}

/// A scheme with each solver, with all springs implicit and with shear springs explicit.
macro_rules! scheme {
    ($id:literal, $method:expr, $least:expr, $most:expr) => {
        [
            row(concat!($id, ":solver=cholesky"), EXACT, Split, |e, s| two_step($method, e, s)),
            row(concat!($id, ":implicit=tension,solver=cholesky"), EXACT, Unknown, |e, s| {
                two_step($method, e, s)
            }),
            row(concat!($id, ":forcing_term=1e-14"), ITERATIVE, Unknown, |e, s| {
                two_step($method, e, s)
            }),
            row(
                concat!($id, ":implicit=tension,forcing_term=1e-14"),
                ITERATIVE,
                Unknown,
                |e, s| two_step($method, e, s),
            ),
        ]
        .map(|row| row.keeping($least, $most).adopting_its_start())
    };
}

fn rows() -> Vec<Row> {
    let mut rows = vec![
        one_step!("explicit-euler", recurrence::explicit_euler, EXACT, Reduced),
        one_step!("adams-bashforth2:steps=1", recurrence::explicit_euler, EXACT, Reduced),
        one_step!("symplectic-euler", recurrence::symplectic_euler, EXACT, Reduced),
        one_step!(
            "symplectic-euler:damping=implicit",
            recurrence::symplectic_euler_implicit_damping,
            EXACT,
            Reduced
        ),
        one_step!("provot:limit=10", recurrence::symplectic_euler, EXACT, Reduced),
        one_step!("leapfrog:solver=cholesky", recurrence::leapfrog, EXACT, Reduced),
        one_step!("leapfrog:solver=cg", recurrence::leapfrog, ITERATIVE, Reduced),
        one_step!(
            "backward-euler:residual=1e-16,solver=cholesky",
            recurrence::backward_euler,
            ITERATIVE,
            Reduced
        ),
        one_step!(
            "bdf2:steps=1,residual=1e-16,solver=cholesky",
            recurrence::backward_euler,
            ITERATIVE,
            Reduced
        ),
        row("baraff-witkin:solver=cholesky", CANCELLING, Clamped, imex),
        row("baraff-witkin:forcing_term=1e-14", ITERATIVE, Clamped, imex),
        row("baraff-witkin:hessian=raw,solver=cholesky", CANCELLING, Reduced, imex),
        row(
            "baraff-witkin:hessian=raw,implicit=tension,forcing_term=1e-14,preconditioner=none",
            ITERATIVE,
            Unknown,
            imex,
        ),
        one_step!("desbrun:torque=none", recurrence::desbrun, CANCELLING, Unknown),
        one_step!("desbrun:torque=none,inverse=dense", recurrence::desbrun, CANCELLING, Unknown),
        one_step!("kang", |theta, eta| recurrence::kang_anchored(theta, eta, 1), EXACT, Unknown),
        row("imex-euler:solver=cholesky", EXACT, Split, imex),
        row("imex-euler:forcing_term=1e-14", ITERATIVE, Split, imex),
        row("imex-euler:implicit=springs,solver=cholesky", EXACT, Unknown, imex),
        row("imex-euler:implicit=tension,solver=cholesky", EXACT, Unknown, imex),
        row("imex-euler:implicit=tension,forcing_term=1e-14", ITERATIVE, Unknown, imex),
        one_step!(
            "imex-updated:forcing_term=1e-16,max_outer=1000",
            recurrence::backward_euler,
            ITERATIVE,
            Unknown
        ),
        one_step!(
            "imex-updated:forcing_term=1e-14,max_outer=1000,safeguard=paper",
            recurrence::backward_euler,
            ITERATIVE,
            Unknown
        ),
        one_step!("terzopoulos-fleischer", recurrence::terzopoulos_fleischer, EXACT, Reduced),
        one_step!(
            "terzopoulos-fleischer:clamp=true",
            recurrence::terzopoulos_fleischer,
            EXACT,
            Reduced
        ),
        row("projective:residual=1e-16", EXACT, Split, projective),
        row("projective:acceleration=chebyshev,residual=1e-16", EXACT, Split, projective),
        one_step!("projective:acceleration=anderson", recurrence::backward_euler, EXACT, Unknown),
        one_step!("projective:acceleration=lbfgs", recurrence::backward_euler, EXACT, Unknown),
        one_step!("projective:acceleration=admm", recurrence::backward_euler, EXACT, Unknown),
        one_step!("exponential:krylov_tol=1e-10", recurrence::exact_oscillator, ITERATIVE, Unknown),
        one_step!(
            "energy-momentum:residual=1e-16,on_failure=report",
            recurrence::implicit_midpoint,
            ITERATIVE,
            Reduced
        ),
        row("adams-bashforth2", EXACT, Reduced, |e, s| adams(2, e, s)).keeping(0.5, 2.0),
        row("adams-bashforth2:steps=3", EXACT, Reduced, |e, s| adams(3, e, s)).keeping(0.5, 2.0),
        row("bdf2:residual=1e-16,solver=cholesky", ITERATIVE, Reduced, |e, s| bdf(2, e, s))
            .keeping(0.5, 2.0),
        row("bdf2:steps=3,residual=1e-16,solver=cholesky", ITERATIVE, Unknown, bdf3)
            .keeping(0.5, 1.5),
        one_step!(
            "midpoint:residual=1e-16,solver=cholesky",
            recurrence::implicit_midpoint,
            ITERATIVE,
            Unknown
        ),
        one_step!("dirk:residual=1e-16,solver=cholesky", tr_bdf2, ITERATIVE, Unknown),
        one_step!("dirk:tableau=sdirk4,residual=1e-16,solver=cholesky", sdirk4, ITERATIVE, Unknown),
        // The other members carry an acceleration, a third unknown: see their own tests.
        one_step!(
            "generalized-alpha:family=newmark,rho_inf=1,residual=1e-16,solver=cholesky",
            recurrence::implicit_midpoint,
            ITERATIVE,
            Unknown
        ),
        // Squeezed springs have blocks without their negative part: across them it is not compared.
        one_step!("vbd:sweeps=200", recurrence::backward_euler, EXACT, Unknown),
        row("imex-rk", EXACT, Split, ars222),
        row("imex-rk:implicit=tension", EXACT, Unknown, ars222),
        // Across a spring the motion decays to the round-off of the force along it.
        row("imex-rk:solver=cg,forcing_term=1e-15", ITERATIVE, Unknown, ars222),
        // Across a compressed spring its instability enlarges round-off.
        row("rosenbrock", EXACT, Unknown, ros2),
        row("rosenbrock:jacobian=clamped", EXACT, Unknown, ros2),
    ];
    rows.extend([
        one_step!("xpbd:substeps=1", |t, e| recurrence::xpbd(t, e, 1), EXACT, Unknown),
        one_step!("xpbd", |t, e| recurrence::xpbd(t, e, 20), EXACT, Unknown),
        row("xpbd:substeps=1,order=2", EXACT, Unknown, |e, s| bdf(2, e, s)).keeping(0.5, 2.0),
        row("xpbd-lines:substeps=1,order=1", EXACT, Unknown, |e, s| factored(e, s, false))
            .keeping(0.5, 2.0),
        row("xpbd-lines:substeps=1", EXACT, Unknown, |e, s| factored(e, s, true)).keeping(0.5, 2.0),
    ]);
    rows.extend(scheme!("imex-sbdf2", Multistep::sbdf2, 0.5, 2.0));
    rows.extend(scheme!("imex-cnab2", Multistep::cnab2, 0.5, 2.0));
    rows.extend(scheme!("imex-mcnab2", Multistep::mcnab2, 0.5, 2.0));
    rows.extend(scheme!("imex-cnlf", |_| Multistep::cnlf(), 1.0, 1.0));
    rows.push(one_step!(
        "leapfrog:damping=explicit",
        recurrence::leapfrog_explicit_damping,
        EXACT,
        Reduced
    ));
    rows
}

#[test]
fn every_method_has_a_recurrence() {
    let grows = "overflows within twenty steps beyond its limit; see the tests of its crate";
    let exceptions = [
        ("rkc", "refuses springs without damping; see the tests of its crate"),
        ("srkn4", grows),
        ("multirate", grows),
    ];
    assert_covers("recurrence", rows().iter().map(|row| row.id), &exceptions);
}

/// A sweep solves one spring exactly, and a net of springs not at all: a part of the error of its
/// old directions stays however often it is repeated.
fn sweeps(id: &str) -> bool {
    ["xpbd", "xpbd-lines"].contains(&name(id))
}

/// `k` and `c` of an anchored spring with the given `θ` and `η` at the step size [`H`].
fn coefficients(theta: f64, eta: f64) -> (f64, f64) {
    (theta * MASS / (H * H), eta * MASS / H)
}

/// Levels `(x, v)` by the rule of a row, newest first, and the sizes of the steps between them.
struct Exact {
    row: Row,
    springs: Springs,
    levels: Vec<Vector2<f64>>,
    sizes: Vec<f64>,
}

impl Exact {
    fn new(row: &Row, springs: Springs, start: (f64, f64)) -> Self {
        let levels = vec![Vector2::new(start.0, start.1)];
        Self { row: *row, springs, levels, sizes: Vec::new() }
    }

    /// The level `(x, hv)` after a step of size `h`.
    fn next(&mut self, h: f64) -> Vector2<f64> {
        let (least, most) = self.row.keeps;
        if self.sizes.first().is_some_and(|last| !(least..=most).contains(&(h / last))) {
            self.levels.truncate(1);
            self.sizes.clear();
        }
        let earlier: Vec<f64> = self.sizes.iter().map(|size| size / h).collect();
        let levels: Vec<_> = self.levels.iter().map(|y| Vector2::new(y.x, h * y.y)).collect();
        (self.row.rule)(&earlier, self.springs.at(h)).next(&levels)
    }

    /// Goes on to a level `(x, hv)` by a step of size `h`.
    fn advance(&mut self, level: Vector2<f64>, h: f64) {
        self.levels.insert(0, Vector2::new(level.x, level.y / h));
        self.sizes.insert(0, h);
        self.levels.truncate(3);
        self.sizes.truncate(2);
    }
}

/// A scene, and what is compared of it.
struct Scene<'a> {
    start: (System, State),
    springs: Springs,
    /// `(x, v)` of the coordinate.
    at: &'a dyn Fn(&State) -> (f64, f64),
    /// Deviations are relative to the solution or to this, if it is larger.
    floor: f64,
    /// Where the exact `x` leaves it, the comparison ends.
    range: f64,
    /// Sizes of the steps in units of [`H`], in turn.
    sizes: &'a [f64],
}

/// Steps a method and its recurrence side by side; returns how many steps were compared.
fn compare(row: &Row, scene: Scene<'_>, tolerance: f64) -> usize {
    let Scene { start, springs, at, floor, range, sizes } = scene;
    let mut run = prepared(row.id, start, H);
    let mut exact = Exact::new(row, springs, at(&run.state));
    for step in 0..STEPS {
        let h = H * sizes[step % sizes.len()];
        let expected = exact.next(h);
        if expected.x.abs() > range {
            return step;
        }
        let scaled = |y: &Vector2<f64>| Vector2::new(y.x, h * y.y).norm();
        let before = exact.levels.iter().map(scaled).fold(0.0, f64::max);
        run.step_by(h);
        let (x, v) = at(&run.state);
        let found = Vector2::new(x, h * v);
        let is_start = row.adopts_start && exact.levels.len() == 1;
        let deviation = (found - expected).norm() / expected.norm().max(before).max(floor);
        let allowed = if is_start { 1e-8 } else { tolerance };
        let Row { id, .. } = row;
        assert!(deviation < allowed, "{id}, {springs:?}, step {step}: {deviation:e}");
        exact.advance(if is_start { found } else { expected }, h);
    }
    STEPS
}

/// `(θ, η)`: smooth, stiff and damped, stiff, at an edge, overdamped.
const PARAMETERS: [(f64, f64); 5] =
    [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0), (2.0, 30.0)];
const CONSTANT: [f64; 1] = [1.0];
/// Ratios from 1/2 to 2, which two-step methods follow, and beyond, where they begin anew.
const VARYING: [f64; 10] = [1.0, 2.0, 1.5, 0.75, 1.25, 1.25, 0.625, 1.5, 0.6875, 1.0];
/// Where squares of an unstable solution do not overflow yet.
const FINITE: f64 = 1e100;

/// Whether the method takes shear springs explicitly, which is the default of IMEX Euler.
fn splits(id: &str) -> bool {
    has(id, "implicit=tension") || name(id) == "imex-euler" && !has(id, "implicit=springs")
}

fn tension_and_shear(springs: Springs, shear: f64) -> [(SpringEffect, f64, f64, f64); 2] {
    let (k, c) = coefficients(springs.implicit, springs.eta);
    let (k_shear, _) = coefficients(shear, 0.0);
    [(SpringEffect::Tension, 0.0, k, c), (SpringEffect::Shear, 0.0, k_shear, 0.0)]
}

/// A spring of rest length 0 is linear: each coordinate obeys the recurrence by itself.
#[test]
fn an_anchored_spring_of_rest_length_zero_moves_by_the_recurrence_at_any_step_sizes() {
    let (x, v) = (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    for row in rows() {
        for (theta, eta) in PARAMETERS {
            let springs = Springs::whole(theta, eta);
            let spec = anchored(MASS, &tension_and_shear(springs, 0.0)[..1], x, v);
            for (sizes, axis) in
                [&CONSTANT[..], &VARYING].iter().flat_map(|s| [0, 1, 2].map(|a| (s, a)))
            {
                let at = |state: &State| (state.x[1][axis], state.v[1][axis]);
                let start = build(&spec);
                let scene = Scene { start, springs, at: &at, floor: 0.0, range: FINITE, sizes };
                let steps = compare(&row, scene, row.tolerance);
                assert!(steps >= 20, "{}, θ={theta} η={eta}: {steps} steps", row.id);
            }
        }
    }
}

/// `x'' = −(κ_I + κ_E)x − δx'`: where tension alone is implicit, shear springs stay explicit.
#[test]
fn explicit_springs_beside_implicit_ones_move_by_the_test_equation() {
    let (x, v) = (Vec3::new(1.0, -0.5, 2.0), Vec3::new(0.0, 40.0, 7.0));
    let parameters = [
        (1.0, 0.5, 0.1),
        (1.0, 7.0, 0.0),
        (0.0, 0.3, 0.0),
        (0.0, 1.0, 0.0),
        (0.36, 0.1, 0.06),
        (0.36, 3.0, 0.06),
        (100.0, 2.0, 0.4),
        (100.0, 50.0, 0.0),
    ];
    for row in rows().into_iter().filter(|row| !sweeps(row.id)) {
        for (theta, shear, eta) in parameters {
            let springs = Springs { implicit: theta, explicit: shear, eta };
            let spec = anchored(MASS, &tension_and_shear(springs, shear), x, v);
            let whole = Springs::whole(theta + shear, eta);
            let springs = if splits(row.id) { springs } else { whole };
            for sizes in [&CONSTANT[..], &VARYING] {
                let at = |state: &State| (state.x[1].y, state.v[1].y);
                let start = build(&spec);
                let scene = Scene { start, springs, at: &at, floor: 0.0, range: FINITE, sizes };
                assert!(compare(&row, scene, row.tolerance) >= 20, "{}", row.id);
            }
        }
    }
}

/// The damping of an explicit spring is explicit too.
#[test]
fn imex_euler_with_explicit_springs_only_is_symplectic_euler() {
    let ((k, c), x) = (coefficients(1.0, 0.2), Vec3::new(1.0, 0.5, 0.0));
    let spec = anchored(MASS, &[(SpringEffect::Shear, 0.0, k, c)], x, Vec3::zeros());
    let row = one_step!(
        "imex-euler:implicit=tension,solver=cholesky",
        recurrence::symplectic_euler,
        EXACT,
        Unknown
    );
    let at = |state: &State| (state.x[1].x, state.v[1].x);
    let (springs, sizes) = (Springs::whole(1.0, 0.2), &CONSTANT);
    let scene = Scene { start: build(&spec), springs, at: &at, floor: 0.0, range: FINITE, sizes };
    assert_eq!(compare(&row, scene, EXACT), STEPS);
}

/// Along a spring with a rest length the motion is the same, offset by it, with both laws of
/// damping, as long as the spring does not turn round.
#[test]
fn motion_along_a_spring_with_a_rest_length_obeys_the_same_recurrence() {
    let (rest, direction) = (4.0, Vec3::new(0.0, 0.6, -0.8));
    let x = direction * (rest + 1.0 / 256.0);
    // The secant stiffness changes along a spring with a rest length.
    for row in rows().iter().filter(|row| !row.id.starts_with("terzopoulos-fleischer")) {
        for ((theta, eta), law) in PARAMETERS.into_iter().flat_map(|p| LAWS.map(|law| (p, law))) {
            // It solves full damping before the springs, and damping along them with them.
            if name(row.id) == "xpbd-lines" && law == DampingLaw::Projected {
                continue;
            }
            let (k, c) = coefficients(theta, eta);
            let springs = [(SpringEffect::Tension, rest, k, c)];
            let mut spec = anchored(MASS, &springs, x, Vec3::zeros());
            spec.damping = law;
            let at = |s: &State| (direction.dot(&s.x[1]) - rest, direction.dot(&s.v[1]));
            let (springs, range) = (Springs::whole(theta, eta), 0.5 * rest);
            let start = build(&spec);
            if !takes(row.id, &start.0) {
                continue;
            }
            let scene = Scene { start, springs, at: &at, floor: rest, range, sizes: &CONSTANT };
            assert!(compare(row, scene, row.tolerance) > 0, "{}, {law:?}", row.id);
        }
    }
}

const LAWS: [DampingLaw; 2] = [DampingLaw::Full, DampingLaw::Projected];

/// A particle between two pinned ones, at the ratio `σ` of rest length to length.
#[test]
fn motion_across_a_spring_obeys_the_recurrence_of_its_reduced_stiffness() {
    let parameters = [(100.0, 0.5), (100.0, 0.99), (100.0, 1.0), (100.0, 1.1), (0.36, 0.3)];
    for (row, (theta, ratio)) in rows().iter().flat_map(|row| parameters.map(|p| (row, p))) {
        let reduced: f64 = theta * (1.0 - ratio);
        let (implicit, explicit) = match row.across {
            Unknown => continue,
            Split => (theta, -ratio * theta),
            Clamped => (reduced.max(0.0), reduced.min(0.0)),
            Reduced => (reduced, 0.0),
        };
        // Where the motion is unstable, Newton's method finds another one, and a clamped secant is
        // none. The first step of a two-step method is one of Newton's: not compared here.
        let two_step = ["imex-sbdf2", "imex-cnab2", "imex-mcnab2", "imex-cnlf"];
        let iterates = row.id.contains("residual=");
        let departs = (iterates || has(row.id, "clamp=true")) && ratio > 1.0;
        if departs || two_step.contains(&name(row.id)) {
            continue;
        }
        // So small that the neglected square is round-off. Where Newton stops at the round-off of
        // the force along the springs, that must stay small beside the motion across them.
        let newton = if name(row.id) == "backward-euler" { 1e-7 } else { 1e-6 };
        let (amplitude, tolerance) = if iterates { (1e-5, newton) } else { (1e-9, ITERATIVE) };
        let floor = if iterates { amplitude } else { 0.0 };
        let (k, _) = coefficients(0.5 * theta, 0.0);
        let middle = Vec3::new(0.0, amplitude, -0.5 * amplitude);
        let positions = [-Vec3::x(), Vec3::x(), middle];
        let mut spec = particles(&[MASS; 3], &positions, &[Vec3::zeros(), Vec3::zeros(), -middle]);
        spec.pins = vec![pin(0), pin(1)];
        spec.springs = (0..2).map(|end| tension((end, 2), ratio, k, 0.0)).collect();
        let at = |state: &State| (state.x[2].z, state.v[2].z);
        let springs = Springs { implicit, explicit, eta: 0.0 };
        let (start, range, sizes) = (build(&spec), 1e3 * amplitude, &CONSTANT);
        let steps = compare(row, Scene { start, springs, at: &at, floor, range, sizes }, tolerance);
        assert!(steps > 0, "{}, θ={theta} ℓ/L={ratio}", row.id);
    }
}

/// A string of zero-length springs between two pins: each of its modes is an oscillator of its own.
#[test]
fn every_mode_of_a_string_moves_by_its_own_recurrence() {
    const FREE: usize = 7;
    let (theta, eta) = (25.0, 0.1);
    let (k, c) = coefficients(theta, eta);
    let mut random = Random::new(11);
    let mut vectors = |size: f64| -> Vec<Vec3> {
        let free = |i: usize| f64::from(u8::from(i > 0 && i <= FREE));
        (0..FREE + 2).map(|i| random.vector() * (size * free(i))).collect()
    };
    let mut spec = particles(&[MASS; FREE + 2], &vectors(1.0), &vectors(30.0));
    spec.pins = vec![pin(0), pin(FREE + 1)];
    spec.springs = (0..=FREE).map(|i| tension((i, i + 1), 0.0, k, c)).collect();
    let phase = |mode: usize| std::f64::consts::PI * mode as f64 / (FREE + 1) as f64;
    let modal = |mode: usize, state: &State| {
        let shape = |vectors: &[Vec3]| -> f64 {
            (0..FREE + 2).map(|i| (phase(mode) * i as f64).sin() * vectors[i].x).sum()
        };
        (shape(&state.x), shape(&state.v))
    };
    let check = |row: &Row, kang: Option<u32>| {
        let mut run = prepared(row.id, build(&spec), H);
        let mut modes: Vec<_> = (1..=FREE)
            .map(|mode| {
                let factor = 4.0 * (0.5 * phase(mode)).sin().powi(2);
                let springs = Springs::whole(theta * factor, eta * factor);
                (mode, factor, Exact::new(row, springs, modal(mode, &run.state)))
            })
            .collect();
        let mut largest: f64 = 0.0;
        for step in 0..STEPS {
            if largest > FINITE {
                break;
            }
            run.step();
            for (mode, factor, exact) in &mut modes {
                let expected = match kang {
                    None => exact.next(H),
                    Some(sweeps) => {
                        // The part of the diagonal that both neighbours have, and the mode's
                        // eigenvalue of their mean.
                        let both = 2.0 * (theta + eta);
                        let jacobi = both / (1.0 + both) * phase(*mode).cos();
                        let (theta, eta) = (theta * *factor, eta * *factor);
                        let y = Vector2::new(exact.levels[0].x, H * exact.levels[0].y);
                        recurrence::kang_mode(theta, eta, jacobi, sweeps) * y
                    }
                };
                let (x, v) = modal(*mode, &run.state);
                let found = Vector2::new(x, H * v);
                // Modes are told apart to round-off of the largest amplitude so far.
                largest = largest.max(expected.norm());
                let deviation = (found - expected).norm() / largest;
                let is_start = row.adopts_start && exact.levels.len() == 1;
                let allowed = if is_start { 1e-8 } else { row.tolerance };
                assert!(deviation < allowed, "{}, mode {mode}, step {step}: {deviation:e}", row.id);
                exact.advance(if is_start { found } else { expected }, H);
            }
        }
    };
    for row in rows().iter().filter(|row| row.id != "kang" && !sweeps(row.id)) {
        check(row, None);
    }
    for (id, sweeps) in [("kang:sweeps=1", 1), ("kang:sweeps=2", 2), ("kang:sweeps=5", 5)] {
        check(&row(id, EXACT, Unknown, imex), Some(sweeps));
    }
}

/// A little below and above the explicit stiffness that theory allows beside the implicit one.
#[test]
fn explicit_springs_are_stable_up_to_the_limit_of_each_method() {
    let limits = [
        ("imex-euler", 10.0, 13.9, 14.1),
        ("imex-euler", 0.0, 3.9, 4.1),
        ("imex-sbdf2", 1e4, 3200.0, 3500.0),
        ("imex-mcnab2", 1e4, 1200.0, 1300.0),
        ("imex-cnlf", 1e4, 9900.0, 10100.0),
        ("imex-cnab2", 1e4, 0.0, 100.0),
        ("leapfrog", 3.95, 0.0, 0.1),
    ];
    for (id, implicit, below, above) in limits {
        for (explicit, stable) in [(below, true), (above, false)] {
            let springs = Springs::whole(implicit, 0.0);
            let springs = tension_and_shear(springs, explicit);
            let count = if explicit > 0.0 { 2 } else { 1 };
            let split = if id == "leapfrog" { "" } else { ":implicit=tension,solver=cholesky" };
            let spec = anchored(MASS, &springs[..count], Vec3::x(), Vec3::zeros());
            let mut run = prepared(&format!("{id}{split}"), build(&spec), H);
            run.steps(3000);
            let Run { state, .. } = &run;
            let size = state.x[1].norm() + H * state.v[1].norm();
            assert_eq!(size < 1e3, stable, "{id}, θ_I={implicit} θ_E={explicit}: {size:e}");
        }
    }
}
