//! The words of the study `momentum`: its question.

/// The question that the study answers.
pub(super) const QUESTION: &str = "Which methods keep the linear and the angular momentum of a cloth that nothing holds, \
     and how much of its spin is left by the others and by Desbrun's correction?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["order"];
