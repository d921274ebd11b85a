//! IMEX methods of two steps.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, Factors, Linear, PUSHING, Problem, TURNING, Theory, form, implicit,
    no_theorem, stable, unstable,
};
use drape_oracle::recurrence::{Multistep, backward_euler};
use drape_report::family::Kin;

/// `imex-sbdf2`.
pub(super) static SBDF2: Entry = Entry {
    registration: &drape_imex::SBDF2,
    lesson: Some(&SBDF2_LESSON),
    theory: Theory {
        case: sbdf2,
        kin: Kin::TwoSteps,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[form("imex-sbdf2").limit(ALWAYS, |t, e| radius(&Multistep::sbdf2(1.0), t, e))],
    },
    runs: Runs {
        order: &[Variant::new("imex-sbdf2", "imex-sbdf2:forcing_term=1e-12")],
        momentum: &[(Variant::new("imex-sbdf2", "imex-sbdf2:forcing_term=1e-12"), Keeps::AsStated)],
        locking: &[(Variant::new("imex-sbdf2", "imex-sbdf2:forcing_term=1e-8"), Steps::All)],
        work_precision: &[
            work::main("imex-sbdf2", "imex-sbdf2"),
            work::extra("imex-sbdf2, Cholesky", "imex-sbdf2:solver=cholesky"),
            work::adaptive("imex-sbdf2, adaptive", "imex-sbdf2"),
        ],
        scaling: &[Contender { label: "imex-sbdf2", method: "imex-sbdf2", largest: 100 }],
        ..Runs::DEFAULTS
    },
};

/// `a` = (3/2, −2, 1/2), `b` = (1, 0, 0), `c` = (2, −1).
fn sbdf2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(4.0, 1.0, -3.0))
}

/// `imex-cnab2`.
pub(super) static CNAB2: Entry = Entry {
    registration: &drape_imex::CNAB2,
    lesson: Some(&CNAB2_LESSON),
    theory: Theory {
        case: cnab2,
        kin: Kin::TwoSteps,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[form("imex-cnab2").limit(ALWAYS, |t, e| radius(&Multistep::cnab2(1.0), t, e))],
    },
    runs: Runs {
        order: &[Variant::new("imex-cnab2", "imex-cnab2:forcing_term=1e-12")],
        momentum: &[(Variant::new("imex-cnab2", "imex-cnab2:forcing_term=1e-12"), Keeps::AsStated)],
        locking: &[(Variant::new("imex-cnab2", "imex-cnab2:forcing_term=1e-8"), Steps::All)],
        scaling: &[Contender { label: "imex-cnab2", method: "imex-cnab2", largest: 100 }],
        ..Runs::DEFAULTS
    },
};

/// `a` = (1, −1, 0), `b` = (1/2, 1/2, 0), `c` = (3/2, −1/2).
fn cnab2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(2.0, 0.0, -2.0))
}

/// `imex-mcnab2`.
pub(super) static MCNAB2: Entry = Entry {
    registration: &drape_imex::MCNAB2,
    lesson: Some(&MCNAB2_LESSON),
    theory: Theory {
        case: mcnab2,
        kin: Kin::TwoSteps,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[form("imex-mcnab2").limit(ALWAYS, |t, e| radius(&Multistep::mcnab2(1.0), t, e))],
    },
    runs: Runs {
        order: &[Variant::new("imex-mcnab2", "imex-mcnab2:forcing_term=1e-12")],
        momentum: &[(
            Variant::new("imex-mcnab2", "imex-mcnab2:forcing_term=1e-12"),
            Keeps::AsStated,
        )],
        locking: &[(Variant::new("imex-mcnab2", "imex-mcnab2:forcing_term=1e-8"), Steps::All)],
        scaling: &[Contender { label: "imex-mcnab2", method: "imex-mcnab2", largest: 100 }],
        ..Runs::DEFAULTS
    },
};

/// `a` = (1, −1, 0), `b` = (9/16, 3/8, 1/16), `c` = (3/2, −1/2).
fn mcnab2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(2.0, 0.25, -2.0))
}

