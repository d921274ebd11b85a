//! What is run for claim C18.

use super::runs::{Exact, error, walk};
use super::scenes::{build, greatest, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use crate::run::Simulation;
use crate::studies::sheet::MASS;
use drape_integrator::{
    Implicit, LaplacianSolver, LinearSettings, PreconditionerKind, SolverKind, Split, StopNorm,
    Weights, hold_pins,
};
use drape_model::{PieceSpec, State, Vec3};
use drape_solvers::Constraints;

pub(super) const TRIAL: Trial = Trial {
    id: "C18",
    scenes: || {
        format!(
            "hanging sheets of {SIDE} × {SIDE} particles, springs 10 or 100 times as stiff beyond \
             2 %, a tenth in compression, {DURATION} s; reference: leapfrog"
        )
    },
    portable: true,
    is_quick: true,
    run: evidence,
    seconds: None,
};

/// Particles along each edge.
const SIDE: u32 = 8;
/// Where the steep piece begins.
const STRAIN: f64 = 0.02;
const DURATION: f64 = 0.4;
/// Stiffness over mass of the first piece, 1/s²; slope of the second over it; step, s.
const CASES: [(f64, f64, f64); 5] = [
    (1e3, 10.0, 0.01),
    (1e3, 10.0, 0.0025),
    (1e3, 100.0, 0.01),
    (1e3, 100.0, 0.0025),
    (1e4, 100.0, 0.01),
];

/// A sheet that hangs by two corners, on springs that are `ratio` times as stiff beyond 2 % and a
/// tenth as stiff in compression.
fn sheet(stiffness: f64, ratio: f64) -> Result<Simulation, HarnessError> {
    let mut spec = hanging(SIDE, stiffness, 40.0).spec()?;
    let piece =
        |up_to_strain, slope: f64| PieceSpec { up_to_strain, stiffness_n_per_m: slope * MASS };
    for spring in &mut spec.springs {
        spring.pieces = [piece(Some(STRAIN), stiffness), piece(None, ratio * stiffness)].into();
        spring.stiffness_n_per_m = spring.pieces[0].stiffness_n_per_m;
    }
    build(&spec)
}

/// IMEX Euler with the matrix of the slopes at the start, kept throughout; the right-hand side has
/// all forces as they are.
fn kept_from_the_start(start: &Simulation, h: f64) -> Result<State, HarnessError> {
    let Simulation { system, state } = start;
    let settings = LinearSettings {
        forcing_term: 1e-10,
        preconditioner: PreconditionerKind::Ic0,
        norm: StopNorm::Euclid,
        solver: SolverKind::Cg,
        rebuild_every_step: false,
    };
    let (implicit, weights) = (Implicit::Springs, Weights::StiffnessAndDamping);
    let mut linear =
        LaplacianSolver::with_split(system, implicit, weights, settings, Split::Paper, h)?;
    linear.refresh_at(system, h, &state.x)?;
    let mut constraints = Constraints::free(system.len());
    hold_pins(system, &mut constraints);
    let mut state = state.clone();
    let mut b = vec![Vec3::zeros(); system.len()];
    for _ in 0..steps(h) {
        implicit.write_impulse(system, &state, h, &mut b);
        linear.solve(&constraints, &b, &mut state.v);
        state.x.iter_mut().zip(&state.v).for_each(|(x, v)| *x += v * h);
        if !state.is_finite() {
            break;
        }
    }
    Ok(state)
}

fn steps(h: f64) -> u64 {
    (DURATION / h).round() as u64
}

/// Last state of a run of IMEX Euler, all springs implicit, solved to the end, and how often the
/// matrix changed.
fn with_split(start: &Simulation, split: &str, h: f64) -> Result<(State, u64), HarnessError> {
    let method =
        format!("imex-euler:norm=euclid,implicit=springs,forcing_term=1e-10,split={split}");
    let mut rebuilt = 0;
    let end = walk(
        start,
        &method,
        h,
        steps(h),
        |_, _| (),
        |_, report, _| {
            rebuilt += u64::from(report.setups.stiffness);
        },
    )?;
    Ok((end, rebuilt))
}

/// Every other way of treating the springs is the same in all runs: only the matrix differs.
fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    let (mut steepest, mut first) = (Vec::new(), Vec::new());
    for (stiffness, ratio, h) in CASES {
        let start = sheet(stiffness, ratio)?;
        let exact = Exact::new(&start, DURATION)?;
        let off = |end: &State| error(&start, end, &exact.state);
        let (end, changes) = with_split(&start, "paper", h)?;
        let rebuilt = off(&end);
        let constant = off(&with_split(&start, "majorant", h)?.0);
        let begun = off(&kept_from_the_start(&start, h)?);
        steepest.push(constant / rebuilt);
        first.push(begun / rebuilt);
        let case = format!("k/m = {stiffness:e} then × {ratio}, h = {h} s");
        for (what, value) in [
            ("error, matrix of the present slopes", rebuilt),
            ("error, kept with the steepest slopes", constant),
            ("error, kept with the slopes at the start", begun),
            ("doubt about the reference", exact.doubt),
        ] {
            numbers.push(Number::new(format!("{what}; {case}"), value, ""));
        }
        let part = changes as f64 / steps(h) as f64;
        numbers.push(Number::new(format!("new matrices a step; {case}"), part, ""));
    }
    let (steepest, first) = (greatest(steepest), greatest(first));
    numbers.push(Number::new(
        "greatest error over that of setting up, steepest slopes",
        steepest,
        "",
    ));
    numbers.push(Number::new(
        "greatest error over that of setting up, slopes at the start",
        first,
        "",
    ));
    Ok(numbers)
}
