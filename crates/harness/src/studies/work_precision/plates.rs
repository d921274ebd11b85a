//! Figures of the experiment `work-precision`.

use super::facts::{self, Facts, Row, Run, STIFFNESS, Scene, TimingRow, Winner};
use crate::families::{families, looks};
use crate::studies::tiles::{self, legend_of_winners, signs_of_winners, told};
use drape_report::Verdict;
use drape_report::family::Kin;
use drape_report::number::{median, percent, power, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Axis, Draft, Look, Matrix, Point, Row as Line, Rule, Series, Shade, Sheet, State, Tile,
    panels_of, values,
};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "work-precision.svg",
        title: "The fastest method for an error changes with the stiffness",
        caption: "At k/m = 10¹⁰ s⁻² implicit methods of second order are the first below an \
                  error of 10⁻²; on softer sheets small explicit steps or sweeps over lines are. \
                  Error of the positions after 0.25 s over the motion, against seconds; left and \
            below is better. A curve is one method from coarse to fine; the black front is the \
            best of all methods. Hollow: the run gains energy or hardly moves, so it is not on the \
            front. Grey: noise, where nothing ranks. Hanging sheet, d/m = 10 s⁻¹. Without timings \
            the axis is modelled time.",
        draw: Draw::Sheet(headline),
    },
    Plate {
        file: "work-precision-effort.svg",
        title: "Modelled time of every method, k/m = 10⁴ and 10⁶ s⁻²",
        caption: "The distance of a curve to the right of the black front shows how much more the \
            method costs than the best one. Error after 0.25 s over the motion, against modelled \
            time; hollow: the run gains energy or hardly moves. Hanging sheet with light damping, \
            d/m = 10 s⁻¹. A row for each kind of method, with the forms that run on all scenes; \
            the front is that of all forms.",
        draw: Draw::Sheet(soft),
    },
    Plate {
        file: "work-precision-stiff.svg",
        title: "Modelled time of every method, k/m = 10⁸ and 10¹⁰ s⁻²",
        caption: "IMEX Euler stays near an error of 1, because its sheet hardly moves at any step \
            that the budget allows. Error after 0.25 s over the motion, against modelled time; \
            the black line is the front of all methods. Hanging sheet, d/m = 10 s⁻¹; 10 × 10 \
            particles at k/m = 10¹⁰ s⁻².",
        draw: Draw::Sheet(stiff),
    },
    Plate {
        file: "work-precision-heavy.svg",
        title: "With heavy damping implicit methods lead from k/m = 10⁶ s⁻² on",
        caption: "Explicit methods hold the front for 1 % up to k/m = 10⁴ s⁻² and leave it above. \
                  Error after 0.25 s over the motion, against modelled time; the \
            black line is the front of all methods. Hanging sheet with d/m = √(k/m); the methods \
            of the first \
            figure.",
        draw: Draw::Sheet(heavy),
    },
    Plate {
        file: "work-precision-size.svg",
        title: "Up to 1600 particles explicit steps and sweeps over lines stay among the first",
        caption: "From 100 to 1600 particles symplectic Euler and XPBD by lines hold or share the \
            front for 1 %. Left: k/m = 10⁶ s⁻² and d/m = 10 s⁻¹ on every mesh, so the finer sheet \
            is a softer cloth. Right: the same cloth, so k/m and d/m grow with the number of \
            particles. Error after 0.25 s over the motion, against modelled time. Hanging sheet.",
        draw: Draw::Sheet(size),
    },
    Plate {
        file: "work-precision-map.svg",
        title: "Which method is the cheapest",
        caption: "Only a colour marks a lead by a factor of 2: blue is an explicit method, yellow \
            an implicit one, violet one of local solves, which the words count as implicit. White \
            places are ties, and two of the methods are named. Each place \
            names the method with the least modelled time for an error. A row is a scene, a \
            damping and an error, a column a stiffness over mass, from soft to stiff. Light \
            damping is d/m = 10 s⁻¹, heavy damping d/m = √(k/m). \u{201c}noise\u{201d}: a start \
            that differs by 1 µm moves the end by more than half of that error. Empty: not run, \
            or no run within the budget reaches the error.",
        draw: Draw::Matrix(map),
    },
];

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    vec![
        kinds(input),
        fastest(input),
        cheapest(input),
        excess(input),
        calibration(input),
        scenes(input),
    ]
}

