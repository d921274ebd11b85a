//! Description and settings of the method.

use crate::tableau::Tableau;
use drape_integrator::{
    Declared, Declares, Method, NewtonLinear, Order, Quantity, Safeguard, SettingError,
    StabilityClass, StageSettings, Supports, TOLERANCE, declare, settings,
};

const RESIDUAL: Declared<f64> = declare!(
    residual: f64 off or in 1e-16..=0.5 = 0,
    "residual at which Newton stops in a stage, relative to the change of velocity that the forces \
     would make; never below round-off. 0: 1e-9, 1e-11, 1e-13 for order 2, 3, 4"
);

/// Diagonally implicit Runge–Kutta methods.
pub static DIRK: Method = Method {
    id: "dirk",
    name: "diagonally implicit Runge-Kutta, TR-BDF2 by default",
    source: "Bank et al. 1985, Hosea & Shampine 1996; Alexander 1977",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "L-stable on linear problems with every tableau; no energy theorem: sdirk4 gains where \
             stiff springs turn",
    supports: Supports::Blocks,
    refuses: &[],
    settings: DirkSettings::SETTINGS,
};

settings! {
    /// Settings of diagonally implicit Runge–Kutta methods.
    pub struct DirkSettings for DIRK, checked by without_control_of_high_order {
        /// coefficients: tr-bdf2 and sdirk2 have order 2, sdirk3 and esdirk3 order 3, sdirk4 order
        /// 4; tr-bdf2 and esdirk3 begin with an explicit stage and lose least where stiff springs
        /// turn
        tableau: Tableau [TrBdf2, Sdirk2, Sdirk3, Esdirk3, Sdirk4] = TrBdf2,
        /// residual at which Newton stops in a stage; 0: by the order
        residual: f64 as RESIDUAL,
        /// most Newton iterations in a stage
        max_iterations: u32 in 1..=10_000 = 100,
        /// whether Newton goes on after them where the stage would gain energy
        safeguard: Safeguard as Safeguard::SETTING,
        /// how Newton solves its linear systems
        linear: NewtonLinear,
        /// local error that a step may make, in mesh widths; 0: the method takes steps as given
        tolerance: f64 as TOLERANCE,
    }
}

/// The estimate of step size control knows errors of order 2 only.
fn without_control_of_high_order(settings: &DirkSettings) -> Result<(), SettingError> {
    if settings.tableau.order() != Order::Two && settings.tolerance > 0.0 {
        return Err(SettingError::Conflict {
            method: DIRK.id,
            key: TOLERANCE.setting.key,
            other: "a tableau of order 3 or 4",
            advice: "take tableau=tr-bdf2 or sdirk2, or tolerance=0",
        });
    }
    Ok(())
}

impl DirkSettings {
    /// Settings of each stage. The residual falls with the order: the coefficients of sdirk4, up to
    /// 125/16, magnify the error of a stage.
    pub(crate) fn stage(&self) -> StageSettings {
        let by_order = match self.tableau.order() {
            Order::Four => 1e-13,
            Order::Three => 1e-11,
            Order::One | Order::Two => 1e-9,
        };
        let residual = if self.residual > 0.0 { self.residual } else { by_order };
        let Self { max_iterations, safeguard, linear, .. } = *self;
        StageSettings { residual, max_iterations, safeguard, linear }
    }
}
