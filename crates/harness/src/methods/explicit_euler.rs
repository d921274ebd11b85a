//! Explicit Euler.

use super::Entry;
use super::runs::{Contender, Runs};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::studies::short;
use crate::theory::{Expectation, Problem, Theory, form, no_theorem, stable, unstable};
use drape_integrator::Implicit;
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{explicit_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_explicit_euler::EXPLICIT,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Explicit,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        forms: &[form("explicit-euler")
            .limit("θ ≤ η and 2η ≤ 4 + θ", |t, e| spectral_radius(&explicit_euler(t, e)))
            .spin(|theta, before, _| spin::explicit_euler(theta, 0.0, before))],
    },
    runs: Runs {
        scaling: &[Contender { label: "explicit-euler", method: "explicit-euler", largest: 316 }],
        ..Runs::DEFAULTS
    },
};

/// `x_{n+1} = x_n + w_n`, `w_{n+1} = w_n − θ x_n − η w_n`: stable for `θ ≤ η` and `2η ≤ 4 + θ`.
fn case(problem: &Problem<'_>) -> Expectation {
    let growing = problem.growing(|theta, eta, [x, w, ..]| {
        let force = -theta * *x - eta * *w;
        *x += *w;
        *w += force;
    });
    if let Some(theta) = growing {
        return unstable(format!("stable only for h²λ ≤ hδ; here h²λ = {}", short(theta)));
    }
    let (_, h) = problem.steps();
    let mut is_damped_enough = !problem.has_contacts();
    Implicit::Springs.visit_weights(problem.system(), &mut |_, _, k, c| {
        is_damped_enough &= c >= h * k;
    });
    if is_damped_enough && h * problem.bounds().1 <= 2.0 {
        stable("every spring has c ≥ hk, and hδ ≤ 2")
    } else {
        no_theorem("within or near its limit: what grows, grows too slowly to be seen for certain")
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Explicit Euler: stable only by the damping of the springs",
    idea: "Positions move with the old velocities, and velocities with the forces at the old \
           positions. Each step adds energy to an oscillation: without damping it grows at every \
           step size. Damping removes energy, and the step is stable as long as the damping \
           removes more than the step adds.",
    docs: "drape-explicit-euler",
    sources: drape_explicit_euler::SOURCES,
    equation: Excerpt::docs(
        "x_{n+1} = x_n + h v_n          v_{n+1} = v_n + h M⁻¹ f(x_n, v_n)",
        "(2)",
    ),
    code: Excerpt::of(
        "src/step/explicit.rs",
        "system.forces(state.level(), force); // f(x_n, v_n)",
        "kick(system, h, force, &mut state.v);",
    ),
    law: Law::OneStep(explicit_euler),
    load: None,
    setting: Setting::oscillator(&["explicit-euler", "leapfrog"])
        .spring(100.0, 2.0)
        .time(0.05, 10.0),
    question: Question::LongestStep,
    attempt: "Set the damping to 0 and look for a stable step. Then double the stiffness: the \
              limit halves, while the limit of leapfrog shrinks only by √2.",
    low: "At this step the total energy still falls. Take a longer one.",
    high: "At this step the oscillation grows: give the run more time, or take a shorter step.",
    traps: &[
        Trap {
            value: |s| 2.0 / libm::sqrt(s.stiffness),
            hint: "That is 2/ω, the limit of leapfrog without damping.",
        },
        Trap {
            value: |s| 2.0 / s.damping,
            hint: "That is 2/δ, the limit of the damping alone. The spring sets a lower one.",
        },
    ],
    study: "stability",
};
