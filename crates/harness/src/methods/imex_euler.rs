//! IMEX Euler.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::presets::Preset;
use crate::theory::{
    ALWAYS, Expectation, Factors, Linear, LoadLaw, PUSHING, Problem, Theory, form, implicit,
    monotone, no_theorem, stable, unstable,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{imex_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_imex::EULER,
    theory: Theory {
        case,
        kin: Kin::ImplicitExplicit,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: true,
        forms: &[
            form("imex-euler")
                .limit(ALWAYS, |t, e| spectral_radius(&imex_euler(t, 0.0, e)))
                .spin(|theta, _, _| spin::imex_euler(theta, 0.0)),
            form("imex-euler, as printed")
                .limit(ALWAYS, |t, e| spectral_radius(&imex_euler(t, 0.0, e))),
            form("imex-euler, all springs")
                .limit(ALWAYS, |t, e| spectral_radius(&imex_euler(t, 0.0, e)))
                .spin(|theta, _, _| spin::imex_euler(theta, 0.0)),
        ],
    },
    runs: Runs {
        presets: &[Preset {
            name: "paper",
            settings: &[("norm", "euclid"), ("split", "paper")],
            help: "as Eberhardt, Etzmuß and Hauth print it",
        }],
        order: &[
            Variant::new("imex-euler", "imex-euler:forcing_term=1e-10"),
            Variant::new(
                "imex-euler, all springs",
                "imex-euler:forcing_term=1e-10,implicit=springs",
            ),
        ],
        energy: &[
            Variant::new("imex-euler", "imex-euler"),
            Variant::new("imex-euler, all springs", "imex-euler:implicit=springs"),
        ],
        momentum: &[
            (Variant::new("imex-euler", "imex-euler:forcing_term=1e-12"), Keeps::AsStated),
            (
                Variant::new(
                    "imex-euler, all springs",
                    "imex-euler:forcing_term=1e-12,implicit=springs",
                ),
                Keeps::AsStated,
            ),
            (Variant::new("imex-euler, ε = 0.001", "imex-euler"), Keeps::Otherwise),
        ],
        stability: &[
            Variant::new("imex-euler, as printed", "imex-euler:forcing_term=0.05,norm=euclid"),
            Variant::new(
                "imex-euler, all springs",
                "imex-euler:forcing_term=1e-10,implicit=springs",
            ),
        ],
        hard_cases: &[
            Variant::new("imex-euler", "imex-euler"),
            Variant::new("imex-euler (exact)", "imex-euler:solver=cholesky,implicit=springs"),
        ],
        locking: &[
            (
                Variant::new("imex-euler", "imex-euler:forcing_term=1e-8,implicit=springs"),
                Steps::All,
            ),
            (Variant::new("imex-euler, tension only", "imex-euler:forcing_term=1e-8"), Steps::One),
        ],
        locked_spring: &[(
            Variant::new("imex-euler", "imex-euler:forcing_term=1e-14"),
            LoadLaw::Filtered,
        )],
        animation: &[],
        work_precision: &[
            work::headline("imex-euler", "imex-euler"),
            work::extra(
                "imex-euler, all springs, Cholesky",
                "imex-euler:implicit=springs,solver=cholesky",
            ),
            work::adaptive("imex-euler, adaptive", "imex-euler"),
        ],
        scaling: &[
            Contender { label: "imex-euler", method: "imex-euler", largest: 1000 },
            Contender {
                label: "imex-euler, Jacobi",
                method: "imex-euler:preconditioner=jacobi",
                largest: 1000,
            },
        ],
        are_effects_timed: true,
        are_effects_quick: true,
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    let settings = problem.choice.settings();
    let implicit = implicit(problem);
    let is_exact = settings.word("solver") == "cholesky";
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    if problem.are_all(implicit) && is_exact {
        return monotone("theorem: all springs in the matrix, full damping, solved exactly");
    }
    match problem.analyse(Some(implicit), &Factors::ONE_STEP) {
        Linear::Nowhere => unstable(
            "some mode has θ_E > 4 + θ_I at the start already: 4M + 2h²L_I − h²K is indefinite",
        ),
        Linear::Everywhere if is_exact => {
            stable("no mode has θ_E > 4 + θ_I at any state: 4M + 2h²L_I − h²L is positive definite")
        }
        Linear::Everywhere => no_theorem(
            "the energy theorem needs an exact solve; this one stops at a tolerance, from an \
             extrapolated start",
        ),
        Linear::Somewhere => {
            no_theorem("θ_E < 4 + θ_I for every mode at the start, but not at every state")
        }
    }
}
