//! M06: second-order methods that Newton solves are alike, never first, and better than backward
//! Euler.

use super::places::{Ground, Place, TIE, TRUSTED, all_of, missed};
use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Ruling, sole, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "M06",
    origin: Origin::Expectation {
        about: "Gonzalez 1996; Hosea, Shampine 1996; Chung, Hulbert 1993",
    },
    says: "second-order Newton methods are alike, never first, and better than backward Euler",
    criterion: "Implicit midpoint, generalized-α, TR-BDF2, BDF2 and energy-momentum need times \
                within a factor 2 of each other for errors of 1e-2, 1e-3 and 1e-4 (k/m = 1e4, 1e6, \
                1e8; heavy damping: 1e6, 1e8), and none is first with light damping. At k/m = 1e6 \
                and h = 0.01 s TR-BDF2 costs no more than backward Euler and is at least 6 times \
                as accurate.",
    reads: &[
        "time at 1e4 for ",
        "time at 1e6 for ",
        "time at 1e8 for ",
        "time at 1e6 heavy for ",
        "time at 1e8 heavy for ",
        "doubt of the reference at ",
        ERROR,
        COST,
    ],
    overturned_by: "One error at which the five differ by more than a factor 4, or at which one of \
                    them needs less than half of the time of all others, refutes it.",
    see: "work-precision-effort.svg",
    age: Age::MODELLED,
    judge,
    readings: sole,
};

/// The methods that the claim names.
pub(crate) const METHODS: [&str; 5] =
    ["midpoint", "generalized-alpha", "dirk", "bdf2", "energy-momentum"];
/// Where they compete.
pub(crate) const GROUNDS: [Ground; 5] = [
    Ground::light(1e4),
    Ground::light(1e6),
    Ground::light(1e8),
    Ground::heavy(1e6),
    Ground::heavy(1e8),
];
/// For which errors.
pub(crate) const LEVELS: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// Greatest ratio of their efforts.
pub(crate) const ALIKE: f64 = 2.0;
/// What compares TR-BDF2 with backward Euler at equal steps, and the limits.
pub(crate) const ERROR: &str = "error of backward Euler over that of TR-BDF2 at h = 0.01 s";
pub(crate) const COST: &str = "effort of TR-BDF2 over that of backward Euler at h = 0.01 s";
pub(crate) const BETTER: f64 = 6.0;
pub(crate) const CHEAP: f64 = 1.0;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let (mut widest, mut at) = (0.0, String::new());
    let (mut led, mut rulings) = (Vec::new(), Vec::new());
    for ground in GROUNDS {
        let doubt = evidence.value(&ground.doubt())?;
        for level in LEVELS.into_iter().filter(|level| doubt <= TRUSTED * level) {
            let mut efforts = Vec::new();
            for method in METHODS {
                efforts.push(evidence.value(&ground.effort(level, method))?);
                let place = Place::of(evidence, &ground, level, method)?;
                if !ground.is_heavy && place.is_first() {
                    let all = evidence.rows(&ground.effort(level, ""))?;
                    let rivals = all.iter().filter(|(name, _)| !METHODS.contains(name));
                    let rival = rivals.map(|(_, rival)| rival.value).fold(f64::MAX, f64::min);
                    // The five may tie with each other: the best of the other methods counts.
                    rulings.push(missed(true, TIE * efforts[efforts.len() - 1] < rival));
                    led.push(format!("`{method}` ({level:e} at k/m = {})", ground.name()));
                }
            }
            let (least, most) = span(&efforts);
            // What no run reaches stands as the largest number.
            let ratio = if most < f64::MAX { most / least } else { f64::INFINITY };
            if ratio > widest {
                (widest, at) = (ratio, format!("{level:e} at k/m = {}", ground.name()));
            }
        }
    }
    let (error, cost) = (evidence.value(ERROR)?, evidence.value(COST)?);
    let led_by = match led.len() {
        0 => "none is first".to_owned(),
        _ => format!("first with light damping: {}", led.join(", ")),
    };
    let reason = format!(
        "Their times differ by a factor of up to {} ({at}); {led_by}. At equal steps TR-BDF2 costs \
         {} times as much as backward Euler and is {} times as accurate.",
        told(widest),
        told(cost),
        told(error)
    );
    rulings.push(missed(widest > ALIKE, widest > TIE * ALIKE));
    rulings.push(Ruling::of(cost <= CHEAP && error >= BETTER));
    Ok(Judgement { verdict: all_of(rulings), reason, repair: None })
}

#[cfg(test)]
mod tests {
    use super::super::places::tests::numbers;
    use super::super::{Number, Ruling};
    use super::*;

    #[test]
    fn each_part_of_the_criterion_can_fail() {
        let efforts = |winner: f64, slow: f64| {
            let mut all = vec![("leapfrog", winner)];
            all.extend(METHODS.map(|method| (method, 2.0)));
            all[5].1 = slow;
            all
        };
        let usual = efforts(1.0, 4.0);
        let ruled = |changed: Option<(usize, &[(&str, f64)])>, error: f64, cost: f64| {
            let changed = changed.map(|(ground, efforts)| (ground, 1, efforts));
            let mut all = numbers(&GROUNDS, &LEVELS, &usual, changed);
            all.extend([Number::new(ERROR, error, ""), Number::new(COST, cost, "")]);
            CLAIM.judge(&Evidence::new(&all)).verdict
        };
        assert_eq!(ruled(None, 6.0, 1.0), Ruling::Holds);
        assert_eq!(ruled(Some((4, efforts(1.0, 8.1).as_slice())), 6.0, 1.0), Ruling::Fails);
        assert_eq!(ruled(Some((4, efforts(1.0, 4.1).as_slice())), 6.0, 1.0), Ruling::Undecided);
        assert_eq!(
            ruled(Some((0, efforts(1.0, f64::INFINITY).as_slice())), 6.0, 1.0),
            Ruling::Fails
        );
        assert_eq!(ruled(Some((2, efforts(4.1, 4.0).as_slice())), 6.0, 1.0), Ruling::Fails);
        assert_eq!(ruled(Some((2, efforts(3.0, 4.0).as_slice())), 6.0, 1.0), Ruling::Undecided);
        assert_eq!(
            ruled(Some((3, efforts(3.0, 4.0).as_slice())), 6.0, 1.0),
            Ruling::Holds,
            "heavy"
        );
        assert_eq!(ruled(None, 5.9, 1.0), Ruling::Fails);
        assert_eq!(ruled(None, 6.0, 1.1), Ruling::Fails);
    }
}
