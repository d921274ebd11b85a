//! Vertex block descent.

use super::Entry;
use super::runs::{Contender, Film, Inside, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, PUSHING, Problem, Theory, form, no_theorem};
use drape_oracle::recurrence::{backward_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_vbd::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Local,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        // A single particle on a spring is one block, which a sweep solves. A law of spin would
        // hold only where the sweeps of two particles converge, so none is stated here.
        forms: &[
            form("vbd").limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
            form("vbd, 100 sweeps"),
            form("vbd, augmented"),
        ],
    },
    runs: Runs {
        order: &[Variant::new("vbd", "vbd:sweeps=200")],
        momentum: &[
            (Variant::new("vbd", "vbd"), Keeps::AsStated),
            (Variant::new("vbd, 100 sweeps", "vbd:sweeps=100"), Keeps::AsStated),
        ],
        locking: &[
            (Variant::new("vbd", "vbd"), Steps::Long),
            (Variant::new("vbd, 100 sweeps", "vbd:sweeps=100"), Steps::Long),
            (Variant::new("vbd, augmented", "vbd:augmented=true"), Steps::One),
        ],
        work_precision: &[
            work::main("vbd", "vbd"),
            work::extra("vbd, 100 sweeps", "vbd:sweeps=100"),
            work::extra("vbd, augmented", "vbd:augmented=true"),
        ],
        animation: &[Film::ladder("vbd", "vbd"), Film::ladder("vbd, 100 sweeps", "vbd:sweeps=100")],
        inside: &[Inside {
            label: "vbd",
            setting: "sweeps",
            rungs: &[(1, 5), (1, 10), (4, 3), (1, 20), (4, 5), (2, 20), (8, 5)],
        }],
        scaling: &[Contender { label: "vbd", method: "vbd", largest: 316 }],
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    no_theorem(
        "backward Euler as far as the sweeps converge: unsolved springs may hold more energy than \
         before",
    )
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Vertex block descent: one particle after the other",
    idea: "Each particle moves to the minimum that its neighbours leave it, in a fixed number of \
           sweeps over all particles. The method has no matrix. A particle on a pinned spring is \
           one block of three unknowns, which one sweep solves: then the step is one of backward \
           Euler. In a stiff cloth a change travels only one spring in half a sweep.",
    docs: "drape-vbd",
    sources: drape_vbd::SOURCES,
    equation: Excerpt::docs(
        "g_i  = m_i (v_i − v̂_i) − h f_i(x) + h (D v)_i",
        "for each i, colour by colour",
    ),
    code: Excerpt::of(
        "src/sweep.rs",
        "// g_i = m (v_i − v̂_i) − h f_i + h (D v)_i, (V2)",
        "Filter::Free => solve(block, &gradient),",
    ),
    law: Law::OneStep(backward_euler),
    load: None,
    setting: Setting::oscillator(&["vbd", "backward-euler"]).time(0.02, 0.5),
    question: Question::EnergyLeft,
    attempt: "Open hanging-textile-1e4 and hanging-textile-1e6 with vbd and backward-euler: where \
              do twenty sweeps stop being enough?",
    low: "It keeps more than that.",
    high: "It loses more than that: both panes agree to the last digit.",
    traps: &[
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
        Trap {
            value: |s| 10.0 * libm::sqrt(Law::OneStep(backward_euler).left(s)),
            hint: "That is the share of the amplitude. The energy goes with its square.",
        },
    ],
    study: "locking",
};
