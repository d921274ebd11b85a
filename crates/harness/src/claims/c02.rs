//! C02: IMEX nearly keeps the implicit method's stability.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Ruling, sole, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C02",
    origin: Origin::Paper { section: "2.2" },
    says: "the implicit method's stability is nearly kept by IMEX",
    criterion: "The energy of IMEX Euler, solved to 1e-10, never grows over the stability atlas.",
    reads: &[
        "steps in which the energy rises by more than round-off",
        "steps",
        "greatest rise above the start over the energy set free",
        "runs over budget",
    ],
    overturned_by: "One step of the atlas in which the energy rises beyond round-off refutes it.",
    see: "stability-atlas.svg",
    age: Age::FIRST,
    judge,
    readings: sole,
};

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let rises = evidence.value("steps in which the energy rises by more than round-off")?;
    let steps = evidence.value("steps")?;
    let worst = evidence.value("greatest rise above the start over the energy set free")?;
    let unfinished = evidence.value("runs over budget")?;
    let verdict = match (rises > 0.0, unfinished > 0.0) {
        (true, _) => Ruling::Fails,
        (false, true) => Ruling::Undecided,
        (false, false) => Ruling::Holds,
    };
    let reason = format!(
        "The energy rises in {rises} of {steps} steps, and at most {} of the energy set free above \
         the start. With all springs in the matrix, an exact solve loses at least ½‖v₊ − v‖²_M a \
         step.",
        told(worst)
    );
    Ok(Judgement { verdict, reason, repair: None })
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn one_rise_refutes_and_what_was_not_run_leaves_it_open() {
        let verdict = |rises, unfinished| {
            let numbers = [
                ("steps in which the energy rises by more than round-off", rises),
                ("steps", 400.0),
                ("greatest rise above the start over the energy set free", 0.0),
                ("runs over budget", unfinished),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.0, 0.0), Ruling::Holds);
        assert_eq!(verdict(1.0, 0.0), Ruling::Fails);
        assert_eq!(verdict(0.0, 1.0), Ruling::Undecided);
    }
}
