//! Description and settings of the method.

use drape_integrator::{Declares, Method, Order, Quantity, StabilityClass, Supports, settings};

/// Terzopoulos and Fleischer's semi-implicit step.
pub static TERZOPOULOS_FLEISCHER: Method = Method {
    id: "terzopoulos-fleischer",
    name: "Terzopoulos-Fleischer, lagged secant stiffness",
    source: "Terzopoulos, Platt, Barr, Fleischer 1987; Terzopoulos, Fleischer 1988; EEH section 3",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "stable for every step on springs of rest length 0; near its rest length a spring \
             resists only one step after it was stretched, so energy may rise; with clamp=true no \
             order is claimed",
    supports: Supports::ScalarMatrix,
    refuses: &[],
    settings: TerzopoulosFleischerSettings::SETTINGS,
};

settings! {
    /// Settings of the semi-implicit step.
    pub struct TerzopoulosFleischerSettings for TERZOPOULOS_FLEISCHER {
        /// raise the negative secant stiffness of compressed springs to 0: the matrix stays
        /// positive definite, but this is another equation, and no order is claimed
        clamp: bool = false,
    }
}
