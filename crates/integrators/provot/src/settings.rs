//! Description and settings of the method.

use drape_integrator::{
    Declares, ElongationSettings, Method, Order, Quantity, StabilityClass, Supports, Word, settings,
};

/// Provot's method.
pub static PROVOT: Method = Method {
    id: "provot",
    name: "symplectic Euler with a limit on elongation",
    source: "Provot 1995",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "as symplectic Euler, stable if h²λ + 2hδ < 4, while no spring exceeds its limit; \
             shortening a spring solves no differential equation, and conserves neither energy \
             nor angular momentum",
    supports: Supports::Explicit,
    refuses: &[],
    settings: ProvotSettings::SETTINGS,
};

/// Whether the correction of positions changes the velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityUpdate {
    /// `v_{n+1} = (x_{n+1} − x_n)/h`.
    Corrected,
    /// Velocities stay, and the springs that were too long go on stretching.
    PositionsOnly,
}

impl Word for VelocityUpdate {
    const WORDS: &'static [(&'static str, Self)] =
        &[("corrected", Self::Corrected), ("positions-only", Self::PositionsOnly)];
}

settings! {
    /// Settings of Provot's method.
    pub struct ProvotSettings for PROVOT {
        /// the limit on elongation
        elongation: ElongationSettings,
        /// whether a corrected position also changes the velocity, by its displacement over the
        /// step size
        velocity: VelocityUpdate [Corrected, PositionsOnly] = Corrected,
    }
}
