//! Experiment `claims`: the ledger of the paper's claims.

use crate::HarnessError;
use crate::claims::{Claim, all};
use crate::facts::{Fact, fact};
use crate::studies::claims::facts::{Facts, Row, TimingRow};
use crate::studies::{Context, Measured, cells, timed};
use std::collections::BTreeMap;

/// How the timings are taken.
pub(super) fn timing() -> String {
    "Wall time of the same work whose operations the facts count, one piece after the other on one \
                  thread; the median of the repetitions decides."
        .to_owned()
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "Each claim is a test of its own; its criterion was fixed before anything was measured and is not tuned. \
                 Confirmed: the criterion is met; refuted: it is not; undecided: the test cannot tell, and the reason says \
                 why. Claims about time are decided from counted work, which is the same on every machine; the \
                 measured seconds stand in the timings and must bear the verdict out. A random number, where one is \
                 drawn, comes from a seed that stands in the test."
            .to_owned()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let chosen: Vec<_> = all().iter().filter(|claim| claim.is_quick || !context.quick).collect();
    let claims = cells(context, "tests", &chosen, |claim| claim.test())?;
    let facts = Facts { claims };
    let timings = if context.quick { None } else { Some(seconds(context)?) };
    Ok(Measured { facts, timings, scenes: BTreeMap::new(), seed: None })
}

/// Times the claims about time.
fn seconds(context: &Context<'_>) -> Result<Vec<TimingRow>, HarnessError> {
    let chosen: Vec<_> = all().iter().filter(|claim| claim.has_seconds()).collect();
    let rows = timed(context, "seconds", &chosen, |claim: &&Claim| claim.seconds())?;
    Ok(rows.into_iter().flatten().collect())
}

/// Its facts, as they are compared: each claim, and each of its numbers.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let of = |row: &Row| {
        let mut bare = fact(row.id.clone(), row.portable, row);
        if let serde_json::Value::Object(values) = &mut bare.values {
            values.remove("numbers");
            if !row.portable {
                // Digits of numbers that passed through a library stand in these sentences.
                values.remove("reason");
                values.remove("repair");
            }
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
mod tests {
    use super::super::words::findings;
    use super::*;
    use crate::claims::Number;
    use crate::claims::Verdict;

    fn row(id: &str, verdict: Verdict, portable: bool) -> Row {
        Row {
            id: id.to_owned(),
            section: "1".to_owned(),
            says: "so".to_owned(),
            criterion: "a < 1".to_owned(),
            verdict,
            numbers: vec![
                Number::new("a", 0.5, "m").against(1.0),
                Number::new("b", 3.0, "").of_machine(),
            ],
            reason: "a is 0.5.".to_owned(),
            repair: (verdict == Verdict::Refuted).then(|| "do b.".to_owned()),
            scenes: "none".to_owned(),
            see: "claims.svg".to_owned(),
            portable,
        }
    }

    #[test]
    fn findings_follow_from_the_verdicts() {
        let rows =
            [("C01", Verdict::Confirmed), ("C02", Verdict::Refuted), ("C03", Verdict::Undecided)];
        let facts = Facts { claims: rows.map(|(id, v)| row(id, v, true)).to_vec() };
        let findings = findings(&facts);
        assert_eq!(
            findings[0],
            "Of 3 claims: 1 confirmed (C01); 1 refuted (C02); 1 undecided (C03)."
        );
        assert_eq!(findings[1], "C02, “so”, is refuted. a is 0.5. Repair: do b.");
        assert_eq!(findings.len(), 3);
    }

    #[test]
    fn numbers_of_the_machine_are_not_compared_nor_sentences_that_hold_rounded_digits() {
        let facts = |portable| {
            let facts = Facts { claims: vec![row("C01", Verdict::Confirmed, portable)] };
            comparable(&facts)
        };
        for portable in [true, false] {
            let facts = facts(portable);
            let keys: Vec<_> = facts.iter().map(|fact| fact.key.as_str()).collect();
            assert_eq!(keys, ["C01", "C01 a"]);
            assert_eq!(facts[0].values.get("reason").is_some(), portable);
            assert_eq!(facts[0].values["verdict"], "confirmed");
        }
    }
}
