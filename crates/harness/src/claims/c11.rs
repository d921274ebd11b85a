//! C11: the Jacobian of F2 does not contribute significantly.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C11",
    origin: Origin::Paper { section: "4" },
    says: "the Jacobian of F2 does not contribute significantly",
    criterion: "At rest ‖∂F2‖ is less than a tenth of ‖∂F1‖.",
    reads: &[
        "ratio, ",
        "mean fall in 0.3 s, k/m = 1e6, IMEX Euler, without ∂F2",
        "mean fall in 0.3 s, k/m = 1e6, Baraff-Witkin, with ∂F2 in the matrix",
    ],
    overturned_by: "Ratios that are all below 0.1 confirm it.",
    see: "locking-stiffness.svg",
    age: Age::SETTLED,
    judge,
    readings,
};

/// Ratio of the norms that all must stay below.
pub(crate) const LIMIT: f64 = 0.1;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let (least, most) = span(&evidence.values("ratio, ")?);
    let fall = |method: &str| evidence.value(&format!("mean fall in 0.3 s, k/m = 1e6, {method}"));
    let without = fall("IMEX Euler, without ∂F2")?;
    let with = fall("Baraff-Witkin, with ∂F2 in the matrix")?;
    let reason = format!(
        "The norm of ∂F2 is at least {} of that of ∂F1: it has the full stiffness across each \
         spring. There it cancels ∂F1, and without it a spring resists turning as it resists \
         stretching.",
        told(least)
    );
    let repair = format!(
        "With ∂F2 in the matrix the sheet falls {} m in 0.3 s, without it {} m.",
        told(with),
        told(without)
    );
    let is_met = most < LIMIT;
    Ok(Judgement::new(is_met, reason).repaired((!is_met).then_some(repair)))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let fall = |method: &str| evidence.value(&format!("mean fall in 0.3 s, k/m = 1e6, {method}"));
    let share = fall("IMEX Euler, without ∂F2")? / fall("Baraff-Witkin, with ∂F2 in the matrix")?;
    Ok(vec![Reading::new(
        "The motion decides: without ∂F2 the sheet falls by at least nine tenths as far as with it.",
        share >= 0.9,
        format!("it falls by {} of the way", told(share)),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn every_ratio_counts() {
        let verdict = |ratio| {
            let numbers = [
                ("ratio, a", 0.05),
                ("ratio, b", ratio),
                ("mean fall in 0.3 s, k/m = 1e6, IMEX Euler, without ∂F2", 0.1),
                ("mean fall in 0.3 s, k/m = 1e6, Baraff-Witkin, with ∂F2 in the matrix", 0.4),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.09), Ruling::Holds);
        assert_eq!(verdict(0.1), Ruling::Fails);
    }
}
