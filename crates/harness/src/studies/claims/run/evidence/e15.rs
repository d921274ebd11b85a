//! What is run for claim C15.

use super::runs::track;
use super::scenes::{build, hanging};
use super::{Number, Timed, Trial};
use crate::HarnessError;
use crate::run::Simulation;
use crate::scenes::bundled;
use crate::studies::claims::facts::TimedCase;
use crate::studies::tables::run::PRINTED;
use drape_integrator::{
    Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, SolverKind, StopNorm, Weights,
    hold_pins,
};
use drape_model::{Level, Vec3};
use drape_solvers::Constraints;
use std::time::Instant;

pub(super) const TRIAL: Trial = Trial {
    id: "C15",
    scenes: || {
        "six rows of the paper's tables for 0.5 s; hanging sheets of 16 to 2704 particles, k/m = \
         1e4 and 1e6, h = 0.01 s, for 0.2 s; IC(0), extrapolated start; operations counted, memory \
         traffic not"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: Some(seconds),
};

/// Sizes of the series that looks for the crossover, particles a side.
const SIDES: [u32; 8] = [4, 6, 8, 10, 14, 20, 28, 52];
/// The tolerances: the paper's order of magnitude, the default here, and what an inverse reaches.
const TOLERANCES: [f64; 3] = [0.05, 1e-3, 1e-10];
const STEP: f64 = 0.01;

/// Operations of a step's solves with CG and with the full inverse.
///
/// For each of three coordinates a product with `A` takes two operations an entry, IC(0) as many,
/// and an iteration three dot products and three sums of vectors besides; a solve starts with one
/// product for its residual. The product with the inverse takes two operations for each of its n²
/// entries.
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
    let run =
        track(start, &format!("imex-euler:norm=euclid,forcing_term={term}"), step, duration, 0)?;
    let n = start.system.len() as f64;
    let (cg, inverse) = operations(n, entries(start), run.per_step(), 1.0);
    Ok(inverse / cg)
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
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
        }
    }
    Ok(numbers)
}

/// One solve of the falling sheet of 400 particles at the stiffer of the paper's values, both ways.
fn seconds() -> Result<Timed, HarnessError> {
    let mut start = build(&hanging(20, 1e6, 40.0).spec()?)?;
    start.state = track(&start, "imex-euler:norm=euclid", STEP, 0.2, 0)?.state;
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
            norm: StopNorm::Euclid,
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
    let number = Number::new("seconds with the inverse / with CG", ratio, "").against(1.0);
    Ok((cases, number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_with_the_inverse_costs_as_much_as_n_over_16_iterations() {
        let (cg, inverse) = operations(1600.0, 8000.0, 100.0, 0.0);
        assert_eq!(operations(1600.0, 8000.0, 0.0, 1.0).1 / cg, 1.0);
        assert_eq!(inverse, 0.0);
    }
}
