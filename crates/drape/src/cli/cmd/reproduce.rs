//! `drape reproduce`: all experiments.

use super::experiment::Run;
use crate::cli::progress::Place;
use drape_harness::studies::{all, find, is_long};
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
    /// Run only the long experiments, which a full run leaves out: large cloth, long motions, hard
    /// cases, and what the modelled times rest on (--quick runs a part of them)
    #[arg(long, conflicts_with_all = ["quick", "only"])]
    long: bool,
    /// Begin nothing after this many minutes. animation-long then ends, and its record names what is
    /// missing. The next run continues and repeats the cell that was interrupted
    #[arg(long, value_name = "N", requires = "long", value_parser = clap::value_parser!(u64).range(1..=100_000))]
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
    let mut written = Vec::new();
    for (place, experiment) in Place::each(&chosen) {
        if until.is_some_and(|until| Instant::now() >= until) {
            tell!("{}: not begun", experiment.name());
        } else if run.record(experiment, place)? {
            written.push(experiment.name());
        }
    }
    super::report::draw(&out)?;
    let is_whole = written.len() == chosen.len();
    unfinished.leave(written)?;
    if !is_whole {
        tell!("cells are missing: the same command goes on");
    }
    if arguments.only.is_empty() && !arguments.long && !arguments.quick {
        let long = all().iter().filter(|study| is_long(**study)).map(|study| study.name());
        let long = long.collect::<Vec<_>>().join(", ");
        tell!(
            "left as they were: {long}; `drape reproduce --long` runs them, and goes on where it \
             stopped"
        );
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
