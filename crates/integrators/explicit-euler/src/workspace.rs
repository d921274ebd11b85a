//! Scratch memory.

mod euler;
mod leapfrog;

pub(crate) use euler::EulerWorkspace;
pub(crate) use leapfrog::{Damping, LeapfrogWorkspace};
