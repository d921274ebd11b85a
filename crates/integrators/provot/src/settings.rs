//! What the method is, and its settings.

use drape_integrator::{
    ElongationSettings, Kind, Method, Order, Quantity, Setting, SettingError, Settings,
    StabilityClass, Support, Treatment,
};

/// Provot's method.
pub static PROVOT: Method = Method {
    id: "provot",
    name: "symplectic Euler with a limit on elongation",
    source: "Provot 1995",
    order: Order::One,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "as symplectic Euler, stable if h²λ + 2hδ < 4, while no spring is longer than its limit; \
             shortening one solves no differential equation and conserves neither energy nor angular momentum",
    supports: &[
        Support::new("tension", Treatment::Explicit),
        Support::new("shear", Treatment::Explicit),
        Support::new("bending", Treatment::Explicit),
        Support::new("shear_angle", Treatment::Explicit),
        Support::new("bending_angle", Treatment::Explicit),
        Support::new("bending_hinge", Treatment::Explicit),
        Support::new("gravity", Treatment::Explicit),
        Support::new("air", Treatment::Explicit),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
        Support::new("friction", Treatment::Constraint),
    ],
    settings: &[
        ElongationSettings::LIMIT,
        ElongationSettings::SWEEPS,
        ElongationSettings::ORDER,
        Setting {
            key: "velocity",
            kind: Kind::Choice(&["corrected", "positions-only"]),
            default: "corrected",
            help: "whether what moves a position also changes the velocity, by the displacement over the step size",
        },
    ],
};

/// Whether the correction of positions changes the velocities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VelocityUpdate {
    /// `v_{n+1} = (x_{n+1} − x_n)/h`.
    #[default]
    Corrected,
    /// It does not: the springs that were too long go on stretching.
    PositionsOnly,
}

/// Settings of Provot's method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProvotSettings {
    /// The limit on elongation.
    pub elongation: ElongationSettings,
    /// Whether velocities are corrected too.
    pub velocity: VelocityUpdate,
}

impl ProvotSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(PROVOT.id, PROVOT.settings, pairs)?;
        let velocity = match settings.word("velocity") {
            "positions-only" => VelocityUpdate::PositionsOnly,
            _ => VelocityUpdate::Corrected,
        };
        Ok(Self { elongation: ElongationSettings::read(&settings), velocity })
    }
}
