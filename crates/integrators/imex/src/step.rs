//! The steps of the two methods of order 1.

mod euler;
mod robust;
mod updated;

pub(crate) use euler::EulerWorkspace;
pub use euler::{EULER, ImexEuler};
pub(crate) use updated::UpdatedWorkspace;
pub use updated::{ImexUpdated, UPDATED};
