//! Angles and hinges: energy, force and stiffness agree, and nothing pushes itself.

use drape_model::effects::{Angles, Hinges};
use drape_model::{AngleEffect, AngleSpec, Effect, EffectKind, HingeSpec, Tangent, Vec3};
use drape_oracle::Random;
use drape_oracle::finite_difference::{Dense, check};
use std::f64::consts::{FRAC_PI_2, PI};

fn angle(rest_rad: f64) -> Box<dyn Effect> {
    let effect = AngleEffect::BendingAngle;
    let angle = AngleSpec { effect, i: 0, j: 1, k: 2, rest_rad, stiffness_n_m: 1.7 };
    Box::new(Angles::new(effect.into(), vec![angle]))
}

fn hinge(rest_rad: f64) -> Box<dyn Effect> {
    let hinge = HingeSpec { i: 0, j: 1, k: 2, l: 3, rest_rad, stiffness_n_m: 0.6 };
    Box::new(Hinges::new(EffectKind::BendingHinge, vec![hinge]))
}

/// Effects with the number of their particles.
fn effects() -> Vec<(Box<dyn Effect>, usize)> {
    let angles = [PI, FRAC_PI_2, 0.4, 2.9].map(|rest| (angle(rest), 3));
    let hinges = [0.0, 0.7, -2.0, 3.0].map(|rest| (hinge(rest), 4));
    angles.into_iter().chain(hinges).collect()
}

/// Three particles in a row or two triangles in a plane, moved by random vectors of about this
/// length.
fn nearly_flat(random: &mut Random, n: usize, size: f64) -> Vec<Vec3> {
    let flat = if n == 3 {
        vec![Vec3::new(-0.8, 0.1, 0.3), Vec3::zeros(), Vec3::new(0.8, -0.1, -0.3) * 1.3]
    } else {
        vec![Vec3::zeros(), Vec3::y(), Vec3::new(-0.9, 0.4, 0.0), Vec3::new(1.2, 0.7, 0.0)]
    };
    flat.into_iter().map(|x| x + random.vector() * size).collect()
}

fn force(effect: &dyn Effect, x: &[Vec3]) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); x.len()];
    effect.add_force(&vec![1.0; x.len()], x, &mut out);
    out
}

fn stiffness(effect: &dyn Effect, x: &[Vec3], tangent: Tangent) -> nalgebra::DMatrix<f64> {
    let mut dense = Dense::zeros(x.len());
    effect.add_stiffness(x, 1.0, tangent, &mut dense);
    dense.0
}

#[test]
fn force_and_stiffness_are_derivatives_of_the_energy_at_random_states() {
    let mut random = Random::new(3);
    for (effect, n) in effects() {
        for case in 0..60 {
            let x: Vec<_> = (0..n).map(|_| random.vector()).collect();
            let found = check(effect.as_ref(), &vec![1.0; n], &x, &x);
            assert!(found.worst() < 1e-5, "{effect:?}, case {case}: {found:?}");
        }
    }
}

#[test]
fn and_near_the_flat_state_and_in_it() {
    let mut random = Random::new(4);
    for (effect, n) in [(angle(PI), 3), (hinge(0.0), 4), (hinge(0.3), 4)] {
        for size in [0.1, 1e-2, 3e-3, 1e-3, 1e-4, 0.0] {
            let x = nearly_flat(&mut random, n, size);
            let found = check(effect.as_ref(), &vec![1.0; n], &x, &x);
            assert!(found.stiffness.best() < 1e-6, "{effect:?}, {size}: {found:?}");
            // Where the force is small its differences drown in the round-off of the energy.
            let bound = if size < 1e-2 && effect.name() != "bending_hinge" { 1e-3 } else { 1e-6 };
            assert!(size == 0.0 || found.force.best() < bound, "{effect:?}, {size}: {found:?}");
        }
    }
}

#[test]
fn forces_have_no_sum_and_no_moment_and_the_stiffness_meets_no_translation() {
    let mut random = Random::new(5);
    for (effect, n) in effects() {
        for _ in 0..40 {
            let x: Vec<_> = (0..n).map(|_| random.vector() * 3.0).collect();
            let f = force(effect.as_ref(), &x);
            let size: f64 = f.iter().map(Vec3::norm).sum::<f64>() + 1e-9;
            let sum: Vec3 = f.iter().sum();
            let moment: Vec3 = x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum();
            assert!(sum.norm() < 1e-13 * size && moment.norm() < 1e-11 * size, "{effect:?}");
            for tangent in [Tangent::Exact, Tangent::Projected] {
                let k = stiffness(effect.as_ref(), &x, tangent);
                let one = nalgebra::DVector::from_fn(3 * n, |row, _| f64::from(row % 3 == 1));
                assert!((&k * one).norm() < 1e-12 * (1e-9 + k.norm()), "{effect:?}");
                assert!((&k - k.transpose()).norm() < 1e-11 * (1e-9 + k.norm()), "{effect:?}");
            }
        }
    }
}

