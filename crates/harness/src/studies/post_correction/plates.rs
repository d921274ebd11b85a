//! Figures of the experiment `post-correction`.

use super::facts::{FORWARD, Facts, Mesh, Row, Spin};
use drape_report::number::{setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{At, Axis, Look, Panel, Point, Rule, Series, Sheet, State, values};

/// What the figures are drawn from.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "post-correction-order.svg",
        title: "Does the order of the sweep decide where the corrected sheet is?",
        caption: "Distance of the positions to those of the run with forward sweeps, over the motion of the stiff sheet, against \
            time; limit 0.1, Provot's method, one sweep a step above and ten below, grid on the left, triangle mesh on the right. A sheet of 20 × 20 \
            particles, k/m = 10⁴ s⁻², hangs from two corners. `list 1` and `list 2` are forward sweeps over lists of springs in another order. \
            Above the dashed line at 0.01 the order decides where the sheet is. `disturbed start` shows what a ten-thousandth of a mesh width \
            at the start does: what lies far above it is no mere sensitivity of the motion.",
        draw: Draw::Sheet(order),
    },
    Plate {
        file: "post-correction-limit.svg",
        title: "Does a soft sheet with ever narrower limits become a stiff one?",
        caption: "Distance of the corrected soft sheet (k/m = 10⁴ s⁻²) to the stiff one (10⁷ s⁻², no correction) over the motion of the latter, \
            against the greatest elongation that the correction leaves to a spring; a panel for each mesh and time, curves for the \
            methods and the sweeps a step. Curves that fall towards the left approach the stiff sheet. The dashed line is the \
            soft sheet without correction at that time. Both axes are logarithmic and the same in all panels.",
        draw: Draw::Sheet(limit),
    },
    Plate {
        file: "post-correction-sweeps.svg",
        title: "How many sweeps it takes to keep the limit",
        caption: "A sheet that fell for 0.25 s without correction, its longest spring nearly twice its length, is corrected by more and \
            more sweeps: greatest elongation that is left, over the rest length, against the number of sweeps, in three orders. Grid \
            on the left, triangle mesh on the right, limit 0.1 above, 0.01 below. The dashed line is the limit. A method that makes one sweep \
            or ten a step stays at the left end of these curves; shortening one spring stretches its neighbours, and the first sweep may make it worse.",
        draw: Draw::Sheet(sweeps),
    },
    Plate {
        file: "post-correction-bill.svg",
        title: "What the correction takes and gives",
        caption: "Forward sweeps, a line for each mesh, method and number of sweeps a step, by limit. Points stand for the energy that corrections gave to \
            the sheet and took from it, summed, over that which the fall sets free; the share of the weight which corrections hold instead of springs; and the \
            residual ‖M a − f‖/‖f‖ of the differential equation, which is 0 for a step without correction (Provot's) or an error of the step \
            (Desbrun's). Residuals about 1 say that the forces of the correction are as large as all forces of the model.",
        draw: Draw::Sheet(bill),
    },
];

fn usual_step(input: &Input) -> f64 {
    input.facts.rows.iter().map(|row| row.step_s).fold(0.0, f64::max)
}

/// Rows at the usual step.
fn rows(input: &Input) -> impl Iterator<Item = &Row> + Clone {
    let step = usual_step(input);
    input.facts.rows.iter().filter(move |row| row.step_s == step)
}

fn solid(x: f64, y: f64) -> Point {
    Point { x, y, state: State::Stable }
}

/// `1 sweep`, `10 sweeps`.
fn sweeps_a_step(sweeps: u32) -> String {
    if sweeps == 1 { "1 sweep".to_owned() } else { format!("{sweeps} sweeps") }
}

