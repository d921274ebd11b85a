//! Description and settings.

use drape_integrator::{
    Declares, Method, Order, Quantity, StabilityClass, Supports, Word, settings,
};
use drape_model::{Effect, EffectKind};

/// The impulse method.
pub static MULTIRATE: Method = Method {
    id: "multirate",
    name: "multirate impulse method (r-RESPA)",
    source: "Tuckerman, Berne and Martyna 1992; Grubmüller et al. 1991",
    order: Order::Two,
    class: StabilityClass::Symplectic,
    conserves: &[Quantity::Momentum, Quantity::AngularMomentum],
    theory: "within the limits h²λ < 4 of the fast and H²λ < 4 of the slow forces, but unstable \
             where \
             H is a little less than half a period of a fast mode: safe for H ≤ π/(2√λ)",
    supports: Supports::Explicit,
    refuses: &[],
    settings: MultirateSettings::SETTINGS,
};

/// Which forces are slow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slow {
    /// All springs and angles but the tension springs.
    ButTension,
    /// What resists bending: springs, angles and hinges.
    Bending,
    /// Angles and hinges.
    Angles,
}

impl Word for Slow {
    const WORDS: &'static [(&'static str, Self)] =
        &[("but-tension", Self::ButTension), ("bending", Self::Bending), ("angles", Self::Angles)];
}

/// Kinds of effects, and whether these settings take them as slow.
const TABLE: [(EffectKind, [bool; 3]); 5] = [
    (EffectKind::Shear, [true, false, false]),
    (EffectKind::Bending, [true, true, false]),
    (EffectKind::ShearAngle, [true, false, true]),
    (EffectKind::BendingAngle, [true, true, true]),
    (EffectKind::BendingHinge, [true, true, true]),
];

fn is_slow(effect: &dyn Effect, column: usize) -> bool {
    TABLE.iter().any(|(kind, slow)| *kind == effect.kind() && slow[column])
}

impl Slow {
    /// Whether an effect is slow, and whether it is fast.
    pub(crate) fn selects(self) -> [fn(&dyn Effect) -> bool; 2] {
        match self {
            Self::ButTension => [|e| is_slow(e, 0), |e| !is_slow(e, 0)],
            Self::Bending => [|e| is_slow(e, 1), |e| !is_slow(e, 1)],
            Self::Angles => [|e| is_slow(e, 2), |e| !is_slow(e, 2)],
        }
    }
}

settings! {
    /// Settings of the method.
    pub struct MultirateSettings for MULTIRATE {
        /// short steps, by the fast forces, in a step
        ratio: u32 in 1..=64 = 3,
        /// slow forces: all but those of the tension springs, those of bending, or those of angles
        slow: Slow [ButTension, Bending, Angles] = ButTension,
    }
}
