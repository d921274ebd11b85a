//! Figures and tables of the experiment `animation`.

use super::facts::{self, Facts, GOOD, HEAVY, Measure, Run, Scene, TIE, TimingRow};
use crate::families::{families, labels, looks};
use crate::studies::tiles::{self, fault, legend, legend_of_winners, signs_of_winners, told};
use drape_report::Verdict;
use drape_report::number::{significant, wrap};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Axis, Draft, Look, Matrix, Point, Row, Rule, Series, Shade, Sheet, State, Tile,
    panels_apart, panels_of,
};
use std::collections::BTreeSet;

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "animation-frames.svg",
        title: "What a frame of cloth costs, and how wrong its shape is",
        caption: FRAMES,
        draw: Draw::Dense(frames),
    },
    Plate {
        file: "animation-map.svg",
        title: "Which method has the cheapest frame",
        caption: MAP,
        draw: Draw::Stacked(map_of_uses),
    },
    Plate {
        file: "animation-front.svg",
        title: "What a frame costs, and how wrong it is",
        caption: FRONT,
        draw: Draw::Sheet(front),
    },
    Plate {
        file: "animation-cheapest.svg",
        title: "Milliseconds a frame that is good enough",
        caption: CHEAPEST,
        draw: Draw::Matrix(cheapest),
    },
];

/// The figures of the long study, in the page's order.
pub(super) const LONG_PLATES: &[Plate<Input>] = &[
    Plate {
        file: "animation-long-frames.svg",
        title: "Larger cloth or five seconds: what a frame costs, and how wrong its shape is",
        caption: LONG_FRAMES,
        draw: Draw::Sheet(long_frames),
    },
    Plate {
        file: "animation-long-map.svg",
        title: "Larger cloth or five seconds: which method has the cheapest frame",
        caption: MAP,
        draw: Draw::Stacked(map),
    },
    Plate {
        file: "animation-long-cheapest.svg",
        title: "Larger cloth or five seconds: milliseconds a frame that is good enough",
        caption: CHEAPEST,
        draw: Draw::Matrix(cheapest),
    },
];

const FRAMES: &str = "Choose the panel of your fabric and the error that you accept: the leftmost \
    curve there is the fastest. Each panel shows one fabric with one damping; the square cloths \
    hang from two corners. Light damping is 10⁻⁵ s times the stiffness, heavy damping 10⁻³ s times \
    the stiffness. Across: time a frame on one core. Upwards: the mean distance of the surfaces \
    over the span; less than 0.01 mm is drawn as 0.01 mm. A curve is a method: the best of its \
    forms, of its numbers of calls a frame, and of substeps in a call. A coloured method is the \
    fastest good one of some panel, or ties with it, or has in at least half of the panels a run \
    that no other run beats in time and error. At most twelve are coloured; all others are grey; \
    the map of winners names the fastest, whatever its colour. Grey area: below the noise, where \
    nothing is ranked. Dashed: good enough, 1 cm or twice the noise. Above a panel stand the \
    methods without a sound run, by the way in which their runs fail.";

const LONG_FRAMES: &str = "Each panel shows the cotton blend, hanging from two corners, on one \
    mesh for one time; its axes are its own. Across: time a frame on one core. Upwards: the mean \
    distance of the surfaces over the span. Runs that are off by more than ten times a good error \
    are left out, and so are methods with no other run. A curve is a method: the best of its \
    numbers of calls a frame, and of substeps in a call. Methods that lead, tie or are seldom \
    beaten are coloured, each as in all figures; the others are grey. Grey area: below the noise, \
    where nothing is ranked. Dashed: good enough, 1 cm or twice the noise. Above a panel stand the \
    methods without a sound run, by the way in which their runs fail.";

