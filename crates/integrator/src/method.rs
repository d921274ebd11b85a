//! Description of a method, and the effects that it supports.

use crate::{PrepareError, Setting, Settings};
use drape_model::{Effect, EffectClass, EffectKind, Obstacle, System};

/// Order of accuracy in the step size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Global error `O(h)`.
    One,
    /// Global error `O(h²)`.
    Two,
    /// Global error `O(h³)`.
    Three,
    /// Global error `O(h⁴)`.
    Four,
}

impl Order {
    /// The exponent of `h`.
    pub const fn number(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Three => 3,
            Self::Four => 4,
        }
    }
}

/// The stability criterion that a method must meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StabilityClass {
    /// The total energy of a closed scene must not rise.
    Dissipative,
    /// The total energy of an undamped scene may oscillate but not drift.
    Symplectic,
}

/// A quantity that a method conserves, up to round-off and the tolerance of its solve. This holds
/// for an undamped system of springs without pins, contacts and external forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// `Σ m v`.
    Momentum,
    /// `Σ m x × v`.
    AngularMomentum,
    /// Kinetic energy plus the potentials of all effects.
    Energy,
}

impl Quantity {
    /// Name of the quantity in prose.
    pub fn name(self) -> &'static str {
        match self {
            Self::Momentum => "momentum",
            Self::AngularMomentum => "angular momentum",
            Self::Energy => "energy",
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
    /// As a compliant constraint, whose compliance is the inverse of the stiffness.
    Compliant,
}

impl Treatment {
    /// The treatment as one word, for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Implicit => "implicit",
            Self::Explicit => "explicit",
            Self::BySetting => "by setting",
            Self::Constraint => "constraint",
            Self::Compliant => "compliant constraint",
        }
    }
}

/// The constraints that a scene can name. A method may also refuse `moving pins` or
/// `moving obstacles`, and the laws of damping, `full damping` and `projected damping`.
const CONSTRAINTS: [&str; 3] = ["pins", "contact", "friction"];

/// How a method treats the effects of a scene: one of four standard answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Supports {
    /// Every effect is taken at the old level.
    Explicit,
    /// Springs are implicit, usually in a scalar matrix; everything else is taken at the old level.
    ScalarMatrix,
    /// Every effect with a Jacobian is in a matrix of 3×3 blocks.
    Blocks,
    /// Springs and stencils are compliant constraints; everything else is taken at the old level.
    Compliant,
}

/// An effect or constraint that a method supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Support {
    /// Name of the effect, or `pins`, `contact` or `friction`.
    pub effect: &'static str,
    /// How the method treats it.
    pub treatment: Treatment,
}

/// Description of a time integrator.
#[derive(Debug, PartialEq)]
pub struct Method {
    /// Id of the method on the command line.
    pub id: &'static str,
    /// Name in prose.
    pub name: &'static str,
    /// Publication of the method.
    pub source: &'static str,
    /// Order of accuracy.
    pub order: Order,
    /// The stability criterion that the method must meet.
    pub class: StabilityClass,
    /// Quantities that the method conserves exactly.
    pub conserves: &'static [Quantity],
    /// What theory says about the stability of the method, in a sentence or two.
    pub theory: &'static str,
    /// How the method treats the effects of a scene.
    pub supports: Supports,
    /// Effects and constraints that the method refuses in spite of [`supports`](Self::supports).
    pub refuses: &'static [&'static str],
    /// Settings of the method, with ranges and defaults.
    pub settings: &'static [Setting],
}

impl Method {
    /// How the method treats an effect of this kind and class.
    ///
    /// If the method has the setting `implicit`, that setting decides about all implicit effects
    /// except the tension springs.
    pub fn treatment(&self, effect: EffectKind, class: EffectClass) -> Treatment {
        let is_implicit = match (self.supports, class) {
            (Supports::Explicit, _) | (_, EffectClass::Uniform) => false,
            (Supports::ScalarMatrix, class) => class == EffectClass::Springs,
            (Supports::Blocks, _) => true,
            (Supports::Compliant, EffectClass::Springs | EffectClass::Stencils) => {
                return Treatment::Compliant;
            }
            (Supports::Compliant, EffectClass::Drag) => false,
        };
        let is_left_open = self.settings.iter().any(|setting| setting.key == "implicit");
        match (is_implicit, is_left_open && effect != EffectKind::Tension) {
            (false, _) => Treatment::Explicit,
            (true, true) => Treatment::BySetting,
            (true, false) => Treatment::Implicit,
        }
    }

    /// The supported effects, then the supported constraints. The method refuses all others by
    /// name.
    pub fn supports(&self) -> impl Iterator<Item = Support> {
        let effect = |&kind: &EffectKind| {
            let treatment = self.treatment(kind, kind.class()?);
            Some(Support { effect: kind.name(), treatment })
        };
        let constraint = |effect| Support { effect, treatment: Treatment::Constraint };
        let effects = EffectKind::ALL.iter().filter_map(effect);
        let all = effects.chain(CONSTRAINTS.into_iter().map(constraint));
        all.filter(|support| !self.refuses.contains(&support.effect))
    }

    /// Whether the method takes an effect at the old time level, with these settings.
    pub fn is_explicit(&self, effect: &dyn Effect, settings: &Settings) -> bool {
        match self.treatment(effect.kind(), EffectClass::of(effect)) {
            Treatment::Explicit => true,
            Treatment::BySetting => settings.get("implicit") == Some("tension"),
            Treatment::Implicit | Treatment::Constraint | Treatment::Compliant => false,
        }
    }

    /// Refuses a system with an effect or constraint that the method does not support.
    ///
    /// # Errors
    /// [`PrepareError::Unsupported`], which names the first such effect or constraint.
    pub fn check(&self, system: &System) -> Result<(), PrepareError> {
        let named = system.effects().map(|effect| effect.name());
        let pins = system.pinned().contains(&true).then_some("pins");
        let contact = (!system.obstacles().is_empty()).then_some("contact");
        let friction = rough_obstacle(system).map(|_| "friction");
        let driven = (!system.moving_pins().is_empty()).then_some("moving pins");
        let moving = system.obstacles().iter().any(|obstacle| obstacle.path.is_some());
        let moving = moving.then_some("moving obstacles");
        let damped = system.effects().filter(|effect| effect.has_damping());
        let mut laws = damped.filter_map(|effect| effect.split());
        let damping = laws.next().map(|split| match split.has_damping_remainder() {
            true => "projected damping",
            false => "full damping",
        });
        let motion = driven.into_iter().chain(moving).chain(damping);
        for what in named.chain(pins).chain(contact).chain(friction).chain(motion) {
            if self.refuses.contains(&what) {
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
        ("moving pins", _) => "pins[].path".to_owned(),
        ("moving obstacles", _) => "obstacles[].path".to_owned(),
        ("full damping" | "projected damping", _) => "damping".to_owned(),
        ("friction", Some((place, obstacle))) => {
            format!("obstacles[{place}].{}.friction", obstacle.shape.name())
        }
        _ => format!("effects.{what}"),
    }
}
