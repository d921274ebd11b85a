//! Settings of the methods with one linear solve per step.

use crate::{Declared, LinearSettings, PreconditionerKind, SolverKind, StopNorm, Word, declare};
use drape_solvers::Norm;

impl Word for PreconditionerKind {
    const WORDS: &'static [(&'static str, Self)] =
        &[("none", Self::None), ("jacobi", Self::Jacobi), ("ic0", Self::Ic0), ("auto", Self::Auto)];
}

impl Word for Norm {
    const WORDS: &'static [(&'static str, Self)] =
        &[("euclid", Self::Euclid), ("preconditioned", Self::Preconditioned)];
}

impl Word for StopNorm {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("velocity", Self::Velocity),
        ("euclid", Self::Euclid),
        ("preconditioned", Self::Preconditioned),
    ];
}

/// The dense inverse has no word, since it needs a limit.
impl Word for SolverKind {
    const WORDS: &'static [(&'static str, Self)] =
        &[("cg", Self::Cg), ("cholesky", Self::Cholesky), ("auto", Self::Auto)];
}

/// How long a matrix is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixUse {
    /// Until the system or the step size changes.
    Kept,
    /// For one step, as varying moduli would require.
    Rebuilt,
}

impl Word for MatrixUse {
    const WORDS: &'static [(&'static str, Self)] =
        &[("kept", Self::Kept), ("rebuilt", Self::Rebuilt)];
}

/// The setting `preconditioner`.
pub const PRECONDITIONER: Declared<PreconditionerKind> = declare!(
    preconditioner: PreconditionerKind [None, Jacobi, Ic0, Auto] = Ic0,
    "preconditioner of the conjugate gradients; auto: the faster of jacobi and ic0, by estimates \
     from the matrix"
);
/// The setting `norm`: the stop test.
pub const NORM: Declared<StopNorm> = declare!(
    norm: StopNorm [Velocity, Euclid, Preconditioned] = Velocity,
    "what the residual is measured against: velocity: the change of velocity that the forces make, \
     in any frame and with any masses; euclid: the right-hand side, as EEH print it, so that a \
     fast sheet or one with a heavy particle is solved loosely; preconditioned: as velocity, in \
     the norm of the preconditioner (updated CG, robust: always that of the inverse mass)"
);
/// The setting `solver`.
pub const SOLVER: Declared<SolverKind> = declare!(
    solver: SolverKind [Cg, Cholesky, Auto] = Cg,
    "conjugate gradients, or a direct solve by sparse Cholesky, which ignores preconditioner, norm \
     and linear tolerance (with contacts: CG to 1e-13, preconditioned by the factor); auto: the \
     faster of the two, by estimates from the matrix"
);
/// The setting `matrix`: whether the matrix is kept.
pub const MATRIX: Declared<MatrixUse> = declare!(
    matrix: MatrixUse [Kept, Rebuilt] = Kept,
    "set the matrix up only when it changes, or in each step, as varying moduli would need"
);

impl LinearSettings {
    /// Settings of a solve with a kept matrix and a stop test relative to the right-hand side.
    pub fn kept(forcing_term: f64, preconditioner: PreconditionerKind, solver: SolverKind) -> Self {
        Self::of(forcing_term, preconditioner, StopNorm::Euclid, solver, MatrixUse::Kept)
    }

    /// Settings of a solve from the values of the settings above.
    pub fn of(
        forcing_term: f64,
        preconditioner: PreconditionerKind,
        norm: StopNorm,
        solver: SolverKind,
        matrix: MatrixUse,
    ) -> Self {
        let rebuild_every_step = matrix == MatrixUse::Rebuilt;
        Self { forcing_term, preconditioner, norm, solver, rebuild_every_step }
    }
}
