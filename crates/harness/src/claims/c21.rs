//! C21: without updates the motion nearly stops at very high stiffness.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C21",
    origin: Origin::Paper { section: "7" },
    says: "without updates the motion nearly stops at very high stiffness",
    criterion: "At k/m ≥ 1e6 and h = 0.01 s less than half of the motion is left.",
    reads: &["plain, ", "solved to 1e-10, ", "updated, "],
    overturned_by: "A stiff sheet that keeps half of its motion refutes it.",
    see: "locking-stiffness.svg",
    age: Age::FIRST,
    judge,
    readings: sole,
};

/// Share of the motion below which it nearly stops; the limit marks the stiff sheets.
pub(crate) const LIMIT: f64 = 0.5;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let (mut plain, mut tight, mut updated) = (Vec::new(), Vec::new(), Vec::new());
    let repaired = evidence.rows("updated, ")?;
    for (sheet, number) in evidence.rows("plain, ")? {
        let exact = evidence.value(&format!("solved to 1e-10, {sheet}"))?;
        if number.limit.is_some() {
            plain.push(number.value);
            tight.push(exact);
            let here = repaired.iter().filter(|(other, _)| *other == sheet);
            updated.extend(here.map(|(_, number)| number.value));
        }
    }
    let ((least, greatest), (_, exact)) = (span(&plain), span(&tight));
    let reason = format!(
        "Plain IMEX Euler keeps {} to {} of the motion, and at most {} when it is solved to 1e-10: \
         the step brakes, not the solver. With updates at least {} is kept.",
        told(least),
        told(greatest),
        told(exact),
        told(span(&updated).0)
    );
    Ok(Judgement::new(greatest.max(exact) < LIMIT, reason))
}

#[cfg(test)]
mod tests {
    use super::super::{Number, Ruling};
    use super::*;

    #[test]
    fn one_stiff_sheet_that_moves_refutes_it_and_soft_ones_do_not_count() {
        let verdict = |stiff, tight| {
            let new = |what: &str, value| Number::new(what, value, "");
            let numbers = [
                new("plain, soft", 0.9),
                new("solved to 1e-10, soft", 0.9),
                new("plain, stiff", stiff).against(LIMIT),
                new("solved to 1e-10, stiff", tight),
                new("updated, stiff", 1.0),
            ];
            CLAIM.judge(&Evidence::new(&numbers)).verdict
        };
        assert_eq!(verdict(0.1, 0.1), Ruling::Holds);
        assert_eq!(verdict(0.6, 0.1), Ruling::Fails);
        assert_eq!(verdict(0.1, 0.6), Ruling::Fails);
    }
}
