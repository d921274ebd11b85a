//! What the method is, and its settings.

use drape_integrator::{
    Kind, Method, Order, Quantity, Setting, SettingError, Settings, StabilityClass, Support,
    Treatment,
};

/// Terzopoulos and Fleischer's semi-implicit step.
pub static TERZOPOULOS_FLEISCHER: Method = Method {
    id: "terzopoulos-fleischer",
    name: "Terzopoulos-Fleischer, lagged secant stiffness",
    source: "Terzopoulos, Platt, Barr, Fleischer 1987; Terzopoulos, Fleischer 1988; EEH section 3",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "stable for every step on springs of rest length 0; near its rest length a spring resists only a step \
             after it was stretched, so that energy may rise; with clamp=true no order is claimed",
    supports: &[
        Support::new("tension", Treatment::Implicit),
        Support::new("shear", Treatment::Implicit),
        Support::new("bending", Treatment::Implicit),
        Support::new("shear_angle", Treatment::Explicit),
        Support::new("bending_angle", Treatment::Explicit),
        Support::new("bending_hinge", Treatment::Explicit),
        Support::new("gravity", Treatment::Explicit),
        Support::new("air", Treatment::Explicit),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
        Support::new("friction", Treatment::Constraint),
    ],
    settings: &[Setting {
        key: "clamp",
        kind: Kind::Choice(&["false", "true"]),
        default: "false",
        help: "raise the negative secant stiffness of compressed springs to 0, so that the matrix stays positive \
               definite: another equation, of which no order is claimed",
    }],
};

/// Settings of the semi-implicit step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TerzopoulosFleischerSettings {
    /// Whether negative secant stiffnesses are raised to 0.
    pub clamp: bool,
}

impl TerzopoulosFleischerSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let method = &TERZOPOULOS_FLEISCHER;
        let settings = Settings::new(method.id, method.settings, pairs)?;
        Ok(Self { clamp: settings.word("clamp") == "true" })
    }
}
