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
        idea: "Positions move with the old velocities, velocities with the forces at the old \
               positions. Nothing has to be solved: one evaluation of the forces is the whole \
               step.",
    },
    Plan {
        method: "leapfrog:step=bound,safety=0.95,solver=cg",
        docs: "drape-explicit-euler",
        idea: "Velocities and positions take turns, half a step apart, which costs no more and is \
               of second order. The step is divided into equal parts below 2/ω, the limit that the \
               stiffest mode of the sheet sets. Damping is taken at the new velocity, by a few \
               iterations of conjugate gradients that are run down to round-off.",
    },
    Plan {
        method: "provot",
        docs: "drape-provot",
        idea: "The full step is kept, whatever the limit says; after it, each spring that is \
               longer than 1.1 times its rest length is shortened by moving its ends.",
    },
    Plan {
        method: "backward-euler:solver=cholesky",
        docs: "drape-backward-euler",
        idea: "The forces are those at the end of the step. That is a nonlinear system in the new \
               velocities, solved by Newton's method, which sets up and factorises a matrix in \
               every iteration.",
    },
    Plan {
        method: "baraff-witkin",
        docs: "drape-baraff-witkin",
        idea: "One Newton iteration is enough: the forces are linearised at the old positions, and \
               one linear system is solved by conjugate gradients.",
    },
    Plan {
        method: "desbrun",
        docs: "drape-desbrun",
        idea: "Only the linear part of the spring force is taken at the new positions. Its matrix \
               never changes, so that it is factorised once, before the first step, and one matrix \
               serves all three coordinates.",
    },
    Plan {
        method: "kang",
        docs: "drape-kang",
        idea: "The system with the constant matrix is not solved at all: each particle is \
               corrected once by what its neighbours do.",
    },
    Plan {
        method: "imex-euler",
        docs: "drape-imex",
        idea: "The system with the constant matrix is solved to a tolerance, by conjugate \
               gradients with an incomplete Cholesky preconditioner. Step size and stiffness may \
               change at any time, and what is not stiff stays explicit.",
    },
    Plan {
        method: "imex-updated",
        docs: "drape-imex",
        idea: "The part of the spring force that was left at the old positions is taken anew while \
               the conjugate gradients run. What they converge to is backward Euler, with the same \
               constant matrix.",
    },
    Plan {
        method: "imex-sbdf2",
        docs: "drape-imex",
        idea: "Two old steps instead of one: differences of second order for the linear part, \
               extrapolation for the rest. One solve with a constant matrix a step, as plain IMEX \
               Euler.",
    },
    Plan {
        method: "imex-rk",
        docs: "drape-imex-rk",
        idea: "Order 2 without old steps: two stages in a step, each solved with one and the same \
               constant matrix, the rest of the force taken anew in each.",
    },
    Plan {
        method: "dirk:solver=cholesky",
        docs: "drape-dirk",
        idea: "Two implicit stages (TR-BDF2): half of the step by the trapezoidal rule, the rest \
               by \
               backward differences. Each is a Newton solve as in backward Euler, with one matrix \
               for both. The step is of second order and still damps what it cannot resolve.",
    },
    Plan {
        method: "projective",
        docs: "drape-projective",
        idea: "Backward Euler without a Hessian: each spring gives its direction on its own, then \
               one solve with a constant matrix joins them. This is done ten times, converged or \
               not.",
    },
    Plan {
        method: "vbd",
        docs: "drape-vbd",
        idea: "No matrix at all: one particle after the other goes to the minimum that its \
               neighbours leave it, in twenty sweeps over the sheet.",
    },
    Plan {
        method: "xpbd",
        docs: "drape-xpbd",
        idea: "Springs are constraints that yield. The step is cut into twenty substeps, and in \
               each every spring is corrected once, one after the other.",
    },
    Plan {
        method: "xpbd-lines",
        docs: "drape-xpbd-lines",
        idea: "The springs of each line of the weave are solved at once, as one tridiagonal \
               system, in place of one after the other. Two-step differences join the \
               substeps.",
    },
    Plan {
        method: "rkc",
        docs: "drape-rkc",
        idea: "Explicit again, for damped cloth: each step has so many stages that the \
               damping of its springs limits it no more, since the range of damping that is \
               stable grows with the square of their number.",
    },
    Plan {
        method: "srkn4:step=bound",
        docs: "drape-srkn4",
        idea: "Explicit, symplectic and of order 4: six evaluations of the forces a step, \
               which may be two and a half times as long as that of leapfrog.",
    },
    Plan {
        method: "multirate:ratio=30",
        docs: "drape-multirate",
        idea: "The tension springs take thirty short steps while all other forces act once a \
               step. What is soft is evaluated less often.",
    },
    Plan {
        method: "midpoint:solver=cholesky",
        docs: "drape-midpoint",
        idea: "One implicit stage, in the middle of the step. Of second order with the cost \
               of backward Euler, and without any damping of its own.",
    },
    Plan {
        method: "generalized-alpha:solver=cholesky",
        docs: "drape-generalized-alpha",
        idea: "Second order with a dial: how much of the fastest motion is left after a step \
               is chosen, and slow motion is kept whatever is chosen.",
    },
    Plan {
        method: "energy-momentum",
        docs: "drape-energy-momentum",
        idea: "The midpoint with another force: that of discrete gradients, which changes the \
               energy by the work of the damping and by nothing else, for springs that turn \
               as well.",
    },
    Plan {
        method: "rosenbrock",
        docs: "drape-rosenbrock",
        idea: "Linearised as Baraff and Witkin, but of second order: two linear solves with \
               one matrix, no iteration.",
    },
    Plan {
        method: "exponential",
        docs: "drape-exponential",
        idea: "The linearised motion is followed exactly, by its exponential in a Krylov \
               subspace. No linear system is solved.",
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
