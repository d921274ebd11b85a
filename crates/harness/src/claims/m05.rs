//! M05: additive Runge–Kutta is what the paper could have used, up to a stiffness.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "M05",
    origin: Origin::Expectation { about: "Ascher, Ruuth, Spiteri 1997; Kennedy, Carpenter 2003" },
    says: "IMEX-RK keeps the motion at k/m = 1e6 and h = 0.01 s, but locks or gains from 1e8",
    criterion: "At h = 0.01 s and k/m = 1e6 each tableau keeps 0.93 to 1.0 of the way of the free \
                edge in 0.3 s (to two digits), and ars222 is stable for 2 s. At 1e8 and at 1e10 \
                each tableau keeps less than half of the way or is not stable.",
    reads: &[
        "way kept at 1e6, ",
        "way kept at 1e8, ",
        "way kept at 1e10, ",
        "energy rise at 1e6, ars222",
        "energy rise at 1e8, ",
        "energy rise at 1e10, ",
    ],
    overturned_by: "One tableau that stands still or races at 1e6, or that is stable and moves \
                    from 1e8 on, refutes it.",
    see: "locking-stiffness.svg",
    age: Age::LATER,
    judge,
    readings: sole,
};

/// The tableaux of the method.
pub(crate) const TABLEAUX: [&str; 4] = ["ars222", "ars443", "ark3", "ark4"];
/// The one that is safe.
const SAFE: &str = "ars222";
/// Stiffness over mass, 1/s²: where the methods move, and where they do not.
pub(crate) const SOFT: f64 = 1e6;
pub(crate) const STIFF: [f64; 2] = [1e8, 1e10];
/// 0.93 and 1.0 to two digits.
pub(crate) const KEPT: std::ops::Range<f64> = 0.925..1.05;
/// Less is a lock.
pub(crate) const LOCKED: f64 = 0.5;
/// Rise of the energy over what the scene sets free, up to which a run is stable.
pub(crate) const STABLE: f64 = 0.02;

/// What the share of the way that a form keeps is called.
pub(crate) fn way(stiffness: f64, form: &str) -> String {
    format!("way kept at {stiffness:e}, {form}")
}

/// What the rise of the energy of a form is called.
pub(crate) fn rise(stiffness: f64, form: &str) -> String {
    format!("energy rise at {stiffness:e}, {form}")
}

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let mut soft = Vec::new();
    for tableau in TABLEAUX {
        soft.push(evidence.value(&way(SOFT, tableau))?);
    }
    let safe = evidence.value(&rise(SOFT, SAFE))?;
    let mut usable = Vec::new();
    for stiffness in STIFF {
        for tableau in TABLEAUX {
            let kept = evidence.value(&way(stiffness, tableau))?;
            let rise = evidence.value(&rise(stiffness, tableau))?;
            if kept >= LOCKED && rise <= STABLE {
                usable.push(format!("{tableau} keeps {} at {stiffness:e}", told(kept)));
            }
        }
    }
    let euler = evidence.value(&way(SOFT, "IMEX Euler"))?;
    let (least, most) = span(&soft);
    let stiff = if usable.is_empty() {
        "From 1e8 on each locks or gains energy".to_owned()
    } else {
        format!("From 1e8 on it still moves: {}", usable.join(", "))
    };
    let reason = format!(
        "At 1e6 the tableaux keep {} to {} of the way (IMEX Euler {}), and the energy of {SAFE} \
         rises by {} of what the scene sets free. {stiff}.",
        told(least),
        told(most),
        told(euler),
        told(safe)
    );
    let is_met = soft.iter().all(|kept| KEPT.contains(kept)) && safe <= STABLE && usable.is_empty();
    Ok(Judgement::new(is_met, reason))
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn it_must_move_at_first_and_fail_from_then_on() {
        let ruled = |changed: &str, value: f64| {
            let mut all = vec![(way(SOFT, "IMEX Euler"), 0.2), (rise(SOFT, SAFE), 0.0)];
            for tableau in TABLEAUX {
                all.push((way(SOFT, tableau), 0.95));
                for stiffness in STIFF {
                    let (kept, gain) = if tableau == "ark4" { (0.9, 3.0) } else { (0.1, 0.0) };
                    all.push((way(stiffness, tableau), kept));
                    all.push((rise(stiffness, tableau), gain));
                }
            }
            let number = all.iter_mut().find(|(what, _)| what == changed);
            number.into_iter().for_each(|number| number.1 = value);
            let all: Vec<_> = all.iter().map(|(what, value)| (what.as_str(), *value)).collect();
            judged(&CLAIM, &all).verdict
        };
        assert_eq!(ruled("", 0.0), Ruling::Holds);
        assert_eq!(ruled(&way(SOFT, "ark3"), 0.9), Ruling::Fails);
        assert_eq!(ruled(&way(SOFT, "ark3"), 1.1), Ruling::Fails);
        assert_eq!(ruled(&rise(SOFT, SAFE), 0.1), Ruling::Fails);
        assert_eq!(ruled(&way(1e8, "ars443"), 0.6), Ruling::Fails);
        assert_eq!(ruled(&rise(1e10, "ark4"), 0.01), Ruling::Fails);
    }
}
