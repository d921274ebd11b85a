//! What each method says that it conserves, it conserves; what it does not say, it does not.

use drape_harness::methods;
use drape_integrator::Quantity;
use drape_model::{DampingLaw, SpringEffect, State, System, Vec3};
use drape_tests::{Random, Run, assert_covers, build, name, particles, prepared, spring, takes};

/// Solved to round-off where a solve is inside; a step that Provot's limit is reached in.
const TIGHT: [&str; 43] = [
    "explicit-euler",
    "symplectic-euler",
    "leapfrog",
    "provot:limit=0.01",
    "provot:limit=0.01,velocity=positions-only",
    "adams-bashforth2",
    "adams-bashforth2:steps=1",
    "adams-bashforth2:steps=3",
    "backward-euler:residual=1e-16,solver=cholesky",
    "bdf2:residual=1e-16,solver=cholesky",
    "bdf2:steps=1,residual=1e-16,solver=cholesky",
    "bdf2:steps=3,residual=1e-16,solver=cholesky",
    "terzopoulos-fleischer",
    "baraff-witkin:forcing_term=1e-14",
    "baraff-witkin:solver=cholesky,implicit=tension",
    "desbrun",
    "kang",
    "imex-euler:forcing_term=1e-14,implicit=springs",
    "imex-updated:forcing_term=1e-14",
    "imex-sbdf2:forcing_term=1e-14",
    "imex-cnab2:forcing_term=1e-14",
    "imex-mcnab2:forcing_term=1e-14",
    "imex-cnlf:forcing_term=1e-14",
    "midpoint:residual=1e-16,solver=cholesky",
    "dirk:residual=1e-16,solver=cholesky",
    "generalized-alpha:residual=1e-16,solver=cholesky",
    // More sweeps converge on this net, and converged steps keep the momentum.
    "vbd:sweeps=1",
    "imex-rk",
    "rosenbrock",
    "leapfrog:damping=explicit",
    "srkn4",
    "multirate",
    "projective",
    "projective:acceleration=anderson",
    "projective:acceleration=lbfgs",
    "projective:acceleration=admm",
    "xpbd",
    "xpbd:substeps=2,iterations=5,sweep=coloured",
    "xpbd:substeps=4,order=2",
    "xpbd-lines:substeps=4",
    "xpbd-lines:substeps=2,iterations=5,order=1",
    "exponential:krylov_tol=1e-10",
    "energy-momentum:residual=1e-16",
];

/// The implicit ones at `θ` about 10⁴. A residual would be seen there: what is linear is solved
/// directly.
const STIFF: [&str; 21] = [
    "backward-euler:residual=1e-16,solver=cholesky",
    "bdf2:residual=1e-16,solver=cholesky",
    "terzopoulos-fleischer:clamp=true",
    "baraff-witkin:solver=cholesky",
    "desbrun",
    "desbrun:inverse=dense",
    "kang",
    "imex-euler:solver=cholesky,implicit=springs",
    "imex-updated:solver=cholesky,forcing_term=1e-14",
    "imex-sbdf2:solver=cholesky",
    "imex-cnab2:solver=cholesky",
    "imex-mcnab2:solver=cholesky",
    "dirk:residual=1e-16,solver=cholesky",
    "generalized-alpha:residual=1e-16,solver=cholesky",
    "vbd",
    "imex-rk",
    "projective",
    "projective:acceleration=lbfgs",
    "xpbd:substeps=1",
    "xpbd-lines:substeps=1,order=1",
    "energy-momentum:residual=1e-16",
];

