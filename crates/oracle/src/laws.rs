//! Laws that a method obeys exactly, at any amplitude and step size.
//!
//! # Spin of two free particles
//!
//! Two particles of mass `m` are joined by a spring with *full* damping. `d` and `v` are their
//! relative position and velocity; `w = hv`, `θ = 2h²k/m`, `η = 2hc/m`. Their angular momentum
//! about the common centre is `½ m d × v`. Since the spring pulls along `d`, each step of a
//! one-step method multiplies it by a factor that follows from the formulas. [`spin`] holds these
//! factors. The exact solution multiplies it by `e^{−δh}`.
//!
//! If `d' = d + w'`, then `d' × w' = d × w'`, and any part of `w'` along `d` drops out. Backward
//! Euler pulls along `d'` and also needs `d × w = d' × w − w' × w`. Provot's method is symplectic
//! Euler until its limit of elongation becomes active and changes the velocities.
//!
//! Linear multistep methods mix several levels and have no such factor. A step of BDF-k is a step
//! of backward Euler with `τ = h b_0/a_0` from the combinations `X* = −Σ_{j≥1} a_j x_{n+1−j}/a_0`
//! and likewise `V*`. So `d' × v'` is `X* × V*` times the
//! [factor of backward Euler](spin::backward_euler) at `(τ/h)² θ` and `(τ/h) η`.
//!
//! # Free fall
//!
//! Under gravity alone every method gives a known discrete parabola: [`free_fall`] in closed form,
//! [`constant_acceleration`] for any multistep method from any start.

use crate::recurrence::Multistep;
use drape_model::Vec3;

/// Factor by which one step multiplies the angular momentum of two free particles.
pub mod spin {
    use crate::recurrence::{jacobi_of_pair, power};

    /// Explicit Euler: `1 − η + θ (1 − ℓ/L_n)`. It grows in tension.
    pub fn explicit_euler(theta: f64, eta: f64, rest_over_length_before: f64) -> f64 {
        1.0 - eta + theta * (1.0 - rest_over_length_before)
    }

    /// Symplectic Euler: `1 − η`, independent of the spring force.
    pub fn symplectic_euler(eta: f64) -> f64 {
        1.0 - eta
    }

    /// Symplectic Euler with implicit damping: `1/(1 + η)`.
    pub fn symplectic_euler_implicit_damping(eta: f64) -> f64 {
        1.0 / (1.0 + eta)
    }

    /// Leapfrog with Crank–Nicolson damping: `(1 − ½η)/(1 + ½η)`, independent of the spring force.
    /// Without damping it is exactly 1.
    ///
    /// The first half kick multiplies `d × w` by `1 − ½η`, the drift `d' = d + w½` keeps `d × w½`,
    /// the second half kick divides by `1 + ½η`.
    pub fn leapfrog(eta: f64) -> f64 {
        (1.0 - 0.5 * eta) / (1.0 + 0.5 * eta)
    }

    /// Kicks over fractions `c` of a step, with drifts between them: `Π p(cη)`, independent of the
    /// spring force. `p` is the series of `e^{−cη}` after `terms` terms. Two fractions of ½ and two
    /// terms give leapfrog with explicit damping. Without damping the factor is exactly 1.
    pub fn kicks(shares: &[f64], eta: f64, terms: u32) -> f64 {
        shares.iter().map(|share| crate::recurrence::kick(*share, 0.0, eta, terms).m22).product()
    }

    /// Backward Euler: `1/(1 + η + θ (1 − ℓ/L_{n+1}))`. It decays in tension and grows in
    /// compression.
    ///
    /// Baraff–Witkin takes one Newton step from the old state and uses `L_n` instead. If it clamps
    /// negative transverse stiffness, pass at most 1 for `ℓ/L_n`.
    pub fn backward_euler(theta: f64, eta: f64, rest_over_length: f64) -> f64 {
        1.0 / (1.0 + eta + theta * (1.0 - rest_over_length))
    }

