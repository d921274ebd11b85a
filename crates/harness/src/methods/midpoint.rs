//! Implicit midpoint.

use super::Entry;
use super::runs::{Film, Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::recurrence::{implicit_midpoint, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_midpoint::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::ImplicitStages,
        matrix: Matrix::of_newton,
        divides: false,
        is_limited: false,
        forms: &[
            form("midpoint")
                .limit(ALWAYS, |t, e| spectral_radius(&implicit_midpoint(t, e)))
                .spin(|_, _, _| 1.0),
            form("midpoint, one CG solve"),
        ],
    },
    runs: Runs {
        order: &[
            Variant::new("midpoint", "midpoint:residual=1e-13"),
            Variant::new("midpoint, one CG solve", LINEARISED),
        ],
        momentum: &[(Variant::new("midpoint", "midpoint:residual=1e-14"), Keeps::AsStated)],
        locking: &[(Variant::new("midpoint", "midpoint"), Steps::Long)],
        work_precision: &[
            work::main("midpoint", "midpoint:residual=1e-3"),
            work::extra("midpoint, one CG solve", LINEARISED),
            work::extra("midpoint, safeguarded", SAFEGUARDED),
            work::adaptive("midpoint, adaptive", "midpoint:residual=1e-3"),
        ],
        animation: &[
            Film::ladder("midpoint", "midpoint"),
            Film::ladder(
                "midpoint, CG",
                "midpoint:residual=1e-3,solver=cg,forcing=eisenstat-walker",
            ),
            Film::ladder(
                "midpoint, one iteration",
                "midpoint:max_iterations=1,solver=cg,cg_tolerance=0.01",
            ),
            Film::ladder(
                "midpoint, three iterations",
                "midpoint:residual=1e-2,max_iterations=3,solver=multigrid",
            ),
            Film::ladder("midpoint, safeguarded", SAFEGUARDED),
        ],
        ..Runs::DEFAULTS
    },
};

/// One linear solve a step.
const LINEARISED: &str = "midpoint:max_iterations=1,solver=cg,cg_tolerance=0.01";

/// As before, with more iterations where the residual would add energy.
const SAFEGUARDED: &str = "midpoint:max_iterations=1,safeguard=work,solver=cg,cg_tolerance=0.01";

fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("A-stable on linear systems, where it damps nothing; {TURNING}"))
}
