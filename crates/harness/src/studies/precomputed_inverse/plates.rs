//! Figures of the experiment `precomputed-inverse`.

use super::facts::{CG, CHOLESKY, Change, DENSE, Facts, Solver, TimingRow, crossover, of};
use drape_report::number::{median_s, significant, trimmed};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{At, Axis, Look, Panel, Point, Rule, Series, Sheet, State};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "inverse-counts.svg",
        title: "What an inverse, a sparse factor and conjugate gradients cost, counted",
        caption: "The dense inverse costs most in every panel; above the dashed line, a change of \
            h or k costs it more than twenty solves. Operations for the set-up and for one solve, \
            memory, and the set-up over a solve. Hanging sheet; CG at ε = 0.001, at two values of \
            k/m and for one fabric.",
        draw: Draw::Sheet(counts),
    },
    Plate {
        file: "inverse-cost.svg",
        title: "What an inverse, a sparse factor and conjugate gradients cost, timed",
        caption: "A step is fastest with the sparse factor or, on soft sheets, with CG. Above the \
            dashed line a rebuild costs more than twenty steps. Medians of five repetitions on \
            one core against the number of particles: first set-up; rebuild after a change of the \
            step; a whole step of the hanging sheet; the rebuild over a step.",
        draw: Draw::Sheet(cost),
    },
];

/// The name of a curve: its solver and series.
fn name(solver: &str, series: &str) -> String {
    if solver == CG { format!("{solver}, {series}") } else { solver.to_owned() }
}

fn look(solver: &str, order: usize) -> Look {
    match solver {
        DENSE => Look::number(0),
        CHOLESKY => Look::number(1),
        _ => Look::number(2 + order),
    }
}

/// A rebuild that costs more than this many steps counts as expensive.
const DEAR: f64 = 20.0;

/// Values of a quantity, with their solver and series.
type Curve<'a> = (&'a str, &'a str, Vec<(usize, f64)>);

fn panel(title: &str, label: &str, sizes: &[f64], curves: &[Curve<'_>], is_worth: bool) -> Panel {
    let all = curves.iter().flat_map(|(_, _, points)| points).map(|(_, value)| *value);
    let span: Vec<f64> = all.chain(is_worth.then_some(DEAR)).collect();
    let x = Axis::log("particles", sizes);
    let mut panel = Panel::new(vec![title.to_owned()], x, Axis::log(label, &span));
    let mut cg = 0;
    for (solver, series, points) in curves {
        let points =
            points.iter().map(|(n, value)| Point { x: *n as f64, y: *value, state: State::Stable });
        let look = look(solver, cg);
        cg += usize::from(*solver == CG);
        panel.series.extend(Series::new(name(solver, series), look, points.collect()));
    }
    if is_worth {
        panel.rules = vec![Rule { label: "20 times as much".to_owned(), at: At::Y(DEAR) }];
    }
    panel
}

/// The curves of a quantity over some rows, by solver and series.
fn curves<'a, R>(
    rows: &'a [R],
    key: fn(&R) -> (&str, &str, usize),
    value: impl Fn(&R) -> f64,
) -> Vec<Curve<'a>> {
    let mut curves: Vec<Curve<'a>> = Vec::new();
    for row in rows {
        let (solver, series, particles) = key(row);
        let point = (particles, value(row));
        match curves.iter_mut().find(|curve| (curve.0, curve.1) == (solver, series)) {
            Some(curve) => curve.2.push(point),
            None => curves.push((solver, series, vec![point])),
        }
    }
    curves
}

