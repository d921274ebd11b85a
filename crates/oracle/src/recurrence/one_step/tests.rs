//! Matrices against the steps that they stand for, and stability where theory puts it.

use super::*;
use crate::Random;
use nalgebra::{DMatrix, DVector, Vector2};

#[test]
fn the_spectral_radius_is_that_of_known_matrices() {
    for (matrix, radius) in [
        (Matrix2::new(0.0, -2.0, 2.0, 0.0), 2.0),
        (Matrix2::new(3.0, 1.0, 0.0, -4.0), 4.0),
        (Matrix2::new(-5.0, 7.0, 0.0, 4.0), 5.0),
        (Matrix2::identity(), 1.0),
    ] {
        assert!((spectral_radius(&matrix) - radius).abs() < 1e-14, "{matrix}");
    }
}

#[test]
fn imex_euler_with_everything_implicit_is_backward_euler() {
    for (theta, eta) in [(0.36, 0.06), (100.0, 0.4), (1e-6, 3.0)] {
        let difference = imex_euler(theta, 0.0, eta) - backward_euler(theta, eta);
        assert!(difference.norm() < 1e-15, "{difference}");
    }
}

/// Random `(θ, η)` over many sizes, and a state.
fn random_cases(seed: u64) -> impl Iterator<Item = (f64, f64, Vector2<f64>)> {
    let mut random = Random::new(seed);
    (0..200).map(move |_| {
        let (theta, eta) = (random.power_of_ten(-3.0, 5.0), random.power_of_ten(-3.0, 3.0));
        (theta, eta, Vector2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0)))
    })
}

/// Newmark's formulas with accelerations, not kicks.
#[test]
fn leapfrog_is_newmark_with_beta_zero_and_gamma_one_half() {
    for (theta, eta, old) in random_cases(1) {
        let new = leapfrog(theta, eta) * old;
        let acceleration = |y: Vector2<f64>| -theta * y.x - eta * y.y;
        let position = old.x + old.y + 0.5 * acceleration(old);
        let residual = new.y - old.y - 0.5 * (acceleration(old) + acceleration(new));
        let scale = (1.0 + theta + eta) * (old.norm() + new.norm());
        let case = format!("θ={theta} η={eta}: {residual:e}");
        assert!((new.x - position).abs() < 1e-14 * scale, "{case}");
        assert!(residual.abs() < 1e-14 * scale, "{case}");
    }
}

#[test]
fn implicit_midpoint_takes_the_forces_in_the_middle_of_the_step() {
    for (theta, eta, old) in random_cases(2) {
        let new = implicit_midpoint(theta, eta) * old;
        let middle = (old + new) * 0.5;
        let rate = Vector2::new(middle.y, -theta * middle.x - eta * middle.y);
        let scale = (1.0 + theta + eta) * (old.norm() + new.norm());
        assert!((new - old - rate).norm() < 1e-14 * scale, "θ={theta} η={eta}");
    }
}

/// The polynomial of the method in positions alone: `(1+θ+½η) x_{n+1} − 2x_n + (1−½η) x_{n−1} = 0`.
#[test]
fn terzopoulos_fleischer_obeys_its_two_step_formula() {
    for (theta, eta, first) in random_cases(3) {
        let matrix = terzopoulos_fleischer(theta, eta);
        let second = matrix * first;
        let third = matrix * second;
        let half = 0.5 * eta;
        let residual = (1.0 + theta + half) * third.x - 2.0 * second.x + (1.0 - half) * first.x;
        let scale = (1.0 + theta + eta) * (first.norm() + second.norm() + third.norm());
        assert!(residual.abs() < 1e-14 * scale, "θ={theta} η={eta}: {residual:e}");
        assert!((second.y - (second.x - first.x)).abs() < 1e-14 * scale, "w = x' − x");
    }
}

/// Desbrun's formulas as they are carried out: the internal force with its artificial viscosity,
/// filtered.
#[test]
fn desbrun_filters_force_and_viscosity() {
    for (theta, eta, old) in random_cases(4) {
        let force = -theta * old.x - (theta + eta) * old.y;
        let velocity = old.y + force / (1.0 + theta + eta);
        let expected = Vector2::new(old.x + velocity, velocity);
        let scale = (1.0 + theta + eta) * old.norm();
        assert!((desbrun(theta, eta) * old - expected).norm() < 1e-14 * scale, "θ={theta} η={eta}");
    }
}

