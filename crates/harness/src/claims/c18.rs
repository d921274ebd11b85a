//! C18: in general the matrix must be set up each step.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, Ruling, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C18",
    origin: Origin::Paper { section: "5" },
    says: "in general the matrix must be set up each step",
    criterion: "With piecewise-linear springs, keeping either matrix doubles the error on some \
                sheet. Refuted if one that is kept is nowhere off by 10 % more.",
    reads: &[
        "greatest error over that of setting up, steepest slopes",
        "greatest error over that of setting up, slopes at the start",
        "error, kept with the slopes at the start; ",
        "error, matrix of the present slopes; ",
    ],
    overturned_by: "It is confirmed if either kept matrix more than doubles the error on some \
                    sheet.",
    see: "claims.svg",
    age: Age::changed("dc79232", "had no threshold before; the verdict is the same"),
    judge,
    readings,
};

/// Keeping the matrix costs accuracy beyond the first ratio of errors, and none below the second.
const MUST: f64 = 2.0;
const NEED_NOT: f64 = 1.1;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let greatest = "greatest error over that of setting up";
    let steepest = evidence.value(&format!("{greatest}, steepest slopes"))?;
    let first = evidence.value(&format!("{greatest}, slopes at the start"))?;
    let (best, _) = span(&evidence.quotients(
        "error, kept with the slopes at the start; ",
        "error, matrix of the present slopes; ",
    )?);
    let kept = steepest.min(first);
    let verdict = if kept > MUST {
        Ruling::Holds
    } else if kept <= NEED_NOT {
        Ruling::Fails
    } else {
        Ruling::Undecided
    };
    let reason = format!(
        "A matrix kept with the steepest slopes makes up to {} times the error of one that is set \
         up anew. Kept with the slopes at the start it makes {} to {} times the error.",
        told(steepest),
        told(best),
        told(first)
    );
    Ok(Judgement { verdict, reason, repair: None })
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let reading = |asks: &'static str, kept: &str| -> Result<Reading, Missing> {
        let ratio = evidence.value(&format!("greatest error over that of setting up, {kept}"))?;
        Ok(Reading::new(asks, ratio > MUST, format!("up to {} times the error", told(ratio))))
    };
    Ok(vec![
        reading("A matrix kept with the steepest slopes doubles the error.", "steepest slopes")?,
        reading("One kept with the slopes at the start doubles it.", "slopes at the start")?,
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn the_better_of_the_matrices_that_are_kept_decides() {
        let verdict = |steepest, first| {
            let numbers = [
                ("greatest error over that of setting up, steepest slopes", steepest),
                ("greatest error over that of setting up, slopes at the start", first),
                ("error, kept with the slopes at the start; a", 0.2),
                ("error, matrix of the present slopes; a", 0.1),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(2.1, 9.0), Ruling::Holds);
        assert_eq!(verdict(2.0, 9.0), Ruling::Undecided);
        assert_eq!(verdict(9.0, 1.1), Ruling::Fails);
    }
}
