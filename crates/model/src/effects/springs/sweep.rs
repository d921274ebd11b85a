//! The fast kernel for springs along diagonals.
//!
//! # How it goes
//!
//! Positions and velocities are read into one array a coordinate, so that eight particles fill a vector register.
//! For each diagonal the forces of all its springs are computed at once and kept:
//! `f_i = g (x_i − x_{i+o})` with `g` after the [`Law`], and `c (v_i − v_{i+o})`. Then each particle takes what its
//! springs left: `+f_{i−o}` for those that come from earlier particles, `−f_i` for its own.
//!
//! A sum has the order of the [readable loops](super::LinearSprings::add_one_by_one), in which particle `i` is met first
//! by its incoming springs, by falling offset, then by its own; all forces of an effect before its damping. Each spring
//! is computed once and its force taken twice with opposite signs, as there. So the results are the same bits. A
//! place without a spring has `k = 0` and `c = 0` and adds a zero, which changes no sum.
//!
//! The arrays are a window that slides over the particles: it fits the second-level cache whatever the size of the sheet, and
//! remembers the forces of the last `o` springs of each diagonal. Each system has one, so that a sweep allocates
//! nothing. The loops are plain Rust; [`pulp`] compiles them for the vector units that the processor has. Rust
//! contracts no product and sum into one rounding, so that the width of the registers leaves no trace.
//!
//! # What it costs
//!
//! For a spring with full damping: 8 flops for the length, a square root, a division, 6 for the force, 6 for the
//! damping, 12 for the sums. A square root and a division of eight numbers take 27 cycles of a Zen 4 core, 0.9 ns a spring, and
//! are half of the time. In main memory: 24 bytes a particle for `x`, 24 for `v`, 48 for the sum, 1 for each diagonal.

use super::diagonals::{Diagonal, Diagonals};
use super::{COLLAPSED, Vec3};

/// Particles that are computed, then gathered, at a time: their forces stay in the first-level cache.
const GROUP: usize = 128;
/// The window is a multiple of this many particles; vector registers hold so many numbers or fewer.
const LANES: usize = 8;

/// The factor `g` of `−g (x_i − x_j)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Law {
    /// `k (1 − ℓ/L)`: the force of the spring, EEH (11).
    Spring,
    /// `−k ℓ/L`: what is left of it without its linear part, EEH (13).
    Nonlinear,
    /// `k`: the linear part, EEH (12).
    Linear,
}

impl Law {
    /// `g` for a spring of stiffness `k` with the quotient `ℓ/L`, N/m.
    #[inline(always)]
    pub(crate) fn stiffness(self, k: f64, rest_over_length: f64) -> f64 {
        match self {
            Self::Spring => k * (1.0 - rest_over_length),
            Self::Nonlinear => -(k * rest_over_length),
            Self::Linear => k,
        }
    }
}

/// What a sweep takes of one effect: a force of its springs, their full damping, or both, in this order.
#[derive(Clone, Copy, Debug)]
pub struct Pass<'a> {
    pub(crate) diagonals: &'a Diagonals,
    pub(crate) law: Option<Law>,
    pub(crate) is_damped: bool,
}

impl Pass<'_> {
    /// Arrays of forces that the pass fills: three a diagonal and kind.
    fn planes(&self) -> usize {
        3 * self.diagonals.list.len()
            * (usize::from(self.law.is_some()) + usize::from(self.is_damped))
    }
}

/// Memory of a sweep: coordinates ahead of the present particles, forces behind them.
#[derive(Debug, Default)]
pub(crate) struct Window {
    /// Particles that the window moves on by.
    chunk: usize,
    /// Forces that are remembered from before the chunk, at least the largest offset.
    history: usize,
    /// Coordinates that are read beyond the chunk.
    ahead: usize,
    /// `x`, `y`, `z` of positions, then of velocities; [`Self::stride`] each.
    coordinates: Vec<f64>,
    /// Forces; [`Self::stride`] each.
    forces: Vec<f64>,
}

