//! C15: CG is cheaper than multiplying with an inverse.

use super::runs::track;
use super::scenes::{build, hanging};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::run::Simulation;
use crate::scenes::bundled;
use crate::studies::claims::facts::{TimedCase, TimingRow};
use crate::studies::short;
use crate::studies::tables::run::PRINTED;
use drape_integrator::{
    Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, SolverKind, Weights, hold_pins,
};
use drape_model::{Level, Vec3};
use drape_solvers::{Constraints, Norm};
use std::time::Instant;

pub(super) const CLAIM: Claim = Claim {
    id: "C15",
    section: "5",
    says: "CG is cheaper than multiplying with an inverse",
    criterion: "confirmed if a step is cheaper from n = 400 on; the crossover is reported",
    is_quick: false,
    test,
    seconds: Some(seconds),
};

/// Sizes of the series that looks for the crossover, particles a side.
const SIDES: [u32; 8] = [4, 6, 8, 10, 14, 20, 28, 52];
/// The tolerances: the paper's order of magnitude, the default here, and what an inverse reaches.
const TOLERANCES: [f64; 3] = [0.05, 1e-3, 1e-10];
const STEP: f64 = 0.01;

/// Operations of a step's solves with CG and with the full inverse.
///
/// For each of three coordinates a product with `A` takes two operations an entry, IC(0) as many, and an iteration
/// three dot products and three sums of vectors besides; a solve starts with one product for its residual. The product
/// with the inverse takes two operations for each of its n² entries.
fn operations(particles: f64, entries: f64, iterations: f64, solves: f64) -> (f64, f64) {
    let cg = iterations * (12.0 * entries + 36.0 * particles)
        + solves * (6.0 * entries + 12.0 * particles);
    (cg, solves * 6.0 * particles * particles)
}

/// Entries of the matrix of the tension springs, both triangles and the diagonal.
fn entries(simulation: &Simulation) -> f64 {
    let mut springs = 0;
    Implicit::Tension.visit_weights(&simulation.system, &mut |_, _, _, _| springs += 1);
    (simulation.system.len() + 2 * springs) as f64
}

/// Operations with the inverse over those with CG, a step.
fn ratio(start: &Simulation, step: f64, duration: f64, term: f64) -> Result<f64, HarnessError> {
    let run = track(start, &format!("imex-euler:forcing_term={term}"), step, duration, 0)?;
    let n = start.system.len() as f64;
    let (cg, inverse) = operations(n, entries(start), run.per_step(), 1.0);
    Ok(inverse / cg)
}

fn test() -> Result<Finding, HarnessError> {
    let mut numbers = Vec::new();
    let mut least = [f64::INFINITY; TOLERANCES.len()];
    let mut printed = f64::INFINITY;
    for row in &PRINTED {
        let start = crate::scenes::build(&bundled(row.scene)?)?.1;
        for (least, term) in least.iter_mut().zip(TOLERANCES) {
            *least = least.min(ratio(&start, row.step_s, 0.5, term)?);
        }
        // The paper's own count; its algorithm solves at least once a step.
        let (n, steps) = (start.system.len() as f64, 1.0 / row.step_s);
        let (cg, inverse) =
            operations(n, entries(&start), row.paper.cg_iterations as f64 / steps, 1.0);
        printed = printed.min(inverse / cg);
    }
    for (least, term) in least.iter().zip(TOLERANCES) {
        let what = format!("inverse / CG, least over the paper's six rows, ε = {term:e}");
        numbers.push(Number::new(what, *least, "").against(1.0));
    }
    let what = "inverse / CG, least over the six rows with the paper's own counts";
    numbers.push(Number::new(what, printed, "").against(1.0));
    let mut crossovers = Vec::new();
    for stiffness in [1e4, 1e6] {
        for term in TOLERANCES {
            let mut crossover = f64::MAX;
            for side in SIDES.into_iter().rev() {
                let start = build(&hanging(side, stiffness, 40.0).spec()?)?;
                if ratio(&start, STEP, 0.2, term)? <= 1.0 {
                    break;
                }
                crossover = f64::from(side * side);
            }
            let what = format!("cheaper from this n on, k/m = {stiffness:e}, ε = {term:e}");
            numbers.push(Number::new(what, crossover, "particles").against(400.0));
            crossovers.push(crossover);
        }
    }
    Ok(judge(numbers, least, printed, &crossovers))
}

