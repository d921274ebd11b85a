//! The energy-momentum method.

use super::Entry;
use super::runs::{Contender, Keeps, Runs, Steps, Variant, work};
use crate::lessons::{Excerpt, Law, Lesson, Question, Setting, Trap};
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
    lesson: Some(&LESSON),
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
        scaling: &[Contender {
            label: "energy-momentum",
            method: "energy-momentum:residual=1e-6",
            largest: 32,
        }],
        ..Runs::DEFAULTS
    },
};

/// A step counts as solved up to this residual, over the change of velocity by the forces.
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

/// Its lesson.
static LESSON: Lesson = Lesson {
    title: "Energy and momentum by construction",
    idea: "The force of a spring is the difference of its energies over the difference of its \
           lengths, not a force at one point. So only the work of the damping changes the energy, \
           at any step size and amplitude, and the method keeps the spin. The step must still \
           resolve the damping: with a long step, a stiff oscillation decays far too slowly.",
    docs: "drape-energy-momentum",
    sources: drape_energy_momentum::SOURCES,
    equation: Excerpt::docs(
        "x_{n+1} = x_n + h v̄                 v_{n+1} = 2 v̄ − v_n",
        "for each spring",
    ),
    code: Excerpt::step("/// `x₊ = x_n + h v̄`, `v₊ = 2 v̄ − v_n`, (1).", "past.remember(mean, h);"),
    law: Law::OneStep(implicit_midpoint),
    load: None,
    setting: Setting::oscillator(&["energy-momentum", "backward-euler"])
        .spring(10_000.0, 4.0)
        .time(0.1, 1.0),
    question: Question::EnergyLeft,
    attempt: "Take the damping away: nothing is lost at any step. Shorten the step to 0.001 s: the \
              loss becomes that of the damping.",
    low: "It keeps more than that: the step does not resolve the oscillation on which the damping \
          acts.",
    high: "It loses more than that: the damping does work.",
    traps: &[
        Trap {
            value: |s| 100.0 * libm::exp(-s.damping * s.duration),
            hint: "That is the exact loss by the damping. The long step keeps more.",
        },
        Trap { value: |_| 100.0, hint: "The exact motion keeps all of it; this method does not." },
    ],
    study: "momentum",
};
