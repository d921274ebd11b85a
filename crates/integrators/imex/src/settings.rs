//! Description and settings of the two methods of order 1.

use drape_integrator::linear_settings::{MATRIX, MatrixUse, NORM, PRECONDITIONER, SOLVER};
use drape_integrator::{
    Declared, Declares, ForcingKind, Implicit, LinearSettings, Method, Order, PreconditionerKind,
    Quantity, SolverKind, Split, StabilityClass, Start, StopNorm, Supports, TOLERANCE, Word,
    declare, settings,
};

/// How step size control estimates the error of a method that splits the force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// From positions alone.
    Plain,
    /// With the error of the part of the force at the old level.
    Splitting,
}

impl Word for Estimator {
    const WORDS: &'static [(&'static str, Self)] =
        &[("plain", Self::Plain), ("splitting", Self::Splitting)];
}

pub(crate) const IMPLICIT_SPRINGS: Declared<Implicit> = declare!(
    implicit: Implicit [Tension, Springs] = Springs,
    "which springs stand in the matrix; the others stay at the old level"
);

pub(crate) const START: Declared<Start> = declare!(
    start: Start [Last, Extrapolated] = Extrapolated,
    "start value of the solve: v_n or 2 v_n - v_{n-1} (EEH 22)"
);

pub(crate) const ESTIMATOR: Declared<Estimator> = declare!(
    estimator: Estimator [Plain, Splitting] = Splitting,
    "error estimate of step size control: from positions alone, which cannot see locking, or with \
     the error of the force at the old level"
);

const IMPLICIT_BENEFIT: &str = "solved exactly with all springs implicit \
     and full damping it never gains energy; it slows motion as friction of the rate h k/m would: a \
     hanging sheet of 400 particles locks from some 500/s on";

/// IMEX Euler.
pub static IMEX_EULER: Method = Method {
    id: "imex-euler",
    name: "IMEX Euler",
    source: "EEH (19)-(21)",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: IMPLICIT_BENEFIT,
    supports: Supports::ScalarMatrix,
    refuses: &[],
    settings: ImexEulerSettings::SETTINGS,
};

/// IMEX Euler with updated right-hand side.
pub static IMEX_UPDATED: Method = Method {
    id: "imex-updated",
    name: "IMEX Euler with updated CG",
    source: "EEH Algorithm 1",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "its fixed point is backward Euler; the robust form lowers the incremental potential \
             at every iteration; the paper's form may gain energy with a loose ε and the \
             extrapolated start",
    supports: Supports::ScalarMatrix,
    refuses: &[],
    settings: ImexUpdatedSettings::SETTINGS,
};

settings! {
    /// Settings of IMEX Euler.
    pub struct ImexEulerSettings for IMEX_EULER {
        /// relative tolerance ε of the solve
        forcing_term: f64 in 1e-16..=0.5 = 1e-3,
        /// preconditioner of the conjugate gradients
        preconditioner: PreconditionerKind as PRECONDITIONER,
        /// start value of the solve
        start: Start as START,
        /// what the residual of the solve is measured against
        norm: StopNorm as NORM,
        /// solver
        solver: SolverKind as SOLVER,
        /// which springs stand in the matrix; the others stay at the old level
        implicit: Implicit [Tension, Springs] = Tension,
        /// how long the matrix is kept
        matrix: MatrixUse as MATRIX,
        /// stiffness in the matrix of springs of several slopes
        split: Split as Split::SETTING,
        /// local error that a step may make, in mesh widths; 0: the method takes steps as given
        tolerance: f64 as TOLERANCE,
        /// how that error is estimated
        estimator: Estimator as ESTIMATOR,
    }
}

/// Which form of Algorithm 1 runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Safeguard {
    /// As printed.
    Paper,
    /// With energy safeguards.
    Robust,
}

impl Word for Safeguard {
    const WORDS: &'static [(&'static str, Self)] =
        &[("paper", Self::Paper), ("robust", Self::Robust)];
}

settings! {
    /// Settings of updated CG.
    pub struct ImexUpdatedSettings for IMEX_UPDATED {
        /// relative tolerance ε of the solve
        forcing_term: f64 in 1e-16..=0.5 = 1e-2,
        /// preconditioner of the conjugate gradients
        preconditioner: PreconditionerKind as PRECONDITIONER,
        /// start value of the solve; best: the one with the lower potential (safeguard=paper takes
        /// it as extrapolated)
        start: Start [Last, Extrapolated, Best] = Best,
        /// Algorithm 1 as printed, or with energy safeguards
        safeguard: Safeguard [Paper, Robust] = Robust,
        /// what the residual of the solve is measured against
        norm: StopNorm as NORM,
        /// solver
        solver: SolverKind as SOLVER,
        /// which springs are implicit
        implicit: Implicit as IMPLICIT_SPRINGS,
        /// how long the matrix is kept
        matrix: MatrixUse as MATRIX,
        /// stiffness in the matrix of springs of several slopes
        split: Split as Split::SETTING,
        /// most updates of the right-hand side in a step; the robust form continues with Newton
        max_outer: u32 in 1..=1_000_000 = 200,
        /// the robust form uses Newton at once where h²k/m is larger than this
        newton_above: f64 in 0.0..=1e300 = 100,
        /// how tightly CG solves between two updates of the right-hand side: to the tolerance of
        /// the step, or by the progress of the updates (Eisenstat and Walker, choice 2)
        forcing: ForcingKind [Constant, EisenstatWalker] = Constant,
        /// local error that a step may make, in mesh widths; 0: the method takes steps as given
        tolerance: f64 as TOLERANCE,
    }
}

impl ImexEulerSettings {
    /// The linear solve.
    pub fn linear(&self) -> LinearSettings {
        let Self { forcing_term, preconditioner, norm, solver, matrix, .. } = *self;
        LinearSettings::of(forcing_term, preconditioner, norm, solver, matrix)
    }
}

impl ImexUpdatedSettings {
    /// The linear solves.
    pub fn linear(&self) -> LinearSettings {
        let Self { forcing_term, preconditioner, norm, solver, matrix, .. } = *self;
        LinearSettings::of(forcing_term, preconditioner, norm, solver, matrix)
    }
}
