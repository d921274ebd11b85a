//! Figure and tables of the experiment `claims`.

use super::facts::{Facts, Number, Row, Ruling, TimedCase, TimingRow};
use crate::claims::{Evidence, Origin, find, is_expectation};
use drape_report::number::{significant, trimmed};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Matrix, Row as Line, Shade, Tile};

/// What the figure is drawn from.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "claims.svg",
        title: "Which of the paper's claims hold",
        caption: "The tile shows what came out for each claim of the paper; its section stands in \
                  brackets. A claim is confirmed if the recorded numbers meet a criterion that was \
                  fixed beforehand. A thick frame marks a claim whose measured seconds contradict \
                  the counted work. Criteria, reasons and repairs stand in the table below.",
        draw: Draw::Matrix(of_paper),
    },
    Plate {
        file: "claims-modern.svg",
        title: "Which expectations about later methods hold",
        caption: "The tile shows what came out for each expectation about methods that were \
                  published after the paper. Calculations on a similar sheet suggested these \
                  expectations; no paper makes them. Their criteria were fixed before this program \
                  measured them. Criteria and reasons stand in the table below.",
        draw: Draw::Matrix(of_later_methods),
    },
];

const KNOWN: [(Ruling, &str, Shade); 3] = [
    (Ruling::Confirmed, "C", Shade::Good),
    (Ruling::Refuted, "R", Shade::Bad),
    (Ruling::Undecided, "?", Shade::Open),
];

fn timing<'a>(input: &'a Input, row: &Row) -> Option<&'a TimingRow> {
    input.timings.iter().flat_map(|timings| &timings.rows).find(|timing| timing.id == row.id)
}

/// Whether measured seconds contradict the counted work.
fn is_contradicted(input: &Input, row: &Row) -> bool {
    timing(input, row).is_some_and(|timing| timing.verdict != row.verdict)
}

/// The verdict of the facts, unless seconds contradict it.
fn ruling(input: &Input, row: &Row) -> Ruling {
    if is_contradicted(input, row) { Ruling::Undecided } else { row.verdict }
}

fn of_paper(input: &Input) -> Option<Matrix> {
    verdicts(input, &of_kind(input, false))
}

fn of_later_methods(input: &Input) -> Option<Matrix> {
    verdicts(input, &of_kind(input, true))
}

/// The claims of the paper, or the expectations about later methods.
fn of_kind(input: &Input, is_later: bool) -> Vec<&Row> {
    input.facts.claims.iter().filter(|row| is_expectation(&row.id) == is_later).collect()
}

fn verdicts(input: &Input, rows: &[&Row]) -> Option<Matrix> {
    let line = |row: &Row| {
        let tile = |(verdict, letter, shade): &(Ruling, &str, Shade)| {
            let is_here = ruling(input, row) == *verdict;
            let text = (*letter).to_owned();
            let tile = Tile { shade: *shade, text, is_marked: is_contradicted(input, row) };
            is_here.then_some(tile).into_iter().collect()
        };
        Line { label: label(row), is_first: true, tiles: KNOWN.iter().map(tile).collect() }
    };
    let legend = KNOWN.iter().map(|(verdict, letter, shade)| {
        let count = rows.iter().filter(|row| ruling(input, row) == *verdict).count();
        let tile = Tile { shade: *shade, text: (*letter).to_owned(), is_marked: false };
        (tile, format!("{}: {count}", verdict.name()))
    });
    (!rows.is_empty()).then(|| Matrix {
        columns: KNOWN.iter().map(|(verdict, ..)| verdict.name().to_owned()).collect(),
        rows: rows.iter().map(|row| line(row)).collect(),
        legend: legend.collect(),
        notes: Vec::new(),
    })
}

/// The claim in words; a record may hold an id that is no longer known.
fn label(row: &Row) -> String {
    let words = find(&row.id).map(|claim| match claim.origin {
        Origin::Paper { section } => format!(" (§{section}) {}", claim.says),
        Origin::Expectation { .. } => format!(" {}", claim.says),
    });
    format!("{}{}", row.id, words.unwrap_or_default())
}

