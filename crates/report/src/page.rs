//! The index page: sections of prose, figures and tables, put into the template.

use crate::ReportError;
use crate::cg::{self, MOTIONS, PRECONDITIONERS, STARTS};
use crate::number::{power, setting, significant, trimmed};
use crate::plot::{names, values};
use crate::tables::{self, VARIANTS};
use drape_records::{Figure, Provenance, Record, Timings};
use minijinja::value::{Serde, Value};
use minijinja::{Environment, UndefinedBehavior, context};
use serde::Serialize;
use std::collections::BTreeSet;

const FILE: &str = "README.md";
const TEMPLATE: &str = include_str!("../templates/README.md.jinja");

/// All that the page says about one experiment.
#[derive(Serialize)]
pub(crate) struct Section {
    name: String,
    question: String,
    method: String,
    command: String,
    quick: bool,
    findings: Vec<String>,
    /// File of the record, beside the page.
    record: String,
    notes: Vec<String>,
    figures: Vec<Figure>,
    tables: Vec<Table>,
    provenance: Vec<Origin>,
}

/// A table of texts.
#[derive(Serialize)]
pub(crate) struct Table {
    pub(crate) title: String,
    pub(crate) header: Vec<String>,
    /// Number of leading columns that hold names, not numbers.
    pub(crate) names: usize,
    pub(crate) rows: Vec<Vec<String>>,
}

/// Provenance of one file.
#[derive(Serialize)]
struct Origin {
    file: String,
    lines: Vec<(String, String)>,
}

/// Fills the template.
pub(crate) fn render(sections: &[Section]) -> Result<String, ReportError> {
    let fill = || {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        environment.add_filter("cell", cell);
        environment.add_template(FILE, TEMPLATE)?;
        let sections = Value::from(Serde(sections));
        environment.get_template(FILE)?.render(context! { sections })
    };
    let page = fill().map_err(|source| ReportError::Page { file: FILE, source })?;
    Ok(format!("{}\n", page.trim_end()))
}

/// Text that stays inside one cell of a Markdown table.
fn cell(text: String) -> String {
    text.replace('\\', "\\\\").replace('|', "\\|").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The tables of `tables`.
pub(crate) fn tables_of_tables(input: &tables::Input) -> Vec<Table> {
    let mut tables = vec![best_fits(input), counts(input), energies(input)];
    tables.extend(input.timings.is_some().then(|| times(input)));
    tables
}

impl Section {
    /// The section of a record with its figures and tables; tables without rows are left out.
    pub(crate) fn new<F>(record: &Record<F>, figures: Vec<Figure>, tables: Vec<Table>) -> Self {
        let mut section = of_record(record, figures);
        section.tables = tables;
        section.tables.retain(|table| !table.rows.is_empty());
        section
    }

    /// The same with what is known of the timings that stand beside the record.
    pub(crate) fn with_timings<R>(mut self, timings: Option<&Timings<R>>) -> Self {
        let file = format!("timings/{}", self.record);
        match timings {
            Some(timings) => {
                self.notes.push(format!("How the times were taken: {}", timings.method));
                self.provenance.push(origin(&file, &timings.provenance));
            }
            None => self.notes.push(format!(
                "No timings were taken here (`{file}` is absent): figures and tables of times are left out."
            )),
        }
        self
    }
}

/// The tables of `cg-vs-stiffness`.
pub(crate) fn tables_of_cg(record: &cg::Input) -> Vec<Table> {
    vec![iterations(record), variants(record), motion(record)]
}

fn of_record<F>(record: &Record<F>, figures: Vec<Figure>) -> Section {
    let file = format!("{}.json", record.experiment);
    Section {
        name: record.experiment.clone(),
        question: record.question.clone(),
        method: record.method.clone(),
        command: record.command.clone(),
        quick: record.quick,
        findings: record.findings.clone(),
        notes: Vec::new(),
        figures,
        tables: Vec::new(),
        provenance: vec![origin(&file, &record.provenance)],
        record: file,
    }
}

fn origin(file: &str, provenance: &Provenance) -> Origin {
    let unknown = || "unknown".to_owned();
    let dirty = match provenance.dirty {
        Some(true) => "with uncommitted changes",
        Some(false) => "clean",
        None => "state of the tree unknown",
    };
    let commit = provenance.commit.clone().unwrap_or_else(unknown);
    let rustc = provenance.rustc.lines().next().unwrap_or_default();
    let mut lines = vec![
        ("commit".to_owned(), format!("{commit}, {dirty}")),
        ("version".to_owned(), provenance.version.clone()),
        ("rustc".to_owned(), rustc.to_owned()),
        ("build".to_owned(), provenance.build.clone()),
        ("cpu".to_owned(), provenance.cpu.clone()),
        ("threads".to_owned(), provenance.threads.to_string()),
        ("Cargo.lock (SHA-256)".to_owned(), provenance.cargo_lock_sha256.clone()),
        (
            "seed".to_owned(),
            provenance.seed.map_or_else(|| "none drawn".to_owned(), |s| s.to_string()),
        ),
        ("date (UTC)".to_owned(), provenance.date.clone()),
    ];
    lines.extend(
        provenance
            .scene_sha256
            .iter()
            .map(|(scene, hash)| (format!("scene `{scene}` (SHA-256)"), hash.clone())),
    );
    Origin { file: format!("`{file}`"), lines }
}

/// A sign behind the number of a run that was not stable.
fn sign(verdict: &str) -> &'static str {
    match verdict {
        "stable" => "",
        "marginal" => " °",
        _ => " ✗",
    }
}

