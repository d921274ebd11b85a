//! Figures and tables of the experiment `energy`.

use super::facts::{Facts, Ledger, Row, Scene};
use crate::families::{families, labels};
use drape_report::number::{power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Axis, Bar, Fill, Panel, Point, Series, Sheet, State};

/// What the figures are drawn from.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "energy-ledger-hanging-1e4.svg",
        title: "Where the energy of a hanging sheet goes, k/m = 10⁴ s⁻²",
        caption: "Each bar is one run of two seconds: to the left of 0 what was taken from the total energy, to the right what was \
            added, in per cent of the energy that the fall sets free. A sheet of 20 × 20 particles is released horizontally \
            from two corners, h = 0.01 s (explicit methods: shorter), without damping above and with d/m = 40 s⁻¹ below. Numerical damping is \
            inertia and the gaps of the forces together. Without damping every part is the method's own doing; with it, what \
            the method takes is missing from what the damping should take. The number behind a bar is the sum, the drift of the energy.",
        draw: Draw::Sheet(|input| ledgers(input, "hanging-1e4")),
    },
    Plate {
        file: "energy-ledger-hanging-1e6.svg",
        title: "Where the energy of a stiff hanging sheet goes, k/m = 10⁶ s⁻²",
        caption: "The same sheet with springs a hundred times as stiff, in per cent of the energy that the fall sets free: to the left of 0 what was \
            taken from the total energy in two seconds, to the right what was added; without damping above, with d/m = 40 s⁻¹ \
            below. A bar that ends near 0 may mean two things: the method keeps the energy, or it locks and the sheet hardly falls; the \
            curves over time tell which.",
        draw: Draw::Sheet(|input| ledgers(input, "hanging-1e6")),
    },
    Plate {
        file: "energy-ledger-spinning-1e4.svg",
        title: "Where the energy of a spinning sheet goes",
        caption: "A sheet of 10 × 10 particles with k/m = 10⁴ s⁻² turns over and over at 2 rad/s for one second, free in space, \
            h = 0.01 s (explicit methods: shorter), without damping above and with d/m = 40 s⁻¹ below. In per cent of its kinetic energy: \
            to the left of 0 what was taken, to the right what was added. The full damping brakes the rotation itself; \
            implicit methods that treat a spring as stiff across itself do so without any damping.",
        draw: Draw::Sheet(|input| ledgers(input, "spinning-1e4")),
    },
    Plate {
        file: "energy-ledger-sphere-1e4.svg",
        title: "Where the energy of a sheet goes that falls on a ball",
        caption: "A sheet of 12 × 12 particles with k/m = 10⁴ s⁻² falls on an inelastic ball, one second, h = 0.01 s (explicit methods: shorter), \
            without damping above and with d/m = 40 s⁻¹ below. In per cent of the energy that the fall sets free: to the \
            left of 0 what was taken, to the right what was added. What the impact on the ball takes is counted as work of the constraint, \
            which is physical; so is counted what pushes out a particle that got in, and the correction takes the speed of that away again.",
        draw: Draw::Sheet(|input| ledgers(input, "sphere-1e4")),
    },
    Plate {
        file: "energy-over-time-hanging-1e4.svg",
        title: "Energy of a hanging sheet over time, k/m = 10⁴ s⁻²",
        caption: "Total energy less that of the start, over the energy that the fall sets free, against time; a row of panels for each family of \
            methods, without damping on the left and with d/m = 40 s⁻¹ on the right, h = 0.01 s (explicit methods: shorter). Without \
            damping the true curve stays at 0; what lies below was lost by the method. A curve that ends crossed out is that of an unstable run.",
        draw: Draw::Sheet(|input| curves(input, "hanging-1e4")),
    },
    Plate {
        file: "energy-over-time-hanging-1e6.svg",
        title: "Energy of a stiff hanging sheet over time, k/m = 10⁶ s⁻²",
        caption: "As before, with springs a hundred times as stiff: total energy less that of the start, over the energy that the fall sets free, \
            against time; without damping on the left and with d/m = 40 s⁻¹ on the right. A method that locks loses \
            energy slowly, as slowly as its sheet falls. A curve that ends crossed out is that of an unstable run.",
        draw: Draw::Sheet(|input| curves(input, "hanging-1e6")),
    },
    Plate {
        file: "energy-over-time-spinning-1e4.svg",
        title: "Energy of a spinning sheet over time",
        caption: "Total energy less that of the start, over the kinetic energy of the spin, against time, for a free sheet that turns over and over, \
            k/m = 10⁴ s⁻², without damping on the left and with d/m = 40 s⁻¹ on the right. Without damping the true \
            curve stays at 0. A curve that ends crossed out is that of an unstable run.",
        draw: Draw::Sheet(|input| curves(input, "spinning-1e4")),
    },
    Plate {
        file: "energy-over-time-sphere-1e4.svg",
        title: "Energy over time of a sheet that falls on a ball",
        caption: "Total energy less that of the start, over the energy that the fall sets free, against time, k/m = 10⁴ s⁻², without damping on \
            the left and with d/m = 40 s⁻¹ on the right. Each particle that hits the inelastic ball loses the energy of its motion \
            into it, so that curves fall from the first impact on whatever the method. A curve that ends crossed out is that of an unstable run.",
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

/// How a scene is damped, in words.
fn damping(scene: &Scene) -> String {
    if scene.is_damped {
        format!("damped, d/m = {} s⁻¹", setting(scene.damping_over_mass_per_s))
    } else {
        "undamped".to_owned()
    }
}

/// The parts of a bar in per cent.
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

/// Longest side of a bar, %.
const REACH: f64 = 250.0;

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
                        (Some(ledger), Some(drift)) => {
                            (parts(ledger), format!("{} %", significant(100.0 * drift, 3)))
                        }
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
            // Room for the number behind the bar.
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

/// How far above its start a curve is followed.
const HIGHEST: f64 = 0.5;

/// A curve up to where it leaves the panel.
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
    // What is round-off of 0 is 0.
    if share.abs() < 1e-9 { "0".to_owned() } else { significant(100.0 * share, 3) }
}

