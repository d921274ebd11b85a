//! The theory of each method.
//!
//! Limits are those of springs of rest length 0, whose forces are linear; they come from the
//! recurrences of the oracle, as do the laws of spin.

use super::case;
use super::{Form, Kin, Limit, Radius, SpinLaw, Theory};
use drape_oracle::laws::spin;
use drape_oracle::recurrence::{
    Multistep, adams_bashforth, backward_euler, bdf, desbrun, explicit_euler, imex_euler,
    kang_pair, leapfrog, spectral_radius, symplectic_euler, symplectic_euler_implicit_damping,
    terzopoulos_fleischer,
};

/// The rule of a method that is stable at every step.
const ALWAYS: &str = "every θ and η";

const fn form(label: &'static str) -> Form {
    Form { label, limit: None, spin: None, order: None }
}

impl Form {
    const fn limit(self, rule: &'static str, radius: Radius) -> Self {
        Self { limit: Some(Limit { rule, radius }), ..self }
    }

    const fn spin(self, law: SpinLaw) -> Self {
        Self { spin: Some(law), ..self }
    }

    const fn order(self, order: Option<u32>) -> Self {
        Self { order: Some(order), ..self }
    }
}

fn two_step(method: &Multistep, theta: f64, eta: f64) -> f64 {
    method.recurrence(theta, 0.0, eta).spectral_radius()
}

pub(crate) static EXPLICIT_EULER: Theory = Theory {
    case: case::explicit_euler,
    kin: Kin::Explicit,
    divides: false,
    is_limited: false,
    forms: &[form("explicit-euler")
        .limit("θ ≤ η and 2η ≤ 4 + θ", |t, e| spectral_radius(&explicit_euler(t, e)))
        .spin(|theta, before, _| spin::explicit_euler(theta, 0.0, before))],
};

pub(crate) static SYMPLECTIC_EULER: Theory = Theory {
    case: case::symplectic_euler,
    kin: Kin::Explicit,
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
};

pub(crate) static LEAPFROG: Theory = Theory {
    case: case::leapfrog,
    kin: Kin::Explicit,
    divides: true,
    is_limited: true,
    forms: &[form("leapfrog")
        .limit("θ < 4", |t, e| spectral_radius(&leapfrog(t, e)))
        .spin(|_, _, _| spin::leapfrog(0.0))],
};

pub(crate) static PROVOT: Theory = Theory {
    case: case::provot,
    kin: Kin::Corrected,
    divides: false,
    is_limited: true,
    // The limit is that of springs within its elongation limit. A method that shortens springs
    // solves another equation, so it claims no order.
    forms: &[form("provot")
        .limit("θ + 2η < 4", |t, e| spectral_radius(&symplectic_euler(t, e)))
        .spin(|_, _, _| spin::symplectic_euler(0.0))
        .order(None)],
};

pub(crate) static ADAMS_BASHFORTH: Theory = Theory {
    case: case::adams_bashforth,
    kin: Kin::Explicit,
    divides: false,
    is_limited: false,
    forms: &[
        form("adams-bashforth2")
            .limit("roots of ρ² + ηρσ + θσ²; undamped never", |t, e| {
                adams_bashforth(2, t, e).spectral_radius()
            }),
        form("adams-bashforth, 3 steps")
            .limit("roots of ρ² + ηρσ + θσ²; undamped θ < 144/275", |t, e| {
                adams_bashforth(3, t, e).spectral_radius()
            })
            .order(Some(3)),
    ],
};

pub(crate) static BACKWARD_EULER: Theory = Theory {
    case: case::backward_euler,
    kin: Kin::Implicit,
    divides: false,
    is_limited: false,
    forms: &[form("backward-euler")
        .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e)))
        .spin(|theta, _, after| spin::backward_euler(theta, 0.0, after))],
};

pub(crate) static BDF: Theory = Theory {
    case: case::bdf2,
    kin: Kin::Implicit,
    divides: false,
    is_limited: false,
    forms: &[
        form("bdf2").limit(ALWAYS, |t, e| bdf(2, t, e).spectral_radius()),
        form("bdf, 3 steps").order(Some(3)),
    ],
};

