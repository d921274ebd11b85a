//! Figures of the experiment `solver-control`.

use super::facts::{Facts, Matched, Run, Scene, TimingRow, matched};
use crate::families::look_among;
use drape_report::number::{power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{At, Axis, Draft, Point, Rule, Series, Sheet, State, names, panels_of};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "control-work.svg",
        title: "Work against error, with constant and with adaptive steps",
        caption: "Adaptive curves lie on or above the constant ones: step size control seldom \
            saves work. Work, counted in sweeps over the springs, against the error of the \
            positions after 0.25 s over the motion; rejected substeps and estimates are counted. \
            400 particles; a row for each scene, order 1 left, order 2 right. Crossed out: \
            diverged.",
        draw: Draw::Sheet(by_work),
    },
    Plate {
        file: "control-matvecs.svg",
        title: "Products with the matrix against error, with constant and with adaptive steps",
        caption: "The splitting estimate costs one more loose solve in each substep, so its curve \
            lies above the curve of the plain estimate. Products with the matrix in 0.25 s \
            against the error of the positions over the motion, for methods that solve by \
            conjugate gradients; a panel for each scene. Crossed out: diverged.",
        draw: Draw::Sheet(by_matvecs),
    },
    Plate {
        file: "control-steps.svg",
        title: "Step sizes that the control chooses, over time",
        caption: "At k/m = 10⁶ s⁻² the splitting estimate shortens the steps of IMEX Euler where \
            the plain estimate lengthens them. Mean size of the substeps in each frame of 0.01 s \
            at a tolerance of 1e-3 mesh widths; a panel for each scene. The sheet starts at rest; \
            in the vibrating scene it starts stretched.",
        draw: Draw::Sheet(over_time),
    },
    Plate {
        file: "control-forcing.svg",
        title: "CG iterations against the inner tolerance, constant and by Eisenstat and Walker",
        caption: "The line of Eisenstat and Walker lies below backward Euler at every constant ε, \
            so no search for a constant pays. CG iterations in 25 steps of 0.01 s against the \
            inner tolerance, a panel for each scene. Every run of backward Euler (block Hessian, \
            block Jacobi) reaches the same residual; IMEX Euler (one system a step, IC(0)) does \
            not.",
        draw: Draw::Sheet(by_forcing),
    },
];

/// Labels of the methods with varied steps, in the legend's order, each with its order of
/// convergence.
const STEPPED: [(&str, u32); 5] = [
    ("backward-euler", 1),
    ("imex-euler", 1),
    ("imex-euler, plain estimate", 1),
    ("bdf2", 2),
    ("imex-sbdf2", 2),
];
const INNER: [&str; 2] = ["backward-euler", "imex-euler"];

/// A short name of a scene.
fn name(scene: &Scene) -> String {
    let kind = scene.id.split('-').next().unwrap_or(&scene.id);
    format!("{kind}, k/m = {} s⁻²", power(scene.stiffness_over_mass_per_s2))
}

fn runs_of<'a>(
    input: &'a Input,
    series: &'a str,
    scene: &'a Scene,
) -> impl Iterator<Item = &'a Run> {
    input.facts.runs.iter().filter(move |run| run.series == series && run.scene == scene.id)
}

fn work(run: &Run) -> f64 {
    run.work_sweeps as f64
}

/// A point at the error of a run and its cost `y`. A run without an error is drawn at an error of
/// 1.
fn point(run: &Run, y: f64) -> Point {
    match run.error {
        Some(x) => Point { x, y, state: State::Stable },
        None => Point { x: 1.0, y, state: State::Failed },
    }
}

/// The curves of constant and of adaptive runs of some methods on a scene.
fn curves(
    input: &Input,
    scene: &Scene,
    labels: &[&str],
    cost: impl Fn(&Run) -> f64,
) -> Vec<Series> {
    let known = STEPPED.map(|(label, _)| label);
    let mut series = Vec::new();
    for label in labels {
        let look = look_among(label, &known);
        for adaptive in [false, true] {
            let runs = runs_of(input, "steps", scene)
                .filter(|run| run.label == *label && run.is_adaptive == adaptive);
            let points: Vec<_> = runs.map(|run| point(run, cost(run))).collect();
            let (name, look) = if adaptive {
                (format!("{label}, adaptive"), look.shifted(1))
            } else {
                (format!("{label}, constant"), look)
            };
            series.extend(Series::new(name, look, points));
        }
    }
    series
}

