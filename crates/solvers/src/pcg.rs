//! Preconditioned conjugate gradients for a filtered system.
//!
//! The loop is Baraff & Witkin's (1998, section 5) with the corrections of Ascher & Boxerman
//! (2003): it projects the start vector instead of discarding it, and measures the residual against
//! the filtered right-hand side. With the filter `S`, the prescribed values `z` and `P ≈ A⁻¹` it
//! finds `x = S x + (I − S) z` with `S (b − A x) = 0`.
//!
//! The loop contains only the control flow. A private trait supplies the sums and updates over all
//! particles, so the same loop runs the readable kernels here and the fast kernels of
//! [`ScalarPcg`](crate::ScalarPcg).

mod operations;

use crate::vector::{BLOCK, axpy};
use crate::{Constraints, LinearOperator, Preconditioner, Vec3};
use operations::Readable;
pub(crate) use operations::{Operations, StartReport};

/// Iterations between two computations of the residual from its definition.
const REFRESH_INTERVAL: usize = 50;

/// A recursive residual below this fraction of the scale of the problem is not trusted, since
/// round-off may have parted it from `b − A x`. The loop computes `b − A x` before it reports
/// convergence.
const TRUSTED_REDUCTION: f64 = 1e-8;

/// The recursive residual has parted from the true one when they differ by more than this fraction
/// of the true one.
const PARTED: f64 = 0.5;

/// After the residuals have parted, the true one must have fallen by this factor before they part
/// again; otherwise round-off has ended all progress.
const LEAST_PROGRESS: f64 = 0.5;

/// The norm of residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Norm {
    /// `√(rᵀr)` (Eberhardt, Etzmuß & Hauth 2000).
    Euclid,
    /// `√(rᵀPr)` (Baraff & Witkin 1998), which approximates the error in the energy norm.
    Preconditioned,
}

/// The number to which the residual is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// The norm of `S (b − A (I − S) z)`. Without the filter the norm would contain the reactions
    /// of the supports, which are large and which no iteration reduces. It costs a multiplication
    /// only if a prescribed value is not zero.
    FilteredRightHandSide,
    /// A number from the caller, in the chosen norm.
    Absolute(f64),
}

/// When a solve stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PcgSettings {
    /// The solve stops if the residual is at most this many times the reference.
    pub forcing_term: f64,
    /// The norm of residual and reference.
    pub norm: Norm,
    /// The solve stops after this many iterations.
    pub max_iterations: usize,
}

impl PcgSettings {
    /// A generous limit for `n` particles: `10 √(3n)`, at least 100.
    pub fn default_max(n: usize) -> usize {
        let unknowns = (3 * n) as f64;
        ((10.0 * unknowns.sqrt()).ceil() as usize).max(100)
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveStatus {
    /// The residual is within the tolerance.
    Converged,
    /// The solve used all allowed iterations.
    IterationLimit,
    /// The solve met a direction of zero or negative curvature, so matrix or preconditioner is not
    /// positive definite; or it met an infinite or undefined number.
    Indefinite,
    /// Round-off keeps the residual above the tolerance. More iterations would not improve the
    /// solution.
    Stagnated,
}

/// Costs and result of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PcgReport {
    /// Steps along a search direction.
    pub iterations: usize,
    /// Products with the matrix: one for each iteration, one for the first residual, one for the
    /// reference if motion is prescribed, and one for each computation of the residual from its
    /// definition.
    pub multiplications: usize,
    /// Last residual divided by the reference, in the chosen norm; 0/0 counts as 0.
    pub relative_residual: f64,
    /// How the solve ended.
    pub status: SolveStatus,
}

/// The vectors of a solve. With them a solve allocates nothing.
#[derive(Clone, Debug)]
pub struct PcgWorkspace {
    /// Residual `r = S (b − A x)`.
    r: Vec<Vec3>,
    /// Search direction `c`.
    c: Vec<Vec3>,
    /// `q = S A c`; at other times scratch.
    q: Vec<Vec3>,
    /// Preconditioned residual `s = P r`.
    s: Vec<Vec3>,
    /// Scratch of sums that threads share.
    sums: Vec<f64>,
}

impl PcgWorkspace {
    /// Room for `n` particles.
    pub fn new(n: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        let sums = vec![0.0; n.div_ceil(BLOCK)];
        Self { r: zeros(), c: zeros(), q: zeros(), s: zeros(), sums }
    }

