//! M07: the exponential method is second at small errors.

use super::places::{Ground, Places, judgement};
use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole};

pub(super) const CLAIM: Claim = Claim {
    id: "M07",
    origin: Origin::Expectation { about: "Michels, Sobottka, Weber 2014; Chen, Ascher, Pai 2018" },
    says: "with light damping the exponential method is second at errors of 1e-3 and 1e-4",
    criterion: "At k/m = 1e6 and 1e8 with light damping `exponential` is among the two methods of \
                least modelled time for errors of 1e-3 and 1e-4.",
    reads: &["time at 1e6 for ", "time at 1e8 for ", "doubt of the reference at "],
    overturned_by: "Two methods that reach one of these errors in less than half of its time refute \
                    it.",
    see: "work-precision-effort.svg",
    age: Age::MODELLED,
    judge,
    readings: sole,
};

/// The method that the claim names.
pub(crate) const METHOD: &str = "exponential";
/// Where it competes.
pub(crate) const GROUNDS: [Ground; 2] = [Ground::light(1e6), Ground::light(1e8)];
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
    fn it_must_be_second_everywhere() {
        let second = [("leapfrog", 1.0), (METHOD, 2.0), ("srkn4", 3.0)];
        let third = [("leapfrog", 1.0), (METHOD, 7.0), ("srkn4", 3.0)];
        let ruled = |changed| contest(&CLAIM, &GROUNDS, &LEVELS, &second, changed);
        assert_eq!(ruled(None), Ruling::Holds);
        assert_eq!(ruled(Some((1, 0, &third[..]))), Ruling::Fails);
    }
}
