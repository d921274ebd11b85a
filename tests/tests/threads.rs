//! A run has the same bits with any number of threads.

use drape_integrator::ExplicitNumbers;
use drape_model::{State, System};
use drape_tests::{Sheet, assert_covers, bits, prepared, stir};
use std::num::NonZero;

/// Each method with settings whose steps are quick on many particles.
const METHODS: [&str; 33] = [
    "explicit-euler",
    "symplectic-euler",
    "symplectic-euler:damping=implicit",
    "leapfrog",
    "provot",
    "adams-bashforth2",
    "backward-euler:solver=cg,residual=1e-3",
    "bdf2:solver=cg,residual=1e-3",
    "backward-euler",
    "backward-euler:solver=multigrid,residual=1e-3",
    "terzopoulos-fleischer",
    "baraff-witkin",
    "desbrun",
    "kang",
    "imex-euler",
    "imex-euler:preconditioner=jacobi",
    "imex-updated:safeguard=paper,max_outer=3",
    "midpoint:solver=cg,residual=1e-3",
    "dirk:solver=cg,residual=1e-3",
    "generalized-alpha:solver=cg,residual=1e-3",
    "vbd:sweeps=3",
    "imex-rk:solver=cg",
    "leapfrog:damping=explicit",
    "rkc",
    "srkn4",
    "multirate",
    "projective:acceleration=anderson,iterations=3",
    "projective:acceleration=admm,iterations=2,solver=cg",
    "xpbd:substeps=2",
    "xpbd:substeps=2,sweep=coloured",
    "xpbd-lines:substeps=2",
    "exponential:krylov_tol=1e-2",
    "energy-momentum:residual=1e-2",
];

/// As many particles as threads are used for, and more.
fn large() -> (System, State) {
    let sheet = Sheet { side: 130, tension: 1e5, shear: 1e4, ..Sheet::default() };
    stir(sheet.build(), 1e-3, 0.1)
}

#[test]
fn every_method_has_the_same_bits_with_one_thread_and_with_three() {
    let starts = "its first step factorises a matrix of blocks, which takes seconds at this size";
    let exceptions =
        ["imex-sbdf2", "imex-cnab2", "imex-mcnab2", "imex-cnlf"].map(|id| (id, starts));
    let each = "each of its steps factorises a matrix of blocks, which takes seconds at this size";
    let exceptions = [&exceptions[..], &[("rosenbrock", each)]].concat();
    assert_covers("threads", METHODS, &exceptions);
    let start = large();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("three threads");
    for id in METHODS {
        let [one, three] = [1, 3].map(|threads| {
            let (mut system, state) = start.clone();
            system.set_threads(NonZero::new(threads).expect("positive"));
            pool.install(|| {
                let mut run = prepared(id, (system, state), 1e-4);
                run.steps(2);
                bits(&run.state)
            })
        });
        assert!(one == three, "{id}");
    }
}

/// So have the energies that a run takes between its steps, and the numbers that limit its step.
#[test]
fn energies_and_limits_have_the_same_bits_with_one_thread_and_with_three() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("three threads");
    let [one, three] = [1, 3].map(|threads| {
        let (mut system, state) = large();
        system.set_threads(NonZero::new(threads).expect("positive"));
        assert!(!system.has_helpers(), "outside of a pool nobody helps");
        pool.install(|| {
            assert_eq!(system.has_helpers(), threads > 1);
            let energies: Vec<_> = system.energies(&state.x).collect();
            let total: f64 = energies.iter().map(|(_, energy)| energy).sum();
            assert_eq!(total.to_bits(), system.potential_energy(&state.x).to_bits());
            let numbers = ExplicitNumbers::new(&system, &state, &|effect| effect.name() == "shear");
            (energies, numbers)
        })
    });
    assert!(one.0.len() > 2 && one.1.explicit_stiffness > 0.0, "{one:?}");
    assert_eq!(one, three);
}
