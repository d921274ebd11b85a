//! The words of the study `hard-cases`: its question, and the findings from its numbers.

use super::facts::{Cell, Expected, Facts, NOTHING_MOVES, PRINTED, SAFEGUARDED};
use crate::studies::names::{count, verb};
use drape_report::number::significant;
use drape_report::{Verdict, Words};
use std::collections::BTreeSet;

/// The question that the study answers.
pub(super) const QUESTION: &str =
    "Which methods stay stable in scenes where others fail, and does theory predict it?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["momentum", "stability"];

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> = [best(facts), theory(facts)].into_iter().flatten().collect();
    let conclusion = match &conclusion[..] {
        [] => "No run came to a verdict.".to_owned(),
        sentences => sentences.join(" "),
    };
    let observations =
        [theorem(facts), explicit_shear(facts), safeguard(facts), rest(facts), unstable(facts)];
    let observations = observations.into_iter().flatten().collect();
    Words { conclusion, observations, caveats: caveats(facts) }
}

fn judged(facts: &Facts) -> impl Iterator<Item = &Cell> {
    facts.cells.iter().filter(|cell| cell.verdict.is_judged())
}

/// The method that is stable most often.
fn best(facts: &Facts) -> Option<String> {
    let mut counts: Vec<(&str, usize, usize)> = Vec::new();
    for method in &facts.methods {
        let all = || judged(facts).filter(|cell| cell.method == *method);
        let stable = all().filter(|cell| cell.verdict == Verdict::Stable).count();
        if all().count() > 0 {
            counts.push((method, stable, all().count()));
        }
    }
    let always: Vec<_> = counts.iter().filter(|(_, stable, all)| stable == all).collect();
    let over = |method: &str| {
        let own = facts.cells.iter().filter(|cell| cell.method == *method);
        own.filter(|cell| cell.verdict == Verdict::OverBudget).count()
    };
    match &always[..] {
        [] => {
            let share = |(_, stable, all): &&(&str, usize, usize)| *stable as f64 / *all as f64;
            let best = counts.iter().max_by(|a, b| share(a).total_cmp(&share(b)))?;
            Some(format!(
                "No form is stable in every run; the best, `{}`, is stable in {} of {}.",
                best.0, best.1, best.2
            ))
        }
        [(method, stable, _)] => {
            let over = over(method);
            let but = match over {
                0 => String::new(),
                over => format!(", but {over} more ran over budget"),
            };
            Some(format!(
                "Only `{method}` is stable in every run that came to a verdict: in {stable}{but}."
            ))
        }
        several => Some(format!(
            "{} of {} forms are stable in every run that came to a verdict.",
            several.len(),
            counts.len()
        )),
    }
}

/// How many verdicts agree with theory.
fn theory(facts: &Facts) -> Option<String> {
    let predicted = judged(facts).filter(|cell| cell.expected != Expected::NoTheorem).count();
    let differing = facts.cells.iter().filter(|cell| cell.differs).count();
    let unexplained = match facts.unexplained.len() {
        0 if differing == 0 => String::new(),
        0 => ", each with an explanation".to_owned(),
        n => format!(", {n} of them without an explanation"),
    };
    (predicted > 0).then(|| {
        format!(
            "Theory covers {predicted} of {} verdicts; {} {} from it{unexplained}.",
            judged(facts).count(),
            if differing == 0 { "none".to_owned() } else { differing.to_string() },
            if differing > 1 { "differ" } else { "differs" }
        )
    })
}

/// How often the energy rose where the energy theorem holds.
fn theorem(facts: &Facts) -> Option<String> {
    let counted = || facts.cells.iter().filter(|cell| cell.is_monotone() && cell.shows_rises());
    let steps: u64 = counted().map(|cell| cell.steps).sum();
    let rises: u64 = counted().map(|cell| cell.rises).sum();
    let what = "the energy of IMEX Euler rose in";
    let cases = "steps of the cases that it covers";
    (steps > 0).then(|| match rises {
        0 => format!("As the energy theorem says, {what} none of {steps} {cases}."),
        _ => format!("Against the energy theorem, {what} {rises} of {steps} {cases}."),
    })
}

