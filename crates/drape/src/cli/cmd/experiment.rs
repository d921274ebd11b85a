//! `drape experiment`.

use crate::cli::exit::Incomplete;
use crate::cli::interrupt;
use crate::cli::output::check_folder;
use crate::cli::progress::{Bars, Place};
use drape_harness::studies::{Context, Study, find};
use drape_harness::{HarnessError, Journal, Missing, Shard, Unfinished, methods, start_threads};
use drape_report::tell;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of the experiment (see `drape list experiments`)
    name: String,
    /// Folder for the results [default: results; with --quick: results-quick; with added or chosen
    /// methods: results-own]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    methods: MethodArguments,
    /// Compute only a subset of the cells
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    shard: ShardArgument,
    /// Start from the beginning and discard the cells that an interrupted run has finished
    #[arg(long)]
    fresh: bool,
    /// Take only the timings anew, of the runs that the record in the folder has (animation,
    /// animation-long, rest and work-precision)
    #[arg(long, conflicts_with_all = ["quick", "shard", "methods"])]
    timings: bool,
    /// Take the timings N times, one round after the other; of each run the quickest timing counts
    #[arg(long, value_name = "N", requires = "timings", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=20))]
    rounds: u32,
}

/// The methods that studies compare.
#[derive(Debug, clap::Args)]
pub(crate) struct MethodArguments {
    /// In studies that compare all methods, compare only these: ids, or program:COMMAND for a
    /// program of your own; separate them by commas, or repeat the option
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    methods: Vec<String>,
}

/// The part of the cells that is computed.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct ShardArgument {
    /// Compute only part I of N of the cells, or `timed` for the timed cells. The folder of --out
    /// then holds the parts that `drape merge` joins, and no record
    #[arg(long, value_name = "I/N", requires = "out")]
    shard: Option<Shard>,
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
    let run = Run {
        out: &out,
        quick: arguments.quick,
        long: arguments.shard.shard.is_none(),
        unfinished: &unfinished,
        until: None,
    };
    if arguments.shard.compute(&run, &[experiment])? {
        return Ok(());
    }
    for (place, experiment) in Place::each(&[experiment]) {
        if arguments.timings {
            run.retime(experiment, place, arguments.rounds)?;
        } else {
            run.record(experiment, place)?;
        }
    }
    super::report::draw(&out)?;
    let timings = timings_of(experiment);
    let journal = if arguments.timings { &timings } else { experiment.name() };
    Ok(unfinished.leave([journal])?)
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
    interrupt::end_and_tell();
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

/// What experiments run with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run<'a> {
    /// Folder for the results.
    pub(crate) out: &'a Path,
    /// Only the quick subset of the cells.
    pub(crate) quick: bool,
    /// Also the timings of ordinary studies that take long.
    pub(crate) long: bool,
    /// What is unfinished in the folder.
    pub(crate) unfinished: &'a Unfinished,
    /// When no cell of `animation-long` is begun any more.
    pub(crate) until: Option<Instant>,
}

