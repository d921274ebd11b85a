//! C13: stiffness depends on k/m, not on k.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, sole, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C13",
    origin: Origin::Paper { section: "5" },
    says: "stiffness depends on k/m, not on k",
    criterion: "Scaling k and m by a power of two keeps every bit (with IC(0), whose square roots \
                round, by a power of four). Any other factor changes less than 1e-9.",
    reads: &[
        "runs scaled by a power of two that differ in a bit",
        "runs scaled by a power of two",
        "greatest change over the motion, other factors",
        "change over the motion by a factor of 2, with the square roots of IC(0)",
        "least change over the motion when k alone is halved",
    ],
    overturned_by: "One bit that differs under a power of two, or a change of 1e-9 otherwise, \
                    refutes it.",
    see: "cg-vs-stiffness.svg",
    age: Age::changed(
        "a3fba16",
        "asks for powers of four with IC(0), whose square roots round; the verdict is the same",
    ),
    judge,
    readings: sole,
};

/// Change over the motion that factors other than powers of two must stay below.
pub(crate) const TOLERANCE: f64 = 1e-9;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let differing = evidence.value("runs scaled by a power of two that differ in a bit")?;
    let runs = evidence.value("runs scaled by a power of two")?;
    let worst = evidence.value("greatest change over the motion, other factors")?;
    let what = "change over the motion by a factor of 2, with the square roots of IC(0)";
    let roots = evidence.value(what)?;
    let control = evidence.value("least change over the motion when k alone is halved")?;
    let reason = format!(
        "Scaling k and m together changes a bit in {differing} of {runs} runs with a power of two, \
         and at most {} of the motion otherwise ({} by a factor of 2 with IC(0)). Halving k alone \
         changes at least {}.",
        told(worst),
        told(roots),
        told(control)
    );
    Ok(Judgement::new(differing == 0.0 && worst < TOLERANCE, reason))
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn one_bit_or_one_large_change_refutes() {
        let verdict = |differing, change| {
            let numbers = [
                ("runs scaled by a power of two that differ in a bit", differing),
                ("runs scaled by a power of two", 9.0),
                ("greatest change over the motion, other factors", change),
                ("change over the motion by a factor of 2, with the square roots of IC(0)", 1e-14),
                ("least change over the motion when k alone is halved", 0.1),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.0, 1e-10), Ruling::Holds);
        assert_eq!(verdict(1.0, 1e-10), Ruling::Fails);
        assert_eq!(verdict(0.0, 1e-8), Ruling::Fails);
    }
}
