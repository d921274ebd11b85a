//! The lessons, in the order in which the methods build on each other, and their texts.

use super::facts::{Lesson, MOVES, Run, Scene};
use crate::studies::short;
use drape_report::Verdict;

/// A lesson about one method, before the method is measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Method id with the settings that are not at their defaults.
    pub(super) method: &'static str,
    /// The crate whose documentation explains the method.
    pub(super) docs: &'static str,
    /// The idea of the method, and what is new in it.
    pub(super) idea: &'static str,
}

impl Plan {
    /// Method id.
    pub(super) fn id(&self) -> &'static str {
        self.method.split(':').next().unwrap_or(self.method)
    }
}

pub(super) const LESSONS: [Plan; 24] = [
    Plan {
        method: "explicit-euler",
        docs: "drape-explicit-euler",
        idea: "Positions move with the old velocities, and velocities with the forces at the old \
               positions. The method solves no equations: a step is one evaluation of the forces.",
    },
    Plan {
        method: "leapfrog:step=bound,safety=0.95,solver=cg",
        docs: "drape-explicit-euler",
        idea: "Velocities and positions take turns, half a step apart. A step costs no more than \
               one of explicit Euler and is of second order. It is divided into equal parts below \
               2/ω, the limit that the stiffest mode of the sheet sets. Damping is taken at the \
               new velocity; a few iterations of conjugate gradients solve for it to round-off.",
    },
    Plan {
        method: "provot",
        docs: "drape-provot",
        idea: "The method takes the full step, even beyond the limit. After the step it shortens \
               each spring that is longer than 1.1 times its rest length, by moving its ends.",
    },
    Plan {
        method: "backward-euler:solver=cholesky",
        docs: "drape-backward-euler",
        idea: "The forces are those at the end of the step. This gives a nonlinear system in the \
               new velocities. Newton's method solves it; every iteration sets up and factorises a \
               matrix.",
    },
    Plan {
        method: "baraff-witkin",
        docs: "drape-baraff-witkin",
        idea: "One Newton iteration replaces the nonlinear solve: the forces are linearised at the \
               old positions, and conjugate gradients solve one linear system.",
    },
    Plan {
        method: "desbrun",
        docs: "drape-desbrun",
        idea: "Only the linear part of the spring force is taken at the new positions. Its matrix \
               never changes, so it is factorised once, before the first step. One matrix serves \
               all three coordinates.",
    },
    Plan {
        method: "kang",
        docs: "drape-kang",
        idea: "The method does not solve the system with the constant matrix. Instead, it corrects \
               each particle once by the motion of its neighbours.",
    },
    Plan {
        method: "imex-euler",
        docs: "drape-imex",
        idea: "Conjugate gradients with an incomplete Cholesky preconditioner solve the system \
               with the constant matrix to a tolerance. Step size and stiffness may change at any \
               time, and forces that are not stiff stay explicit.",
    },
    Plan {
        method: "imex-updated",
        docs: "drape-imex",
        idea: "While the conjugate gradients run, the method updates the part of the spring force \
               that plain IMEX Euler leaves at the old positions. The iteration converges to \
               backward Euler, with the same constant matrix.",
    },
    Plan {
        method: "imex-sbdf2",
        docs: "drape-imex",
        idea: "The method uses two old steps instead of one. It takes differences of second order \
               for the linear part and extrapolates the rest. A step costs one solve with a \
               constant matrix, as in plain IMEX Euler.",
    },
    Plan {
        method: "imex-rk",
        docs: "drape-imex-rk",
        idea: "The method has order 2 without old steps. A step has two stages, which solve with \
               the same constant matrix; each stage evaluates the rest of the force anew.",
    },
    Plan {
        method: "dirk:solver=cholesky",
        docs: "drape-dirk",
        idea: "The step has two implicit stages (TR-BDF2). The trapezoidal rule takes its first \
               part, and backward differences take it to its end. Each stage is a Newton solve as \
               in backward Euler, with one matrix for both. The step is of second order and still \
               damps motion that it cannot resolve.",
    },
    Plan {
        method: "projective",
        docs: "drape-projective",
        idea: "This is backward Euler without a Hessian. Each spring finds its direction alone; \
               then one solve with a constant matrix joins them. The method repeats this ten \
               times, converged or not.",
    },
    Plan {
        method: "vbd",
        docs: "drape-vbd",
        idea: "The method has no matrix. One particle after the other moves to the minimum that \
               its neighbours leave it, in twenty sweeps over the sheet.",
    },
    Plan {
        method: "xpbd",
        docs: "drape-xpbd",
        idea: "Springs are constraints with a compliance. The step is divided into twenty \
               substeps. Each substep corrects every spring once, one after the other.",
    },
    Plan {
        method: "xpbd-lines",
        docs: "drape-xpbd-lines",
        idea: "The method solves all springs of a line of the weave together, as one tridiagonal \
               system, instead of one after the other. Two-step differences connect the substeps.",
    },
    Plan {
        method: "rkc",
        docs: "drape-rkc",
        idea: "This method is explicit and made for damped cloth. The range of stable damping \
               grows with the square of the number of stages. So each step takes enough stages \
               that the damping of the springs no longer limits it.",
    },
    Plan {
        method: "srkn4:step=bound",
        docs: "drape-srkn4",
        idea: "This method is explicit, symplectic and of order 4. A step takes six evaluations of \
               the forces and may be two and a half times as long as a step of leapfrog.",
    },
    Plan {
        method: "multirate:ratio=30",
        docs: "drape-multirate",
        idea: "The tension springs take thirty short steps while all other forces act once a step. \
               So soft forces are evaluated less often.",
    },
    Plan {
        method: "midpoint:solver=cholesky",
        docs: "drape-midpoint",
        idea: "The method has one implicit stage, in the middle of the step. It is of second \
               order, costs as much as backward Euler, and has no damping of its own.",
    },
    Plan {
        method: "generalized-alpha:solver=cholesky",
        docs: "drape-generalized-alpha",
        idea: "The method is of second order and has an adjustable damping. A setting says how \
               much of the fastest motion a step leaves; slow motion is kept at every setting.",
    },
    Plan {
        method: "energy-momentum",
        docs: "drape-energy-momentum",
        idea: "This is the midpoint rule with another force, that of discrete gradients. Only the \
               work of the damping changes the energy, even for springs that turn.",
    },
    Plan {
        method: "rosenbrock",
        docs: "drape-rosenbrock",
        idea: "The method linearises as Baraff and Witkin do, but is of second order: two linear \
               solves with one matrix, and no iteration.",
    },
    Plan {
        method: "exponential",
        docs: "drape-exponential",
        idea: "The method follows the linearised motion exactly, by its exponential in a Krylov \
               subspace. It solves no linear system.",
    },
];

