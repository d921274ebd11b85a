//! The record as a page.

use crate::plan::{Goal, Plan, YARDSTICK};
use crate::record::{Case, Pair, Row, Runs, Setup};
use drape_benches::Mesh;
use drape_report::Timings;
use drape_report::number::median;
use std::fmt::Write as _;

/// The page that stands beside the record.
pub(crate) fn page(timings: &Timings<Row>, plans: &[Plan]) -> String {
    let mut page = format!("# Drape beside other programs\n\n{}\n\n", timings.method);
    for row in &timings.rows {
        if let Row::Setup(setup) = row {
            page += &conditions(setup, &timings.provenance.cpu);
        }
    }
    for method in ["imex-euler", "baraff-witkin"] {
        let plans: Vec<_> = plans.iter().filter(|plan| plan.case.method == method).collect();
        if !plans.is_empty() {
            let _ = writeln!(page, "## {method}\n");
            times(&mut page, timings, &plans);
            ratios(&mut page, timings, &plans);
        }
    }
    page
}

fn conditions(setup: &Setup, cpu: &str) -> String {
    let core = setup.core.map_or("not pinned to a core".to_owned(), |n| format!("core {n}"));
    let peers = match setup.peers_sha256.len() {
        0 => "No peer was measured: DRAPE_PEERS names no folder.".to_owned(),
        _ => {
            "Peers: ".to_owned()
                + &setup.peers_sha256.keys().cloned().collect::<Vec<_>>().join(", ")
                + "."
        }
    };
    let about = setup.about.as_ref().map(|about| format!("\n\n```text\n{}\n```", about.trim()));
    format!("{cpu}, {core}. {peers}{}\n\n", about.unwrap_or_default())
}

fn runs<'a>(timings: &'a Timings<Row>, case: &'a Case) -> impl Iterator<Item = &'a Runs> {
    timings.rows.iter().filter_map(move |row| match row {
        Row::Runs(runs) if runs.case == *case => Some(runs),
        _ => None,
    })
}

fn pairs<'a>(timings: &'a Timings<Row>, case: &'a Case) -> impl Iterator<Item = &'a Pair> {
    timings.rows.iter().filter_map(move |row| match row {
        Row::Pair(pair) if pair.case == *case => Some(pair),
        _ => None,
    })
}

/// The setting in which the solvers of a method differ.
fn short(solver: &str) -> &str {
    solver.rsplit(['=', ':']).next().unwrap_or(solver)
}

fn case_name(case: &Case) -> String {
    format!("{} | {:.0e} | {}", case.side, case.stiffness_over_mass_per_s2, case.steps)
}

/// Median time of a step over all runs, µs, of every program.
fn times(page: &mut String, timings: &Timings<Row>, plans: &[&Plan]) {
    // The first case has the solvers of all.
    let mut columns: Vec<_> = runs(timings, &plans[0].case)
        .map(|runs| (runs.program.clone(), runs.solver.clone(), runs.mesh.clone()))
        .collect();
    columns.sort_by_key(|(program, _, mesh)| (program == "drape", mesh == Mesh::General.name()));
    let head = |(program, solver, mesh): &(String, String, String)| match program.as_str() {
        "drape" => format!("drape, {mesh}: {}", short(solver)),
        _ => format!("{program} {solver}"),
    };
    page.push_str(
        "Median time of a step, µs; in brackets the iterations of the solver a step.\n\n",
    );
    let heads: Vec<_> = columns.iter().map(head).collect();
    let _ = writeln!(page, "| N | k/m | steps | {} |", heads.join(" | "));
    let _ = writeln!(page, "|{}", "---|".repeat(3 + columns.len()));
    for plan in plans {
        let cell = |(program, solver, mesh): &(String, String, String)| {
            let mut found = runs(timings, &plan.case);
            let it = found.find(|runs| {
                runs.program == *program && runs.solver == *solver && runs.mesh == *mesh
            });
            it.map_or("–".to_owned(), |runs| {
                format!("{} ({:.1})", digits(middle_us(runs)), runs.iterations_per_step)
            })
        };
        let cells: Vec<_> = columns.iter().map(cell).collect();
        let _ = writeln!(page, "| {} | {} |", case_name(&plan.case), cells.join(" | "));
    }
    page.push('\n');
}

