//! Symplectic Euler.

use super::Entry;
use super::runs::{Contender, Film, Runs, Variant, work};
use crate::need::Matrix;
use crate::theory::{Expectation, Factors, Problem, Theory, explicit, form};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{
    spectral_radius, symplectic_euler, symplectic_euler_implicit_damping,
};
use drape_report::family::Kin;

/// Its forms in studies that compare limits and orders.
const FORMS: &[Variant] = &[
    Variant::new("symplectic-euler", "symplectic-euler"),
    Variant::new("symplectic-euler, implicit damping", "symplectic-euler:damping=implicit"),
];

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_explicit_euler::SYMPLECTIC,
    theory: Theory {
        case,
        kin: Kin::Explicit,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: true,
        forms: &[
            form("symplectic-euler")
                .limit("θ + 2η < 4", |t, e| spectral_radius(&symplectic_euler(t, e)))
                .spin(|_, _, _| spin::symplectic_euler(0.0)),
            form("symplectic-euler, implicit damping").limit("θ < 4 + 2η", |t, e| {
                spectral_radius(&symplectic_euler_implicit_damping(t, e))
            }),
        ],
    },
    runs: Runs {
        order: FORMS,
        stability: FORMS,
        animation: &[
            Film::limit("symplectic-euler", "symplectic-euler"),
            Film::limit("symplectic-euler, implicit damping", "symplectic-euler:damping=implicit"),
        ],
        work_precision: &[work::headline("symplectic-euler", "symplectic-euler")],
        scaling: &[Contender {
            label: "symplectic-euler",
            method: "symplectic-euler",
            largest: 1000,
        }],
        are_effects_timed: true,
        are_effects_quick: true,
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    explicit(problem, "h²λ + 2hδ < 4", &Factors::ONE_STEP)
}
