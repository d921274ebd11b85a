//! Description and settings.

use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, StepControl, Supports, settings,
};

/// The symplectic Runge–Kutta–Nyström method of order 4.
pub static SRKN4: Method = Method {
    id: "srkn4",
    name: "symplectic Runge–Kutta–Nyström of order 4",
    source: "Blanes and Moan 2002",
    order: Order::Four,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "its energy stays very close to the true one; stable if h²λ < 25.27 and hδ < 8.8, but \
             for a hairline at h²λ = 10.02",
    supports: Supports::Explicit,
    refuses: &["air", "contact", "friction", "moving pins", "moving obstacles"],
    settings: Srkn4Settings::SETTINGS,
};

settings! {
    /// Settings of the method.
    pub struct Srkn4Settings for SRKN4 {
        /// take the step as given, or divide it into equal substeps within safety · 5.0269/√λ and
        /// 8/δ, with λ estimated as the cloth moves (auto) or bounded for all positions (bound)
        step: StepControl [Fixed, Auto, Bound] = Fixed,
        /// longest substep of step=auto or bound over the stability limit 5.0269/√λ; for bound,
        /// 0.95 is enough
        safety: f64 in 0.05..=1.0 = 0.7,
    }
}
