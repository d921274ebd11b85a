//! Conjugate gradients on compressed rows, for any pattern. A particle is four numbers, the last
//! one zero, so that one 256-bit operation serves its three coordinates.

use super::buckets::Buckets;
use crate::pcg::{Norm, Operations, StartReport};
use crate::preconditioner::{IncompleteCholesky, Jacobi};
use crate::vector::{BLOCK, SLOTS, combine};
use crate::{Constraints, ScalarMatrix, Vec3};
use drape_kernels::lanes::{Four, Lanes, Plain, four_wide, vectorised};
use pulp::Arch;

/// The preconditioner of a solve.
#[derive(Clone, Copy, Debug)]
pub enum ScalarPreconditioner<'a> {
    /// No preconditioner.
    Identity,
    /// Division by the diagonal.
    Jacobi(&'a Jacobi),
    /// Incomplete Cholesky without fill.
    Ic0(&'a IncompleteCholesky),
}

/// The vectors of a solve.
#[derive(Debug)]
pub(super) struct Padded {
    x: Vec<Lanes>,
    r: Vec<Lanes>,
    c: Vec<Lanes>,
    q: Vec<Lanes>,
    /// `P r`, where `P` is not diagonal.
    s: Vec<Lanes>,
    /// The farthest row that a row is coupled to.
    reach: usize,
    buckets: Buckets,
    arch: Arch,
}

impl Padded {
    /// Room for solves with the pattern of `a`.
    pub(super) fn new(a: &ScalarMatrix, diagonal: bool) -> Self {
        let n = a.n();
        let zeros = || vec![[0.0; 4]; n];
        let ahead = |i: usize| a.row(i).0.last().map_or(0, |&last| last as usize - i);
        Self {
            x: zeros(),
            r: zeros(),
            c: zeros(),
            q: zeros(),
            s: if diagonal { Vec::new() } else { zeros() },
            reach: (0..n).map(ahead).max().unwrap_or(0),
            buckets: Buckets::new(n),
            arch: four_wide(),
        }
    }

    /// Number of particles.
    pub(super) fn n(&self) -> usize {
        self.r.len()
    }

    /// The residual, to particles.
    pub(super) fn residual(&self, out: &mut [Vec3]) {
        for (out, r) in out.iter_mut().zip(&self.r) {
            *out = Vec3::new(r[0], r[1], r[2]);
        }
    }

    /// The operations of one solve.
    pub(super) fn operations<'a>(
        &'a mut self,
        a: &'a ScalarMatrix,
        p: ScalarPreconditioner<'a>,
        constraints: &'a Constraints,
        b: &'a [Vec3],
        solution: &'a mut [Vec3],
    ) -> PaddedSolve<'a> {
        self.buckets.fill(constraints);
        let (postponed, square) = (None, f64::NAN);
        PaddedSolve {
            problem: Problem { a, p, constraints, b },
            solution,
            postponed,
            square,
            of: self,
        }
    }
}

/// What a solve reads but does not change.
#[derive(Clone, Copy, Debug)]
struct Problem<'a> {
    a: &'a ScalarMatrix,
    p: ScalarPreconditioner<'a>,
    constraints: &'a Constraints,
    b: &'a [Vec3],
}

/// One solve.
#[derive(Debug)]
pub(super) struct PaddedSolve<'a> {
    problem: Problem<'a>,
    solution: &'a mut [Vec3],
    /// `α` of an update of `x` that the next sweep over `c` performs.
    postponed: Option<f64>,
    /// `rᵀr`.
    square: f64,
    of: &'a mut Padded,
}

