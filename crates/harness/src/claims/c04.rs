//! C04: one linearised Newton step suffers at high stiffness.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Ruling, sole, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C04",
    origin: Origin::Paper { section: "3" },
    says: "one linearised Newton step suffers at high stiffness",
    criterion: "From k/m = 1e4 to 1e8 the error of one step over that of the converged method \
                grows by more than 2.",
    reads: &["growth of their quotient, "],
    overturned_by: "Series whose quotients all grow by at most 2 refute it.",
    see: "work-precision.svg",
    age: Age::FIRST,
    judge,
    readings: sole,
};

/// Least growth of the quotient of the errors.
pub(crate) const GROWTH: f64 = 2.0;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let growth = evidence.values("growth of their quotient, ")?;
    let growing = growth.iter().filter(|growth| **growth > GROWTH).count();
    let (low, high) = span(&growth);
    let verdict = match growing {
        0 => Ruling::Fails,
        count if count == growth.len() => Ruling::Holds,
        _ => Ruling::Undecided,
    };
    let reason = format!(
        "The quotient of the errors grows by a factor of {} to {}, beyond 2 in {growing} of {} \
         series. One linearisation keeps the old directions of the springs and sees late what a \
         turn stretches.",
        told(low),
        told(high),
        growth.len()
    );
    Ok(Judgement { verdict, reason, repair: None })
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn all_series_must_agree() {
        let verdict = |a, b, c| {
            let numbers = [("a", a), ("b", b), ("c", c)]
                .map(|(series, growth)| (format!("growth of their quotient, {series}"), growth));
            let numbers = numbers.each_ref().map(|(what, growth)| (what.as_str(), *growth));
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(4.0, 3.0, 2.1), Ruling::Holds);
        assert_eq!(verdict(1.1, 1.5, GROWTH), Ruling::Fails);
        assert_eq!(verdict(1.1, 3.0, 4.0), Ruling::Undecided);
        assert_eq!(verdict(1.1, 1.2, 4.0), Ruling::Undecided);
    }
}
