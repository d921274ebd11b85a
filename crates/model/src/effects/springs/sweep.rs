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

mod loops;

use self::loops::{
    Ends, add_scaled, give, spring_forces, spring_forces_and_take, spring_forces_and_take_twice,
    take, take_from, take_twice, weighted_differences,
};
pub(super) use self::loops::{join, split};
use super::diagonals::{Diagonal, Diagonals};
use super::listed::Listed;
use super::{COLLAPSED, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Fewest particles for which waking other threads takes less time than they save.
const LEAST_FOR_THREADS: usize = 16_384;
/// Most effects that one sweep takes together.
pub(crate) const MAX_PASSES: usize = 4;
/// Most particles that are computed, then gathered, at a time.
pub(super) const GROUP: usize = 512;
/// The window is a multiple of this many particles; vector registers hold so many numbers or fewer.
pub(super) const LANES: usize = 8;

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

/// What a sweep takes of one effect.
#[derive(Clone, Copy, Debug)]
pub enum Pass<'a> {
    /// Springs along diagonals.
    Springs(Springs<'a>),
    /// Springs in any order.
    Listed(ListedSprings<'a>),
    /// The same acceleration for all.
    Field(Field<'a>),
}

/// A force of springs, their full damping, or both, in this order.
#[derive(Clone, Copy, Debug)]
pub struct Springs<'a> {
    pub(crate) diagonals: &'a Diagonals,
    pub(crate) law: Option<Law>,
    pub(crate) is_damped: bool,
}

/// As [`Springs`], for springs in any order.
#[derive(Clone, Copy, Debug)]
pub struct ListedSprings<'a> {
    pub(crate) list: &'a Listed,
    pub(crate) law: Option<Law>,
    pub(crate) is_damped: bool,
}

/// `f_i = m_i g`.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    pub(crate) acceleration: Vec3,
    pub(crate) mass: &'a [f64],
}

impl<'a> Pass<'a> {
    /// The springs, if it is such.
    #[inline(always)]
    pub(crate) fn springs(&self) -> Option<&Springs<'a>> {
        match self {
            Self::Springs(springs) => Some(springs),
            Self::Listed(_) | Self::Field(_) => None,
        }
    }
}

/// Two incoming, then two own springs' forces: an array, and how far back in it.
type Sides = [(usize, usize); 4];

impl Springs<'_> {
    /// One for the forces and one for the damping.
    fn kinds(&self) -> usize {
        usize::from(self.law.is_some()) + usize::from(self.is_damped)
    }

    /// Arrays of forces that the pass fills: three a diagonal and kind.
    fn planes(&self) -> usize {
        3 * self.diagonals.list.len() * self.kinds()
    }

    /// With two diagonals: what one coordinate of the sums takes, arrays of forces and how far back in them, of each kind.
    /// `first` is the array of the first diagonal's force in this coordinate.
    #[inline(always)]
    fn pairs(&self, first: usize) -> Option<(Sides, Option<Sides>)> {
        let Diagonals { list, incoming, .. } = self.diagonals;
        let ([a, b], &[c, d]) = (list.as_slice(), incoming.as_slice()) else { return None };
        let offset = [a.offset, b.offset];
        let sides = |first: usize| {
            [(first + 3 * c, offset[c]), (first + 3 * d, offset[d]), (first, 0), (first + 3, 0)]
        };
        Some((sides(first), (self.kinds() == 2).then(|| sides(first + 6))))
    }

    /// Diagonals with damping.
    fn damped(&self) -> usize {
        if self.is_damped { self.diagonals.list.len() } else { 0 }
    }
}

impl Field<'_> {
    /// Adds the weight of the particles `from + range` in one coordinate.
    #[inline(always)]
    fn add(&self, axis: usize, from: usize, range: Range<usize>, sum: &mut [f64]) {
        let mass = &self.mass[from..];
        let range = range.start.min(mass.len())..range.end.min(mass.len());
        add_scaled(&mut sum[range.clone()], &mass[range], self.acceleration[axis]);
    }
}

