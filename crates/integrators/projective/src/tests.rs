//! Projective dynamics against its own mathematics.

mod convergence;
mod iterates;
mod laws;
mod sheet;
mod surroundings;

use crate::{Projective, ProjectiveSettings};
use drape_model::{State, System};
use drape_oracle::Run;

/// Each acceleration.
const ALL: [&str; 5] = ["none", "chebyshev", "anderson", "lbfgs", "admm"];

/// Settings from `key=value,key=value`.
fn settings(text: &str) -> ProjectiveSettings {
    let pairs = text.split(',').filter_map(|pair| pair.split_once('='));
    ProjectiveSettings::from_pairs(pairs).unwrap_or_else(|error| panic!("{error}"))
}

fn run(text: &str, start: (System, State), h: f64) -> Run {
    Run::new(Box::new(Projective::new(settings(text))), start, h)
}
