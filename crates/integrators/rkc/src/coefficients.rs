//! The coefficients of the method, and its stability polynomial.

use nalgebra::Complex;

/// Damping of the stability polynomial, `ε`.
const EPSILON: f64 = 2.0 / 13.0;
/// Most stages of a substep.
pub(crate) const MOST_STAGES: u32 = 200;

/// Coefficients of stage `j`, (R4).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stage {
    /// `μ_j`.
    pub(crate) mu: f64,
    /// `ν_j`.
    pub(crate) nu: f64,
    /// `μ̃_j`.
    pub(crate) mu_tilde: f64,
    /// `γ̃_j`.
    pub(crate) gamma_tilde: f64,
    /// `c_{j−1}`: the force of stage `j` belongs to `t_n + c_{j−1} h`.
    pub(crate) time: f64,
}

/// The coefficients for one number of stages.
#[derive(Debug)]
pub(crate) struct Coefficients {
    /// `μ̃₁`, (R3).
    pub(crate) first: f64,
    /// Stages 2 to `s`, (R4).
    pub(crate) stages: Vec<Stage>,
    w0: f64,
    w1: f64,
    /// `a_s` and `b_s`.
    last: (f64, f64),
}

/// `T_j(w₀)` and its first two derivatives.
#[derive(Clone, Copy)]
struct Chebyshev([f64; 3]);

impl Chebyshev {
    /// From the two before, (R1).
    fn next(w0: f64, [a, b]: [Self; 2]) -> Self {
        let (Self([t, d, e]), Self([t_old, d_old, e_old])) = (b, a);
        let value = 2.0 * w0 * t - t_old;
        let slope = 2.0 * (t + w0 * d) - d_old;
        Self([value, slope, 4.0 * d + 2.0 * w0 * e - e_old])
    }

    /// `b_j`, (R2).
    fn weight(self) -> f64 {
        let Self([_, d, e]) = self;
        e / (d * d)
    }
}

impl Coefficients {
    /// Memory for any number of stages, filled for `stages`.
    pub(crate) fn new(stages: u32) -> Self {
        let room = Vec::with_capacity(MOST_STAGES as usize);
        let mut new = Self { first: 0.0, stages: room, w0: 0.0, w1: 0.0, last: (0.0, 0.0) };
        new.set(stages);
        new
    }

    /// Number of stages, `s`.
    pub(crate) fn count(&self) -> u32 {
        self.stages.len() as u32 + 1
    }

    /// Fills the coefficients for `s ≥ 2` stages.
    pub(crate) fn set(&mut self, s: u32) {
        if self.count() == s {
            return;
        }
        let w0 = 1.0 + EPSILON / f64::from(s * s);
        let start = [Chebyshev([1.0, 0.0, 0.0]), Chebyshev([w0, 1.0, 0.0])];
        let pair = (1..s).fold(start, |pair, _| [pair[1], Chebyshev::next(w0, pair)]);
        let Chebyshev([_, d, e]) = pair[1];
        let w1 = d / e; // T_s'(w₀)/T_s''(w₀), (R1)
        let second = Chebyshev::next(w0, start).weight(); // b₀ = b₁ = b₂, (R2)
        self.stages.clear();
        self.first = second * w1; // μ̃₁ = b₁ w₁, (R3)
        let (mut pair, mut b) = (start, [second, second]); // b_{j−2}, b_{j−1}
        let mut a = 1.0 - second * w0; // a_{j−1} = 1 − b_{j−1} T_{j−1}(w₀)
        let mut time = self.first; // c₁
        for _ in 2..=s {
            let new = Chebyshev::next(w0, pair);
            let Chebyshev([t, d, e]) = new;
            let b_j = new.weight();
            let mu_tilde = 2.0 * b_j * w1 / b[1];
            self.stages.push(Stage {
                mu: 2.0 * b_j * w0 / b[1],
                nu: -b_j / b[0],
                mu_tilde,
                gamma_tilde: -a * mu_tilde,
                time,
            });
            (a, time) = (1.0 - b_j * t, w1 * e / d);
            self.last = (a, b_j);
            (pair, b) = ([pair[1], new], [b[1], b_j]);
        }
        (self.w0, self.w1) = (w0, w1);
    }

    /// `P_s(z) = a_s + b_s T_s(w₀ + w₁ z)`, (R5).
    pub(crate) fn polynomial(&self, z: Complex<f64>) -> Complex<f64> {
        let argument = z * self.w1 + self.w0;
        let (mut before, mut value) = (Complex::new(1.0, 0.0), argument);
        for _ in 1..self.count() {
            (before, value) = (value, argument * value * 2.0 - before);
        }
        value * self.last.1 + self.last.0
    }

    /// Whether a substep of `h` seconds is stable on the oscillator with stiffness `κ` (1/s²) and
    /// damping `δ` (1/s).
    pub(crate) fn is_stable(&self, h: f64, stiffness: f64, damping: f64) -> bool {
        let (theta, half) = (h * h * stiffness, 0.5 * h * damping);
        let discriminant = half * half - theta;
        let root = discriminant.abs().sqrt();
        let is_inside = |z: Complex<f64>| self.polynomial(z).norm_sqr() <= 1.0 + ROUND_OFF;
        if discriminant < 0.0 {
            is_inside(Complex::new(-half, root))
        } else {
            // (−half + root) without cancellation: the roots multiply to θ.
            let fast = -half - root;
            let slow = if fast == 0.0 { 0.0 } else { theta / fast };
            is_inside(Complex::new(fast, 0.0)) && is_inside(Complex::new(slow, 0.0))
        }
    }
}

/// Of the square of the polynomial.
const ROUND_OFF: f64 = 1e-10;
