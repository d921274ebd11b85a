//! The fast kernel for springs in any order.
//!
//! The springs are taken in batches: the differences of the ends are read one after the other, lengths and factors
//! computed for the whole batch in vector registers, and the forces added one after the other, in the order of the
//! list. Only the middle part, with its square root and division, is worth vectors; it does not depend on who
//! is whose neighbour. The results are those of the [readable loops](super::LinearSprings::add_one_by_one), bit for bit.
//!
//! A spring costs what it costs in [`super::sweep`], and 32 bytes of its own beside the vectors at its ends.

use super::sweep::Law;
use super::{COLLAPSED, Spring, Vec3};

/// Springs of a batch: the arrays stay in the first-level cache.
const BATCH: usize = 64;

/// Adds `−g (x_i − x_j)` of each spring to `out`, N.
pub(crate) fn add(springs: &[Spring], law: Law, x: &[Vec3], out: &mut [Vec3]) {
    match law {
        Law::Spring => dispatch(springs, |k, q| Law::Spring.stiffness(k, q), x, out),
        Law::Nonlinear => dispatch(springs, |k, q| Law::Nonlinear.stiffness(k, q), x, out),
        Law::Linear => add_weighted(springs, |s| s.stiffness, x, out),
    }
}

/// Adds `−c (v_i − v_j)` of each spring to `out`, N.
pub(crate) fn damp_fully(springs: &[Spring], v: &[Vec3], out: &mut [Vec3]) {
    add_weighted(springs, |s| s.damping, v, out);
}

fn add_weighted(springs: &[Spring], weight: impl Fn(&Spring) -> f64, x: &[Vec3], out: &mut [Vec3]) {
    for s in springs {
        let (i, j) = s.ends();
        let f = (x[i] - x[j]) * weight(s);
        out[i] -= f;
        out[j] += f;
    }
}

fn dispatch(
    springs: &[Spring],
    law: impl Fn(f64, f64) -> f64 + Copy,
    x: &[Vec3],
    out: &mut [Vec3],
) {
    pulp::Arch::new().dispatch(Batches { springs, law, x, out });
}

struct Batches<'a, L> {
    springs: &'a [Spring],
    law: L,
    x: &'a [Vec3],
    out: &'a mut [Vec3],
}

impl<L: Fn(f64, f64) -> f64> pulp::WithSimd for Batches<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { springs, law, x, out } = self;
        let mut d = [[0.0; 3]; BATCH];
        let (mut rest_length, mut stiffness) = ([0.0; BATCH], [0.0; BATCH]);
        let (mut squares, mut g) = ([0.0; BATCH], [0.0; BATCH]);
        for batch in springs.chunks(BATCH) {
            for (t, s) in batch.iter().enumerate() {
                let (a, b) = (&x[s.i as usize], &x[s.j as usize]);
                d[t] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
                squares[t] = d[t][0] * d[t][0] + d[t][1] * d[t][1] + d[t][2] * d[t][2];
                (rest_length[t], stiffness[t]) = (s.rest_length, s.stiffness);
            }
            for t in 0..BATCH {
                let length = squares[t].sqrt();
                let far = length > COLLAPSED * rest_length[t];
                let rest_over_length = if far { rest_length[t] / length } else { 0.0 };
                g[t] = law(stiffness[t], rest_over_length);
            }
            for ((s, d), g) in batch.iter().zip(&d).zip(&g) {
                let f = [d[0] * g, d[1] * g, d[2] * g];
                let a = &mut out[s.i as usize];
                *a = Vec3::new(a[0] - f[0], a[1] - f[1], a[2] - f[2]);
                let b = &mut out[s.j as usize];
                *b = Vec3::new(b[0] + f[0], b[1] + f[1], b[2] + f[2]);
            }
        }
    }
}
