//! Hard cases for the ledger of claims: methods in settings of their own, from one perturbed start
//! each.

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
    /// Greatest rise of the energy over what the scene sets free.
    pub(crate) gain: f64,
    /// Whether that is as little as a stable run may gain.
    pub(crate) is_stable: bool,
    /// Whether it ended before its time.
    pub(crate) is_over_budget: bool,
}

/// Runs methods (ids with settings) on the cases with these ids, undamped and damped, each run for
/// at most `budget` visits of a spring; one list a method.
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
