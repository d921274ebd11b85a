//! The words of the study `cg-vs-stiffness`: its question.

/// The question that the study answers.
pub(super) const QUESTION: &str = "How do the CG iterations of plain and of updated IMEX Euler grow with the \
     stiffness, the step size and the tolerance, and does the cloth still move?";
/// Studies that a reader should know before this one.
pub(super) const BUILDS_ON: &[&str] = &["tables"];
