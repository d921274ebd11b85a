//! The record of a comparison as a file, and as a page that needs no other file.

use super::advice::{Advice, advise, command, lines};
use super::facts::{End, Facts, Form, Metric, Run};
use super::{Comparison, Options};
use crate::families::{families, labels};
use crate::{HarnessError, Source, provenance};
use drape_model::{System, SystemSpec, Vec3};
use drape_render::{Camera, Colour, Font, Image, Subject, View, draw};
use drape_report::file::{write_atomically, write_json};
use drape_report::number::significant;
use drape_report::page::{Head, Outline, Part, Section, Table, absent, texts};
use drape_report::plate::{self, Draw, Plate};
use drape_report::plot::{At, Axis, Look, Point, Rule, Series, Sheet, State, panels_of};
use drape_report::{
    Content, Figure, Provenance, RECORD_FORMAT, Record, ReportError, Verdict, Words, printable,
};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Name of the record.
pub const NAME: &str = "compare";
/// Size of a picture of the cloth, pixels.
const SIDES: [u32; 2] = [360, 300];
/// Runs whose ends are shown beside the true one.
const SHOWN: usize = 3;
const PICTURE: &str = "compare-ends.png";

const OUTLINE: Outline = Outline {
    parts: &[Part { title: "This scene", studies: &[], table_first: true }],
    answers: &[NAME],
    longest_answer: 1,
    leads: &[&["compare-front.svg"]],
};

const PLATES: &[Plate<Facts>] = &[Plate {
    file: "compare-front.svg",
    title: "What a frame costs, and how wrong it is",
    caption: "The line joins the runs that no other beats in both. Time a frame on one core \
              against \
        the error; a marker for each run that gains no energy and keeps its motion: one form of a \
        method with one number of steps a frame. Dashed: the error that was asked for, and the \
        noise of the scene, below which nothing is ranked.",
    draw: Draw::Sheet(front),
}];

/// What a comparison was asked, and by which program.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The options.
    pub options: &'a Options,
    /// The command line that asks it again.
    pub command: &'a str,
    /// What the program was built from.
    pub source: &'a Source,
}

/// The record of a comparison.
pub fn record(comparison: &Comparison, request: &Request<'_>) -> Record<Facts> {
    let Comparison { facts, hash, .. } = comparison;
    let scenes = [(facts.scene.name.clone(), hash.clone())].into();
    let provenance = provenance(request.source, scenes);
    let mut figures: Vec<Figure> = PLATES.iter().map(Plate::figure).collect();
    figures.push(picture());
    Record {
        format: RECORD_FORMAT.to_owned(),
        experiment: NAME.to_owned(),
        question: format!(
            "Which method shows `{}` with a {} error within {} m in the least time?",
            printable(&facts.scene.name),
            facts.scene.metric.name(),
            significant(facts.scene.target_m, 3)
        ),
        method: method(facts),
        words: words(facts, &advise(facts)),
        command: request.command.to_owned(),
        quick: false,
        figures,
        facts: facts.clone(),
        provenance: Provenance { seed: Some(request.options.seed), ..provenance },
    }
}

/// Writes `compare.json` and `compare.html` into a folder; returns the files.
///
/// # Errors
/// [`PageError`] with the file that could not be written, or the figure that could not be drawn.
pub fn write(
    out: &Path,
    record: Record<Facts>,
    comparison: &Comparison,
    spec: &SystemSpec,
) -> Result<Vec<PathBuf>, PageError> {
    let json = out.join(format!("{NAME}.json"));
    write_json(&json, &record).map_err(HarnessError::from)?;
    let (frame, facts) = record.split();
    let mut files = Vec::new();
    let mut figures = plate::draw_all(PLATES, &facts, &mut files)?;
    if let Some(image) = ends(comparison, spec)? {
        let png = image
            .png()
            .map_err(|error| ReportError::Picture { file: PICTURE, source: Box::new(error) })?;
        files.push((format!("figures/{PICTURE}"), Content::Png(png)));
        figures.push(picture());
    }
    let section = Section::new(&frame, figures, tables(&facts));
    let title = format!("Which method for {}?", printable(&facts.scene.name));
    let lead = lead(&facts);
    let head = Head { title: &title, lead: &lead };
    let page = drape_report::one_page(head, &[section], &OUTLINE, &files)?;
    let html = out.join(format!("{NAME}.html"));
    write_atomically(&html, page.as_bytes()).map_err(HarnessError::from)?;
    Ok(vec![json, html])
}

