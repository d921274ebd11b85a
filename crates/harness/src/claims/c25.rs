//! C25: a constant forcing term suffices.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C25",
    origin: Origin::Paper { section: "7" },
    says: "a constant forcing term suffices",
    criterion: "Error and motion change by less than 5 % over ε = 1e-1 … 1e-6.",
    reads: &[
        "change of the motion, ",
        "change of the error, ",
        "values of ε within 5 %, updated, safeguarded, ",
    ],
    overturned_by: "Changes below 5 % in every scene, for both forms of the paper, confirm it.",
    see: "cg-vs-forcing-term.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Change over the value at the tightest ε that all must stay below.
pub(crate) const LIMIT: f64 = 0.05;
/// The form that stands beside those of the paper and does not decide.
const SAFE: &str = "updated, safeguarded, ";

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let motions = evidence.rows("change of the motion, ")?;
    let (mut paper, mut safe) = (Vec::new(), Vec::new());
    for (of, motion) in &motions {
        let change = motion.value.max(evidence.value(&format!("change of the error, {of}"))?);
        if of.starts_with(SAFE) { safe.push(change) } else { paper.push(change) }
    }
    let good = paper.iter().filter(|change| **change < LIMIT).count();
    let ((_, worst), (_, kept)) = (span(&paper), span(&safe));
    // Of six values of ε, only the loosest may be off.
    let within = evidence.values(&format!("values of ε within 5 %, {SAFE}"))?;
    let nearly = within.iter().filter(|count| **count >= 5.0).count();
    let reason = format!(
        "Error and motion stay within 5 % in {good} of {} pairs of scene and form, and change by \
         up to {} times. |b| grows like θ, so a constant ε leaves the forces unsolved in stiff \
         scenes.",
        paper.len(),
        told(worst)
    );
    let repair = format!(
        "Measure the residual by the change of the forces, and start where the potential is lower. \
         The greatest change is {} then, and ε ≤ 1e-2 stays within 5 % in {nearly} of {} scenes.",
        told(kept),
        within.len()
    );
    let is_met = good == paper.len();
    Ok(Judgement::new(is_met, reason).repaired((!is_met && kept < worst).then_some(repair)))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let motions = evidence.rows("change of the motion, plain, ")?;
    let all: Vec<_> = motions.iter().map(|(_, number)| number.value).collect();
    let good = all.iter().filter(|change| **change < LIMIT).count();
    Ok(vec![Reading::new(
        "For the plain iteration, by the motion alone.",
        good == all.len(),
        format!("within 5 % in {good} of {} scenes", all.len()),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn both_forms_of_the_paper_decide_and_the_safeguarded_does_not() {
        let verdict = |plain, printed, safe| {
            let mut numbers = vec![("values of ε within 5 %, updated, safeguarded, a", 6.0)];
            numbers.extend([
                ("change of the motion, plain, a", plain),
                ("change of the error, plain, a", 0.01),
                ("change of the motion, updated as printed, a", 0.01),
                ("change of the error, updated as printed, a", printed),
                ("change of the motion, updated, safeguarded, a", safe),
                ("change of the error, updated, safeguarded, a", 0.01),
            ]);
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.04, 0.04, 1.0), Ruling::Holds);
        assert_eq!(verdict(0.04, 0.06, 0.0), Ruling::Fails);
        assert_eq!(verdict(0.06, 0.04, 0.0), Ruling::Fails);
    }
}