const MAP: &str = "Each place names the method with the least time a frame for an error, on one \
    core: blue places an explicit method, yellow places an implicit one, violet places one of \
    local solves. If a row changes its colour, the error that you accept decides between the \
    kinds. A row is a scene at 60 frames a second, or at the rate that it names. A column is an \
    error: of the shape where the cloth is held, of the particles at 0.3 s elsewhere, and none \
    after seconds in the wind. A run whose mean kinetic energy is off by more than a factor of 1.5 \
    is not ranked. White: methods tie, within a factor of 2 or if the error may be a tenth larger \
    or smaller; the place names two and counts the others. Grey: no run reaches the error, or the \
    noise is more than half of it.";

const FRONT: &str = "The line joins the runs that no other run beats in both time and error. Each \
    panel shows a scene; each marker is a stable run that keeps its kinetic energy within a factor \
    of 1.5, one form of a method with one number of calls and of substeps in a call. Across: time \
    a frame on one core. Upwards: the mean distance of the surfaces over the span where the cloth \
    is held, the distance of the particles at 0.3 s elsewhere. Dashed: good enough, 1 cm or twice \
    the noise, and the noise of the scene, below which nothing is ranked.";

const CHEAPEST: &str = "Marked runs are the cheapest of a scene or tie with it, within a factor of \
    2; the map counts methods, and also those that would tie if the error might be a tenth larger \
    or smaller. The number is the time of the cheapest good run of a form, on one core. A good run \
    gains no energy, keeps its motion, keeps its kinetic energy within a factor of 1.5, and is off \
    by at most 1 cm or twice the noise: by shape where the cloth is held, by the particles at 0.3 \
    s elsewhere. After seconds in the wind no distance ranks the runs. There, in place of the \
    distance, it must be near at 0.3 s and stretch by at most 1 % more.";

fn time(input: &Input, run: &Run) -> Option<f64> {
    let rows = &input.timings.as_ref()?.rows;
    rows.iter().find(|row| row.is_of(run)).map(|row| row.frame_s)
}

/// Sound runs of a scene that have a time and an error: the run, its time (s) and its error (m).
fn timed<'a>(input: &'a Input, scene: &'a Scene) -> Vec<(&'a Run, f64, f64)> {
    let own = input.facts.runs.iter().filter(|run| run.scene == scene.id && run.is_sound());
    own.filter_map(|run| Some((run, time(input, run)?, scene.error(run)?))).collect()
}

/// The Pareto front: the runs that no other run beats in both time and error, cheapest first.
fn best(mut runs: Vec<(&Run, f64, f64)>) -> Vec<(&Run, f64, f64)> {
    runs.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.2.total_cmp(&b.2)));
    let mut least = f64::INFINITY;
    runs.retain(|(_, _, error)| {
        let is_better = *error < least;
        least = least.min(*error);
        is_better
    });
    runs
}

/// The runs among these that keep their kinetic energy.
fn lively(mut runs: Vec<(&Run, f64, f64)>) -> Vec<(&Run, f64, f64)> {
    runs.retain(|(run, ..)| run.is_lively(1.0));
    runs
}

/// The measure that ranks the runs of a scene, in words.
fn measured(scene: &Scene) -> &'static str {
    match scene.measure {
        Measure::Shape => "distance of surfaces",
        Measure::Trajectory => "particles at 0.3 s",
        Measure::Kept => "nothing: energy and strain kept",
    }
}

/// The scenes that have runs. A long study may list scenes that were not run yet.
fn shown(input: &Input) -> impl Iterator<Item = &Scene> {
    let has_runs = |scene: &&Scene| input.facts.runs.iter().any(|run| run.scene == scene.id);
    input.facts.scenes.iter().filter(has_runs)
}

/// The scenes of the one figure: cloth that hangs by its corners. A mesh coarser than the finest
/// one with all forms is left out.
fn hanging(input: &Input) -> Vec<&Scene> {
    let hanging = || shown(input).filter(|scene| scene.id.starts_with("hanging"));
    let full = hanging().filter(|scene| scene.has_all_forms);
    let least = full.map(|scene| scene.particles).max().unwrap_or(0);
    hanging().filter(|scene| scene.particles >= least).collect()
}