    /// Implicit midpoint: `(1 − ε)/(1 + ε)`, `ε = ½η/(1 + ¼θ (1 − ℓ/L_m))` with the length `L_m` of
    /// `½ (d + d')`. It is exactly 1 without damping, and with damping *projected* on that
    /// direction.
    ///
    /// `d' × w' − d × w = d_m × (w' − w) + (d' − d) × w_m = −η d_m × w_m` and
    /// `½ (d' × w' + d × w) = d_m × w_m + ¼ (d' − d) × (w' − w)`.
    pub fn implicit_midpoint(theta: f64, eta: f64, rest_over_length_middle: f64) -> f64 {
        let loss = 0.5 * eta / (1.0 + 0.25 * theta * (1.0 - rest_over_length_middle));
        (1.0 - loss) / (1.0 + loss)
    }

    /// The trapezoidal rule, which is Newmark's method with `β = ¼`, `γ = ½`, from a consistent
    /// acceleration: `(1 − ½η + ¼θ (1 − ℓ/L_n))/(1 + ½η + ¼θ (1 − ℓ/L_{n+1}))`. Without damping
    /// `(1 + ¼θ (1 − ℓ/L)) d × w` is the same at all levels, so the spin oscillates and never
    /// drifts.
    ///
    /// With `s = 1 − ℓ/L` the step says that `d − ½w` and `(1 + ½η) w + ½θ s d` at the new level
    /// are `d + ½w` and `(1 − ½η) w − ½θ s d` at the old one. Each pair has a cross product.
    pub fn trapezoid(
        theta: f64,
        eta: f64,
        rest_over_length_before: f64,
        rest_over_length: f64,
    ) -> f64 {
        let pull = |ratio: f64| 0.25 * theta * (1.0 - ratio);
        (1.0 - 0.5 * eta + pull(rest_over_length_before))
            / (1.0 + 0.5 * eta + pull(rest_over_length))
    }

    /// The energy-momentum method: the law of [`implicit_midpoint`] with `1 − 2ℓ/(L_n + L_{n+1})`
    /// for `1 − ℓ/L_m`. It is exactly 1 without damping.
    ///
    /// The discrete gradient pulls along `d + d'`, with `k (1 − 2ℓ/(L_n + L_{n+1}))` per half of
    /// it.
    pub fn energy_momentum(
        theta: f64,
        eta: f64,
        rest_over_length_before: f64,
        rest_over_length_after: f64,
    ) -> f64 {
        let mean = 2.0 / (1.0 / rest_over_length_before + 1.0 / rest_over_length_after);
        implicit_midpoint(theta, eta, mean)
    }

    /// IMEX Euler: `1/(1 + θ + η)`, independent of the spring force. This law describes the locking
    /// of IMEX Euler. Desbrun's predictor, without the torque correction, obeys it too.
    pub fn imex_euler(theta: f64, eta: f64) -> f64 {
        1.0 / (1.0 + theta + eta)
    }

    /// IMEX Euler with *projected* damping, its linear part in the matrix and its remainder at
    /// level `n`: `(1 + η)/(1 + θ + η)`.
    pub fn imex_euler_projected_damping(theta: f64, eta: f64) -> f64 {
        (1.0 + eta) / (1.0 + theta + eta)
    }

    /// Terzopoulos–Fleischer: `(1 − ½η)/(1 + ½η + θ (1 − ℓ/L_n))`, with the secant stiffness of the
    /// old length. If it clamps negative secants, pass at most 1 for `ℓ/L_n`.
    pub fn terzopoulos_fleischer(theta: f64, eta: f64, rest_over_length_before: f64) -> f64 {
        (1.0 - 0.5 * eta) / (1.0 + 0.5 * eta + theta * (1.0 - rest_over_length_before))
    }

    /// Terzopoulos–Fleischer with *projected* damping, half of its linear part in the matrix and
    /// its remainder at level `n`: `(1 + ½η)/(1 + ½η + θ (1 − ℓ/L_n))`.
    pub fn terzopoulos_fleischer_projected_damping(
        theta: f64,
        eta: f64,
        rest_over_length_before: f64,
    ) -> f64 {
        (1.0 + 0.5 * eta) / (1.0 + 0.5 * eta + theta * (1.0 - rest_over_length_before))
    }