impl Run<'_> {
    /// Runs an experiment and writes its records. It skips the cells, or the whole experiment, that
    /// an interrupted run has finished. Returns whether all cells are there.
    pub(crate) fn record(&self, study: &dyn Study, place: Place) -> anyhow::Result<bool> {
        let name = study.name();
        place.tell(name);
        let journal = self.unfinished.journal(name, self.quick)?.until(self.until);
        if journal.is_finished() {
            tell!("{name}: finished before the interruption");
            return Ok(true);
        }
        if journal.was_finished() {
            tell!("{name}: a file is missing or changed since: writing all again");
        }
        tell_kept(name, &journal, "before the interruption");
        let files = self.go(study, &journal, place)?;
        let missing = journal.missing();
        if missing.is_empty() {
            journal.finish(&files)?;
        }
        missing.iter().for_each(|missing| tell!("{name}: {missing}"));
        Ok(missing.is_empty())
    }

    /// Takes the timings of the runs of a record anew, in so many rounds.
    fn retime(&self, study: &dyn Study, place: Place, rounds: u32) -> anyhow::Result<()> {
        let name = timings_of(study);
        let journal = self.unfinished.journal(&name, self.quick)?;
        tell_kept(&name, &journal, "before the interruption");
        let files = self.with(study, &journal, place, |context| study.retime(context, rounds))?;
        Ok(journal.finish(&files)?)
    }

    /// Writes the records of an experiment if all its cells are there, and computes none. Returns
    /// what is missing.
    pub(crate) fn join(&self, study: &dyn Study, place: Place) -> anyhow::Result<Vec<Missing>> {
        let name = study.name();
        place.tell(name);
        let journal = self.unfinished.journal(name, self.quick)?.for_reading();
        tell_kept(name, &journal, "by the parts");
        match self.go(study, &journal, place) {
            Ok(files) => {
                journal.finish(&files)?;
                Ok(Vec::new())
            }
            Err(HarnessError::Elsewhere) => Ok(journal.missing()),
            Err(error) => Err(error.into()),
        }
    }

    /// Computes the cells of a shard.
    fn part(&self, study: &dyn Study, shard: Shard, place: Place) -> anyhow::Result<()> {
        let name = study.name();
        place.tell(name);
        let journal = self.unfinished.journal(name, self.quick)?.for_shard(shard);
        if journal.has_shard(shard) {
            tell!("{name}: shard {shard} was finished before");
            return Ok(());
        }
        tell_kept(name, &journal, "before the interruption");
        match self.go(study, &journal, place) {
            Ok(_) => Ok(()),
            // What is timed may hang on what is counted.
            Err(HarnessError::Elsewhere) if shard == Shard::Timed && lacks_counts(&journal) => {
                Err(Incomplete(format!(
                    "{name}: cells are missing that are counted and not timed: merge the other \
                     shards into {} first",
                    self.out.display()
                ))
                .into())
            }
            // Its own cells are done.
            Err(HarnessError::Elsewhere) => Ok(journal.end_shard(shard)?),
            Err(error) => Err(error.into()),
        }
    }

    fn go(
        &self,
        study: &dyn Study,
        journal: &Journal,
        place: Place,
    ) -> Result<Vec<PathBuf>, HarnessError> {
        self.with(study, journal, place, |context| study.run(context))
    }

    /// Does a part of a study, and tells which files it wrote.
    fn with(
        &self,
        study: &dyn Study,
        journal: &Journal,
        place: Place,
        work: impl Fn(&Context<'_>) -> Result<Vec<PathBuf>, HarnessError>,
    ) -> Result<Vec<PathBuf>, HarnessError> {
        let progress = Bars::new(study.name(), place);
        let source = crate::cli::source();
        let context = Context {
            out: self.out,
            quick: self.quick,
            long: self.long,
            progress: &progress,
            journal,
            allocated: crate::cli::allocated(),
            source: &source,
        };
        let files = work(&context);
        tell_failures();
        let files = files?;
        for file in &files {
            tell!("wrote {}", file.display());
        }
        Ok(files)
    }
}

impl ShardArgument {
    /// Computes the shard of each study, if one is asked for.
    pub(crate) fn compute(
        self,
        run: &Run<'_>,
        studies: &[&'static dyn Study],
    ) -> anyhow::Result<bool> {
        let Some(shard) = self.shard else { return Ok(false) };
        // A part that is killed early still tells which studies it is a part of.
        for study in studies {
            run.unfinished.journal(study.name(), run.quick)?;
        }
        for (place, study) in Place::each(studies) {
            run.part(study, shard, place)?;
        }
        tell!("shard {shard} is done; `drape merge` joins {} with the others", run.out.display());
        Ok(true)
    }
}

/// Whether cells are missing that are not timed.
fn lacks_counts(journal: &Journal) -> bool {
    journal.missing().iter().any(|missing| !missing.is_timed)
}

/// The name of the journal of a study's timings, where they are taken anew.
fn timings_of(study: &dyn Study) -> String {
    format!("{}-timings", study.name())
}

/// Tells what a journal holds.
fn tell_kept(name: &str, journal: &Journal, when: &str) {
    if journal.dropped() > 0 {
        tell!("{name}: {} lines of the journal are damaged and ignored", journal.dropped());
    }
    if journal.cells() > 0 {
        tell!("{name}: {} cells were finished {when}", journal.cells());
    }
}
