//! The words of the study `regret`: its question, and the findings from its numbers.

use super::facts::{Case, Facts, MEDIAN, MET, Outcome, Tally, WORST};
use drape_report::Words;
use drape_report::number::{median, percent, significant};

/// The question that the study answers.
pub(super) const QUESTION: &str = "Is the advice of drape compare as good as an exhaustive search, \
     on scenes on which no form was tuned?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["work-precision", "animation"];

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> = [met(facts), cost(facts)].into_iter().flatten().collect();
    let conclusion = match &conclusion[..] {
        [] => "No case could be judged.".to_owned(),
        sentences => sentences.join(" "),
    };
    let observations = [effort(facts), worst(facts), same(facts), lacking(facts), none(facts)];
    let caveats = [
        untrusted(facts),
        not_measured(facts),
        Some(
            "Time is modelled from counted work, so the facts are the same everywhere; the tables \
             by the clock hold for one machine."
                .to_owned(),
        ),
        Some(
            "Advice and search share the modelled prices and the true motion, so a regret of 1 says \
             only that the comparison leaves out no better run; an error of the prices cancels. \
             Only the clock tests the prices."
                .to_owned(),
        ),
        Some(
            "The scenes have at most 144 particles, last half a second, and hold only springs, \
             gravity and pins, because prices know no other force. Only the clock judges contact, \
             friction, wind and angles."
                .to_owned(),
        ),
    ];
    Words {
        conclusion,
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats.into_iter().flatten().collect(),
    }
}

fn tally(facts: &Facts) -> Tally {
    Tally::of(facts.cases.iter().filter_map(Case::outcome))
}

/// How often the target is met on the pushed cloth.
fn met(facts: &Facts) -> Option<String> {
    let tally = tally(facts);
    let verdict = if tally.share()? >= MET { "as it should" } else { "and should more often" };
    Some(format!(
        "The advised run meets its target, measured again on a pushed cloth, in {} of {} cases, \
         {verdict} (at least {}).",
        tally.met,
        tally.measured(),
        percent(MET, 2)
    ))
}

fn regrets(facts: &Facts) -> impl Iterator<Item = f64> {
    facts.cases.iter().filter_map(|case| case.regret)
}

/// The regret of the advice, and the effort of the comparison.
fn cost(facts: &Facts) -> Option<String> {
    let (middle, worst) = (median(regrets(facts))?, regrets(facts).reduce(f64::max)?);
    let is_kept = middle <= MEDIAN && worst <= WORST;
    let verdict = if is_kept { "within" } else { "beyond" };
    Some(format!(
        "It takes {} times as long as the best form in the median and {} times at most, which is \
         {verdict} the aim of {MEDIAN} and {WORST}.",
        significant(middle, 3),
        significant(worst, 3)
    ))
}

fn effort(facts: &Facts) -> Option<String> {
    let middle = median(facts.cases.iter().map(|case| case.effort))?;
    Some(format!(
        "The comparison needs {} of the modelled time of the exhaustive search, in the median.",
        percent(middle, 2)
    ))
}

/// The case with the greatest regret.
fn worst(facts: &Facts) -> Option<String> {
    let regret = |case: &&Case| case.regret.unwrap_or(0.0);
    let case = facts.cases.iter().max_by(|a, b| regret(a).total_cmp(&regret(b)))?;
    let (advice, best) = case.advice.as_ref().zip(case.best.as_ref())?;
    (regret(&case) > 1.0).then(|| {
        format!(
            "The regret is greatest for `{}` at {} mm: the advice is {} with {} steps a frame, and \
             the best form is {} with {}.",
            case.scene,
            significant(1e3 * case.target_m, 2),
            advice.label,
            advice.substeps,
            best.label,
            best.substeps
        )
    })
}

fn same(facts: &Facts) -> Option<String> {
    let found = facts.cases.iter().filter(|case| case.regret.is_some_and(|regret| regret <= 1.0));
    let all = regrets(facts).count();
    (all > 0)
        .then(|| format!("In {} of {all} cases, the comparison finds the best run.", found.count()))
}

