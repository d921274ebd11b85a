//! Conjugate gradients in single precision on bands, for solves with a loose tolerance.
//!
//! An inexact Newton method needs a few digits of each linear system, and checks the result by its
//! own residual in double precision. In single precision the matrix takes half of the memory, a
//! register holds twice as many numbers, and the vectors of the loop stay in one array per
//! coordinate, so no product copies them. On one core of a Zen 3, an iteration on 52 × 52 particles
//! with six bands takes 29 µs: 23 for the product and 6 for the rest.
//!
//! Sums go by groups of [`GROUP`] rows with [`LANES`] accumulators a coordinate, and the groups'
//! sums are added in double precision. So the instruction set changes no bit.

use super::bands::Bands;
use super::product::{self, GROUP, Place, Term};
use super::{BlockMatrix, Layout};
use crate::bands::{Divisible, PerBlock, in_items, split_each};
use crate::{BlockJacobi, PcgReport, PcgSettings, SolveStatus, Vec3};

/// Accumulators of a sum.
const LANES: usize = 16;
/// No solve is tighter than this; round-off of the residual is some hundredth of it.
const LEAST_TERM: f64 = 1e-5;

/// Conjugate gradients in single precision, preconditioned by the diagonal blocks.
#[derive(Debug)]
pub struct SinglePcg {
    n: usize,
    /// Parts of a sweep that threads share.
    bands: usize,
    offsets: Vec<usize>,
    /// Zeros before row 0, at least the largest offset.
    lead: usize,
    /// Distance of two planes of the matrix, and of two of a vector.
    strides: [usize; 2],
    terms: Vec<Term>,
    /// `xx, xy, xz, yy, yz, zz` of the diagonal, then of each band.
    matrix: Vec<f32>,
    /// The same of the inverse diagonal blocks, without lead.
    inverse: Vec<f32>,
    x: Vec<f32>,
    r: Vec<f32>,
    c: Vec<f32>,
    q: Vec<f32>,
    s: Vec<f32>,
    /// Two sums for each group of rows.
    sums: Vec<[f64; 2]>,
}

impl SinglePcg {
    /// Memory for solves with a matrix of bands; `None` for any other layout.
    pub fn new(a: &BlockMatrix) -> Option<Self> {
        let Layout::Bands(bands) = &a.layout else { return None };
        let (n, lead, offsets) = (bands.n(), bands.lead(), bands.offsets().to_vec());
        let page = |len: usize| len.next_multiple_of(1024) + 80;
        let strides = [page(lead + n + LANES), page(2 * lead + n + LANES)];
        let vector = || vec![0.0; 3 * strides[1]];
        Some(Self {
            n,
            bands: 1,
            lead,
            strides,
            terms: product::terms(&offsets, lead, strides[0]),
            matrix: vec![0.0; 6 * (offsets.len() + 1) * strides[0]],
            inverse: vec![0.0; 6 * strides[0]],
            offsets,
            x: vector(),
            r: vector(),
            c: vector(),
            q: vector(),
            s: vector(),
            sums: vec![[0.0; 2]; n.next_multiple_of(LANES).div_ceil(GROUP)],
        })
    }

