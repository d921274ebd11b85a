//! A particle in a corner of three planes is held as by a pin, whichever solver is used: contacts
//! on three sides leave it nothing to move in, and a factor that knows of pins alone must not move
//! it.

use drape_model::{ObstacleSpec, State, System, Vec3};
use drape_tests::{Run, build, particles, pin, prepared, tension};

/// N/m; the particle in the corner has 1 kg, so that its `θ` is 1.
const STIFFNESS: f64 = 1e4;
const H: f64 = 0.01;
const STEPS: usize = 5;

/// The direct solvers, each with the iterative one where there is one.
const PAIRS: [(&str, Option<&str>); 10] = [
    ("imex-euler:solver=cholesky", Some("imex-euler:forcing_term=1e-14")),
    (
        "imex-euler:solver=cholesky,implicit=springs",
        Some("imex-euler:forcing_term=1e-14,implicit=springs"),
    ),
    ("symplectic-euler:damping=implicit", None),
    (
        "imex-updated:solver=cholesky,forcing_term=1e-14",
        Some("imex-updated:solver=cg,forcing_term=1e-14"),
    ),
    (
        "imex-updated:solver=cholesky,safeguard=paper,forcing_term=1e-14",
        Some("imex-updated:solver=cg,safeguard=paper,forcing_term=1e-14"),
    ),
    ("imex-sbdf2:solver=cholesky", Some("imex-sbdf2:forcing_term=1e-14")),
    ("imex-cnab2:solver=cholesky", Some("imex-cnab2:forcing_term=1e-14")),
    ("baraff-witkin:solver=cholesky", Some("baraff-witkin:forcing_term=1e-14")),
    ("leapfrog:solver=cholesky", Some("leapfrog:solver=cg")),
    ("projective", Some("projective:solver=cg,forcing_term=1e-14")),
];

/// Particle 0 in the corner `x, y, z ≥ 0`, and one that is free and flies towards it, so that the
/// spring between them presses particle 0 into the corner. `pinned` puts a pin in place of the
/// planes.
fn corner(damping: f64, pinned: bool) -> (System, State) {
    let (x, v) = (Vec3::new(0.5, 0.4, 0.3), Vec3::new(-3.0, -2.0, -2.5));
    let mut spec = particles(&[1.0, 8.0], &[Vec3::zeros(), x], &[Vec3::zeros(), v]);
    let rest = 1.1 * x.norm();
    spec.springs = vec![tension((0, 1), rest, STIFFNESS, damping)];
    if pinned {
        spec.pins = vec![pin(0)];
    } else {
        let plane = |normal: Vec3| ObstacleSpec::plane([0.0; 3], normal.into(), 0.0);
        spec.obstacles = [Vec3::x(), Vec3::y(), Vec3::z()].map(plane).to_vec();
    }
    build(&spec)
}

/// Velocities of both particles after each step.
fn velocities(id: &str, damping: f64, pinned: bool) -> Vec<[Vec3; 2]> {
    let mut run = prepared(id, corner(damping, pinned), H);
    let velocity = |run: &mut Run| {
        run.step();
        [run.state.v[0], run.state.v[1]]
    };
    let found = (0..STEPS).map(|_| velocity(&mut run)).collect();
    assert!(run.state.x[0].norm() < 1e-9, "{id}: the corner holds: {:?}", run.state.x[0]);
    found
}

fn largest_difference(a: &[[Vec3; 2]], b: &[[Vec3; 2]]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn direct_and_iterative_solvers_agree_on_a_particle_in_a_corner() {
    for (direct, iterative) in PAIRS {
        for damping in [0.0, 300.0] {
            let held = velocities(direct, damping, false);
            assert!(held[0][1].norm() > 1.0, "{direct}: the free particle moves: {:?}", held[0]);
            if let Some(iterative) = iterative {
                let apart = largest_difference(&held, &velocities(iterative, damping, false));
                assert!(apart < 1e-9, "{direct}, c = {damping}: {apart:e} m/s from {iterative}");
            }
            // Leapfrog's second half kick knows of pins alone: its damping sees what contacts stop
            // only after it.
            if damping == 0.0 || !direct.starts_with("leapfrog") {
                let apart = largest_difference(&held, &velocities(direct, damping, true));
                assert!(apart < 1e-9, "{direct}, c = {damping}: {apart:e} m/s from a pin");
            }
        }
    }
}
