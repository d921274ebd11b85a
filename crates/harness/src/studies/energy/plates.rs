//! Figures and tables of the experiment `energy`.

use super::facts::{Facts, Ledger, Row, Scene};
use crate::families::{families, labels};
use drape_report::number::{percent, power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Axis, Bar, Fill, Panel, Point, Series, Sheet, State};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "energy-ledger-hanging-1e4.svg",
        title: "Where the energy of a hanging sheet goes, k/m = 10⁴ s⁻²",
        caption: "Without damping (above) implicit methods take most of the energy; with damping \
            (below) dampers have less left to take. Each bar is a run of two seconds: energy \
            taken lies left of 0, energy added right, in per cent of the energy that the fall \
            sets free. The number is the sum. Numerical damping is inertia and gaps together.",
        draw: Draw::Sheet(|input| ledgers(input, "hanging-1e4")),
    },
    Plate {
        file: "energy-ledger-hanging-1e6.svg",
        title: "Where the energy of a stiff hanging sheet goes, k/m = 10⁶ s⁻²",
        caption: "IMEX Euler leaves almost nothing to the damping of the scene, because its sheet \
            locks and hardly falls. The sheet has springs a hundred times as stiff as before. \
            Energy taken (left) and added (right) in two seconds, in per cent of what the fall \
            sets free, without damping above, with d/m = 40 s⁻¹ below.",
        draw: Draw::Sheet(|input| ledgers(input, "hanging-1e6")),
    },
    Plate {
        file: "energy-ledger-spinning-1e4.svg",
        title: "Where the energy of a spinning sheet goes",
        caption: "Methods that add stiffness across a spring stop the rotation without any \
            damping. A free sheet of 10 × 10 particles, k/m = 10⁴ s⁻², turns at 2 rad/s for one \
            second: energy taken (left) and added (right), in per cent of the kinetic energy, \
            without damping above, with d/m = 40 s⁻¹ below. Full damping slows the rotation \
            itself.",
        draw: Draw::Sheet(|input| ledgers(input, "spinning-1e4")),
    },
    Plate {
        file: "energy-ledger-sphere-1e4.svg",
        title: "Where the energy of a sheet goes that falls on a ball",
        caption: "Contacts take and add much energy; corrections take back the energy that pushing \
            particles out adds. A sheet of 12 × 12 particles, k/m = 10⁴ s⁻², falls on an \
            inelastic ball for one second: energy taken (left) and added (right), in per cent of \
            what the fall sets free, without damping above, with d/m = 40 s⁻¹ below.",
        draw: Draw::Sheet(|input| ledgers(input, "sphere-1e4")),
    },
    Plate {
        file: "energy-over-time-hanging-1e4.svg",
        title: "Energy of a hanging sheet over time, k/m = 10⁴ s⁻²",
        caption: "Without damping (left) the true curve stays at 0; implicit methods fall below \
                  it from the first second on. Total energy less that of the start, over the \
            energy that the fall sets free; a row for each family, d/m = 40 s⁻¹ on the right, h = \
            0.01 s (explicit methods: shorter). A crossed-out end is an unstable \
            run.",
        draw: Draw::Sheet(|input| curves(input, "hanging-1e4")),
    },
    Plate {
        file: "energy-over-time-hanging-1e6.svg",
        title: "Energy of a stiff hanging sheet over time, k/m = 10⁶ s⁻²",
        caption: "A method that locks loses energy as slowly as its sheet falls. The springs are a \
            hundred times as stiff as before. Total energy less that of the start, over the \
            energy that the fall sets free, without damping on the left, with d/m = 40 s⁻¹ on the \
            right. A crossed-out end is an unstable run.",
        draw: Draw::Sheet(|input| curves(input, "hanging-1e6")),
    },
    Plate {
        file: "energy-over-time-spinning-1e4.svg",
        title: "Energy of a spinning sheet over time",
        caption: "Without damping (left) the true curve stays at 0; where a curve drops, the \
            method alone stops the spin. Total energy less that of the start, over the kinetic \
            energy, for a free sheet that turns over and over, k/m = 10⁴ s⁻²; d/m = 40 s⁻¹ on the \
            right. A crossed-out end is an unstable run.",
        draw: Draw::Sheet(|input| curves(input, "spinning-1e4")),
    },
    Plate {
        file: "energy-over-time-sphere-1e4.svg",
        title: "Energy over time of a sheet that falls on a ball",
        caption: "Every curve falls from the first impact on, because the inelastic ball takes the \
            energy of what hits it. Total energy less that of the start, over the energy that the \
            fall sets free, k/m = 10⁴ s⁻², without damping on the left, with d/m = 40 s⁻¹ on the \
            right. A crossed-out end is an unstable run.",
        draw: Draw::Sheet(|input| curves(input, "sphere-1e4")),
    },
];

const NUMERICAL: &str = "numerical damping";