/// `imex-cnlf`.
pub(super) static CNLF: Entry = Entry {
    registration: &drape_imex::CNLF,
    lesson: Some(&CNLF_LESSON),
    theory: Theory {
        case: cnlf,
        kin: Kin::TwoSteps,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[form("imex-cnlf").limit(ALWAYS, |t, e| radius(&Multistep::cnlf(), t, e))],
    },
    runs: Runs {
        order: &[Variant::new("imex-cnlf", "imex-cnlf:forcing_term=1e-12")],
        momentum: &[(Variant::new("imex-cnlf", "imex-cnlf:forcing_term=1e-12"), Keeps::AsStated)],
        locking: &[(Variant::new("imex-cnlf", "imex-cnlf:forcing_term=1e-8"), Steps::All)],
        scaling: &[Contender { label: "imex-cnlf", method: "imex-cnlf", largest: 100 }],
        ..Runs::DEFAULTS
    },
};

/// `a` = (1/2, 0, −1/2), `b` = (1/2, 0, 1/2), `c` = (1, 0). About an equilibrium roots may lie on
/// the unit circle.
fn cnlf(problem: &Problem<'_>) -> Expectation {
    two_step(&Problem { is_at_rest: false, ..*problem }, &Factors::two_step(0.0, 1.0, -1.0))
}

fn two_step(problem: &Problem<'_>, factors: &Factors) -> Expectation {
    let implicit = implicit(problem);
    let is_explicit_beside = !problem.are_all(implicit);
    let is_steady = problem.schedule.pattern.is_empty();
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if is_explicit_beside
        && is_steady
        && problem.analyse(Some(implicit), factors) == Linear::Nowhere
    {
        unstable("a root of the characteristic polynomial is below −1 for some mode at the start")
    } else if problem.is_at_rest {
        stable(
            "an equilibrium is a fixed point; small motions about it have θ_E between −θ_I and 0, \
             where no root of \
             the characteristic polynomial is outside the unit circle",
        )
    } else {
        no_theorem(format!(
            "on the linear test equation no root is outside the unit circle for springs that are \
             not compressed; {TURNING}"
        ))
    }
}

fn radius(method: &Multistep, theta: f64, eta: f64) -> f64 {
    method.recurrence(theta, 0.0, eta).spectral_radius()
}

/// Its lesson.
static SBDF2_LESSON: Lesson = Lesson {
    title: "Backward differences, with the rest extrapolated",
    idea: "The method uses two old steps instead of one: differences of second order for the \
           linear part of the springs, extrapolation for the rest. A step costs one solve with a \
           constant matrix, as in IMEX Euler. Slow oscillations keep far more of their energy; \
           fast ones die out.",
    docs: "drape-imex",
    sources: drape_imex::SOURCES,
    equation: Excerpt::docs("b  = −(1/a_0) M (a_1 v_n + a_2 v_{n−1})", "x_{n+1} = X* + τ v_{n+1}"),
    code: Excerpt::of(
        "src/two_step/step.rs",
        "let inertia = v[i] + (v[i] - v_old[i]) * (a2 / a0);",
        "self.b[i] = inertia * m",
    ),
    law: Law::TwoSteps {
        first: backward_euler,
        later: |t, e| Multistep::sbdf2(1.0).recurrence(t, 0.0, e),
        substeps: 1,
    },
    load: None,
    setting: Setting::oscillator(&["imex-sbdf2", "imex-euler"]).time(0.05, 1.0),
    question: Question::EnergyLeft,
    attempt: "Step once and read the energy: the first step is one of backward Euler. How much of \
              the loss does it cause?",
    low: "It keeps more than that.",
    high: "It loses more than that.",
    traps: &[
        Trap {
            value: |s| Law::OneStep(backward_euler).left(s),
            hint: "That is what backward Euler leaves. Look at the first pane.",
        },
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
    ],
    study: "order",
};

