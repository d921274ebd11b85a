//! Every effect: energy → force → Jacobian, its linear split, its symmetries.

use drape_model::{DampingLaw, Effect, Level, SpringEffect, State, System, Tangent, Vec3};
use drape_oracle::finite_difference;
use drape_tests::{Random, build, gravity, particles, spring};
use nalgebra::{DMatrix, Rotation3, SymmetricEigen};

const PARTICLES: usize = 6;

/// A random cloud with all kinds of springs, stretched and compressed, and gravity.
fn cloud(random: &mut Random, law: DampingLaw) -> (System, State) {
    let vectors =
        |random: &mut Random| -> Vec<Vec3> { (0..PARTICLES).map(|_| random.vector()).collect() };
    let masses: Vec<f64> = (0..PARTICLES).map(|_| random.between(0.5, 2.0)).collect();
    let (x, v) = (vectors(random), vectors(random));
    let mut spec = particles(&masses, &x, &v);
    spec.damping = law;
    spec.effects.gravity = gravity();
    for i in 0..PARTICLES {
        for j in 0..i {
            let effect = SpringEffect::ALL[random.below(3)];
            let rest = (x[i] - x[j]).norm() * random.between(0.3, 2.0);
            let (k, c) = (random.between(1.0, 100.0), random.between(0.1, 3.0));
            spec.springs.push(spring(effect, (i, j), rest, k, c));
        }
    }
    build(&spec)
}

fn for_each_effect(mut check: impl FnMut(&dyn Effect, DampingLaw, &System, &State)) {
    let mut random = Random::new(5);
    let mut seen = Vec::new();
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for _ in 0..10 {
            let (system, state) = cloud(&mut random, law);
            for effect in system.effects() {
                check(effect, law, &system, &state);
                seen.push(effect.name());
            }
        }
    }
    for name in ["tension", "shear", "bending", "gravity"] {
        assert!(seen.iter().filter(|seen| **seen == name).count() >= 10, "{name} was not met");
    }
}

fn force(effect: &dyn Effect, system: &System, x: &[Vec3]) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); x.len()];
    effect.add_force(system.mass(), x, &mut out);
    out
}

fn damping_force(effect: &dyn Effect, x: &[Vec3], v: &[Vec3]) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); x.len()];
    effect.add_damping_force(Level { t: 0.0, x, v }, &mut out);
    out
}

fn size(vectors: &[Vec3]) -> f64 {
    vectors.iter().map(Vec3::norm).sum()
}

fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).sum()
}

#[test]
fn forces_and_jacobians_are_the_derivatives_of_energies_and_forces() {
    for_each_effect(|effect, law, system, state| {
        let found = finite_difference::check(effect, system.mass(), &state.x, &state.v);
        assert!(found.worst() < 1e-7, "{}, {law:?}: {found:?}", effect.name());
    });
}

/// The projected tangent has no negative eigenvalue, and is the exact one where springs are
/// stretched.
#[test]
fn the_projected_stiffness_is_positive_semi_definite() {
    let tangents = |effect: &dyn Effect, x: &[Vec3]| {
        [Tangent::Exact, Tangent::Projected].map(|tangent| {
            let mut matrix = finite_difference::Dense::zeros(x.len());
            effect.add_stiffness(x, 1.0, tangent, &mut matrix);
            matrix.0
        })
    };
    let lowest = |matrix: DMatrix<f64>| SymmetricEigen::new(matrix).eigenvalues.min();
    let mut indefinite = 0;
    for_each_effect(|effect, _, _, state| {
        let [exact, projected] = tangents(effect, &state.x);
        let norm = exact.norm();
        indefinite += usize::from(lowest(exact) < -1e-3 * norm);
        assert!(lowest(projected) >= -1e-12 * norm, "{}", effect.name());
        let far: Vec<Vec3> = state.x.iter().map(|x| x * 1e3).collect();
        let [exact, projected] = tangents(effect, &far);
        assert_eq!(exact, projected, "{}", effect.name());
    });
    assert!(indefinite > 10, "compressed springs make the exact tangent indefinite");
}

/// `F1 + F2 = F`, and the damping is `−L_c v` plus its remainder.
#[test]
fn the_linear_split_adds_up_to_the_force() {
    for_each_effect(|effect, law, system, state| {
        let (x, v) = (&state.x, &state.v);
        let Some(split) = effect.split() else {
            assert_eq!(effect.name(), "gravity");
            return;
        };
        let zeros = || vec![Vec3::zeros(); x.len()];
        let (mut sum, mut damping, mut remainder) = (zeros(), zeros(), zeros());
        split.visit_weights(&mut |i, j, k, c| {
            sum[i] -= (x[i] - x[j]) * k;
            sum[j] += (x[i] - x[j]) * k;
            damping[i] -= (v[i] - v[j]) * c;
            damping[j] += (v[i] - v[j]) * c;
        });
        let linear = size(&sum);
        split.add_nonlinear_force(x, &mut sum);
        let whole = force(effect, system, x);
        assert!(distance(&sum, &whole) < 1e-13 * linear, "{}", effect.name());
        split.add_damping_remainder(x, v, &mut remainder);
        let linear = size(&damping);
        assert_eq!(size(&remainder) > 0.0, law == DampingLaw::Projected);
        damping.iter_mut().zip(&remainder).for_each(|(a, b)| *a += b);
        let whole = damping_force(effect, x, v);
        assert!(distance(&damping, &whole) < 1e-13 * linear, "{}", effect.name());
    });
}

/// Springs know neither place nor direction, pull in pairs and along the line between their ends.
#[test]
fn springs_are_invariant_and_conserve_momenta() {
    let rotation = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let shift = Vec3::new(3.0, -2.0, 1.0);
    let torque =
        |x: &[Vec3], f: &[Vec3]| -> Vec3 { x.iter().zip(f).map(|(x, f)| x.cross(f)).sum() };
    for_each_effect(|effect, law, system, state| {
        if effect.name() == "gravity" {
            return;
        }
        let (x, v) = (&state.x, &state.v);
        let moved: Vec<Vec3> = x.iter().map(|x| rotation * x + shift).collect();
        let turned =
            |vectors: &[Vec3]| -> Vec<Vec3> { vectors.iter().map(|a| rotation * a).collect() };
        let energy = effect.energy(system.mass(), x);
        assert!((effect.energy(system.mass(), &moved) - energy).abs() < 1e-12 * energy);
        let f = force(effect, system, x);
        let tolerance = 1e-11 * size(&f);
        assert!(distance(&force(effect, system, &moved), &turned(&f)) < tolerance);
        assert!(f.iter().sum::<Vec3>().norm() < tolerance && torque(x, &f).norm() < tolerance);
        let f = damping_force(effect, x, v);
        let tolerance = 1e-11 * size(&f);
        assert!(distance(&damping_force(effect, &moved, &turned(v)), &turned(&f)) < tolerance);
        assert!(f.iter().sum::<Vec3>().norm() < tolerance);
        let power: f64 = v.iter().zip(&f).map(|(v, f)| v.dot(f)).sum();
        assert!(power < 0.0, "damping dissipates");
        // Full damping brakes a rigid rotation too, projected damping does not feel it.
        let spun: Vec<Vec3> = x.iter().map(|x| shift.cross(x)).collect();
        let braked = size(&damping_force(effect, x, &spun)) > 1e-6;
        assert_eq!(braked, law == DampingLaw::Full, "{}", effect.name());
        if law == DampingLaw::Projected {
            assert!(torque(x, &f).norm() < tolerance);
        }
    });
}
