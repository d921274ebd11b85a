//! An estimate and a bound of the largest eigenvalue of the stiffness. This eigenvalue limits every
//! explicit step.

use crate::Implicit;
use crate::random::Lcg;
use drape_model::{Effect, Level, Part, Revisions, System, Tangent, Vec3};
use drape_solvers::vector::{dot, weighted_dot};

/// Products between two checks of the estimate's growth in [`LargestEigenvalue::converge`].
const BATCH: usize = 10;
/// Growth over a batch, relative, at which the estimate counts as converged.
const CONVERGED: f64 = 0.01;
/// Most products of one [`LargestEigenvalue::converge`].
const MOST_PRODUCTS: usize = 200;

/// Estimates `λ_max(M⁻¹ K)`, 1/s², by power iteration, without a matrix. `K` is the Hessian of the
/// potential energy. The contribution of each spring or angle is made positive semi-definite, so
/// that compression does not hide the stiff modes.
///
/// The Rayleigh quotient approaches `λ_max` from below. The iteration starts from the vector of the
/// last call. While the cloth changes slowly, two products per call are enough.
#[derive(Clone, Debug)]
pub struct LargestEigenvalue {
    direction: Vec<Vec3>,
    product: Vec<Vec3>,
}

impl LargestEigenvalue {
    /// Memory for a system.
    pub fn new(system: &System) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let mut estimate = Self { direction: zeros(), product: zeros() };
        estimate.restart();
        estimate
    }

    /// Starts again from a random vector, which contains every mode. Call it after a change of the
    /// system, or after a jump of the state.
    pub fn restart(&mut self) {
        let mut random = Lcg::new();
        self.direction.fill_with(|| Vec3::from_fn(|_, _| random.signed()));
    }

    /// Iterates until ten products raise the estimate by less than 1 %, or until 200 products.
    /// Returns the estimate, 1/s², and the number of products.
    pub fn converge(&mut self, system: &System, x: &[Vec3]) -> (f64, usize) {
        let mut last = self.estimate(system, x, BATCH);
        let mut products = BATCH;
        while products < MOST_PRODUCTS {
            let next = self.estimate(system, x, BATCH);
            products += BATCH;
            let grows = next > last * (1.0 + CONVERGED);
            last = next;
            if !grows {
                break;
            }
        }
        (last, products)
    }

    /// `product ← K direction` at `x`, N; 0 for pinned particles.
    fn multiply(&mut self, system: &System, x: &[Vec3]) {
        system.clear_pinned(&mut self.direction);
        let (p, f) = (&self.direction, &mut self.product);
        Implicit::Everything.multiply_stiffness(system, x, Tangent::Projected, p, f);
        system.clear_pinned(&mut self.product);
    }

    /// The Rayleigh quotient after `products` products at `x`, 1/s²; 0 without springs.
    pub fn estimate(&mut self, system: &System, x: &[Vec3], products: usize) -> f64 {
        let mut quotient = 0.0;
        for _ in 0..products {
            self.multiply(system, x);
            let inertia = weighted_dot(system.mass(), &self.direction, &self.direction);
            if inertia > 0.0 {
                quotient = dot(&self.direction, &self.product) / inertia;
            }
            let size = dot(&self.product, &self.product).sqrt();
            if size > 0.0 && size.is_finite() {
                for ((p, f), m) in self.direction.iter_mut().zip(&self.product).zip(system.mass()) {
                    *p = f / (m * size);
                }
            }
        }
        quotient
    }

    /// The damping ratio `ζ = pᵀ D p / (2 √λ pᵀ M p)` of the direction `p` that the last
    /// [estimate](Self::estimate) `λ` led to, by the damping `D` of the springs at `x`; 0 without
    /// springs. The mode is critically damped for `ζ = 1`.
    pub fn damping_ratio(&mut self, system: &System, x: &[Vec3], eigenvalue: f64) -> f64 {
        system.clear_pinned(&mut self.direction);
        let Self { direction, product } = self;
        product.fill(Vec3::zeros());
        let springs = Implicit::Springs.effects(system).map(|effect| (effect, Part::Damping));
        system.add_forces(springs, Level { t: 0.0, x, v: direction }, product);
        system.clear_pinned(product);
        let inertia = weighted_dot(system.mass(), direction, direction);
        let ratio = -dot(direction, product) / (2.0 * eigenvalue.sqrt() * inertia);
        if ratio.is_finite() && ratio > 0.0 { ratio } else { 0.0 }
    }
}

