//! Figures of the experiment `collision`.

use super::facts::{Facts, Increase, POSITION, Row, SEVERE, Scene, TELEPORT, VELOCITY, factors};
use drape_report::Verdict;
use drape_report::number::{power, setting, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{At, Axis, Look, Panel, Point, Rule, Series, Sheet, State, values};
use drape_report::verdict::SIGNS;

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "collision-iterations.svg",
        title: "Iterations in contact, over those with the velocity constraint",
        caption: "Few solid points lie right of the dashed line at 2, which marks the severe \
            increase that the paper reports. Iterations a step from the first contact on, over \
            those with the velocity constraint. Each line is a scene: obstacle, speed (m/s), k/m \
            (s⁻²). Position: altered within the step; teleport: moved by hand after it. Crossed \
            out: a run gains energy.",
        draw: Draw::Sheet(iterations),
    },
    Plate {
        file: "collision-course.svg",
        title: "Iterations step by step: a sheet falls on a table at 3 m/s",
        caption: "The counts rise at the contact with the constraint too, because cloth in contact \
            is harder to solve for. Iterations of each step of 0.01 s; 20 × 20 particles meet the \
            table shortly before 0.1 s. Left k/m = 10⁴ s⁻², right 10⁶ s⁻²; above IMEX Euler, \
            below Baraff and Witkin's step.",
        draw: Draw::Sheet(course),
    },
    Plate {
        file: "collision-depth.svg",
        title: "How deep particles get into an obstacle",
        caption: "No particle penetrates deeper than one step can carry it (dashed line at 1). \
            Greatest depth at the end of a step, before particles are moved by hand, over v h, \
            the way of the fastest particle in a step. Each point is a scene, each line a method \
            with its way of handling contact. Particles inside are drawn on the surface.",
        draw: Draw::Sheet(depth),
    },
    Plate {
        file: "collision-energy.svg",
        title: "Energy gained by contacts",
        caption: "Stiff sheets whose particles are moved by hand (teleport) gain up to thirty \
            times the available energy; with the constraint most methods gain none. Greatest rise \
            of the total energy above its start, over the available energy; each point is a \
            scene. Right of the dashed line at 0.02 a run is not stable. Every gain is an \
            artefact.",
        draw: Draw::Sheet(energy),
    },
];

/// The name of a method with its way out.
fn name(row: &Row) -> String {
    format!("{}, {}", row.label, row.way_out)
}

/// The names of the rows, in the record's order.
fn names_of<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in rows {
        let name = name(row);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The run with the velocity constraint for the same scene and method.
fn constrained<'a>(input: &'a Input, row: &Row) -> Option<&'a Row> {
    let rows = input.facts.rows.iter();
    let same = |other: &&Row| other.scene == row.scene && other.label == row.label;
    rows.filter(same).find(|other| other.way_out == VELOCITY)
}

/// Factor of the iterations, and whether neither run gains energy. `None` for the constraint itself
/// and for methods without iterations.
fn factor(input: &Input, row: &Row) -> Option<(f64, bool)> {
    let velocity = constrained(input, row)?;
    let is_other = row.way_out != VELOCITY && velocity.iterations_after > 0;
    let is_fair = row.verdict == Verdict::Stable && velocity.verdict == Verdict::Stable;
    is_other.then(|| (row.rate() / velocity.rate(), is_fair))
}

fn iterations(input: &Input) -> Option<Sheet> {
    let rows = &input.facts.rows;
    let scenes: Vec<String> = input.facts.scenes.iter().map(|scene| scene.id.clone()).collect();
    let altered = || rows.iter().filter(|row| factor(input, row).is_some());
    let factors: Vec<f64> = altered().filter_map(|row| factor(input, row)).map(|f| f.0).collect();
    let label = "iterations over those with the velocity constraint (ratio)";
    let span: Vec<f64> = factors.iter().copied().chain([0.5, 2.0]).collect();
    let mut panel = Panel::new(Vec::new(), Axis::log(label, &span), Axis::names("", &scenes));
    for (n, name_of) in names_of(altered()).iter().enumerate() {
        let points = altered().filter(|row| name(row) == *name_of).filter_map(|row| {
            let y = -(scenes.iter().position(|scene| *scene == row.scene)? as f64);
            let (x, is_fair) = factor(input, row)?;
            let state = if is_fair { State::Stable } else { State::Failed };
            Some(Point { x, y, state })
        });
        let series = Series::new(name_of.clone(), Look::number(n), points.collect());
        panel.series.extend(series.map(Series::apart));
    }
    panel.rules = vec![
        Rule { label: "severe: twice as many".to_owned(), at: At::X(SEVERE) },
        Rule { label: "as many".to_owned(), at: At::X(1.0) },
    ];
    (!factors.is_empty()).then_some(Sheet { panels: vec![panel], notes: Vec::new() })
}