/// Memory of a sweep: coordinates ahead of the present particles, forces behind them.
#[derive(Debug, Default)]
pub(crate) struct Window {
    /// Particles that the window moves on by.
    pub(super) chunk: usize,
    /// Forces that are remembered from before the chunk, at least the largest offset.
    history: usize,
    /// Coordinates that are read beyond the chunk.
    pub(super) ahead: usize,
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
        let chunk = particles.min((4 * reach).clamp(1024, 1536).max(reach));
        let chunk = chunk.next_multiple_of(LANES);
        let history = reach.next_multiple_of(LANES);
        let ahead = history + LANES;
        let mut window = Self { chunk, history, ahead, ..Self::default() };
        window.coordinates = vec![0.0; 6 * window.stride()];
        window.forces = vec![0.0; planes * window.stride()];
        window
    }

    /// Whether these passes can share a sweep with this window.
    pub(crate) fn fits<'a>(&self, passes: impl Iterator<Item = &'a Pass<'a>> + Clone) -> bool {
        let springs = passes.clone().filter_map(Pass::springs);
        let Some(particles) = springs.clone().next().map(|s| s.diagonals.particles) else {
            return false;
        };
        let same = passes.clone().all(|pass| match pass {
            Pass::Springs(springs) => springs.diagonals.particles == particles,
            Pass::Listed(_) => false,
            Pass::Field(field) => field.mass.len() == particles,
        });
        let planes: usize = springs.clone().map(Springs::planes).sum();
        let reach = springs.map(|springs| springs.diagonals.reach()).max().unwrap_or(0);
        same && reach <= self.history && planes * self.stride() <= self.forces.len()
    }

    /// Distance of two arrays. Five cache lines more than a page, lest the same place of all of them falls
    /// into the same set of the cache.
    fn stride(&self) -> usize {
        (self.chunk + self.history + self.ahead).next_multiple_of(512) + 40
    }

    /// The arrays.
    #[inline(always)]
    pub(super) fn block(&mut self) -> Block<'_> {
        let stride = self.stride();
        let Self { history, coordinates, forces, .. } = self;
        Block { stride, history: *history, coordinates, forces }
    }
}

/// Adds what `passes` ask for to `out`, N, with one window for each thread that takes part. The passes
/// [fit](Window::fits) the windows.
pub(crate) fn add(
    passes: &[Option<Pass<'_>>],
    windows: &mut [Window],
    x: &[Vec3],
    v: &[Vec3],
    out: &mut [Vec3],
) {
    let Some(first) = passes.iter().flatten().find_map(Pass::springs) else { return };
    let particles = first.diagonals.particles;
    assert!(x.len() >= particles && v.len() >= particles && out.len() >= particles);
    let x = bytemuck::cast_slice(x);
    let v = springs(passes).any(|pass| pass.is_damped).then_some(bytemuck::cast_slice(v));
    let out: &mut [f64] = bytemuck::cast_slice_mut(&mut out[..particles]);
    let band = particles.div_ceil(windows.len().max(1)).next_multiple_of(LANES);
    let sweep = |(k, (window, out)): (usize, (&mut Window, &mut [f64]))| {
        let range = k * band..particles.min((k + 1) * band);
        pulp::Arch::new().dispatch(Sweep { passes, range, window, x, v, out });
    };
    match windows {
        [window] => sweep((0, (window, out))),
        windows if particles < LEAST_FOR_THREADS || band < windows[0].history => {
            let range = 0..particles;
            pulp::Arch::new().dispatch(Sweep { passes, range, window: &mut windows[0], x, v, out });
        }
        windows => {
            windows.par_iter_mut().zip(out.par_chunks_mut(3 * band)).enumerate().for_each(sweep)
        }
    }
}

#[inline(always)]
pub(super) fn springs<'a>(passes: &'a [Option<Pass<'a>>]) -> impl Iterator<Item = &'a Springs<'a>> {
    passes.iter().flatten().filter_map(Pass::springs)
}

struct Sweep<'a> {
    passes: &'a [Option<Pass<'a>>],
    /// Particles whose sums are wanted.
    range: Range<usize>,
    window: &'a mut Window,
    x: &'a [f64],
    v: Option<&'a [f64]>,
    /// Their sums.
    out: &'a mut [f64],
}

