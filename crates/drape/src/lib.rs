//! Time integrators for mass-spring cloth, compared on one and the same cloth.

pub use drape_harness as harness;
pub use drape_integrator as integrator;
pub use drape_model as model;
