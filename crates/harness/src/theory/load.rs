//! The motion of a single spring that is loaded across itself, where the law of locking has a
//! closed form.
//!
//! The spring pulls along `d`, so that it falls out of the angular momentum `J = d × v` over the
//! mass, and so does what is added to `d` along `v'`. IMEX Euler gives
//! `J' = (J + h d × a)/(1 + θ)`, `θ = h²k/m`, at any amplitude; Desbrun and Kang, whose filter
//! passes the load, `J' = J/(1 + θ) + h d × a`. From rest, and while the deflection is small, the
//! speed after `n` steps is thus `h a q (1 − qⁿ)/(1 − q)`, `q = 1/(1 + θ)`, or that without the
//! first `q`: it tends to `a/(hκ)`, or to `a/(hκ) + ha`. Updated CG that starts at `v_n` and ends
//! after `N` passes adds the share `1 − (θ/(1 + θ))ᴺ` of `ha` in each step: its fall is slowed
//! down, but does not end. Backward Euler adds all of it.

/// How a method answers to the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LoadLaw {
    /// The load passes the filter with the rest.
    Filtered,
    /// The load is added behind the filter.
    Unfiltered,
    /// So many passes from the velocity of the last step.
    Passes(i32),
    /// As if there were no spring.
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

    /// The angular momentum after a step, from that before and what the load adds to it.
    pub(crate) fn follow(self, theta: f64, before: f64, load: f64) -> Option<f64> {
        match self {
            Self::Filtered => Some((before + load) / (1.0 + theta)),
            Self::Unfiltered => Some(before / (1.0 + theta) + load),
            Self::Passes(_) | Self::Free => None,
        }
    }
}
