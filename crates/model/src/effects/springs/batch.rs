//! The fast kernel for springs in any order.
//!
//! Positions, velocities and forces are copied to vectors of four numbers, the last of which is 0, so that a particle is
//! one register. The springs are taken in batches: the differences of the ends are read one spring after the other, lengths and
//! factors computed for the whole batch, and the forces added one after the other, in the order of the list. A sum
//! has the order of the [readable loops](super::LinearSprings::add_one_by_one): the results are the same bits.
//!
//! A spring costs the flops that it costs in [`super::sweep`], of which a quarter is done for the empty number, and reads 24 bytes of its own
//! beside the vectors at its ends, 32 with damping. What it takes depends on whether those are in the cache: on the numbering of the
//! particles and on the order of the list.

use super::COLLAPSED;
use super::listed::Listed;
use super::sweep::{Law, Pass};
use crate::Vec3;

/// Springs of a batch: the arrays stay in the first-level cache.
const BATCH: usize = 64;

/// A vector, and a 0.
type Quad = [f64; 4];

/// Memory of a sweep: one register a particle and vector.
#[derive(Debug, Default)]
pub(crate) struct Quads {
    x: Vec<Quad>,
    v: Vec<Quad>,
    out: Vec<Quad>,
}

impl Quads {
    /// Memory for springs of so many particles.
    pub(crate) fn new(particles: usize) -> Self {
        let zeros = || vec![[0.0; 4]; particles];
        Self { x: zeros(), v: zeros(), out: zeros() }
    }

    /// For how many particles there is memory.
    pub(crate) fn particles(&self) -> usize {
        self.x.len()
    }
}

/// Adds what `passes` ask for to `out`, N; diagonals are not among them.
pub(crate) fn add(
    passes: &[Option<Pass<'_>>],
    quads: &mut Quads,
    x: &[Vec3],
    v: &[Vec3],
    out: &mut [Vec3],
) {
    pulp::Arch::new().dispatch(Batches { passes, quads, x, v, out });
}

struct Batches<'a> {
    passes: &'a [Option<Pass<'a>>],
    quads: &'a mut Quads,
    x: &'a [Vec3],
    v: &'a [Vec3],
    out: &'a mut [Vec3],
}

impl pulp::WithSimd for Batches<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { passes, quads: Quads { x: x4, v: v4, out: sums }, x, v, out } = self;
        widen(x, x4);
        if passes.iter().flatten().any(|pass| matches!(pass, Pass::Listed(s) if s.law.is_damped()))
        {
            widen(v, v4);
        }
        widen(out, sums);
        for pass in passes.iter().flatten() {
            match pass {
                Pass::Listed(springs) => {
                    let list = springs.list;
                    match springs.law {
                        Law::Spring => add_forces::<false>(list, Law::Spring, x4, v4, sums),
                        Law::DampedSpring => add_forces::<true>(list, Law::Spring, x4, v4, sums),
                        Law::Nonlinear => add_forces::<false>(list, Law::Nonlinear, x4, v4, sums),
                        Law::Linear => add_weighted(list, &list.stiffness, x4, sums),
                        Law::Damping => add_weighted(list, &list.damping, v4, sums),
                    }
                }
                Pass::Field(field) => {
                    let g = field.acceleration;
                    for (sum, m) in sums.iter_mut().zip(field.mass) {
                        *sum = [sum[0] + g.x * m, sum[1] + g.y * m, sum[2] + g.z * m, 0.0];
                    }
                }
                Pass::Springs(_) => {}
            }
        }
        for (out, sum) in out.iter_mut().zip(&*sums) {
            *out = Vec3::new(sum[0], sum[1], sum[2]);
        }
    }
}

#[inline(always)]
fn widen(from: &[Vec3], to: &mut [Quad]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = [from.x, from.y, from.z, 0.0];
    }
}

#[inline(always)]
fn minus(a: &Quad, b: &Quad) -> Quad {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

#[inline(always)]
fn plus(a: &Quad, b: &Quad) -> Quad {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

#[inline(always)]
fn times(a: &Quad, g: f64) -> Quad {
    [a[0] * g, a[1] * g, a[2] * g, a[3] * g]
}

/// Adds `−g (x_i − x_j)` of each spring, and with it `−c (v_i − v_j)` if they are damped.
#[inline(always)]
fn add_forces<const DAMPED: bool>(
    list: &Listed,
    law: Law,
    x: &[Quad],
    v: &[Quad],
    sums: &mut [Quad],
) {
    let mut d = [[0.0; 4]; BATCH];
    let (mut squares, mut g) = ([0.0; BATCH], [0.0; BATCH]);
    let lists = list.rest_length.chunks(BATCH).zip(list.stiffness.chunks(BATCH));
    let parameters = lists.zip(list.damping.chunks(BATCH));
    for (ends, ((rest_length, stiffness), damping)) in list.ends.chunks(BATCH).zip(parameters) {
        for ((d, square), &[i, j]) in d.iter_mut().zip(&mut squares).zip(ends) {
            *d = minus(&x[i as usize], &x[j as usize]);
            *square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        }
        factors(&squares, rest_length, stiffness, law, &mut g);
        for (((&[i, j], d), g), c) in ends.iter().zip(&d).zip(&g).zip(damping) {
            let mut f = times(d, *g);
            if DAMPED {
                f = plus(&f, &times(&minus(&v[i as usize], &v[j as usize]), *c));
            }
            sums[i as usize] = minus(&sums[i as usize], &f);
            sums[j as usize] = plus(&sums[j as usize], &f);
        }
    }
}

/// The factors of a batch.
#[inline(always)]
fn factors(
    squares: &[f64; BATCH],
    rest_length: &[f64],
    stiffness: &[f64],
    law: Law,
    g: &mut [f64; BATCH],
) {
    let m = rest_length.len().min(stiffness.len()).min(BATCH);
    let (squares, rest_length, stiffness) = (&squares[..m], &rest_length[..m], &stiffness[..m]);
    let g = &mut g[..m];
    for t in 0..m {
        let length = squares[t].sqrt();
        let far = length > COLLAPSED * rest_length[t];
        g[t] = law.stiffness(stiffness[t], if far { rest_length[t] / length } else { 0.0 });
    }
}

/// Adds `−w (x_i − x_j)` of each spring.
#[inline(always)]
fn add_weighted(list: &Listed, weights: &[f64], x: &[Quad], sums: &mut [Quad]) {
    for (&[i, j], &w) in list.ends.iter().zip(weights) {
        let f = times(&minus(&x[i as usize], &x[j as usize]), w);
        sums[i as usize] = minus(&sums[i as usize], &f);
        sums[j as usize] = plus(&sums[j as usize], &f);
    }
}