impl Window {
    /// A window for sweeps over any of these springs.
    pub(crate) fn new<'a>(all: impl Iterator<Item = &'a Diagonals>) -> Self {
        let (mut reach, mut planes, mut particles) = (0, 0, 0);
        for diagonals in all {
            reach = reach.max(diagonals.reach());
            planes += 6 * diagonals.list.len();
            particles = particles.max(diagonals.particles);
        }
        if planes == 0 {
            return Self::default();
        }
        let up = |n: usize| n.next_multiple_of(GROUP);
        let chunk = up(particles).min(up((4 * reach).clamp(512, 2560).max(reach)));
        let history = reach.next_multiple_of(LANES);
        let ahead = history + LANES;
        let mut window = Self { chunk, history, ahead, ..Self::default() };
        window.coordinates = vec![0.0; 6 * window.stride()];
        window.forces = vec![0.0; planes * window.stride()];
        window
    }

    /// Whether these passes can share a sweep with this window.
    pub(crate) fn fits<'a>(&self, passes: impl Iterator<Item = &'a Pass<'a>> + Clone) -> bool {
        let same = |particles: usize| passes.clone().all(|p| p.diagonals.particles == particles);
        let planes: usize = passes.clone().map(Pass::planes).sum();
        let reach = passes.clone().map(|pass| pass.diagonals.reach()).max().unwrap_or(0);
        passes.clone().next().is_none_or(|first| same(first.diagonals.particles))
            && reach <= self.history
            && planes * self.stride() <= self.forces.len()
    }

    /// Distance of two arrays. Five cache lines more than a page, lest the same place of all of them falls
    /// into the same set of the cache.
    fn stride(&self) -> usize {
        (self.chunk + self.history + self.ahead).next_multiple_of(512) + 40
    }
}

/// Adds what `passes` ask for to `out`, N. The passes [fit](Window::fits) the window.
pub(crate) fn add(
    passes: &[Option<Pass<'_>>],
    window: &mut Window,
    x: &[Vec3],
    v: &[Vec3],
    out: &mut [Vec3],
) {
    let Some(first) = passes.iter().flatten().next() else { return };
    let particles = first.diagonals.particles;
    assert!(x.len() >= particles && v.len() >= particles && out.len() >= particles);
    pulp::Arch::new().dispatch(Sweep {
        passes,
        particles,
        window,
        x: bytemuck::cast_slice(x),
        v: passes.iter().flatten().any(|pass| pass.is_damped).then_some(bytemuck::cast_slice(v)),
        out: bytemuck::cast_slice_mut(out),
    });
}

struct Sweep<'a> {
    passes: &'a [Option<Pass<'a>>],
    particles: usize,
    window: &'a mut Window,
    x: &'a [f64],
    v: Option<&'a [f64]>,
    out: &'a mut [f64],
}

impl pulp::WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { passes, particles, window, x, v, out } = self;
        let stride = window.stride();
        let &mut Window { chunk, history, ahead, ref mut coordinates, ref mut forces } = window;
        let mut block = Block { stride, history, coordinates, forces };
        if particles > chunk {
            block.forget();
        }
        let mut sums = [0.0; 3 * GROUP];
        let mut begin = 0;
        while begin < particles {
            let fresh = if begin == 0 { 0 } else { ahead };
            block.read(0, x, begin, fresh, chunk, ahead, begin > 0);
            if let Some(v) = v {
                block.read(3, v, begin, fresh, chunk, ahead, begin > 0);
            }
            let end = particles.min(begin + chunk);
            let mut i = begin;
            while i < end {
                let m = GROUP.min(end - i);
                let padded = m.next_multiple_of(LANES);
                block.compute(passes, i, i - begin, padded);
                let out = &mut out[3 * i..3 * (i + m)];
                split(&mut sums, GROUP, m, out);
                block.gather(passes, i - begin, padded, &mut sums);
                join(&sums, GROUP, m, out);
                i += GROUP;
            }
            begin += chunk;
            if begin < particles {
                block.slide(passes, chunk);
            }
        }
    }
}

/// The arrays of a window.
struct Block<'a> {
    stride: usize,
    history: usize,
    coordinates: &'a mut [f64],
    forces: &'a mut [f64],
}

