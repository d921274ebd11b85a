//! Direct solvers: they factor a matrix once and solve with it any number of times.
//!
//! | matrix | positive definite | may be indefinite |
//! |---|---|---|
//! | [`ScalarMatrix`](crate::ScalarMatrix) | [`CompleteCholesky`](crate::CompleteCholesky), [`DenseInverse`](crate::DenseInverse) | [`CompleteLdlt`] |
//! | [`BlockMatrix`](crate::BlockMatrix) | [`BlockFactor`] of both kinds | [`BlockFactor`], [`FactorKind::Ldlt`] |
//!
//! [`BlockLu`] solves with [`UnsymmetricBlocks`], which are not symmetric.

mod block;
mod lu;
mod scalar;

pub use crate::sparse_factor::FactorKind;
pub use block::BlockFactor;
pub use lu::{BlockLu, UnsymmetricBlocks};
pub use scalar::CompleteLdlt;
