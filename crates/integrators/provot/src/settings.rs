//! What the method is, and its settings.

use drape_integrator::{
    Kind, Method, Order, Quantity, Setting, SettingError, Settings, StabilityClass, Support,
    SweepOrder, Treatment,
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
        Support::new("gravity", Treatment::Explicit),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
    ],
    settings: &[
        Setting {
            key: "limit",
            kind: Kind::Number { min: 1e-4, max: 10.0 },
            default: "0.1",
            help: "greatest elongation of a tension or shear spring over its rest length",
        },
        Setting {
            key: "sweeps",
            kind: Kind::Integer { min: 1, max: 1000 },
            default: "1",
            help: "most sweeps over the springs in a step; it ends early when no spring is too long",
        },
        Setting {
            key: "order",
            kind: Kind::Choice(SweepOrder::WORDS),
            default: "forward",
            help: "in which order a sweep visits the springs; alternating: every second sweep of a step backward",
        },
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProvotSettings {
    /// Greatest elongation over the rest length.
    pub limit: f64,
    /// Most sweeps in a step.
    pub sweeps: usize,
    /// Order of a sweep.
    pub order: SweepOrder,
    /// Whether velocities are corrected too.
    pub velocity: VelocityUpdate,
}

impl Default for ProvotSettings {
    fn default() -> Self {
        Self {
            limit: 0.1,
            sweeps: 1,
            order: SweepOrder::Forward,
            velocity: VelocityUpdate::Corrected,
        }
    }
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
        Ok(Self {
            limit: settings.number("limit"),
            sweeps: settings.integer("sweeps"),
            order: SweepOrder::read(settings.word("order")),
            velocity,
        })
    }
}
