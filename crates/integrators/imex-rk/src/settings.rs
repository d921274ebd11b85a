//! Description and settings of the method.

use crate::tableau::Pair;
use drape_integrator::linear_settings::{MATRIX, MatrixUse, NORM};
use drape_integrator::{
    Declares, Implicit, LinearSettings, Method, Order, PreconditionerKind, Quantity, SolverKind,
    StabilityClass, StopNorm, Supports, settings,
};

/// Additive Runge–Kutta methods.
pub static IMEX_RK: Method = Method {
    id: "imex-rk",
    name: "IMEX Runge-Kutta",
    source: "Ascher, Ruuth and Spiteri 1997; Kennedy and Carpenter 2003; split of EEH section 4",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "the implicit part is L-stable, but nothing bounds the energy of the split: explicit \
             springs beside stiff implicit ones, or compressed springs, may make it grow; a stiff \
             sheet locks in its displacement, with ark3 and ark4 while its velocity goes on",
    supports: Supports::ScalarMatrix,
    refuses: &["contact", "friction", "moving pins", "moving obstacles"],
    settings: ImexRkSettings::SETTINGS,
};

settings! {
    /// Settings of the additive Runge–Kutta methods.
    pub struct ImexRkSettings for IMEX_RK {
        /// coefficients: two and four implicit stages of order 2 and 3 (Ascher, Ruuth, Spiteri), or
        /// three and five of order 3 and 4 (Kennedy, Carpenter)
        tableau: Pair [Ars222, Ars443, Ark3, Ark4] = Ars222,
        /// a direct solve by sparse Cholesky, which keeps every order, or conjugate gradients;
        /// auto: the faster of the two, by estimates from the matrix
        solver: SolverKind [Cg, Cholesky, Auto] = Cholesky,
        /// relative tolerance ε of the conjugate gradients
        forcing_term: f64 in 1e-16..=0.5 = 1e-9,
        /// preconditioner of the conjugate gradients
        preconditioner: PreconditionerKind [None, Jacobi, Ic0, Auto] = Ic0,
        /// what the residual of the solve is measured against
        norm: StopNorm as NORM,
        /// which springs stand in the matrix; the others stay explicit
        implicit: Implicit [Tension, Springs] = Springs,
        /// how long the matrix is kept
        matrix: MatrixUse as MATRIX,
    }
}

impl ImexRkSettings {
    /// The linear solve.
    pub fn linear(&self) -> LinearSettings {
        let Self { forcing_term, preconditioner, norm, solver, matrix, .. } = *self;
        LinearSettings::of(forcing_term, preconditioner, norm, solver, matrix)
    }
}
