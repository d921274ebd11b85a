//! Leapfrog.

use super::Entry;
use super::runs::{
    Contender, Film, Runs, Steps, Variant,
    work::{self, Knob},
};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{
    Expectation, Factors, PUSHING, Problem, Theory, Weights, explicit, form, no_theorem, stable,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{leapfrog, leapfrog_explicit_damping, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_explicit_euler::VERLET,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Explicit,
        // The matrix of implicit damping, where the system has damping.
        matrix: |settings| match settings.word("damping") {
            "explicit" => Matrix::None,
            _ => Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        },
        divides: true,
        is_limited: true,
        forms: &[
            form("leapfrog")
                .limit("θ < 4", |t, e| spectral_radius(&leapfrog(t, e)))
                .spin(|_, _, _| spin::leapfrog(0.0)),
            form("leapfrog, explicit damping").limit("θ < 4 and η < 4", |t, e| {
                spectral_radius(&leapfrog_explicit_damping(t, e))
            }),
        ],
    },
    runs: Runs {
        stability: &[
            Variant::new("leapfrog", "leapfrog"),
            Variant::new("leapfrog, explicit damping", "leapfrog:damping=explicit"),
        ],
        energy: &[Variant::new("leapfrog", "leapfrog:solver=cg")],
        hard_cases: &[
            Variant::new("leapfrog", "leapfrog"),
            Variant::new("leapfrog (auto)", "leapfrog:step=auto"),
            Variant::new("leapfrog (bound)", "leapfrog:step=bound"),
        ],
        work_precision: &[
            work::headline("leapfrog", "leapfrog:step=bound")
                .knob(Knob::Setting("safety", SAFETIES)),
            work::main("leapfrog, explicit damping", "leapfrog:step=bound,damping=explicit")
                .knob(Knob::Setting("safety", SAFETIES)),
            work::extra("leapfrog, CG", "leapfrog:step=bound,solver=cg")
                .knob(Knob::Setting("safety", SAFETIES)),
            work::extra("leapfrog, fixed steps", "leapfrog"),
        ],
        locking: &[
            (Variant::new("leapfrog", "leapfrog"), Steps::One),
            (Variant::new("leapfrog (auto)", "leapfrog:step=auto"), Steps::One),
        ],
        scaling: &[Contender { label: "leapfrog", method: "leapfrog:solver=cg", largest: 1000 }],
        animation: &[
            Film::limit("leapfrog", "leapfrog"),
            Film::limit("leapfrog, explicit damping", "leapfrog:damping=explicit"),
        ],
        ..Runs::DEFAULTS
    },
};

/// Length of a substep over the stability limit.
const SAFETIES: &[f64] = &[0.95, 0.5, 0.25, 0.125, 0.0625];

/// Half of the damping is taken at either velocity, so it cancels at `ζ = −1`.
const FACTORS: Factors = Factors {
    explicit: Weights { damping: 0.0, ..Factors::ONE_STEP.explicit },
    ..Factors::ONE_STEP
};

fn case(problem: &Problem<'_>) -> Expectation {
    let settings = problem.choice.settings();
    let is_explicit = settings.word("damping") == "explicit" && problem.is_damped();
    match settings.word("step") {
        "auto" => no_theorem(
            "substeps within the limit by an estimate of the largest eigenvalue, which follows \
             the cloth with a delay",
        ),
        "bound" if problem.has_contacts() => no_theorem(PUSHING),
        "bound" => stable("substeps within the limit h²λ < 4 at every state"),
        _ if is_explicit => no_theorem("stable if h²λ < 4 and hδ < 4"),
        _ => explicit(problem, "h²λ < 4", &FACTORS),
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Leapfrog: order 2 for one force a step",
    idea: "A step consists of half a kick, a drift and half a kick. It is the same forwards and \
           backwards in time. This gives order 2 and an energy that stays close to the true one \
           for any length of time. Once the step is too long for the fastest oscillation, the \
           method breaks down at once.",
    docs: "drape-explicit-euler",
    sources: drape_explicit_euler::SOURCES,
    equation: Excerpt::docs(
        "v½      = v_n + h/2 M⁻¹ (F(x_n) − D(x_n) v_n)",
        "R(x, v) = L_c v − D(x) v",
    ),
    code: Excerpt::of(
        "src/step/leapfrog.rs",
        "self.kept.begin(system, &state.x, &mut report); // F(x_n)",
        "self.kept.evaluate(system, &state.x, &mut report); // F(x_{n+1})",
    ),
    law: Law::OneStep(leapfrog),
    load: None,
    setting: Setting::oscillator(&["leapfrog", "explicit-euler"]).time(0.1, 20.0),
    question: Question::LongestStep,
    attempt: "Add as much damping as you like: the limit does not change. Then multiply k/m by \
              100: how much shorter must the step be?",
    low: "At this step the energy oscillates but does not grow. Take a longer one.",
    high: "At this step the energy explodes within a few steps. Take a shorter one.",
    traps: &[
        Trap {
            value: |s| std::f64::consts::TAU / libm::sqrt(s.stiffness),
            hint: "That is the period 2π/ω. A step must be shorter than a third of it.",
        },
        Trap { value: |s| 1.0 / libm::sqrt(s.stiffness), hint: "That is 1/ω, half of the limit." },
    ],
    study: "stability",
};
