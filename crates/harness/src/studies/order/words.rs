//! The words of the study `order`: its question.

/// The question that the study answers.
pub(super) const QUESTION: &str = "Does the error of every method fall with the order that theory gives, how large \
     is its constant, and what is left of the order where the springs are too stiff for the step?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["course"];