    /// Baraff–Witkin with the clamped Hessian: `1/(1 + η + θ max(0, 1 − ℓ/L_n))`. It is the law of
    /// backward Euler with the length before the step, and without growth in compression.
    pub fn baraff_witkin(theta: f64, eta: f64, rest_over_length_before: f64) -> f64 {
        backward_euler(theta, eta, rest_over_length_before.min(1.0))
    }

    /// XPBD in one sweep, with any damping along the spring and at any length: `L_+/L_pred`, the
    /// length after the sweep over that of the prediction `d + w`.
    ///
    /// The sweep scales the prediction by `L_+/L_pred`, and `(d + w) × w = d × w`. Without damping
    /// `L_pred = L_+ + θ (L_+ − ℓ)`: the factor is that of [`backward_euler`].
    pub fn xpbd(predicted_length: f64, length_after: f64) -> f64 {
        length_after / predicted_length
    }

    /// Kang's step after `sweeps` corrections by the neighbours: `1 − φ (θ + η)/(1 + θ + η)` with
    /// `φ = 1 − γ^{sweeps+1}`, `γ = −a/(1+a)`, `a = ½ (θ + η)`.
    ///
    /// Kang's formula (`sweeps = 1`) gives `(1 + a²)/(1 + a)²`, which is never below ½ and tends to
    /// 1 for very stiff springs. The predictor alone gives `(1 − a)/(1 + a)` and reverses the
    /// rotation for `a > 1`.
    pub fn kang(theta: f64, eta: f64, sweeps: u32) -> f64 {
        1.0 - kang_share(theta, eta, sweeps) * (theta + eta)
    }

    /// Kang's step with *projected* damping, its linear part in the matrix and its remainder at
    /// level `n`: `1 − φ θ/(1 + θ + η)`.
    pub fn kang_projected_damping(theta: f64, eta: f64, sweeps: u32) -> f64 {
        1.0 - kang_share(theta, eta, sweeps) * theta
    }

    /// `φ/(1 + θ + η)`.
    fn kang_share(theta: f64, eta: f64, sweeps: u32) -> f64 {
        let jacobi = jacobi_of_pair(0.5 * theta, 0.5 * eta);
        (1.0 - power(jacobi, sweeps)) / (1.0 + theta + eta)
    }
}

/// Which velocity moves the positions in free fall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drift {
    /// The old velocity: explicit Euler.
    OldVelocity,
    /// The new velocity: all the other Euler methods, Terzopoulos–Fleischer, Kang.
    NewVelocity,
    /// The new velocity in each of this number of substeps: XPBD. `v` gains `g h/n` in a substep.
    Substeps(u32),
    /// The mean of old and new velocity, which is exact: leapfrog and implicit midpoint. Multistep
    /// methods of order 2 and 3 also belong here if their first steps are exact, for example by
    /// Heun's method, the trapezoidal rule or implicit midpoint.
    MeanVelocity,
    /// The mean of old and new velocity, after a first step of backward Euler: CNAB2, MCNAB2.
    MeanAfterBackwardEuler,
    /// BDF2 and SBDF2 after a first step of backward Euler.
    Bdf2AfterBackwardEuler,
    /// CNLF after a first step of backward Euler, at a constant step size.
    CnlfAfterBackwardEuler,
}

impl Drift {
    /// Difference of the position after `n` steps from `x_0 + n h v_0 + ½ n² h² g`, in units of
    /// `h² g`.
    fn error(self, n: u32) -> f64 {
        let half = 0.5 * f64::from(n);
        // A multistep method of order 2 makes no error of its own here. It carries on the error of
        // the first step, ½ h² g, by the roots of Σ a_j ζ^{k−j}: 1 for CNAB2, 1 and 1/3 for BDF2,
        // ±1 for CNLF.
        match self {
            Self::OldVelocity => -half,
            Self::NewVelocity => half,
            Self::Substeps(count) => half / f64::from(count),
            Self::MeanVelocity => 0.0,
            Self::MeanAfterBackwardEuler => 0.5 * f64::from(n.min(1)),
            Self::Bdf2AfterBackwardEuler => 0.75 * (1.0 - 3.0_f64.powi(-(n.min(64) as i32))),
            Self::CnlfAfterBackwardEuler => 0.5 * f64::from(n % 2),
        }
    }
}

