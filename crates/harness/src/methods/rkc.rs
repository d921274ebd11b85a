//! Runge–Kutta–Chebyshev.

use super::Entry;
use super::runs::{Contender, Film, Runs, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, Theory, form, no_theorem};
use drape_oracle::recurrence::{rkc2, spectral_radius};
use drape_report::family::Kin;

/// Number of stages of the form with a fixed number.
const STAGES: u32 = 6;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_rkc::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::ExplicitStages,
        matrix: |_| Matrix::None,
        divides: true,
        is_limited: false,
        forms: &[
            // The method divides a step until its parts are stable.
            form("rkc").limit(ALWAYS, |_, _| 1.0),
            form("rkc, 6 stages").limit("|P₆(z)| ≤ 1: η < 22.9, undamped never", |t, e| {
                spectral_radius(&rkc2(STAGES, t, e))
            }),
        ],
    },
    runs: Runs {
        order: FIXED,
        stability: FIXED,
        work_precision: &[
            work::main("rkc", "rkc"),
            work::extra("rkc, 6 stages", "rkc:step=fixed,stages=6"),
        ],
        animation: &[Film::ladder("rkc", "rkc")],
        scaling: &[Contender { label: "rkc", method: "rkc", largest: 316 }],
        ..Runs::DEFAULTS
    },
};

/// The form with a fixed number of stages.
const FIXED: &[Variant] =
    &[Variant::new("rkc", "rkc"), Variant::new("rkc, 6 stages", "rkc:step=fixed,stages=6")];

fn case(_: &Problem<'_>) -> Expectation {
    no_theorem("substeps and stages by the damping of modes that are damped like the springs")
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Runge, Kutta and Chebyshev: stages against damping",
    idea: "An explicit step has several stages. If they follow Chebyshev polynomials, the range of \
           stable damping grows with the square of their number, not with the number itself. So \
           heavy damping costs few evaluations and no solve.",
    docs: "drape-rkc",
    sources: drape_rkc::SOURCES,
    equation: Excerpt::docs("w₀ = 1 + ε/s²", "P_s(z) = a_s + b_s T_s(w₀ + w₁ z)"),
    code: Excerpt::step(
        "accelerations(system, Level { t, x, v }, acceleration); // F_{j−1}",
        "last.v[i] * mu",
    ),
    law: Law::OneStep(|t, e| rkc2(STAGES, t, e)),
    load: None,
    setting: Setting::oscillator(&["rkc:step=fixed,stages=6", "explicit-euler"])
        .spring(1.0, 100.0)
        .time(0.1, 10.0),
    question: Question::LongestStep,
    attempt: "Set stages=12 and look for the limit again: is it twice or four times as long? Count \
              force evaluations, not steps.",
    low: "At this step the motion still dies out. Take a longer one.",
    high: "At this step the damping makes the velocity grow. Take a shorter one.",
    traps: &[
        Trap {
            value: |s| 2.0 / s.damping,
            hint: "That is 2/δ, the limit of explicit Euler, which uses one stage.",
        },
        Trap {
            value: |s| 2.0 * f64::from(STAGES) / s.damping,
            hint: "That is the limit of as many steps of explicit Euler. Chebyshev stages allow a \
                   longer step: their limit grows with the square of their number.",
        },
    ],
    study: "stability",
};
