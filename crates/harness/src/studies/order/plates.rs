//! Figures of the experiment `order`.

use super::facts::{Facts, Row, Run, Scene, finest_error, outcome};
use crate::families::{families, labels};
use drape_report::number::{power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{At, Axis, Look, Panel, Point, Rule, Series, Sheet, State};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "order-observed.svg",
        title: "Observed order of accuracy",
        caption: "On smooth scenes nearly every method stands on its bar, the order of theory \
            (none: it claims none); with stiff springs most methods fall short of it. Slope of \
            log e over log h, where e is the error of the positions after 0.25 s and h the step; \
            four steps, each half the one before. Crossed out on the left: fewer than three runs \
            for a slope.",
        draw: Draw::Sheet(observed),
    },
    Plate {
        file: "order-smooth.svg",
        title: "Error against the time step, every oscillation resolved",
        caption: "Methods of one order run parallel to one of the black lines, of slope 1 and 2; \
            only Provot's error, and that of clamped Terzopoulos-Fleischer, hardly falls. Smooth \
            scene (k/m = 400 s⁻², full damping); error of the positions after 0.25 s over how far \
            the sheet has moved, against h.",
        draw: Draw::Sheet(smooth),
    },
    Plate {
        file: "order-stiff.svg",
        title: "Error against the time step, stiff springs",
        caption: "At k/m = 10⁶ s⁻² (right) errors hardly fall with h; an error that stays near 1 \
            means that the sheet almost stands still. At 10⁴ s⁻² (left) several methods still \
            show their order. Error of the positions after 0.25 s over how far the sheet has \
            moved; black lines have slope 1 and 2. Crossed out: diverged, or farther off than the \
            sheet has moved.",
        draw: Draw::Sheet(stiff),
    },
];

/// The look of the theoretical order.
const THEORY: Look = Look::pair(4, 5);
/// Range of the axis of orders. A row without an order is drawn at the left end.
const ORDERS: [f64; 2] = [-0.8, 3.1];

fn rows_of<'a>(input: &'a Input, scene: &Scene) -> impl Iterator<Item = &'a Row> + Clone {
    let id = scene.id.clone();
    input.facts.rows.iter().filter(move |row| row.scene == id)
}

/// A short name of a scene.
fn name(scene: &Scene) -> String {
    let stiffness = power(scene.stiffness_over_mass_per_s2);
    let kind = if scene.resolved { "smooth" } else { "stiff" };
    format!("{kind}, k/m = {stiffness} s⁻², {} damping", scene.damping)
}

/// Method and label of a row.
fn identity(row: &Row) -> (&str, &str) {
    (&row.method, &row.label)
}

fn observed(input: &Input) -> Option<Sheet> {
    let rows = || input.facts.rows.iter();
    let labels = labels(rows().map(identity));
    let height = |row: &Row| -> f64 {
        labels.iter().position(|label| *label == row.label).map_or(0.0, |n| -(n as f64))
    };
    let axis = Axis::linear("observed order", &ORDERS);
    let mut panel = Panel::new(Vec::new(), axis, Axis::names("", &labels));
    let theory = rows().filter_map(|row| {
        let x = f64::from(row.theory?);
        Some(Point { x, y: height(row), state: State::Stable })
    });
    let theory = Series::new("theory".to_owned(), THEORY, theory.collect());
    panel.series.extend(theory.map(Series::apart));
    for (n, scene) in input.facts.scenes.iter().enumerate() {
        let points = rows_of(input, scene).map(|row| match row.order {
            Some(x) => Point { x, y: height(row), state: State::Stable },
            None => Point { x: ORDERS[0], y: height(row), state: State::Failed },
        });
        let series = Series::new(name(scene), Look::number(n), points.collect());
        panel.series.extend(series.map(Series::apart));
    }
    (!labels.is_empty()).then(|| Sheet { panels: vec![panel], notes: Vec::new() })
}

fn smooth(input: &Input) -> Option<Sheet> {
    let scene = input.facts.scenes.iter().find(|scene| scene.resolved)?;
    errors(input, &[scene])
}

fn stiff(input: &Input) -> Option<Sheet> {
    let scenes: Vec<_> = input.facts.scenes.iter().filter(|scene| !scene.resolved).collect();
    errors(input, &scenes)
}

