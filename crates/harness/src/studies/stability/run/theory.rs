//! What the closed forms say: spectral radii of the methods on the oscillator, and the eigenvalues of the sheet.

use drape_integrator::Implicit;
use drape_model::{System, Vec3};
use drape_oracle::Random;
use drape_oracle::recurrence::{
    Multistep, adams_bashforth, backward_euler, bdf, desbrun, explicit_euler, imex_euler,
    kang_pair, leapfrog, spectral_radius, symplectic_euler, symplectic_euler_implicit_damping,
    terzopoulos_fleischer,
};

/// A spectral radius above 1 by no more than this is round-off.
const ROUND_OFF: f64 = 1e-9;
/// Bisections of a step: to the last digits.
const BISECTIONS: u32 = 60;
/// Products of a power iteration.
const PRODUCTS: usize = 500;

/// What a step multiplies the motion by in the long run, from `θ = h²κ` and `η = hδ`.
pub(super) type Radius = fn(theta: f64, eta: f64) -> f64;

/// The closed form of a method on springs of rest length 0.
pub(super) struct Theory {
    pub(super) label: &'static str,
    /// When a step is stable, in words.
    pub(super) rule: &'static str,
    pub(super) radius: Radius,
}

const fn theory(label: &'static str, rule: &'static str, radius: Radius) -> Theory {
    Theory { label, rule, radius }
}

const ALWAYS: &str = "every θ and η";

