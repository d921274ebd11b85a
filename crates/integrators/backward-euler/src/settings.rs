//! What the method is, and its settings.

use drape_integrator::{
    ForcingRule, Method, NewtonLinear, Order, Quantity, SettingError, Settings, StabilityClass,
    StageSettings, Support, TOLERANCE, Treatment,
};

/// Backward Euler.
pub static BACKWARD_EULER: Method = Method {
    id: "backward-euler",
    name: "backward Euler with full Newton",
    source: "EEH (3) with k = 1, (4), (5)",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "L-stable on linear problems; not energy monotone where \
             springs are compressed",
    supports: &[
        Support::new("tension", Treatment::Implicit),
        Support::new("shear", Treatment::Implicit),
        Support::new("bending", Treatment::Implicit),
        Support::new("shear_angle", Treatment::Implicit),
        Support::new("bending_angle", Treatment::Implicit),
        Support::new("bending_hinge", Treatment::Implicit),
        Support::new("gravity", Treatment::Explicit),
        Support::new("air", Treatment::Implicit),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
        Support::new("friction", Treatment::Constraint),
    ],
    settings: &[
        StageSettings::RESIDUAL,
        StageSettings::MAX_ITERATIONS,
        NewtonLinear::JACOBIAN,
        NewtonLinear::SOLVER,
        ForcingRule::FORCING,
        ForcingRule::CG_TOLERANCE,
        TOLERANCE,
    ],
};

/// Settings of backward Euler.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BackwardEulerSettings {
    /// How Newton's method solves and when it stops.
    pub stage: StageSettings,
    /// Local error that a step may make, in mesh widths; 0: steps are taken as they are given.
    pub tolerance: f64,
}

impl BackwardEulerSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(BACKWARD_EULER.id, BACKWARD_EULER.settings, pairs)?;
        Ok(Self {
            stage: StageSettings::read(&settings),
            tolerance: settings.number(TOLERANCE.key),
        })
    }
}
