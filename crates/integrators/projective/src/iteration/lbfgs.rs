//! A quasi-Newton method with limited memory (Liu, Bouaziz, Kavan 2017).
//!
//! The plain iteration is a gradient method in the metric `A`. L-BFGS improves `A⁻¹` by what the
//! last `m` iterates tell of the Hessian:
//!
//! ```text
//! s_j = v^{j+1} − v^j             y_j = S∇Φ(v^{j+1}) − S∇Φ(v^j)       r_j = 1/(s_jᵀ y_j)
//! q ← S∇Φ(v^k);   newest to oldest:  a_j = r_j s_jᵀ q,  q ← q − a_j y_j
//! p ← A⁻¹ q;      oldest to newest:  p ← p + (a_j − r_j y_jᵀ p) s_j                    (P8)
//! v^{k+1} = v^k − t p,  t = 1, ½, ¼, …  until  Φ(v^{k+1}) ≤ Φ(v^k) − c t pᵀ S∇Φ(v^k)   (P9)
//! ```
//!
//! Pairs without positive curvature are left out, so that (P8) stays positive definite. Where no
//! `t` serves, the plain step does, by (P4). Near the minimum the decrease of `Φ` drowns in its
//! round-off. Then steps are full, and the pairs are dropped where a step leaves a gradient ten
//! times as large. A pair whose `y` is little more than round-off is not taken at all.

use super::{ENERGY_ROUND_OFF, Iterate};
use drape_model::Vec3;
use drape_solvers::vector::{axpy, dot, norm};

/// `c`, Armijo's constant.
const SUFFICIENT_DECREASE: f64 = 1e-4;
const MAX_HALVINGS: u32 = 30;
/// A predicted decrease below this fraction of `Φ` cannot be verified.
const RESOLUTION: f64 = 1e-12;
/// Greatest factor by which the gradient may grow in a step that is not verified.
const MOST_GROWTH: f64 = 10.0;
/// Least curvature `sᵀy` of a pair over `|s| |y|`.
const LEAST_CURVATURE: f64 = 1e-12;
/// Least change of the gradient over its round-off.
const LEAST_CHANGE: f64 = 1e3;

#[derive(Debug)]
pub(super) struct Lbfgs {
    /// `s_j`, m/s, and `y_j`, kg m/s, in rings.
    s: Vec<Vec<Vec3>>,
    y: Vec<Vec<Vec3>>,
    /// `1/(s_jᵀ y_j)` and `a_j`.
    inverse_curvature: Vec<f64>,
    a: Vec<f64>,
    known: usize,
    next: usize,
    /// `v^{k−1}`, m/s, and `S∇Φ` there, kg m/s.
    has_last: bool,
    last_velocity: Vec<Vec3>,
    last_gradient: Vec<Vec3>,
    q: Vec<Vec3>,
    direction: Vec<Vec3>,
    trial: Vec<Vec3>,
    /// `Φ(v^k)`, J, where it is known.
    value: Option<f64>,
    /// Whether the last step could not be verified.
    is_blind: bool,
}

impl Lbfgs {
    pub(super) fn new(n: usize, memory: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self {
            s: (0..memory).map(|_| zeros()).collect(),
            y: (0..memory).map(|_| zeros()).collect(),
            inverse_curvature: vec![0.0; memory],
            a: vec![0.0; memory],
            known: 0,
            next: 0,
            has_last: false,
            last_velocity: zeros(),
            last_gradient: zeros(),
            q: zeros(),
            direction: zeros(),
            trial: zeros(),
            value: None,
            is_blind: false,
        }
    }

    pub(super) fn begin(&mut self) {
        (self.has_last, self.value, self.is_blind) = (false, None, false);
        self.forget();
    }

    fn forget(&mut self) {
        (self.known, self.next) = (0, 0);
    }

    /// (P8) and (P9).
    #[doc(alias = "Liu-Bouaziz-Kavan 2017")]
    #[doc(alias = "L-BFGS")]
    pub(super) fn advance(&mut self, at: &mut Iterate<'_>) {
        if self.is_blind && norm(at.gradient) > MOST_GROWTH * norm(&self.last_gradient) {
            self.forget();
        } else if self.has_last {
            self.remember(at);
        }
        self.has_last = true;
        self.last_velocity.copy_from_slice(at.v);
        self.last_gradient.copy_from_slice(at.gradient);
        self.find_direction(at); // p, (P8)
        let present = match self.value {
            Some(value) => value,
            None => at.potential.value(at.system, at.v),
        };
        let slope = dot(&self.direction, at.gradient);
        self.is_blind = slope.abs() <= RESOLUTION * present.abs();
        if self.is_blind {
            self.value = None;
            axpy(-1.0, &self.direction, at.v);
            return;
        }
        let slack = ENERGY_ROUND_OFF * present.abs();
        let mut length = 1.0;
        for _ in 0..=if slope > 0.0 { MAX_HALVINGS } else { 0 } {
            for ((trial, v), p) in self.trial.iter_mut().zip(&*at.v).zip(&self.direction) {
                *trial = v - p * length;
            }
            let value = at.potential.value(at.system, &self.trial);
            if slope > 0.0 && value <= present - SUFFICIENT_DECREASE * length * slope + slack {
                self.value = Some(value);
                at.v.copy_from_slice(&self.trial); // (P9)
                return;
            }
            length *= 0.5;
        }
        self.forget();
        self.value = None;
        at.fixed_point_residual();
        axpy(1.0, at.residual, at.v); // (P3)
    }

    /// The two loops of (P8).
    fn find_direction(&mut self, at: &mut Iterate<'_>) {
        let memory = self.s.len();
        let newest = self.next + memory - 1;
        self.q.copy_from_slice(at.gradient);
        for j in (0..self.known).map(|age| (newest - age) % memory) {
            self.a[j] = self.inverse_curvature[j] * dot(&self.s[j], &self.q);
            axpy(-self.a[j], &self.y[j], &mut self.q);
        }
        at.metric.solve(&self.q, &mut self.direction, at.report);
        for j in (0..self.known).rev().map(|age| (newest - age) % memory) {
            let b = self.inverse_curvature[j] * dot(&self.y[j], &self.direction);
            axpy(self.a[j] - b, &self.s[j], &mut self.direction);
        }
    }

    /// Puts `v^k − v^{k−1}` and the change of the gradient in the place of the oldest pair.
    fn remember(&mut self, at: &mut Iterate<'_>) {
        let (s, y) = (&mut self.s[self.next], &mut self.y[self.next]);
        for i in 0..s.len() {
            s[i] = at.v[i] - self.last_velocity[i];
            y[i] = at.gradient[i] - self.last_gradient[i];
        }
        let curvature = dot(s, y);
        let is_convex = curvature > LEAST_CURVATURE * (dot(s, s) * dot(y, y)).sqrt();
        let size = at.potential.filtered_norm(&at.metric.at_rest, y);
        if is_convex && size > LEAST_CHANGE * at.potential.round_off() {
            self.inverse_curvature[self.next] = 1.0 / curvature;
            self.next = (self.next + 1) % self.s.len();
            self.known = (self.known + 1).min(self.s.len());
        } else {
            // The refused pair has overwritten the oldest one of a full ring.
            self.known = self.known.min(self.s.len() - 1);
        }
    }
}
