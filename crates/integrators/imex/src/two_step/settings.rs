//! What the four methods are, and their settings.

use super::Scheme;
use crate::settings::{
    ESTIMATOR, IMPLICIT_SPRINGS, START, SUPPORTS, SUPPORTS_WITHOUT_FRICTION, sees_splitting,
};
use drape_integrator::{
    Implicit, Kind, LinearSettings, Method, Order, Quantity, Setting, SettingError, Settings,
    StabilityClass, Start, TOLERANCE, linear_settings as linear,
};

const FORCING_TERM: Setting = Setting {
    key: "forcing_term",
    kind: Kind::Number { min: 1e-16, max: 0.5 },
    default: "1e-3",
    help: "tolerance ε of the solve, relative to the change of momentum that the forces would make in it",
};

const SETTINGS: &[Setting] = &[
    FORCING_TERM,
    linear::PRECONDITIONER,
    START,
    linear::NORM,
    linear::SOLVER,
    IMPLICIT_SPRINGS,
    linear::MATRIX,
    TOLERANCE,
    ESTIMATOR,
];

/// Those of CNLF, which starts anew at any change of the step size and so cannot choose its own.
const EQUAL_STEP_SETTINGS: &[Setting] = &[
    FORCING_TERM,
    linear::PRECONDITIONER,
    START,
    linear::NORM,
    linear::SOLVER,
    IMPLICIT_SPRINGS,
    linear::MATRIX,
];

const fn two_step(
    id: &'static str,
    name: &'static str,
    source: &'static str,
    theory: &'static str,
) -> Method {
    Method {
        id,
        name,
        source,
        order: Order::Two,
        class: StabilityClass::Dissipative,
        conserves: &[Quantity::Momentum],
        theory,
        supports: SUPPORTS,
        settings: SETTINGS,
    }
}

/// SBDF2.
pub static IMEX_SBDF2: Method = two_step(
    "imex-sbdf2",
    "IMEX BDF2 (SBDF2)",
    "EEH (7)-(9); Ascher, Ruuth and Wetton 1995",
    "slow rotation is kept to order 2, so linear theory knows no locking, but a stiff sheet lags behind; stiff modes are damped; explicit springs \
     beside stiff implicit ones are stable below a third of their stiffness",
);

/// CNAB2.
pub static IMEX_CNAB2: Method = two_step(
    "imex-cnab2",
    "IMEX Crank-Nicolson Adams-Bashforth (CNAB2)",
    "EEH (7)-(9); Ascher, Ruuth and Wetton 1995",
    "slow rotation is kept to order 2, but a stiff sheet lags behind; stiff modes ring undamped, so that any explicit stiffness beside them, even a \
     small one, makes them grow",
);

/// MCNAB2.
pub static IMEX_MCNAB2: Method = two_step(
    "imex-mcnab2",
    "modified IMEX Crank-Nicolson Adams-Bashforth (MCNAB2)",
    "EEH (7)-(9); Ascher, Ruuth and Wetton 1995",
    "slow rotation is kept to order 2, but a stiff sheet lags behind; stiff modes are damped to a third in each step; explicit springs beside stiff implicit \
     ones are stable below an eighth of their stiffness",
);

/// CNLF.
pub static IMEX_CNLF: Method = Method {
    supports: SUPPORTS_WITHOUT_FRICTION,
    settings: EQUAL_STEP_SETTINGS,
    ..two_step(
        "imex-cnlf",
        "IMEX Crank-Nicolson leapfrog (CNLF)",
        "EEH (7)-(9); Ascher, Ruuth and Wetton 1995",
        "slow rotation is kept to order 2, but so is its parasitic mode, which alternates from step to step and \
         which contacts feed until it gains energy",
    )
};

impl Scheme {
    /// What the method is.
    pub fn method(self) -> &'static Method {
        match self {
            Self::Sbdf2 => &IMEX_SBDF2,
            Self::Cnab2 => &IMEX_CNAB2,
            Self::Mcnab2 => &IMEX_MCNAB2,
            Self::Cnlf => &IMEX_CNLF,
        }
    }
}

/// Settings of a two-step method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImexTwoStepSettings {
    /// Which method.
    pub scheme: Scheme,
    /// The linear solve.
    pub linear: LinearSettings,
    /// Start value.
    pub start: Start,
    /// Which springs are implicit.
    pub implicit: Implicit,
    /// Local error that a step may make, in mesh widths; 0: steps are taken as they are given, as CNLF always does.
    pub tolerance: f64,
    /// Whether the estimate of that error counts the splitting of the force.
    pub sees_splitting: bool,
}

impl ImexTwoStepSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        scheme: Scheme,
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let method = scheme.method();
        let settings = Settings::new(method.id, method.settings, pairs)?;
        let has_control = scheme != Scheme::Cnlf;
        Ok(Self {
            scheme,
            linear: LinearSettings::read(&settings, settings.number("forcing_term")),
            start: Start::read(settings.word("start")),
            implicit: Implicit::read(settings.word("implicit")),
            tolerance: if has_control { settings.number(TOLERANCE.key) } else { 0.0 },
            sees_splitting: has_control && sees_splitting(&settings),
        })
    }
}
