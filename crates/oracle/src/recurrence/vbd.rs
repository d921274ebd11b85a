//! Block descent with a given number of sweeps, exactly.

use nalgebra::{Matrix4, Vector4};

/// A step of vertex block descent on two equal free particles on a spring of rest length 0, after
/// `sweeps` sweeps, as a matrix on `(x_1, x_2, w_1, w_2)` along one axis, `w = hv`. Here
/// `s = h²k/m` and `d = hc/m`. The sweeps start at `v_n`, and particle 1 moves first.
///
/// With `a = s + d` backward Euler solves `(1 + a) w_1 − a w_2 = w_{n,1} − s (x_1 − x_2)` and its
/// mirror image; its solution is `w*`. Each half of a sweep sets the error of one particle to the
/// error of the other, times `r = a/(1 + a)`:
///
/// ```text
/// w_2 = w_2* + r^{2 sweeps} (w_{n,2} − w_2*)      w_1 = w_1* + r^{2 sweeps − 1} (w_{n,2} − w_2*)
/// ```
///
/// The two errors differ, so the momentum `w_1 + w_2` is conserved only in the limit.
#[doc(alias = "Gauss-Seidel")]
pub fn vbd_pair(s: f64, d: f64, sweeps: u32) -> Matrix4<f64> {
    let a = s + d;
    let r = a / (1.0 + a);
    let late = r.powi(2 * sweeps as i32);
    let early = r.powi(2 * sweeps as i32 - 1);
    let columns = [0, 1, 2, 3].map(|column| {
        let mut start = Vector4::zeros();
        start[column] = 1.0;
        let pull = s * (start[0] - start[1]);
        let b = [start[2] - pull, start[3] + pull];
        // The inverse of [[1 + a, −a], [−a, 1 + a]].
        let w = [(1.0 + a) * b[0] + a * b[1], a * b[0] + (1.0 + a) * b[1]];
        let w = w.map(|w| w / (1.0 + 2.0 * a));
        let error = start[3] - w[1];
        let w = [w[0] + early * error, w[1] + late * error];
        Vector4::new(start[0] + w[0], start[1] + w[1], w[0], w[1])
    });
    Matrix4::from_columns(&columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrence::backward_euler;

    /// The relative motion of the pair is an oscillator with `θ = 2s`, `η = 2d`; the centre moves
    /// on.
    #[test]
    fn many_sweeps_are_backward_euler() {
        let (s, d) = (3.0, 0.25);
        let found = vbd_pair(s, d, 400);
        let expected = backward_euler(2.0 * s, 2.0 * d);
        let relative = found * Vector4::new(1.0, -1.0, 0.5, -0.5);
        let oscillator = expected * nalgebra::Vector2::new(2.0, 1.0);
        assert!((relative[0] - relative[1] - oscillator[0]).abs() < 1e-14);
        assert!((relative[2] - relative[3] - oscillator[1]).abs() < 1e-14);
        let centre = found * Vector4::new(1.0, 1.0, 1.0, 1.0);
        assert!((centre - Vector4::new(2.0, 2.0, 1.0, 1.0)).norm() < 1e-14);
    }

    /// Written out: particle 1 first, then particle 2 with the new velocity of particle 1.
    #[test]
    fn one_sweep_moves_one_particle_after_the_other() {
        let (s, d, start) = (2.0, 0.5, Vector4::new(1.0, -0.5, 0.25, 2.0));
        let a = s + d;
        let w1 = (start[2] - s * (start[0] - start[1]) + a * start[3]) / (1.0 + a);
        let w2 = (start[3] + s * (start[0] - start[1]) + a * w1) / (1.0 + a);
        let expected = Vector4::new(start[0] + w1, start[1] + w2, w1, w2);
        assert!((vbd_pair(s, d, 1) * start - expected).norm() < 1e-14);
    }
}
