//! Figures of the experiment `tables`: the paper's two tables with drape's counts.

pub(super) mod tabulated;

use super::facts::{Facts, PLAIN, Row, TimingRow, UPDATED_PAPER, UPDATED_ROBUST, VARIANTS};
use crate::families::looks;
use drape_report::Verdict;
use drape_report::number::{power, setting, significant};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Axis, Bar, Draft, Fill, Look, Panel, Point, Rule, Series, Sheet, State, names, panels_of,
    place_of,
};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "tables-counts.svg",
        title: "CG iterations against the forcing term, beside the paper's",
        caption: "Where a curve meets the dashed line, that ε repeats the paper's count; no single \
            ε does so in all rows. Conjugate-gradient (CG) iterations of one second against the \
            forcing term ε, at which the solver stops, a panel for each row of the paper's tables \
            2 and 3. The illegible exponents of k/m are read as 4 and 6.",
        draw: Draw::Sheet(counts),
    },
    Plate {
        file: "tables-exponents.svg",
        title: "Which reading of the illegible exponent fits the paper's counts",
        caption: "Several readings come near the dashed line, our count equal to the paper's: the \
            counts do not decide the exponents. CG iterations of one second at the best-fitting ε \
            over the paper's count, for each reading of k/m, a panel for each row of the paper's \
            tables 2 and 3. The dotted upright line is the reading that drape takes.",
        draw: Draw::Sheet(exponents),
    },
    Plate {
        file: "tables-cost.svg",
        title: "Where the time of one second goes, on the paper's machine and on ours",
        caption: "If the matrix is kept from step to step, its set-up almost vanishes; on the \
            paper's machine it took a fifth to a half of the time. Shares of the solver's wall \
            time; our shares come from a pass with a clock around each phase, and the time behind \
            a bar is the median without that clock. The paper's machine is a MIPS R10000 at 250 \
            MHz: compare shares, not times.",
        draw: Draw::Sheet(cost),
    },
];

/// The variants of the rows' cells, in order.
pub(super) fn variants(facts: &Facts) -> Vec<&str> {
    names(&VARIANTS, facts.rows.iter().flat_map(|row| &row.cells).map(|cell| cell.variant.as_str()))
}

/// The verdict on the run of a variant at a forcing term.
pub(super) fn verdict(row: &Row, variant: &str, forcing_term: f64) -> Option<Verdict> {
    let cells = || row.cells.iter().filter(|cell| cell.variant == variant);
    cells().find(|cell| cell.forcing_term == forcing_term).map(|cell| cell.verdict)
}

/// The subject of the printed table.
pub(super) fn subject(row: &Row) -> &str {
    match row.table {
        2 => "square table",
        3 => "hanging textile",
        _ => &row.scene,
    }
}

fn heading(row: &Row) -> String {
    format!("Table {}, row {}: {}", row.table, row.row, subject(row))
}

/// The look of a variant. The safeguarded form is the default one, so it has the look of its method,
/// as in all figures. Some variants are drawn without lines, so the printed form has another marker.
pub(in crate::studies) fn look_of_variant(variant: &str) -> Look {
    let forms = looks(&["imex-updated"; 2]);
    match variant {
        PLAIN => looks(&["imex-euler"])[0],
        UPDATED_ROBUST => forms[0],
        UPDATED_PAPER => forms[1].shifted(1),
        _ => Look::number(place_of(variant, &VARIANTS)),
    }
}

fn counts(input: &Input) -> Option<Sheet> {
    let facts = &input.facts;
    let rows: Vec<&Row> = facts.rows.iter().filter(|row| row.assumed_reading).collect();
    let drafts: Vec<Draft> = rows
        .iter()
        .map(|row| {
            let series = variants(facts).into_iter().filter_map(|variant| {
                let cells = row.cells.iter().filter(|cell| cell.variant == variant);
                let points = cells.map(|cell| Point {
                    x: cell.forcing_term,
                    y: cell.cg_iterations as f64,
                    state: State::of_verdict(cell.verdict),
                });
                Series::new(variant.to_owned(), look_of_variant(variant), points.collect())
            });
            let conditions = format!(
                "{} particles, k/m = {} s⁻², h = {} s",
                row.particles,
                power(row.stiffness_over_mass_per_s2),
                setting(row.step_s)
            );
            let paper = Rule {
                label: "the paper's count".to_owned(),
                at: At::Y(row.paper.cg_iterations as f64),
            };
            (vec![heading(row), conditions], series.collect(), vec![paper])
        })
        .collect();
    panels_of(
        drafts,
        |xs| Axis::log("forcing term ε (dimensionless)", xs),
        |ys| {
            let paper = rows.iter().map(|row| row.paper.cg_iterations as f64);
            let all: Vec<f64> = ys.iter().copied().chain(paper).collect();
            Axis::log_with_zero("CG iterations in 1 s", &all)
        },
    )
}