/// For each mesh, drape's fastest solver beside each of the peer's.
fn ratios(page: &mut String, timings: &Timings<Row>, plans: &[&Plan]) {
    let mut solvers: Vec<_> =
        pairs(timings, &plans[0].case).map(|pair| pair.peer_solver.clone()).collect();
    solvers.dedup();
    if solvers.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "The peer's time over that of drape's fastest solver on the mesh: median over the pairs of runs, in brackets the \
         least and the greatest; ✗ where the answers differ by more than the tolerance explains.{}\n",
        if plans.iter().any(|plan| plan.goal.is_some()) {
            format!(" Goals are set against `{YARDSTICK}`.")
        } else {
            String::new()
        }
    );
    let _ = writeln!(page, "| N | k/m | steps | mesh | drape | {} | goal |", solvers.join(" | "));
    let _ = writeln!(page, "|{}", "---|".repeat(6 + solvers.len()));
    for plan in plans {
        for mesh in Mesh::ALL {
            let time = |runs: &&Runs| middle_us(runs);
            let own = runs(timings, &plan.case)
                .filter(|runs| runs.program == "drape" && runs.mesh == mesh.name());
            let Some(best) = own.min_by(|a, b| time(a).total_cmp(&time(b))) else { continue };
            let of = |solver: &String| {
                let mut found = pairs(timings, &plan.case);
                let pair = found.find(|pair| {
                    pair.peer_solver == *solver
                        && pair.mesh == best.mesh
                        && pair.solver == best.solver
                });
                pair.map_or("–".to_owned(), ratio)
            };
            let cells: Vec<_> = solvers.iter().map(of).collect();
            let _ = writeln!(
                page,
                "| {} | {} | {} | {} | {} |",
                case_name(&plan.case),
                mesh.name(),
                short(&best.solver),
                cells.join(" | "),
                plan.goal.map_or("–".to_owned(), |goal| goal_of(goal, mesh))
            );
        }
    }
    page.push('\n');
}

fn ratio(pair: &Pair) -> String {
    pair.ratio.as_ref().map_or_else(
        || format!("✗ ({:.1e} m)", pair.difference_m),
        |ratio| format!("{:.2} ({:.2}–{:.2})", ratio.median, ratio.least, ratio.greatest),
    )
}

fn goal_of(goal: Goal, mesh: Mesh) -> String {
    match mesh {
        Mesh::Grid => format!("≥ {}, aim {}", goal.grid, goal.grid_aim),
        Mesh::General => format!("≥ {}", goal.general),
    }
}

/// The median of its times; not a number where it has none.
fn middle_us(runs: &Runs) -> f64 {
    median(runs.median_us.iter().copied()).unwrap_or(f64::NAN)
}

/// Three significant digits, or all of a whole number.
fn digits(value: f64) -> String {
    let decimals = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Ratio;

    #[test]
    fn the_fastest_solver_of_a_mesh_stands_beside_each_of_the_peers() {
        let case = Case {
            method: "imex-euler".to_owned(),
            side: 20,
            stiffness_over_mass_per_s2: 1e4,
            steps: 100,
        };
        let runs = |program: &str, solver: &str, median: f64| {
            Row::Runs(Runs {
                case: case.clone(),
                program: program.to_owned(),
                solver: solver.to_owned(),
                mesh: "grid".to_owned(),
                median_us: vec![median],
                mean_us: Vec::new(),
                iterations_per_step: 2.0,
                middle_m: 0.0,
                lowest_m: 0.0,
            })
        };
        let pair = |solver: &str, median: Option<f64>| {
            Row::Pair(Pair {
                case: case.clone(),
                peer: "eigen_imex".to_owned(),
                peer_solver: YARDSTICK.to_owned(),
                solver: solver.to_owned(),
                mesh: "grid".to_owned(),
                difference_m: 0.5,
                allowed_m: 0.1,
                ratio: median.map(|median| Ratio {
                    samples: vec![median],
                    median,
                    least: median,
                    greatest: median,
                }),
            })
        };
        let (jacobi, ic0) = ("imex-euler:preconditioner=jacobi", "imex-euler:preconditioner=ic0");
        let timings = |ratio| Timings {
            format: String::new(),
            experiment: String::new(),
            method: "How.".to_owned(),
            rows: vec![
                runs("eigen_imex", YARDSTICK, 50.0),
                runs("drape", ic0, 20.0),
                runs("drape", jacobi, 10.0),
                pair(ic0, Some(2.5)),
                pair(jacobi, ratio),
            ],
            provenance: drape_harness::provenance(&Default::default(), Default::default()),
        };
        let goal = Some(Goal { grid: 4.0, grid_aim: 6.0, general: 2.0 });
        let plans = [Plan { case: case.clone(), rounds: 1, programs: Vec::new(), goal }];
        let said = page(&timings(Some(5.0)), &plans);
        let line = "| 20 | 1e4 | 100 | grid | jacobi | 5.00 (5.00–5.00) | ≥ 4, aim 6 |";
        assert!(said.contains(line), "{said}");
        assert!(
            said.contains("| 20 | 1e4 | 100 | 50.0 (2.0) | 20.0 (2.0) | 10.0 (2.0) |"),
            "{said}"
        );
        assert!(page(&timings(None), &plans).contains("| jacobi | ✗ (5.0e-1 m) |"));
    }
}
