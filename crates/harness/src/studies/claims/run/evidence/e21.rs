//! What is run for claim C21.

use super::runs::{free_edge, track, true_motion};
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c21::LIMIT;

pub(super) const TRIAL: Trial = Trial {
    id: "C21",
    scenes: || {
        "sheets of 100, 400 and 2704 particles that fall from two corners, k/m = 1e4 to 1e8, \
         damped and undamped, with and without shear; all springs implicit; way of the middle of \
         the free edge in 1 s"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

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

/// One sheet's retained motion: the way of the middle of the free edge within a second over that of
/// the true motion.
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
        plain: kept("imex-euler:norm=euclid,implicit=springs")?,
        exact_solve: kept("imex-euler:norm=euclid,implicit=springs,forcing_term=1e-10")?,
        // The repair: Algorithm 1 with safeguards and without its turn to Newton's method, which
        // would factorise.
        updated: if tension > 1e6 || side > 20 {
            f64::NAN
        } else {
            kept("imex-updated:newton_above=1e300,max_outer=100000")?
        },
    })
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    Ok(numbers(&SHEETS.into_iter().map(row).collect::<Result<Vec<_>, _>>()?))
}

fn numbers(rows: &[Row]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for row in rows {
        let number = Number::new(format!("plain, {}", row.label), row.plain, "");
        numbers.push(if row.is_stiff { number.against(LIMIT) } else { number });
        numbers.push(Number::new(format!("solved to 1e-10, {}", row.label), row.exact_solve, ""));
        if row.updated.is_finite() {
            numbers.push(Number::new(format!("updated, {}", row.label), row.updated, ""));
        }
    }
    numbers
}
