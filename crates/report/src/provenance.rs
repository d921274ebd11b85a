//! The origin of a record.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What must be known to repeat a record: source, build, machine, input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of the `drape` package.
    pub version: String,
    /// Commit of the sources from which the program was built; `None` if they were not in a
    /// repository.
    pub commit: Option<String>,
    /// Whether the sources differed from that commit: the crates, `Cargo.toml` and `Cargo.lock`.
    pub dirty: Option<bool>,
    /// SHA-256 of `Cargo.lock`.
    pub cargo_lock_sha256: String,
    /// What `rustc -Vv` printed at build time.
    pub rustc: String,
    /// Profile, optimisation level, target and flags of the build.
    pub build: String,
    /// Processor model.
    pub cpu: String,
    /// Number of threads that computed facts.
    pub threads: usize,
    /// SHA-256 of each scene, by name.
    pub scene_sha256: BTreeMap<String, String>,
    /// Seed of the random numbers; `None` if none were drawn.
    pub seed: Option<u64>,
    /// Date and time of the run, UTC, ISO 8601.
    pub date: String,
}