impl Operations for PaddedSolve<'_> {
    fn start(&mut self, reference: Option<Norm>) -> StartReport {
        let constraints = self.problem.constraints;
        let mut start = StartReport { reference: f64::NAN, multiplications: 0 };
        let mut with_load = false;
        match reference {
            None => {}
            Some(norm) if constraints.has_prescribed_motion() => {
                self.of.x.fill([0.0; 4]);
                for &i in constraints.constrained() {
                    self.of.x[i as usize] = lanes(&constraints.prescribed(i as usize));
                }
                let square = self.residual();
                start = StartReport { reference: self.length(square, norm), multiplications: 1 };
            }
            Some(Norm::Euclid) => with_load = true,
            Some(Norm::Preconditioned) => {
                let Self { problem, of, .. } = &mut *self;
                for (k, r) in of.r.chunks_mut(BLOCK).enumerate() {
                    right_hand_side(Plain, *problem, of.buckets.block(k), k * BLOCK, r);
                }
                start.reference = of.precondition(*problem).sqrt();
            }
        }
        let Self { problem, solution, of, .. } = self;
        let squares = vectorised!(of.arch, [four,
            of: &'k mut Padded = of,
            problem: Problem<'k> = *problem,
            solution: &'k [Vec3] = solution,
            with_load: bool = with_load,
        ] -> (f64, f64) {
            of.load(four, problem.constraints, solution);
            of.residuals(four, problem, with_load)
        });
        self.square = squares.0;
        if with_load {
            start.reference = squares.1.sqrt();
        }
        start
    }

    fn stop_at_prescribed(&mut self) {
        self.problem.constraints.prescribed_only(self.solution);
    }

    fn residual_norm(&mut self) -> f64 {
        self.square.sqrt()
    }

    fn precondition(&mut self) -> f64 {
        self.of.precondition(self.problem)
    }

    fn refresh(&mut self) -> f64 {
        let Self { problem, of, .. } = self;
        of.q.copy_from_slice(&of.r);
        self.square = vectorised!(of.arch, [four,
            of: &'k mut Padded = of,
            problem: Problem<'k> = *problem,
            postponed: Option<f64> = self.postponed.take(),
        ] -> f64 {
            of.complete(four, postponed);
            of.residuals(four, problem, false).0
        });
        let gap = vectorised!(of.arch, [four, of: &'k mut Padded = of] -> f64 {
            for (q, r) in of.q.iter_mut().zip(&of.r) {
                *q = four.store(four.sub(four.load(*r), four.load(*q)));
            }
            dot(four, &of.q, &of.q)
        });
        gap.sqrt()
    }

    fn direction(&mut self, beta: Option<f64>) -> f64 {
        let Self { problem, of, .. } = self;
        vectorised!(of.arch, [four,
            of: &'k mut Padded = of,
            problem: Problem<'k> = *problem,
            beta: Option<f64> = beta,
            postponed: Option<f64> = self.postponed.take(),
        ] -> f64 {
            of.direction(four, problem, beta, postponed)
        })
    }

    fn direction_is_zero(&mut self) -> bool {
        self.of.c.as_flattened().iter().all(|c| c * c == 0.0)
    }

    fn advance(&mut self, alpha: f64) {
        self.postponed = Some(alpha);
        let of = &mut *self.of;
        self.square = vectorised!(of.arch, [four, of: &'k mut Padded = of, alpha: f64 = alpha] -> f64 {
            let minus_alpha = four.splat(-alpha);
            let mut square = 0.0;
            for (r, q) in of.r.chunks_mut(BLOCK).zip(of.q.chunks(BLOCK)) {
                square += sum(four, Advance { minus_alpha, r, q });
            }
            square
        });
    }

    fn finish(&mut self) {
        let Self { of, solution, .. } = self;
        let postponed = self.postponed.take();
        vectorised!(of.arch, [four,
            of: &'k mut Padded = of,
            postponed: Option<f64> = postponed,
            solution: &'k mut [Vec3] = solution,
        ] -> () {
            of.complete(four, postponed);
            for (v, x) in solution.iter_mut().zip(&of.x) {
                *v = Vec3::new(x[0], x[1], x[2]);
            }
        });
    }
}

