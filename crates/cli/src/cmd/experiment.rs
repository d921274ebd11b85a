//! `drape experiment`.

use crate::progress::Bars;
use drape_harness::experiments::{Context, Experiment, find};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of the experiment (see `drape list experiments`)
    name: String,
    /// Folder for the results [default: results, or results-quick with --quick]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Only the quick subset of the cells
    #[arg(long)]
    quick: bool,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let out = folder(arguments.out.as_deref(), arguments.quick);
    record(find(&arguments.name)?, &out, arguments.quick)?;
    super::report::draw(&out)
}

/// Where results go: a quick subset never replaces full results unasked.
pub(crate) fn folder(out: Option<&Path>, quick: bool) -> PathBuf {
    out.unwrap_or(Path::new(if quick { "results-quick" } else { "results" })).to_owned()
}

/// Runs an experiment and writes its records.
pub(crate) fn record(experiment: &Experiment, out: &Path, quick: bool) -> anyhow::Result<()> {
    let figures = drape_report::figures_of(experiment.name);
    let progress = Bars::new(experiment.name);
    let context = Context { out, quick, figures: &figures, progress: &progress };
    for file in experiment.run(&context)? {
        eprintln!("wrote {}", file.display());
    }
    Ok(())
}