pub(crate) static TERZOPOULOS_FLEISCHER: Theory = Theory {
    case: case::terzopoulos_fleischer,
    kin: Kin::Implicit,
    divides: false,
    is_limited: false,
    forms: &[
        form("terzopoulos-fleischer")
            .limit(ALWAYS, |t, e| spectral_radius(&terzopoulos_fleischer(t, e)))
            .spin(|theta, before, _| spin::terzopoulos_fleischer(theta, 0.0, before)),
        // Weights that are cut off in compression make another equation: no order is claimed.
        form("terzopoulos-fleischer, clamped")
            .spin(|theta, before, _| spin::terzopoulos_fleischer(theta, 0.0, before.min(1.0)))
            .order(None),
    ],
};

pub(crate) static BARAFF_WITKIN: Theory = Theory {
    case: case::baraff_witkin,
    kin: Kin::Implicit,
    divides: false,
    is_limited: false,
    // Across the spring the linearised force is that of the old secant stiffness.
    forms: &[form("baraff-witkin")
        .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e)))
        .spin(|theta, before, _| spin::baraff_witkin(theta, 0.0, before))],
};

pub(crate) static DESBRUN: Theory = Theory {
    case: case::desbrun,
    kin: Kin::Corrected,
    divides: false,
    is_limited: false,
    forms: &[
        form("desbrun").limit(ALWAYS, |t, e| spectral_radius(&desbrun(t, e))),
        form("desbrun, no correction").spin(|theta, _, _| spin::imex_euler(theta, 0.0)),
    ],
};

pub(crate) static KANG: Theory = Theory {
    case: case::kang,
    kin: Kin::Corrected,
    divides: false,
    is_limited: false,
    forms: &[
        form("kang")
            .limit(ALWAYS, |t, e| spectral_radius(&kang_pair(0.5 * t, 0.5 * e, 1)))
            .spin(|theta, _, _| spin::kang(theta, 0.0, 1)),
        form("kang, 8 sweeps").spin(|theta, _, _| spin::kang(theta, 0.0, 8)),
    ],
};

pub(crate) static IMEX_EULER: Theory = Theory {
    case: case::imex_euler,
    kin: Kin::ImplicitExplicit,
    divides: false,
    is_limited: true,
    forms: &[
        form("imex-euler")
            .limit(ALWAYS, |t, e| spectral_radius(&imex_euler(t, 0.0, e)))
            .spin(|theta, _, _| spin::imex_euler(theta, 0.0)),
        form("imex-euler, as printed")
            .limit(ALWAYS, |t, e| spectral_radius(&imex_euler(t, 0.0, e))),
        form("imex-euler, all springs")
            .limit(ALWAYS, |t, e| spectral_radius(&imex_euler(t, 0.0, e)))
            .spin(|theta, _, _| spin::imex_euler(theta, 0.0)),
    ],
};

pub(crate) static IMEX_UPDATED: Theory = Theory {
    case: case::imex_updated,
    kin: Kin::ImplicitExplicit,
    divides: false,
    is_limited: false,
    forms: &[
        form("imex-updated")
            .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e)))
            .spin(|theta, _, after| spin::backward_euler(theta, 0.0, after)),
        form("imex-updated, as printed")
            .limit(ALWAYS, |t, e| spectral_radius(&backward_euler(t, e))),
    ],
};

pub(crate) static SBDF2: Theory = Theory {
    case: case::imex_sbdf2,
    kin: Kin::TwoSteps,
    divides: false,
    is_limited: false,
    forms: &[form("imex-sbdf2").limit(ALWAYS, |t, e| two_step(&Multistep::sbdf2(1.0), t, e))],
};

pub(crate) static CNAB2: Theory = Theory {
    case: case::imex_cnab2,
    kin: Kin::TwoSteps,
    divides: false,
    is_limited: false,
    forms: &[form("imex-cnab2").limit(ALWAYS, |t, e| two_step(&Multistep::cnab2(1.0), t, e))],
};

pub(crate) static MCNAB2: Theory = Theory {
    case: case::imex_mcnab2,
    kin: Kin::TwoSteps,
    divides: false,
    is_limited: false,
    forms: &[form("imex-mcnab2").limit(ALWAYS, |t, e| two_step(&Multistep::mcnab2(1.0), t, e))],
};

pub(crate) static CNLF: Theory = Theory {
    case: case::imex_cnlf,
    kin: Kin::TwoSteps,
    divides: false,
    is_limited: false,
    forms: &[form("imex-cnlf").limit(ALWAYS, |t, e| two_step(&Multistep::cnlf(), t, e))],
};
