//! `drape merge`: parts of studies that were computed apart become records.

use super::experiment::{MethodArguments, Run};
use crate::cli::exit::Incomplete;
use crate::cli::progress::Place;
use drape_harness::studies::all;
use drape_report::tell;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder for the results
    out: PathBuf,
    /// Folders of runs with --shard. The command also joins the parts that an earlier merge left
    /// in OUT
    #[arg(value_name = "PART")]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    methods: MethodArguments,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    arguments.methods.choose()?;
    let out = &arguments.out;
    let unfinished = super::experiment::enter(out, false)?;
    let joined = unfinished.join(&arguments.parts)?;
    let run = Run { out, quick: joined.quick, long: false, unfinished: &unfinished, until: None };
    let is_joined = |name: &str| joined.experiments.iter().any(|joined| joined == name);
    let (mut counted, mut timed, mut written) = (0, Vec::new(), Vec::new());
    let studies: Vec<_> = all().iter().copied().filter(|s| is_joined(s.name())).collect();
    for (place, study) in Place::each(&studies) {
        let missing = run.join(study, place)?;
        for missing in &missing {
            tell!("{}: {missing}", study.name());
            if !missing.is_timed {
                counted += missing.numbers.len();
            } else if timed.last() != Some(&study.name()) {
                timed.push(study.name());
            }
        }
        if missing.is_empty() {
            written.push(study.name());
        }
    }
    if counted > 0 || !timed.is_empty() {
        return Err(incomplete(counted, &timed, arguments).into());
    }
    super::report::draw(out)?;
    unfinished.leave(written)?;
    tell!("merged; read {}", out.join("report.html").display());
    Ok(())
}

/// How many cells are missing, and what to do.
fn incomplete(counted: usize, timed: &[&str], arguments: &Arguments) -> Incomplete {
    let out = arguments.out.display();
    let way = if counted > 0 {
        format!(
            "{counted} cells are missing: run the shards again whose parts are unfinished, with \
             the same --out, then merge again; {out} keeps what is there"
        )
    } else {
        format!(
            "only timed cells are missing: run `drape reproduce --shard timed --only {} --out \
             {out}` on a machine that does nothing else, then `drape merge {out}`",
            timed.join(",")
        )
    };
    Incomplete(way)
}