fn scenes_of<'a>(input: &'a Input, name: &str) -> Vec<&'a Scene> {
    let mut scenes: Vec<_> =
        input.facts.scenes.iter().filter(|scene| scene.scene == name).collect();
    scenes.sort_by_key(|scene| scene.is_damped);
    scenes
}

fn rows_of<'a>(input: &'a Input, scene: &Scene) -> impl Iterator<Item = &'a Row> + Clone + use<'a> {
    let id = scene.id.clone();
    input.facts.rows.iter().filter(move |row| row.scene == id)
}

/// Method and label of a row.
fn identity(row: &Row) -> (&str, &str) {
    (&row.method, &row.label)
}

/// The damping of a scene, in words.
fn damping(scene: &Scene) -> String {
    if scene.is_damped {
        format!("damped, d/m = {} s⁻¹", setting(scene.damping_over_mass_per_s))
    } else {
        "undamped".to_owned()
    }
}

/// The parts of a bar, in per cent.
fn parts(ledger: &Ledger) -> Vec<(&'static str, Fill, f64)> {
    [
        ("damping of the scene", Fill::Dark, ledger.damping),
        (NUMERICAL, Fill::Hatched, ledger.numerical()),
        ("residual of the solver", Fill::Light, ledger.residual),
        ("pins and contacts", Fill::Upright, ledger.constraint),
        ("corrections", Fill::Crossed, ledger.correction),
    ]
    .map(|(label, fill, share)| (label, fill, 100.0 * share))
    .to_vec()
}

/// Longest side of a bar, in per cent.
const REACH: f64 = 100.0;

fn ledgers(input: &Input, name: &str) -> Option<Sheet> {
    let scenes = scenes_of(input, name);
    let shown = |row: &&Row| row.ledger.is_some() || row.drift.is_none();
    let panels: Vec<Panel> = scenes
        .iter()
        .filter_map(|scene| {
            let rows = || rows_of(input, scene).filter(shown);
            let labels = labels(rows().map(identity));
            let bars: Vec<_> = rows()
                .filter_map(|row| {
                    let y = -(labels.iter().position(|label| *label == row.label)? as f64);
                    let (parts, end) = match (&row.ledger, row.drift) {
                        (Some(ledger), Some(drift)) => (parts(ledger), percent(drift, 3)),
                        _ => (Vec::new(), row.verdict.to_string()),
                    };
                    Some(Bar { y, parts, reach: REACH, end })
                })
                .collect();
            let sums = bars.iter().flat_map(|bar| {
                let sum = |sign: f64| -> f64 {
                    let parts = bar.parts.iter().map(|(.., part)| (sign * part).max(0.0));
                    parts.sum::<f64>().min(REACH) * sign
                };
                [sum(-1.0), sum(1.0)]
            });
            let mut ends: Vec<f64> = sums.chain([-1.0, 1.0]).collect();
            // Leaves room for the number behind the bar.
            let least = ends.iter().copied().fold(0.0, f64::min);
            let greatest = ends.iter().copied().fold(0.0, f64::max);
            ends.push(greatest + 0.16 * (greatest - least));
            (!labels.is_empty()).then(|| Panel {
                bars,
                ..Panel::new(
                    vec![damping(scene)],
                    Axis::linear(
                        "change of the total energy (% of what the scene sets free)",
                        &ends,
                    ),
                    Axis::names("", &labels),
                )
            })
        })
        .collect();
    let mut notes = Vec::new();
    if panels.iter().flat_map(|panel| &panel.bars).any(|bar| bar.longest_side() > REACH) {
        notes.push(format!(
            "Bars longer than {REACH} % are drawn shorter; the numbers in them are true."
        ));
    }
    if !input.facts.unattributed.is_empty() {
        notes.push(format!(
            "Unattributed, having no energy identity of a single step: {}.",
            input.facts.unattributed.join(", ")
        ));
    }
    (!panels.is_empty()).then_some(Sheet { panels, notes })
}

/// Height above its start up to which a curve is drawn, over `E_ref`.
const HIGHEST: f64 = 0.5;

/// The points of a curve up to the first outside the panel.
fn followed(scene: &Scene, row: &Row) -> Vec<Point> {
    let samples = scene.time_s.iter().zip(&row.energy);
    let outside = row.energy.iter().position(|energy| *energy > HIGHEST);
    let shown = outside.map_or(row.energy.len(), |first| first + 1);
    let mut points: Vec<_> = samples
        .take(shown)
        .map(|(&x, &y)| Point { x, y: y.min(HIGHEST), state: State::Stable })
        .collect();
    if let (None, Some(last)) = (row.drift, points.last_mut()) {
        last.state = State::Failed;
    }
    points
}