/// The title of a panel of the one figure.
fn panel(scene: &Scene) -> Vec<String> {
    let cloth = if scene.has_all_forms {
        format!("k/m = {} s⁻²", significant(scene.stiffness_over_mass_per_s2, 2))
    } else {
        format!("{} particles", scene.particles)
    };
    let span = format!("{cloth}, {} s", significant(scene.span_s, 1));
    vec![format!("{}, {} damping", scene.fabric, scene.damping()), span]
}

/// Largest number of methods that the one figure names.
const NAMED: usize = 12;

/// The methods that stand on the fronts of at least half of the scenes, or have the fastest good run
/// of some scene or tie with it; at most [`NAMED`] of them. Errors below the noise count as equal to
/// it, and errors too large for the map are left out.
fn named<'a>(input: &'a Input, scenes: &[&'a Scene]) -> Vec<&'a str> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    let mut leads: BTreeSet<&str> = BTreeSet::new();
    for scene in scenes {
        leads.extend(leaders(input, scene, scene.good_m()).iter().map(|(run, _)| run.id()));
    }
    counts.extend(leads.iter().map(|method| (*method, 0)));
    for scene in scenes {
        let most = MOST.max(scene.good_m());
        let useful = timed(input, scene).into_iter().filter(|(.., error)| *error <= most);
        let floored = useful.map(|(run, time, error)| (run, time, error.max(scene.floor_m())));
        let front = best(lively(floored.collect()));
        let mut seen: Vec<&str> = front.iter().map(|(run, ..)| run.id()).collect();
        seen.sort_unstable();
        seen.dedup();
        for method in seen {
            match counts.iter_mut().find(|(known, _)| *known == method) {
                Some((_, count)) => *count += 1,
                None => counts.push((method, 1)),
            }
        }
    }
    counts.retain(|(method, count)| 2 * count >= scenes.len() || leads.contains(method));
    counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    counts.into_iter().take(NAMED).map(|(method, _)| method).collect()
}

/// All methods, in the order of the runs.
fn methods<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<&'a str> {
    let mut methods: Vec<&str> = Vec::new();
    for run in runs {
        if !methods.contains(&run.id()) {
            methods.push(run.id());
        }
    }
    methods
}

/// Methods without a sound run on a scene, once for each way in which their runs fail, with its
/// sign.
fn without_curve<'a>(input: &'a Input, scene: &Scene) -> Vec<(String, &'a str)> {
    let own = || input.facts.runs.iter().filter(|run| run.scene == scene.id);
    let faults_of = |method: &'a str| {
        let its = || own().filter(move |run| run.id() == method).map(|run| run.verdict);
        let is_sound = its().any(|verdict| verdict == Verdict::Stable);
        let signs: BTreeSet<String> = its().map(|verdict| fault(&[verdict]).text).collect();
        signs.into_iter().filter(move |_| !is_sound).map(move |sign| (sign, method))
    };
    methods(own()).into_iter().flat_map(faults_of).collect()
}

/// Names behind their signs, one line for each sign.
fn by_sign(faults: &[(String, &str)]) -> Vec<String> {
    let signs = ["L", "✗", ">", "–"].into_iter();
    let line = |sign: &str| {
        let own = faults.iter().filter(|(other, _)| other == sign);
        let names: Vec<&str> = own.map(|(_, method)| *method).collect();
        (!names.is_empty()).then(|| format!("{sign} {}", names.join(", ")))
    };
    signs.filter_map(line).collect()
}

/// Number of characters that fit in a line above a panel of the one figure.
const LETTERS: usize = 35;
/// Smaller errors are drawn as this one in the one figure, m.
const LEAST_SHOWN: f64 = 1e-5;