    /// The filtered residual `S (b − A x)` at the end of the last solve, as the recursion computed
    /// it.
    pub fn residual(&self) -> &[Vec3] {
        &self.r
    }
}

/// Solves `S (b − A x) = 0` for `x` with `(I − S) x = (I − S) z`. The solve starts at the free part
/// of `x`; on return `x` holds the solution, or the last iterate.
///
/// It solves for all 3n unknowns at once: dot products run over all coordinates. Three separate
/// solves, one for each coordinate, would take other numbers of iterations.
///
/// The first test of the residual precedes the first iteration, so a good start may need none.
/// Where the reference is zero, the prescribed values alone are the solution.
///
/// ```
/// use drape_solvers::{
///     Constraints, Filter, Identity, Norm, PcgSettings, PcgWorkspace, Reference, ScalarMatrix,
///     SolveStatus, Vec3, filtered_pcg,
/// };
/// // Two coupled nodes: the first is moved by (1, 0, 0), and no force acts on the second.
/// let mut a = ScalarMatrix::with_pattern(2, [(0, 1)]);
/// a.add_diagonal(0, 1.0);
/// a.add_diagonal(1, 1.0);
/// a.add_edge(0, 1, 3.0);
/// let mut constraints = Constraints::free(2);
/// constraints.set(0, Filter::Fixed, Vec3::x());
/// let mut x = [Vec3::zeros(); 2];
/// let report = filtered_pcg(
///     &a,
///     &Identity,
///     &constraints,
///     &[Vec3::zeros(); 2],
///     &mut x,
///     Reference::FilteredRightHandSide,
///     &PcgSettings { forcing_term: 1e-12, norm: Norm::Euclid, max_iterations: 10 },
///     &mut PcgWorkspace::new(2),
/// );
/// assert_eq!(report.status, SolveStatus::Converged);
/// assert_eq!(x, [Vec3::x(), Vec3::x() * 0.75]);
/// ```
///
/// # Panics
/// When the sizes of the arguments differ.
#[expect(
    clippy::too_many_arguments,
    reason = "a linear solve has this many independent parts; each call names them in order"
)]
pub fn filtered_pcg(
    a: &(impl LinearOperator + ?Sized),
    p: &dyn Preconditioner,
    constraints: &Constraints,
    b: &[Vec3],
    x: &mut [Vec3],
    reference: Reference,
    settings: &PcgSettings,
    workspace: &mut PcgWorkspace,
) -> PcgReport {
    let n = a.size();
    assert!(
        [constraints.len(), b.len(), x.len(), workspace.r.len()] == [n; 4],
        "matrix, constraints, vectors and workspace are for different numbers of particles"
    );
    let mut operations = Readable { a, p, constraints, b, x, workspace };
    conjugate_gradients(&mut operations, reference, settings)
}

/// The loop of [`filtered_pcg`] over any implementation of its operations.
pub(crate) fn conjugate_gradients(
    operations: &mut impl Operations,
    reference: Reference,
    settings: &PcgSettings,
) -> PcgReport {
    let mut report = PcgReport {
        iterations: 0,
        multiplications: 0,
        relative_residual: f64::NAN,
        status: SolveStatus::Indefinite,
    };
    let reference = match reference {
        Reference::Absolute(value) => {
            operations.start(None);
            value
        }
        Reference::FilteredRightHandSide => {
            let start = operations.start(Some(settings.norm));
            report.multiplications += start.multiplications;
            if start.reference == 0.0 {
                operations.stop_at_prescribed();
                report.relative_residual = 0.0;
                report.status = SolveStatus::Converged;
                return report;
            }
            start.reference
        }
    };
    report.multiplications += 1;
    let target = settings.forcing_term * reference;

    // Whether r comes from its definition, not from the recursion.
    let mut fresh = true;
    // Whether the next direction starts a new sequence of conjugate ones.
    let mut restart = true;
    // The largest residual so far, or the reference: the scale of round-off.
    let mut scale = reference;
    // δ of the iteration before.
    let mut delta_old = f64::NAN;
    // Length of the true residual when the recursive one last parted from it.
    let mut parted_at = f64::INFINITY;
    let mut out_of_digits = false;

    report.status = loop {
        // How large is the residual?  δ = rᵀ P r
        let mut delta = f64::NAN;
        let length = match settings.norm {
            Norm::Euclid => operations.residual_norm(),
            Norm::Preconditioned => {
                delta = operations.precondition();
                delta.sqrt()
            }
        };
        report.relative_residual = if length == 0.0 { 0.0 } else { length / reference };
        if !length.is_finite() {
            break SolveStatus::Indefinite;
        }
        scale = scale.max(length);
        let small = length <= target;
        if small && (fresh || length >= TRUSTED_REDUCTION * scale) {
            break SolveStatus::Converged;
        }
        if out_of_digits {
            break SolveStatus::Stagnated;
        }

        // Is it the residual at all?
        if !fresh && (small || report.iterations.is_multiple_of(REFRESH_INTERVAL)) {
            let gap = operations.refresh();
            report.multiplications += 1;
            fresh = true;
            let length = operations.residual_norm();
            if small || gap > PARTED * length {
                out_of_digits = length > LEAST_PROGRESS * parted_at;
                parted_at = length;
                restart = true;
            }
            continue;
        }
        if report.iterations >= settings.max_iterations {
            break SolveStatus::IterationLimit;
        }

        // c ← S (P r + δ/δ_old c),  q = S A c
        if settings.norm == Norm::Euclid {
            delta = operations.precondition();
        }
        if delta == 0.0 {
            break SolveStatus::Stagnated;
        }
        if delta < 0.0 || delta.is_nan() {
            break SolveStatus::Indefinite;
        }
        let beta = (!restart).then(|| delta / delta_old);
        let curvature = operations.direction(beta);
        report.multiplications += 1;
        restart = false;
        delta_old = delta;

        // α = δ / cᵀq,  x ← x + α c,  r ← r − α q
        if curvature <= 0.0 || curvature.is_nan() {
            let underflow = curvature == 0.0 && operations.direction_is_zero();
            break if underflow { SolveStatus::Stagnated } else { SolveStatus::Indefinite };
        }
        operations.advance(delta / curvature);
        report.iterations += 1;
        fresh = false;
    };
    operations.finish();
    report
}

/// `out ← A x − b`, unfiltered: the impulse of the constraints on each particle. In free directions
/// it is the negative residual of the solve, which is small.
///
/// # Panics
/// When the lengths differ.
pub fn constraint_impulse(
    a: &(impl LinearOperator + ?Sized),
    b: &[Vec3],
    x: &[Vec3],
    out: &mut [Vec3],
) {
    a.multiply(x, out);
    axpy(-1.0, b, out);
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
#[path = "pcg_tests.rs"]
mod tests;
