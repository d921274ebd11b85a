//! Baraff and Witkin.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, LoadLaw, PUSHING, Problem, Theory, at_rest_or, beside_explicit, form,
    implicit, no_theorem,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_baraff_witkin::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Implicit,
        matrix: |settings| Matrix::BlockFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        // Across the spring, the linearised force has the old secant stiffness.
        forms: &[form("baraff-witkin")
            .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e)))
            .spin(|theta, before, _| spin::baraff_witkin(theta, 0.0, before))],
    },
    runs: Runs {
        order: &[Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-12")],
        momentum: &[(
            Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-12"),
            Keeps::AsStated,
        )],
        locking: &[(Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-8"), Steps::All)],
        locked_spring: &[(
            Variant::new("baraff-witkin", "baraff-witkin:forcing_term=1e-14"),
            LoadLaw::Free,
        )],
        work_precision: &[
            work::headline("baraff-witkin", "baraff-witkin"),
            work::extra("baraff-witkin, Cholesky", "baraff-witkin:solver=cholesky"),
        ],
        scaling: &[Contender { label: "baraff-witkin", method: "baraff-witkin", largest: 316 }],
        are_effects_timed: true,
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    let implicit = implicit(problem);
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if problem.are_all(implicit) {
        at_rest_or(
            problem,
            "one Newton step with clamped tangents: A-stable where they are constant",
        )
    } else {
        beside_explicit(problem, implicit)
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "One linear solve a step: order 1",
    idea: "Backward Euler needs a nonlinear solve. Baraff and Witkin take a single Newton \
           iteration: they linearise the forces at the old positions and solve one linear system \
           by conjugate gradients. On a linear spring this is exactly backward Euler, with its \
           damping. For a method of order 1, the loss is proportional to the step.",
    docs: "drape-baraff-witkin",
    sources: drape_baraff_witkin::SOURCES,
    equation: Excerpt::docs(
        "(M − h ∂f/∂v − h² ∂f/∂x) Δv = h (f_0 + h ∂f/∂x v_0 + ∂f/∂x y)",
        "x_{n+1} = x_n + h (v_n + Δv) + y",
    ),
    code: Excerpt::step(
        "linear.linearise(system, state, y, h);",
        "linear.solve(changes, change, &mut report)?;",
    ),
    law: Law::OneStep(backward_euler),
    load: None,
    setting: Setting::oscillator(&["baraff-witkin", "dirk"]).time(0.001, 1.0),
    question: Question::LossRatio,
    attempt: "Take steps ten times as long: why does the ratio fall? The loss cannot exceed the \
              energy at the start.",
    low: "The loss falls faster than that.",
    high: "In a method of order 1, half of the step does not reduce the loss that much.",
    traps: &[
        Trap {
            value: |_| 4.0,
            hint: "That is the ratio of an error of order 2. This method has order 1.",
        },
        Trap { value: |_| 8.0, hint: "That is what the second pane shows." },
    ],
    study: "order",
};
