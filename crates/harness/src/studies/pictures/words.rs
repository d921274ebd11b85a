//! The words of the study `pictures`: its question.

/// The question that the study answers.
pub(super) const QUESTION: &str = "What does the cloth look like: on a table and hanging from two corners, and with each method?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];
