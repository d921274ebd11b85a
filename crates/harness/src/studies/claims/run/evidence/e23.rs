//! What is run for claim C23.

use super::runs::{track, true_motion, walk};
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c23::LIMIT;
use crate::run::Simulation;
use drape_integrator::SolveStatus;

pub(super) const TRIAL: Trial = Trial {
    id: "C23",
    scenes: || {
        "sheets of 64 and 144 particles with shear 0.1 k on their true motion after 0.1, 0.2 and \
         0.3 s, h = 0.01 s, all springs implicit, IC(0), from v_n; up to h²k/m = 100 also runs of \
         0.5 s with the extrapolated start"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const STEP: f64 = 0.01;
/// Most updates in a step: a count that is cut off there is a lower bound, far beyond the limit.
const CAP: u32 = 2000;
/// The `h²k/m` of the series.
const THETAS: [f64; 5] = [1.0, 10.0, 100.0, 1e3, 1e4];
/// Times at which a step is looked at on the true motion, s.
const TIMES: [f64; 3] = [0.1, 0.2, 0.3];

/// Iterations of one and the same step, plain and updated, from the old velocity.
fn one_step(start: &Simulation) -> Result<(u32, u32, bool), HarnessError> {
    let mut counts = [0; 2];
    let mut is_capped = false;
    let methods = [
        "imex-euler:norm=euclid,forcing_term=1e-4,start=last,implicit=springs".to_owned(),
        format!(
            "imex-updated:norm=euclid,forcing_term=1e-4,start=last,safeguard=paper,max_outer={CAP}"
        ),
    ];
    for (count, method) in counts.iter_mut().zip(&methods) {
        walk(
            start,
            method,
            STEP,
            1,
            |_, _| (),
            |_, report, _| {
                *count = report.cg_iterations;
                is_capped = report.solve != SolveStatus::Converged;
            },
        )?;
    }
    Ok((counts[0], counts[1], is_capped))
}

/// Updated over plain iterations at one `h²k/m`.
struct Row {
    theta: f64,
    /// Greatest ratio of a step from one and the same state.
    step: f64,
    /// Ratio of the sums over half a second, each on its own way; 0 where it was not run.
    run: f64,
    is_capped: bool,
}

fn row(theta: f64) -> Result<Row, HarnessError> {
    let stiffness = theta / (STEP * STEP);
    let mut row = Row { theta, step: 0.0, run: 0.0, is_capped: false };
    for side in [8, 12] {
        let mut sheet = hanging(side, stiffness, 40.0);
        sheet.shear = 0.1 * stiffness;
        let start = build(&sheet.spec()?)?;
        let mut at = start.clone();
        let mut last = 0.0;
        for time in TIMES {
            at.state = true_motion(&at, time - last, 0)?.state;
            last = time;
            let (plain, updated, is_capped) = one_step(&at)?;
            row.step = row.step.max(f64::from(updated) / f64::from(plain.max(1)));
            row.is_capped |= is_capped;
        }
        if theta <= 100.0 {
            let plain = "imex-euler:norm=euclid,forcing_term=1e-4,implicit=springs";
            let updated =
                "imex-updated:norm=euclid,forcing_term=1e-4,safeguard=paper,max_outer=2000";
            let count =
                |method| Ok::<_, HarnessError>(track(&start, method, STEP, 0.5, 0)?.iterations);
            row.run = row.run.max(count(updated)? as f64 / count(plain)? as f64);
        }
    }
    Ok(row)
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    Ok(numbers(&THETAS.into_iter().map(row).collect::<Result<Vec<_>, _>>()?))
}

fn numbers(rows: &[Row]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for Row { theta, step, run, is_capped } in rows {
        let bound = if *is_capped { " at least" } else { "" };
        let what = format!("updated / plain, same step, h²k/m = {theta:e}{bound}");
        numbers.push(Number::new(what, *step, "").against(LIMIT));
        if *run > 0.0 {
            numbers.push(
                Number::new(format!("updated / plain, run, h²k/m = {theta:e}"), *run, "")
                    .against(LIMIT),
            );
        }
    }
    numbers
}
