//! M01: with light damping leapfrog leads at small errors.

use super::places::{Ground, Places, judgement};
use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole};

pub(super) const CLAIM: Claim = Claim {
    id: "M01",
    origin: Origin::Expectation { about: "Hairer, Lubich, Wanner 2003" },
    says: "with light damping leapfrog leads at errors of 0.1 % and below",
    criterion: "At k/m = 1e4, 1e6, 1e8 and 1e10 leapfrog is among the two methods of least \
                modelled time for errors of 1e-3 and 1e-4.",
    reads: &[
        "time at 1e4 for ",
        "time at 1e6 for ",
        "time at 1e8 for ",
        "time at 1e10 n = 100 for ",
        "doubt of the reference at ",
    ],
    overturned_by: "Two methods that reach one of these errors in less than half of its time refute \
                    it.",
    see: "work-precision-effort.svg",
    age: Age::MODELLED,
    judge,
    readings: sole,
};

/// The method that the claim names.
pub(crate) const METHOD: &str = "leapfrog";
/// Where it competes.
pub(crate) const GROUNDS: [Ground; 4] =
    [Ground::light(1e4), Ground::light(1e6), Ground::light(1e8), Ground::light(1e10).of_side(10)];
/// For which errors.
pub(crate) const LEVELS: [f64; 2] = [1e-3, 1e-4];

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let places = Places::of(evidence, METHOD, &GROUNDS, &LEVELS)?;
    Ok(judgement(places.lead(), &[places]))
}

#[cfg(test)]
mod tests {
    use super::super::Ruling;
    use super::super::places::tests::contest;
    use super::*;

    #[test]
    fn leapfrog_may_be_second_but_nowhere_third() {
        let second = [("rkc", 1.0), (METHOD, 2.0), ("xpbd", 3.0)];
        let third = [("rkc", 1.0), (METHOD, 4.0), ("xpbd", 1.5)];
        let tied = [("rkc", 1.0), (METHOD, 2.0), ("xpbd", 1.5)];
        let late = [("rkc", 1.0), (METHOD, f64::INFINITY)];
        let ruled = |changed| contest(&CLAIM, &GROUNDS, &LEVELS, &second, changed);
        assert_eq!(ruled(None), Ruling::Holds);
        assert_eq!(ruled(Some((3, 1, &third[..]))), Ruling::Fails);
        assert_eq!(ruled(Some((3, 1, &tied[..]))), Ruling::Undecided);
        assert_eq!(ruled(Some((0, 0, &late[..]))), Ruling::Fails);
        assert_eq!(ruled(Some((0, 0, &second[..0]))), Ruling::Undecided);
    }
}
