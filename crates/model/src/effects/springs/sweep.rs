//! The fast kernel for springs along diagonals.
//!
//! # How it goes
//!
//! The sweep reads positions and velocities into one array per coordinate, so that eight particles
//! fill a vector register. For each vector of particles it computes and keeps the forces of all
//! springs to later particles: `f_i = g (x_i − x_{i+o})` with `g` after the [`Law`], plus
//! `c (v_i − v_{i+o})` with full damping, or projected damping alone. Some vectors later it adds the
//! kept forces to each particle: `+f_{i−o}` of springs from earlier particles, `−f_i` of its own.
//! Where a place along a diagonal has no spring, it overwrites the force by 0, which changes no sum;
//! where a spring is half as strong, it halves the force, which is exact.
//!
//! Each sum has the order of the [readable loop](super::LinearSprings::add_reference): a particle
//! meets its incoming springs first, by falling offset, then its own. As in the loop, each spring
//! is computed once and its force added twice with opposite signs. So the results are the same
//! bits.
//!
//! The arrays are a window that slides over the particles and remembers the forces of the last `o`
//! springs of each diagonal. It fits the second-level cache up to some hundred columns, for any
//! number of rows. Each system has one window per thread, so that a sweep allocates nothing.
//! [`pulp`] compiles the kernel for the vector units of the processor. Products and sums are
//! rounded separately, so the width of the registers changes no bit.
//!
//! # What it costs
//!
//! | with full damping | per spring |
//! |---|---|
//! | length | 8 flops, a square root, a division |
//! | force | 5 flops |
//! | damping | 9 flops |
//! | sums | 6 flops |
//!
//! A Zen 4 core takes about 2 ns per spring: 0.5 ns for the square root and the division (4.2 ns
//! for eight of each), 0.4 ns for reading and writing coordinates. Main memory carries 24 bytes per
//! particle for `x`, 24 for `v`, 48 for the sum (24 if it begins with zero), and 4 for each place
//! along a diagonal without a spring.
//!
//! # What was tried
//!
//! Nanoseconds per spring on a sheet of 52 × 52 particles, on one core of a machine with other
//! work:
//!
//! | variant | ns |
//! |---|---|
//! | one loop per diagonal, vectorised by the compiler, force and damping apart | 2.9 |
//! | … force and damping as one | 2.3 |
//! | … and all arrays at cache lines | 2.15 |
//! | all diagonals of a vector in one loop, every read checked | 2.9 |
//! | … with a distance of arrays that the compiler knows | 2.05 |
//! | the same in C++, everything known to the compiler, no copies of coordinates: the bound | 1.15 |
//!
//! Reading coordinates group by group instead of chunk by chunk gained nothing. A Zen 5 core
//! takes 1.2 ns on the same sheet, and at times 1.9 ns while other programs run, even with fixed
//! addresses. Sums that begin with zero in a register, not with zeros in memory, take a twentieth
//! less time (316 × 316).

mod kernel;
mod windows;

pub(super) use self::kernel::{Plan, Planes};
pub(crate) use self::windows::Windows;
use super::Vec3;
use super::diagonals::Diagonals;
use super::listed::Listed;
use drape_kernels::lanes::WIDEST;
use drape_kernels::planes::{Aligned, Frame, join, split, stride};
use rayon::prelude::*;
use std::ops::Range;

/// Distance of two arrays of a window, which fits sheets of 344 columns with bending springs.
pub(super) const NARROW: usize = stride(2048);
/// As [`NARROW`], for all offsets up to [`MAX_OFFSET`].
pub(super) const WIDE: usize = stride(16_384);
/// Largest offset of a diagonal that fits a window.
pub(super) const MAX_OFFSET: usize = 5_000;
/// Most effects that one sweep takes together.
pub(crate) const MAX_PASSES: usize = 4;
/// Most particles that a sweep computes, then gathers, at a time.
pub(super) const GROUP: usize = 128;

/// The force of a spring: `−g (x_i − x_j)` with the factor `g`, a damping force, or their sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Law {
    /// `g = k (1 − ℓ/L)`: the force of the spring, EEH (11).
    Spring,
    /// The same with the full damping, EEH (14).
    DampedSpring,
    /// `g = −k ℓ/L`: the force without its linear part, EEH (13).
    Nonlinear,
    /// `g = k`: the linear part, EEH (12).
    Linear,
    /// The full damping alone.
    Damping,
    /// Projected damping alone: `−c ûûᵀ(v_i − v_j)`.
    Projected,
}

impl Law {
    /// All laws.
    #[cfg(test)]
    pub(super) const ALL: [Self; 6] = [
        Self::Spring,
        Self::DampedSpring,
        Self::Nonlinear,
        Self::Linear,
        Self::Damping,
        Self::Projected,
    ];

