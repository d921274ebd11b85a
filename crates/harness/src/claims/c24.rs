//! C24: updated CG needs fewer iterations than plain CG on the full system.

use super::{Age, Claim, Evidence, Judgement, Missing, Number, Origin, Reading, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C24",
    origin: Origin::Paper { section: "7" },
    says: "updated CG needs fewer iterations than plain CG on the full system",
    criterion: "Updated CG takes fewer iterations at equal error, in every comparison.",
    reads: &["updated, ", "full system, "],
    overturned_by: "It is confirmed if updated CG wins every comparison.",
    see: "work-precision.svg",
    age: Age::changed("35329f5", "says that each comparison counts; the verdict is the same"),
    judge,
    readings,
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

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    // A family that never reaches the error has no number.
    let updated = evidence.rows("updated, ")?;
    let fewer = |family: &str, stiffness: &[&str]| {
        let mut wins = (0, 0);
        for (at, number) in &updated {
            if stiffness.iter().any(|k| at.starts_with(&format!("k/m = {k},"))) {
                let other = evidence.value(&format!("{family}, {at}"));
                wins.0 += usize::from(other.map_or(true, |other| number.value < other));
                wins.1 += 1;
            }
        }
        wins
    };
    let plain = fewer("plain IMEX", &["1e5", "1e6", "1e7", "1e8"]);
    let soft = fewer("full system", &["1e5", "1e6"]);
    let seen = |(wins, all): (usize, usize)| format!("fewer in {wins} of {all} comparisons");
    Ok(vec![
        Reading::new(
            "“Plain CG” is that of plain IMEX Euler, which locks and so needs shorter steps.",
            plain.0 == plain.1,
            seen(plain),
        ),
        Reading::new(
            "On the full system, for the stiffness of the paper's tables, up to k/m = 1e6.",
            soft.0 == soft.1,
            seen(soft),
        ),
    ])
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
        assert_eq!(with(&[("updated, b", 5.0)]), Ruling::Holds);
        assert_eq!(with(&[("updated, b", 7.0), ("full system, b", 6.0)]), Ruling::Fails);
        assert_eq!(with(&[("full system, b", 6.0)]), Ruling::Fails);
        assert_eq!(verdict(&[]), Ruling::Undecided);
    }
}
