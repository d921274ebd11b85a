//! Figures of the experiment `cg-vs-stiffness`.

pub(super) mod tabulated;

use super::facts::{Cell, Facts};
use crate::studies::tables::facts::VARIANTS;
use drape_report::number::{power, setting};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    Axis, Draft, Look, Point, Series, Sheet, State, names, panels_of, place_of, values,
};

/// What the figures are drawn from.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "cg-vs-stiffness.svg",
        title: "CG iterations per step against stiffness, by preconditioner and start vector",
        caption: "Hanging textile, one panel for each number of particles and variant (plain IMEX \
            Euler; updated-paper: with the paper's Algorithm 1 as printed) at h = 0.01 s and forcing \
            term ε = 0.05, with k/m the same at every number of particles. Conjugate gradient (CG) iterations per step against stiffness over mass k/m. Colour \
            and dashes tell the preconditioner: none, Jacobi, or incomplete Cholesky without \
            fill-in (ic0). The marker tells the vector from which CG starts: the last velocity, its \
            extrapolation. Axes are logarithmic and the same in all panels. Markers tell runs that \
            were not stable.",
        draw: Draw::Sheet(against_stiffness),
    },
    Plate {
        file: "cg-vs-theta.svg",
        title: "CG iterations per step against θ = h²k/m, by time step",
        caption: "Hanging textile, one panel for each number of particles and variant (plain IMEX \
            Euler; updated-paper: with Algorithm 1 as printed), ic0 and extrapolated start at ε = 0.05. All time steps h and stiffnesses k/m of the \
            sweeps over stiffness and over the step, at fixed k/m and at fixed material, drawn \
            against the dimensionless θ = h²k/m; marker and colour tell h. If θ alone decided, the \
            curves of all steps would lie on one another.",
        draw: Draw::Sheet(against_theta),
    },
    Plate {
        file: "cg-plain-vs-updated.svg",
        title: "CG iterations per step against stiffness, plain and updated",
        caption: "Hanging textile, one panel for each number of particles; ic0, extrapolated \
            start, h = 0.01 s, ε = 0.05, with k/m the same at every number of particles. Plain is \
            the IMEX Euler step; updated-paper adds the paper's Algorithm 1 as printed, \
            updated-robust its safeguarded form, which starts at the better of the extrapolation and \
            the last velocity and goes over to Newton's method for h²k/m above 100, where its CG count \
            is 0 (with 2704 particles it was run up to k/m = 10⁶ only). Iterations of all outer passes count. Markers \
            tell runs that were not stable: their count is that of another motion.",
        draw: Draw::Sheet(plain_and_updated),
    },
    Plate {
        file: "cg-vs-step.svg",
        title: "CG iterations in one simulated second against the time step",
        caption: "Hanging textile, a panel for each number of particles and variant; ic0, \
            extrapolated start, ε = 0.05. All CG iterations of one simulated second (the mean per step \
            times the steps of a second) against the time step h, one curve for each stiffness \
            over mass k/m. A smaller step makes each \
            solve easier and their number greater: the curves tell which of the two wins.",
        draw: Draw::Sheet(against_step),
    },
    Plate {
        file: "cg-vs-forcing-term.svg",
        title: "CG iterations per step against the forcing term",
        caption: "Hanging textile, a panel for each number of particles and variant; ic0, \
            extrapolated start, h = 0.01 s. CG iterations per step against the forcing term ε, the \
            relative tolerance at which the solver stops (tight on the left, loose on the right), \
            one curve for each stiffness over mass k/m.",
        draw: Draw::Sheet(against_forcing_term),
    },
    Plate {
        file: "motion-vs-stiffness.svg",
        title: "How far the free edge has moved after 0.3 s, against stiffness",
        caption: "Hanging textile, a panel for each time step h. Vertical displacement of the free \
            edge's midpoint at t = 0.3 s (negative: down) against stiffness over mass k/m, one \
            curve for each method at its default settings; shear springs of a tenth of the \
            stiffness are added. It is the check on the counts: few iterations are worth nothing \
            where the sheet hardly moves. Free fall with steps of 0.01 s comes to -0.456 m: the figure \
            shows locking, not accuracy. Tension only: the shear springs are left out of the matrix. Backward Euler is the method to compare with, as it \
            solves the full nonlinear equation of the step. Runs that diverged stay in the figure, \
            crossed out, on the edge of the panel when their value lies beyond it.",
        draw: Draw::Sheet(motion),
    },
];

