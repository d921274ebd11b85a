//! Hard cases for the ledger of claims: methods with chosen settings, each from one perturbed
//! start.

use super::cell::{Stage, Tally};
use super::scenes;
use crate::HarnessError;
use crate::methods::Choice;
use crate::run::Runner;
use drape_report::Verdict;
use rayon::prelude::*;

/// What a method did on a case.
#[derive(Clone, Debug)]
pub(crate) struct HardCase {
    /// Greatest rise of the energy, over the energy that the scene sets free.
    pub(crate) gain: f64,
    /// Whether the verdict is `stable`.
    pub(crate) is_stable: bool,
    /// Whether the run exceeded its budget.
    pub(crate) is_over_budget: bool,
}

/// Runs `methods` (ids with settings) on the cases with these `ids`, undamped and damped. Each run
/// may take at most `budget` visits of a spring. Returns one list of results for each method.
pub(crate) fn survey(
    methods: &[&str],
    ids: &[&str],
    budget: f64,
) -> Result<Vec<Vec<HardCase>>, HarnessError> {
    let choices = methods.iter().map(|method| Ok(Choice::parse(method, &[])?));
    let choices = choices.collect::<Result<Vec<_>, HarnessError>>()?;
    let cases = scenes::all();
    let settings: Vec<_> = cases
        .iter()
        .filter(|case| ids.contains(&case.id))
        .flat_map(|case| [false, true].map(|is_damped| (case, is_damped)))
        .collect();
    let of_case = |&(case, is_damped): &(&scenes::Case, bool)| {
        let stage = Stage::new(case, is_damped)?;
        let of_choice = |choice: &Choice| {
            let runner = Runner::by(choice, &case.setup.schedule);
            let runner = runner.reference(stage.reference.energy).budget(budget);
            let run = runner.count(&stage.starts[0])?;
            let mut tally = Tally::default();
            tally.add(&run, stage.reference);
            Ok(HardCase {
                gain: tally.gain,
                is_stable: tally.verdict == Some(Verdict::Stable),
                is_over_budget: tally.is_over_budget,
            })
        };
        choices.iter().map(of_choice).collect::<Result<Vec<_>, HarnessError>>()
    };
    let rows: Vec<Vec<HardCase>> =
        settings.par_iter().with_max_len(1).map(of_case).collect::<Result<_, _>>()?;
    let column = |n: usize| rows.iter().map(|row| row[n].clone()).collect();
    Ok((0..methods.len()).map(column).collect())
}
