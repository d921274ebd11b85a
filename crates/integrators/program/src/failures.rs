//! The failures of programs, collected for the end of a study, whose table cells do not keep
//! sentences.

use std::sync::Mutex;

static FAILURES: Mutex<Vec<(String, u64)>> = Mutex::new(Vec::new());

/// Notes a failure.
#[cfg(unix)]
pub(crate) fn note(sentence: &str) {
    let Ok(mut failures) = FAILURES.lock() else { return };
    match failures.iter_mut().find(|(known, _)| known == sentence) {
        Some((_, count)) => *count += 1,
        None => failures.push((sentence.to_owned(), 1)),
    }
}

/// Each different failure of a program in this process so far, with its number of occurrences.
pub fn failures() -> Vec<(String, u64)> {
    FAILURES.lock().map(|failures| failures.clone()).unwrap_or_default()
}
