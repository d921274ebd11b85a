//! Criterion benches of steps, solves and set-ups