/// Position (m) and velocity (m/s) after `n = steps` steps of free fall: the discrete parabola
/// `x_0 + n h v_0 + (½ n² + e_n) h² g`, and `v_0 + n h g`.
///
/// | drift | `e_n` |
/// |---|---|
/// | [`OldVelocity`](Drift::OldVelocity), [`NewVelocity`](Drift::NewVelocity) | `−½ n`, `½ n` |
/// | [`Substeps`](Drift::Substeps) of `h/s` | `½ n/s` |
/// | [`MeanVelocity`](Drift::MeanVelocity) | 0 |
/// | [`MeanAfterBackwardEuler`](Drift::MeanAfterBackwardEuler) | `½` from the first step on |
/// | [`Bdf2AfterBackwardEuler`](Drift::Bdf2AfterBackwardEuler) | `¾ (1 − 3^{−n})` |
/// | [`CnlfAfterBackwardEuler`](Drift::CnlfAfterBackwardEuler) | `½` after an odd number of steps, else 0 |
pub fn free_fall(drift: Drift, x: Vec3, v: Vec3, g: Vec3, h: f64, steps: u32) -> (Vec3, Vec3) {
    let n = f64::from(steps);
    (x + v * (n * h) + g * ((0.5 * n * n + drift.error(steps)) * h * h), v + g * (n * h))
}

/// Position and velocity of a linear multistep method on `x'' = g` after `steps` more steps of size
/// `h`.
///
/// `history` holds the past levels, newest first: at least as many as the method has steps, taken
/// from its actual first steps. If step sizes vary, call it for one step at a time. Gravity may
/// belong to either part, because the weights of both have the same sum.
///
/// ```
/// use drape_model::Vec3;
/// use drape_oracle::{laws::constant_acceleration, recurrence::Multistep};
/// let (g, h) = (-Vec3::z(), 0.5);
/// let level = |t: f64| (g * (0.5 * t * t), g * t);
/// let ab2 = Multistep::adams_bashforth(&[1.0]);
/// assert_eq!(constant_acceleration(&ab2, &[level(0.5), level(0.0)], g, h, 7), level(4.0));
/// ```
pub fn constant_acceleration(
    method: &Multistep,
    history: &[(Vec3, Vec3)],
    g: Vec3,
    h: f64,
    steps: u32,
) -> (Vec3, Vec3) {
    let Multistep { a, b, c } = method;
    let mut levels: Vec<_> = history[..a.len() - 1].to_vec();
    for _ in 0..steps {
        let (mut x, mut v) = (Vec3::zeros(), Vec3::zeros());
        for (j, (x_old, v_old)) in levels.iter().enumerate() {
            x += v_old * (h * b[j + 1]) - x_old * a[j + 1];
            v += g * (h * c[j + 1]) - v_old * a[j + 1];
        }
        v /= a[0];
        x = (x + v * (h * b[0])) / a[0];
        levels.rotate_right(1);
        levels[0] = (x, v);
    }
    levels[0]
}

/// Lengths of the springs of a hanging chain at rest, top first, m. Each spring carries the weight
/// of all particles below it: `L_j = ℓ_j + g Σ_{i ≥ j} m_i / k_j`.
///
/// `masses[j]` hangs at the lower end of spring `j`; `g` is the size of the acceleration.
///
/// ```
/// use drape_oracle::laws::hanging_chain;
/// assert_eq!(hanging_chain(&[1.0, 2.0], &[10.0, 5.0], &[0.5, 0.25], 10.0), [3.5, 4.25]);
/// ```
///
/// # Panics
/// If the lists differ in length.
pub fn hanging_chain(masses: &[f64], stiffness: &[f64], rest_length: &[f64], g: f64) -> Vec<f64> {
    assert!([stiffness.len(), rest_length.len()] == [masses.len(); 2], "one of each a spring");
    let below = |j: usize| masses[j..].iter().sum::<f64>();
    (0..masses.len()).map(|j| rest_length[j] + g * below(j) / stiffness[j]).collect()
}

#[cfg(test)]
mod tests;
