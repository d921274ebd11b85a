//! C23: the updated iteration converges as well as plain CG.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C23",
    origin: Origin::Paper { section: "7" },
    says: "the updated iteration converges as well as plain CG",
    criterion: "At ε = 1e-4 and h²k/m = 1 … 1e4 updated CG takes at most twice the iterations of \
                plain CG.",
    reads: &["updated / plain, ", "updated / plain, same step, "],
    overturned_by: "Ratios that are all at most 2 confirm it.",
    see: "cg-plain-vs-updated.svg",
    age: Age::SETTLED,
    judge,
    readings,
};

/// Greatest ratio of the iterations.
pub(crate) const LIMIT: f64 = 2.0;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let ratios = evidence.values("updated / plain, ")?;
    let (mildest, worst) = span(&evidence.values("updated / plain, same step, ")?);
    let within = ratios.iter().filter(|ratio| **ratio <= LIMIT).count();
    let reason = format!(
        "From the same state a step of updated CG takes {} to {} times the iterations of plain CG; \
         {within} of {} ratios are at most {LIMIT}. Each update undoes part of the convergence.",
        told(mildest),
        told(worst),
        ratios.len()
    );
    Ok(Judgement::new(within == ratios.len(), reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let (_, worst) = span(&evidence.values("updated / plain, ")?);
    let (mildest, _) = span(&evidence.values("updated / plain, run, ")?);
    Ok(vec![
        Reading::new(
            "“As well as” within a factor of ten.",
            worst <= 10.0,
            format!("up to {} times", told(worst)),
        ),
        Reading::new(
            "Over a whole run at the softest sheet, within a factor of two.",
            mildest <= LIMIT,
            format!("{} times", told(mildest)),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn every_stiffness_must_stay_within_the_factor() {
        let verdict = |step, run| {
            let numbers = [
                ("updated / plain, same step, h²k/m = 1e0", step),
                ("updated / plain, run, h²k/m = 1e0", run),
                ("updated / plain, same step, h²k/m = 1e1", 1.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(2.0, 1.0), Ruling::Holds);
        assert_eq!(verdict(2.1, 1.0), Ruling::Fails);
        assert_eq!(verdict(1.0, 2.1), Ruling::Fails);
    }
}