    /// Solves `A x = b` from zero until `‖b − A x‖` is `settings.forcing_term` times `‖b‖`, but not
    /// below 1e-5 times. `diagonal` holds the inverse diagonal blocks of `a`. The norm is always
    /// Euclid's, so `settings.norm` is ignored. The scales of `a` and `b` do not matter.
    ///
    /// If single precision is not sufficient, the solve ends with [`SolveStatus::IterationLimit`].
    /// It ends with [`SolveStatus::Indefinite`] if the matrix is not positive definite, or if
    /// numbers leave the range. `x` is undefined then. The report counts one product per iteration,
    /// and the product that shows an indefinite matrix. Returns `None` for a matrix of another
    /// layout.
    ///
    /// # Panics
    /// When the lengths differ.
    pub fn solve(
        &mut self,
        a: &BlockMatrix,
        diagonal: &BlockJacobi,
        b: &[Vec3],
        x: &mut [Vec3],
        settings: &PcgSettings,
    ) -> Option<PcgReport> {
        assert_eq!([b.len(), x.len()], [self.n; 2], "one vector a row");
        let Layout::Bands(bands) = &a.layout else { return None };
        if bands.n() != self.n || bands.offsets() != self.offsets {
            return None;
        }
        self.bands = a.bands;
        let stiffest = self.load(bands, diagonal);
        let largest = self.largest(|row| b[row].amax());
        if largest == 0.0 {
            x.fill(Vec3::zeros());
            let is_zero = b.iter().all(|b| *b == Vec3::zeros()); // else it is undefined
            let status = if is_zero { SolveStatus::Converged } else { SolveStatus::Indefinite };
            let (iterations, multiplications, relative_residual) = (0, 0, 0.0);
            return Some(PcgReport { iterations, multiplications, relative_residual, status });
        }
        let Self { n, bands, lead, strides: [_, stride], .. } = *self;
        let (_, groups) = self.extent();
        for plane in self.r.chunks_exact_mut(stride) {
            plane[lead + n..].fill(0.0);
        }
        let part = Groups { planes: planes_mut(&mut self.r, stride, lead, n), sums: &mut [] };
        in_items(bands, groups, part, &|groups, Groups { planes, .. }: Groups<'_, 3>| {
            for (axis, plane) in planes.into_iter().enumerate() {
                for (to, from) in plane.iter_mut().zip(&b[GROUP * groups.start..]) {
                    *to = (from[axis] / largest) as f32;
                }
            }
        });
        let term = settings.forcing_term.max(LEAST_TERM);
        let report = self.iterate(term, settings.max_iterations);
        let scale = largest / stiffest;
        let from = &self.x;
        in_items(bands, groups, Vectors(x), &|groups, Vectors(x)| {
            let planes = planes_of(from, stride, lead + GROUP * groups.start);
            for (axis, plane) in planes.into_iter().enumerate() {
                for (to, from) in x.iter_mut().zip(plane) {
                    to[axis] = f64::from(*from) * scale;
                }
            }
        });
        Some(report)
    }

    /// Reads the matrix over its greatest diagonal number, which it returns.
    fn load(&mut self, bands: &Bands, diagonal: &BlockJacobi) -> f64 {
        let [xx, _, _, yy, _, zz] = bands.diagonal();
        let stiffest = self.largest(|row| xx[row].max(yy[row]).max(zz[row]));
        let stiffest = stiffest.max(f64::MIN_POSITIVE);
        let len = self.lead + self.n + LANES;
        let inverse = 1.0 / stiffest;
        let stride = self.strides[0];
        let part = Planes { numbers: &mut self.matrix, stride };
        in_items(self.bands, 6 * (self.offsets.len() + 1), part, &|planes, part: Planes<'_>| {
            let from = bands.planes().skip(planes.start);
            for (to, from) in part.numbers.chunks_exact_mut(stride).zip(from) {
                for (to, from) in to[..len].iter_mut().zip(from) {
                    *to = (from * inverse) as f32;
                }
            }
        });
        let (n, part) = (self.n, Planes { numbers: &mut self.inverse, stride });
        in_items(self.bands, 6, part, &|planes, part: Planes<'_>| {
            let from = diagonal.planes().into_iter().skip(planes.start);
            for (to, from) in part.numbers.chunks_exact_mut(stride).zip(from) {
                for (to, from) in to[..n].iter_mut().zip(from) {
                    *to = (from * stiffest) as f32;
                }
            }
        });
        stiffest
    }

    /// The greatest of some numbers, one a row, or 0. Their order does not matter, so neither do
    /// bands.
    fn largest(&mut self, number: impl Fn(usize) -> f64 + Sync) -> f64 {
        let (n, groups) = (self.n, self.extent().1);
        let part = PerBlock(&mut self.sums[..]);
        in_items(self.bands, groups, part, &|groups, PerBlock(sums): PerBlock<'_, [f64; 2]>| {
            for (group, sum) in groups.zip(sums) {
                let rows = GROUP * group..n.min(GROUP * (group + 1));
                sum[0] = rows.fold(0.0, |largest: f64, row| largest.max(number(row)));
            }
        });
        self.sums.iter().fold(0.0, |largest: f64, sum| largest.max(sum[0]))
    }
}

