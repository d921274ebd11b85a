//! Record of the comparison with programs outside drape, in paired runs.

use serde::{Deserialize, Serialize};

/// The sheet, the method and the number of steps that two programs were given alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Case {
    /// `imex-euler` or `baraff-witkin`.
    pub(crate) method: String,
    /// Particles along each edge.
    pub(crate) side: u32,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Number of steps from the start.
    pub(crate) steps: u32,
}

/// One line of the record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Row {
    /// The conditions of all runs.
    Setup(Setup),
    /// All runs of one program with one solver on one case.
    Runs(Runs),
    /// A solver of drape beside one of a peer.
    Pair(Pair),
}

/// The conditions of all runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Setup {
    /// The core that every program was pinned to; absent where the machine cannot pin.
    pub(crate) core: Option<u32>,
    /// SHA-256 of the executable of each peer, by name; empty where no peer was measured.
    pub peers_sha256: std::collections::BTreeMap<String, String>,
    /// Versions and compiler flags of the peers, as their builder noted them.
    pub(crate) about: Option<String>,
}

/// All runs of one program with one solver on one case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Runs {
    /// What was run.
    pub(crate) case: Case,
    /// `drape`, or the name of the peer.
    pub(crate) program: String,
    /// Method id with its settings, or the peer's name of its solver.
    pub(crate) solver: String,
    /// `grid`, or `general`: the same cloth with particles and springs in random order.
    pub(crate) mesh: String,
    /// Median time of a step, µs; one entry a run.
    pub(crate) median_us: Vec<f64>,
    /// Mean time of a step, µs; one entry a run; empty where the program does not tell it.
    pub(crate) mean_us: Vec<f64>,
    /// Iterations of the solver a step.
    pub(crate) iterations_per_step: f64,
    /// Height of the middle particle at the end, m.
    pub(crate) middle_m: f64,
    /// Height of the lowest particle at the end, m.
    pub(crate) lowest_m: f64,
}

/// A solver of drape beside one of a peer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Pair {
    /// What was run.
    pub(crate) case: Case,
    /// As in [`Runs::program`].
    pub(crate) peer: String,
    /// As in [`Runs::solver`], of the peer.
    pub(crate) peer_solver: String,
    /// As in [`Runs::solver`], of drape.
    pub(crate) solver: String,
    /// As in [`Runs::mesh`], of drape.
    pub(crate) mesh: String,
    /// Greater of the differences between the two heights of the middle and of the lowest particle,
    /// m.
    pub(crate) difference_m: f64,
    /// Greatest difference that the tolerance of the solvers explains, m.
    pub(crate) allowed_m: f64,
    /// Absent where the answers differ by more than is allowed.
    pub(crate) ratio: Option<Ratio>,
}

/// The peer's time of a step over drape's: above 1 where drape is faster.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ratio {
    /// One entry a pair of runs, in which one followed soon upon the other.
    pub(crate) samples: Vec<f64>,
    /// Their median.
    pub(crate) median: f64,
    /// The least.
    pub(crate) least: f64,
    /// The greatest.
    pub(crate) greatest: f64,
}
