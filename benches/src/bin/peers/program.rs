//! A program (drape or a peer) that takes the steps of a case, and its output.

use crate::error::PeersError;
use crate::record::Case;
use drape_benches::Mesh;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Relative tolerance of every iterative solve.
pub(crate) const TOLERANCE: f64 = 1e-3;

/// Result of one run of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// Median time of a step, µs.
    pub(crate) median_us: f64,
    /// Mean time of a step, µs.
    pub(crate) mean_us: Option<f64>,
    /// Iterations of the solver a step.
    pub(crate) iterations: f64,
    /// Height of the middle particle at the end, m.
    pub(crate) middle: f64,
    /// Height of the lowest particle at the end, m.
    pub(crate) lowest: f64,
}

/// A program with one of its solvers.
#[derive(Clone, Debug)]
pub(crate) enum Program {
    /// This program, on one of the meshes.
    Drape { method: &'static str, mesh: Mesh },
    /// An executable in the folder of peers.
    Peer { peer: &'static Peer, path: PathBuf, solver: &'static str },
}

/// A peer: its name, the method that it computes and the words around its numbers.
#[derive(Debug)]
pub(crate) struct Peer {
    /// Name of the executable.
    pub(crate) name: &'static str,
    /// The method that it computes.
    pub(crate) method: &'static str,
    median: &'static str,
    iterations: &'static str,
}

/// The peers that this program knows how to ask.
pub(crate) static PEERS: [Peer; 2] = [
    Peer {
        name: "eigen_imex",
        method: "imex-euler",
        median: "total",
        iterations: "iters/step/rhs",
    },
    Peer { name: "eigen_bw", method: "baraff-witkin", median: "med", iterations: "it" },
];

impl Program {
    /// `drape`, or the peer's name.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Drape { .. } => "drape",
            Self::Peer { peer, .. } => peer.name,
        }
    }

    /// The method id with its settings, or the peer's name of its solver.
    pub(crate) fn solver(&self) -> &'static str {
        match self {
            Self::Drape { method, .. } => method,
            Self::Peer { solver, .. } => solver,
        }
    }

    /// The order of particles and springs that it works on; a peer's is that of the grid.
    pub(crate) fn mesh(&self) -> &'static str {
        match self {
            Self::Drape { mesh, .. } => mesh.name(),
            Self::Peer { .. } => Mesh::Grid.name(),
        }
    }

    /// Runs it once on one core and one thread.
    pub(crate) fn run(&self, case: &Case, core: Option<u32>) -> Result<Sample, PeersError> {
        let named = |source| PeersError::Start { program: self.to_string(), source };
        let (path, words) = match self {
            Self::Drape { .. } => (std::env::current_exe().map_err(named)?, "total"),
            Self::Peer { peer, path, .. } => (path.clone(), peer.median),
        };
        let mut command = pinned(&path, core);
        for variable in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"] {
            command.env(variable, "1");
        }
        let (side, steps) = (case.side.to_string(), case.steps.to_string());
        let stiffness = case.stiffness_over_mass_per_s2.to_string();
        match self {
            Self::Drape { method, mesh } => {
                command.args(["step", method, &side, mesh.name(), &steps, &stiffness]);
            }
            Self::Peer { solver, .. } => {
                let tolerance = TOLERANCE.to_string();
                command.args([side.as_str(), solver, &tolerance, &steps, &stiffness]);
            }
        }
        let output = command.output().map_err(named)?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let said = said.trim().lines().last().unwrap_or("nothing on standard error").to_owned();
            return Err(PeersError::Failed {
                program: self.to_string(),
                status: output.status,
                said,
            });
        }
        let iterations = match self {
            Self::Drape { .. } => "iterations",
            Self::Peer { peer, .. } => peer.iterations,
        };
        read(&self.to_string(), &String::from_utf8_lossy(&output.stdout), [words, iterations])
    }
}

impl std::fmt::Display for Program {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {} ({})", self.name(), self.solver(), self.mesh())
    }
}

/// The numbers of a line of output: the word before the median, and that before the iterations,
/// differ.
fn read(program: &str, line: &str, words: [&'static str; 2]) -> Result<Sample, PeersError> {
    let tokens: Vec<_> = line.split_whitespace().collect();
    let found = |word: &str| {
        let position = tokens.iter().position(|token| *token == word)?;
        tokens.get(position + 1)?.parse::<f64>().ok().filter(|value| value.is_finite())
    };
    let number = |word: &'static str| {
        found(word).ok_or_else(|| PeersError::Output {
            program: program.to_owned(),
            expected: word,
            found: if line.trim().is_empty() {
                "nothing".to_owned()
            } else {
                line.trim().to_owned()
            },
        })
    };
    // `… 12.3 (mean) …`
    let mean = tokens.windows(2).find(|pair| pair[1] == "(mean)");
    Ok(Sample {
        median_us: number(words[0])?,
        mean_us: mean.and_then(|pair| pair[0].parse().ok()),
        iterations: number(words[1])?,
        middle: number("xmid")?,
        lowest: number("ymin")?,
    })
}

