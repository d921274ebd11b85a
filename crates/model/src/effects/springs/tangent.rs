//! The matrix of a linearised step, and a product with its stiffness, in one sweep along diagonals.
//!
//! # How it goes
//!
//! The window of [`super::sweep`] brings positions `x` and a vector `w`. For each diagonal the
//! sweep computes the blocks `S = σ k [ûûᵀ + (1 − ℓ/L)(I − ûûᵀ)]` of all its springs at once, and
//! keeps them with the opposite sign in their places beside the main diagonal of the matrix. With
//! them it computes the forces `k [ûûᵀ + …] (w_i − w_j)`. Then each particle sums up the blocks and
//! forces of its springs. Full damping adds the same multiple of the identity for all springs of a
//! diagonal. The sweep adds it beside the main diagonal as soon as the particles at both ends have
//! read `S` there.
//!
//! A sum has the order of the reference form, which goes through [`BlockSink`](crate::BlockSink): a
//! particle meets its incoming springs first, by falling offset, and then its own; all stiffnesses
//! of an effect come before its damping. So both forms give the same bits.
//!
//! Threads share the rows in bands. A band needs the blocks and forces of the springs that lead
//! into it from the rows before, which belong to another band, so it computes them once more into
//! memory of its own. Full damping waits for the end of the band where the particles that read `S`
//! belong to the next one. So each number of the matrix comes from the same operations for any
//! number of bands.
//!
//! # What it costs
//!
//! A spring takes a square root, 4 divisions, 50 flops for block and force, 6 for the sum of
//! forces, 12 for the blocks at its ends, and 9 for full damping. The matrix takes 6 numbers per
//! spring here, and 36 in compressed rows.

use super::diagonals::{Diagonal, MAX_DIAGONALS};
use super::sweep::{Block, GROUP, MAX_PASSES, Pass, Plan, Sums, Window, Windows, springs};
use super::{COLLAPSED, Vec3};
use crate::Tangent;
use drape_kernels::bands::{Divisible, in_bands, split_each};
use drape_kernels::blocks::BandPlanes;
use drape_kernels::lanes::WIDEST;
use drape_kernels::planes::{join, split};
use drape_kernels::vector::BLOCK;
use std::ops::Range;

/// `M + σ K + τ D` at positions `x`, with `K = −∂f/∂x` and `D = −∂f/∂v`.
#[derive(Clone, Copy, Debug)]
pub struct Linearised<'a> {
    /// Positions at which `K` is taken, m.
    pub x: &'a [Vec3],
    /// Which second derivative of the energy `K` is.
    pub tangent: Tangent,
    /// Factor `σ` of `K`.
    pub stiffness_scale: f64,
    /// Factor `τ` of `D`.
    pub damping_scale: f64,
}

/// A product `K w` that a sweep computes beside the matrix.
#[derive(Debug)]
pub struct StiffnessProduct<'a> {
    /// The vector `w`, m; one entry per particle.
    pub w: &'a [Vec3],
    /// The vector to which `K w` is added, N.
    pub out: &'a mut [Vec3],
}

