//! Exact recurrences, finite-difference checks, observed order, reference trajectories
