//! Additive Runge–Kutta.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, PUSHING, Problem, TURNING, Theory, form, implicit, no_theorem, stable,
};
use drape_imex_rk::{ARK3, ARK4, ARS222, ARS443, Tableau};
use drape_oracle::recurrence::{
    AdditiveTableau, Amplification, additive_runge_kutta, backward_euler, spectral_radius,
};
use drape_report::family::Kin;

/// Its tableaux in studies that compare limits and orders.
const FORMS: &[Variant] = &[
    Variant::new("imex-rk", "imex-rk"),
    Variant::new("imex-rk, ars443", "imex-rk:tableau=ars443"),
    Variant::new("imex-rk, ark3", "imex-rk:tableau=ark3"),
    Variant::new("imex-rk, ark4", "imex-rk:tableau=ark4"),
];

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_imex_rk::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::ImplicitExplicit,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[
            form("imex-rk").limit(ALWAYS, |t, e| radius(&ARS222, t, e)),
            form("imex-rk, ars443").limit(ALWAYS, |t, e| radius(&ARS443, t, e)).order(Some(3)),
            form("imex-rk, ark3").limit(ALWAYS, |t, e| radius(&ARK3, t, e)).order(Some(3)),
            form("imex-rk, ark4").limit(ALWAYS, |t, e| radius(&ARK4, t, e)).order(Some(4)),
        ],
    },
    runs: Runs {
        order: FORMS,
        stability: FORMS,
        energy: FORMS,
        momentum: &[
            (Variant::new("imex-rk", "imex-rk"), Keeps::AsStated),
            (Variant::new("imex-rk, ark3", "imex-rk:tableau=ark3"), Keeps::AsStated),
            (Variant::new("imex-rk, ark4", "imex-rk:tableau=ark4"), Keeps::AsStated),
        ],
        locking: &[
            (Variant::new("imex-rk", "imex-rk"), Steps::All),
            (Variant::new("imex-rk, ark3", "imex-rk:tableau=ark3"), Steps::All),
            (Variant::new("imex-rk, ark4", "imex-rk:tableau=ark4"), Steps::All),
        ],
        work_precision: &[
            work::main("imex-rk", "imex-rk"),
            work::extra("imex-rk, ars443", "imex-rk:tableau=ars443"),
            work::main("imex-rk, ark3", "imex-rk:tableau=ark3"),
            work::main("imex-rk, ark4", "imex-rk:tableau=ark4"),
        ],
        scaling: &[Contender { label: "imex-rk", method: "imex-rk", largest: 100 }],
        ..Runs::DEFAULTS
    },
};

/// The spectral radius of a step where all stiffness is implicit.
fn radius(tableau: &Tableau, theta: f64, eta: f64) -> f64 {
    spectral_radius(&matrix(tableau, theta, eta))
}

fn matrix(tableau: &Tableau, theta: f64, eta: f64) -> Amplification {
    let &Tableau { explicit, implicit, explicit_weights, implicit_weights, .. } = tableau;
    let pair = AdditiveTableau { explicit, implicit, explicit_weights, implicit_weights };
    additive_runge_kutta(&pair, theta, 0.0, eta)
}

/// Let the explicit stiffness be `θ_E = r θ_I`. From `r = −1` on, only `ars222` and `ark3` are
/// stable for every `θ_I`. About an equilibrium of stretched springs, `−1 ≤ r ≤ 0`.
fn case(problem: &Problem<'_>) -> Expectation {
    let takes_turns = matches!(problem.choice.settings().word("tableau"), "ars222" | "ark3");
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if problem.is_at_rest && takes_turns && problem.are_all(implicit(problem)) {
        stable(
            "an equilibrium is a fixed point; small motions about it have θ_E between −θ_I and 0, \
             where the factors \
             of a step are not outside the unit circle",
        )
    } else {
        no_theorem(format!(
            "the implicit part is L-stable, but nothing bounds the energy of the split; {TURNING}"
        ))
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Order 2 without a past",
    idea: "A step has two stages, which solve with the same constant matrix. Each stage evaluates \
           the rest of the force anew. The order is 2 without old levels, so steps, pins and \
           contacts may change at any time. Motion that the step does not resolve dies out.",
    docs: "drape-imex-rk",
    sources: drape_imex_rk::SOURCES,
    equation: Excerpt::docs(
        "X* = x_n + h Σ_{j<i} a^I_ij v_j      V* = v_n + h Σ_{j<i} (a^I_ij g_j + a^E_ij e_j)",
        "(5)",
    ),
    code: Excerpt::step(
        "self.write_right_hand_side(system, implicit, tau);",
        "drift(system, tau, &self.velocity, &mut self.position);",
    ),
    law: Law::OneStep(|t, e| matrix(&ARS222, t, e)),
    load: None,
    setting: Setting::oscillator(&["imex-rk", "imex-sbdf2"]).time(0.2, 1.0),
    question: Question::EnergyLeft,
    attempt: "Compare with imex-sbdf2 at a step twice as short, which costs as many solves.",
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
