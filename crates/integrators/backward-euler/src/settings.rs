//! What the method is, and its settings.

use drape_integrator::{
    Method, Order, Quantity, SettingError, Settings, StabilityClass, StageSettings, Support,
    Treatment,
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
        Support::new("gravity", Treatment::Explicit),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
    ],
    settings: &[StageSettings::RESIDUAL, StageSettings::MAX_ITERATIONS],
};

/// Settings of backward Euler.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BackwardEulerSettings {
    /// When Newton's method stops.
    pub stage: StageSettings,
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
        Ok(Self { stage: StageSettings::read(&settings) })
    }
}
