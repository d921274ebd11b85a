//! Runs the programs in turns and compares their results.

use crate::error::PeersError;
use crate::plan::{Plan, is_direct};
use crate::program::{Program, Sample, TOLERANCE};
use crate::record::{Case, Pair, Ratio, Row, Runs};
use drape_report::number::median;

/// Runs all programs of a plan in turns. Every other round reverses the order, so that a drift of
/// the machine affects both sides of a ratio.
pub(crate) fn measure(plan: &Plan, core: Option<u32>) -> Result<Vec<Row>, PeersError> {
    let Plan { case, rounds, programs, .. } = plan;
    let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); programs.len()];
    for round in 0..*rounds {
        let mut order: Vec<_> = (0..programs.len()).collect();
        if round % 2 == 1 {
            order.reverse();
        }
        for n in order {
            samples[n].push(programs[n].run(case, core)?);
        }
    }
    let runs: Vec<_> =
        programs.iter().zip(&samples).map(|(program, all)| summary(case, program, all)).collect();
    let ours = || runs.iter().filter(|runs| runs.program == "drape");
    let theirs = runs.iter().filter(|runs| runs.program != "drape");
    let pairs: Vec<_> = theirs.flat_map(|peer| ours().map(|own| pair(own, peer))).collect();
    Ok(runs.into_iter().map(Row::Runs).chain(pairs.into_iter().map(Row::Pair)).collect())
}

fn summary(case: &Case, program: &Program, samples: &[Sample]) -> Runs {
    // The steps are the same in every run.
    let last = samples.last();
    let of = |value: fn(&Sample) -> f64| last.map_or(f64::NAN, value);
    Runs {
        case: case.clone(),
        program: program.name().to_owned(),
        solver: program.solver().to_owned(),
        mesh: program.mesh().to_owned(),
        median_us: samples.iter().map(|sample| sample.median_us).collect(),
        mean_us: samples.iter().filter_map(|sample| sample.mean_us).collect(),
        iterations_per_step: of(|sample| sample.iterations),
        middle_m: of(|sample| sample.middle),
        lowest_m: of(|sample| sample.lowest),
    }
}

/// Error of a printed height, and of two direct solves, relative to the fall.
const ROUND_OFF: f64 = 1e-6;
/// The greatest error of a height that solves to [`TOLERANCE`] explain, relative to the fall: each
/// step adds an error of its velocity, which later steps carry on.
const TOLERATED: f64 = 10.0 * TOLERANCE;

/// A solver of drape beside one of a peer; without a ratio where their answers differ.
fn pair(own: &Runs, peer: &Runs) -> Pair {
    let difference_m =
        (own.middle_m - peer.middle_m).abs().max((own.lowest_m - peer.lowest_m).abs());
    // The sheet starts at height 0.
    let fall = own.lowest_m.abs().max(peer.lowest_m.abs());
    let exact = is_direct(&own.solver) && is_direct(&peer.solver);
    // The peers print six digits at least, one of them four of the lowest height.
    let digits = if peer.case.method == "imex-euler" { 1e-6 } else { 1e-4 };
    let allowed_m = digits + if exact { ROUND_OFF } else { TOLERATED } * fall;
    let ratio = (difference_m <= allowed_m).then(|| {
        let samples: Vec<_> =
            peer.median_us.iter().zip(&own.median_us).map(|(peer, own)| peer / own).collect();
        Ratio {
            median: median(samples.iter().copied()).unwrap_or(f64::NAN),
            least: samples.iter().copied().fold(f64::INFINITY, f64::min),
            greatest: samples.iter().copied().fold(0.0, f64::max),
            samples,
        }
    });
    Pair {
        case: own.case.clone(),
        peer: peer.program.clone(),
        peer_solver: peer.solver.clone(),
        solver: own.solver.clone(),
        mesh: own.mesh.clone(),
        difference_m,
        allowed_m,
        ratio,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_benches::Mesh;

    fn runs(program: &str, solver: &str, median_us: [f64; 3], lowest_m: f64) -> Runs {
        Runs {
            case: Case {
                method: "imex-euler".to_owned(),
                side: 3,
                stiffness_over_mass_per_s2: 1e4,
                steps: 1,
            },
            program: program.to_owned(),
            solver: solver.to_owned(),
            mesh: "grid".to_owned(),
            median_us: median_us.to_vec(),
            mean_us: Vec::new(),
            iterations_per_step: 0.0,
            middle_m: -1.0,
            lowest_m,
        }
    }

    #[test]
    fn ratios_are_those_of_runs_in_the_same_round() {
        let own = runs("drape", "imex-euler", [1.0, 2.0, 1.0], -2.0);
        let peer = runs("peer", "cgicn", [4.0, 10.0, 3.0], -2.01);
        let ratio = pair(&own, &peer).ratio.expect("agreement");
        assert_eq!(ratio.samples, [4.0, 5.0, 3.0]);
        assert_eq!((ratio.median, ratio.least, ratio.greatest), (4.0, 3.0, 5.0));
    }

    #[test]
    fn answers_that_differ_give_no_ratio() {
        let off = |solver, peer_solver, lowest| {
            let own = runs("drape", solver, [1.0; 3], -2.0);
            pair(&own, &runs("peer", peer_solver, [1.0; 3], lowest)).ratio.is_none()
        };
        assert!(off("imex-euler", "cgicn", -2.1));
        assert!(!off("imex-euler", "cholamd", -2.01));
        assert!(off("imex-euler:solver=cholesky", "cholamd", -2.01));
        assert!(!off("imex-euler:solver=cholesky", "cholamd", -2.000_002));
    }

    #[test]
    fn without_peers_drape_is_measured_alone() {
        let programs = vec![Program::Drape { method: "imex-euler", mesh: Mesh::Grid }];
        let case = runs("", "", [0.0; 3], 0.0).case;
        let plan = Plan { case, rounds: 0, programs, goal: None };
        let rows = measure(&plan, None).expect("nothing to fail");
        assert!(matches!(rows.as_slice(), [Row::Runs(_)]));
    }
}