/// Kang's step on a whole system of unit masses. `laplacian` belongs to springs of stiffness 1,
/// with pinned particles left out.
fn kang_step(
    laplacian: &DMatrix<f64>,
    (s, d): (f64, f64),
    sweeps: u32,
    x: &DVector<f64>,
    w: &DVector<f64>,
) -> (DVector<f64>, DVector<f64>) {
    let force = -(laplacian * x) * s - (laplacian * w) * (s + d);
    let diagonal = laplacian.diagonal() * (s + d);
    let mut change = force.clone();
    for i in 0..change.len() {
        change[i] /= 1.0 + diagonal[i];
    }
    for _ in 0..sweeps {
        let last = change.clone();
        for i in 0..change.len() {
            let others = (0..last.len()).filter(|j| *j != i);
            let pull: f64 = others.map(|j| -laplacian[(i, j)] * (s + d) * last[j]).sum();
            change[i] = (force[i] + pull) / (1.0 + diagonal[i]);
        }
    }
    (x + w + &change, w + change)
}

/// Two free particles, an anchored one, and two modes of a ring of six.
#[test]
fn kang_takes_one_jacobi_sweep_a_correction() {
    let pair = DMatrix::from_row_slice(2, 2, &[1.0, -1.0, -1.0, 1.0]);
    let anchored = DMatrix::from_element(1, 1, 1.0);
    let ring = DMatrix::from_fn(6, 6, |i, j| match (6 + i - j) % 6 {
        0 => 2.0,
        1 | 5 => -1.0,
        _ => 0.0,
    });
    let wave =
        |p: usize| DVector::from_fn(6, |i, _| (std::f64::consts::TAU * (i * p) as f64 / 6.0).cos());
    let relative = DVector::from_row_slice(&[1.0, -1.0]);
    for (s, d) in [(0.18, 0.03), (50.0, 0.0), (3.0, 7.0), (0.0, 2.0)] {
        for sweeps in 0..6 {
            let of_ring = |p: usize| {
                let cosine = (std::f64::consts::TAU * p as f64 / 6.0).cos();
                let gamma = 2.0 * (s + d) * cosine / (1.0 + 2.0 * (s + d));
                let lambda = 2.0 - 2.0 * cosine;
                kang_mode(lambda * s, lambda * d, gamma, sweeps)
            };
            for (laplacian, mode, matrix) in [
                (&pair, relative.clone(), kang_pair(s, d, sweeps)),
                (&anchored, DVector::from_element(1, 1.0), kang_anchored(s, d, sweeps)),
                (&ring, wave(1), of_ring(1)),
                (&ring, wave(3), of_ring(3)),
            ] {
                for start in [Vector2::x(), Vector2::y()] {
                    let (x, w) = (&mode * start.x, &mode * start.y);
                    let (x, w) = kang_step(laplacian, (s, d), sweeps, &x, &w);
                    let expected = matrix * start;
                    let error = (x - &mode * expected.x).norm() + (w - &mode * expected.y).norm();
                    let case = format!("s={s} d={d}, {sweeps} sweeps: {error:e}");
                    assert!(error < 1e-13, "{case}");
                }
            }
        }
    }
}