/// The look of the Pareto front.
pub(in crate::studies) const FRONT: Look = Look::pair(4, 3);
const MAP_LEVELS: [f64; 3] = [1e-1, 1e-2, 1e-3];
const LEVELS: &str = "errors of 10 %, 1 % and 0.1 %";
pub(in crate::studies) const MODELLED: &str = "modelled time (s)";
/// The word for an error that is too small to rank.
const NOISE: &str = "noise";
const ERROR: &str = "error over motion (dimensionless)";

/// Scenes of one series over stiffness, softest first.
fn by_stiffness<'a>(input: &'a Input, name: &str, damping: &str) -> Vec<&'a Scene> {
    let scenes = input.facts.scenes.iter();
    let mut scenes: Vec<_> = scenes
        .filter(|s| s.scene == name && s.damping == damping && has_series(s, STIFFNESS))
        .collect();
    let quotient = |scene: &&Scene| scene.stiffness_over_mass_per_s2;
    scenes.sort_by(|a, b| quotient(a).total_cmp(&quotient(b)));
    scenes
}

fn has_series(scene: &Scene, name: &str) -> bool {
    scene.series.iter().any(|series| series == name)
}

fn rows_of<'a>(input: &'a Input, scene: &'a Scene) -> impl Iterator<Item = &'a Row> + Clone {
    input.facts.rows.iter().filter(move |row| row.scene == scene.id)
}

/// Measure of what a run costs.
#[derive(Clone, Copy, PartialEq)]
enum Cost {
    Modelled,
    Seconds,
}

/// Cost and error of a completed run. Seconds are given only for a verified run. A run that may not
/// win is marked.
fn point(input: &Input, row: &Row, run: &Run, cost: Cost) -> Option<Point> {
    let error = run.error.filter(|_| run.verdict == Verdict::Completed)?;
    let spent = match cost {
        Cost::Modelled => run.modelled_s,
        Cost::Seconds => {
            let rows = &input.timings.as_ref()?.rows;
            let is_same = |t: &&TimingRow| {
                t.scene == row.scene && t.label == row.label && t.value == run.value
            };
            // Timings may be older than the facts: those of another run do not count.
            let is_of = |t: &&TimingRow| t.is_verified && t.error.to_bits() == error.to_bits();
            rows.iter().find(is_same).filter(is_of)?.seconds
        }
    };
    Some(Point { x: spent, y: error, state: mark(run) })
}

/// The marker of a run: hollow if it may not win.
pub(in crate::studies) fn mark(run: &Run) -> State {
    if run.flaw.is_none() { State::Stable } else { State::Flawed }
}

fn points(input: &Input, row: &Row, cost: Cost) -> Vec<Point> {
    row.runs.iter().filter_map(|run| point(input, row, run, cost)).collect()
}

/// A curve from the coarsest run to the finest. Its cost need not rise.
pub(in crate::studies) fn curve(label: &str, look: Look, points: Vec<Point>) -> Option<Series> {
    Series::path(label.to_owned(), look, points)
}

/// The runs without a flaw that no other such run beats in both cost and error. Errors below the
/// noise count as equal to it.
fn front(input: &Input, scene: &Scene, cost: Cost) -> Option<Series> {
    let mut all: Vec<_> = rows_of(input, scene).flat_map(|row| points(input, row, cost)).collect();
    all.retain(|point| point.state == State::Stable);
    all.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut best = f64::INFINITY;
    all.retain(|point| {
        let error = point.y.max(scene.floor);
        let is_better = error < best;
        best = best.min(error);
        is_better
    });
    Some(curve("Pareto front of all methods", FRONT, all)?.behind())
}

/// Rows of the headline's methods with a look each.
fn headline_rows<'a>(input: &'a Input, scene: &'a Scene) -> impl Iterator<Item = (&'a Row, Look)> {
    let rows: Vec<_> = rows_of(input, scene).filter(|row| row.is_headline).collect();
    let methods: Vec<_> = rows.iter().map(|row| row.method.as_str()).collect();
    rows.into_iter().zip(looks(&methods))
}

