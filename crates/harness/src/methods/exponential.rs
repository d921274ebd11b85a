//! Exponential Rosenbrock-Euler.

use super::Entry;
use super::runs::{Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::recurrence::{exact_oscillator, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_exponential::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::Linearised,
        matrix: |_| Matrix::Blocks,
        divides: false,
        is_limited: false,
        forms: &[form("exponential").limit(ALWAYS, |t, e| spectral_radius(&exact_oscillator(t, e)))],
    },
    runs: Runs {
        order: &[Variant::new("exponential", "exponential:krylov_tol=1e-10")],
        momentum: &[(Variant::new("exponential", "exponential:krylov_tol=1e-10"), Keeps::AsStated)],
        locking: &[(Variant::new("exponential", "exponential"), Steps::Long)],
        work_precision: &[
            work::main("exponential", "exponential:krylov_tol=1e-3"),
            work::extra("exponential, tight", "exponential"),
        ],
        ..Runs::DEFAULTS
    },
};

/// Linear motion is exact; what the tangent does to springs that turn is not bounded.
fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("exact on linear systems; {TURNING}"))
}
