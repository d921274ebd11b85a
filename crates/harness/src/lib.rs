//! Runs, verdicts and experiments