/// Overwrites `matrix` with `M + σ K + τ D` and adds `K w` to `product`, if it is given, on as many
/// threads as there are windows. The passes must [fit](Windows::fits), and their offsets must be
/// the bands of the matrix, no two of them equal.
pub(crate) fn add(
    passes: &[Option<Pass<'_>>],
    windows: &Windows,
    mass: &[f64],
    at: &Linearised<'_>,
    matrix: BandPlanes<'_>,
    product: Option<StiffnessProduct<'_>>,
) {
    let bands = windows.bands(particles(passes));
    add_in_bands(bands, passes, windows, mass, at, matrix, product);
}

/// As [`add`], in a given number of bands. No band may be shorter than the longest offset of a
/// spring, rounded up to a multiple of [`WIDEST`].
pub(super) fn add_in_bands(
    bands: usize,
    passes: &[Option<Pass<'_>>],
    windows: &Windows,
    mass: &[f64],
    at: &Linearised<'_>,
    matrix: BandPlanes<'_>,
    product: Option<StiffnessProduct<'_>>,
) {
    let n = mass.len();
    let lengths = product.as_ref().map_or([n; 2], |p| [p.w.len(), p.out.len()]);
    assert!(at.x.len() == n && lengths == [n; 2], "one vector a particle");
    let x: &[f64] = bytemuck::cast_slice(at.x);
    // Without a product the kernel computes the forces of any vector, and nothing reads them.
    let (w, out): (&[f64], Option<&mut [f64]>) = match product {
        Some(StiffnessProduct { w, out }) => {
            (bytemuck::cast_slice(w), Some(bytemuck::cast_slice_mut(out)))
        }
        None => (x, None),
    };
    let BandPlanes { planes, stride, lead, offsets } = matrix;
    let planes = planes.chunks_exact_mut(stride).map(|plane| &mut plane[lead..]);
    let part = Part { rows: Rows::new(0, planes), out };
    let particles = particles(passes);
    in_bands(bands, particles, part, &|range, Part { rows, out }| {
        let window = &mut *windows.free();
        let rows = Rows { first: range.start, ..rows };
        pulp::Arch::new().dispatch(Sweep {
            passes,
            range,
            window,
            mass,
            at,
            offsets,
            x,
            w,
            rows,
            out,
        });
    });
}

/// One more than the last particle that has a spring.
fn particles(passes: &[Option<Pass<'_>>]) -> usize {
    springs(passes).map(|pass| pass.diagonals.particles).max().unwrap_or(0)
}

/// What a band writes: its rows of the matrix and of the product.
struct Part<'a> {
    rows: Rows<'a>,
    out: Option<&'a mut [f64]>,
}

impl Divisible for Part<'_> {
    fn split(self, blocks: usize) -> (Self, Self) {
        let (rows, other_rows) = self.rows.split(blocks * BLOCK);
        let (out, other_out) = self.out.map(|out| out.split_at_mut(3 * blocks * BLOCK)).unzip();
        (Self { rows, out }, Self { rows: other_rows, out: other_out })
    }
}

struct Sweep<'a> {
    passes: &'a [Option<Pass<'a>>],
    /// Particles whose rows the sweep computes.
    range: Range<usize>,
    window: &'a mut Window,
    mass: &'a [f64],
    at: &'a Linearised<'a>,
    /// Offsets of the bands of the matrix.
    offsets: &'a [usize],
    x: &'a [f64],
    w: &'a [f64],
    /// The rows of the range, and padding behind the last one of all.
    rows: Rows<'a>,
    out: Option<&'a mut [f64]>,
}

