//! Figures and tables of the experiment `trajectory`.

use super::facts::{Beside, Facts, Kind, LEVELS, Row, Run, Scene, Winner, tally};
use super::words::{cheapest, counted, frequent, id, runs, winner};
use crate::families::looks;
use crate::studies::tiles::{legend_of_winners, signs_of_winners, told};
use crate::studies::work_precision::plates::{FRONT, MODELLED, curve, mark, tile, told_winner};
use drape_report::number::{percent, power, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Axis, Draft, Look, Matrix, Panel, Point, Row as Line, Rule, Series, Shade, Sheet, State,
    Tile, panels_of, values,
};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "trajectory-map.svg",
        title: "Which method follows the motion at least cost, by stiffness and damping",
        caption: "Only a colour marks a lead by a factor of 2: blue is an explicit method, yellow \
            an implicit one, violet one of local solves, which the words count as implicit. White \
            places are ties, and two of the methods are named. Each place \
            names the method with the least modelled time for an error of the trajectory. A row is \
            a damping and an error, a column a stiffness over mass, from soft to stiff. \
            \u{201c}noise\u{201d}: a start that differs by 1 µm moves the end by more than half of \
            that error. Runs that gain energy, hardly move or take steps of more than 1/24 s do not rank. Hanging sheet, T = 0.25 \
            s.",
        draw: Draw::Matrix(map),
    },
    Plate {
        file: "trajectory-noise.svg",
        title: "How far one micrometre at the start moves the end",
        caption: "Above the dashed line an error of 1 % means nothing: two starts that differ by 1 \
            µm out of the sheet end further apart than half of it. Upwards: mean distance of \
            eight perturbed motions from the unperturbed one after 0.25 s, over the motion. \
            Across: stiffness over mass. Each curve is one damping.",
        draw: Draw::Sheet(noise),
    },
    Plate {
        file: "trajectory-front.svg",
        title: "What a small error of the trajectory costs, without damping and with much",
        caption: "With damping, implicit methods move to the left and explicit ones to the right: \
            left and below is better. Error of the positions after 0.25 s over the motion, \
            against modelled time. Grey: below the noise, where nothing ranks. A curve is one \
            method from coarse to fine; the black front is the best of all forms of all methods. \
            Hollow: the run gains energy or hardly moves, so it is not on the front. Steps of more \
            than 1/24 s are left out. Left: no damping; right: the stiffest mode is damped critically.",
        draw: Draw::Sheet(front),
    },
    Plate {
        file: "trajectory-errors.svg",
        title: "Four errors of the same runs, and the motion that they keep",
        caption: "A method that is good by one measure may be poor by another: compare a curve's \
                  place from panel to panel. Trajectory at the end; shape, strain and energy \
            beyond the true ones; and the path of the middle of the free edge over the true path. \
            Each against modelled time, on the hanging sheet with k/m = 10⁶ s⁻² and d/m = 10 s⁻¹. \
            Grey: below the noise. Hollow: the run gains energy or hardly moves.",
        draw: Draw::Sheet(errors),
    },
];

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    vec![kinds(input), leaders(input), cheapest_runs(input), others(input), scenes(input)]
}

/// Names of the dampings in the order of the record.
fn dampings(input: &Input) -> Vec<&str> {
    crate::studies::names::labels(input.facts.scenes.iter().map(|scene| scene.damping.as_str()))
}

fn scene_at<'a>(input: &'a Input, damping: &str, stiffness: f64) -> Option<&'a Scene> {
    let is_it = |s: &&Scene| s.damping == damping && s.stiffness_over_mass_per_s2 == stiffness;
    input.facts.scenes.iter().find(is_it)
}

fn stiffnesses(input: &Input) -> Vec<f64> {
    values(input.facts.scenes.iter().map(|scene| scene.stiffness_over_mass_per_s2))
}

fn quotient(stiffness: f64) -> String {
    format!("k/m = {} s⁻²", power(stiffness))
}