/// A number with its unit and limit.
fn number(number: &Number) -> String {
    let value = match number.value {
        value if value >= f64::MAX => "∞".to_owned(),
        // Round numbers of steps or particles.
        value if value.fract() == 0.0 && value.abs() < 1e6 => format!("{value}"),
        value => significant(value, 3),
    };
    let unit = if number.unit.is_empty() { String::new() } else { format!(" {}", number.unit) };
    let limit = number.limit.map_or(String::new(), |l| format!(" (limit {})", trimmed(l, 3)));
    format!("{}: {value}{unit}{limit}", number.what)
}

pub(super) fn tables(input: &Input) -> Vec<Table> {
    let later = of_kind(input, true);
    let mut tables = vec![ledger(
        input,
        &of_kind(input, false),
        "**The ledger.** Claims, criteria, verdicts, and what helps where a claim is refuted.",
        "§",
    )];
    if !later.is_empty() {
        let title = "**Expectations about later methods.** No paper makes them; the publications \
                     named are those of the methods.";
        tables.push(ledger(input, &later, title, "methods"));
    }
    tables.extend([evidence(input), seconds(input)]);
    tables
}

/// The verdict in words.
fn told(input: &Input, row: &Row) -> String {
    if is_contradicted(input, row) {
        let counted = row.verdict.name();
        format!("**undecided** (by counted work {counted}, by seconds not)")
    } else {
        format!("**{}**", row.verdict.name())
    }
}

fn ledger(input: &Input, rows: &[&Row], title: &str, origin: &str) -> Table {
    let line = |row: &&Row| {
        let claim = find(&row.id).ok()?;
        let judgement = claim.judge(&Evidence::new(&row.numbers));
        Some(vec![
            row.id.clone(),
            match claim.origin {
                Origin::Paper { section: origin } | Origin::Expectation { about: origin } => origin,
            }
            .to_owned(),
            claim.says.to_owned(),
            claim.criterion.to_owned(),
            told(input, row),
            judgement.reason,
            judgement.repair.unwrap_or_else(absent),
            claim.overturned_by.to_owned(),
            format!("[{}](figures/{})", claim.see, claim.see),
        ])
    };
    Table {
        title: title.to_owned(),
        header: texts(&[
            "id",
            origin,
            "claim",
            "criterion",
            "verdict",
            "reason",
            "repair",
            "overturned by",
            "figure",
        ]),
        names: 9,
        rows: rows.iter().filter_map(line).collect(),
    }
}

fn evidence(input: &Input) -> Table {
    let line = |row: &Row| {
        let numbers: Vec<_> = row.numbers.iter().map(number).collect();
        vec![row.id.clone(), row.scenes.clone(), numbers.join("; ")]
    };
    Table {
        title: "**The evidence.** What was run, and the numbers behind each verdict.".to_owned(),
        header: texts(&["id", "scenes", "numbers"]),
        names: 3,
        rows: input.facts.claims.iter().map(line).collect(),
    }
}

fn seconds(input: &Input) -> Table {
    let line = |row: &TimingRow| {
        let case = |case: &TimedCase| {
            let median = significant(1e3 * case.median_s(), 3);
            format!("{}: {median} ms ({} times)", case.what, case.samples_ns.len())
        };
        let cases: Vec<_> = row.cases.iter().map(case).collect();
        vec![row.id.clone(), cases.join("; "), number(&row.number), row.verdict.name().to_owned()]
    };
    let rows = input.timings.iter().flat_map(|timings| &timings.rows);
    Table {
        title: "**Seconds beside the counted work.** Median wall times, and the verdict by them \
             alone."
            .to_owned(),
        header: texts(&["id", "timed", "number", "verdict by seconds"]),
        names: 4,
        rows: rows.map(line).collect(),
    }
}
