//! Figure and tables of the experiment `hard-cases`.

use super::facts::{Case, Cell, Expected, Facts};
use drape_report::Verdict;
use drape_report::number::{significant, trimmed};
use drape_report::page::{Table, absent};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Matrix, Row, Shade, Tile};

/// The input of the figure.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[Plate {
    file: "hard-cases.svg",
    title: "Verdicts on the hard cases, by method",
    caption: "Explicit methods at fixed steps diverge almost everywhere; backward Euler is \
            stable wherever it comes to a verdict. A row is a case, a column a method; left tile \
            without damping, right tile with it. The letter is the worst of three perturbed \
            starts; a capital letter means that theory covers it. Thick frame: the verdict \
            differs from theory.",
    draw: Draw::Matrix(verdicts),
}];

const KNOWN: [(Verdict, &str, Shade); 7] = [
    (Verdict::Stable, "S", Shade::Good),
    (Verdict::Marginal, "M", Shade::Fair),
    (Verdict::Unstable, "U", Shade::Bad),
    (Verdict::Diverged, "D", Shade::Worst),
    (Verdict::OverBudget, "B", Shade::Open),
    (Verdict::Refused, "R", Shade::Idle),
    (Verdict::NotApplicable, "–", Shade::Idle),
];

/// The letter of a verdict. A capital means that theory predicts it.
fn letter(cell: &Cell) -> String {
    let known = KNOWN.iter().find(|(verdict, ..)| *verdict == cell.verdict);
    let letter = known.map_or("?", |(_, letter, _)| letter);
    if cell.expected == Expected::NoTheorem { letter.to_lowercase() } else { letter.to_owned() }
}

fn tile(cell: &Cell) -> Tile {
    let known = KNOWN.iter().find(|(verdict, ..)| *verdict == cell.verdict);
    Tile {
        shade: known.map_or(Shade::Idle, |(.., shade)| *shade),
        text: letter(cell),
        is_marked: cell.differs,
    }
}

/// The cells of a case and a method, the undamped one first.
fn pair<'a>(facts: &'a Facts, case: &Case, method: &str) -> Vec<&'a Cell> {
    let mut cells: Vec<_> =
        facts.cells.iter().filter(|cell| cell.case == case.name && cell.method == method).collect();
    cells.sort_by_key(|cell| cell.is_damped);
    cells
}

/// Id of a case: the first word of its name.
fn id(case: &Case) -> &str {
    case.name.split(' ').next().unwrap_or_default()
}

fn verdicts(input: &Input) -> Option<Matrix> {
    let facts = &input.facts;
    let mut rows = Vec::new();
    for (n, case) in facts.cases.iter().enumerate() {
        let tiles = |method: &String| pair(facts, case, method).into_iter().map(tile).collect();
        let tiles = facts.methods.iter().map(tiles).collect();
        let is_first = n == 0 || id(&facts.cases[n - 1]) != id(case);
        rows.push(Row { label: case.name.clone(), is_first, tiles });
    }
    let legend = KNOWN
        .iter()
        .filter(|(verdict, ..)| facts.cells.iter().any(|cell| cell.verdict == *verdict));
    let mut legend: Vec<_> = legend
        .map(|&(verdict, letter, shade)| {
            let tile = Tile { shade, text: letter.to_owned(), is_marked: false };
            let is_idle = verdict == Verdict::NotApplicable;
            let meaning = if is_idle { "nothing to vary" } else { verdict.name() };
            (tile, meaning.to_owned())
        })
        .collect();
    let marked = Tile { shade: Shade::Idle, text: String::new(), is_marked: true };
    if facts.cells.iter().any(|cell| cell.differs) {
        legend.push((marked, "not what theory says".to_owned()));
    }
    let notes = vec![
        "Left tile: without damping, right tile: with it. Capital letter: theory says whether \
         the run should be stable; small letter: no theorem."
            .to_owned(),
    ];
    let columns = facts.methods.clone();
    (!facts.cells.is_empty()).then_some(Matrix { columns, rows, legend, notes })
}

fn damping(cell: &Cell) -> &'static str {
    if cell.is_damped { "damped" } else { "undamped" }
}

/// The verdict with the number that decided it.
fn verdict(cell: &Cell) -> String {
    let letter = letter(cell);
    match cell.verdict {
        Verdict::Marginal | Verdict::Unstable => format!("{letter} {}", significant(cell.gain, 2)),
        Verdict::OverBudget => format!("{letter} {} s", trimmed(cell.reached_s, 3)),
        _ => letter,
    }
}

