//! The words of the study `claims`.

use super::facts::{Facts, Row, Ruling};
use crate::claims::{Claim, Evidence, Origin, Standing, all, find, is_expectation, standing};
use crate::studies::names::{count, verb};
use drape_report::Words;

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which of the paper's claims hold?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["hard-cases", "work-precision", "solver-control"];

/// Most things that a sentence lists.
const LIST: usize = 5;

/// What the facts say.
pub(super) fn words(facts: &Facts) -> Words {
    let is_later = |row: &&Row| is_expectation(&row.id);
    let (later, rows): (Vec<&Row>, Vec<&Row>) = facts.claims.iter().partition(is_later);
    let mut conclusion = tally(&rows, "claims of the paper");
    if !later.is_empty() {
        conclusion = format!("{conclusion} {}", tally(&later, "expectations about later methods"));
    }
    let (paper, expected): (Vec<&Claim>, Vec<&Claim>) =
        all().iter().partition(|claim| claim.origin.is_paper());
    let mut caveats = Vec::new();
    if rows.len() < paper.len() {
        caveats.push(format!("Only {} of {} claims were tested.", rows.len(), paper.len()));
    }
    if later.len() < expected.len() {
        let (tested, known) = (later.len(), expected.len());
        caveats.push(format!(
            "Only {tested} of {known} expectations about later methods were tested."
        ));
    }
    caveats.extend([
        "A claim is general; its verdict holds for the scenes that were run, and another reading \
         may overturn it."
            .to_owned(),
        "Counted work decides the claims of the paper about time, and modelled time the expectations \
         M01 to M04 and M06 to M08; the ledger says where measured seconds disagree."
            .to_owned(),
    ]);
    if !later.is_empty() {
        caveats.push(
            "Calculations on a similar sheet suggested the expectations; no paper makes them."
                .to_owned(),
        );
    }
    let rounded = facts.claims.iter().filter(|row| !row.portable).count();
    if rounded > 0 {
        caveats.push(format!(
            "Numbers of {} may differ in their last digits between machines.",
            count(rounded, "claim")
        ));
    }
    let observations = [unrepaired(&rows), worst(&rows), open(&rows), held(&later)];
    Words { conclusion, observations: observations.into_iter().flatten().collect(), caveats }
}

/// Where a claim stands under all its readings.
fn stands(row: &Row) -> Standing {
    standing(&row.id, row.verdict, &row.numbers)
}

/// How many stand where.
fn tally(rows: &[&Row], what: &str) -> String {
    let count = |at: Standing| rows.iter().filter(|row| stands(row) == at).count();
    let [holds, depends, fails, undecided] = Standing::ALL.map(count);
    // Where each has one reading, nothing can depend on it.
    let has_readings = |row: &&Row| {
        let numbers = Evidence::new(&row.numbers);
        find(&row.id).is_ok_and(|claim| !claim.readings(&numbers).is_empty())
    };
    let reading = match depends {
        0 if !rows.iter().any(has_readings) => String::new(),
        0 => "; none depends on the reading".to_owned(),
        1 => "; one depends on the reading".to_owned(),
        n if undecided > 0 => format!("; {n} depend on the reading"),
        _ => "; the others depend on the reading".to_owned(),
    };
    let open = match undecided {
        0 => String::new(),
        n => format!("; {n} {} undecided", verb(n, "is", "are")),
    };
    let all = rows.len();
    let (hold, fail) = (verb(holds, "holds", "hold"), verb(fails, "fails", "fail"));
    format!("Of {all} {what}, {holds} {hold} and {fails} {fail}{reading}{open}.")
}

/// Which expectations about later methods hold.
fn held(later: &[&Row]) -> Option<String> {
    let held = later.iter().filter(|row| stands(row) == Standing::Holds);
    let ids: Vec<_> = held.map(|row| row.id.as_str()).collect();
    (1..=LIST)
        .contains(&ids.len())
        .then(|| format!("Expectations about later methods that hold: {}.", ids.join(", ")))
}

/// How many of the claims whose criterion fails have a remedy.
fn unrepaired(rows: &[&Row]) -> Option<String> {
    let failing: Vec<_> = rows.iter().filter(|row| row.verdict == Ruling::Fails).collect();
    let is_repaired = |row: &&&&Row| {
        let judge = |row: &Row| find(&row.id).ok()?.judge(&Evidence::new(&row.numbers)).repair;
        judge(row).is_some()
    };
    let repaired = failing.iter().filter(is_repaired).count();
    (!failing.is_empty()).then(|| {
        format!(
            "A remedy was measured for {repaired} of {} whose criterion fails.",
            count(failing.len(), "claim")
        )
    })
}

