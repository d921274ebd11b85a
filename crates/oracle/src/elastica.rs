//! The heavy elastica: an inextensible strip that is clamped horizontally at one end and bends
//! under its own weight.
//!
//! With the arc length `s` from the clamp over the free length `L`, the slope `θ` below the
//! horizontal, the areal density `ρ` and the bending rigidity `B` per width, the moments balance as
//!
//! ```text
//! θ'' = −Γ (1 − s) cos θ       θ(0) = 0       θ'(1) = 0       Γ = ρ g L³/B
//! ```
//!
//! So `Γ` alone determines how far the strip bends. The ratio `H/W` of the drop of the free end to
//! its reach is one curve over `Γ`, the *master curve* of cantilever tests (V. Romero, M. Ly, A. H.
//! Rasheed, R. Charrondière, A. Lazarus, S. Neukirch, F. Bertails-Descoubes 2021, *Physical
//! validation of simulators in computer graphics*, ACM Transactions on Graphics 40(4), 66,
//! doi:10.1145/3450626.3459931). The textile standard (Peirce 1930; ASTM D1388) is the point
//! `Γ = 8` of this curve: there the chord falls at 41.5°, and half of `L` is the bending length.
//!
//! This module integrates the equation from the free end by Runge and Kutta's method, and finds the
//! slope at the free end by bisection.

/// Steps of the integration; the error of `H/W` is below 1e-12.
const STEPS: usize = 2000;
/// Halvings of the interval that holds the slope of the free end.
const HALVINGS: usize = 60;

/// The shape of a strip, in units of its free length.
#[derive(Clone, Debug, PartialEq)]
pub struct Cantilever {
    /// Reach and height (negative below the clamp) at equal steps of the arc length, from 0 at the
    /// clamp to 1.
    pub places: Vec<[f64; 2]>,
    /// Slope below the horizontal at the same places, rad.
    pub slope: Vec<f64>,
}

impl Cantilever {
    /// Drop of the free end over its reach, `H/W`.
    pub fn drop_over_reach(&self) -> f64 {
        self.places.last().map_or(0.0, |[reach, height]| -height / reach)
    }

    /// Reach and height at an arc length from 0 to 1, by linear interpolation. For negative arc
    /// lengths the strip is straight.
    pub fn at(&self, s: f64) -> [f64; 2] {
        if s <= 0.0 {
            return [s, 0.0];
        }
        let steps = self.places.len() - 1;
        let position = (s * steps as f64).min(steps as f64);
        let k = (position as usize).min(steps - 1);
        let part = position - k as f64;
        [0, 1].map(|axis| {
            let (a, b) = (self.places[k][axis], self.places[k + 1][axis]);
            a + (b - a) * part
        })
    }
}

/// Slopes from the free end to the clamp, if the free end has the slope `end`.
fn slopes(gamma: f64, end: f64) -> Vec<f64> {
    let h = 1.0 / STEPS as f64;
    let moment = |sigma: f64, theta: f64| -gamma * sigma * libm::cos(theta);
    let (mut theta, mut rate) = (end, 0.0);
    let mut list = vec![theta];
    for step in 0..STEPS {
        let sigma = step as f64 * h;
        let (a1, b1) = (rate, moment(sigma, theta));
        let (a2, b2) = (rate + 0.5 * h * b1, moment(sigma + 0.5 * h, theta + 0.5 * h * a1));
        let (a3, b3) = (rate + 0.5 * h * b2, moment(sigma + 0.5 * h, theta + 0.5 * h * a2));
        let (a4, b4) = (rate + h * b3, moment(sigma + h, theta + h * a3));
        theta += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
        rate += h / 6.0 * (b1 + 2.0 * (b2 + b3) + b4);
        list.push(theta);
    }
    list
}

/// The strip with this `Γ`, which must be above 0.
///
/// ```
/// let bent = drape_oracle::elastica::cantilever(8.0);
/// assert!((bent.drop_over_reach() - 0.8843).abs() < 1e-4);
/// let chord = bent.drop_over_reach().atan().to_degrees();
/// assert!((chord - 41.487).abs() < 1e-3);
/// ```
pub fn cantilever(gamma: f64) -> Cantilever {
    // At a slope of 0 the weight bends the strip upwards at the clamp; at 90° not at all.
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let at_clamp = slopes(gamma, middle).last().copied().unwrap_or_default();
        if at_clamp < 0.0 { low = middle } else { high = middle }
    }
    let mut slope = slopes(gamma, 0.5 * (low + high));
    slope.reverse();
    // Simpson's rule on pairs of steps would give every second place only; Hermite's cubic of the
    // integrand is as accurate: ∫ f = h (f₀ + f₁)/2 + h² (f₀' − f₁')/12.
    let h = 1.0 / STEPS as f64;
    let mut places = vec![[0.0, 0.0]];
    let rates: Vec<f64> = (0..=STEPS).map(|k| rate(&slope, k, h)).collect();
    for k in 0..STEPS {
        let (a, b) = (slope[k], slope[k + 1]);
        let [x, z] = places[k];
        let cosine = 0.5 * h * (libm::cos(a) + libm::cos(b))
            + h * h / 12.0 * (libm::sin(b) * rates[k + 1] - libm::sin(a) * rates[k]);
        let sine = 0.5 * h * (libm::sin(a) + libm::sin(b))
            + h * h / 12.0 * (libm::cos(a) * rates[k] - libm::cos(b) * rates[k + 1]);
        places.push([x + cosine, z - sine]);
    }
    Cantilever { places, slope }
}

/// Curvature by differences.
fn rate(slope: &[f64], k: usize, h: f64) -> f64 {
    let last = slope.len() - 1;
    match k {
        0 => (-3.0 * slope[0] + 4.0 * slope[1] - slope[2]) / (2.0 * h),
        k if k == last => (3.0 * slope[k] - 4.0 * slope[k - 1] + slope[k - 2]) / (2.0 * h),
        k => (slope[k + 1] - slope[k - 1]) / (2.0 * h),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_master_curve_has_its_known_values() {
        let known = [(1.0, 0.1246), (2.0, 0.2467), (4.0, 0.4777), (8.0, 0.8843), (16.0, 1.5628)];
        for (gamma, expected) in known {
            let found = cantilever(gamma).drop_over_reach();
            assert!((found - expected).abs() < 6e-5, "{gamma}: {found}");
        }
    }

    #[test]
    fn a_light_strip_bends_as_a_beam() {
        // Small deflection: H = Γ/8.
        let found = cantilever(1e-3).drop_over_reach();
        assert!((found / 1.25e-4 - 1.0).abs() < 1e-5, "{found}");
    }

    #[test]
    fn the_clamp_holds_and_the_strip_keeps_its_length() {
        let bent = cantilever(8.0);
        assert!(bent.slope[0].abs() < 1e-12);
        let pieces = bent.places.windows(2);
        let length: f64 = pieces.map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum();
        assert!((length - 1.0).abs() < 1e-6, "{length}");
    }
}
