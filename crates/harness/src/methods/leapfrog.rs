//! Leapfrog.

use super::Entry;
use super::runs::{
    Contender, Film, Runs, Variant,
    work::{self, Knob},
};
use crate::need::Matrix;
use crate::theory::{
    Expectation, Factors, PUSHING, Problem, Theory, Weights, explicit, form, no_theorem, stable,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{leapfrog, leapfrog_explicit_damping, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_explicit_euler::VERLET,
    theory: Theory {
        case,
        kin: Kin::Explicit,
        // Of the damping, if any.
        matrix: |settings| match settings.word("damping") {
            "explicit" => Matrix::None,
            _ => Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        },
        divides: true,
        is_limited: true,
        forms: &[
            form("leapfrog")
                .limit("θ < 4", |t, e| spectral_radius(&leapfrog(t, e)))
                .spin(|_, _, _| spin::leapfrog(0.0)),
            form("leapfrog, explicit damping").limit("θ < 4 and η < 4", |t, e| {
                spectral_radius(&leapfrog_explicit_damping(t, e))
            }),
        ],
    },
    runs: Runs {
        stability: &[
            Variant::new("leapfrog", "leapfrog"),
            Variant::new("leapfrog, explicit damping", "leapfrog:damping=explicit"),
        ],
        energy: &[Variant::new("leapfrog", "leapfrog:solver=cg")],
        hard_cases: &[
            Variant::new("leapfrog", "leapfrog"),
            Variant::new("leapfrog (auto)", "leapfrog:step=auto"),
            Variant::new("leapfrog (bound)", "leapfrog:step=bound"),
        ],
        work_precision: &[
            work::headline("leapfrog", "leapfrog:step=bound")
                .knob(Knob::Setting("safety", SAFETIES)),
            work::main("leapfrog, explicit damping", "leapfrog:step=bound,damping=explicit")
                .knob(Knob::Setting("safety", SAFETIES)),
            work::extra("leapfrog, CG", "leapfrog:step=bound,solver=cg")
                .knob(Knob::Setting("safety", SAFETIES)),
            work::extra("leapfrog, fixed steps", "leapfrog"),
        ],
        scaling: &[Contender { label: "leapfrog", method: "leapfrog:solver=cg", largest: 1000 }],
        animation: &[
            Film::limit("leapfrog", "leapfrog"),
            Film::limit("leapfrog, explicit damping", "leapfrog:damping=explicit"),
        ],
        ..Runs::DEFAULTS
    },
};

/// Substep over the stability limit.
const SAFETIES: &[f64] = &[0.95, 0.5, 0.25, 0.125, 0.0625];

/// Half of the damping is taken at either velocity: at `ζ = −1` it falls out.
const FACTORS: Factors = Factors {
    explicit: Weights { damping: 0.0, ..Factors::ONE_STEP.explicit },
    ..Factors::ONE_STEP
};

fn case(problem: &Problem<'_>) -> Expectation {
    let settings = problem.choice.settings();
    let is_explicit = settings.word("damping") == "explicit" && problem.is_damped();
    match settings.word("step") {
        "auto" => no_theorem(
            "substeps within the limit by an estimate of the largest eigenvalue, which follows \
             the cloth with a delay",
        ),
        "bound" if problem.has_contacts() => no_theorem(PUSHING),
        "bound" => stable("substeps within the limit h²λ < 4 at every state"),
        _ if is_explicit => no_theorem("stable if h²λ < 4 and hδ < 4"),
        _ => explicit(problem, "h²λ < 4", &FACTORS),
    }
}