static THEORIES: [Theory; 21] = [
    theory("explicit-euler", "θ ≤ η and 2η ≤ 4 + θ", |t, e| {
        spectral_radius(&explicit_euler(t, e))
    }),
    theory("symplectic-euler", "θ + 2η < 4", |t, e| spectral_radius(&symplectic_euler(t, e))),
    theory("symplectic-euler, implicit damping", "θ < 4 + 2η", |t, e| {
        spectral_radius(&symplectic_euler_implicit_damping(t, e))
    }),
    theory("leapfrog", "θ < 4", |t, e| spectral_radius(&leapfrog(t, e))),
    // On springs within its limit.
    theory("provot", "θ + 2η < 4", |t, e| spectral_radius(&symplectic_euler(t, e))),
    theory("adams-bashforth2", "roots of ρ² + ηρσ + θσ²; undamped never", |t, e| {
        adams_bashforth(2, t, e).spectral_radius()
    }),
    theory(
        "adams-bashforth, 3 steps",
        "roots of ρ² + ηρσ + θσ²; undamped θ < 144/275",
        |t, e| adams_bashforth(3, t, e).spectral_radius(),
    ),
    theory("backward-euler", ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
    theory("bdf2", ALWAYS, |t, e| bdf(2, t, e).spectral_radius()),
    theory("baraff-witkin", ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
    theory("terzopoulos-fleischer", ALWAYS, |t, e| spectral_radius(&terzopoulos_fleischer(t, e))),
    theory("desbrun", ALWAYS, |t, e| spectral_radius(&desbrun(t, e))),
    theory("kang", ALWAYS, |t, e| spectral_radius(&kang_pair(0.5 * t, 0.5 * e, 1))),
    theory("imex-euler, as printed", ALWAYS, |t, e| spectral_radius(&imex_euler(t, 0.0, e))),
    theory(super::EXACT, ALWAYS, |t, e| spectral_radius(&imex_euler(t, 0.0, e))),
    theory("imex-updated", ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
    theory("imex-updated, as printed", ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
    theory("imex-sbdf2", ALWAYS, |t, e| two_step(&Multistep::sbdf2(1.0), t, e)),
    theory("imex-cnab2", ALWAYS, |t, e| two_step(&Multistep::cnab2(1.0), t, e)),
    theory("imex-mcnab2", ALWAYS, |t, e| two_step(&Multistep::mcnab2(1.0), t, e)),
    theory("imex-cnlf", ALWAYS, |t, e| two_step(&Multistep::cnlf(), t, e)),
];

fn two_step(method: &Multistep, theta: f64, eta: f64) -> f64 {
    method.recurrence(theta, 0.0, eta).spectral_radius()
}

pub(super) fn theory_of(label: &str) -> Option<&'static Theory> {
    THEORIES.iter().find(|theory| theory.label == label)
}

/// The longest of the steps from `range[0]` that are all admitted, up to the first that is not: to the last digits; 0 if
/// the first is not, `None` if all are. The range is searched by doubling.
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

impl Theory {
    /// Whether no oscillation of stiffness `κ` (1/s²) and damping `δ` (1/s) grows.
    pub(super) fn is_stable(&self, h: f64, stiffness: f64, damping: f64) -> bool {
        (self.radius)(h * h * stiffness, h * damping) <= 1.0 + ROUND_OFF
    }

    /// Factor by which an oscillation's energy grows over a number of steps.
    pub(super) fn growth(&self, h: f64, stiffness: f64, damping: f64, steps: f64) -> f64 {
        libm::pow((self.radius)(h * h * stiffness, h * damping), 2.0 * steps)
    }
}

/// A spring between two particles of a system.
struct Link {
    ends: [usize; 2],
    stiffness: f64,
    /// Direction in which it resists; `None`: in every one, as in the Laplacian.
    direction: Option<Vec3>,
}

/// Largest algebraic eigenvalue of `M⁻¹ Σ`, 1/s², with a sum of springs of either sign, on the particles that are
/// not pinned: by power iteration from a vector without a pattern, in a fixed order.
fn largest(system: &System, links: &[Link]) -> f64 {
    let mut rows = vec![0.0; system.len()];
    for link in links {
        for end in link.ends {
            rows[end] += 2.0 * link.stiffness.abs() / system.mass()[end];
        }
    }
    // All eigenvalues of the shifted matrix are positive, so that the greatest wins.
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

/// How a method with the tension springs in its matrix answers to the shear springs beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beside {
    /// IMEX Euler: the whole Laplacian resists, `4M + 2h² L_I − h² (K_I + K_E)` must be positive definite.
    Laplacian,
    /// Updated CG, which converges to backward Euler of its springs: only their tangents resist,
    /// `4M + h² K_I − h² K_E`, and those may vanish.
    Tangent,
}

/// Whether explicit shear outweighs implicit tension in some mode at a step `h`: at any positions, as far as the
/// Laplacians bound it, or at the given ones.
pub(super) fn outweighs(system: &System, x: &[Vec3], h: f64, beside: Beside, is_at: bool) -> bool {
    let mut sum = Vec::new();
    links(system, x, Implicit::Springs, 1.0, is_at, &mut sum);
    match (beside, is_at) {
        (Beside::Laplacian, _) => links(system, x, Implicit::Tension, -2.0, false, &mut sum),
        (Beside::Tangent, true) => links(system, x, Implicit::Tension, -2.0, true, &mut sum),
        // Without the tension springs.
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
            let theory = theory_of(label).unwrap();
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

    /// A sheet of structural springs approaches 8 k/m from below; diagonals do not raise its highest mode.
    #[test]
    fn the_largest_eigenvalue_lies_below_the_bound_and_the_explicit_share_below_a_half() {
        let sheet = Setting::with_shear(1e4, 0.0, 0.1).unwrap();
        let (system, x) = (&sheet.simulation.system, &sheet.simulation.state.x);
        let share = largest_eigenvalue(system, x) / 8e4;
        assert!((0.9..1.0).contains(&share), "{share}");
        // A mode along one direction only has 4 k of tension against 8 k_s of shear.
        for (ratio, expected) in [(0.4, false), (0.8, true)] {
            let sheet = Setting::with_shear(1e6, 0.0, ratio).unwrap();
            let (system, x) = (&sheet.simulation.system, &sheet.simulation.state.x);
            let outweighs = |beside| outweighs(system, x, 0.1, beside, false);
            assert_eq!(outweighs(Beside::Laplacian), expected, "{ratio}");
            // Nothing but the masses resists: h² 8 k_s/m is far above 4.
            assert!(outweighs(Beside::Tangent), "{ratio}");
        }
    }
}
