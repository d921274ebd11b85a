//! The impulse method.

use super::Entry;
use super::runs::{Contender, Runs, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::studies::short;
use crate::theory::{Expectation, Problem, Theory, form, limit, no_theorem, unstable};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{impulse, spectral_radius};
use drape_report::family::Kin;
use nalgebra::Vector2;

/// Its default number of fast steps in a step.
const RATIO: u32 = 3;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_multirate::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::ExplicitStages,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        // This holds where all springs are fast. Slow springs bring resonance at √θ = π.
        forms: &[form("multirate")
            .limit(
                "θ < 36 and η < 12, but near multiples of π in √θ beside slow springs",
                |t, e| spectral_radius(&impulse(t, 0.0, e, RATIO)),
            )
            .spin(|_, _, _| spin::kicks(&[], 0.0, 2))],
    },
    runs: Runs {
        work_precision: &[work::main("multirate", "multirate")],
        scaling: &[Contender { label: "multirate", method: "multirate", largest: 100 }],
        ..Runs::DEFAULTS
    },
};

/// Only tension springs set the limit; shear springs resonate with them.
fn case(problem: &Problem<'_>) -> Expectation {
    let growing = problem.growing(|theta, eta, state| {
        let [x, w, ..] = *state;
        // Taking all springs as fast gives a limit above the true one.
        let new = impulse(theta, 0.0, eta, RATIO) * Vector2::new(x, w);
        *state = [new.x, new.y, 0.0, 0.0];
    });
    match growing {
        Some(theta) => unstable(format!(
            "H²λ = {} at the start is beyond the limit 4 ratio² of the short steps",
            short(theta)
        )),
        None => no_theorem(format!("slow forces resonate with fast modes ({})", limit(problem))),
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Short steps for stiff springs alone",
    idea: "Tension springs are stiff and cheap to evaluate; other forces are soft and may be \
           expensive. The stiff springs take several short leapfrog steps inside each long step, \
           and the soft forces give half a kick at both of its ends. If these kicks keep time with \
           a fast oscillation, they resonate.",
    docs: "drape-multirate",
    sources: drape_multirate::SOURCES,
    equation: Excerpt::docs("v ← v + H/2 M⁻¹ F_S(x_n)", "v ← v + H/2 M⁻¹ F_S(x_{n+1})"),
    code: Excerpt::step(
        "self.slow.begin(system, &state.x, &mut report); // F_S(x_n)",
        "kick(system, 0.5 * h, self.slow.force(), &mut state.v); // v ← v + H/2 M⁻¹ F_S, (I3)",
    ),
    law: Law::OneStep(|t, e| impulse(t, 0.0, e, RATIO)),
    load: None,
    setting: Setting::oscillator(&["multirate", "leapfrog"]).time(0.3, 30.0),
    question: Question::LongestStep,
    attempt: "Set ratio=6: how does the limit change? On a sheet with shear springs the limit is \
              lower; try hanging-textile-sheared-1e4.",
    low: "At this step the energy oscillates but does not grow. Take a longer one.",
    high: "At this step the energy explodes. Take a shorter one.",
    traps: &[Trap {
        value: |s| 2.0 / libm::sqrt(s.stiffness),
        hint: "That is 2/ω, the limit of leapfrog without damping.",
    }],
    study: "stability",
};