/// Decides at the tolerances at which the method is run.
fn judge(numbers: Vec<Number>, least: [f64; 3], printed: f64, crossovers: &[f64]) -> Finding {
    let used = [crossovers[0], crossovers[1], crossovers[3], crossovers[4]];
    let crossover = used.into_iter().fold(0.0, f64::max);
    let is_met = least[0] > 1.0 && least[1] > 1.0 && printed > 1.0 && crossover <= 400.0;
    Finding {
        verdict: Verdict::of(is_met),
        numbers,
        reason: format!(
            "In the scenes of the paper's tables the product with the full inverse takes at least {} times the \
             operations of CG at ε = 0.05, {} times at 1e-3 and {} times at 1e-10, and {} times those of the counts that \
             the paper prints. A product with the inverse costs 6n², an iteration about 96n operations, so that CG wins \
             while it takes fewer than n/16 iterations; at these tolerances it does from n = {crossover} on.",
            short(least[0]),
            short(least[1]),
            short(least[2]),
            short(printed)
        ),
        repair: None,
        scenes: "six rows of the paper's tables for 0.5 s; hanging sheets of 16 to 2704 particles, k/m = 1e4 and 1e6, \
                 h = 0.01 s, for 0.2 s; IC(0), extrapolated start; operations counted, memory traffic not"
            .to_owned(),
        see: "inverse-cost.svg",
        portable: true,
    }
}

/// One solve of the falling sheet of 400 particles at the stiffer of the paper's values, both ways.
fn seconds() -> Result<TimingRow, HarnessError> {
    let mut start = build(&hanging(20, 1e6, 40.0).spec()?)?;
    start.state = track(&start, "imex-euler", STEP, 0.2, 0)?.state;
    let Simulation { system, state } = &start;
    let mut constraints = Constraints::free(system.len());
    hold_pins(system, &mut constraints);
    let mut b = vec![Vec3::zeros(); system.len()];
    let rest = vec![Vec3::zeros(); system.len()];
    system.forces(Level { v: &rest, ..state.level() }, &mut b);
    for i in 0..b.len() {
        b[i] = b[i] * STEP + state.v[i] * system.mass()[i];
    }
    let mut cases = Vec::new();
    for (what, solver) in [
        ("CG with IC(0), ε = 1e-3, from v_n", SolverKind::Cg),
        ("product with the full inverse", SolverKind::DenseInverse { limit_bytes: 1 << 30 }),
    ] {
        let settings = LinearSettings {
            forcing_term: 1e-3,
            preconditioner: PreconditionerKind::Ic0,
            norm: Norm::Euclid,
            solver,
            rebuild_every_step: false,
        };
        let weights = Weights::StiffnessAndDamping;
        let mut linear = LaplacianSolver::new(system, Implicit::Tension, weights, settings, STEP)?;
        let mut v = state.v.clone();
        let mut once = || {
            v.copy_from_slice(&state.v);
            let begin = Instant::now();
            if solver == SolverKind::Cg {
                linear.solve(&constraints, &b, &mut v);
            } else {
                linear.apply_preconditioner(&b, &mut v);
            }
            begin.elapsed().as_nanos() as u64
        };
        let samples_ns = (0..101).map(|_| once()).collect();
        cases.push(TimedCase { what: what.to_owned(), samples_ns });
    }
    let ratio = cases[1].median_s() / cases[0].median_s();
    Ok(TimingRow {
        id: CLAIM.id.to_owned(),
        cases,
        number: Number::new("seconds with the inverse / with CG", ratio, "").against(1.0),
        verdict: Verdict::of(ratio > 1.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_decided_at_the_tolerances_that_are_used_and_by_the_crossover() {
        let of = |least, crossover| {
            let crossovers = [16.0, 36.0, 2704.0, 64.0, crossover, 2704.0];
            judge(Vec::new(), least, 2.0, &crossovers).verdict
        };
        assert_eq!(of([9.0, 5.0, 0.5], 400.0), Verdict::Confirmed);
        assert_eq!(of([9.0, 0.9, 0.5], 400.0), Verdict::Refuted);
        assert_eq!(of([9.0, 5.0, 0.5], 784.0), Verdict::Refuted);
    }

    #[test]
    fn a_product_with_the_inverse_costs_as_much_as_n_over_16_iterations() {
        let (cg, inverse) = operations(1600.0, 8000.0, 100.0, 0.0);
        assert_eq!(operations(1600.0, 8000.0, 0.0, 1.0).1 / cg, 1.0);
        assert_eq!(inverse, 0.0);
    }
}