#[test]
fn a_rigid_motion_turns_the_force_and_keeps_the_energy() {
    let mut random = Random::new(6);
    for (effect, n) in effects() {
        for _ in 0..40 {
            let mass = vec![1.0; n];
            let x: Vec<_> = (0..n).map(|_| random.vector()).collect();
            let turn = nalgebra::Rotation3::new(random.vector() * 2.0);
            let shift = random.vector() * 5.0;
            let moved: Vec<_> = x.iter().map(|x| turn * x + shift).collect();
            let (before, after) = (effect.energy(&mass, &x), effect.energy(&mass, &moved));
            assert!((before - after).abs() < 1e-11 * (1.0 + before), "{before} {after}");
            for (f, g) in force(effect.as_ref(), &x).iter().zip(force(effect.as_ref(), &moved)) {
                assert!((turn * f - g).norm() < 1e-10 * (1.0 + f.norm()), "{effect:?}");
            }
        }
    }
}

#[test]
fn the_projected_stiffness_is_positive_semidefinite_and_exact_at_rest() {
    let mut random = Random::new(7);
    for (effect, n) in effects() {
        for case in 0..40 {
            let size = [1.0, 1e-2, 1e-5, 1e-9, 0.0][case % 5];
            let x = nearly_flat(&mut random, n, size);
            let values = stiffness(effect.as_ref(), &x, Tangent::Projected).symmetric_eigenvalues();
            assert!(values.min() >= -1e-12 * values.max(), "{effect:?}, {size}: {values}");
        }
    }
    for (effect, n) in [(angle(PI), 3), (hinge(0.0), 4)] {
        let x = nearly_flat(&mut random, n, 0.0);
        let [exact, projected] = [Tangent::Exact, Tangent::Projected]
            .map(|tangent| stiffness(effect.as_ref(), &x, tangent));
        assert!((&exact - projected).norm() < 1e-12 * exact.norm() && exact.norm() > 0.1);
    }
}

#[test]
fn small_bending_of_a_row_costs_what_the_angle_says() {
    // x_1 at height z between neighbours at distance 1: π − β = 2 atan z.
    let x = [Vec3::x() * -1.0, Vec3::new(0.0, 0.0, 1e-3), Vec3::x()];
    let turn = 2.0 * 1e-3_f64.atan();
    let energy = angle(PI).energy(&[1.0; 3], &x);
    assert!((energy / (0.85 * turn * turn) - 1.0).abs() < 1e-10);
    // Two unit triangles folded by a right angle about the edge along y.
    let x = [Vec3::zeros(), Vec3::y(), Vec3::x() * -1.0, Vec3::z()];
    assert!((hinge(0.0).energy(&[1.0; 4], &x) - 0.3 * FRAC_PI_2 * FRAC_PI_2).abs() < 1e-14);
}

#[test]
fn degenerate_shapes_exert_no_force_and_are_survived() {
    let zero = Vec3::zeros();
    let shapes: [(Box<dyn Effect>, Vec<Vec3>); 6] = [
        (angle(PI), vec![zero; 3]),
        (angle(PI), vec![zero, zero, Vec3::x()]),
        (angle(PI), vec![Vec3::x(), zero, Vec3::x()]), // folded upon itself
        (angle(FRAC_PI_2), vec![Vec3::x(), zero, -Vec3::x()]), // no plane to turn in
        (hinge(0.3), vec![zero; 4]),
        (hinge(0.3), vec![zero, Vec3::y(), Vec3::y() * 2.0, Vec3::x()]),
    ];
    for (effect, x) in shapes {
        assert!(force(effect.as_ref(), &x).iter().all(|f| *f == zero), "{effect:?}");
        assert!(effect.energy(&vec![1.0; x.len()], &x).is_finite());
        for tangent in [Tangent::Exact, Tangent::Projected] {
            let k = stiffness(effect.as_ref(), &x, tangent);
            assert!(k.iter().all(|k| k.is_finite()), "{effect:?}");
        }
    }
}

#[test]
fn the_shorter_way_round_counts_where_the_dihedral_angle_jumps() {
    let fold = |by: f64| {
        let (sin, cos) = by.sin_cos();
        [Vec3::zeros(), Vec3::y(), -Vec3::x(), Vec3::new(cos, 0.0, sin)]
    };
    let energies = [3.1, -3.1].map(|by| hinge(3.0).energy(&[1.0; 4], &fold(-by)));
    let turns = [3.1, -3.1].map(|by| hinge(-3.0).energy(&[1.0; 4], &fold(-by)));
    assert_eq!(energies.map(f64::to_bits), [turns[1], turns[0]].map(f64::to_bits));
    let nearest = energies[0].min(energies[1]);
    assert!((nearest - 0.3 * 0.01).abs() < 1e-9, "{energies:?}");
    let farther = energies[0].max(energies[1]);
    let expected = 2.0 * PI - 6.1;
    assert!((farther - 0.3 * expected * expected).abs() < 1e-9, "{energies:?}");
}
