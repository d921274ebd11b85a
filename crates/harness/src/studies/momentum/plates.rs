//! Figures of the experiment `momentum`.

use super::facts::{Facts, LEAST_CHANGE, Row, Scene, prototype_of};
use crate::families::{families, labels};
use drape_report::Verdict;
use drape_report::number::{power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Axis, Look, Panel, Point, Series, Sheet, State};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "momentum-spin-left.svg",
        title: "How much of its spin a free cloth keeps for one second",
        caption: "Explicit, BDF and two-step IMEX methods keep nearly all of the spin (1 is true); \
            IMEX Euler, Desbrun without a consistent correction and Kang lose most of it. Angular \
            momentum about the centre of mass after one second over that of the start; undamped \
            and unpinned, h = 0.01 s (explicit methods: shorter). Crossed out: the run diverged or \
            gained more energy than there was in the spin.",
        draw: Draw::Sheet(spin_left),
    },
    Plate {
        file: "momentum-spin.svg",
        title: "Spin of a free sheet over time",
        caption: "On the stiff sheet (right) IMEX Euler stops the spin within a tenth of a second; \
            on the softer one (left) it fades. Angular momentum about the centre of mass over \
            that of the start; a sheet of 20 × 20 particles turns over and over at 2 rad/s, \
            undamped, h = 0.01 s (explicit methods: shorter). The curve of an unstable run ends \
            early.",
        draw: Draw::Sheet(spin),
    },
    Plate {
        file: "momentum-drift.svg",
        title: "Drift of linear momentum",
        caption: "The momentum drifts only with Kang's method, with vertex block descent, and with \
            loose solves of IMEX Euler and of updated CG; elsewhere only round-off or the \
            tolerance of a solve is left. Greatest distance of the momentum from its value under \
            gravity alone, over mass and greatest speed. Crossed out: the run diverged or gained \
            more energy than there was in the spin.",
        draw: Draw::Sheet(drift),
    },
];

fn rows_of<'a>(input: &'a Input, scene: &Scene) -> impl Iterator<Item = &'a Row> + Clone {
    let id = scene.id.clone();
    input.facts.rows.iter().filter(move |row| row.scene == id)
}

/// A short name of a scene.
fn name(scene: &Scene) -> String {
    let body = match scene.particles {
        2 => "two particles",
        _ if scene.has_gravity() => "falling sheet",
        _ => "spinning sheet",
    };
    format!("{body}, k/m = {} s⁻²", power(scene.stiffness_over_mass_per_s2))
}

/// Method and label of a row.
fn identity(row: &Row) -> (&str, &str) {
    (&row.method, &row.label)
}

/// One line of points for each method, with the values of some scenes. A run without a value is
/// crossed out on the right edge.
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

/// A method has no curve if its curves stay this near to 1 on all sheets.
const STEADY: f64 = 0.05;

