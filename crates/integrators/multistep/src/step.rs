//! The steps, one file a family.

mod adams_bashforth;
mod bdf;

pub use adams_bashforth::AdamsBashforth;
pub use bdf::Bdf;
