//! Laws that hold at any amplitude: free fall, momentum, spin, order, descent.

use super::{ALL, run};
use crate::Projective;
use drape_integrator::SolveStatus;
use drape_model::{DampingLaw, SpringEffect, State, System, Vec3};
use drape_oracle::adaptive::AdaptiveSettings;
use drape_oracle::laws::{Drift, free_fall, spin};
use drape_oracle::order::of_method;
use drape_oracle::reference::reference;
use drape_oracle::scenes::{
    GRAVITY, Sheet, build, particles, spring, stiffening, stir, tension, uneven,
};
use drape_oracle::{Random, apart, bits};

/// The iterations start at the inertial velocities, which are the solution here.
#[test]
fn a_free_sheet_falls_on_the_parabola_of_backward_euler() {
    let velocity = Vec3::new(1.0, -2.0, 3.0);
    for acceleration in ALL {
        let sheet = Sheet { side: 9, tension: 1e6, shear: 1e5, pinned: false, ..Sheet::default() };
        let (system, mut state) = sheet.build();
        state.v.fill(velocity);
        let start = state.x.clone();
        let mut run = run(&format!("acceleration={acceleration}"), (system, state), 0.01);
        for n in 1..=50 {
            let report = run.step();
            for (x, v) in start.iter().zip(run.state.x.iter().zip(&run.state.v)) {
                let (fall, speed) = free_fall(Drift::NewVelocity, *x, velocity, GRAVITY, 0.01, n);
                let off = (v.0 - fall).norm().max((v.1 - speed).norm());
                assert!(off < 1e-10, "{acceleration}, step {n}: {off:e}");
            }
            assert!(report.outer_passes <= 1, "round-off: {report:?}");
        }
    }
}

/// Free particles of different masses on a random net of springs.
fn net(stiffness: f64, damping: f64, law: DampingLaw) -> (System, State) {
    let mut random = Random::new(21);
    let n = 12;
    let masses: Vec<f64> = (0..n).map(|_| random.between(0.5, 2.0)).collect();
    let x: Vec<Vec3> = (0..n).map(|_| random.vector()).collect();
    let v: Vec<Vec3> = (0..n).map(|_| random.vector()).collect();
    let mut spec = particles(&masses, &x, &v);
    for (i, j) in (1..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
        if j + 1 == i || random.chance(0.3) {
            let rest = (x[i] - x[j]).norm() * random.between(0.7, 1.3);
            let k = stiffness * random.between(0.4, 1.6);
            spec.springs.push(spring(SpringEffect::Tension, (i, j), rest, k, damping));
        }
    }
    spec.damping = law;
    build(&spec)
}

/// The tolerance of the global step is relative: masses and stiffnesses in another unit, which is a
/// power of two here, change no bit of the motion.
#[test]
fn the_unit_of_mass_does_not_matter() {
    for acceleration in ALL {
        let end = |unit: f64| {
            let mut spec = Sheet::default().spec();
            spec.particles.mass_kg.iter_mut().for_each(|m| *m *= unit);
            for spring in &mut spec.springs {
                spring.stiffness_n_per_m *= unit;
                spring.damping_n_s_per_m *= unit;
            }
            let start = stir(build(&spec), 0.02, 0.5);
            let text = format!("acceleration={acceleration},solver=cg,forcing_term=1e-3");
            let mut run = run(&text, start, 0.01);
            run.steps(3);
            bits(&run.state)
        };
        assert_eq!(end(1.0), end(2.0_f64.powi(20)), "{acceleration}");
    }
}

/// All iterates have the momentum of the start: forces act in pairs, and the columns of the matrix
/// add up to the masses.
#[test]
fn momentum_is_exact_after_any_number_of_iterations() {
    for acceleration in ALL {
        for iterations in [1, 3, 15] {
            for (stiffness, tolerance) in [(125.0, 1e-13), (1e8, 1e-11)] {
                for (damping, law) in
                    [(0.0, DampingLaw::Full), (2.0, DampingLaw::Full), (2.0, DampingLaw::Projected)]
                {
                    let text = format!("acceleration={acceleration},iterations={iterations}");
                    let mut run = run(&text, net(stiffness, damping, law), 0.01);
                    let start = run.system.momentum(&run.state);
                    run.steps(50);
                    let sizes = run.state.x.iter().zip(&run.state.v).zip(run.system.mass());
                    let size: f64 = sizes.map(|((x, v), m)| m * (v.norm() + x.norm() / 0.01)).sum();
                    let drift = (run.system.momentum(&run.state) - start).norm() / size;
                    assert!(drift < tolerance, "{text}, k={stiffness:e}, {law:?}: {drift:e}");
                }
            }
        }
    }
}

