//! Solvers for matrices that need not be symmetric, for the full system of section 2.3.

use drape_solvers::vector::{axpy, dot, norm, subtract_from};
use drape_solvers::{LinearOperator, Vec3};

/// Most iterations.
const MOST: usize = 5_000;

/// BiCGStab (van der Vorst 1992) from zero until `‖b − A x‖ ≤ tolerance ‖b‖`; returns the products
/// with the matrix, or `None` where it breaks down or does not get there.
pub(super) fn bicgstab(
    a: &impl LinearOperator,
    b: &[Vec3],
    x: &mut [Vec3],
    tolerance: f64,
) -> Option<usize> {
    let zeros = || vec![Vec3::zeros(); b.len()];
    x.fill(Vec3::zeros());
    let (mut r, mut p, mut q, mut t) = (b.to_vec(), b.to_vec(), zeros(), zeros());
    let shadow = r.clone();
    let goal = tolerance * norm(b);
    let mut rho = dot(&shadow, &r);
    for iteration in 0..MOST {
        let size = norm(&r);
        if size <= goal {
            return Some(2 * iteration);
        }
        if !size.is_finite() {
            return None;
        }
        a.multiply(&p, &mut q);
        let alpha = rho / dot(&shadow, &q);
        axpy(-alpha, &q, &mut r);
        axpy(alpha, &p, x);
        a.multiply(&r, &mut t);
        let omega = dot(&t, &r) / dot(&t, &t).max(f64::MIN_POSITIVE);
        axpy(omega, &r, x);
        axpy(-omega, &t, &mut r);
        let next = dot(&shadow, &r);
        let beta = next / rho * (alpha / omega);
        rho = next;
        for i in 0..p.len() {
            p[i] = r[i] + (p[i] - q[i] * omega) * beta;
        }
    }
    None
}

/// Dense elimination with row exchanges of an operator that acts on the three coordinates alike.
pub(super) struct Elimination {
    /// `L` below the diagonal, `U` on and above it, row by row.
    rows: Vec<Vec<f64>>,
    /// Which row of the operator stands where.
    order: Vec<usize>,
}

impl Elimination {
    pub(super) fn new(a: &impl LinearOperator) -> Self {
        let n = a.size();
        let (mut unit, mut column) = (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
        let mut rows = vec![vec![0.0; n]; n];
        for j in 0..n {
            unit[j].x = 1.0;
            a.multiply(&unit, &mut column);
            unit[j].x = 0.0;
            rows.iter_mut().zip(&column).for_each(|(row, c)| row[j] = c.x);
        }
        let mut order: Vec<_> = (0..n).collect();
        for k in 0..n {
            let size = |i: &usize| rows[*i][k].abs();
            let pivot = (k..n).max_by(|i, j| size(i).total_cmp(&size(j))).unwrap_or(k);
            rows.swap(k, pivot);
            order.swap(k, pivot);
            let (above, below) = rows.split_at_mut(k + 1);
            let pivot = &above[k];
            for row in below.iter_mut().filter(|row| row[k] != 0.0) {
                row[k] /= pivot[k];
                let factor = row[k];
                let rest = row[k + 1..].iter_mut().zip(&pivot[k + 1..]);
                rest.for_each(|(entry, p)| *entry -= factor * p);
            }
        }
        Self { rows, order }
    }

    fn apply(&self, b: &[Vec3]) -> Vec<Vec3> {
        let mut x: Vec<_> = self.order.iter().map(|&i| b[i]).collect();
        for i in 0..x.len() {
            let known = self.rows[i][..i].iter().zip(&x[..i]);
            x[i] = known.fold(x[i], |rest, (l, x)| rest - x * *l);
        }
        for i in (0..x.len()).rev() {
            let known = self.rows[i][i + 1..].iter().zip(&x[i + 1..]);
            x[i] = known.fold(x[i], |rest, (u, x)| rest - x * *u) / self.rows[i][i];
        }
        x
    }

    /// `A⁻¹ b`, refined twice by the residual.
    pub(super) fn solve(&self, a: &impl LinearOperator, b: &[Vec3]) -> Vec<Vec3> {
        let mut x = self.apply(b);
        let mut r = x.clone();
        for _ in 0..2 {
            a.multiply(&x, &mut r);
            subtract_from(b, &mut r);
            axpy(1.0, &self.apply(&r), &mut x);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `(1, −2; 3, 4)`: not symmetric, and elimination exchanges its rows.
    struct Small;

    impl LinearOperator for Small {
        fn size(&self) -> usize {
            2
        }

        fn multiply(&self, x: &[Vec3], y: &mut [Vec3]) {
            (y[0], y[1]) = (x[0] - x[1] * 2.0, x[0] * 3.0 + x[1] * 4.0);
        }
    }

    #[test]
    fn both_solvers_find_the_known_solution() {
        let b = [Vec3::new(-3.0, 0.0, 1.0), Vec3::new(11.0, 0.0, 3.0)];
        let known = [Vec3::new(1.0, 0.0, 1.0), Vec3::new(2.0, 0.0, 0.0)];
        let mut x = vec![Vec3::zeros(); 2];
        assert!(bicgstab(&Small, &b, &mut x, 1e-12).is_some());
        let direct = Elimination::new(&Small).solve(&Small, &b);
        for ((x, direct), known) in x.iter().zip(&direct).zip(&known) {
            assert!((x - known).norm() < 1e-10 && (direct - known).norm() < 1e-15);
        }
    }
}