/// The section of the paper with the smallest share of claims that hold, among those with several; none if two share that place.
fn worst(rows: &[&Row]) -> Option<String> {
    let mut sections: Vec<(&str, usize, usize)> = Vec::new();
    for row in rows {
        let Origin::Paper { section } = find(&row.id).ok()?.origin else { continue };
        let does_hold = usize::from(stands(row) == Standing::Holds);
        match sections.iter_mut().find(|(other, ..)| *other == section) {
            Some((_, holding, all)) => (*holding, *all) = (*holding + does_hold, *all + 1),
            None => sections.push((section, does_hold, 1)),
        }
    }
    let share = |(_, holding, all): &(&str, usize, usize)| *holding as f64 / *all as f64;
    sections.retain(|(.., all)| *all > 1);
    sections.sort_by(|a, b| share(a).total_cmp(&share(b)));
    let (section, holding, all) = *sections.first()?;
    let is_tie = sections.get(1).is_some_and(|next| share(next) == share(&sections[0]));
    (!is_tie).then(|| {
        let hold = verb(holding, "holds", "hold");
        format!("Section {section} does worst: {holding} of {all} claims {hold} in every reading.")
    })
}

/// The claims whose criterion the numbers cannot decide. Such a claim does not hold, whatever its
/// other readings say.
fn open(rows: &[&Row]) -> Option<String> {
    let open = rows.iter().filter(|row| row.verdict == Ruling::Undecided);
    let ids: Vec<_> = open.map(|row| row.id.as_str()).collect();
    match ids.len() {
        0 => None,
        count if count > LIST => Some(format!("{count} criteria are undecided.")),
        _ => {
            let ids = ids.join(", ");
            Some(format!("The criterion is undecided, because it is met only in part: {ids}."))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::facts::Number;
    use super::*;

    fn row(id: &str, verdict: Ruling, portable: bool) -> Row {
        let scenes = "none".to_owned();
        Row { id: id.to_owned(), verdict, numbers: Vec::new(), scenes, portable }
    }

    #[test]
    fn words_follow_from_the_verdicts() {
        let rows = [
            row("C01", Ruling::Holds, true),
            row("C04", Ruling::Fails, false),
            row("C05", Ruling::Holds, true),
            row("C09", Ruling::Undecided, true),
        ];
        let said = words(&Facts { claims: rows.to_vec() });
        assert_eq!(
            said.conclusion,
            "Of 4 claims of the paper, 2 hold and 1 fails; 1 is undecided."
        );
        assert_eq!(
            said.observations[0],
            "A remedy was measured for 0 of 1 claim whose criterion fails."
        );
        assert!(
            said.observations[1].starts_with("Section 3 does worst"),
            "{:?}",
            said.observations
        );
        assert!(said.observations[1].ends_with("1 of 3 claims holds in every reading."));
        assert!(said.observations[2].ends_with("in part: C09."));
        assert!(said.caveats[0].contains("4 of 29"), "{:?}", said.caveats);
        assert!(said.caveats.iter().any(|caveat| caveat.starts_with("Numbers of 1 claim ")));
    }

    /// An expectation is no claim of the paper: neither its count nor its sections change.
    #[test]
    fn expectations_are_counted_apart() {
        let paper = [row("C01", Ruling::Holds, true), row("C02", Ruling::Fails, true)];
        let later = [row("M01", Ruling::Holds, true), row("M02", Ruling::Fails, true)];
        let alone = words(&Facts { claims: paper.to_vec() });
        let both = words(&Facts { claims: paper.into_iter().chain(later).collect() });
        let first = "Of 2 claims of the paper, 1 holds and 1 fails.";
        assert_eq!(alone.conclusion, first);
        let second = "Of 2 expectations about later methods, 1 holds and 1 fails.";
        assert_eq!(both.conclusion, format!("{first} {second}"));
        let held = "Expectations about later methods that hold: M01.".to_owned();
        assert_eq!(both.observations, [alone.observations, vec![held]].concat());
        assert!(both.caveats.iter().any(|caveat| caveat.contains("no paper makes them")));
        assert!(both.caveats[1].contains("2 of 8 expectations"), "{:?}", both.caveats);
    }

    /// C09 with a criterion that is met only in part, and a reading that holds.
    #[test]
    fn a_reading_is_told_where_there_is_one_and_an_undecided_criterion_does_not_hold() {
        let spread = |case: &str, value| {
            Number::new(format!("difference between orders over motion, {case}"), value, "")
        };
        let verdict = Ruling::Undecided;
        let numbers = vec![spread("a", 0.02), spread("b", 0.001)];
        let said = words(&Facts { claims: vec![Row { numbers, ..row("C09", verdict, true) }] });
        let told = "Of 1 claims of the paper, 0 hold and 0 fail; one depends on the reading.";
        assert_eq!(said.conclusion, told);
        assert!(said.observations.iter().any(|one| one.ends_with("only in part: C09.")));
    }

    #[test]
    fn a_tie_of_sections_is_not_told() {
        let rows = ["C01", "C02", "C10", "C11"].map(|id| row(id, Ruling::Fails, true));
        let rows: Vec<&Row> = rows.iter().collect();
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
