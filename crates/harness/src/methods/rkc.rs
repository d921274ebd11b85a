//! Runge–Kutta–Chebyshev.

use super::Entry;
use super::runs::{Film, Runs, Variant, work};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, Theory, form, no_theorem};
use drape_oracle::recurrence::{rkc2, spectral_radius};
use drape_report::family::Kin;

/// Stages of the form with fixed ones.
const STAGES: u32 = 6;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_rkc::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::ExplicitStages,
        matrix: |_| Matrix::None,
        divides: true,
        is_limited: false,
        forms: &[
            // It divides a step until it is stable.
            form("rkc").limit(ALWAYS, |_, _| 1.0),
            form("rkc, 6 stages").limit("|P₆(z)| ≤ 1: η < 22.9, undamped never", |t, e| {
                spectral_radius(&rkc2(STAGES, t, e))
            }),
        ],
    },
    runs: Runs {
        order: FIXED,
        stability: FIXED,
        work_precision: &[
            work::main("rkc", "rkc"),
            work::extra("rkc, 6 stages", "rkc:step=fixed,stages=6"),
        ],
        animation: &[Film::ladder("rkc", "rkc")],
        ..Runs::DEFAULTS
    },
};

/// With one number of stages.
const FIXED: &[Variant] =
    &[Variant::new("rkc", "rkc"), Variant::new("rkc, 6 stages", "rkc:step=fixed,stages=6")];

fn case(_: &Problem<'_>) -> Expectation {
    no_theorem("substeps and stages by the damping of modes that are damped like the springs")
}
