//! The words of the study `effects`: its question, and the findings from its numbers.

use super::facts::{Cell, EVERYTHING, Effect, Facts, NOTHING};
use crate::studies::names::verb;
use drape_report::number::{setting, significant};
use drape_report::{Verdict, Words};

/// The question that the study answers.
pub(super) const QUESTION: &str = "What does each effect of a scene cost and change, and does \
                                   an effect that is not named cost anything?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];

/// The findings that the facts support.
pub(super) fn words(facts: &Facts) -> Words {
    let conclusion: Vec<_> =
        [Some(matrices(facts)), dearest(facts)].into_iter().flatten().collect();
    let observations =
        [support(facts), idle(facts), together(facts), changes(facts), outcomes(facts)];
    Words {
        conclusion: conclusion.join(" "),
        observations: observations.into_iter().flatten().collect(),
        caveats: caveats(facts),
    }
}

/// The additions that are measured by themselves.
fn single(facts: &Facts) -> impl Iterator<Item = &Effect> {
    facts.effects.iter().filter(|e| ![NOTHING, EVERYTHING].contains(&e.name.as_str()))
}

fn completed(facts: &Facts) -> impl Iterator<Item = &Cell> {
    facts.cells.iter().filter(|cell| cell.verdict == Verdict::Completed)
}

fn of<'a>(facts: &'a Facts, method: &'a str) -> impl Iterator<Item = &'a Cell> {
    facts.cells.iter().filter(move |cell| cell.method == method)
}

/// How many effects enlarge which matrix.
fn matrices(facts: &Facts) -> String {
    let bare = |value: fn(&Effect) -> usize| {
        let nothing = facts.effects.iter().find(|effect| effect.name == NOTHING);
        nothing.map_or(0, value)
    };
    let grown = |value: fn(&Effect) -> usize| {
        single(facts).filter(|effect| value(effect) > bare(value)).count()
    };
    let (scalar, block) = (grown(|effect| effect.springs), grown(|effect| effect.coupled_pairs));
    format!(
        "Of {} additions, {scalar} {} the scalar matrix of IMEX methods and {block} {} the matrix \
         of 3×3 blocks; the others keep the pattern.",
        single(facts).count(),
        verb(scalar, "enlarges", "enlarge"),
        verb(block, "enlarges", "enlarge")
    )
}

/// CG iterations of a cell, over those of the bare scene with the same method.
fn ratio(facts: &Facts, cell: &Cell) -> Option<f64> {
    let is_bare = |other: &&Cell| other.effect == NOTHING && other.method == cell.method;
    let bare = completed(facts).find(is_bare).filter(|bare| bare.cg_iterations > 0)?;
    Some(cell.cg_iterations as f64 / bare.cg_iterations as f64)
}

/// The effect and the method with the most CG iterations, relative to the bare sheet.
fn dearest(facts: &Facts) -> Option<String> {
    let alone = completed(facts).filter(|cell| ![NOTHING, EVERYTHING].contains(&&*cell.effect));
    let ratios = alone.filter_map(|cell| Some((ratio(facts, cell)?, cell)));
    let (ratio, cell) = ratios.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!(
        "`{}` costs most: `{}` takes {} times the CG iterations of the bare sheet.",
        cell.effect,
        cell.method,
        significant(ratio, 2)
    ))
}

fn support(facts: &Facts) -> Option<String> {
    let all = facts.supports.len();
    let refused = facts.supports.iter().filter(|support| support.treatment == "refused").count();
    (all > 0).then(|| match refused {
        0 => format!("Every method takes every effect: none of {all} pairs is refused."),
        n => format!(
            "{n} of {all} pairs of a method and an effect {} refused.",
            verb(n, "is", "are")
        ),
    })
}

/// An addition that changes nothing.
fn idle(facts: &Facts) -> Option<String> {
    let changes_nothing = |effect: &&Effect| {
        let mut cells = facts.cells.iter().filter(|cell| cell.effect == effect.name).peekable();
        let same =
            |cell: &Cell| cell.change_m == Some(0.0) && ratio(facts, cell).is_none_or(|r| r == 1.0);
        cells.peek().is_some() && cells.all(same)
    };
    let effect = single(facts).find(changes_nothing)?;
    Some(format!("`{}` changes no position and no CG iteration, with any method.", effect.name))
}

fn together(facts: &Facts) -> Option<String> {
    let cells = completed(facts).filter(|cell| cell.effect == EVERYTHING);
    let ratios: Vec<_> = cells.filter_map(|cell| ratio(facts, cell)).collect();
    let least = ratios.iter().copied().reduce(f64::min)?;
    let most = ratios.iter().copied().reduce(f64::max)?;
    Some(format!(
        "`{EVERYTHING}` takes {} to {} times the CG iterations of the bare sheet, by method.",
        significant(least, 2),
        significant(most, 2)
    ))
}

