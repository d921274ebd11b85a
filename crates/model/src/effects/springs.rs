//! Linear springs with full or projected damping: tension, shear and bending `(i, i+2)`.

use super::{BlockSink, Effect, LinearSplit, Tangent};
use crate::{DampingLaw, Mat3, Vec3};

/// A spring shorter than this fraction of its rest length has no direction: `û = 0`, which is a
/// subgradient of the length, so that the energy theorem of the implicit-explicit split still holds.
const COLLAPSED: f64 = 1e-12;

/// One linear spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// First end.
    pub i: u32,
    /// Second end.
    pub j: u32,
    /// Rest length `ℓ`, m.
    pub rest_length: f64,
    /// Stiffness `k`, N/m.
    pub stiffness: f64,
    /// Damping coefficient `c` (EEH: d), N s/m.
    pub damping: f64,
}

impl Spring {
    fn ends(&self) -> (usize, usize) {
        (self.i as usize, self.j as usize)
    }

    /// `ℓ/L`, or 0 for a collapsed spring: then `−k(1 − ℓ/L) d` is the force in every case.
    fn rest_over_length(&self, length: f64) -> f64 {
        if length > COLLAPSED * self.rest_length { self.rest_length / length } else { 0.0 }
    }

    /// `d = x_i − x_j` and the direction `û = d/L`, which is 0 for a collapsed spring.
    fn direction(&self, x: &[Vec3]) -> Vec3 {
        let (i, j) = self.ends();
        let d = x[i] - x[j];
        let length = d.norm();
        if length > COLLAPSED * self.rest_length { d / length } else { Vec3::zeros() }
    }
}

/// All linear springs of one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSprings {
    name: &'static str,
    springs: Vec<Spring>,
    damping: Option<DampingLaw>,
}

impl LinearSprings {
    /// Springs that report under `name`. Without a damping coefficient above 0 no damping pass
    /// exists.
    pub fn new(name: &'static str, springs: Vec<Spring>, law: DampingLaw) -> Self {
        let damping = springs.iter().any(|s| s.damping > 0.0).then_some(law);
        Self { name, springs, damping }
    }

    /// The springs, in the order of the specification.
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }
}

impl Effect for LinearSprings {
    fn name(&self) -> &'static str {
        self.name
    }

    /// `U = Σ ½ k (L − ℓ)²`.
    fn energy(&self, _mass: &[f64], x: &[Vec3]) -> f64 {
        let energy = |s: &Spring| {
            let (i, j) = s.ends();
            let stretch = (x[i] - x[j]).norm() - s.rest_length;
            0.5 * s.stiffness * stretch * stretch
        };
        self.springs.iter().map(energy).sum()
    }

    /// `f_i = −k (L − ℓ) û`: the negative of EEH (11).
    #[doc(alias = "EEH 11")]
    fn add_force(&self, _mass: &[f64], x: &[Vec3], out: &mut [Vec3]) {
        for s in &self.springs {
            let (i, j) = s.ends();
            let d = x[i] - x[j];
            let f = d * (s.stiffness * (1.0 - s.rest_over_length(d.norm())));
            out[i] -= f;
            out[j] += f;
        }
    }

    fn has_damping(&self) -> bool {
        self.damping.is_some()
    }

    /// Full: `f_i = −c (v_i − v_j)`, the negative of EEH (14). Projected: `f_i = −c ûûᵀ(v_i − v_j)`.
    #[doc(alias = "EEH 14")]
    fn add_damping_force(&self, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]) {
        let Some(law) = self.damping else { return };
        for s in &self.springs {
            let (i, j) = s.ends();
            let rate = v[i] - v[j];
            let f = match law {
                DampingLaw::Full => rate * s.damping,
                DampingLaw::Projected => {
                    let u = s.direction(x);
                    u * (s.damping * u.dot(&rate))
                }
            };
            out[i] -= f;
            out[j] += f;
        }
    }

    fn has_jacobian(&self) -> bool {
        true
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        for s in &self.springs {
            let (i, j) = s.ends();
            visit(i, j);
        }
    }

    /// `−∂f_i/∂x_i = k [ûûᵀ + (1 − ℓ/L)(I − ûûᵀ)]`: eigenvalues `k` along the spring and
    /// `k (1 − ℓ/L)`, twice, across it; the latter are negative exactly when it is compressed.
    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink) {
        for s in &self.springs {
            let (i, j) = s.ends();
            let d = x[i] - x[j];
            let length = d.norm();
            let transverse = match (1.0 - s.rest_over_length(length), tangent) {
                (t, Tangent::Exact) => t,
                (t, Tangent::Projected) => t.max(0.0),
            };
            let u = s.direction(x);
            let block = (u * u.transpose() * (1.0 - transverse)
                + Mat3::from_diagonal_element(transverse))
                * (scale * s.stiffness);
            sink.add_pair(i, j, &block);
        }
    }

    fn add_damping(&self, x: &[Vec3], scale: f64, sink: &mut dyn BlockSink) {
        let Some(law) = self.damping else { return };
        for s in &self.springs {
            let (i, j) = s.ends();
            let block = match law {
                DampingLaw::Full => Mat3::from_diagonal_element(scale * s.damping),
                DampingLaw::Projected => {
                    let u = s.direction(x);
                    u * u.transpose() * (scale * s.damping)
                }
            };
            sink.add_pair(i, j, &block);
        }
    }

    fn split(&self) -> Option<&dyn LinearSplit> {
        Some(self)
    }

    fn scale_stiffness(&mut self, factor: f64) -> bool {
        self.springs.iter_mut().for_each(|s| s.stiffness *= factor);
        true
    }

    fn scale_damping(&mut self, factor: f64) -> bool {
        self.springs.iter_mut().for_each(|s| s.damping *= factor);
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

impl LinearSplit for LinearSprings {
    fn visit_weights(&self, visit: &mut dyn FnMut(usize, usize, f64, f64)) {
        for s in &self.springs {
            let (i, j) = s.ends();
            visit(i, j, s.stiffness, s.damping);
        }
    }

    fn visit_rest_lengths(&self, visit: &mut dyn FnMut(usize, usize, f64)) {
        for s in &self.springs {
            let (i, j) = s.ends();
            visit(i, j, s.rest_length);
        }
    }

    fn visit_secants(&self, x: &[Vec3], visit: &mut dyn FnMut(usize, usize, f64)) {
        for s in &self.springs {
            let (i, j) = s.ends();
            let length = (x[i] - x[j]).norm();
            visit(i, j, s.stiffness * (1.0 - s.rest_over_length(length)));
        }
    }

    /// `F2_i = +k ℓ û`: constant in size, the negative of EEH (13).
    #[doc(alias = "EEH 13")]
    fn add_nonlinear_force(&self, x: &[Vec3], out: &mut [Vec3]) {
        for s in &self.springs {
            let (i, j) = s.ends();
            let d = x[i] - x[j];
            let f = d * (s.stiffness * s.rest_over_length(d.norm()));
            out[i] += f;
            out[j] -= f;
        }
    }

    fn add_damping_remainder(&self, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]) {
        if self.damping != Some(DampingLaw::Projected) {
            return;
        }
        for s in &self.springs {
            let (i, j) = s.ends();
            let rate = v[i] - v[j];
            let u = s.direction(x);
            let f = (rate - u * u.dot(&rate)) * s.damping;
            out[i] += f;
            out[j] -= f;
        }
    }
}
