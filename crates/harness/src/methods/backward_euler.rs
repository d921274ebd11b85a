//! Backward Euler.

use super::Entry;
use super::runs::{Contender, Film, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
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
    lesson: Some(&LESSON),
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
        order: &[Variant::new("backward-euler", "backward-euler:residual=1e-12,solver=cholesky")],
        momentum: &[(
            Variant::new("backward-euler", "backward-euler:residual=1e-12,solver=cholesky"),
            Keeps::AsStated,
        )],
        energy: &[Variant::new("backward-euler", EXACT)],
        hard_cases: &[Variant::new("backward-euler", EXACT)],
        stability: &[Variant::new("backward-euler", EXACT)],
        locking: &[(Variant::new("backward-euler", EXACT), Steps::Long)],
        locked_spring: &[(
            Variant::new("backward-euler", "backward-euler:residual=1e-12,solver=cholesky"),
            LoadLaw::Free,
        )],
        animation: &[
            Film::ladder("backward-euler, safeguarded auto", SAFEGUARDED),
            Film::ladder("backward-euler", EXACT),
            Film::ladder("backward-euler, auto", "backward-euler:residual=1e-3"),
            Film::ladder(
                "backward-euler, one iteration",
                "backward-euler:residual=1e-2,max_iterations=1,solver=multigrid",
            ),
        ],
        work_precision: &[
            work::main("backward-euler", LOOSE),
            work::extra("backward-euler, tight", EXACT),
            work::extra("backward-euler, auto", "backward-euler:residual=1e-3"),
            work::main("backward-euler, safeguarded", SAFEGUARDED),
            work::adaptive("backward-euler, adaptive", LOOSE),
        ],
        scaling: &[Contender { label: "backward-euler", method: LOOSE, largest: 100 }],
        are_effects_timed: true,
        ..Runs::DEFAULTS
    },
};

/// A form solved by factors, for studies of the method rather than of its solver.
const EXACT: &str = "backward-euler:solver=cholesky";

/// The same form, solved to a thousandth.
const LOOSE: &str = "backward-euler:residual=1e-3,solver=cholesky";

/// A form with one linear solve a step, and with more where its residual would add energy.
const SAFEGUARDED: &str = "backward-euler:max_iterations=1,safeguard=work";

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    stable(
        "it lowers the incremental potential in every step and damps every mode; its energy may \
         still rise in a step",
    )
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Backward Euler: stable, and it damps",
    idea: "The forces are those at the end of the step. The method is stable at every step size, \
           because each step removes energy: an undamped spring loses the share θ/(1 + θ) of its \
           energy in every step, with θ = h²k/m. In a film this loss often looks like air drag.",
    docs: "drape-backward-euler",
    sources: drape_backward_euler::SOURCES,
    equation: Excerpt::docs("M (v_{n+1} − v_n) = h f(x_{n+1}, v_{n+1})", "(4)"),
    code: Excerpt::step(
        "// M (v_{n+1} − v_n) = h f(x_n + h v_{n+1}, v_{n+1})",
        "each_particle(system, &mut state.x, |i| x[i]);",
    ),
    law: Law::OneStep(backward_euler),
    load: None,
    setting: Setting::oscillator(&["backward-euler", "midpoint"]),
    question: Question::EnergyLeft,
    attempt: "Halve the step: does half of the loss go away? Multiply k/m by 100 and watch the \
              loss of stiff springs.",
    low: "The step takes less than that.",
    high: "The loss is larger: the spring has no damping, but the method has.",
    traps: &[
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
        Trap {
            value: |s| 10.0 * libm::sqrt(Law::OneStep(backward_euler).left(s)),
            hint: "That is the share of the amplitude. The energy goes with its square.",
        },
    ],
    study: "energy",
};
