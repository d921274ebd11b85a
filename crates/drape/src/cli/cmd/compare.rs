//! `drape compare`.

use super::refusal;
use crate::cli::input::{files, in_file, load};
use crate::cli::interrupt::{self, Interrupted};
use crate::cli::limit::LimitArguments;
use crate::cli::number::{fraction, number};
use crate::cli::output::{Sink, check_folder, print};
use crate::cli::progress::Clock as Progress;
use drape_harness::compare::facts::{End, Facts, Metric};
use drape_harness::compare::{
    Clock, DOMINATED, Options, PageError, Request, advise, journal_name, lines, page_time, quoted,
    record, resume, write,
};
use drape_harness::{HarnessError, Shard, Unfinished, start_threads};
use drape_model::Violation;
use drape_report::tell;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled scene, or a file with a scene or a discretised system
    scene: String,
    /// Methods, separated by commas, with settings after a colon: imex-euler,xpbd:order=2 (default:
    /// all, in the forms that the studies run)
    #[arg(long, value_name = "ID,ID")]
    methods: Option<String>,
    /// Measure of the error: distance of the surfaces, or of the particles
    #[arg(long, value_enum, default_value = "shape")]
    metric: MetricArgument,
    /// Greatest error, m (default: a hundredth of the longest side of the cloth)
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = number)]
    target: Option<f64>,
    /// Length of a frame, s: a number or a fraction
    #[arg(long, value_name = "S", default_value = "1/60", allow_hyphen_values = true)]
    frame: String,
    /// Limit of the wall time: 90, 90s, 5m or 1h
    #[arg(long, value_name = "TIME", default_value = "60s", allow_hyphen_values = true)]
    budget: String,
    /// Simulated time, s (default: of the scene; a discretised system has none)
    #[arg(long, allow_negative_numbers = true, value_parser = number)]
    duration: Option<f64>,
    /// Seed of the perturbed starts that measure the noise
    #[arg(long, value_name = "N", default_value_t = 20)]
    seed: u64,
    /// Run every form until it meets the target, even if another leads by far
    #[arg(long)]
    exhaustive: bool,
    /// Folder for compare.json and compare.html
    #[arg(long, value_name = "DIR", default_value = "compare")]
    out: PathBuf,
    /// Start from the beginning and discard the findings of an interrupted comparison
    #[arg(long)]
    fresh: bool,
    /// Run only the forms whose hash belongs to shard I of N, and give no advice; --parts joins
    /// shards. Run each shard on a machine of its own, because its times count
    #[arg(long, value_name = "I/N", conflicts_with = "parts")]
    shard: Option<Shard>,
    /// Folders of shards of the same comparison. The command joins their findings and runs the
    /// forms that are missing in all of them
    #[arg(long, value_name = "DIR,DIR", value_delimiter = ',')]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    limit: LimitArguments,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum MetricArgument {
    /// Mean distance of the surfaces
    Shape,
    /// Root mean square distance of the particles
    Trajectory,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut options = Options {
        methods: arguments.methods.clone(),
        metric: match arguments.metric {
            MetricArgument::Shape => Metric::Shape,
            MetricArgument::Trajectory => Metric::Trajectory,
        },
        target_m: arguments.target,
        rate: rate(&arguments.frame)?,
        budget: budget(&arguments.budget)?,
        began: Some(crate::cli::began()),
        reserve: Duration::ZERO,
        seed: arguments.seed,
        exhaustive: arguments.exhaustive,
        dominated: DOMINATED,
        clock: Clock::Wall,
        shard: shard(arguments.shard)?,
        interrupt: Some(interrupt::flag()),
    };
    let input = load(&arguments.scene, arguments.limit, None)?;
    let step_s = 1.0 / options.rate;
    let time = drape_harness::time_span(Some(step_s), arguments.duration, &input)?;
    check_frame(&arguments.frame, step_s, time.duration_s)?;
    check_folder("--out", &arguments.out)?;
    let inputs = files(&arguments.scene, &input);
    for name in ["compare.json", "compare.html"] {
        Sink::check("--out", &arguments.out.join(name), &inputs)?;
    }
    start_threads()?;
    let spec = input.spec();
    // A shard writes no page.
    if options.shard.is_none() {
        options.reserve = page_time(spec).map_err(|error| refused(error, &arguments.scene))?;
    }
    let name = journal_name(spec, time.duration_s, &options);
    check_parts(&arguments.parts, &name)?;
    let unfinished = Unfinished::enter(&arguments.out, arguments.fresh)?;
    if !arguments.parts.is_empty() {
        unfinished.join(&arguments.parts)?;
    }
    let journal = unfinished.journal(&name, false)?;
    if journal.cells() > 0 {
        tell!("drape: going on from {} findings in {}", journal.cells(), arguments.out.display());
    }
    let clock = Progress::new("compare", options.budget);
    let (scene, seconds) = (&arguments.scene, time.duration_s);
    let compared = resume(scene, spec, seconds, &options, &journal, &|tick| clock.show(tick));
    clock.end();
    let comparison = match compared {
        Ok(comparison) => comparison,
        Err(error) => {
            // A refused question leaves nothing behind.
            drop(journal);
            unfinished.leave([name.as_str()])?;
            return Err(refused(error, &arguments.scene));
        }
    };
    if let Some(shard) = options.shard {
        return part_is_done(arguments, shard, &comparison.facts);
    }
    let source = crate::cli::source();
    let command = arguments.command();
    let request = Request { options: &options, command: &command, source: &source };
    let record = record(&comparison, &request);
    let written =
        write(&arguments.out, record, &comparison, spec).map_err(|error| match error {
            PageError::Harness(error) => anyhow::Error::from(error),
            PageError::Report(error) => error.into(),
        })?;
    let mut text = lines(&comparison.facts, &advise(&comparison.facts)).join("\n");
    text.push('\n');
    for file in &written {
        tell!("wrote {}", file.display());
    }
    print(&text)?;
    if interrupt::is_set() {
        return Err(Interrupted(format!(
            "interrupted after {:.1} s; the advice is that of the runs until then; to go on: {}",
            comparison.facts.seconds,
            interrupt::command(&["--fresh"])
        ))
        .into());
    }
    drop(journal);
    Ok(unfinished.leave([name.as_str()])?)
}