fn frames(input: &Input) -> Option<Sheet> {
    frames_within(input, None)
}

/// Errors over this times a good one do not stand on the figure of the long study.
const FAR: f64 = 10.0;

fn long_frames(input: &Input) -> Option<Sheet> {
    frames_within(input, Some(FAR))
}

/// The one figure. With `far`, panels have axes of their own and no errors over `far` times a good one.
fn frames_within(input: &Input, far: Option<f64>) -> Option<Sheet> {
    input.timings.as_ref()?;
    let mut scenes = hanging(input);
    scenes.retain(|scene| !timed(input, scene).is_empty());
    let named = named(input, &scenes);
    let others = methods(input.facts.runs.iter().filter(|run| !named.contains(&run.id())));
    let looks = looks(&named);
    let draft = |scene: &&Scene| -> Draft {
        let mut runs = timed(input, scene);
        runs.retain(|(.., error)| far.is_none_or(|far| *error <= far * scene.good_m()));
        let point = |(_, time, error): &(&Run, f64, f64)| Point {
            x: 1e3 * time,
            y: 1e3 * error.max(LEAST_SHOWN),
            state: State::Stable,
        };
        let points = |method: &str| {
            let own = runs.iter().filter(|(run, ..)| run.id() == method).copied().collect();
            best(own).iter().map(point).collect()
        };
        let behind = others.iter().filter_map(|method| {
            Some(Series::path("any other method".to_owned(), Look::GREY, points(method))?.behind())
        });
        let curves = named.iter().zip(&looks);
        let curves = curves
            .filter_map(|(method, look)| Series::path((*method).to_owned(), *look, points(method)));
        let series = behind.chain(curves).collect();
        let noise = (1e3 * scene.floor_m()).max(1e-3);
        let rules = vec![
            Rule { label: "noise".to_owned(), at: At::Below(noise) },
            Rule { label: "good enough".to_owned(), at: At::Y(1e3 * scene.good_m()) },
        ];
        (panel(scene), series, rules)
    };
    let drafts = scenes.iter().map(draft).collect();
    let x = |xs: &[f64]| Axis::log("ms a frame", xs);
    let y = |ys: &[f64]| Axis::log("error of shape (mm)", &[ys, &[1e3 * GOOD]].concat());
    let sheet = if far.is_some() { panels_apart(drafts, x, y) } else { panels_of(drafts, x, y) };
    let mut sheet = sheet?;
    let faults: Vec<_> = scenes.iter().map(|scene| without_curve(input, scene)).collect();
    // Where not all methods were run, a fault may be missing.
    let is_whole = |scene: &Scene| input.facts.not_run(scene) == 0;
    let whole = faults.iter().zip(&scenes).filter(|(_, scene)| is_whole(scene));
    let whole: Vec<_> = whole.map(|(own, _)| own).collect();
    let is_everywhere =
        |fault: &(String, &str)| !whole.is_empty() && whole.iter().all(|own| own.contains(fault));
    for (panel, own) in sheet.panels.iter_mut().zip(&faults) {
        let own: Vec<_> = own.iter().filter(|fault| !is_everywhere(fault)).cloned().collect();
        panel.above = by_sign(&own).iter().flat_map(|line| wrap(line, LETTERS)).collect();
    }
    let common = whole.first().copied().into_iter().flatten().filter(|fault| is_everywhere(fault));
    let common = by_sign(&common.cloned().collect::<Vec<_>>());
    if faults.iter().any(|own| !own.is_empty()) {
        let signs = "L stand still, ✗ gain energy, > exceed the budget of work, – are refused.";
        sheet.notes.push(format!(
            "Above a panel, methods without a sound run, with each way in which runs fail: {signs}"
        ));
    }
    if !common.is_empty() {
        let are_whole = scenes.iter().all(|scene| is_whole(scene));
        let run = if are_whole { "" } else { " in which they were run" };
        sheet.notes.push(format!("In every panel{run}: {}.", common.join("; ")));
    }
    sheet.notes.extend(scenes.iter().filter_map(|scene| partly_run(input, scene)));
    sheet.notes.extend(dampings(&scenes));
    sheet.notes.extend(input.machine());
    Some(sheet)
}

