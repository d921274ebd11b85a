//! `drape reproduce`: all experiments, the long ones apart.

use super::experiment::Run;
use crate::cli::progress::Place;
use drape_harness::studies::{Study, all, find, is_long};
use drape_report::tell;
use std::path::PathBuf;
use std::time::{Duration, Instant};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder for the results [default: results; with --quick: results-quick; with added or chosen
    /// methods: results-own]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    methods: super::experiment::MethodArguments,
    /// Compute only a subset of the cells, and no timings
    #[arg(long)]
    quick: bool,
    /// Run only the experiments that a full run leaves out: large cloth, long motions, hard cases,
    /// what the modelled times rest on, and side studies (--quick runs a part of them)
    #[arg(long, conflicts_with_all = ["quick", "only"])]
    long: bool,
    /// Begin nothing after this many minutes. animation-long then ends, and its record names what is
    /// missing. The next run continues and repeats the cell that was interrupted
    #[arg(long, value_name = "N", requires = "long", conflicts_with = "shard", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    minutes: Option<u64>,
    #[command(flatten)]
    shard: super::experiment::ShardArgument,
    /// Run only these experiments, separated by commas
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Start from the beginning and discard the cells that an interrupted run has finished
    #[arg(long)]
    fresh: bool,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let begin = Instant::now();
    arguments.methods.choose()?;
    let out = super::experiment::folder(arguments.out.as_deref(), arguments.quick);
    let chosen = match arguments.only.as_slice() {
        [] => all()
            .iter()
            .filter(|study| arguments.quick || is_long(**study) == arguments.long)
            .copied()
            .collect(),
        names => names.iter().map(|name| find(name)).collect::<Result<Vec<_>, _>>()?,
    };
    let unfinished = super::experiment::enter(&out, arguments.fresh)?;
    let until = arguments.minutes.map(|minutes| begin + Duration::from_secs(60 * minutes));
    let run =
        Run { out: &out, quick: arguments.quick, long: false, unfinished: &unfinished, until };
    if arguments.shard.compute(&run, &chosen)? {
        return Ok(());
    }
    let is_whole = record_all(&run, &chosen)?;
    super::report::draw(&out)?;
    if is_whole {
        unfinished.leave(chosen.iter().map(|study| study.name()))?;
    } else {
        // The journals of finished studies stay, so that the next command does not repeat them.
        tell!("not all is done: the same command goes on");
    }
    if arguments.only.is_empty() && !arguments.long && !arguments.quick {
        let long = || all().iter().filter(|study| is_long(**study)).map(|study| study.name());
        let told = long().collect::<Vec<_>>().join(", ");
        let is_there = |name| out.join(name).with_extension("json").exists();
        if long().all(is_there) {
            tell!("left as they were: {told}");
        } else {
            tell!(
                "left out: {told}; without them the report lacks some sections and the table of uses"
            );
        }
        tell!("`drape reproduce --long` runs them, and goes on where it stopped");
        tell!(
            "taken by neither: the timings of regret (`drape experiment regret`) and of \
             work-precision (`drape experiment work-precision --timings`)"
        );
    }
    tell!(
        "done in {:.1} s; read {}",
        begin.elapsed().as_secs_f64(),
        out.join("report.html").display()
    );
    Ok(())
}

/// Records the studies one after the other, and begins none when the time is over. Returns whether
/// all cells of all studies are there.
fn record_all(run: &Run<'_>, chosen: &[&'static dyn Study]) -> anyhow::Result<bool> {
    let mut is_whole = true;
    for (place, study) in Place::each(chosen) {
        if run.until.is_some_and(|until| Instant::now() >= until) {
            tell!("{}: not begun", study.name());
            is_whole = false;
        } else {
            is_whole &= run.record(study, place)?;
        }
    }
    Ok(is_whole)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use drape_harness::Unfinished;

    #[test]
    fn no_study_begins_when_the_time_is_over_and_the_rest_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let unfinished = Unfinished::enter(out, false).unwrap();
        let chosen = [find("order").unwrap()];
        let run = |until| Run { out, quick: true, long: false, unfinished: &unfinished, until };
        assert!(!record_all(&run(Some(Instant::now())), &chosen).unwrap());
        assert!(!out.join("order.json").exists());
        assert!(record_all(&run(None), &chosen).unwrap());
        assert!(out.join("order.json").exists());
        // What is finished stays so, until the command that finds all of it whole.
        let later = Some(Instant::now() + Duration::from_secs(600));
        assert!(record_all(&run(later), &chosen).unwrap());
    }
}
