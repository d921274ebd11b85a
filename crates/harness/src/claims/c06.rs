//! C06: a precomputed inverse forbids changing h and k.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C06",
    origin: Origin::Paper { section: "3" },
    says: "a precomputed inverse forbids changing h and k",
    criterion: "Rebuilding the dense inverse and sparse Cholesky costs at least 20 steps each. The \
                published dense inverse decides.",
    reads: &[
        "steps that a rebuild costs, dense inverse, ",
        "steps that a rebuild costs, sparse Cholesky, ",
    ],
    overturned_by: "A mesh on which rebuilding the dense inverse costs less than 20 steps refutes \
                    it.",
    see: "inverse-cost.svg",
    age: Age::changed(
        "10e556a",
        "named the dense inverse as the one that decides; the verdict is the same",
    ),
    judge,
    readings,
};

/// Least cost of a rebuild, in steps.
pub(crate) const LIMIT: f64 = 20.0;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let (low, high) = span(&evidence.values("steps that a rebuild costs, dense inverse, ")?);
    let (least, most) = span(&evidence.values("steps that a rebuild costs, sparse Cholesky, ")?);
    let factor = if most < LIMIT { "refuted for" } else { "not refuted for" };
    let reason = format!(
        "Rebuilding the dense inverse costs as much as {} to {} steps. The claim is {factor} a \
         sparse Cholesky factor, which costs {} to {} steps.",
        told(low),
        told(high),
        told(least),
        told(most)
    );
    let every = most.ceil().max(1.0);
    let repair =
        format!("A sparse factor may be rebuilt every {every} steps at twice the cost at most.");
    Ok(Judgement::new(low >= LIMIT, reason).repaired((most < LIMIT).then_some(repair)))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let (least, most) = span(&evidence.values("steps that a rebuild costs, sparse Cholesky, ")?);
    Ok(vec![Reading::new(
        "A sparse Cholesky factor stands for the inverse: its rebuild costs at least 20 steps.",
        least >= LIMIT,
        format!("{} to {} steps", told(least), told(most)),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn the_published_inverse_decides_and_the_factor_is_told() {
        let judged = |dense, sparse| {
            let numbers = [
                ("steps that a rebuild costs, dense inverse, a", dense),
                ("steps that a rebuild costs, dense inverse, b", 400.0),
                ("steps that a rebuild costs, sparse Cholesky, a", 2.0),
                ("steps that a rebuild costs, sparse Cholesky, b", sparse),
            ];
            judged(&CLAIM, &numbers)
        };
        let judgement = judged(30.0, 5.0);
        assert_eq!(judgement.verdict, Ruling::Holds);
        assert!(judgement.reason.contains("refuted for a sparse") && judgement.repair.is_some());
        assert_eq!(judged(19.0, 5.0).verdict, Ruling::Fails);
        assert!(judged(30.0, 25.0).repair.is_none());
    }
}
