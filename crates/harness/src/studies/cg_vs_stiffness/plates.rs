//! Figures of the experiment `cg-vs-stiffness`.

pub(super) mod tabulated;

use super::facts::{
    BASE_PRECONDITIONER, BASE_START, Cell, FORCING_TERMS, Facts, IMPLICIT, PLAIN_MOTION, STEP,
    STIFFNESS, TENSION_ONLY, UPDATED_MOTION, UPDATED_ROBUST, at_base_forcing_term, at_base_point,
    at_base_step, at_fixed_k_over_m, with_base_solver,
};
use crate::families::look_among;
use crate::studies::tables::facts::VARIANTS;
use crate::studies::tables::plates::look_of_variant;
use drape_report::number::{power, setting};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    Axis, Draft, Look, Point, Series, Sheet, State, names, panels_of, place_of, values,
};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "cg-vs-stiffness.svg",
        title: "CG iterations per step against stiffness",
        caption: "With incomplete Cholesky (ic0) the count of plain CG stays lowest on stiff \
            sheets; updated CG as printed (updated-paper) is unstable there. Hanging textile, h = \
            0.01 s, ε = 0.05; conjugate-gradient (CG) iterations per step against k/m. Colour and \
            dashes tell the preconditioner, markers the start vector: the last velocity, or its \
            extrapolation.",
        draw: Draw::Sheet(against_stiffness),
    },
    Plate {
        file: "cg-vs-theta.svg",
        title: "CG iterations per step against θ = h²k/m",
        caption: "For plain CG θ = h²k/m nearly decides the count: curves of different steps h lie \
            close together, at large θ less so. Hanging textile, ic0, extrapolated start, \
            ε = 0.05; CG iterations per step of all steps and stiffnesses that were run, at fixed \
            k/m and at fixed material.",
        draw: Draw::Sheet(against_theta),
    },
    Plate {
        file: "cg-plain-vs-updated.svg",
        title: "CG iterations per step, plain and updated",
        caption: "Updates cost iterations. As printed (updated-paper) they take some more than \
            plain CG and are unstable on stiff sheets; safeguarded (updated-robust) they take \
            many more and are always stable. Hanging textile, ic0, h = 0.01 s, ε = 0.05; \
            iterations of all passes per step against k/m. Above h²k/m = 100 the safeguarded form \
            takes Newton iterations instead, each with a factorisation.",
        draw: Draw::Sheet(plain_and_updated),
    },
    Plate {
        file: "cg-vs-step.svg",
        title: "CG iterations in one second against the time step",
        caption: "Short steps do not pay: each solve is easier, but there are more of them, and \
            plain CG takes the most iterations at the shortest step. Hanging textile, ic0, \
            extrapolated start, ε = 0.05; all CG iterations of one simulated second against the \
            step h, a curve for each k/m.",
        draw: Draw::Sheet(against_step),
    },
    Plate {
        file: "cg-vs-forcing-term.svg",
        title: "CG iterations per step against the forcing term",
        caption: "Updated CG needs a tight tolerance on the stiff sheet, which costs iterations; \
            with a loose one it is unstable. Hanging textile, ic0, extrapolated start, h = 0.01 \
            s; CG iterations per step against the forcing term ε, the relative tolerance at which \
            the solver stops (tight on the left), a curve for each k/m.",
        draw: Draw::Sheet(against_forcing_term),
    },
    Plate {
        file: "motion-vs-stiffness.svg",
        title: "Fall of the free edge after 0.3 s against stiffness",
        caption: "On stiff springs the sheet of plain IMEX Euler hardly falls, however few \
            iterations it takes; updated CG lies on backward Euler. Hanging textile with shear \
            springs, h = 0.01 s, default settings; vertical displacement of the free edge's \
            midpoint (negative: down) against k/m. Tension only: shear springs are left out of the \
            matrix. A diverged run beyond the panel stands on its edge.",
        draw: Draw::Sheet(motion),
    },
];

pub(super) const PRECONDITIONERS: [&str; 3] = ["none", "jacobi", BASE_PRECONDITIONER];
pub(super) const STARTS: [&str; 3] = [BASE_START, "last", "best"];
/// Labels of the curves of motion, in the legend's order.
pub(super) const MOTIONS: [&str; 4] = [PLAIN_MOTION, UPDATED_MOTION, TENSION_ONLY, IMPLICIT];

const K_OVER_M: &str = "stiffness over mass k/m (s⁻²)";
const PER_STEP: &str = "CG iterations per step";

