//! C03: the reduction from 6n to 3n unknowns loses nothing.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C03",
    origin: Origin::Paper { section: "2.3" },
    says: "the reduction from 6n to 3n unknowns loses nothing",
    criterion: "Both systems give the same velocities to 1e-12, and 6n unknowns cost more than 1.5 \
                times as much.",
    reads: &[
        "difference of Δv, ",
        "work of 6n over that of 3n, BiCGStab, ",
        "the same of one iteration, ",
    ],
    overturned_by: "Velocities that differ by more than 1e-12, or a cost ratio of at most 1.5, \
                    refute it.",
    see: "work-precision.svg",
    age: Age::FIRST,
    judge,
    readings: sole,
};

/// Greatest accepted difference of the velocities.
pub(crate) const EQUAL: f64 = 1e-12;
/// Least ratio of the costs.
pub(crate) const RATIO: f64 = 1.5;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let (_, apart) = span(&evidence.values("difference of Δv, ")?);
    let solves = evidence.values("work of 6n over that of 3n, BiCGStab, ")?;
    let iterations = evidence.values("the same of one iteration, ")?;
    let failing = solves.iter().filter(|ratio| **ratio >= f64::MAX).count();
    let (cheapest, _) = span(&[solves.clone(), iterations].concat());
    let reason = format!(
        "The velocities differ by at most {}, so eliminating Δx is exact algebra. With 6n unknowns \
         the work is at least {} times as much, and {failing} of {} solves fail.",
        told(apart),
        told(cheapest),
        solves.len()
    );
    Ok(Judgement::new(apart <= EQUAL && cheapest > RATIO, reason))
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn velocities_that_differ_or_a_saving_too_small_refute() {
        let verdict = |apart, ratio| {
            let numbers = [
                ("difference of Δv, a", 1e-15),
                ("difference of Δv, b", apart),
                ("work of 6n over that of 3n, BiCGStab, a", 3.0),
                ("work of 6n over that of 3n, BiCGStab, b", ratio),
                ("the same of one iteration, a", 2.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(1e-13, 2.0), Ruling::Holds);
        assert_eq!(verdict(1e-11, 2.0), Ruling::Fails);
        assert_eq!(verdict(1e-13, 1.4), Ruling::Fails);
        assert_eq!(verdict(1e-13, RATIO), Ruling::Fails);
        assert_eq!(verdict(f64::NAN, 2.0), Ruling::Fails);
    }
}
