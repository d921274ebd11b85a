//! What is run for claim C24.

use super::runs::{Exact, error, track};
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use crate::run::Simulation;
use drape_model::State;

pub(super) const TRIAL: Trial = Trial {
    id: "C24",
    scenes: || {
        "a hanging sheet of 144 particles with shear 0.1 k, k/m = 1e5 to 1e8; error after 0.3 s \
         against the true motion; h from 0.03 s down, ε from 0.1 to 1e-3, the cheapest run that is \
         good enough"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// Simulated time, s: the sheet is on its way down.
const SPAN: f64 = 0.3;
/// Errors over the motion at which iterations are compared.
const LEVELS: [f64; 3] = [0.1, 0.05, 0.02];
/// Steps within the span.
const COUNTS: [u32; 7] = [10, 20, 30, 60, 120, 240, 480];
/// Steps of plain IMEX Euler, which needs smaller ones.
const FINE: [u32; 5] = [480, 1200, 3000, 7500, 15000];

/// What a family of runs reaches: error and iterations of each.
type Front = Vec<(f64, u64)>;

/// Least iterations of a run with at most this error.
fn least(front: &Front, level: f64) -> Option<u64> {
    front.iter().filter(|run| run.0 <= level).map(|run| run.1).min()
}

fn front(
    start: &Simulation,
    exact: &State,
    forms: &[String],
    counts: &[u32],
) -> Result<Front, HarnessError> {
    let mut front = Vec::new();
    for form in forms {
        for &count in counts {
            let run = track(start, form, SPAN / f64::from(count), SPAN, 0)?;
            front.push((error(start, &run.state, exact), run.iterations));
        }
    }
    Ok(front)
}

fn forms(id: &str, terms: &[&str], rest: &str) -> Vec<String> {
    terms.iter().map(|term| format!("{id}:forcing_term={term},{rest}")).collect()
}

/// Iterations of the three families at one stiffness and one error.
struct Row {
    label: String,
    updated: Option<u64>,
    full: Option<u64>,
    plain: Option<u64>,
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let (mut rows, mut reference) = (Vec::new(), 0.0_f64);
    for stiffness in [1e5, 1e6, 1e7, 1e8] {
        let mut sheet = hanging(12, stiffness, 40.0);
        sheet.shear = 0.1 * stiffness;
        let start = build(&sheet.spec()?)?;
        let Exact { state: exact, doubt } = Exact::new(&start, SPAN)?;
        reference = reference.max(doubt);
        for bare in [true, false] {
            let (scalar, block, name) = if bare {
                ("preconditioner=none", "preconditioner=none", "no preconditioner")
            } else {
                ("preconditioner=ic0", "preconditioner=block-jacobi", "IC(0) / block Jacobi")
            };
            let printed = format!("norm=euclid,safeguard=paper,max_outer=2000,{scalar}");
            let updated = forms("imex-updated", &["0.05", "1e-2", "1e-3"], &printed);
            let full = forms("baraff-witkin", &["0.1", "1e-2", "1e-3"], block);
            let plain =
                forms("imex-euler", &["1e-2"], &format!("norm=euclid,implicit=springs,{scalar}"));
            let updated = front(&start, &exact, &updated, &COUNTS)?;
            let full = front(&start, &exact, &full, &COUNTS)?;
            let plain = front(&start, &exact, &plain, &FINE)?;
            rows.extend(LEVELS.map(|level| Row {
                label: format!("k/m = {stiffness:e}, error {level}, {name}"),
                updated: least(&updated, level),
                full: least(&full, level),
                plain: least(&plain, level),
            }));
        }
    }
    Ok(numbers(&rows, reference))
}

fn numbers(rows: &[Row], reference: f64) -> Vec<Number> {
    let mut numbers = Vec::new();
    for row in rows {
        for (name, count) in
            [("updated", row.updated), ("full system", row.full), ("plain IMEX", row.plain)]
        {
            let Some(count) = count else { continue };
            numbers.push(Number::new(format!("{name}, {}", row.label), count as f64, ""));
        }
    }
    numbers.push(Number::new("reference against twice its step, over the motion", reference, ""));
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_run_that_is_good_enough_counts() {
        let front = vec![(0.2, 10), (0.05, 40), (0.01, 30)];
        assert_eq!(least(&front, 0.1), Some(30));
        assert_eq!(least(&front, 0.5), Some(10));
        assert_eq!(least(&front, 0.001), None);
    }
}
