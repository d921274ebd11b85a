//! The law of locking.
//!
//! With all springs in the matrix, a step of IMEX Euler is
//! `(M + h² L_k + h L_d) v' = M v + h F(x)`. This is symplectic Euler with an additional full
//! damping `hk` of every spring. The springs of a sheet at rest length do not resist a motion
//! across them. Such a sheet therefore falls like one in honey: `M v' = M g − h L_k v`, towards
//! `h L_k v = M g`. A mode with `κ = λ k/m` approaches `a/(hκ)`.

use drape_integrator::Implicit;
use drape_model::System;

/// Relative residual at which the solver stops.
const TOLERANCE: f64 = 1e-13;

/// Solves `L_k u = k 1` with `u = 0` at pinned particles, for equal masses `m` and the stiffness
/// quotient `k/m` in 1/s². The terminal speed of the law is `a u/(h k/m)`. Conjugate gradients sum
/// in a fixed order, so the bits are the same on every machine.
pub(super) fn lever(system: &System, stiffness_over_mass: f64) -> Vec<f64> {
    let n = system.len();
    let mut springs = Vec::new();
    Implicit::Springs.visit_weights(system, &mut |i, j, k, _| springs.push((i, j, k)));
    let unit: Vec<f64> = system.mass().iter().map(|m| m * stiffness_over_mass).collect();
    let free: Vec<f64> = system.pinned().iter().map(|p| if *p { 0.0 } else { 1.0 }).collect();
    let multiply = |p: &[f64]| {
        let mut product = vec![0.0; n];
        for &(i, j, k) in &springs {
            let pull = k * (p[i] - p[j]);
            product[i] += pull;
            product[j] -= pull;
        }
        for (i, value) in product.iter_mut().enumerate() {
            *value *= free[i] / unit[i];
        }
        product
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut u, mut r) = (vec![0.0; n], free.clone());
    let mut p = r.clone();
    let mut rr = dot(&r, &r);
    let target = TOLERANCE * TOLERANCE * rr;
    for _ in 0..10 * n {
        if rr <= target {
            break;
        }
        let q = multiply(&p);
        let step = rr / dot(&p, &q);
        for i in 0..n {
            u[i] += step * p[i];
            r[i] -= step * q[i];
        }
        let next = dot(&r, &r);
        for i in 0..n {
            p[i] = r[i] + next / rr * p[i];
        }
        rr = next;
    }
    u
}

/// `1/λ` of the lowest swing of a sheet of `side` rows that is held along a whole edge, with
/// `λ = (π/2N)²`.
pub(super) fn swing_lever(side: u32) -> f64 {
    let root = 2.0 * f64::from(side) / std::f64::consts::PI;
    root * root
}
