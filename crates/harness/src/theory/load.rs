//! The motion of a single spring that is loaded across itself, where the law of locking has a
//! closed form.
//!
//! Let `J = d × v` be the angular momentum over the mass. The spring pulls along `d`, so its force
//! does not change `J`. Nor does the part along `v'` that a step adds to `d`. With `θ = h²k/m`,
//! IMEX Euler gives `J' = (J + h d × a)/(1 + θ)` at any amplitude. The filter of Desbrun and of
//! Kang lets the load pass, so these methods give `J' = J/(1 + θ) + h d × a`.
//!
//! Let `q = 1/(1 + θ)`. From rest, and while the deflection is small, the speed of IMEX Euler after
//! `n` steps is thus `h a q (1 − qⁿ)/(1 − q)`, which tends to `a/(hκ)`. Desbrun and Kang lack the
//! first `q`, and their speed tends to `a/(hκ) + ha`. Updated CG that starts at `v_n` and ends
//! after `N` passes adds the share `1 − (θ/(1 + θ))ᴺ` of `ha` in each step. This slows its fall
//! down, but does not end it. Backward Euler adds all of `ha`.

/// The response of a method to the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LoadLaw {
    /// The filter acts on the load and all other forces.
    Filtered,
    /// The load is added after the filter.
    Unfiltered,
    /// The method makes so many passes from the velocity of the last step.
    Passes(i32),
    /// The particle moves as if it had no spring.
    Free,
}

impl LoadLaw {
    /// Speed after `steps` steps from rest over that of a single step in free fall.
    pub(crate) fn speed(self, theta: f64, steps: u64) -> f64 {
        let q = 1.0 / (1.0 + theta);
        let n = steps as f64;
        let sum = (1.0 - libm::pow(q, n)) / (1.0 - q);
        match self {
            Self::Filtered => q * sum,
            Self::Unfiltered => sum,
            Self::Passes(passes) => n * (1.0 - libm::pow(theta * q, f64::from(passes))),
            Self::Free => n,
        }
    }

    /// The angular momentum after a step, from that before the step and the part that the load
    /// adds.
    pub(crate) fn follow(self, theta: f64, before: f64, load: f64) -> Option<f64> {
        match self {
            Self::Filtered => Some((before + load) / (1.0 + theta)),
            Self::Unfiltered => Some(before / (1.0 + theta) + load),
            Self::Passes(_) | Self::Free => None,
        }
    }
}
