//! C15: CG is cheaper than multiplying with an inverse.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C15",
    origin: Origin::Paper { section: "5" },
    says: "CG is cheaper than multiplying with an inverse",
    criterion: "A step with CG takes fewer operations from n = 400 on. The crossover is reported.",
    reads: &[
        "inverse / CG, least over the paper's six rows, ε = 5e-2",
        "inverse / CG, least over the paper's six rows, ε = 1e-3",
        "inverse / CG, least over the six rows with the paper's own counts",
        "cheaper from this n on, ",
    ],
    overturned_by: "A row of the paper, or a sheet of 400 particles, on which the inverse is \
                    cheaper refutes it.",
    see: "inverse-cost.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Particles from which CG must be cheaper.
const FROM: f64 = 400.0;
/// The tolerances at which the method is used.
const USED: [&str; 2] = ["ε = 5e-2", "ε = 1e-3"];

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let least = |term: &str| {
        evidence.value(&format!("inverse / CG, least over the paper's six rows, {term}"))
    };
    let [loose, tight] = USED.map(least);
    let (loose, tight) = (loose?, tight?);
    let what = "inverse / CG, least over the six rows with the paper's own counts";
    let printed = evidence.value(what)?;
    let crossovers = evidence.rows("cheaper from this n on, ")?;
    let used = crossovers.iter().filter(|(at, _)| USED.iter().any(|term| at.ends_with(term)));
    let crossover = used.fold(0.0_f64, |most, (_, number)| most.max(number.value));
    let reason = format!(
        "On the paper's scenes the inverse takes at least {} (ε = 0.05) and {} (ε = 1e-3) times \
         the operations of CG, and {} times with the paper's own counts. CG wins from n = {} on.",
        told(loose),
        told(tight),
        told(printed),
        told(crossover)
    );
    Ok(Judgement::new(
        [loose, tight, printed].iter().all(|r| *r > 1.0) && crossover <= FROM,
        reason,
    ))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let tight = "ε = 1e-10";
    let rows = evidence.rows("cheaper from this n on, ")?;
    let from = rows.iter().filter(|(at, _)| at.ends_with(tight));
    let from = from.fold(0.0_f64, |most, (_, number)| most.max(number.value));
    Ok(vec![Reading::new(
        "Both give the same solution: CG to 1e-10 is cheaper from n = 400 on.",
        from <= FROM,
        format!("it is cheaper from n = {} on", told(from)),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn it_is_decided_at_the_tolerances_that_are_used_and_by_the_crossover() {
        let verdict = |loose, tight, crossover| {
            let numbers = [
                ("inverse / CG, least over the paper's six rows, ε = 5e-2", loose),
                ("inverse / CG, least over the paper's six rows, ε = 1e-3", tight),
                ("inverse / CG, least over the paper's six rows, ε = 1e-10", 0.5),
                ("inverse / CG, least over the six rows with the paper's own counts", 2.0),
                ("cheaper from this n on, k/m = 1e6, ε = 5e-2", 36.0),
                ("cheaper from this n on, k/m = 1e6, ε = 1e-3", crossover),
                ("cheaper from this n on, k/m = 1e6, ε = 1e-10", 2704.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict(9.0, 5.0, 400.0), Ruling::Holds);
        assert_eq!(verdict(9.0, 0.9, 400.0), Ruling::Fails);
        assert_eq!(verdict(9.0, 5.0, 784.0), Ruling::Fails);
    }
}
