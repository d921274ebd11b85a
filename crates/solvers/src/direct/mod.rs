//! Direct solvers: a matrix is factored once and solved with as often as wanted.
//!
//! | matrix | positive definite | may be indefinite |
//! |---|---|---|
//! | [`ScalarMatrix`](crate::ScalarMatrix) | [`CompleteCholesky`](crate::CompleteCholesky), [`DenseInverse`](crate::DenseInverse) | [`CompleteLdlt`] |
//! | [`BlockMatrix`](crate::BlockMatrix) | [`BlockCholesky`] | [`BlockLdlt`] |

mod block;
mod scalar;

pub use block::{BlockCholesky, BlockLdlt};
pub use scalar::CompleteLdlt;
