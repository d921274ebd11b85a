//! `drape picture`.

use super::refusal;
use crate::cli::exit::Diverged;
use crate::cli::input::{files, in_file, load};
use crate::cli::limit::LimitArguments;
use crate::cli::number::number;
use crate::cli::output::{Sink, check_extension, is_stream};
use crate::cli::progress::bar;
use drape_harness::methods::{Choice, MethodError};
use drape_harness::{Divergence, HarnessError, Moving, OrderedSimulation};
use drape_model::{TimeSpan, Vec3, Violation};
use drape_render::{Camera, Colour, Font, Image, Subject, View, draw};
use std::path::{Path, PathBuf};
use std::str::FromStr;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled scene, or a file with a scene or a discretised system
    scene: String,
    /// Id of a method; settings follow a colon. If repeated, the picture shows the methods side by
    /// side, from the same camera
    #[arg(long = "method", value_name = "METHOD", default_value = "backward-euler")]
    methods: Vec<String>,
    /// A setting of the method; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Time step, s, a number or a fraction such as 1/60 (default: of the scene; a discretised system has none)
    #[arg(long, allow_negative_numbers = true, value_parser = number)]
    dt: Option<f64>,
    /// Simulated time, s (default: of the scene; a discretised system has none)
    #[arg(long, allow_negative_numbers = true, value_parser = number)]
    duration: Option<f64>,
    /// Time of the picture, s; may be repeated (default: the end). The picture shows the end of the
    /// first step that ends at this time or later
    #[arg(long = "time", value_name = "S", allow_negative_numbers = true, value_parser = number)]
    times: Vec<f64>,
    /// File for the picture, or - for standard output; several pictures get numbers: FILE-1.png
    /// and so on
    #[arg(long, value_name = "FILE.png", default_value = "picture.png")]
    out: PathBuf,
    /// Size in pixels of the picture, or of each method's; each side from 64 to 4096
    #[arg(long, value_name = "WxH", default_value = "960x720")]
    size: String,
    /// Camera: auto, front, side, top, or AZIMUTH,ELEVATION in degrees
    #[arg(long, value_name = "VIEW", default_value = "auto", allow_hyphen_values = true)]
    camera: String,
    /// Draw no ground and no shadow
    #[arg(long)]
    no_ground: bool,
    #[command(flatten)]
    limit: LimitArguments,
}

/// Shortest and longest side of a picture, pixels.
const SIDES: [u32; 2] = [64, 4096];
/// Seconds by which a step may end too early: round-off of a sum of steps.
const EARLY: f64 = 1e-9;

/// Most methods side by side, and in a row.
const MOST: usize = 12;
const ROW: usize = 3;
/// Pixels between the pictures of two methods.
const GAP: u32 = 4;

/// A method and its pictures.
struct Film {
    choice: Choice,
    shots: Vec<Shot>,
    divergence: Option<Divergence>,
}

