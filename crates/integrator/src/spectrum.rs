//! The largest eigenvalue of the stiffness, which limits every explicit step.

use crate::Implicit;
use drape_model::{BlockSink, Mat3, System, Tangent, Vec3};
use drape_solvers::vector::{dot, weighted_dot};

/// Estimates `λ_max(M⁻¹ K)`, 1/s², by power iteration, without a matrix; `K` is the Hessian of the potential
/// energy with each spring's block made positive semi-definite, so that compression does not hide the stiff modes.
///
/// The iteration starts from the vector of the last call: while the cloth changes slowly, two
/// products a call are enough. The Rayleigh quotient approaches `λ_max` from below.
#[derive(Clone, Debug)]
pub struct LargestEigenvalue {
    direction: Vec<Vec3>,
    product: Vec<Vec3>,
}

/// Adds `K p` without storing `K`.
struct Product<'a> {
    p: &'a [Vec3],
    out: &'a mut [Vec3],
}

impl BlockSink for Product<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        let f = block * (self.p[i] - self.p[j]);
        self.out[i] += f;
        self.out[j] -= f;
    }
}

impl LargestEigenvalue {
    /// Memory for a system, with a start vector that has a part in every mode.
    pub fn new(system: &System) -> Self {
        // Neighbours alternate in sign almost everywhere, as in the stiffest mode.
        let rough = |i: usize, k: usize| libm::sin(((3 * i + k) as f64 + 1.0) * 2.399_963);
        let direction = |i| Vec3::new(rough(i, 0), rough(i, 1), rough(i, 2));
        Self {
            direction: (0..system.len()).map(direction).collect(),
            product: vec![Vec3::zeros(); system.len()],
        }
    }

    /// `out ← K p` at `x`, N, for particles that are not pinned; 0 for those that are.
    fn multiply(&mut self, system: &System, x: &[Vec3]) {
        self.product.fill(Vec3::zeros());
        for (p, _) in self.direction.iter_mut().zip(system.pinned()).filter(|(_, pinned)| **pinned)
        {
            *p = Vec3::zeros();
        }
        let mut sink = Product { p: &self.direction, out: &mut self.product };
        for effect in Implicit::Everything.effects(system) {
            effect.add_stiffness(x, 1.0, Tangent::Projected, &mut sink);
        }
        for (f, _) in self.product.iter_mut().zip(system.pinned()).filter(|(_, pinned)| **pinned) {
            *f = Vec3::zeros();
        }
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
}
