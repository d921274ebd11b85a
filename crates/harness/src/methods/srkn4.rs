//! Symplectic Runge–Kutta–Nyström of order 4.

use super::Entry;
use super::runs::{
    Contender, Runs, Steps, Variant,
    work::{self, Knob},
};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::studies::short;
use crate::theory::{Expectation, Problem, Theory, form, limit, no_theorem, unstable};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{spectral_radius, srkn4};
use drape_report::family::Kin;
use nalgebra::Vector2;

/// Number of terms in the series of its damped kicks.
const TERMS: u32 = 5;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_srkn4::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::ExplicitStages,
        matrix: |_| Matrix::None,
        divides: true,
        is_limited: false,
        forms: &[form("srkn4")
            .limit("θ < 25.27 without damping, but for a hairline at π²; η < 8.8", |t, e| {
                spectral_radius(&srkn4(t, e, TERMS))
            })
            .spin(|_, _, _| spin::kicks(&[], 0.0, TERMS))],
    },
    runs: Runs {
        hard_cases: &[
            Variant::new("srkn4", "srkn4"),
            Variant::new("srkn4 (auto)", "srkn4:step=auto"),
        ],
        work_precision: &[
            work::main("srkn4", "srkn4:step=bound").knob(Knob::Setting("safety", SAFETIES)),
            work::extra("srkn4, fixed steps", "srkn4"),
        ],
        locking: &[
            (Variant::new("srkn4", "srkn4"), Steps::One),
            (Variant::new("srkn4 (auto)", "srkn4:step=auto"), Steps::One),
        ],
        scaling: &[Contender { label: "srkn4", method: "srkn4", largest: 316 }],
        ..Runs::DEFAULTS
    },
};

/// Length of a substep over the stability limit.
const SAFETIES: &[f64] = &[0.95, 0.7, 0.5, 0.25, 0.125];

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.choice.settings().word("step") != "fixed" {
        return no_theorem("substeps within the limit of a linear motion");
    }
    let growing = problem.growing(|theta, eta, state| {
        let [x, w, ..] = *state;
        let new = srkn4(theta, eta, TERMS) * Vector2::new(x, w);
        *state = [new.x, new.y, 0.0, 0.0];
    });
    match growing {
        Some(theta) => unstable(format!(
            "h²λ = {} at the start is beyond its limit, whatever the damping",
            short(theta)
        )),
        None => {
            no_theorem(format!("linear theory finds no growth at the start ({})", limit(problem)))
        }
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Order 4 without a solve",
    idea: "A step has six kicks and six drifts of different lengths, some of them backwards. They \
           cancel all errors up to order 4, and the map still preserves areas. A step costs six \
           evaluations of the forces. It may be longer than a step of leapfrog, and its error is \
           far smaller.",
    docs: "drape-srkn4",
    sources: drape_srkn4::SOURCES,
    equation: Excerpt::docs("v ← e^{−b h M⁻¹D} v + …", "(N3)"),
    code: Excerpt::step(
        "self.kick(system, KICKS[0] * h, state, &mut report);",
        "self.kick(system, b * h, state, &mut report);",
    ),
    law: Law::OneStep(|t, e| srkn4(t, e, TERMS)),
    load: None,
    setting: Setting::oscillator(&["srkn4", "leapfrog"]).spring(100.0, 1.0).time(0.3, 20.0),
    question: Question::LongestStep,
    attempt: "Divide the limit by six, the number of force evaluations, and compare with leapfrog: \
              how much does order 4 cost at the limit, and how much accuracy does it gain at a \
              fifth of it?",
    low: "At this step the total energy still falls. Take a longer one.",
    high: "At this step the oscillation grows. Take a shorter one.",
    traps: &[
        Trap {
            value: |s| 2.0 / libm::sqrt(s.stiffness),
            hint: "That is 2/ω, the limit of leapfrog without damping.",
        },
        Trap {
            value: |s| 12.0 / libm::sqrt(s.stiffness),
            hint: "That is the limit of six steps of leapfrog. Some of the six drifts go \
                   backwards, which makes the limit shorter.",
        },
    ],
    study: "stability",
};
