//! The two updates of every explicit method.

use drape_model::{System, Vec3};

/// `v ← v + h M⁻¹ f`, with `f` in N.
pub fn kick(system: &System, h: f64, force: &[Vec3], v: &mut [Vec3]) {
    for ((v, f), m) in v.iter_mut().zip(force).zip(system.mass()) {
        *v += f * (h / m);
    }
}

/// `x ← x + h v`.
pub fn drift(h: f64, v: &[Vec3], x: &mut [Vec3]) {
    for (x, v) in x.iter_mut().zip(v) {
        *x += v * h;
    }
}
