//! `drape experiment`.

use crate::progress::Bars;
use drape_harness::experiments::{Context, Experiment, find};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of the experiment (see `drape list experiments`)
    name: String,
    /// Folder for the results
    #[arg(long, default_value = "results")]
    out: PathBuf,
    /// Only the quick subset of the cells
    #[arg(long)]
    quick: bool,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    record(find(&arguments.name)?, &arguments.out, arguments.quick)?;
    super::report::draw(&arguments.out)
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