impl Block<'_> {
    /// No force is remembered.
    fn forget(&mut self) {
        for plane in self.forces.chunks_mut(self.stride) {
            plane[..self.history].fill(0.0);
        }
    }

    /// Reads coordinates of `chunk + ahead` particles from `begin` into three arrays, of which the first `fresh` are there
    /// already, `chunk` places further on. Beyond the last particle there are zeros.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "positions of a window in two arrays")]
    fn read(
        &mut self,
        first_plane: usize,
        from: &[f64],
        begin: usize,
        fresh: usize,
        chunk: usize,
        ahead: usize,
        slid: bool,
    ) {
        let planes = &mut self.coordinates[first_plane * self.stride..][..3 * self.stride];
        if slid {
            for plane in planes.chunks_exact_mut(self.stride) {
                plane.copy_within(chunk..chunk + ahead, 0);
            }
        }
        let n = from.len() / 3;
        let there = (begin + fresh).min(n);
        let end = (begin + chunk + ahead).min(n);
        split(&mut planes[there - begin..], self.stride, end - there, &from[3 * there..3 * end]);
        for plane in planes.chunks_exact_mut(self.stride) {
            plane[end - begin..chunk + ahead].fill(0.0);
        }
    }

    /// The forces of the springs of `m` particles.
    #[inline(always)]
    fn compute(&mut self, passes: &[Option<Pass<'_>>], particle: usize, at: usize, m: usize) {
        let Self { stride, history, ref coordinates, ref mut forces } = *self;
        let ends = |axis: usize, offset: usize| {
            let plane = &coordinates[axis * stride..][..stride];
            (&plane[at..at + m], &plane[at + offset..at + offset + m])
        };
        let mut planes =
            forces.chunks_exact_mut(stride).map(|plane| &mut plane[history + at..][..m]);
        for pass in passes.iter().flatten() {
            if let Some(law) = pass.law {
                for d in &pass.diagonals.list {
                    let (Some(fx), Some(fy), Some(fz)) =
                        (planes.next(), planes.next(), planes.next())
                    else {
                        return;
                    };
                    let ((x, x2), (y, y2), (z, z2)) =
                        (ends(0, d.offset), ends(1, d.offset), ends(2, d.offset));
                    let present = &d.present[particle..particle + m];
                    match law {
                        Law::Spring => {
                            let law = |k, q| Law::Spring.stiffness(k, q);
                            spring_forces(d, law, present, x, y, z, x2, y2, z2, fx, fy, fz);
                        }
                        Law::Nonlinear => {
                            let law = |k, q| Law::Nonlinear.stiffness(k, q);
                            spring_forces(d, law, present, x, y, z, x2, y2, z2, fx, fy, fz);
                        }
                        Law::Linear => {
                            weighted_differences(d.stiffness, present, x, x2, fx);
                            weighted_differences(d.stiffness, present, y, y2, fy);
                            weighted_differences(d.stiffness, present, z, z2, fz);
                        }
                    }
                }
            }
            if pass.is_damped {
                for d in &pass.diagonals.list {
                    for axis in 3..6 {
                        let Some(f) = planes.next() else { return };
                        let (v, v2) = ends(axis, d.offset);
                        let present = &d.present[particle..particle + m];
                        weighted_differences(d.damping, present, v, v2, f);
                    }
                }
            }
        }
    }

    /// Adds to the sums of `m` particles what their springs left.
    #[inline(always)]
    fn gather(
        &self,
        passes: &[Option<Pass<'_>>],
        at: usize,
        m: usize,
        sums: &mut [f64; 3 * GROUP],
    ) {
        let at = self.history + at;
        let side = |plane: usize, back: usize| &self.forces[plane * self.stride + at - back..][..m];
        let mut first = 0;
        for pass in passes.iter().flatten() {
            let Diagonals { list, incoming, .. } = pass.diagonals;
            let kind = 3 * list.len();
            let own = |first: usize, d: usize, axis: usize| side(first + 3 * d + axis, 0);
            let other = |first: usize, d: usize, axis: usize| {
                let d = incoming[d];
                side(first + 3 * d + axis, list[d].offset)
            };
            for (axis, sum) in sums.chunks_exact_mut(GROUP).enumerate() {
                let sum = &mut sum[..m];
                match (list.len(), pass.planes() / kind) {
                    (2, 2) => take_twice(
                        sum,
                        other(first, 0, axis),
                        other(first, 1, axis),
                        own(first, 0, axis),
                        own(first, 1, axis),
                        other(first + kind, 0, axis),
                        other(first + kind, 1, axis),
                        own(first + kind, 0, axis),
                        own(first + kind, 1, axis),
                    ),
                    (2, 1) => take(
                        sum,
                        other(first, 0, axis),
                        other(first, 1, axis),
                        own(first, 0, axis),
                        own(first, 1, axis),
                    ),
                    (_, kinds) => {
                        for k in 0..kinds {
                            let first = first + k * kind;
                            (0..list.len()).for_each(|d| take_from(sum, other(first, d, axis)));
                            (0..list.len()).for_each(|d| give(sum, own(first, d, axis)));
                        }
                    }
                }
            }
            first += pass.planes();
        }
    }

    /// Moves the window on: the last forces become the first ones.
    fn slide(&mut self, passes: &[Option<Pass<'_>>], chunk: usize) {
        let mut planes = self.forces.chunks_exact_mut(self.stride);
        for pass in passes.iter().flatten() {
            let kinds = pass.planes() / (3 * pass.diagonals.list.len());
            for d in (0..kinds).flat_map(|_| &pass.diagonals.list) {
                for plane in planes.by_ref().take(3) {
                    let from = self.history - d.offset;
                    plane.copy_within(from + chunk..self.history + chunk, from);
                }
            }
        }
    }
}

/// `f = g (x − x2)` for a vector of springs.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one slice a coordinate: no two may overlap")]
fn spring_forces(
    d: &Diagonal,
    law: impl Fn(f64, f64) -> f64,
    present: &[u8],
    x: &[f64],
    y: &[f64],
    z: &[f64],
    x2: &[f64],
    y2: &[f64],
    z2: &[f64],
    fx: &mut [f64],
    fy: &mut [f64],
    fz: &mut [f64],
) {
    let m = present.len();
    let (x, y, z) = (&x[..m], &y[..m], &z[..m]);
    let (x2, y2, z2) = (&x2[..m], &y2[..m], &z2[..m]);
    let (fx, fy, fz) = (&mut fx[..m], &mut fy[..m], &mut fz[..m]);
    let collapsed = COLLAPSED * d.rest_length;
    for t in 0..m {
        let (dx, dy, dz) = (x[t] - x2[t], y[t] - y2[t], z[t] - z2[t]);
        let length = (dx * dx + dy * dy + dz * dz).sqrt();
        let rest_over_length = if length > collapsed { d.rest_length / length } else { 0.0 };
        let g = law(f64::from(present[t]) * d.stiffness, rest_over_length);
        fx[t] = dx * g;
        fy[t] = dy * g;
        fz[t] = dz * g;
    }
}

/// `f = w (a − b)` where a spring is, else 0.
#[inline(always)]
fn weighted_differences(w: f64, present: &[u8], a: &[f64], b: &[f64], f: &mut [f64]) {
    let m = present.len();
    let (a, b, f) = (&a[..m], &b[..m], &mut f[..m]);
    for t in 0..m {
        f[t] = (a[t] - b[t]) * (f64::from(present[t]) * w);
    }
}

/// Two incoming and two own springs.
#[inline(always)]
fn take(sum: &mut [f64], a: &[f64], b: &[f64], c: &[f64], d: &[f64]) {
    let m = sum.len();
    let (a, b, c, d) = (&a[..m], &b[..m], &c[..m], &d[..m]);
    for t in 0..m {
        sum[t] = sum[t] + a[t] + b[t] - c[t] - d[t];
    }
}

/// As [`take`], with force and damping.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one slice a summand: no two may overlap")]
fn take_twice(
    sum: &mut [f64],
    a: &[f64],
    b: &[f64],
    c: &[f64],
    d: &[f64],
    a2: &[f64],
    b2: &[f64],
    c2: &[f64],
    d2: &[f64],
) {
    let m = sum.len();
    let (a, b, c, d) = (&a[..m], &b[..m], &c[..m], &d[..m]);
    let (a2, b2, c2, d2) = (&a2[..m], &b2[..m], &c2[..m], &d2[..m]);
    for t in 0..m {
        sum[t] = sum[t] + a[t] + b[t] - c[t] - d[t] + a2[t] + b2[t] - c2[t] - d2[t];
    }
}

#[inline(always)]
fn take_from(sum: &mut [f64], a: &[f64]) {
    sum.iter_mut().zip(a).for_each(|(sum, a)| *sum += a);
}

#[inline(always)]
fn give(sum: &mut [f64], a: &[f64]) {
    sum.iter_mut().zip(a).for_each(|(sum, a)| *sum -= a);
}

/// Vectors of `m` particles into one array a coordinate, `stride` apart.
#[inline(always)]
fn split(planes: &mut [f64], stride: usize, m: usize, from: &[f64]) {
    let (x, rest) = planes.split_at_mut(stride);
    let (y, z) = rest.split_at_mut(stride);
    split_three(&mut x[..m], &mut y[..m], &mut z[..m], &from[..3 * m]);
}

#[inline(always)]
fn split_three(x: &mut [f64], y: &mut [f64], z: &mut [f64], from: &[f64]) {
    let m = x.len();
    let (y, z, from) = (&mut y[..m], &mut z[..m], &from[..3 * m]);
    for t in 0..m {
        x[t] = from[3 * t];
        y[t] = from[3 * t + 1];
        z[t] = from[3 * t + 2];
    }
}

/// The inverse of [`split`].
#[inline(always)]
fn join(planes: &[f64], stride: usize, m: usize, to: &mut [f64]) {
    let (x, y, z) = (&planes[..m], &planes[stride..][..m], &planes[2 * stride..][..m]);
    let to = &mut to[..3 * m];
    for t in 0..m {
        to[3 * t] = x[t];
        to[3 * t + 1] = y[t];
        to[3 * t + 2] = z[t];
    }
}
