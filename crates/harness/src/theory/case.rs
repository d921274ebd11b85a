//! The prediction of theory for a method on a case, from the scene and the settings alone.
//!
//! Most rules were written before the methods ran here. Three rules were derived after first runs
//! had failed, so they explain and do not predict: for the secant method, for explicit springs
//! beside Baraff-Witkin and the two-step methods, and for drag in divided steps of leapfrog.

use super::linear::{Factors, Linear, Problem, Weights};
use crate::studies::hard_cases::facts::{Expected, NOTHING_MOVES};
use crate::studies::short;
use drape_integrator::Implicit;

/// The expected behaviour of a method, and the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Expectation {
    pub(crate) kind: Expected,
    pub(crate) reason: String,
}

pub(crate) fn monotone(reason: impl Into<String>) -> Expectation {
    Expectation { kind: Expected::Monotone, reason: reason.into() }
}

pub(crate) fn stable(reason: impl Into<String>) -> Expectation {
    Expectation { kind: Expected::Stable, reason: reason.into() }
}

pub(crate) fn unstable(reason: impl Into<String>) -> Expectation {
    Expectation { kind: Expected::Unstable, reason: reason.into() }
}

pub(crate) fn no_theorem(reason: impl Into<String>) -> Expectation {
    Expectation { kind: Expected::NoTheorem, reason: reason.into() }
}

/// The prediction of theory for a problem.
pub(crate) fn expectation(problem: &Problem<'_>) -> Expectation {
    if !problem.has_moving_springs() && !problem.has_contacts() {
        return stable(NOTHING_MOVES);
    }
    if let Some(factor) = problem.explicit_drag().filter(|factor| *factor > 2.0) {
        return unstable(format!(
            "drag at the old velocity is stable for hδ ≤ 2 at most; here the sheet as a whole has \
             hδ = {}",
            short(factor)
        ));
    }
    (problem.choice.theory().case)(problem)
}

pub(crate) const PUSHING: &str = "contacts that push out do work";
pub(crate) const TURNING: &str = "nothing is proved for springs that turn";

/// The bounds on the fastest mode, in words.
pub(crate) fn limit(problem: &Problem<'_>) -> String {
    let (_, h) = problem.steps();
    let (stiffness, damping) = problem.bounds();
    format!("h²λ ≤ {}, hδ ≤ {}", short(h * h * stiffness), short(h * damping))
}

/// The prediction for a method that takes all springs at the old level.
pub(crate) fn explicit(problem: &Problem<'_>, condition: &str, factors: &Factors) -> Expectation {
    let limit = limit(problem);
    match problem.analyse(None, factors) {
        Linear::Nowhere => {
            unstable(format!("beyond the limit {condition} at the start already ({limit})"))
        }
        _ if problem.has_contacts() => no_theorem(PUSHING),
        Linear::Everywhere => stable(format!("within {condition} at every state ({limit})")),
        Linear::Somewhere => {
            no_theorem(format!("within {condition} at the start, but not at every state ({limit})"))
        }
    }
}

/// Backward Euler for the implicit springs beside explicit ones.
const BESIDE_EXPLICIT: Factors = Factors {
    implicit: Weights { tangent: 1.0, damping: 2.0, ..Weights::NONE },
    ..Factors::ONE_STEP
};

/// The prediction for methods that have the tangent of their implicit springs in the matrix, and
/// explicit springs beside them.
pub(crate) fn beside_explicit(problem: &Problem<'_>, implicit: Implicit) -> Expectation {
    match problem.analyse(Some(implicit), &BESIDE_EXPLICIT) {
        Linear::Nowhere => unstable(
            "some mode of the explicit springs outweighs the implicit ones at the start already: \
             4M + h²K_I − h²K_E is indefinite",
        ),
        _ => no_theorem(
            "the implicit springs outweigh the explicit ones at the start, but not at every state",
        ),
    }
}

/// Which springs are implicit by the setting `implicit`.
pub(crate) fn implicit(problem: &Problem<'_>) -> Implicit {
    match problem.choice.settings().word("implicit") {
        "tension" => Implicit::Tension,
        _ => Implicit::Springs,
    }
}

/// Near an equilibrium, linear theory decides alone.
pub(crate) fn at_rest_or(problem: &Problem<'_>, reason: &str) -> Expectation {
    if problem.is_at_rest {
        stable(
            "an equilibrium is a fixed point, and small motions about it are linear, where the \
             method is A-stable",
        )
    } else {
        no_theorem(reason)
    }
}
