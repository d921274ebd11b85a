//! M03: vertex block descent and projective dynamics do not share the lead of XPBD.

use super::places::{Ground, Places, all_of, judgement};
use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole};

pub(super) const CLAIM: Claim = Claim {
    id: "M03",
    origin: Origin::Expectation { about: "Bouaziz et al. 2014; Chen et al. 2024" },
    says: "vertex block descent and projective dynamics do not share the lead of XPBD",
    criterion: "At k/m = 1e6, 1e8 and 1e10 with light damping neither is among the two methods of \
                least modelled time for errors of 10 %, 3 % or 1 %.",
    reads: &[
        "time at 1e6 for ",
        "time at 1e8 for ",
        "time at 1e10 for ",
        "doubt of the reference at ",
    ],
    overturned_by: "One of these errors that one of the two reaches in less than half of the time of \
                    all others but one refutes it.",
    see: "work-precision-stiff.svg",
    age: Age::MODELLED,
    judge,
    readings: sole,
};

/// The methods that the claim names.
pub(crate) const METHODS: [&str; 2] = ["vbd", "projective"];
/// Where they compete.
pub(crate) const GROUNDS: [Ground; 3] =
    [Ground::light(1e6), Ground::light(1e8), Ground::light(1e10)];
/// For which errors.
pub(crate) const LEVELS: [f64; 3] = [1e-1, 3e-2, 1e-2];

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let [first, second] = METHODS.map(|method| Places::of(evidence, method, &GROUNDS, &LEVELS));
    let places = [first?, second?];
    Ok(judgement(all_of(places.iter().map(Places::lag)), &places))
}

#[cfg(test)]
mod tests {
    use super::super::Ruling;
    use super::super::places::tests::contest;
    use super::*;

    #[test]
    fn neither_may_be_second_anywhere() {
        let behind = [("xpbd", 1.0), ("dirk", 2.0), ("vbd", 3.0), ("projective", f64::INFINITY)];
        let second = [("xpbd", 1.0), ("dirk", 7.0), ("vbd", 9.0), ("projective", 3.0)];
        let tied = [("xpbd", 1.0), ("dirk", 4.0), ("vbd", 5.0), ("projective", 3.0)];
        let ruled = |changed| contest(&CLAIM, &GROUNDS, &LEVELS, &behind, changed);
        assert_eq!(ruled(None), Ruling::Holds);
        assert_eq!(ruled(Some((2, 2, &second[..]))), Ruling::Fails);
        assert_eq!(ruled(Some((2, 2, &tied[..]))), Ruling::Undecided);
        assert_eq!(ruled(Some((2, 2, &second[..2]))), Ruling::Undecided);
    }
}
