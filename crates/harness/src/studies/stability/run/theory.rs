//! The longest stable step in theory, and the eigenvalues of the sheet.

use drape_integrator::Implicit;
use drape_model::{System, Vec3};
use drape_oracle::Random;

/// Number of bisections of a step: enough for all digits.
const BISECTIONS: u32 = 60;
/// Number of products of a power iteration.
const PRODUCTS: usize = 500;

/// The longest step up to which every step in the range is admitted, to the last digits. Doubling
/// searches the range. Returns 0 if the first step is not admitted, and `None` if all are.
pub(super) fn longest(range: [f64; 2], admits: impl Fn(f64) -> bool) -> Option<f64> {
    let mut good = range[0];
    if !admits(good) {
        return Some(0.0);
    }
    let mut bad = 2.0 * good;
    while admits(bad) {
        if bad >= range[1] {
            return None;
        }
        (good, bad) = (bad, 2.0 * bad);
    }
    for _ in 0..BISECTIONS {
        let middle = (good * bad).sqrt();
        if admits(middle) { good = middle } else { bad = middle }
    }
    Some(good)
}

/// A spring between two particles of a system.
struct Link {
    ends: [usize; 2],
    stiffness: f64,
    /// Direction in which the spring resists. `None` means every direction, as in the Laplacian.
    direction: Option<Vec3>,
}

/// Largest algebraic eigenvalue of `M⁻¹ Σ`, 1/s², on the particles that are not pinned. `Σ` is a
/// sum of springs of either sign. A power iteration starts from a vector without a pattern and sums
/// in a fixed order.
fn largest(system: &System, links: &[Link]) -> f64 {
    let mut rows = vec![0.0; system.len()];
    for link in links {
        for end in link.ends {
            rows[end] += 2.0 * link.stiffness.abs() / system.mass()[end];
        }
    }
    // The shift makes all eigenvalues positive, so the greatest one dominates.
    let shift = rows.iter().copied().fold(0.0, f64::max);
    let mut random = Random::new(1);
    let mut p: Vec<Vec3> = (0..system.len()).map(|_| random.vector()).collect();
    let mut value = 0.0;
    for _ in 0..PRODUCTS {
        system.clear_pinned(&mut p);
        let mut product: Vec<Vec3> =
            p.iter().zip(system.mass()).map(|(p, m)| p * (shift * m)).collect();
        for Link { ends: [i, j], stiffness, direction } in links {
            let relative = p[*i] - p[*j];
            let pull = match direction {
                Some(u) => u * (stiffness * u.dot(&relative)),
                None => relative * *stiffness,
            };
            product[*i] += pull;
            product[*j] -= pull;
        }
        let (mut inertia, mut work, mut size) = (0.0, 0.0, 0.0);
        for ((p, q), (m, pinned)) in
            p.iter().zip(&mut product).zip(system.mass().iter().zip(system.pinned()))
        {
            if *pinned {
                *q = Vec3::zeros();
            }
            inertia += m * p.norm_squared();
            work += p.dot(q);
            *q /= *m;
            size += q.norm_squared();
        }
        value = work / inertia - shift;
        let size = size.sqrt();
        p = product.into_iter().map(|q| q / size).collect();
    }
    value
}

fn links(
    system: &System,
    x: &[Vec3],
    which: Implicit,
    factor: f64,
    is_tangent: bool,
    into: &mut Vec<Link>,
) {
    which.visit_weights(system, &mut |i, j, k, _| {
        let direction = is_tangent.then(|| (x[i] - x[j]).normalize());
        into.push(Link { ends: [i, j], stiffness: factor * k, direction });
    });
}

/// Largest eigenvalue of `M⁻¹ L_k`, 1/s².
pub(super) fn largest_eigenvalue(system: &System, x: &[Vec3]) -> f64 {
    let mut all = Vec::new();
    links(system, x, Implicit::Springs, 1.0, false, &mut all);
    largest(system, &all)
}

/// How the implicit tension springs of a method resist the explicit shear springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beside {
    /// IMEX Euler: the whole Laplacian resists. `4M + 2h² L_I − h² (K_I + K_E)` must be positive
    /// definite.
    Laplacian,
    /// Updated CG, which converges to backward Euler of its implicit springs. Only their tangents
    /// resist, `4M + h² K_I − h² K_E`, and these may vanish.
    Tangent,
}

/// Whether explicit shear outweighs implicit tension in some mode at a step `h` (s). With `is_at`
/// the answer is for the positions `x`; otherwise it is for any positions, as far as Laplacians
/// bound it.
pub(super) fn outweighs(system: &System, x: &[Vec3], h: f64, beside: Beside, is_at: bool) -> bool {
    let mut sum = Vec::new();
    links(system, x, Implicit::Springs, 1.0, is_at, &mut sum);
    match (beside, is_at) {
        (Beside::Laplacian, _) => links(system, x, Implicit::Tension, -2.0, false, &mut sum),
        (Beside::Tangent, true) => links(system, x, Implicit::Tension, -2.0, true, &mut sum),
        // The explicit springs alone, without the tension springs.
        (Beside::Tangent, false) => links(system, x, Implicit::Tension, -1.0, false, &mut sum),
    }
    h * h * largest(system, &sum) > 4.0
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::super::sheet::Setting;
    use super::*;

    #[test]
    fn limits_are_those_of_the_rules() {
        let of = |label: &str, damping: f64| {
            let theory = crate::theory::form_of(label).and_then(|form| form.limit).unwrap();
            longest([1e-4, 8.0], |h| theory.is_stable(h, 100.0, damping))
        };
        let close =
            |a: Option<f64>, b: f64| assert!((a.unwrap() / b - 1.0).abs() < 1e-4, "{a:?} {b}");
        close(of("leapfrog", 0.0), 0.2);
        close(of("leapfrog", 7.0), 0.2);
        // 100 h² + 2 · 15 h = 4.
        close(of("symplectic-euler", 15.0), 0.1);
        close(of("symplectic-euler, implicit damping", 15.0), 0.4);
        close(of("explicit-euler", 2.0), 0.02);
        close(of("adams-bashforth, 3 steps", 0.0), (144.0_f64 / 275.0).sqrt() / 10.0);
        assert_eq!(of("explicit-euler", 0.0), Some(0.0));
        assert_eq!(of("backward-euler", 0.0), None);
        assert_eq!(of("imex-cnlf", 0.0), None);
    }

    /// A sheet of structural springs approaches 8 k/m from below; diagonals do not raise its
    /// highest mode.
    #[test]
    fn the_largest_eigenvalue_lies_below_the_bound_and_the_explicit_share_below_a_half() {
        let sheet = Setting::with_shear(1e4, 0.0, 0.1).unwrap();
        let (system, x) = (&sheet.simulation.system, &sheet.simulation.state.x);
        let share = largest_eigenvalue(system, x) / 8e4;
        assert!((0.9..1.0).contains(&share), "{share}");
        // A mode along one direction has only 4 k of tension against 8 k_s of shear.
        for (ratio, expected) in [(0.4, false), (0.8, true)] {
            let sheet = Setting::with_shear(1e6, 0.0, ratio).unwrap();
            let (system, x) = (&sheet.simulation.system, &sheet.simulation.state.x);
            let outweighs = |beside| outweighs(system, x, 0.1, beside, false);
            assert_eq!(outweighs(Beside::Laplacian), expected, "{ratio}");
            // Only the masses resist, and h² 8 k_s/m is far above 4.
            assert!(outweighs(Beside::Tangent), "{ratio}");
        }
    }
}
