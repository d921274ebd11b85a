//! The choice of a solver behind `solver=auto` and `preconditioner=auto`.
//!
//! The choice depends on the matrix alone and not on a clock, so that a run can be repeated. It
//! compares the estimated times of a solve for three right-hand sides, in nanoseconds per row. The
//! costs in the table were measured on one core of a Zen 4 processor, on meshes of 400 to 10 000
//! particles:
//!
//! | | start and end | an iteration | iterations |
//! |---|---|---|---|
//! | CG, Jacobi, matrix by diagonals | 2 | 2.8 | `√κ` |
//! | CG, Jacobi, compressed rows | 5 | 6.3 | `√κ` |
//! | CG, IC(0) | 9 | 12.5 | `0.35 √κ` |
//! | kept Cholesky factor | 1 | 0.9 an entry of the factor | 1 |
//!
//! `κ = 2 max aᵢᵢ/mᵢ` bounds the condition of the matrix scaled by its diagonal. The mass `mᵢ` is
//! the sum of row `i`. The next table was measured on hanging sheets, with a start value
//! extrapolated from the last steps and `ε` = 1e-3:
//!
//! | `√κ` | iterations with Jacobi | with IC(0) |
//! |---|---|---|
//! | 3.6 | 3.4 | 1.4 |
//! | 28 | 30 to 40 | 8.4 to 11 |
//!
//! Other tolerances scale the iterations by `ln ε / ln 1e-3`. On a mesh with 5 entries per row, a
//! factor has about `3 log₂ n − 19` entries per row, and at least 9. It has more where the rows of
//! the matrix have more. Measured: 9.2 at `n` = 400, 14.7 at 2704, 20.6 at 10 000, 28 at 100 000.
//!
//! A factor is not chosen in three cases; `solver=cholesky` may still request it:
//!
//! * above 60 000 rows, where the elimination order alone takes half a second;
//! * where the matrix is rebuilt in each step, since making a factor costs 20 solves;
//! * with obstacles, because the factor takes account of pins only.

use crate::{LinearSettings, PreconditionerKind, SolverKind};
use drape_model::System;
use drape_solvers::{ScalarLayout, ScalarMatrix, ScalarPcg};

/// Most rows for which a factor is chosen.
const MOST_ROWS: usize = 60_000;

/// Nanoseconds a row for the start and end of a solve, and for an iteration.
struct Cost {
    start: f64,
    iteration: f64,
}

const DIAGONALS: Cost = Cost { start: 2.0, iteration: 2.8 };
const ROWS: Cost = Cost { start: 5.0, iteration: 6.3 };
const IC0: Cost = Cost { start: 9.0, iteration: 12.5 };
const FACTOR_START: f64 = 1.0;
const FACTOR_ENTRY: f64 = 0.9;
/// Iterations with IC(0) over those with Jacobi.
const IC0_ITERATIONS: f64 = 0.35;

impl Cost {
    fn of(&self, iterations: f64) -> f64 {
        self.start + self.iteration * iterations
    }
}

/// The settings with every `auto` replaced by the choice that should be fastest for `a`.
pub(crate) fn choose(
    settings: LinearSettings,
    system: &System,
    a: &ScalarMatrix,
) -> LinearSettings {
    let is_auto = settings.solver == SolverKind::Auto;
    if !is_auto && settings.preconditioner != PreconditionerKind::Auto {
        return settings;
    }
    let iterations = jacobi_iterations(a) * (settings.forcing_term.ln() / 1e-3_f64.ln()).max(0.1);
    let is_banded = ScalarPcg::new(a, true).layout() == ScalarLayout::Diagonals;
    let jacobi = if is_banded { DIAGONALS } else { ROWS }.of(iterations);
    let ic0 = IC0.of(IC0_ITERATIONS * iterations);
    let (preconditioner, cg) = match settings.preconditioner {
        PreconditionerKind::Auto if jacobi <= ic0 => (PreconditionerKind::Jacobi, jacobi),
        PreconditionerKind::Auto => (PreconditionerKind::Ic0, ic0),
        PreconditionerKind::Ic0 => (PreconditionerKind::Ic0, ic0),
        given => (given, jacobi),
    };
    let may_factorise =
        a.n() <= MOST_ROWS && !settings.rebuild_every_step && system.obstacles().is_empty();
    let solver = match settings.solver {
        SolverKind::Auto if may_factorise && factor_solve(a) < cg => SolverKind::Cholesky,
        SolverKind::Auto => SolverKind::Cg,
        given => given,
    };
    LinearSettings { preconditioner, solver, ..settings }
}

