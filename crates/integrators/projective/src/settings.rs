//! Description and settings of the method.

use drape_integrator::{
    Declared, Declares, LinearSettings, Method, Order, PreconditionerKind, Quantity, SolverKind,
    StabilityClass, Supports, Word, declare, settings,
};

/// Projective dynamics.
pub static PROJECTIVE: Method = Method {
    id: "projective",
    name: "projective dynamics",
    source: "Liu, Bargteil, O'Brien, Kavan 2013; Bouaziz et al. 2014",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "each plain iteration lowers the incremental potential of backward Euler, for every \
             step and stiffness; a fixed number of them may stop far above its minimum: then a \
             stiff sheet stands still",
    supports: Supports::ScalarMatrix,
    refuses: &[],
    settings: ProjectiveSettings::SETTINGS,
};

/// How an iterate follows from the last ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acceleration {
    /// Local step and global step in turn.
    None,
    /// Chebyshev's semi-iterative method on top of it.
    Chebyshev,
    /// Anderson's acceleration.
    Anderson,
    /// A quasi-Newton method with limited memory.
    Lbfgs,
    /// The alternating direction method of multipliers.
    Admm,
}

impl Word for Acceleration {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("none", Self::None),
        ("chebyshev", Self::Chebyshev),
        ("anderson", Self::Anderson),
        ("lbfgs", Self::Lbfgs),
        ("admm", Self::Admm),
    ];
}

const RESIDUAL: Declared<f64> = declare!(
    residual: f64 off or in 1e-16..=0.5 = 0,
    "residual at which the iteration stops, relative to the change of velocity that the forces \
     would make; 0: the number of iterations is fixed, and only round-off stops earlier"
);

const SOLVER: Declared<SolverKind> = declare!(
    solver: SolverKind [Cg, Cholesky] = Cholesky,
    "global step by the kept sparse Cholesky factor (with contacts: CG to 1e-13, preconditioned \
     by the factor), or by conjugate gradients"
);

settings! {
    /// Settings of projective dynamics.
    pub struct ProjectiveSettings for PROJECTIVE {
        /// how an iterate follows from the last ones
        acceleration: Acceleration [None, Chebyshev, Anderson, Lbfgs, Admm] = None,
        /// most iterations in a step, each with one global step
        iterations: u32 in 1..=1000 = 10,
        /// earlier iterates that anderson and lbfgs remember within a step
        memory: usize in 1..=20 = 5,
        /// chebyshev: estimate of the factor by which a plain iteration shrinks the error
        rho: f64 in 0.0..=0.99999 = 0.95,
        /// residual at which the iteration stops
        residual: f64 as RESIDUAL,
        /// how the global step is solved
        solver: SolverKind as SOLVER,
        /// relative tolerance of the conjugate gradients of solver=cg
        forcing_term: f64 in 1e-16..=0.5 = 1e-6,
    }
}

impl ProjectiveSettings {
    /// The linear solve of the global step.
    pub fn linear(&self) -> LinearSettings {
        LinearSettings::kept(self.forcing_term, PreconditionerKind::Ic0, self.solver)
    }
}