/// H16: shear springs as stiff as the tension springs, left out of the matrix.
fn explicit_shear(facts: &Facts) -> Option<String> {
    let of_case = facts.cells.iter().filter(|cell| cell.case.starts_with("H16"));
    let outside: Vec<_> =
        of_case.filter(|cell| cell.settings.contains("implicit=tension")).collect();
    let failing = outside.iter().filter(|cell| cell.verdict != Verdict::Stable).count();
    (failing > 0).then(|| {
        format!(
            "Shear springs as stiff as the tension springs must be in the matrix: without them, \
             {failing} of {} {} not stable (H16).",
            count(outside.len(), "run"),
            verb(failing, "is", "are")
        )
    })
}

/// H20: the energy that the paper's algorithm gains, and the verdict of its safeguarded form.
fn safeguard(facts: &Facts) -> Option<String> {
    let at = |method: &str| {
        let cells = facts.cells.iter().filter(|c| c.case.starts_with("H20") && c.method == method);
        cells.max_by(|a, b| a.gain.total_cmp(&b.gain))
    };
    let (paper, robust) = (at(PRINTED)?, at(SAFEGUARDED)?);
    Some(format!(
        "At ε = 0.1 (H20), updated CG as printed is {}: its energy rises by {} times the released \
         energy; its safeguarded form is {}.",
        paper.verdict,
        significant(paper.gain, 3),
        robust.verdict
    ))
}

/// How many forms move the sheet at rest.
fn rest(facts: &Facts) -> Option<String> {
    let looked = || facts.cells.iter().filter(|cell| cell.strayed_m.is_some());
    let moving = methods(looked().filter(|cell| !cell.note.is_empty()));
    let all = methods(looked());
    (all > 0).then(|| match moving {
        0 => "No form moves a sheet that starts at rest (H18).".to_owned(),
        n => format!(
            "{n} of {} {} a sheet that starts at rest (H18).",
            count(all, "form"),
            verb(n, "moves", "move")
        ),
    })
}

/// Number of methods, in a named form or at their defaults, that the cells belong to.
fn methods<'a>(cells: impl Iterator<Item = &'a Cell>) -> usize {
    cells.map(|cell| cell.method.as_str()).collect::<BTreeSet<_>>().len()
}

/// How few verdicts are stable.
fn unstable(facts: &Facts) -> Option<String> {
    let all = judged(facts).count();
    let stable = judged(facts).filter(|cell| cell.verdict == Verdict::Stable).count();
    (all > 0).then(|| format!("Over all forms, {stable} of {all} verdicts are `stable`."))
}