/// Its lesson.
static CNAB2_LESSON: Lesson = Lesson {
    title: "Crank and Nicolson with Adams and Bashforth: only the start loses",
    idea: "The method takes half of the linear part of the springs at each level, as in the \
           trapezoidal rule, which keeps the energy of every oscillation, fast or slow. But a \
           two-step method needs a first step, and this is one of backward Euler. The energy that \
           it removes is lost; the energy that it leaves rings for ever.",
    docs: "drape-imex",
    sources: drape_imex::SOURCES,
    equation: Excerpt::docs("b  = −(1/a_0) M (a_1 v_n + a_2 v_{n−1})", "x_{n+1} = X* + τ v_{n+1}"),
    code: Excerpt::of(
        "src/two_step/coefficients.rs",
        "Coefficients { a: [1.0, -1.0, 0.0], b: [0.5, 0.5, 0.0], c: adams_bashforth }",
        "Coefficients",
    ),
    law: Law::TwoSteps {
        first: backward_euler,
        later: |t, e| Multistep::cnab2(1.0).recurrence(t, 0.0, e),
        substeps: 1,
    },
    load: None,
    setting: Setting::oscillator(&["imex-cnab2", "imex-mcnab2"]).time(0.1, 1.0),
    question: Question::EnergyLeft,
    attempt: "Read the energy after one step, two, ten. Then shorten the step: the loss of the \
              start shrinks with h².",
    low: "Only the first step loses energy.",
    high: "The first step is one of backward Euler, which loses energy.",
    traps: &[
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
        Trap {
            value: |s| Law::OneStep(backward_euler).left(s),
            hint: "That is what backward Euler leaves. Look at the first pane.",
        },
        Trap {
            value: |s| {
                10.0 * libm::sqrt(
                    Law::TwoSteps {
                        first: backward_euler,
                        later: |t, e| Multistep::cnab2(1.0).recurrence(t, 0.0, e),
                        substeps: 1,
                    }
                    .left(s),
                )
            },
            hint: "That is the share of the amplitude. The energy goes with its square.",
        },
    ],
    study: "order",
};

/// Its lesson.
static MCNAB2_LESSON: Lesson = Lesson {
    title: "A sixteenth of the oldest level",
    idea: "With Crank and Nicolson's method, stiff oscillations ring. A small weight on the oldest \
           level damps them, and the order stays 2. The method lies between the trapezoidal rule \
           and backward differences.",
    docs: "drape-imex",
    sources: drape_imex::SOURCES,
    equation: Excerpt::docs("b  = −(1/a_0) M (a_1 v_n + a_2 v_{n−1})", "x_{n+1} = X* + τ v_{n+1}"),
    code: Excerpt::of(
        "src/two_step/coefficients.rs",
        "b: [(8.0 + 1.0 / omega) / 16.0, (7.0 - 1.0 / omega) / 16.0, 1.0 / 16.0],",
        "b: [",
    ),
    law: Law::TwoSteps {
        first: backward_euler,
        later: |t, e| Multistep::mcnab2(1.0).recurrence(t, 0.0, e),
        substeps: 1,
    },
    load: None,
    setting: Setting::oscillator(&["imex-mcnab2", "imex-cnab2"]).time(0.1, 1.0),
    question: Question::EnergyLeft,
    attempt: "Multiply k/m by 10000 and play: which pane keeps ringing?",
    low: "It keeps more than that.",
    high: "It loses more than the second pane, which loses only in its first step.",
    traps: &[
        Trap {
            value: |s| 100.0 / (1.0 + s.numbers(s.step).0),
            hint: "That is what the second pane leaves. Here the oldest level damps every step.",
        },
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
        Trap {
            value: |s| Law::OneStep(backward_euler).left(s),
            hint: "That is what backward Euler leaves. Look at the first pane.",
        },
    ],
    study: "order",
};

/// Its lesson.
static CNLF_LESSON: Lesson = Lesson {
    title: "Crank and Nicolson with leapfrog: two motions that do not meet",
    idea: "The method steps from level n−1 over level n to level n+1. Without forces at level n, \
           even and odd levels are independent. The even levels continue from the start; the odd \
           ones continue from the first step, which is one of backward Euler. Neither loses \
           energy, and they drift apart.",
    docs: "drape-imex",
    sources: drape_imex::SOURCES,
    equation: Excerpt::docs("b  = −(1/a_0) M (a_1 v_n + a_2 v_{n−1})", "x_{n+1} = X* + τ v_{n+1}"),
    code: Excerpt::of("src/two_step/coefficients.rs", "Self::Cnlf => Coefficients {", "Self::Cnlf"),
    law: Law::TwoSteps {
        first: backward_euler,
        later: |t, e| Multistep::cnlf().recurrence(t, 0.0, e),
        substeps: 1,
    },
    load: None,
    setting: Setting::oscillator(&["imex-cnlf", "imex-cnab2"]).time(0.2, 1.0),
    question: Question::EnergyLeft,
    attempt: "Press Step several times: the energy jumps between two values. Which steps keep all \
              of it?",
    low: "The odd levels continue from the first step; only that step loses energy.",
    high: "The last step is an odd one. Its energy is that of the first step.",
    traps: &[
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
        Trap {
            value: |s| Law::OneStep(backward_euler).left(s),
            hint: "That is what backward Euler leaves. Look at the first pane.",
        },
    ],
    study: "order",
};