fn spin(input: &Input) -> Option<Sheet> {
    let scenes: Vec<_> =
        input.facts.scenes.iter().filter(|scene| scene.is_spinning_sheet()).collect();
    let rows = || scenes.iter().flat_map(|scene| rows_of(input, scene));
    let times: Vec<f64> = scenes.iter().flat_map(|scene| &scene.time_s).copied().collect();
    let values: Vec<f64> = rows().flat_map(|row| &row.spin).copied().chain([0.0]).collect();
    let row_of = |scene: &Scene, label: &str| rows_of(input, scene).find(|row| row.label == label);
    // A run that ended early is drawn, so that the figure shows where it ended.
    let is_steady = |label: &str| {
        scenes.iter().filter_map(|scene| Some((scene, row_of(scene, label)?))).all(
            |(scene, row)| {
                row.spin.len() == scene.time_s.len()
                    && row.spin.iter().all(|spin| libm::fabs(spin - 1.0) <= STEADY)
            },
        )
    };
    let (mut panels, mut left_out) = (Vec::new(), Vec::new());
    for family in families(rows().map(identity)) {
        let (steady, drawn): (Vec<_>, Vec<_>) =
            family.members.into_iter().partition(|(label, _)| is_steady(label));
        left_out.extend(steady.iter().map(|(label, _)| *label));
        for scene in scenes.iter().filter(|_| !drawn.is_empty()) {
            let stiffness = power(scene.stiffness_over_mass_per_s2);
            let mut panel = Panel::new(
                vec![format!("{}, k/m = {stiffness} s⁻²", family.title)],
                Axis::linear("time (s)", &times),
                Axis::linear("|L|/|L₀|", &values),
            );
            let curve = |(label, look): &(&str, Look)| {
                let row = row_of(scene, label)?;
                let points = scene.time_s.iter().zip(&row.spin);
                let points = points.map(|(&x, &y)| Point { x, y, state: State::Stable });
                Series::new(row.label.clone(), *look, points.collect())
            };
            panel.series = drawn.iter().filter_map(curve).collect();
            panels.push(panel);
        }
    }
    let note = format!("Left out, as they stay within 5 % of 1: {}.", left_out.join("; "));
    let notes = (!left_out.is_empty()).then_some(note).into_iter().collect();
    (!panels.is_empty()).then_some(Sheet { panels, notes })
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let scenes: Vec<_> = input.facts.scenes.iter().collect();
    let (pairs, sheets): (Vec<_>, Vec<_>) = scenes.iter().partition(|scene| scene.particles == 2);
    let number = |value: Option<f64>, digits| value.map_or_else(absent, |v| significant(v, digits));
    let mut left = table(
        input,
        &scenes,
        "**Spin that is left** after one second, over that of the start; best kept first.",
        |row| number(row.final_spin, 3),
    );
    left.rows.sort_by(|a, b| change(input, &a[0]).total_cmp(&change(input, &b[0])));
    let drifts = table(
        input,
        &sheets,
        "**Drift of linear momentum; of angular momentum; gain of energy** over that of the spin.",
        |row| {
            let values = [row.momentum_drift, row.angular_momentum_drift, row.energy_gain];
            values.map(|value| number(value, 2)).join("; ")
        },
    );
    let laws = table(
        input,
        &pairs,
        "**Two particles**: spin left after one second; the same by the exact law of the method.",
        |row| [row.final_spin, row.law].map(|value| number(value, 6)).join("; "),
    );
    vec![left, drifts, gains(input), prototype(input), laws, steps(input)]
}

/// Greatest change of the spin of a label, over all scenes; infinite if a run failed.
fn change(input: &Input, label: &str) -> f64 {
    let rows = input.facts.rows.iter().filter(|row| row.label == label);
    let change = |row: &Row| row.final_spin.map_or(f64::INFINITY, |spin| libm::fabs(spin - 1.0));
    rows.map(change).fold(0.0, f64::max)
}

/// The name of a row's scene.
fn scene_of(input: &Input, row: &Row) -> String {
    let scene = input.facts.scenes.iter().find(|scene| scene.id == row.scene);
    scene.map_or_else(|| row.scene.clone(), name)
}

/// The table of runs that gain energy, greatest gain first.
fn gains(input: &Input) -> Table {
    let rows = input.facts.rows.iter();
    let mut rows: Vec<_> = rows
        .filter_map(|row| Some((row, row.energy_gain.filter(|gain| *gain > LEAST_CHANGE)?)))
        .collect();
    rows.sort_by(|a, b| b.1.total_cmp(&a.1));
    let line = |(row, gain): &(&Row, f64)| {
        vec![
            row.label.clone(),
            scene_of(input, row),
            significant(100.0 * gain, 3),
            row.final_spin.map_or_else(absent, |spin| significant(spin, 3)),
        ]
    };
    Table {
        title:
            "**Runs that gain more than 1 % of the energy of the spin**, the greatest gain first."
                .to_owned(),
        header: texts(&["method", "scene", "gain (%)", "spin left"]),
        names: 2,
        rows: rows.iter().map(line).collect(),
    }
}

/// The table of Desbrun's correction against an independent prototype.
fn prototype(input: &Input) -> Table {
    let line = |row: &Row| {
        let (expected, is_confirmed) = prototype_of(row)?;
        Some(vec![
            row.label.clone(),
            scene_of(input, row),
            row.final_spin.map_or_else(absent, |spin| significant(spin, 3)),
            expected.to_string(),
            if is_confirmed { "yes" } else { "no" }.to_owned(),
        ])
    };
    Table {
        title: "**Spin left by Desbrun's correction, beside an independent prototype.** Here the \
                consistent one takes its lever arms at the old positions."
            .to_owned(),
        header: texts(&["method", "scene", "spin left", "prototype", "confirmed"]),
        names: 2,
        rows: input.facts.rows.iter().filter_map(line).collect(),
    }
}

/// A table with a row for each label and a column for each scene.
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

/// The table of step sizes.
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
        title: "**Step sizes**: explicit methods take shorter ones.".to_owned(),
        header: texts(&["scene", "particles", "ω_max at most (1/s)", "h (s)", "h, explicit (s)"]),
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}
