//! The correction of the torque that the filter adds.

use crate::settings::Torque;
use drape_integrator::Implicit;
use drape_model::{Level, Mat3, System, Vec3};

/// Inertia about an axis below this fraction of the largest counts as none: particles on a line.
const DEGENERATE: f64 = 1e-12;

/// Damping force of the springs at a level, N.
pub(crate) fn damping_force(system: &System, at: Level<'_>, out: &mut [Vec3]) {
    out.fill(Vec3::zeros());
    for effect in Implicit::Springs.effects(system).filter(|effect| effect.has_damping()) {
        effect.add_damping_force(at, out);
    }
}

/// Adds `h M⁻¹ F_corr` to `v` (m/s), given `Δv = h M⁻¹ F_filtered` and the damping force (N) at
/// `x`; (D3).
pub(crate) fn correct(
    torque: Torque,
    system: &System,
    h: f64,
    x: &[Vec3],
    change: &[Vec3],
    damping: &[Vec3],
    v: &mut [Vec3],
) {
    match torque {
        Torque::None => {}
        Torque::Literal => literal(system, h, x, change, v),
        Torque::Consistent if system.pinned().contains(&true) => {}
        Torque::Consistent => consistent(system, h, x, change, damping, v),
    }
}

/// As published: `δT = Σ F_i × x_i`, `F_corr,i = h (x_G − x_i) × δT`, `x_G` the mean of the
/// positions.
fn literal(system: &System, h: f64, x: &[Vec3], change: &[Vec3], v: &mut [Vec3]) {
    let mass = system.mass();
    let mut torque = Vec3::zeros();
    let mut mean = Vec3::zeros();
    for i in 0..x.len() {
        torque += (change[i] * (mass[i] / h)).cross(&x[i]);
        mean += x[i];
    }
    mean /= x.len() as f64;
    for i in (0..x.len()).filter(|&i| !system.pinned()[i]) {
        v[i] += (mean - x[i]).cross(&torque) * (h * h / mass[i]);
    }
}

/// `F_corr,i = m_i β × r_i` with `β = −I_G⁻¹ Σ r_i × (F_i − f_damping,i)`, where `r_i = x_i − x_G`
/// and `x_G` is the centre of mass. It is the rigid rotation that restores the angular momentum
/// which the filter took. Full damping has a torque of its own, which stays. Since
/// `x_{n+1} = x_n + h v_{n+1}`, this keeps `Σ m x × v` exactly where nothing is damped.
#[doc(alias = "torque correction")]
fn consistent(
    system: &System,
    h: f64,
    x: &[Vec3],
    change: &[Vec3],
    damping: &[Vec3],
    v: &mut [Vec3],
) {
    let mass = system.mass();
    let total: f64 = mass.iter().sum();
    let weighted = x.iter().zip(mass).fold(Vec3::zeros(), |sum, (x, m)| sum + x * *m);
    let centre = weighted / total;
    let mut moment = Vec3::zeros(); // Σ r × (m Δv − h f_damping)
    let mut inertia = Mat3::zeros();
    for i in 0..x.len() {
        let r = x[i] - centre;
        moment += r.cross(&(change[i] * mass[i] - damping[i] * h));
        let square = Mat3::from_diagonal_element(r.norm_squared()) - r * r.transpose();
        inertia += square * mass[i];
    }
    let spin = -solve(&inertia, &moment); // h β
    for (v, x) in v.iter_mut().zip(x) {
        *v += spin.cross(&(x - centre));
    }
}

