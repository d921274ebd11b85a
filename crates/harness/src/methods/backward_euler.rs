//! Backward Euler.

use super::Entry;
use super::runs::{Contender, Film, Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, LoadLaw, PUSHING, Problem, Theory, form, no_theorem, stable,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_backward_euler::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::Implicit,
        matrix: Matrix::of_newton,
        divides: false,
        is_limited: false,
        forms: &[form("backward-euler")
            .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e)))
            .spin(|theta, _, after| spin::backward_euler(theta, 0.0, after))],
    },
    runs: Runs {
        order: &[Variant::new("backward-euler", "backward-euler:residual=1e-12")],
        momentum: &[(
            Variant::new("backward-euler", "backward-euler:residual=1e-12"),
            Keeps::AsStated,
        )],
        locking: &[(Variant::new("backward-euler", "backward-euler"), Steps::Long)],
        locked_spring: &[(
            Variant::new("backward-euler", "backward-euler:residual=1e-12"),
            LoadLaw::Free,
        )],
        animation: &[
            Film::ladder("backward-euler", "backward-euler"),
            Film::ladder(
                "backward-euler, CG",
                "backward-euler:residual=1e-3,solver=cg,forcing=eisenstat-walker",
            ),
            Film::ladder(
                "backward-euler, one iteration",
                "backward-euler:residual=1e-2,max_iterations=1,solver=multigrid",
            ),
        ],
        work_precision: &[
            work::main("backward-euler", "backward-euler:residual=1e-3"),
            work::extra("backward-euler, tight", "backward-euler"),
            work::extra("backward-euler, auto", "backward-euler:residual=1e-3,solver=auto"),
            work::adaptive("backward-euler, adaptive", "backward-euler:residual=1e-3"),
        ],
        scaling: &[Contender {
            label: "backward-euler",
            method: "backward-euler:residual=1e-3",
            largest: 100,
        }],
        are_effects_timed: true,
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    stable(
        "it lowers the incremental potential in every step and damps every mode; its energy may \
         still rise in a step",
    )
}