/// The five methods that are compared first.
pub(super) const HEADLINE: [&str; 5] =
    ["explicit-euler", "baraff-witkin", "desbrun", "kang", "imex-updated"];

/// A run that keeps less than this share of the motion stands still.
const LOCKED: f64 = 0.5;
/// An error of the height above which a lesson mentions it, m.
const OFF: f64 = 0.05;
/// An excess of stretch over the true motion above which a lesson mentions it.
const SLACK: f64 = 0.05;

/// The lesson about the method called `name`: the findings from its runs, and the shortcoming of
/// the lesson before.
pub(super) fn lesson(
    plan: &Plan,
    name: &str,
    runs: Vec<Run>,
    scenes: &[Scene],
    before: Option<&Lesson>,
) -> Lesson {
    let parts = runs.iter().zip(scenes).map(|(run, scene)| told(run, scene));
    Lesson {
        id: plan.id().to_owned(),
        title: name.to_owned(),
        method: plan.method.to_owned(),
        docs: plan.docs.to_owned(),
        idea: plan.idea.to_owned(),
        before: before.map(|before| lacking(before, scenes)),
        finding: format!("{}.", parts.collect::<Vec<_>>().join(". ")),
        runs,
    }
}

fn at(scene: &Scene) -> String {
    format!("k/m = {:e}/s²", scene.stiffness_over_mass_per_s2)
}

fn per_cent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// The way in which a run that is not stable ended.
fn failure(run: &Run) -> String {
    match (run.verdict, run.energy_gain) {
        (Verdict::Diverged, _) => format!("it diverged after {} s", short(run.reached_s)),
        (Verdict::OverBudget, _) => format!("its budget ended after {} s", short(run.reached_s)),
        (verdict, Some(gain)) => format!("it is {verdict} (gains {} of E_ref)", per_cent(gain)),
        (verdict, None) => format!("it is {verdict}"),
    }
}

/// The finding from one run.
fn told(run: &Run, scene: &Scene) -> String {
    let (Some(motion), Some(error), Some(stretch)) =
        (run.retained_motion, run.height_error_m, run.greatest_stretch)
    else {
        return format!("At {} {}", at(scene), failure(run));
    };
    let work = [
        (run.force_evaluations, "force evaluations"),
        (run.cg_iterations, "CG iterations"),
        (run.factorisations, "factorisations"),
    ];
    let work = work.into_iter().filter(|(count, _)| *count > 0);
    let work: Vec<_> = work.map(|(count, what)| format!("{count} {what}")).collect();
    format!(
        "At {} it is stable and keeps {} of the motion; the free edge is at most {} m off its true \
         height, springs stretch by up to {} (truly {}); {} steps took {}",
        at(scene),
        per_cent(motion),
        short(error),
        per_cent(stretch),
        per_cent(scene.greatest_stretch),
        run.steps,
        work.join(", ")
    )
}

/// The gravest shortcoming of a method. In this order: it is unstable, it stands still, its springs
/// are too long, it departs from the true motion, or it takes much work.
fn lacking(lesson: &Lesson, scenes: &[Scene]) -> String {
    let parts: Vec<_> = lesson
        .runs
        .iter()
        .zip(scenes)
        .filter_map(|(run, scene)| Some(format!("{} at {}", shortcoming(run, scene)?, at(scene))))
        .collect();
    if parts.is_empty() {
        return format!("{} lacks nothing that these numbers show.", lesson.id);
    }
    format!("{}: {}.", lesson.id, parts.join("; "))
}

fn shortcoming(run: &Run, scene: &Scene) -> Option<String> {
    let (Some(motion), Some(error), Some(stretch)) =
        (run.retained_motion, run.height_error_m, run.greatest_stretch)
    else {
        return Some(failure(run));
    };
    if motion < LOCKED {
        return Some(format!(
            "it all but stands still (only {} of the motion is left)",
            per_cent(motion)
        ));
    }
    if stretch > scene.greatest_stretch + SLACK {
        let truly = per_cent(scene.greatest_stretch);
        return Some(format!("its springs stretch by {} (truly {truly})", per_cent(stretch)));
    }
    if motion < MOVES {
        return Some(format!("only {} of the motion is left", per_cent(motion)));
    }
    if run.factorisations > run.steps {
        return Some(format!(
            "it needs {} factorisations for {} steps",
            run.factorisations, run.steps
        ));
    }
    if run.force_evaluations > 2 * run.steps {
        return Some(format!(
            "it needs {} evaluations of the forces for {} steps",
            run.force_evaluations, run.steps
        ));
    }
    (error > OFF).then(|| format!("the free edge is up to {} m off its true height", short(error)))
}
