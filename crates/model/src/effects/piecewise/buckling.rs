//! The buckling of a strip of cloth that is compressed, after Choi and Ko (2002).
//!
//! A strip has the rest length `ℓ` and the flexural rigidity `B` (N m²). When its ends come closer
//! than its buckling load allows, it bends into an arc of a circle and keeps its length. With
//! `y = sinc⁻¹(L/ℓ)`, half of the angle of the arc, its ends push with
//!
//! ```text
//! T = (4 B/ℓ²) y²/(cos y − sinc y)      ≈  (4 B/ℓ²) P(L/ℓ)
//! P(x) = −11.541 x⁴ + 34.193 x³ − 39.083 x² + 23.116 x − 9.713
//! ```
//!
//! The paper gives the formula. The polynomial comes from the cloth solver of Blender, which calls
//! it `fb` and lets the user set the factor in front of it. The formula has values from 3 to 10;
//! the polynomial deviates from it by at most 0.16. drape uses the polynomial.
//!
//! Until it buckles the strip is a spring, `T = k (L − ℓ)`. It buckles at the greatest length at
//! which the spring would push as hard as the arc. At all shorter lengths it is an arc. A very soft
//! spring never buckles.
//!
//! `P` rises and is concave for `0 ≤ x ≤ 1`. So both parts of the curve rise, and the energy is
//! convex in `L`.

/// Coefficients of `P`, of rising powers.
const P: [f64; 5] = [-9.713, 23.116, -39.083, 34.193, -11.541];
/// Most iterations for the length at which it buckles; Newton's method takes about five.
const MOST: usize = 60;

/// Tension over the length below the rest length, for one rest length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Buckling {
    /// Stiffness before it buckles, N/m.
    stiffness: f64,
    /// `4 B/ℓ²`, N.
    load: f64,
    /// `(4 B/ℓ³) P'(0)`: the greatest slope of the buckled strip, at `L = 0`, N/m.
    steepest_buckled: f64,
    /// `L/ℓ` at which it buckles; 0: never.
    at: f64,
}

/// `P(x)`.
pub(super) fn polynomial(x: f64) -> f64 {
    P.iter().rev().fold(0.0, |sum, p| sum * x + p)
}

/// `P'(x)`.
fn derivative(x: f64) -> f64 {
    let terms = P.iter().enumerate().skip(1);
    terms.rev().fold(0.0, |sum, (power, p)| sum * x + power as f64 * p)
}

/// `∫ P dx` from 0.
fn integral(x: f64) -> f64 {
    let terms = P.iter().enumerate();
    terms.rev().fold(0.0, |sum, (power, p)| sum * x + p / (power as f64 + 1.0)) * x
}

impl Buckling {
    /// A strip with a stiffness (N/m) of at least 0, and a rigidity (N m²) and a rest length (m)
    /// above 0. If it is so short that its load is not finite,
    /// [`steepest_buckled`](Self::steepest_buckled) is not finite either.
    pub(crate) fn new(stiffness: f64, rigidity: f64, rest: f64) -> Self {
        let load = 4.0 * rigidity / (rest * rest);
        let steepest_buckled = load / rest * derivative(0.0);
        // The greatest root of g(x) = load P(x) − k ℓ (x − 1) below 1. g is concave and negative at
        // 1, and its tangents lie above it. If g falls, a tangent meets 0 between the root and the
        // last iterate, so Newton's method descends to the root without passing it. If g rises, or
        // the tangent meets 0 below 0, there is no root.
        let force = stiffness * rest;
        let mut at = 1.0;
        for _ in 0..MOST {
            let difference = load * polynomial(at) - force * (at - 1.0);
            let slope = load * derivative(at) - force;
            let next = at - difference / slope;
            if slope >= 0.0 || next <= 0.0 {
                at = 0.0;
                break;
            }
            if next >= at {
                break;
            }
            at = next;
        }
        Self { stiffness, load, steepest_buckled, at }
    }

    /// `T`, N.
    pub(crate) fn tension(&self, rest: f64, length: f64) -> f64 {
        let x = length / rest;
        if x < self.at { self.load * polynomial(x) } else { self.stiffness * (length - rest) }
    }

    /// `T'`, N/m.
    pub(crate) fn slope(&self, rest: f64, length: f64) -> f64 {
        let x = length / rest;
        if x < self.at { self.load / rest * derivative(x) } else { self.stiffness }
    }

    /// `U`, J: the integral of the tension, in closed form.
    pub(crate) fn energy(&self, rest: f64, length: f64) -> f64 {
        let x = length / rest;
        if x < self.at {
            let stretch = rest * (self.at - 1.0);
            let buckled = self.load * rest * (integral(x) - integral(self.at));
            0.5 * self.stiffness * stretch * stretch + buckled
        } else {
            let stretch = length - rest;
            0.5 * self.stiffness * stretch * stretch
        }
    }

    /// The greatest slope of the buckled strip, N/m.
    pub(crate) fn steepest_buckled(&self) -> f64 {
        self.steepest_buckled
    }

    /// The greatest slope, N/m.
    pub(crate) fn steepest(&self) -> f64 {
        if self.at > 0.0 { self.stiffness.max(self.steepest_buckled) } else { self.stiffness }
    }

    /// Multiplies all tensions.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.stiffness *= factor;
        self.load *= factor;
        self.steepest_buckled *= factor;
    }
}
