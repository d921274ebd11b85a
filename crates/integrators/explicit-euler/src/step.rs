//! The steps, one file a method.

mod explicit;
mod leapfrog;
mod symplectic;

pub use explicit::ExplicitEuler;
pub use leapfrog::Leapfrog;
pub use symplectic::SymplecticEuler;
