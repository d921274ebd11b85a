//! Frames of a run: a sequence of OBJ files, a glTF animation.

use super::refusal;
use crate::cli::number::number;
use crate::cli::output::{Sink, check_extension};
use drape_harness::{Moving, OrderedSimulation};
use drape_model::{SystemSpec, TimeSpan, Violation};
use drape_render::{Animation, Subject, animation, obj};
use drape_report::file::{probe, write_atomically};
use drape_report::tell;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct FrameArguments {
    /// Write each frame as an OBJ file into this new or empty folder. Obstacles go to
    /// obstacles.obj, or to a file for each frame if one moves
    #[arg(long, value_name = "DIR")]
    frames: Option<PathBuf>,
    /// Write the motion as one glTF 2.0 binary with a morph target for each frame; at most 1000
    /// frames
    #[arg(long, value_name = "FILE.glb")]
    animation: Option<PathBuf>,
    /// Frames in a simulated second [default: 25]. A frame shows the first step that ends at its
    /// time or later
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    fps: Option<f64>,
}

const USUAL_FPS: f64 = 25.0;
/// Most frames in a simulated second.
const MOST_FPS: f64 = 1e6;
/// Part of a frame by which a step may end before its frame, because of round-off.
const EARLY: f64 = 1e-6;

/// Writes the frames of a run.
pub(crate) struct Frames {
    subject: Subject,
    fps: f64,
    /// The next frame that is due.
    next: f64,
    /// Digits of a frame's number.
    digits: usize,
    folder: Option<(PathBuf, usize)>,
    animation: Option<(Sink, Animation)>,
    /// Why a frame could not be written. No frame is written after it.
    failure: Option<anyhow::Error>,
}

/// Greatest number of frames of a run.
fn most_frames(time: TimeSpan, fps: f64) -> u64 {
    let (whole, rest) = time.steps();
    let steps = whole + u64::from(rest.is_some());
    // A step gives at most one frame. A cast of a float saturates.
    steps.min((time.duration_s * fps + EARLY) as u64) + 1
}

impl Frames {
    /// Checks the options and writes the first frame. `None` if the user wants no frames. `taken`
    /// are the files of the scene and where the record goes.
    pub(crate) fn begin(
        arguments: &FrameArguments,
        spec: &SystemSpec,
        simulation: &OrderedSimulation,
        time: TimeSpan,
        (inputs, record): (&[PathBuf], Option<&Sink>),
    ) -> anyhow::Result<Option<Self>> {
        if let Some(fps) = arguments.fps {
            if !(fps > 0.0 && fps <= MOST_FPS) {
                let expected = format!("a number above 0 and at most {MOST_FPS:e}");
                return Err(refusal("--fps", fps, expected).into());
            }
            if arguments.frames.is_none() && arguments.animation.is_none() {
                let expected = "`--frames DIR` or `--animation FILE.glb` beside it".to_owned();
                return Err(refusal("--fps", fps, expected).into());
            }
        }
        let fps = arguments.fps.unwrap_or(USUAL_FPS);
        let most = most_frames(time, fps);
        let subject = || Subject::new(spec, simulation.obstacles());
        let animation = arguments.animation.as_ref().map(|file| {
            check_extension("--animation", file, "glb", "glTF 2.0 binary")?;
            let sink = Sink::check("--animation", file, inputs)?;
            record.map_or(Ok(()), |record| sink.check_apart("--animation", record, "--out"))?;
            if most > animation::MOST_FRAMES {
                let expected = format!(
                    "at most {} frames: a smaller --fps or --duration",
                    animation::MOST_FRAMES
                );
                return Err(refusal("--animation", format!("{most} frames"), expected));
            }
            Animation::check_size(spec.particles.mass_kg.len(), most).map_err(|error| {
                refusal("--animation", format!("{most} frames"), format!("a smaller file: {error}"))
            })?;
            Ok((sink, Animation::new(subject())))
        });
        let animation = animation.transpose()?;
        if let Some(folder) = &arguments.frames {
            prepare(folder)?;
        }
        if arguments.frames.is_none() && animation.is_none() {
            return Ok(None);
        }
        let mut frames = Self {
            subject: subject(),
            fps,
            next: 0.0,
            digits: (most - 1).to_string().len().max(4),
            folder: arguments.frames.clone().map(|folder| (folder, 0)),
            animation,
            failure: None,
        };
        if let Some((folder, _)) = &frames.folder
            && !frames.subject.solids.is_empty()
            && !frames.subject.moves()
        {
            let text = obj::solids(&frames.subject.solids);
            write_atomically(&folder.join("obstacles.obj"), text.as_bytes())?;
        }
        frames.look(simulation.moving());
        Ok(Some(frames))
    }

    /// Writes a frame if one is due.
    pub(crate) fn look(&mut self, moving: Moving<'_>) {
        let frame = moving.time() * self.fps + EARLY;
        if frame < self.next || self.failure.is_some() || !moving.is_finite() {
            return;
        }
        self.next = frame.floor() + 1.0;
        let x = moving.display_positions();
        if let Some((folder, count)) = &mut self.folder {
            let write = |kind: &str, text: String| {
                let name = format!("{kind}-{count:0digits$}.obj", digits = self.digits);
                write_atomically(&folder.join(name), text.as_bytes())
            };
            let mut outcome = write("frame", obj::cloth(&self.subject, &x));
            if outcome.is_ok() && self.subject.moves() {
                let solids = &self.subject.at(moving.time()).solids;
                outcome = write("obstacles", obj::solids(solids));
            }
            match outcome {
                Ok(()) => *count += 1,
                Err(error) => self.failure = Some(error.into()),
            }
        }
        if let Some((_, animation)) = &mut self.animation {
            // A frame beyond the range of float32 belongs to a run that diverges: leave it out.
            let _ = animation.push(moving.time(), &x);
        }
    }

    /// Whether the animation goes to standard output.
    pub(crate) fn is_standard(&self) -> bool {
        self.animation.as_ref().is_some_and(|(sink, _)| sink.is_standard())
    }

    /// Writes the animation and reports the files.
    pub(crate) fn finish(self) -> anyhow::Result<()> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        if let Some((folder, count)) = &self.folder {
            tell!("wrote {count} frames into {}", folder.display());
        }
        if let Some((sink, animation)) = &self.animation {
            sink.write(&animation.glb()?)?;
        }
        Ok(())
    }
}

/// Makes a folder for frames. A folder with files is refused, so that frames of two runs never mix.
fn prepare(folder: &Path) -> Result<(), Violation> {
    let refuse = |reason: String| {
        let expected = format!("a new or empty folder that can be written ({reason})");
        refusal("--frames", folder.display(), expected)
    };
    let made = std::fs::create_dir_all(folder).and_then(|()| std::fs::read_dir(folder));
    let mut entries = made.map_err(|error| refuse(error.to_string()))?;
    if entries.next().is_some() {
        return Err(refuse("it holds files".to_owned()));
    }
    probe(&folder.join("frame")).map_err(|error| refuse(error.to_string()))
}
