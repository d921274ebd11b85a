//! Anderson's acceleration (Peng et al. 2018).
//!
//! The plain iteration is a map `G(v) = v + f(v)`, whose fixed point is wanted. The method takes
//! the differences of the last `m` residuals, fits the present one by them, and applies the same
//! combination to the images:
//!
//! ```text
//! Δf_j = f^{j+1} − f^j            ΔG_j = G^{j+1} − G^j            j = k−m, …, k−1
//! θ    = argmin ‖f^k − Σ_j θ_j Δf_j‖_M                                                 (P6)
//! v^{k+1} = G^k − Σ_j θ_j ΔG_j    where Φ falls, else G^k                              (P7)
//! ```
//!
//! (P7) is a secant method for `f(v) = 0`. On its own it may diverge. The plain step lowers `Φ` by
//! (P4), so a step back to it keeps the descent; the differences are then dropped.

use super::{ENERGY_ROUND_OFF, Iterate};
use drape_model::Vec3;
use drape_solvers::vector::{axpy, weighted_dot};

/// A difference that the newer ones explain up to this part of its square adds nothing but
/// round-off.
const DEPENDENT: f64 = 1e-13;

#[derive(Debug)]
pub(super) struct Anderson {
    /// `Δf_j`, m/s, in a ring.
    residual_differences: Vec<Vec<Vec3>>,
    /// `ΔG_j`, m/s, likewise.
    image_differences: Vec<Vec<Vec3>>,
    /// `f^{k−1}` and `G^{k−1}`, m/s.
    has_last: bool,
    last_residual: Vec<Vec3>,
    last_image: Vec<Vec3>,
    image: Vec<Vec3>,
    candidate: Vec<Vec3>,
    /// Differences that are known, and the place of the next one.
    known: usize,
    next: usize,
    /// `Φ(v^k)`, J, where it is known.
    value: Option<f64>,
    fit: LeastSquares,
}

impl Anderson {
    pub(super) fn new(n: usize, memory: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self {
            residual_differences: (0..memory).map(|_| zeros()).collect(),
            image_differences: (0..memory).map(|_| zeros()).collect(),
            has_last: false,
            last_residual: zeros(),
            last_image: zeros(),
            image: zeros(),
            candidate: zeros(),
            known: 0,
            next: 0,
            value: None,
            fit: LeastSquares::new(memory),
        }
    }

    pub(super) fn begin(&mut self) {
        (self.has_last, self.value) = (false, None);
        self.forget();
    }

    fn forget(&mut self) {
        (self.known, self.next) = (0, 0);
    }

    /// (P6) and (P7).
    #[doc(alias = "Peng et al. 2018")]
    #[doc(alias = "Anderson 1965")]
    pub(super) fn advance(&mut self, at: &mut Iterate<'_>) {
        at.fixed_point_residual();
        for ((image, v), f) in self.image.iter_mut().zip(&*at.v).zip(&*at.residual) {
            *image = v + f; // G^k
        }
        if self.has_last {
            self.remember(at.residual);
        }
        self.has_last = true;
        self.last_residual.copy_from_slice(at.residual);
        self.last_image.copy_from_slice(&self.image);
        self.candidate.copy_from_slice(&self.image);
        if self.known > 0 {
            let mass = at.system.mass();
            let memory = self.residual_differences.len();
            let place = |age: usize| (self.next + memory - 1 - age) % memory; // newest first
            let (df, f) = (&self.residual_differences, &*at.residual);
            let product = |a: usize, b: usize| weighted_dot(mass, &df[place(a)], &df[place(b)]);
            let right = |a: usize| weighted_dot(mass, &df[place(a)], f);
            let theta = self.fit.solve(self.known, product, right); // (P6)
            for (age, theta) in theta.iter().enumerate() {
                axpy(-theta, &self.image_differences[place(age)], &mut self.candidate); // (P7)
            }
            let present = match self.value {
                Some(value) => value,
                None => at.potential.value(at.system, at.v),
            };
            let value = at.potential.value(at.system, &self.candidate);
            if value <= present + ENERGY_ROUND_OFF * present.abs() {
                self.value = Some(value);
                at.v.copy_from_slice(&self.candidate);
                return;
            }
            self.forget();
        }
        self.value = None;
        at.v.copy_from_slice(&self.image);
    }

    /// Puts `f^k − f^{k−1}` and `G^k − G^{k−1}` in the place of the oldest ones.
    fn remember(&mut self, residual: &[Vec3]) {
        let difference = |out: &mut [Vec3], new: &[Vec3], old: &[Vec3]| {
            out.iter_mut().zip(new).zip(old).for_each(|((out, new), old)| *out = new - old);
        };
        difference(&mut self.residual_differences[self.next], residual, &self.last_residual);
        difference(&mut self.image_differences[self.next], &self.image, &self.last_image);
        self.next = (self.next + 1) % self.residual_differences.len();
        self.known = (self.known + 1).min(self.residual_differences.len());
    }
}

/// A small problem of least squares by its normal equations, which Cholesky's method solves. A
/// column that depends on those before it gets the coefficient 0.
#[derive(Debug)]
struct LeastSquares {
    size: usize,
    factor: Vec<f64>,
    solution: Vec<f64>,
}

impl LeastSquares {
    fn new(size: usize) -> Self {
        Self { size, factor: vec![0.0; size * size], solution: vec![0.0; size] }
    }

    /// The coefficients of the first `count` columns, from their products with each other and with
    /// the right-hand side.
    fn solve(
        &mut self,
        count: usize,
        product: impl Fn(usize, usize) -> f64,
        right: impl Fn(usize) -> f64,
    ) -> &[f64] {
        let (l, x, n) = (&mut self.factor, &mut self.solution, self.size);
        for j in 0..count {
            for i in j..count {
                let known: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
                let square = product(i, j);
                let left = square - known;
                l[i * n + j] = match (i == j, l[j * n + j]) {
                    (true, _) if left > DEPENDENT * square => left.sqrt(),
                    (true, _) => 0.0,
                    (false, pivot) if pivot > 0.0 => left / pivot,
                    (false, _) => 0.0,
                };
            }
            let known: f64 = (0..j).map(|k| l[j * n + k] * x[k]).sum();
            let pivot = l[j * n + j];
            x[j] = if pivot > 0.0 { (right(j) - known) / pivot } else { 0.0 };
        }
        for j in (0..count).rev() {
            let known: f64 = (j + 1..count).map(|i| l[i * n + j] * x[i]).sum();
            let pivot = l[j * n + j];
            x[j] = if pivot > 0.0 { (x[j] - known) / pivot } else { 0.0 };
        }
        &x[..count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_fit_and_leave_out_what_depends_on_the_rest() {
        let columns = [[1.0, 2.0, 0.5], [2.0, 4.0, 1.0], [0.0, -1.0, 3.0]];
        let b = [1.0, 1.0, -2.0];
        let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut fit = LeastSquares::new(5);
        let x = fit.solve(3, |i, j| dot(&columns[i], &columns[j]), |i| dot(&columns[i], &b));
        assert_eq!(x[1], 0.0, "twice the first");
        let left: Vec<f64> =
            (0..3).map(|k| b[k] - x[0] * columns[0][k] - x[2] * columns[2][k]).collect();
        for column in &columns {
            let along: f64 = column.iter().zip(&left).map(|(a, b)| a * b).sum();
            assert!(along.abs() < 1e-14, "{along:e}");
        }
    }
}
