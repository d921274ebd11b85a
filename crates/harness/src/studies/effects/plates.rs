//! Figure and tables of the experiment `effects`.

use super::facts::{Cell, Facts, NOTHING, TimingRow};
use drape_report::Verdict;
use drape_report::number::{significant, trimmed};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Matrix, Row, Shade, Tile};

/// The input of the figure and the tables.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[Plate {
    file: "effects-support.svg",
    title: "Which method takes which effect, and how",
    caption: "Most methods take most effects; a method refuses by name what it cannot honour (R). \
            A row is an effect, a column a method. I: implicit, at the new time level; E: \
            explicit, at the old one; S: either, by a setting; C: by a constraint on the new \
            velocity; R: refused. An effect that is not named costs nothing.",
    draw: Draw::Matrix(support),
}];

const KNOWN: [(&str, &str, Shade); 5] = [
    ("implicit", "I", Shade::Good),
    ("by setting", "S", Shade::Fair),
    ("constraint", "C", Shade::Still),
    ("explicit", "E", Shade::Open),
    ("refused", "R", Shade::Bad),
];

fn tile(treatment: &str) -> Tile {
    let known = KNOWN.iter().find(|(name, ..)| *name == treatment);
    Tile {
        shade: known.map_or(Shade::Idle, |(.., shade)| *shade),
        text: known.map_or("?", |(_, letter, _)| letter).to_owned(),
        is_marked: false,
    }
}

/// The names without repetition, in the order of their first occurrence.
fn different<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut different = Vec::new();
    for name in names {
        if !different.contains(&name) {
            different.push(name);
        }
    }
    different
}

fn support(input: &Input) -> Option<Matrix> {
    let supports = &input.facts.supports;
    let columns = different(supports.iter().map(|support| support.method.as_str()));
    let effects = different(supports.iter().map(|support| support.effect.as_str()));
    let row = |effect: &&str| {
        let of = |method: &&str| {
            let found = supports.iter().find(|s| s.effect == *effect && s.method == *method);
            found.map(|support| tile(&support.treatment)).into_iter().collect()
        };
        Row {
            label: (*effect).to_owned(),
            is_first: false,
            tiles: columns.iter().map(of).collect(),
        }
    };
    let rows: Vec<_> = effects.iter().map(row).collect();
    let is_there = |name: &str| supports.iter().any(|support| support.treatment == name);
    let legend = KNOWN.iter().filter(|(name, ..)| is_there(name));
    let legend = legend.map(|(name, ..)| (tile(name), (*name).to_owned())).collect();
    (!rows.is_empty()).then(|| Matrix {
        columns: texts(&columns),
        rows,
        legend,
        notes: vec![
            "A method refuses, by name and before the first step, what it cannot honour."
                .to_owned(),
        ],
    })
}

fn effects(input: &Input) -> impl Iterator<Item = &str> {
    input.facts.effects.iter().map(|effect| effect.name.as_str())
}

fn header(first: &str, methods: &[&str]) -> Vec<String> {
    texts(&[&[first], methods].concat())
}

/// A table with a row for each effect and a column for each method.
fn by_method(input: &Input, title: &str, text: impl Fn(&Cell) -> String) -> Table {
    let facts = &input.facts;
    let methods: Vec<&str> = facts.methods.iter().map(String::as_str).collect();
    let row = |effect: &str| {
        let of = |method: &&str| {
            let cell = facts.cells.iter().find(|c| c.effect == effect && c.method == *method);
            cell.map_or_else(absent, |cell| match cell.verdict {
                Verdict::Completed => text(cell),
                Verdict::Diverged => "✗".to_owned(),
                other => other.to_string(),
            })
        };
        [effect.to_owned()].into_iter().chain(methods.iter().map(of)).collect()
    };
    let is_run = |effect: &&str| facts.cells.iter().any(|cell| cell.effect == *effect);
    Table {
        title: title.to_owned(),
        header: header("effect", &methods),
        names: 1,
        rows: effects(input).filter(is_run).map(row).collect(),
    }
}

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let mut tables = Vec::from_iter(bill(input));
    tables.extend([counts(input), changes(input), additions(input)]);
    tables
}

/// The table of ratios of times with and without each effect; `None` without timings.
fn bill(input: &Input) -> Option<Table> {
    let rows = &input.timings.as_ref()?.rows;
    let methods = different(rows.iter().map(|row| row.method.as_str()));
    let line = |effect: &str| {
        let of = |method: &&str| {
            let found = rows.iter().find(|row| row.effect == effect && row.method == *method);
            found.map_or_else(absent, |row| {
                let bytes = |bytes: Option<i64>| bytes.map_or_else(absent, kilobytes);
                format!(
                    "{}; {}; {}",
                    significant(row.ratio, 3),
                    bytes(row.system_bytes),
                    bytes(row.method_bytes)
                )
            })
        };
        [effect.to_owned()].into_iter().chain(methods.iter().map(of)).collect()
    };
    Some(Table {
        title:
            "**Cost of each effect**: time of the run with the effect over the time without it; \
                kilobytes that the system holds more; kilobytes that the prepared method holds \
                more."
                .to_owned(),
        header: header("effect", &methods),
        names: 1,
        rows: effects(input).filter(|effect| *effect != NOTHING).map(line).collect(),
    })
}

fn kilobytes(bytes: i64) -> String {
    trimmed(bytes as f64 / 1e3, 1)
}

fn counts(input: &Input) -> Table {
    by_method(
        input,
        "**Counts of the run**: CG iterations; products with the matrix; sweeps over forces or \
         energies; builds of a matrix, preconditioner or factor. ✗ \
         diverged.",
        |cell| {
            format!(
                "{}; {}; {}; {}",
                cell.cg_iterations, cell.matvecs, cell.force_evaluations, cell.setups
            )
        },
    )
}

fn changes(input: &Input) -> Table {
    by_method(
        input,
        "**What each effect changes**: distance of the particles at the end from the sheet \
         without it, root of the mean square, mm. ✗ diverged, – nothing to compare \
         with.",
        |cell| cell.change_m.map_or_else(absent, |change| significant(1e3 * change, 3)),
    )
}

fn additions(input: &Input) -> Table {
    let facts = &input.facts;
    let left_out = facts.left_out();
    let line = |effect: &super::facts::Effect| {
        vec![
            effect.name.clone(),
            format!("`{}`", effect.adds),
            effect.objects.to_string(),
            effect.springs.to_string(),
            effect.coupled_pairs.to_string(),
            if left_out.contains(&effect.name.as_str()) { "no" } else { "yes" }.to_owned(),
        ]
    };
    Table {
        title: format!(
            "**The additions** to the scene `{}`: forces in the running system; springs in the \
             scalar matrix; pairs of particles in the 3×3 blocks; whether `all together` has \
             it.",
            facts.scene
        ),
        header: texts(&["effect", "keys", "forces", "springs", "pairs", "together"]),
        names: 2,
        rows: facts.effects.iter().map(line).collect(),
    }
}
