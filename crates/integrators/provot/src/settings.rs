//! What the method is, and its settings.

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
    theory: "as symplectic Euler, stable if h²λ + 2hδ < 4, while no spring is longer than its limit; \
             shortening one solves no differential equation and conserves neither energy nor angular momentum",
    supports: Supports::Explicit,
    refuses: &[],
    settings: ProvotSettings::SETTINGS,
};

/// Whether the correction of positions changes the velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityUpdate {
    /// `v_{n+1} = (x_{n+1} − x_n)/h`.
    Corrected,
    /// It does not: the springs that were too long go on stretching.
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
        /// whether what moves a position also changes the velocity, by the displacement over the step size
        velocity: VelocityUpdate [Corrected, PositionsOnly] = Corrected,
    }
}