fn course(input: &Input) -> Option<Sheet> {
    let drawn = || input.facts.rows.iter().filter(|row| !row.iterations_by_step.is_empty());
    let scenes: Vec<&Scene> = input
        .facts
        .scenes
        .iter()
        .filter(|scene| drawn().any(|row| row.scene == scene.id))
        .collect();
    let highest = drawn().flat_map(|row| &row.iterations_by_step).max().copied();
    let times: Vec<f64> = scenes.iter().flat_map(|s| [0.0, s.steps as f64 * s.step_s]).collect();
    let mut panels = Vec::new();
    for method in ["imex-euler", "baraff-witkin"] {
        for scene in &scenes {
            let rows = || drawn().filter(|row| row.scene == scene.id && row.label == method);
            let counts: Vec<f64> = drawn()
                .filter(|row| row.label == method)
                .flat_map(|row| &row.iterations_by_step)
                .map(|count| f64::from(*count))
                .chain([0.0])
                .collect();
            let stiffness = power(scene.stiffness_over_mass_per_s2);
            let mut panel = Panel::new(
                vec![format!("{method}, k/m = {stiffness} s⁻²")],
                Axis::linear("time (s)", &times),
                Axis::linear("iterations a step", &counts),
            );
            for row in rows() {
                let place = [VELOCITY, POSITION, TELEPORT];
                let look = place.iter().position(|way_out| *way_out == row.way_out);
                let points = row.iterations_by_step.iter().enumerate().map(|(n, count)| Point {
                    x: (n + 1) as f64 * scene.step_s,
                    y: f64::from(*count),
                    state: State::Stable,
                });
                let look = Look::number(look.unwrap_or(place.len()));
                panel.series.extend(Series::new(row.way_out.clone(), look, points.collect()));
            }
            panels.extend((!panel.series.is_empty()).then_some(panel));
        }
    }
    (highest.is_some() && !panels.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// A row of points for each method and way out, and a series for each obstacle and stiffness.
fn dots(input: &Input, value: fn(&Row) -> f64, axis: Axis, rule: Rule) -> Option<Sheet> {
    let Facts { scenes, rows, .. } = &input.facts;
    let names = names_of(rows.iter());
    let mut panel = Panel::new(Vec::new(), axis, Axis::names("", &names));
    let mut kinds: Vec<(&str, f64)> = Vec::new();
    let kind = |scene: &'_ Scene| (scene.obstacle.clone(), scene.stiffness_over_mass_per_s2);
    for scene in scenes {
        let pair = (scene.obstacle.as_str(), scene.stiffness_over_mass_per_s2);
        if !kinds.contains(&pair) {
            kinds.push(pair);
        }
    }
    for (n, (obstacle, stiffness)) in kinds.iter().enumerate() {
        let points = rows.iter().filter_map(|row| {
            let scene = scenes.iter().find(|scene| scene.id == row.scene)?;
            if kind(scene) != ((*obstacle).to_owned(), *stiffness) {
                return None;
            }
            let y = -(names.iter().position(|entry| *entry == name(row))? as f64);
            Some(Point { x: value(row), y, state: State::of_verdict(row.verdict) })
        });
        let label = format!("{obstacle}, k/m = {} s⁻²", power(*stiffness));
        let series = Series::new(label, Look::number(n), points.collect());
        panel.series.extend(series.map(Series::apart));
    }
    panel.rules = vec![rule];
    (!panel.series.is_empty()).then_some(Sheet { panels: vec![panel], notes: Vec::new() })
}

fn depth(input: &Input) -> Option<Sheet> {
    let depths = input.facts.rows.iter().map(|row| row.depth_over_reach);
    let span: Vec<f64> = depths.chain([0.0, 1.0]).collect();
    let axis = Axis::linear("greatest depth over v h (dimensionless)", &span);
    let rule = Rule { label: "as deep as one step carries".to_owned(), at: At::X(1.0) };
    dots(input, |row| row.depth_over_reach, axis, rule)
}

fn energy(input: &Input) -> Option<Sheet> {
    /// Smaller gains are drawn as zero.
    const LEAST: f64 = 1e-4;
    let value = |row: &Row| if row.gain < LEAST { 0.0 } else { row.gain };
    let gains: Vec<f64> = input.facts.rows.iter().map(value).chain([0.02]).collect();
    let axis = Axis::log_with_zero("gain over the available energy (dimensionless)", &gains);
    let rule = Rule { label: "limit of a stable run".to_owned(), at: At::X(0.02) };
    dots(input, value, axis, rule)
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    vec![ways(input), counts(input), rebounds(input)]
}

/// The table of methods with their ways out. Those that gain energy least often are first.
fn ways(input: &Input) -> Table {
    let facts = &input.facts;
    let (factors, onsets) = (factors(facts), facts.onsets());
    let available = |row: &Row| {
        let scene = facts.scenes.iter().find(|scene| scene.id == row.scene);
        scene.map_or(f64::INFINITY, |scene| scene.available_j)
    };
    let line = |of: String| {
        let own = || facts.rows.iter().filter(|row| name(row) == of);
        let gaining = own().filter(|row| row.verdict != Verdict::Stable).count();
        let release = own().map(|row| row.release_j / available(row)).fold(0.0, f64::max);
        let depth = own().map(|row| row.depth_over_reach).fold(0.0, f64::max);
        let first = own().next()?;
        let is_own = |f: &&Increase<'_>| f.label == first.label && f.way_out == first.way_out;
        let factor = factors.iter().find(is_own).filter(|factor| !factor.by_scene.is_empty());
        let (range, severe) = factor.map_or_else(
            || (absent(), absent()),
            |factor| {
                let at = |n: usize| significant(factor.by_scene[n].0, 3);
                let last = factor.by_scene.len() - 1;
                let severe = factor.by_scene.iter().filter(|(factor, _)| *factor >= SEVERE).count();
                let range = format!("{}; {}; {}", at(0), at(factor.by_scene.len() / 2), at(last));
                let worst = factor.by_scene[last].1;
                (format!("{range} ({worst})"), format!("{severe} of {}", factor.by_scene.len()))
            },
        );
        let onset =
            onsets.iter().find(|(label, _)| first.way_out == VELOCITY && *label == first.label);
        let all = own().count();
        let cells = vec![
            of.clone(),
            format!("{gaining} of {all}"),
            range,
            severe,
            onset.map_or_else(absent, |(_, rise)| significant(*rise, 3)),
            significant(100.0 * release, 3),
            significant(depth, 3),
        ];
        Some((gaining as f64 / all as f64, cells))
    };
    let mut lines: Vec<_> = names_of(facts.rows.iter()).into_iter().filter_map(line).collect();
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    Table {
        title: "**Ways out, those that gain energy least often first.** Factor: iterations over \
                those with the velocity constraint, least, middle and greatest, where neither run \
                gains energy. Contact: iterations in contact over those before. Release: the \
                worst rise of the energy as particles leave, over the available energy."
            .to_owned(),
        header: texts(&[
            "method, way out",
            "gain energy",
            "factor",
            "twice as many",
            "contact",
            "release (%)",
            "depth over v h",
        ]),
        names: 1,
        rows: lines.into_iter().map(|(_, cells)| cells).collect(),
    }
}

fn counts(input: &Input) -> Table {
    let names = names_of(input.facts.rows.iter());
    let mut header = texts(&["scene"]);
    header.extend(names.iter().cloned());
    let line = |scene: &Scene| {
        let cell = |name_of: &String| {
            let mut rows = input.facts.rows.iter().filter(|row| row.scene == scene.id);
            rows.find(|row| name(row) == *name_of).map_or_else(absent, |row| {
                format!("{}{}", significant(row.rate(), 3), row.verdict.sign())
            })
        };
        std::iter::once(scene.id.clone()).chain(names.iter().map(cell)).collect()
    };
    Table {
        title: format!(
            "**Iterations a step from the first contact on.** Linear iterations; backward Euler's \
             are Newton's, each with a factorisation. \
             {SIGNS}"
        ),
        header,
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}

/// The table of rebounds: ranges over all methods, by body, obstacle, restitution, speed and way
/// out.
fn rebounds(input: &Input) -> Table {
    let bounces = &input.facts.bounces;
    let mut rows = Vec::new();
    let mut bodies: Vec<(&str, &str)> = Vec::new();
    for bounce in bounces {
        let pair = (bounce.body.as_str(), bounce.obstacle.as_str());
        if !bodies.contains(&pair) {
            bodies.push(pair);
        }
    }
    for (body, obstacle) in bodies {
        let of = || bounces.iter().filter(move |b| b.body == body && b.obstacle == obstacle);
        for restitution in values(of().map(|bounce| bounce.restitution)) {
            for speed in values(of().map(|bounce| bounce.speed_m_s)) {
                let chosen =
                    || of().filter(|b| b.restitution == restitution && b.speed_m_s == speed);
                let range = |found: Vec<f64>| {
                    let low = found.iter().copied().reduce(f64::min);
                    let high = found.iter().copied().reduce(f64::max);
                    match (low, high) {
                        (Some(low), Some(high)) => {
                            format!("{} to {}", significant(low, 3), significant(high, 3))
                        }
                        _ => absent(),
                    }
                };
                let theory = chosen().find_map(|bounce| bounce.height_theory_m);
                let mut line = texts(&[body, obstacle]);
                line.extend([setting(restitution), setting(speed)]);
                line.push(range(chosen().filter_map(|bounce| bounce.measured).collect()));
                line.push(theory.map_or_else(absent, |height| significant(height, 3)));
                line.extend([VELOCITY, POSITION, TELEPORT].map(|way_out| {
                    let ways = chosen().filter(|bounce| bounce.way_out == way_out);
                    range(ways.filter_map(|bounce| bounce.height_m).collect())
                }));
                rows.push(line);
            }
        }
    }
    Table {
        title: "**Rebounds.** Normal speed after the first contact over the speed before, range \
                over all methods; height that is reached again, m, by theory and by way \
            out."
            .to_owned(),
        header: texts(&[
            "body",
            "obstacle",
            "e",
            "speed (m/s)",
            "speed ratio",
            "height, theory",
            "velocity",
            "position",
            "teleport",
        ]),
        names: 2,
        rows,
    }
}
