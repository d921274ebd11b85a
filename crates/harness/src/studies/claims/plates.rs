//! Figure and tables of the experiment `claims`.

use super::facts::{Facts, Number, Row, TimingRow, Verdict};
use drape_report::number::{significant, trimmed};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Matrix, Row as Line, Shade, Tile};

/// What the figure is drawn from.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// How many claims hold.
fn answer(input: &Input) -> Option<String> {
    let rows = &input.facts.claims;
    let count =
        |verdict: Verdict| rows.iter().filter(|row| verdict_of(input, row) == verdict).count();
    (!rows.is_empty()).then(|| {
        format!(
            "Of {} claims of the paper that were tested by criteria fixed beforehand, {} are confirmed, {} refuted and {} undecided.",
            rows.len(),
            count(Verdict::Confirmed),
            count(Verdict::Refuted),
            count(Verdict::Undecided)
        )
    })
}

pub(super) const PLATES: &[Plate<Input>] = &[Plate {
    file: "claims.svg",
    title: "Which of the paper's claims hold",
    caption: "One row for each claim of the paper, in our words, with the place of the claim in brackets. The tile \
        tells what its test found: confirmed if the criterion that was fixed beforehand is met, refuted if it is \
        not, undecided if the test cannot tell, because an effect is absent or because counted work and measured seconds \
        disagree (thick frame). Criteria, numbers, reasons and what repairs a refuted claim stand in the tables below.",
    draw: Draw::Matrix(verdicts),
}];

const KNOWN: [(Verdict, &str, Shade); 3] = [
    (Verdict::Confirmed, "C", Shade::Good),
    (Verdict::Refuted, "R", Shade::Bad),
    (Verdict::Undecided, "?", Shade::Open),
];

fn timing<'a>(input: &'a Input, row: &Row) -> Option<&'a TimingRow> {
    input.timings.iter().flat_map(|timings| &timings.rows).find(|timing| timing.id == row.id)
}

/// Whether measured seconds contradict the counted work.
fn is_contradicted(input: &Input, row: &Row) -> bool {
    timing(input, row).is_some_and(|timing| timing.verdict != row.verdict)
}

/// The verdict of the facts, unless seconds contradict it.
fn verdict_of(input: &Input, row: &Row) -> Verdict {
    if is_contradicted(input, row) { Verdict::Undecided } else { row.verdict }
}

fn verdicts(input: &Input) -> Option<Matrix> {
    let rows = &input.facts.claims;
    let line = |row: &Row| {
        let tile = |(verdict, letter, shade): &(Verdict, &str, Shade)| {
            let is_here = verdict_of(input, row) == *verdict;
            let text = (*letter).to_owned();
            let tile = Tile { shade: *shade, text, is_marked: is_contradicted(input, row) };
            is_here.then_some(tile).into_iter().collect()
        };
        Line {
            label: format!("{} (§{}) {}", row.id, row.section, row.says),
            is_first: true,
            tiles: KNOWN.iter().map(tile).collect(),
        }
    };
    let legend = KNOWN.iter().map(|(verdict, letter, shade)| {
        let count = rows.iter().filter(|row| verdict_of(input, row) == *verdict).count();
        let tile = Tile { shade: *shade, text: (*letter).to_owned(), is_marked: false };
        (tile, format!("{}: {count}", verdict.name()))
    });
    (!rows.is_empty()).then(|| Matrix {
        columns: KNOWN.iter().map(|(verdict, ..)| verdict.name().to_owned()).collect(),
        rows: rows.iter().map(line).collect(),
        legend: legend.collect(),
        notes: Vec::new(),
    })
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
    vec![ledger(input), evidence(input), seconds(input)]
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

fn ledger(input: &Input) -> Table {
    let line = |row: &Row| {
        vec![
            row.id.clone(),
            row.section.clone(),
            row.says.clone(),
            row.criterion.clone(),
            told(input, row),
            row.reason.clone(),
            row.repair.clone().unwrap_or_else(absent),
            format!("[{}](figures/{})", row.see, row.see),
        ]
    };
    Table {
        title: "**The ledger.** What the paper claims, what was fixed beforehand as its test, and what came out; repair: \
                what helps where a claim is refuted, as far as it was measured."
            .to_owned(),
        header: texts(&[
            "id", "§", "claim", "criterion", "verdict", "reason", "repair", "figure",
        ]),
        names: 8,
        rows: input.facts.claims.iter().map(line).collect(),
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
        let case = |case: &super::facts::TimedCase| {
            let median = significant(1e3 * case.median_s(), 3);
            format!("{}: {median} ms ({} times)", case.what, case.samples_ns.len())
        };
        let cases: Vec<_> = row.cases.iter().map(case).collect();
        vec![row.id.clone(), cases.join("; "), number(&row.number), row.verdict.name().to_owned()]
    };
    let rows = input.timings.iter().flat_map(|timings| &timings.rows);
    Table {
        title:
            "**Seconds beside the counted work.** Median wall times, and the verdict by them alone."
                .to_owned(),
        header: texts(&["id", "timed", "number", "verdict by seconds"]),
        names: 4,
        rows: rows.map(line).collect(),
    }
}