fn header(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let facts = &input.facts;
    vec![tally(facts), differences(facts), numbers(facts), cases(facts)]
}

/// Counts of the verdicts of each method, the most stable method first.
fn tally(facts: &Facts) -> Table {
    let line = |method: &String| {
        let own = || facts.cells.iter().filter(|cell| cell.method == *method);
        let count = |verdict: Verdict| own().filter(|cell| cell.verdict == verdict).count();
        let judged = own().filter(|cell| cell.verdict.is_judged()).count();
        let stable = count(Verdict::Stable);
        let seen = || own().filter(|cell| cell.shows_rises());
        let rises: u64 = seen().map(|cell| cell.rises).sum();
        let steps: u64 = seen().map(|cell| cell.steps).sum();
        let strayed = own().filter(|cell| !cell.note.is_empty()).filter_map(|cell| cell.strayed_m);
        let strayed = strayed.reduce(f64::max).map_or_else(absent, |way| {
            if way < f64::MAX { significant(way, 2) } else { "without end".to_owned() }
        });
        let cells = vec![
            method.clone(),
            format!("{stable} of {judged}"),
            count(Verdict::OverBudget).to_string(),
            own().filter(|cell| cell.differs).count().to_string(),
            format!("{rises} of {steps}"),
            strayed,
        ];
        (stable as f64 / judged.max(1) as f64, judged, cells)
    };
    let mut lines: Vec<_> = facts.methods.iter().map(line).collect();
    lines.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
    Table {
        title: "**Methods, the most stable first**: stable runs of those with a verdict; cells \
                over budget; verdicts against theory; steps in which the energy rose, where \
            round-off lets them be counted; how far a sheet at rest strays. –: it keeps \
            still."
            .to_owned(),
        header: header(&[
            "method",
            "stable",
            "over budget",
            "against theory",
            "rises",
            "strays \
            (m)",
        ]),
        names: 1,
        rows: lines.into_iter().map(|(.., cells)| cells).collect(),
    }
}

fn differences(facts: &Facts) -> Table {
    let line = |cell: &Cell| {
        vec![
            cell.case.clone(),
            format!("{}, {}", cell.method, damping(cell)),
            verdict(cell),
            format!("{}: {}", cell.expected, cell.reason),
            cell.explanation.clone().unwrap_or_else(|| "**unexplained**".to_owned()),
        ]
    };
    Table {
        title: "**Where the verdict is not what theory says**, and why.".to_owned(),
        header: header(&["case", "method", "verdict", "theory", "explanation"]),
        names: 5,
        rows: facts.cells.iter().filter(|cell| cell.differs).map(line).collect(),
    }
}

fn numbers(facts: &Facts) -> Table {
    let mut names = header(&["case"]);
    names.extend(facts.methods.iter().cloned());
    let line = |case: &Case| {
        let mut line = vec![case.name.clone()];
        line.extend(facts.methods.iter().map(|method| {
            let verdicts = pair(facts, case, method).into_iter().map(verdict);
            verdicts.collect::<Vec<_>>().join(" / ")
        }));
        line
    };
    Table {
        title: "**Verdicts**, undamped / damped: S stable, M marginal and U unstable (with the \
                gain over E_ref), D diverged, B over budget (with the time reached), R refused, – \
            nothing to vary. Capital letter: theory says what should come \
            out."
            .to_owned(),
        header: names,
        names: 1,
        rows: if facts.cells.is_empty() {
            Vec::new()
        } else {
            facts.cases.iter().map(line).collect()
        },
    }
}

fn cases(facts: &Facts) -> Table {
    let line = |case: &Case| {
        vec![
            case.name.clone(),
            case.scene.clone(),
            case.judged.clone(),
            case.particles.to_string(),
            trimmed(case.step_s, 3),
            case.steps.to_string(),
            format!(
                "{} / {}",
                significant(case.released_undamped_j, 3),
                significant(case.released_damped_j, 3)
            ),
        ]
    };
    Table {
        title: "**The cases.** h: the step (the base of the pattern in H09); E_ref: energy that \
                the scene sets free, undamped / \
            damped."
            .to_owned(),
        header: header(&["case", "scene", "judged", "particles", "h (s)", "steps", "E_ref (J)"]),
        names: 3,
        rows: facts.cases.iter().map(line).collect(),
    }
}
