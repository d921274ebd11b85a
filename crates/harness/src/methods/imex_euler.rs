//! IMEX Euler.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap, gravity};
use crate::need::Matrix;
use crate::presets::Preset;
use crate::theory::{
    ALWAYS, Expectation, Factors, Linear, LoadLaw, PUSHING, Problem, Theory, form, implicit,
    monotone, no_theorem, stable, unstable,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, imex_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_imex::EULER,
    lesson: Some(&LESSON),
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
        inside: &[],
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

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "IMEX Euler: fast, stable, and it locks",
    idea: "The linear part of the springs is implicit, with a matrix that never changes. The rest, \
           which turns with the spring, stays explicit. The matrix is stiff in every direction, \
           but a spring is stiff only along itself. So the method slows a motion across a stiff \
           spring as if the spring resisted it: the cloth locks.",
    docs: "drape-imex",
    sources: drape_imex::SOURCES,
    equation: Excerpt::docs("A v_{n+1} = M v_n + h [F_explicit(x_n, v_n) − L_k x_n]", "(20)"),
    code: Excerpt::of(
        "src/step/euler.rs",
        "// A = M + h² L_k + h L_c, EEH (21)",
        "rhs.assemble(system, state, h);",
    ),
    law: Law::OneStep(backward_euler),
    load: Some(LoadLaw::Filtered),
    setting: Setting::load(&["imex-euler", "imex-updated"]),
    question: Question::Speed,
    attempt: "Halve the step, or divide k/m by ten: how does the speed follow? Then open \
              hanging-textile-1e6 with both methods.",
    low: "It is faster than that.",
    high: "It never becomes that fast: each step keeps only 1/(1 + h²k/m) of the speed.",
    traps: &[
        Trap {
            value: |s| 1e3 * gravity(s.scene) * s.duration,
            hint: "That is free fall, which the second pane shows. The first is locked.",
        },
        Trap {
            value: |s| 1e3 * gravity(s.scene) * s.step,
            hint: "That is the change of speed h g of a single step; the matrix divides it by 1 + \
                   h²k/m.",
        },
    ],
    study: "locking",
};
