//! Figures of the experiment `momentum`.

use super::facts::{Facts, Row, Scene};
use crate::families::{families, labels};
use drape_report::Verdict;
use drape_report::number::{power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Axis, Look, Panel, Point, Series, Sheet, State};

/// What the figures are drawn from.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "momentum-spin-left.svg",
        title: "How much of its spin a free cloth keeps for one second",
        caption: "Angular momentum about the centre of mass after one second over that of the start, |L|/|L₀|; the \
            truth is 1. Undamped and unpinned: a sheet of 20 × 20 particles that turns over and over at 2 rad/s (`spin`), the \
            same sheet falling and spinning like a disc, with one side heavier than the other (`fall`), and two \
            particles on a spring (`pair`), each at the k/m that stands behind its name. h = 0.01 s; explicit methods take shorter steps below their limit. Linear solves are tight \
            unless a tolerance ε is named. Crossed out on the right edge: the run diverged or gained more energy \
            than there was in the spin.",
        draw: Draw::Sheet(spin_left),
    },
    Plate {
        file: "momentum-spin.svg",
        title: "Spin of a free sheet over time",
        caption: "The sheet of 20 × 20 particles that turns over and over at 2 rad/s, undamped, h = 0.01 s (explicit \
            methods: shorter steps below their limit): k/m = 10⁴ s⁻² on the left, 10⁶ s⁻² on the right, a row of \
            panels for each family of methods, all with the same axes. Angular momentum about the centre of mass over \
            that of the start, against time. A curve that ends early is that of a run which diverged or gained more \
            energy than there was in the spin.",
        draw: Draw::Sheet(spin),
    },
    Plate {
        file: "momentum-drift.svg",
        title: "Drift of linear momentum",
        caption: "Greatest distance of the momentum from where gravity alone would have it, within one second, over \
            mass and greatest speed; the axis is logarithmic. Near 10⁻¹⁵ only round-off is left, near 10⁻¹² the \
            tolerance of a solve. The falling sheet is heavier on one side, so that nothing cancels by symmetry. \
            Crossed out on the right edge: the run diverged or gained more energy than there was in the spin.",
        draw: Draw::Sheet(drift),
    },
];

fn rows_of<'a>(input: &'a Input, scene: &Scene) -> impl Iterator<Item = &'a Row> + Clone {
    let id = scene.id.clone();
    input.facts.rows.iter().filter(move |row| row.scene == id)
}

fn has_gravity(scene: &Scene) -> bool {
    scene.gravity_m_s2 != [0.0; 3]
}

/// A sheet in space, where nothing but its springs acts.
fn is_spinning_sheet(scene: &Scene) -> bool {
    scene.particles > 2 && !has_gravity(scene)
}

/// A scene in a few words.
fn name(scene: &Scene) -> String {
    let body = match scene.particles {
        2 => "two particles",
        _ if has_gravity(scene) => "falling sheet",
        _ => "spinning sheet",
    };
    format!("{body}, k/m = {} s⁻²", power(scene.stiffness_over_mass_per_s2))
}

/// Method and label of a row.
fn identity(row: &Row) -> (&str, &str) {
    (&row.method, &row.label)
}

/// One line of dots for each method, from the values of some scenes; runs without a value are crossed out on the
/// right edge.
fn dots(
    input: &Input,
    scenes: &[&Scene],
    value: impl Fn(&Row) -> Option<f64>,
    axis: impl Fn(&[f64]) -> Axis,
) -> Option<Sheet> {
    let rows = || scenes.iter().flat_map(|scene| rows_of(input, scene));
    let labels = labels(rows().map(identity));
    let values: Vec<f64> = rows().filter_map(&value).collect();
    let mut panel = Panel::new(Vec::new(), axis(&values), Axis::names("", &labels));
    for (n, scene) in scenes.iter().enumerate() {
        let points = rows_of(input, scene).filter_map(|row| {
            let y = -(labels.iter().position(|label| *label == row.label)? as f64);
            Some(match value(row).filter(|_| row.verdict == Verdict::Completed) {
                Some(x) => Point { x, y, state: State::Stable },
                None => Point { x: f64::INFINITY, y, state: State::Failed },
            })
        });
        let series = Series::new(name(scene), Look::number(n), points.collect());
        panel.series.extend(series.map(Series::apart));
    }
    (!labels.is_empty()).then(|| Sheet { panels: vec![panel], notes: Vec::new() })
}

fn spin_left(input: &Input) -> Option<Sheet> {
    let scenes: Vec<_> = input.facts.scenes.iter().collect();
    let axis = |values: &[f64]| {
        let span: Vec<f64> = values.iter().copied().chain([0.0, 1.0]).collect();
        Axis::linear("|L|/|L₀| after one second (dimensionless)", &span)
    };
    dots(input, &scenes, |row| row.final_spin, axis)
}

