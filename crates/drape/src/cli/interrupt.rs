//! Ctrl-C, or SIGTERM: what is there is kept, and one line says how to go on.

use drape_harness::compare::quoted;
use drape_report::tell;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

static FLAG: AtomicBool = AtomicBool::new(false);
/// The signal that came last; SIGINT before.
static SIGNAL: AtomicU8 = AtomicU8::new(2);

/// The exit code that shells give to a command that a signal ended: 128 and its number, 130 for
/// Ctrl-C and 143 for SIGTERM.
pub(crate) fn exit_code() -> u8 {
    128 + SIGNAL.load(Ordering::Relaxed)
}

/// Ends the process at once, with the programs that it started.
fn exit() -> ! {
    drape_harness::methods::kill_programs();
    std::process::exit(exit_code().into());
}

/// Sets what Ctrl-C and SIGTERM do, on a thread of its own. Where no such signals or no thread can
/// be had, they end the process as ever.
#[cfg(unix)]
fn on_signal(mut act: impl FnMut() + Send + 'static) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else {
        return;
    };
    let handle = signals.handle();
    let wait = move || {
        for signal in signals.forever() {
            SIGNAL.store(u8::try_from(signal).unwrap_or(2), Ordering::Relaxed);
            act();
        }
    };
    if std::thread::Builder::new().name("interrupt".to_owned()).spawn(wait).is_err() {
        handle.close();
    }
}

#[cfg(not(unix))]
fn on_signal(_act: impl FnMut() + Send + 'static) {}

/// Ends the process at once and says how to go on: its journal holds every finished cell.
pub(crate) fn end_and_tell() {
    on_signal(|| {
        tell!("drape: interrupted; finished cells are kept; to go on: {}", command(&["--fresh"]));
        exit();
    });
}

/// A flag that the first signal sets, so that the command ends soon and keeps what it has. The
/// second ends the process at once.
pub(crate) fn flag() -> &'static AtomicBool {
    on_signal(|| {
        if FLAG.swap(true, Ordering::Relaxed) {
            tell!("drape: interrupted twice; no result is written");
            exit();
        }
    });
    &FLAG
}

/// Whether a signal came.
pub(crate) fn is_set() -> bool {
    FLAG.load(Ordering::Relaxed)
}

/// The command line of this process without some options.
pub(crate) fn command(without: &[&str]) -> String {
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let words = words.filter(|word| !without.contains(&word.as_str()));
    let words = std::iter::once("drape".to_owned()).chain(words.map(|word| quoted(&word)));
    words.collect::<Vec<_>>().join(" ")
}

/// The user ended the command; what it had is kept.
#[derive(Debug)]
pub(crate) struct Interrupted(pub(crate) String);

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Interrupted {}
