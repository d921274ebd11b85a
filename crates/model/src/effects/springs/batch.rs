//! The fast kernels for springs in any order.
//!
//! Positions, velocities and forces are copied to vectors of four numbers, so that a particle fills
//! one register; the fourth number is 0. The springs come in batches. A batch reads the differences
//! of the ends spring by spring and computes lengths and factors for all its springs. Then it adds
//! the forces one after the other, in the order of the list. Each sum has the order of the
//! [readable loops](super::LinearSprings::add_reference), so the results are the same bits.
//!
//! With AVX2 a batch is four springs and stays in `registers`; otherwise arrays hold it.
//!
//! A spring takes the flops that it takes in [`super::sweep`]; a quarter of them is spent on the
//! empty number. It reads 24 bytes of its own, 32 with damping, and the vectors at its ends. Its
//! time depends on whether these vectors are in the cache, that is, on the numbering of the
//! particles and the order of the list.
//!
//! # What was tried
//!
//! Nanoseconds per spring on one core of an AMD EPYC (Zen 4), the least of forty repetitions. The
//! system is a square sheet, `N` particles wide, with gravity and three damped effects of springs.
//! Its particles and springs were shuffled, then numbered anew. A fifth of the time goes into
//! copying to registers and back.
//!
//! | variant | N = 52 | 100 |
//! |---|---|---|
//! | batches of 64 in arrays | 4.0 | 4.5 |
//! | position and velocity of a particle in one cache line | 4.7 | 4.5 |
//! | one check of an index for all vectors | 4.0 | 4.5 |
//! | groups of 8 in arrays, three under way | 4.3 | 4.6 |
//! | four springs in registers | **3.25** | **3.6** |
//! | … the next four read before these are added | 3.25 | 3.55 |
//! | … position and velocity in one cache line | 3.8 | 3.65 |

#[cfg(target_arch = "x86_64")]
mod registers;

use super::listed::Listed;
use super::sweep::{Begin, Law, Pass};
use super::{COLLAPSED, projected};
use crate::Vec3;
use drape_kernels::lanes::{Four, Lanes as Quad, Plain};
use drape_kernels::triples::{Triple, Triples as _};
use drape_kernels::vector::SLOTS;

/// Springs of a batch: the arrays stay in the first-level cache.
const BATCH: usize = 64;

/// Memory of a sweep: one register per particle and vector.
#[derive(Debug, Default)]
pub(crate) struct Quads {
    x: Vec<Quad>,
    v: Vec<Quad>,
    out: Vec<Quad>,
}

impl Quads {
    /// Memory for springs between this many particles.
    pub(crate) fn new(particles: usize) -> Self {
        let zeros = || vec![[0.0; 4]; particles];
        Self { x: zeros(), v: zeros(), out: zeros() }
    }

    /// Number of particles that have memory.
    pub(crate) fn particles(&self) -> usize {
        self.x.len()
    }
}

/// Adds the forces of `passes`, N, to `out` or to zero. Springs along diagonals are ignored.
pub(crate) fn add(
    passes: &[Option<Pass<'_>>],
    quads: &mut Quads,
    x: &[Vec3],
    v: &[Vec3],
    out: &mut [Vec3],
    begin: Begin,
) {
    #[cfg(target_arch = "x86_64")]
    if let Some(kernel) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(kernel, Batches { kernel, passes, quads, x, v, out, begin });
    }
    pulp::Arch::new().dispatch(Batches { kernel: InArrays, passes, quads, x, v, out, begin });
}

/// How the forces of springs are computed.
trait Kernel: Copy {
    /// Adds `−g (x_i − x_j)` of each spring, plus `−c (v_i − v_j)` if they are damped.
    fn add_forces<const DAMPED: bool>(
        self,
        list: &Listed,
        law: Law,
        x: &[Quad],
        v: &[Quad],
        sums: &mut [Quad],
    );

    /// Adds projected damping, `−c û û·(v_i − v_j)`, of each spring.
    fn add_along(self, list: &Listed, x: &[Quad], v: &[Quad], sums: &mut [Quad]);
}

/// In batches that are kept in arrays, for any processor.
#[derive(Clone, Copy)]
struct InArrays;

struct Batches<'a, K> {
    kernel: K,
    passes: &'a [Option<Pass<'a>>],
    quads: &'a mut Quads,
    x: &'a [Vec3],
    v: &'a [Vec3],
    out: &'a mut [Vec3],
    begin: Begin,
}