fn by_work(input: &Input) -> Option<Sheet> {
    let mut drafts: Vec<Draft> = Vec::new();
    for scene in &input.facts.scenes {
        for order in [1, 2] {
            let labels: Vec<_> =
                STEPPED.iter().filter(|(_, p)| *p == order).map(|(label, _)| *label).collect();
            let title = vec![format!("{}, order {order}", name(scene))];
            drafts.push((title, curves(input, scene, &labels, work), Vec::new()));
        }
    }
    panels_of(
        drafts,
        |values| Axis::log("error over motion", values),
        |values| Axis::log("work (sweeps over the springs)", values),
    )
}

fn by_matvecs(input: &Input) -> Option<Sheet> {
    let labels: Vec<_> =
        STEPPED.iter().map(|(label, _)| *label).filter(|label| label.starts_with("imex")).collect();
    let drafts = input.facts.scenes.iter().map(|scene| {
        let series = curves(input, scene, &labels, |run| run.matvecs as f64);
        (vec![name(scene)], series, Vec::new())
    });
    panels_of(
        drafts.collect(),
        |values| Axis::log("error over motion", values),
        |values| Axis::log("products with the matrix", values),
    )
}

fn over_time(input: &Input) -> Option<Sheet> {
    let known = STEPPED.map(|(label, _)| label);
    let drafts = input.facts.scenes.iter().map(|scene| {
        let histories = input.facts.histories.iter().filter(|h| h.scene == scene.id);
        let found: Vec<_> = histories.collect();
        let labels = names(&known, found.iter().map(|h| h.label.as_str()));
        let series = labels.iter().filter_map(|label| {
            let history = found.iter().find(|h| h.label == *label)?;
            let points = history.time_s.iter().zip(&history.step_s);
            let points = points.map(|(&x, &y)| Point { x, y, state: State::Stable }).collect();
            let look = look_among(label, &known);
            Series::new((*label).to_owned(), look, points)
        });
        (vec![name(scene)], series.collect(), Vec::new())
    });
    panels_of(
        drafts.collect(),
        |values| Axis::linear("time (s)", values),
        |values| Axis::log("step size (s)", values),
    )
}