fn caveats(facts: &Facts) -> Vec<String> {
    let over = facts.cells.iter().filter(|cell| cell.verdict == Verdict::OverBudget).count();
    let over = (over > 0).then(|| {
        format!(
            "{over} of {} cells ran over budget and {} no verdict.",
            facts.cells.len(),
            verb(over, "has", "have")
        )
    });
    let trivial = judged(facts).filter(|cell| cell.reason == NOTHING_MOVES).count();
    let trivial = (trivial > 0).then(|| {
        format!(
            "{trivial} of the verdicts that theory covers {} scenes in which no spring moves.",
            verb(trivial, "concerns", "concern")
        )
    });
    let blind = facts.cells.iter().filter(|cell| cell.is_monotone() && !cell.shows_rises()).count();
    let blind = (blind > 0).then(|| {
        format!(
            "{} {} not counted for the energy theorem: round-off hides rises there.",
            count(blind, "cell"),
            verb(blind, "is", "are")
        )
    });
    let later = "Some rules of theory were derived after first runs had failed: they explain, but \
                 do not predict.";
    [over, trivial, blind, Some(later.to_owned())].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(case: &str, method: &str, verdict: Verdict, expected: Expected) -> Cell {
        Cell {
            case: case.to_owned(),
            method: method.to_owned(),
            is_damped: false,
            settings: "some:implicit=tension".to_owned(),
            verdict,
            note: String::new(),
            expected,
            reason: String::new(),
            differs: !expected.admits(verdict, 0),
            explanation: None,
            runs: 3,
            gain: 0.5,
            drift: 0.0,
            rises: 0,
            round_off: 0.0,
            steps: 100,
            reached_s: 1.0,
            cg_iterations: 0,
            newton_iterations: 0,
            unconverged_steps: 0,
            strayed_m: None,
            strayed_m_per_s: None,
            portable: true,
        }
    }

    fn facts(cells: Vec<Cell>) -> Facts {
        let mut methods: Vec<_> = cells.iter().map(|cell| cell.method.clone()).collect();
        methods.sort();
        methods.dedup();
        Facts { cases: Vec::new(), methods, cells, unexplained: Vec::new() }
    }

    #[test]
    fn the_conclusion_names_who_is_always_stable_and_what_differs_from_theory() {
        use Expected::{NoTheorem, Stable};
        let firm = cell("H01 a", "firm", Verdict::Stable, Stable);
        let over = cell("H02 b", "firm", Verdict::OverBudget, Stable);
        let weak = cell("H01 a", "weak", Verdict::Unstable, NoTheorem);
        let mut few = facts(vec![firm.clone(), over.clone(), weak.clone()]);
        assert_eq!(
            words(&few).conclusion,
            "Only `firm` is stable in every run that came to a verdict: in 1, but 1 more ran over \
             budget. Theory covers 1 of 2 verdicts; none differs from it."
        );
        assert!(words(&few).caveats[0].starts_with("1 of 3 cells ran over budget"));
        few.cells[0].verdict = Verdict::Marginal;
        few.cells[0].differs = true;
        let said = words(&few).conclusion;
        assert!(said.starts_with("No form is stable in every run; the best, `"), "{said}");
        assert!(said.ends_with("1 differs from it, each with an explanation."), "{said}");
        few.unexplained.push("H01 a".to_owned());
        let said = words(&few).conclusion;
        assert!(said.ends_with("1 differs from it, 1 of them without an explanation."), "{said}");
        let both = facts(vec![firm.clone(), Cell { method: "also".to_owned(), ..firm }]);
        assert!(words(&both).conclusion.starts_with("2 of 2 forms are stable in every run"));
        assert_eq!(words(&facts(vec![over])).conclusion, "No run came to a verdict.");
    }

    #[test]
    fn observations_tell_a_broken_theorem_and_who_moves_at_rest() {
        let monotone = cell("H01 a", "firm", Verdict::Stable, Expected::Monotone);
        let rising = Cell { rises: 2, ..monotone.clone() };
        let blind = Cell { round_off: 1.0, ..rising.clone() };
        let shear = cell("H16 shear", "firm", Verdict::Diverged, Expected::NoTheorem);
        let printed =
            Cell { gain: 800.0, ..cell("H20 ε", PRINTED, Verdict::Unstable, Expected::NoTheorem) };
        let safe = cell("H20 ε", SAFEGUARDED, Verdict::Stable, Expected::NoTheorem);
        let still = Cell { strayed_m: Some(0.0), ..monotone.clone() };
        let said = words(&facts(vec![
            monotone.clone(),
            blind.clone(),
            shear,
            printed,
            safe,
            still.clone(),
        ]));
        let text = said.observations.join("\n");
        for part in [
            "As the energy theorem says, the energy of IMEX Euler rose in none of 200 steps",
            "without them, 1 of 1 run is not stable (H16)",
            "as printed is unstable: its energy rises by 800 times",
            "its safeguarded form is stable",
            "No form moves a sheet that starts at rest (H18).",
            "4 of 6 verdicts are `stable`",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        assert!(said.caveats.iter().any(|c| c.starts_with("1 cell is not counted")), "{said:?}");
        let moving = Cell { note: "does not keep still".to_owned(), ..still };
        let text = words(&facts(vec![monotone, rising, moving])).observations.join("\n");
        assert!(
            text.contains("Against the energy theorem, the energy of IMEX Euler rose in 2 of 300"),
            "{text}"
        );
        assert!(text.contains("1 of 1 form moves a sheet that starts at rest (H18)"), "{text}");
    }
}
