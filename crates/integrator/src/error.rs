//! Errors of an integrator.

use drape_solvers::SolverError;

/// Why a system cannot be prepared for a method.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// The method does not support an effect or a constraint that the scene names.
    #[error("`{key}`: {method} does not support {what}; leave it out or choose another method")]
    Unsupported {
        /// Method id.
        method: &'static str,
        /// The unsupported effect or constraint.
        what: String,
        /// Path of the key in the scene that names it.
        key: String,
    },
    /// An operator would need more memory than the limit. Nothing was allocated for it.
    #[error(
        "the dense inverse and its work space would take {bytes} bytes, the limit is {limit}; set \
         `memory_limit_mib` to {} or more, take fewer particles or `inverse=cholesky`",
        .bytes.div_ceil(1 << 20)
    )]
    TooLarge {
        /// Memory that the operator would take, bytes.
        bytes: u64,
        /// Memory that the operator may take, bytes.
        limit: u64,
    },
    /// An external program that takes the steps failed, such as a program of the user.
    #[error("{0}")]
    Outside(String),
    /// An operator could not be built.
    #[error("the system matrix cannot be set up: {0}")]
    Solver(#[source] SolverError),
}

impl From<SolverError> for PrepareError {
    fn from(error: SolverError) -> Self {
        match error {
            SolverError::TooLarge { bytes, limit } => Self::TooLarge { bytes, limit },
            other => Self::Solver(other),
        }
    }
}

/// Why a step was not taken. The state is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum StepError {
    /// The system was never prepared, or its sparsity pattern has changed since it was.
    #[error("the system is new or its topology changed: call `prepare` first")]
    NeedsPrepare,
    /// The state has another number of particles than the system.
    #[error("the state has {found} particles, the system {expected}")]
    SizeMismatch {
        /// Particles of the system.
        expected: usize,
        /// Particles of the state.
        found: usize,
    },
    /// The step would need more substeps than a step may have.
    #[error(
        "the step needs {needed} substeps, and at most {most} are taken; shorten the step, lower \
         the stiffness or take an implicit method"
    )]
    TooManySubsteps {
        /// Number of substeps that the stability limit requires.
        needed: u32,
        /// Largest number of substeps of a step.
        most: u32,
    },
    /// An external program that takes the steps failed, such as a program of the user.
    #[error("{0}")]
    Outside(String),
    /// An operator could not be rebuilt after a change.
    #[error("the system matrix cannot be rebuilt: {0}")]
    Solver(#[from] SolverError),
}
