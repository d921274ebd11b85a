//! C14: a finer mesh is stiffer.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C14",
    origin: Origin::Paper { section: "5" },
    says: "a finer mesh is stiffer",
    criterion: "At fixed material the largest frequency grows with N.",
    reads: &["largest frequency, ", "the same, N = 80 over N = 5, at fixed k/m, grid"],
    overturned_by: "One refinement after which the largest frequency is not larger refutes it.",
    see: "cg-vs-stiffness.svg",
    age: Age::FIRST,
    judge,
    readings,
};

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let series = evidence.series("largest frequency, ", ", N = ")?;
    let spread = evidence.value("the same, N = 80 over N = 5, at fixed k/m, grid")?;
    let grows = series.iter().all(|(_, s)| s.windows(2).all(|pair| pair[1] > pair[0]));
    let growth = |s: &[f64]| s.last().zip(s.first()).map_or(0.0, |(last, first)| last / first);
    let (least, _) = span(&series.iter().map(|(_, s)| growth(s)).collect::<Vec<_>>());
    let trend = if grows { "grows" } else { "does not grow" };
    let reason = format!(
        "At fixed material the largest frequency {trend} with every refinement, by a factor of at \
         least {} in all. At fixed k/m it changes by a factor of {}, so a finer mesh is a softer \
         cloth there.",
        told(least),
        told(spread)
    );
    Ok(Judgement::new(grows, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let spread = evidence.value("the same, N = 80 over N = 5, at fixed k/m, grid")?;
    Ok(vec![Reading::new(
        "The mesh is refined at fixed k/m: the largest frequency grows by more than 10 %.",
        spread > 1.1,
        format!("by a factor of {} from N = 5 to N = 80", told(spread)),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn one_refinement_that_does_not_stiffen_refutes() {
        let verdict = |last| {
            let numbers = [
                ("largest frequency, grid, N = 5", 1.0),
                ("largest frequency, grid, N = 10", 2.0),
                ("largest frequency, triangles, N = 5", 1.0),
                ("largest frequency, triangles, N = 10", 1.1),
                ("largest frequency, triangles, N = 20", last),
                ("the same, N = 80 over N = 5, at fixed k/m, grid", 1.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(1.2), Ruling::Holds);
        assert_eq!(verdict(1.1), Ruling::Fails);
    }
}