/// Converged iterations are backward Euler, whose factor of the spin is known: in tension, in
/// compression and fast. The multipliers of ADMM do not settle on a spring that turns round, so it
/// stays in tension.
#[test]
fn two_particles_spin_as_with_backward_euler_once_the_iterations_converge() {
    const H: f64 = 1.0 / 64.0;
    let (mass, rest) = (0.25, 0.5);
    for (acceleration, thetas, least, speed) in [
        ("none", &[0.01, 1.0][..], 0.1, 8.0),
        ("anderson", &[0.01, 1.0, 50.0], 0.1, 8.0),
        ("lbfgs", &[0.01, 1.0, 50.0], 0.1, 8.0),
        ("admm", &[0.01, 1.0], 1.0, 4.0),
    ] {
        let mut random = Random::new(3);
        let cases = thetas.iter().flat_map(|t| [(*t, 0.0), (*t, 0.125)]);
        for ((theta, eta), law) in
            cases.flat_map(|c| [DampingLaw::Full, DampingLaw::Projected].map(|law| (c, law)))
        {
            let d = random.vector().normalize() * (rest * random.between(least, 3.0));
            let velocities = [random.vector() * speed, random.vector() * speed];
            let mut spec = particles(&[mass; 2], &[Vec3::zeros(), d], &velocities);
            spec.damping = law;
            let (k, c) = (0.5 * theta * mass / (H * H), 0.5 * eta * mass / H);
            spec.springs = vec![tension((0, 1), rest, k, c)];
            let text = format!("acceleration={acceleration},iterations=1000,residual=1e-16");
            let mut run = run(&text, build(&spec), H);
            for step in 0..100 {
                let relative = |state: &State| (state.x[1] - state.x[0], state.v[1] - state.v[0]);
                let (d, v) = relative(&run.state);
                let report = run.step();
                let case = format!("{text}, {law:?}, θ={theta} η={eta}, step {step}");
                assert_eq!(report.solve, SolveStatus::Converged, "{case}: {report:?}");
                let (d_after, v_after) = relative(&run.state);
                let loss = if law == DampingLaw::Full { eta } else { 0.0 };
                let factor = spin::backward_euler(theta, loss, rest / d_after.norm());
                let (before, after) = (d.cross(&v), d_after.cross(&v_after));
                let off = (after - before * factor).norm();
                let force = (1.0 + theta) * (d.norm() + rest) / H + v.norm() + v_after.norm();
                let round_off = 128.0 * f64::EPSILON * d.norm().max(d_after.norm()) * force;
                let allowed = 1e-9 * before.norm().max(after.norm()) + round_off;
                assert!(off < allowed, "{case}: {off:e}, allowed {allowed:e}");
            }
        }
    }
}

/// Rigid rotation at the equilibrium length, one second: numbers of backward Euler.
#[test]
fn two_particles_rotate_for_a_second_like_backward_euler() {
    for (theta, spin, angle, energy) in [
        (1.0, 0.962_422_682_8, 1.961_709_49, None),
        (100.0, 0.962_425_268_4, 1.961_647_10, Some(0.926_348_48)),
    ] {
        let (h, omega): (f64, f64) = (0.01, 2.0);
        let kappa = theta / (h * h);
        let length = kappa / (kappa - omega * omega);
        let half = Vec3::x() * (0.5 * length);
        let velocity = Vec3::y() * (0.5 * length * omega);
        let mut spec = particles(&[1.0; 2], &[-half, half], &[-velocity, velocity]);
        spec.springs = vec![tension((0, 1), 1.0, 0.5 * kappa, 0.0)];
        let mut run = run("acceleration=anderson,iterations=1000,residual=1e-16", build(&spec), h);
        let momentum =
            |state: &State| (state.x[1] - state.x[0]).cross(&(state.v[1] - state.v[0])).z;
        let (start, start_energy) = (momentum(&run.state), run.energy());
        let (mut turned, mut last) = (0.0, 0.0_f64);
        for _ in 0..100 {
            run.step();
            let d = run.state.x[1] - run.state.x[0];
            let now = d.y.atan2(d.x);
            turned += now - last;
            last = now;
        }
        let ratio = momentum(&run.state) / start;
        assert!((ratio - spin).abs() < 1e-9, "θ={theta}: {ratio}");
        assert!((turned - angle).abs() < 1e-8, "θ={theta}: {turned}");
        if let Some(energy) = energy {
            let ratio = run.energy() / start_energy;
            assert!((ratio - energy).abs() < 1e-7, "θ={theta}: {ratio}");
        }
    }
}

