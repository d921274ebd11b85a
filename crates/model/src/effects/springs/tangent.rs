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
//! # What it costs
//!
//! A spring takes a square root, 4 divisions, 50 flops for block and force, 6 for the sum of
//! forces, 12 for the blocks at its ends, and 9 for full damping. The matrix takes 6 numbers per
//! spring here, and 36 in compressed rows.

use super::diagonals::Diagonal;
use super::sweep::{Block, GROUP, Pass, Plan, Sums, Window, springs};
use super::{COLLAPSED, Vec3};
use crate::Tangent;
use drape_kernels::blocks::BandPlanes;
use drape_kernels::lanes::WIDEST;
use drape_kernels::planes::{join, split};

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

/// Overwrites `matrix` with `M + σ K + τ D` and adds `K w` to `product`, if it is given. The passes
/// must [fit](Window::fits) the window, and their offsets must be bands of the matrix, no two of
/// them equal.
pub(crate) fn add(
    passes: &[Option<Pass<'_>>],
    window: &mut Window,
    mass: &[f64],
    at: &Linearised<'_>,
    matrix: BandPlanes<'_>,
    product: Option<StiffnessProduct<'_>>,
) {
    let n = mass.len();
    let lengths = product.as_ref().map_or([n; 2], |p| [p.w.len(), p.out.len()]);
    assert!(at.x.len() == n && lengths == [n; 2], "one vector a particle");
    pulp::Arch::new().dispatch(Sweep { passes, window, mass, at, matrix, product });
}

struct Sweep<'a> {
    passes: &'a [Option<Pass<'a>>],
    window: &'a mut Window,
    mass: &'a [f64],
    at: &'a Linearised<'a>,
    matrix: BandPlanes<'a>,
    product: Option<StiffnessProduct<'a>>,
}

impl pulp::WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self { passes, window, mass, at, matrix, product } = self;
        let particles = springs(passes).map(|p| p.diagonals.particles).max().unwrap_or(0);
        let x: &[f64] = bytemuck::cast_slice(at.x);
        // Without a product the kernel computes the forces of any vector, and nothing reads them.
        let (w, mut out): (&[f64], Option<&mut [f64]>) = match product {
            Some(StiffnessProduct { w, out }) => {
                (bytemuck::cast_slice(w), Some(bytemuck::cast_slice_mut(out)))
            }
            None => (x, None),
        };
        let (chunk, ahead) = (window.chunk, window.ahead);
        let plan = Plan::new(passes, 0);
        let mut block = window.block();
        let mut sums = Sums([[0.0; GROUP]; 3]);
        if particles > chunk {
            block.forget();
        }
        let (diagonal, bands) = matrix.planes.split_at_mut(6 * matrix.stride);
        let mut blocks = Blocks {
            diagonal,
            bands,
            stride: matrix.stride,
            lead: matrix.lead,
            offsets: matrix.offsets,
        };
        let mut begin = 0;
        while begin < particles {
            block.read(0, x, begin, chunk, ahead, begin > 0);
            block.read(3, w, begin, chunk, ahead, begin > 0);
            let end = particles.min(begin + chunk);
            for i in (begin..end).step_by(ROWS) {
                let m = ROWS.min(end - i);
                let padded = m.next_multiple_of(WIDEST);
                blocks.compute(passes, &mut block, at, i, i - begin, padded);
                blocks.gather(passes, at.damping_scale, &mass[i..i + m], i);
                blocks.damp(passes, at.damping_scale, i, m);
                if let Some(out) = &mut out {
                    let out = &mut out[3 * i..3 * (i + m)];
                    split(sums.0.as_flattened_mut(), GROUP, out);
                    block.gather(simd, &plan, begin, i - begin, padded, &mut sums);
                    join(sums.0.as_flattened(), GROUP, out);
                }
            }
            begin += chunk;
            if begin < particles {
                block.slide(passes, chunk);
            }
        }
        blocks.without_springs(&mass[particles..], particles);
    }
}

/// Rows of the matrix that a sweep computes, then gathers, at a time: their blocks stay in the
/// first-level cache.
const ROWS: usize = GROUP;

/// Which of the six numbers of a block are on its diagonal.
const AXES: [bool; 6] = [true, false, false, true, false, true];

/// The arrays of a matrix.
struct Blocks<'a> {
    diagonal: &'a mut [f64],
    bands: &'a mut [f64],
    stride: usize,
    lead: usize,
    offsets: &'a [usize],
}