const SIGNS: &str = "° marginal, ✗ unstable or diverged.";

pub(crate) fn texts(parts: &[&str]) -> Vec<String> {
    parts.iter().map(|part| (*part).to_owned()).collect()
}

/// Which row it is, as the leading columns of every table of rows.
fn row_names(row: &drape_records::tables::Row) -> Vec<String> {
    let k_over_m = power(row.stiffness_over_mass_per_s2);
    vec![
        format!("{}.{} {}", row.table, row.row, tables::subject(row)),
        row.particles.to_string(),
        if row.assumed_reading { k_over_m } else { format!("({k_over_m})") },
        setting(row.step_s),
    ]
}

/// The same for a table that has several lines a row: what tells them apart comes second.
fn case_names(row: &drape_records::tables::Row, case: &str) -> Vec<String> {
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

const ROW_HEADER: [&str; 4] = ["table.row", "particles", "k/m (s⁻²)", "h (s)"];
const READINGS: &str = "k/m in brackets: a neighbouring reading of the illegible exponent.";

fn best_fits(input: &tables::Input) -> Table {
    let rows = &input.record.facts.rows;
    let found = rows.iter().flat_map(|row| &row.best_fit).map(|fit| fit.variant.as_str());
    let variants = names(&VARIANTS, found);
    let mut header = texts(&ROW_HEADER);
    header.extend(texts(&["d/m (1/s)", "paper's count"]));
    header.extend(variants.iter().map(|variant| format!("{variant}: count (ratio) at ε")));
    let line = |row: &drape_records::tables::Row| {
        let mut line = row_names(row);
        line.push(setting(row.damping_over_mass_per_s));
        line.push(row.paper.cg_iterations.to_string());
        line.extend(variants.iter().map(|variant| {
            let fit = row.best_fit.iter().find(|fit| fit.variant == *variant);
            fit.map_or_else(absent, |fit| {
                let verdict = tables::verdict(row, variant, fit.forcing_term).unwrap_or("stable");
                format!(
                    "{} ({}) at {}{}",
                    fit.cg_iterations,
                    significant(fit.ratio, 3),
                    setting(fit.forcing_term),
                    sign(verdict)
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

pub(crate) fn absent() -> String {
    "–".to_owned()
}

fn counts(input: &tables::Input) -> Table {
    let facts = &input.record.facts;
    let mut terms =
        values(facts.rows.iter().flat_map(|row| &row.cells).map(|cell| cell.forcing_term));
    terms.reverse();
    let mut header = case_header("variant");
    header.push("paper's count".to_owned());
    header.extend(terms.iter().map(|term| format!("ε = {}", setting(*term))));
    let mut rows = Vec::new();
    for row in &facts.rows {
        for variant in tables::variants(facts) {
            let cells: Vec<_> = row.cells.iter().filter(|cell| cell.variant == variant).collect();
            if cells.is_empty() {
                continue;
            }
            let mut line = case_names(row, variant);
            line.push(row.paper.cg_iterations.to_string());
            line.extend(terms.iter().map(|term| {
                let cell = cells.iter().find(|cell| cell.forcing_term == *term);
                cell.map_or_else(absent, |c| format!("{}{}", c.cg_iterations, sign(&c.verdict)))
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

fn energies(input: &tables::Input) -> Table {
    let facts = &input.record.facts;
    let variants = tables::variants(facts);
    let mut header = texts(&ROW_HEADER);
    header.extend(variants.iter().map(|variant| format!("{variant}: energy gain (J), verdicts")));
    let line = |row: &drape_records::tables::Row| {
        let mut line = row_names(row);
        line.extend(variants.iter().map(|variant| {
            let cells = || row.cells.iter().filter(|cell| cell.variant == *variant);
            let gain = cells().map(|cell| cell.energy_gain_j).max_by(f64::total_cmp);
            let verdicts: BTreeSet<&str> = cells().map(|cell| cell.verdict.as_str()).collect();
            let verdicts: Vec<&str> = verdicts.into_iter().collect();
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

fn times(input: &tables::Input) -> Table {
    let timings = input.timings.iter().flat_map(|timings| &timings.rows);
    let mut rows = Vec::new();
    for row in &input.record.facts.rows {
        let timed: Vec<_> = timings.clone().filter(|timing| timing.id == row.id).collect();
        if timed.is_empty() {
            continue;
        }
        let parts = |parts: [f64; 3]| parts.map(tables::milliseconds);
        let mut line = case_names(row, "the paper");
        line.push(row.paper.cg_iterations.to_string());
        line.extend([tables::milliseconds(row.paper.solver_s), absent()]);
        line.extend(parts(tables::paper_parts(row)));
        rows.push(line);
        for timing in timed {
            let mut line = case_names(row, &tables::timed_case(timing));
            line.push(timing.cg_iterations.to_string());
            line.extend([tables::milliseconds(timing.solver_s), spread(&timing.samples_ns)]);
            line.extend(parts(tables::parts(timing)));
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
            let milliseconds = |ns: u64| tables::milliseconds(ns as f64 * 1e-9);
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

/// Lines of a table over material, size and stiffness: one for each that `cells` hold.
fn by_stiffness(
    cells: &[&drape_records::cg::Cell],
    columns: impl Fn(&[&drape_records::cg::Cell]) -> Vec<String>,
) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for material in names(&["fixed-k-over-m"], cells.iter().map(|c| c.material.as_str())) {
        let sizes: BTreeSet<usize> = cells.iter().map(|c| c.particles).collect();
        for n in sizes {
            for k_over_m in values(cells.iter().map(|c| c.stiffness_over_mass_per_s2)) {
                let chosen: Vec<_> = cells
                    .iter()
                    .copied()
                    .filter(|c| c.material == material && c.particles == n)
                    .filter(|c| c.stiffness_over_mass_per_s2 == k_over_m)
                    .collect();
                if !chosen.is_empty() {
                    let mut line = vec![material.to_owned(), n.to_string(), power(k_over_m)];
                    line.extend(columns(&chosen));
                    rows.push(line);
                }
            }
        }
    }
    rows
}

const CG_HEADER: [&str; 3] = ["series", "particles", "k/m (s⁻²)"];

fn per_step(cell: &drape_records::cg::Cell) -> String {
    format!("{}{}", trimmed(cell.cg_per_step, 3), sign(&cell.verdict))
}

fn base_cells(record: &cg::Input) -> Vec<&drape_records::cg::Cell> {
    let cells = record.facts.cells.iter();
    cells.filter(|cell| cell.series == "stiffness" && cg::at_base_point(cell)).collect()
}

fn iterations(record: &cg::Input) -> Table {
    let mut cells = base_cells(record);
    cells.retain(|cell| cell.variant == "plain");
    let preconditioners = names(&PRECONDITIONERS, cells.iter().map(|c| c.preconditioner.as_str()));
    let starts = names(&STARTS, cells.iter().map(|c| c.start.as_str()));
    let pairs: Vec<(&str, &str)> = preconditioners
        .iter()
        .flat_map(|p| starts.iter().map(move |s| (*p, *s)))
        .filter(|(p, s)| cells.iter().any(|c| c.preconditioner == *p && c.start == *s))
        .collect();
    let mut header = texts(&CG_HEADER);
    header.extend(pairs.iter().map(|(p, s)| format!("{p}, {s}")));
    let rows = by_stiffness(&cells, |cells| {
        let cell = |(p, s): &(&str, &str)| {
            let cell = cells.iter().find(|c| c.preconditioner == *p && c.start == *s);
            cell.map_or_else(absent, |cell| per_step(cell))
        };
        pairs.iter().map(cell).collect()
    });
    Table {
        title: format!(
            "**CG iterations per step of the plain method** at h = 0.01 s, ε = 0.05, by \
             preconditioner and start vector. {SIGNS}"
        ),
        header,
        names: 1,
        rows,
    }
}

fn variants(record: &cg::Input) -> Table {
    let mut cells = base_cells(record);
    cells.retain(|cell| cg::with_base_solver(cell));
    let variants = names(&VARIANTS, cells.iter().map(|c| c.variant.as_str()));
    let mut header = texts(&CG_HEADER);
    header.extend(variants.iter().map(|v| format!("{v}: per step; energy gain (J)")));
    let rows = by_stiffness(&cells, |cells| {
        let cell = |variant: &&str| {
            let cell = cells.iter().find(|c| c.variant == *variant);
            cell.map_or_else(absent, |c| {
                format!("{}; {}", per_step(c), significant(c.energy_gain_j, 3))
            })
        };
        variants.iter().map(cell).collect()
    });
    Table {
        title: format!(
            "**CG iterations per step, plain and updated,** with ic0 and extrapolated start at \
             h = 0.01 s, ε = 0.05, and the greatest rise of the total energy above its start. {SIGNS}"
        ),
        header,
        names: 1,
        rows,
    }
}

fn motion(record: &cg::Input) -> Table {
    let motion = &record.facts.motion;
    let labels = names(&MOTIONS, motion.iter().map(|m| m.label.as_str()));
    let mut rows = Vec::new();
    for step in values(motion.iter().map(|m| m.step_s)) {
        for k_over_m in values(motion.iter().map(|m| m.stiffness_over_mass_per_s2)) {
            let chosen: Vec<_> = motion
                .iter()
                .filter(|m| m.step_s == step && m.stiffness_over_mass_per_s2 == k_over_m)
                .collect();
            if chosen.is_empty() {
                continue;
            }
            let mut line = vec![setting(step), power(k_over_m)];
            line.extend(labels.iter().map(|label| {
                let found = chosen.iter().find(|m| m.label == *label);
                found.map_or_else(absent, |m| {
                    format!("{}{}", significant(m.fall_m, 3), sign(&m.verdict))
                })
            }));
            rows.push(line);
        }
    }
    let mut header = texts(&["h (s)", "k/m (s⁻²)"]);
    header.extend(labels.iter().map(|label| format!("{label} (m)")));
    Table {
        title: format!(
            "**Vertical displacement of the free edge's midpoint** at t = 0.3 s (negative: down). \
             {SIGNS}"
        ),
        header,
        names: 0,
        rows,
    }
}
