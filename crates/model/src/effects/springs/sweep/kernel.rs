//! The kernel of a sweep: the forces of the springs of one vector of particles, and the sums of
//! another.
//!
//! The kernel computes all springs of a vector of particles together. While the square roots and
//! divisions of one diagonal are under way, it takes the differences and products of the next, and
//! sums up particles further behind.

use super::super::diagonals::Diagonal;
use super::super::{COLLAPSED, diagonals::MAX_DIAGONALS};
use super::{Begin, Block, Field, GROUP, Law, MAX_PASSES, Pass, Sums};
use pulp::Simd;
use std::array::from_fn;
use std::ops::Range;

/// Most diagonals of a sweep.
const MAX_ROWS: usize = MAX_PASSES * MAX_DIAGONALS;

/// A diagonal of a sweep.
#[derive(Clone, Copy)]
struct Row<'a> {
    law: Law,
    offset: usize,
    rest_length: f64,
    stiffness: f64,
    damping: f64,
    /// The first of its three arrays of forces.
    plane: usize,
    /// The places without a spring that are still ahead.
    absent: &'a [u32],
    /// Those ahead whose spring is half as strong.
    halves: &'a [u32],
}

impl<'a> Row<'a> {
    fn new(d: &'a Diagonal, law: Law, plane: usize, first: usize) -> Self {
        let &Diagonal { offset, rest_length, .. } = d;
        let (stiffness, damping) = (d.most() * d.stiffness, d.most() * d.damping);
        let ahead = |list: &'a [u32]| &list[list.partition_point(|i| (*i as usize) < first)..];
        let (absent, halves) = (ahead(&d.absent), ahead(&d.halves));
        Self { law, offset, rest_length, stiffness, damping, plane, absent, halves }
    }
}

/// A term of a particle's sum.
#[derive(Clone, Copy)]
enum Term<'a> {
    /// The forces of springs from particles `back` places before it, from this array on.
    Incoming { plane: usize, back: usize },
    /// The opposite of its own springs' forces.
    Own { plane: usize },
    /// Its weight.
    Field(Field<'a>),
}

