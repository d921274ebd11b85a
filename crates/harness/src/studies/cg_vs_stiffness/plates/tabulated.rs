//! The tables of the experiment `cg-vs-stiffness`.

use super::super::facts::Cell;
use super::{Input, MOTIONS, PRECONDITIONERS, STARTS, at_base_point, with_base_solver};
use crate::studies::tables::facts::VARIANTS;
use drape_report::number::{power, setting, significant, trimmed};
use drape_report::page::{Table, absent, texts};
use drape_report::plot::{names, values};
use drape_report::verdict::SIGNS;
use std::collections::BTreeSet;

/// The tables of `cg-vs-stiffness`.
pub(in super::super) fn tables(record: &Input) -> Vec<Table> {
    vec![iterations(record), variants(record), motion(record)]
}

/// Lines of a table over material, size and stiffness: one for each that `cells` hold.
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
    cells.filter(|cell| cell.series == "stiffness" && at_base_point(cell)).collect()
}

fn iterations(record: &Input) -> Table {
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
                    format!("{}{}", significant(m.fall_m, 3), m.verdict.sign())
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
