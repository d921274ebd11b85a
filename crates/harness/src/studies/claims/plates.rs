//! Figure and tables of the experiment `claims`.

use super::facts::{Facts, Number, Row, Ruling, TimedCase, TimingRow};
use crate::claims::{Evidence, Origin, Reading, Standing, find, is_expectation, standing};
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
        caption: "The first tile of a line shows the verdict on a claim of the paper, the others \
            the verdict on each reading of its words; its section stands in brackets. A claim \
            depends on the reading if the readings disagree. The tables below give the readings \
            with their numbers, reasons and repairs.",
        draw: Draw::Matrix(of_paper),
    },
    Plate {
        file: "claims-modern.svg",
        title: "Which expectations about later methods hold",
        caption: "Each line shows the result for an expectation about methods that were published \
            after the paper. Calculations on a similar sheet suggested these expectations; no \
            paper makes them. Modelled time judges them: a miss within a factor of 2 is \
            undecided, and errors that noise hides do not count.",
        draw: Draw::Matrix(of_later_methods),
    },
];

/// Letter and shade of where a claim stands.
fn stands(standing: Standing) -> (&'static str, Shade) {
    match standing {
        Standing::Holds => ("H", Shade::Good),
        Standing::Depends => ("D", Shade::Fair),
        Standing::Fails => ("F", Shade::Bad),
        Standing::Undecided => ("?", Shade::Open),
    }
}

/// Letter and shade of a verdict.
fn ruled(ruling: Ruling) -> (&'static str, Shade) {
    stands(match ruling {
        Ruling::Holds => Standing::Holds,
        Ruling::Fails => Standing::Fails,
        Ruling::Undecided => Standing::Undecided,
    })
}

fn timing<'a>(input: &'a Input, row: &Row) -> Option<&'a TimingRow> {
    input.timings.iter().flat_map(|timings| &timings.rows).find(|timing| timing.id == row.id)
}

/// Whether measured seconds contradict the counted work.
fn is_contradicted(input: &Input, row: &Row) -> bool {
    timing(input, row).is_some_and(|timing| timing.verdict != row.verdict)
}

fn of_paper(input: &Input) -> Option<Matrix> {
    verdicts(&of_kind(input, false))
}

fn of_later_methods(input: &Input) -> Option<Matrix> {
    verdicts(&of_kind(input, true))
}

/// The claims of the paper, or the expectations about later methods.
fn of_kind(input: &Input, is_later: bool) -> Vec<&Row> {
    input.facts.claims.iter().filter(|row| is_expectation(&row.id) == is_later).collect()
}

/// The readings of a claim besides its criterion.
fn readings(row: &Row) -> Vec<Reading> {
    find(&row.id).map_or_else(|_| Vec::new(), |c| c.readings(&Evidence::new(&row.numbers)))
}

/// Where a claim stands under all readings.
fn standing_of(row: &Row) -> Standing {
    standing(&row.id, row.verdict, &row.numbers)
}

fn verdicts(rows: &[&Row]) -> Option<Matrix> {
    let tile = |(letter, shade): (&str, Shade)| {
        vec![Tile { shade, text: letter.to_owned(), is_marked: false }]
    };
    let most = rows.iter().map(|row| readings(row).len()).max()?;
    let line = |row: &Row| {
        let mut tiles = vec![tile(stands(standing_of(row))), tile(ruled(row.verdict))];
        tiles.extend(readings(row).iter().map(|reading| tile(ruled(reading.verdict))));
        tiles.resize_with(2 + most, Vec::new);
        Line { label: label(row), is_first: true, tiles }
    };
    let legend = Standing::ALL.map(|standing| {
        let count = rows.iter().filter(|row| standing_of(row) == standing).count();
        let (letter, shade) = stands(standing);
        let tile = Tile { shade, text: letter.to_owned(), is_marked: false };
        (tile, format!("{}: {count}", standing.name()))
    });
    let mut columns = vec!["in all".to_owned(), "criterion".to_owned()];
    columns.extend((2..2 + most).map(|number| format!("reading {number}")));
    Some(Matrix {
        columns,
        rows: rows.iter().map(|row| line(row)).collect(),
        legend: legend.to_vec(),
        notes: vec!["The numbers count the first column.".to_owned()],
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
        "**The ledger.** Claims with their place in the paper, their criteria and verdicts, and a \
         remedy where a criterion fails.",
        "§",
    )];
    if !later.is_empty() {
        let title = "**Expectations about later methods.** No paper makes them; the publications \
                     named are those of the methods.";
        tables.push(ledger(input, &later, title, "methods"));
    }
    tables.extend([ways(input), evidence(input), seconds(input)]);
    tables
}

/// The verdict in words; that of the facts stands, whatever a machine's seconds say.
fn told(input: &Input, row: &Row) -> String {
    let name = row.verdict.name();
    if is_contradicted(input, row) {
        format!("**{name}** by counted work (by seconds on this machine it does not)")
    } else {
        format!("**{name}**")
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
            format!("**{}**", standing_of(row).name()),
            claim.criterion.to_owned(),
            told(input, row),
            judgement.reason,
            judgement.repair.unwrap_or_else(absent),
            claim.overturned_by.to_owned(),
            format!("[{}](figures/{})", claim.see, claim.see),
            claim.age.to_string(),
        ])
    };
    Table {
        title: title.to_owned(),
        header: texts(&[
            "id",
            origin,
            "claim",
            "stands",
            "criterion",
            "its verdict",
            "reason",
            "repair",
            "overturned by",
            "figure",
            "criterion since",
        ]),
        names: 11,
        rows: rows.iter().filter_map(line).collect(),
    }
}

/// The readings as columns.
fn ways(input: &Input) -> Table {
    let rows = &input.facts.claims;
    let most = rows.iter().map(|row| readings(row).len()).max().unwrap_or(0);
    let line = |row: &Row| {
        let others = readings(row);
        let claim = find(&row.id).ok().filter(|_| !others.is_empty())?;
        let way = |asks: &str, verdict: &str, seen: &str| format!("{asks} **{verdict}**: {seen}");
        let judgement = claim.judge(&Evidence::new(&row.numbers));
        let mut cells = vec![
            row.id.clone(),
            claim.says.to_owned(),
            format!("**{}**", standing_of(row).name()),
            way(claim.criterion, row.verdict.name(), &judgement.reason),
        ];
        cells.extend(others.iter().map(|r| way(r.asks, r.verdict.name(), &r.seen)));
        cells.resize_with(4 + most, absent);
        Some(cells)
    };
    let fixed = ["id", "claim", "stands", "criterion"].map(str::to_owned);
    let further = (2..2 + most).map(|number| format!("reading {number}"));
    Table {
        title: "**The readings.** Some claims allow several readings, or depend on a parameter \
                that the paper does not print. The table lists each reading with its verdict and \
                numbers."
            .to_owned(),
        header: fixed.into_iter().chain(further).collect(),
        names: 4 + most,
        rows: rows.iter().filter_map(line).collect(),
    }
}

fn evidence(input: &Input) -> Table {
    let line = |row: &Row| {
        let numbers: Vec<_> = row.numbers.iter().map(number).collect();
        vec![row.id.clone(), row.scenes.clone(), numbers.join("; ")]
    };
    Table {
        title: "**The evidence.** The runs and the numbers behind each verdict.".to_owned(),
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
