//! C24: updated CG needs fewer iterations than plain CG on the full system.

use super::{Claim, Evidence, Judgement, Missing, Number, Origin, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C24",
    origin: Origin::Paper { section: "7" },
    says: "updated CG needs fewer iterations than plain CG on the full system",
    criterion: "Updated CG takes fewer iterations at equal error, in every comparison.",
    reads: &["updated, ", "full system, "],
    overturned_by: "It is confirmed if updated CG wins every comparison.",
    see: "work-precision.svg",
    judge,
};

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    // A family that never reaches the error has no number.
    let (updated, full) = (evidence.rows("updated, ")?, evidence.rows("full system, ")?);
    let count = |rows: &[(&str, &Number)], at: &str| {
        rows.iter().find(|(other, _)| *other == at).map(|(_, number)| number.value)
    };
    let mut ratios = Vec::new();
    for (at, number) in &updated {
        ratios.push(count(&full, at).map_or(0.0, |full| number.value / full));
    }
    let lost = full.iter().filter(|(at, _)| count(&updated, at).is_none()).count();
    let (all, fewer) = (ratios.len() + lost, ratios.iter().filter(|ratio| **ratio < 1.0).count());
    let (low, high) = span(&ratios);
    let reason = format!(
        "At equal error updated CG takes {} to {} times the iterations of plain CG on the full \
         system, and fewer in {fewer} of {all} comparisons. Its updates grow in number with θ; \
         Newton's steps do not.",
        told(low),
        told(high)
    );
    Ok(Judgement::new(fewer == all, reason))
}

#[cfg(test)]
mod tests {
    use super::super::{Ruling, judged};
    use super::*;

    #[test]
    fn it_must_win_every_comparison_and_not_reaching_the_error_loses() {
        let verdict = |numbers: &[(&str, f64)]| judged(&CLAIM, numbers).verdict;
        let won = [("updated, a", 5.0), ("full system, a", 6.0)];
        let with = |more: &[(&'static str, f64)]| verdict(&[&won, more].concat());
        assert_eq!(with(&[("updated, b", 5.0)]), Ruling::Confirmed);
        assert_eq!(with(&[("updated, b", 7.0), ("full system, b", 6.0)]), Ruling::Refuted);
        assert_eq!(with(&[("full system, b", 6.0)]), Ruling::Refuted);
        assert_eq!(verdict(&[]), Ruling::Undecided);
    }
}
