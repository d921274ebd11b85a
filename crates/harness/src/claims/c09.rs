//! C09: post-correction of elongated springs is not physically sound.

use super::{Age, Claim, Evidence, Judgement, Missing, Origin, Reading, Ruling, span, told};

pub(super) const CLAIM: Claim = Claim {
    id: "C09",
    origin: Origin::Paper { section: "3" },
    says: "post-correction of elongated springs is not physically sound",
    criterion: "At limit 0.1 the order of the sweep moves the final positions by more than 1 % of \
                the motion, or they do not approach the stiff reference as the limit falls to \
                0.01.",
    reads: &[
        "difference between orders over motion, ",
        "distance from the stiff reference over motion, limit ",
        "the same between starts 1e-9 m apart, ",
    ],
    overturned_by: "Cases that all agree decide it.",
    see: "post-correction-order.svg",
    age: Age::FIRST,
    judge,
    readings,
};

/// Greatest accepted difference between orders, over the motion.
pub(crate) const ORDER: f64 = 0.01;
/// Limits of the elongation, falling.
pub(crate) const LIMITS: [f64; 3] = [0.1, 0.03, 0.01];

fn judge(evidence: Evidence<'_>) -> Result<Judgement, Missing> {
    let spreads = evidence.rows("difference between orders over motion, ")?;
    let (mut depending, mut astray, mut unsound) = (0, 0, 0);
    for (name, spread) in &spreads {
        let of = |limit: f64| {
            let what = "distance from the stiff reference over motion, limit";
            evidence.value(&format!("{what} {limit}, {name}"))
        };
        let [a, b, c] = LIMITS.map(of);
        let (a, b, c) = (a?, b?, c?);
        let (depends, approaches) = (spread.value > ORDER, b < a && c < b);
        depending += usize::from(depends);
        astray += usize::from(!approaches);
        unsound += usize::from(depends || !approaches);
    }
    let values: Vec<_> = spreads.iter().map(|(_, spread)| spread.value).collect();
    let (_, spread) = span(&values);
    let (_, control) = span(&evidence.values("the same between starts 1e-9 m apart, ")?);
    let verdict = match unsound {
        0 => Ruling::Fails,
        count if count == spreads.len() => Ruling::Holds,
        _ => Ruling::Undecided,
    };
    let reason = format!(
        "The order of the sweep matters in {depending} of {} cases, by up to {} of the motion; \
         starts a nanometre apart differ by at most {}. In {astray} cases the sheet does not \
         approach the stiff one.",
        spreads.len(),
        told(spread),
        told(control)
    );
    Ok(Judgement { verdict, reason, repair: None })
}

fn readings(evidence: Evidence<'_>) -> Result<Vec<Reading>, Missing> {
    let spreads = evidence.values("difference between orders over motion, ")?;
    let depending = spreads.iter().filter(|spread| **spread > ORDER).count();
    Ok(vec![Reading::new(
        "“Not guaranteed”: one case in which the order of the sweep matters is enough.",
        depending > 0,
        format!("it matters in {depending} of {} cases", spreads.len()),
    )])
}

#[cfg(test)]
mod tests {
    use super::super::{Number, Ruling, Standing, standing};
    use super::*;

    /// What is recorded of a case.
    fn case(name: &str, spread: f64, errors: [f64; 3]) -> Vec<Number> {
        let number = |what: &str, value| Number::new(format!("{what}, {name}"), value, "");
        let mut numbers = vec![
            number("difference between orders over motion", spread),
            number("the same between starts 1e-9 m apart", 0.0),
        ];
        let what = "distance from the stiff reference over motion, limit";
        let errors = LIMITS.iter().zip(errors);
        numbers.extend(errors.map(|(limit, error)| number(&format!("{what} {limit}"), error)));
        numbers
    }

    #[test]
    fn all_cases_must_agree() {
        let sound = case("a", 0.001, [0.3, 0.2, 0.1]);
        let depending = case("b", 0.02, [0.3, 0.2, 0.1]);
        let astray = case("c", 0.001, [0.3, 0.2, 0.25]);
        let resting = case("d", 0.001, [0.3, 0.2, 0.2]);
        let verdict = |cases: &[&[Number]]| CLAIM.judge(&Evidence::new(&cases.concat())).verdict;
        assert_eq!(verdict(&[&depending, &astray]), Ruling::Holds);
        assert_eq!(verdict(&[&depending, &sound]), Ruling::Undecided);
        assert_eq!(verdict(&[&sound]), Ruling::Fails);
        assert_eq!(verdict(&[&astray]), Ruling::Holds);
        assert_eq!(verdict(&[&resting]), Ruling::Holds);
    }

    /// One reading that holds does not outvote a criterion that is met only in part.
    #[test]
    fn it_does_not_hold_while_its_criterion_is_undecided() {
        let stands = |other: &[Number]| {
            let numbers = [case("b", 0.02, [0.3, 0.2, 0.1]), other.to_vec()].concat();
            let verdict = CLAIM.judge(&Evidence::new(&numbers)).verdict;
            (verdict, standing(CLAIM.id, verdict, &numbers))
        };
        let sound = case("a", 0.001, [0.3, 0.2, 0.1]);
        assert_eq!(stands(&sound), (Ruling::Undecided, Standing::Depends));
        let depending = case("a", 0.02, [0.3, 0.2, 0.1]);
        assert_eq!(stands(&depending), (Ruling::Holds, Standing::Holds));
    }
}
