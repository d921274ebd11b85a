//! C24: updated CG needs fewer iterations than plain CG on the full system.

use super::runs::{Exact, error, track};
use super::scenes::{build, hanging};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::run::Simulation;
use crate::studies::short;
use drape_model::State;

pub(super) const CLAIM: Claim = Claim {
    id: "C24",
    section: "7",
    says: "updated CG needs fewer iterations than plain CG on the full system",
    criterion: "iterations at equal error",
    is_quick: false,
    test,
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
    stiffness: f64,
    updated: Option<u64>,
    full: Option<u64>,
    plain: Option<u64>,
}

fn test() -> Result<Finding, HarnessError> {
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
            let printed = format!("safeguard=paper,max_outer=2000,{scalar}");
            let updated = forms("imex-updated", &["0.05", "1e-2", "1e-3"], &printed);
            let full = forms("baraff-witkin", &["0.1", "1e-2", "1e-3"], block);
            let plain = forms("imex-euler", &["1e-2"], &format!("implicit=springs,{scalar}"));
            let updated = front(&start, &exact, &updated, &COUNTS)?;
            let full = front(&start, &exact, &full, &COUNTS)?;
            let plain = front(&start, &exact, &plain, &FINE)?;
            rows.extend(LEVELS.map(|level| Row {
                stiffness,
                label: format!("k/m = {stiffness:e}, error {level}, {name}"),
                updated: least(&updated, level),
                full: least(&full, level),
                plain: least(&plain, level),
            }));
        }
    }
    Ok(judge(&rows, reference))
}

/// Updated over full; a family that does not get there takes without end.
fn ratio(row: &Row) -> Option<f64> {
    match (row.updated, row.full) {
        (Some(updated), Some(full)) => Some(updated as f64 / full as f64),
        (Some(_), None) => Some(0.0),
        (None, Some(_)) => Some(f64::INFINITY),
        (None, None) => None,
    }
}

fn judge(rows: &[Row], reference: f64) -> Finding {
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
    let ratios: Vec<_> = rows.iter().filter_map(ratio).collect();
    let fewer = ratios.iter().filter(|ratio| **ratio < 1.0).count();
    let verdict = match ratios.len() {
        0 => Verdict::Undecided,
        all => Verdict::of(fewer == all),
    };
    let finite = || ratios.iter().filter(|ratio| ratio.is_finite() && **ratio > 0.0);
    let low = finite().fold(f64::INFINITY, |low, ratio| low.min(*ratio));
    let high = finite().fold(0.0_f64, |high, ratio| high.max(*ratio));
    let scalar: Vec<_> =
        rows.iter().filter_map(|row| Some(row.updated? as f64 / row.plain? as f64)).collect();
    let mut stiffnesses: Vec<_> = rows.iter().map(|row| row.stiffness).collect();
    stiffnesses.dedup();
    let tally = |stiffness: &f64| {
        let rows = rows.iter().filter(|row| row.stiffness == *stiffness);
        let ratios: Vec<_> = rows.filter_map(ratio).collect();
        let fewer = ratios.iter().filter(|ratio| **ratio < 1.0).count();
        format!("{fewer} of {} at k/m = {stiffness:e}", ratios.len())
    };
    let by_stiffness: Vec<_> = stiffnesses.iter().map(tally).collect();
    let against = scalar.iter().filter(|ratio| **ratio < 1.0).count();
    Finding {
        verdict,
        numbers,
        reason: format!(
            "At equal error updated CG as printed takes {} to {} times the iterations of plain CG on the full linearised system (3×3 \
             blocks, one Newton step), fewer in {fewer} of {} comparisons: {}. The number of its updates grows with θ, that of Newton's \
             steps does not. Against plain CG on its own scalar matrix, which locks and must take far smaller steps for the same motion, \
             it takes fewer in {against} of {}.",
            short(low),
            short(high),
            ratios.len(),
            by_stiffness.join(", "),
            scalar.len()
        ),
        repair: None,
        scenes: "a hanging sheet of 144 particles with shear 0.1 k, k/m = 1e5 to 1e8; error after 0.3 s against the true motion; h from \
                 0.03 s down, ε from 0.1 to 1e-3, the cheapest run that is good enough"
            .to_owned(),
        see: "work-precision.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_must_win_every_comparison_and_not_reaching_the_error_loses() {
        let row = |updated, full| Row {
            label: String::new(),
            stiffness: 1e6,
            updated,
            full,
            plain: None,
        };
        let of = |rows: &[Row]| judge(rows, 0.0).verdict;
        assert_eq!(of(&[row(Some(5), Some(6)), row(Some(5), None)]), Verdict::Confirmed);
        assert_eq!(of(&[row(Some(5), Some(6)), row(Some(7), Some(6))]), Verdict::Refuted);
        assert_eq!(of(&[row(None, Some(6))]), Verdict::Refuted);
        assert_eq!(of(&[row(None, None)]), Verdict::Undecided);
    }

    #[test]
    fn the_cheapest_run_that_is_good_enough_counts() {
        let front = vec![(0.2, 10), (0.05, 40), (0.01, 30)];
        assert_eq!(least(&front, 0.1), Some(30));
        assert_eq!(least(&front, 0.5), Some(10));
        assert_eq!(least(&front, 0.001), None);
    }
}
