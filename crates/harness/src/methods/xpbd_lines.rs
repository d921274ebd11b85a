//! XPBD by lines.

use super::Entry;
use super::runs::work::Knob;
use super::runs::{Contender, Film, Inside, Keeps, Runs, Variant, work};
use super::xpbd::RUNGS;
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, PUSHING, Problem, Theory, form, no_theorem, stable};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{
    factored_backward_euler, factored_bdf2, factored_start, spectral_radius, xpbd,
};
use drape_report::family::Kin;

/// Substeps in a default step.
const SUBSTEPS: i32 = 20;
/// Substeps of a step of given size, coarsest first.
const DIVISIONS: &[f64] = &[1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0];

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_xpbd_lines::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Local,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        // A sweep solves one spring, apart from its damping. It does not solve families of lines
        // together, and these may gain energy.
        forms: &[
            form("xpbd-lines").limit(ALWAYS, |t, e| {
                let n = f64::from(SUBSTEPS);
                factored_bdf2(1.0, t / (n * n), e / n).spectral_radius().powi(SUBSTEPS)
            }),
            form("xpbd-lines, one substep")
                .limit(ALWAYS, |t, e| factored_bdf2(1.0, t, e).spectral_radius()),
            form("xpbd-lines, order 1, one substep")
                .limit(ALWAYS, |t, e| spectral_radius(&factored_backward_euler(t, e)))
                .spin(|theta, _, after| spin::backward_euler(theta, 0.0, after))
                .order(Some(1)),
        ],
    },
    runs: Runs {
        order: &[Variant::new("xpbd-lines", "xpbd-lines")],
        energy: &[Variant::new("xpbd-lines", "xpbd-lines")],
        momentum: &[
            (Variant::new("xpbd-lines", "xpbd-lines"), Keeps::AsStated),
            (
                Variant::new("xpbd-lines, order 1, one substep", "xpbd-lines:order=1,substeps=1"),
                Keeps::AsStated,
            ),
        ],
        stability: &[
            Variant::new("xpbd-lines", "xpbd-lines"),
            Variant::new("xpbd-lines, one substep", "xpbd-lines:substeps=1"),
        ],
        work_precision: &[
            work::headline("xpbd-lines", "xpbd-lines"),
            work::extra("xpbd-lines, more substeps", "xpbd-lines")
                .knob(Knob::Setting("substeps", DIVISIONS)),
        ],
        animation: &[Film::ladder("xpbd-lines", "xpbd-lines")],
        inside: &[Inside { label: "xpbd-lines", setting: "substeps", rungs: RUNGS }],
        scaling: &[Contender { label: "xpbd-lines", method: "xpbd-lines", largest: 316 }],
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
    title: "Whole lines of the weave at once",
    idea: "The springs of a line form a chain, and the equations of a chain are tridiagonal. \
           Elimination solves them at once, so a pull crosses the sheet in a single sweep. Because \
           a sweep is this accurate, the substeps can use two-step differences, which hardly damp.",
    docs: "drape-xpbd-lines",
    sources: drape_xpbd_lines::SOURCES,
    equation: Excerpt::docs("x* = ((1+ω)² x_n − ω² x_{n−1})/(1+2ω),   v* likewise,", "(L2)"),
    code: Excerpt::step(
        "let substep = particles.predict(system, state, h, end);",
        "particles.finish(system, state, substep);",
    ),
    law: Law::TwoSteps {
        first: factored_start,
        later: |t, e| factored_bdf2(1.0, t, e),
        substeps: SUBSTEPS as u32,
    },
    load: None,
    setting: Setting::oscillator(&["xpbd-lines", "xpbd"]).time(1.0, 5.0),
    question: Question::EnergyLeft,
    attempt: "Set order=1 in the first pane: now both panes lose the same. Then open \
              hanging-textile-1e6 with both.",
    low: "It keeps more than that.",
    high: "It loses more than that.",
    traps: &[
        Trap {
            value: |s| Law::OneStep(|t, e| xpbd(t, e, SUBSTEPS as u32)).left(s),
            hint: "That is what the second pane leaves, with substeps of order 1.",
        },
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
    ],
    study: "energy",
};
