//! The cases, solvers and repetitions of the comparison, and the ratios that are its goals.

use crate::program::{Peer, Program};
use crate::record::Case;
use drape_benches::Mesh;
use std::path::PathBuf;

/// A case with the programs that run it.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) case: Case,
    /// How often each program runs.
    pub(crate) rounds: usize,
    pub(crate) programs: Vec<Program>,
    /// Goals for the ratio to [`YARDSTICK`], if the case has any.
    pub(crate) goal: Option<Goal>,
}

/// Goals for the ratio to [`YARDSTICK`]: the least ratio on each mesh, and a higher aim on the
/// grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    pub(crate) grid: f64,
    pub(crate) grid_aim: f64,
    pub(crate) general: f64,
}

/// The peer's solver to which goals refer: CG with incomplete Cholesky, like drape's default.
pub(crate) const YARDSTICK: &str = "cgicn";

/// With the peer's stop test, relative to the right-hand side.
const IMEX: [&str; 4] = [
    "imex-euler:implicit=tension,forcing_term=1e-3,norm=euclid,preconditioner=auto,solver=auto",
    "imex-euler:implicit=tension,forcing_term=1e-3,norm=euclid,preconditioner=jacobi",
    "imex-euler:implicit=tension,forcing_term=1e-3,norm=euclid,preconditioner=ic0",
    "imex-euler:implicit=tension,solver=cholesky",
];
const IMEX_PEER: [&str; 3] = [YARDSTICK, "cgjac", "cholamd"];
/// In the norm of the peer's stop test, and from its start.
const BARAFF_WITKIN: [&str; 3] = [
    "baraff-witkin:implicit=everything,forcing_term=1e-3,norm=euclid,start=last,preconditioner=none",
    "baraff-witkin:implicit=everything,forcing_term=1e-3,norm=euclid,start=last,preconditioner=block-jacobi",
    "baraff-witkin:implicit=everything,solver=cholesky",
];
const BARAFF_WITKIN_PEER: [&str; 3] = ["jac", "ic", "llt"];

/// Largest side at which Baraff and Witkin's matrix is factorised: beyond it one step takes a
/// minute. The matrix of IMEX Euler is factorised up to 316; ordering a million rows takes longer
/// than all steps.
const LARGEST_FACTOR: u32 = 100;

/// Method, k/m, side, steps, rounds, goal.
type Line = (&'static str, f64, u32, u32, usize, Option<Goal>);

const fn goal(grid: f64, grid_aim: f64, general: f64) -> Option<Goal> {
    Some(Goal { grid, grid_aim, general })
}

/// Steps are fewer on large sheets, where a run would take minutes; both programs take the same.
const LINES: [Line; 11] = [
    ("imex-euler", 1e4, 20, 100, 9, goal(4.0, 6.0, 2.5)),
    ("imex-euler", 1e4, 52, 100, 9, goal(5.0, 8.0, 3.0)),
    ("imex-euler", 1e4, 100, 100, 7, goal(5.0, 8.0, 3.0)),
    ("imex-euler", 1e4, 316, 30, 5, goal(5.0, 8.0, 2.5)),
    ("imex-euler", 1e4, 1000, 10, 3, goal(3.5, 4.5, 2.5)),
    ("imex-euler", 1e6, 52, 100, 7, None),
    ("imex-euler", 1e6, 100, 100, 5, None),
    ("baraff-witkin", 1e4, 20, 100, 5, None),
    ("baraff-witkin", 1e4, 52, 50, 5, None),
    ("baraff-witkin", 1e4, 100, 20, 3, None),
    ("baraff-witkin", 1e4, 316, 6, 3, None),
];

/// The cases up to a side, with drape on both meshes and every peer that computes the method. Drape
/// and the peers take turns.
pub(crate) fn plans(peers: &[(&'static Peer, PathBuf)], largest: u32, rounds: usize) -> Vec<Plan> {
    let lines = LINES.iter().filter(|line| line.2 <= largest);
    lines
        .map(|&(method, stiffness, side, steps, usual, goal)| {
            let (ours, theirs) = match method {
                "imex-euler" => (IMEX.as_slice(), IMEX_PEER),
                _ => (BARAFF_WITKIN.as_slice(), BARAFF_WITKIN_PEER),
            };
            let is_fit = |solver: &str| {
                let largest = if method == "imex-euler" { 316 } else { LARGEST_FACTOR };
                side <= largest || !is_direct(solver)
            };
            let drape = ours
                .iter()
                .flat_map(|&method| Mesh::ALL.map(move |mesh| Program::Drape { method, mesh }));
            let peers = peers.iter().filter(|(peer, _)| peer.method == method);
            let asked = peers.flat_map(|(peer, path)| {
                theirs.map(|solver| Program::Peer { peer, path: path.clone(), solver })
            });
            let (drape, asked): (Vec<_>, Vec<_>) = (drape.collect(), asked.collect());
            let longest = drape.len().max(asked.len());
            let turns = (0..longest).flat_map(|n| [asked.get(n), drape.get(n)]);
            let programs = turns.flatten().filter(|p| is_fit(p.solver())).cloned().collect();
            let case = Case {
                method: method.to_owned(),
                side,
                stiffness_over_mass_per_s2: stiffness,
                steps,
            };
            Plan { case, rounds: usual.min(rounds), programs, goal }
        })
        .collect()
}

/// Whether a solver has no tolerance of its own.
pub(crate) fn is_direct(solver: &str) -> bool {
    solver.starts_with("chol") || solver == "llt" || solver.contains("solver=cholesky")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::PEERS;
    use drape_harness::methods::Choice;

    #[test]
    fn every_case_has_drape_on_both_meshes_and_its_own_peer() {
        let peers = PEERS.each_ref().map(|peer| (peer, PathBuf::from(peer.name)));
        for Plan { case, programs, .. } in plans(&peers, 1000, 9) {
            let count = |name: &str| programs.iter().filter(|p| p.name() == name).count();
            let (peer, other) = match case.method.as_str() {
                "imex-euler" => ("eigen_imex", "eigen_bw"),
                _ => ("eigen_bw", "eigen_imex"),
            };
            assert!(count("drape") >= 4 && count(peer) >= 2 && count(other) == 0, "{case:?}");
        }
        assert!(plans(&[], 52, 1).iter().all(|plan| plan.rounds == 1 && plan.case.side <= 52));
    }

    #[test]
    fn every_method_is_one_of_drape() {
        for method in IMEX.iter().chain(&BARAFF_WITKIN) {
            Choice::parse(method, &[]).expect("a method with its settings");
        }
    }
}
