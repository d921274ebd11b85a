//! C22: the reason is that the matrix couples no coordinate directions.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, Ruling, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C22",
    origin: Origin::Paper { section: "7" },
    says: "the reason is that the matrix couples no coordinate directions",
    criterion: "An aligned spring, whose exact Hessian has no coupling either, does not lock; the \
        3×3-block variant, which couples, does not lock.",
    reads: &["kept, aligned spring, ", "kept, spring at 45°, ", "kept, sheet, "],
    overturned_by: "It is confirmed if neither the aligned spring nor the coupled matrix locks.",
    see: "locking-stiffness.svg",
    age: Age::changed(
        "35329f5",
        "said before what is looked at, not what decides; the verdict is the same",
    ),
    judge,
    readings,
};

/// A run keeps less than this of the motion: it locks.
pub(crate) const LOCKED: f64 = 0.5;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let kept = |what: &str, matrix: &str| evidence.value(&format!("kept, {what}, {matrix}"));
    let (imex, hessian) = ("matrix of IMEX Euler", "exact Hessian");
    let coupled = "coupled, half as stiff across";
    let aligned = (kept("aligned spring", imex)?, kept("aligned spring", hessian)?);
    let oblique = (kept("spring at 45°", imex)?, kept("spring at 45°", coupled)?);
    let sheet = (kept("sheet", coupled)?, kept("sheet", hessian)?);
    let aligned_locks = aligned.0 < LOCKED && aligned.1 >= LOCKED;
    let coupled_locks = oblique.1 < LOCKED && sheet.0 < LOCKED;
    let verdict = match (aligned_locks, coupled_locks) {
        (true, true) => Ruling::Fails,
        (false, false) => Ruling::Holds,
        _ => Ruling::Undecided,
    };
    let reason = format!(
        "An aligned spring, which needs no coupling, keeps {} of its motion (one at 45° {}). A \
         coupled matrix that is half as stiff across springs leaves {} to the sheet: the stiffness \
         across springs decides.",
        told(aligned.0),
        told(oblique.0),
        told(sheet.0)
    );
    let repair =
        format!("Take ∂F2 into the matrix: the sheet keeps {} of its motion.", told(sheet.1));
    let helps = verdict == Ruling::Fails && sheet.1 >= LOCKED;
    Ok(Judgement { verdict, reason, repair: helps.then_some(repair) })
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let kept = |what: &str, matrix: &str| evidence.value(&format!("kept, {what}, {matrix}"));
    let without = kept("spring at 45°", "exact Hessian without coupling")?;
    let with = kept("spring at 45°", "exact Hessian")?;
    Ok(vec![Reading::new(
        "For springs across the axes: the exact Hessian locks without its coupling only.",
        without < LOCKED && with >= LOCKED,
        format!("{} is kept without it, {} with it", told(without), told(with)),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn the_verdict_takes_both_halves() {
        let verdict = |aligned: f64, oblique: f64, sheet: f64| {
            let numbers = [
                ("kept, aligned spring, matrix of IMEX Euler", aligned),
                ("kept, aligned spring, exact Hessian", 1.0),
                ("kept, spring at 45°, matrix of IMEX Euler", 0.01),
                ("kept, spring at 45°, coupled, half as stiff across", oblique),
                ("kept, sheet, coupled, half as stiff across", sheet),
                ("kept, sheet, exact Hessian", 1.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(0.01, 0.1, 0.1), Ruling::Fails);
        assert_eq!(verdict(0.01, 1.0, 1.0), Ruling::Undecided);
        assert_eq!(verdict(1.0, 1.0, 1.0), Ruling::Holds);
    }
}
