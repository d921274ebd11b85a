//! Exponential Rosenbrock-Euler.

use super::Entry;
use super::runs::{Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, Problem, TURNING, Theory, at_rest_or, form};
use drape_oracle::recurrence::{exact_oscillator, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_exponential::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Linearised,
        matrix: |_| Matrix::Blocks,
        divides: false,
        is_limited: false,
        forms: &[form("exponential").limit(ALWAYS, |t, e| spectral_radius(&exact_oscillator(t, e)))],
    },
    runs: Runs {
        order: &[Variant::new("exponential", "exponential:krylov_tol=1e-10")],
        momentum: &[(Variant::new("exponential", "exponential:krylov_tol=1e-10"), Keeps::AsStated)],
        locking: &[(Variant::new("exponential", "exponential"), Steps::Long)],
        work_precision: &[
            work::main("exponential", "exponential:krylov_tol=1e-3"),
            work::extra("exponential, tight", "exponential"),
        ],
        ..Runs::DEFAULTS
    },
};

/// Linear motion is exact. For springs that turn, nothing bounds the effect of the tangent.
fn case(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("exact on linear systems; {TURNING}"))
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "The exact linear motion",
    idea: "The linearised motion of a step has a closed form, the exponential of its matrix. A \
           Krylov subspace approximates it to a tolerance by products with the matrix; the method \
           solves no linear system. A linear spring moves exactly, at any step size. Where springs \
           turn, the error of the linearisation remains.",
    docs: "drape-exponential",
    sources: drape_exponential::SOURCES,
    equation: Excerpt::docs(
        "y_{n+1} = y_n + h φ₁(hJ) F = y_n + h F + h² φ₂(hJ) J F",
        "φ₂(z) = (φ₁(z) − 1)/z",
    ),
    code: Excerpt::step(
        "/// `y ← y + τ F + τ² φ₂(τJ) J F`, which is `y + τ φ₁(τJ) F`, (1).",
        "state.v[i] += (acceleration[i] + v[i] * tau) * tau;",
    ),
    law: Law::OneStep(exact_oscillator),
    load: None,
    setting: Setting::oscillator(&["exponential", "midpoint"]).time(0.2, 4.0),
    question: Question::Period,
    attempt: "Open loaded-spring with both methods: that spring turns, so the linearised motion is \
              not the true one.",
    low: "The oscillation is slower than that. A few steps cover a period, so count several \
          periods.",
    high: "The oscillation is faster than that. Do you count in the first pane?",
    traps: &[Trap {
        value: |s| {
            std::f64::consts::TAU * s.step
                / (2.0 * libm::atan(0.5 * s.step * libm::sqrt(s.stiffness)))
        },
        hint: "That is the period of the midpoint, the second pane.",
    }],
    study: "order",
};
