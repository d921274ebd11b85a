//! Backward differentiation formulas.

use super::Entry;
use super::runs::{Film, Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::recurrence::bdf;
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_multistep::BACKWARD_DIFFERENTIATION,
    theory: Theory {
        case,
        kin: Kin::Implicit,
        matrix: Matrix::of_newton,
        divides: false,
        is_limited: false,
        forms: &[
            form("bdf2").limit(ALWAYS, |t, e| bdf(2, t, e).spectral_radius()),
            form("bdf, 3 steps").order(Some(3)),
        ],
    },
    runs: Runs {
        order: &[
            Variant::new("bdf2", "bdf2:residual=1e-12"),
            Variant::new("bdf, 3 steps", "bdf2:steps=3,residual=1e-12"),
        ],
        momentum: &[
            (Variant::new("bdf2", "bdf2:residual=1e-12"), Keeps::AsStated),
            (Variant::new("bdf, 3 steps", "bdf2:steps=3,residual=1e-12"), Keeps::AsStated),
        ],
        locking: &[(Variant::new("bdf2", "bdf2"), Steps::Long)],
        animation: &[
            Film::ladder("bdf2", "bdf2"),
            Film::ladder("bdf2, CG", "bdf2:residual=1e-3,solver=cg,forcing=eisenstat-walker"),
            Film::ladder("bdf2, one iteration", "bdf2:residual=1e-2,max_iterations=1,solver=cg"),
            Film::ladder(
                "bdf2, three iterations",
                "bdf2:residual=1e-2,max_iterations=3,solver=multigrid",
            ),
            Film::ladder("bdf2, safeguarded", SAFEGUARDED),
        ],
        work_precision: &[
            work::headline("bdf2", "bdf2:residual=1e-3"),
            work::extra("bdf2, tight", "bdf2"),
            work::extra("bdf2, auto", "bdf2:residual=1e-3,solver=auto"),
            work::extra("bdf2, safeguarded", SAFEGUARDED),
            work::adaptive("bdf2, adaptive", "bdf2:residual=1e-3"),
        ],
        ..Runs::DEFAULTS
    },
};

/// One linear solve a step, more where its residual would add energy.
const SAFEGUARDED: &str = "bdf2:max_iterations=1,safeguard=work,solver=cg,cg_tolerance=0.01";

fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("A-stable on linear systems; {TURNING}"))
}