impl SinglePcg {
    /// The iterations, from the residual in `r`.
    fn iterate(&mut self, term: f64, most: usize) -> PcgReport {
        let mut report = PcgReport {
            iterations: 0,
            multiplications: 0,
            relative_residual: 1.0,
            status: SolveStatus::IterationLimit,
        };
        self.x.fill(0.0);
        self.c.fill(0.0);
        self.q.fill(0.0);
        let [mut squared, mut delta] = self.advance(0.0); // s = P r, δ = r·s
        let goal = term * term * squared;
        let reference = squared;
        let mut beta = 0.0;
        while report.iterations < most {
            self.turn(beta); // c ← s + β c
            let curvature = self.multiply(); // q = A c
            report.multiplications += 1;
            let alpha = (delta / curvature) as f32;
            let is_definite = curvature > 0.0 && delta > 0.0;
            if !(is_definite && curvature.is_finite() && alpha.is_finite()) {
                report.status = SolveStatus::Indefinite;
                break;
            }
            let last = delta;
            [squared, delta] = self.advance(alpha);
            report.iterations += 1;
            report.relative_residual = (squared / reference).sqrt();
            if squared <= goal {
                report.status = SolveStatus::Converged;
                break;
            }
            beta = (delta / last) as f32;
        }
        report
    }

    /// Number of rows that sweeps visit, and of their groups.
    fn extent(&self) -> (usize, usize) {
        let rows = self.n.next_multiple_of(LANES);
        (rows, rows.div_ceil(GROUP))
    }

    /// `c ← s + β c`.
    fn turn(&mut self, beta: f32) {
        let (rows, groups) = self.extent();
        let Self { bands, lead, strides: [_, stride], ref mut c, ref s, .. } = *self;
        let part = Groups { planes: planes_mut(c, stride, lead, rows), sums: &mut [] };
        in_items(bands, groups, part, &|groups, Groups { planes, .. }| {
            let s = planes_of(s, stride, lead + GROUP * groups.start);
            pulp::Arch::new().dispatch(Turn { beta, s, c: planes });
        });
    }

    /// `x ← x + α c`, `r ← r − α q`, `s ← P r`; returns `r·r` and `r·s`.
    fn advance(&mut self, alpha: f32) -> [f64; 2] {
        let (rows, groups) = self.extent();
        let Self { bands, lead, strides: [matrix_stride, stride], .. } = *self;
        let Self { x, r, c, q, s, inverse, sums, .. } = self;
        let [x, r, s] = [x, r, s].map(|vector| planes_mut(vector, stride, lead, rows));
        let ([x0, x1, x2], [r0, r1, r2], [s0, s1, s2]) = (x, r, s);
        let planes = [x0, x1, x2, r0, r1, r2, s0, s1, s2];
        let part = Groups { planes, sums: &mut sums[..] };
        in_items(bands, groups, part, &|groups, part: Groups<'_, 9>| {
            let first = GROUP * groups.start;
            let [c, q] = [&*c, &*q].map(|vector| planes_of(vector, stride, lead + first));
            let inverse = std::array::from_fn(|k| &inverse[k * matrix_stride + first..]);
            pulp::Arch::new().dispatch(Advance { alpha, c, q, inverse, part });
        });
        sums.iter().fold([0.0; 2], |total, sum| [total[0] + sum[0], total[1] + sum[1]])
    }

    /// `q ← A c`; returns `c·q`.
    fn multiply(&mut self) -> f64 {
        let (rows, groups) = self.extent();
        let Self { bands, lead, strides, .. } = *self;
        let Self { q, c, matrix, terms, sums, .. } = self;
        let part = Groups { planes: planes_mut(q, strides[1], lead, rows), sums: &mut sums[..] };
        in_items(bands, groups, part, &|groups, part: Groups<'_, 3>| {
            let first = GROUP * groups.start;
            pulp::Arch::new().dispatch(Product { first, lead, strides, matrix, terms, c, part });
        });
        sums.iter().fold(0.0, |total, sum| total + sum[0])
    }
}

/// The rows of some planes in groups of [`GROUP`], and two sums for each group.
struct Groups<'a, const N: usize> {
    planes: [&'a mut [f32]; N],
    sums: &'a mut [[f64; 2]],
}

impl<const N: usize> Divisible for Groups<'_, N> {
    fn split(self, groups: usize) -> (Self, Self) {
        let (sums, other_sums) = self.sums.split_at_mut(groups.min(self.sums.len()));
        let [planes, others] = split_each(self.planes, GROUP * groups);
        (Self { planes, sums }, Self { planes: others, sums: other_sums })
    }
}

