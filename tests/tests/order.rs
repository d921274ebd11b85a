//! The error of every method falls with the order that theory gives.

use drape_model::{DampingLaw, State, System, Vec3};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::order::{of_method, position_error};
use drape_oracle::order_of;
use drape_oracle::reference::{Reference, reference};
use drape_tests::{Sheet, assert_covers, method, prepared, stir, takes};

/// `8 (k + k_s)/m ≥ ω_max²`.
const OMEGA_MAX: f64 = 63.3;
const SPAN: f64 = 0.25;

/// How a method stands changes of its step size.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Steps {
    /// It keeps its order.
    Any,
    /// It keeps its order while steps change by less than half.
    Gentle,
    /// Each change costs it an order: it begins anew, or carries what belongs to the old step.
    Constant,
}

use Steps::{Any, Constant, Gentle};

/// The order of each method; solves are tight enough not to be seen.
const METHODS: [(&str, i32, Steps); 63] = [
    ("explicit-euler", 1, Any),
    ("symplectic-euler", 1, Any),
    ("symplectic-euler:damping=implicit", 1, Any),
    ("leapfrog", 2, Any),
    ("leapfrog:solver=cholesky", 2, Any),
    // With its limit out of reach: the correction has no order.
    ("provot:limit=10", 1, Any),
    ("adams-bashforth2:steps=1", 1, Any),
    ("adams-bashforth2", 2, Any),
    ("adams-bashforth2:steps=3", 3, Any),
    ("backward-euler:residual=1e-12,solver=cholesky", 1, Any),
    ("bdf2:residual=1e-12,steps=1,solver=cholesky", 1, Any),
    ("bdf2:residual=1e-13,solver=cholesky", 2, Any),
    ("bdf2:residual=1e-15,steps=3,solver=cholesky", 3, Gentle),
    ("terzopoulos-fleischer", 1, Any),
    ("baraff-witkin:forcing_term=1e-10", 1, Any),
    ("baraff-witkin:hessian=raw,forcing_term=1e-10", 1, Any),
    ("baraff-witkin:implicit=tension,solver=cholesky", 1, Any),
    ("desbrun", 1, Any),
    ("desbrun:inverse=dense", 1, Any),
    ("desbrun:torque=none,inverse=dense", 1, Any),
    ("kang", 1, Any),
    ("kang:sweeps=4", 1, Any),
    ("imex-euler:forcing_term=1e-10", 1, Any),
    ("imex-euler:forcing_term=1e-10,implicit=springs", 1, Any),
    ("imex-updated:forcing_term=1e-9", 1, Any),
    ("imex-updated:forcing_term=1e-9,safeguard=paper", 1, Any),
    ("imex-sbdf2:forcing_term=1e-12", 2, Any),
    ("imex-sbdf2:solver=cholesky", 2, Any),
    ("imex-sbdf2:forcing_term=1e-12,implicit=tension", 2, Any),
    ("imex-cnab2:forcing_term=1e-12", 2, Any),
    ("imex-cnab2:forcing_term=1e-12,implicit=tension", 2, Any),
    ("imex-mcnab2:forcing_term=1e-12", 2, Any),
    ("imex-mcnab2:forcing_term=1e-12,implicit=tension", 2, Any),
    ("imex-cnlf:forcing_term=1e-12", 2, Constant),
    ("imex-cnlf:forcing_term=1e-12,implicit=tension", 2, Constant),
    ("midpoint:residual=1e-13,solver=cholesky", 2, Any),
    ("dirk:residual=1e-13,solver=cholesky", 2, Any),
    ("dirk:tableau=sdirk2,residual=1e-13,solver=cholesky", 2, Any),
    // Its acceleration belongs to a time between two steps, which depends on their length.
    ("generalized-alpha:residual=1e-13,solver=cholesky", 2, Constant),
    ("generalized-alpha:family=newmark,rho_inf=1,residual=1e-13,solver=cholesky", 2, Any),
    ("generalized-alpha:family=newmark,rho_inf=0.5,residual=1e-12,solver=cholesky", 1, Any),
    ("vbd", 1, Any),
    ("vbd:start=previous,sweeps=40", 1, Any),
    ("imex-rk", 2, Any),
    ("imex-rk:solver=cg,forcing_term=1e-12", 2, Any),
    // With steps of 1 and 2 in turn the errors come to the order late: 2.5, 2.8, 2.9.
    ("imex-rk:tableau=ars443", 3, Gentle),
    ("imex-rk:tableau=ark3", 3, Any),
    ("imex-rk:tableau=ark4", 4, Any),
    ("rosenbrock", 2, Any),
    ("rosenbrock:jacobian=clamped", 2, Any),
    // The others refuse projected damping: their orders stand in the tests of the method.
    ("rosenbrock:tableau=ros34pw2", 3, Any),
    ("leapfrog:damping=explicit", 2, Any),
    ("rkc:step=fixed,stages=6", 2, Any),
    ("multirate", 2, Any),
    ("projective:iterations=200,residual=1e-9", 1, Any),
    ("projective:acceleration=lbfgs,iterations=200,residual=1e-9", 1, Any),
    ("xpbd", 1, Any),
    ("xpbd:substeps=2,iterations=3,sweep=coloured", 1, Any),
    // One sweep leaves an error of the damping that is of order 1.
    ("xpbd:substeps=4,order=2,iterations=2", 2, Any),
    ("xpbd-lines:substeps=2,order=1", 1, Any),
    ("xpbd-lines:substeps=4,iterations=2", 2, Any),
    ("exponential:krylov_tol=1e-10", 2, Any),
    // It refuses projected damping.
    ("energy-momentum:residual=1e-13", 2, Any),
];

