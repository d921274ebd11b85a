//! The words of the study `hard-cases`: its question.

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which method stays stable where methods fail, and does it do so where its theory \
     says that it should?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["momentum", "stability"];
