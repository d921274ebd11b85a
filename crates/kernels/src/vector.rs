//! Block vectors: one `Vec3` per particle, and the few operations that conjugate gradients need.
//!
//! # One order of summation
//!
//! Floating-point addition is not associative, so a sum is only reproducible if its order is part
//! of its definition:
//!
//! 1. The particles are cut into blocks of [`BLOCK`] (the last one may be shorter).
//! 2. A block has twelve accumulators that start at zero, one for each of [`SLOTS`] = 4 slots and 3
//!    coordinates. Particle `i` of the block adds its three products to slot `i mod 4`, in order of
//!    increasing `i`.
//! 3. The sum of slot `s` is `p_s = (x_s + y_s) + z_s`; the block's is `(p_0 + p_1) + (p_2 + p_3)`.
//! 4. The blocks' sums are added from the first to the last.
//!
//! Products and sums are rounded separately (no fused multiply-add). The twelve accumulators are
//! independent and lie in memory order, so they fit SIMD registers of 2 or 4 lanes without a
//! shuffle. Different threads can sum the blocks. SIMD and threads give the same bits as this code.

use crate::Vec3;
use crate::bands::{PerBlock, in_bands};
use crate::lanes::{Four, four_wide, vectorised};

/// Number of particles in a block, the unit that one thread sums.
pub const BLOCK: usize = 256;

/// Number of particles in a group, each with accumulators of its own.
pub const SLOTS: usize = 4;

/// Numbers that [`weighted_sum`] keeps in registers at a time.
const CHUNK: usize = 32;

/// The dot product over all particles and coordinates, Σ aᵢ·bᵢ, in the order of the
/// [module's text](self).
///
/// ```
/// use drape_kernels::{Vec3, vector::dot};
/// let a = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 1.0, 0.0)];
/// assert_eq!(dot(&a, &a), 15.0);
/// ```
///
/// # Panics
/// When the lengths differ.
pub fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    assert_eq!(a.len(), b.len(), "block vectors of different length");
    vectorised!(four_wide(), [four,
        a: &'k [f64] = bytemuck::cast_slice(a),
        b: &'k [f64] = bytemuck::cast_slice(b),
    ] -> f64 {
        let mut total = 0.0;
        for (a, b) in a.chunks(3 * BLOCK).zip(b.chunks(3 * BLOCK)) {
            total += dot_of_block(four, a, b);
        }
        total
    })
}

/// As [`dot`], in so many [`bands`](crate::bands), with the same bits. `sums` is scratch, one
/// number a [`BLOCK`] of particles.
///
/// # Panics
/// When the lengths differ.
pub fn dot_in_bands(bands: usize, a: &[Vec3], b: &[Vec3], sums: &mut [f64]) -> f64 {
    if bands < 2 {
        return dot(a, b);
    }
    assert_eq!(a.len(), b.len(), "block vectors of different length");
    assert_eq!(sums.len(), a.len().div_ceil(BLOCK), "one sum a block");
    in_bands(bands, a.len(), PerBlock(&mut *sums), &|band, PerBlock(sums)| {
        for (sum, first) in sums.iter_mut().zip(band.clone().step_by(BLOCK)) {
            let block = first..band.end.min(first + BLOCK);
            *sum = dot(&a[block.clone()], &b[block]);
        }
    });
    sums.iter().fold(0.0, |total, sum| total + sum)
}

/// The accumulators of a block lie in three registers in the order of memory: four particles are
/// three loads.
#[inline(always)]
fn dot_of_block(four: impl Four, a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [four.splat(0.0); 3];
    let (a, a_rest) = a.as_chunks::<12>();
    let (b, b_rest) = b.as_chunks::<12>();
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a.as_chunks().0, b.as_chunks().0);
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum = four.add(*sum, four.mul(four.load(*a), four.load(*b)));
        }
    }
    let mut sums = [four.store(sums[0]), four.store(sums[1]), four.store(sums[2])];
    for (sum, (a, b)) in sums.as_flattened_mut().iter_mut().zip(a_rest.iter().zip(b_rest)) {
        *sum += a * b;
    }
    let sums = sums.as_flattened().as_chunks::<3>().0;
    combine(&[sums[0], sums[1], sums[2], sums[3]])
}

