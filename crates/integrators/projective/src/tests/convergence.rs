//! Each acceleration against Newton's minimum of one step of a hanging sheet.

use super::run;
use drape_integrator::{
    Implicit, IncrementalPotential, Newton, NewtonLinear, NewtonSettings, Safeguard, SolveStatus,
};
use drape_model::{State, System, Vec3};
use drape_oracle::scenes::Sheet;
use drape_solvers::{Constraints, Filter};

pub(super) const H: f64 = 0.01;

/// The sheet of 20 × 20 particles that hangs from two corners; shear springs have a tenth.
pub(super) fn hanging(tension: f64, damping: f64) -> (System, State) {
    Sheet { side: 20, tension, shear: 0.1 * tension, damping, ..Sheet::default() }.build()
}

/// Leapfrog with explicit damping, just under its limit; returns the path of the middle of the free
/// edge, m.
pub(super) fn leapfrog((system, state): &mut (System, State), stiffness: f64, span: f64) -> f64 {
    let steps = (span * (4.35 * stiffness).sqrt() / 1.4).ceil().max(span / 1e-4);
    let h = span / steps;
    let mut force = vec![Vec3::zeros(); state.len()];
    system.forces(state.level(), &mut force);
    let mut path = 0.0;
    for _ in 0..steps as u64 {
        let before = middle(state);
        for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
            state.v[i] += force[i] * (0.5 * h / system.mass()[i]);
            state.x[i] += state.v[i] * h;
        }
        system.forces(state.level(), &mut force);
        for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
            state.v[i] += force[i] * (0.5 * h / system.mass()[i]);
        }
        path += (middle(state) - before).norm();
    }
    state.t += span;
    path
}

/// The middle of the free edge, m.
pub(super) fn middle(state: &State) -> Vec3 {
    (state.x[19 * 20 + 9] + state.x[19 * 20 + 10]) * 0.5
}

/// The minimum of the incremental potential of one step, and its inertial start, m/s.
pub(super) fn newton(system: &System, state: &State) -> (Vec<Vec3>, Vec<Vec3>) {
    let mut potential = IncrementalPotential::new(system, Implicit::Springs);
    let mut newton = Newton::new(system, &potential, NewtonLinear::CHOLESKY)
        .unwrap_or_else(|error| panic!("{error}"));
    let mut constraints = Constraints::free(state.len());
    for i in (0..state.len()).filter(|&i| system.pinned()[i]) {
        constraints.set(i, Filter::Fixed, Vec3::zeros());
    }
    let mut frozen = vec![Vec3::zeros(); state.len()];
    Implicit::Springs.add_explicit_forces(system, state.level(), &mut frozen);
    potential.begin(system, H, (&state.x, &state.v), state.level(), &frozen);
    let mut start = potential.target().to_vec();
    constraints.impose(&mut start);
    let mut v = start.clone();
    let residual = potential.round_off().max(1e-13 * potential.scale());
    let settings = NewtonSettings { residual, max_iterations: 300, safeguard: Safeguard::None };
    let report = newton
        .minimise(system, &mut potential, &constraints, &mut v, &settings)
        .unwrap_or_else(|error| panic!("{error}"));
    assert_ne!(report.status, SolveStatus::IterationLimit, "{report:?}");
    (v, start)
}

fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>().sqrt()
}

/// The sheet after 0.2 s without damping, with the minimum of its next step and the start.
pub(super) struct Moment {
    start: (System, State),
    minimum: Vec<Vec3>,
    whole: f64,
}

impl Moment {
    pub(super) fn new(theta: f64) -> Self {
        let stiffness = theta / (H * H);
        let mut start = hanging(stiffness, 0.0);
        leapfrog(&mut start, stiffness, 0.2);
        let (minimum, inertial) = newton(&start.0, &start.1);
        let whole = distance(&inertial, &minimum);
        Self { start, minimum, whole }
    }

    /// What `iterations` leave of the distance between the start and the minimum.
    pub(super) fn left(&self, acceleration: &str, iterations: u32) -> f64 {
        let text = format!("acceleration={acceleration},iterations={iterations}");
        let mut run = run(&text, self.start.clone(), H);
        run.step();
        distance(&run.state.v, &self.minimum) / self.whole
    }
}

const FORMS: [&str; 7] = [
    "none",
    "chebyshev,rho=0.95",
    "chebyshev,rho=0.99",
    "chebyshev,rho=0.999",
    "anderson",
    "lbfgs",
    "admm",
];

/// What is left after 10, 30 and 100 iterations at `h²k/m` = 1 and 100.
#[test]
fn each_acceleration_comes_as_near_to_newtons_minimum_as_an_independent_program_says() {
    // The guard of Anderson's acceleration decides differently after a little round-off.
    let close = |found: f64, expected: f64, case: &str| {
        let tolerance = if case.starts_with("anderson") { 0.2 } else { 0.05 };
        assert!((found / expected - 1.0).abs() < tolerance, "{case}: {found:e}, not {expected:e}");
    };
    let one = Moment::new(1.0);
    let hundred = Moment::new(100.0);
    for (form, at_one, at_hundred) in [
        ("none", [2.863e-2, 3.631e-4], [4.802e-1, 3.525e-1, 1.819e-1]),
        ("chebyshev,rho=0.95", [2.863e-2, 6.140e-5], [4.802e-1, 2.130e-1, 4.968e-2]),
        ("chebyshev,rho=0.99", [2.863e-2, 2.873e-3], [4.802e-1, 9.837e-2, 6.284e-3]),
        ("anderson", [4.265e-4, 2.004e-9], [3.017e-1, 4.781e-2, 1.196e-4]),
        ("lbfgs", [1.589e-3, 3.139e-8], [2.934e-1, 6.248e-2, 1.036e-3]),
        ("admm", [3.311e-2, 5.248e-4], [4.806e-1, 3.530e-1, 1.823e-1]),
    ] {
        for (iterations, expected) in [10, 30].into_iter().zip(at_one) {
            close(one.left(form, iterations), expected, &format!("{form}, 1, {iterations}"));
        }
        for (iterations, expected) in [10, 30, 100].into_iter().zip(at_hundred) {
            close(hundred.left(form, iterations), expected, &format!("{form}, 100, {iterations}"));
        }
    }
}

/// The table of the crate's documentation.
#[test]
#[ignore = "prints the table of the documentation"]
#[allow(clippy::print_stderr, reason = "a table")]
fn table_of_convergence() {
    for (theta, counts) in
        [(1.0, &[10, 30, 100][..]), (100.0, &[10, 30, 100, 400]), (1e4, &[30, 100, 400])]
    {
        let moment = Moment::new(theta);
        for form in FORMS {
            let left: Vec<String> =
                counts.iter().map(|&k| format!("{:.3e}", moment.left(form, k))).collect();
            eprintln!("θ={theta} {form}: {}", left.join(" | "));
        }
    }
}
