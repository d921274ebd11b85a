//! Description and settings of the four methods.

use super::TwoStep;
use crate::settings::{ESTIMATOR, Estimator, IMPLICIT_SPRINGS, START};
use drape_integrator::linear_settings::{MATRIX, MatrixUse, NORM, PRECONDITIONER, SOLVER};
use drape_integrator::{
    Declares, Implicit, LinearSettings, Method, Order, PreconditionerKind, Quantity, Setting,
    SettingError, Settings, SolverKind, StabilityClass, Start, StopNorm, Supports, TOLERANCE,
    settings,
};
use std::ops::Deref;

settings! {
    /// The settings that the four methods share.
    pub struct TwoStepValues {
        /// relative tolerance ε of the solve
        forcing_term: f64 in 1e-16..=0.5 = 1e-3,
        /// preconditioner of the conjugate gradients
        preconditioner: PreconditionerKind as PRECONDITIONER,
        /// start value of the solve
        start: Start as START,
        /// what the residual of the solve is measured against
        norm: StopNorm as NORM,
        /// solver
        solver: SolverKind as SOLVER,
        /// which springs are implicit
        implicit: Implicit as IMPLICIT_SPRINGS,
        /// how long the matrix is kept
        matrix: MatrixUse as MATRIX,
        /// local error that a step may make, in mesh widths; 0: the method takes steps as given, as
        /// CNLF always does
        tolerance: f64 as TOLERANCE,
        /// how that error is estimated
        estimator: Estimator as ESTIMATOR,
    }
}

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
        supports: Supports::ScalarMatrix,
        refuses: &[],
        settings: TwoStepValues::SETTINGS,
    }
}

/// SBDF2.
pub static IMEX_SBDF2: Method = two_step(
    "imex-sbdf2",
    "IMEX BDF2 (SBDF2)",
    "EEH (7)-(9); Ascher, Ruuth and Wetton 1995",
    "slow rotation is kept to order 2, so linear theory knows no locking, but a stiff sheet lags \
     behind; stiff modes are damped; explicit springs beside stiff implicit ones are stable below \
     a third of their stiffness",
);

/// CNAB2.
pub static IMEX_CNAB2: Method = two_step(
    "imex-cnab2",
    "IMEX Crank-Nicolson Adams-Bashforth (CNAB2)",
    "EEH (7)-(9); Ascher, Ruuth and Wetton 1995",
    "slow rotation is kept to order 2, but a stiff sheet lags behind; stiff modes ring undamped, \
     so any explicit stiffness beside them, even a small one, makes them grow",
);

/// MCNAB2.
pub static IMEX_MCNAB2: Method = two_step(
    "imex-mcnab2",
    "modified IMEX Crank-Nicolson Adams-Bashforth (MCNAB2)",
    "EEH (7)-(9); Ascher, Ruuth and Wetton 1995",
    "slow rotation is kept to order 2, but a stiff sheet lags behind; stiff modes are damped to a \
     third in each step; explicit springs beside stiff implicit ones are stable below an eighth of \
     their stiffness",
);

/// The settings of CNLF. It starts anew at any change of the step size, so step size control is
/// left out.
const EQUAL_STEP_SETTINGS: &[Setting] = match TwoStepValues::SETTINGS {
    [others @ .., _tolerance, _estimator] => others,
    _ => &[],
};

/// CNLF.
///
/// It refuses friction: a particle that friction stops would alternate between two positions for
/// ever. Its difference formula joins every other level,
/// `x_{n+1} = x_{n−1} + h (v_{n+1} + v_{n−1})`, so `x_{n+1} = x_{n−1}` once the velocities are 0.
pub static IMEX_CNLF: Method = Method {
    refuses: &["friction"],
    settings: EQUAL_STEP_SETTINGS,
    ..two_step(
        "imex-cnlf",
        "IMEX Crank-Nicolson leapfrog (CNLF)",
        "EEH (7)-(9); Ascher, Ruuth and Wetton 1995",
        "slow rotation is kept to order 2, but so is a parasitic mode that alternates from step to \
         step, and contacts feed it until it gains energy",
    )
};

impl TwoStep {
    /// Description of the method.
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
    pub scheme: TwoStep,
    /// Its settings.
    pub values: TwoStepValues,
}

impl Deref for ImexTwoStepSettings {
    type Target = TwoStepValues;

    fn deref(&self) -> &TwoStepValues {
        &self.values
    }
}

impl ImexTwoStepSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        scheme: TwoStep,
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let method = scheme.method();
        Ok(Self::of(scheme, &Settings::new(method.id, method.settings, pairs)?))
    }

    /// Reads checked settings. Settings that the method does not have keep their defaults.
    pub(crate) fn of(scheme: TwoStep, settings: &Settings) -> Self {
        Self { scheme, values: TwoStepValues::read(settings) }
    }

    /// The linear solve.
    pub fn linear(&self) -> LinearSettings {
        let TwoStepValues { forcing_term, preconditioner, norm, solver, matrix, .. } = self.values;
        LinearSettings::of(forcing_term, preconditioner, norm, solver, matrix)
    }

    /// Whether step size control asks for the splitting error.
    pub(crate) fn sees_splitting(&self) -> bool {
        self.tolerance > 0.0 && self.estimator == Estimator::Splitting
    }
}
