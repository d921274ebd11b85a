//! Errors of an integrator.

use drape_solvers::SolverError;

/// Why a system cannot be prepared for a method.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// The method does not support something that the scene names.
    #[error("`{key}`: {method} does not support {what}; leave it out or choose another method")]
    Unsupported {
        /// Method id.
        method: &'static str,
        /// The effect or constraint.
        what: String,
        /// Path of the key that names it in a scene.
        key: String,
    },
    /// An operator would need more memory than the limit; nothing was allocated for it.
    #[error(
        "the dense inverse and its work space would take {bytes} bytes, the limit is {limit}; set \
         `memory_limit_mib` to {} or more, take fewer particles or `inverse=cholesky`",
        .bytes.div_ceil(1 << 20)
    )]
    TooLarge {
        /// Memory that it would take.
        bytes: u64,
        /// Memory that it may take.
        limit: u64,
    },
    /// Something outside this process that takes the steps failed, such as a program of the user.
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

/// Why a step was not taken. The state is as it was.
#[derive(Debug, thiserror::Error)]
pub enum StepError {
    /// The system was never prepared, or its sparsity pattern changed since.
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
    /// The step would be divided into more substeps than a run can take.
    #[error(
        "the step needs {needed} substeps, and at most {most} are taken; shorten the step, lower \
         the stiffness or take an implicit method"
    )]
    TooManySubsteps {
        /// Substeps within the stability limit.
        needed: u32,
        /// Substeps that a step may have.
        most: u32,
    },
    /// Something outside this process that takes the steps failed, such as a program of the user.
    #[error("{0}")]
    Outside(String),
    /// An operator could not be rebuilt after a change.
    #[error("the system matrix cannot be rebuilt: {0}")]
    Solver(#[from] SolverError),
}
