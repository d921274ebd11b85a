//! Adams-Bashforth.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::studies::short;
use crate::theory::{Expectation, Problem, Theory, form, no_theorem, unstable};
use drape_oracle::recurrence::{adams_bashforth, explicit_euler};
use drape_report::family::Kin;

/// Its forms in studies that compare limits and orders.
const FORMS: &[Variant] = &[
    Variant::new("adams-bashforth2", "adams-bashforth2"),
    Variant::new("adams-bashforth, 3 steps", "adams-bashforth2:steps=3"),
];

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_multistep::EXPLICIT_ADAMS,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Explicit,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        forms: &[
            form("adams-bashforth2")
                .limit("roots of ρ² + ηρσ + θσ²; undamped never", |t, e| {
                    adams_bashforth(2, t, e).spectral_radius()
                }),
            form("adams-bashforth, 3 steps")
                .limit("roots of ρ² + ηρσ + θσ²; undamped θ < 144/275", |t, e| {
                    adams_bashforth(3, t, e).spectral_radius()
                })
                .order(Some(3)),
        ],
    },
    runs: Runs {
        order: FORMS,
        stability: FORMS,
        momentum: &[
            (Variant::new("adams-bashforth2", "adams-bashforth2"), Keeps::AsStated),
            (Variant::new("adams-bashforth, 3 steps", "adams-bashforth2:steps=3"), Keeps::AsStated),
        ],
        work_precision: &[
            work::main("adams-bashforth2", "adams-bashforth2"),
            work::extra("adams-bashforth, 3 steps", "adams-bashforth2:steps=3"),
        ],
        scaling: &[Contender {
            label: "adams-bashforth2",
            method: "adams-bashforth2",
            largest: 316,
        }],
        ..Runs::DEFAULTS
    },
};

/// `y_{n+1} = y_n + h (3/2 f_n − 1/2 f_{n−1})`.
fn case(problem: &Problem<'_>) -> Expectation {
    let growing = problem.growing(|theta, eta, state| {
        let [x, w, old_w, old_force] = *state;
        let force = -theta * x - eta * w;
        *state = [x + 1.5 * w - 0.5 * old_w, w + 1.5 * force - 0.5 * old_force, w, force];
    });
    match growing {
        Some(theta) => unstable(format!(
            "its region of stability leaves out h²λ = {}, whatever the damping",
            short(theta)
        )),
        None if problem.is_damped() => no_theorem("stable for small steps with damping"),
        None => no_theorem("unstable on the imaginary axis, but too slowly to be seen for certain"),
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Adams and Bashforth: order 2 from the last step",
    idea: "The method keeps the force of the step before. A straight line through both forces, \
           extrapolated over the step, gives order 2 without another evaluation. For pure damping \
           its limit is half that of explicit Euler. Without damping an oscillation grows at every \
           step size, though slowly.",
    docs: "drape-multistep",
    sources: drape_multistep::SOURCES,
    equation: Excerpt::docs(
        "y_{n+k} = y_{n+k−1} + h Σ_{j<k} β_j f_{n+j}                explicit Adams",
        "explicit Adams",
    ),
    code: Excerpt::of(
        "src/step/adams_bashforth.rs",
        "let formula = LinearMultistep::adams_bashforth(&steps[..k]);",
        "history.mean(ACCELERATION, a, beta, mean);",
    ),
    law: Law::TwoSteps {
        first: explicit_euler,
        later: |t, e| adams_bashforth(2, t, e),
        substeps: 1,
    },
    load: None,
    setting: Setting::oscillator(&["adams-bashforth2", "explicit-euler"])
        .spring(100.0, 10.0)
        .time(0.05, 20.0),
    question: Question::LongestStep,
    attempt: "Set the damping to 0 and let it run for a minute at a short step: the energy creeps \
              up.",
    low: "At this step the total energy still falls. Take a longer one.",
    high: "At this step the oscillation grows. Take a shorter one.",
    traps: &[
        Trap {
            value: |s| s.damping / s.stiffness,
            hint: "That is δ/κ, the limit of explicit Euler. The second level changes it.",
        },
        Trap {
            value: |s| 2.0 / libm::sqrt(s.stiffness),
            hint: "That is 2/ω, the limit of leapfrog without damping.",
        },
    ],
    study: "stability",
};
