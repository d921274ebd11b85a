//! Pins at rest, and pins on paths.

use drape_model::{System, Vec3};
use drape_solvers::{Constraints, Filter};

/// Writes the pinned particles of a system to `constraints`, at rest.
pub fn hold_pins(system: &System, constraints: &mut Constraints) {
    for &pin in system.pins() {
        constraints.set(pin as usize, Filter::Fixed, Vec3::zeros());
    }
}

/// Gives pins on paths the velocity, m/s, that leads from `x` at time `t` to the path `h` seconds
/// later. Velocities of other particles do not change.
pub fn lead_pins(system: &System, t: f64, h: f64, x: &[Vec3], v: &mut [Vec3]) {
    for pin in system.moving_pins() {
        v[pin.particle] = (pin.position(t + h) - x[pin.particle]) / h;
    }
}