/// A damping with its unit.
fn with_unit(damping: &str) -> String {
    let has_unit = damping.starts_with("d/m") && !damping.ends_with("= 0");
    if has_unit { format!("{damping} s⁻¹") } else { damping.to_owned() }
}

fn map(input: &Input) -> Option<Matrix> {
    let stiffnesses = stiffnesses(input);
    let mut rows = Vec::new();
    for damping in dampings(input) {
        for (n, level) in LEVELS.into_iter().enumerate() {
            let place = |stiffness: &f64| {
                let tile = match scene_at(input, damping, *stiffness) {
                    Some(scene) if !scene.ranks(level) => told(Shade::Idle, "noise"),
                    Some(scene) if scene.is_damped() => tile(winner(&input.facts, scene, level)),
                    Some(scene) => guessed(tile(winner(&input.facts, scene, level))),
                    None => told(Shade::Idle, ""),
                };
                vec![tile]
            };
            rows.push(Line {
                label: format!("{}, {}", with_unit(damping), percent(level, 1)),
                is_first: n == 0,
                tiles: stiffnesses.iter().map(place).collect(),
            });
        }
    }
    let notes = vec![
        signs_of_winners("below twice the time"),
        turns(input),
        "d/m: damping over mass; ζ: damping ratio of the stiffest mode. Grey names are guesses: all \
         timed runs are damped."
            .to_owned(),
    ];
    let legend = legend_of_winners("no run gets there, or noise");
    (!rows.is_empty()).then(|| Matrix {
        columns: stiffnesses.iter().map(|k| quotient(*k)).collect(),
        rows,
        legend,
        notes,
    })
}

/// A winner whose modelled time is a guess.
fn guessed(tile: Tile) -> Tile {
    Tile { shade: Shade::Idle, ..tile }
}

/// In how many rows of damped sheets explicit methods lead on soft sheets and implicit ones on stiff
/// sheets.
fn turns(input: &Input) -> String {
    let (mut all, mut turning) = (0, 0);
    let is_damped = |damping: &&str| {
        let mut own = input.facts.scenes.iter().filter(|scene| scene.damping == **damping);
        own.all(Scene::is_damped)
    };
    for damping in dampings(input).into_iter().filter(is_damped) {
        for level in LEVELS {
            let scenes = stiffnesses(input).into_iter().filter_map(|k| scene_at(input, damping, k));
            let kinds = scenes.filter_map(|scene| winner(&input.facts, scene, level)?.kind());
            let kinds: Vec<_> = kinds.collect();
            let explicit = kinds.iter().position(|kind| *kind == Kind::Explicit);
            let implicit = kinds.iter().rposition(|kind| *kind == Kind::Implicit);
            all += 1;
            let turn = explicit.zip(implicit);
            turning += usize::from(turn.is_some_and(|(explicit, implicit)| explicit < implicit));
        }
    }
    format!(
        "In {turning} of {all} rows with damping explicit methods lead on the softest sheets and implicit ones on \
         the stiffest, a tie among methods of one kind included."
    )
}

fn noise(input: &Input) -> Option<Sheet> {
    let point = |scene: &Scene| Point {
        x: scene.stiffness_over_mass_per_s2,
        y: scene.floor,
        state: State::Stable,
    };
    let curve = |(n, damping): (usize, &str)| {
        let own = input.facts.scenes.iter().filter(|scene| scene.damping == damping);
        Series::new(with_unit(damping), Look::number(n), own.map(point).collect())
    };
    let series = dampings(input).into_iter().enumerate().filter_map(curve).collect();
    let half = 0.5 * LEVELS[1];
    let rule = Rule { label: "half of 1 %".to_owned(), at: At::Y(half) };
    panels_of(
        vec![(vec!["Hanging sheet, T = 0.25 s".to_owned()], series, vec![rule])],
        |xs| Axis::log("stiffness over mass k/m (s⁻²)", xs),
        |ys| Axis::log("noise over motion (dimensionless)", &[ys, &[half]].concat()),
    )
}

