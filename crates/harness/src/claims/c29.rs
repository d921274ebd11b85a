//! C29: several hundred particles in real time.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C29",
    origin: Origin::Paper { section: "9" },
    says: "several hundred particles in real time",
    criterion: "The paper's own tables decide. Beside it stands the largest n in real time here.",
    reads: &[
        "paper's fastest run of 400 particles, a simulated second",
        "paper's slowest run of 400 particles",
        "paper's fastest without the set-up of the matrix",
        "largest n in real time by counted work, ",
    ],
    overturned_by: "A run of 400 particles within a second in the paper's tables confirms it.",
    see: "scaling-cost.svg",
    age: Age::FIRST,
    judge,
    readings,
};

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let fastest = evidence.value("paper's fastest run of 400 particles, a simulated second")?;
    let slowest = evidence.value("paper's slowest run of 400 particles")?;
    let kept = evidence.value("paper's fastest without the set-up of the matrix")?;
    let (largest, _) = span(&evidence.values("largest n in real time by counted work, ")?);
    let reason = format!(
        "In the paper's tables a simulated second of 400 particles took {} to {} s, and without \
         the set-up of the matrix {} s. At 5 ns a visit of a spring {} particles run in real time.",
        told(fastest),
        told(slowest),
        told(kept),
        told(largest)
    );
    Ok(Judgement::new(fastest <= 1.0, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let kept = evidence.value("paper's fastest without the set-up of the matrix")?;
    let (largest, _) = span(&evidence.values("largest n in real time by counted work, ")?);
    let several = 400.0 / kept;
    Ok(vec![
        Reading::new(
            "“Several hundred” are 200, at the paper's time a particle without the set-up.",
            several >= 200.0,
            format!("{several:.0} particles"),
        ),
        Reading::new(
            "On a machine of today, 400 particles.",
            largest >= 400.0,
            format!("{} particles at 5 ns a visit of a spring", told(largest)),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn the_fastest_of_the_paper_decides() {
        let verdict = |fastest| {
            let numbers = [
                ("paper's fastest run of 400 particles, a simulated second", fastest),
                ("paper's slowest run of 400 particles", 3.0),
                ("paper's fastest without the set-up of the matrix", 0.5),
                ("largest n in real time by counted work, fixed material", 400.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.9), Ruling::Holds);
        assert_eq!(verdict(2.0), Ruling::Fails);
    }
}