/// A command that runs on one core, where the machine can do that.
fn pinned(path: &Path, core: Option<u32>) -> Command {
    match core {
        None => Command::new(path),
        Some(core) => {
            let mut command = Command::new("taskset");
            command.arg("-c").arg(core.to_string()).arg(path);
            command
        }
    }
}

/// The core to use: that which was asked for or the last one, if programs can be pinned at all.
pub(crate) fn core(asked: Option<u32>) -> Option<u32> {
    let can_pin = Command::new("taskset").arg("--version").output().is_ok();
    let last = || std::thread::available_parallelism().map_or(0, |n| n.get() as u32 - 1);
    can_pin.then(|| asked.unwrap_or_else(last))
}

/// The peers in the folder that `DRAPE_PEERS` names; none where it names nothing.
pub(crate) fn peers(folder: Option<&Path>) -> Result<Vec<(&'static Peer, PathBuf)>, PeersError> {
    let Some(folder) = folder else { return Ok(Vec::new()) };
    let refuse = |reason: String| {
        let known = PEERS.each_ref().map(|peer| peer.name).join(", ");
        Err(PeersError::Folder { folder: folder.to_owned(), reason, known })
    };
    if let Err(error) = std::fs::read_dir(folder) {
        return refuse(error.to_string());
    }
    let found: Vec<_> = PEERS
        .iter()
        .map(|peer| (peer, folder.join(peer.name)))
        .filter(|(_, path)| path.is_file())
        .collect();
    if found.is_empty() {
        return refuse("no known peer in it".to_owned());
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = "N=52 solver=cgicn tol=0.001 | per-step us: total 455.8 (med) 492.5 (mean) force 117.4 \
        | iters/step/rhs 0.80 max 3 | ymin -4.811852 xmid -3.925022830";

    #[test]
    fn the_numbers_of_a_peer_are_found_by_the_words_before_them() {
        let sample = read("peer", LINE, ["total", "iters/step/rhs"]).expect("complete");
        let expected = Sample {
            median_us: 455.8,
            mean_us: Some(492.5),
            iterations: 0.8,
            middle: -3.925_022_83,
            lowest: -4.811_852,
        };
        assert_eq!(sample, expected);
        let bw =
            "bw jac N=52: step us med 1874.1 | it 5.54 | nnz 307044 xmid -1.250758 ymin -1.2508";
        let sample = read("peer", bw, ["med", "it"]).expect("complete");
        assert_eq!((sample.median_us, sample.mean_us), (1874.1, None));
    }

    #[test]
    fn an_answer_that_is_not_understood_says_what_is_missing() {
        let refused = |line: &str| {
            read("peer", line, ["total", "iters/step/rhs"]).expect_err("refused").to_string()
        };
        assert!(refused("").contains("`total`") && refused("").contains("nothing"));
        assert!(refused(&LINE.replace("455.8", "nan")).contains("`total`"));
        assert!(refused(&LINE.replace("xmid", "mid")).contains("`xmid`"));
    }

    #[test]
    fn a_folder_without_a_known_peer_is_refused_and_no_folder_is_not() {
        assert!(peers(None).expect("no folder").is_empty());
        let folder = tempfile::tempdir().expect("a folder");
        let refused = peers(Some(folder.path())).expect_err("empty").to_string();
        assert!(refused.contains("no known peer") && refused.contains("eigen_imex"), "{refused}");
        assert!(peers(Some(&folder.path().join("none"))).is_err());
        std::fs::write(folder.path().join("eigen_bw"), "").expect("written");
        let found = peers(Some(folder.path())).expect("one peer");
        assert_eq!(found.len(), 1);
        // It is no program at all.
        let program = Program::Peer { peer: found[0].0, path: found[0].1.clone(), solver: "jac" };
        let case = Case {
            method: "baraff-witkin".to_owned(),
            side: 3,
            stiffness_over_mass_per_s2: 1e4,
            steps: 1,
        };
        assert!(program.run(&case, None).expect_err("no program").to_string().contains("eigen_bw"));
    }
}
