//! What the method is, and its settings.

use drape_integrator::{
    Kind, Method, Order, Setting, SettingError, Settings, StabilityClass, Support, Treatment,
};

/// Backward Euler.
pub static BACKWARD_EULER: Method = Method {
    id: "backward-euler",
    name: "backward Euler with full Newton",
    source: "EEH (3) with k = 1, (4), (5)",
    order: Order::One,
    class: StabilityClass::Dissipative,
    theory: "conserves linear momentum; L-stable on linear problems; not energy monotone where \
             springs are compressed",
    supports: &[
        Support::new("tension", Treatment::Implicit),
        Support::new("shear", Treatment::Implicit),
        Support::new("bending", Treatment::Implicit),
        Support::new("gravity", Treatment::Explicit),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
    ],
    settings: &[
        Setting {
            key: "residual",
            kind: Kind::Number { min: 1e-16, max: 0.5 },
            default: "1e-9",
            help: "residual at which Newton stops, relative to the change of velocity that the forces would make; \
                   never below round-off",
        },
        Setting {
            key: "max_iterations",
            kind: Kind::Integer { min: 1, max: 10_000 },
            default: "100",
            help: "most Newton iterations in a step",
        },
    ],
};

/// Settings of backward Euler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackwardEulerSettings {
    /// Relative residual at which Newton's method stops.
    pub residual: f64,
    /// Most Newton iterations in a step.
    pub max_iterations: u32,
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
            residual: settings.number("residual"),
            max_iterations: settings.integer("max_iterations") as u32,
        })
    }
}
