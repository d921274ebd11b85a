//! Jacobi sweeps from zero.

use drape_solvers::{ScalarMatrix, ScalarPcg, Vec3, vector::norm};

/// `Δv = D⁻¹ b`, (K2), then `sweeps` times `Δv ← D⁻¹ (b − (A − D) Δv)`, (K3): each particle is
/// corrected by its neighbours. `Δv` is 0 where `fixed` is set. Returns `‖b − A Δv‖/‖b‖` over the
/// free particles *before* the last sweep.
#[doc(alias = "Jacobi")]
#[doc(alias = "Kang-Choi-Cho 2000")]
pub(crate) fn sweep(
    (a, fast): (&ScalarMatrix, &mut ScalarPcg),
    b: &[Vec3],
    fixed: &[bool],
    sweeps: u32,
    product: &mut [Vec3],
    change: &mut [Vec3],
) -> f64 {
    for i in 0..b.len() {
        change[i] = if fixed[i] { Vec3::zeros() } else { b[i] / a.diagonal(i) };
    }
    let mut residual = 0.0;
    for sweep in 1..=sweeps {
        fast.multiply(a, change, product);
        for i in 0..b.len() {
            product[i] = if fixed[i] { Vec3::zeros() } else { b[i] - product[i] };
            change[i] += product[i] / a.diagonal(i);
        }
        if sweep == sweeps {
            residual = norm(product);
        }
    }
    let free = b.iter().zip(fixed).filter(|(_, fixed)| !**fixed);
    let size = free.map(|(b, _)| b.norm_squared()).sum::<f64>().sqrt();
    if residual > 0.0 { residual / size } else { residual }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_solvers::{LinearOperator, ScalarPreconditioner};

    fn chain(n: usize) -> ScalarMatrix {
        let mut a = ScalarMatrix::with_pattern(n, (1..n).map(|i| (i - 1, i)));
        (0..n).for_each(|i| a.add_diagonal(i, 1.0 + 0.25 * i as f64));
        (1..n).for_each(|i| a.add_edge(i - 1, i, 2.0 + 0.5 * i as f64));
        a
    }

    fn fast(a: &ScalarMatrix) -> ScalarPcg {
        let mut fast = ScalarPcg::new(a, true);
        fast.update(a, ScalarPreconditioner::Identity);
        fast
    }

    /// The published formula, written out particle by particle.
    #[test]
    fn one_correction_is_kangs_formula() {
        let (a, n) = (chain(5), 5);
        let b: Vec<Vec3> = (0..n).map(|i| Vec3::new(1.0, i as f64, -2.0 * i as f64)).collect();
        let fixed = [false, false, false, true, false];
        let (mut product, mut change) = (b.clone(), b.clone());
        sweep((&a, &mut fast(&a)), &b, &fixed, 1, &mut product, &mut change);
        let star = |j: usize| if fixed[j] { Vec3::zeros() } else { b[j] / a.diagonal(j) };
        for i in 0..n {
            let neighbours = (0..n).filter(|&j| j != i).map(|j| star(j) * -a.get(i, j));
            let sum = neighbours.fold(b[i], |sum, term| sum + term);
            let expected = if fixed[i] { Vec3::zeros() } else { sum / a.diagonal(i) };
            assert!((change[i] - expected).norm() < 1e-15, "particle {i}");
        }
    }

    #[test]
    fn many_corrections_solve_the_system_and_the_residual_says_so() {
        let a = chain(6);
        let b: Vec<Vec3> = (0..6).map(|i| Vec3::new(1.0, i as f64, 0.5)).collect();
        let fixed = [false; 6];
        let (mut product, mut change) = (b.clone(), b.clone());
        let mut last = f64::INFINITY;
        for sweeps in [1, 4, 16, 64] {
            let residual =
                sweep((&a, &mut fast(&a)), &b, &fixed, sweeps, &mut product, &mut change);
            assert!(residual < last, "{sweeps} sweeps: {residual}");
            last = residual;
        }
        a.multiply(&change, &mut product);
        let left = product.iter().zip(&b).map(|(p, b)| (p - b).norm()).fold(0.0, f64::max);
        assert!(left < 1e-3 && last < 1e-3, "{left:e}, {last:e}");
    }

    #[test]
    fn pinned_particles_have_no_part_in_the_residual() {
        let a = chain(6);
        let b: Vec<Vec3> = (0..6).map(|i| Vec3::new(1.0, i as f64, 0.5)).collect();
        let fixed = [false, false, false, true, false, false];
        let (mut product, mut change) = (b.clone(), b.clone());
        let residual = sweep((&a, &mut fast(&a)), &b, &fixed, 64, &mut product, &mut change);
        assert!(residual < 1e-3 && change[3] == Vec3::zeros(), "{residual:e}");
    }
}
