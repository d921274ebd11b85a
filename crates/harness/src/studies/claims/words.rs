//! The words of the study `claims`.

use super::facts::{Facts, Row, Ruling};
use crate::claims::{Evidence, all, find};
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which of the paper's claims hold?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["hard-cases", "work-precision", "solver-control"];

/// Most things that a sentence lists.
const LIST: usize = 5;

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    let rows = &facts.claims;
    let count = |ruling: Ruling| rows.iter().filter(|row| row.verdict == ruling).count();
    let [confirmed, refuted, undecided] =
        [Ruling::Confirmed, Ruling::Refuted, Ruling::Undecided].map(count);
    let others = match undecided {
        0 => "no claim is undecided",
        1 => "one is undecided",
        _ => "the others are undecided",
    };
    let mut caveats = Vec::new();
    if rows.len() < all().len() {
        caveats.push(format!("Only {} of {} claims were tested.", rows.len(), all().len()));
    }
    caveats.extend([
        "A claim is general; its verdict holds for the scenes that were run.".to_owned(),
        "Counted work decides claims about time; where measured seconds disagree, the figure shows \
         the claim as undecided."
            .to_owned(),
    ]);
    let rounded = rows.iter().filter(|row| !row.portable).count();
    if rounded > 0 {
        caveats.push(format!(
            "Numbers of {rounded} claims may differ in their last digits between machines."
        ));
    }
    Words {
        conclusion: format!(
            "Of {} claims of the paper, {confirmed} are confirmed and {refuted} refuted; {others}.",
            rows.len()
        ),
        observations: [unrepaired(rows), worst(rows), open(rows)].into_iter().flatten().collect(),
        caveats,
    }
}

/// How many of the refuted claims have a remedy.
fn unrepaired(rows: &[Row]) -> Option<String> {
    let refuted: Vec<_> = rows.iter().filter(|row| row.verdict == Ruling::Refuted).collect();
    let is_repaired = |row: &&&Row| {
        let judge = |row: &Row| find(&row.id).ok()?.judge(&Evidence::new(&row.numbers)).repair;
        judge(row).is_some()
    };
    let repaired = refuted.iter().filter(is_repaired).count();
    (!refuted.is_empty()).then(|| {
        format!("A remedy was measured for {repaired} of the {} refuted claims.", refuted.len())
    })
}

/// The section of the paper with the smallest share of confirmed claims, among those with
/// several; none if two share that place.
fn worst(rows: &[Row]) -> Option<String> {
    let mut sections: Vec<(&str, usize, usize)> = Vec::new();
    for row in rows {
        let section = find(&row.id).ok()?.section;
        let is_confirmed = usize::from(row.verdict == Ruling::Confirmed);
        match sections.iter_mut().find(|(other, ..)| *other == section) {
            Some((_, confirmed, all)) => (*confirmed, *all) = (*confirmed + is_confirmed, *all + 1),
            None => sections.push((section, is_confirmed, 1)),
        }
    }
    let share = |(_, confirmed, all): &(&str, usize, usize)| *confirmed as f64 / *all as f64;
    sections.retain(|(.., all)| *all > 1);
    sections.sort_by(|a, b| share(a).total_cmp(&share(b)));
    let (section, confirmed, all) = *sections.first()?;
    let is_tie = sections.get(1).is_some_and(|next| share(next) == share(&sections[0]));
    (!is_tie).then(|| {
        format!("Section {section} fares worst: {confirmed} of {all} claims are confirmed.")
    })
}

/// The claims that the numbers cannot decide.
fn open(rows: &[Row]) -> Option<String> {
    let open = rows.iter().filter(|row| row.verdict == Ruling::Undecided);
    let ids: Vec<_> = open.map(|row| row.id.as_str()).collect();
    match ids.len() {
        0 => None,
        count if count > LIST => Some(format!("{count} claims are undecided.")),
        _ => {
            let ids = ids.join(", ");
            Some(format!("Undecided, because the criterion is met only in part: {ids}."))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(id: &str, verdict: Ruling, portable: bool) -> Row {
        let scenes = "none".to_owned();
        Row { id: id.to_owned(), verdict, numbers: Vec::new(), scenes, portable }
    }

    #[test]
    fn words_follow_from_the_verdicts() {
        let rows = [
            row("C01", Ruling::Confirmed, true),
            row("C04", Ruling::Refuted, false),
            row("C05", Ruling::Confirmed, true),
            row("C09", Ruling::Undecided, true),
        ];
        let said = words(&Facts { claims: rows.to_vec() });
        assert_eq!(
            said.conclusion,
            "Of 4 claims of the paper, 2 are confirmed and 1 refuted; one is undecided."
        );
        assert_eq!(said.observations[0], "A remedy was measured for 0 of the 1 refuted claims.");
        assert!(
            said.observations[1].starts_with("Section 3 fares worst"),
            "{:?}",
            said.observations
        );
        assert!(said.observations[1].ends_with("1 of 3 claims are confirmed."));
        assert!(said.observations[2].ends_with("in part: C09."));
        assert!(said.caveats[0].contains("4 of 29"), "{:?}", said.caveats);
        assert!(said.caveats.iter().any(|caveat| caveat.starts_with("Numbers of 1 claims")));
    }

    #[test]
    fn a_tie_of_sections_is_not_told() {
        let rows = ["C01", "C02", "C10", "C11"].map(|id| row(id, Ruling::Refuted, true));
        assert_eq!(worst(&rows), None);
        assert!(worst(&rows[..2]).is_some());
    }

    #[test]
    fn without_rows_there_is_still_a_conclusion() {
        let said = words(&Facts { claims: Vec::new() });
        assert!(said.conclusion.starts_with("Of 0 claims"), "{}", said.conclusion);
        assert!(said.observations.is_empty());
    }
}
