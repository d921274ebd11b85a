//! The steps, one file a method.

mod explicit;
mod leapfrog;
mod symplectic;

pub(crate) use explicit::ExplicitWorkspace;
pub use explicit::{EXPLICIT, ExplicitEuler};
pub use leapfrog::{Leapfrog, VERLET};
pub(crate) use symplectic::SymplecticWorkspace;
pub use symplectic::{SYMPLECTIC, SymplecticEuler};
