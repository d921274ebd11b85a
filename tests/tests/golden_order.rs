//! The error of every method falls with the order that theory gives.

use drape_model::{DampingLaw, State, System, Vec3};
use drape_oracle::order::of_method;
use drape_oracle::reference::{ReferenceSettings, reference};
use drape_tests::{Sheet, build, method};

/// `8 (k + k_s)/m ≥ ω_max²`.
const OMEGA_MAX: f64 = 63.3;
const SPAN: f64 = 0.25;

/// With what order each method is expected; solves are tight enough not to be seen.
const METHODS: [(&str, i32); 31] = [
    ("explicit-euler", 1),
    ("symplectic-euler", 1),
    ("symplectic-euler:damping=implicit", 1),
    ("leapfrog", 2),
    ("leapfrog:solver=cholesky", 2),
    // With its limit out of reach: the correction has no order.
    ("provot:limit=10", 1),
    ("adams-bashforth2:steps=1", 1),
    ("adams-bashforth2", 2),
    ("adams-bashforth2:steps=3", 3),
    ("backward-euler:residual=1e-12", 1),
    ("bdf2:residual=1e-12,steps=1", 1),
    ("bdf2:residual=1e-13", 2),
    ("bdf2:residual=1e-15,steps=3", 3),
    ("terzopoulos-fleischer", 1),
    ("baraff-witkin:forcing_term=1e-10", 1),
    ("baraff-witkin:hessian=raw,forcing_term=1e-10", 1),
    ("baraff-witkin:implicit=tension,solver=cholesky", 1),
    ("desbrun", 1),
    ("desbrun:inverse=dense", 1),
    ("desbrun:torque=none,inverse=dense", 1),
    ("kang", 1),
    ("kang:sweeps=4", 1),
    ("imex-euler:forcing_term=1e-10", 1),
    ("imex-euler:forcing_term=1e-10,implicit=springs", 1),
    ("imex-updated:forcing_term=1e-9", 1),
    ("imex-updated:forcing_term=1e-9,safeguard=paper", 1),
    ("imex-sbdf2:forcing_term=1e-12", 2),
    ("imex-sbdf2:forcing_term=1e-12,implicit=tension", 2),
    ("imex-cnab2:forcing_term=1e-12", 2),
    ("imex-mcnab2:forcing_term=1e-12", 2),
    ("imex-cnlf:forcing_term=1e-12", 2),
];

const SHEET: Sheet = Sheet {
    side: 6,
    tension: 400.0,
    shear: 100.0,
    damping: 2.0,
    law: DampingLaw::Full,
    pinned: true,
};

#[test]
fn every_method_has_its_order_on_a_smooth_scene() {
    for method in drape_harness::methods::all() {
        let listed = METHODS.iter().any(|(id, _)| id.split(':').next() == Some(method.id));
        assert!(listed, "{} has no entry", method.id);
    }
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (system, mut start) = Sheet { law, ..SHEET }.build();
        // Out of the plane in which springs across are without force.
        for (i, x) in start.x.iter_mut().enumerate() {
            x.z += 0.02 * (i as f64).sin();
        }
        check(&system, &start, &format!("pinned, {law:?}"));
    }
}

/// Without pins a method could win or lose spin as a whole. There is no gravity, whose parabola would outweigh
/// the error of the springs, and the damping slows the rotation.
#[test]
fn every_method_has_its_order_on_a_free_sheet_that_spins() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let mut scene = Sheet { law, pinned: false, ..SHEET }.scene();
        scene.effects.gravity = None;
        let spec = scene.discretise().unwrap_or_else(|violation| panic!("{violation}"));
        let (system, mut start) = build(&spec);
        let axis = Vec3::new(1.0, -0.5, 3.0);
        for i in 0..start.len() {
            start.x[i].z += 0.02 * (i as f64).sin();
            start.v[i] = axis.cross(&start.x[i]);
        }
        check(&system, &start, &format!("free, {law:?}"));
    }
}

fn check(system: &System, start: &State, scene: &str) {
    let steps = [40, 80, 160, 320];
    assert!(SPAN / f64::from(steps[0]) * OMEGA_MAX < 0.5);
    let exact = reference(system, start, &[SPAN], ReferenceSettings::default())
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(exact.position_error < 1e-9, "{:e}", exact.position_error);
    let mut wrong = Vec::new();
    for (id, order) in METHODS {
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
