//! Description and settings of the method.

use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, StageSettings, Start, Supports, TOLERANCE,
    settings,
};

/// Implicit midpoint.
pub static MIDPOINT: Method = Method {
    id: "midpoint",
    name: "implicit midpoint with full Newton",
    source: "Volino & Magnenat-Thalmann 2005",
    order: Order::Two,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "symplectic, A-stable on linear problems and undamped at every step size there; \
             unstable at large h²k/m where undamped springs turn",
    supports: Supports::Blocks,
    refuses: &[],
    settings: MidpointSettings::SETTINGS,
};

settings! {
    /// Settings of implicit midpoint.
    pub struct MidpointSettings for MIDPOINT {
        /// how Newton's method solves and when it stops
        stage: StageSettings,
        /// start value of Newton's method; last: v_n; best: the best of v_n, the extrapolated velocity
        /// and free motion
        start: Start [Last, Best] = Best,
        /// local error that a step may make, in mesh widths; 0: the method takes steps as given
        tolerance: f64 as TOLERANCE,
    }
}