impl PaddedSolve<'_> {
    /// `r ← S (b − A x)`, and its square.
    fn residual(&mut self) -> f64 {
        let Self { problem, of, .. } = self;
        vectorised!(of.arch, [four,
            of: &'k mut Padded = of,
            problem: Problem<'k> = *problem,
        ] -> f64 {
            of.residuals(four, problem, false).0
        })
    }

    /// The length of `r`, whose square is given.
    fn length(&mut self, square: f64, norm: Norm) -> f64 {
        match norm {
            Norm::Euclid => square.sqrt(),
            Norm::Preconditioned => self.of.precondition(self.problem).sqrt(),
        }
    }
}

impl Padded {
    /// `s ← P r`, unless `P` is diagonal; returns `rᵀ P r`.
    fn precondition(&mut self, problem: Problem<'_>) -> f64 {
        vectorised!(self.arch, [four, of: &'k mut Padded = self, problem: Problem<'k> = problem] -> f64 {
            match problem.p {
                ScalarPreconditioner::Identity => dot(four, &of.r, &of.r),
                ScalarPreconditioner::Jacobi(jacobi) => {
                    let inverse = &jacobi.inverse_diagonal()[..of.r.len()];
                    let blocks = of.r.chunks(BLOCK).zip(inverse.chunks(BLOCK));
                    blocks.fold(0.0, |delta, (r, inverse)| delta + sum(four, Divided { r, inverse }))
                }
                ScalarPreconditioner::Ic0(factor) => {
                    factor.apply_to_lanes(four, &of.r, &mut of.s);
                    dot(four, &of.r, &of.s)
                }
            }
        })
    }

    /// `x ← S x₀ + (I − S) z`.
    #[inline(always)]
    fn load(&mut self, four: impl Four, constraints: &Constraints, start: &[Vec3]) {
        for (x, v) in self.x.iter_mut().zip(start) {
            *x = four.store(four.load(lanes(v)));
        }
        for &i in constraints.constrained() {
            let i = i as usize;
            let free = constraints.filter(i).apply(start[i]);
            self.x[i] = lanes(&(free + constraints.prescribed(i)));
        }
    }

    /// `r ← S (b − A x)`. Returns its square and, if `with_load`, that of `S b`, with `q` as
    /// scratch memory.
    #[inline(always)]
    fn residuals(&mut self, four: impl Four, problem: Problem<'_>, with_load: bool) -> (f64, f64) {
        let (mut square, mut load) = (0.0, 0.0);
        for (k, (r, b)) in self.r.chunks_mut(BLOCK).zip(problem.b.chunks(BLOCK)).enumerate() {
            let (first, particles) = (k * BLOCK, self.buckets.block(k));
            // Right-hand sides stay in registers: a load after a store in pieces would stall.
            let of_block = sum(four, Residual { a: problem.a, x: &self.x, first, b, r });
            square += if particles.is_empty() {
                of_block
            } else {
                project(problem.constraints, particles, first, r);
                sum(four, Product(r, r))
            };
            if with_load {
                let right = &mut self.q[..r.len()];
                right_hand_side(four, problem, particles, first, right);
                load += sum(four, Product(right, right));
            }
        }
        (square, load)
    }

    /// `x ← x + α c`.
    #[inline(always)]
    fn complete(&mut self, four: impl Four, alpha: Option<f64>) {
        let Some(alpha) = alpha else { return };
        let alpha = four.splat(alpha);
        for (x, c) in self.x.iter_mut().zip(&self.c) {
            *x = four.store(four.add(four.load(*x), four.mul(alpha, four.load(*c))));
        }
    }

