//! Runs.
pub mod methods;
