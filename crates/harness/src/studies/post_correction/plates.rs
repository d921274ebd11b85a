//! Figures of the experiment `post-correction`.

use super::facts::{
    DEPENDS, FORWARD, Facts, Mesh, PERTURBED, Row, Spin, Sweeps, groups, spread, usual_step,
};
use drape_report::number::{setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{At, Axis, Look, Panel, Point, Rule, Series, Sheet, State, values};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "post-correction-order.svg",
        title: "The order of the sweep decides where the corrected sheet is",
        caption: "At 2 s, most orders of the sweep differ by more than 1 % of the motion (dashed \
            line); a disturbed start differs by ten thousand times less. Distance to the run with \
            forward sweeps, over the motion of the stiff sheet; Provot's method, limit 0.1, one \
            sweep a step above, ten below, grid left, triangles right. `list 1` and `list 2`: \
            forward over permuted springs.",
        draw: Draw::Sheet(order),
    },
    Plate {
        file: "post-correction-limit.svg",
        title: "Does a soft sheet with ever narrower limits become a stiff one?",
        caption: "Curves fall towards the left: narrower limits bring the soft sheet nearer to the \
            stiff sheet, but the curves level off far from it. Distance of the corrected soft \
            sheet (k/m = 10⁴ s⁻²) to the stiff one (10⁷ s⁻²) over its motion, against the \
            elongation that the limit allows. Dashed: the soft sheet without correction.",
        draw: Draw::Sheet(limit),
    },
    Plate {
        file: "post-correction-sweeps.svg",
        title: "How many sweeps it takes to keep the limit",
        caption: "One sweep makes the longest spring longer; hundreds are needed to come near the \
                  limit (dashed). Greatest elongation that is left on a sheet that fell for 0.25 \
            s without correction, against the number of sweeps, in three orders. Grid left, \
            triangles right; limit 0.1 above, 0.01 \
            below.",
        draw: Draw::Sheet(sweeps),
    },
    Plate {
        file: "post-correction-bill.svg",
        title: "What the correction takes and gives",
        caption: "A residual near 1 means that the forces of the correction are as large as all \
            forces of the model; the corrections carry nearly all of the weight. Energy given and \
            taken, over what the fall sets free; share of the weight held; residual ‖M a − \
            f‖/‖f‖. Forward sweeps; each line is a mesh, a method, sweeps a step and a limit.",
        draw: Draw::Sheet(bill),
    },
];

/// Rows at the usual step.
fn rows(input: &Input) -> impl Iterator<Item = &Row> + Clone {
    let step = usual_step(&input.facts);
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

/// Label and number of sweeps a step of a row.
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
    vec![distances(input), lengths(input), orders(input), convergence(input), spins(input)]
}

/// The distances between orders, by mesh, method and limit.
fn orders(input: &Input) -> Table {
    let groups = groups(&input.facts);
    let with = groups.iter().filter_map(|(key, rows)| {
        let spread = spread(rows);
        let last = *spread.last()?;
        let disturbed = rows.iter().find(|row| row.order == PERTURBED);
        let disturbed = disturbed.map_or_else(absent, |row| listed(&row.order_distance));
        let (mesh, label, limit, sweeps) = *key;
        let method = format!("{label}, {} a step", sweeps_a_step(sweeps));
        let decides = if last > DEPENDS { "yes" } else { "no" }.to_owned();
        let cells =
            vec![mesh.to_owned(), method, setting(limit), decides, listed(&spread), disturbed];
        Some((last, cells))
    });
    let mut with: Vec<_> = with.collect();
    with.sort_by(|a, b| b.0.total_cmp(&a.0));
    Table {
        title: format!(
            "**Orders of the sweep, the farthest apart first**: whether the order decides where \
             the sheet ends (by more than {DEPENDS} of the motion); greatest distance to forward \
             sweeps at the times above; the same of a disturbed \
             start."
        ),
        header: texts(&["mesh", "method", "limit", "decides", "distance", "disturbed start"]),
        names: 2,
        rows: with.into_iter().map(|(_, cells)| cells).collect(),
    }
}

/// The stretch that repeated sweeps leave.
fn convergence(input: &Input) -> Table {
    let line = |run: &Sweeps| {
        let left =
            |elongation: Option<&f64>| elongation.map_or_else(absent, |e| significant(*e, 3));
        vec![
            run.mesh.clone(),
            run.order.clone(),
            setting(run.limit),
            significant(run.before, 3),
            left(run.elongation.first()),
            left(run.elongation.last()),
            run.sweeps.last().map_or_else(absent, u32::to_string),
            run.met().map_or_else(absent, |n| n.to_string()),
        ]
    };
    Table {
        title: "**Convergence of sweeps**: greatest elongation before, after one sweep and after \
                the last; sweeps that meet the limit within 1 %. –: none \
            here."
            .to_owned(),
        header: texts(&[
            "mesh",
            "order",
            "limit",
            "before",
            "after 1",
            "after last",
            "last",
            "met \
            by",
        ]),
        names: 2,
        rows: input.facts.sweeps.iter().map(line).collect(),
    }
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
        title: "**The meshes**: times, s; motion of the stiff sheet, m; over it the stiff sheet's \
                own error and the distance of the uncorrected soft sheet; greatest elongation of \
            both."
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
        title: "**Forward sweeps**: distance to the stiff sheet at the times above; greatest \
                elongation; energy given and taken, over that of the fall; share of the weight \
            held; residual of the equation, and without the \
            correction."
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
        title: "**Free sheets that spin** at 10 rad/s for one second, undamped: greatest change \
                of momentum by a correction (over mass and edge speed), angular momentum left, \
            the part that corrections took, energy \
            left."
            .to_owned(),
        header: texts(&["mesh", "method", "limit", "ΔP", "|L|/|L₀|", "taken", "H/H₀"]),
        names: 2,
        rows: input.facts.spins.iter().map(line).collect(),
    }
}
