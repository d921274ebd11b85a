//! `φ₂(hJ) g` in a Krylov subspace: Arnoldi's method, and the function of the small matrix.

use crate::series::Series;
use drape_model::Vec3;
use drape_solvers::vector::{axpy, dot, norm};

/// A new direction shorter than this part of the product that it comes from is round-off: the
/// subspace is invariant, and the result exact.
const INVARIANT: f64 = 1e-14;
/// An error below this part of the result is round-off.
const ROUND_OFF: f64 = 1e-14;
/// A Taylor series is taken for matrices of at most this norm: where the norm is larger, terms
/// cancel.
const TAYLOR_NORM: f64 = 1.0;
/// For estimates of the error, where fewer digits count.
const ROUGH_NORM: f64 = 4.0;
/// A matrix beyond `m² + LARGE` needs more than `m` dimensions.
const LARGE: f64 = 4.0;
/// A matrix beyond this norm is never worth its Taylor series.
const HUGE: f64 = 1e6;
/// The error is estimated after this many new dimensions, or after an eighth of the present ones.
const BETWEEN_TESTS: usize = 4;

/// An orthonormal basis `V` of the Krylov subspace of `J` and `g`, with `J V_m = V_{m+1} H`.
#[derive(Debug)]
pub(crate) struct Krylov {
    most: usize,
    /// Numbers of a vector, in threes.
    size: usize,
    /// `m + 1` vectors, one after the other.
    basis: Vec<Vec3>,
    /// `H`, and functions of it.
    hessenberg: Series,
    /// `β = ‖g‖`.
    norm: f64,
    dimension: usize,
    is_invariant: bool,
    /// `φ_k(hH) e₁`.
    coefficients: Vec<f64>,
}

impl Krylov {
    pub(crate) fn new(size: usize, most: usize) -> Self {
        // No subspace has more dimensions than the space.
        let most = most.min(3 * size).max(1);
        Self {
            most,
            size,
            basis: vec![Vec3::zeros(); (most + 1) * size],
            hessenberg: Series::new(most),
            norm: 0.0,
            dimension: 0,
            is_invariant: true,
            coefficients: vec![0.0; most],
        }
    }

    /// Starts from `g`.
    pub(crate) fn begin(&mut self, g: &[Vec3]) {
        self.norm = norm(g);
        self.dimension = 0;
        self.is_invariant = self.norm == 0.0;
        for (v, g) in self.basis.iter_mut().zip(g) {
            *v = if self.norm > 0.0 { g / self.norm } else { Vec3::zeros() };
        }
    }

    /// Number of dimensions: the products that the subspace took.
    pub(crate) fn dimension(&self) -> usize {
        self.dimension
    }

    /// Adds dimensions until the error of `h² φ₂(hJ) g` is at most `tolerance · h`. When all are
    /// used it shortens `h` by halves instead, which needs no product: the subspace does not depend
    /// on `h`. Returns the step that it serves; `None` where that is shorter than `least`, or where
    /// numbers are not finite.
    pub(crate) fn serve(
        &mut self,
        mut h: f64,
        least: f64,
        tolerance: f64,
        mut product: impl FnMut(&[Vec3], &mut [Vec3]),
    ) -> Option<f64> {
        let mut test_at = BETWEEN_TESTS;
        while !self.is_invariant && self.dimension < self.most {
            if !self.norm.is_finite() || !self.extend(&mut product) {
                return None;
            }
            if self.is_invariant || self.dimension >= test_at || self.dimension == self.most {
                if self.is_good(h, tolerance) {
                    return Some(h);
                }
                test_at = self.dimension + BETWEEN_TESTS.max(self.dimension / 8);
            }
        }
        while !self.is_good(h, tolerance) {
            h *= 0.5;
            if h < least {
                return None;
            }
        }
        Some(h)
    }

    /// One step of Arnoldi's method with full orthogonalisation. Returns `false` for numbers that
    /// are not finite.
    fn extend(&mut self, product: &mut impl FnMut(&[Vec3], &mut [Vec3])) -> bool {
        let (m, size) = (self.dimension, self.size);
        let (known, rest) = self.basis.split_at_mut((m + 1) * size);
        let new = &mut rest[..size];
        product(&known[m * size..], new);
        let length = norm(new);
        let column = self.hessenberg.column(m);
        for (v, h) in known.chunks_exact(size).zip(&mut *column) {
            *h = dot(v, new);
            axpy(-*h, v, new);
        }
        let left = norm(new);
        column[m + 1] = left;
        self.dimension = m + 1;
        self.is_invariant = left <= INVARIANT * length;
        if !self.is_invariant {
            new.iter_mut().for_each(|v| *v /= left);
        }
        left.is_finite()
    }