/// What light and heavy damping mean, of the scenes shown.
fn dampings(scenes: &[&Scene]) -> Option<String> {
    let of = |is_heavy: bool| {
        let mut own = scenes.iter().map(|scene| scene.damping_over_stiffness_s);
        own.find(|damping| (*damping >= HEAVY) == is_heavy)
    };
    let told = [("Light", of(false)), ("Heavy", of(true))];
    let told = told.into_iter().filter_map(|(name, damping)| {
        Some(format!("{name} damping: {:e} s times the stiffness of a spring.", damping?))
    });
    let told: Vec<_> = told.collect();
    (!told.is_empty()).then(|| told.join(" "))
}

/// The largest error of the map, m.
const MOST: f64 = 0.03;
/// Largest errors of the columns of the map.
const LEVELS: [Level; 4] = [Level::At(MOST), Level::Good, Level::At(0.003), Level::At(0.001)];

/// The largest error of a column.
#[derive(Clone, Copy)]
enum Level {
    /// The same in every scene, m.
    At(f64),
    /// The scene's own bound on a good error, which noise may raise.
    Good,
}

impl Level {
    fn of(self, scene: &Scene) -> f64 {
        match self {
            Self::At(error) => error,
            Self::Good => scene.good_m(),
        }
    }

    fn name(self) -> String {
        match self {
            Self::At(error) => format!("{} mm", 1e3 * error),
            Self::Good => format!("{} mm, good", 1e3 * GOOD),
        }
    }
}

/// The fastest lively run of each method with an error of at most `level` (m), fastest first, where
/// `share` times as much is accepted.
fn fastest<'a>(input: &'a Input, scene: &'a Scene, level: f64, share: f64) -> Vec<(&'a Run, f64)> {
    let good = |run: &Run, error: f64| error <= share * level && run.is_lively(share);
    let good = timed(input, scene).into_iter().filter(|(run, _, error)| good(run, *error));
    facts::fastest_of_each(good.map(|(run, time, _)| (run, time)))
}

/// The fastest run with an error of at most `level` (m), and those that tie with it. Empty if the
/// noise exceeds half of `level`.
fn leaders<'a>(input: &'a Input, scene: &'a Scene, level: f64) -> Vec<(&'a Run, f64)> {
    if 2.0 * scene.floor_m() > level {
        return Vec::new();
    }
    facts::leaders(|share| fastest(input, scene, level, share))
}

fn winner(input: &Input, scene: &Scene, level: f64) -> Tile {
    if scene.measure == Measure::Kept {
        return told(Shade::Idle, "not ranked");
    }
    let leaders = leaders(input, scene, level);
    let [(first, least), ties @ ..] = &leaders[..] else { return told(Shade::Idle, "") };
    let ties: Vec<&str> = ties.iter().map(|(run, _)| run.id()).collect();
    let next = fastest(input, scene, level, 1.0).get(1).map(|(_, next)| next / least);
    tiles::winner(first.id(), first.is_limited, &ties, next)
}

/// The map, with a note about energy. Runs of the long study have time to gain it.
fn map_of_uses(input: &Input) -> Option<Matrix> {
    let uses = "Most scenes last 0.3 to 0.6 s. Over 5 s some of these runs gain energy: the map of \
                animation-long.";
    let mut map = map(input)?;
    map.notes.push(uses.to_owned());
    Some(map)
}

