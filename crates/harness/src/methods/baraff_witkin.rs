//! Baraff and Witkin.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, LoadLaw, PUSHING, Problem, Theory, at_rest_or, beside_explicit, form,
    implicit, no_theorem,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_baraff_witkin::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::Implicit,
        matrix: |settings| Matrix::BlockFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        // Across the spring the linearised force is that of the old secant stiffness.
        forms: &[form("baraff-witkin")
            .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e)))
            .spin(|theta, before, _| spin::baraff_witkin(theta, 0.0, before))],
    },
    runs: Runs {
        order: &[Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-12")],
        momentum: &[(
            Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-12"),
            Keeps::AsStated,
        )],
        locking: &[(Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-8"), Steps::All)],
        locked_spring: &[(
            Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-14"),
            LoadLaw::Free,
        )],
        work_precision: &[
            work::headline("baraff-witkin", "baraff-witkin"),
            work::extra("baraff-witkin, Cholesky", "baraff-witkin:solver=cholesky"),
        ],
        scaling: &[Contender { label: "baraff-witkin", method: "baraff-witkin", largest: 316 }],
        are_effects_timed: true,
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    let implicit = implicit(problem);
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if problem.are_all(implicit) {
        at_rest_or(
            problem,
            "one Newton step with clamped tangents: A-stable where they are constant",
        )
    } else {
        beside_explicit(problem, implicit)
    }
}
