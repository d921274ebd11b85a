//! Figures and tables of the experiment `rest`.

use super::facts::{Accepted, Facts, Minimum, Run, Scene, TIE, TimingRow};
use crate::families::{families, labels};
use crate::studies::tiles::{fault, legend};
use drape_report::number::significant;
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Axis, Draft, Look, Matrix, Point, Row, Rule, Series, Shade, Sheet, State, Tile, panels_of,
};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "rest-arrival.svg",
        title: "When the cloth has come to rest",
        caption: "First-order methods with long steps come to rest soonest, because they damp the \
            motion. Each panel is a scene. Across: length of a step. Upwards: simulated time \
            after which the surface stays within 1 mm of its rest shape. Only runs whose shape is \
            right; the dashed line is the time that a run has.",
        draw: Draw::Sheet(arrival),
    },
    Plate {
        file: "rest-cheapest.svg",
        title: "Computing time until the cloth rests",
        caption: "Marked runs are the cheapest of a scene or tie with it, within a factor of 3. \
            The number is the time on one core that the cheapest run of a form takes until its \
            surface stays within 1 mm of its rest shape, which must be a right one: the least \
            known, or one in which a true motion ends. Order and marks belong to the processor \
            that the note below the tiles names.",
        draw: Draw::Matrix(cheapest),
    },
];

fn time(input: &Input, run: &Run) -> Option<f64> {
    let rows = &input.timings.as_ref()?.rows;
    rows.iter().find(|row| row.is_of(run)).map(|row| row.seconds)
}

fn runs<'a>(input: &'a Input, scene: &'a Scene) -> impl Iterator<Item = &'a Run> + Clone {
    input.facts.runs.iter().filter(move |run| run.scene == scene.id)
}

fn arrival(input: &Input) -> Option<Sheet> {
    let draft = |scene: &Scene| -> Draft {
        let all = input.facts.runs.iter().map(|run| (run.method.as_str(), run.label.as_str()));
        let own = families(all).into_iter().enumerate().filter_map(|(n, family)| {
            let is_its = |run: &&Run| family.members.iter().any(|(label, _)| *label == run.label);
            let right = runs(input, scene).filter(is_its).filter(|run| run.is_right());
            let points = right.filter_map(|run| {
                let x = 100.0 / f64::from(run.steps);
                Some(Point { x, y: run.arrival_s?, state: State::Stable })
            });
            let look = Look::of_family(n, n / 7);
            Some(Series::new(family.title.to_owned(), look, points.collect())?.apart())
        });
        let rule = Rule { label: "time that a run has".to_owned(), at: At::Y(scene.span_s) };
        (vec![scene.id.clone()], own.collect(), vec![rule])
    };
    panels_of(
        input.facts.scenes.iter().map(draft).collect(),
        |xs| Axis::log("step (ms)", xs),
        |ys| {
            let spans = input.facts.scenes.iter().map(|scene| scene.span_s);
            let ys: Vec<f64> = ys.iter().copied().chain(spans).collect();
            Axis::log("at rest after (s)", &ys)
        },
    )
}

fn all_labels(input: &Input) -> Vec<String> {
    labels(input.facts.runs.iter().map(|run| (run.method.as_str(), run.label.as_str())))
}

/// The cheapest right run of a form on a scene, with its cost.
fn cheapest_of<'a>(input: &'a Input, scene: &'a Scene, label: &str) -> Option<(&'a Run, f64)> {
    let right = runs(input, scene).filter(|run| run.label == label && run.is_right());
    let timed = right.filter_map(|run| Some((run, time(input, run)?)));
    timed.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn cheapest(input: &Input) -> Option<Matrix> {
    let machine = input.machine()?;
    let (scenes, labels) = (&input.facts.scenes, all_labels(input));
    let least = |scene: &Scene| {
        let times = labels.iter().filter_map(|label| Some(cheapest_of(input, scene, label)?.1));
        times.fold(f64::INFINITY, f64::min)
    };
    let tile = |scene: &Scene, label: &str| {
        let Some((_, time)) = cheapest_of(input, scene, label) else {
            let own = runs(input, scene).filter(|run| run.label == label);
            return fault(&own.map(|run| run.verdict).collect::<Vec<_>>());
        };
        let is_marked = time <= TIE * least(scene);
        let shade = if is_marked { Shade::Good } else { Shade::Open };
        Tile { shade, text: significant(time, 2), is_marked }
    };
    let row = |label: &String| Row {
        label: label.clone(),
        is_first: false,
        tiles: scenes.iter().map(|scene| vec![tile(scene, label)]).collect(),
    };
    Some(Matrix {
        columns: scenes.iter().map(|scene| scene.id.clone()).collect(),
        rows: labels.iter().map(row).collect(),
        legend: legend(
            "s",
            &[("≠", "at rest in a shape that is not right"), ("~", "on its way at the end")],
        ),
        notes: vec![machine],
    })
}

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let mut tables = vec![scenes(input)];
    tables.extend(input.facts.scenes.iter().map(|scene| leaders(input, scene)));
    tables.push(endings(input));
    tables
}