/// The weighted dot product Σ wᵢ aᵢ·bᵢ with one weight per particle; every term is `(wᵢ aᵢₖ) bᵢₖ`,
/// summed in the order of [`dot`].
///
/// # Panics
/// When the lengths differ.
pub fn weighted_dot(w: &[f64], a: &[Vec3], b: &[Vec3]) -> f64 {
    assert_eq!(w.len(), a.len(), "one weight a particle");
    assert_eq!(a.len(), b.len(), "block vectors of different length");
    let mut total = 0.0;
    for ((w, a), b) in w.chunks(BLOCK).zip(a.chunks(BLOCK)).zip(b.chunks(BLOCK)) {
        let mut sums = [[0.0; 3]; SLOTS];
        for ((w, a), b) in w.chunks(SLOTS).zip(a.chunks(SLOTS)).zip(b.chunks(SLOTS)) {
            for (((sum, w), a), b) in sums.iter_mut().zip(w).zip(a).zip(b) {
                for k in 0..3 {
                    sum[k] += w * a[k] * b[k];
                }
            }
        }
        total += combine(&sums);
    }
    total
}

/// As [`weighted_dot`], in so many [`bands`](crate::bands), with the same bits. `sums` is scratch,
/// one number a [`BLOCK`] of particles.
///
/// # Panics
/// When the lengths differ.
pub fn weighted_dot_in_bands(
    bands: usize,
    w: &[f64],
    a: &[Vec3],
    b: &[Vec3],
    sums: &mut [f64],
) -> f64 {
    if bands < 2 {
        return weighted_dot(w, a, b);
    }
    assert_eq!([w.len(), a.len()], [b.len(); 2], "one weight a particle");
    assert_eq!(sums.len(), a.len().div_ceil(BLOCK), "one sum a block");
    in_bands(bands, a.len(), PerBlock(&mut *sums), &|band, PerBlock(sums)| {
        for (sum, first) in sums.iter_mut().zip(band.clone().step_by(BLOCK)) {
            let block = first..band.end.min(first + BLOCK);
            *sum = weighted_dot(&w[block.clone()], &a[block.clone()], &b[block]);
        }
    });
    sums.iter().fold(0.0, |total, sum| total + sum)
}

/// Step 3 of the summation: twelve accumulators become one number.
#[inline(always)]
pub fn combine(sums: &[[f64; 3]; SLOTS]) -> f64 {
    let slot = |s: usize| (sums[s][0] + sums[s][1]) + sums[s][2];
    (slot(0) + slot(1)) + (slot(2) + slot(3))
}

/// The Euclidean norm √(a·a).
pub fn norm(a: &[Vec3]) -> f64 {
    dot(a, a).sqrt()
}

/// `y ← y + alpha x`.
///
/// # Panics
/// When the lengths differ.
pub fn axpy(alpha: f64, x: &[Vec3], y: &mut [Vec3]) {
    update(x, y, |x, y| y + alpha * x);
}

/// `y ← x + beta y`, the update of a search direction.
///
/// # Panics
/// When the lengths differ.
pub fn scale_add(beta: f64, x: &[Vec3], y: &mut [Vec3]) {
    update(x, y, |x, y| x + beta * y);
}

/// `y ← b − y`, which turns a product `A x` into a residual.
///
/// # Panics
/// When the lengths differ.
pub fn subtract_from(b: &[Vec3], y: &mut [Vec3]) {
    update(b, y, |b, y| b - y);
}

/// `out ← 2 x − y`, the next term of an arithmetic progression.
///
/// # Panics
/// When the lengths differ.
pub fn extrapolate(x: &[Vec3], y: &[Vec3], out: &mut [Vec3]) {
    assert_eq!([x.len(), y.len()], [out.len(); 2], "block vectors of different length");
    vectorised!(pulp::Arch::new(), [_four,
        x: &'k [f64] = bytemuck::cast_slice(x),
        y: &'k [f64] = bytemuck::cast_slice(y),
        out: &'k mut [f64] = bytemuck::cast_slice_mut(out),
    ] -> () {
        for ((out, x), y) in out.iter_mut().zip(x).zip(y) {
            *out = 2.0 * x - y;
        }
    });
}

/// `out ← ((y + c₀ k₀) + c₁ k₁) + …` over the terms `(cᵢ, kᵢ)` in their order, with 0 for an absent
/// `y`: a stage of a Runge-Kutta method in one pass.
///
/// # Panics
/// When the lengths differ.
pub fn weighted_sum(y: Option<&[Vec3]>, terms: &[(f64, &[Vec3])], out: &mut [Vec3]) {
    for k in y.iter().chain(terms.iter().map(|(_, k)| k)) {
        assert_eq!(k.len(), out.len(), "block vectors of different length");
    }
    vectorised!(pulp::Arch::new(), [_four,
        y: Option<&'k [f64]> = y.map(bytemuck::cast_slice),
        terms: &'k [(f64, &'k [Vec3])] = terms,
        out: &'k mut [f64] = bytemuck::cast_slice_mut(out),
    ] -> () {
        let (chunks, rest) = out.as_chunks_mut::<CHUNK>();
        for (at, out) in chunks.iter_mut().enumerate() {
            let mut sum = match y {
                Some(y) => y.as_chunks().0[at],
                None => [0.0; CHUNK],
            };
            for (c, k) in terms {
                let k: &[f64] = bytemuck::cast_slice(k);
                let k: &[f64; CHUNK] = &k.as_chunks().0[at];
                for (sum, k) in sum.iter_mut().zip(k) {
                    *sum += k * c;
                }
            }
            *out = sum;
        }
        let begin = CHUNK * chunks.len();
        for (at, out) in (begin..).zip(rest) {
            let mut sum = y.map_or(0.0, |y| y[at]);
            for (c, k) in terms {
                let k: &[f64] = bytemuck::cast_slice(k);
                sum += k[at] * c;
            }
            *out = sum;
        }
    });
}