/// Drift and excess dissipation of all methods on all scenes.
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
        title: "**Drift of the energy; excess dissipation**, in % of E_ref: (H_N − H₀)/E_ref, and what was lost beyond \
            ∫vᵀDv dt. ✗ gained too much energy."
            .to_owned(),
        header,
        names: 1,
        rows: labels(input.facts.rows.iter().map(identity)).into_iter().map(line).collect(),
    }
}

/// The ledger of a scene in full.
fn causes(input: &Input, scene: &Scene) -> Table {
    let with = || rows_of(input, scene).filter_map(|row| Some((row, row.ledger.as_ref()?)));
    let mut effects: Vec<&String> = with().flat_map(|(_, ledger)| ledger.gaps.keys()).collect();
    effects.sort();
    effects.dedup();
    let mut header = texts(&["method", "damping", "inertia"]);
    header.extend(effects.iter().map(|effect| format!("gap of {effect}")));
    header.extend(texts(&["residual", "pins, contacts", "corrections", "sum", "closes to"]));
    let line = |(row, ledger): (&Row, &Ledger)| {
        let mut cells = vec![row.label.clone()];
        cells.extend([ledger.damping, ledger.inertia].map(per_cent));
        let gap = |effect: &&String| ledger.gaps.get(*effect).copied();
        cells.extend(effects.iter().map(|effect| gap(effect).map_or_else(absent, per_cent)));
        let rest = [ledger.residual, ledger.constraint, ledger.correction, ledger.sum()];
        cells.extend(rest.map(per_cent));
        cells.push(row.closure_defect.map_or_else(absent, |defect| significant(defect, 1)));
        cells
    };
    Table {
        title: format!(
            "**Ledger, {}**: sums over the run in % of E_ref = {} J; what adds energy is positive. The last column is the error \
             of the sums over the magnitudes of the terms.",
            scene.id,
            significant(scene.reference_energy_j, 3)
        ),
        header,
        names: 1,
        rows: with().map(line).collect(),
    }
}

/// The scenes and their steps.
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
