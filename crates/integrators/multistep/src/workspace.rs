//! Scratch memory and history, one file a family.

mod adams_bashforth;
mod bdf;

pub(crate) use adams_bashforth::AdamsWorkspace;
pub(crate) use bdf::{BdfWorkspace, Obstacles};

use crate::coefficients::MAX_STEPS;
use drape_integrator::History;

/// The sizes of the last steps, s, the present one first, and how many the history allows.
fn step_sizes(history: &History<2>, h: f64) -> ([f64; MAX_STEPS], usize) {
    let mut steps = [h; MAX_STEPS];
    for age in 0..history.len() {
        steps[age + 1] = history.step(age);
    }
    (steps, history.len() + 1)
}
