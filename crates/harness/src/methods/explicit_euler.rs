//! Explicit Euler.

use super::Entry;
use super::runs::Runs;
use crate::need::Matrix;
use crate::studies::short;
use crate::theory::{Expectation, Problem, Theory, form, no_theorem, stable, unstable};
use drape_integrator::Implicit;
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{explicit_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_explicit_euler::EXPLICIT,
    theory: Theory {
        case,
        kin: Kin::Explicit,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        forms: &[form("explicit-euler")
            .limit("θ ≤ η and 2η ≤ 4 + θ", |t, e| spectral_radius(&explicit_euler(t, e)))
            .spin(|theta, before, _| spin::explicit_euler(theta, 0.0, before))],
    },
    runs: Runs::DEFAULTS,
};

/// `x_{n+1} = x_n + w_n`, `w_{n+1} = w_n − θ x_n − η w_n`: stable for `θ ≤ η` and `2η ≤ 4 + θ`.
fn case(problem: &Problem<'_>) -> Expectation {
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