/// Why a comparison was refused, with the file where the fault is in the scene.
fn refused(error: HarnessError, scene: &str) -> anyhow::Error {
    match error {
        HarnessError::Violation(violation) if !violation.path.starts_with("--") => {
            in_file(scene, violation).into()
        }
        other => other.in_scene(scene).into(),
    }
}

/// A shard that may be raced: the timed one has no meaning here.
fn shard(shard: Option<Shard>) -> Result<Option<Shard>, Violation> {
    match shard {
        Some(Shard::Timed) => {
            Err(refusal("--shard", "`timed`", "I/N: every run of a comparison is timed"))
        }
        shard => Ok(shard),
    }
}

/// Refuses the first part that holds no journal of this comparison.
fn check_parts(parts: &[PathBuf], name: &str) -> Result<(), Violation> {
    let journal = |part: &PathBuf| part.join(".unfinished").join(name).with_extension("journal");
    let lacks = |part: &&PathBuf| !journal(part).is_file();
    let Some(part) = parts.iter().find(lacks) else { return Ok(()) };
    let expected = "folders of `drape compare --shard` of the same scene with the same --metric, \
                    --target, --frame, --duration, --seed and --exhaustive, not yet joined";
    Err(refusal("--parts", format_args!("`{}`", part.display()), expected))
}

/// What a shard says when its forms have been raced, or the time is over.
fn part_is_done(arguments: &Arguments, shard: Shard, facts: &Facts) -> anyhow::Result<()> {
    let out = arguments.out.display();
    let left = facts.forms.iter().filter(|form| form.end == End::OutOfTime).count();
    if interrupt::is_set() {
        return Err(Interrupted(format!(
            "interrupted after {:.1} s; finished runs are kept in {out}; to go on: {}",
            facts.seconds,
            interrupt::command(&["--fresh"])
        ))
        .into());
    }
    let rest = if left > 0 { format!(", {left} of them not to their end") } else { String::new() };
    let forms = match facts.forms.len() {
        1 => "1 form was".to_owned(),
        more => format!("{more} forms were"),
    };
    tell!(
        "shard {shard}: {forms} raced{rest}; to join shards: drape compare {} --parts {out},…",
        quoted(&arguments.scene)
    );
    Ok(())
}

