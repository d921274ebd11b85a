//! Rosenbrock.

use super::Entry;
use super::runs::{Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, PUSHING, Problem, TURNING, Theory, at_rest_or, form, no_theorem,
};
use drape_oracle::recurrence::{
    Amplification, RosenbrockTableau, backward_euler, rosenbrock, spectral_radius,
};
use drape_report::family::Kin;
use drape_rosenbrock::{RODAS3, RODAS4, ROS2, ROS3P, ROS34PW2, Tableau};

/// Its forms in studies that compare limits and orders.
const FORMS: &[Variant] = &[
    Variant::new("rosenbrock", "rosenbrock"),
    Variant::new("rosenbrock, ros3p", "rosenbrock:tableau=ros3p"),
    Variant::new("rosenbrock, rodas3", "rosenbrock:tableau=rodas3"),
    Variant::new("rosenbrock, ros34pw2", "rosenbrock:tableau=ros34pw2"),
    Variant::new("rosenbrock, rodas4", "rosenbrock:tableau=rodas4"),
    Variant::new("rosenbrock, ros34pw2, clamped", "rosenbrock:tableau=ros34pw2,jacobian=clamped"),
];

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_rosenbrock::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Linearised,
        matrix: |_| Matrix::BlockFactor,
        divides: false,
        is_limited: false,
        forms: &[
            form("rosenbrock").limit(ALWAYS, |t, e| radius(&ROS2, t, e)),
            form("rosenbrock, ros3p").limit(ALWAYS, |t, e| radius(&ROS3P, t, e)).order(Some(3)),
            form("rosenbrock, rodas3").limit(ALWAYS, |t, e| radius(&RODAS3, t, e)).order(Some(3)),
            form("rosenbrock, ros34pw2")
                .limit(ALWAYS, |t, e| radius(&ROS34PW2, t, e))
                .order(Some(3)),
            form("rosenbrock, rodas4").limit(ALWAYS, |t, e| radius(&RODAS4, t, e)).order(Some(4)),
            // Springs of rest length 0 are never compressed, so the Jacobian is the same.
            form("rosenbrock, ros34pw2, clamped")
                .limit(ALWAYS, |t, e| radius(&ROS34PW2, t, e))
                .order(Some(3)),
        ],
    },
    runs: Runs {
        order: FORMS,
        stability: FORMS,
        momentum: &[
            (Variant::new("rosenbrock", "rosenbrock"), Keeps::AsStated),
            (Variant::new("rosenbrock, rodas4", "rosenbrock:tableau=rodas4"), Keeps::AsStated),
        ],
        locking: &[(Variant::new("rosenbrock", "rosenbrock"), Steps::Long)],
        work_precision: &[
            work::main("rosenbrock", "rosenbrock"),
            work::extra("rosenbrock, ros3p", "rosenbrock:tableau=ros3p"),
            work::extra("rosenbrock, rodas3", "rosenbrock:tableau=rodas3"),
            work::extra(
                "rosenbrock, ros34pw2, clamped",
                "rosenbrock:tableau=ros34pw2,jacobian=clamped",
            ),
            work::main("rosenbrock, rodas4", "rosenbrock:tableau=rodas4"),
        ],
        ..Runs::DEFAULTS
    },
};

fn matrix(tableau: &Tableau, theta: f64, eta: f64) -> Amplification {
    let (alpha, gamma, weights) = tableau.definition();
    let definition = RosenbrockTableau { alpha, gamma, weights };
    rosenbrock(&definition, (theta, eta), (theta, eta))
}

fn radius(tableau: &Tableau, theta: f64, eta: f64) -> f64 {
    spectral_radius(&matrix(tableau, theta, eta))
}

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if problem.choice.settings().word("jacobian") == "exact" {
        at_rest_or(
            problem,
            "one linearisation a step: A-stable where the Jacobian is constant, and a spring that \
             turns stretches",
        )
    } else {
        no_theorem(format!(
            "the matrix is not the Jacobian where springs are compressed; {TURNING}"
        ))
    }
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Order 2 without iterations",
    idea: "The Jacobian is a part of the formula of the stages, so the method needs no iteration. \
           Two linear solves with one matrix give order 2, and motion that the step cannot resolve \
           dies out. On linear springs the method equals a diagonally implicit method of two \
           stages.",
    docs: "drape-rosenbrock",
    sources: drape_rosenbrock::SOURCES,
    equation: Excerpt::docs(
        "k_i = h F(y_n + Σ_{j<i} α_ij k_j) + h J Σ_{j≤i} γ_ij k_j",
        "y_{n+1} = y_n + Σ_i b_i k_i",
    ),
    code: Excerpt::step(
        "// b = τ [f(x, v) + (1/h) M Σ c_ij u^v_j − τ K_n r_x]",
        "*u = (velocity + drift) * tau;",
    ),
    law: Law::OneStep(|t, e| matrix(&ROS2, t, e)),
    load: None,
    setting: Setting::oscillator(&["rosenbrock", "baraff-witkin"]).time(0.1, 4.0),
    question: Question::EnergyLeft,
    attempt: "Take tableau=rodas4: order 4, four linear solves more. How much is left now?",
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
