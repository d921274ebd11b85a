//! XPBD.

use super::Entry;
use super::runs::work::Knob;
use super::runs::{Contender, Film, Inside, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, LoadLaw, PUSHING, Problem, Theory, form, no_theorem, stable,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, bdf, spectral_radius, xpbd};
use drape_report::family::Kin;

/// Substeps in a default step.
const SUBSTEPS: u32 = 20;
/// Substeps of a step of given size, coarsest first.
const DIVISIONS: &[f64] = &[1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 300.0, 1000.0];
/// Calls a frame with their substeps. As many substeps in fewer calls cost the same.
pub(super) const RUNGS: &[(u32, u32)] =
    &[(1, 4), (1, 6), (1, 8), (1, 10), (1, 15), (1, 20), (2, 20), (4, 20)];

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_xpbd::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Local,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        // A sweep solves one spring exactly. It does not solve a net, which may gain energy.
        forms: &[
            form("xpbd").limit(ALWAYS, |t, e| spectral_radius(&xpbd(t, e, SUBSTEPS))),
            form("xpbd, one substep")
                .limit(ALWAYS, |t, e| spectral_radius(&xpbd(t, e, 1)))
                .spin(|theta, _, after| spin::backward_euler(theta, 0.0, after)),
            form("xpbd, order 2, one substep")
                .limit(ALWAYS, |t, e| bdf(2, t, e).spectral_radius())
                .order(Some(2)),
            form("xpbd, order 2").order(Some(2)),
        ],
    },
    runs: Runs {
        order: &[
            Variant::new("xpbd", "xpbd"),
            Variant::new("xpbd, order 2", "xpbd:order=2,iterations=2"),
        ],
        energy: &[Variant::new("xpbd", "xpbd"), Variant::new("xpbd, order 2", "xpbd:order=2")],
        momentum: &[
            (Variant::new("xpbd", "xpbd"), Keeps::AsStated),
            (Variant::new("xpbd, one substep", "xpbd:substeps=1"), Keeps::AsStated),
        ],
        stability: &[
            Variant::new("xpbd", "xpbd"),
            Variant::new("xpbd, one substep", "xpbd:substeps=1"),
            Variant::new("xpbd, order 2, one substep", "xpbd:substeps=1,order=2"),
        ],
        locking: &[(Variant::new("xpbd", "xpbd"), Steps::All)],
        locked_spring: &[(Variant::new("xpbd, one substep", "xpbd:substeps=1"), LoadLaw::Free)],
        work_precision: &[
            work::headline("xpbd", "xpbd"),
            work::extra("xpbd, more substeps", "xpbd").knob(Knob::Setting("substeps", DIVISIONS)),
            work::extra("xpbd, order 2", "xpbd:order=2"),
        ],
        scaling: &[Contender { label: "xpbd", method: "xpbd", largest: 316 }],
        are_effects_timed: true,
        animation: &[Film::ladder("xpbd", "xpbd"), Film::ladder("xpbd, order 2", "xpbd:order=2")],
        inside: &[
            Inside { label: "xpbd", setting: "substeps", rungs: RUNGS },
            Inside { label: "xpbd, order 2", setting: "substeps", rungs: RUNGS },
        ],
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    if problem.is_at_rest && problem.system().effects().all(|effect| effect.name() != "gravity") {
        return stable("the springs are at their rest lengths: no sweep moves anything");
    }
    no_theorem("a sweep that ends before the solution may set energy free")
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "XPBD: many small substeps instead of many iterations",
    idea: "A spring is a constraint with a compliance. The step is divided into twenty substeps, \
           and each of them corrects every spring once. On one spring a correction is a substep of \
           backward Euler. So the method damps like backward Euler with the substep: twenty times \
           as many steps, each with a four-hundredth of θ.",
    docs: "drape-xpbd",
    sources: drape_xpbd::SOURCES,
    equation: Excerpt::docs(
        "Δλ = −(C + α̃ λ + γ u·(q_i − q_j)) / ((1 + γ)(w_i + w_j) + α̃)",
        "q_i += w_i Δλ u",
    ),
    code: Excerpt::step(
        "let substep = particles.predict(system, state, h, end);",
        "particles.finish(system, state, substep);",
    ),
    law: Law::OneStep(|t, e| xpbd(t, e, SUBSTEPS)),
    load: None,
    setting: Setting::oscillator(&["xpbd", "backward-euler"]).time(0.1, 1.0),
    question: Question::EnergyLeft,
    attempt: "Compare substeps=1 and substeps=100. How much does a substep cost, and how much \
              accuracy does it gain?",
    low: "The substeps are short: it keeps more than that.",
    high: "It loses more than that: even short substeps damp.",
    traps: &[
        Trap {
            value: |s| Law::OneStep(backward_euler).left(s),
            hint: "That is what backward Euler leaves. Look at the first pane.",
        },
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
        Trap {
            value: |s| 10.0 * libm::sqrt(Law::OneStep(|t, e| xpbd(t, e, SUBSTEPS)).left(s)),
            hint: "That is the share of the amplitude. The energy goes with its square.",
        },
    ],
    study: "energy",
};
