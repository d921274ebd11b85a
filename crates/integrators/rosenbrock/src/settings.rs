//! Description and settings of the method.

use crate::tableau::Scheme;
use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, Supports, Word, settings,
};
use drape_model::Tangent;
use drape_solvers::FactorKind;

/// Rosenbrock methods.
pub static ROSENBROCK: Method = Method {
    id: "rosenbrock",
    name: "Rosenbrock",
    source: "Rosenbrock 1963; Hairer and Wanner IV.7; Verwer et al. 1999",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "L-stable where forces are linear (ros3p: A-stable); a spring that turns within a step \
             stretches by the square of the angle times k, so that undamped stiff cloth gains \
             energy",
    supports: Supports::Blocks,
    refuses: &["contact", "friction", "moving pins", "moving obstacles"],
    settings: RosenbrockSettings::SETTINGS,
};

/// Form of the Jacobian in the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JacobianForm {
    /// The exact one, indefinite where springs are compressed.
    Exact,
    /// Without the negative stiffness across compressed springs.
    Clamped,
}

impl Word for JacobianForm {
    const WORDS: &'static [(&'static str, Self)] =
        &[("exact", Self::Exact), ("clamped", Self::Clamped)];
}

impl JacobianForm {
    /// The derivative of the forces in the matrix.
    pub fn tangent(self) -> Tangent {
        match self {
            Self::Exact => Tangent::Exact,
            Self::Clamped => Tangent::Projected,
        }
    }

    /// The factorisation that the matrix has.
    pub fn factor_kind(self) -> FactorKind {
        match self {
            Self::Exact => FactorKind::Ldlt,
            Self::Clamped => FactorKind::Cholesky,
        }
    }
}

settings! {
    /// Settings of the Rosenbrock methods.
    pub struct RosenbrockSettings for ROSENBROCK {
        /// coefficients: ros2 and ros34pw2 (orders 2, 3) keep their order with an inexact Jacobian;
        /// ros3p, rodas3 and rodas4 (3, 3, 4) need the exact one
        tableau: Scheme [Ros2, Ros3p, Rodas3, Ros34pw2, Rodas4] = Ros2,
        /// the exact Jacobian, factorised as LDLᵀ, or without the negative stiffness across
        /// compressed springs, factorised by Cholesky
        jacobian: JacobianForm [Exact, Clamped] = Exact,
    }
}
