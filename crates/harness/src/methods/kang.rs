//! Kang.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, LoadLaw, Problem, Theory, form, no_theorem};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, kang_anchored, kang_pair, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_kang::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Corrected,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        forms: &[
            form("kang")
                .limit(ALWAYS, |t, e| spectral_radius(&kang_pair(0.5 * t, 0.5 * e, 1)))
                .spin(|theta, _, _| spin::kang(theta, 0.0, 1)),
            form("kang, 8 sweeps").spin(|theta, _, _| spin::kang(theta, 0.0, 8)),
        ],
    },
    runs: Runs {
        order: &[Variant::new("kang", "kang"), Variant::new("kang, 8 sweeps", "kang:sweeps=8")],
        momentum: &[
            (Variant::new("kang", "kang"), Keeps::AsStated),
            (Variant::new("kang, 8 sweeps", "kang:sweeps=8"), Keeps::AsStated),
        ],
        locking: &[
            (Variant::new("kang", "kang"), Steps::All),
            (Variant::new("kang, 8 sweeps", "kang:sweeps=8"), Steps::One),
        ],
        locked_spring: &[(Variant::new("kang", "kang"), LoadLaw::Unfiltered)],
        work_precision: &[
            work::main("kang", "kang"),
            work::extra("kang, 8 sweeps", "kang:sweeps=8"),
        ],
        scaling: &[Contender { label: "kang", method: "kang", largest: 316 }],
        ..Runs::DEFAULTS
    },
};

fn case(_: &Problem<'_>) -> Expectation {
    no_theorem("two Jacobi sweeps are stable for springs of rest length 0 only")
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Kang: one correction by the neighbours",
    idea: "The method does not solve the system with the constant matrix. Each particle takes the \
           change of velocity that it would have alone; one correction then adds the motion of its \
           neighbours. If its only neighbour is pinned, the correction is zero, and the step is \
           one of backward Euler.",
    docs: "drape-kang",
    sources: drape_kang::SOURCES,
    equation: Excerpt::docs(
        "Δv*_i = h F̃_i / D_i                                     each particle alone",
        "corrected by its neighbours",
    ),
    code: Excerpt::step(
        "// Δv*_i = h F̃_i / D_i, (K2)",
        "drift(system, h, &state.v, &mut state.x);",
    ),
    law: Law::OneStep(|t, e| kang_anchored(t, e, 1)),
    load: None,
    setting: Setting::oscillator(&["kang", "exponential"]).time(0.02, 0.3),
    question: Question::EnergyLeft,
    attempt: "Open hanging-textile-1e4: two sweeps do not solve a sheet. Compare sweeps=1 with \
              sweeps=8.",
    low: "It keeps more than that.",
    high: "It damps like backward Euler, whose system it approximates.",
    traps: &[
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
        Trap {
            value: |s| 10.0 * libm::sqrt(Law::OneStep(backward_euler).left(s)),
            hint: "That is the share of the amplitude. The energy goes with its square.",
        },
    ],
    study: "locking",
};
