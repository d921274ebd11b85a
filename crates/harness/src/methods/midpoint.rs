//! Implicit midpoint.

use super::Entry;
use super::runs::{Contender, Film, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::recurrence::{implicit_midpoint, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_midpoint::REGISTRATION,
    lesson: Some(&LESSON),
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
            Variant::new("midpoint", "midpoint:residual=1e-13,solver=cholesky"),
            Variant::new("midpoint, one CG solve", LINEARISED),
        ],
        momentum: &[(
            Variant::new("midpoint", "midpoint:residual=1e-14,solver=cholesky"),
            Keeps::AsStated,
        )],
        energy: &[Variant::new("midpoint", EXACT)],
        hard_cases: &[Variant::new("midpoint", EXACT)],
        stability: &[Variant::new("midpoint", EXACT)],
        locking: &[(Variant::new("midpoint", EXACT), Steps::Long)],
        work_precision: &[
            work::main("midpoint", LOOSE),
            work::extra("midpoint, one CG solve", LINEARISED),
            work::extra("midpoint, auto", "midpoint:residual=1e-3"),
            work::main("midpoint, safeguarded", SAFEGUARDED),
            work::adaptive("midpoint, adaptive", LOOSE),
        ],
        animation: &[
            Film::ladder("midpoint, safeguarded auto", SAFEGUARDED),
            Film::ladder("midpoint", EXACT),
            Film::ladder("midpoint, auto", "midpoint:residual=1e-3"),
            Film::ladder(
                "midpoint, one iteration",
                "midpoint:max_iterations=1,solver=cg,cg_tolerance=0.01",
            ),
            Film::ladder(
                "midpoint, three iterations",
                "midpoint:residual=1e-2,max_iterations=3,solver=multigrid",
            ),
        ],
        scaling: &[Contender {
            label: "midpoint",
            method: "midpoint:residual=1e-3,solver=cholesky",
            largest: 100,
        }],
        ..Runs::DEFAULTS
    },
};

/// A form solved by factors, for studies of the method rather than of its solver.
const EXACT: &str = "midpoint:solver=cholesky";

/// The same form, solved to a thousandth.
const LOOSE: &str = "midpoint:residual=1e-3,solver=cholesky";

/// A form with one linear solve a step.
const LINEARISED: &str = "midpoint:max_iterations=1,solver=cg,cg_tolerance=0.01";

/// The same form, with more iterations where the residual would add energy.
const SAFEGUARDED: &str = "midpoint:max_iterations=1,safeguard=work";

fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("A-stable on linear systems, where it damps nothing; {TURNING}"))
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "The implicit midpoint: all of the energy, in slow motion",
    idea: "The method has one implicit stage, in the middle of the step. On linear springs it \
           keeps the energy exactly at every step size. But an oscillation that the step does not \
           resolve never decays, and it is too slow: a step turns it by 2 atan(ωh/2) instead of \
           ωh.",
    docs: "drape-midpoint",
    sources: drape_midpoint::SOURCES,
    equation: Excerpt::docs("M (w − v_n) = h/2 f(x_n + h/2 w, w)", "(2)"),
    code: Excerpt::step(
        "let w = stage.velocity();",
        "w[i] + (w[i] - state.v[i]) // v_{n+1} = 2 w − v_n, (2)",
    ),
    law: Law::OneStep(implicit_midpoint),
    load: None,
    setting: Setting::oscillator(&["midpoint", "exponential"]).time(0.2, 4.0),
    question: Question::Period,
    attempt: "Make the step longer and longer: how many steps does a period take at least?",
    low: "The oscillation is slower than that: count the steps of the first pane, not of the \
          second.",
    high: "The oscillation is faster than that.",
    traps: &[Trap {
        value: |s| std::f64::consts::TAU / libm::sqrt(s.stiffness),
        hint: "That is the exact period 2π/ω, which the second pane shows. The first one is slower.",
    }],
    study: "order",
};
