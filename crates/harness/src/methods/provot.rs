//! Provot.

use super::Entry;
use super::runs::{Contender, Runs, Variant};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{Expectation, Problem, Theory, form, no_theorem};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{spectral_radius, symplectic_euler};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_provot::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Corrected,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: true,
        // The limit holds for springs within the elongation limit. A method that shortens springs
        // solves another equation, so it claims no order.
        forms: &[form("provot")
            .limit("θ + 2η < 4", |t, e| spectral_radius(&symplectic_euler(t, e)))
            .spin(|_, _, _| spin::symplectic_euler(0.0))
            .order(None)],
    },
    runs: Runs {
        order: &[
            Variant::new("provot", "provot"),
            Variant::new("provot, limit out of reach", "provot:limit=10"),
        ],
        scaling: &[Contender { label: "provot", method: "provot", largest: 316 }],
        ..Runs::DEFAULTS
    },
};

fn case(_: &Problem<'_>) -> Expectation {
    no_theorem("nothing is proved about moving the ends of springs behind an explicit step")
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Provot: shorten what has become too long",
    idea: "The step is explicit. After it, the method shortens each spring that is longer than its \
           limit, by moving its ends. A cloth of soft springs then looks stiff at a long step. The \
           energy of the stretch is lost, so this is no longer the motion of the springs.",
    docs: "drape-provot",
    sources: drape_provot::SOURCES,
    equation: Excerpt::docs(
        "v = v_n + h M⁻¹ f(x_n, v_n)                                                         (P1)",
        "(P2)",
    ),
    code: Excerpt::step(
        "kick(system, h, force, &mut contacts.free_velocity);",
        "report.correction = limit.correct",
    ),
    law: Law::OneStep(symplectic_euler),
    load: None,
    setting: Setting::oscillator(&["provot:limit=0.2", "symplectic-euler"])
        .spring(1.0, 0.0)
        .time(0.02, 4.0),
    question: Question::GreatestStretch,
    attempt: "Set limit=0.6, which the spring never reaches: both panes agree. Where does the \
              kinetic energy go when the spring reaches a limit?",
    low: "The spring becomes longer than that before the limit holds it.",
    high: "The limit does not let the spring become that long.",
    traps: &[Trap {
        value: |s| 50.0 / libm::sqrt(s.stiffness),
        hint: "That is the stretch of the free oscillation, v/ω. The second pane reaches it; in \
               the first the limit prevents it.",
    }],
    study: "course",
};
