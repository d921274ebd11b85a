//! A run has the same bits with any number of threads.

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

#[test]
fn every_method_has_the_same_bits_with_one_thread_and_with_three() {
    let starts = "its first step factorises a matrix of blocks, which takes seconds at this size";
    let exceptions =
        ["imex-sbdf2", "imex-cnab2", "imex-mcnab2", "imex-cnlf"].map(|id| (id, starts));
    let each = "each of its steps factorises a matrix of blocks, which takes seconds at this size";
    let exceptions = [&exceptions[..], &[("rosenbrock", each)]].concat();
    assert_covers("threads", METHODS, &exceptions);
    // As many particles as threads are used for, and more.
    let sheet = Sheet { side: 130, tension: 1e5, shear: 1e4, ..Sheet::default() };
    let start = stir(sheet.build(), 1e-3, 0.1);
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