/// A picture that the user wants.
struct Shot {
    due: f64,
    /// Time and positions, once the run has reached the moment.
    taken: Option<(f64, Vec<Vec3>)>,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let size = size(&arguments.size)?;
    check_extension("--out", &arguments.out, "png", "PNG image")?;
    let view = View::from_str(&arguments.camera)
        .map_err(|error| refusal("--camera", &arguments.camera, error.to_string()))?;
    let choices = choices(arguments)?;
    let input = load(&arguments.scene, arguments.limit, choices.first())?;
    let time = drape_harness::time_span(arguments.dt, arguments.duration, &input)?;
    let times = moments(&arguments.times, time)?;
    let inputs = files(&arguments.scene, &input);
    if times.len() > 1 && is_stream(&arguments.out) {
        let expected = format!("FILE.png: {} pictures need a file each", times.len());
        return Err(refusal("--out", arguments.out.display(), &expected).into());
    }
    let sinks = numbered(&arguments.out, times.len());
    let sink = |file: &PathBuf| Sink::check("--out", file, &inputs);
    let sinks = sinks.iter().map(sink).collect::<Result<Vec<_>, _>>()?;
    let spec = input.spec();
    let prepare = |choice: Choice| {
        let simulation = OrderedSimulation::new(spec, &choice)
            .map_err(|violation| in_file(&arguments.scene, violation))?;
        Ok((choice, simulation))
    };
    let prepared = choices.into_iter().map(prepare).collect::<anyhow::Result<Vec<_>>>()?;
    let Some((_, first)) = prepared.first() else { return Ok(()) };
    let subject = Subject::new(spec, first.obstacles());
    let film = |(choice, mut simulation)| {
        film(choice, &mut simulation, &times, time)
            .map_err(|error| error.in_scene(&arguments.scene))
    };
    let films = prepared.into_iter().map(film).collect::<Result<Vec<_>, _>>()?;
    // All pictures share one camera, so that they can be compared.
    let taken = films.iter().flat_map(|film| &film.shots).filter_map(|shot| shot.taken.as_ref());
    let points: Vec<Vec3> = taken.flat_map(|(t, x)| subject.at(*t).points(x)).collect();
    let (subject, points) =
        if arguments.no_ground { (subject, points) } else { subject.on_ground(points) };
    let camera = Camera::fit(view, &points, f64::from(size[0]) / f64::from(size[1]));
    let scene = [spec.name.as_str(), &time.step_s.to_string()];
    for (n, sink) in sinks.iter().enumerate() {
        let panels = films.iter().map(|film| panel(film, n, &subject, &camera, size, scene));
        sink.write(&side_by_side(&panels.collect::<Vec<_>>(), size).png()?)?;
    }
    diverged(&films)
}

/// The methods, each with its settings.
fn choices(arguments: &Arguments) -> anyhow::Result<Vec<Choice>> {
    let Arguments { methods, settings, .. } = arguments;
    if methods.len() > MOST {
        let expected = format!("at most {MOST} methods");
        return Err(
            refusal("--method", format_args!("{} methods", methods.len()), &expected).into()
        );
    }
    if let ([_, _, ..], Some(setting)) = (&methods[..], settings.first()) {
        let expected = "no --set beside several methods: write METHOD:KEY=VALUE";
        return Err(refusal("--set", setting, expected).into());
    }
    let parse = |method: &String| {
        Choice::parse(method, settings)
            .map_err(|error: MethodError| HarnessError::from(error).into())
    };
    methods.iter().map(parse).collect()
}

/// The picture of a method at moment `n`, with its label.
fn panel(
    film: &Film,
    n: usize,
    subject: &Subject,
    camera: &Camera,
    size: [u32; 2],
    [scene, step]: [&str; 2],
) -> Image {
    let shot = &film.shots[n];
    let (mut image, time_s) = match (&shot.taken, &film.divergence) {
        (None, Some(divergence)) => {
            let reason = format!("diverged at t = {:.4} s", divergence.time);
            (Image::failure(size, &reason), shot.due)
        }
        (None, None) => (Image::failure(size, "not reached"), shot.due),
        (Some((t, x)), _) => (draw(&subject.at(*t), x, camera, size), *t),
    };
    let method = film.choice.method().id;
    let label = format!("{scene}, {method}, h = {step} s, t = {time_s:.4} s");
    let bottom = size[1].saturating_sub(Font::Small.height() + 8);
    image.write(&label, 10, bottom, Font::Small, Colour::GREY);
    image
}

/// Pictures of one size in rows.
fn side_by_side(panels: &[Image], [width, height]: [u32; 2]) -> Image {
    let columns = panels.len().min(ROW);
    let rows = panels.len().div_ceil(ROW);
    let extent = |count: usize, side: u32| count as u32 * (side + GAP) - GAP;
    let mut sheet = Image::new(extent(columns, width), extent(rows, height));
    for (n, panel) in panels.iter().enumerate() {
        let [column, row] = [n % ROW, n / ROW].map(|k| k as u32);
        sheet.paste(panel, column * (width + GAP), row * (height + GAP));
    }
    sheet
}

