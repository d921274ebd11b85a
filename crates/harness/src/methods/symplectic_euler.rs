//! Symplectic Euler.

use super::Entry;
use super::runs::{Contender, Film, Runs, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{Expectation, Factors, Problem, Theory, explicit, form};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{
    spectral_radius, symplectic_euler, symplectic_euler_implicit_damping,
};
use drape_report::family::Kin;

/// Its forms in studies that compare limits and orders.
const FORMS: &[Variant] = &[
    Variant::new("symplectic-euler", "symplectic-euler"),
    Variant::new("symplectic-euler, implicit damping", "symplectic-euler:damping=implicit"),
];

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_explicit_euler::SYMPLECTIC,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Explicit,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: true,
        forms: &[
            form("symplectic-euler")
                .limit("θ + 2η < 4", |t, e| spectral_radius(&symplectic_euler(t, e)))
                .spin(|_, _, _| spin::symplectic_euler(0.0)),
            form("symplectic-euler, implicit damping").limit("θ < 4 + 2η", |t, e| {
                spectral_radius(&symplectic_euler_implicit_damping(t, e))
            }),
        ],
    },
    runs: Runs {
        order: FORMS,
        stability: FORMS,
        animation: &[
            Film::limit("symplectic-euler", "symplectic-euler"),
            Film::limit("symplectic-euler, implicit damping", "symplectic-euler:damping=implicit"),
        ],
        work_precision: &[work::headline("symplectic-euler", "symplectic-euler")],
        scaling: &[Contender {
            label: "symplectic-euler",
            method: "symplectic-euler",
            largest: 1000,
        }],
        are_effects_timed: true,
        are_effects_quick: true,
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    explicit(problem, "h²λ + 2hδ < 4", &Factors::ONE_STEP)
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Symplectic Euler: the new velocity moves the positions",
    idea: "The method differs from explicit Euler in one word: the positions move with the new \
           velocity. The map then preserves areas in the space of position and velocity, so an \
           oscillation cannot grow below the limit. Explicit damping makes that limit shorter.",
    docs: "drape-explicit-euler",
    sources: drape_explicit_euler::SOURCES,
    equation: Excerpt::docs(
        "v_{n+1} = v_n + h M⁻¹ f(x_n, v_n)                                                   (S1)",
        "(S2)",
    ),
    code: Excerpt::of(
        "src/step/symplectic.rs",
        "system.forces(state.level(), force); // f(x_n, v_n)",
        "drift(system, h, &state.v, &mut state.x);",
    ),
    law: Law::OneStep(symplectic_euler),
    load: None,
    setting: Setting::oscillator(&["symplectic-euler", "symplectic-euler:damping=implicit"])
        .spring(100.0, 8.0)
        .time(0.15, 20.0),
    question: Question::LongestStep,
    attempt: "The second pane takes the damping at the new velocity: find its limit too. Which \
              damping makes the limit longer, which one makes it shorter?",
    low: "At this step the total energy still falls. Take a longer one.",
    high: "At this step the oscillation grows: explicit damping lowers the limit.",
    traps: &[
        Trap {
            value: |s| 2.0 / libm::sqrt(s.stiffness),
            hint: "That is 2/ω, the limit of leapfrog without damping.",
        },
        Trap {
            value: |s| 2.0 / s.damping,
            hint: "That is 2/δ, the limit of the damping alone. The spring and the damping add up.",
        },
    ],
    study: "stability",
};