#[test]
fn kang_without_damping_has_the_published_matrix_and_an_even_number_of_corrections_overshoots() {
    for s in [0.01, 0.5, 1.9, 2.1, 100.0] {
        let q = 2.0 * s / ((1.0 + s) * (1.0 + s));
        let expected = Matrix2::new(1.0 - q, 1.0 - q, -q, 1.0 - q);
        assert!((kang_pair(s, 0.0, 1) - expected).norm() < 1e-14, "s={s}");
        let radius = |sweeps| spectral_radius(&kang_pair(s, 0.0, sweeps));
        assert!((radius(1) - (1.0 - q).sqrt()).abs() < 1e-14, "s={s}");
        assert_eq!(radius(0) <= 1.0, s < 2.0, "s={s}");
        for d in [0.0, 0.3, 10.0] {
            let odd = spectral_radius(&kang_pair(s, d, 3));
            assert!(odd < 1.0, "s={s} d={d}: {odd}");
            let (theta, eta) = (2.0 * s, 2.0 * d);
            let share = 1.0 + ((s + d) / (1.0 + s + d)).powi(3);
            let stable = share * (3.0 * theta + 2.0 * eta) <= 4.0 * (1.0 + theta + eta);
            assert_eq!(spectral_radius(&kang_pair(s, d, 2)) <= 1.0, stable, "s={s} d={d}");
        }
    }
    assert!(spectral_radius(&kang_pair(100.0, 0.0, 2)) > 1.5);
    let many = kang_pair(3.0, 1.0, 200) - backward_euler(6.0, 2.0);
    assert!(many.norm() < 1e-14, "many sweeps solve exactly: {many}");
}

/// Explicit Euler: `θ ≤ η` and `2η ≤ 4 + θ`. Symplectic: `θ + 2η < 4`, or `θ < 4 + 2η`. Leapfrog:
/// `θ < 4`.
#[test]
fn stability_limits_are_where_theory_puts_them() {
    let stable = |a: Amplification| spectral_radius(&a) <= 1.0 + 1e-12;
    for i in 1..60 {
        for j in 0..60 {
            // Off the boundaries, which lie at multiples of 1/8.
            let (theta, eta) = (0.125 * f64::from(i) + 0.03, 0.125 * f64::from(j) + 0.01);
            let case = format!("θ={theta} η={eta}");
            let explicit = theta <= eta && 2.0 * eta <= 4.0 + theta;
            assert_eq!(stable(explicit_euler(theta, eta)), explicit, "{case}");
            assert_eq!(stable(symplectic_euler(theta, eta)), theta + 2.0 * eta < 4.0, "{case}");
            let implicit_damping = symplectic_euler_implicit_damping(theta, eta);
            assert_eq!(stable(implicit_damping), theta < 4.0 + 2.0 * eta, "{case}");
            for eta in [0.0, eta, 100.0 * eta] {
                assert_eq!(stable(leapfrog(theta, eta)), theta < 4.0, "leapfrog, {case}");
                assert!(stable(backward_euler(theta, eta)), "{case}");
                assert!(stable(implicit_midpoint(theta, eta)), "{case}");
                assert!(stable(terzopoulos_fleischer(theta, eta)), "{case}");
                assert!(stable(kang_pair(0.5 * theta, 0.5 * eta, 1)), "{case}");
            }
        }
    }
}

/// Order 2 means that a step follows the exact motion up to `h³`, order 1 up to `h²`.
#[test]
fn one_step_follows_the_exact_motion_up_to_the_order_of_the_method() {
    // x'' = −x − x'/5 over a step h, on (x, w = hv): exp of h [[0, 1], [−1, −1/5]] in scaled form.
    let exact = |h: f64| Matrix2::new(0.0, 1.0, -h * h, -0.2 * h).exp();
    type Method = fn(f64, f64) -> Amplification;
    let methods: [(&str, i32, Method); 9] = [
        ("explicit Euler", 1, explicit_euler),
        ("symplectic Euler", 1, symplectic_euler),
        ("symplectic Euler, implicit damping", 1, symplectic_euler_implicit_damping),
        ("leapfrog", 2, leapfrog),
        ("backward Euler", 1, backward_euler),
        ("implicit midpoint", 2, implicit_midpoint),
        ("Terzopoulos-Fleischer", 1, terzopoulos_fleischer),
        ("Desbrun", 1, desbrun),
        ("Kang", 1, |theta, eta| kang_pair(0.5 * theta, 0.5 * eta, 1)),
    ];
    for (name, order, method) in methods {
        let error = |h: f64| {
            let difference = method(h * h, 0.2 * h) - exact(h);
            let start = Vector2::new(1.0, 0.7 * h);
            let wrong = difference * start;
            wrong.x.hypot(wrong.y / h)
        };
        let slope = (error(1e-2) / error(5e-3)).log2();
        assert!((slope - f64::from(order + 1)).abs() < 0.05, "{name}: {slope}");
    }
}
