//! What the two families are, and their settings.

use crate::coefficients::MAX_STEPS;
use drape_integrator::{
    ForcingRule, Kind, Method, NewtonLinear, Order, Quantity, Setting, SettingError, Settings,
    StabilityClass, StageSettings, Support, TOLERANCE, Treatment,
};
use std::ops::RangeInclusive;

const fn supports(springs: Treatment) -> [Support; 11] {
    [
        Support::new("tension", springs),
        Support::new("shear", springs),
        Support::new("bending", springs),
        Support::new("shear_angle", springs),
        Support::new("bending_angle", springs),
        Support::new("bending_hinge", springs),
        Support::new("gravity", Treatment::Explicit),
        Support::new("air", springs),
        Support::new("pins", Treatment::Constraint),
        Support::new("contact", Treatment::Constraint),
        Support::new("friction", Treatment::Constraint),
    ]
}

const fn steps(help: &'static str) -> Setting {
    Setting {
        key: "steps",
        kind: Kind::Integer { min: 1, max: MAX_STEPS as u64 },
        default: "2",
        help,
    }
}

/// Adams–Bashforth, of two steps unless the settings say otherwise.
pub static ADAMS_BASHFORTH2: Method = Method {
    id: "adams-bashforth2",
    name: "two-step Adams-Bashforth",
    source: "EEH (2)",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "two steps: unstable without damping at every step size, by (hω)⁴/4 a step; three steps: \
             stable for hω < 0.72 without damping; both only for small h²k/m and hd/m",
    supports: &supports(Treatment::Explicit),
    settings: &[steps("number k of steps, which is the order; 1 is explicit Euler")],
};

/// Backward differentiation, of two steps unless the settings say otherwise.
pub static BDF2: Method = Method {
    id: "bdf2",
    name: "two-step BDF",
    source: "EEH (3), (4), (5)",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "two steps: L-stable on linear problems, no energy theorem; three steps: gains up to 4.6 % \
             a step where an undamped spring has hω < 1.94",
    supports: &supports(Treatment::Implicit),
    settings: &[
        steps("number k of steps, which is the order; 1 is backward Euler"),
        StageSettings::RESIDUAL,
        StageSettings::MAX_ITERATIONS,
        NewtonLinear::JACOBIAN,
        NewtonLinear::SOLVER,
        ForcingRule::FORCING,
        ForcingRule::CG_TOLERANCE,
        TOLERANCE,
    ],
};

/// Ratios of neighbouring steps that Adams–Bashforth bridges. Its sums of old slopes are stable at any ratio
/// ("zero-stable"); what limits it is accuracy: at a growth by 2 the weights are `(−1, 2)`.
pub(crate) const ADAMS_RATIOS: RangeInclusive<f64> = 0.5..=2.0;

/// Number `k` of steps of a method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Steps {
    /// The Euler methods.
    One,
    /// What the ids say.
    #[default]
    Two,
    /// The highest order here.
    Three,
}

impl Steps {
    fn read(settings: &Settings) -> Self {
        match settings.integer("steps") {
            1 => Self::One,
            3 => Self::Three,
            _ => Self::Two,
        }
    }

    /// `k`.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Three => 3,
        }
    }
}

/// Settings of Adams–Bashforth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdamsBashforthSettings {
    /// Number of steps.
    pub steps: Steps,
}

impl AdamsBashforthSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(ADAMS_BASHFORTH2.id, ADAMS_BASHFORTH2.settings, pairs)?;
        Ok(Self { steps: Steps::read(&settings) })
    }
}

/// Settings of BDF.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BdfSettings {
    /// Number of steps.
    pub steps: Steps,
    /// How Newton's method solves and when it stops.
    pub stage: StageSettings,
    /// Local error that a step may make, in mesh widths; 0: steps are taken as they are given.
    pub tolerance: f64,
}

impl BdfSettings {
    /// Reads `key=value` pairs.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value that does not fit, and for a tolerance with three steps, whose
    /// step sizes may not vary as much as the control asks for.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SettingError> {
        let settings = Settings::new(BDF2.id, BDF2.settings, pairs)?;
        let (steps, tolerance) = (Steps::read(&settings), settings.number(TOLERANCE.key));
        if steps == Steps::Three && tolerance > 0.0 {
            return Err(SettingError::Conflict {
                method: BDF2.id,
                key: TOLERANCE.key,
                other: "steps=3",
                advice: "take steps=1 or 2, or tolerance=0",
            });
        }
        Ok(Self { steps, stage: StageSettings::read(&settings), tolerance })
    }

    /// Ratios of neighbouring steps that the method bridges. Errors of the past die out while every ratio is below
    /// `1 + √2` for two steps (Grigorieff 1983); for three steps a steady growth is unstable from the golden
    /// ratio 1.618 on (a test finds nothing worse), and smaller bounds are proven (Calvo, Grande and Grigorieff
    /// 1990).
    pub(crate) fn ratios(&self) -> RangeInclusive<f64> {
        let most = if self.steps == Steps::Three { 1.5 } else { 2.0 };
        0.5..=most
    }
}
