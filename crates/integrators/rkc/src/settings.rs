//! Description and settings.

use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, Supports, Word, settings,
};

/// Runge–Kutta–Chebyshev.
pub static RKC: Method = Method {
    id: "rkc",
    name: "Runge–Kutta–Chebyshev",
    source: "Sommeijer, Shampine and Verwer 1998",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "with s stages stable on overdamped modes for hδ < 0.65 (s² − 1), on vibrations for \
             h√λ < \
             1.6 to 4.7 only, whatever s; it divides its steps accordingly and refuses springs \
             without damping",
    supports: Supports::Explicit,
    refuses: &[],
    settings: RkcSettings::SETTINGS,
};

/// Who chooses substeps and stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Division {
    /// The method: as few as stability allows.
    Auto,
    /// The user.
    Fixed,
}

impl Word for Division {
    const WORDS: &'static [(&'static str, Self)] = &[("auto", Self::Auto), ("fixed", Self::Fixed)];
}

settings! {
    /// Settings of the method.
    pub struct RkcSettings for RKC {
        /// divide the step into as few substeps with as few stages as stability allows, or take it
        /// as given with all stages
        step: Division [Auto, Fixed] = Auto,
        /// force evaluations of a substep: at most so many for step=auto, exactly for step=fixed
        stages: u32 in 2..=200 = 200,
        /// factor of the spectral radius for which step=auto chooses stages; its test of vibrations
        /// has no margin
        safety: f64 in 1.0..=4.0 = 1.1,
    }
}
