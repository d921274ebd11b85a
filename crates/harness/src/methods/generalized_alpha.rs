//! The generalized-α family.

use super::Entry;
use super::runs::{Film, Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::GeneralizedAlpha;
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_generalized_alpha::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::ImplicitStages,
        matrix: Matrix::of_newton,
        divides: false,
        is_limited: false,
        forms: &[
            form("generalized-alpha")
                .limit(ALWAYS, |t, e| GeneralizedAlpha::chung_hulbert(0.5).spectral_radius(t, e)),
            form("trapezoid")
                .limit(ALWAYS, |t, e| GeneralizedAlpha::newmark(1.0).spectral_radius(t, e))
                .spin(|theta, before, after| spin::trapezoid(theta, 0.0, before, after)),
        ],
    },
    runs: Runs {
        order: &[
            Variant::new("generalized-alpha", "generalized-alpha:residual=1e-13"),
            Variant::new("trapezoid", "generalized-alpha:family=newmark,rho_inf=1,residual=1e-13"),
        ],
        momentum: &[
            (
                Variant::new("generalized-alpha", "generalized-alpha:residual=1e-12"),
                Keeps::AsStated,
            ),
            (
                Variant::new(
                    "trapezoid",
                    "generalized-alpha:family=newmark,rho_inf=1,residual=1e-12",
                ),
                Keeps::AsStated,
            ),
        ],
        stability: &[
            Variant::new("generalized-alpha", "generalized-alpha"),
            Variant::new("trapezoid", "generalized-alpha:family=newmark,rho_inf=1"),
        ],
        locking: &[(Variant::new("generalized-alpha", "generalized-alpha"), Steps::Long)],
        work_precision: &[
            work::main("generalized-alpha", "generalized-alpha:residual=1e-3"),
            work::extra("generalized-alpha, safeguarded", SAFEGUARDED),
        ],
        animation: &[
            Film::ladder("generalized-alpha", "generalized-alpha"),
            Film::ladder(
                "generalized-alpha, CG",
                "generalized-alpha:residual=1e-3,solver=cg,forcing=eisenstat-walker",
            ),
            Film::ladder(
                "generalized-alpha, one iteration",
                "generalized-alpha:max_iterations=1,solver=cg,cg_tolerance=0.01",
            ),
            Film::ladder(
                "generalized-alpha, three iterations",
                "generalized-alpha:residual=1e-2,max_iterations=3,solver=multigrid",
            ),
            Film::ladder("generalized-alpha, safeguarded", SAFEGUARDED),
        ],
        ..Runs::DEFAULTS
    },
};

/// One linear solve a step, more where its residual would add energy.
const SAFEGUARDED: &str =
    "generalized-alpha:max_iterations=1,safeguard=work,solver=cg,cg_tolerance=0.01";

fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("A-stable on linear systems; {TURNING}"))
}