    /// One sweep: the postponed `x ← x + α c`, then `c ← S (P r + β c)`, and as soon as the needed
    /// rows are known, `q ← S A c` and `cᵀq`.
    #[inline(always)]
    fn direction(
        &mut self,
        four: impl Four,
        problem: Problem<'_>,
        beta: Option<f64>,
        postponed: Option<f64>,
    ) -> f64 {
        let n = self.r.len();
        let blocks = n.div_ceil(BLOCK);
        let (mut curvature, mut multiplied) = (0.0, 0);
        for k in 0..blocks {
            let (first, known) = (k * BLOCK, n.min((k + 1) * BLOCK));
            match problem.p {
                ScalarPreconditioner::Identity => {
                    self.turn(four, first..known, beta, postponed, |r, _, _| four.load(r));
                }
                ScalarPreconditioner::Jacobi(jacobi) => {
                    let inverse = jacobi.inverse_diagonal();
                    self.turn(four, first..known, beta, postponed, |r, _, i| {
                        four.mul(four.load(r), four.splat(inverse[i]))
                    });
                }
                ScalarPreconditioner::Ic0(_) => {
                    self.turn(four, first..known, beta, postponed, |_, s, i| four.load(s[i]));
                }
            }
            project(problem.constraints, self.buckets.block(k), first, &mut self.c[first..known]);
            while multiplied < blocks {
                let (first, end) = (multiplied * BLOCK, n.min((multiplied + 1) * BLOCK));
                if end + self.reach > known && known < n {
                    break;
                }
                let (c, q) = (&self.c[first..end], &mut self.q[first..end]);
                let of_block = sum(four, Curvature { a: problem.a, all: &self.c, first, c, q });
                let particles = self.buckets.block(multiplied);
                curvature += if particles.is_empty() {
                    of_block
                } else {
                    project(problem.constraints, particles, first, q);
                    sum(four, Product(c, q))
                };
                multiplied += 1;
            }
        }
        curvature
    }

    /// `x ← x + α c`, `c ← P r + β c` in some rows, where `P r` in row `i` is `s(r, s, i)`.
    #[inline(always)]
    fn turn<F: Four>(
        &mut self,
        four: F,
        rows: std::ops::Range<usize>,
        beta: Option<f64>,
        postponed: Option<f64>,
        s: impl Fn(Lanes, &[Lanes], usize) -> F::Numbers,
    ) {
        let first = rows.start;
        let (x, c) = (&mut self.x[rows.clone()], &mut self.c[rows.clone()]);
        for (i, ((x, c), r)) in x.iter_mut().zip(c).zip(&self.r[rows]).enumerate() {
            let old = four.load(*c);
            if let Some(alpha) = postponed {
                *x = four.store(four.add(four.load(*x), four.mul(four.splat(alpha), old)));
            }
            let mut new = s(*r, &self.s, first + i);
            if let Some(beta) = beta {
                new = four.add(new, four.mul(four.splat(beta), old));
            }
            *c = four.store(new);
        }
    }
}

/// A particle's coordinates.
#[inline(always)]
fn lanes(v: &Vec3) -> Lanes {
    [v.x, v.y, v.z, 0.0]
}

/// `out ← S b` in a block with these constrained particles that begins with row `first`.
#[inline(always)]
fn right_hand_side(
    four: impl Four,
    problem: Problem<'_>,
    particles: &[u32],
    first: usize,
    out: &mut [Lanes],
) {
    for (out, b) in out.iter_mut().zip(&problem.b[first..]) {
        *out = four.store(four.load(lanes(b)));
    }
    project(problem.constraints, particles, first, out);
}

/// Row `i` of `A x`, summed from its first column to its last.
#[inline(always)]
fn row_product<F: Four>(four: F, a: &ScalarMatrix, x: &[Lanes], i: usize) -> F::Numbers {
    let (columns, values) = a.row(i);
    let mut sum = four.splat(0.0);
    for (&j, &value) in columns.iter().zip(values) {
        sum = four.add(sum, four.mul(four.splat(value), four.load(x[j as usize])));
    }
    sum
}

/// `x ← S x` for the constrained particles of a block that begins with row `first`.
#[inline(always)]
fn project(constraints: &Constraints, particles: &[u32], first: usize, x: &mut [Lanes]) {
    for &i in particles {
        let x = &mut x[i as usize - first];
        *x = lanes(&constraints.filter(i as usize).apply(Vec3::new(x[0], x[1], x[2])));
    }
}

/// The dot product of two vectors.
#[inline(always)]
fn dot(four: impl Four, a: &[Lanes], b: &[Lanes]) -> f64 {
    let mut total = 0.0;
    for (a, b) in a.chunks(BLOCK).zip(b.chunks(BLOCK)) {
        total += sum(four, Product(a, b));
    }
    total
}

