//! Laws that a method obeys exactly, at any amplitude and step size.
//!
//! # Spin of two free particles
//!
//! Two particles of mass `m` on a spring; `d` and `v` are their relative position and velocity,
//! `θ = 2h²k/m`, `η = 2hc/m` with *full* damping. The angular momentum about the common centre is
//! `½ m d × v`. Since the spring pulls along `d`, each method multiplies it by a number per step that
//! can be read off its formulas; [`spin`] has them. The exact solution multiplies it by `e^{−δh}`.

use drape_model::Vec3;

/// Factor by which one step multiplies the angular momentum of two free particles.
pub mod spin {
    /// Explicit Euler: `1 − η + θ (1 − ℓ/L_n)`. It grows in tension.
    pub fn explicit_euler(theta: f64, eta: f64, rest_over_length_before: f64) -> f64 {
        1.0 - eta + theta * (1.0 - rest_over_length_before)
    }

    /// Symplectic Euler: `1 − η`, whatever the spring does.
    pub fn symplectic_euler(eta: f64) -> f64 {
        1.0 - eta
    }

    /// Symplectic Euler with implicit damping: `1/(1 + η)`.
    pub fn symplectic_euler_implicit_damping(eta: f64) -> f64 {
        1.0 / (1.0 + eta)
    }

    /// Backward Euler: `1/(1 + η + θ (1 − ℓ/L_{n+1}))`. It decays in tension, grows in compression.
    pub fn backward_euler(theta: f64, eta: f64, rest_over_length_after: f64) -> f64 {
        1.0 / (1.0 + eta + theta * (1.0 - rest_over_length_after))
    }

    /// IMEX Euler: `1/(1 + θ + η)`, whatever the spring does: the law of its locking.
    pub fn imex_euler(theta: f64, eta: f64) -> f64 {
        1.0 / (1.0 + theta + eta)
    }

    /// IMEX Euler with *projected* damping, of which the linear part stands in the matrix and the
    /// remainder at level `n`: `(1 + η)/(1 + θ + η)`.
    pub fn imex_euler_projected_damping(theta: f64, eta: f64) -> f64 {
        (1.0 + eta) / (1.0 + theta + eta)
    }
}

/// Which velocity moves the positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drift {
    /// The old one: explicit Euler.
    OldVelocity,
    /// The new one: all the other Euler methods.
    NewVelocity,
}

/// Position and velocity after `steps` steps of free fall: the discrete parabola
/// `x_0 + n h v_0 + ½ n (n ∓ 1) h² g`, `v_0 + n h g`.
pub fn free_fall(drift: Drift, x: Vec3, v: Vec3, g: Vec3, h: f64, steps: u32) -> (Vec3, Vec3) {
    let n = f64::from(steps);
    let other = match drift {
        Drift::OldVelocity => n - 1.0,
        Drift::NewVelocity => n + 1.0,
    };
    (x + v * (n * h) + g * (0.5 * n * other * h * h), v + g * (n * h))
}

/// Lengths at rest of the springs of a hanging chain, top first, m: each carries the weight of all
/// particles below, `L_j = ℓ_j + g Σ_{i ≥ j} m_i / k_j`.
///
/// `masses[j]` hangs at the lower end of spring `j`; `g` is the size of the acceleration.
///
/// ```
/// use drape_oracle::laws::hanging_chain;
/// assert_eq!(hanging_chain(&[1.0, 2.0], &[10.0, 5.0], &[0.5, 0.25], 10.0), [3.5, 4.25]);
/// ```
///
/// # Panics
/// When the lists differ in length.
pub fn hanging_chain(masses: &[f64], stiffness: &[f64], rest_length: &[f64], g: f64) -> Vec<f64> {
    assert!([stiffness.len(), rest_length.len()] == [masses.len(); 2], "one of each a spring");
    let below = |j: usize| masses[j..].iter().sum::<f64>();
    (0..masses.len()).map(|j| rest_length[j] + g * below(j) / stiffness[j]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parabola_is_what_repeated_steps_give() {
        let (g, h) = (Vec3::new(0.0, 1.0, -9.81), 0.25);
        for drift in [Drift::OldVelocity, Drift::NewVelocity] {
            let (x0, v0) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, 0.5, 4.0));
            let (mut x, mut v) = (x0, v0);
            for steps in 1..10 {
                let old = v;
                v += g * h;
                x += h * if drift == Drift::OldVelocity { old } else { v };
                let (expected_x, expected_v) = free_fall(drift, x0, v0, g, h, steps);
                assert!((x - expected_x).norm() < 1e-13 && (v - expected_v).norm() < 1e-13);
            }
        }
    }
}
