//! What theory says about a method on a case, from the scene and the settings alone.
//!
//! Most rules were written before the methods ran here. Three were derived after first runs had
//! failed, so they explain and do not predict: the secant method, explicit springs beside
//! Baraff-Witkin and the two-step methods, and drag in divided steps of leapfrog.

use super::linear::{Factors, Linear, Problem, Weights};
use crate::studies::hard_cases::facts::{Expected, NOTHING_MOVES};
use crate::studies::short;
use drape_integrator::Implicit;

/// What a method should do, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Expectation {
    pub(crate) kind: Expected,
    pub(crate) reason: String,
}

fn monotone(reason: impl Into<String>) -> Expectation {
    Expectation { kind: Expected::Monotone, reason: reason.into() }
}

fn stable(reason: impl Into<String>) -> Expectation {
    Expectation { kind: Expected::Stable, reason: reason.into() }
}

fn unstable(reason: impl Into<String>) -> Expectation {
    Expectation { kind: Expected::Unstable, reason: reason.into() }
}

fn no_theorem(reason: impl Into<String>) -> Expectation {
    Expectation { kind: Expected::NoTheorem, reason: reason.into() }
}

/// What theory says.
pub(crate) fn expectation(problem: &Problem<'_>) -> Expectation {
    if !problem.has_moving_springs() && !problem.has_contacts() {
        return stable(NOTHING_MOVES);
    }
    if let Some(factor) = problem.explicit_drag().filter(|factor| *factor > 2.0) {
        return unstable(format!(
            "drag at the old velocity is stable for hδ ≤ 2 at most; here the sheet as a whole has hδ = {}",
            short(factor)
        ));
    }
    (problem.choice.theory().case)(problem)
}

const PUSHING: &str = "contacts that push out do work";
const TURNING: &str = "nothing is proved for springs that turn";

/// In words: the bounds on the fastest mode.
fn limit(problem: &Problem<'_>) -> String {
    let (_, h) = problem.steps();
    let (stiffness, damping) = problem.bounds();
    format!("h²λ ≤ {}, hδ ≤ {}", short(h * h * stiffness), short(h * damping))
}

/// `x_{n+1} = x_n + w_n`, `w_{n+1} = w_n − θ x_n − η w_n`: stable for `θ ≤ η` and `2η ≤ 4 + θ`.
pub(super) fn explicit_euler(problem: &Problem<'_>) -> Expectation {
    let growing = problem.growing(|theta, eta, [x, w, ..]| {
        let force = -theta * *x - eta * *w;
        *x += *w;
        *w += force;
    });
    if let Some(theta) = growing {
        return unstable(format!("stable only for h²λ ≤ hδ; here h²λ = {}", short(theta)));
    }
    let (_, h) = problem.steps();
    let mut is_damped_enough = !problem.has_contacts();
    Implicit::Springs.visit_weights(problem.system(), &mut |_, _, k, c| {
        is_damped_enough &= c >= h * k;
    });
    if is_damped_enough && h * problem.bounds().1 <= 2.0 {
        stable("every spring has c ≥ hk, and hδ ≤ 2")
    } else {
        no_theorem("within or near its limit: what grows, grows too slowly to be seen for certain")
    }
}

/// `y_{n+1} = y_n + h (3/2 f_n − 1/2 f_{n−1})`.
pub(super) fn adams_bashforth(problem: &Problem<'_>) -> Expectation {
    let growing = problem.growing(|theta, eta, state| {
        let [x, w, old_w, old_force] = *state;
        let force = -theta * x - eta * w;
        *state = [x + 1.5 * w - 0.5 * old_w, w + 1.5 * force - 0.5 * old_force, w, force];
    });
    match growing {
        Some(theta) => unstable(format!(
            "its region of stability leaves out h²λ = {}, whatever the damping",
            short(theta)
        )),
        None if problem.is_damped() => no_theorem("stable for small steps with damping"),
        None => no_theorem("unstable on the imaginary axis, but too slowly to be seen for certain"),
    }
}

pub(super) fn symplectic_euler(problem: &Problem<'_>) -> Expectation {
    explicit(problem, "h²λ + 2hδ < 4", &Factors::ONE_STEP)
}

/// Half of the damping is taken at either velocity: at `ζ = −1` it falls out.
const LEAPFROG: Factors = Factors {
    explicit: Weights { damping: 0.0, ..Factors::ONE_STEP.explicit },
    ..Factors::ONE_STEP
};

pub(super) fn leapfrog(problem: &Problem<'_>) -> Expectation {
    match problem.choice.settings().word("step") {
        "auto" => no_theorem(
            "substeps within the limit by an estimate of the largest eigenvalue, which follows the cloth with a delay",
        ),
        "bound" if problem.has_contacts() => no_theorem(PUSHING),
        "bound" => stable("substeps within the limit h²λ < 4 at every state"),
        _ => explicit(problem, "h²λ < 4", &LEAPFROG),
    }
}