/// What was asked, in a sentence or two.
fn lead(facts: &Facts) -> String {
    let Facts { scene, forms, runs, .. } = facts;
    let run = |(n, _): &(usize, &Form)| runs.iter().any(|run| run.form == *n);
    format!(
        "{} forms of methods, {} of which were run, show {} particles and {} springs for {} frames \
         of {} s. Wanted: the least time a frame with a {} error of at most {} mm.",
        forms.len(),
        forms.iter().enumerate().filter(run).count(),
        scene.particles,
        scene.springs,
        scene.frames,
        significant(scene.frame_s, 3),
        scene.metric.name(),
        significant(1e3 * scene.target_m, 2)
    )
}

/// Time of all of a page but its pictures.
const PLAIN: Duration = Duration::from_millis(80);

/// How long [`write()`] will take, about: from the time of a picture of the start.
///
/// # Errors
/// [`HarnessError`] where the system is refused.
pub fn page_time(spec: &SystemSpec) -> Result<Duration, HarnessError> {
    let begin = Instant::now();
    let (system, state) = spec.build()?;
    let first = [("start".to_owned(), &state.x)];
    sheet(spec, &system, &first, 0.0).png().ok();
    Ok(begin.elapsed() * (SHOWN + 1) as u32 + PLAIN)
}

