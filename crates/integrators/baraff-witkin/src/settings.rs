//! Description and settings of the method.

use drape_integrator::{
    Declares, Implicit, Method, Order, Quantity, StabilityClass, Supports, Word, settings,
};
use drape_model::Tangent;
use drape_solvers::Norm;

/// Baraff and Witkin's implicit step.
pub static BARAFF_WITKIN: Method = Method {
    id: "baraff-witkin",
    name: "linearised implicit Euler",
    source: "Baraff & Witkin 1998 (6), (15)-(18)",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "backward Euler where forces are linear; elsewhere one linear solve a step without an \
             energy theorem: it may gain energy at large h²k/m",
    supports: Supports::Blocks,
    refuses: &[],
    settings: BaraffWitkinSettings::SETTINGS,
};

/// The preconditioner of CG.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preconditioning {
    /// None.
    None,
    /// The inverses of the 3×3 diagonal blocks.
    BlockJacobi,
}

/// The linear solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockSolver {
    /// Filtered conjugate gradients.
    Cg,
    /// A sparse factorisation: Cholesky, or `L D Lᵀ` of the raw matrix.
    Direct,
}

/// How a particle inside an obstacle is led out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recovery {
    /// By its velocity, at limited speed (EEH section 6).
    Velocity,
    /// By the position alteration `y`, at once (Baraff & Witkin section 6).
    Position,
}

/// Where the conjugate gradients start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstChange {
    /// At no change of velocity.
    Zero,
    /// At the `Δv` of the last step.
    Last,
}

/// Form of `∂f/∂x` in the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hessian {
    /// Without the negative stiffness across compressed springs.
    Clamped,
    /// Unchanged.
    Raw,
}

impl Word for Preconditioning {
    const WORDS: &'static [(&'static str, Self)] =
        &[("none", Self::None), ("block-jacobi", Self::BlockJacobi)];
}

impl Word for BlockSolver {
    const WORDS: &'static [(&'static str, Self)] = &[("cg", Self::Cg), ("cholesky", Self::Direct)];
}

impl Word for FirstChange {
    const WORDS: &'static [(&'static str, Self)] = &[("zero", Self::Zero), ("last", Self::Last)];
}

impl Word for Hessian {
    const WORDS: &'static [(&'static str, Self)] =
        &[("clamped", Self::Clamped), ("raw", Self::Raw)];
}

impl Word for Recovery {
    const WORDS: &'static [(&'static str, Self)] =
        &[("velocity", Self::Velocity), ("position", Self::Position)];
}

settings! {
    /// Settings of Baraff and Witkin's step.
    pub struct BaraffWitkinSettings for BARAFF_WITKIN {
        /// relative tolerance of the conjugate gradients
        forcing_term: f64 in 1e-16..=0.5 = 1e-3,
        /// preconditioner of the conjugate gradients
        preconditioner: Preconditioning [None, BlockJacobi] = BlockJacobi,
        /// norm of the residual in the stop test
        norm: Norm [Euclid, Preconditioned] = Preconditioned,
        /// conjugate gradients, or a sparse factorisation in each step (LDLᵀ with hessian=raw)
        solver: BlockSolver [Cg, Direct] = Cg,
        /// start of the conjugate gradients: at no change of velocity, or at the change of the last
        /// step
        start: FirstChange [Zero, Last] = Zero,
        /// ∂f/∂x without the negative stiffness across compressed springs, or unchanged: then the
        /// matrix may be indefinite, and conjugate gradients stop early
        hessian: Hessian [Clamped, Raw] = Clamped,
        /// which forces are linearised; the others stay at the old level
        implicit: Implicit [Everything, Tension] = Everything,
        /// how particles leave an obstacle: led out by their velocity, or put on its surface at
        /// once by the position alteration y
        contact: Recovery [Velocity, Position] = Velocity,
    }
}

impl BaraffWitkinSettings {
    /// The derivative of the forces in the matrix.
    pub fn tangent(&self) -> Tangent {
        match self.hessian {
            Hessian::Clamped => Tangent::Projected,
            Hessian::Raw => Tangent::Exact,
        }
    }
}
