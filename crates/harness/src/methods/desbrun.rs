//! Desbrun.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap, gravity};
use crate::need::Matrix;
use crate::presets::Preset;
use crate::theory::{
    ALWAYS, Expectation, LoadLaw, PUSHING, Problem, Theory, form, monotone, no_theorem,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, desbrun, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_desbrun::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Corrected,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "inverse", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[
            form("desbrun").limit(ALWAYS, |t, e| spectral_radius(&desbrun(t, e))),
            form("desbrun, no correction").spin(|theta, _, _| spin::imex_euler(theta, 0.0)),
        ],
    },
    runs: Runs {
        presets: &[Preset {
            name: "paper",
            settings: &[("inverse", "dense"), ("torque", "literal"), ("inverse_dynamics", "true")],
            help: "as Desbrun, Schröder and Barr publish it: the full inverse, the torque in their \
               units, and springs shortened after the step",
        }],
        energy: &[
            Variant::new("desbrun, no correction", "desbrun:torque=none"),
            Variant::new("desbrun", "desbrun"),
        ],
        momentum: &[
            (Variant::new("desbrun, no correction", "desbrun:torque=none"), Keeps::Otherwise),
            (Variant::new("desbrun, literal", "desbrun:torque=literal"), Keeps::Otherwise),
            (Variant::new("desbrun, consistent", "desbrun:torque=consistent"), Keeps::AsStated),
        ],
        locking: &[(Variant::new("desbrun", "desbrun"), Steps::All)],
        locked_spring: &[(Variant::new("desbrun", "desbrun"), LoadLaw::Unfiltered)],
        scaling: &[Contender { label: "desbrun", method: "desbrun", largest: 316 }],
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    let has_gravity = problem.system().effects().any(|effect| effect.name() == "gravity");
    let has_pins = problem.system().pinned().contains(&true);
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if has_gravity && has_pins {
        no_theorem(
            "the theorem of IMEX Euler, but for gravity, which passes by the filter while the \
             pins' reaction does not",
        )
    } else if !has_pins && problem.choice.settings().word("torque") != "none" {
        no_theorem(
            "its predictor has the theorem of IMEX Euler, its correction of the torque has none",
        )
    } else {
        monotone("the theorem of IMEX Euler: an exact solve with all springs and full damping")
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Desbrun: a matrix that never changes, and a load beside it",
    idea: "Only the linear part of the spring force is taken at the new positions. Its matrix \
           never changes and is factorised once. The filter W slows every motion of a stiff \
           spring, even a motion across it that does not stretch it. Gravity is added after the \
           filter: each step adds the full h g, but the filter removes the speed of the step \
           before.",
    docs: "drape-desbrun",
    sources: drape_desbrun::SOURCES,
    equation: Excerpt::docs(
        "F̃ = F(x_n) − h L_k v_n − L_c v_n                                                    (D1)",
        "(D5)",
    ),
    code: Excerpt::step(
        "// Δv = A⁻¹ h F̃ = h M⁻¹ F_filtered, (D2)",
        "drift(system, h, &state.v, &mut state.x); // x_{n+1} = x_n + h v_{n+1}, (D5)",
    ),
    law: Law::OneStep(backward_euler),
    load: Some(LoadLaw::Unfiltered),
    setting: Setting::load(&["desbrun", "imex-updated"]),
    question: Question::Speed,
    attempt: "Halve the step: the speed halves as well, though nothing about the cloth has changed.",
    low: "The filter does not act on the load: each step adds the whole of h g.",
    high: "The filter removes the speed of the step before, so speeds cannot add up.",
    traps: &[
        Trap {
            value: |s| 1e3 * gravity(s.scene) / (s.step * s.stiffness),
            hint: "That would be so if the load were filtered, too.",
        },
        Trap {
            value: |s| 1e3 * gravity(s.scene) * s.duration,
            hint: "That is free fall, which the second pane shows.",
        },
    ],
    study: "locking",
};