/// Planes of a matrix that threads share.
struct Planes<'a> {
    numbers: &'a mut [f32],
    stride: usize,
}

impl Divisible for Planes<'_> {
    fn split(self, planes: usize) -> (Self, Self) {
        let stride = self.stride;
        let (numbers, others) = self.numbers.split_at_mut(planes * stride);
        (Self { numbers, stride }, Self { numbers: others, stride })
    }
}

/// Vectors that threads share in groups of [`GROUP`].
struct Vectors<'a>(&'a mut [Vec3]);

impl Divisible for Vectors<'_> {
    fn split(self, groups: usize) -> (Self, Self) {
        let (left, right) = self.0.split_at_mut((GROUP * groups).min(self.0.len()));
        (Self(left), Self(right))
    }
}

/// The rows of the three planes of a vector, to be written.
fn planes_mut(vector: &mut [f32], stride: usize, lead: usize, rows: usize) -> [&mut [f32]; 3] {
    let (x, rest) = vector.split_at_mut(stride);
    let (y, z) = rest.split_at_mut(stride);
    [x, y, z].map(|plane| &mut plane[lead..][..rows])
}

/// The three planes of a vector from a place on.
fn planes_of(vector: &[f32], stride: usize, place: usize) -> [&[f32]; 3] {
    std::array::from_fn(|axis| &vector[axis * stride + place..(axis + 1) * stride])
}

struct Turn<'a> {
    beta: f32,
    s: [&'a [f32]; 3],
    c: [&'a mut [f32]; 3],
}

impl pulp::WithSimd for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { beta, s, c } = self;
        for (c, s) in c.into_iter().zip(s) {
            for (c, s) in c.iter_mut().zip(s) {
                *c = s + beta * *c;
            }
        }
    }
}

struct Advance<'a> {
    alpha: f32,
    c: [&'a [f32]; 3],
    q: [&'a [f32]; 3],
    inverse: [&'a [f32]; 6],
    /// `x`, `r` and `s`; `r·r` and `r·s`.
    part: Groups<'a, 9>,
}

impl pulp::WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { alpha, c, q, inverse, part } = self;
        let [x0, x1, x2, r0, r1, r2, s0, s1, s2] = part.planes;
        let rows = x0.len();
        let (x, r) = ([x0, x1, x2], [r0, r1, r2]);
        for (i, total) in (0..rows).step_by(GROUP).zip(part.sums) {
            let m = GROUP.min(rows - i);
            for axis in 0..3 {
                let (x, r) = (&mut x[axis][i..][..m], &mut r[axis][i..][..m]);
                let (c, q) = (&c[axis][i..][..m], &q[axis][i..][..m]);
                for t in 0..m {
                    x[t] += alpha * c[t];
                    r[t] -= alpha * q[t];
                }
            }
            let r: [&[f32]; 3] = std::array::from_fn(|axis| &r[axis][i..][..m]);
            let p: [&[f32]; 6] = std::array::from_fn(|k| &inverse[k][i..][..m]);
            let s0 = &mut s0[i..][..m];
            let s1 = &mut s1[i..][..m];
            let s2 = &mut s2[i..][..m];
            for t in 0..m {
                s0[t] = p[0][t] * r[0][t] + p[1][t] * r[1][t] + p[2][t] * r[2][t];
                s1[t] = p[1][t] * r[0][t] + p[3][t] * r[1][t] + p[4][t] * r[2][t];
                s2[t] = p[2][t] * r[0][t] + p[4][t] * r[1][t] + p[5][t] * r[2][t];
            }
            let mut sums = [[0.0; LANES]; 2];
            for (r, s) in r.into_iter().zip([&*s0, &*s1, &*s2]) {
                add_products(r, r, &mut sums[0]);
                add_products(r, s, &mut sums[1]);
            }
            *total = [sum(&sums[0]), sum(&sums[1])];
        }
    }
}

struct Product<'a> {
    /// First row.
    first: usize,
    lead: usize,
    strides: [usize; 2],
    matrix: &'a [f32],
    terms: &'a [Term],
    c: &'a [f32],
    /// `q`; `c·q`.
    part: Groups<'a, 3>,
}