impl pulp::WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { passes, range, window, x, v, out } = self;
        let (chunk, history, ahead) = (window.chunk, window.history, window.ahead);
        let mut block = window.block();
        let read = |block: &mut Block<'_>, begin: usize, slid: bool| {
            block.read(0, x, begin, chunk, ahead, slid);
            if let Some(v) = v {
                block.read(3, v, begin, chunk, ahead, slid);
            }
        };
        if range.start > 0 {
            // What springs from before the range leave in it.
            read(&mut block, range.start - history, false);
            block.compute(passes, range.start - history, 0, history);
            block.slide(passes, history);
        } else if range.end > chunk {
            block.forget();
        }
        let mut sums = [0.0; 3 * GROUP];
        let mut begin = range.start;
        while begin < range.end {
            read(&mut block, begin, begin > range.start);
            let end = range.end.min(begin + chunk) - begin;
            // A small sheet in some groups, so that most of its sums run along with the next group's forces.
            let group = end.div_ceil(4).next_multiple_of(4 * LANES).min(GROUP);
            let length = |at: usize| group.min(end - at);
            block.compute(passes, begin, 0, length(0).next_multiple_of(LANES));
            for at in (0..end).step_by(group) {
                let m = length(at);
                let out = &mut out[3 * (begin - range.start + at)..][..3 * m];
                split(&mut sums, GROUP, m, out);
                let next = at + group;
                if next < end {
                    let following = length(next).next_multiple_of(LANES);
                    block.gather_and_compute(passes, begin, at, group, following, &mut sums);
                } else {
                    block.gather(passes, begin, at, 0..m.next_multiple_of(LANES), &mut sums);
                }
                join(&sums, GROUP, m, out);
            }
            begin += chunk;
            if begin < range.end {
                block.slide(passes, chunk);
            }
        }
    }
}

/// `m` numbers from place `at` on of each of the first three arrays.
#[inline(always)]
fn row_of_three(planes: &mut [f64], stride: usize, at: usize, m: usize) -> [&mut [f64]; 3] {
    let (x, rest) = planes.split_at_mut(stride);
    let (y, z) = rest.split_at_mut(stride);
    [&mut x[at..][..m], &mut y[at..][..m], &mut z[at..][..m]]
}

/// Where coordinates of a group of particles begin in a window.
pub(super) struct Coordinates<'a> {
    planes: &'a [f64],
    stride: usize,
    at: usize,
}

impl<'a> Coordinates<'a> {
    /// `x`, `y`, `z` of positions and of velocities of the `m` particles `offset` places further on.
    #[inline(always)]
    pub(super) fn of(&self, offset: usize, m: usize) -> [&'a [f64]; 6] {
        std::array::from_fn(|axis| &self.planes[axis * self.stride + self.at + offset..][..m])
    }
}

/// The arrays of a window.
pub(super) struct Block<'a> {
    stride: usize,
    history: usize,
    coordinates: &'a mut [f64],
    forces: &'a mut [f64],
}

