//! What the tests across crates share: the methods with their settings, and runs of them.

pub mod auto;
pub mod drape;
pub mod engine;
pub mod equations;
pub mod fuzz;
pub mod splice;

use drape_harness::methods::{self, Choice};
use drape_integrator::{Integrator, PrepareError, Setups, StepReport};
use drape_model::{State, System};
pub use drape_oracle::scenes::{
    GRAVITY, Sheet, anchored, build, floor, gravity, particles, pin, spring, stiffening, stir,
    tension, uneven,
};
pub use drape_oracle::{Random, Run, apart, bits, largest, seconds};

/// Every method, with settings that lead through different code.
pub const METHODS: [&str; 90] = [
    "explicit-euler",
    "symplectic-euler",
    "symplectic-euler:damping=implicit",
    "leapfrog",
    "leapfrog:solver=cholesky",
    "leapfrog:step=auto",
    "provot",
    "provot:limit=1e-3,sweeps=4,order=alternating,velocity=positions-only",
    "adams-bashforth2",
    "adams-bashforth2:steps=1",
    "adams-bashforth2:steps=3",
    "backward-euler",
    "backward-euler:jacobian=saved",
    "backward-euler:solver=cg,forcing=eisenstat-walker",
    "backward-euler:solver=multigrid,forcing=eisenstat-walker",
    "backward-euler:tolerance=0.01",
    "bdf2",
    "bdf2:steps=1",
    "bdf2:jacobian=saved,solver=cg",
    "bdf2:tolerance=0.01",
    "bdf2:steps=3",
    "bdf2:max_iterations=1,solver=cg,safeguard=work",
    "backward-euler:solver=cholesky",
    "terzopoulos-fleischer",
    "terzopoulos-fleischer:clamp=true",
    "baraff-witkin",
    "baraff-witkin:hessian=raw,norm=euclid,preconditioner=none",
    "baraff-witkin:solver=cholesky,contact=position,implicit=tension",
    "baraff-witkin:hessian=raw,solver=cholesky,start=last",
    "desbrun",
    "desbrun:inverse=dense,torque=literal",
    "desbrun:torque=none,inverse_dynamics=true,limit=1e-3",
    "kang",
    "kang:sweeps=5",
    "imex-euler",
    "imex-euler:solver=cholesky,implicit=springs",
    "imex-euler:tolerance=0.01",
    "imex-euler:preconditioner=jacobi,norm=preconditioned,start=last",
    "imex-updated",
    "imex-updated:newton_above=0",
    "imex-updated:forcing=eisenstat-walker",
    "imex-updated:tolerance=0.01",
    "imex-updated:safeguard=paper",
    "imex-updated:solver=cholesky",
    "imex-sbdf2",
    "imex-sbdf2:solver=cholesky",
    "imex-sbdf2:tolerance=0.01",
    "imex-cnab2",
    "imex-mcnab2",
    "imex-mcnab2:tolerance=0.01,estimator=plain",
    "imex-mcnab2:implicit=tension,norm=preconditioned,start=last",
    "imex-cnlf",
    "midpoint",
    "midpoint:jacobian=saved,solver=cg",
    "midpoint:tolerance=0.01",
    "dirk",
    "dirk:tableau=sdirk2,jacobian=saved",
    "dirk:tableau=esdirk3",
    "dirk:tableau=sdirk4",
    "dirk:tolerance=0.01",
    "generalized-alpha",
    "generalized-alpha:family=newmark,rho_inf=1",
    "vbd",
    "vbd:start=previous,sweeps=60,chebyshev=0.5",
    "vbd:augmented=true,sweeps=5,start=inertial",
    "imex-rk",
    "imex-rk:tableau=ark4,solver=cg",
    "imex-rk:tableau=ark3,implicit=tension",
    "rosenbrock",
    "rosenbrock:tableau=ros34pw2,jacobian=clamped",
    "leapfrog:damping=explicit",
    "rkc",
    "srkn4",
    "multirate",
    "multirate:ratio=2,slow=bending",
    "projective",
    "projective:acceleration=chebyshev,iterations=15",
    "projective:acceleration=anderson",
    "projective:acceleration=lbfgs,memory=3",
    "projective:acceleration=admm",
    "xpbd",
    "xpbd:substeps=4,iterations=3,sweep=coloured",
    "xpbd:substeps=8,order=2",
    "xpbd-lines",
    "xpbd-lines:substeps=1",
    "xpbd-lines:substeps=4,iterations=3,order=1",
    "exponential",
    "exponential:krylov_tol=1e-3,max_dim=20",
    "energy-momentum",
    "energy-momentum:on_failure=report",
];

