//! Projective dynamics and its accelerations.

use super::Entry;
use super::runs::{Contender, Film, Inside, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
use crate::need::Matrix;
use crate::presets::Preset;
use crate::theory::{ALWAYS, Expectation, PUSHING, Problem, Theory, form, no_theorem};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{backward_euler, spectral_radius};
use drape_report::family::Kin;

const CONVERGED: &str = "projective:acceleration=lbfgs,iterations=1000,residual=1e-9";

/// Calls a frame with their iterations, of the accelerated forms.
const ACCELERATED: &[(u32, u32)] = &[(1, 10), (2, 10), (1, 30), (4, 10), (2, 30)];

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_projective::REGISTRATION,
    lesson: Some(&LESSON),
    theory: Theory {
        case,
        kin: Kin::Local,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[
            form("projective").limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
            form("projective, 50 iterations")
                .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
            form("projective, Chebyshev")
                .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
            form("projective, Anderson")
                .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
            form("projective, L-BFGS").limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
            form("projective, ADMM").limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
            form("projective, converged")
                .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e)))
                .spin(|theta, _, after| spin::backward_euler(theta, 0.0, after)),
        ],
    },
    runs: Runs {
        presets: &[
            Preset {
                name: "anderson",
                settings: &[("acceleration", "anderson"), ("iterations", "20")],
                help: "Anderson's acceleration, guarded by the incremental potential (Peng et al. \
                       2018)",
            },
            Preset {
                name: "converged",
                settings: &[
                    ("acceleration", "lbfgs"),
                    ("iterations", "1000"),
                    ("residual", "1e-6"),
                ],
                help: "L-BFGS to a tolerance: backward Euler without a Hessian (Liu et al. 2017)",
            },
        ],
        order: &[Variant::new("projective, converged", CONVERGED)],
        momentum: &[
            (Variant::new("projective, converged", CONVERGED), Keeps::AsStated),
            (Variant::new("projective", "projective"), Keeps::AsStated),
        ],
        locking: &[
            (Variant::new("projective", "projective"), Steps::All),
            (Variant::new("projective, 50 iterations", "projective:iterations=50"), Steps::All),
            (
                Variant::new(
                    "projective, Chebyshev",
                    "projective:acceleration=chebyshev,rho=0.99,iterations=50",
                ),
                Steps::One,
            ),
            (
                Variant::new(
                    "projective, Anderson",
                    "projective:acceleration=anderson,iterations=30",
                ),
                Steps::One,
            ),
            (
                Variant::new("projective, L-BFGS", "projective:acceleration=lbfgs,iterations=30"),
                Steps::One,
            ),
            (Variant::new("projective, ADMM", "projective:acceleration=admm"), Steps::One),
        ],
        work_precision: &[
            work::main("projective", "projective"),
            work::extra(
                "projective, Chebyshev",
                "projective:acceleration=chebyshev,rho=0.99,iterations=50",
            ),
            work::extra("projective, Anderson", "projective:acceleration=anderson,iterations=30"),
            work::extra("projective, L-BFGS", "projective:acceleration=lbfgs,iterations=30"),
        ],
        scaling: &[Contender { label: "projective", method: "projective", largest: 100 }],
        animation: &[
            Film::ladder("projective", "projective"),
            Film::ladder("projective, Anderson", "projective:acceleration=anderson,iterations=30"),
            Film::ladder("projective, L-BFGS", "projective:acceleration=lbfgs,iterations=30"),
        ],
        inside: &[
            Inside {
                label: "projective",
                setting: "iterations",
                rungs: &[
                    (1, 5),
                    (1, 10),
                    (4, 3),
                    (2, 10),
                    (8, 3),
                    (4, 10),
                    (16, 3),
                    (8, 10),
                    (32, 3),
                ],
            },
            Inside { label: "projective, Anderson", setting: "iterations", rungs: ACCELERATED },
            Inside { label: "projective, L-BFGS", setting: "iterations", rungs: ACCELERATED },
        ],
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    no_theorem(
        "each plain or guarded iteration lowers the incremental potential of backward Euler, \
         which bounds no energy \
         while it is above the minimum",
    )
}

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Projective dynamics: local directions, one constant matrix",
    idea: "A step of backward Euler is the minimum of an energy. First each spring finds its best \
           direction alone; then one solve with a constant matrix joins all directions. On a \
           single spring the direction is right at once, so one iteration completes the step. In a \
           stiff cloth, ten iterations are far from convergence.",
    docs: "drape-projective",
    sources: drape_projective::SOURCES,
    equation: Excerpt::docs(
        "Φ(v) = ½‖v − v̂‖²_M + U(x_n + h v) + ½ h vᵀ D v",
        "A    = M + h² L_k + h L_c",
    ),
    code: Excerpt::step(
        "v.copy_from_slice(minimiser.potential.target()); // v⁰ = v̂",
        "minimiser.minimise(settings, system, constraints, v, &mut report);",
    ),
    law: Law::OneStep(backward_euler),
    load: None,
    setting: Setting::oscillator(&["projective", "exponential"]).time(0.005, 1.0),
    question: Question::EnergyLeft,
    attempt: "Open hanging-textile-1e6 with projective beside projective:converged: how far are \
              ten iterations from convergence?",
    low: "It keeps more than that.",
    high: "It damps like backward Euler, whose minimum it searches for.",
    traps: &[
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
        Trap {
            value: |s| 10.0 * libm::sqrt(Law::OneStep(backward_euler).left(s)),
            hint: "That is the share of the amplitude. The energy goes with its square.",
        },
    ],
    study: "locking",
};