fn by_forcing(input: &Input) -> Option<Sheet> {
    let drafts = input.facts.scenes.iter().map(|scene| {
        let runs = |label: &'static str| {
            runs_of(input, "forcing", scene).filter(move |run| run.label == label)
        };
        let series = INNER.iter().filter_map(|label| {
            let points = runs(label).filter_map(|run| {
                let y = run.cg_iterations as f64;
                Some(Point { x: run.value?, y, state: State::Stable })
            });
            Series::new((*label).to_owned(), look_among(label, &INNER), points.collect())
        });
        let walker = runs(INNER[0]).filter(|run| run.value.is_none());
        let rules = walker.map(|run| Rule {
            label: "backward-euler, Eisenstat-Walker".to_owned(),
            at: At::Y(run.cg_iterations as f64),
        });
        (vec![name(scene)], series.collect(), rules.collect())
    });
    panels_of(
        drafts.collect(),
        |values| Axis::log("inner tolerance ε (dimensionless)", values),
        |values| Axis::log("CG iterations in 25 steps", values),
    )
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let inner = |series: &'static str, title: &str| Table {
        title: title.to_owned(),
        header: texts(&[
            "scene",
            "method",
            "ε",
            "Newton",
            "updates",
            "CG",
            "factorisations",
            "forces",
            "work",
            "error",
            "energy gain (J)",
        ]),
        names: 2,
        rows: rows_of(input, series, |run| {
            vec![
                run.value.map_or_else(absent, setting),
                run.newton_iterations.to_string(),
                run.outer_passes.to_string(),
                run.cg_iterations.to_string(),
                run.factorisations.to_string(),
                run.force_evaluations.to_string(),
                run.work_sweeps.to_string(),
                error(run),
                significant(run.energy_gain_j, 2),
            ]
        }),
    };
    let steps = Table {
        title: "**Constant and adaptive steps** of 0.25 s. Size: the step in s, or the tolerance \
                in mesh widths. ✗ diverged; ° some solves ended before their \
            tolerance."
            .to_owned(),
        header: texts(&[
            "scene",
            "method",
            "steps",
            "size",
            "substeps",
            "rejected",
            "set-ups",
            "factorisations",
            "forces",
            "products",
            "work",
            "error",
        ]),
        names: 2,
        rows: rows_of(input, "steps", |run| {
            vec![
                if run.is_adaptive { "adaptive" } else { "constant" }.to_owned(),
                run.value.map_or_else(absent, setting),
                run.substeps.to_string(),
                run.rejected.to_string(),
                run.setups.to_string(),
                run.factorisations.to_string(),
                run.force_evaluations.to_string(),
                run.matvecs.to_string(),
                run.work_sweeps.to_string(),
                error(run),
            ]
        }),
    };
    let titles = [
        (
            "forcing",
            "**Forcing terms.** 25 steps of 0.01 s; ε is the inner tolerance, – where it follows \
             the outer iteration or, for updated CG, is the \
             step's.",
        ),
        (
            "jacobian",
            "**Saved Jacobians.** The same steps; a saved factor is reused over iterations and \
             steps as long as it works, as the solver or as the preconditioner of CG.",
        ),
        (
            "preconditioner",
            "**Preconditioners of IMEX Euler.** The same steps, all springs implicit, ε = 10⁻³.",
        ),
    ];
    let inner = titles.into_iter().map(|(series, title)| inner(series, title));
    let seconds = input.timings.as_ref().map(|timings| seconds(&timings.rows));
    inner.chain([adaptive(input), steps]).chain(seconds).collect()
}

/// The table of the savings by adaptive steps, largest first.
fn adaptive(input: &Input) -> Table {
    let mut pairs = matched(&input.facts);
    pairs.sort_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    let line = |pair: &Matched<'_>| {
        let Matched { adaptive, constant } = pair;
        let scene = input.facts.scenes.iter().find(|scene| scene.id == adaptive.scene);
        vec![
            scene.map_or_else(absent, name),
            adaptive.label.clone(),
            adaptive.value.map_or_else(absent, setting),
            significant(pair.ratio(), 3),
            error(adaptive),
            error(constant),
            format!("{} ({})", adaptive.substeps, adaptive.rejected),
            constant.substeps.to_string(),
        ]
    };
    Table {
        title: "**Adaptive against constant steps, the greatest saving first**: work over the \
                constant step's that is at least as exact; errors; substeps (rejected) and \
            constant steps."
            .to_owned(),
        header: texts(&[
            "scene",
            "method",
            "tolerance",
            "work ratio",
            "error",
            "error, constant",
            "substeps",
            "steps",
        ]),
        names: 2,
        rows: pairs.iter().map(line).collect(),
    }
}

fn error(run: &Run) -> String {
    let sign = if run.unconverged_steps > 0 { " °" } else { "" };
    run.error.map_or_else(|| "✗".to_owned(), |error| format!("{}{sign}", significant(error, 3)))
}

fn rows_of(input: &Input, series: &str, values: impl Fn(&Run) -> Vec<String>) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for scene in &input.facts.scenes {
        for run in runs_of(input, series, scene) {
            let mut row = vec![name(scene), run.label.clone()];
            row.extend(values(run));
            rows.push(row);
        }
    }
    rows
}

fn seconds(rows: &[TimingRow]) -> Table {
    let line = |row: &TimingRow| {
        let kind = if row.is_adaptive { "adaptive" } else { "constant" };
        vec![
            row.series.clone(),
            row.label.clone(),
            kind.to_owned(),
            row.value.map_or_else(absent, setting),
            significant(row.median_s, 3),
        ]
    };
    Table {
        title: "**Seconds.** Median of the repetitions for all steps of 0.25 s.".to_owned(),
        header: texts(&["series", "method", "steps", "size", "s"]),
        names: 2,
        rows: rows.iter().map(line).collect(),
    }
}
