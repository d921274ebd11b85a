//! M08: Rosenbrock and multirate methods never lead.

use super::places::{Ground, Places, all_of, judgement};
use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole};

pub(super) const CLAIM: Claim = Claim {
    id: "M08",
    origin: Origin::Expectation { about: "Tuckerman, Berne, Martyna 1992; Lang, Verwer 2001" },
    says: "with light damping Rosenbrock and multirate methods are never on the front",
    criterion: "At k/m = 1e4, 1e6, 1e8 and 1e10 neither needs the least modelled time of all \
                methods for an error of 10 %, 1 %, 1e-3 or 1e-4.",
    reads: &[
        "time at 1e4 for ",
        "time at 1e6 for ",
        "time at 1e8 for ",
        "time at 1e10 n = 100 for ",
        "doubt of the reference at ",
    ],
    overturned_by: "One of these errors that one of the two reaches in less than half of the time of \
                    all others refutes it.",
    see: "work-precision-effort.svg",
    age: Age::MODELLED,
    judge,
    readings: sole,
};

/// The methods that the claim names.
pub(crate) const METHODS: [&str; 2] = ["rosenbrock", "multirate"];
/// Where they compete.
pub(crate) const GROUNDS: [Ground; 4] =
    [Ground::light(1e4), Ground::light(1e6), Ground::light(1e8), Ground::light(1e10).of_side(10)];
/// For which errors.
pub(crate) const LEVELS: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let [first, second] = METHODS.map(|method| Places::of(evidence, method, &GROUNDS, &LEVELS));
    let places = [first?, second?];
    Ok(judgement(all_of(places.iter().map(Places::follow)), &places))
}

#[cfg(test)]
mod tests {
    use super::super::Ruling;
    use super::super::places::tests::contest;
    use super::*;

    #[test]
    fn they_may_be_second_but_never_first() {
        let second = [("leapfrog", 1.0), ("rosenbrock", 2.0), ("multirate", f64::INFINITY)];
        let first = [("leapfrog", 1.0), ("rosenbrock", 2.0), ("multirate", 0.4)];
        let ruled = |changed| contest(&CLAIM, &GROUNDS, &LEVELS, &second, changed);
        assert_eq!(ruled(None), Ruling::Holds);
        assert_eq!(ruled(Some((1, 3, &first[..]))), Ruling::Fails);
    }
}
