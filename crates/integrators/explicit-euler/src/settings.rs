//! What the two methods are, and their settings.

use drape_integrator::{
    Kind, Method, Order, Quantity, Setting, SettingError, Settings, StabilityClass, Support,
    Treatment,
};

const SUPPORTS: &[Support] = &[
    Support::new("tension", Treatment::Explicit),
    Support::new("shear", Treatment::Explicit),
    Support::new("bending", Treatment::Explicit),
    Support::new("gravity", Treatment::Explicit),
    Support::new("pins", Treatment::Constraint),
    Support::new("contact", Treatment::Constraint),
];

/// Explicit Euler.
pub static EXPLICIT_EULER: Method = Method {
    id: "explicit-euler",
    name: "explicit Euler",
    source: "EEH (2) with k = 1",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "stable only if h²k/m ≤ hd/m, so never without damping",
    supports: SUPPORTS,
    settings: &[],
};

/// Symplectic Euler.
pub static SYMPLECTIC_EULER: Method = Method {
    id: "symplectic-euler",
    name: "symplectic Euler",
    source: "the explicit part of Provot 1995",
    order: Order::One,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "its energy stays close to the true one; stable if h²λ + 2hδ < 4",
    supports: SUPPORTS,
    settings: &[Setting {
        key: "damping",
        kind: Kind::Choice(&["explicit", "implicit"]),
        default: "explicit",
        help: "whether the springs' damping is taken at the old or the new velocity",
    }],
};

/// Where symplectic Euler takes the damping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DampingTreatment {
    /// At `v_n`.
    #[default]
    Explicit,
    /// At `v_{n+1}`: one sparse solve a step.
    Implicit,
}

/// Settings of symplectic Euler.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SymplecticSettings {
    /// Where the damping is taken.
    pub damping: DampingTreatment,
}

impl SymplecticSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(SYMPLECTIC_EULER.id, SYMPLECTIC_EULER.settings, pairs)?;
        let damping = match settings.word("damping") {
            "implicit" => DampingTreatment::Implicit,
            _ => DampingTreatment::Explicit,
        };
        Ok(Self { damping })
    }
}