impl Blocks<'_> {
    /// Where the planes of a diagonal are among the bands.
    #[inline(always)]
    fn band(&self, d: &Diagonal) -> usize {
        6 * self.stride * self.offsets.iter().position(|o| *o == d.offset).unwrap_or(0)
    }

    /// Computes `−S` of the springs of `m` particles, and the opposite of their forces.
    #[inline(always)]
    fn compute(
        &mut self,
        passes: &[Option<Pass<'_>>],
        window: &mut Block<'_>,
        at: &Linearised<'_>,
        particle: usize,
        in_window: usize,
        m: usize,
    ) {
        let (coordinates, mut forces) = window.group(in_window, m);
        for d in springs(passes).flat_map(|pass| &pass.diagonals.list) {
            let first = self.band(d);
            let row = self.lead + particle;
            let mut planes = self.bands[first..]
                .chunks_exact_mut(self.stride)
                .map(|plane| &mut plane[row..][..m]);
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
            let present = &d.present[particle..particle + m];
            let scale = at.stiffness_scale;
            match at.tangent {
                Tangent::Exact => {
                    let law = |t: f64| t;
                    blocks_and_forces(
                        d, scale, law, present, own, other, xx, xy, xz, yy, yz, zz, fx, fy, fz,
                    );
                }
                Tangent::Projected => {
                    let law = |t: f64| t.max(0.0);
                    blocks_and_forces(
                        d, scale, law, present, own, other, xx, xy, xz, yy, yz, zz, fx, fy, fz,
                    );
                }
            }
        }
    }

    /// Sums up the diagonal blocks of particles: their masses and the blocks of their springs.
    #[inline(always)]
    fn gather(&mut self, passes: &[Option<Pass<'_>>], scale: f64, mass: &[f64], particle: usize) {
        let m = mass.len();
        let row = self.lead + particle;
        for (c, on_axis) in AXES.into_iter().enumerate() {
            let mut sums = [0.0; ROWS];
            let sums = &mut sums[..m];
            if on_axis {
                sums.copy_from_slice(mass);
            }
            for pass in springs(passes) {
                let list = &pass.diagonals.list;
                let incoming = || pass.diagonals.incoming.iter().map(|&d| &list[d]);
                let side = |d: &Diagonal, back: usize| {
                    &self.bands[self.band(d) + c * self.stride + row - back..][..m]
                };
                for d in incoming() {
                    subtract(sums, side(d, d.offset));
                }
                for d in list {
                    subtract(sums, side(d, 0));
                }
                if on_axis && pass.law.is_damped() {
                    for d in incoming() {
                        let before = d.offset.saturating_sub(particle).min(m);
                        let from = particle + before - d.offset.min(particle + before);
                        let present = &d.present[from..][..m - before];
                        add_where(&mut sums[before..], present, scale * d.damping);
                    }
                    for d in list {
                        add_where(sums, &d.present[particle..][..m], scale * d.damping);
                    }
                }
            }
            self.diagonal[c * self.stride + row..][..m].copy_from_slice(sums);
        }
    }

    /// Adds full damping to the blocks whose other end is among `m` particles: no sum needs `S`
    /// from them any more.
    #[inline(always)]
    fn damp(&mut self, passes: &[Option<Pass<'_>>], scale: f64, particle: usize, m: usize) {
        for pass in springs(passes).filter(|pass| pass.law.is_damped()) {
            for d in &pass.diagonals.list {
                let first = self.band(d) + self.lead;
                let from = particle.saturating_sub(d.offset);
                let to = (particle + m).saturating_sub(d.offset);
                for (c, _) in AXES.into_iter().enumerate().filter(|(_, on_axis)| *on_axis) {
                    let plane = &mut self.bands[first + c * self.stride..][from..to];
                    add_where(plane, &d.present[from..to], -(scale * d.damping));
                }
            }
        }
    }

    /// The masses of particles without springs.
    fn without_springs(&mut self, mass: &[f64], particle: usize) {
        for (c, on_axis) in AXES.into_iter().enumerate() {
            let plane = &mut self.diagonal[c * self.stride + self.lead + particle..][..mass.len()];
            if on_axis { plane.copy_from_slice(mass) } else { plane.fill(0.0) }
        }
    }
}

/// `−S` and `−K w` of a vector of springs between `own` and `other` ends, each `x`, `y`, `z` of
/// positions and of `w`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one slice a coordinate: no two may overlap")]
fn blocks_and_forces(
    d: &Diagonal,
    scale: f64,
    law: impl Fn(f64) -> f64,
    present: &[u8],
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
    let m = present.len();
    let (own, other) = (own.map(|a| &a[..m]), other.map(|a| &a[..m]));
    let (xx, xy, xz) = (&mut xx[..m], &mut xy[..m], &mut xz[..m]);
    let (yy, yz, zz) = (&mut yy[..m], &mut yz[..m], &mut zz[..m]);
    let (fx, fy, fz) = (&mut fx[..m], &mut fy[..m], &mut fz[..m]);
    for t in 0..m {
        let difference = |axis: usize| own[axis][t] - other[axis][t];
        let direction =
            unit_block([difference(0), difference(1), difference(2)], d.rest_length, &law);
        let k = f64::from(present[t]) * d.stiffness;
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

/// `xx, xy, xz, yy, yz, zz` of `ûûᵀ + a (I − ûûᵀ)` for ends that are `d` apart, where `law` maps
/// `1 − ℓ/L` to `a`.
#[inline(always)]
pub(super) fn unit_block(
    [dx, dy, dz]: [f64; 3],
    rest_length: f64,
    law: &impl Fn(f64) -> f64,
) -> [f64; 6] {
    let length = (dx * dx + dy * dy + dz * dz).sqrt();
    let far = length > COLLAPSED * rest_length;
    let over_length = |a: f64| if far { a / length } else { 0.0 };
    let across = law(1.0 - over_length(rest_length));
    let (ux, uy, uz) = (over_length(dx), over_length(dy), over_length(dz));
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

/// Adds `a` where a spring is.
#[inline(always)]
fn add_where(sums: &mut [f64], present: &[u8], a: f64) {
    for (sum, here) in sums.iter_mut().zip(present) {
        *sum += f64::from(*here) * a;
    }
}
