//! Conjugate gradients on compressed rows, for any pattern: a particle is four numbers, of which the last is zero,
//! so that one 256-bit operation serves its three coordinates.

use super::buckets::Buckets;
use super::simd::{Four, four_wide, vectorised};
use crate::pcg::{Norm, Operations, Start};
use crate::preconditioner::{IncompleteCholesky, Jacobi};
use crate::vector::{BLOCK, SLOTS, combine};
use crate::{Constraints, ScalarMatrix, Vec3};
use pulp::Arch;

/// The coordinates of a particle, and zero.
pub(crate) type Lanes = [f64; 4];

/// Which preconditioner a solve uses.
#[derive(Clone, Copy, Debug)]
pub enum ScalarPreconditioner<'a> {
    /// None.
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
    /// `P r`, where it is not the product with a diagonal.
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

/// What a solve looks at but does not change.
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
    /// `α` of an update of `x` that the next sweep over `c` will do.
    postponed: Option<f64>,
    /// `rᵀr`.
    square: f64,
    of: &'a mut Padded,
}

impl Operations for PaddedSolve<'_> {
    fn start(&mut self, reference: Option<Norm>) -> Start {
        let Self { problem, solution, of, .. } = self;
        let Problem { constraints, b, .. } = *problem;
        let mut start = Start { reference: f64::NAN, multiplications: 0 };
        if let Some(norm) = reference {
            if constraints.has_prescribed_motion() {
                of.x.fill([0.0; 4]);
                for &i in constraints.constrained() {
                    of.x[i as usize] = lanes(&constraints.prescribed(i as usize));
                }
                start.multiplications = 1;
            }
            let with_product = start.multiplications == 1;
            let square = vectorised!(of.arch, [four,
                of: &'k mut Padded = of,
                problem: Problem<'k> = *problem,
                with_product: bool = with_product,
            ] -> f64 {
                of.residual(four, problem, with_product)
            });
            start.reference = match norm {
                Norm::Euclid => square.sqrt(),
                Norm::Preconditioned => of.precondition(*problem).sqrt(),
            };
        }
        for (x, v) in of.x.iter_mut().zip(&**solution) {
            *x = lanes(v);
        }
        for &i in constraints.constrained() {
            let i = i as usize;
            let free = constraints.filter(i).apply(solution[i]);
            of.x[i] = lanes(&(free + constraints.prescribed(i)));
        }
        debug_assert_eq!(b.len(), of.x.len());
        self.square = vectorised!(of.arch, [four,
            of: &'k mut Padded = of,
            problem: Problem<'k> = *problem,
        ] -> f64 {
            of.residual(four, problem, true)
        });
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
            of.residual(four, problem, true)
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
            let mut sum = 0.0;
            for (r, q) in of.r.chunks_mut(BLOCK).zip(of.q.chunks(BLOCK)) {
                sum += sum_of_block(four, q.len(), |i| {
                    let new = four.add(four.load(r[i]), four.mul(minus_alpha, four.load(q[i])));
                    r[i] = four.store(new);
                    four.mul(new, new)
                });
            }
            sum
        });
    }

    fn finish(&mut self) {
        let of = &mut *self.of;
        let postponed = self.postponed.take();
        vectorised!(of.arch, [four, of: &'k mut Padded = of, postponed: Option<f64> = postponed] -> () {
            of.complete(four, postponed)
        });
        for (v, x) in self.solution.iter_mut().zip(&of.x) {
            *v = Vec3::new(x[0], x[1], x[2]);
        }
    }
}

impl Padded {
    /// `s ← P r` unless `P` is diagonal; returns `rᵀ P r`.
    fn precondition(&mut self, problem: Problem<'_>) -> f64 {
        vectorised!(self.arch, [four, of: &'k mut Padded = self, problem: Problem<'k> = problem] -> f64 {
            match problem.p {
                ScalarPreconditioner::Identity => dot(four, &of.r, &of.r),
                ScalarPreconditioner::Jacobi(jacobi) => {
                    let inverse = &jacobi.inverse_diagonal()[..of.r.len()];
                    let mut sum = 0.0;
                    for (r, inverse) in of.r.chunks(BLOCK).zip(inverse.chunks(BLOCK)) {
                        sum += sum_of_block(four, r.len().min(inverse.len()), |i| {
                            let r = four.load(r[i]);
                            four.mul(r, four.mul(r, four.splat(inverse[i])))
                        });
                    }
                    sum
                }
                ScalarPreconditioner::Ic0(factor) => {
                    factor.apply_to_lanes(four, &of.r, &mut of.s);
                    dot(four, &of.r, &of.s)
                }
            }
        })
    }

    /// `r ← S (b − A x)` or `S b`, and its square.
    #[inline(always)]
    fn residual(&mut self, four: impl Four, problem: Problem<'_>, with_product: bool) -> f64 {
        let mut sum = 0.0;
        for (k, (r, b)) in self.r.chunks_mut(BLOCK).zip(problem.b.chunks(BLOCK)).enumerate() {
            let first = k * BLOCK;
            for (i, (r, b)) in r.iter_mut().zip(b).enumerate() {
                *r = lanes(b);
                if with_product {
                    let product = row_product(four, problem.a, &self.x, first + i);
                    *r = four.store(four.sub(four.load(*r), product));
                }
            }
            project(problem.constraints, self.buckets.block(k), first, r);
            sum += sum_of_block(four, r.len(), |i| four.mul(four.load(r[i]), four.load(r[i])));
        }
        sum
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

    /// One sweep: `x ← x + α c` as postponed, `c ← S (P r + β c)`, and as soon as the rows that it needs
    /// are known, `q ← S A c` and `cᵀq`.
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
                let q = &mut self.q[first..end];
                for (i, q) in q.iter_mut().enumerate() {
                    *q = four.store(row_product(four, problem.a, &self.c, first + i));
                }
                project(problem.constraints, self.buckets.block(multiplied), first, q);
                let c = &self.c[first..end];
                curvature +=
                    sum_of_block(four, q.len(), |i| four.mul(four.load(c[i]), four.load(q[i])));
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
    let mut sum = 0.0;
    for (a, b) in a.chunks(BLOCK).zip(b.chunks(BLOCK)) {
        sum += sum_of_block(four, b.len().min(a.len()), |i| {
            four.mul(four.load(a[i]), four.load(b[i]))
        });
    }
    sum
}

/// The sum of `len` terms of three numbers each.
#[inline(always)]
fn sum_of_block<F: Four>(four: F, len: usize, mut term: impl FnMut(usize) -> F::Numbers) -> f64 {
    let mut sums = [four.splat(0.0); SLOTS];
    let mut i = 0;
    while i + SLOTS <= len {
        for (s, sum) in sums.iter_mut().enumerate() {
            *sum = four.add(*sum, term(i + s));
        }
        i += SLOTS;
    }
    for sum in sums.iter_mut().take(len - i) {
        *sum = four.add(*sum, term(i));
        i += 1;
    }
    combine(&sums.map(|sum| {
        let [x, y, z, _] = four.store(sum);
        [x, y, z]
    }))
}