impl<K: Kernel> pulp::WithSimd for Batches<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { kernel, passes, quads, x, v, out, mut begin } = self;
        let Quads { x: x4, v: v4, out: sums } = quads;
        widen(x, x4);
        if passes.iter().flatten().any(|pass| matches!(pass, Pass::Listed(s) if s.law.is_damped()))
        {
            widen(v, v4);
        }
        match begin {
            Begin::Present => widen(out, sums),
            Begin::Zero => sums.fill([0.0; 4]),
        }
        for pass in passes.iter().flatten() {
            match pass {
                Pass::Listed(springs) => {
                    let list = springs.list;
                    match springs.law {
                        Law::Spring => kernel.add_forces::<false>(list, Law::Spring, x4, v4, sums),
                        Law::DampedSpring => {
                            kernel.add_forces::<true>(list, Law::Spring, x4, v4, sums)
                        }
                        Law::Nonlinear => {
                            kernel.add_forces::<false>(list, Law::Nonlinear, x4, v4, sums)
                        }
                        Law::Linear => add_weighted(list, &list.stiffness, x4, sums),
                        Law::Damping => add_weighted(list, &list.damping, v4, sums),
                        Law::Projected => kernel.add_along(list, x4, v4, sums),
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
        let (out, rest) = out.split_at_mut(sums.len().min(out.len()));
        begin.clear(rest);
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

/// Adds `−f` to the first end, and `f` to the other.
#[inline(always)]
fn add_to_ends(sums: &mut [Quad], [i, j]: [u32; 2], f: &Quad) {
    sums[i as usize] = minus(&sums[i as usize], f);
    sums[j as usize] = plus(&sums[j as usize], f);
}

impl Kernel for InArrays {
    #[inline(always)]
    fn add_forces<const DAMPED: bool>(
        self,
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
                add_to_ends(sums, [i, j], &f);
            }
        }
    }

    #[inline(always)]
    fn add_along(self, list: &Listed, x: &[Quad], v: &[Quad], sums: &mut [Quad]) {
        add_along(Plain, list, x, v, sums);
    }
}

/// Projected damping of four springs at a time, and of the rest one by one.
#[inline(always)]
fn add_along<F: Four>(four: F, list: &Listed, x: &[Quad], v: &[Quad], sums: &mut [Quad]) {
    // One check of a particle's index serves all vectors.
    let n = x.len();
    let (v, sums) = (&v[..n], &mut sums[..n]);
    let whole = list.ends.len() / SLOTS * SLOTS;
    let parameters = list.rest_length.as_chunks::<SLOTS>().0.iter().zip(list.damping.as_chunks().0);
    for (ends, (rest, damping)) in list.ends.as_chunks::<SLOTS>().0.iter().zip(parameters) {
        let (d, w) = (differences(four, x, ends), differences(four, v, ends));
        let [x, y, z] = along(four, four.load(*rest), four.load(*damping), d, w);
        let [a, b, c, d] = four.transpose([x, y, z, four.splat(0.0)]);
        add_at_ends(four, sums, ends[0], a);
        add_at_ends(four, sums, ends[1], b);
        add_at_ends(four, sums, ends[2], c);
        add_at_ends(four, sums, ends[3], d);
    }
    for t in whole..list.ends.len() {
        let [i, j] = list.ends[t].map(|end| end as usize);
        let (d, w) = (minus(&x[i], &x[j]), minus(&v[i], &v[j]));
        let (d, w) = (Vec3::new(d[0], d[1], d[2]), Vec3::new(w[0], w[1], w[2]));
        let f = projected(list.rest_length[t], list.damping[t], d, w);
        add_to_ends(sums, list.ends[t], &[f.x, f.y, f.z, 0.0]);
    }
}

/// The differences of the ends of four springs, coordinate by coordinate.
// Closures and `map` would not be compiled for the registers.
#[inline(always)]
fn differences<F: Four>(four: F, from: &[Quad], [a, b, c, d]: &[[u32; 2]; SLOTS]) -> Triple<F> {
    let [a, b] = [difference(four, from, *a), difference(four, from, *b)];
    let [c, d] = [difference(four, from, *c), difference(four, from, *d)];
    let [x, y, z, _] = four.transpose([a, b, c, d]);
    [x, y, z]
}

#[inline(always)]
fn difference<F: Four>(four: F, from: &[Quad], [i, j]: [u32; 2]) -> F::Numbers {
    four.sub(four.load(from[i as usize]), four.load(from[j as usize]))
}

/// Adds `−f` to the first end, and `f` to the other.
#[inline(always)]
fn add_at_ends<F: Four>(four: F, sums: &mut [Quad], [i, j]: [u32; 2], f: F::Numbers) {
    sums[i as usize] = four.store(four.sub(four.load(sums[i as usize]), f));
    sums[j as usize] = four.store(four.add(four.load(sums[j as usize]), f));
}

/// `c û û·w` of four springs with the differences `d` and `w` of their ends.
#[inline(always)]
fn along<F: Four>(
    four: F,
    rest: F::Numbers,
    damping: F::Numbers,
    d: Triple<F>,
    w: Triple<F>,
) -> Triple<F> {
    let length = four.sqrt(four.dot(d, d));
    let collapsed = four.mul(four.splat(COLLAPSED), rest);
    let zero = four.splat(0.0);
    let mut u = four.over(d, length);
    for u in &mut u {
        *u = four.where_at_most(length, collapsed, zero, *u);
        // A length that is no number has no direction.
        *u = four.where_at_most(length, four.splat(f64::INFINITY), *u, zero);
    }
    four.times(u, four.mul(damping, four.dot(u, w)))
}

/// Adds the force of one spring.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn add_one<const DAMPED: bool>(
    list: &Listed,
    t: usize,
    law: Law,
    x: &[Quad],
    v: &[Quad],
    sums: &mut [Quad],
) {
    let [i, j] = list.ends[t];
    let d = minus(&x[i as usize], &x[j as usize]);
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    let mut f = times(&d, factor(length, list.rest_length[t], list.stiffness[t], law));
    if DAMPED {
        f = plus(&f, &times(&minus(&v[i as usize], &v[j as usize]), list.damping[t]));
    }
    add_to_ends(sums, [i, j], &f);
}

/// The factor of a spring.
#[inline(always)]
fn factor(length: f64, rest_length: f64, stiffness: f64, law: Law) -> f64 {
    let far = length > COLLAPSED * rest_length;
    law.stiffness(stiffness, if far { rest_length / length } else { 0.0 })
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
        g[t] = factor(squares[t].sqrt(), rest_length[t], stiffness[t], law);
    }
}

