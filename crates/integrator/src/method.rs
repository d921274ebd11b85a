//! What a method is, and what it supports.

use crate::{PrepareError, Setting, Settings};
use drape_model::{Effect, EffectKind, Obstacle, System};

/// Order of accuracy in the step size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Global error `O(h)`.
    One,
    /// Global error `O(h²)`.
    Two,
}

/// Which stability verdict a method is held to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StabilityClass {
    /// The total energy of a closed scene must not rise.
    Dissipative,
    /// The total energy of an undamped scene may oscillate but not drift.
    Symplectic,
}

/// What a method keeps exactly, up to round-off and the tolerance of its solve, on an undamped system of springs
/// without pins, contacts and external forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// `Σ m v`.
    Momentum,
    /// `Σ m x × v`.
    AngularMomentum,
}

impl Quantity {
    /// Its name in prose.
    pub fn name(self) -> &'static str {
        match self {
            Self::Momentum => "momentum",
            Self::AngularMomentum => "angular momentum",
        }
    }
}

/// How a method integrates an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// At the new time level.
    Implicit,
    /// At the old time level.
    Explicit,
    /// Implicit or explicit, by the setting `implicit`.
    BySetting,
    /// By a linear constraint on the new velocity.
    Constraint,
}

impl Treatment {
    /// One word for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Implicit => "implicit",
            Self::Explicit => "explicit",
            Self::BySetting => "by setting",
            Self::Constraint => "constraint",
        }
    }
}

/// One thing that a method supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Support {
    /// Name of the effect, or `pins`, `contact` or `friction`.
    pub effect: &'static str,
    /// How it is treated.
    pub treatment: Treatment,
}

impl Support {
    /// An effect and how it is treated.
    pub const fn new(effect: &'static str, treatment: Treatment) -> Self {
        Self { effect, treatment }
    }
}

/// Description of a time integrator.
#[derive(Debug, PartialEq)]
pub struct Method {
    /// Id on the command line.
    pub id: &'static str,
    /// Name in prose.
    pub name: &'static str,
    /// Where it was published.
    pub source: &'static str,
    /// Order of accuracy.
    pub order: Order,
    /// Which verdict it is held to.
    pub class: StabilityClass,
    /// What it conserves exactly.
    pub conserves: &'static [Quantity],
    /// What its theory says about stability, in a sentence or two.
    pub theory: &'static str,
    /// What it supports; everything else is refused by name.
    pub supports: &'static [Support],
    /// Its settings with ranges and defaults.
    pub settings: &'static [Setting],
}

impl Method {
    /// Whether the method, set like that, takes an effect at the old time level.
    pub fn is_explicit(&self, effect: &dyn Effect, settings: &Settings) -> bool {
        let treatment = self.supports.iter().find(|support| support.effect == effect.name());
        treatment.is_some_and(|support| match support.treatment {
            Treatment::Explicit => true,
            Treatment::BySetting => {
                settings.iter().any(|setting| setting == ("implicit", "tension"))
            }
            Treatment::Implicit | Treatment::Constraint => false,
        })
    }

    /// Refuses a system that names something which the method cannot honour.
    ///
    /// # Errors
    /// [`PrepareError::Unsupported`] with the first such effect or constraint.
    pub fn check(&self, system: &System) -> Result<(), PrepareError> {
        // Every method takes an effect from outside the library by what it offers.
        let is_known = |effect: &&dyn Effect| !matches!(effect.kind(), EffectKind::Own(_));
        let named = system.effects().filter(is_known).map(|effect| effect.name());
        let pins = system.pinned().contains(&true).then_some("pins");
        let contact = (!system.obstacles().is_empty()).then_some("contact");
        let friction = rough_obstacle(system).map(|_| "friction");
        for what in named.chain(pins).chain(contact).chain(friction) {
            if !self.supports.iter().any(|support| support.effect == what) {
                let (what, key) = (what.to_owned(), key_of(system, what));
                return Err(PrepareError::Unsupported { method: self.id, what, key });
            }
        }
        Ok(())
    }
}

/// The first obstacle with friction, and its place in the list.
fn rough_obstacle(system: &System) -> Option<(usize, &Obstacle)> {
    system.obstacles().iter().enumerate().find(|(_, obstacle)| obstacle.friction > 0.0)
}

/// Path of the key by which a scene names something.
fn key_of(system: &System, what: &str) -> String {
    match (what, rough_obstacle(system)) {
        ("pins", _) => "pins".to_owned(),
        ("contact", _) => "obstacles".to_owned(),
        ("friction", Some((place, obstacle))) => {
            format!("obstacles[{place}].{}.friction", obstacle.shape.name())
        }
        _ => format!("effects.{what}"),
    }
}