fn curves(input: &Input, name: &str) -> Option<Sheet> {
    let scenes = scenes_of(input, name);
    let rows = || scenes.iter().flat_map(|scene| rows_of(input, scene));
    let times: Vec<f64> = scenes.iter().flat_map(|scene| &scene.time_s).copied().collect();
    let drawn = scenes.iter().flat_map(|scene| {
        rows_of(input, scene).flat_map(|row| followed(scene, row)).map(|point| point.y)
    });
    let energies: Vec<f64> = drawn.chain([0.0]).collect();
    let mut panels = Vec::new();
    for family in families(rows().map(identity)) {
        for scene in &scenes {
            let mut panel = Panel::new(
                vec![format!("{}, {}", family.title, damping(scene))],
                Axis::linear("time (s)", &times),
                Axis::linear("(H − H₀)/E_ref", &energies),
            );
            panel.series = family
                .members
                .iter()
                .filter_map(|(label, look)| {
                    let row = rows_of(input, scene).find(|row| row.label == *label)?;
                    let series = Series::new(row.label.clone(), *look, followed(scene, row))?;
                    Some(series.sparse())
                })
                .collect();
            panels.push(panel);
        }
    }
    (!panels.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let mut tables = vec![overview(input)];
    tables.extend(input.facts.scenes.iter().map(|scene| causes(input, scene)));
    tables.push(scenes(input));
    tables
}

fn per_cent(share: f64) -> String {
    // A share that is round-off counts as 0.
    if share.abs() < 1e-9 { "0".to_owned() } else { significant(100.0 * share, 3) }
}

/// The table of drift and excess dissipation, for all methods on all scenes.
fn overview(input: &Input) -> Table {
    let mut header = texts(&["method"]);
    header.extend(input.facts.scenes.iter().map(|scene| scene.id.clone()));
    let cell = |row: &Row| match (row.drift, row.excess_dissipation) {
        (Some(drift), Some(excess)) => format!("{}; {}", per_cent(drift), per_cent(excess)),
        _ => format!("✗ {}", row.verdict),
    };
    let line = |label: String| {
        let row = |scene: &Scene| rows_of(input, scene).find(|row| row.label == label);
        let cells = input.facts.scenes.iter().map(|scene| row(scene).map_or_else(absent, cell));
        std::iter::once(label.clone()).chain(cells).collect()
    };
    Table {
        title:
            "**Drift of the energy; excess dissipation**, in % of E_ref. ✗ gained too much energy."
                .to_owned(),
        header,
        names: 1,
        rows: labels(input.facts.rows.iter().map(identity)).into_iter().map(line).collect(),
    }
}

/// The table of a scene's complete ledgers.
fn causes(input: &Input, scene: &Scene) -> Table {
    let with = || rows_of(input, scene).filter_map(|row| Some((row, row.ledger.as_ref()?)));
    let mut effects: Vec<&String> = with().flat_map(|(_, ledger)| ledger.gaps.keys()).collect();
    effects.sort();
    effects.dedup();
    let mut header = texts(&["method", "numerical", "damping", "inertia"]);
    header.extend(effects.iter().map(|effect| format!("gap of {effect}")));
    header.extend(texts(&["residual", "pins, contacts", "corrections", "sum", "closes to"]));
    let mut sorted: Vec<_> = with().collect();
    sorted.sort_by(|a, b| a.1.numerical().total_cmp(&b.1.numerical()));
    let line = |(row, ledger): (&Row, &Ledger)| {
        let mut cells = vec![row.label.clone()];
        cells.extend([ledger.numerical(), ledger.damping, ledger.inertia].map(per_cent));
        let gap = |effect: &&String| ledger.gaps.get(*effect).copied();
        cells.extend(effects.iter().map(|effect| gap(effect).map_or_else(absent, per_cent)));
        let rest = [ledger.residual, ledger.constraint, ledger.correction, ledger.sum()];
        cells.extend(rest.map(per_cent));
        cells.push(row.closure_defect.map_or_else(absent, |defect| significant(defect, 1)));
        cells
    };
    Table {
        title: format!(
            "**Ledger, {}**, the greatest numerical damping first: sums over the run in % of \
             E_ref = {} J; positive terms add energy.",
            scene.id,
            significant(scene.reference_energy_j, 3)
        ),
        header,
        names: 1,
        rows: sorted.into_iter().map(line).collect(),
    }
}

/// The table of scenes and their steps.
fn scenes(input: &Input) -> Table {
    let line = |scene: &Scene| {
        let shorter = rows_of(input, scene).map(|row| row.step_s).filter(|h| *h < scene.step_s);
        vec![
            scene.id.clone(),
            scene.particles.to_string(),
            power(scene.stiffness_over_mass_per_s2),
            setting(scene.duration_s),
            significant(scene.reference_energy_j, 3),
            setting(scene.step_s),
            shorter.min_by(f64::total_cmp).map_or_else(absent, |h| significant(h, 3)),
        ]
    };
    Table {
        title: "**Scenes**, and the step sizes that explicit methods need.".to_owned(),
        header: texts(&[
            "scene",
            "particles",
            "k/m (s⁻²)",
            "duration (s)",
            "E_ref (J)",
            "h (s)",
            "h, explicit, least (s)",
        ]),
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}
