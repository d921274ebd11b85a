//! What can go wrong in a run.

use crate::methods::MethodError;
use drape_integrator::{InvalidTimeStep, PrepareError, StepError};
use drape_model::{SceneError, Violation, nearest};
use drape_oracle::adaptive::AdaptiveError;
use drape_report::RecordError;
use std::path::PathBuf;

/// Why a run or an experiment ended without a result.
#[derive(Debug, thiserror::Error)]
pub enum HarnessError {
    /// The scene was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A value of a scene or of the time span was refused.
    #[error(transparent)]
    Violation(#[from] Violation),
    /// The method or a setting was refused.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The method refused the system.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// The method refused the system that a scene describes.
    #[error("{file}: {}{refusal}", origin(refusal))]
    Refused {
        /// The scene as it was asked for.
        file: String,
        /// Key and reason.
        refusal: PrepareError,
    },
    /// A step could not be taken because of what the scene describes.
    #[error("{file}: with the step (`time.step_s` or --dt): {error}")]
    Stopped {
        /// The scene as it was asked for.
        file: String,
        /// The reason.
        error: StepError,
    },
    /// The time step was refused.
    #[error(transparent)]
    TimeStep(#[from] InvalidTimeStep),
    /// A contract of the integrator was broken.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The scene has no exact solution to compare with.
    #[error(transparent)]
    Reference(#[from] AdaptiveError),
    /// A record could not be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Another process writes results into the folder.
    #[error(
        "{}: another process is writing results there; wait for it or choose another folder with \
         --out",
        folder.display()
    )]
    Busy {
        /// The folder.
        folder: PathBuf,
    },
    /// Missing cells belong to other shards, so this process may not compute them.
    #[error("the missing cells belong to other shards; join the shards with `drape merge`")]
    Elsewhere,
    /// The time of a study that may stop ended within a run.
    #[error("the time limit of --minutes is over")]
    Late,
    /// A folder that is to be merged holds no fitting part.
    #[error("{}: {found}; expected {expected}", path.display())]
    Part {
        /// The folder, or the journal in it.
        path: PathBuf,
        /// What is wrong with it.
        found: String,
        /// What is allowed.
        expected: String,
    },
    /// The operating system refused to start a thread.
    #[error(
        "the system refuses a thread for each processor ({0}); set the variable \
         RAYON_NUM_THREADS to a smaller number"
    )]
    Threads(#[source] rayon::ThreadPoolBuildError),
    /// No such experiment.
    #[error("no experiment `{name}`{}; expected one of: {known}", nearest(name, known.split(", ")))]
    UnknownExperiment {
        /// The name that was asked for.
        name: String,
        /// The known names.
        known: String,
    },
    /// A study has no start of that name.
    #[error(
        "the study {study} has no scene `{name}`{}; expected one of: {known}",
        nearest(name, known.split("; "))
    )]
    UnknownStart {
        /// The study.
        study: &'static str,
        /// What was asked for.
        name: String,
        /// The known ones.
        known: String,
    },
    /// The timings of a study cannot be taken without its facts.
    #[error(
        "the study {study} has no timings that can be taken without its runs; expected one of: \
         {known}"
    )]
    NoOwnTimings {
        /// The study.
        study: &'static str,
        /// The studies with such timings.
        known: String,
    },
    /// A record has a scene that this program does not have, or that differs from its own.
    #[error(
        "{}: the scene `{scene}` of the record {found}; expected the scene of this program, so \
         compute the record anew",
        record.display()
    )]
    OtherScene {
        /// The record.
        record: PathBuf,
        /// The scene.
        scene: String,
        /// How it differs.
        found: String,
    },
    /// A record has a form of a method that this program does not have.
    #[error(
        "{}: this program has no form `{label}`; expected the forms of this program, so compute the \
         record anew",
        record.display()
    )]
    OtherForm {
        /// The record.
        record: PathBuf,
        /// The label of the form.
        label: String,
    },
    /// No such claim.
    #[error("no claim `{id}`; expected one of: {known}")]
    UnknownClaim {
        /// What was asked for.
        id: String,
        /// The known ones.
        known: String,
    },
}

impl HarnessError {
    /// The same error. Where the method refused the system, it names the scene's file.
    #[must_use]
    pub fn in_scene(self, file: &str) -> Self {
        match self {
            Self::Prepare(refusal) => Self::Refused { file: file.to_owned(), refusal },
            Self::Step(error @ StepError::TooManySubsteps { .. }) => {
                Self::Stopped { file: file.to_owned(), error }
            }
            other => other,
        }
    }
}

/// The origin of a matrix of the system, for messages about that matrix.
const MATRIX: &str = "with its masses and stiffnesses and the step (`time.step_s` or --dt) ";

fn origin(refusal: &PrepareError) -> &'static str {
    if matches!(refusal, PrepareError::Solver(_)) { MATRIX } else { "" }
}
