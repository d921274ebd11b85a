//! Kang.

use super::Entry;
use super::runs::{Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, LoadLaw, Problem, Theory, form, no_theorem};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{kang_pair, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_kang::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::Corrected,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        forms: &[
            form("kang")
                .limit(ALWAYS, |t, e| spectral_radius(&kang_pair(0.5 * t, 0.5 * e, 1)))
                .spin(|theta, _, _| spin::kang(theta, 0.0, 1)),
            form("kang, 8 sweeps").spin(|theta, _, _| spin::kang(theta, 0.0, 8)),
        ],
    },
    runs: Runs {
        order: &[Variant::new("kang", "kang"), Variant::new("kang, 8 sweeps", "kang:sweeps=8")],
        momentum: &[
            (Variant::new("kang", "kang"), Keeps::AsStated),
            (Variant::new("kang, 8 sweeps", "kang:sweeps=8"), Keeps::AsStated),
        ],
        locking: &[
            (Variant::new("kang", "kang"), Steps::All),
            (Variant::new("kang, 8 sweeps", "kang:sweeps=8"), Steps::One),
        ],
        locked_spring: &[(Variant::new("kang", "kang"), LoadLaw::Unfiltered)],
        work_precision: &[
            work::main("kang", "kang"),
            work::extra("kang, 8 sweeps", "kang:sweeps=8"),
        ],
        ..Runs::DEFAULTS
    },
};

fn case(_: &Problem<'_>) -> Expectation {
    no_theorem("two Jacobi sweeps are stable for springs of rest length 0 only")
}
