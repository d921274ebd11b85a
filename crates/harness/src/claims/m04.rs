//! M04: with heavy damping additive, Chebyshev and implicit methods lead in turn.

use super::places::{Ground, Places, all_of, judgement};
use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole};

pub(super) const CLAIM: Claim = Claim {
    id: "M04",
    origin: Origin::Expectation {
        about: "Hosea, Shampine 1996; Sommeijer, Shampine, Verwer 1998; Kennedy, Carpenter 2003",
    },
    says: "with heavy damping lead IMEX-RK at 10 %, RKC at 1e6, then TR-BDF2 at 1e8",
    criterion: "With d/m = √(k/m) these are among the two methods of least modelled time: \
                `imex-rk` for an error of 10 % at k/m = 1e6, `rkc` for 1e-3 and 1e-4 there, and \
                `dirk` for 1e-3 and 1e-4 at 1e8.",
    reads: &["time at 1e6 heavy for ", "time at 1e8 heavy for ", "doubt of the reference at "],
    overturned_by: "Two methods that reach one of these errors in less than half of its time refute \
                    it.",
    see: "work-precision-heavy.svg",
    age: Age::MODELLED,
    judge,
    readings: sole,
};

/// Which method leads on which sheet for which errors.
pub(crate) const REGIMES: [(&str, Ground, &[f64]); 3] = [
    ("imex-rk", Ground::heavy(1e6), &[1e-1]),
    ("rkc", Ground::heavy(1e6), &[1e-3, 1e-4]),
    ("dirk", Ground::heavy(1e8), &[1e-3, 1e-4]),
];

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let [a, b, c] =
        REGIMES.map(|(method, ground, levels)| Places::of(evidence, method, &[ground], levels));
    let places = [a?, b?, c?];
    Ok(judgement(all_of(places.iter().map(Places::lead)), &places))
}

#[cfg(test)]
mod tests {
    use super::super::places::tests::numbers;
    use super::super::{Number, Ruling};
    use super::*;

    #[test]
    fn each_regime_can_fail() {
        let ruled = |slow: Option<(usize, f64)>| {
            let mut all: Vec<Number> = Vec::new();
            for (at, (method, ground, levels)) in REGIMES.into_iter().enumerate() {
                let effort = slow.filter(|(one, _)| *one == at).map_or(1.5, |(_, effort)| effort);
                let efforts = [("leapfrog", 1.0), (method, effort), ("bdf2", 2.0)];
                all.extend(numbers(&[ground], levels, &efforts, None));
            }
            CLAIM.judge(&Evidence::new(&all)).verdict
        };
        assert_eq!(ruled(None), Ruling::Holds);
        for at in 0..REGIMES.len() {
            assert_eq!(ruled(Some((at, 9.0))), Ruling::Fails, "{at}");
            assert_eq!(ruled(Some((at, 3.9))), Ruling::Undecided, "{at}: a tie");
        }
    }
}