/// Rows of the headline's methods with a look each.
fn named<'a>(input: &'a Input, scene: &'a Scene) -> Vec<(&'a Row, Look)> {
    let own = input.facts.rows.iter().filter(|row| row.scene == scene.id && row.is_headline);
    let rows: Vec<_> = own.collect();
    let methods: Vec<_> = rows.iter().map(|row| row.method.as_str()).collect();
    rows.into_iter().zip(looks(&methods)).collect()
}

/// The runs of a row that a figure shows: those with a state for each picture.
fn drawn(row: &Row) -> impl Iterator<Item = &Run> {
    row.runs.iter().filter(|run| !run.skips_pictures())
}

/// A run in a figure of modelled time.
fn point(run: &Run, y: f64) -> Point {
    Point { x: run.modelled_s, y, state: mark(run) }
}

/// The Pareto front of time and error. It ends at the noise.
fn front_of(input: &Input, scene: &Scene) -> Option<Series> {
    let on_it = runs(&input.facts, scene).filter(|(_, run)| run.is_on_front);
    let mut points: Vec<_> = on_it.filter_map(|(_, run)| Some(point(run, run.error?))).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    Some(curve("Pareto front of all methods", FRONT, points)?.behind())
}

/// The figure of fronts: the first and the last damping, with the stiffnesses from the second on.
fn front(input: &Input) -> Option<Sheet> {
    let dampings = dampings(input);
    let ends = [*dampings.first()?, *dampings.last()?];
    let stiffnesses = stiffnesses(input);
    let first = usize::from(stiffnesses.len() > 1);
    let mut drafts: Vec<Draft> = Vec::new();
    let mut floors = Vec::new();
    for stiffness in &stiffnesses[first..] {
        for damping in ends.iter().take(dampings.len().min(2)) {
            let Some(scene) = scene_at(input, damping, *stiffness) else { continue };
            let curves = named(input, scene).into_iter().filter_map(|(row, look)| {
                let point = |run: &Run| Some(point(run, run.error?));
                curve(&row.label, look, drawn(row).filter_map(point).collect())
            });
            let series = front_of(input, scene).into_iter().chain(curves).collect();
            let title = format!("{}, {}", quotient(*stiffness), with_unit(damping));
            floors.push(0.7 * scene.floor);
            let noise = Rule { label: "noise".to_owned(), at: At::Below(scene.floor) };
            drafts.push((vec![title], series, vec![noise]));
        }
    }
    // A band far below all curves would compress them.
    let least = 0.3 * LEVELS[2];
    floors.retain(|floor| *floor > least);
    panels_of(
        drafts,
        |xs| Axis::log(MODELLED, xs),
        |ys| Axis::log("error of the trajectory over motion", &[ys, floors.as_slice()].concat()),
    )
}

/// The quantity in a panel of the figure of errors.
struct Measure {
    title: &'static str,
    axis: &'static str,
    of: fn(&Run, &Beside) -> f64,
    /// The noise, in the same unit.
    floor: fn(&Scene) -> f64,
}

const MEASURES: [Measure; 4] = [
    Measure {
        title: "Trajectory",
        axis: "error over motion",
        of: |run, _| run.error.unwrap_or(0.0),
        floor: |scene| scene.floor,
    },
    Measure {
        title: "Shape",
        axis: "distance of surfaces (mm)",
        of: |_, beside| 1e3 * beside.shape_m,
        floor: |scene| 1e3 * scene.shape_floor_m,
    },
    Measure {
        title: "Stretch",
        axis: "|strain beyond| (%)",
        of: |_, beside| 100.0 * beside.strain.abs(),
        floor: |scene| 100.0 * scene.strain_floor,
    },
    Measure {
        title: "Energy",
        axis: "|energy beyond| (% of what is set free)",
        of: |_, beside| 100.0 * beside.energy.abs(),
        floor: |scene| 100.0 * scene.energy_floor,
    },
];

/// The scene of the figure of errors. If the record lacks it, the first scene.
fn shown(input: &Input) -> Option<&Scene> {
    scene_at(input, "d/m = 10", 1e6).or(input.facts.scenes.first())
}

