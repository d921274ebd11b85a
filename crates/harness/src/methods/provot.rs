//! Provot.

use super::Entry;
use super::runs::{Runs, Variant};
use crate::need::Matrix;
use crate::theory::{Expectation, Problem, Theory, form, no_theorem};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{spectral_radius, symplectic_euler};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_provot::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::Corrected,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: true,
        // The limit is that of springs within its elongation limit. A method that shortens springs
        // solves another equation, so it claims no order.
        forms: &[form("provot")
            .limit("θ + 2η < 4", |t, e| spectral_radius(&symplectic_euler(t, e)))
            .spin(|_, _, _| spin::symplectic_euler(0.0))
            .order(None)],
    },
    runs: Runs {
        order: &[
            Variant::new("provot", "provot"),
            Variant::new("provot, limit out of reach", "provot:limit=10"),
        ],
        ..Runs::DEFAULTS
    },
};

fn case(_: &Problem<'_>) -> Expectation {
    no_theorem("nothing is proved about moving the ends of springs behind an explicit step")
}