/// Adds `−w (x_i − x_j)` of each spring.
#[inline(always)]
fn add_weighted(list: &Listed, weights: &[f64], x: &[Quad], sums: &mut [Quad]) {
    for (&[i, j], &w) in list.ends.iter().zip(weights) {
        let f = times(&minus(&x[i as usize], &x[j as usize]), w);
        add_to_ends(sums, [i, j], &f);
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::effects::springs::Spring;
    use crate::effects::springs::sweep::ListedSprings;
    use drape_kernels::testing::{Random, assert_same_bits};

    /// The sums of both kernels.
    fn both(list: &Listed, law: Law, n: usize) -> Option<[Vec<Vec3>; 2]> {
        let mut random = Random::new(1);
        let (mut x, v, start) = (random.vectors(n), random.vectors(n), random.vectors(n));
        x[1] = x[0]; // a collapsed spring has no direction
        let passes = [Some(Pass::Listed(ListedSprings { list, law }))];
        let [mut in_arrays, mut in_registers] = [(); 2].map(|()| start.clone());
        let quads = &mut Quads::new(n);
        let (passes, x, v, begin) = (&passes[..], &x[..], &v[..], Begin::Present);
        let out = &mut in_arrays[..];
        let kernel = InArrays;
        pulp::Arch::new().dispatch(Batches { kernel, passes, quads, x, v, out, begin });
        let kernel = pulp::x86::V3::try_new()?;
        let out = &mut in_registers[..];
        pulp::Simd::vectorize(kernel, Batches { kernel, passes, quads, x, v, out, begin });
        Some([in_arrays, in_registers])
    }

    #[test]
    fn registers_give_the_bits_of_arrays_for_any_number_of_springs() {
        for count in (0..20_u32).chain([63, 64, 65, 200]) {
            let n = count + 2;
            let springs: Vec<Spring> = (0..count)
                .map(|t| Spring {
                    i: t,
                    j: if t == 0 { 1 } else { (t * 7 + 3) % t },
                    rest_length: 0.3 + 0.01 * f64::from(t),
                    stiffness: 7.3 - 0.02 * f64::from(t),
                    damping: 0.2,
                })
                .collect();
            let list = Listed::new(&springs);
            for law in Law::ALL {
                let Some([in_arrays, in_registers]) = both(&list, law, n as usize) else { return };
                assert_same_bits((count, law), &in_arrays, &in_registers);
            }
        }
    }
}