/// `y ← w x + alpha y` with one weight per particle.
///
/// # Panics
/// When the lengths differ.
pub fn weighted_scale_add(w: &[f64], x: &[Vec3], alpha: f64, y: &mut [Vec3]) {
    weighted_update(w, x, y, |w, x, y| w * x + alpha * y);
}

/// `y ← y + (alpha / w) x` with one weight per particle.
///
/// # Panics
/// When the lengths differ.
pub fn divided_axpy(alpha: f64, w: &[f64], x: &[Vec3], y: &mut [Vec3]) {
    weighted_update(w, x, y, |w, x, y| y + x * (alpha / w));
}

/// `y ← f(x, y)`, number by number, compiled for the present processor.
#[inline]
fn update(x: &[Vec3], y: &mut [Vec3], f: impl Fn(f64, f64) -> f64) {
    assert_eq!(x.len(), y.len(), "block vectors of different length");
    pulp::Arch::new().dispatch(Update {
        x: bytemuck::cast_slice(x),
        y: bytemuck::cast_slice_mut(y),
        f,
    });
}

struct Update<'a, F> {
    x: &'a [f64],
    y: &'a mut [f64],
    f: F,
}

impl<F: Fn(f64, f64) -> f64> pulp::WithSimd for Update<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for (y, x) in self.y.iter_mut().zip(self.x) {
            *y = (self.f)(*x, *y);
        }
    }
}

/// As [`update`] with one weight per particle, `y ← f(w, x, y)`.
#[inline]
fn weighted_update(w: &[f64], x: &[Vec3], y: &mut [Vec3], f: impl Fn(f64, f64, f64) -> f64) {
    assert_eq!([w.len(), x.len()], [y.len(); 2], "block vectors of different length");
    pulp::Arch::new().dispatch(WeightedUpdate {
        w,
        x: bytemuck::cast_slice(x),
        y: bytemuck::cast_slice_mut(y),
        f,
    });
}

struct WeightedUpdate<'a, F> {
    w: &'a [f64],
    x: &'a [f64],
    y: &'a mut [f64],
    f: F,
}

impl<F: Fn(f64, f64, f64) -> f64> pulp::WithSimd for WeightedUpdate<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { w, x, y, f } = self;
        let particles = x.as_chunks::<3>().0.iter().zip(y.as_chunks_mut::<3>().0);
        for (w, (x, y)) in w.iter().zip(particles) {
            *y = [f(*w, x[0], y[0]), f(*w, x[1], y[1]), f(*w, x[2], y[2])];
        }
    }
}

/// The readable forms, which give the bits of the fast ones.
pub mod reference {
    use super::{BLOCK, SLOTS};
    use crate::Vec3;

    /// Σ (wᵢ aᵢ)·bᵢ in the order of the [module's text](super), number by number; without weights
    /// Σ aᵢ·bᵢ.
    pub fn dot(w: Option<&[f64]>, a: &[Vec3], b: &[Vec3]) -> f64 {
        let mut total = 0.0;
        for begin in (0..a.len()).step_by(BLOCK) {
            let end = a.len().min(begin + BLOCK);
            let mut sums = [0.0_f64; 3 * SLOTS];
            for flat in 0..3 * (end - begin) {
                let (i, k) = (begin + flat / 3, flat % 3);
                let left = w.map_or(a[i][k], |w| w[i] * a[i][k]);
                sums[flat % (3 * SLOTS)] += left * b[i][k];
            }
            let p = |s: usize| sums[3 * s] + sums[3 * s + 1] + sums[3 * s + 2];
            total += (p(0) + p(1)) + (p(2) + p(3));
        }
        total
    }

