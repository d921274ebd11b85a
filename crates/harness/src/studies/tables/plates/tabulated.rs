//! The tables of the experiment `tables`.

use super::super::facts::Row;
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
    let mut tables = vec![best_fits(input), counts(input), energies(input)];
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
            "**The paper's counts and the nearest of ours.** CG iterations in one simulated second; \
             ratio: our count over the paper's. {READINGS} {SIGNS}"
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
            "**Counts at every forcing term.** CG iterations in one simulated second. {READINGS} \
             {SIGNS}"
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
            "**Energy and verdicts.** Greatest rise of the total energy above its start among all \
             forcing terms, and the verdicts that occurred. {READINGS}"
        ),
        header,
        names: 1,
        rows: facts.rows.iter().map(line).collect(),
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
        title: "**Wall time of one simulated second.** The paper's rows are its printed columns, \
                from a MIPS R10000 at 250 MHz. Ours: solver is the median of the repetitions with \
                the phase clock off; the phases come from a pass of their own."
            .to_owned(),
        header,
        names: 2,
        rows,
    }
}

/// Least and greatest of the samples, in milliseconds.
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

/// Which row it is, as the leading columns of every table of rows.
fn row_names(row: &Row) -> Vec<String> {
    let k_over_m = power(row.stiffness_over_mass_per_s2);
    vec![
        format!("{}.{} {}", row.table, row.row, subject(row)),
        row.particles.to_string(),
        if row.assumed_reading { k_over_m } else { format!("({k_over_m})") },
        setting(row.step_s),
    ]
}

/// The same for a table that has several lines a row: what tells them apart comes second.
fn case_names(row: &Row, case: &str) -> Vec<String> {
    let mut names = row_names(row);
    names.insert(1, case.to_owned());
    names
}

/// Header of the columns that [`case_names`] makes.
fn case_header(case: &str) -> Vec<String> {
    let mut header = texts(&ROW_HEADER);
    header.insert(1, case.to_owned());
    header
}
