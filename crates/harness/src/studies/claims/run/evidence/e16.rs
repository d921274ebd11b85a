//! What is run for claim C16.

use super::runs::{track, walk};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c16::LIMIT;
use crate::run::Simulation;
use crate::scenes::{build, bundled};
use crate::studies::tables::run::PRINTED;
use drape_integrator::{
    ContactSet, Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, SolverKind,
    StepReport, StopNorm, Weights,
};
use drape_model::{Level, Vec3};
use drape_solvers::Constraints;

pub(super) const TRIAL: Trial = Trial {
    id: "C16",
    scenes: || {
        "the six rows of the paper's tables, a simulated second each, plain IMEX Euler, ε = 1e-3 \
         relative to |b|, single solves also at 0.05; steps from the extrapolated start, single solves from v_n"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const METHOD: &str = "imex-euler:norm=euclid,forcing_term=1e-3";

/// Most iterations of a single solve from `v_n`, before each step of the run anew: a step with
/// contacts may solve again after releases, and its own count would hold the iterations of all.
fn most_of_a_solve(start: &Simulation, step: f64, forcing_term: f64) -> Result<f64, HarnessError> {
    let system = &start.system;
    let n = system.len();
    let settings = LinearSettings {
        forcing_term,
        preconditioner: PreconditionerKind::Ic0,
        norm: StopNorm::Euclid,
        solver: SolverKind::Cg,
        rebuild_every_step: false,
    };
    let weights = Weights::StiffnessAndDamping;
    let mut linear = LaplacianSolver::new(system, Implicit::Tension, weights, settings, step)?;
    let (mut contacts, mut constraints) = (ContactSet::new(system), Constraints::free(n));
    let (rest, mut b) = (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
    let mut most = 0;
    let steps = (1.0 / step).round() as u64;
    let method = format!("imex-euler:norm=euclid,forcing_term={forcing_term}");
    walk(
        start,
        &method,
        step,
        steps,
        |system, state| {
            contacts.detect(system, &state.x, &state.v, (step, state.t + step), &mut constraints);
            system.forces(Level { v: &rest, ..state.level() }, &mut b);
            for (i, &mass) in system.mass().iter().enumerate() {
                b[i] = b[i] * step + state.v[i] * mass; // EEH (21)
            }
            let mut v = state.v.clone();
            most = most.max(linear.solve(&constraints, &b, &mut v).iterations);
        },
        |_, _, _| (),
    )?;
    Ok(most as f64)
}

/// Steps that take more iterations than the limit.
fn walked_over(start: &Simulation, step: f64) -> Result<u64, HarnessError> {
    let mut over = 0;
    let steps = (1.0 / step).round() as u64;
    let look = |report: &StepReport| u64::from(f64::from(report.cg_iterations) > LIMIT);
    walk(start, METHOD, step, steps, |_, _| (), |_, report, _| over += look(report))?;
    Ok(over)
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    let (mut over, mut steps) = (0, 0);
    for row in &PRINTED {
        let label = format!("table {} row {}", row.table, row.row);
        let start = build(&bundled(row.scene)?)?.1;
        for (forcing_term, at) in [(1e-3, ""), (0.05, ", ε = 0.05")] {
            let solve = most_of_a_solve(&start, row.step_s, forcing_term)?;
            let what = format!("{label}: most of a solve, IC(0){at}");
            numbers.push(Number::new(what, solve, "").against(LIMIT));
        }
        for preconditioner in ["ic0", "jacobi", "none"] {
            let method = format!("{METHOD},preconditioner={preconditioner}");
            let run = track(&start, &method, row.step_s, 1.0, 0)?;
            numbers.push(Number::new(
                format!("{label}: mean of a step, {preconditioner}"),
                run.per_step(),
                "",
            ));
            numbers.push(Number::new(
                format!("{label}: most of a step, {preconditioner}"),
                f64::from(run.most),
                "",
            ));
            if preconditioner == "ic0" {
                over += walked_over(&start, row.step_s)?;
                steps += run.steps;
            }
        }
    }
    let share = over as f64 / steps as f64;
    let what = "share of steps with more than 10 iterations";
    numbers.push(Number::new(what, share, ""));
    Ok(numbers)
}