/// The id of a method without its settings.
pub fn name(id: &str) -> &str {
    id.split(':').next().unwrap_or(id)
}

/// Whether the settings of an id have this pair.
pub fn has(id: &str, pair: &str) -> bool {
    id.split([':', ',']).skip(1).any(|given| given == pair)
}

/// Whether the method controls its step size, so that a call takes several steps.
pub fn is_adaptive(id: &str) -> bool {
    id.contains("tolerance=")
}

/// Checks that a table has a row for every method of the registry, or says why it has none.
///
/// # Panics
/// For a method without a row or an exception, with both, and for a name that is no method.
pub fn assert_covers<'a>(
    table: &str,
    rows: impl IntoIterator<Item = &'a str>,
    exceptions: &[(&str, &str)],
) {
    let rows: Vec<_> = rows.into_iter().map(name).collect();
    for method in methods::all() {
        let has_row = rows.contains(&method.id);
        let is_exempt = exceptions.iter().any(|(id, _)| *id == method.id);
        assert!(has_row || is_exempt, "{table}: add a row or an exception for {}", method.id);
        assert!(!(has_row && is_exempt), "{table}: {} has a row and an exception", method.id);
    }
    let names = rows.iter().chain(exceptions.iter().map(|(id, _)| id));
    for id in names {
        assert!(methods::all().any(|method| method.id == *id), "{table}: no method {id}");
    }
}

/// An integrator by its id and settings, as on the command line.
///
/// # Panics
/// When no such method or setting exists.
pub fn method(id: &str) -> Box<dyn Integrator> {
    let choice = Choice::parse(id, &[]).unwrap_or_else(|error| panic!("{error}"));
    choice.build().unwrap_or_else(|error| panic!("{error}"))
}

/// A method prepared for a system.
///
/// # Panics
/// When the method refuses the system.
pub fn prepared(id: &str, start: (System, State), h: f64) -> Run {
    Run::new(method(id), start, h)
}

/// The same state with a new integrator.
pub fn fresh(id: &str, run: &Run) -> Run {
    prepared(id, (run.system.clone(), run.state.clone()), run.h)
}

/// A report without its set-ups, which a new integrator charges to another cause.
pub fn work(report: StepReport) -> StepReport {
    StepReport { setups: Setups::default(), ..report }
}

/// Whether the method of this id takes a system; it refuses by name what it cannot take.
///
/// # Panics
/// When no such method or setting exists.
pub fn takes(id: &str, system: &System) -> bool {
    let refused = method(id).prepare(system, seconds(0.01));
    !matches!(refused, Err(PrepareError::Unsupported { .. }))
}

/// Whether the method of this id takes obstacles with friction.
///
/// # Panics
/// When no such method or setting exists.
pub fn takes_friction(id: &str) -> bool {
    let choice = Choice::parse(id, &[]).unwrap_or_else(|error| panic!("{error}"));
    choice.method().supports().any(|support| support.effect == "friction")
}

/// A bundled scene at its start.
///
/// # Panics
/// When no bundled scene has this name.
pub fn bundled(name: &str) -> (System, State) {
    build(&drape_oracle::scenes::bundled(name))
}
