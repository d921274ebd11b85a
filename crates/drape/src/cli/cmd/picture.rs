//! `drape picture`.

use crate::cli::exit::Diverged;
use crate::cli::input::{files, in_file, load};
use crate::cli::limit::LimitArguments;
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
    /// Id of a method; settings follow a colon
    #[arg(long, default_value = "backward-euler")]
    method: String,
    /// A setting of the method; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Time step, s (default: of the scene; a discretised system has none)
    #[arg(long, allow_negative_numbers = true)]
    dt: Option<f64>,
    /// Simulated time, s (default: of the scene; a discretised system has none)
    #[arg(long, allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Moment of the picture, s; may be repeated (default: the end). The picture shows the first
    /// step that ends then or later
    #[arg(long = "time", value_name = "S", allow_negative_numbers = true)]
    times: Vec<f64>,
    /// File for the picture, or - for standard output; several pictures get numbers: FILE-1.png
    /// and so on
    #[arg(long, value_name = "FILE.png", default_value = "picture.png")]
    out: PathBuf,
    /// Size in pixels; each side from 64 to 4096
    #[arg(long, value_name = "WxH", default_value = "960x720")]
    size: String,
    /// Camera: auto, front, side, top, or AZIMUTH,ELEVATION in degrees
    #[arg(long, value_name = "VIEW", default_value = "auto", allow_hyphen_values = true)]
    camera: String,
    #[command(flatten)]
    limit: LimitArguments,
}

/// Shortest and longest side of a picture, pixels.
const SIDES: [u32; 2] = [64, 4096];
/// Seconds by which a step may end too early: round-off of a sum of steps.
const EARLY: f64 = 1e-9;

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
        .map_err(|error| refusal("--camera", &arguments.camera, &error.to_string()))?;
    let choice = Choice::parse(&arguments.method, &arguments.settings)
        .map_err(|error: MethodError| HarnessError::from(error))?;
    let input = load(&arguments.scene, arguments.limit, Some(&choice))?;
    let time = drape_harness::time_span(arguments.dt, arguments.duration, &input)?;
    let mut shots = shots(&arguments.times, time)?;
    let inputs = files(&arguments.scene, &input);
    if shots.len() > 1 && is_stream(&arguments.out) {
        let expected = format!("FILE.png: {} pictures need a file each", shots.len());
        return Err(refusal("--out", &arguments.out.display().to_string(), &expected).into());
    }
    let sinks = numbered(&arguments.out, shots.len());
    let sink = |file: &PathBuf| Sink::check("--out", file, &inputs);
    let sinks = sinks.iter().map(sink).collect::<Result<Vec<_>, _>>()?;
    let spec = input.spec();
    let mut simulation = OrderedSimulation::new(spec, &choice)
        .map_err(|violation| in_file(&arguments.scene, violation))?;
    let subject = Subject::new(spec, simulation.obstacles());
    let divergence = take(&mut shots, &mut simulation, time, &choice)
        .map_err(|error| error.in_scene(&arguments.scene))?;
    if let Some(divergence) = &divergence {
        // Positions after a divergence show nothing.
        let is_lost = |shot: &Shot| shot.taken.as_ref().is_some_and(|(t, _)| *t >= divergence.time);
        shots.iter_mut().filter(|shot| is_lost(shot)).for_each(|shot| shot.taken = None);
    }
    // All pictures share one camera, so that they can be compared.
    let taken = || shots.iter().filter_map(|shot| shot.taken.as_ref());
    let points: Vec<Vec3> = taken().flat_map(|(t, x)| subject.at(*t).points(x)).collect();
    let camera = Camera::fit(view, &points, f64::from(size[0]) / f64::from(size[1]));
    for (shot, sink) in shots.iter().zip(&sinks) {
        let (mut image, time_s) = match (&shot.taken, &divergence) {
            (None, Some(divergence)) => {
                let reason = format!("diverged at t = {:.4} s", divergence.time);
                (Image::failure(size, &reason), shot.due)
            }
            (None, None) => (Image::failure(size, "not reached"), shot.due),
            (Some((t, x)), _) => (draw(&subject.at(*t), x, &camera, size), *t),
        };
        let method = choice.method().id;
        let label = format!("{}, {method}, h = {} s, t = {time_s:.4} s", spec.name, time.step_s);
        let bottom = size[1].saturating_sub(Font::Small.height() + 8);
        image.write(&label, 10, bottom, Font::Small, Colour::GREY);
        sink.write(&image.png()?)?;
    }
    let Some(divergence) = divergence else { return Ok(()) };
    Err(Diverged(format!(
        "{} diverged at step {} (t = {} s): {}; pictures from then on show no cloth",
        choice.full_id(),
        divergence.step,
        divergence.time,
        divergence.criterion
    ))
    .into())
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

fn refusal(key: &str, value: &str, expected: &str) -> Violation {
    Violation { path: key.to_owned(), value: value.to_owned(), expected: expected.to_owned() }
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
fn shots(times: &[f64], time: TimeSpan) -> Result<Vec<Shot>, Violation> {
    let end = [time.duration_s];
    let times = if times.is_empty() { &end[..] } else { times };
    let check = |&due: &f64| {
        if due >= 0.0 && due <= time.duration_s {
            return Ok(Shot { due, taken: None });
        }
        let expected = format!("a time from 0 to the duration, {} s", time.duration_s);
        Err(refusal("--time", &due.to_string(), &expected))
    };
    times.iter().map(check).collect()
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