fn map(input: &Input) -> Option<Matrix> {
    input.timings.as_ref()?;
    let row = |scene: &Scene| Row {
        label: scene.id.clone(),
        is_first: false,
        tiles: LEVELS.iter().map(|level| vec![winner(input, scene, level.of(scene))]).collect(),
    };
    Some(Matrix {
        columns: LEVELS.iter().map(|level| level.name()).collect(),
        rows: shown(input).map(row).collect(),
        legend: legend_of_winners(match input.facts.missing.is_empty() {
            true => "not reached, or noise",
            false => "not reached, not timed, or noise",
        }),
        notes: vec![
            signs_of_winners("within a factor of 2 or a tenth of what is accepted"),
            "Good: off by 10 mm, or by twice the noise where that is more.".to_owned(),
        ]
        .into_iter()
        .chain(shown(input).filter_map(raised))
        .chain(shown(input).filter_map(|scene| partly_run(input, scene)))
        .chain(input.machine())
        .collect(),
    })
}

/// The good error of a scene, where noise raises it.
fn raised(scene: &Scene) -> Option<String> {
    let is_raised = scene.measure != Measure::Kept && scene.good_m() > GOOD;
    is_raised.then(|| {
        format!(
            "In the row \u{201c}{}\u{201d} good means {} mm.",
            scene.id,
            millimetres(scene.good_m())
        )
    })
}

fn front(input: &Input) -> Option<Sheet> {
    let draft = |scene: &Scene| -> Draft {
        let runs = lively(timed(input, scene));
        let point = |(_, time, error): &(&Run, f64, f64)| Point {
            x: 1e3 * time,
            y: 1e3 * error.max(1e-6),
            state: State::Stable,
        };
        let all = input.facts.runs.iter().map(|run| (run.method.as_str(), run.label.as_str()));
        let own = families(all).into_iter().enumerate().filter_map(|(n, family)| {
            let is_its = |run: &Run| family.members.iter().any(|(label, _)| *label == run.label);
            let points = runs.iter().filter(|(run, ..)| is_its(run)).map(point);
            let look = Look::of_family(n, n / 7);
            Some(Series::new(family.title.to_owned(), look, points.collect())?.apart())
        });
        let mut series: Vec<Series> = own.collect();
        let line = best(runs).iter().map(point).collect();
        series.extend(Series::path("the front".to_owned(), Look::number(0), line));
        let floor = 1e3 * scene.floor_m();
        let rules = vec![
            Rule { label: "good enough".to_owned(), at: At::Y(1e3 * scene.good_m()) },
            Rule { label: "noise".to_owned(), at: At::Y(floor.max(1e-3)) },
        ];
        (vec![scene.id.clone(), measured(scene).to_owned()], series, rules)
    };
    let mut sheet = panels_of(
        shown(input).map(draft).collect(),
        |xs| Axis::log("ms a frame", xs),
        |ys| {
            let floors = shown(input).map(|scene| 1e3 * scene.floor_m().max(1e-6));
            let ys: Vec<f64> = ys.iter().copied().chain(floors).collect();
            Axis::log("error (mm)", &ys)
        },
    )?;
    sheet.notes.push(input.machine()?);
    Some(sheet)
}