/// A panel for one scene, with the front below the curves.
fn panel(input: &Input, scene: &Scene, title: String, cost: Cost) -> Draft {
    let curves = headline_rows(input, scene)
        .filter_map(|(row, look)| curve(&row.label, look, points(input, row, cost)));
    let series: Vec<_> = front(input, scene, cost).into_iter().chain(curves).collect();
    let rule = |level: &f64| Rule { label: LEVELS.to_owned(), at: At::Y(*level) };
    (vec![title], series, MAP_LEVELS.iter().map(rule).chain(noise(scene)).collect())
}

/// The band of errors that noise forbids to rank. Noise below the edge of the curves is not shown.
fn noise(scene: &Scene) -> Option<Rule> {
    let rule = Rule { label: "noise".to_owned(), at: At::Below(scene.floor) };
    (scene.floor > LEAST_SHOWN).then_some(rule)
}

/// Who leads the front from the coarsest of the levels to the finest, in a sentence.
fn named_front(input: &Input, scene: &Scene, cost: Cost) -> Option<String> {
    let fastest = |level: f64| {
        let of = |row: &'_ Row| {
            let mut points = points(input, row, cost);
            points.retain(|point| point.state == State::Stable && point.y <= level);
            points.into_iter().map(|point| point.x).reduce(f64::min)
        };
        let all = rows_of(input, scene).filter_map(|row| Some((of(row)?, row)));
        let (_, row) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
        row.label.split(',').next().map(str::to_owned)
    };
    let ranked: Vec<f64> = MAP_LEVELS.into_iter().filter(|level| scene.ranks(*level)).collect();
    let mut names: Vec<String> = ranked.iter().filter_map(|level| fastest(*level)).collect();
    names.dedup();
    let least = percent(*ranked.last()?, 1);
    let stiffness = power(scene.stiffness_over_mass_per_s2);
    (!names.is_empty()).then(|| {
        format!("Front at k/m = {stiffness} s⁻², from 10 % to {least}: {}.", names.join(", "))
    })
}

fn quotient(scene: &Scene) -> String {
    format!("k/m = {} s⁻²", power(scene.stiffness_over_mass_per_s2))
}

/// Curves end at this error: below, nobody asks for a cloth.
const LEAST_SHOWN: f64 = 1e-6;

/// Ends a curve where it falls below [`LEAST_SHOWN`], by a straight line in logarithms between the
/// two runs about it. Returns whether it does.
fn cut(points: &mut Vec<Point>) -> bool {
    let is_small = |point: &Point| point.y < LEAST_SHOWN;
    let Some(first) = points.iter().position(is_small) else { return false };
    if let Some(before) = first.checked_sub(1).map(|before| points[before]) {
        let below = &mut points[first];
        let share = (LEAST_SHOWN / before.y).ln() / (below.y / before.y).ln();
        below.x = before.x * (below.x / before.x).powf(share);
    }
    points[first].y = LEAST_SHOWN;
    // What goes on below the edge is not shown.
    points.retain(|point| !is_small(point));
    true
}

fn sheet(mut drafts: Vec<Draft>, cost: Cost) -> Option<Sheet> {
    let label = if cost == Cost::Seconds { "time of the run (s)" } else { MODELLED };
    let mut is_cut = false;
    for series in drafts.iter_mut().flat_map(|draft| &mut draft.1) {
        is_cut |= cut(&mut series.points);
    }
    let mut sheet = panels_of(drafts, |xs| Axis::log(label, xs), |ys| Axis::log(ERROR, ys))?;
    sheet.notes.extend(is_cut.then(|| {
        "Curves end at an error of 10⁻⁶, between two runs or at the first one.".to_owned()
    }));
    Some(sheet)
}

/// The four stiffest scenes of a series.
fn four(input: &Input, damping: &str, cost: Cost) -> Option<Sheet> {
    let scenes = by_stiffness(input, "hanging", damping);
    let last = &scenes[scenes.len().saturating_sub(4)..];
    let title = |scene: &Scene| format!("{}, {} particles", quotient(scene), scene.particles);
    let mut sheet =
        sheet(last.iter().map(|scene| panel(input, scene, title(scene), cost)).collect(), cost)?;
    sheet.notes.extend(last.iter().filter_map(|scene| named_front(input, scene, cost)));
    sheet.notes.extend(input.machine().filter(|_| matches!(cost, Cost::Seconds)));
    Some(sheet)
}