/// A sheet out of the plane in which springs across have no force.
fn sheet(law: DampingLaw) -> Sheet {
    Sheet { side: 6, tension: 400.0, shear: 100.0, damping: 2.0, law, ..Sheet::default() }
}

const LAWS: [DampingLaw; 2] = [DampingLaw::Full, DampingLaw::Projected];

#[test]
fn every_method_has_an_order() {
    let small = "of order 4: round-off at these steps; see the tests of its crate";
    assert_covers("order", METHODS.map(|(id, _, _)| id), &[("srkn4", small)]);
}

#[test]
fn every_method_has_its_order_on_a_smooth_scene() {
    for law in LAWS {
        let (system, start) = stir(sheet(law).build(), 0.02, 0.0);
        check(&system, &start, &format!("pinned, {law:?}"));
    }
}

/// Without pins a method could win or lose spin as a whole. There is no gravity, whose parabola
/// would outweigh the error of the springs, and the damping slows the rotation.
#[test]
fn every_method_has_its_order_on_a_free_sheet_that_spins() {
    for law in LAWS {
        let free = Sheet { pinned: false, gravity: Vec3::zeros(), ..sheet(law) };
        let (system, mut start) = stir(free.build(), 0.02, 0.0);
        let axis = Vec3::new(1.0, -0.5, 3.0);
        for i in 0..start.len() {
            start.v[i] = axis.cross(&start.x[i]);
        }
        check(&system, &start, &format!("free, {law:?}"));
    }
}

fn exact(system: &System, start: &State) -> Reference {
    let exact = reference(system, start, &[SPAN], AdaptiveSettings::default())
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(exact.position_error < 1e-9, "{:e}", exact.position_error);
    exact
}

fn check(system: &System, start: &State, scene: &str) {
    let steps = [40, 80, 160, 320];
    assert!(SPAN / f64::from(steps[0]) * OMEGA_MAX < 0.5);
    let exact = exact(system, start);
    let mut wrong = Vec::new();
    for (id, order, _) in METHODS.into_iter().filter(|(id, ..)| takes(id, system)) {
        let found = of_method(|| method(id), system, start, &exact, &steps)
            .unwrap_or_else(|error| panic!("{id}: {error}"));
        let constant = found.error_constant(order);
        let summary =
            format!("{id}, {scene}: order {:.3}, e = {constant:.3} h^{order}", found.order);
        let expected = (found.order - f64::from(order)).abs() < 0.15;
        if !expected || !(0.01..1e6).contains(&constant) {
            wrong.push(format!("{summary}: {:.3?}", found.pairwise));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// With the coefficients of a constant step, methods of several steps would have the order 1.
#[test]
fn the_order_survives_changes_of_the_step_size() {
    let gentle: &[f64] = &[1.0, 1.17, 1.34];
    let patterns = [gentle, &[1.0, 2.0], &[1.0, 1.5, 0.75, 1.25]];
    let mut wrong = Vec::new();
    for law in LAWS {
        let sheet = Sheet { side: 3, tension: 100.0, shear: 25.0, ..sheet(law) };
        let (system, start) = stir(sheet.build(), 0.02, 1.0);
        let exact = exact(&system, &start);
        let taken = METHODS.into_iter().filter(|(id, ..)| takes(id, &system));
        for (id, order, steps) in taken.filter(|(_, _, steps)| *steps != Constant) {
            let count = if steps == Gentle { 1 } else { patterns.len() };
            for pattern in &patterns[..count] {
                let error = |count: u32| {
                    let unit = SPAN / (f64::from(count) * pattern.iter().sum::<f64>());
                    let mut run = prepared(id, (system.clone(), start.clone()), unit);
                    for share in (0..count).flat_map(|_| *pattern) {
                        run.step_by(unit * share);
                    }
                    position_error(&system, &start.x, &exact.states[0].x, &run.state.x)
                };
                let found = order_of(SPAN, &[20, 40, 80, 160], error);
                let found = found.unwrap_or_else(|error| panic!("{id}: {error}"));
                if (found.order - f64::from(order)).abs() >= 0.15 {
                    wrong.push(format!("{id}, {law:?}, {pattern:?}: {found:?}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