/// `√κ`.
fn jacobi_iterations(a: &ScalarMatrix) -> f64 {
    let over_mass = |i: usize| {
        let sum: f64 = a.row(i).1.iter().sum();
        a.diagonal(i) / sum.max(f64::MIN_POSITIVE)
    };
    (2.0 * (0..a.n()).map(over_mass).fold(0.0, f64::max)).sqrt()
}

/// Nanoseconds a row for a solve with a factor.
fn factor_solve(a: &ScalarMatrix) -> f64 {
    let n = a.n().max(2) as f64;
    let entries = (3.0 * n.log2() - 19.0).max(9.0) * (a.nonzeros() as f64 / (5.0 * n)).max(1.0);
    FACTOR_START + FACTOR_ENTRY * entries
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::StopNorm;
    use drape_kernels::testing::mesh_edges;

    /// A sheet of `side` × `side` particles of mass 1 kg whose springs weigh `weight` in the
    /// matrix.
    fn sheet(side: usize, weight: f64, stride: usize) -> ScalarMatrix {
        let n = side * side;
        // A stride coprime to n shuffles the particles.
        let mut edges = mesh_edges(side, side, &[(0, 1), (1, 0)]);
        for (i, j) in &mut edges {
            (*i, *j) = (*i * stride % n, *j * stride % n);
        }
        let mut a = ScalarMatrix::with_pattern(n, edges.iter().copied());
        (0..n).for_each(|i| a.add_diagonal(i, 1.0));
        edges.iter().for_each(|&(i, j)| a.add_edge(i, j, weight));
        a
    }

    fn system(obstacle: bool) -> System {
        let text = if obstacle { "square-table-1e4" } else { "hanging-textile-1e4" };
        drape_model::load(text).unwrap().spec().build().unwrap().0
    }

    const AUTO: LinearSettings = LinearSettings {
        forcing_term: 1e-3,
        preconditioner: PreconditionerKind::Auto,
        norm: StopNorm::Velocity,
        solver: SolverKind::Auto,
        rebuild_every_step: false,
    };

    fn chosen(settings: LinearSettings, a: &ScalarMatrix) -> (SolverKind, PreconditionerKind) {
        let LinearSettings { solver, preconditioner, .. } = choose(settings, &system(false), a);
        (solver, preconditioner)
    }

    #[test]
    fn small_or_stiff_sheets_are_factorised_large_soft_ones_iterated() {
        let solver = |side, weight| chosen(AUTO, &sheet(side, weight, 1)).0;
        assert_eq!(solver(20, 1.4), SolverKind::Cholesky);
        assert_eq!(solver(52, 100.4), SolverKind::Cholesky);
        assert_eq!(solver(100, 100.4), SolverKind::Cholesky);
        assert_eq!(solver(200, 1.4), SolverKind::Cg);
        assert_eq!(solver(250, 100.4), SolverKind::Cg, "too large to order");
        assert_eq!(solver(52, 1e-3), SolverKind::Cg, "hardly coupled");
    }

    #[test]
    fn a_factor_is_not_chosen_where_it_cannot_be_kept() {
        let stiff = sheet(52, 100.4, 1);
        let rebuilt = LinearSettings { rebuild_every_step: true, ..AUTO };
        assert_eq!(chosen(rebuilt, &stiff).0, SolverKind::Cg);
        assert_eq!(choose(AUTO, &system(true), &stiff).solver, SolverKind::Cg);
        let loose = LinearSettings { forcing_term: 0.3, ..AUTO };
        assert_eq!(chosen(loose, &sheet(100, 1.4, 1)).0, SolverKind::Cg);
    }

    #[test]
    fn jacobi_serves_regular_sheets_and_ic0_stiff_general_meshes() {
        let cg = LinearSettings { solver: SolverKind::Cg, ..AUTO };
        let preconditioner = |a: &ScalarMatrix| chosen(cg, a).1;
        assert_eq!(preconditioner(&sheet(52, 1.4, 1)), PreconditionerKind::Jacobi);
        assert_eq!(preconditioner(&sheet(52, 100.4, 1)), PreconditionerKind::Jacobi);
        assert_eq!(preconditioner(&sheet(52, 0.1, 1663)), PreconditionerKind::Jacobi);
        assert_eq!(preconditioner(&sheet(52, 100.4, 1663)), PreconditionerKind::Ic0);
    }

    #[test]
    fn what_is_given_stays() {
        let a = sheet(20, 1.4, 1);
        let given = LinearSettings {
            solver: SolverKind::Cg,
            preconditioner: PreconditionerKind::None,
            ..AUTO
        };
        assert_eq!(choose(given, &system(false), &a), given);
    }
}