/// `I⁻¹ b` for a symmetric positive semi-definite `I`; 0 about axes without inertia.
fn solve(inertia: &Mat3, b: &Vec3) -> Vec3 {
    if !inertia.iter().chain(b.iter()).all(|a| a.is_finite()) {
        return Vec3::zeros();
    }
    let eigen = inertia.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut solution = Vec3::zeros();
    for k in 0..3 {
        if eigen.eigenvalues[k] > DEGENERATE * largest {
            let axis = eigen.eigenvectors.column(k).into_owned();
            solution += axis * (axis.dot(b) / eigen.eigenvalues[k]);
        }
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::parse;
    use drape_oracle::Random;

    fn system(pin: &str) -> System {
        let text = format!(
            r#"{{ "format": "drape-system/1", "pins": [{pin}],
            "particles": {{ "mass_kg": [1, 2, 0.5, 4],
            "position_m": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]] }} }}"#
        );
        parse("test", &text).expect("valid").spec().build().expect("valid").0
    }

    fn angular_momentum(system: &System, x: &[Vec3], v: &[Vec3]) -> Vec3 {
        let terms = system.mass().iter().zip(x.iter().zip(v));
        terms.fold(Vec3::zeros(), |sum, (m, (x, v))| sum + x.cross(v) * *m)
    }

    /// In consistent units the correction takes back the whole torque, about any point, and leaves
    /// the momentum alone.
    #[test]
    fn the_consistent_correction_restores_angular_momentum_exactly() {
        let mut random = Random::new(5);
        let system = system("");
        for flat in [false, true] {
            let mut x: Vec<Vec3> = (0..4).map(|_| random.vector() * 3.0).collect();
            if flat {
                // On a line there is an axis without inertia.
                x = (0..4).map(|i| Vec3::new(1.0, 2.0, 2.0) * f64::from(i)).collect();
            }
            let mut change: Vec<Vec3> = (0..4).map(|_| random.vector()).collect();
            let total: f64 = system.mass().iter().sum();
            let drift =
                change.iter().zip(system.mass()).fold(Vec3::zeros(), |p, (c, m)| p + c * *m);
            change.iter_mut().for_each(|c| *c -= drift / total); // internal forces
            let mut v = change.clone();
            let none = vec![Vec3::zeros(); 4];
            correct(Torque::Consistent, &system, 0.01, &x, &change, &none, &mut v);
            assert!(angular_momentum(&system, &x, &change).norm() > 0.1);
            assert!(angular_momentum(&system, &x, &v).norm() < 1e-13, "flat: {flat}");
            let momentum = v.iter().zip(system.mass()).fold(Vec3::zeros(), |p, (v, m)| p + v * *m);
            assert!(momentum.norm() < 1e-13);
        }
    }

    /// The published correction depends on the step and the unit of length, which is its fault.
    #[test]
    fn the_literal_correction_is_the_published_formula_and_misses_the_torque() {
        let (system, h) = (system(""), 0.1);
        let mut random = Random::new(6);
        let x: Vec<Vec3> = (0..4).map(|_| random.vector()).collect();
        let change: Vec<Vec3> = (0..4).map(|_| random.vector()).collect();
        let mut v = vec![Vec3::zeros(); 4];
        let none = vec![Vec3::zeros(); 4];
        correct(Torque::Literal, &system, h, &x, &change, &none, &mut v);
        let mean = x.iter().sum::<Vec3>() / 4.0;
        let force = |i: usize| change[i] * (system.mass()[i] / h);
        let torque: Vec3 = (0..4).map(|i| force(i).cross(&x[i])).sum();
        for i in 0..4 {
            let correction = (mean - x[i]).cross(&torque) * h;
            assert!((v[i] - correction * (h / system.mass()[i])).norm() < 1e-14);
        }
        let (before, after) =
            (angular_momentum(&system, &x, &change), angular_momentum(&system, &x, &v));
        assert!((before + after).norm() > 0.5 * before.norm());
    }

    #[test]
    fn with_a_pin_the_consistent_correction_does_nothing() {
        let system = system(r#"{ "particle": 0 }"#);
        let x = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let change = vec![Vec3::zeros(), Vec3::y(), Vec3::z(), Vec3::x()];
        let mut v = change.clone();
        let none = vec![Vec3::zeros(); 4];
        correct(Torque::Consistent, &system, 0.01, &x, &change, &none, &mut v);
        assert_eq!(v, change);
    }

    #[test]
    fn the_torque_of_the_damping_is_left_to_it() {
        let (system, state) = drape_oracle::scenes::Sheet {
            side: 3,
            pinned: false,
            ..drape_oracle::scenes::Sheet::default()
        }
        .build();
        let h = 0.01;
        let damping: Vec<_> = state.x.iter().map(|x| Vec3::z().cross(x)).collect();
        let change: Vec<_> = damping.iter().zip(system.mass()).map(|(f, m)| f * (h / m)).collect();
        let turned = |damping: &[Vec3]| {
            let mut v = state.v.clone();
            correct(Torque::Consistent, &system, h, &state.x, &change, damping, &mut v);
            v.iter().zip(&state.v).map(|(v, before)| (v - before).norm()).fold(0.0, f64::max)
        };
        let greatest = change.iter().map(|change| change.norm()).fold(0.0, f64::max);
        assert!(turned(&damping) < 1e-13 * greatest);
        assert!(turned(&vec![Vec3::zeros(); damping.len()]) > 0.1 * greatest);
    }
}