fn headline(input: &Input) -> Option<Sheet> {
    let cost = if input.timings.is_some() { Cost::Seconds } else { Cost::Modelled };
    four(input, "light", cost)
}

fn heavy(input: &Input) -> Option<Sheet> {
    four(input, "heavy", Cost::Modelled)
}

fn soft(input: &Input) -> Option<Sheet> {
    families_of(input, [1e4, 1e6])
}

fn stiff(input: &Input) -> Option<Sheet> {
    families_of(input, [1e8, 1e10])
}

/// Families that share a row of panels, with the title of the row.
const ROWS: [(&str, &[Kin]); 5] = [
    ("Explicit", &[Kin::Explicit, Kin::ExplicitStages, Kin::Adaptive]),
    ("Implicit", &[Kin::Implicit]),
    ("Implicit, of higher order", &[Kin::ImplicitStages, Kin::Linearised]),
    ("Implicit-explicit", &[Kin::ImplicitExplicit, Kin::TwoSteps]),
    ("Local solves, filters, other", &[Kin::Local, Kin::Corrected, Kin::Other]),
];

/// Whether a form is drawn beside those of all methods: the first of its method, and forms that run
/// on more than the scenes of one series.
fn is_main(facts: &Facts, label: &str) -> bool {
    let of = |row: &&Row| row.label == label;
    let Some(own) = facts.rows.iter().find(of) else { return false };
    let id = |row: &'_ Row| row.method.split(':').next().map(str::to_owned);
    let first = facts.rows.iter().find(|row| id(row) == id(own));
    let is_elsewhere = |row: &Row| {
        let scene = facts.scenes.iter().find(|scene| scene.id == row.scene);
        scene.is_some_and(|scene| scene.damping != "light" || !has_series(scene, STIFFNESS))
    };
    first.is_some_and(|row| row.label == label) || facts.rows.iter().filter(of).any(is_elsewhere)
}

/// A row of panels for families of methods, a column for each stiffness.
fn families_of(input: &Input, stiffnesses: [f64; 2]) -> Option<Sheet> {
    let mut scenes = by_stiffness(input, "hanging", "light");
    scenes.retain(|scene| stiffnesses.contains(&scene.stiffness_over_mass_per_s2));
    let identity = |row: &'_ Row| (row.method.clone(), row.label.clone());
    let known: Vec<_> =
        scenes.iter().flat_map(|scene| rows_of(input, scene)).map(identity).collect();
    let families = families(known.iter().map(|(method, label)| (&**method, &**label)));
    let mut drafts = Vec::new();
    for (title, kin) in ROWS {
        let own = families.iter().filter(|family| kin.contains(&family.kin));
        let members = own.flat_map(|family| &family.members);
        let members: Vec<_> = members.filter(|(label, _)| is_main(&input.facts, label)).collect();
        let curves_at = |scene: &&Scene| -> Vec<Series> {
            let curve_of = |(label, look): &&(&str, Look)| {
                let row = rows_of(input, scene).find(|row| row.label == *label)?;
                curve(label, *look, points(input, row, Cost::Modelled))
            };
            members.iter().filter_map(curve_of).collect()
        };
        let curves: Vec<_> = scenes.iter().map(curves_at).collect();
        if curves.iter().all(Vec::is_empty) {
            continue;
        }
        for (scene, curves) in scenes.iter().zip(curves) {
            let series = front(input, scene, Cost::Modelled).into_iter().chain(curves).collect();
            let title = format!("{title}, {}", quotient(scene));
            drafts.push((vec![title], series, noise(scene).into_iter().collect()));
        }
    }
    sheet(drafts, Cost::Modelled)
}

fn size(input: &Input) -> Option<Sheet> {
    let facts = &input.facts;
    let mut drafts = Vec::new();
    let sizes = facts.scenes.iter().filter(|scene| scene.series.iter().any(|s| s != STIFFNESS));
    for particles in values(sizes.map(|scene| scene.particles as f64)) {
        for series in ["k/m fixed", "material fixed"] {
            let is_it = |s: &&Scene| {
                s.particles as f64 == particles && has_series(s, &format!("size, {series}"))
            };
            let Some(scene) = facts.scenes.iter().find(is_it) else { continue };
            let title = format!("{} particles, {series}, {}", scene.particles, quotient(scene));
            drafts.push(panel(input, scene, title, Cost::Modelled));
        }
    }
    sheet(drafts, Cost::Modelled)
}