/// The diagonals that a sweep computes and the terms that it sums, in the order of the passes.
pub(in super::super) struct Plan<'a> {
    rows: [Option<Row<'a>>; MAX_ROWS],
    terms: [Option<Term<'a>>; 2 * MAX_ROWS + MAX_PASSES],
}

impl<'a> Plan<'a> {
    /// The plan of a sweep that begins with particle `first`.
    pub(in super::super) fn new(passes: &[Option<Pass<'a>>], first: usize) -> Self {
        let mut plan = Self { rows: [None; MAX_ROWS], terms: [None; 2 * MAX_ROWS + MAX_PASSES] };
        let (mut rows, mut terms) = (plan.rows.iter_mut(), plan.terms.iter_mut());
        let mut push = |term| terms.next().into_iter().for_each(|place| *place = Some(term));
        let mut plane = 0;
        for pass in passes.iter().flatten() {
            match pass {
                Pass::Springs(springs) => {
                    let list = &springs.diagonals.list;
                    for &d in &springs.diagonals.incoming {
                        push(Term::Incoming { plane: plane + 3 * d, back: list[d].offset });
                    }
                    for diagonal in list {
                        push(Term::Own { plane });
                        let row = Row::new(diagonal, springs.law, plane, first);
                        rows.next().into_iter().for_each(|place| *place = Some(row));
                        plane += 3;
                    }
                }
                Pass::Field(field) => push(Term::Field(*field)),
                Pass::Listed(_) => {}
            }
        }
        plan
    }
}

/// The arrays of a window, at a distance known at compile time: the compiler then knows that no
/// vector lies outside.
pub(in super::super) struct Planes<'a, const STRIDE: usize> {
    history: usize,
    coordinates: &'a [[f64; STRIDE]; 6],
    forces: &'a mut [[f64; STRIDE]],
}

impl<'a, const STRIDE: usize> Planes<'a, STRIDE> {
    /// The arrays of a block with this stride.
    #[inline(always)]
    pub(in super::super) fn of(block: &'a mut Block<'_>) -> Option<Self> {
        let coordinates = block.coordinates.as_chunks().0.first_chunk()?;
        let forces = block.forces.as_chunks_mut().0;
        (block.stride == STRIDE).then_some(Self { history: block.history, coordinates, forces })
    }

    /// Computes the forces of the springs of `m` particles. The first stands at place `at` of a
    /// chunk that begins with particle `begin`.
    #[inline(always)]
    pub(super) fn compute<S: Simd>(
        &mut self,
        simd: S,
        plan: &mut Plan<'_>,
        begin: usize,
        at: usize,
        m: usize,
    ) {
        for t in (at..at + m).step_by(S::F64_LANES) {
            self.springs(simd, plan, t);
        }
        self.correct(plan, begin, at + m);
    }

    /// Adds the kept forces to the sums or to zero, for the particles at these places behind place
    /// `at` of the chunk.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "where particles are, and where their sums")]
    pub(in super::super) fn gather<S: Simd>(
        &self,
        simd: S,
        plan: &Plan<'_>,
        begin: usize,
        at: usize,
        places: Range<usize>,
        from: Begin,
        sums: &mut Sums,
    ) {
        for t in places.step_by(S::F64_LANES) {
            self.sum(simd, plan, begin, at + t, t, from, sums);
        }
    }

    /// As [`gather`](Self::gather) for `m` particles, together with [`compute`](Self::compute) for
    /// the `following ≤ m` behind them.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "two jobs at once")]
    pub(super) fn gather_and_compute<S: Simd>(
        &mut self,
        simd: S,
        plan: &mut Plan<'_>,
        begin: usize,
        at: usize,
        m: usize,
        following: usize,
        from: Begin,
        sums: &mut Sums,
    ) {
        for t in (0..following).step_by(S::F64_LANES) {
            self.springs(simd, plan, at + m + t);
            self.sum(simd, plan, begin, at + t, t, from, sums);
        }
        self.gather(simd, plan, begin, at, following..m, from, sums);
        self.correct(plan, begin, at + m + following);
    }

    /// Computes the forces of a vector's own springs, also at places without a spring.
    #[inline(always)]
    fn springs<S: Simd>(&mut self, simd: S, plan: &Plan<'_>, at: usize) {
        let near: [S::f64s; 6] = from_fn(|axis| load::<S, STRIDE>(&self.coordinates[axis], at));
        for row in plan.rows.iter().map_while(Option::as_ref) {
            let far = at + row.offset;
            let difference = |axis: usize| {
                let far = load::<S, STRIDE>(&self.coordinates[axis], far);
                simd.sub_f64s(near[axis], far)
            };
            let f = match row.law {
                Law::Linear => times(simd, from_fn(difference), row.stiffness),
                Law::Damping => times(simd, from_fn(|axis| difference(3 + axis)), row.damping),
                Law::Projected => {
                    let d = [difference(0), difference(1), difference(2)];
                    along(simd, row, d, [difference(3), difference(4), difference(5)])
                }
                Law::Spring | Law::Nonlinear => force(simd, row, from_fn(difference)),
                Law::DampedSpring => {
                    let force = force(simd, row, from_fn(difference));
                    let damping = times(simd, from_fn(|axis| difference(3 + axis)), row.damping);
                    from_fn(|axis| simd.add_f64s(force[axis], damping[axis]))
                }
            };
            for (plane, f) in self.forces[row.plane..][..3].iter_mut().zip(f) {
                store::<S, STRIDE>(plane, self.history + at, f);
            }
        }
    }

    /// Clears the forces at places without a spring, and halves those of springs that are half as
    /// strong, up to place `end` of the chunk.
    #[inline(always)]
    fn correct(&mut self, plan: &mut Plan<'_>, begin: usize, end: usize) {
        for row in plan.rows.iter_mut().map_while(Option::as_mut) {
            let places = self.history..self.history + end;
            let planes = &mut self.forces[row.plane..][..3];
            let next = |list: &mut &[u32]| {
                let (&i, ahead) = list.split_first()?;
                let at = places.start + (i as usize - begin);
                (at < places.end).then(|| *list = ahead)?;
                Some(at)
            };
            while let Some(at) = next(&mut row.absent) {
                planes.iter_mut().for_each(|plane| plane[at] = 0.0);
            }
            while let Some(at) = next(&mut row.halves) {
                planes.iter_mut().for_each(|plane| plane[at] *= 0.5);
            }
        }
    }

    /// Sums up a vector of particles, which stands at `place` among the sums.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "where particles are, and where their sums")]
    fn sum<S: Simd>(
        &self,
        simd: S,
        plan: &Plan<'_>,
        begin: usize,
        at: usize,
        place: usize,
        from: Begin,
        sums: &mut Sums,
    ) {
        let mut sum: [S::f64s; 3] = from_fn(|axis| match from {
            Begin::Present => load::<S, GROUP>(&sums.0[axis], place),
            Begin::Zero => simd.splat_f64s(0.0),
        });
        let here = self.history + at;
        for term in plan.terms.iter().map_while(Option::as_ref) {
            match *term {
                Term::Incoming { plane, back } => {
                    for (sum, plane) in sum.iter_mut().zip(&self.forces[plane..][..3]) {
                        *sum = simd.add_f64s(*sum, load::<S, STRIDE>(plane, here - back));
                    }
                }
                Term::Own { plane } => {
                    for (sum, plane) in sum.iter_mut().zip(&self.forces[plane..][..3]) {
                        *sum = simd.sub_f64s(*sum, load::<S, STRIDE>(plane, here));
                    }
                }
                Term::Field(Field { acceleration, mass }) => {
                    let mass = &mass[mass.len().min(begin + at)..];
                    let mass = match S::as_simd_f64s(mass).0.first() {
                        Some(mass) => *mass,
                        None => simd.partial_load_f64s(mass),
                    };
                    for (axis, sum) in sum.iter_mut().enumerate() {
                        let a = simd.splat_f64s(acceleration[axis]);
                        *sum = simd.add_f64s(*sum, simd.mul_f64s(a, mass));
                    }
                }
            }
        }
        for (axis, sum) in sum.into_iter().enumerate() {
            store::<S, GROUP>(&mut sums.0[axis], place, sum);
        }
    }
}

/// `g d` of springs with the differences `d` of their ends.
#[inline(always)]
fn force<S: Simd>(simd: S, row: &Row<'_>, d: [S::f64s; 3]) -> [S::f64s; 3] {
    let [xx, yy, zz] = d.map(|d| simd.mul_f64s(d, d));
    let length = simd.sqrt_f64s(simd.add_f64s(simd.add_f64s(xx, yy), zz));
    let is_long = simd.greater_than_f64s(length, simd.splat_f64s(COLLAPSED * row.rest_length));
    let quotient = simd.div_f64s(simd.splat_f64s(row.rest_length), length);
    let quotient = simd.select_f64s(is_long, quotient, simd.splat_f64s(0.0));
    let k = simd.splat_f64s(row.stiffness);
    let g = if row.law == Law::Nonlinear {
        simd.neg_f64s(simd.mul_f64s(k, quotient))
    } else {
        simd.mul_f64s(k, simd.sub_f64s(simd.splat_f64s(1.0), quotient))
    };
    d.map(|d| simd.mul_f64s(d, g))
}

/// `c û (û·w)` of springs with the differences `d` and `w` of their ends' positions and velocities.
// Not every closure is compiled for the registers, so there is none.
#[inline(always)]
fn along<S: Simd>(simd: S, row: &Row<'_>, d: [S::f64s; 3], w: [S::f64s; 3]) -> [S::f64s; 3] {
    let length = simd.sqrt_f64s(dot(simd, d, d));
    let is_long = simd.greater_than_f64s(length, simd.splat_f64s(COLLAPSED * row.rest_length));
    let u = [
        over_where(simd, is_long, d[0], length),
        over_where(simd, is_long, d[1], length),
        over_where(simd, is_long, d[2], length),
    ];
    let rate = simd.mul_f64s(simd.splat_f64s(row.damping), dot(simd, u, w));
    [simd.mul_f64s(u[0], rate), simd.mul_f64s(u[1], rate), simd.mul_f64s(u[2], rate)]
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: [S::f64s; 3], b: [S::f64s; 3]) -> S::f64s {
    let plane = simd.add_f64s(simd.mul_f64s(a[0], b[0]), simd.mul_f64s(a[1], b[1]));
    simd.add_f64s(plane, simd.mul_f64s(a[2], b[2]))
}

/// `a/b` where the mask says so, else 0.
// The choice between floating-point numbers is not always inlined.
#[inline(always)]
fn over_where<S: Simd>(simd: S, mask: S::m64s, a: S::f64s, b: S::f64s) -> S::f64s {
    let quotient = bytemuck::cast(simd.div_f64s(a, b));
    bytemuck::cast(simd.select_u64s(mask, quotient, bytemuck::cast(simd.splat_f64s(0.0))))
}

/// `w d`.
#[inline(always)]
fn times<S: Simd>(simd: S, d: [S::f64s; 3], w: f64) -> [S::f64s; 3] {
    d.map(|d| simd.mul_f64s(d, simd.splat_f64s(w)))
}

/// The vector that begins at place `at`. Clamping `at` spares a check of bounds.
#[inline(always)]
fn load<S: Simd, const N: usize>(from: &[f64; N], at: usize) -> S::f64s {
    debug_assert!(at + S::F64_LANES <= N);
    S::as_simd_f64s(&from[at.min(N - S::F64_LANES)..][..S::F64_LANES]).0[0]
}

#[inline(always)]
fn store<S: Simd, const N: usize>(to: &mut [f64; N], at: usize, value: S::f64s) {
    debug_assert!(at + S::F64_LANES <= N);
    S::as_mut_simd_f64s(&mut to[at.min(N - S::F64_LANES)..][..S::F64_LANES]).0[0] = value;
}
