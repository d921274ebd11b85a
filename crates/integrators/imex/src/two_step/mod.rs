//! The two-step methods of order 2, which share one formula.

mod coefficients;
mod old_level;
mod settings;
mod split_forces;
mod step;
mod workspace;

pub use coefficients::{Coefficients, TwoStep};
pub use settings::{
    IMEX_CNAB2, IMEX_CNLF, IMEX_MCNAB2, IMEX_SBDF2, ImexTwoStepSettings, TwoStepValues,
};
pub use step::{CNAB2, CNLF, ImexTwoStep, MCNAB2, SBDF2};

#[cfg(test)]
mod tests;
