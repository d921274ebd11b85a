//! What each method says that it conserves, it conserves; what it does not say, it does not.

use drape_harness::methods;
use drape_integrator::Quantity;
use drape_model::{SpringEffect, State, System, Vec3};
use drape_oracle::Random;
use drape_tests::{Run, build, particles, spring};

/// Solved to round-off where a solve is inside; a step that Provot's limit is reached in.
const TIGHT: [&str; 17] = [
    "explicit-euler",
    "symplectic-euler",
    "leapfrog",
    "provot:limit=0.01",
    "adams-bashforth2",
    "backward-euler:residual=1e-16",
    "bdf2:residual=1e-16",
    "terzopoulos-fleischer",
    "baraff-witkin:forcing_term=1e-14",
    "desbrun",
    "kang",
    "imex-euler:forcing_term=1e-14,implicit=springs",
    "imex-updated:forcing_term=1e-14",
    "imex-sbdf2:forcing_term=1e-14",
    "imex-cnab2:forcing_term=1e-14",
    "imex-mcnab2:forcing_term=1e-14",
    "imex-cnlf:forcing_term=1e-14",
];

/// Free particles of different masses on a random net of undamped springs, in any state of stretch.
fn net() -> (System, State) {
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
            spec.springs.push(spring(effect, (i, j), rest, random.between(50.0, 200.0), 0.0));
        }
    }
    build(&spec)
}

/// Greatest change of momentum and of angular momentum, each over its own scale.
fn drifts(id: &str) -> [f64; 2] {
    let mut run = Run::new(id, net(), 0.01);
    let values =
        |run: &Run| [run.system.momentum(&run.state), run.system.angular_momentum(&run.state)];
    let start = values(&run);
    let mut worst = [0.0_f64; 2];
    for _ in 0..50 {
        run.step();
        for (worst, (now, start)) in worst.iter_mut().zip(values(&run).iter().zip(&start)) {
            // Masses, lengths and speeds are of order 1.
            *worst = worst.max((now - start).norm() / run.system.len() as f64);
        }
    }
    worst
}

#[test]
fn methods_conserve_what_they_state_and_nothing_else() {
    for method in methods::all() {
        let id = TIGHT.iter().find(|id| id.split(':').next() == Some(method.id));
        let id = id.unwrap_or_else(|| panic!("{} is not in the list", method.id));
        let found = drifts(id);
        for (quantity, drift) in [Quantity::Momentum, Quantity::AngularMomentum].iter().zip(found) {
            let name = quantity.name();
            if method.conserves.contains(quantity) {
                assert!(drift < 1e-11, "{id}: {name} drifts by {drift:e}");
            } else {
                assert!(drift > 1e-6, "{id}: {name} drifts by {drift:e} only, and is not stated");
            }
        }
    }
}