    /// Whether the subspace gives `h² φ₂(hJ) g` to the tolerance; if so, it computes the
    /// coefficients.
    ///
    /// The error is about `β h³ h_{m+1,m} (e_mᵀ φ₃(hH) e₁) v_{m+1}` (Saad 1992).
    fn is_good(&mut self, h: f64, tolerance: f64) -> bool {
        let m = self.dimension;
        if m == 0 {
            return self.is_invariant; // there is nothing to compute
        }
        if !self.is_invariant {
            if !self.function(3, h) {
                return false;
            }
            let next = self.hessenberg.element(m, m - 1);
            let size = self.norm * h * h;
            let error = size * (h * next * self.coefficients[m - 1]).abs();
            let is_within = error <= (tolerance * h).max(ROUND_OFF * size);
            if !is_within {
                return false;
            }
        }
        self.function(2, h)
    }

    /// Writes `φ_k(hH) e₁` to the coefficients. Returns `false`, without computing it, where the
    /// matrix is so large that so few dimensions cannot be enough.
    fn function(&mut self, k: usize, h: f64) -> bool {
        let m = self.dimension;
        let size = 1.0 + h * self.hessenberg.norm(m);
        let is_hopeless = size > (m * m) as f64 + LARGE && !self.is_invariant;
        if is_hopeless || size.is_nan() || size > HUGE {
            return false;
        }
        let parts = (size / if k == 2 { TAYLOR_NORM } else { ROUGH_NORM }).ceil();
        let column = self.hessenberg.last_column([m, k], h, parts as u64);
        self.coefficients[..m].copy_from_slice(column);
        true
    }

    /// Calls `add` with each basis vector and its coefficient in `φ₂(hJ) g`.
    pub(crate) fn combine(&self, mut add: impl FnMut(f64, &[Vec3])) {
        let m = self.dimension;
        for (v, c) in self.basis.chunks_exact(self.size).zip(&self.coefficients[..m]) {
            add(c * self.norm, v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_oracle::Random;
    use nalgebra::DMatrix;

    /// `φ₂` of a dense matrix by a block exponential.
    fn second(a: &DMatrix<f64>) -> DMatrix<f64> {
        let n = a.nrows();
        let mut block = DMatrix::zeros(3 * n, 3 * n);
        block.view_mut((0, 0), (n, n)).copy_from(a);
        for k in 0..2 {
            block.view_mut((k * n, (k + 1) * n), (n, n)).fill_with_identity();
        }
        block.exp().view((0, 2 * n), (n, n)).into_owned()
    }

    fn flat(vectors: &[Vec3]) -> Vec<f64> {
        vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
    }

    /// A skew part of frequencies up to `size`, and some damping.
    fn matrix(n: usize, size: f64, random: &mut Random) -> DMatrix<f64> {
        let a = DMatrix::from_fn(n, n, |_, _| random.between(-1.0, 1.0));
        (&a - a.transpose() - &a * a.transpose() * 0.02) * (size / (n as f64).sqrt())
    }

    fn check(size: f64, most: usize, tolerance: f64) -> (usize, f64, f64) {
        let mut random = Random::new(4);
        let particles = 16;
        let a = matrix(3 * particles, size, &mut random);
        let g: Vec<Vec3> = (0..particles).map(|_| random.vector()).collect();
        let mut krylov = Krylov::new(particles, most);
        krylov.begin(&g);
        let product = |x: &[Vec3], y: &mut [Vec3]| {
            let out = &a * DMatrix::from_vec(3 * x.len(), 1, flat(x));
            for (y, out) in y.iter_mut().zip(out.as_slice().chunks_exact(3)) {
                *y = Vec3::new(out[0], out[1], out[2]);
            }
        };
        let h = krylov.serve(1.0, 1e-3, tolerance, product).expect("finite");
        let mut sum = vec![Vec3::zeros(); particles];
        krylov.combine(|c, v| axpy(c, v, &mut sum));
        let exact = second(&(&a * h)) * DMatrix::from_vec(3 * particles, 1, flat(&g));
        let found = DMatrix::from_vec(3 * particles, 1, flat(&sum));
        (krylov.dimension(), h, h * h * (found - exact).norm())
    }

    #[test]
    fn the_second_function_of_a_matrix_is_met_to_the_tolerance_and_to_round_off() {
        for size in [0.1, 1.0, 5.0] {
            for tolerance in [1e-3, 1e-6, 1e-9] {
                let (dimension, h, error) = check(size, 40, tolerance);
                assert_eq!(h, 1.0);
                assert!(error <= 3.0 * tolerance, "{size}, {tolerance}, {dimension}: {error:e}");
            }
        }
        let (dimension, h, error) = check(5.0, 48, 0.0);
        assert!(dimension <= 48 && h == 1.0 && error < 1e-12, "{dimension}: {error:e}");
    }

    #[test]
    fn a_subspace_that_is_too_small_serves_a_shorter_step() {
        let (dimension, h, error) = check(20.0, 12, 1e-6);
        assert!(dimension == 12 && h < 0.5 && h > 1e-3, "{h}");
        assert!(error <= 3e-6 * h, "{error:e}");
    }
}
