//! C05: Desbrun does not solve the equation completely; momentum is only about kept.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C05",
    origin: Origin::Paper { section: "3" },
    says: "Desbrun does not solve the equation completely; momentum is only about kept",
    criterion: "The error stays above 10 % of the motion as h → 0, or the angular momentum drifts \
                by more than 1 %.",
    reads: &[
        "error over motion, ",
        "angular drift in 1 s as published, ",
        "greatest drift of the momentum, as published",
    ],
    overturned_by: "Errors below 10 % in every scene, with drifts of at most 1 %, refute it.",
    see: "momentum-spin-left.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Error over the motion that the smallest step must reach.
pub(crate) const ERROR: f64 = 0.1;
/// Greatest accepted drift of the angular momentum in a second.
pub(crate) const DRIFT: f64 = 0.01;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let errors = evidence.series("error over motion, ", ", h = ")?;
    let drifts = evidence.values("angular drift in 1 s as published, ")?;
    let momentum = evidence.value("greatest drift of the momentum, as published")?;
    let is_stuck = |errors: &[f64]| errors.last().is_none_or(|last| *last >= ERROR);
    let stuck = errors.iter().filter(|(_, errors)| is_stuck(errors)).count();
    let drifting = drifts.iter().filter(|drift| **drift > DRIFT).count();
    let (low, high) = span(&drifts);
    let reason = format!(
        "The error stays above 10 % of the motion in {stuck} of {} scenes. The angular momentum \
         drifts by {} to {} in a second; linear momentum is kept to {}.",
        errors.len(),
        told(low),
        told(high),
        told(momentum)
    );
    Ok(Judgement::new(stuck > 0 || drifting > 0, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let errors = evidence.series("error over motion, ", ", h = ")?;
    let last: Vec<_> = errors.iter().filter_map(|(_, errors)| errors.last().copied()).collect();
    let (_, drift) = span(&evidence.values("angular drift in 1 s as published, ")?);
    let (least, most) = span(&last);
    Ok(vec![
        Reading::new(
            "First half: the error stays above 10 % of the motion in some scene as h → 0.",
            most >= ERROR,
            format!("{} to {} of the motion at the smallest step", told(least), told(most)),
        ),
        Reading::new(
            "Second half: angular momentum is kept approximately, to 10 % in a second.",
            drift <= 0.1,
            format!("up to {} is lost", told(drift)),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn either_half_of_the_criterion_confirms() {
        let verdict = |error, drift| {
            let numbers = [
                ("error over motion, a scene, h = 0.01 s", 0.9),
                ("error over motion, a scene, h = 0.001 s", error),
                ("angular drift in 1 s as published, a", drift),
                ("greatest drift of the momentum, as published", 0.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.01, 0.001), Ruling::Fails);
        assert_eq!(verdict(0.2, 0.001), Ruling::Holds);
        assert_eq!(verdict(0.01, 0.02), Ruling::Holds);
    }
}
