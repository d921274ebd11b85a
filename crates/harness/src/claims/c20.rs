//! C20: any collision, elastic or inelastic; no penetration visible.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C20",
    origin: Origin::Paper { section: "6" },
    says: "any collision, elastic or inelastic; no penetration visible",
    criterion: "No particle is deeper than v·h or displayed inside, and restitution is met within \
                5 %.",
    reads: &[
        "greatest depth over v·h",
        "greatest lack of the velocity that restitution asks for",
        "impacts",
        "impacts that springs pull off faster",
        "the same with limp springs",
        "greatest displayed depth of a particle",
        "greatest displayed depth between particles",
    ],
    overturned_by: "One impact that leaves too slowly, or one particle that lies too deep, refutes \
                    it.",
    see: "collision-depth.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Greatest accepted distance of the velocity after an impact from what restitution asks for, over
/// that before. By the law of impact it is met where the contact pushes, and exceeded where other
/// forces let it go.
pub(crate) const TOLERANCE: f64 = 0.05;
/// Round-off of a depth, m.
const ROUND_OFF: f64 = 1e-12;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let depth = evidence.value("greatest depth over v·h")?;
    let lack = evidence.value("greatest lack of the velocity that restitution asks for")?;
    let count = evidence.value("impacts")?;
    let pulled = evidence.value("impacts that springs pull off faster")?;
    let limp = evidence.value("the same with limp springs")?;
    let displayed = evidence.value("greatest displayed depth of a particle")?;
    let between = evidence.value("greatest displayed depth between particles")?;
    let reason = format!(
        "Of {count} impacts none leaves too slowly by more than {} of its speed, and {pulled} \
         leave faster, pulled by stiff springs. No particle is deeper than {} v·h, but displayed \
         triangles cut into obstacles by up to {} m.",
        told(lack.max(0.0)),
        told(depth),
        told(between)
    );
    let is_met = count > 0.0
        && depth <= 1.0 + 1e-9
        && lack <= TOLERANCE
        && limp == 0.0
        && displayed <= ROUND_OFF;
    Ok(Judgement::new(is_met, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let between = evidence.value("greatest displayed depth between particles")?;
    Ok(vec![Reading::new(
        "“Visible” is what is drawn: no displayed triangle cuts an obstacle.",
        between <= ROUND_OFF,
        format!("by up to {} m", told(between)),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn each_part_of_the_criterion_can_fail() {
        let verdict = |changed: &str, value: f64| {
            let mut numbers = [
                ("greatest depth over v·h", 1.0),
                ("greatest lack of the velocity that restitution asks for", 0.05),
                ("impacts", 5.0),
                ("impacts that springs pull off faster", 2.0),
                ("the same with limp springs", 0.0),
                ("greatest displayed depth of a particle", 0.0),
                ("greatest displayed depth between particles", 0.3),
            ];
            let number = numbers.iter_mut().find(|(what, _)| *what == changed);
            number.into_iter().for_each(|number| number.1 = value);
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict("", 0.0), Ruling::Holds);
        assert_eq!(verdict("greatest depth over v·h", 1.0 + 1e-12), Ruling::Holds);
        for (changed, value) in [
            ("greatest depth over v·h", 1.1),
            ("greatest lack of the velocity that restitution asks for", 0.06),
            ("the same with limp springs", 1.0),
            ("greatest displayed depth of a particle", 1e-3),
            ("impacts", 0.0),
        ] {
            assert_eq!(verdict(changed, value), Ruling::Fails, "{changed}");
        }
    }
}