/// The cells of one sweep that `kind` selects.
fn select<'a>(input: &'a Input, series: &str, kind: impl Fn(&Cell) -> bool) -> Vec<&'a Cell> {
    input.facts.cells.iter().filter(|cell| cell.series == series && kind(cell)).collect()
}

fn point(cell: &Cell, x: f64, y: f64) -> Point {
    Point { x, y, state: State::of_verdict(cell.verdict) }
}

fn particles(n: usize) -> String {
    format!("{n} particles")
}

/// The different numbers of particles, ascending.
fn sizes(cells: &[&Cell]) -> Vec<usize> {
    let sizes: std::collections::BTreeSet<usize> = cells.iter().map(|c| c.particles).collect();
    sizes.into_iter().collect()
}

/// One panel for each number of particles; `series` makes its curves.
fn by_size(cells: &[&Cell], series: impl Fn(&[&Cell]) -> Vec<Series>) -> Vec<Draft> {
    let of_size = |n| cells.iter().copied().filter(|cell| cell.particles == n).collect::<Vec<_>>();
    sizes(cells)
        .into_iter()
        .map(|n| (vec![particles(n)], series(&of_size(n)), Vec::new()))
        .collect()
}

/// One curve for each different value of a quantity.
fn by_value(
    cells: &[&Cell],
    all: &[f64],
    quantity: fn(&Cell) -> f64,
    label: impl Fn(f64) -> String,
    place: impl Fn(&Cell) -> Point,
) -> Vec<Series> {
    all.iter()
        .enumerate()
        .filter_map(|(n, value)| {
            let points = cells.iter().filter(|cell| quantity(cell) == *value);
            Series::new(label(*value), Look::number(n), points.map(|cell| place(cell)).collect())
        })
        .collect()
}

fn against_stiffness(input: &Input) -> Option<Sheet> {
    let cells = select(input, STIFFNESS, |cell| {
        cell.variant != UPDATED_ROBUST && at_fixed_k_over_m(cell) && at_base_point(cell)
    });
    let preconditioners = names(&PRECONDITIONERS, cells.iter().map(|c| c.preconditioner.as_str()));
    let starts = names(&STARTS, cells.iter().map(|c| c.start.as_str()));
    let drafts = by_size_and_variant(&cells, |cells| {
        let pairs = preconditioners.iter().flat_map(|p| starts.iter().map(move |s| (*p, *s)));
        pairs
            .filter_map(|(preconditioner, start)| {
                let look = Look::pair(
                    place_of(preconditioner, &PRECONDITIONERS),
                    place_of(start, &STARTS),
                );
                let chosen =
                    cells.iter().filter(|c| c.preconditioner == preconditioner && c.start == start);
                let points = chosen.map(|c| point(c, c.stiffness_over_mass_per_s2, c.cg_per_step));
                Series::new(format!("{preconditioner}, {start}"), look, points.collect())
            })
            .collect()
    });
    panels_of(drafts, |xs| Axis::log(K_OVER_M, xs), |ys| Axis::log_with_zero(PER_STEP, ys))
}

fn against_theta(input: &Input) -> Option<Sheet> {
    let kind = |cell: &Cell| {
        cell.variant != UPDATED_ROBUST && with_base_solver(cell) && at_base_forcing_term(cell)
    };
    let mut cells = select(input, STIFFNESS, kind);
    cells.extend(select(input, STEP, kind));
    let steps = values(cells.iter().map(|cell| cell.step_s));
    let drafts = by_size_and_variant(&cells, |cells| {
        by_value(
            cells,
            &steps,
            |cell| cell.step_s,
            |h| format!("h = {} s", setting(h)),
            |cell| point(cell, cell.theta, cell.cg_per_step),
        )
    });
    panels_of(
        drafts,
        |xs| Axis::log("θ = h²k/m (dimensionless)", xs),
        |ys| Axis::log_with_zero(PER_STEP, ys),
    )
}

