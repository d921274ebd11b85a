//! Progress: a bar on a terminal, plain lines otherwise.

use drape_harness::compare::Tick;
use drape_harness::studies::{Progress, Study};
use drape_report::tell;
use indicatif::{FormattedDuration, ProgressBar, ProgressStyle};
use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Which of several studies is at work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// From 1.
    number: usize,
    of: usize,
    begin: Instant,
}

impl Place {
    /// Each study with its place; the first one begins now.
    pub(crate) fn each<'a>(
        studies: &'a [&'static dyn Study],
    ) -> impl Iterator<Item = (Self, &'static dyn Study)> + 'a {
        let (of, begin) = (studies.len(), Instant::now());
        (1..).zip(studies).map(move |(number, study)| (Self { number, of, begin }, *study))
    }

    /// Tells, where there are several studies, which one begins, and the time so far.
    pub(crate) fn tell(self, name: &str) {
        if self.of > 1 {
            tell!("{self}{name}, after {}", FormattedDuration(self.begin.elapsed()));
        }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.of == 1 { Ok(()) } else { write!(f, "[{}/{}] ", self.number, self.of) }
    }
}

/// Shows the progress of an experiment.
pub(crate) struct Bars {
    experiment: &'static str,
    place: Place,
    bar: Mutex<Option<ProgressBar>>,
}

impl Bars {
    pub(crate) fn new(experiment: &'static str, place: Place) -> Self {
        Self { experiment, place, bar: Mutex::new(None) }
    }
}

/// A bar of `length` parts on standard error, or `None` if that is no terminal.
pub(crate) fn bar(label: &str, length: u64) -> Option<ProgressBar> {
    if !std::io::stderr().is_terminal() {
        return None;
    }
    let bar = ProgressBar::new(length);
    let style =
        ProgressStyle::with_template("{prefix:32} [{bar:40}] {pos}/{len} {elapsed}/{duration}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
    bar.set_prefix(label.to_owned());
    Some(bar)
}

impl Progress for Bars {
    fn begin(&self, part: &str, cells: usize) {
        let label = format!("{}{}: {part}", self.place, self.experiment);
        let bar = bar(&label, cells as u64);
        if bar.is_none() {
            tell!("{label}: {cells} cells");
        }
        if let Ok(mut slot) = self.bar.lock() {
            *slot = bar;
        }
    }

    fn done(&self) {
        if let Ok(slot) = self.bar.lock() {
            slot.as_ref().inspect(|bar| bar.inc(1));
        }
    }

    fn end(&self) {
        if let Ok(mut slot) = self.bar.lock() {
            slot.take().inspect(|bar| bar.finish());
        }
    }
}

/// Shows how much of a time is spent, and what leads.
pub(crate) struct Clock {
    label: &'static str,
    bar: Option<ProgressBar>,
    /// The part that was told last.
    part: Mutex<&'static str>,
}

impl Clock {
    pub(crate) fn new(label: &'static str, time: Duration) -> Self {
        let bar = bar(label, time.as_secs());
        if let Some(bar) = &bar {
            let style = ProgressStyle::with_template("{prefix:24} [{bar:40}] {pos}/{len} s {msg}");
            bar.set_style(
                style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "),
            );
        }
        Self { label, bar, part: Mutex::new("") }
    }

    pub(crate) fn show(&self, tick: &Tick<'_>) {
        if let Some(bar) = &self.bar {
            bar.set_prefix(format!("{}: {}", self.label, tick.part));
            bar.set_position(tick.elapsed.as_secs());
            if let Some(leads) = tick.leads {
                bar.set_message(format!("leads: {leads}"));
            }
            return;
        }
        let Ok(mut part) = self.part.lock() else { return };
        if *part != tick.part {
            tell!("{}: {} ({:.1} s)", self.label, tick.part, tick.elapsed.as_secs_f64());
            *part = tick.part;
        }
    }

    pub(crate) fn end(&self) {
        self.bar.as_ref().inspect(|bar| bar.finish_and_clear());
    }
}
