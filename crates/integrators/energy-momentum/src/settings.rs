//! Description and settings of the method.

use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, Supports, Word, settings,
};

/// The energy-momentum method.
pub static ENERGY_MOMENTUM: Method = Method {
    id: "energy-momentum",
    name: "energy-momentum method with discrete gradients",
    source: "LaBudde and Greenspan (1974); Gonzalez (1996)",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum, Quantity::Energy],
    theory: "a solved step changes the energy by the work of the damping alone; not every step can \
             be solved",
    supports: Supports::ScalarMatrix,
    refuses: &["shear_angle", "bending_angle", "bending_hinge", "projected damping"],
    settings: EnergyMomentumSettings::SETTINGS,
};

/// What a step does when Newton's method finds no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnFailure {
    /// It takes two steps of half the length, each of which may be divided again.
    Halve,
    /// It takes the best velocity that was found, and reports it.
    Report,
}

impl Word for OnFailure {
    const WORDS: &'static [(&'static str, Self)] =
        &[("halve", Self::Halve), ("report", Self::Report)];
}

settings! {
    /// Settings of the energy-momentum method.
    pub struct EnergyMomentumSettings for ENERGY_MOMENTUM {
        /// residual at which Newton stops, relative to the change of velocity that the forces would
        /// make; never below round-off
        residual: f64 in 1e-16..=0.5 = 1e-9,
        /// most Newton iterations for one velocity
        max_iterations: u32 in 1..=10_000 = 60,
        /// divide a step that Newton cannot solve, at most six times, or report it
        on_failure: OnFailure [Halve, Report] = Halve,
    }
}