/// A cell of a map: the winner's method with its lead, coloured by its kind, or a tie.
pub(in crate::studies) fn tile(winner: Option<&Winner>) -> Tile {
    let Some((label, is_explicit, winner)) =
        winner.and_then(|winner| Some((winner.label.as_deref()?, winner.is_explicit?, winner)))
    else {
        return told(Shade::Idle, "");
    };
    let short = |label| -> &str { str::split(label, ',').next().unwrap_or_default() };
    let ties: Vec<&str> = winner.tied.iter().map(|tied| short(&tied.label)).collect();
    tiles::winner(short(label), is_explicit, &ties, winner.ratio)
}

/// The cheapest form with its time, and the forms that tie with it or the next one.
pub(in crate::studies) fn told_winner(winner: Option<&Winner>) -> String {
    let told = winner.and_then(|winner| {
        let (label, time) = winner.label.as_ref().zip(winner.modelled_s)?;
        let behind = |label: &str, ratio: f64| format!("{label} × {}", significant(ratio, 2));
        let second = winner.runner_up.as_ref().zip(winner.ratio);
        let second = second.map_or_else(String::new, |(label, ratio)| match winner.tied.len() {
            0 => format!("; next {}", behind(label, ratio)),
            1 => format!("; tie with {}", behind(label, ratio)),
            ties => format!("; tie with {} and {} more", behind(label, ratio), ties - 1),
        });
        let beside = winner.energy.zip(winner.retained);
        let beside = beside.map_or_else(String::new, |(energy, retained)| {
            let (energy, retained) = (significant(100.0 * energy, 2), significant(retained, 2));
            format!(" (energy {energy} %, R {retained})")
        });
        Some(format!("{label}, {} ms{beside}{second}", significant(1e3 * time, 2)))
    });
    told.unwrap_or_else(absent)
}

fn map(input: &Input) -> Option<Matrix> {
    let facts = &input.facts;
    let of_series = facts.scenes.iter().filter(|scene| has_series(scene, STIFFNESS));
    let stiffnesses = values(of_series.map(|scene| scene.stiffness_over_mass_per_s2));
    let mut rows = Vec::new();
    for (name, damping) in
        [("hanging", "light"), ("hanging", "heavy"), ("thrown", "light"), ("spread", "light")]
    {
        let scenes = by_stiffness(input, name, damping);
        for (n, level) in MAP_LEVELS.into_iter().enumerate().filter(|_| !scenes.is_empty()) {
            let winner = |stiffness: &f64| {
                let scene =
                    scenes.iter().find(|scene| scene.stiffness_over_mass_per_s2 == *stiffness);
                vec![
                    scene.map_or_else(|| told(Shade::Idle, ""), |scene| place(facts, scene, level)),
                ]
            };
            rows.push(Line {
                label: format!("{name}, {damping}, {}", percent(level, 1)),
                is_first: n == 0,
                tiles: stiffnesses.iter().map(winner).collect(),
            });
        }
    }
    let columns =
        stiffnesses.iter().map(|k| format!("k/m = {} s⁻²", power(*k))).collect::<Vec<_>>();
    let notes = vec![
        signs_of_winners("below twice the time"),
        "Rows: scene, damping, error. At k/m = 100 s⁻² heavy damping is the light one.".to_owned(),
    ];
    let legend = legend_of_winners("not run, not reached, or noise");
    (!rows.is_empty()).then_some(Matrix { columns, rows, legend, notes })
}

/// A place of the map.
fn place(facts: &Facts, scene: &Scene, level: f64) -> Tile {
    if !scene.ranks(level) {
        return told(Shade::Idle, NOISE);
    }
    tile(facts.winners.iter().find(|winner| winner.scene == scene.id && winner.level == level))
}