/// Whether a method diverged, and when.
fn diverged(films: &[Film]) -> anyhow::Result<()> {
    let sentence = |film: &Film| {
        let divergence = film.divergence.as_ref()?;
        Some(format!(
            "{} diverged at step {} (t = {} s): {}; pictures from then on show no cloth",
            film.choice.full_id(),
            divergence.step,
            divergence.time,
            divergence.criterion
        ))
    };
    let sentences: Vec<_> = films.iter().filter_map(sentence).collect();
    if sentences.is_empty() { Ok(()) } else { Err(Diverged(sentences.join("; ")).into()) }
}

/// Runs a method and keeps the positions at each moment.
fn film(
    choice: Choice,
    simulation: &mut OrderedSimulation,
    times: &[f64],
    time: TimeSpan,
) -> Result<Film, HarnessError> {
    let mut shots: Vec<Shot> = times.iter().map(|&due| Shot { due, taken: None }).collect();
    let divergence = take(&mut shots, simulation, time, &choice)?;
    if let Some(divergence) = &divergence {
        // Positions after a divergence show nothing.
        let is_lost = |shot: &Shot| shot.taken.as_ref().is_some_and(|(t, _)| *t >= divergence.time);
        shots.iter_mut().filter(|shot| is_lost(shot)).for_each(|shot| shot.taken = None);
    }
    Ok(Film { choice, shots, divergence })
}

/// Runs the simulation up to the last moment and keeps the positions at each moment.
fn take(
    shots: &mut [Shot],
    simulation: &mut OrderedSimulation,
    time: TimeSpan,
    choice: &Choice,
) -> Result<Option<Divergence>, HarnessError> {
    look(shots, simulation.moving());
    let Some(last) = shots.iter().filter(|s| s.taken.is_none()).map(|s| s.due).reduce(f64::max)
    else {
        return Ok(None);
    };
    let span = TimeSpan { duration_s: last, ..time };
    let (whole, rest) = span.steps();
    let bar = bar(choice.method().id, whole + u64::from(rest.is_some()));
    let outcome = simulation.simulate(span, |runner| {
        runner.observe(|moment| {
            bar.as_ref().inspect(|bar| bar.set_position(moment.step));
            look(shots, moment.moving());
        })
    })?;
    bar.inspect(|bar| bar.finish_and_clear());
    Ok(outcome.divergence)
}

/// Keeps the positions for each moment that the run has reached.
fn look(shots: &mut [Shot], moving: Moving<'_>) {
    let is_due = |shot: &&mut Shot| shot.taken.is_none() && moving.time() >= shot.due - EARLY;
    for shot in shots.iter_mut().filter(is_due) {
        shot.taken = Some((moving.time(), moving.display_positions()));
    }
}

/// Reads a size.
fn size(text: &str) -> Result<[u32; 2], Violation> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let in_range = |side: &u32| (SIDES[0]..=SIDES[1]).contains(side);
    sides.filter(|sides: &[u32; 2]| sides.iter().all(in_range)).ok_or_else(|| {
        let expected = format!("WIDTHxHEIGHT, each {} to {} pixels", SIDES[0], SIDES[1]);
        refusal("--size", text, &expected)
    })
}

/// The moments that the user wants, or the end.
fn moments(times: &[f64], time: TimeSpan) -> Result<Vec<f64>, Violation> {
    let end = [time.duration_s];
    let times = if times.is_empty() { &end[..] } else { times };
    let is_wrong = |due: &&f64| !(0.0..=time.duration_s).contains(*due);
    match times.iter().find(is_wrong) {
        Some(due) => {
            let expected = format!("a time from 0 to the duration, {} s", time.duration_s);
            Err(refusal("--time", due, &expected))
        }
        None => Ok(times.to_vec()),
    }
}

/// One file name for each picture.
fn numbered(out: &Path, count: usize) -> Vec<PathBuf> {
    if count == 1 {
        return vec![out.to_owned()];
    }
    let [stem, extension] = [out.file_stem(), out.extension()]
        .map(|part| part.unwrap_or_default().display().to_string());
    let dot = if extension.is_empty() { "" } else { "." };
    (1..=count).map(|n| out.with_file_name(format!("{stem}-{n}{dot}{extension}"))).collect()
}