/// The cheapest good run of a form on a scene.
fn cheapest_of<'a>(input: &'a Input, scene: &'a Scene, label: &str) -> Option<(&'a Run, f64)> {
    let own = input.facts.runs.iter().filter(|run| run.scene == scene.id && run.label == label);
    let good = own.filter(|run| run.is_good(scene));
    let timed = good.filter_map(|run| Some((run, time(input, run)?)));
    timed.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn all_labels(input: &Input) -> Vec<String> {
    labels(input.facts.runs.iter().map(|run| (run.method.as_str(), run.label.as_str())))
}

/// The least time of a good run on a scene, s.
fn least(input: &Input, scene: &Scene) -> Option<f64> {
    let labels = all_labels(input);
    let times = labels.iter().filter_map(|label| Some(cheapest_of(input, scene, label)?.1));
    times.reduce(f64::min)
}

/// The text of a form whose good runs were not timed.
const UNTIMED: &str = "✓";

/// The cell of a form without a good run on a scene that was timed.
fn without(input: &Input, scene: &Scene, label: &str) -> Tile {
    let own = input.facts.runs.iter().filter(|run| run.scene == scene.id && run.label == label);
    if own.clone().any(|run| run.is_good(scene)) {
        return told(Shade::Open, UNTIMED);
    }
    fault(&own.map(|run| run.verdict).collect::<Vec<_>>())
}

fn cheapest(input: &Input) -> Option<Matrix> {
    input.timings.as_ref()?;
    let scenes: Vec<&Scene> = shown(input).collect();
    let tile = |scene: &Scene, label: &str| match cheapest_of(input, scene, label) {
        None => without(input, scene, label),
        Some((_, time)) => {
            let is_marked = least(input, scene).is_some_and(|least| time <= TIE * least);
            let shade = if is_marked { Shade::Good } else { Shade::Open };
            Tile { shade, text: significant(1e3 * time, 2), is_marked }
        }
    };
    let rows = all_labels(input)
        .iter()
        .map(|label| Row {
            label: label.clone(),
            is_first: false,
            tiles: scenes.iter().map(|scene| vec![tile(scene, label)]).collect(),
        })
        .collect();
    let mut legend = legend("ms", &[("≠", "stable, but not good enough")]);
    if !input.facts.missing.is_empty() {
        legend.insert(2, (told(Shade::Open, UNTIMED), "good enough, but not timed".to_owned()));
    }
    Some(Matrix {
        columns: scenes.iter().map(|scene| scene.id.clone()).collect(),
        rows,
        legend,
        notes: shown(input)
            .filter_map(|scene| partly_run(input, scene))
            .chain(input.machine())
            .collect(),
    })
}

/// Says how many methods were run and timed on a scene, if not all of them.
fn partly_run(input: &Input, scene: &Scene) -> Option<String> {
    let own = input.facts.runs.iter().filter(|run| run.scene == scene.id);
    let run = own.map(|run| run.label.as_str()).collect::<BTreeSet<_>>().len();
    let not_run = input.facts.not_run(scene);
    let own = || input.facts.missing.iter().filter(|missing| missing.scene == scene.id);
    let dear = own().map(|missing| missing.over_budget.len()).sum::<usize>();
    let untimed = own().map(|missing| missing.not_timed.len()).sum::<usize>();
    let told = [
        (not_run, format!("{run} of {} methods were run", run + not_run)),
        (dear, format!("over budget in a shorter span: {dear}")),
        (untimed, format!("sound, but not timed: {untimed}")),
    ];
    let told: Vec<_> = told.into_iter().filter(|(number, _)| *number > 0).map(|(_, t)| t).collect();
    (!told.is_empty()).then(|| format!("{}: {}.", scene.id, told.join("; ")))
}

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let mut tables = vec![scenes(input)];
    tables.extend(shown(input).map(|scene| fronts(input, scene)));
    tables.push(errors(input));
    tables
}

fn millimetres(value: f64) -> String {
    significant(1e3 * value, 2)
}