/// How many scenes each kind of methods leads.
fn kinds(input: &Input) -> Table {
    let line = |level: f64| {
        let at = || input.facts.winners.iter().filter(move |winner| winner.level == level);
        let leads = facts::tally(at().filter_map(Winner::kind));
        let missed = at().filter(|winner| winner.label.is_none()).count();
        let noisy = input.facts.scenes.iter().filter(|scene| !scene.ranks(level)).count();
        let counts = leads.into_iter().chain([missed, noisy]).map(|count| count.to_string());
        std::iter::once(format!("≤ {}", percent(level, 1))).chain(counts).collect()
    };
    Table {
        title: "**Who leads by a factor of 2**: the number of scenes for each error.".to_owned(),
        header: texts(&["error", "explicit", "implicit", "tie", "not reached", NOISE]),
        names: 1,
        rows: MAP_LEVELS.into_iter().map(line).collect(),
    }
}

/// The fastest verified run for each error, by measured time.
fn fastest(input: &Input) -> Table {
    let line = |scene: &Scene| {
        let runs = || {
            rows_of(input, scene).flat_map(|row| {
                points(input, row, Cost::Seconds).into_iter().map(move |point| (row, point))
            })
        };
        let place = |level: f64| {
            if !scene.ranks(level) {
                return NOISE.to_owned();
            }
            let is_good = |point: &Point| point.state == State::Stable && point.y <= level;
            let good = runs().filter(|(_, point)| is_good(point));
            good.min_by(|a, b| a.1.x.total_cmp(&b.1.x)).map_or_else(absent, |(row, point)| {
                format!("{}, {} ms", row.label, significant(1e3 * point.x, 3))
            })
        };
        runs().next()?;
        Some(std::iter::once(name(scene)).chain(MAP_LEVELS.map(place)).collect())
    };
    let mut header = texts(&["scene"]);
    header.extend(MAP_LEVELS.map(|level| format!("error ≤ {}", percent(level, 1))));
    Table {
        title:
            "**Fastest by the clock**: the method with the least time for an error, and its time, \
                among timed runs that repeat the recorded answer bit by bit."
                .to_owned(),
        header,
        names: 1,
        rows: input.facts.scenes.iter().filter_map(line).collect(),
    }
}

/// Ratio of measured to modelled time of each form.
fn calibration(input: &Input) -> Table {
    let rows = || input.facts.rows.iter();
    let mut labels: Vec<&str> = Vec::new();
    for row in rows() {
        if !labels.contains(&row.label.as_str()) {
            labels.push(&row.label);
        }
    }
    let line = |label: &str| {
        let quotients = rows().filter(|row| row.label == label).flat_map(|row| {
            let quotient =
                move |run: &Run| Some(point(input, row, run, Cost::Seconds)?.x / run.modelled_s);
            row.runs.iter().filter_map(quotient).collect::<Vec<_>>()
        });
        let quotients = values(quotients);
        let (least, greatest) = (quotients.first()?, quotients.last()?);
        let number = |value: f64| significant(value, 2);
        Some(vec![
            label.to_owned(),
            number(*least),
            number(median(quotients.iter().copied())?),
            number(*greatest),
            quotients.len().to_string(),
        ])
    };
    Table {
        title:
            "**Measured over modelled time** of the timed runs of each form. If the ratios of two \
             forms differ, the seconds decide."
                .to_owned(),
        header: texts(&["method", "least", "median", "greatest", "runs"]),
        names: 1,
        rows: labels.into_iter().filter_map(line).collect(),
    }
}

fn name(scene: &Scene) -> String {
    format!(
        "{}, {} damping, {}, {} particles",
        scene.scene,
        scene.damping,
        quotient(scene),
        scene.particles
    )
}

/// The cheapest run for each error, by modelled time.
fn cheapest(input: &Input) -> Table {
    let facts = &input.facts;
    let line = |scene: &Scene| {
        let place = |level: f64| {
            if !scene.ranks(level) {
                return NOISE.to_owned();
            }
            told_winner(facts.winners.iter().find(|w| w.scene == scene.id && w.level == level))
        };
        std::iter::once(name(scene)).chain(MAP_LEVELS.map(place)).collect()
    };
    let mut header = texts(&["scene"]);
    header.extend(MAP_LEVELS.map(|level| format!("error ≤ {}", percent(level, 1))));
    Table {
        title:
            "**Cheapest by modelled time**: the method with the least time for an error, its energy \
             at the end beyond the true one, its motion kept (R), and the next other method with \
             its time over that. Below a factor of 2 it is a tie. –: no run within the budget \
             reaches this error."
                .to_owned(),
        header,
        names: 1,
        rows: facts.scenes.iter().map(line).collect(),
    }
}

