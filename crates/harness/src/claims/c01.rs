//! C01: stationary iterations are unfit for stiff systems, CG fits.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C01",
    origin: Origin::Paper { section: "2.2" },
    says: "stationary iterations are unfit for stiff systems, CG fits",
    criterion: "At h²k/m = 100, to 1e-6, Jacobi needs more than 10 times as many sweeps as CG \
                iterations.",
    reads: &["Jacobi / CG, ", "over-relaxed sweeps with the best factor, ", "CG iterations, "],
    overturned_by: "One system on which Jacobi needs at most 10 times as many sweeps refutes it.",
    see: "cg-vs-theta.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Least ratio of sweeps to iterations.
pub(crate) const RATIO: f64 = 10.0;

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let (worst, _) = span(&evidence.values("Jacobi / CG, ")?);
    let relaxed =
        evidence.quotients("over-relaxed sweeps with the best factor, ", "CG iterations, ")?;
    let (low, high) = span(&relaxed);
    let reason = format!(
        "Jacobi needs at least {} times as many sweeps as CG needs iterations. Over-relaxation \
         with the best factor is stationary too, but needs only {} to {} times as many.",
        told(worst),
        told(low),
        told(high)
    );
    Ok(Judgement::new(worst > RATIO, reason))
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let relaxed =
        evidence.quotients("over-relaxed sweeps with the best factor, ", "CG iterations, ")?;
    let (low, high) = span(&relaxed);
    Ok(vec![Reading::new(
        "Over-relaxation with the best factor, the best stationary iteration, needs more than 10 \
         times as many sweeps.",
        low > RATIO,
        format!("{} to {} times", told(low), told(high)),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn the_worst_ratio_decides() {
        let verdict = |ratios: [f64; 2]| {
            let numbers = [
                ("Jacobi / CG, a", ratios[0]),
                ("Jacobi / CG, b", ratios[1]),
                ("over-relaxed sweeps with the best factor, a", 5.0),
                ("CG iterations, a", 4.0),
            ];
            judged(&CLAIM, &numbers).verdict
        };
        assert_eq!(verdict([30.0, 11.0]), Ruling::Holds);
        assert_eq!(verdict([30.0, 9.0]), Ruling::Fails);
    }
}