impl pulp::WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self { passes, range, window, mass, at, offsets, x, w, mut rows, mut out } = self;
        let particles = particles(passes);
        let (chunk, history, ahead) = (window.chunk, window.history, window.ahead);
        let plan = Plan::new(passes, 0);
        let (mut block, kept, kept_stride) = window.block_and_kept();
        let mut sums = Sums([[0.0; GROUP]; 3]);
        let damping = at.damping_scale;
        let read = |block: &mut Block<'_>, begin: usize, slid: bool| {
            block.read(0, x, begin, chunk, ahead, slid);
            block.read(3, w, begin, chunk, ahead, slid);
        };
        let mut before = None;
        if range.start > 0 {
            // Springs that lead from before the range into it.
            let first = range.start - history;
            let planes = kept.chunks_exact_mut(kept_stride);
            let mut rows = Rows::new(first, (0..6).map(|_| <&mut [f64]>::default()).chain(planes));
            read(&mut block, first, false);
            for i in (0..history).step_by(ROWS) {
                rows.compute(passes, offsets, &mut block, at, first + i, i, ROWS.min(history - i));
            }
            block.slide(passes, history);
            before = Some(rows);
        } else if particles > chunk {
            block.forget();
        }
        let mut begin = range.start;
        while begin < range.end {
            read(&mut block, begin, begin > range.start);
            let end = range.end.min(begin + chunk);
            for i in (begin..end).step_by(ROWS) {
                let m = ROWS.min(end - i);
                let padded = m.next_multiple_of(WIDEST);
                rows.compute(passes, offsets, &mut block, at, i, i - begin, padded);
                rows.gather(passes, offsets, before.as_ref(), damping, &mass[i..i + m], i);
                rows.damp(passes, offsets, damping, |offset| {
                    i.saturating_sub(offset)..(i + m).saturating_sub(offset)
                });
                if let Some(out) = &mut out {
                    let out = &mut out[3 * (i - range.start)..][..3 * m];
                    split(sums.0.as_flattened_mut(), GROUP, out);
                    block.gather(simd, &plan, begin, i - begin, padded, &mut sums);
                    join(sums.0.as_flattened(), GROUP, out);
                }
            }
            begin += chunk;
            if begin < range.end {
                block.slide(passes, chunk);
            }
        }
        if range.end < particles {
            // The next band has blocks of its own for the springs that lead into it.
            rows.damp(passes, offsets, damping, |offset| {
                range.end.saturating_sub(offset)..range.end
            });
        } else {
            rows.without_springs(&mass[particles..], particles);
        }
    }
}

/// Rows of the matrix that a sweep computes, then gathers, at a time: their blocks stay in the
/// first-level cache.
const ROWS: usize = GROUP;

/// Which of the six numbers of a block are on its diagonal.
const AXES: [bool; 6] = [true, false, false, true, false, true];

/// Most planes of a matrix: six for the diagonal, six for each band.
const MOST_PLANES: usize = 6 * (1 + MAX_PASSES * MAX_DIAGONALS);

/// Some rows of the planes of a matrix.
struct Rows<'a> {
    /// Particle of the first row.
    first: usize,
    /// Six planes for the diagonal, then six for each band; empty where there is no band.
    planes: [&'a mut [f64]; MOST_PLANES],
}

impl<'a> Rows<'a> {
    fn new(first: usize, planes: impl Iterator<Item = &'a mut [f64]>) -> Self {
        let mut rows = Self { first, planes: std::array::from_fn(|_| <&mut [f64]>::default()) };
        rows.planes.iter_mut().zip(planes).for_each(|(to, plane)| *to = plane);
        rows
    }

    /// Splits off the first `count` rows; returns them and the rest.
    fn split(self, count: usize) -> (Self, Self) {
        let Self { first, planes } = self;
        let [planes, others] = split_each(planes, count);
        (Self { first, planes }, Self { first: first + count, planes: others })
    }