fn exponents(input: &Input) -> Option<Sheet> {
    let facts = &input.facts;
    let variants = names(
        &VARIANTS,
        facts.rows.iter().flat_map(|row| &row.best_fit).map(|fit| fit.variant.as_str()),
    );
    let drafts = facts
        .rows
        .iter()
        .filter(|row| row.assumed_reading)
        .map(|taken| {
            let readings: Vec<&Row> = facts
                .rows
                .iter()
                .filter(|row| (row.table, row.row) == (taken.table, taken.row))
                .collect();
            let series = variants.iter().filter_map(|variant| {
                let points = readings.iter().flat_map(|row| {
                    let fits = row.best_fit.iter().filter(|fit| fit.variant == *variant);
                    fits.map(|fit| Point {
                        x: row.stiffness_over_mass_per_s2,
                        y: fit.ratio,
                        state: verdict(row, variant, fit.forcing_term)
                            .map_or(State::Stable, State::of_verdict),
                    })
                });
                Series::new((*variant).to_owned(), look_of_variant(variant), points.collect())
            });
            let conditions = format!(
                "{} particles, h = {} s, paper: {}",
                taken.particles,
                setting(taken.step_s),
                taken.paper.cg_iterations
            );
            let rules = vec![
                Rule { label: "ratio 1: the paper's count".to_owned(), at: At::Y(1.0) },
                Rule {
                    label: "reading that drape takes".to_owned(),
                    at: At::X(taken.stiffness_over_mass_per_s2),
                },
            ];
            (vec![heading(taken), conditions], series.collect(), rules)
        })
        .collect();
    panels_of(
        drafts,
        |xs| Axis::log("stiffness over mass k/m (s⁻²)", xs),
        |ys| {
            let all: Vec<f64> = ys.iter().copied().chain([1.0]).collect();
            Axis::log_with_zero("count / paper's count (ratio)", &all)
        },
    )
}

/// Seconds in CG, in the set-up of the matrix, and in the rest.
pub(super) fn parts(row: &TimingRow) -> [f64; 3] {
    let phases = &row.phases_s;
    [phases.solve, phases.matrix_setup, phases.forces + phases.contact + phases.update]
}

/// Seconds in CG, in the set-up of the matrix, and in the rest, as the paper printed them.
pub(super) fn paper_parts(row: &Row) -> [f64; 3] {
    let paper = &row.paper;
    let rest = (paper.solver_s - paper.cg_s - paper.matrix_setup_s).max(0.0);
    [paper.cg_s, paper.matrix_setup_s, rest]
}

/// The name of a timed case, e.g. `plain, matrix kept`.
pub(super) fn timed_case(row: &TimingRow) -> String {
    format!("{}, matrix {}", row.variant, row.matrix)
}

/// Milliseconds with three digits, as text.
pub(super) fn milliseconds(seconds: f64) -> String {
    significant(1e3 * seconds, 3)
}

fn cost(input: &Input) -> Option<Sheet> {
    let timings = input.timings.as_ref()?;
    let panels: Vec<Panel> = input
        .facts
        .rows
        .iter()
        .filter_map(|row| {
            let timed: Vec<&TimingRow> = timings.rows.iter().filter(|t| t.id == row.id).collect();
            (!timed.is_empty()).then(|| cost_panel(row, &timed))
        })
        .collect();
    let notes = input.machine().into_iter().collect();
    (!panels.is_empty()).then_some(Sheet { panels, notes })
}

fn cost_panel(row: &Row, timed: &[&TimingRow]) -> Panel {
    let paper = ("the paper".to_owned(), paper_parts(row), row.paper.solver_s);
    let ours = timed.iter().map(|t| (timed_case(t), parts(t), t.solver_s));
    let cases: Vec<_> = std::iter::once(paper).chain(ours).collect();
    let names: Vec<String> = cases.iter().map(|(name, ..)| name.clone()).collect();
    let title = format!(
        "{}, {} particles, k/m = {} s⁻², h = {} s",
        heading(row),
        row.particles,
        power(row.stiffness_over_mass_per_s2),
        setting(row.step_s)
    );
    let bars = cases.iter().enumerate().map(|(n, (_, parts, solver_s))| {
        let whole: f64 = parts.iter().sum();
        let share = |part: f64| if whole > 0.0 { 100.0 * part / whole } else { 0.0 };
        Bar {
            y: -(n as f64),
            parts: vec![
                ("CG", Fill::Dark, share(parts[0])),
                ("set-up of the matrix", Fill::Hatched, share(parts[1])),
                ("rest", Fill::Light, share(parts[2])),
            ],
            reach: f64::INFINITY,
            end: format!("{} ms per simulated s", milliseconds(*solver_s)),
        }
    });
    Panel {
        bars: bars.collect(),
        ..Panel::new(
            vec![title],
            Axis::per_cent("share of the solver's time (%)"),
            Axis::names("", &names),
        )
    }
}
