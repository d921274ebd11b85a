//! Description and settings of the method.

use drape_integrator::{Declares, Method, Order, Quantity, StabilityClass, Supports, settings};

/// The exponential Rosenbrock-Euler method.
pub static EXPONENTIAL: Method = Method {
    id: "exponential",
    name: "exponential Rosenbrock-Euler with Krylov subspaces",
    source: "Pope (1963); Hochbruck, Ostermann, Schweitzer (2009)",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "exact on linear problems at any step; it follows the tangent of springs that turn, \
             and \
             nothing bounds the energy that this adds",
    supports: Supports::Blocks,
    refuses: &["contact", "friction", "moving pins"],
    settings: ExponentialSettings::SETTINGS,
};

settings! {
    /// Settings of the exponential Rosenbrock-Euler method.
    pub struct ExponentialSettings for EXPONENTIAL {
        /// local error of the Krylov subspace in the velocities, m/s for each second of the step
        krylov_tol: f64 in 1e-10..=1e-2 = 1e-5,
        /// most dimensions of a subspace; a step that needs more is divided
        max_dim: usize in 10..=500 = 150,
    }
}
