//! What the method is, and its settings.

use drape_integrator::{
    Kind, Method, Order, Setting, SettingError, Settings, StabilityClass, Support, Treatment,
};

/// Kang's neighbour-corrected sweep.
pub static KANG: Method = Method {
    id: "kang",
    name: "Kang's neighbour-corrected sweep",
    source: "Kang, Choi, Cho 2000; EEH section 3",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[],
    theory: "two Jacobi sweeps in place of the solve of IMEX Euler: stable on springs of rest length 0, \
             energy may rise on others; smooth stretching is hardly resisted, a stiff sheet sags like rubber; \
             momentum is kept only where all particles have equal masses and springs",
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
        key: "sweeps",
        kind: Kind::Integer { min: 1, max: 64 },
        default: "1",
        help: "corrections by the neighbours in a step: 1 is the published formula, more approach IMEX Euler; an even \
               number overshoots the roughest shapes",
    }],
};

/// Settings of Kang's method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KangSettings {
    /// Corrections by the neighbours, at least 1.
    pub sweeps: u32,
}

impl KangSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(KANG.id, KANG.settings, pairs)?;
        Ok(Self { sweeps: settings.integer("sweeps") as u32 })
    }
}