/// The effects that move the sheet most and least. The method is that with the shortest step, of
/// those that complete all runs.
fn changes(facts: &Facts) -> Option<String> {
    let completes = |m: &&String| of(facts, m).all(|cell| cell.verdict == Verdict::Completed);
    let step = |m: &String| of(facts, m).map(|cell| cell.step_s).fold(f64::INFINITY, f64::min);
    let methods = facts.methods.iter().filter(completes);
    let method = methods.min_by(|a, b| step(a).total_cmp(&step(b)))?;
    let alone = || of(facts, method).filter(|cell| ![NOTHING, EVERYTHING].contains(&&*cell.effect));
    let changes = || alone().filter_map(|cell| Some((cell.change_m?, cell.effect.as_str())));
    let (most, what) = changes().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let (least, little) = changes().filter(|c| c.0 > 0.0).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!(
        "By the end, `{what}` has moved the sheet most, by {} m, and `{little}` least, by {} m \
         ({method}).",
        significant(most, 2),
        significant(least, 1)
    ))
}

/// Numbers of runs that were refused or diverged.
fn outcomes(facts: &Facts) -> Option<String> {
    let count = |verdict| facts.cells.iter().filter(|cell| cell.verdict == verdict).count();
    let (refused, diverged) = (count(Verdict::Refused), count(Verdict::Diverged));
    let all = facts.cells.len();
    (all > 0).then(|| match (refused, diverged) {
        (0, 0) => format!("All {all} runs completed."),
        _ => format!(
            "Of {all} runs, {diverged} diverged and {refused} {} refused by name.",
            verb(refused, "was", "were")
        ),
    })
}

fn caveats(facts: &Facts) -> Vec<String> {
    let left_out = facts.left_out().len();
    let left_out = (left_out > 0).then(|| {
        format!(
            "`{EVERYTHING}` leaves out {left_out} of {} additions: another of their kind replaces \
             them.",
            single(facts).count()
        )
    });
    let span = format!(
        "One undamped sheet falls for {} s; CG iterations of other scenes may rise by more.",
        setting(facts.duration_s)
    );
    left_out.into_iter().chain([span]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effect(name: &str, adds: &str, springs: usize, coupled_pairs: usize) -> Effect {
        Effect { name: name.to_owned(), adds: adds.to_owned(), objects: 2, springs, coupled_pairs }
    }

    fn cell(effect: &str, method: &str, cg_iterations: u64, change_m: f64) -> Cell {
        Cell {
            effect: effect.to_owned(),
            method: method.to_owned(),
            step_s: 0.01,
            verdict: Verdict::Completed,
            steps: 50,
            cg_iterations,
            newton_iterations: 0,
            matvecs: 0,
            force_evaluations: 0,
            setups: 0,
            change_m: Some(change_m),
            portable: true,
        }
    }

    fn facts() -> Facts {
        Facts {
            scene: "{}".to_owned(),
            duration_s: 0.5,
            effects: vec![
                effect(NOTHING, "{}", 10, 10),
                effect("shear", r#"{"effects":{"shear":1}}"#, 15, 15),
                effect("angle", r#"{"effects":{"angle":1}}"#, 10, 15),
                effect("far ball", r#"{"obstacles":[{"far":1}]}"#, 10, 10),
                effect(EVERYTHING, r#"{"effects":{"shear":1},"obstacles":[{"far":1}]}"#, 15, 15),
            ],
            methods: vec!["a".to_owned()],
            supports: Vec::new(),
            cells: vec![
                cell(NOTHING, "a", 10, 0.0),
                cell("shear", "a", 12, 0.5),
                cell("angle", "a", 35, 0.25),
                cell("far ball", "a", 10, 0.0),
                cell(EVERYTHING, "a", 40, 0.75),
            ],
        }
    }

    #[test]
    fn words_tell_what_grows_costs_and_changes() {
        let said = words(&facts());
        assert_eq!(
            said.conclusion,
            "Of 3 additions, 1 enlarges the scalar matrix of IMEX methods and 2 enlarge the matrix \
             of 3×3 blocks; the others keep the pattern. `angle` costs most: `a` takes 3.5 times \
             the CG iterations of the bare sheet."
        );
        let text = said.observations.join("\n");
        for part in [
            "`far ball` changes no position",
            "takes 4.0 to 4.0 times",
            "`shear` has moved the sheet most, by 0.50 m, and `angle` least, by 0.2 m (a).",
            "All 5 runs completed.",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        assert!(said.caveats[0].contains("leaves out 1 of 3 additions"), "{said:?}");
    }

    #[test]
    fn a_far_ball_that_moves_a_sheet_is_not_idle_and_what_fails_is_counted() {
        let mut facts = facts();
        facts.cells[3].change_m = Some(0.1);
        facts.cells[1].verdict = Verdict::Diverged;
        facts.cells[2].verdict = Verdict::Refused;
        let support = |treatment: &str| super::super::facts::Support {
            effect: "shear".to_owned(),
            method: "a".to_owned(),
            treatment: treatment.to_owned(),
        };
        facts.supports = vec![support("implicit"), support("refused")];
        let text = words(&facts).observations.join("\n");
        assert!(!text.contains("changes no position"), "{text}");
        assert!(text.contains("Of 5 runs, 1 diverged and 1 was refused"), "{text}");
        assert!(text.contains("1 of 2 pairs of a method and an effect is refused"), "{text}");
        // A subset without single additions has no most expensive one.
        facts.cells.truncate(1);
        let said = words(&facts);
        assert!(said.conclusion.ends_with("the others keep the pattern."), "{said:?}");
    }
}
