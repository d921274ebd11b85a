//! The lessons, in the order in which the methods build on each other.

/// One method, before it is measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Method id with the settings that are not at their defaults.
    pub(super) method: &'static str,
    /// The crate whose documentation explains it.
    pub(super) docs: &'static str,
    /// What it does, and what is new in it.
    pub(super) idea: &'static str,
}

impl Plan {
    /// Method id.
    pub(super) fn id(&self) -> &'static str {
        self.method.split(':').next().unwrap_or(self.method)
    }
}

pub(super) const LESSONS: [Plan; 10] = [
    Plan {
        method: "explicit-euler",
        docs: "drape-explicit-euler",
        idea: "Positions move with the old velocities, velocities with the forces at the old positions. Nothing has to be solved: \
               one evaluation of the forces is the whole step.",
    },
    Plan {
        method: "leapfrog:step=bound,safety=0.95,solver=cg",
        docs: "drape-explicit-euler",
        idea: "Velocities and positions take turns, half a step apart, which costs no more and is of second order. The step is \
               divided into equal parts below 2/ω, the limit that the stiffest mode of the sheet sets. Damping is taken at the new \
               velocity, by a few iterations of conjugate gradients that are run down to round-off.",
    },
    Plan {
        method: "provot",
        docs: "drape-provot",
        idea: "The full step is kept, whatever the limit says; after it, each spring that is longer than 1.1 times its rest \
               length is shortened by moving its ends.",
    },
    Plan {
        method: "backward-euler",
        docs: "drape-backward-euler",
        idea: "The forces are those at the end of the step. That is a nonlinear system in the new velocities, solved by \
               Newton's method, which sets up and factorises a matrix in every iteration.",
    },
    Plan {
        method: "baraff-witkin",
        docs: "drape-baraff-witkin",
        idea: "One Newton iteration is enough: the forces are linearised at the old positions, and one linear system is \
               solved by conjugate gradients.",
    },
    Plan {
        method: "desbrun",
        docs: "drape-desbrun",
        idea: "Only the linear part of the spring force is taken at the new positions. Its matrix never changes, so that it \
               is factorised once, before the first step, and one matrix serves all three coordinates.",
    },
    Plan {
        method: "kang",
        docs: "drape-kang",
        idea: "The system with the constant matrix is not solved at all: each particle is corrected once by what its \
               neighbours do.",
    },
    Plan {
        method: "imex-euler",
        docs: "drape-imex",
        idea: "The system with the constant matrix is solved to a tolerance, by conjugate gradients with an incomplete Cholesky \
               preconditioner. Step size and stiffness may change at any time, and what is not stiff stays explicit.",
    },
    Plan {
        method: "imex-updated",
        docs: "drape-imex",
        idea: "The part of the spring force that was left at the old positions is taken anew while the conjugate gradients run. \
               What they converge to is backward Euler, with the same constant matrix.",
    },
    Plan {
        method: "imex-sbdf2",
        docs: "drape-imex",
        idea: "Two old steps instead of one: differences of second order for the linear part, extrapolation for the rest. One \
               solve with a constant matrix a step, as plain IMEX Euler.",
    },
];

/// The five methods that are compared first.
pub(super) const HEADLINE: [&str; 5] =
    ["explicit-euler", "baraff-witkin", "desbrun", "kang", "imex-updated"];
