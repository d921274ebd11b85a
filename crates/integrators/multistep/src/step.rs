//! The steps, one file a family.

mod adams_bashforth;
mod bdf;

pub use adams_bashforth::{AdamsBashforth, EXPLICIT_ADAMS};
pub use bdf::{BACKWARD_DIFFERENTIATION, Bdf};