fn errors(input: &Input) -> Option<Sheet> {
    let scene = shown(input)?;
    let rows = named(input, scene);
    let all = rows.iter().flat_map(|(row, _)| drawn(row)).filter(|run| run.beside.is_some());
    let xs: Vec<f64> = all.map(|run| run.modelled_s).collect();
    let curves = |of: &dyn Fn(&Run, &Beside) -> f64| -> Vec<Series> {
        let of_row = |(row, look): &(&Row, Look)| {
            let point = |run: &Run| Some(point(run, of(run, run.beside.as_ref()?)));
            let points = drawn(row).filter_map(point).filter(|point| point.y > 0.0);
            curve(&row.label, *look, points.collect())
        };
        rows.iter().filter_map(of_row).collect()
    };
    let ys = |series: &[Series]| -> Vec<f64> {
        series.iter().flat_map(|series| &series.points).map(|point| point.y).collect()
    };
    let mut panels: Vec<Panel> = MEASURES
        .iter()
        .map(|measure| {
            let series = curves(&measure.of);
            let floor = (measure.floor)(scene);
            let mut values = ys(&series);
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            values.extend((floor > least).then_some(floor));
            let rules = vec![Rule { label: "noise".to_owned(), at: At::Below(floor) }];
            let title = vec![measure.title.to_owned()];
            let axes = (Axis::log(MODELLED, &xs), Axis::log(measure.axis, &values));
            Panel { series, rules, ..Panel::new(title, axes.0, axes.1) }
        })
        .collect();
    let series = curves(&|_, beside| beside.retained);
    let axis = Axis::linear("motion kept R", &[ys(&series), vec![0.0, 1.0]].concat());
    let rules = vec![Rule { label: "the true motion".to_owned(), at: At::Y(1.0) }];
    let title = vec!["Motion kept".to_owned()];
    panels.push(Panel { series, rules, ..Panel::new(title, Axis::log(MODELLED, &xs), axis) });
    (!xs.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// The table of how many damped sheets each kind of methods leads.
fn kinds(input: &Input) -> Table {
    let facts = &input.facts;
    let line = |level: f64| {
        let leads = tally(counted(facts, level).filter_map(Winner::kind));
        let missed = counted(facts, level).filter(|winner| winner.label.is_none()).count();
        let damped = facts.scenes.iter().filter(|scene| scene.is_damped());
        let noisy = damped.filter(|scene| !scene.ranks(level)).count();
        let counts = leads.into_iter().chain([missed, noisy]).map(|count| count.to_string());
        std::iter::once(format!("≤ {}", percent(level, 1))).chain(counts).collect()
    };
    Table {
        title: "**Who leads by a factor of 2**: the number of damped sheets for each error."
            .to_owned(),
        header: texts(&["error", "explicit", "implicit", "tie", "not reached", "noise"]),
        names: 1,
        rows: LEVELS.into_iter().map(line).collect(),
    }
}

/// The table of how often methods are the cheapest or tie.
fn leaders(input: &Input) -> Table {
    let facts = &input.facts;
    let counts = LEVELS.map(|level| frequent(facts, level));
    let ranked = |level: f64| counted(facts, level).filter(|w| w.label.is_some()).count();
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in counts.iter().rev().flatten() {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let line = |name: &&str| {
        let count = |counts: &Vec<(&str, usize)>| {
            let own = counts.iter().find(|(other, _)| other == name);
            own.map_or_else(absent, |(_, count)| count.to_string())
        };
        std::iter::once((*name).to_owned()).chain(counts.iter().map(count)).collect()
    };
    let heading =
        LEVELS.map(|level| format!("error ≤ {}, of {}", percent(level, 1), ranked(level)));
    Table {
        title: "**Who is the cheapest or ties**: on how many damped sheets a method has the least \
                modelled time for an error, or less than twice that."
            .to_owned(),
        header: std::iter::once("method".to_owned()).chain(heading).collect(),
        names: 1,
        rows: names.iter().map(line).collect(),
    }
}

/// The table of winners with their leads.
fn cheapest_runs(input: &Input) -> Table {
    let place = |scene: &Scene, level: f64| {
        if !scene.ranks(level) {
            return "noise".to_owned();
        }
        told_winner(winner(&input.facts, scene, level))
    };
    let line = |scene: &Scene| {
        let places = LEVELS.map(|level| place(scene, level));
        std::iter::once(scene.id.clone()).chain(places).collect()
    };
    let heading = LEVELS.map(|level| format!("error ≤ {}", percent(level, 1)));
    Table {
        title: "**Cheapest by modelled time**: the form with the least time for an error of the \
                trajectory, its energy at the end beyond the true one, its motion kept (R), and \
                the next other method with its time over that. Below a factor of 2 it is a tie. \
                –: no run within the budget reaches this error."
            .to_owned(),
        header: std::iter::once("sheet".to_owned()).chain(heading).collect(),
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}

/// The table of the other errors, for the cheapest run of the leading and of other methods at 1 %.
fn others(input: &Input) -> Table {
    let level = LEVELS[1];
    let mut rows = Vec::new();
    for scene in input.facts.scenes.iter().filter(|scene| scene.ranks(level)) {
        let good = |run: &Run| run.is_good(level);
        let Some((best, _)) = cheapest(runs(&input.facts, scene), good) else { continue };
        let is_other = |(row, _): &(&Row, &Run)| id(&row.label) != id(&best.label);
        let next = cheapest(runs(&input.facts, scene).filter(is_other), good);
        for (row, run) in cheapest(runs(&input.facts, scene), good).into_iter().chain(next) {
            let Some(beside) = run.beside else { continue };
            let ratio = if scene.dissipated > level {
                significant(-beside.energy / scene.dissipated, 2)
            } else {
                absent()
            };
            rows.push(vec![
                scene.id.clone(),
                row.label.clone(),
                format!("{} = {}", row.knob, run.value),
                significant(1e3 * run.modelled_s, 2),
                significant(100.0 * run.error.unwrap_or(0.0), 2),
                significant(1e3 * beside.shape_m, 2),
                significant(100.0 * beside.strain, 2),
                significant(100.0 * beside.energy, 2),
                ratio,
                significant(beside.retained, 3),
            ]);
        }
    }
    let header = [
        "sheet",
        "form",
        "run",
        "modelled time (ms)",
        "trajectory (%)",
        "shape (mm)",
        "strain beyond (%)",
        "energy beyond (%)",
        "dissipation of the method over that of the cloth",
        "motion kept",
    ];
    Table {
        title:
            "**All errors of the cheapest runs** with an error of the trajectory of at most 1 %: \
                of the leading method and of the next. –: the cloth dissipates less than 1 %."
                .to_owned(),
        header: texts(&header),
        names: 2,
        rows,
    }
}

/// The table of scenes and their noise.
fn scenes(input: &Input) -> Table {
    let line = |scene: &Scene| {
        vec![
            scene.id.clone(),
            scene.particles.to_string(),
            significant(scene.damping_over_mass_per_s, 2),
            significant(scene.damping_ratio, 2),
            significant(scene.motion_m, 3),
            significant(100.0 * scene.dissipated, 2),
            significant(scene.reference_error, 2),
            significant(scene.floor, 2),
            significant(1e3 * scene.shape_floor_m, 2),
            significant(100.0 * scene.strain_floor, 2),
            significant(100.0 * scene.energy_floor, 2),
        ]
    };
    let header = [
        "sheet",
        "particles",
        "d/m (s⁻¹)",
        "ζ of the stiffest mode",
        "motion (m)",
        "energy lost by the true motion (%)",
        "error of the reference",
        "noise of the trajectory",
        "of the shape (mm)",
        "of the strain (%)",
        "of the energy (%)",
    ];
    Table {
        title: "**Sheets and noise.** Motion: root mean square of the distances that the \
                particles move in 0.25 s. Noise: the change at the end after a change of 1 µm at \
                the start, mean of eight."
            .to_owned(),
        header: texts(&header),
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}