fn count(facts: &Facts, is_it: impl Fn(&Case) -> bool) -> Option<String> {
    match facts.cases.iter().filter(|case| is_it(case)).count() {
        0 => None,
        1 => Some("1 case".to_owned()),
        count => Some(format!("{count} cases")),
    }
}

/// How many cases lack an advice although the search found a run that meets the target.
fn lacking(facts: &Facts) -> Option<String> {
    let cases = count(facts, Case::lacks_advice)?;
    Some(format!(
        "In {cases}, the search finds a form that meets the target but the comparison finds none; \
         that counts as not met."
    ))
}

fn none(facts: &Facts) -> Option<String> {
    let cases = count(facts, |case| case.best.is_none())?;
    Some(format!("In {cases}, the search finds no form that meets the target."))
}

fn untrusted(facts: &Facts) -> Option<String> {
    let cases = count(facts, |case| !case.is_trusted)?;
    Some(format!("The true motion is not trusted in {cases}."))
}

fn not_measured(facts: &Facts) -> Option<String> {
    let cases = count(facts, |case| case.outcome() == Some(Outcome::NotMeasured))?;
    Some(format!(
        "In {cases}, no true motion was found for the pushed cloth: this counts neither as met nor \
         as missed."
    ))
}

#[cfg(test)]
mod tests {
    use super::super::facts::Pick;
    use super::*;

    fn case(regret: f64, again_m: Option<f64>) -> Case {
        let pick = |label: &str, frame_s| Pick {
            label: label.to_owned(),
            method: label.to_owned(),
            substeps: 4,
            error_m: 0.008,
            frame_s,
        };
        Case {
            scene: "strip".to_owned(),
            description: String::new(),
            particles: 105,
            target_m: 0.01,
            good_m: 0.01,
            is_trusted: true,
            best: Some(pick("best", 1.0)),
            advice: Some(pick("advised", regret)),
            regret: Some(regret),
            effort: 0.2,
            again_m,
            again_good_m: Some(0.01),
            portable: false,
        }
    }

    #[test]
    fn the_conclusion_judges_targets_and_regret() {
        let good = Facts { cases: vec![case(1.0, Some(0.009)), case(1.2, Some(0.01))] };
        let said = words(&good).conclusion;
        assert!(said.contains("in 2 of 2 cases, as it should"), "{said}");
        assert!(
            said.contains("1.10 times as long as the best form in the median and 1.20"),
            "{said}"
        );
        assert!(said.contains("within the aim"), "{said}");
        let bad = Facts { cases: vec![case(1.0, None), case(1.6, Some(0.02))] };
        let said = words(&bad).conclusion;
        assert!(said.contains("in 0 of 2 cases, and should more often"), "{said}");
        assert!(said.contains("beyond the aim"), "{said}");
        let caveats = words(&good).caveats.join(" ");
        assert!(caveats.contains("an error of the prices cancels"), "{caveats}");
        assert_eq!(words(&Facts { cases: vec![] }).conclusion, "No case could be judged.");
    }

    #[test]
    fn an_advice_that_is_missing_counts_as_missed_and_one_that_was_not_measured_does_not() {
        let lacking = Case { advice: None, regret: None, again_good_m: None, ..case(1.0, None) };
        let unknown = Case { again_good_m: None, ..case(1.0, None) };
        let hopeless = Case { best: None, ..lacking.clone() };
        let cases = vec![case(1.0, Some(0.009)), lacking, unknown, hopeless];
        let said = words(&Facts { cases });
        assert!(said.conclusion.contains("in 1 of 2 cases, and should more"), "{said:?}");
        let observed = said.observations.join(" ");
        assert!(observed.contains("In 1 case, the search finds a form that meets"), "{said:?}");
        assert!(observed.contains("In 1 case, the search finds no form"), "{said:?}");
        let caveats = said.caveats.join(" ");
        assert!(caveats.contains("In 1 case, no true motion was found"), "{said:?}");
    }
}
