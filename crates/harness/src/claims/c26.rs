//! C26: iterations grow with stiffness; a smaller step need not mean more.

use super::{Age, Claim, Evidence, Judgement, Missing, Number, Origin, Reading, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C26",
    origin: Origin::Paper { section: "8" },
    says: "iterations grow with stiffness; a smaller step need not mean more",
    criterion: "Iterations a step are monotone in k/m, and their total over a second is not \
                monotone in h.",
    reads: &[
        "they grow up to k/m, ",
        "total not monotone in h (1: yes), ",
        "way of a corner, stiffest over softest, ",
    ],
    overturned_by: "Iterations that grow with k/m in every series confirm it.",
    see: "cg-vs-stiffness.svg",
    age: Age::FIRST,
    judge,
    readings,
};

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let growth = evidence.rows("they grow up to k/m, ")?;
    let mixed = evidence.values("total not monotone in h (1: yes), ")?;
    // The limit is the greatest stiffness of the series.
    let grows = |number: &Number| number.limit.is_some_and(|end| number.value >= end);
    let growing = growth.iter().filter(|(_, number)| grows(number)).count();
    let not_monotone = mixed.iter().filter(|mixed| **mixed > 0.0).count();
    let mut way = 1.0_f64;
    for (series, _) in growth.iter().filter(|(_, number)| !grows(number)) {
        let what = format!("way of a corner, stiffest over softest, {series}");
        way = way.min(evidence.value(&what)?);
    }
    let reason = format!(
        "Iterations a step grow throughout in {growing} of {} series; in the others the cloth \
         locks and a corner keeps as little as {} of its way. The total is not monotone in h in \
         {not_monotone} of {}.",
        growth.len(),
        told(way),
        mixed.len()
    );
    Ok(Judgement::new(growing == growth.len() && not_monotone > 0, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let growth = evidence.rows("they grow up to k/m, ")?;
    let grows = |number: &Number| number.limit.is_some_and(|end| number.value >= end);
    let reading = |asks: &'static str, form: &str| -> Result<Reading, Missing> {
        let own: Vec<_> = growth.iter().filter(|(of, _)| of.ends_with(form)).collect();
        let growing = own.iter().filter(|(_, number)| grows(number)).count();
        let mut mixed = 0.0;
        for (of, _) in &own {
            mixed += evidence.value(&format!("total not monotone in h (1: yes), {of}"))?;
        }
        let seen = format!("they grow throughout in {growing} of {} scenes", own.len());
        Ok(Reading::new(asks, growing == own.len() && mixed > 0.0, seen))
    };
    Ok(vec![
        reading("Of Algorithm 1, with updates, alone.", ", updated")?,
        reading("Of the plain iteration at ε = 1e-3 alone.", ", plain, ε = 1e-3")?,
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, ruled};
    use super::*;

    #[test]
    fn growth_must_be_general_and_one_exception_in_the_step_is_enough() {
        let verdict = |grows_to, mixed| {
            let numbers = [
                ("they grow up to k/m, a", 1e4, 1e4),
                ("they grow up to k/m, b", grows_to, 1e4),
                ("total not monotone in h (1: yes), a", mixed, 0.0),
                ("total not monotone in h (1: yes), b", 0.0, 0.0),
                ("way of a corner, stiffest over softest, b", 0.1, 0.0),
            ];
            ruled(&CLAIM, &numbers)
        };
        assert_eq!(verdict(1e4, 1.0), Ruling::Holds);
        assert_eq!(verdict(1e4, 0.0), Ruling::Fails);
        assert_eq!(verdict(1e3, 1.0), Ruling::Fails);
    }
}
