//! What theory promises about the energy of the implicit-explicit methods.

use drape_model::{DampingLaw, SpringEffect, State, System, Vec3};
use drape_tests::{
    Random, Run, Sheet, apart, build, gravity, largest, particles, pin, prepared, spring,
};

/// A random system of 2 to 10 particles: springs stretched, compressed, collapsed, of rest length
/// 0; masses over six decades; pins; `h` and `θ` over many.
fn random_system(random: &mut Random) -> (System, State, f64) {
    let n = 2 + random.below(9);
    let h = random.power_of_ten(-4.0, 0.0);
    let theta = random.power_of_ten(-9.0, 10.0);
    let spread = if random.chance(0.5) { 3.0 } else { 0.0 };
    let masses: Vec<f64> = (0..n).map(|_| random.power_of_ten(-spread, spread + 1e-9)).collect();
    let mut x: Vec<Vec3> = (0..n).map(|_| random.vector()).collect();
    let speed = random.power_of_ten(-2.0, 2.0);
    let v: Vec<Vec3> = (0..n).map(|_| random.vector() * speed).collect();
    if random.chance(0.3) {
        x[1] = x[0];
    }
    let lightest = masses.iter().fold(f64::INFINITY, |a, &m| a.min(m));
    let mut spec = particles(&masses, &x, &v);
    for i in 1..n {
        for j in 0..i {
            if j + 1 == i || random.chance(0.2) {
                let rest = match random.below(4) {
                    0 => 0.0,
                    1 => (x[i] - x[j]).norm(),
                    _ => random.between(0.0, 3.0),
                };
                let k = theta * lightest / (h * h) * random.unit();
                let c = if random.chance(0.5) { lightest / h * random.unit() } else { 0.0 };
                let effect = SpringEffect::ALL[random.below(3)];
                spec.springs.push(spring(effect, (i, j), rest, k, c));
            }
        }
    }
    spec.pins = (0..n).filter(|_| random.chance(0.15)).map(pin).collect();
    spec.effects.gravity = if random.chance(0.5) { gravity() } else { None };
    let (system, mut state) = build(&spec);
    for pin in &spec.pins {
        state.v[pin.particle as usize] = Vec3::zeros();
    }
    (system, state, h)
}

/// `θ_max = h² max k/m`, with the lighter end of each spring, and `½ Σ k L²`.
fn scales(system: &System, x: &[Vec3], h: f64) -> (f64, f64) {
    let (mut theta, mut energy): (f64, f64) = (0.0, 0.0);
    for split in system.effects().filter_map(|effect| effect.split()) {
        split.visit_weights(&mut |i, j, k, _| {
            theta = theta.max(h * h * k / system.mass()[i].min(system.mass()[j]));
            energy += 0.5 * k * (x[i] - x[j]).norm_squared();
        });
    }
    (theta, energy)
}

/// Round-off of a step over `(1 + θ_max)` times the energies. The worst of 10⁵ steps was 7.4e-16,
/// at small `θ` from the sum of the energy itself, at large `θ` from the solve.
const ROUND_OFF: f64 = 2e-15;

/// By how much a step breaks `H_+ ≤ H − ½‖v_+ − v‖²_M − h v_+ᵀ L_c v_+`, over round-off.
fn violation(run: &mut Run) -> f64 {
    let before = run.state.clone();
    let energy = run.energy();
    run.step();
    let (system, h) = (&run.system, run.h);
    let change: Vec<Vec3> = run.state.v.iter().zip(&before.v).map(|(a, b)| a - b).collect();
    let mut damping = vec![Vec3::zeros(); run.state.len()];
    for effect in system.effects() {
        effect.add_damping_force(run.state.level(), &mut damping);
    }
    let power: f64 = run.state.v.iter().zip(&damping).map(|(v, f)| v.dot(f)).sum();
    let bound = energy - system.kinetic_energy(&change) + h * power;
    let (theta, springs) = scales(system, &before.x, h);
    let kinetic = system.kinetic_energy(&before.v);
    let potential: f64 = system.energies(&before.x).map(|(_, energy)| energy.abs()).sum();
    let round_off = ROUND_OFF * (1.0 + theta) * (springs + potential + kinetic);
    (run.energy() - bound) / round_off.max(f64::MIN_POSITIVE)
}

/// Theorem: solved exactly, with all springs implicit, IMEX Euler never gains energy, whatever the
/// step size, the stiffness and the state.
#[test]
fn imex_euler_never_gains_energy() {
    const SYSTEMS: usize = 2000;
    const STEPS: usize = 50;
    let mut random = Random::new(2000);
    for number in 0..SYSTEMS {
        let (system, state, h) = random_system(&mut random);
        let mut run = prepared("imex-euler:solver=cholesky,implicit=springs", (system, state), h);
        for step in 0..STEPS {
            let found = violation(&mut run);
            assert!(found <= 1.0, "system {number}, step {step}: {found:e} times round-off");
        }
    }
}

/// The same check finds the methods that gain energy.
#[test]
fn the_energy_check_fails_for_methods_without_the_theorem() {
    for id in ["explicit-euler", "symplectic-euler", "imex-euler:solver=cholesky,implicit=tension"]
    {
        let mut random = Random::new(2000);
        let gains = (0..200).any(|_| {
            let (system, state, h) = random_system(&mut random);
            let mut run = prepared(id, (system, state), h);
            (0..5).any(|_| violation(&mut run) > 1e3)
        });
        assert!(gains, "{id}");
    }
}

/// A moving, crumpled sheet whose stiffest springs have the given `θ`.
fn crumpled(random: &mut Random, theta: f64, law: DampingLaw, h: f64) -> (System, State) {
    let tension = theta / (h * h);
    let shear = 0.3 * tension;
    let sheet = Sheet { tension, shear, damping: 5.0, law, ..Sheet::default() };
    let (system, mut state) = sheet.build();
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        state.x[i] += random.vector() * 0.05;
        state.v[i] = random.vector();
    }
    (system, state)
}

/// The fixed point of Algorithm 1 is backward Euler of the whole system.
#[test]
fn updated_cg_converges_to_backward_euler() {
    const H: f64 = 0.01;
    // Updates alone, without Newton's method.
    let variants = [
        "forcing_term=1e-16,max_outer=1000000,newton_above=1e300",
        "forcing_term=1e-16,max_outer=1000000,newton_above=1e300,solver=cholesky",
        "forcing_term=1e-16,max_outer=1000000,newton_above=1e300,start=last",
        "forcing_term=1e-13,max_outer=1000000,safeguard=paper",
    ];
    let mut random = Random::new(77);
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for theta in [0.1, 1.0, 10.0, 100.0] {
            let start = crumpled(&mut random, theta, law, H);
            let mut implicit = prepared("backward-euler:residual=1e-16", start.clone(), H);
            implicit.step();
            let scale = largest(&implicit.state.v);
            for variant in variants {
                let mut run = prepared(&format!("imex-updated:{variant}"), start.clone(), H);
                let report = run.step();
                assert_eq!(report.newton_iterations, 0, "{variant}");
                let error = apart(&run.state.v, &implicit.state.v) / scale;
                let case = format!("{variant}, {law:?}, θ={theta}, {} passes", report.outer_passes);
                assert!(error < 1e-8, "{case}: {error:e}");
            }
        }
    }
}