fn drift(input: &Input) -> Option<Sheet> {
    let scenes: Vec<_> = input.facts.scenes.iter().filter(|scene| scene.particles > 2).collect();
    let axis = |values: &[f64]| Axis::log("drift of momentum (dimensionless)", values);
    dots(input, &scenes, |row| row.momentum_drift, axis)
}

fn spin(input: &Input) -> Option<Sheet> {
    let scenes: Vec<_> =
        input.facts.scenes.iter().filter(|scene| is_spinning_sheet(scene)).collect();
    let rows = || scenes.iter().flat_map(|scene| rows_of(input, scene));
    let times: Vec<f64> = scenes.iter().flat_map(|scene| &scene.time_s).copied().collect();
    let values: Vec<f64> = rows().flat_map(|row| &row.spin).copied().chain([0.0]).collect();
    let mut panels = Vec::new();
    for family in families(rows().map(identity)) {
        for scene in &scenes {
            let stiffness = power(scene.stiffness_over_mass_per_s2);
            let mut panel = Panel::new(
                vec![format!("{}, k/m = {stiffness} s⁻²", family.title)],
                Axis::linear("time (s)", &times),
                Axis::linear("|L|/|L₀|", &values),
            );
            panel.series = family
                .members
                .iter()
                .filter_map(|(label, look)| {
                    let row = rows_of(input, scene).find(|row| row.label == *label)?;
                    let points = scene.time_s.iter().zip(&row.spin);
                    let points = points.map(|(&x, &y)| Point { x, y, state: State::Stable });
                    Series::new(row.label.clone(), *look, points.collect())
                })
                .collect();
            panels.push(panel);
        }
    }
    (!panels.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let scenes: Vec<_> = input.facts.scenes.iter().collect();
    let (pairs, sheets): (Vec<_>, Vec<_>) = scenes.iter().partition(|scene| scene.particles == 2);
    let number = |value: Option<f64>, digits| value.map_or_else(absent, |v| significant(v, digits));
    let left = table(
        input,
        &scenes,
        "**Spin that is left**: angular momentum about the centre of mass after one second over that of the start.",
        |row| number(row.final_spin, 3),
    );
    let drifts = table(
        input,
        &sheets,
        "**Drift of linear momentum; drift of angular momentum; gain of energy** (greatest rise of the total energy over \
         the energy of the spin).",
        |row| {
            let values = [row.momentum_drift, row.angular_momentum_drift, row.energy_gain];
            values.map(|value| number(value, 2)).join("; ")
        },
    );
    let laws = table(
        input,
        &pairs,
        "**Two particles: measured; law.** |L|/|L₀| after one second, and what the exact law of the method gives, where \
         one is known.",
        |row| [row.final_spin, row.law].map(|value| number(value, 6)).join("; "),
    );
    vec![left, drifts, laws, steps(input)]
}

/// A line for each label, a column for each scene.
fn table(input: &Input, scenes: &[&Scene], title: &str, cell: impl Fn(&Row) -> String) -> Table {
    let mut header = texts(&["method"]);
    header.extend(scenes.iter().map(|scene| name(scene)));
    let text =
        |row: &Row| if row.verdict == Verdict::Completed { cell(row) } else { "✗".to_owned() };
    let line = |label: String| {
        let row = |scene: &&Scene| rows_of(input, scene).find(|row| row.label == label);
        let cells = scenes.iter().map(|scene| row(scene).map_or_else(absent, text));
        std::iter::once(label.clone()).chain(cells).collect()
    };
    let rows = scenes.iter().flat_map(|scene| rows_of(input, scene));
    Table {
        title: format!("{title} ✗ diverged, or gained more energy than there was in the spin."),
        header,
        names: 1,
        rows: labels(rows.map(identity)).into_iter().map(line).collect(),
    }
}

/// Step sizes on the scenes.
fn steps(input: &Input) -> Table {
    let line = |scene: &Scene| {
        let shorter = rows_of(input, scene).map(|row| row.step_s).filter(|h| *h < scene.step_s);
        let explicit = shorter.min_by(f64::total_cmp);
        vec![
            name(scene),
            scene.particles.to_string(),
            significant(scene.greatest_frequency_per_s, 3),
            setting(scene.step_s),
            explicit.map_or_else(absent, |h| significant(h, 3)),
        ]
    };
    Table {
        title: "**Step sizes**, which explicit methods need shorter.".to_owned(),
        header: texts(&["scene", "particles", "ω_max at most (1/s)", "h (s)", "h, explicit (s)"]),
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}
