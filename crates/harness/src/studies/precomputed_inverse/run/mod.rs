//! Experiment `precomputed-inverse`: the cost of Desbrun's inverse, and of a change of the system.

mod changes;
mod system;
#[cfg(test)]
mod tests;

use crate::facts::{Fact, fact};
use crate::methods::Choice;
use crate::run::Simulation;
use crate::studies::precomputed_inverse::facts::{Facts, TimingRow};
use crate::studies::stepper::Stepper;
use crate::studies::{Context, Measured, Start, cells, timed};
use crate::{HarnessError, system_hash};
use drape_model::Vec3;
use std::collections::BTreeMap;
use std::time::Instant;
use system::{Case, LOOSE, Problem, STEP};

/// Numbers of particles along each edge: 100 to 2704 particles, the paper's largest sheet.
const SIDES: [u32; 5] = [10, 20, 30, 40, 52];
const QUICK_SIDES: [u32; 2] = [10, 20];
/// Number of timed repetitions.
const REPETITIONS: usize = 5;
/// Number of steps in a repetition.
const TIMED_STEPS: u64 = 50;

/// How the timings are taken.
pub(super) fn timing() -> String {
    format!(
        "One case runs at a time on one thread, with {REPETITIONS} repetitions of each. Set-up is \
         the allocation, the analysis of the pattern and the numbers. A rebuild computes the \
         numbers anew in the same memory, for another step size. A step is the mean over \
         {TIMED_STEPS} steps from the start: of `desbrun` with inverse or factor and without its \
         correction of torques, and of `imex-euler` with CG (ε = {LOOSE}). A solve is the linear \
         system alone, from 0. Here direct solvers refine their solution once; in `desbrun` they \
         do not."
    )
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "A sheet hangs from two corners. It has structural springs and shear springs with a tenth \
         of their stiffness, all implicit, with d/m = 40 s⁻¹ and h = {STEP} s. Three solvers \
         solve A v = b with A = M + h² L_k + h L_c, one scalar matrix for all three coordinates: \
         the full inverse, a sparse Cholesky factor (rows ordered by AMD), and conjugate \
         gradients with IC(0). Operations are counted to leading order from the non-zeros. The \
         inverse takes n³ operations to compute and 6 n² to apply. The factor takes Σ c² to \
         compute, where c is the number of entries of a column, and 12 times its entries to \
         apply. A CG iteration takes one product with A, two triangular solves and five vector \
         operations. A solve is counted with one iteration more than the mean per step of a run \
         of one second at ε = {LOOSE}. To compare solutions, all solvers solve the same system, \
         CG to 1e-14. Then a run changes on the way; after each change the study compares the \
         running method with one that starts anew. In the series `one fabric`, k/m is 1e6/s² at \
         400 particles and grows with their number."
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let mut starts: Vec<Start> = Vec::new();
    for case in system::cases(&SIDES) {
        let start = Start::new(case.name(), move || case.spec());
        if starts.iter().all(|other| other.name() != start.name()) {
            starts.push(start);
        }
    }
    starts
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let cases = system::cases(if context.quick { &QUICK_SIDES } else { &SIDES });
    let solvers = cells(context, "solvers", &cases, system::solver)?;
    let changes = cells(context, "changes", &changes::METHODS, |(solver, method)| {
        changes::change(solver, method)
    })?;
    let facts = Facts { solvers: solvers.all()?, changes: changes.all()? };
    let mut hashes = BTreeMap::new();
    for case in &cases {
        hashes.insert(case.name(), system_hash(&case.spec()?));
    }
    let timings =
        if context.quick { None } else { Some(timed(context, "timings", &cases, time)?.all()?) };
    Ok(Measured { facts, timings, scenes: hashes, seed: None })
}

fn nanoseconds(begin: Instant) -> u64 {
    begin.elapsed().as_nanos() as u64
}

fn time(case: &Case) -> Result<TimingRow, HarnessError> {
    let problem = Problem::new(&case.spec()?, 0)?;
    let Simulation { system, state } = &problem.simulation;
    let choice = Choice::parse(&case.method(), &[])?;
    let mut row = TimingRow {
        particles: system.len(),
        solver: case.solver.to_owned(),
        series: case.series.to_owned(),
        method: choice.full_id(),
        setup_ns: Vec::new(),
        rebuild_ns: Vec::new(),
        step_ns: Vec::new(),
        solve_ns: Vec::new(),
    };
    for _ in 0..REPETITIONS {
        let begin = Instant::now();
        let mut solver = problem.solver(case.settings(LOOSE))?;
        row.setup_ns.push(nanoseconds(begin));
        let mut v = vec![Vec3::zeros(); system.len()];
        let begin = Instant::now();
        solver.solve(&problem.constraints, &problem.b, &mut v);
        row.solve_ns.push(nanoseconds(begin));
        let begin = Instant::now();
        solver.refresh(system, 0.5 * STEP)?;
        row.rebuild_ns.push(nanoseconds(begin));
        let mut state = state.clone();
        let mut stepper = Stepper::new(&choice, system, STEP)?;
        let begin = Instant::now();
        for _ in 0..TIMED_STEPS {
            stepper.step(system, &mut state)?;
        }
        row.step_ns.push(nanoseconds(begin) / TIMED_STEPS);
    }
    Ok(row)
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let Facts { solvers, changes } = facts;
    let solvers = solvers.iter().map(|solver| {
        let key = format!("{} {}, {}", solver.particles, solver.solver, solver.series);
        fact(key, solver.portable, solver)
    });
    let changes = changes
        .iter()
        .map(|change| fact(format!("changes {}", change.solver), change.portable, change));
    solvers.chain(changes).collect()
}