    /// Computes `−S` of the springs of `m` particles, and the opposite of their forces.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "of what, with what, where and whereto")]
    fn compute(
        &mut self,
        passes: &[Option<Pass<'_>>],
        offsets: &[usize],
        window: &mut Block<'_>,
        at: &Linearised<'_>,
        particle: usize,
        in_window: usize,
        m: usize,
    ) {
        let (coordinates, mut forces) = window.group(in_window, m);
        for d in springs(passes).flat_map(|pass| &pass.diagonals.list) {
            let row = particle - self.first;
            let mut planes =
                self.planes[band(offsets, d)..].iter_mut().map(|plane| &mut plane[row..][..m]);
            let mut block = || planes.next();
            let (Some(xx), Some(xy), Some(xz), Some(yy), Some(yz), Some(zz)) =
                (block(), block(), block(), block(), block(), block())
            else {
                return;
            };
            let (Some(fx), Some(fy), Some(fz)) = (forces.next(), forces.next(), forces.next())
            else {
                return;
            };
            let own = coordinates.of(0, m);
            let other = coordinates.of(d.offset, m);
            let multiple = &d.multiple[particle..particle + m];
            let scale = at.stiffness_scale;
            match at.tangent {
                Tangent::Exact => {
                    let law = |t: f64| t;
                    blocks_and_forces(
                        d, scale, law, multiple, own, other, xx, xy, xz, yy, yz, zz, fx, fy, fz,
                    );
                }
                Tangent::Projected => {
                    let law = |t: f64| t.max(0.0);
                    blocks_and_forces(
                        d, scale, law, multiple, own, other, xx, xy, xz, yy, yz, zz, fx, fy, fz,
                    );
                }
            }
        }
    }

    /// Sums up the diagonal blocks of particles: their masses and the blocks of their springs.
    /// `before` are the last rows before these, as [computed](Self::compute); without them there
    /// are none.
    #[inline(always)]
    fn gather(
        &mut self,
        passes: &[Option<Pass<'_>>],
        offsets: &[usize],
        before: Option<&Rows<'_>>,
        scale: f64,
        mass: &[f64],
        particle: usize,
    ) {
        let m = mass.len();
        let row = particle - self.first;
        for (c, on_axis) in AXES.into_iter().enumerate() {
            let mut sums = [0.0; ROWS];
            let sums = &mut sums[..m];
            if on_axis {
                sums.copy_from_slice(mass);
            }
            for pass in springs(passes) {
                let list = &pass.diagonals.list;
                let incoming = || pass.diagonals.incoming.iter().map(|&d| &list[d]);
                for d in incoming() {
                    let plane = band(offsets, d) + c;
                    // So many of the springs lead from before these rows.
                    let outside = d.offset.saturating_sub(row).min(m);
                    if outside > 0
                        && let Some(before) = before
                    {
                        let from = particle - d.offset - before.first;
                        subtract(&mut sums[..outside], &before.planes[plane][from..][..outside]);
                    }
                    let from = (row + outside).saturating_sub(d.offset);
                    subtract(&mut sums[outside..], &self.planes[plane][from..][..m - outside]);
                }
                for d in list {
                    subtract(sums, &self.planes[band(offsets, d) + c][row..][..m]);
                }
                if on_axis && pass.law.is_damped() {
                    for d in incoming() {
                        let before = d.offset.saturating_sub(particle).min(m);
                        let from = particle + before - d.offset.min(particle + before);
                        let multiple = &d.multiple[from..][..m - before];
                        add_multiples(&mut sums[before..], multiple, scale * d.damping);
                    }
                    for d in list {
                        add_multiples(sums, &d.multiple[particle..][..m], scale * d.damping);
                    }
                }
            }
            self.planes[c][row..][..m].copy_from_slice(sums);
        }
    }

    /// Adds full damping to the blocks of some particles' springs of each offset, those of them
    /// that lie in these rows: no sum may need `S` from them any more.
    #[inline(always)]
    fn damp(
        &mut self,
        passes: &[Option<Pass<'_>>],
        offsets: &[usize],
        scale: f64,
        particles: impl Fn(usize) -> Range<usize>,
    ) {
        for pass in springs(passes).filter(|pass| pass.law.is_damped()) {
            for d in &pass.diagonals.list {
                let Range { start, end } = particles(d.offset);
                let start = start.max(self.first);
                let end = end.max(start);
                let rows = start - self.first..end - self.first;
                for (c, _) in AXES.into_iter().enumerate().filter(|(_, on_axis)| *on_axis) {
                    let plane = &mut self.planes[band(offsets, d) + c][rows.clone()];
                    add_multiples(plane, &d.multiple[start..end], -(scale * d.damping));
                }
            }
        }
    }

    /// The masses of particles without springs.
    fn without_springs(&mut self, mass: &[f64], particle: usize) {
        for (c, on_axis) in AXES.into_iter().enumerate() {
            let plane = &mut self.planes[c][particle - self.first..][..mass.len()];
            if on_axis { plane.copy_from_slice(mass) } else { plane.fill(0.0) }
        }
    }
}

/// Which plane is the first one of a diagonal.
#[inline(always)]
fn band(offsets: &[usize], d: &Diagonal) -> usize {
    6 * (1 + offsets.iter().position(|o| *o == d.offset).unwrap_or(0))
}

/// `−S` and `−K w` of a vector of springs between `own` and `other` ends, each `x`, `y`, `z` of
/// positions and of `w`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one slice a coordinate: no two may overlap")]
fn blocks_and_forces(
    d: &Diagonal,
    scale: f64,
    law: impl Fn(f64) -> f64,
    multiple: &[u8],
    own: [&[f64]; 6],
    other: [&[f64]; 6],
    xx: &mut [f64],
    xy: &mut [f64],
    xz: &mut [f64],
    yy: &mut [f64],
    yz: &mut [f64],
    zz: &mut [f64],
    fx: &mut [f64],
    fy: &mut [f64],
    fz: &mut [f64],
) {
    let m = multiple.len();
    let (own, other) = (own.map(|a| &a[..m]), other.map(|a| &a[..m]));
    let (xx, xy, xz) = (&mut xx[..m], &mut xy[..m], &mut xz[..m]);
    let (yy, yz, zz) = (&mut yy[..m], &mut yz[..m], &mut zz[..m]);
    let (fx, fy, fz) = (&mut fx[..m], &mut fy[..m], &mut fz[..m]);
    for t in 0..m {
        let difference = |axis: usize| own[axis][t] - other[axis][t];
        let d_t = [difference(0), difference(1), difference(2)];
        let (u, across) = unit_direction(d_t, d.rest_length, &law);
        let direction = unit_block(u, across);
        let k = f64::from(multiple[t]) * d.stiffness;
        let s = direction.map(|b| 0.0 - b * (scale * k));
        (xx[t], xy[t], xz[t]) = (s[0], s[1], s[2]);
        (yy[t], yz[t], zz[t]) = (s[3], s[4], s[5]);
        let b = direction.map(|b| b * k);
        let (wx, wy, wz) = (difference(3), difference(4), difference(5));
        fx[t] = -(b[0] * wx + b[1] * wy + b[2] * wz);
        fy[t] = -(b[1] * wx + b[3] * wy + b[4] * wz);
        fz[t] = -(b[2] * wx + b[4] * wy + b[5] * wz);
    }
}

/// `û` and the factor `a` of `ûûᵀ + a (I − ûûᵀ)` for ends that are `d` apart, where `law` maps
/// `1 − ℓ/L` to `a`. The direction of a collapsed spring is 0.
#[inline(always)]
pub(super) fn unit_direction(
    [dx, dy, dz]: [f64; 3],
    rest_length: f64,
    law: &impl Fn(f64) -> f64,
) -> ([f64; 3], f64) {
    let length = (dx * dx + dy * dy + dz * dz).sqrt();
    let far = length > COLLAPSED * rest_length;
    let over_length = |a: f64| if far { a / length } else { 0.0 };
    let across = law(1.0 - over_length(rest_length));
    ([over_length(dx), over_length(dy), over_length(dz)], across)
}

/// `xx, xy, xz, yy, yz, zz` of `ûûᵀ + a (I − ûûᵀ)`.
#[inline(always)]
pub(super) fn unit_block([ux, uy, uz]: [f64; 3], across: f64) -> [f64; 6] {
    let along = 1.0 - across;
    [
        ux * ux * along + across,
        ux * uy * along + 0.0,
        ux * uz * along + 0.0,
        uy * uy * along + across,
        uy * uz * along + 0.0,
        uz * uz * along + across,
    ]
}

#[inline(always)]
fn subtract(sums: &mut [f64], a: &[f64]) {
    for (sum, a) in sums.iter_mut().zip(a) {
        *sum -= a;
    }
}

/// Adds `a` for each of the weakest spring's multiples.
#[inline(always)]
fn add_multiples(sums: &mut [f64], multiple: &[u8], a: f64) {
    for (sum, here) in sums.iter_mut().zip(multiple) {
        *sum += f64::from(*here) * a;
    }
}