/// The terms of a sum over the particles of a block, with updates on the way. A closure might not
/// be inlined into the function that has the instruction set.
trait Terms<F: Four> {
    /// Number of terms.
    fn len(&self) -> usize;

    /// The term of particle `i`.
    fn term(&mut self, four: F, i: usize) -> F::Numbers;
}

/// Sums in the documented order.
#[inline(always)]
fn sum<F: Four>(four: F, mut terms: impl Terms<F>) -> f64 {
    let len = terms.len();
    let mut sums = [four.splat(0.0); SLOTS];
    let mut i = 0;
    while i + SLOTS <= len {
        for (s, sum) in sums.iter_mut().enumerate() {
            *sum = four.add(*sum, terms.term(four, i + s));
        }
        i += SLOTS;
    }
    for sum in sums.iter_mut().take(len - i) {
        *sum = four.add(*sum, terms.term(four, i));
        i += 1;
    }
    combine(&sums.map(|sum| {
        let [x, y, z, _] = four.store(sum);
        [x, y, z]
    }))
}

/// Of a dot product.
struct Product<'a>(&'a [Lanes], &'a [Lanes]);

impl<F: Four> Terms<F> for Product<'_> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.0.len().min(self.1.len())
    }

    #[inline(always)]
    fn term(&mut self, four: F, i: usize) -> F::Numbers {
        four.mul(four.load(self.0[i]), four.load(self.1[i]))
    }
}

/// Of `rᵀ D⁻¹ r`.
struct Divided<'a> {
    r: &'a [Lanes],
    inverse: &'a [f64],
}

impl<F: Four> Terms<F> for Divided<'_> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.r.len().min(self.inverse.len())
    }

    #[inline(always)]
    fn term(&mut self, four: F, i: usize) -> F::Numbers {
        let r = four.load(self.r[i]);
        four.mul(r, four.mul(r, four.splat(self.inverse[i])))
    }
}

/// Of `rᵀr` after `r ← r − α q`.
struct Advance<'a, N> {
    minus_alpha: N,
    r: &'a mut [Lanes],
    q: &'a [Lanes],
}

impl<F: Four> Terms<F> for Advance<'_, F::Numbers> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.r.len().min(self.q.len())
    }

    #[inline(always)]
    fn term(&mut self, four: F, i: usize) -> F::Numbers {
        let step = four.mul(self.minus_alpha, four.load(self.q[i]));
        let new = four.add(four.load(self.r[i]), step);
        self.r[i] = four.store(new);
        four.mul(new, new)
    }
}

/// Of `rᵀr` after `r ← b − A x` in a block that begins with row `first`.
struct Residual<'a> {
    a: &'a ScalarMatrix,
    x: &'a [Lanes],
    first: usize,
    b: &'a [Vec3],
    r: &'a mut [Lanes],
}

impl<F: Four> Terms<F> for Residual<'_> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.r.len().min(self.b.len())
    }

    #[inline(always)]
    fn term(&mut self, four: F, i: usize) -> F::Numbers {
        let product = row_product(four, self.a, self.x, self.first + i);
        let new = four.sub(four.load(lanes(&self.b[i])), product);
        self.r[i] = four.store(new);
        four.mul(new, new)
    }
}

/// Of `cᵀq` after `q ← A c` in a block that begins with row `first`.
struct Curvature<'a> {
    a: &'a ScalarMatrix,
    all: &'a [Lanes],
    first: usize,
    c: &'a [Lanes],
    q: &'a mut [Lanes],
}

impl<F: Four> Terms<F> for Curvature<'_> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.c.len().min(self.q.len())
    }

    #[inline(always)]
    fn term(&mut self, four: F, i: usize) -> F::Numbers {
        let product = row_product(four, self.a, self.all, self.first + i);
        self.q[i] = four.store(product);
        four.mul(four.load(self.c[i]), product)
    }
}
