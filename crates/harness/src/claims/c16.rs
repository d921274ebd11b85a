//! C16: IC makes the iteration converge in very few steps.

use super::runs::{track, walk};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::run::Simulation;
use crate::scenes::{build, bundled};
use crate::studies::short;
use crate::studies::tables::run::PRINTED;
use drape_integrator::{
    ContactSet, Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, SolverKind,
    StepReport, Weights,
};
use drape_model::{Level, Vec3};
use drape_solvers::{Constraints, Norm};

pub(super) const CLAIM: Claim = Claim {
    id: "C16",
    section: "5",
    says: "IC makes the iteration converge in very few steps",
    criterion: "≤ 10 iterations to 1e-3 over the paper's range of parameters",
    is_quick: false,
    test,
    seconds: None,
};

const LIMIT: f64 = 10.0;
const METHOD: &str = "imex-euler:forcing_term=1e-3";

/// Most iterations of a single solve from `v_n`, before each step of the run anew: a step with contacts may solve again after
/// releases, and its own count would hold the iterations of all.
fn most_of_a_solve(start: &Simulation, step: f64) -> Result<f64, HarnessError> {
    let system = &start.system;
    let n = system.len();
    let settings = LinearSettings {
        forcing_term: 1e-3,
        preconditioner: PreconditionerKind::Ic0,
        norm: Norm::Euclid,
        solver: SolverKind::Cg,
        rebuild_every_step: false,
    };
    let weights = Weights::StiffnessAndDamping;
    let mut linear = LaplacianSolver::new(system, Implicit::Tension, weights, settings, step)?;
    let (mut contacts, mut constraints) = (ContactSet::new(system), Constraints::free(n));
    let (rest, mut b) = (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
    let mut most = 0;
    let steps = (1.0 / step).round() as u64;
    walk(
        start,
        METHOD,
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

fn test() -> Result<Finding, HarnessError> {
    let mut numbers = Vec::new();
    let (mut seen, mut over, mut steps) = (Seen::default(), 0, 0);
    for row in &PRINTED {
        let label = format!("table {} row {}", row.table, row.row);
        let start = build(&bundled(row.scene)?)?.1;
        let solve = most_of_a_solve(&start, row.step_s)?;
        numbers.push(
            Number::new(format!("{label}: most of a solve, IC(0)"), solve, "").against(LIMIT),
        );
        seen.solve = seen.solve.max(solve);
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
                let loose = track(&start, "imex-euler:forcing_term=0.05", row.step_s, 1.0, 0)?;
                seen.loose = seen.loose.max(f64::from(loose.most));
                over += walked_over(&start, row.step_s)?;
                steps += run.steps;
                if f64::from(run.most) > LIMIT {
                    seen.rows.push(format!("{label}, n = {}", start.system.len()));
                }
                seen.mean = seen.mean.max(run.per_step());
                seen.step = seen.step.max(f64::from(run.most));
            } else {
                seen.bare = seen.bare.max(f64::from(run.most));
            }
        }
    }
    seen.share = over as f64 / steps as f64;
    let what = "share of steps with more than 10 iterations";
    numbers.push(Number::new(what, seen.share, ""));
    Ok(judge(numbers, &seen))
}

/// The greatest counts over all rows.
#[derive(Clone, Debug, Default)]
struct Seen {
    solve: f64,
    step: f64,
    mean: f64,
    /// Of a step without IC(0).
    bare: f64,
    /// Of a step with IC(0) to the paper's order of tolerance.
    loose: f64,
    /// Share of the steps that take more than the limit.
    share: f64,
    /// The rows in which some do.
    rows: Vec<String>,
}

fn judge(numbers: Vec<Number>, seen: &Seen) -> Finding {
    let Seen { solve, step, mean, bare, loose, share, ref rows } = *seen;
    Finding {
        verdict: Verdict::of(solve <= LIMIT),
        numbers,
        reason: format!(
            "With IC(0) the dearest solve of all rows takes {solve} iterations, a step {} on the mean of the dearest row and {step} \
             at most; {} % of the steps take more than {LIMIT} (in: {}). Without IC(0) the dearest step takes {bare}; to the paper's ε = 0.05 \
             IC(0) takes {loose} at most.",
            short(mean),
            short(100.0 * share),
            if rows.is_empty() { "none".to_owned() } else { rows.join(", ") }
        ),
        repair: None,
        scenes: "the six rows of the paper's tables, a simulated second each, plain IMEX Euler, ε = 1e-3 relative to |b|; steps from \
                 the extrapolated start, single solves from v_n"
            .to_owned(),
        see: "cg-vs-stiffness.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dearest_solve_decides() {
        let of = |solve| judge(Vec::new(), &Seen { solve, ..Seen::default() });
        assert_eq!(of(10.0).verdict, Verdict::Confirmed);
        assert_eq!(of(11.0).verdict, Verdict::Refuted);
    }
}