/// A row of panels for each family of methods, and a panel for each scene. All have the same axes.
fn errors(input: &Input, scenes: &[&Scene]) -> Option<Sheet> {
    let rows = || scenes.iter().flat_map(|scene| rows_of(input, scene));
    let runs = || rows().flat_map(|row| &row.runs);
    let steps: Vec<f64> = runs().map(|run| run.step_s).collect();
    let errors: Vec<f64> = runs().filter_map(|run| run.error).collect();
    let coarsest = steps.iter().copied().fold(0.0, f64::max);
    let greatest = errors.iter().copied().fold(0.0, f64::max);
    let axes = || {
        let y = Axis::log("error over motion (dimensionless)", &errors);
        (Axis::log("time step h (s)", &steps), y)
    };
    let mut panels = Vec::new();
    for family in families(rows().map(identity)) {
        for scene in scenes {
            let stiffness = power(scene.stiffness_over_mass_per_s2);
            let (x, y) = axes();
            let mut panel =
                Panel::new(vec![format!("{}, k/m = {stiffness} s⁻²", family.title)], x, y);
            panel.series = family
                .members
                .iter()
                .filter_map(|(label, look)| {
                    let row = rows_of(input, scene).find(|row| row.label == *label)?;
                    let points = row.runs.iter().map(|run| match run.error {
                        Some(y) => Point { x: run.step_s, y, state: State::Stable },
                        None => Point { x: run.step_s, y: f64::INFINITY, state: State::Failed },
                    });
                    Series::new(row.label.clone(), *look, points.collect())
                })
                .collect();
            panel.rules = [1, 2]
                .map(|order| Rule {
                    label: format!("slope {order}"),
                    at: At::Slope { order: f64::from(order), x: coarsest, y: greatest },
                })
                .into();
            panels.push(panel);
        }
    }
    (!errors.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let errors = input.facts.scenes.iter().map(|scene| errors_of(input, scene));
    [orders(input), stiffness(input), constants(input)].into_iter().chain(errors).collect()
}

/// The observed order, with the error constant if the order is that of theory.
fn order(row: &Row) -> String {
    let sign = if row.accepted == Some(false) { " ✗" } else { "" };
    let constant =
        row.error_constant.map_or_else(String::new, |c| format!("; {}", significant(c, 3)));
    let text = |order: f64| format!("{order:.2}").replace('-', "−");
    row.order.map_or_else(absent, |order| format!("{}{sign}{constant}", text(order)))
}

fn orders(input: &Input) -> Table {
    let scenes = &input.facts.scenes;
    let mut header = texts(&["method", "theory"]);
    header.extend(scenes.iter().map(name));
    let line = |label: String| {
        let row = |scene| rows_of(input, scene).find(|row| row.label == label);
        let rows: Vec<_> = scenes.iter().map(row).collect();
        let theory = rows.iter().flatten().next().and_then(|row| row.theory);
        let mut line = vec![label.clone(), theory.map_or_else(absent, |p| p.to_string())];
        line.extend(rows.iter().map(|row| row.map_or_else(absent, order)));
        line
    };
    Table {
        title: "**Observed order; error constant** C = e/hᵖ (1/sᵖ) at the finest step, where the \
                order is that of theory within 0.15. ✗: it is not, although every oscillation is \
                resolved. –: no order is claimed, or fewer than three runs ended."
            .to_owned(),
        header,
        names: 1,
        rows: labels(input.facts.rows.iter().map(identity)).into_iter().map(line).collect(),
    }
}

/// The table of orders on stiff springs, scene by scene. The best outcome and the least error come
/// first.
fn stiffness(input: &Input) -> Table {
    let mut lines = Vec::new();
    for scene in input.facts.scenes.iter().filter(|scene| !scene.resolved) {
        let mut rows: Vec<_> = rows_of(input, scene).collect();
        let error = |row: &Row| finest_error(row).unwrap_or(f64::INFINITY);
        rows.sort_by(|a, b| outcome(a).cmp(&outcome(b)).then(error(a).total_cmp(&error(b))));
        lines.extend(rows.into_iter().map(|row| {
            vec![
                power(scene.stiffness_over_mass_per_s2),
                row.label.clone(),
                outcome(row).name().to_owned(),
                row.theory.map_or_else(absent, |theory| theory.to_string()),
                row.order.map_or_else(absent, |order| format!("{order:.2}").replace('-', "−")),
                finest_error(row).map_or_else(absent, |error| significant(error, 3)),
                row.fitted.to_string(),
            ]
        }));
    }
    Table {
        title:
            "**What is left of the order on stiff springs**, the best outcome first. Error: at the \
                finest step, over the motion."
                .to_owned(),
        header: texts(&[
            "k/m (s⁻²)",
            "method",
            "outcome",
            "theory",
            "order",
            "error",
            "runs in the fit",
        ]),
        names: 3,
        rows: lines,
    }
}

/// The table of error constants on the first smooth scene, sorted by order and size.
fn constants(input: &Input) -> Table {
    let scene = input.facts.scenes.iter().find(|scene| scene.resolved);
    let rows = scene.into_iter().flat_map(|scene| rows_of(input, scene));
    let mut rows: Vec<_> =
        rows.filter_map(|row| Some((row.theory?, row.error_constant?, &row.label))).collect();
    rows.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let line = |(theory, constant, label): &(u32, f64, &String)| {
        vec![theory.to_string(), (*label).clone(), significant(*constant, 3)]
    };
    Table {
        title: format!(
            "**Error constants C = e/hᵖ** (1/sᵖ), {}, the least first.",
            scene.map_or_else(String::new, name)
        ),
        header: texts(&["order p", "method", "C"]),
        names: 2,
        rows: rows.iter().map(line).collect(),
    }
}

fn errors_of(input: &Input, scene: &Scene) -> Table {
    let rows = || rows_of(input, scene);
    let steps = rows().next().map_or(&[][..], |row| row.runs.as_slice());
    let mut header = texts(&["method"]);
    header.extend(steps.iter().map(|run| format!("h = {} s", setting(run.step_s))));
    let error = |run: &Run| {
        let sign = if run.unconverged_steps > 0 { " °" } else { "" };
        run.error.map_or_else(|| "✗".to_owned(), |e| format!("{}{sign}", significant(e, 3)))
    };
    let line = |label: String| {
        let row = rows().find(|row| row.label == label)?;
        Some(std::iter::once(label.clone()).chain(row.runs.iter().map(error)).collect())
    };
    Table {
        title: format!(
            "**Errors, {}**, after {} s, over how far the sheet has moved. ✗ diverged, or farther \
             off than the sheet has moved; ° some solves missed their tolerance. The reference is \
             off by at most {} m.",
            name(scene),
            setting(scene.span_s),
            significant(scene.reference_error_m, 2)
        ),
        header,
        names: 1,
        rows: labels(rows().map(identity)).into_iter().filter_map(line).collect(),
    }
}
