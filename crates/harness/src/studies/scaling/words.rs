//! The words of the study `scaling`: its question.

/// The question that the study answers.
pub(super) const QUESTION: &str = "How do the iterations and the time of a step grow with the number of particles, from a hundred to a \
     million?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["work-precision"];