    /// `out ← ((y + c₀ k₀) + c₁ k₁) + …`, number by number.
    pub fn weighted_sum(y: Option<&[Vec3]>, terms: &[(f64, &[Vec3])], out: &mut [Vec3]) {
        for i in 0..out.len() {
            let begin = y.map_or(Vec3::zeros(), |y| y[i]);
            out[i] = terms.iter().fold(begin, |sum, (c, k)| sum + k[i] * *c);
        }
    }

    /// `y ← f(w, x, y)` for each coordinate of each particle.
    pub fn update(w: &[f64], x: &[Vec3], y: &mut [Vec3], f: impl Fn(f64, f64, f64) -> f64) {
        for i in 0..y.len() {
            for k in 0..3 {
                y[i][k] = f(w[i], x[i][k], y[i][k]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Random, assert_same_bits};

    #[test]
    fn sums_have_the_documented_order_bit_for_bit() {
        let mut random = Random::new(1);
        for n in (0..40).chain([255, 256, 257, 511, 512, 513, 1000, 1023, 2000]) {
            let (a, b, w) = (random.vectors(n), random.vectors(n), random.units(n));
            let mut sums = vec![f64::NAN; n.div_ceil(BLOCK)];
            for bands in [1, 2, 5] {
                let shared = dot_in_bands(bands, &a, &b, &mut sums);
                assert_same_bits((n, bands), &reference::dot(None, &a, &b), &shared);
                let shared = weighted_dot_in_bands(bands, &w, &a, &b, &mut sums);
                assert_same_bits((n, bands), &reference::dot(Some(&w), &a, &b), &shared);
            }
            assert_same_bits(n, &reference::dot(Some(&w), &a, &b), &weighted_dot(&w, &a, &b));
        }
    }

    #[test]
    fn a_weighted_sum_has_the_bits_of_the_readable_loop() {
        let mut random = Random::new(7);
        for n in [0, 1, 2, 10, 11, 12, 31, 32, 33, 100, 257] {
            let all: Vec<_> = (0..13).map(|_| random.vectors(n)).collect();
            for count in 0..all.len() {
                let factors = random.units(count);
                let terms = factors.iter().zip(&all[1..]);
                let terms: Vec<_> = terms.map(|(c, k)| (*c, k.as_slice())).collect();
                for y in [None, Some(all[0].as_slice())] {
                    let mut outs = [vec![Vec3::repeat(f64::NAN); n], vec![Vec3::zeros(); n]];
                    reference::weighted_sum(y, &terms, &mut outs[0]);
                    weighted_sum(y, &terms, &mut outs[1]);
                    assert_same_bits((n, count), &outs[0], &outs[1]);
                }
            }
        }
    }

    #[test]
    fn the_order_matters_for_the_bits() {
        // A left-to-right sum differs: without this the test above could not fail.
        let mut random = Random::new(2);
        let (a, b) = (random.vectors(2000), random.vectors(2000));
        let left_to_right: f64 = a.iter().zip(&b).map(|(a, b)| a.dot(b)).sum();
        assert_ne!(dot(&a, &b).to_bits(), left_to_right.to_bits());
        assert!((dot(&a, &b) - left_to_right).abs() < 1e-11);
    }

    /// `y ← f(w, x, y)`, by its name: the formula, and what computes it fast.
    type Row = (&'static str, fn(f64, f64, f64) -> f64, fn(&[f64], &[Vec3], &mut [Vec3]));

    const UPDATES: [Row; 6] = [
        ("axpy", |_, x, y| y + 0.3 * x, |_, x, y| axpy(0.3, x, y)),
        ("scale_add", |_, x, y| x + 0.3 * y, |_, x, y| scale_add(0.3, x, y)),
        ("subtract_from", |_, x, y| x - y, |_, x, y| subtract_from(x, y)),
        ("extrapolate", |_, x, y| 2.0 * x - y, |_, x, y| extrapolate(x, &Vec::from(&*y), y)),
        ("weighted", |w, x, y| w * x + 0.3 * y, |w, x, y| weighted_scale_add(w, x, 0.3, y)),
        ("divided", |w, x, y| y + x * (0.3 / w), |w, x, y| divided_axpy(0.3, w, x, y)),
    ];

    #[test]
    fn updates_of_any_length_give_the_bits_of_their_formulas() {
        let mut random = Random::new(3);
        for n in (0..40).chain([255, 1000]) {
            let (x, y, w) = (random.vectors(n), random.vectors(n), random.units(n));
            for (name, formula, update) in UPDATES {
                let [mut expected, mut fast] = [(); 2].map(|()| y.clone());
                reference::update(&w, &x, &mut expected, formula);
                update(&w, &x, &mut fast);
                assert_same_bits((name, n), &expected, &fast);
            }
        }
        assert_eq!(norm(&[Vec3::new(2.0, 3.0, 6.0)]), 7.0);
    }
}
