//! What is run for claim C02.

use super::atlas::{SCENES, Survey, survey};
use super::scenes::greatest;
use super::{Number, Trial};
use crate::HarnessError;

pub(super) const TRIAL: Trial = Trial {
    id: "C02",
    scenes: || format!("{SCENES}; {METHOD}"),
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const METHOD: &str = "imex-euler:norm=euclid,forcing_term=1e-10,implicit=springs,start=last";

fn evidence() -> Result<Vec<Number>, HarnessError> {
    Ok(numbers(&survey(METHOD)?))
}

fn numbers(runs: &[Survey]) -> Vec<Number> {
    let worst = greatest(runs.iter().map(|run| run.gain));
    let steps: u64 = runs.iter().map(|run| run.steps).sum();
    let rises: u64 = runs.iter().map(|run| run.rises).sum();
    let stable = runs.iter().filter(|run| run.verdict == drape_report::Verdict::Stable).count();
    let unfinished = runs.iter().filter(|run| run.is_over_budget).count();
    vec![
        Number::new("steps in which the energy rises by more than round-off", rises as f64, "")
            .against(0.0),
        Number::new("steps", steps as f64, ""),
        Number::new("greatest rise above the start over the energy set free", worst, ""),
        Number::new("stable runs", stable as f64, ""),
        Number::new("runs", runs.len() as f64, ""),
        Number::new("runs over budget", unfinished as f64, ""),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(rises: u64, is_over_budget: bool) -> Survey {
        let verdict = drape_report::Verdict::Stable;
        Survey { verdict, gain: 0.0, rises, steps: 200, is_over_budget }
    }

    #[test]
    fn rises_and_unfinished_runs_are_counted() {
        let numbers = numbers(&[run(0, false), run(1, false), run(2, true)]);
        let value = |what: &str| numbers.iter().find(|n| n.what == what).map(|n| n.value);
        let rises = "steps in which the energy rises by more than round-off";
        assert_eq!(value(rises), Some(3.0));
        assert_eq!(value("runs over budget"), Some(1.0));
    }
}