fn plain_and_updated(input: &Input) -> Option<Sheet> {
    let cells = select(input, STIFFNESS, |cell| {
        with_base_solver(cell) && at_fixed_k_over_m(cell) && at_base_point(cell)
    });
    let variants = names(&VARIANTS, cells.iter().map(|cell| cell.variant.as_str()));
    let drafts = by_size(&cells, |cells| {
        let curve = |variant: &&str| {
            let chosen = cells.iter().filter(|cell| cell.variant == *variant);
            let points = chosen.map(|c| point(c, c.stiffness_over_mass_per_s2, c.cg_per_step));
            Series::new((*variant).to_owned(), look_of_variant(variant), points.collect())
        };
        let robust = cells.iter().filter(|cell| cell.variant == UPDATED_ROBUST);
        let newton = robust.map(|c| {
            let a_step = c.newton_iterations as f64 / c.steps as f64;
            point(c, c.stiffness_over_mass_per_s2, a_step)
        });
        let look = look_of_variant(UPDATED_ROBUST).shifted(4);
        let newton = Series::new(format!("{UPDATED_ROBUST}, Newton"), look, newton.collect());
        variants.iter().filter_map(curve).chain(newton).collect()
    });
    panels_of(drafts, |xs| Axis::log(K_OVER_M, xs), |ys| Axis::log_with_zero(PER_STEP, ys))
}

/// A panel for each number of particles and variant. `series` makes its curves.
fn by_size_and_variant(cells: &[&Cell], series: impl Fn(&[&Cell]) -> Vec<Series>) -> Vec<Draft> {
    let variants = names(&VARIANTS, cells.iter().map(|cell| cell.variant.as_str()));
    let mut drafts = Vec::new();
    for n in sizes(cells) {
        for variant in &variants {
            let chosen: Vec<&Cell> = cells
                .iter()
                .copied()
                .filter(|cell| cell.particles == n && cell.variant == *variant)
                .collect();
            let title = format!("{}, {variant}", particles(n));
            drafts.push((vec![title], series(&chosen), Vec::new()));
        }
    }
    drafts
}

/// One curve for each k/m.
fn by_stiffness(cells: &[&Cell], all: &[&Cell], place: impl Fn(&Cell) -> Point) -> Vec<Series> {
    let stiffnesses = values(all.iter().map(|cell| cell.stiffness_over_mass_per_s2));
    by_value(
        cells,
        &stiffnesses,
        |cell| cell.stiffness_over_mass_per_s2,
        |k| format!("k/m = {} s⁻²", power(k)),
        place,
    )
}

fn against_step(input: &Input) -> Option<Sheet> {
    let cells = select(input, STEP, |cell| {
        with_base_solver(cell) && at_fixed_k_over_m(cell) && at_base_forcing_term(cell)
    });
    let drafts = by_size_and_variant(&cells, |chosen| {
        by_stiffness(chosen, &cells, |c| point(c, c.step_s, c.cg_per_step / c.step_s))
    });
    panels_of(
        drafts,
        |xs| Axis::log("time step h (s)", xs),
        |ys| Axis::log_with_zero("CG iterations in 1 s", ys),
    )
}

fn against_forcing_term(input: &Input) -> Option<Sheet> {
    let cells = select(input, FORCING_TERMS, |cell| {
        with_base_solver(cell) && at_fixed_k_over_m(cell) && at_base_step(cell)
    });
    let drafts = by_size_and_variant(&cells, |chosen| {
        by_stiffness(chosen, &cells, |c| point(c, c.forcing_term, c.cg_per_step))
    });
    panels_of(
        drafts,
        |xs| Axis::log("forcing term ε (dimensionless)", xs),
        |ys| Axis::log_with_zero(PER_STEP, ys),
    )
}

fn motion(input: &Input) -> Option<Sheet> {
    let motion = &input.facts.motion;
    let labels = names(&MOTIONS, motion.iter().map(|m| m.label.as_str()));
    let steps = values(motion.iter().map(|m| m.step_s));
    let drafts = steps
        .iter()
        .map(|h| {
            let series = labels.iter().filter_map(|label| {
                let chosen = motion.iter().filter(|m| m.step_s == *h && m.label == *label);
                let points = chosen.map(|m| Point {
                    x: m.stiffness_over_mass_per_s2,
                    y: m.fall_m,
                    state: State::of_verdict(m.verdict),
                });
                let look = look_among(label, &MOTIONS);
                Series::new((*label).to_owned(), look, points.collect())
            });
            (vec![format!("h = {} s", setting(*h))], series.collect(), Vec::new())
        })
        .collect();
    // Only runs that stayed on the scene set the axis. Otherwise a run that flew off would flatten
    // them.
    let held = motion.iter().filter(|m| State::of_verdict(m.verdict) != State::Failed);
    let span: Vec<f64> = held.map(|m| m.fall_m).chain([0.0]).collect();
    panels_of(
        drafts,
        |xs| Axis::log(K_OVER_M, xs),
        |_| Axis::linear("vertical displacement at t = 0.3 s (m)", &span),
    )
}
