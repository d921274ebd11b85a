//! The two updates of every explicit method, and updates of each particle by itself. The threads of
//! the system share them.

use drape_model::{System, Vec3};
use drape_solvers::bands::{bands, in_bands};
use drape_solvers::vector::{axpy, divided_axpy};

/// Updates the velocities: `v ← v + h M⁻¹ f`, with `h` in s, `f` in N and `v` in m/s.
pub fn kick(system: &System, h: f64, force: &[Vec3], v: &mut [Vec3]) {
    let (n, mass) = (v.len(), system.mass());
    in_bands(bands(system.threads(), n), n, v, &|band, v: &mut [Vec3]| {
        divided_axpy(h, &mass[band.clone()], &force[band], v);
    });
}

/// Updates the positions: `x ← x + h v`, with `h` in s, `v` in m/s and `x` in m.
pub fn drift(system: &System, h: f64, v: &[Vec3], x: &mut [Vec3]) {
    let n = x.len();
    in_bands(bands(system.threads(), n), n, x, &|band, x: &mut [Vec3]| axpy(h, &v[band], x));
}

/// Sets the item of each particle to what `of` returns for its index.
///
/// ```
/// # use drape_model::{System, Vec3};
/// use drape_integrator::each_particle;
/// # fn momenta(system: &System, v: &[Vec3]) -> Vec<Vec3> {
/// let mut momentum = vec![Vec3::zeros(); v.len()];
/// each_particle(system, &mut momentum, |i| v[i] * system.mass()[i]);
/// # momentum
/// # }
/// ```
pub fn each_particle<T: Send>(system: &System, items: &mut [T], of: impl Fn(usize) -> T + Sync) {
    change_each(system, items, |i, item| *item = of(i));
}

/// Changes the item of each particle.
pub fn change_each<T: Send>(
    system: &System,
    items: &mut [T],
    change: impl Fn(usize, &mut T) + Sync,
) {
    let n = items.len();
    in_bands(bands(system.threads(), n), n, items, &|band, items: &mut [T]| {
        for (i, item) in band.zip(items) {
            change(i, item);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::parse;

    #[test]
    fn a_kick_divides_by_each_mass_and_a_drift_by_none() {
        let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [2, 8],
            "position_m": [[0, 0, 0], [1, 0, 0]], "velocity_m_s": [[1, 0, 0], [0, 1, 0]] } }"#;
        let (system, mut state) =
            parse("test", text).expect("valid").spec().build().expect("valid");
        kick(&system, 0.5, &[Vec3::new(0.0, 4.0, 8.0); 2], &mut state.v);
        assert_eq!(state.v, [Vec3::new(1.0, 1.0, 2.0), Vec3::new(0.0, 1.25, 0.5)]);
        drift(&system, 0.5, &state.v, &mut state.x);
        assert_eq!(state.x, [Vec3::new(0.5, 0.5, 1.0), Vec3::new(1.0, 0.625, 0.25)]);
    }
}
