//! Desbrun.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant};
use crate::need::Matrix;
use crate::presets::Preset;
use crate::theory::{
    ALWAYS, Expectation, LoadLaw, PUSHING, Problem, Theory, form, monotone, no_theorem,
};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{desbrun, spectral_radius};
use drape_report::family::Kin;

/// Its entry in the registry.
pub(super) static ENTRY: Entry = Entry {
    registration: &drape_desbrun::REGISTRATION,
    theory: Theory {
        case,
        kin: Kin::Corrected,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "inverse", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[
            form("desbrun").limit(ALWAYS, |t, e| spectral_radius(&desbrun(t, e))),
            form("desbrun, no correction").spin(|theta, _, _| spin::imex_euler(theta, 0.0)),
        ],
    },
    runs: Runs {
        presets: &[Preset {
            name: "paper",
            settings: &[("inverse", "dense"), ("torque", "literal"), ("inverse_dynamics", "true")],
            help: "as Desbrun, Schröder and Barr publish it: the full inverse, the torque in their \
               units, and springs shortened after the step",
        }],
        energy: &[
            Variant::new("desbrun, no correction", "desbrun:torque=none"),
            Variant::new("desbrun", "desbrun"),
        ],
        momentum: &[
            (Variant::new("desbrun, no correction", "desbrun:torque=none"), Keeps::Otherwise),
            (Variant::new("desbrun, literal", "desbrun:torque=literal"), Keeps::Otherwise),
            (Variant::new("desbrun, consistent", "desbrun:torque=consistent"), Keeps::AsStated),
        ],
        locking: &[(Variant::new("desbrun", "desbrun"), Steps::All)],
        locked_spring: &[(Variant::new("desbrun", "desbrun"), LoadLaw::Unfiltered)],
        scaling: &[Contender { label: "desbrun", method: "desbrun", largest: 316 }],
        ..Runs::DEFAULTS
    },
};

fn case(problem: &Problem<'_>) -> Expectation {
    let has_gravity = problem.system().effects().any(|effect| effect.name() == "gravity");
    let has_pins = problem.system().pinned().contains(&true);
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if has_gravity && has_pins {
        no_theorem(
            "the theorem of IMEX Euler, but for gravity, which passes by the filter while the \
             pins' reaction does not",
        )
    } else if !has_pins && problem.choice.settings().word("torque") != "none" {
        no_theorem(
            "its predictor has the theorem of IMEX Euler, its correction of the torque has none",
        )
    } else {
        monotone("the theorem of IMEX Euler: an exact solve with all springs and full damping")
    }
}
