//! `drape experiment`.

use crate::cli::output::check_folder;
use crate::cli::progress::Bars;
use drape_harness::studies::{Context, Study, find};
use drape_harness::{HarnessError, Unfinished, methods, start_threads};
use drape_report::tell;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of the experiment (see `drape list experiments`)
    name: String,
    /// Folder for the results [default: results; with --quick: results-quick; with methods that
    /// were added or chosen: results-own]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    methods: MethodArguments,
    /// Compute only a subset of the cells
    #[arg(long)]
    quick: bool,
    /// Start anew and discard the cells that an interrupted run has finished
    #[arg(long)]
    fresh: bool,
}

/// The methods that studies compare.
#[derive(Debug, clap::Args)]
pub(crate) struct MethodArguments {
    /// Compare only these methods, in studies that compare all: ids, or program:COMMAND for a
    /// program of your own; separated by commas, or given several times
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    methods: Vec<String>,
}

impl MethodArguments {
    /// Restricts the studies.
    pub(crate) fn choose(&self) -> Result<(), HarnessError> {
        if !self.methods.is_empty() {
            methods::choose(self.methods.iter().map(String::as_str))?;
        }
        Ok(())
    }
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let experiment = find(&arguments.name)?;
    arguments.methods.choose()?;
    let out = folder(arguments.out.as_deref(), arguments.quick);
    let unfinished = enter(&out, arguments.fresh)?;
    record(experiment, &out, arguments.quick, &unfinished)?;
    super::report::draw(&out)?;
    Ok(unfinished.leave([experiment.name()])?)
}

/// The folder for results. By default neither a quick subset nor results of other methods replace
/// full results.
pub(crate) fn folder(out: Option<&Path>, quick: bool) -> PathBuf {
    let usual = match (methods::are_ours_alone(), quick) {
        (false, _) => "results-own",
        (true, true) => "results-quick",
        (true, false) => "results",
    };
    out.unwrap_or(Path::new(usual)).to_owned()
}

/// Tells what programs of the user did wrong: cells of a study keep no sentences.
fn tell_failures() {
    for (sentence, count) in methods::program_failures() {
        let often = if count > 1 { format!(" ({count} times)") } else { String::new() };
        tell!("drape: warning: {sentence}{often}");
    }
}

/// Checks the folder for results, starts the threads and takes up what is unfinished there.
pub(crate) fn enter(out: &Path, fresh: bool) -> anyhow::Result<Unfinished> {
    check_folder("--out", out)?;
    start_threads()?;
    compare_commits(out);
    Ok(Unfinished::enter(out, fresh)?)
}

/// Warns where the results lie in the repository of the program, but at another commit.
fn compare_commits(out: &Path) {
    let source = crate::cli::source();
    if let (Some(built), Some(there)) = (&source.commit, source.other_commit_at(out)) {
        tell!(
            "drape: warning: {} is at commit {there}; this program, which the records name, was \
             built from {built}",
            out.display()
        );
    }
}

/// Runs an experiment and writes its records. It skips the cells, or the whole experiment, that an
/// interrupted run has finished.
pub(crate) fn record(
    study: &dyn Study,
    out: &Path,
    quick: bool,
    unfinished: &Unfinished,
) -> anyhow::Result<()> {
    let name = study.name();
    let journal = unfinished.journal(name, quick)?;
    if journal.is_finished() {
        tell!("{name}: finished before the interruption");
        return Ok(());
    }
    if journal.was_finished() {
        tell!("{name}: a file is missing or changed since: writing all again");
    }
    if journal.dropped() > 0 {
        tell!("{name}: {} lines of the journal are damaged and ignored", journal.dropped());
    }
    if journal.cells() > 0 {
        tell!("{name}: {} cells were finished before the interruption", journal.cells());
    }
    let progress = Bars::new(name);
    let source = crate::cli::source();
    let context = Context {
        out,
        quick,
        progress: &progress,
        journal: &journal,
        allocated: crate::cli::allocated(),
        source: &source,
    };
    let files = study.run(&context);
    tell_failures();
    let files = files?;
    for file in &files {
        tell!("wrote {}", file.display());
    }
    Ok(journal.finish(&files)?)
}