/// The table of scenes.
fn scenes(input: &Input) -> Table {
    let line = |scene: &Scene| {
        vec![
            scene.id.clone(),
            measured(scene).to_owned(),
            significant(scene.stiffness_over_mass_per_s2, 2),
            significant(scene.theta, 2),
            scene.limit_substeps.to_string(),
            millimetres(scene.shape_floor_m),
            millimetres(scene.trajectory_floor_m),
            millimetres(scene.reference_error_m),
            significant(100.0 * scene.strain, 2),
        ]
    };
    let header = [
        "scene",
        "ranked by",
        "k/m (1/s²)",
        "h²k/m of a frame",
        "calls within the limit",
        "noise of the shape (mm)",
        "noise at 0.3 s (mm)",
        "error of the truth (mm)",
        "strain (%)",
    ];
    Table {
        title: "**Scenes**: fabrics with measured constants, equally stiff on every mesh."
            .to_owned(),
        header: texts(&header),
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}

/// The table of a scene's front.
fn fronts(input: &Input, scene: &Scene) -> Table {
    let some = |value: Option<f64>, text: fn(f64) -> String| value.map_or_else(absent, text);
    let (rows, what) = match scene.measure {
        Measure::Kept => {
            (good(input, scene), "the runs near at 0.3 s that keep kinetic energy and strain")
        }
        _ => {
            let best = best(lively(timed(input, scene))).into_iter();
            let rows = best.map(|(run, time, error)| (run, time, Some(error))).collect();
            (
                rows,
                "the runs that no other beats in time and error, of those that keep their kinetic energy",
            )
        }
    };
    let line = |(run, time, error): &(&Run, f64, Option<f64>)| {
        vec![
            run.label.clone(),
            run.calls(scene),
            significant(1e3 * time, 2),
            some(*error, millimetres),
            some(run.shape_error_m, millimetres),
            some(run.trajectory_error_m, millimetres),
            some(run.excess_strain, |strain| significant(100.0 * strain, 2)),
            some(run.retained, |share| significant(share, 3)),
            some(run.kinetic, |share| significant(share, 3)),
        ]
    };
    let header = [
        "form",
        "a frame",
        "ms a frame",
        "error that ranks (mm)",
        "shape (mm)",
        "trajectory at 0.3 s (mm)",
        "excess strain (%)",
        "motion kept",
        "kinetic energy kept",
    ];
    Table {
        title: format!("**{}**: {what}.", scene.id),
        header: texts(&header),
        names: 1,
        rows: rows.iter().map(line).collect(),
    }
}

/// Good runs of a scene whose runs no distance ranks, cheapest first.
fn good<'a>(input: &'a Input, scene: &Scene) -> Vec<(&'a Run, f64, Option<f64>)> {
    let own = input.facts.runs.iter().filter(|run| run.scene == scene.id && run.is_good(scene));
    let mut runs: Vec<_> = own.filter_map(|run| Some((run, time(input, run)?, None))).collect();
    runs.sort_by(|a, b| a.1.total_cmp(&b.1));
    runs
}

/// The table of errors by calls a frame, for every form.
fn errors(input: &Input) -> Table {
    let runs = &input.facts.runs;
    let cell = |scene: &Scene, label: &str| {
        let own = runs.iter().filter(|run| run.scene == scene.id && run.label == label);
        let told = own.map(|run| {
            let kept = |kinetic| format!("{} of its energy", significant(kinetic, 2));
            let value = match scene.measure {
                Measure::Kept => run.kinetic.map(kept),
                _ => scene.error(run).map(millimetres),
            };
            let value = value.filter(|_| run.is_sound());
            let value = value.unwrap_or_else(|| run.verdict.to_string());
            let inside = run.inside.map_or_else(String::new, |number| format!("×{number}"));
            format!("{}{inside}: {value}", run.substeps)
        });
        let told: Vec<_> = told.collect();
        if told.is_empty() { absent() } else { told.join("; ") }
    };
    let line = |label: &String| {
        let cells = shown(input).map(|scene| cell(scene, label));
        std::iter::once(label.clone()).chain(cells).collect()
    };
    let scenes = shown(input).map(|scene| scene.id.clone());
    Table {
        title: "**All runs**: calls a frame with the ranking error in mm, or the verdict. 2×20: 2 \
                calls of 20 substeps, sweeps or iterations, where the study varies these. If no \
                error ranks the runs: the share of the kinetic energy that is kept."
            .to_owned(),
        header: std::iter::once("form".to_owned()).chain(scenes).collect(),
        names: 1,
        rows: all_labels(input).iter().map(line).collect(),
    }
}
