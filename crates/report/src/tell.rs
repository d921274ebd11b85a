//! Messages on standard error.

use std::io::Write as _;

/// Writes a message as one line to standard error, with the arguments of [`format!`].
///
/// A message is a courtesy: where it cannot be written, because the reader closed the pipe or the
/// disk is full, the program goes on, and its exit code stays what it is. [`eprintln!`] panics.
#[macro_export]
macro_rules! tell {
    ($($part:tt)*) => { $crate::tell(::std::format_args!($($part)*)) };
}

/// Writes a message as one line to standard error. [`tell!`](crate::tell!) says more.
pub fn tell(message: std::fmt::Arguments<'_>) {
    // One write a line, so that lines of several processes do not mix.
    let line = format!("{message}\n");
    let _ = std::io::stderr().lock().write_all(line.as_bytes());
}
