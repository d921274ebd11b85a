//! The tables of the experiment `tables`.

use super::super::facts::{
    Cell, PLAIN, Row, UPDATED_PAPER, assumed, climbs, nearest_reading, worst_factor,
};
use super::{
    Input, VARIANTS, milliseconds, paper_parts, parts, subject, timed_case, variants, verdict,
};
use drape_report::Verdict;
use drape_report::number::{power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plot::{names, values};
use drape_report::verdict::SIGNS;
use std::collections::BTreeSet;

/// The tables of `tables`.
pub(in super::super) fn tables(input: &Input) -> Vec<Table> {
    let mut tables = vec![
        best_fits(input),
        counts(input),
        common(input),
        readings(input),
        troubled(input),
        energies(input),
    ];
    tables.extend(input.timings.is_some().then(|| times(input)));
    tables
}

const ROW_HEADER: [&str; 4] = ["table.row", "particles", "k/m (s⁻²)", "h (s)"];
const READINGS: &str = "k/m in brackets: a neighbouring reading of the illegible exponent.";

fn best_fits(input: &Input) -> Table {
    let rows = &input.facts.rows;
    let found = rows.iter().flat_map(|row| &row.best_fit).map(|fit| fit.variant.as_str());
    let variants = names(&VARIANTS, found);
    let mut header = texts(&ROW_HEADER);
    header.extend(texts(&["d/m (1/s)", "paper's count"]));
    header.extend(variants.iter().map(|variant| format!("{variant}: count (ratio) at ε")));
    let line = |row: &Row| {
        let mut line = row_names(row);
        line.push(setting(row.damping_over_mass_per_s));
        line.push(row.paper.cg_iterations.to_string());
        line.extend(variants.iter().map(|variant| {
            let fit = row.best_fit.iter().find(|fit| fit.variant == *variant);
            fit.map_or_else(absent, |fit| {
                let verdict = verdict(row, variant, fit.forcing_term).unwrap_or(Verdict::Stable);
                format!(
                    "{} ({}) at {}{}",
                    fit.cg_iterations,
                    significant(fit.ratio, 3),
                    setting(fit.forcing_term),
                    verdict.sign()
                )
            })
        }));
        line
    };
    Table {
        title: format!(
            "**The paper's counts and the nearest of ours**: CG iterations in one second; ratio: \
             ours over the paper's. {READINGS} {SIGNS}"
        ),
        header,
        names: 1,
        rows: rows.iter().map(line).collect(),
    }
}

fn counts(input: &Input) -> Table {
    let facts = &input.facts;
    let mut terms =
        values(facts.rows.iter().flat_map(|row| &row.cells).map(|cell| cell.forcing_term));
    terms.reverse();
    let mut header = case_header("variant");
    header.push("paper's count".to_owned());
    header.extend(terms.iter().map(|term| format!("ε = {}", setting(*term))));
    let mut rows = Vec::new();
    for row in &facts.rows {
        for variant in variants(facts) {
            let cells: Vec<_> = row.cells.iter().filter(|cell| cell.variant == variant).collect();
            if cells.is_empty() {
                continue;
            }
            let mut line = case_names(row, variant);
            line.push(row.paper.cg_iterations.to_string());
            line.extend(terms.iter().map(|term| {
                let cell = cells.iter().find(|cell| cell.forcing_term == *term);
                cell.map_or_else(absent, |c| format!("{}{}", c.cg_iterations, c.verdict.sign()))
            }));
            rows.push(line);
        }
    }
    Table {
        title: format!(
            "**Counts at every forcing term**: CG iterations in one second. {READINGS} {SIGNS}"
        ),
        header,
        names: 2,
        rows,
    }
}

fn energies(input: &Input) -> Table {
    let facts = &input.facts;
    let variants = variants(facts);
    let mut header = texts(&ROW_HEADER);
    header.extend(variants.iter().map(|variant| format!("{variant}: energy gain (J), verdicts")));
    let line = |row: &Row| {
        let mut line = row_names(row);
        line.extend(variants.iter().map(|variant| {
            let cells = || row.cells.iter().filter(|cell| cell.variant == *variant);
            let gain = cells().map(|cell| cell.energy_gain_j).max_by(f64::total_cmp);
            let verdicts: BTreeSet<Verdict> = cells().map(|cell| cell.verdict).collect();
            let verdicts: Vec<_> = verdicts.into_iter().map(Verdict::name).collect();
            gain.map_or_else(absent, |gain| {
                format!("{}, {}", significant(gain, 3), verdicts.join(" or "))
            })
        }));
        line
    };
    Table {
        title: format!(
            "**Energy and verdicts**: greatest rise of the total energy above its start among all \
             forcing terms, and all verdicts. {READINGS}"
        ),
        header,
        names: 1,
        rows: facts.rows.iter().map(line).collect(),
    }
}

/// The table of the factors by which a single ε misses the paper's counts.
fn common(input: &Input) -> Table {
    let rows = &input.facts.rows;
    let mut terms = values(assumed(rows).flat_map(|row| &row.cells).map(|cell| cell.forcing_term));
    terms.reverse();
    let line = |term: &f64| {
        let factor = |variant| worst_factor(rows, variant, *term);
        let text = |factor: Option<f64>| factor.map_or_else(absent, |f| significant(f, 3));
        vec![setting(*term), text(factor(PLAIN)), text(factor(UPDATED_PAPER))]
    };
    Table {
        title: "**One ε for all rows**: the factor by which the count misses the paper's in the \
                worst row."
            .to_owned(),
        header: texts(&["ε", PLAIN, UPDATED_PAPER]),
        names: 0,
        rows: terms.iter().map(line).collect(),
    }
}

/// The table of the nearest reading of each row; empty if only one reading was run.
fn readings(input: &Input) -> Table {
    let rows = &input.facts.rows;
    let several = rows.iter().any(|row| !row.assumed_reading);
    let line = |row: &Row| {
        let nearest = |variant| nearest_reading(rows, row, variant).map_or_else(absent, power);
        vec![
            format!("{}.{} {}", row.table, row.row, subject(row)),
            power(row.stiffness_over_mass_per_s2),
            nearest(PLAIN),
            nearest(UPDATED_PAPER),
        ]
    };
    Table {
        title:
            "**The reading of k/m (s⁻²) that comes nearest to the paper's count**, at its best ε."
                .to_owned(),
        header: texts(&["table.row", "read as", "nearest, plain", "nearest, updated-paper"]),
        names: 1,
        rows: assumed(rows).filter(|_| several).map(line).collect(),
    }
}

/// The table of runs that gain energy, climb or do not converge, greatest gain first.
fn troubled(input: &Input) -> Table {
    let cells = assumed(&input.facts.rows).flat_map(|row| row.cells.iter().map(move |c| (row, c)));
    let is_troubled =
        |cell: &Cell| cell.verdict != Verdict::Stable || cell.unconverged_steps > 0 || climbs(cell);
    let mut cells: Vec<_> = cells.filter(|(_, cell)| is_troubled(cell)).collect();
    cells.sort_by(|a, b| b.1.energy_gain_j.total_cmp(&a.1.energy_gain_j));
    let line = |(row, cell): &(&Row, &Cell)| {
        vec![
            format!("{}.{} {}", row.table, row.row, subject(row)),
            cell.variant.clone(),
            setting(cell.forcing_term),
            cell.verdict.to_string(),
            significant(cell.energy_gain_j, 3),
            significant(100.0 * cell.energy_climb, 3),
            cell.unconverged_steps.to_string(),
        ]
    };
    Table {
        title:
            "**Runs that gain energy, climb after a loss or miss their tolerance**, the greatest \
                gain first. Climb: rise above the least energy so far, over the released energy."
                .to_owned(),
        header: texts(&[
            "table.row",
            "variant",
            "ε",
            "verdict",
            "gain (J)",
            "climb (%)",
            "steps short of ε",
        ]),
        names: 2,
        rows: cells.iter().map(line).collect(),
    }
}

fn times(input: &Input) -> Table {
    let timings = input.timings.iter().flat_map(|timings| &timings.rows);
    let mut rows = Vec::new();
    for row in &input.facts.rows {
        let timed: Vec<_> = timings.clone().filter(|timing| timing.id == row.id).collect();
        if timed.is_empty() {
            continue;
        }
        let texts = |parts: [f64; 3]| parts.map(milliseconds);
        let mut line = case_names(row, "the paper");
        line.push(row.paper.cg_iterations.to_string());
        line.extend([milliseconds(row.paper.solver_s), absent()]);
        line.extend(texts(paper_parts(row)));
        rows.push(line);
        for timing in timed {
            let mut line = case_names(row, &timed_case(timing));
            line.push(timing.cg_iterations.to_string());
            line.extend([milliseconds(timing.solver_s), spread(&timing.samples_ns)]);
            line.extend(texts(parts(timing)));
            rows.push(line);
        }
    }
    let mut header = case_header("case");
    header.extend(texts(&[
        "CG iterations",
        "solver (ms)",
        "least to greatest (ms)",
        "CG (ms)",
        "matrix set-up (ms)",
        "rest (ms)",
    ]));
    Table {
        title:
            "**Wall time of one second.** The paper's rows are its printed columns (MIPS R10000, \
                250 MHz). Ours: the median of the repetitions; phases come from a separate pass."
                .to_owned(),
        header,
        names: 2,
        rows,
    }
}

/// Least and greatest of the samples, in milliseconds, as text.
fn spread(samples_ns: &[u64]) -> String {
    match (samples_ns.iter().min(), samples_ns.iter().max()) {
        (Some(least), Some(greatest)) => {
            let milliseconds = |ns: u64| milliseconds(ns as f64 * 1e-9);
            format!(
                "{} to {} of {}",
                milliseconds(*least),
                milliseconds(*greatest),
                samples_ns.len()
            )
        }
        _ => absent(),
    }
}

/// The leading columns of every table of rows, which identify the row.
fn row_names(row: &Row) -> Vec<String> {
    let k_over_m = power(row.stiffness_over_mass_per_s2);
    vec![
        format!("{}.{} {}", row.table, row.row, subject(row)),
        row.particles.to_string(),
        if row.assumed_reading { k_over_m } else { format!("({k_over_m})") },
        setting(row.step_s),
    ]
}

/// The same columns for a table with several lines a row. The case comes second.
fn case_names(row: &Row, case: &str) -> Vec<String> {
    let mut names = row_names(row);
    names.insert(1, case.to_owned());
    names
}

/// Header of the columns of [`case_names`].
fn case_header(case: &str) -> Vec<String> {
    let mut header = texts(&ROW_HEADER);
    header.insert(1, case.to_owned());
    header
}
