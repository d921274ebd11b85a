//! Experiment `claims`: what is run for the paper's claims and for expectations about later
//! methods.

mod atlas;
mod contest;
mod evidence;
mod general;
mod meshes;
mod runs;
mod scenes;

use crate::HarnessError;
use crate::claims::{Claim, Evidence, find, unknown};
use crate::facts::{Fact, fact};
use crate::run::starts::watch;
use crate::studies::claims::facts::{Facts, Row, Ruling, TimingRow};
use crate::studies::{Context, Measured, Start, cells, timed};
use drape_model::SystemSpec;
use evidence::{TRIALS, Trial};
use std::collections::BTreeMap;

/// How the timings are taken.
pub(super) fn timing() -> String {
    "Wall time of the work whose operations the facts count. One piece runs after the other on \
     one thread, and the median of the repetitions decides."
        .to_owned()
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "Each claim has a criterion, which reads recorded numbers. Where the paper's words allow \
     another reading, or the paper does not print a parameter that decides, the study also tests \
     further readings. A claim holds or fails if it does so under every reading. It depends if \
     readings disagree, and is undecided if the numbers cannot tell. The ledger states since when \
     each criterion stands. Counted work, which is the same on every machine, decides claims \
     about time; the ledger says where measured seconds disagree. Random numbers come from fixed \
     seeds."
        .to_owned()
}

/// The systems from which its runs start.
pub(super) fn starts() -> Vec<Start> {
    // Each claim builds its own scenes; the record describes them in words.
    Vec::new()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let chosen: Vec<_> = TRIALS.iter().filter(|trial| trial.is_quick || !context.quick).collect();
    let claims = cells(context, "tests", &chosen, |trial| row(trial))?.all()?;
    let timings = if context.quick { None } else { Some(seconds(context, &claims)?) };
    Ok(Measured { facts: Facts { claims }, timings, scenes: BTreeMap::new(), seed: None })
}

/// Measures one claim and judges it.
///
/// # Errors
/// [`HarnessError`] when a run is refused.
pub fn test(claim: &Claim) -> Result<Row, HarnessError> {
    let trial = TRIALS.iter().find(|trial| trial.id == claim.id);
    trial.map_or_else(|| Err(unknown(claim.id)), row)
}

/// As [`test()`], with the systems from which its runs start, the smallest first. What a claim takes
/// over from one that was tested before in this process is not started again.
///
/// # Errors
/// As [`test()`].
pub fn test_with_starts(claim: &Claim) -> Result<(Row, Vec<SystemSpec>), HarnessError> {
    let (row, systems) = watch(|| test(claim));
    Ok((row?, systems))
}

fn row(trial: &Trial) -> Result<Row, HarnessError> {
    let numbers = (trial.run)()?;
    let verdict = find(trial.id)?.judge(&Evidence::new(&numbers)).verdict;
    let Trial { id, scenes, portable, .. } = *trial;
    Ok(Row { id: id.to_owned(), verdict, numbers, scenes: scenes(), portable })
}

/// Times the claims about time.
fn seconds(context: &Context<'_>, claims: &[Row]) -> Result<Vec<TimingRow>, HarnessError> {
    let chosen: Vec<_> = TRIALS
        .iter()
        .zip(claims)
        .filter_map(|(trial, row)| Some((trial.id, row.verdict, trial.seconds?)))
        .collect();
    timed(context, "seconds", &chosen, |&(id, counted, measure)| {
        let (cases, number) = measure()?;
        // Without a limit the seconds cannot contradict the facts.
        let verdict = number.limit.map_or(counted, |limit| Ruling::of(number.value >= limit));
        Ok(TimingRow { id: id.to_owned(), cases, number, verdict })
    })?
    .all()
}

/// Its facts, as they are compared: the verdict of each claim, and each of its numbers.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let of = |row: &Row| {
        let mut bare = fact(row.id.clone(), row.portable, row);
        if let serde_json::Value::Object(values) = &mut bare.values {
            values.remove("numbers");
            values.remove("scenes");
        }
        let numbers = row.numbers.iter().filter(|number| number.is_compared);
        let key = |what: &str| format!("{} {what}", row.id);
        let mut facts = vec![bare];
        facts.extend(numbers.map(|number| fact(key(&number.what), row.portable, number)));
        facts
    };
    facts.claims.iter().flat_map(of).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::claims::all;
    use crate::studies::claims::facts::Number;

    #[test]
    fn numbers_of_the_machine_are_not_compared_nor_texts() {
        let row = Row {
            id: "C01".to_owned(),
            verdict: Ruling::Holds,
            numbers: vec![
                Number::new("a", 0.5, "m").against(1.0),
                Number::new("b", 3.0, "").of_machine(),
            ],
            scenes: "none".to_owned(),
            portable: true,
        };
        let facts = comparable(&Facts { claims: vec![row] });
        let keys: Vec<_> = facts.iter().map(|fact| fact.key.as_str()).collect();
        assert_eq!(keys, ["C01", "C01 a"]);
        assert_eq!(facts[0].values["verdict"], "holds");
        assert_eq!(facts[0].values["portable"], true);
        assert!(facts[0].values.get("scenes").is_none());
        assert_eq!(facts[1].values["value"], 0.5);
    }

    #[test]
    fn each_claim_has_its_trial() {
        let ids: Vec<_> = all().iter().map(|claim| claim.id).collect();
        assert_eq!(TRIALS.each_ref().map(|trial| trial.id).as_slice(), ids);
    }

    #[test]
    fn quick_claims_come_to_a_verdict_with_numbers_and_scenes() {
        for trial in TRIALS.iter().filter(|trial| trial.is_quick) {
            let row = row(trial).unwrap();
            let mut names: Vec<_> = row.numbers.iter().map(|number| &number.what).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), row.numbers.len(), "{}: two numbers of one name", row.id);
            let judgement = find(&row.id).unwrap().judge(&Evidence::new(&row.numbers));
            assert_eq!(judgement.verdict, row.verdict);
            assert!(!judgement.reason.is_empty() && !row.scenes.is_empty(), "{}", row.id);
        }
    }
}