impl Arguments {
    /// The command line that asks the same.
    fn command(&self) -> String {
        let metric = match self.metric {
            MetricArgument::Shape => "shape",
            MetricArgument::Trajectory => "trajectory",
        };
        let mut words = vec!["drape".to_owned(), "compare".to_owned(), self.scene.clone()];
        let mut add = |key: &str, value: String| words.extend([key.to_owned(), value]);
        if let Some(methods) = &self.methods {
            add("--methods", methods.clone());
        }
        add("--metric", metric.to_owned());
        if let Some(target) = self.target {
            add("--target", target.to_string());
        }
        add("--frame", self.frame.clone());
        add("--budget", self.budget.clone());
        if let Some(duration) = self.duration {
            add("--duration", duration.to_string());
        }
        add("--seed", self.seed.to_string());
        if self.exhaustive {
            words.push("--exhaustive".to_owned());
        }
        let words: Vec<String> =
            words.iter().map(|word| drape_harness::compare::quoted(word)).collect();
        words.join(" ")
    }
}

/// Frames a second, from the length of one.
fn rate(text: &str) -> Result<f64, Violation> {
    let rate = fraction(text).map(|(a, b)| b / a);
    let expected = "a length in seconds above 0, as a number or a fraction such as 1/60";
    rate.filter(|rate| *rate > 0.0 && rate.is_finite())
        .ok_or_else(|| refusal("--frame", format_args!("`{text}`"), expected))
}

/// Refuses a frame that is longer than the motion: often it is a number of frames a second.
fn check_frame(text: &str, step_s: f64, duration_s: f64) -> Result<(), Violation> {
    let expected = format!(
        "a length of at most the {duration_s} s of the motion; for 60 frames a second, 1/60"
    );
    let is_short = step_s <= duration_s * (1.0 + 1e-9);
    is_short.then_some(()).ok_or_else(|| refusal("--frame", format_args!("`{text}`"), &expected))
}

/// A time with its unit; seconds without one.
fn budget(text: &str) -> Result<Duration, Violation> {
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0), ("", 1.0)];
    let read = |(unit, factor): (&str, f64)| {
        let number = text.trim().strip_suffix(unit)?.trim().parse::<f64>().ok()?;
        Duration::try_from_secs_f64(number * factor).ok()
    };
    let expected = "a time such as 90, 90s, 5m or 1h";
    units
        .into_iter()
        .find_map(read)
        .ok_or_else(|| refusal("--budget", format_args!("`{text}`"), expected))
}

#[cfg(test)]
mod tests {
    use super::{budget, check_frame, rate};
    use std::time::Duration;

    #[test]
    fn frames_and_budgets_are_read_or_refused() {
        assert_eq!(rate("1/60"), Ok(60.0));
        assert_eq!(rate("0.04"), Ok(25.0));
        for wrong in ["", "0", "-1/60", "1/0", "a", "1/2/3", "inf", "nan"] {
            assert!(rate(wrong).is_err(), "{wrong}");
        }
        assert_eq!(check_frame("1/60", 1.0 / 60.0, 1.0), Ok(()));
        let refused = check_frame("60", 60.0, 1.0).err().map(|refusal| refusal.expected);
        assert!(refused.is_some_and(|expected| expected.ends_with("60 frames a second, 1/60")));
        let seconds = |s| Ok(Duration::from_secs_f64(s));
        for (text, expected) in [("90", 90.0), ("90s", 90.0), ("1.5m", 90.0), ("250ms", 0.25)] {
            assert_eq!(budget(text), seconds(expected), "{text}");
        }
        for wrong in ["", "s", "-1", "1d", "nan", "1e400"] {
            assert!(budget(wrong).is_err(), "{wrong}");
        }
    }
}
