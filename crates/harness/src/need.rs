//! Estimates the memory and the work of a run before it starts.

use crate::methods::Choice;
use crate::studies::variant::is_explicit;
use drape_integrator::Settings;
use drape_model::Size;

/// The estimated need of a run. On flat sheets of 40 000 particles and more, the estimate is 0.8 to
/// 1.4 times the measured need. A cloth that is no surface may need more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// Memory, bytes.
    pub bytes: u64,
    /// Floating-point operations of each factorisation, where the method factors a matrix.
    pub factorisation: Option<f64>,
}

/// The matrix that a method holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Matrix {
    /// No matrix, or one that the memory of a particle includes.
    None,
    /// Blocks of 3 × 3 numbers, not factored.
    Blocks,
    /// A factor with one number for a pair of particles.
    ScalarFactor,
    /// A factor with nine numbers for a pair of particles.
    BlockFactor,
}

impl Matrix {
    /// This matrix if the setting `key` has that value, else [`Matrix::None`].
    pub(crate) fn if_set(self, settings: &Settings, key: &str, value: &str) -> Self {
        if settings.get(key) == Some(value) { self } else { Self::None }
    }

    /// The matrix of Newton's method with these settings.
    pub(crate) fn of_newton(settings: &Settings) -> Self {
        match (settings.get("solver"), settings.get("jacobian")) {
            (Some("cholesky"), _) | (Some("cg" | "auto"), Some("saved")) => Self::BlockFactor,
            _ => Self::Blocks,
        }
    }
}

/// Bytes of a program that has loaded no scene.
const PROGRAM: f64 = 1e7;
/// Bytes for each particle, in the specification, the system, the state and the method's memory.
const PARTICLE: f64 = 750.0;
/// The same for explicit methods, which solve no system.
const EXPLICIT_PARTICLE: f64 = 350.0;
/// Bytes for each spring in a matrix of blocks that is not factored.
const BLOCKS: f64 = 150.0;
/// Bytes that a spring adds to a factor of blocks, over the binary logarithm of the number of
/// particles. Nested dissection of a surface gives this law.
const FILL: f64 = 190.0;
/// The same for a factor of numbers, with its indices.
const SCALAR_FILL: f64 = 30.0;
/// Operations that factor the matrix of a sheet with two springs a particle, over the number of
/// particles to the power 1.5. A matrix of numbers takes a 27th part.
const OPERATIONS: f64 = 270.0;

impl Choice {
    /// The estimated need of a run with this choice on a system of that size.
    pub fn need(&self, size: &Size) -> Need {
        let (n, springs) = (size.particles.max(1) as f64, size.springs as f64);
        let matrix = (self.theory().matrix)(self.settings());
        // Bytes a spring.
        let held = match matrix {
            Matrix::None => 0.0,
            Matrix::Blocks => BLOCKS,
            Matrix::ScalarFactor => SCALAR_FILL * n.log2(),
            Matrix::BlockFactor => FILL * n.log2(),
        };
        let particle = if is_explicit(self.method()) { EXPLICIT_PARTICLE } else { PARTICLE };
        let listed = size.bytes_of_springs() as f64 + 2.0 * size.file as f64;
        let bytes = PROGRAM + particle * n + listed + springs * held;
        let dense = (springs / (2.0 * n)).powi(2);
        let operations = OPERATIONS * n.powf(1.5) * dense;
        let factorisation = match matrix {
            Matrix::None | Matrix::Blocks => None,
            Matrix::ScalarFactor => Some(operations / 27.0),
            Matrix::BlockFactor => Some(operations),
        };
        Need { bytes: bytes as u64, factorisation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn need(method: &str, side: u64, springs: u64) -> Need {
        let (particles, file) = (side * side, 500);
        let size = Size { file, particles, springs: springs * particles };
        Choice::parse(method, &[]).expect("a method").need(&size)
    }

    /// The measured numbers are peaks of the resident memory, MiB, in one step of sheets with two
    /// and with six springs a particle.
    #[test]
    fn the_estimate_is_near_what_was_measured() {
        for (method, side, springs, measured) in [
            ("explicit-euler", 400, 2, 88.0),
            ("explicit-euler", 400, 6, 151.0),
            ("leapfrog", 250, 2, 119.0),
            ("leapfrog", 250, 6, 219.0),
            ("imex-euler", 400, 2, 149.0),
            ("imex-euler", 400, 6, 209.0),
            ("imex-euler:solver=cholesky", 250, 2, 110.0),
            ("baraff-witkin", 250, 6, 96.0),
            ("desbrun", 250, 2, 116.0),
            ("desbrun", 250, 6, 222.0),
            ("terzopoulos-fleischer", 250, 6, 201.0),
            ("backward-euler:solver=cholesky", 250, 2, 416.0),
            ("backward-euler:solver=cholesky", 250, 6, 1131.0),
            ("backward-euler:solver=cholesky", 400, 2, 1121.0),
            ("bdf2:solver=cholesky", 400, 6, 3171.0),
        ] {
            let told = need(method, side, springs).bytes as f64 / f64::from(1 << 20);
            let ratio = told / measured;
            assert!((0.8..1.4).contains(&ratio), "{method} {side} {springs}: {told} {measured}");
        }
    }

    #[test]
    fn work_is_told_where_a_matrix_is_factored() {
        assert_eq!(need("imex-euler", 100, 2).factorisation, None);
        let scalar = need("imex-euler:solver=cholesky", 100, 2).factorisation;
        let block = need("bdf2:jacobian=saved", 100, 2).factorisation;
        assert!(scalar.is_some_and(|s| block.is_some_and(|b| 20.0 * s < b && b > 1e8)));
        for method in ["bdf2", "bdf2:solver=multigrid"] {
            assert_eq!(need(method, 100, 2).factorisation, None, "{method}");
        }
    }
}