/// Level of error in the table [`excess`].
const LEVEL: f64 = 1e-2;

/// Cost of the headline's methods over the cheapest, along the lightly damped series.
fn excess(input: &Input) -> Table {
    let scenes = by_stiffness(input, "hanging", "light");
    let mut labels: Vec<&str> = Vec::new();
    for row in scenes.iter().flat_map(|scene| rows_of(input, scene)).filter(|r| r.is_headline) {
        if !labels.contains(&row.label.as_str()) {
            labels.push(&row.label);
        }
    }
    let line = |scene: &&Scene| {
        let rows = || rows_of(input, scene);
        if !scene.ranks(LEVEL) {
            return None;
        }
        let (_, least) = facts::cheapest(rows(), LEVEL)?;
        let cost = |label: &&str| {
            let own = facts::cheapest(rows().filter(|row| row.label == *label), LEVEL);
            own.map_or_else(absent, |(_, run)| significant(run.modelled_s / least.modelled_s, 3))
        };
        let missed = rows().filter(|row| row.misses(LEVEL)).count();
        let mut line = vec![quotient(scene)];
        line.extend(labels.iter().map(cost));
        line.push(format!("{missed} of {}", rows().count()));
        Some(line)
    };
    let mut header = texts(&["hanging, light damping"]);
    header.extend(texts(&labels));
    header.push("variants over budget".to_owned());
    Table {
        title: format!(
            "**Modelled time for an error of {}, over the cheapest of all methods**, and how many \
             variants exceed their budget first. –: not within the budget.",
            percent(LEVEL, 1)
        ),
        header,
        names: 1,
        rows: scenes.iter().filter_map(line).collect(),
    }
}

fn scenes(input: &Input) -> Table {
    let line = |scene: &Scene| {
        vec![
            name(scene),
            scene.springs.to_string(),
            significant(scene.damping_over_mass_per_s, 3),
            significant(scene.motion_m, 3),
            significant(scene.reference_error, 2),
            significant(scene.floor, 2),
            significant(100.0 * scene.energy_floor, 2),
            significant(scene.budget, 2),
        ]
    };
    Table {
        title: "**Scenes and references.** Motion: root mean square of the distances that the \
             particles move in 0.25 s. Noise: the change at the end after a change of 1 µm at the \
             start, mean of eight."
            .to_owned(),
        header: texts(&[
            "scene",
            "springs",
            "d/m (s⁻¹)",
            "motion (m)",
            "error of the reference",
            "noise of the positions",
            "of the energy (%)",
            "budget of a run (visits)",
        ]),
        names: 1,
        rows: input.facts.scenes.iter().map(line).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_method_has_one_row_of_panels() {
        for kin in Kin::ALL {
            let rows = ROWS.iter().filter(|(_, kinds)| kinds.contains(&kin)).count();
            assert_eq!(rows, 1, "{kin:?}");
        }
    }

    #[test]
    fn a_curve_ends_where_it_crosses_the_least_error() {
        let point = |x: f64, y: f64| Point { x, y, state: State::Stable };
        let cut = |points: &[(f64, f64)]| {
            let mut all: Vec<_> = points.iter().map(|&(x, y)| point(x, y)).collect();
            let is_cut = super::cut(&mut all);
            (is_cut, all.iter().map(|p| (p.x, p.y)).collect::<Vec<_>>())
        };
        let (is_cut, ended) = cut(&[(1.0, 1e-4), (1e4, 1e-8), (1e5, 1e-9), (1e6, 1e-5)]);
        assert!(is_cut);
        assert_eq!((ended.len(), ended[0], ended[1].1), (3, (1.0, 1e-4), LEAST_SHOWN));
        assert!((ended[1].0 - 1e2).abs() < 1e-9, "{}", ended[1].0);
        assert_eq!(cut(&[(2.0, 1e-8)]), (true, vec![(2.0, LEAST_SHOWN)]));
        assert_eq!(cut(&[(2.0, 1e-5)]), (false, vec![(2.0, 1e-5)]));
    }
}
