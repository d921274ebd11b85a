//! Diagonally implicit Runge–Kutta methods.

use super::Entry;
use super::runs::{Contender, Film, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::recurrence::{RungeKutta, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_dirk::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::ImplicitStages,
        matrix: Matrix::of_newton,
        divides: false,
        is_limited: false,
        forms: &[
            form("dirk").limit(ALWAYS, |t, e| radius(&RungeKutta::tr_bdf2(), t, e)),
            form("dirk, sdirk2").limit(ALWAYS, |t, e| radius(&RungeKutta::sdirk2(), t, e)),
            form("dirk, sdirk3")
                .limit(ALWAYS, |t, e| radius(&RungeKutta::sdirk3(), t, e))
                .order(Some(3)),
            form("dirk, esdirk3")
                .limit(ALWAYS, |t, e| radius(&RungeKutta::esdirk3(), t, e))
                .order(Some(3)),
            form("dirk, sdirk4")
                .limit(ALWAYS, |t, e| radius(&RungeKutta::sdirk4(), t, e))
                .order(Some(4)),
            form("dirk, one CG solve a stage"),
        ],
    },
    runs: Runs {
        order: &[
            Variant::new("dirk", "dirk:residual=1e-13,solver=cholesky"),
            Variant::new("dirk, sdirk2", "dirk:tableau=sdirk2,residual=1e-13,solver=cholesky"),
            Variant::new("dirk, sdirk3", "dirk:tableau=sdirk3,residual=1e-15,solver=cholesky"),
            Variant::new("dirk, esdirk3", "dirk:tableau=esdirk3,residual=1e-15,solver=cholesky"),
            Variant::new("dirk, sdirk4", "dirk:tableau=sdirk4,residual=1e-16,solver=cholesky"),
        ],
        momentum: &[
            (Variant::new("dirk", "dirk:residual=1e-12,solver=cholesky"), Keeps::AsStated),
            (Variant::new("dirk, esdirk3", ESDIRK3), Keeps::AsStated),
            (Variant::new("dirk, sdirk4", SDIRK4), Keeps::AsStated),
        ],
        energy: &[Variant::new("dirk", EXACT)],
        hard_cases: &[Variant::new("dirk", EXACT)],
        stability: &[
            Variant::new("dirk", EXACT),
            Variant::new("dirk, esdirk3", ESDIRK3),
            Variant::new("dirk, sdirk4", SDIRK4),
        ],
        locking: &[(Variant::new("dirk", EXACT), Steps::Long)],
        work_precision: &[
            work::headline("dirk", "dirk:residual=1e-3,solver=cholesky"),
            work::extra("dirk, saved factor", "dirk:residual=1e-3,jacobian=saved,solver=cholesky"),
            work::extra("dirk, one CG solve a stage", LINEARISED),
            work::extra("dirk, auto", "dirk:residual=1e-3"),
            work::main("dirk, safeguarded", SAFEGUARDED),
            work::extra("dirk, esdirk3", ESDIRK3),
            work::extra("dirk, sdirk4", SDIRK4),
        ],
        animation: &[
            Film::ladder("dirk, safeguarded auto", SAFEGUARDED),
            Film::ladder("dirk", EXACT),
            Film::ladder("dirk, auto", "dirk:residual=1e-3"),
            Film::ladder(
                "dirk, one iteration",
                "dirk:max_iterations=1,solver=cg,cg_tolerance=0.01",
            ),
            Film::ladder(
                "dirk, three iterations",
                "dirk:residual=1e-2,max_iterations=3,solver=multigrid",
            ),
        ],
        scaling: &[Contender {
            label: "dirk",
            method: "dirk:residual=1e-3,solver=cholesky",
            largest: 100,
        }],
        ..Runs::DEFAULTS
    },
};

/// A form solved by factors, for studies of the method rather than of its solver.
const EXACT: &str = "dirk:solver=cholesky";

/// The same form, of order 3.
const ESDIRK3: &str = "dirk:tableau=esdirk3,solver=cholesky";

/// The same form, of order 4.
const SDIRK4: &str = "dirk:tableau=sdirk4,solver=cholesky";

/// A form with one linear solve a stage.
const LINEARISED: &str = "dirk:max_iterations=1,solver=cg,cg_tolerance=0.01";

/// The same form, with more iterations where the residual would add energy.
const SAFEGUARDED: &str = "dirk:max_iterations=1,safeguard=work";

fn radius(method: &RungeKutta, theta: f64, eta: f64) -> f64 {
    spectral_radius(&method.amplification(theta, eta))
}

fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("L-stable on linear systems; {TURNING}"))
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Two implicit stages: how fast does the loss shrink?",
    idea: "The trapezoidal rule takes the first part of the step, and backward differences the \
           rest. The method has order 2 and damps motion that it cannot resolve. The energy that \
           it removes from an oscillation falls faster than its error: for short steps, the loss \
           in a given time is proportional to the third power of the step.",
    docs: "drape-dirk",
    sources: drape_dirk::SOURCES,
    equation: Excerpt::docs("w₁ = v_n,  a₁ = M⁻¹f(x_n, v_n)", "(5)"),
    code: Excerpt::step(
        "x += self.w[j][particle] * (h * a);",
        "state.v.copy_from_slice(&self.w[last]);",
    ),
    law: Law::OneStep(|t, e| RungeKutta::tr_bdf2().amplification(t, e)),
    load: None,
    setting: Setting::oscillator(&["dirk", "backward-euler"]).time(0.1, 4.0),
    question: Question::LossRatio,
    attempt: "Halve the step twice more. The ratio comes closer to 8. Do the same with the second \
              pane.",
    low: "The loss falls faster than that.",
    high: "At steps this long the loss does not fall that fast yet.",
    traps: &[
        Trap {
            value: |_| 4.0,
            hint: "Order 2 divides the error by 4. The loss of energy is proportional to the third \
                   power of the step.",
        },
        Trap { value: |_| 2.0, hint: "That is the ratio of a method of order 1 at short steps." },
        Trap {
            value: |_| 8.0,
            hint: "That is the limit for short steps. These steps are long: measure.",
        },
    ],
    study: "order",
};
