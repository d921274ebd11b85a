//! The generalized-α family.

use super::Entry;
use super::runs::{Contender, Film, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{GeneralizedAlpha, backward_euler};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_generalized_alpha::REGISTRATION,
    lesson: Some(&LESSON),
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
            Variant::new("generalized-alpha", "generalized-alpha:residual=1e-13,solver=cholesky"),
            Variant::new(
                "trapezoid",
                "generalized-alpha:family=newmark,rho_inf=1,residual=1e-13,solver=cholesky",
            ),
        ],
        momentum: &[
            (
                Variant::new(
                    "generalized-alpha",
                    "generalized-alpha:residual=1e-12,solver=cholesky",
                ),
                Keeps::AsStated,
            ),
            (
                Variant::new(
                    "trapezoid",
                    "generalized-alpha:family=newmark,rho_inf=1,residual=1e-12,solver=cholesky",
                ),
                Keeps::AsStated,
            ),
        ],
        stability: &[
            Variant::new("generalized-alpha", EXACT),
            Variant::new("trapezoid", "generalized-alpha:family=newmark,rho_inf=1,solver=cholesky"),
        ],
        energy: &[Variant::new("generalized-alpha", EXACT)],
        hard_cases: &[Variant::new("generalized-alpha", EXACT)],
        locking: &[(Variant::new("generalized-alpha", EXACT), Steps::Long)],
        work_precision: &[
            work::main("generalized-alpha", "generalized-alpha:residual=1e-3,solver=cholesky"),
            work::extra("generalized-alpha, auto", "generalized-alpha:residual=1e-3"),
            work::main("generalized-alpha, safeguarded", SAFEGUARDED),
        ],
        animation: &[
            Film::ladder("generalized-alpha, safeguarded auto", SAFEGUARDED),
            Film::ladder("generalized-alpha", EXACT),
            Film::ladder("generalized-alpha, auto", "generalized-alpha:residual=1e-3"),
            Film::ladder(
                "generalized-alpha, one iteration",
                "generalized-alpha:max_iterations=1,solver=cg,cg_tolerance=0.01",
            ),
            Film::ladder(
                "generalized-alpha, three iterations",
                "generalized-alpha:residual=1e-2,max_iterations=3,solver=multigrid",
            ),
        ],
        scaling: &[Contender {
            label: "generalized-alpha",
            method: "generalized-alpha:residual=1e-3,solver=cholesky",
            largest: 100,
        }],
        ..Runs::DEFAULTS
    },
};

/// A form solved by factors, for studies of the method rather than of its solver.
const EXACT: &str = "generalized-alpha:solver=cholesky";

/// A form with one linear solve a step, and with more where its residual would add energy.
const SAFEGUARDED: &str = "generalized-alpha:max_iterations=1,safeguard=work";

fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("A-stable on linear systems; {TURNING}"))
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "A dial for numerical damping",
    idea: "The method takes forces and accelerations at two different points within the step. The \
           setting rho_inf is the share of the fastest oscillations that a step leaves: 1 keeps \
           them, 0 removes them within a few steps. Slow oscillations lose little, and the order \
           is 2.",
    docs: "drape-generalized-alpha",
    sources: drape_generalized_alpha::SOURCES,
    equation: Excerpt::docs(
        "(1 − α_m) a_{n+1} + α_m a_n = (1 − α_f) M⁻¹f_{n+1} + α_f M⁻¹f_n",
        "v_{n+1} = v_n + h ((1 − γ) a_n + γ a_{n+1})",
    ),
    code: Excerpt::step(
        "// X* = x_n + h v_n + h² (½ − β) a_n − τ_x (v_n + h (1 − γ) a_n), (4)",
        "self.memory.v_star[i] =",
    ),
    law: Law::Alpha(|| GeneralizedAlpha::chung_hulbert(0.5)),
    load: None,
    setting: Setting::oscillator(&["generalized-alpha", "backward-euler"]).time(0.1, 4.0),
    question: Question::EnergyLeft,
    attempt: "Set rho_inf=0 and rho_inf=1 in two panes. Then multiply k/m by 10000: in which pane \
              does the spring ring, in which is it still?",
    low: "It keeps more than that.",
    high: "It loses more than that: rho_inf is not 1.",
    traps: &[
        Trap {
            value: |s| Law::OneStep(backward_euler).left(s),
            hint: "That is what backward Euler leaves. Look at the first pane.",
        },
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
    ],
    study: "order",
};
