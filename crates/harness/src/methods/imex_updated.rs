//! IMEX Euler with updated conjugate gradients.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap, gravity};
use crate::need::Matrix;
use crate::presets::Preset;
use crate::theory::{
    ALWAYS, Expectation, LoadLaw, PUSHING, Problem, Theory, beside_explicit, form, implicit,
    no_theorem, stable,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, spectral_radius};
use drape_report::family::Kin;

/// Algorithm 1 as printed, which starts from the velocity of the last step and ends after so many
/// updates of the right-hand side.
macro_rules! passes {
    ($number:literal) => {
        concat!(
            "imex-updated:safeguard=paper,norm=euclid,start=last,forcing_term=1e-8,max_outer=",
            $number
        )
    };
}

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_imex::UPDATED,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::ImplicitExplicit,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[
            form("imex-updated")
                .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e)))
                .spin(|theta, _, after| spin::backward_euler(theta, 0.0, after)),
            form("imex-updated, as printed")
                .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
        ],
    },
    runs: Runs {
        presets: &[Preset {
            name: "paper",
            settings: &[
                ("safeguard", "paper"),
                ("start", "extrapolated"),
                ("norm", "euclid"),
                ("implicit", "tension"),
                ("split", "paper"),
            ],
            help: "Algorithm 1 as Eberhardt, Etzmuß and Hauth print it; it may gain energy",
        }],
        order: &[
            Variant::new("imex-updated", "imex-updated:forcing_term=1e-9"),
            Variant::new(
                "imex-updated, as printed",
                "imex-updated:forcing_term=1e-9,safeguard=paper,norm=euclid",
            ),
        ],
        energy: &[
            Variant::new("imex-updated", "imex-updated"),
            Variant::new("imex-updated, as printed", "imex-updated:safeguard=paper,norm=euclid"),
        ],
        momentum: &[
            (Variant::new("imex-updated", "imex-updated:forcing_term=1e-9"), Keeps::AsStated),
            (Variant::new("imex-updated, ε = 0.01", "imex-updated"), Keeps::Otherwise),
            (
                Variant::new(
                    "imex-updated, as printed, ε = 0.01",
                    "imex-updated:safeguard=paper,norm=euclid",
                ),
                Keeps::Otherwise,
            ),
        ],
        stability: &[
            Variant::new("imex-updated", "imex-updated"),
            Variant::new(
                "imex-updated, as printed",
                "imex-updated:safeguard=paper,norm=euclid,start=extrapolated,forcing_term=0.05",
            ),
        ],
        hard_cases: &[
            Variant::new("imex-updated", "imex-updated"),
            Variant::new(
                "imex-updated (paper)",
                "imex-updated:safeguard=paper,norm=euclid,start=extrapolated",
            ),
        ],
        locking: &[
            (Variant::new("imex-updated", "imex-updated:forcing_term=1e-4"), Steps::All),
            (
                Variant::new(
                    "imex-updated, as printed",
                    "imex-updated:safeguard=paper,norm=euclid,forcing_term=1e-4",
                ),
                Steps::One,
            ),
            (Variant::new("imex-updated, 1 pass", passes!("1")), Steps::All),
            (Variant::new("imex-updated, 2 passes", passes!("2")), Steps::One),
            (Variant::new("imex-updated, 4 passes", passes!("4")), Steps::One),
            (Variant::new("imex-updated, 8 passes", passes!("8")), Steps::All),
        ],
        locked_spring: &[
            (Variant::new("imex-updated, 1 pass", passes!("1")), LoadLaw::Passes(1)),
            (Variant::new("imex-updated, 2 passes", passes!("2")), LoadLaw::Passes(2)),
            (Variant::new("imex-updated, 4 passes", passes!("4")), LoadLaw::Passes(4)),
            (Variant::new("imex-updated, 8 passes", passes!("8")), LoadLaw::Passes(8)),
        ],
        work_precision: &[
            work::headline("imex-updated", "imex-updated"),
            work::extra("imex-updated, ε = 1e-6", "imex-updated:forcing_term=1e-6"),
            work::extra("imex-updated, as printed", "imex-updated:safeguard=paper,norm=euclid"),
            work::adaptive("imex-updated, adaptive", "imex-updated"),
        ],
        scaling: &[Contender { label: "imex-updated", method: "imex-updated", largest: 316 }],
        are_effects_timed: true,
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    let settings = problem.choice.settings();
    let implicit = implicit(problem);
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if settings.word("safeguard") == "paper" {
        no_theorem(
            "an extrapolated start that passes a loose test is no step downhill: energy may come \
             in",
        )
    } else if problem.are_all(implicit) {
        stable(
            "every pass lowers the incremental potential of backward Euler, and a step that gains \
             energy is solved \
             again",
        )
    } else {
        beside_explicit(problem, implicit)
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Updated conjugate gradients: the lock opens",
    idea: "While conjugate gradients run, the method updates the part of the force that plain IMEX \
           Euler leaves at the old positions. The matrix stays constant, but the iteration \
           converges to backward Euler. A motion across a stiff spring is then free, as it should \
           be.",
    docs: "drape-imex",
    sources: drape_imex::SOURCES,
    equation: Excerpt::docs(
        "repeat  b = M v_n + h [F_frozen − L_k x_n + F2(x_n + h v)]",
        "until   an update of b needs no CG iteration",
    ),
    code: Excerpt::of(
        "src/step/robust.rs",
        "rhs.update(system, state, h, v, linear.slopes()); // b(v), (U1)",
        "let solve = linear.solve_to(constraints, &rhs.b, v, goal * lightest); // A v = b, (U2)",
    ),
    law: Law::OneStep(backward_euler),
    load: Some(LoadLaw::Free),
    setting: Setting::load(&["imex-updated", "imex-euler"]),
    question: Question::Speed,
    attempt: "Compare the CG iterations a step in both panes: these are the cost. Then open \
              hanging-textile-1e6.",
    low: "It is faster than that: the updates let the load accelerate the particle.",
    high: "It cannot be faster than in free fall.",
    traps: &[
        Trap {
            value: |s| 1e3 * gravity(s.scene) / (s.step * s.stiffness),
            hint: "That is the speed of the locked particle, the second pane.",
        },
        Trap {
            value: |s| 1e3 * gravity(s.scene) * s.step,
            hint: "That is the change of speed of a single step. The changes add up.",
        },
    ],
    study: "locking",
};