    /// `g` for a spring of stiffness `k` with the quotient `ℓ/L`, N/m.
    #[inline(always)]
    pub(crate) fn stiffness(self, k: f64, rest_over_length: f64) -> f64 {
        match self {
            Self::Spring | Self::DampedSpring => k * (1.0 - rest_over_length),
            Self::Nonlinear => -(k * rest_over_length),
            Self::Linear => k,
            Self::Damping | Self::Projected => 0.0,
        }
    }

    /// Whether velocities matter.
    #[inline(always)]
    pub(crate) fn is_damped(self) -> bool {
        matches!(self, Self::DampedSpring | Self::Damping | Self::Projected)
    }
}

/// The forces of one effect, in the form that a sweep takes.
#[derive(Clone, Copy, Debug)]
pub enum Pass<'a> {
    /// Springs along diagonals.
    Springs(Springs<'a>),
    /// Springs in any order.
    Listed(ListedSprings<'a>),
    /// The same acceleration for all particles.
    Field(Field<'a>),
}

/// Springs along diagonals, with the law of their force.
#[derive(Clone, Copy, Debug)]
pub struct Springs<'a> {
    pub(crate) diagonals: &'a Diagonals,
    pub(crate) law: Law,
}

/// As [`Springs`], for springs in any order.
#[derive(Clone, Copy, Debug)]
pub struct ListedSprings<'a> {
    pub(crate) list: &'a Listed,
    pub(crate) law: Law,
}

/// `f_i = m_i g`.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    pub(crate) acceleration: Vec3,
    pub(crate) mass: &'a [f64],
}

impl<'a> Pass<'a> {
    /// The springs, if they lie along diagonals.
    #[inline(always)]
    pub(crate) fn springs(&self) -> Option<&Springs<'a>> {
        match self {
            Self::Springs(springs) => Some(springs),
            Self::Listed(_) | Self::Field(_) => None,
        }
    }
}

impl Springs<'_> {
    /// Arrays of forces that the pass fills: three per diagonal.
    fn planes(&self) -> usize {
        3 * self.diagonals.list.len()
    }
}

/// Memory of a sweep: coordinates ahead of the present particles, forces behind them.
#[derive(Debug, Default)]
pub(crate) struct Window {
    /// Number of particles by which the window moves on.
    pub(super) chunk: usize,
    /// Number of forces remembered from before the chunk, at least the largest offset.
    pub(super) history: usize,
    /// Number of coordinates read beyond the chunk.
    pub(super) ahead: usize,
    /// `x`, `y`, `z` of positions, then of velocities; [`Self::stride`] each.
    coordinates: Aligned,
    /// Forces; [`Self::stride`] each.
    forces: Aligned,
    /// Blocks of the springs of `history` particles, six numbers each, for a matrix that threads
    /// share; [`Self::kept_stride`] each. Empty if there is no other thread.
    kept: Aligned,
}

impl Window {
    /// A window for sweeps over any of these springs. Its arrays lie at least `lead` numbers behind
    /// other memory; without `lead` it is the only one.
    fn new<'a>(lead: usize, all: impl Iterator<Item = &'a Diagonals>) -> Self {
        let (mut reach, mut planes, mut particles) = (0, 0, 0);
        for diagonals in all {
            reach = reach.max(diagonals.reach());
            planes += 3 * diagonals.list.len();
            particles = particles.max(diagonals.particles);
        }
        if planes == 0 {
            return Self::default();
        }
        let history = reach.next_multiple_of(WIDEST);
        let ahead = history + WIDEST;
        // A band of another thread computes all forces from before it in one chunk.
        let least = history.max(512);
        let room = NARROW.saturating_sub(history + ahead);
        let chunk = if room >= least { room } else { least }.min(1536).max(least);
        let chunk = chunk.min(particles.next_multiple_of(WIDEST));
        let mut window = Self { chunk, history, ahead, ..Self::default() };
        window.coordinates = Aligned::zeros(lead, 6 * window.stride());
        window.forces = Aligned::zeros(lead, planes * window.stride());
        if lead > 0 {
            window.kept = Aligned::zeros(lead, 2 * planes * window.kept_stride());
        }
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

    /// Distance of two arrays.
    fn stride(&self) -> usize {
        if self.chunk + self.history + self.ahead <= NARROW { NARROW } else { WIDE }
    }

    /// Distance of two arrays of kept blocks.
    fn kept_stride(&self) -> usize {
        stride(self.history)
    }

    /// The arrays.
    #[inline(always)]
    pub(super) fn block(&mut self) -> Block<'_> {
        self.block_and_kept().0
    }

    /// The arrays, those of kept blocks, and the distance of two of the latter.
    #[inline(always)]
    pub(super) fn block_and_kept(&mut self) -> (Block<'_>, &mut [f64], usize) {
        let (stride, kept_stride) = (self.stride(), self.kept_stride());
        let Self { history, coordinates, forces, kept, .. } = self;
        let (coordinates, forces) = (coordinates.all_mut(), forces.all_mut());
        let block = Block { stride, history: *history, coordinates, forces };
        (block, kept.all_mut(), kept_stride)
    }
}