/// Why a comparison could not be written.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A file could not be written, or the system could not be built.
    #[error(transparent)]
    Harness(#[from] HarnessError),
    /// A figure could not be drawn or the page not filled.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// How the facts were measured.
fn method(facts: &Facts) -> String {
    let error = match facts.scene.metric {
        Metric::Shape => {
            "mean distance from the particles of each surface to the triangles of the other"
        }
        Metric::Trajectory => "root mean square distance of the particles",
    };
    format!(
        "The steps of the true motion are halved until this changes it by less than a tenth of the \
         target, or by no more than the noise. Starts perturbed by a millionth of the cloth's size \
         (seeded) measure the noise, the mean distance of such a motion from the nearest other \
         one; a run is compared with the nearest of these motions, too. Error: {error}, as a mean \
         over up to 10 moments in {} frames. A run is locked if its energy is stable and its free \
         particles move, on average, less than half of the true path. Where pins, obstacles or \
         wind do work, a gain of energy is a rise that is surely beyond that work; a run is open \
         if no rise is known to be one, or to be none. Without a true motion, the check of `drape \
         run` in up to three short windows decides whether a run is locked; if the check cannot \
         measure anything, theory decides. Each form runs with rising numbers of steps a frame \
         until it meets the target, or would take more than three times as long as another form \
         that does. Time a frame is the wall time of the steps on one thread, without set-up, and \
         the least of the repetitions; a frame that takes more than five times the median counts \
         as five. The time limit decides which runs were made, but not their results.",
        facts.scene.frames
    )
}

fn words(facts: &Facts, advice: &Advice) -> Words {
    let said = |run: &Run| {
        let form = facts.form_of(run);
        let steps = if run.substeps == 1 { "step" } else { "steps" };
        format!("`{}` with {} {steps} a frame", form.method, run.substeps)
    };
    let conclusion = match (&advice.take, &advice.closest) {
        (Some(pick), _) => {
            let run = &facts.runs[pick.run];
            format!(
                "Take {}: {} ms a frame, error {} mm. Run it: `{}`",
                said(run),
                significant(1e3 * run.frame_s, 2),
                significant(1e3 * run.error_m.unwrap_or(0.0), 2),
                command(facts, run)
            )
        }
        (None, Some(pick)) => {
            let run = &facts.runs[pick.run];
            format!("No run meets the target in this time. The closest is {}.", said(run))
        }
        (None, None) => "No run was stable, moved and could be judged.".to_owned(),
    };
    let observations = lines(facts, advice);
    let kept = |line: &&String| {
        ["held to", "ties", "runner-up", "others", "explodes", "locks"]
            .iter()
            .any(|w| line.starts_with(w))
    };
    let sentence = |line: &String| {
        let (word, text) = line.split_at(line.len().min(11));
        format!("**{}**: {}.", word.trim(), text.trim())
    };
    let mut caveats = vec!["Times are those of this machine.".to_owned()];
    if !facts.truth.is_trusted {
        caveats.push(
            "No true motion was found in the time: errors are distances to the same form with half \
             the steps. Such runs may agree and still be wrong. Only runs that stand still are left \
             out, by a cheap check."
                .to_owned(),
        );
    }
    Words {
        conclusion,
        observations: observations.iter().filter(kept).map(sentence).collect(),
        caveats,
    }
}

/// Forms with a look of their own in the figure; of more, a family of methods has one.
const MOST_SERIES: usize = 24;

/// Sound runs with their errors.
fn sound(facts: &Facts) -> impl Iterator<Item = (&Run, f64)> {
    facts.runs.iter().filter(|run| run.is_sound()).filter_map(|run| Some((run, run.error_m?)))
}

fn front(facts: &Facts) -> Option<Sheet> {
    let point = |(run, error): &(&Run, f64)| Point {
        x: 1e3 * run.frame_s,
        y: 1e3 * error.max(1e-9),
        state: State::Stable,
    };
    let runs: Vec<_> = sound(facts).collect();
    let all = facts.forms.iter().map(|form| (form.method.as_str(), form.label.as_str()));
    let families = families(all);
    let of = |members: &[(&str, Look)]| -> Vec<Point> {
        let is_its =
            |run: &Run| members.iter().any(|(label, _)| *label == facts.form_of(run).label);
        runs.iter().filter(|(run, _)| is_its(run)).map(point).collect()
    };
    let members = families.iter().flat_map(|family| &family.members);
    let single = members.filter_map(|member| {
        let (label, look) = *member;
        Some(Series::new(label.to_owned(), look, of(&[*member]))?.apart())
    });
    let mut series: Vec<Series> = single.collect();
    if series.len() > MOST_SERIES {
        let own = families.iter().enumerate().filter_map(|(n, family)| {
            let look = Look::of_family(n, n / 7);
            Some(Series::new(family.title.to_owned(), look, of(&family.members))?.apart())
        });
        series = own.collect();
    }
    let mut best = runs.clone();
    best.sort_by(|a, b| a.0.frame_s.total_cmp(&b.0.frame_s).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    best.retain(|(_, error)| {
        let is_better = *error < least;
        least = least.min(*error);
        is_better
    });
    let line = best.iter().map(point).collect();
    series.extend(Series::path("the front".to_owned(), Look::number(0), line));
    let mut rules = vec![Rule { label: "target".to_owned(), at: At::Y(1e3 * facts.good_m()) }];
    if let Some(floor) = facts.truth.floor_m.filter(|floor| *floor > 0.0) {
        rules.push(Rule { label: "noise".to_owned(), at: At::Y(1e3 * floor.max(1e-9)) });
    }
    let error = format!("{} error (mm)", facts.scene.metric.name());
    panels_of(
        vec![(vec![printable(&facts.scene.name).into_owned()], series, rules)],
        |xs| Axis::log("ms a frame", xs),
        |ys| {
            let ys: Vec<f64> = ys.iter().copied().chain([1e3 * facts.good_m()]).collect();
            Axis::log(&error, &ys)
        },
    )
}

fn picture() -> Figure {
    Figure {
        file: PICTURE.to_owned(),
        title: "The cloth at the end".to_owned(),
        caption: "First the true motion, where there is one, then the best runs with their error."
            .to_owned(),
    }
}

/// The cloth at the end of the best runs, side by side.
fn ends(comparison: &Comparison, spec: &SystemSpec) -> Result<Option<Image>, HarnessError> {
    let facts = &comparison.facts;
    let advice = advise(facts);
    let picks = advice.take.iter().chain(&advice.ties).chain(&advice.runner_up);
    let mut shown: Vec<(String, &Vec<Vec3>)> = Vec::new();
    shown.extend(comparison.true_end.as_ref().map(|x| ("true motion".to_owned(), x)));
    for pick in picks.chain(&advice.closest).take(SHOWN) {
        let run = &facts.runs[pick.run];
        let error = significant(1e3 * run.error_m.unwrap_or(0.0), 2);
        let label = format!("{} x{}: {error} mm", facts.form_of(run).label, run.substeps);
        shown.extend(comparison.ends[run.form].as_ref().map(|x| (label, x)));
    }
    if shown.is_empty() {
        return Ok(None);
    }
    let (system, _) = spec.build()?;
    let end = facts.scene.frame_s * f64::from(facts.scene.frames);
    Ok(Some(sheet(spec, &system, &shown, end)))
}

/// Positions of the cloth at a time, side by side, each with its label.
fn sheet(spec: &SystemSpec, system: &System, shown: &[(String, &Vec<Vec3>)], time: f64) -> Image {
    let subject = Subject::new(spec, system.obstacles());
    let subject = subject.at(time);
    let points: Vec<Vec3> = shown.iter().flat_map(|(_, x)| subject.points(x)).collect();
    let (subject, points) = subject.into_owned().on_ground(points);
    let aspect = f64::from(SIDES[0]) / f64::from(SIDES[1]);
    let camera = Camera::fit(View::default(), &points, aspect);
    let head = Font::Small.height() + 8;
    let mut sheet = Image::new(SIDES[0] * shown.len() as u32, SIDES[1] + head);
    for (n, (label, x)) in (0..).zip(shown) {
        let x = system.display_positions(x, time);
        sheet.paste(&draw(&subject, &x, &camera, SIDES), n * SIDES[0], head);
        let most = (SIDES[0] / Font::Small.width("x").max(1)) as usize;
        let label: String = label.chars().take(most.saturating_sub(2)).collect();
        sheet.write(&label, n * SIDES[0] + 8, 4, Font::Small, Colour::INK);
    }
    sheet
}

fn tables(facts: &Facts) -> Vec<Table> {
    vec![forms(facts), runs(facts), refusals(facts)]
}

fn millimetres(error: Option<f64>) -> String {
    error.map_or_else(absent, |error| significant(1e3 * error, 2))
}

fn share(value: Option<f64>) -> String {
    value.map_or_else(absent, |value| significant(value, 2))
}

/// Why a form ran no more, in words.
fn said(end: End) -> &'static str {
    match end {
        End::Good => "meets the target",
        End::Dominated => "over 3 × the best",
        End::Exhausted => "all steps tried",
        End::OutOfTime => "time over",
        End::Refused => "refused",
    }
}

/// The best run of each form: the cheapest that meets the target, or else the last. A form that was
/// not run stands there, too.
pub(super) fn forms(facts: &Facts) -> Table {
    let mut rows: Vec<(f64, Vec<String>)> = Vec::new();
    for (n, form) in facts.forms.iter().enumerate() {
        let own = || facts.runs.iter().filter(|run| run.form == n);
        let met = own().filter(|run| facts.is_met(run));
        let best = met.min_by(|a, b| a.frame_s.total_cmp(&b.frame_s));
        let shown = best.or_else(|| own().next_back());
        let rank = shown.map_or(f64::INFINITY, |run| {
            if best.is_some() { run.frame_s } else { 1e9 + run.frame_s }
        });
        let of = |cell: &dyn Fn(&Run) -> String| shown.map_or_else(absent, cell);
        rows.push((
            rank,
            vec![
                form.label.clone(),
                of(&|run| verdict(facts, run)),
                match (form.end, best) {
                    (End::Good, None) => "misses the target when pushed".to_owned(),
                    (end, _) => said(end).to_owned(),
                },
                of(&|run| run.substeps.to_string()),
                of(&|run| significant(1e3 * run.frame_s, 2)),
                of(&|run| millimetres(run.error_m)),
                of(&|run| share(run.retained)),
            ],
        ));
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let header =
        ["form", "verdict", "ended", "steps a frame", "ms a frame", "error (mm)", "motion kept"];
    Table {
        title: "**Forms**: the cheapest run that meets the target, or else the last.".to_owned(),
        header: texts(&header),
        names: 3,
        rows: rows.into_iter().map(|(_, row)| row).collect(),
    }
}

/// Its verdict, and what a push makes of it. A run that was stopped has none.
fn verdict(facts: &Facts, run: &Run) -> String {
    if run.verdict == Verdict::OverBudget {
        return "stopped".to_owned();
    }
    let pushed = match (run.is_fragile(), facts.strays(run)) {
        (true, _) => ", gains energy when pushed",
        (false, true) => ", errs too much when pushed",
        (false, false) => "",
    };
    format!("{}{pushed}", run.verdict)
}

fn runs(facts: &Facts) -> Table {
    let order = labels(facts.forms.iter().map(|f| (f.method.as_str(), f.label.as_str())));
    let place = |run: &Run| order.iter().position(|label| *label == facts.form_of(run).label);
    let mut runs: Vec<&Run> = facts.runs.iter().collect();
    runs.sort_by_key(|run| (place(run), run.substeps));
    let line = |run: &&Run| {
        vec![
            facts.form_of(run).label.clone(),
            verdict(facts, run),
            run.substeps.to_string(),
            significant(1e3 * run.frame_s, 2),
            millimetres(run.error_m),
            share(run.retained),
            share(run.gain),
            run.force_evaluations.to_string(),
            run.matvecs.to_string(),
            run.factorisations.to_string(),
            run.unconverged_steps.to_string(),
        ]
    };
    let header = [
        "form",
        "verdict",
        "steps a frame",
        "ms a frame",
        "error (mm)",
        "motion kept",
        "energy gained",
        "force sweeps",
        "products",
        "factorisations",
        "steps not converged",
    ];
    Table {
        title: "**All runs**.".to_owned(),
        header: texts(&header),
        names: 2,
        rows: runs.iter().map(line).collect(),
    }
}

fn refusals(facts: &Facts) -> Table {
    let line = |form: &Form| Some(vec![form.label.clone(), form.refusal.clone()?]);
    Table {
        title: "**Refused**: what a method cannot do with this scene.".to_owned(),
        header: texts(&["form", "reason"]),
        names: 2,
        rows: facts.forms.iter().filter_map(line).collect(),
    }
}
