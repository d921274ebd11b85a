//! The impulse method.

use super::Entry;
use super::runs::{Runs, work};
use crate::need::Matrix;
use crate::studies::short;
use crate::theory::{Expectation, Problem, Theory, form, limit, no_theorem, unstable};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{impulse, spectral_radius};
use drape_report::family::Kin;
use nalgebra::Vector2;

/// Its default.
const RATIO: u32 = 3;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_multirate::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::ExplicitStages,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        // Where all springs are fast; slow ones bring resonance at √θ = π.
        forms: &[form("multirate")
            .limit(
                "θ < 36 and η < 12, but near multiples of π in √θ beside slow springs",
                |t, e| spectral_radius(&impulse(t, 0.0, e, RATIO)),
            )
            .spin(|_, _, _| spin::kicks(&[], 0.0, 2))],
    },
    runs: Runs { work_precision: &[work::main("multirate", "multirate")], ..Runs::DEFAULTS },
};

/// Tension springs alone set the limit; shear springs resonate with them.
fn case(problem: &Problem<'_>) -> Expectation {
    let growing = problem.growing(|theta, eta, state| {
        let [x, w, ..] = *state;
        // Were all springs fast, the step would be stable for longer than it can be.
        let new = impulse(theta, 0.0, eta, RATIO) * Vector2::new(x, w);
        *state = [new.x, new.y, 0.0, 0.0];
    });
    match growing {
        Some(theta) => unstable(format!(
            "H²λ = {} at the start is beyond the limit 4 ratio² of the short steps",
            short(theta)
        )),
        None => no_theorem(format!("slow forces resonate with fast modes ({})", limit(problem))),
    }
}
