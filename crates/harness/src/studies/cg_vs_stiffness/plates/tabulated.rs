//! The tables of the experiment `cg-vs-stiffness`.

use super::super::facts::{
    Cell, FORCING_TERMS, PLAIN, STEP, STIFFNESS, at_base_point, at_base_step, with_base_solver,
};
use super::{Input, MOTIONS, PRECONDITIONERS, STARTS};
use crate::studies::tables::facts::VARIANTS;
use drape_report::Verdict;
use drape_report::number::{power, setting, significant, trimmed};
use drape_report::page::{Table, absent, texts};
use drape_report::plot::{names, values};
use drape_report::verdict::SIGNS;
use std::collections::BTreeSet;

/// The tables of `cg-vs-stiffness`.
pub(in super::super) fn tables(record: &Input) -> Vec<Table> {
    vec![
        iterations(record),
        variants(record),
        gaining(record),
        sweep(record, STEP, "h", |cell| cell.step_s),
        sweep(record, FORCING_TERMS, "ε", |cell| cell.forcing_term),
        motion(record),
    ]
}

/// Lines of a table: one for each material, size and stiffness in `cells`.
fn by_stiffness(cells: &[&Cell], columns: impl Fn(&[&Cell]) -> Vec<String>) -> Vec<Vec<String>> {
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

fn per_step(cell: &Cell) -> String {
    format!("{}{}", trimmed(cell.cg_per_step, 3), cell.verdict.sign())
}

fn base_cells(record: &Input) -> Vec<&Cell> {
    let cells = record.facts.cells.iter();
    cells.filter(|cell| cell.series == STIFFNESS && at_base_point(cell)).collect()
}

fn iterations(record: &Input) -> Table {
    let mut cells = base_cells(record);
    cells.retain(|cell| cell.variant == PLAIN);
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
            "**CG iterations per step of plain CG**, by preconditioner and start vector. \
             h = 0.01 s, ε = 0.05. {SIGNS}"
        ),
        header,
        names: 1,
        rows,
    }
}

fn variants(record: &Input) -> Table {
    let mut cells = base_cells(record);
    cells.retain(|cell| with_base_solver(cell));
    let variants = names(&VARIANTS, cells.iter().map(|c| c.variant.as_str()));
    let mut header = texts(&CG_HEADER);
    header.extend(variants.iter().map(|v| format!("{v}: per step; energy gain (J)")));
    let rows = by_stiffness(&cells, |cells| {
        let cell = |variant: &&str| {
            let cell = cells.iter().find(|c| c.variant == *variant);
            cell.map_or_else(absent, |c| {
                let newton = match c.newton_iterations {
                    0 => String::new(),
                    count => format!("; {count} Newton"),
                };
                format!("{}; {}{newton}", per_step(c), significant(c.energy_gain_j, 3))
            })
        };
        variants.iter().map(cell).collect()
    });
    Table {
        title: format!(
            "**CG iterations per step and gain of energy, plain and updated**, with the Newton \
             iterations of the run. ic0, h = 0.01 s, ε = 0.05. {SIGNS}"
        ),
        header,
        names: 1,
        rows,
    }
}

/// The table of runs of plain CG that gained energy, greatest gain first.
fn gaining(record: &Input) -> Table {
    let mut cells: Vec<_> = record.facts.cells.iter().collect();
    cells.retain(|cell| cell.series == STIFFNESS && cell.variant == PLAIN);
    cells.retain(|cell| cell.verdict != Verdict::Stable);
    cells.sort_by(|a, b| b.energy_gain_j.total_cmp(&a.energy_gain_j));
    let line = |cell: &&Cell| {
        vec![
            cell.material.clone(),
            cell.particles.to_string(),
            power(cell.stiffness_over_mass_per_s2),
            cell.preconditioner.clone(),
            cell.start.clone(),
            format!("{}{}", significant(cell.energy_gain_j, 3), cell.verdict.sign()),
            format!("{} of {}", cell.idle_steps, cell.steps),
        ]
    };
    let mut header = texts(&CG_HEADER);
    header.extend(texts(&["preconditioner", "start", "gain (J)", "steps without an iteration"]));
    Table {
        title: format!("**Runs of plain CG that gained energy**, the greatest gain first. {SIGNS}"),
        header,
        names: 1,
        rows: cells.iter().map(line).collect(),
    }
}

/// The table of CG iterations in one second, for a sweep over the step or the forcing term.
fn sweep(record: &Input, series: &str, name: &str, of: fn(&Cell) -> f64) -> Table {
    let mut cells: Vec<_> = record.facts.cells.iter().collect();
    cells.retain(|cell| cell.series == series && with_base_solver(cell));
    cells.retain(|cell| series == STEP || at_base_step(cell));
    let columns = values(cells.iter().map(|cell| of(cell)));
    let mut rows = Vec::new();
    for variant in names(&VARIANTS, cells.iter().map(|cell| cell.variant.as_str())) {
        for k_over_m in values(cells.iter().map(|cell| cell.stiffness_over_mass_per_s2)) {
            let cell = |value: &f64| {
                let mut cells = cells.iter().filter(|cell| cell.variant == variant);
                let found = cells
                    .find(|cell| cell.stiffness_over_mass_per_s2 == k_over_m && of(cell) == *value);
                let count = |c: &&Cell| format!("{}{}", c.cg_iterations, c.verdict.sign());
                found.map_or_else(absent, count)
            };
            let mut line = vec![variant.to_owned(), power(k_over_m)];
            line.extend(columns.iter().map(cell));
            rows.push(line);
        }
    }
    let mut header = texts(&["variant", "k/m (s⁻²)"]);
    let unit = if series == STEP { " s" } else { "" };
    header.extend(columns.iter().map(|value| format!("{name} = {}{unit}", setting(*value))));
    Table {
        title: format!("**CG iterations in one second** by {name}. {SIGNS}"),
        header,
        names: 1,
        rows,
    }
}

fn motion(record: &Input) -> Table {
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
                    let gain = match m.verdict {
                        Verdict::Stable => String::new(),
                        _ => format!(" ({} J)", significant(m.energy_gain_j, 3)),
                    };
                    format!("{}{}{gain}", significant(m.fall_m, 3), m.verdict.sign())
                })
            }));
            rows.push(line);
        }
    }
    let mut header = texts(&["h (s)", "k/m (s⁻²)"]);
    header.extend(labels.iter().map(|label| format!("{label} (m)")));
    Table {
        title: format!(
            "**Fall of the free edge's midpoint** at t = 0.3 s (negative: down), with the gain of \
             energy of a run that was not stable. {SIGNS}"
        ),
        header,
        names: 0,
        rows,
    }
}