fn scenes(input: &Input) -> Table {
    let line = |scene: &Scene| {
        let least = scene.minima.iter().map(|found| found.energy_j).fold(f64::INFINITY, f64::min);
        let told = |found: &Minimum| {
            let excess = 100.0 * (found.energy_j - least) / scene.released_j;
            let saddle = if found.is_minimum { "" } else { " (no minimum)" };
            format!("{}: {}{saddle}", found.from, significant(excess, 2))
        };
        let accepted = |found: &Accepted| {
            let excess = significant(100.0 * found.excess_energy, 2);
            format!("{excess}: {}", found.from.join(", "))
        };
        vec![
            scene.id.clone(),
            scene.particles.to_string(),
            scene.limit_steps.to_string(),
            significant(1e3 * scene.released_j, 3),
            scene.minima.iter().map(told).collect::<Vec<_>>().join("; "),
            scene.accepted.iter().map(accepted).collect::<Vec<_>>().join("; "),
        ]
    };
    Table {
        title: "**Scenes**: rest shapes by the start of the search, and their energy above the \
                least in % of the energy set free. The last column has the energies that count as \
                right, with the searches and true motions that reach them."
            .to_owned(),
        header: texts(&[
            "scene",
            "particles",
            "steps within the limit in 0.1 s",
            "energy set free (mJ)",
            "rest shapes",
            "right shapes",
        ]),
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}

/// The table of the best right run of the first ten forms: by measured time, or by the simulated
/// time of arrival if nothing was timed. Modelled times and counted work stand beside them, but they
/// do not rank.
fn leaders(input: &Input, scene: &Scene) -> Table {
    let cpu = input.timings.as_ref().map(|timings| &timings.provenance.cpu);
    let rank = |run: &Run| if cpu.is_some() { time(input, run) } else { run.arrival_s };
    let mut best: Vec<(&Run, f64)> = Vec::new();
    for run in runs(input, scene).filter(|run| run.is_right()) {
        let Some(cost) = rank(run) else { continue };
        match best.iter_mut().find(|(other, _)| other.label == run.label) {
            Some(known) if known.1 <= cost => {}
            Some(known) => *known = (run, cost),
            None => best.push((run, cost)),
        }
    }
    best.sort_by(|a, b| a.1.total_cmp(&b.1));
    let some = |value: Option<f64>| value.map_or_else(absent, |value| significant(value, 2));
    let line = |(run, _): &(&Run, f64)| {
        vec![
            run.label.clone(),
            run.steps.to_string(),
            some(run.arrival_s),
            some(time(input, run)),
            some(run.modelled_s),
            some(run.effort.map(|visits| 1e-6 * visits)),
            some(run.shape_error_m.map(|error| 1e3 * error)),
            some(run.excess_energy.map(|excess| 100.0 * excess)),
        ]
    };
    Table {
        title: match cpu {
            Some(cpu) => format!(
                "**{}**: the ten cheapest forms that come to rest in a right shape, by seconds on \
                 {cpu}.",
                scene.id
            ),
            None => {
                format!("**{}**: the ten forms that come to rest in a right shape first.", scene.id)
            }
        },
        header: texts(&[
            "form",
            "steps in 0.1 s",
            "arrives after (s)",
            "seconds",
            "modelled seconds",
            "visits (millions)",
            "last distance (mm)",
            "excess energy (%)",
        ]),
        names: 1,
        rows: best.iter().take(10).map(line).collect(),
    }
}

/// The table of arrivals: when each form arrives, or why it does not.
fn endings(input: &Input) -> Table {
    let cell = |scene: &Scene, label: &str| {
        let own = runs(input, scene).filter(|run| run.label == label);
        let told = own.map(|run| {
            let arrival = run.arrival_s.filter(|_| run.is_right());
            let value = arrival.map_or_else(
                || match run.arrival_s {
                    Some(_) if !run.is_right() => format!("{}, other shape", run.verdict),
                    _ => run.verdict.to_string(),
                },
                |time| format!("{} s", significant(time, 2)),
            );
            format!("{}: {value}", run.steps)
        });
        told.collect::<Vec<_>>().join("; ")
    };
    let line = |label: &String| {
        let cells = input.facts.scenes.iter().map(|scene| cell(scene, label));
        std::iter::once(label.clone()).chain(cells).collect()
    };
    let scenes = input.facts.scenes.iter().map(|scene| scene.id.clone());
    Table {
        title:
            "**All runs**: steps in 0.1 s, and the time at which the cloth has come to rest in a \
             right shape, or the verdict."
                .to_owned(),
        header: std::iter::once("form".to_owned()).chain(scenes).collect(),
        names: 1,
        rows: all_labels(input).iter().map(line).collect(),
    }
}