/// The sums of a group, one array per coordinate.
#[repr(align(64))]
pub(super) struct Sums(pub(super) [[f64; GROUP]; 3]);

/// The value with which sums begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Begin {
    /// The value in the output.
    Present,
    /// Zero; the value in the output is overwritten.
    Zero,
}

impl Begin {
    /// If sums begin with zero, writes the zeros; the sums then go on from there.
    pub(crate) fn clear(&mut self, out: &mut [Vec3]) {
        if *self == Self::Zero {
            bytemuck::cast_slice_mut::<Vec3, f64>(out).fill(0.0);
            *self = Self::Present;
        }
    }
}

/// Work on complete sums while they are in a cache. Each call gets the sums of some particles, and
/// several threads may call at a time.
pub(crate) type Finish<'a> = dyn Fn(Range<usize>, &mut [Vec3]) + Sync + 'a;

/// Adds the forces of `passes`, N, to `out` or to zero, and finishes all of `out`, on as many
/// threads as there are windows. The passes must [fit](Windows::fits).
pub(crate) fn add(
    passes: &[Option<Pass<'_>>],
    windows: &mut Windows,
    x: &[Vec3],
    v: &[Vec3],
    out: &mut [Vec3],
    begin: Begin,
    finish: Option<&Finish<'_>>,
) {
    let particles = springs(passes).next().map_or(0, |springs| springs.diagonals.particles);
    add_in_bands(windows.bands(particles), passes, windows, x, v, out, begin, finish);
}

/// As [`add`], in a given number of bands. No band may be shorter than the longest offset of a
/// spring.
#[expect(clippy::too_many_arguments, reason = "how, of what, with what, where and whereto")]
pub(super) fn add_in_bands(
    bands: usize,
    passes: &[Option<Pass<'_>>],
    windows: &mut Windows,
    x: &[Vec3],
    v: &[Vec3],
    out: &mut [Vec3],
    mut begin: Begin,
    finish: Option<&Finish<'_>>,
) {
    let Some(first) = passes.iter().flatten().find_map(Pass::springs) else { return };
    let particles = first.diagonals.particles;
    assert!(x.len() >= particles && v.len() >= particles && out.len() >= particles);
    let x = bytemuck::cast_slice(x);
    let v = springs(passes).any(|pass| pass.law.is_damped()).then_some(bytemuck::cast_slice(v));
    let (out, rest) = out.split_at_mut(particles);
    let from = begin;
    begin.clear(rest);
    if let Some(finish) = finish.filter(|_| !rest.is_empty()) {
        finish(particles..particles + rest.len(), rest);
    }
    let out: &mut [f64] = bytemuck::cast_slice_mut(out);
    let sweep = |range, window: &mut Window, out: &mut [f64]| {
        pulp::Arch::new().dispatch(Sweep { passes, range, window, x, v, from, out, finish });
    };
    if bands == 1 {
        return sweep(0..particles, windows.first(), out);
    }
    let band = particles.div_ceil(bands).next_multiple_of(WIDEST);
    out.par_chunks_mut(3 * band).with_max_len(1).enumerate().for_each(|(k, out)| {
        let range = k * band..particles.min((k + 1) * band);
        sweep(range, &mut windows.free(), out);
    });
}

#[inline(always)]
pub(super) fn springs<'a>(passes: &'a [Option<Pass<'a>>]) -> impl Iterator<Item = &'a Springs<'a>> {
    passes.iter().flatten().filter_map(Pass::springs)
}

struct Sweep<'a> {
    passes: &'a [Option<Pass<'a>>],
    /// Particles that the sweep sums.
    range: Range<usize>,
    window: &'a mut Window,
    x: &'a [f64],
    v: Option<&'a [f64]>,
    /// The value with which sums begin.
    from: Begin,
    /// Their sums.
    out: &'a mut [f64],
    finish: Option<&'a Finish<'a>>,
}

impl pulp::WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        if self.window.stride() == NARROW {
            self.sweep::<S, NARROW>(simd);
        } else {
            self.sweep::<S, WIDE>(simd);
        }
    }
}