impl pulp::WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { first, lead, strides: [matrix_stride, stride], matrix, terms, c, part } = self;
        let q = part.planes;
        let rows = q[0].len();
        for (i, total) in (0..rows).step_by(GROUP).zip(part.sums) {
            let m = GROUP.min(rows - i);
            let at = Place {
                planes: matrix,
                stride: matrix_stride,
                row: first + i,
                x: c,
                x_stride: stride,
                x_row: first + i,
                rows: m,
            };
            let mut sums = [[0.0; GROUP]; 3];
            at.add_all(terms, &mut sums);
            let mut dots = [0.0; LANES];
            for (axis, sums) in sums.iter().enumerate() {
                add_products(&c[axis * stride + lead + first + i..][..m], &sums[..m], &mut dots);
                q[axis][i..][..m].copy_from_slice(&sums[..m]);
            }
            total[0] = sum(&dots);
        }
    }
}

/// Adds the products of two arrays, number by number, to the accumulators in turn.
#[inline(always)]
fn add_products(a: &[f32], b: &[f32], sums: &mut [f32; LANES]) {
    for (a, b) in a.as_chunks::<LANES>().0.iter().zip(b.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
}

#[inline(always)]
fn sum(sums: &[f32; LANES]) -> f64 {
    sums.iter().map(|sum| f64::from(*sum)).sum()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::test_support::Random;
    use crate::{Filter, LinearOperator, Mat3, Norm, vector::norm};
    use drape_kernels::blocks::Coupling;

    /// A sheet with its springs along the bands, `M + θ K`, times `scale`, and pinned at row 5.
    fn sheet([down, across]: [usize; 2], theta: f64, scale: f64) -> BlockMatrix {
        let (n, mut random) = (down * across, Random::new(7));
        let offsets = vec![1, across - 1, across, across + 1];
        let mut a = BlockMatrix::new(n, &Coupling::Bands(offsets.clone()), []);
        (0..n).for_each(|i| a.add_diagonal(i, &Mat3::from_diagonal_element(scale)));
        for o in offsets {
            for i in 0..n.saturating_sub(o) {
                let u = (random.vector() + Vec3::x()).normalize();
                a.add_pair(i, i + o, &(u * u.transpose() * (theta * scale)));
            }
        }
        let mut constraints = crate::Constraints::free(n);
        constraints.set(5, Filter::Fixed, Vec3::zeros());
        a.project(&constraints);
        a
    }

    fn settings(forcing_term: f64) -> PcgSettings {
        PcgSettings { forcing_term, norm: Norm::Euclid, max_iterations: 500 }
    }

    fn solved(a: &BlockMatrix, b: &[Vec3], term: f64) -> (Vec<Vec3>, PcgReport) {
        let mut diagonal = BlockJacobi::new(a);
        diagonal.update(a).unwrap();
        let mut x = vec![Vec3::repeat(f64::NAN); a.n()];
        let mut pcg = SinglePcg::new(a).unwrap();
        let report = pcg.solve(a, &diagonal, b, &mut x, &settings(term)).unwrap();
        assert_eq!(report.status, SolveStatus::Converged);
        (x, report)
    }

    fn right_side(n: usize) -> Vec<Vec3> {
        let mut b = Random::new(8).vectors(n);
        b[5] = Vec3::zeros();
        b
    }

    #[test]
    fn the_residual_is_as_small_as_asked_for_on_sheets_of_any_size() {
        for sides in [[3, 7], [20, 20], [23, 31], [40, 60]] {
            let (a, b) = (sheet(sides, 100.0, 1.0), right_side(sides[0] * sides[1]));
            let mut last = 0;
            for term in [0.5, 1e-1, 1e-2, 1e-3, 1e-4] {
                let (x, report) = solved(&a, &b, term);
                let mut left = x.clone();
                a.multiply(&x, &mut left);
                left.iter_mut().zip(&b).for_each(|(left, b)| *left -= b);
                let ratio = norm(&left) / norm(&b);
                assert!(ratio < 1.05 * term, "{sides:?}: {ratio:e} for {term:e}");
                assert!((ratio - report.relative_residual).abs() < 0.05 * term, "{report:?}");
                assert!(report.iterations > last && report.multiplications == report.iterations);
                assert_eq!(x[5], Vec3::zeros());
                last = report.iterations;
            }
        }
    }

    #[test]
    fn scales_do_not_matter() {
        let b = right_side(400);
        let (x, report) = solved(&sheet([20, 20], 50.0, 1.0), &b, 1e-3);
        for [matrix, side] in [[2.0_f64.powi(-90), 2.0_f64.powi(-60)], [2.0_f64.powi(90), 1.0]] {
            let scaled: Vec<Vec3> = b.iter().map(|b| b * side).collect();
            let (other, same) = solved(&sheet([20, 20], 50.0, matrix), &scaled, 1e-3);
            assert_eq!(same, report);
            assert!(x.iter().zip(&other).all(|(x, y)| *x == y * (matrix / side)));
        }
    }

    #[test]
    fn it_says_where_it_does_not_do_and_counts_what_it_tried() {
        let mut a = sheet([20, 20], 50.0, 1.0);
        let b = right_side(400);
        let mut diagonal = BlockJacobi::new(&a);
        diagonal.update(&a).unwrap();
        let (mut pcg, mut x) = (SinglePcg::new(&a).unwrap(), b.clone());
        let few = PcgSettings { max_iterations: 3, ..settings(1e-3) };
        let ended = |report: PcgReport| (report.iterations, report.multiplications, report.status);
        let limited = pcg.solve(&a, &diagonal, &b, &mut x, &few).unwrap();
        assert_eq!(ended(limited), (3, 3, SolveStatus::IterationLimit));
        let zeros = vec![Vec3::zeros(); 400];
        let none = pcg.solve(&a, &diagonal, &zeros, &mut x, &few).unwrap();
        assert_eq!((ended(none), &x), ((0, 0, SolveStatus::Converged), &zeros));
        for undefined in [f64::NAN, f64::INFINITY] {
            for some in [1, 100, 400] {
                let mut b = zeros.clone();
                b[..some].fill(Vec3::repeat(undefined));
                let report = pcg.solve(&a, &diagonal, &b, &mut x, &settings(1e-4)).unwrap();
                assert_eq!(report.status, SolveStatus::Indefinite, "{some} of {undefined}");
            }
        }
        // A spring that pushes makes the matrix indefinite.
        a.add_pair(100, 101, &(Mat3::identity() * -1e4));
        let refused = pcg.solve(&a, &diagonal, &b, &mut x, &settings(1e-4)).unwrap();
        assert_eq!(refused.status, SolveStatus::Indefinite);
        assert_eq!(refused.multiplications, refused.iterations + 1);
        let rows = BlockMatrix::with_pattern(400, [(0, 1)]);
        assert!(SinglePcg::new(&rows).is_none());
        assert_eq!(pcg.solve(&rows, &diagonal, &b, &mut x, &few), None);
    }

    /// No solve leaves numbers behind, not even one that runs out of range: 713 rows end inside a
    /// group of accumulators.
    #[test]
    fn a_failed_solve_leaves_nothing_behind() {
        let (a, b) = (sheet([23, 31], 100.0, 1.0), right_side(713));
        let expected = solved(&a, &b, 1e-3);
        let mut diagonal = BlockJacobi::new(&a);
        diagonal.update(&a).unwrap();
        let mut pcg = SinglePcg::new(&a).unwrap();
        // Residuals of 1e-36 over P of 1e-3: the first length of a step exceeds single precision.
        let mut weak = BlockMatrix::new(713, &a.coupling(), []);
        let mut stiff = weak.clone();
        for i in 0..713 {
            let number = if i == 5 { 1.0 } else { 1e-36 };
            weak.add_diagonal(i, &Mat3::from_diagonal_element(number));
            stiff.add_diagonal(i, &Mat3::from_diagonal_element(1e3));
        }
        let mut wrong = BlockJacobi::new(&stiff);
        wrong.update(&stiff).unwrap();
        let mut x = b.clone();
        let report = pcg.solve(&weak, &wrong, &b, &mut x, &settings(1e-3)).unwrap();
        assert_eq!((report.iterations, report.status), (0, SolveStatus::Indefinite));
        pcg.r.fill(f32::NAN);
        let report = pcg.solve(&a, &diagonal, &b, &mut x, &settings(1e-3)).unwrap();
        assert_eq!((x, report), expected);
    }
}