/// A method that takes all springs at the old level.
fn explicit(problem: &Problem<'_>, condition: &str, factors: &Factors) -> Expectation {
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

pub(super) fn provot(_: &Problem<'_>) -> Expectation {
    no_theorem("nothing is proved about moving the ends of springs behind an explicit step")
}

pub(super) fn backward_euler(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    stable(
        "it lowers the incremental potential in every step and damps every mode; its energy may still rise in a step",
    )
}

/// Backward Euler for the implicit springs beside explicit ones.
const BESIDE_EXPLICIT: Factors = Factors {
    implicit: Weights { tangent: 1.0, damping: 2.0, ..Weights::NONE },
    ..Factors::ONE_STEP
};

/// Methods with the tangent of their implicit springs in the matrix and explicit springs beside
/// them.
fn beside_explicit(problem: &Problem<'_>, implicit: Implicit) -> Expectation {
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
fn implicit(problem: &Problem<'_>) -> Implicit {
    match problem.choice.settings().word("implicit") {
        "tension" => Implicit::Tension,
        _ => Implicit::Springs,
    }
}

/// Near an equilibrium linear theory is the whole truth.
fn at_rest_or(problem: &Problem<'_>, reason: &str) -> Expectation {
    if problem.is_at_rest {
        stable(
            "an equilibrium is a fixed point, and small motions about it are linear, where the method is A-stable",
        )
    } else {
        no_theorem(reason)
    }
}

pub(super) fn baraff_witkin(problem: &Problem<'_>) -> Expectation {
    let implicit = implicit(problem);
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if problem.are_all(implicit) {
        at_rest_or(
            problem,
            "one Newton step with clamped tangents: A-stable where they are constant",
        )
    } else {
        beside_explicit(problem, implicit)
    }
}

pub(super) fn bdf2(problem: &Problem<'_>) -> Expectation {
    at_rest_or(problem, &format!("A-stable on linear systems; {TURNING}"))
}

pub(super) fn kang(_: &Problem<'_>) -> Expectation {
    no_theorem("two Jacobi sweeps are stable for springs of rest length 0 only")
}

/// Its force `−k (1 − ℓ/L_n) d_{n+1}` is implicit in the secant stiffness only. Along the spring,
/// `L_n` adds an explicit part, which is everything near the rest length. The damping is centred.
const SECANT: Factors = Factors {
    implicit: Weights { tangent: -1.0, secant: 2.0, ..Weights::NONE },
    ..Factors::ONE_STEP
};

pub(super) fn terzopoulos_fleischer(problem: &Problem<'_>) -> Expectation {
    match problem.analyse(Some(Implicit::Springs), &SECANT) {
        Linear::Nowhere => unstable(format!(
            "near the rest length the secant stiffness vanishes and the method is leapfrog, here beyond its limit \
             h²λ < 4 at the start ({})",
            limit(problem)
        )),
        _ => no_theorem("the secant stiffness at the old positions is negative in compression"),
    }
}

pub(super) fn desbrun(problem: &Problem<'_>) -> Expectation {
    let has_gravity = problem.system().effects().any(|effect| effect.name() == "gravity");
    let has_pins = problem.system().pinned().contains(&true);
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if has_gravity && has_pins {
        no_theorem(
            "the theorem of IMEX Euler, but for gravity, which passes by the filter while the pins' reaction does not",
        )
    } else if !has_pins && problem.choice.settings().word("torque") != "none" {
        no_theorem(
            "its predictor has the theorem of IMEX Euler, its correction of the torque has none",
        )
    } else {
        monotone("the theorem of IMEX Euler: an exact solve with all springs and full damping")
    }
}

pub(super) fn imex_euler(problem: &Problem<'_>) -> Expectation {
    let settings = problem.choice.settings();
    let implicit = implicit(problem);
    let is_exact = settings.word("solver") == "cholesky";
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    if problem.are_all(implicit) && is_exact {
        return monotone("theorem: all springs in the matrix, full damping, solved exactly");
    }
    match problem.analyse(Some(implicit), &Factors::ONE_STEP) {
        Linear::Nowhere => unstable(
            "some mode has θ_E > 4 + θ_I at the start already: 4M + 2h²L_I − h²K is indefinite",
        ),
        Linear::Everywhere if is_exact => {
            stable("no mode has θ_E > 4 + θ_I at any state: 4M + 2h²L_I − h²L is positive definite")
        }
        Linear::Everywhere => no_theorem(
            "the energy theorem needs an exact solve; this one stops at a tolerance, from an extrapolated start",
        ),
        Linear::Somewhere => {
            no_theorem("θ_E < 4 + θ_I for every mode at the start, but not at every state")
        }
    }
}

pub(super) fn imex_updated(problem: &Problem<'_>) -> Expectation {
    let settings = problem.choice.settings();
    let implicit = implicit(problem);
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if settings.word("safeguard") == "paper" {
        no_theorem(
            "an extrapolated start that passes a loose test is no step downhill: energy may come in",
        )
    } else if problem.are_all(implicit) {
        stable(
            "every pass lowers the incremental potential of backward Euler, and a step that gains energy is solved \
             again",
        )
    } else {
        beside_explicit(problem, implicit)
    }
}

/// `a` = (3/2, −2, 1/2), `b` = (1, 0, 0), `c` = (2, −1).
pub(super) fn imex_sbdf2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(4.0, 1.0, -3.0))
}

/// `a` = (1, −1, 0), `b` = (1/2, 1/2, 0), `c` = (3/2, −1/2).
pub(super) fn imex_cnab2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(2.0, 0.0, -2.0))
}

/// `a` = (1, −1, 0), `b` = (9/16, 3/8, 1/16), `c` = (3/2, −1/2).
pub(super) fn imex_mcnab2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(2.0, 0.25, -2.0))
}

/// `a` = (1/2, 0, −1/2), `b` = (1/2, 0, 1/2), `c` = (1, 0). About an equilibrium roots may lie on
/// the unit circle.
pub(super) fn imex_cnlf(problem: &Problem<'_>) -> Expectation {
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
            "an equilibrium is a fixed point; small motions about it have θ_E between −θ_I and 0, where no root of \
             the characteristic polynomial is outside the unit circle",
        )
    } else {
        no_theorem(format!(
            "on the linear test equation no root is outside the unit circle for springs that are not compressed; {TURNING}"
        ))
    }
}
