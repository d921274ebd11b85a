//! C10: implicit tension alone suffices.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C10",
    origin: Origin::Paper { section: "4" },
    says: "implicit tension alone suffices",
    criterion: "Over h in [1e-4, 1], stable steps stay stable with explicit shear and bending at \
                ratios 1e-4 … 1, for plain and for updated CG.",
    reads: &[
        "stable with it in the matrix, ",
        "of these lost without, ",
        "least ratio that fails, ",
    ],
    overturned_by: "It is confirmed if no stable step is lost.",
    see: "stability-atlas.svg",
    age: Age::FIRST,
    judge,
    readings,
};

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let stable: f64 = evidence.values("stable with it in the matrix, ")?.iter().sum();
    let losses = evidence.rows("of these lost without, ")?;
    let lost: f64 = losses.iter().map(|(_, number)| number.value).sum();
    let at = |name: &str| match evidence.value(&format!("least ratio that fails, {name}")) {
        Ok(ratio) => format!("{name}: from {}", told(ratio)),
        Err(_) => format!("{name}: at none"),
    };
    let ratios: Vec<_> = losses.iter().map(|(name, _)| at(name)).collect();
    let reason = format!(
        "Explicit springs lose {lost} of {stable} stable settings, at these ratios of stiffness: \
         {}.",
        ratios.join("; ")
    );
    let repair = "Take all springs into the matrix: all steps that are lost here are stable then.";
    let is_met = lost == 0.0;
    Ok(Judgement::new(is_met, reason).repaired((!is_met).then(|| repair.to_owned())))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let ratios = evidence.values("least ratio that fails, ").unwrap_or_default();
    let (least, _) = span(&ratios);
    let seen = || format!("the least ratio that fails is {}", told(least));
    Ok(vec![
        Reading::new(
            "“Several magnitudes” less stiff are two: ratios of at most 1e-2.",
            least > 1e-2,
            seen(),
        ),
        Reading::new(
            "“Several magnitudes” less stiff are three: ratios of at most 1e-3.",
            least > 1e-3,
            seen(),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn one_lost_step_refutes_and_the_least_ratio_is_told() {
        let name = "plain CG, explicit shear";
        let judged = |lost: f64, ratio: Option<f64>| {
            let (stable, without) = (
                format!("stable with it in the matrix, {name}"),
                format!("of these lost without, {name}"),
            );
            let least = format!("least ratio that fails, {name}");
            let mut numbers = vec![(stable.as_str(), 2.0), (without.as_str(), lost)];
            numbers.extend(ratio.map(|ratio| (least.as_str(), ratio)));
            judged(&CLAIM, &numbers)
        };
        assert_eq!(judged(0.0, None).verdict, Ruling::Holds);
        let judgement = judged(2.0, Some(0.5));
        assert_eq!(judgement.verdict, Ruling::Fails);
        assert!(judgement.repair.is_some());
        assert!(judgement.reason.contains("plain CG, explicit shear: from 0.5"));
    }
}
