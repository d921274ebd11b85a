//! Terzopoulos and Fleischer.

use super::Entry;
use super::runs::{Keeps, Runs, Variant};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, Factors, Linear, Problem, Theory, Weights, form, limit, no_theorem,
    unstable,
};
use drape_integrator::Implicit;
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{leapfrog, spectral_radius, terzopoulos_fleischer};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_terzopoulos_fleischer::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Implicit,
        matrix: |_| Matrix::ScalarFactor,
        divides: false,
        is_limited: false,
        forms: &[
            form("terzopoulos-fleischer")
                .limit(ALWAYS, |t, e| spectral_radius(&terzopoulos_fleischer(t, e)))
                .spin(|theta, before, _| spin::terzopoulos_fleischer(theta, 0.0, before)),
            // Weights that are cut off in compression solve another equation, so it claims no
            // order.
            form("terzopoulos-fleischer, clamped")
                .spin(|theta, before, _| spin::terzopoulos_fleischer(theta, 0.0, before.min(1.0)))
                .order(None),
        ],
    },
    runs: Runs {
        order: &[
            Variant::new("terzopoulos-fleischer", "terzopoulos-fleischer"),
            Variant::new("terzopoulos-fleischer, clamped", "terzopoulos-fleischer:clamp=true"),
        ],
        momentum: &[
            (Variant::new("terzopoulos-fleischer", "terzopoulos-fleischer"), Keeps::AsStated),
            (
                Variant::new("terzopoulos-fleischer, clamped", "terzopoulos-fleischer:clamp=true"),
                Keeps::AsStated,
            ),
        ],
        ..Runs::DEFAULTS
    },
};

/// Its force `−k (1 − ℓ/L_n) d_{n+1}` is implicit in the secant stiffness only. Along the spring,
/// `L_n` adds an explicit part, and near the rest length this part is the whole force. The damping
/// is centred.
const SECANT: Factors = Factors {
    implicit: Weights { tangent: -1.0, secant: 2.0, ..Weights::NONE },
    ..Factors::ONE_STEP
};

fn case(problem: &Problem<'_>) -> Expectation {
    match problem.analyse(Some(Implicit::Springs), &SECANT) {
        Linear::Nowhere => unstable(format!(
            "near the rest length the secant stiffness vanishes and the method is leapfrog, here \
             beyond its limit \
             h²λ < 4 at the start ({})",
            limit(problem)
        )),
        _ => no_theorem("the secant stiffness at the old positions is negative in compression"),
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Implicit in name: the secant stiffness",
    idea: "The method writes the force of a spring as a secant stiffness times its vector, and \
           takes only the vector at the new level. Near the rest length the secant stiffness is \
           almost zero. So along the spring the force is as explicit as in leapfrog, with the same \
           limit of the step. Across a stretched spring the step is implicit.",
    docs: "drape-terzopoulos-fleischer",
    sources: drape_terzopoulos_fleischer::SOURCES,
    equation: Excerpt::docs("A v_{n+1} = b          A = M + h² K(x_n) + ½ h C", "(T3)"),
    code: Excerpt::step(
        "// A = M + h² K(x_n) + ½ h C, b =",
        "drift(system, h, &state.v, &mut state.x);",
    ),
    law: Law::OneStep(leapfrog),
    load: None,
    setting: Setting::oscillator(&["terzopoulos-fleischer", "leapfrog"])
        .spring(100.0, 2.0)
        .time(0.1, 20.0),
    question: Question::LongestStep,
    attempt: "Set the damping to 0 and let it run for minutes: the energy creeps up at every step \
              size, because the method uses the old length of the spring.",
    low: "At this step the total energy still falls. Take a longer one.",
    high: "At this step the motion along the spring grows: only the part across it is implicit.",
    traps: &[Trap {
        value: |s| 1.0 / libm::sqrt(s.stiffness),
        hint: "That is 1/ω, half of the limit.",
    }],
    study: "stability",
};
