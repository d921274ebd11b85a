//! Description and settings of the method.

use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, StageSettings, Supports, TOLERANCE, settings,
};

/// Backward Euler.
pub static BACKWARD_EULER: Method = Method {
    id: "backward-euler",
    name: "backward Euler with full Newton",
    source: "EEH (3) with k = 1, (4), (5)",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "L-stable on linear problems; not energy monotone where springs are compressed",
    supports: Supports::Blocks,
    refuses: &[],
    settings: BackwardEulerSettings::SETTINGS,
};

settings! {
    /// Settings of backward Euler.
    pub struct BackwardEulerSettings for BACKWARD_EULER {
        /// how Newton's method solves and when it stops
        stage: StageSettings,
        /// local error that a step may make, in mesh widths; 0: the method takes steps as given
        tolerance: f64 as TOLERANCE,
    }
}
