//! C21: without updates the motion nearly stops at very high stiffness.

use super::runs::{free_edge, track, true_motion};
use super::scenes::{build, hanging};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::studies::short;

pub(super) const CLAIM: Claim = Claim {
    id: "C21",
    section: "7",
    says: "without updates the motion nearly stops at very high stiffness",
    criterion: "retained motion < 0.5 at k/m ≥ 1e6, h = 0.01",
    is_quick: false,
    test,
    seconds: None,
};

const LIMIT: f64 = 0.5;
const STEP: f64 = 0.01;

/// Particles a side, stiffness over mass (1/s²), damping over mass (1/s), shear over tension.
const SHEETS: [(u32, f64, f64, f64); 8] = [
    (20, 1e4, 40.0, 0.1),
    (20, 1e6, 40.0, 0.1),
    (20, 1e6, 0.0, 0.1),
    (20, 1e6, 40.0, 0.0),
    (10, 1e6, 40.0, 0.1),
    (52, 1e6, 40.0, 0.1),
    (20, 1e7, 40.0, 0.1),
    (10, 1e8, 40.0, 0.1),
];

/// One sheet's retained motion: the way of the middle of the free edge within a second over that of the true motion.
struct Row {
    label: String,
    is_stiff: bool,
    plain: f64,
    exact_solve: f64,
    updated: f64,
}

fn row((side, tension, damping, shear): (u32, f64, f64, f64)) -> Result<Row, HarnessError> {
    let mut sheet = hanging(side, tension, damping);
    sheet.shear = shear * tension;
    let spec = sheet.spec()?;
    let (start, tracked) = (build(&spec)?, free_edge(&spec));
    let exact = true_motion(&start, 1.0, tracked)?.path;
    let kept = |method: &str| {
        Ok::<_, HarnessError>(track(&start, method, STEP, 1.0, tracked)?.path / exact)
    };
    let is_stiff = tension >= 1e6;
    Ok(Row {
        label: format!("n = {}, k/m = {tension:e}, d/m = {damping}, shear {shear} k", side * side),
        is_stiff,
        plain: kept("imex-euler:implicit=springs")?,
        exact_solve: kept("imex-euler:implicit=springs,forcing_term=1e-10")?,
        // The repair: Algorithm 1 with safeguards and without its turn to Newton's method, which would factorise.
        updated: if tension > 1e6 || side > 20 {
            f64::NAN
        } else {
            kept("imex-updated:newton_above=1e300,max_outer=100000")?
        },
    })
}

fn test() -> Result<Finding, HarnessError> {
    Ok(judge(&SHEETS.into_iter().map(row).collect::<Result<Vec<_>, _>>()?))
}

fn judge(rows: &[Row]) -> Finding {
    let mut numbers = Vec::new();
    for row in rows {
        let number = Number::new(format!("plain, {}", row.label), row.plain, "");
        numbers.push(if row.is_stiff { number.against(LIMIT) } else { number });
        numbers.push(Number::new(format!("solved to 1e-10, {}", row.label), row.exact_solve, ""));
        if row.updated.is_finite() {
            numbers.push(Number::new(format!("updated, {}", row.label), row.updated, ""));
        }
    }
    let stiff = || rows.iter().filter(|row| row.is_stiff);
    let greatest = stiff().fold(0.0_f64, |most, row| most.max(row.plain).max(row.exact_solve));
    let least = stiff().fold(f64::INFINITY, |least, row| least.min(row.plain));
    let updated = stiff().map(|row| row.updated).filter(|kept| kept.is_finite());
    let updated = updated.fold(f64::INFINITY, f64::min);
    Finding {
        verdict: Verdict::of(greatest < LIMIT),
        numbers,
        reason: format!(
            "At k/m ≥ 1e6 and h = 0.01 s plain IMEX Euler keeps {} to {} of the way that the true motion goes within a second, \
             whether solved to 1e-3 or to 1e-10. It is the step, not the solver, that brakes: the matrix resists motion across \
             a spring with the whole stiffness, as a damper of h k would; with updates at least {} is kept.",
            short(least),
            short(greatest),
            short(updated)
        ),
        repair: None,
        scenes: "sheets of 100, 400 and 2704 particles that fall from two corners, k/m = 1e4 to 1e8, damped and undamped, with and \
                 without shear; all springs implicit; way of the middle of the free edge in 1 s"
            .to_owned(),
        see: "locking-stiffness.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_stiff_sheet_that_moves_refutes_it_and_soft_ones_do_not_count() {
        let row = |is_stiff, plain| Row {
            label: String::new(),
            is_stiff,
            plain,
            exact_solve: plain,
            updated: 1.0,
        };
        assert_eq!(judge(&[row(false, 0.9), row(true, 0.1)]).verdict, Verdict::Confirmed);
        assert_eq!(judge(&[row(true, 0.6), row(true, 0.1)]).verdict, Verdict::Refuted);
    }
}