fn counts(input: &Input) -> Option<Sheet> {
    let rows = &input.facts.solvers;
    let sizes: Vec<f64> = rows.iter().map(|row| row.particles as f64).collect();
    let of = |value: fn(&Solver) -> f64| {
        curves(rows, |row| (row.solver.as_str(), row.series.as_str(), row.particles), value)
    };
    let panels = vec![
        panel("To make", "operations", &sizes, &of(|row| row.setup_operations), false),
        panel("To solve once", "operations", &sizes, &of(|row| row.solve_operations), false),
        panel("Memory", "bytes", &sizes, &of(|row| row.kept_bytes as f64), false),
        panel(
            "Set-up over one solve",
            "solves",
            &sizes,
            &of(|row| row.setup_operations / row.solve_operations),
            true,
        ),
    ];
    (!rows.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// Median of the samples, in milliseconds.
fn milliseconds(samples: &[u64]) -> f64 {
    1e3 * median_s(samples)
}

fn worth(row: &TimingRow) -> f64 {
    median_s(&row.rebuild_ns) / median_s(&row.step_ns)
}

fn cost(input: &Input) -> Option<Sheet> {
    let rows = &input.timings.as_ref()?.rows;
    let sizes: Vec<f64> = rows.iter().map(|row| row.particles as f64).collect();
    let of = |value: fn(&TimingRow) -> f64| {
        curves(rows, |row| (row.solver.as_str(), row.series.as_str(), row.particles), value)
    };
    let panels = vec![
        panel("First set-up", "time (ms)", &sizes, &of(|row| milliseconds(&row.setup_ns)), false),
        panel("Rebuild", "time (ms)", &sizes, &of(|row| milliseconds(&row.rebuild_ns)), false),
        panel("A step", "time (ms)", &sizes, &of(|row| milliseconds(&row.step_ns)), false),
        panel("Rebuild over one step", "steps", &sizes, &of(worth), true),
    ];
    let notes = input.machine().into_iter().collect();
    (!rows.is_empty()).then_some(Sheet { panels, notes })
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let mut tables = vec![solvers(input), counted_crossovers(input), changes(input)];
    if let Some(timings) = &input.timings {
        tables.extend([times(&timings.rows), crossovers(&timings.rows)]);
    }
    tables
}

fn solvers(input: &Input) -> Table {
    let line = |row: &Solver| {
        vec![
            row.particles.to_string(),
            name(&row.solver, &row.series),
            row.kept_nonzeros.to_string(),
            significant(row.kept_bytes as f64 / 1024.0, 3),
            significant(row.setup_operations, 3),
            significant(row.solve_operations, 3),
            significant(row.setup_operations / row.solve_operations, 3),
            if row.solver == CG { trimmed(row.cg_per_step, 3) } else { absent() },
            significant(row.disagreement, 2),
        ]
    };
    Table {
        title: "**Counted**: entries and memory of the stored matrix or factor, operations to \
                compute it and to solve once, their ratio, CG iterations a step, relative \
                difference of the solution to the sparse factor's."
            .to_owned(),
        header: texts(&[
            "particles",
            "solver",
            "entries",
            "memory (KiB)",
            "to make",
            "to solve",
            "set-up (solves)",
            "CG a step",
            "difference",
        ]),
        names: 2,
        rows: input.facts.solvers.iter().map(line).collect(),
    }
}

/// The table of the numbers of particles from which on a solve with CG takes fewer operations.
fn counted_crossovers(input: &Input) -> Table {
    let facts = &input.facts;
    let mut series: Vec<&str> = of(facts, CG).map(|row| row.series.as_str()).collect();
    series.sort_unstable();
    series.dedup();
    let line = |series: &&str| {
        let turn = |solver| {
            let others: Vec<_> = of(facts, solver).collect();
            let cg = of(facts, CG).filter(|row| row.series == *series);
            crossover(cg, &others).map_or_else(|| "never here".to_owned(), |n| n.to_string())
        };
        vec![name(CG, series), turn(DENSE), turn(CHOLESKY)]
    };
    Table {
        title: "**Crossover by operations**: the number of particles from which on a solve with \
                CG takes fewer."
            .to_owned(),
        header: texts(&["solves with", "dense inverse", "sparse Cholesky"]),
        names: 1,
        rows: series.iter().map(line).collect(),
    }
}

fn changes(input: &Input) -> Table {
    let line = |run: &Change| {
        let greatest = run.distance_to_fresh_m.iter().copied().fold(0.0, f64::max);
        vec![
            run.solver.clone(),
            run.steps.to_string(),
            run.first.to_string(),
            run.step_size.to_string(),
            run.stiffness.to_string(),
            run.constraints.to_string(),
            significant(greatest, 2),
        ]
    };
    let changed = input.facts.changes.first().map(|run| run.changed.join(", "));
    Table {
        title: format!(
            "**Set-ups by cause** in a run in which the system changes ({}), and the greatest \
             distance to runs that start anew after each \
             change.",
            changed.unwrap_or_default()
        ),
        header: texts(&[
            "solver",
            "steps",
            "first",
            "step size",
            "stiffness, masses",
            "pins",
            "distance (m)",
        ]),
        names: 1,
        rows: input.facts.changes.iter().map(line).collect(),
    }
}

fn times(rows: &[TimingRow]) -> Table {
    let line = |row: &TimingRow| {
        let ms = |samples: &[u64]| significant(milliseconds(samples), 3);
        vec![
            row.particles.to_string(),
            name(&row.solver, &row.series),
            ms(&row.setup_ns),
            ms(&row.rebuild_ns),
            ms(&row.step_ns),
            ms(&row.solve_ns),
            significant(worth(row), 3),
        ]
    };
    Table {
        title: "**Timed**, medians, ms; the rebuild also in steps.".to_owned(),
        header: texts(&[
            "particles",
            "solver",
            "set-up",
            "rebuild",
            "step",
            "solve",
            "rebuild (steps)",
        ]),
        names: 2,
        rows: rows.iter().map(line).collect(),
    }
}

/// The table of the numbers of particles from which on a step with CG is faster.
fn crossovers(rows: &[TimingRow]) -> Table {
    let mut series: Vec<&str> = Vec::new();
    for row in rows.iter().filter(|row| row.solver == CG) {
        if !series.contains(&row.series.as_str()) {
            series.push(&row.series);
        }
    }
    let faster = |series: &str, other: &str| {
        let mut first = None;
        for row in rows.iter().filter(|row| row.solver == CG && row.series == series) {
            let same = |o: &&TimingRow| o.solver == other && o.particles == row.particles;
            let Some(other) = rows.iter().find(same) else { continue };
            if median_s(&row.step_ns) >= median_s(&other.step_ns) {
                first = None;
            } else if first.is_none() {
                first = Some(row.particles);
            }
        }
        first.map_or_else(|| "never here".to_owned(), |n| n.to_string())
    };
    let line =
        |series: &&str| vec![name(CG, series), faster(series, DENSE), faster(series, CHOLESKY)];
    Table {
        title: "**Crossover by the clock**: the number of particles from which on a step with CG \
                is faster."
            .to_owned(),
        header: texts(&["steps with", "dense inverse", "sparse Cholesky"]),
        names: 1,
        rows: series.iter().map(line).collect(),
    }
}
