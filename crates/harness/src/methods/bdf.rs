//! Backward differentiation formulas.

use super::Entry;
use super::runs::{Contender, Film, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::recurrence::{backward_euler, bdf};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_multistep::BACKWARD_DIFFERENTIATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Implicit,
        matrix: Matrix::of_newton,
        divides: false,
        is_limited: false,
        forms: &[
            form("bdf2").limit(ALWAYS, |t, e| bdf(2, t, e).spectral_radius()),
            form("bdf, 3 steps").order(Some(3)),
        ],
    },
    runs: Runs {
        order: &[
            Variant::new("bdf2", "bdf2:residual=1e-12,solver=cholesky"),
            Variant::new("bdf, 3 steps", "bdf2:steps=3,residual=1e-12,solver=cholesky"),
        ],
        momentum: &[
            (Variant::new("bdf2", "bdf2:residual=1e-12,solver=cholesky"), Keeps::AsStated),
            (
                Variant::new("bdf, 3 steps", "bdf2:steps=3,residual=1e-12,solver=cholesky"),
                Keeps::AsStated,
            ),
        ],
        energy: &[Variant::new("bdf2", EXACT)],
        hard_cases: &[Variant::new("bdf2", EXACT)],
        stability: &[Variant::new("bdf2", EXACT)],
        locking: &[(Variant::new("bdf2", EXACT), Steps::Long)],
        animation: &[
            Film::ladder("bdf2, safeguarded auto", SAFEGUARDED),
            Film::ladder("bdf2", EXACT),
            Film::ladder("bdf2, auto", "bdf2:residual=1e-3"),
            Film::ladder("bdf2, one iteration", "bdf2:residual=1e-2,max_iterations=1,solver=cg"),
            Film::ladder(
                "bdf2, three iterations",
                "bdf2:residual=1e-2,max_iterations=3,solver=multigrid",
            ),
        ],
        work_precision: &[
            work::headline("bdf2", LOOSE),
            work::extra("bdf2, tight", EXACT),
            work::extra("bdf2, auto", "bdf2:residual=1e-3"),
            work::main("bdf2, safeguarded", SAFEGUARDED),
            work::adaptive("bdf2, adaptive", LOOSE),
        ],
        scaling: &[Contender {
            label: "bdf2",
            method: "bdf2:residual=1e-3,solver=cholesky",
            largest: 100,
        }],
        ..Runs::DEFAULTS
    },
};

/// A form solved by factors, for studies of the method rather than of its solver.
const EXACT: &str = "bdf2:solver=cholesky";

/// The same form, solved to a thousandth.
const LOOSE: &str = "bdf2:residual=1e-3,solver=cholesky";

/// A form with one linear solve a step, and with more where its residual would add energy.
const SAFEGUARDED: &str = "bdf2:max_iterations=1,safeguard=work";

fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("A-stable on linear systems; {TURNING}"))
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Backward differences over two steps",
    idea: "A parabola through two old levels and the new one satisfies the equation at the new \
           level. The method has order 2, is as stable as backward Euler, and costs the same. An \
           oscillation that the steps resolve loses far less energy; one that they do not resolve \
           still dies out. The first step has no old levels, so it is a step of backward Euler.",
    docs: "drape-multistep",
    sources: drape_multistep::SOURCES,
    equation: Excerpt::docs(
        "Σ_{j=0}^{k} α_j y_{n+j} = h β_k f_{n+k}                    backward differentiation",
        "backward differentiation",
    ),
    code: Excerpt::of(
        "src/step/bdf.rs",
        "let formula = LinearMultistep::bdf(&steps[..k]);",
        "formula.tau(h)",
    ),
    law: Law::TwoSteps { first: backward_euler, later: |t, e| bdf(2, t, e), substeps: 1 },
    load: None,
    setting: Setting::oscillator(&["bdf2", "backward-euler"]).time(0.05, 1.0),
    question: Question::EnergyLeft,
    attempt: "Step once, and see how much of the loss belongs to the first step. Then compare both \
              panes at h = 0.01 s.",
    low: "It keeps more than that. Is the second pane backward Euler?",
    high: "It loses more than that, most of it in steps that are not the first.",
    traps: &[
        Trap {
            value: |s| Law::OneStep(backward_euler).left(s),
            hint: "That is what backward Euler leaves. Look at the first pane.",
        },
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
    ],
    study: "order",
};
