//! One step of each method on the oscillator `x'' = −κx − δx'`, as a matrix.
//!
//! A step of size `h` maps `(x, w = hv)` to `A (x, w)` with a matrix that depends on `θ = h²κ` and
//! `η = hδ` only. A method that does not reproduce its matrix to round-off is another method.
//!
//! On a system of springs of rest length 0 each eigenmode of the graph Laplacian is such an
//! oscillator. With a rest length above 0 the motion along an anchored spring is, offset by it; the
//! small motion across a spring of length `L` is one with `θ (1 − ℓ/L)`, of which the
//! implicit-explicit methods take `θ` implicitly and `−θ ℓ/L` explicitly.

use nalgebra::Matrix2;

/// Amplification matrix on `(x, w)`, `w = hv`.
pub type Amplification = Matrix2<f64>;

/// Explicit Euler: `[[1, 1], [−θ, 1−η]]`.
pub fn explicit_euler(theta: f64, eta: f64) -> Amplification {
    Matrix2::new(1.0, 1.0, -theta, 1.0 - eta)
}

/// Symplectic Euler with the damping at the old velocity: `[[1−θ, 1−η], [−θ, 1−η]]`.
pub fn symplectic_euler(theta: f64, eta: f64) -> Amplification {
    Matrix2::new(1.0 - theta, 1.0 - eta, -theta, 1.0 - eta)
}

/// Symplectic Euler with the damping at the new velocity:
/// `[[1−θ/(1+η), 1/(1+η)], [−θ/(1+η), 1/(1+η)]]`.
pub fn symplectic_euler_implicit_damping(theta: f64, eta: f64) -> Amplification {
    imex_euler(0.0, theta, eta)
}

/// Backward Euler: `[[1+η, 1], [−θ, 1]] / (1+θ+η)`.
///
/// ```
/// use drape_oracle::recurrence::{backward_euler, spectral_radius};
/// assert!((spectral_radius(&backward_euler(1.0, 0.0)) - 0.5_f64.sqrt()).abs() < 1e-15);
/// ```
pub fn backward_euler(theta: f64, eta: f64) -> Amplification {
    Matrix2::new(1.0 + eta, 1.0, -theta, 1.0) / (1.0 + theta + eta)
}

/// IMEX Euler on `x'' = −(κ_I + κ_E)x − δx'` with `κ_I` and `δ` implicit and `κ_E` explicit:
/// `[[1−(θ_I+θ_E)/D, 1/D], [−(θ_I+θ_E)/D, 1/D]]`, `D = 1 + θ_I + η`. With `θ_E = 0` it is backward
/// Euler.
pub fn imex_euler(theta_implicit: f64, theta_explicit: f64, eta: f64) -> Amplification {
    let d = 1.0 + theta_implicit + eta;
    let pull = (theta_implicit + theta_explicit) / d;
    Matrix2::new(1.0 - pull, 1.0 / d, -pull, 1.0 / d)
}

/// Largest modulus of the two eigenvalues: the factor by which a step multiplies the oscillation in
/// the long run.
pub fn spectral_radius(a: &Amplification) -> f64 {
    let (half_trace, determinant) = (0.5 * a.trace(), a.determinant());
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// Independent values: the roots of the characteristic polynomials, computed elsewhere.
    #[test]
    #[allow(clippy::approx_constant, reason = "the table is kept as it was computed")]
    fn spectral_radii_match_the_golden_table() {
        let radii = |theta, eta| {
            [
                explicit_euler(theta, eta),
                symplectic_euler(theta, eta),
                symplectic_euler_implicit_damping(theta, eta),
                backward_euler(theta, eta),
            ]
            .map(|a| spectral_radius(&a))
        };
        let golden = [
            ((0.36, 0.06), [1.140175425099, 0.969535971483, 0.971285862357, 0.839181358297]),
            ((100.0, 0.4), [10.029955134496, 98.393902061129, 69.704038306364, 0.099307265287]),
            ((100.0, 0.0), [10.049875621121, 97.989794855664, 97.989794855664, 0.099503719021]),
            ((1.0, 0.0), [1.414213562373, 1.0, 1.0, 0.707106781187]),
        ];
        for ((theta, eta), expected) in golden {
            for (found, expected) in radii(theta, eta).into_iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-10, "θ={theta} η={eta}: {found}");
            }
        }
        let imex = [
            ((1.0, 0.0, 0.0), 0.707106781187, 1e-10),
            ((0.36, 0.0, 0.06), 0.839181358297, 1e-10),
            ((100.0, -99.0, 0.0), 0.989999, 1e-6),
            ((100.0, -110.0, 0.0), 1.099909, 1e-6),
            ((100.0, 50.0, 0.0), 0.453411, 1e-6),
            ((100.0, -100.0, 0.0), 1.0, 1e-10),
        ];
        for ((implicit, explicit, eta), expected, tolerance) in imex {
            let found = spectral_radius(&imex_euler(implicit, explicit, eta));
            let case = format!("θ_I={implicit} θ_E={explicit} η={eta}: {found}");
            assert!((found / expected - 1.0).abs() < tolerance, "{case}");
        }
    }

    /// Explicit Euler: `θ ≤ η` and `2η ≤ 4 + θ`. Symplectic: `θ + 2η < 4`, or `θ < 4 + 2η`.
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
                assert!(stable(backward_euler(theta, eta)), "{case}");
            }
        }
    }
}
