//! The words of the study `tables`: its question.

/// The question that the study answers.
pub(super) const QUESTION: &str = "Do the paper's iteration counts (tables 2 and 3) come out, for which \
     reading of their illegible exponents and at which solver tolerance?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];