/// Bounds `λ_max(M⁻¹ K)`, 1/s², at all positions. The bound depends on the system alone.
///
/// The Hessian of a spring is at most `k` in every direction, so `K ≤ L_k` at all positions. With
/// `d_i = Σ_j k_ij`, no eigenvalue of `M⁻¹ L_k` exceeds the greatest `d_i/m_i + d_j/m_j` of a
/// spring (Anderson and Morley's bound; a pinned end counts as infinitely heavy). On a grid of
/// springs along warp and weft it is `8 k/m`.
#[derive(Clone, Debug)]
pub struct StiffnessBound {
    stiffness_sums: Vec<f64>,
}

impl StiffnessBound {
    /// Memory for a system. `None` if an effect has a stiffness but no
    /// [linear split](drape_model::LinearSplit), because no bound is known at other positions.
    pub fn new(system: &System) -> Option<Self> {
        let is_known = |effect: &dyn Effect| {
            !effect.has_jacobian() || effect.split().is_some() || effect.is_drag()
        };
        system.effects().all(is_known).then(|| Self { stiffness_sums: vec![0.0; system.len()] })
    }

    /// The bound, 1/s²; 0 without springs.
    pub fn evaluate(&mut self, system: &System) -> f64 {
        laplacian_bound(system, &mut self.stiffness_sums, |k, _| k)
    }
}

/// Bounds `λ_max(M⁻¹ D)`, 1/s, of the springs' damping at all positions, in the same way as
/// [`StiffnessBound`]: `D ≤ L_c`, for full and for projected damping. Drag is not included.
#[derive(Clone, Debug)]
pub struct DampingBound {
    damping_sums: Vec<f64>,
    /// The present value, and its system.
    known: Option<(Revisions, f64)>,
}

impl DampingBound {
    /// Memory for a system.
    pub fn new(system: &System) -> Self {
        Self { damping_sums: vec![0.0; system.len()], known: None }
    }

    /// The bound, 1/s; 0 without damped springs. It is evaluated again if the system has changed.
    pub fn evaluate(&mut self, system: &System) -> f64 {
        let revisions = system.revisions();
        match self.known {
            Some((known_for, bound)) if known_for == revisions => bound,
            _ => {
                let bound = laplacian_bound(system, &mut self.damping_sums, |_, c| c);
                self.known = Some((revisions, bound));
                bound
            }
        }
    }
}

