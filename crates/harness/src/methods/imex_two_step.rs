//! IMEX methods of two steps.

use super::Entry;
use super::runs::{Keeps, Runs, Steps, Variant, work};
use crate::need::Matrix;
use crate::theory::{
    ALWAYS, Expectation, Factors, Linear, PUSHING, Problem, TURNING, Theory, form, implicit,
    no_theorem, stable, unstable,
};
use drape_oracle::recurrence::Multistep;
use drape_report::family::Kin;

/// `imex-sbdf2`.
pub(super) static SBDF2: Entry = Entry {
    registration: &drape_imex::SBDF2,
    theory: Theory {
        case: sbdf2,
        kin: Kin::TwoSteps,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[form("imex-sbdf2").limit(ALWAYS, |t, e| radius(&Multistep::sbdf2(1.0), t, e))],
    },
    runs: Runs {
        order: &[Variant::new("imex-sbdf2", "imex-sbdf2:forcing_term=1e-12")],
        momentum: &[(Variant::new("imex-sbdf2", "imex-sbdf2:forcing_term=1e-12"), Keeps::AsStated)],
        locking: &[(Variant::new("imex-sbdf2", "imex-sbdf2:forcing_term=1e-8"), Steps::All)],
        work_precision: &[
            work::main("imex-sbdf2", "imex-sbdf2"),
            work::extra("imex-sbdf2, Cholesky", "imex-sbdf2:solver=cholesky"),
            work::adaptive("imex-sbdf2, adaptive", "imex-sbdf2"),
        ],
        ..Runs::DEFAULTS
    },
};

/// `a` = (3/2, −2, 1/2), `b` = (1, 0, 0), `c` = (2, −1).
fn sbdf2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(4.0, 1.0, -3.0))
}

/// `imex-cnab2`.
pub(super) static CNAB2: Entry = Entry {
    registration: &drape_imex::CNAB2,
    theory: Theory {
        case: cnab2,
        kin: Kin::TwoSteps,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[form("imex-cnab2").limit(ALWAYS, |t, e| radius(&Multistep::cnab2(1.0), t, e))],
    },
    runs: Runs {
        order: &[Variant::new("imex-cnab2", "imex-cnab2:forcing_term=1e-12")],
        momentum: &[(Variant::new("imex-cnab2", "imex-cnab2:forcing_term=1e-12"), Keeps::AsStated)],
        locking: &[(Variant::new("imex-cnab2", "imex-cnab2:forcing_term=1e-8"), Steps::All)],
        ..Runs::DEFAULTS
    },
};

/// `a` = (1, −1, 0), `b` = (1/2, 1/2, 0), `c` = (3/2, −1/2).
fn cnab2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(2.0, 0.0, -2.0))
}

/// `imex-mcnab2`.
pub(super) static MCNAB2: Entry = Entry {
    registration: &drape_imex::MCNAB2,
    theory: Theory {
        case: mcnab2,
        kin: Kin::TwoSteps,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[form("imex-mcnab2").limit(ALWAYS, |t, e| radius(&Multistep::mcnab2(1.0), t, e))],
    },
    runs: Runs {
        order: &[Variant::new("imex-mcnab2", "imex-mcnab2:forcing_term=1e-12")],
        momentum: &[(
            Variant::new("imex-mcnab2", "imex-mcnab2:forcing_term=1e-12"),
            Keeps::AsStated,
        )],
        locking: &[(Variant::new("imex-mcnab2", "imex-mcnab2:forcing_term=1e-8"), Steps::All)],
        ..Runs::DEFAULTS
    },
};

/// `a` = (1, −1, 0), `b` = (9/16, 3/8, 1/16), `c` = (3/2, −1/2).
fn mcnab2(problem: &Problem<'_>) -> Expectation {
    two_step(problem, &Factors::two_step(2.0, 0.25, -2.0))
}

/// `imex-cnlf`.
pub(super) static CNLF: Entry = Entry {
    registration: &drape_imex::CNLF,
    theory: Theory {
        case: cnlf,
        kin: Kin::TwoSteps,
        matrix: |settings| Matrix::ScalarFactor.if_set(settings, "solver", "cholesky"),
        divides: false,
        is_limited: false,
        forms: &[form("imex-cnlf").limit(ALWAYS, |t, e| radius(&Multistep::cnlf(), t, e))],
    },
    runs: Runs {
        order: &[Variant::new("imex-cnlf", "imex-cnlf:forcing_term=1e-12")],
        momentum: &[(Variant::new("imex-cnlf", "imex-cnlf:forcing_term=1e-12"), Keeps::AsStated)],
        locking: &[(Variant::new("imex-cnlf", "imex-cnlf:forcing_term=1e-8"), Steps::All)],
        ..Runs::DEFAULTS
    },
};

/// `a` = (1/2, 0, −1/2), `b` = (1/2, 0, 1/2), `c` = (1, 0). About an equilibrium roots may lie on
/// the unit circle.
fn cnlf(problem: &Problem<'_>) -> Expectation {
    two_step(&Problem { is_at_rest: false, ..*problem }, &Factors::two_step(0.0, 1.0, -1.0))
}

fn two_step(problem: &Problem<'_>, factors: &Factors) -> Expectation {
    let implicit = implicit(problem);
    let is_explicit_beside = !problem.are_all(implicit);
    let is_steady = problem.schedule.pattern.is_empty();
    if problem.has_contacts() {
        no_theorem(PUSHING)
    } else if is_explicit_beside
        && is_steady
        && problem.analyse(Some(implicit), factors) == Linear::Nowhere
    {
        unstable("a root of the characteristic polynomial is below −1 for some mode at the start")
    } else if problem.is_at_rest {
        stable(
            "an equilibrium is a fixed point; small motions about it have θ_E between −θ_I and 0, \
             where no root of \
             the characteristic polynomial is outside the unit circle",
        )
    } else {
        no_theorem(format!(
            "on the linear test equation no root is outside the unit circle for springs that are \
             not compressed; {TURNING}"
        ))
    }
}

fn radius(method: &Multistep, theta: f64, eta: f64) -> f64 {
    method.recurrence(theta, 0.0, eta).spectral_radius()
}