#[test]
fn converged_iterations_have_order_one() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let sheet =
            Sheet { side: 6, tension: 400.0, shear: 100.0, damping: 2.0, law, ..Sheet::default() };
        let (system, start) = stir(sheet.build(), 0.02, 0.0);
        let exact = reference(&system, &start, &[0.25], AdaptiveSettings::default())
            .unwrap_or_else(|error| panic!("{error}"));
        for acceleration in ALL {
            let text = format!("acceleration={acceleration},iterations=200,residual=1e-9");
            let method = || Box::new(Projective::new(super::settings(&text))) as Box<_>;
            let found = of_method(method, &system, &start, &exact, &[40, 80, 160])
                .unwrap_or_else(|error| panic!("{error}"));
            assert!((found.order - 1.0).abs() < 0.15, "{text}, {law:?}: {found:?}");
        }
    }
}

/// A wavy, stretched sheet on two pins: the errors are those of an independent program's backward
/// Euler.
#[test]
fn the_errors_on_a_smooth_scene_are_those_of_an_independent_program() {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 100.0, damping: 5.0, ..Sheet::default() };
    let (system, mut state) = sheet.build();
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        let (x, y) = (state.x[i].x + 0.5, state.x[i].y + 0.5);
        let moved = Vec3::new(1.03 * x, 0.98 * y, 0.02 * (3.0 * y + 1.0).sin());
        state.x[i] = moved - Vec3::new(0.5, 0.5, 0.0);
        state.v[i] = Vec3::new((2.0 * y).sin(), x, (3.0 * x).cos()) * 0.3;
    }
    let exact = reference(&system, &state, &[0.2], AdaptiveSettings::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let text = "acceleration=anderson,iterations=200,residual=1e-10";
    for (steps, expected) in [(20, 4.4903e-2), (160, 5.7195e-3)] {
        let mut run = run(text, (system.clone(), state.clone()), 0.2 / f64::from(steps));
        run.steps(steps as usize);
        let distance = |a: &[Vec3], b: &[Vec3]| -> f64 {
            a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>().sqrt()
        };
        let end = &exact.states[0].x;
        let error = distance(&run.state.x, end) / distance(end, &state.x);
        assert!((error / expected - 1.0).abs() < 1e-3, "{steps} steps: {error:e}");
    }
}

/// Every plain iteration and every guarded one lowers the potential; a step therefore ends lower,
/// the more iterations it takes. The number of iterations of a deterministic method is its clock.
#[test]
fn the_incremental_potential_falls_at_every_iteration() {
    use drape_integrator::{Implicit, IncrementalPotential};
    let h = 0.01;
    for acceleration in ["none", "anderson", "lbfgs"] {
        for theta in [0.1, 10.0, 1e4] {
            for (law, steep) in [
                (DampingLaw::Full, None),
                (DampingLaw::Projected, None),
                (DampingLaw::Full, Some(0.1)),
            ] {
                let k = theta / (h * h);
                let sheet = Sheet { side: 5, tension: k, shear: 0.3 * k, law, ..Sheet::default() };
                let spec = steep.map_or(sheet.spec(), |ratio| stiffening(sheet.spec(), ratio));
                let (system, state) = stir(uneven(build(&spec)), 0.1, 3.0);
                let mut frozen = vec![Vec3::zeros(); state.len()];
                Implicit::Springs.add_explicit_forces(&system, state.level(), &mut frozen);
                let mut potential = IncrementalPotential::new(&system, Implicit::Springs);
                let from = (&state.x[..], &state.v[..]);
                potential.begin(&system, h, from, state.level(), &frozen);
                let mut last = f64::INFINITY;
                for iterations in 1..=25 {
                    let text = format!("acceleration={acceleration},iterations={iterations}");
                    let mut run = run(&text, (system.clone(), state.clone()), h);
                    run.step();
                    let value = potential.value(&system, &run.state.v);
                    let case = format!("{text}, θ={theta}, {law:?}, {steep:?}");
                    assert!(value <= last * (1.0 + 1e-12), "{case}: {last} → {value} J");
                    last = value;
                }
            }
        }
    }
}

/// The multipliers of springs with two slopes converge to the same minimum.
#[test]
fn multipliers_find_the_minimum_of_springs_with_two_slopes_too() {
    for ratio in [0.1, 5.0] {
        let spec = Sheet { tension: 1e4, shear: 1e3, ..Sheet::default() }.spec();
        let start = || stir(build(&stiffening(spec.clone(), ratio)), 0.02, 0.5);
        let end = |acceleration: &str| {
            let text = format!("acceleration={acceleration},iterations=1000,residual=1e-10");
            let mut run = run(&text, start(), 0.01);
            let reports = run.steps(3);
            for report in reports {
                assert_eq!(report.solve, SolveStatus::Converged, "{report:?}");
            }
            run.state.x
        };
        let off = apart(&end("admm"), &end("lbfgs"));
        assert!(off < 1e-8, "{ratio}: {off:e}");
    }
}