fn order(input: &Input) -> Option<Sheet> {
    const DEPENDS: f64 = 0.01;
    let widest = rows(input).map(|row| row.limit).fold(0.0, f64::max);
    let drawn = || {
        rows(input).filter(|row| {
            row.limit == widest && row.label == "provot" && !row.order_distance.is_empty()
        })
    };
    let mut orders: Vec<&str> = Vec::new();
    for row in drawn() {
        if !orders.contains(&row.order.as_str()) {
            orders.push(&row.order);
        }
    }
    let distances: Vec<f64> =
        drawn().flat_map(|row| &row.order_distance).copied().chain([DEPENDS]).collect();
    let times: Vec<f64> =
        input.facts.meshes.iter().flat_map(|mesh| &mesh.time_s).copied().collect();
    let mut panels = Vec::new();
    for sweeps in values(drawn().map(|row| f64::from(row.sweeps))) {
        for mesh in &input.facts.meshes {
            let mut panel = Panel::new(
                vec![format!("{}, {} a step", mesh.id, sweeps_a_step(sweeps as u32))],
                Axis::linear("time (s)", &times),
                Axis::log("distance over motion", &distances),
            );
            for (n, name) in orders.iter().enumerate() {
                let row = drawn().find(|row| {
                    row.mesh == mesh.id && f64::from(row.sweeps) == sweeps && row.order == *name
                });
                let points =
                    row.into_iter().flat_map(|row| mesh.time_s.iter().zip(&row.order_distance));
                let points = points.map(|(t, d)| solid(*t, *d)).collect();
                panel.series.extend(Series::new((*name).to_owned(), Look::number(n), points));
            }
            let label = "the order decides where the sheet is".to_owned();
            panel.rules = vec![Rule { label, at: At::Y(DEPENDS) }];
            panels.extend((!panel.series.is_empty()).then_some(panel));
        }
    }
    (!panels.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// Method and sweeps a step.
fn variant(row: &Row) -> String {
    format!("{}, {} a step", row.label, sweeps_a_step(row.sweeps))
}

fn variants<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<String> {
    let mut variants: Vec<String> = Vec::new();
    for row in rows {
        let name = variant(row);
        if !variants.contains(&name) {
            variants.push(name);
        }
    }
    variants
}

fn limit(input: &Input) -> Option<Sheet> {
    let drawn = || rows(input).filter(|row| row.order == FORWARD);
    let limits = values(drawn().map(|row| row.limit));
    if limits.len() < 2 {
        return None;
    }
    let distances: Vec<f64> = drawn()
        .flat_map(|row| &row.distance)
        .chain(input.facts.meshes.iter().flat_map(|mesh| &mesh.uncorrected_distance))
        .copied()
        .collect();
    let variants = variants(drawn());
    let times = input.facts.meshes.first()?.time_s.len();
    let mut panels = Vec::new();
    for time in 0..times {
        for mesh in &input.facts.meshes {
            let mut panel = Panel::new(
                vec![format!("{}, t = {} s", mesh.id, setting(mesh.time_s[time]))],
                Axis::log("limit of the elongation", &limits),
                Axis::log("distance over motion", &distances),
            );
            for (n, name) in variants.iter().enumerate() {
                let points = drawn().filter(|row| row.mesh == mesh.id && variant(row) == *name);
                let points =
                    points.filter_map(|row| Some(solid(row.limit, *row.distance.get(time)?)));
                panel.series.extend(Series::new(name.clone(), Look::number(n), points.collect()));
            }
            panel.rules.extend(mesh.uncorrected_distance.get(time).map(|distance| Rule {
                label: "without correction".to_owned(),
                at: At::Y(*distance),
            }));
            panels.push(panel);
        }
    }
    Some(Sheet { panels, notes: Vec::new() })
}

fn sweeps(input: &Input) -> Option<Sheet> {
    let runs = &input.facts.sweeps;
    let counts: Vec<f64> = runs.iter().flat_map(|r| &r.sweeps).map(|n| f64::from(*n)).collect();
    let lengths: Vec<f64> =
        runs.iter().flat_map(|run| run.elongation.iter().copied().chain([run.limit])).collect();
    let mut orders: Vec<&str> = Vec::new();
    for run in runs {
        if !orders.contains(&run.order.as_str()) {
            orders.push(&run.order);
        }
    }
    let mut panels = Vec::new();
    for limit in values(runs.iter().map(|run| run.limit)).into_iter().rev() {
        for mesh in &input.facts.meshes {
            let mut panel = Panel::new(
                vec![format!("{}, limit {}", mesh.id, setting(limit))],
                Axis::log("sweeps", &counts),
                Axis::log("greatest elongation left", &lengths),
            );
            for (n, name) in orders.iter().enumerate() {
                let run = runs
                    .iter()
                    .find(|run| run.mesh == mesh.id && run.limit == limit && run.order == *name);
                let points = run.into_iter().flat_map(|run| run.sweeps.iter().zip(&run.elongation));
                let points = points.map(|(n, left)| solid(f64::from(*n), *left)).collect();
                panel.series.extend(Series::new((*name).to_owned(), Look::number(n), points));
            }
            panel.rules = vec![Rule { label: "limit".to_owned(), at: At::Y(limit) }];
            panels.extend((!panel.series.is_empty()).then_some(panel));
        }
    }
    (!panels.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// A quantity of a row, with its name.
type Quantity = (&'static str, fn(&Row) -> f64);

const BILL: [Quantity; 4] = [
    ("energy given", |row| row.energy_given),
    ("energy taken", |row| row.energy_taken),
    ("share of the weight held", |row| row.weight_held),
    ("residual of the equation", |row| row.residual),
];

fn bill(input: &Input) -> Option<Sheet> {
    let drawn: Vec<&Row> = rows(input).filter(|row| row.order == FORWARD).collect();
    let name = |row: &Row| format!("{}, {}, limit {}", row.mesh, variant(row), setting(row.limit));
    let names: Vec<String> = drawn.iter().map(|row| name(row)).collect();
    let all = BILL.iter().flat_map(|(_, value)| drawn.iter().map(|row| value(row)));
    let span: Vec<f64> = all.chain([0.0]).collect();
    let mut panel = Panel::new(
        Vec::new(),
        Axis::linear("share (dimensionless)", &span),
        Axis::names("", &names),
    );
    for (n, (label, value)) in BILL.iter().enumerate() {
        let points = drawn.iter().enumerate().map(|(y, row)| solid(value(row), -(y as f64)));
        let series = Series::new((*label).to_owned(), Look::number(n), points.collect());
        panel.series.extend(series.map(Series::apart));
    }
    (!drawn.is_empty()).then_some(Sheet { panels: vec![panel], notes: Vec::new() })
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    vec![distances(input), lengths(input), spins(input)]
}

fn listed(values: &[f64]) -> String {
    values.iter().map(|value| significant(*value, 3)).collect::<Vec<_>>().join("; ")
}

fn distances(input: &Input) -> Table {
    let line = |mesh: &Mesh| {
        vec![
            mesh.id.clone(),
            mesh.particles.to_string(),
            mesh.springs.to_string(),
            listed(&mesh.time_s),
            listed(&mesh.motion_m),
            listed(&mesh.reference_error),
            listed(&mesh.uncorrected_distance),
            significant(mesh.uncorrected_elongation, 3),
            significant(mesh.reference_elongation, 3),
        ]
    };
    Table {
        title: "**The meshes**: times, s; motion of the stiff sheet, m; its own error and the distance of the soft sheet without correction, over \
                that motion; greatest elongation of the soft sheet without correction and of the stiff one."
            .to_owned(),
        header: texts(&[
            "mesh",
            "particles",
            "springs",
            "t",
            "motion",
            "error",
            "uncorrected",
            "elongation, soft",
            "elongation, stiff",
        ]),
        names: 1,
        rows: input.facts.meshes.iter().map(line).collect(),
    }
}

fn lengths(input: &Input) -> Table {
    let line = |row: &Row| {
        vec![
            row.mesh.clone(),
            variant(row),
            setting(row.limit),
            setting(row.step_s),
            listed(&row.distance),
            significant(row.elongation, 3),
            significant(row.energy_given, 3),
            significant(row.energy_taken, 3),
            significant(row.weight_held, 3),
            significant(row.residual, 3),
            significant(row.uncorrected_residual, 2),
        ]
    };
    let forward = input.facts.rows.iter().filter(|row| row.order == FORWARD);
    Table {
        title: "**Forward sweeps**: distance to the stiff sheet at the times above; greatest elongation of a spring in the run; energy given and \
                taken by corrections over that of the fall; share of the weight they hold; residual of the equation, and of the same steps without \
                their correction."
            .to_owned(),
        header: texts(&[
            "mesh",
            "method",
            "limit",
            "h (s)",
            "distance",
            "elongation",
            "given",
            "taken",
            "weight",
            "residual",
            "uncorrected",
        ]),
        names: 2,
        rows: forward.map(line).collect(),
    }
}

fn spins(input: &Input) -> Table {
    let line = |spin: &Spin| {
        vec![
            spin.mesh.clone(),
            spin.label.clone(),
            spin.limit.map_or_else(absent, setting),
            significant(spin.momentum_change, 2),
            significant(spin.angular_momentum_left, 4),
            significant(spin.angular_momentum_taken, 3),
            significant(spin.energy_left, 4),
        ]
    };
    Table {
        title: "**Free sheets that spin in their plane** at 10 rad/s for one second, undamped: greatest change of momentum by a correction \
                (over mass and edge speed), angular momentum left, the part that corrections took, energy left."
            .to_owned(),
        header: texts(&["mesh", "method", "limit", "ΔP", "|L|/|L₀|", "taken", "H/H₀"]),
        names: 2,
        rows: input.facts.spins.iter().map(line).collect(),
    }
}