/// The greatest `d_i/m_i + d_j/m_j` of a spring, where `d_i` sums the weights of a particle's
/// springs.
fn laplacian_bound(system: &System, sums: &mut [f64], weight: fn(f64, f64) -> f64) -> f64 {
    sums.fill(0.0);
    Implicit::Springs.visit_weights(system, &mut |i, j, k, c| {
        sums[i] += weight(k, c);
        sums[j] += weight(k, c);
    });
    for ((sum, mass), pinned) in sums.iter_mut().zip(system.mass()).zip(system.pinned()) {
        *sum = if *pinned { 0.0 } else { *sum / mass };
    }
    let mut bound: f64 = 0.0;
    Implicit::Springs.visit_weights(system, &mut |i, j, _, _| {
        bound = bound.max(sums[i] + sums[j]);
    });
    bound
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::net;
    use drape_model::{EffectKind, State};

    /// A string of zero-length springs, `k/m` = 100, between two pins.
    fn string(free: usize) -> (System, State) {
        let mut random = Lcg::new();
        let x: Vec<_> = (0..free + 2).map(|_| Vec3::from_fn(|_, _| random.signed())).collect();
        let springs: Vec<_> = (0..=free).map(|i| (i, i + 1, 50.0, 0.0)).collect();
        net("tension", &vec![0.5; free + 2], &x, &springs, &[0, free + 1])
    }

    fn largest_of_string(free: usize) -> f64 {
        let half = 0.5 * std::f64::consts::PI * free as f64 / (free + 1) as f64;
        400.0 * libm::sin(half) * libm::sin(half)
    }

    #[test]
    fn the_estimate_rises_to_the_largest_eigenvalue_of_a_string() {
        let (system, state) = string(7);
        let exact = largest_of_string(7);
        let mut eigenvalue = LargestEigenvalue::new(&system);
        let mut last = 0.0;
        for _ in 0..200 {
            let estimate = eigenvalue.estimate(&system, &state.x, 1);
            assert!(estimate >= last - 1e-12 * exact && estimate < exact * (1.0 + 1e-12));
            last = estimate;
        }
        assert!((last / exact - 1.0).abs() < 1e-9, "{last} for {exact}");
    }

    #[test]
    fn a_converged_estimate_of_a_long_string_is_within_the_margin_of_five_percent() {
        let (system, state) = string(1000);
        let (estimate, products) = LargestEigenvalue::new(&system).converge(&system, &state.x);
        let share = estimate / largest_of_string(1000);
        assert!((0.95..=1.0).contains(&share) && products < 100, "{share} after {products}");
    }

    #[test]
    fn a_pair_has_the_reduced_mass_along_the_spring_and_nothing_across_when_compressed() {
        for length in [0.5, 1.0, 2.0] {
            let x = [Vec3::zeros(), Vec3::new(0.0, 0.6, 0.8) * length];
            let (system, state) = net("tension", &[1e-3, 10.0], &x, &[(0, 1, 7.0, 1.0)], &[]);
            let (estimate, _) = LargestEigenvalue::new(&system).converge(&system, &state.x);
            assert!((estimate / (7.0 * (1e3 + 0.1)) - 1.0).abs() < 1e-9, "{length}: {estimate}");
        }
    }

    #[test]
    fn nothing_stiff_nothing_free_and_nothing_finite_are_survived() {
        let (system, state) = net("tension", &[1.0, 2.0], &[Vec3::zeros(), Vec3::x()], &[], &[]);
        assert_eq!(LargestEigenvalue::new(&system).converge(&system, &state.x).0, 0.0);
        let (mut system, state) = string(3);
        let mut eigenvalue = LargestEigenvalue::new(&system);
        let broken = vec![Vec3::repeat(f64::NAN); system.len()];
        eigenvalue.converge(&system, &broken);
        let (after, _) = eigenvalue.converge(&system, &state.x);
        assert!((after / largest_of_string(3) - 1.0).abs() < 1e-3, "{after}");
        assert!((0..5).all(|i| system.set_pinned(i, true)));
        assert_eq!(eigenvalue.converge(&system, &state.x).0, 0.0);
        // Every part of the vector is 0 now.
        assert!((1..4).all(|i| system.set_pinned(i, false)));
        eigenvalue.restart();
        let fresh = LargestEigenvalue::new(&system).converge(&system, &state.x);
        assert_eq!(eigenvalue.converge(&system, &state.x), fresh);
    }

    #[test]
    fn the_bound_holds_at_all_positions_and_is_met_by_a_pair() {
        let mut random = Lcg::new();
        for case in 0..50 {
            let n = 12;
            let mass: Vec<f64> = (0..n).map(|_| libm::exp(3.0 * random.signed())).collect();
            let springs: Vec<_> = (1..n)
                .flat_map(|j| [(j - 1, j), (0, j)])
                .filter(|(i, j)| i != j)
                .map(|(i, j)| (i, j, libm::exp(2.0 * random.signed()), random.signed().abs()))
                .collect();
            let x: Vec<_> = (0..n).map(|_| Vec3::from_fn(|_, _| random.signed())).collect();
            let pinned: &[usize] = if case % 2 == 0 { &[] } else { &[0, 7] };
            let (system, state) = net("tension", &mass, &x, &springs, pinned);
            let bound = StiffnessBound::new(&system).expect("springs only").evaluate(&system);
            let estimate = LargestEigenvalue::new(&system).estimate(&system, &state.x, 500);
            assert!(estimate <= bound * (1.0 + 1e-12), "case {case}: {estimate} over {bound}");
            assert!(estimate > 0.2 * bound, "case {case}: {estimate} under {bound}");
        }
        let x = [Vec3::zeros(), Vec3::x()];
        let (mut system, _) = net("tension", &[0.5, 4.0], &x, &[(0, 1, 2.0, 1.0)], &[]);
        let mut bound = StiffnessBound::new(&system).expect("springs only");
        assert_eq!(bound.evaluate(&system), 4.5);
        assert!(system.set_pinned(0, true));
        assert_eq!(bound.evaluate(&system), 0.5);
        assert!(system.scale_stiffness(EffectKind::Tension, 3.0));
        assert_eq!(bound.evaluate(&system), 1.5);
        let (system, _) = net("tension", &[0.5, 4.0], &x, &[], &[]);
        assert_eq!(StiffnessBound::new(&system).map(|mut b| b.evaluate(&system)), Some(0.0));
    }

    #[test]
    fn the_damping_has_a_bound_of_its_own() {
        let text = r#"{ "format": "drape-system/1",
            "particles": { "mass_kg": [0.5, 4], "position_m": [[0, 0, 0], [1, 0, 0]] },
            "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
                "stiffness_n_per_m": 7, "damping_n_s_per_m": 2 }] }"#;
        let (mut system, _) =
            drape_model::parse("pair", text).expect("valid").spec().build().expect("valid");
        let mut bound = DampingBound::new(&system);
        assert_eq!([(); 2].map(|()| bound.evaluate(&system)), [4.5; 2]);
        assert!(system.set_pinned(0, true) && system.scale_damping(EffectKind::Tension, 3.0));
        assert_eq!(bound.evaluate(&system), 1.5);
    }
}
