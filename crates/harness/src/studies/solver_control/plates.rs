//! Figures of the experiment `solver-control`.

use super::facts::{Facts, Run, Scene, TimingRow};
use drape_report::number::{power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Axis, Draft, Look, Point, Rule, Series, Sheet, State, names, panels_of, place_of,
};

/// What the figures are drawn from.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "control-work.svg",
        title: "Work against error, with constant and with adaptive steps",
        caption: "A sheet of 400 particles after 0.25 s, a row of panels for each scene, methods of order 1 on the left \
            and of order 2 on the right. The work against the error of the positions over how far the sheet has moved, weighed \
            in sweeps over the springs: a product with the scalar matrix counts 2, a set-up of the scalar matrix 30, a \
            factorisation 1000, a solve with its factor 18; rejected substeps and error estimates are counted. Constant \
            steps from 0.01 s on, each half the one before; adaptive runs divide frames of 0.01 s by tolerances from 0.1 \
            to 1e-4 mesh widths. Where the adaptive curve lies below, step size control saves work. The plain \
            estimate of IMEX Euler looks at positions alone. Runs that diverged are crossed out.",
        draw: Draw::Sheet(by_work),
    },
    Plate {
        file: "control-matvecs.svg",
        title: "Products with the matrix against error, with constant and with adaptive steps",
        caption: "The same runs of the methods whose linear systems are solved by conjugate gradients: the number of \
            products with the matrix in 0.25 s against the error of the positions over how far the sheet has moved, a \
            panel for each scene. The estimate that sees the splitting of the force costs one loose solve more in each substep, which is \
            counted. Axes are logarithmic; runs that diverged are crossed out.",
        draw: Draw::Sheet(by_matvecs),
    },
    Plate {
        file: "control-steps.svg",
        title: "Step sizes that the control chooses, over time",
        caption: "Mean size of the substeps in each frame of 0.01 s at a tolerance of 1e-3 mesh widths, a panel for each \
            scene, one curve a method. A curve at the upper edge takes each frame in one step. At the start the sheet is \
            at rest (stretched in the vibrating scene); the control follows the acceleration of the fall and the \
            vibration of the springs.",
        draw: Draw::Sheet(over_time),
    },
    Plate {
        file: "control-forcing.svg",
        title: "CG iterations against the inner tolerance, constant and by Eisenstat and Walker",
        caption: "Backward Euler whose Newton systems are solved by conjugate gradients on the block Hessian with block-Jacobi \
            preconditioning, and IMEX Euler with its one linear system a step and IC(0), 25 steps of 0.01 s, a panel for each \
            scene. All CG iterations against the constant inner tolerance ε (loose on the right). The line across: the \
            iterations of backward Euler where the tolerance of each Newton iteration follows Eisenstat and Walker. Every \
            run of backward Euler reaches the same residual, so that the counts compare like with like; those of IMEX Euler \
            do not.",
        draw: Draw::Sheet(by_forcing),
    },
];

/// Labels of the stepped methods, in the legend's order, with their order.
const STEPPED: [(&str, u32); 5] = [
    ("backward-euler", 1),
    ("imex-euler", 1),
    ("imex-euler, plain estimate", 1),
    ("bdf2", 2),
    ("imex-sbdf2", 2),
];
const INNER: [&str; 2] = ["backward-euler", "imex-euler"];

/// A scene in a few words.
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

/// What an error costs; a run without an error stands where the error is as large as the motion.
fn point(run: &Run, y: f64) -> Point {
    match run.error {
        Some(x) => Point { x, y, state: State::Stable },
        None => Point { x: 1.0, y, state: State::Failed },
    }
}

/// Constant and adaptive runs of some methods on a scene.
fn curves(
    input: &Input,
    scene: &Scene,
    labels: &[&str],
    cost: impl Fn(&Run) -> f64,
) -> Vec<Series> {
    let known = STEPPED.map(|(label, _)| label);
    let mut series = Vec::new();
    for label in labels {
        let look = place_of(label, &known);
        for adaptive in [false, true] {
            let runs = runs_of(input, "steps", scene)
                .filter(|run| run.label == *label && run.is_adaptive == adaptive);
            let points: Vec<_> = runs.map(|run| point(run, cost(run))).collect();
            let (name, look) = if adaptive {
                (format!("{label}, adaptive"), Look::pair(look, look + 1))
            } else {
                (format!("{label}, constant"), Look::pair(look, look))
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
            Series::new((*label).to_owned(), Look::number(place_of(label, &known)), points)
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
        let series = INNER.iter().enumerate().filter_map(|(n, label)| {
            let points = runs(label).filter_map(|run| {
                let y = run.cg_iterations as f64;
                Some(Point { x: run.value?, y, state: State::Stable })
            });
            Series::new((*label).to_owned(), Look::number(n), points.collect())
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
        title: "**Constant and adaptive steps.** Runs of 0.25 s. Size: the step in s, or the tolerance in mesh widths; \
                rejected substeps are part of the counts; set-ups are those of the kept matrix. ✗ diverged; ° some solves \
                ended before their tolerance."
            .to_owned(),
        header: texts(&[
            "scene", "method", "steps", "size", "substeps", "rejected", "set-ups", "factorisations",
            "forces", "products", "work", "error",
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
            "**Forcing terms.** 25 steps of 0.01 s; ε is the inner tolerance, – where it follows the progress of the \
          outer iteration or, for updated CG, is that of the step.",
        ),
        (
            "jacobian",
            "**Saved Jacobians.** The same steps; saved: the factor is kept over iterations and steps while it \
          serves, as the solver or as the preconditioner of CG (which follows Eisenstat and Walker).",
        ),
        (
            "preconditioner",
            "**Preconditioners of IMEX Euler.** The same steps, all springs implicit, ε = 10⁻³.",
        ),
    ];
    let inner = titles.into_iter().map(|(series, title)| inner(series, title));
    let seconds = input.timings.as_ref().map(|timings| seconds(&timings.rows));
    inner.chain([steps]).chain(seconds).collect()
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
