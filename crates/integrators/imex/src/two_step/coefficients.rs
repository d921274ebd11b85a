//! Coefficients of the four methods.

/// A two-step method (Ascher, Ruuth and Wetton 1995).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TwoStep {
    /// Semi-implicit backward differentiation.
    Sbdf2,
    /// Crank–Nicolson with Adams–Bashforth.
    Cnab2,
    /// CNAB with a small part of the oldest level in the implicit part, which damps stiff modes.
    Mcnab2,
    /// Crank–Nicolson over two steps with leapfrog.
    Cnlf,
}

/// Coefficients of a two-step method for `y' = f + g` with `g` implicit, EEH (7). Index 0 is the
/// new level; the paper counts from the oldest one and takes `α_k = 1`.
///
/// ```text
/// (1/h) Σ_{j=0}^{2} a_j y_{n+1−j} = Σ_{j=1}^{2} c_j f_{n+1−j} + Σ_{j=0}^{2} b_j g_{n+1−j}
/// ```
///
/// With `ω = h_n/h_{n−1}`, the last step over the one before (Wang and Ruuth 2008):
///
/// | | `a_0, a_1, a_2` | `b_0, b_1, b_2` | `c_1, c_2` | `τ = h b_0/a_0` |
/// |---|---|---|---|---|
/// | SBDF2 | `(1+2ω)/(1+ω), −(1+ω), ω²/(1+ω)` | `1, 0, 0` | `1+ω, −ω` | `2h/3` at `ω = 1` |
/// | CNAB2 | `1, −1, 0` | `1/2, 1/2, 0` | `1+ω/2, −ω/2` | `h/2` |
/// | MCNAB2 | `1, −1, 0` | `(8+1/ω)/16, (7−1/ω)/16, 1/16` | `1+ω/2, −ω/2` | `9h/16` at `ω = 1` |
/// | CNLF | `1/2, 0, −1/2` | `1/2, 0, 1/2` | `1, 0` | `h`, `ω = 1` only |
#[doc(alias = "EEH 7")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Of the levels `n+1`, `n`, `n−1`.
    pub a: [f64; 3],
    /// Of the implicit part at the levels `n+1`, `n`, `n−1`.
    pub b: [f64; 3],
    /// Of the explicit part at the levels `n`, `n−1`.
    pub c: [f64; 2],
}

/// Ratios of neighbouring steps that the variable-step coefficients bridge. SBDF2 forgets its start
/// while `ω < 1 + √2`. After a jump by more than a factor of 2 the method starts anew.
const STEP_RATIOS: std::ops::RangeInclusive<f64> = 0.5..=2.0;

impl TwoStep {
    /// The coefficients for equal steps.
    pub fn at_constant_step(self) -> Coefficients {
        self.formula(1.0)
    }

    /// The coefficients where the last step is `omega` times the one before. `None` where the
    /// method has to start anew: outside of [1/2, 2], and CNLF at any change.
    pub fn coefficients(self, omega: f64) -> Option<Coefficients> {
        let fits = match self {
            Self::Cnlf => omega == 1.0,
            _ => STEP_RATIOS.contains(&omega),
        };
        fits.then(|| self.formula(omega))
    }

    fn formula(self, omega: f64) -> Coefficients {
        let adams_bashforth = [1.0 + 0.5 * omega, -0.5 * omega];
        match self {
            Self::Sbdf2 => {
                let sum = 1.0 + omega;
                Coefficients {
                    a: [(1.0 + 2.0 * omega) / sum, -sum, omega * omega / sum],
                    b: [1.0, 0.0, 0.0],
                    c: [sum, -omega],
                }
            }
            Self::Cnab2 => {
                Coefficients { a: [1.0, -1.0, 0.0], b: [0.5, 0.5, 0.0], c: adams_bashforth }
            }
            Self::Mcnab2 => Coefficients {
                a: [1.0, -1.0, 0.0],
                b: [(8.0 + 1.0 / omega) / 16.0, (7.0 - 1.0 / omega) / 16.0, 1.0 / 16.0],
                c: adams_bashforth,
            },
            Self::Cnlf => Coefficients { a: [0.5, 0.0, -0.5], b: [0.5, 0.0, 0.5], c: [1.0, 0.0] },
        }
    }
}

impl Coefficients {
    /// `τ = h b_0/a_0`, s: the time for which the new velocity acts.
    pub fn tau(&self, h: f64) -> f64 {
        h * (self.b[0] / self.a[0])
    }
}
