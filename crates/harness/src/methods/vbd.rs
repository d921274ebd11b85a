//! Vertex block descent.

use super::Entry;
use super::runs::{Film, Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{ALWAYS, Expectation, PUSHING, Problem, Theory, form, no_theorem};
use drape_oracle::recurrence::{backward_euler, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_vbd::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::Local,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        // A single particle on a spring is one block, which a sweep solves. The law of spin holds
        // where the sweeps of two particles converge, so none is stated here.
        forms: &[
            form("vbd").limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
            form("vbd, 100 sweeps"),
            form("vbd, augmented"),
        ],
    },
    runs: Runs {
        order: &[Variant::new("vbd", "vbd:sweeps=200")],
        momentum: &[
            (Variant::new("vbd", "vbd"), Keeps::AsStated),
            (Variant::new("vbd, 100 sweeps", "vbd:sweeps=100"), Keeps::AsStated),
        ],
        locking: &[
            (Variant::new("vbd", "vbd"), Steps::Long),
            (Variant::new("vbd, 100 sweeps", "vbd:sweeps=100"), Steps::Long),
            (Variant::new("vbd, augmented", "vbd:augmented=true"), Steps::One),
        ],
        work_precision: &[
            work::main("vbd", "vbd"),
            work::extra("vbd, 100 sweeps", "vbd:sweeps=100"),
            work::extra("vbd, augmented", "vbd:augmented=true"),
        ],
        animation: &[Film::ladder("vbd", "vbd"), Film::ladder("vbd, 100 sweeps", "vbd:sweeps=100")],
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    no_theorem(
        "backward Euler as far as the sweeps converge: unsolved springs may hold more energy than \
         before",
    )
}
