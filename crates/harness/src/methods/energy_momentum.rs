//! The energy-momentum method.

use super::Entry;
use super::runs::{Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, LoadLaw, PUSHING, Problem, Theory, form, no_theorem, stable,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{implicit_midpoint, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_energy_momentum::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::ImplicitStages,
        matrix: |_| Matrix::BlockFactor,
        divides: false,
        is_limited: false,
        forms: &[form("energy-momentum")
            .limit(ALWAYS, |t, e| spectral_radius(&implicit_midpoint(t, e)))
            .spin(|_, before, after| spin::energy_momentum(0.0, 0.0, before, after))],
    },
    runs: Runs {
        order: &[Variant::new("energy-momentum", "energy-momentum:residual=1e-12")],
        momentum: &[(
            Variant::new("energy-momentum", "energy-momentum:residual=1e-12"),
            Keeps::AsStated,
        )],
        locking: &[(Variant::new("energy-momentum", "energy-momentum"), Steps::Long)],
        locked_spring: &[(
            Variant::new("energy-momentum", "energy-momentum:residual=1e-12"),
            LoadLaw::Free,
        )],
        work_precision: &[work::main("energy-momentum", "energy-momentum:residual=1e-6")],
        ..Runs::DEFAULTS
    },
};

/// Greatest residual, over the change of velocity by the forces, of a step that counts as solved.
const SOLVED: f64 = 1e-6;

fn case(problem: &Problem<'_>) -> Expectation {
    if problem.has_contacts() {
        return no_theorem(PUSHING);
    }
    if problem.choice.settings().number("residual") > SOLVED {
        return no_theorem(
            "the theorem is of solved steps; what a loose tolerance leaves does work",
        );
    }
    stable("a step that is solved changes the energy by the work of the damping alone")
}