impl Block<'_> {
    /// No force is remembered.
    pub(super) fn forget(&mut self) {
        for plane in self.forces.chunks_mut(self.stride) {
            plane[..self.history].fill(0.0);
        }
    }

    /// The coordinates of particles from place `at` on, and the arrays for the forces of `m` of them.
    #[inline(always)]
    pub(super) fn group(
        &mut self,
        at: usize,
        m: usize,
    ) -> (Coordinates<'_>, impl Iterator<Item = &mut [f64]>) {
        let Self { stride, history, ref coordinates, ref mut forces } = *self;
        let forces =
            forces.chunks_exact_mut(stride).map(move |plane| &mut plane[history + at..][..m]);
        (Coordinates { planes: coordinates, stride, at }, forces)
    }

    /// Reads coordinates of `chunk + ahead` particles from `begin` into three arrays. After a chunk has been done the first
    /// `ahead` are there already, `chunk` places further on. Beyond the last particle there are zeros.
    #[inline(always)]
    pub(super) fn read(
        &mut self,
        first_plane: usize,
        from: &[f64],
        begin: usize,
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
        let there = (begin + if slid { ahead } else { 0 }).min(n);
        let end = (begin + chunk + ahead).min(n);
        split(&mut planes[there - begin..], self.stride, end - there, &from[3 * there..3 * end]);
        for plane in planes.chunks_exact_mut(self.stride) {
            plane[end - begin..chunk + ahead].fill(0.0);
        }
    }

    /// The forces of the springs of `m` particles, of which the first is at place `at` of a chunk that begins with
    /// particle `begin`.
    #[inline(always)]
    fn compute(&mut self, passes: &[Option<Pass<'_>>], begin: usize, at: usize, m: usize) {
        let mut plane = 0;
        for pass in springs(passes) {
            for d in pass.law.iter().flat_map(|_| &pass.diagonals.list) {
                self.compute_springs(pass, d, plane, begin, at, m);
                plane += 3;
            }
            for d in &pass.diagonals.list[..pass.damped()] {
                self.compute_damping(d, plane, begin, at, m);
                plane += 3;
            }
        }
    }

    /// Both ends of `m` springs of a diagonal.
    #[inline(always)]
    fn ends<'c>(
        coordinates: &'c [f64],
        stride: usize,
        d: &Diagonal,
        at: usize,
        m: usize,
    ) -> Ends<'c> {
        let near = |axis: usize| &coordinates[axis * stride + at..][..m];
        let far = |axis: usize| &coordinates[axis * stride + at + d.offset..][..m];
        Ends { near: [near(0), near(1), near(2)], far: [far(0), far(1), far(2)] }
    }

    #[inline(always)]
    fn compute_springs(
        &mut self,
        pass: &Springs<'_>,
        d: &Diagonal,
        plane: usize,
        begin: usize,
        at: usize,
        m: usize,
    ) {
        let Self { stride, history, ref coordinates, ref mut forces } = *self;
        let ends = Self::ends(coordinates, stride, d, at, m);
        let present = &d.present[begin + at..][..m];
        let [fx, fy, fz] = row_of_three(&mut forces[plane * stride..], stride, history + at, m);
        match pass.law {
            Some(Law::Spring) => {
                spring_forces(d, |k, q| Law::Spring.stiffness(k, q), present, ends, [fx, fy, fz]);
            }
            Some(Law::Nonlinear) => {
                spring_forces(
                    d,
                    |k, q| Law::Nonlinear.stiffness(k, q),
                    present,
                    ends,
                    [fx, fy, fz],
                );
            }
            Some(Law::Linear) => {
                weighted_differences(d.stiffness, present, ends, [fx, fy, fz]);
            }
            None => {}
        }
    }

    #[inline(always)]
    fn compute_damping(&mut self, d: &Diagonal, plane: usize, begin: usize, at: usize, m: usize) {
        let Self { stride, history, ref coordinates, ref mut forces } = *self;
        let ends = Self::ends(&coordinates[3 * stride..], stride, d, at, m);
        let present = &d.present[begin + at..][..m];
        let f = row_of_three(&mut forces[plane * stride..], stride, history + at, m);
        weighted_differences(d.damping, present, ends, f);
    }

    /// Adds to the sums what their springs left, for the particles at the places `at + range` of the chunk.
    #[inline(always)]
    pub(super) fn gather(
        &self,
        passes: &[Option<Pass<'_>>],
        begin: usize,
        at: usize,
        range: Range<usize>,
        sums: &mut [f64; 3 * GROUP],
    ) {
        let mut first = 0;
        for pass in passes.iter().flatten() {
            for (axis, sum) in sums.chunks_exact_mut(GROUP).enumerate() {
                match pass {
                    Pass::Springs(pass) => {
                        self.gather_axis(pass, first + axis, at, range.clone(), sum)
                    }
                    Pass::Field(field) => field.add(axis, begin + at, range.clone(), sum),
                    Pass::Listed(_) => {}
                }
            }
            first += pass.springs().map_or(0, Springs::planes);
        }
    }

    #[inline(always)]
    fn gather_axis(
        &self,
        pass: &Springs<'_>,
        first: usize,
        at: usize,
        range: Range<usize>,
        sum: &mut [f64],
    ) {
        let at = self.history + at + range.start;
        let sum = &mut sum[range.clone()];
        let side = |(plane, back): (usize, usize)| {
            &self.forces[plane * self.stride + at - back..][..range.len()]
        };
        if let Some((a, b)) = pass.pairs(first) {
            match b {
                None => take(sum, [side(a[0]), side(a[1]), side(a[2]), side(a[3])]),
                Some(b) => take_twice(
                    sum,
                    [side(a[0]), side(a[1]), side(a[2]), side(a[3])],
                    [side(b[0]), side(b[1]), side(b[2]), side(b[3])],
                ),
            }
            return;
        }
        let Diagonals { list, incoming, .. } = pass.diagonals;
        for first in (0..pass.kinds()).map(|kind| first + 3 * list.len() * kind) {
            for &d in incoming {
                take_from(sum, side((first + 3 * d, list[d].offset)));
            }
            for d in 0..list.len() {
                give(sum, side((first + 3 * d, 0)));
            }
        }
    }

    /// As [`gather`](Self::gather) for `m` particles, together with [`compute`](Self::compute) for the `following` ones:
    /// sums fill the time in which the next square roots and divisions are on their way.
    #[inline(always)]
    fn gather_and_compute(
        &mut self,
        passes: &[Option<Pass<'_>>],
        begin: usize,
        at: usize,
        m: usize,
        following: usize,
        sums: &mut [f64; 3 * GROUP],
    ) {
        let next = at + m;
        let is_plain = |s: &Springs<'_>| s.law == Some(Law::Spring) && s.diagonals.list.len() == 2;
        if !springs(passes).all(is_plain) {
            self.gather(passes, begin, at, 0..m, sums);
            self.compute(passes, begin, next, following);
            return;
        }
        // As many rows of springs as there are diagonals, each with the next sum in its coordinate.
        let mut jobs = (0..3 * passes.iter().flatten().count()).map(|job| (job / 3, job % 3));
        let mut first = [0; MAX_PASSES + 1];
        for (p, pass) in passes.iter().flatten().enumerate() {
            first[p + 1] = first[p] + pass.springs().map_or(0, Springs::planes);
        }
        for (p, pass) in passes.iter().enumerate() {
            let Some(Pass::Springs(pass)) = pass else { continue };
            for (k, d) in pass.diagonals.list.iter().enumerate() {
                let plane = first[p] + 3 * k;
                let mut is_computed = false;
                for (q, axis) in jobs.by_ref() {
                    let sum = &mut sums[axis * GROUP..][..GROUP];
                    match &passes[q] {
                        Some(Pass::Springs(other)) => {
                            let from = first[q] + axis;
                            self.compute_and_take(
                                d, plane, begin, next, following, other, from, at, sum,
                            );
                            self.gather_axis(other, from, at, following..m, sum);
                            is_computed = true;
                            break;
                        }
                        Some(Pass::Field(field)) => field.add(axis, begin + at, 0..m, sum),
                        Some(Pass::Listed(_)) | None => {}
                    }
                }
                if !is_computed {
                    self.compute_springs(pass, d, plane, begin, next, following);
                }
            }
        }
        for (q, axis) in jobs {
            let sum = &mut sums[axis * GROUP..][..GROUP];
            match &passes[q] {
                Some(Pass::Springs(pass)) => self.gather_axis(pass, first[q] + axis, at, 0..m, sum),
                Some(Pass::Field(field)) => field.add(axis, begin + at, 0..m, sum),
                Some(Pass::Listed(_)) | None => {}
            }
        }
        for (p, pass) in passes.iter().enumerate() {
            let Some(Pass::Springs(pass)) = pass else { continue };
            for (k, d) in pass.diagonals.list[..pass.damped()].iter().enumerate() {
                self.compute_damping(d, first[p] + 6 + 3 * k, begin, next, following);
            }
        }
    }

    /// The forces of one diagonal from place `next` on, and one coordinate of the sums from place `at` on.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "two jobs at once")]
    fn compute_and_take(
        &mut self,
        d: &Diagonal,
        plane: usize,
        begin: usize,
        next: usize,
        m: usize,
        pass: &Springs<'_>,
        from: usize,
        at: usize,
        sum: &mut [f64],
    ) {
        let Self { stride, history, ref coordinates, ref mut forces } = *self;
        let ends = Self::ends(coordinates, stride, d, next, m);
        let present = &d.present[begin + next..][..m];
        let (before, rest) = forces.split_at_mut(plane * stride);
        let (own, after) = rest.split_at_mut(3 * stride);
        let (fx, own) = own.split_at_mut(stride);
        let (fy, fz) = own.split_at_mut(stride);
        let (x, fx) = fx.split_at_mut(history + next);
        let (y, fy) = fy.split_at_mut(history + next);
        let (z, fz) = fz.split_at_mut(history + next);
        let (before, own, after): (&[f64], [&[f64]; 3], &[f64]) = (before, [x, y, z], after);
        let side = |(p, back): (usize, usize)| {
            let start = history + at - back;
            match p.checked_sub(plane) {
                None => &before[p * stride + start..][..m],
                Some(axis @ 0..3) => &own[axis][start..][..m],
                Some(later) => &after[(later - 3) * stride + start..][..m],
            }
        };
        let (f, sum) = ([&mut fx[..m], &mut fy[..m], &mut fz[..m]], &mut sum[..m]);
        match pass.pairs(from) {
            Some((a, None)) => spring_forces_and_take(
                d,
                present,
                ends,
                f,
                sum,
                [side(a[0]), side(a[1]), side(a[2]), side(a[3])],
            ),
            Some((a, Some(b))) => {
                let (a, b) = (
                    [side(a[0]), side(a[1]), side(a[2]), side(a[3])],
                    [side(b[0]), side(b[1]), side(b[2]), side(b[3])],
                );
                spring_forces_and_take_twice(d, present, ends, f, sum, a, b);
            }
            None => {}
        }
    }

    /// Moves the window on: the last forces become the first ones.
    pub(super) fn slide(&mut self, passes: &[Option<Pass<'_>>], chunk: usize) {
        let mut planes = self.forces.chunks_exact_mut(self.stride);
        for pass in springs(passes) {
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