impl Sweep<'_> {
    #[inline(always)]
    fn sweep<S: pulp::Simd, const STRIDE: usize>(self, simd: S) {
        let Self { passes, range, window, x, v, from, out, finish } = self;
        let (chunk, history, ahead) = (window.chunk, window.history, window.ahead);
        let mut plan = Plan::new(passes, range.start.saturating_sub(history));
        let mut block = window.block();
        assert_eq!(block.stride, STRIDE, "a window of this width");
        let mut sums = Sums([[0.0; GROUP]; 3]);
        let read = |block: &mut Block<'_>, begin: usize, slid: bool| {
            block.read(0, x, begin, chunk, ahead, slid);
            if let Some(v) = v {
                block.read(3, v, begin, chunk, ahead, slid);
            }
        };
        if range.start > 0 {
            // Forces of springs that lead from before the range into it.
            read(&mut block, range.start - history, false);
            let Some(mut planes) = Planes::<STRIDE>::of(&mut block) else { return };
            planes.compute(simd, &mut plan, range.start - history, 0, history);
            block.slide(passes, history);
        } else {
            block.forget();
        }
        let mut begin = range.start;
        while begin < range.end {
            read(&mut block, begin, begin > range.start);
            let end = range.end.min(begin + chunk) - begin;
            let length = |at: usize| GROUP.min(end.saturating_sub(at));
            let Some(mut planes) = Planes::<STRIDE>::of(&mut block) else { return };
            planes.compute(simd, &mut plan, begin, 0, length(0).next_multiple_of(WIDEST));
            for at in (0..end).step_by(GROUP) {
                let m = length(at);
                let out = &mut out[3 * (begin - range.start + at)..][..3 * m];
                if from == Begin::Present {
                    split(sums.0.as_flattened_mut(), GROUP, out);
                }
                let following = length(at + GROUP).next_multiple_of(WIDEST);
                let m_padded = m.next_multiple_of(WIDEST);
                planes.gather_and_compute(
                    simd, &mut plan, begin, at, m_padded, following, from, &mut sums,
                );
                join(sums.0.as_flattened(), GROUP, out);
            }
            if let Some(finish) = finish {
                let out = &mut out[3 * (begin - range.start)..][..3 * end];
                finish(begin..begin + end, bytemuck::cast_slice_mut(out));
            }
            begin += chunk;
            if begin < range.end {
                block.slide(passes, chunk);
            }
        }
    }
}

/// Where coordinates of a group of particles begin in a window.
pub(super) struct Coordinates<'a> {
    planes: &'a [f64],
    stride: usize,
    at: usize,
}

impl<'a> Coordinates<'a> {
    /// `x`, `y`, `z` of positions and of velocities of the `m` particles `offset` places further
    /// on.
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
    /// Forgets all remembered forces.
    pub(super) fn forget(&mut self) {
        for plane in self.forces.chunks_mut(self.stride) {
            plane[..self.history].fill(0.0);
        }
    }

    /// The coordinates of particles from place `at` on, and the arrays for the forces of `m` of
    /// them.
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

    /// Adds the kept forces to the sums of `m` particles, from place `at` of the chunk on.
    #[inline(always)]
    pub(super) fn gather<S: pulp::Simd>(
        &mut self,
        simd: S,
        plan: &Plan<'_>,
        begin: usize,
        at: usize,
        m: usize,
        sums: &mut Sums,
    ) {
        if let Some(planes) = Planes::<NARROW>::of(self) {
            planes.gather(simd, plan, begin, at, 0..m, Begin::Present, sums);
        } else if let Some(planes) = Planes::<WIDE>::of(self) {
            planes.gather(simd, plan, begin, at, 0..m, Begin::Present, sums);
        }
    }

    /// Reads coordinates of `chunk + ahead` particles from `begin` into three arrays. After a slide
    /// the arrays hold the first `ahead` already, `chunk` places further on. Beyond the last
    /// particle they get zeros.
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
        let kept = if slid { ahead } else { 0 };
        let first = begin as isize;
        Frame { first, len: chunk + ahead, kept, moved: chunk }.read(planes, self.stride, from);
    }

    /// Moves the window on: the last forces become the first ones.
    pub(super) fn slide(&mut self, passes: &[Option<Pass<'_>>], chunk: usize) {
        let mut planes = self.forces.chunks_exact_mut(self.stride);
        for pass in springs(passes) {
            for d in &pass.diagonals.list {
                for plane in planes.by_ref().take(3) {
                    let from = self.history - d.offset;
                    plane.copy_within(from + chunk..self.history + chunk, from);
                }
            }
        }
    }
}
