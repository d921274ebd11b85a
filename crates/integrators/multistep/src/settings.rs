//! What the two families are, and their settings.

use crate::coefficients::MAX_STEPS;
use drape_integrator::{
    Declared, Declares, Kind, Method, Order, Quantity, Setting, SettingError, StabilityClass,
    StageSettings, Supports, TOLERANCE, Value, settings,
};
use std::ops::RangeInclusive;

const fn steps(help: &'static str) -> Declared<Steps> {
    let kind = Kind::Integer { min: 1, max: MAX_STEPS as u64 };
    Declared { setting: Setting { key: "steps", kind, default: "2", help }, default: Steps::Two }
}

const ADAMS_STEPS: Declared<Steps> =
    steps("number k of steps, which is the order; 1 is explicit Euler");
const BDF_STEPS: Declared<Steps> =
    steps("number k of steps, which is the order; 1 is backward Euler");

/// Adams–Bashforth, of two steps unless the settings say otherwise.
pub static ADAMS_BASHFORTH2: Method = Method {
    id: "adams-bashforth2",
    name: "two-step Adams-Bashforth",
    source: "EEH (2)",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "two steps: unstable without damping at every step size, by (hω)⁴/4 a step; three \
             steps: stable for hω < 0.72 without damping; both only for small h²k/m and hd/m",
    supports: Supports::Explicit,
    refuses: &[],
    settings: AdamsBashforthSettings::SETTINGS,
};

/// Backward differentiation, of two steps unless the settings say otherwise.
pub static BDF2: Method = Method {
    id: "bdf2",
    name: "two-step BDF",
    source: "EEH (3), (4), (5)",
    order: Order::Two,
    class: StabilityClass::Dissipative,
    conserves: &[Quantity::Momentum],
    theory: "two steps: L-stable on linear problems, no energy theorem; three steps: gains up to \
             4.6 % a step where an undamped spring has hω < 1.94",
    supports: Supports::Blocks,
    refuses: &[],
    settings: BdfSettings::SETTINGS,
};

/// Ratios of neighbouring steps that Adams–Bashforth bridges. It is zero-stable at any ratio;
/// accuracy sets the limit: at a growth by 2 the weights are `(−1, 2)`.
pub(crate) const ADAMS_RATIOS: RangeInclusive<f64> = 0.5..=2.0;

/// Number `k` of steps of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steps {
    /// The Euler methods.
    One,
    /// The default, which the ids name.
    Two,
    /// The highest order here.
    Three,
}

impl Value for Steps {
    fn read(text: &str) -> Option<Self> {
        let k: usize = text.parse().ok()?;
        [Self::One, Self::Two, Self::Three].into_iter().find(|steps| steps.count() == k)
    }
}

impl Steps {
    /// `k`.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Three => 3,
        }
    }
}

settings! {
    /// Settings of Adams–Bashforth.
    pub struct AdamsBashforthSettings for ADAMS_BASHFORTH2 {
        /// number of steps
        steps: Steps as ADAMS_STEPS,
    }
}

settings! {
    /// Settings of BDF.
    pub struct BdfSettings for BDF2, checked by without_control_of_three {
        /// number of steps
        steps: Steps as BDF_STEPS,
        /// how Newton's method solves and when it stops
        stage: StageSettings,
        /// local error that a step may make, in mesh widths; 0: the method takes steps as given
        tolerance: f64 as TOLERANCE,
    }
}

/// Step size control varies steps by more than the three-step method allows.
fn without_control_of_three(settings: &BdfSettings) -> Result<(), SettingError> {
    if settings.steps == Steps::Three && settings.tolerance > 0.0 {
        return Err(SettingError::Conflict {
            method: BDF2.id,
            key: TOLERANCE.setting.key,
            other: "steps=3",
            advice: "take steps=1 or 2, or tolerance=0",
        });
    }
    Ok(())
}

impl BdfSettings {
    /// Ratios of neighbouring steps that the method bridges. With two steps, past errors die out
    /// while every ratio is below `1 + √2` (Grigorieff 1983). With three steps, steady growth is
    /// unstable from the golden ratio 1.618 on; a test finds nothing worse, and smaller bounds are
    /// proven (Calvo, Grande and Grigorieff 1990).
    pub(crate) fn ratios(&self) -> RangeInclusive<f64> {
        let most = if self.steps == Steps::Three { 1.5 } else { 2.0 };
        0.5..=most
    }
}
