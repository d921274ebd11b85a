//! The words of the study `claims`: its question.

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which of the paper's claims hold?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["hard-cases", "work-precision", "solver-control"];