/// Free particles of different masses on a random net of springs, in any state of stretch;
/// `stiffness` is the mean of theirs, N/m, `damping` the coefficient of all, N s/m.
fn net(stiffness: f64, damping: f64, law: DampingLaw) -> (System, State) {
    let mut random = Random::new(21);
    let n = 12;
    let masses: Vec<f64> = (0..n).map(|_| random.between(0.5, 2.0)).collect();
    let x: Vec<Vec3> = (0..n).map(|_| random.vector()).collect();
    let v: Vec<Vec3> = (0..n).map(|_| random.vector()).collect();
    let mut spec = particles(&masses, &x, &v);
    for i in 1..n {
        for j in 0..i {
            if j + 1 != i && random.chance(0.7) {
                continue;
            }
            let length = (x[i] - x[j]).norm();
            let effect =
                if random.chance(0.5) { SpringEffect::Tension } else { SpringEffect::Shear };
            let rest = length * random.between(0.7, 1.3);
            let k = stiffness * random.between(0.4, 1.6);
            spec.springs.push(spring(effect, (i, j), rest, k, damping));
        }
    }
    spec.damping = law;
    build(&spec)
}

const H: f64 = 0.01;
const STEPS: usize = 50;

/// Greatest change of momentum and of angular momentum, and the largest sum of the terms that each
/// adds up from.
struct Drifts {
    drift: [f64; 2],
    terms: [f64; 2],
}

fn drifts(id: &str, net: (System, State)) -> Drifts {
    let mut run = prepared(id, net, H);
    let values =
        |run: &Run| [run.system.momentum(&run.state), run.system.angular_momentum(&run.state)];
    let start = values(&run);
    let (mut drift, mut terms) = ([0.0_f64; 2], [0.0_f64; 2]);
    for _ in 0..STEPS {
        run.step();
        for (drift, (now, start)) in drift.iter_mut().zip(values(&run).iter().zip(&start)) {
            *drift = drift.max((now - start).norm());
        }
        let (mut momentum, mut spin) = (0.0, 0.0);
        for ((x, v), m) in run.state.x.iter().zip(&run.state.v).zip(run.system.mass()) {
            momentum += m * (v.norm() + x.norm() / H);
            spin += m * x.norm() * (v.norm() + x.norm() / H);
        }
        terms = [terms[0].max(momentum), terms[1].max(spin)];
    }
    Drifts { drift, terms }
}

#[test]
fn methods_conserve_what_they_state_and_nothing_else() {
    let refuses = "refuses springs without damping; see the tests of its crate";
    assert_covers("conservation", TIGHT, &[("rkc", refuses)]);
    for id in TIGHT {
        check(id, 125.0, 1e-13);
    }
}

/// Round-off is `θ` times as large: masses are lost in a matrix of large stiffnesses, once in each
/// stage of a step.
#[test]
fn implicit_methods_conserve_the_same_on_a_stiff_net() {
    for id in STIFF {
        check(id, 1e8, 2e-11);
    }
}

/// Damping acts in pairs.
#[test]
fn methods_that_conserve_momentum_do_so_with_damping() {
    for (id, law) in TIGHT.into_iter().flat_map(|id| LAWS.map(|law| (id, law))) {
        let method = methods::all().find(|method| name(id) == method.id).expect("a method");
        let net = net(125.0, 2.0, law);
        if !takes(id, &net.0) {
            continue;
        }
        let Drifts { drift, terms } = drifts(id, net);
        if method.conserves.contains(&Quantity::Momentum) {
            assert!(drift[0] < 1e-13 * terms[0], "{id}, {law:?}: {:e}", drift[0] / terms[0]);
        }
    }
}

const LAWS: [DampingLaw; 2] = [DampingLaw::Full, DampingLaw::Projected];

fn check(id: &str, stiffness: f64, tolerance: f64) {
    let method = methods::all().find(|method| name(id) == method.id).expect("a method");
    let Drifts { drift, terms } = drifts(id, net(stiffness, 0.0, DampingLaw::Full));
    for (k, quantity) in [Quantity::Momentum, Quantity::AngularMomentum].iter().enumerate() {
        let (name, drift) = (quantity.name(), drift[k] / terms[k]);
        if method.conserves.contains(quantity) {
            assert!(drift < tolerance, "{id}: {name} drifts by {drift:e}");
        } else {
            assert!(drift > 1e-6, "{id}: {name} drifts by {drift:e} only, and is not stated");
        }
    }
}
