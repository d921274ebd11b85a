//! C02: the implicit method's stability is nearly kept by IMEX.

use super::atlas::{SCENES, Survey, survey, told};
use super::scenes::greatest;
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::studies::short;

pub(super) const CLAIM: Claim = Claim {
    id: "C02",
    section: "2.2",
    says: "the implicit method's stability is nearly kept by IMEX",
    criterion: "no energy growth over the stability atlas for IMEX Euler, solved to 1e-10",
    is_quick: false,
    test,
    seconds: None,
};

const METHOD: &str = "imex-euler:forcing_term=1e-10,implicit=springs,start=last";

fn test() -> Result<Finding, HarnessError> {
    Ok(judge(&survey(METHOD)?))
}

fn judge(runs: &[Survey]) -> Finding {
    let growing: Vec<_> = runs.iter().filter(|run| run.rises > 0).collect();
    let worst = greatest(runs.iter().map(|run| run.gain));
    let steps: u64 = runs.iter().map(|run| run.steps).sum();
    let rises: u64 = runs.iter().map(|run| run.rises).sum();
    let stable = runs.iter().filter(|run| run.verdict == drape_report::Verdict::Stable).count();
    let unfinished = runs.iter().filter(|run| run.is_over_budget).count();
    let seen = match growing.first() {
        None => format!("The energy rises in none of {steps} steps."),
        Some(run) => {
            format!("The energy rises in {rises} of {steps} steps, first at: {}.", told(&run.place))
        }
    };
    Finding {
        verdict: match (growing.len(), unfinished) {
            (0, 0) => Verdict::Confirmed,
            (0, _) => Verdict::Undecided,
            _ => Verdict::Refuted,
        },
        numbers: vec![
            Number::new("steps in which the energy rises by more than round-off", rises as f64, "")
                .against(0.0),
            Number::new("steps", steps as f64, ""),
            Number::new("greatest rise above the start over the energy set free", worst, ""),
            Number::new("stable runs", stable as f64, ""),
            Number::new("runs", runs.len() as f64, ""),
            Number::new("runs over budget", unfinished as f64, ""),
        ],
        reason: format!(
            "{seen} That is more than the paper asks for: with all springs in the matrix and an exact solve each step gives up \
             at least ½‖v₊ − v‖²_M (convex splitting), for every h and k; the greatest rise above the start is {} of the \
             energy set free.",
            short(worst)
        ),
        repair: None,
        scenes: format!("{SCENES}; {METHOD}"),
        see: "stability-atlas.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::super::atlas::places;
    use super::*;

    fn run(rises: u64, is_over_budget: bool) -> Survey {
        let place = places()[0];
        let verdict = drape_report::Verdict::Stable;
        Survey { place, verdict, gain: 0.0, rises, steps: 200, is_over_budget }
    }

    #[test]
    fn one_rise_refutes_and_what_was_not_run_leaves_it_open() {
        assert_eq!(judge(&[run(0, false), run(0, false)]).verdict, Verdict::Confirmed);
        assert_eq!(judge(&[run(0, false), run(1, false)]).verdict, Verdict::Refuted);
        assert_eq!(judge(&[run(0, true)]).verdict, Verdict::Undecided);
    }
}