/// The base point: what is held while one factor varies.
pub(super) const BASE_STEP_S: f64 = 0.01;
const BASE_FORCING_TERM: f64 = 0.05;
pub(super) const BASE_PRECONDITIONER: &str = "ic0";
pub(super) const BASE_START: &str = "extrapolated";
const ROBUST: &str = "updated-robust";
const FIXED_K_OVER_M: &str = "fixed-k-over-m";

pub(super) const PRECONDITIONERS: [&str; 3] = ["none", "jacobi", "ic0"];
pub(super) const STARTS: [&str; 3] = ["extrapolated", "last", "best"];
/// Labels of the curves of motion, in the legend's order.
pub(super) const MOTIONS: [&str; 4] =
    ["imex-euler", "imex-updated", "imex-updated, tension only", "backward-euler"];

const K_OVER_M: &str = "stiffness over mass k/m (s⁻²)";
const PER_STEP: &str = "CG iterations per step";

/// Equality of settings, which may have been computed.
fn same(a: f64, b: f64) -> bool {
    libm::fabs(a - b) <= 1e-9 * libm::fabs(b)
}

pub(super) fn at_base_point(cell: &Cell) -> bool {
    at_base_step(cell) && at_base_forcing_term(cell)
}

fn at_base_step(cell: &Cell) -> bool {
    same(cell.step_s, BASE_STEP_S)
}

fn at_base_forcing_term(cell: &Cell) -> bool {
    same(cell.forcing_term, BASE_FORCING_TERM)
}

pub(super) fn with_base_solver(cell: &Cell) -> bool {
    // The robust form starts at the better of both: the extrapolation alone is not one of its safeguards.
    let start = if cell.variant == ROBUST { "best" } else { BASE_START };
    cell.preconditioner == BASE_PRECONDITIONER && cell.start == start
}

fn at_fixed_k_over_m(cell: &Cell) -> bool {
    cell.material == FIXED_K_OVER_M
}

/// The cells of a series of the experiment that are of a kind.
fn select<'a>(input: &'a Input, series: &str, kind: impl Fn(&Cell) -> bool) -> Vec<&'a Cell> {
    input.facts.cells.iter().filter(|cell| cell.series == series && kind(cell)).collect()
}

fn point(cell: &Cell, x: f64, y: f64) -> Point {
    Point { x, y, state: State::of_verdict(cell.verdict) }
}

fn particles(n: usize) -> String {
    format!("{n} particles")
}

/// The different numbers of particles, in rising order.
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
    let cells = select(input, "stiffness", |cell| {
        cell.variant != ROBUST && at_fixed_k_over_m(cell) && at_base_point(cell)
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
        cell.variant != ROBUST && with_base_solver(cell) && at_base_forcing_term(cell)
    };
    let mut cells = select(input, "stiffness", kind);
    cells.extend(select(input, "step", kind));
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
    let cells = select(input, "stiffness", |cell| {
        with_base_solver(cell) && at_fixed_k_over_m(cell) && at_base_point(cell)
    });
    let variants = names(&VARIANTS, cells.iter().map(|cell| cell.variant.as_str()));
    let drafts = by_size(&cells, |cells| {
        variants
            .iter()
            .filter_map(|variant| {
                let chosen = cells.iter().filter(|cell| cell.variant == *variant);
                let points = chosen.map(|c| point(c, c.stiffness_over_mass_per_s2, c.cg_per_step));
                let look = Look::number(place_of(variant, &VARIANTS));
                Series::new((*variant).to_owned(), look, points.collect())
            })
            .collect()
    });
    panels_of(drafts, |xs| Axis::log(K_OVER_M, xs), |ys| Axis::log_with_zero(PER_STEP, ys))
}

/// A panel for each number of particles and variant; `series` makes its curves.
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
    let cells = select(input, "step", |cell| {
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
    let cells = select(input, "forcing-term", |cell| {
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
                let look = Look::number(place_of(label, &MOTIONS));
                Series::new((*label).to_owned(), look, points.collect())
            });
            (vec![format!("h = {} s", setting(*h))], series.collect(), Vec::new())
        })
        .collect();
    // Only runs that held decide on the axis, so that one that flew off does not flatten them.
    let held = motion.iter().filter(|m| State::of_verdict(m.verdict) != State::Failed);
    let span: Vec<f64> = held.map(|m| m.fall_m).chain([0.0]).collect();
    panels_of(
        drafts,
        |xs| Axis::log(K_OVER_M, xs),
        |_| Axis::linear("vertical displacement at t = 0.3 s (m)", &span),
    )
}
