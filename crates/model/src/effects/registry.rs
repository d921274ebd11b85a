//! The machinery behind the list of effects in [`effects`](super).
//!
//! A line of the list gives the kind, the key under which a scene names the effect, the type of the
//! value there and the [`Entry`]. If the line says `frozen`, a frozen system keeps the effect under
//! the same key. Otherwise the frozen system keeps it in a list.

use super::{Effect, EffectKind};
use crate::error::Violation;
use crate::numbering::Strands;
use crate::{Cloth, SystemSpec};
use std::fmt;

/// How a method sees the forces of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectClass {
    /// Springs: they have Jacobians and a linear split.
    Springs,
    /// A stencil of three or four particles, such as an angle or a hinge: it has Jacobians and no
    /// split.
    Stencils,
    /// A force without a Jacobian, such as gravity.
    Uniform,
    /// Drag against a medium, with a Jacobian.
    Drag,
}

impl EffectClass {
    /// The class of an effect, derived from what the effect offers.
    pub fn of(effect: &dyn Effect) -> Self {
        match (effect.split(), effect.has_jacobian()) {
            (Some(_), _) => Self::Springs,
            (None, true) if effect.is_drag() => Self::Drag,
            (None, true) => Self::Stencils,
            (None, false) => Self::Uniform,
        }
    }
}

/// How an effect gets from a scene to a frozen system, and from there to a running one.
pub(crate) trait Entry {
    /// The value under the key of the effect in a scene.
    type Value;

    /// How a method sees the forces.
    const CLASS: EffectClass;

    /// About how many springs, angles or hinges it makes for each particle of a grid and of a mesh.
    const PIECES: [u64; 2] = [0, 0];

    /// Applies the law to the cloth and adds the outcome to a frozen system. Particles and
    /// triangles are checked already.
    fn freeze(
        law: &Self::Value,
        kind: EffectKind,
        cloth: Weave<'_>,
        spec: &mut SystemSpec,
    ) -> Result<(), Violation>;

    /// Checks what a frozen system holds of this kind; `None` if it holds nothing.
    fn check(kind: EffectKind, spec: &SystemSpec) -> Result<Option<Box<dyn Checked>>, Violation>;

    /// Shifts times, for a system that is frozen after `t` seconds.
    fn advance(_spec: &mut SystemSpec, _t: f64) {}
}

/// The cloth of a scene, as laws need it.
#[derive(Clone, Copy)]
pub(crate) struct Weave<'a> {
    pub(crate) cloth: &'a Cloth,
    /// Mean mass of its particles, kg.
    pub(crate) mass: f64,
}

/// An effect with checked values, before it lays out its memory.
pub(crate) trait Checked {
    /// Its springs, which determine the order of the particles.
    fn springs(&mut self) -> Option<Strands<'_>> {
        None
    }

    /// Visits the index of every particle on which it acts, except those of its springs.
    fn visit_particles(&mut self, visit: &mut dyn FnMut(&mut u32));

    /// The effect that runs.
    fn assemble(self: Box<Self>) -> Box<dyn Effect>;
}

impl fmt::Display for EffectKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

macro_rules! effects {
    ($(
        #[doc = $doc:literal]
        $Kind:ident $key:ident: $Value:ty $(, frozen $Frozen:ty)? => $Entry:ty;
    )+) => {
        /// A kind of force. Scenes, records and messages know it by its name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[derive(Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum EffectKind {
            $(#[doc = $doc] $Kind,)+
            /// An effect that a user of this library wrote, with its name. Scenes cannot name it.
            #[serde(skip)]
            Own(&'static str),
        }

        impl EffectKind {
            /// All kinds that a scene can name, in the order in which a system sums them.
            pub const ALL: &'static [Self] = &[$(Self::$Kind),+];

            /// How a method sees the forces of this kind. `None` for an effect that a user wrote;
            /// [`EffectClass::of`] derives its class.
            pub fn class(self) -> Option<EffectClass> {
                match self {
                    $(Self::$Kind => Some(<$Entry as $crate::effects::registry::Entry>::CLASS),)+
                    Self::Own(_) => None,
                }
            }

            /// Its name, such as `bending_hinge`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$Kind => stringify!($key),)+
                    Self::Own(name) => name,
                }
            }
        }

        /// The effects that a scene names.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Effects {
            $(
                #[doc = $doc]
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub $key: Option<$Value>,
            )+
            /// Treatment of contacts with the obstacles.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub contact: Option<ContactSpec>,
        }

        impl Effects {
            /// About how many springs, angles and hinges each particle gets, on a grid and on a
            /// mesh.
            pub(crate) fn pieces(&self) -> [u64; 2] {
                let mut sum = [0, 0];
                $(
                    if self.$key.is_some() {
                        let pieces = <$Entry as Entry>::PIECES;
                        sum.iter_mut().zip(pieces).for_each(|(sum, pieces)| *sum += pieces);
                    }
                )+
                sum
            }

            /// Adds all named effects to a frozen system.
            pub(crate) fn freeze(
                &self,
                cloth: Weave<'_>,
                spec: &mut SystemSpec,
            ) -> Result<(), Violation> {
                $(
                    if let Some(law) = &self.$key {
                        <$Entry as Entry>::freeze(law, EffectKind::$Kind, cloth, spec)?;
                    }
                )+
                Ok(())
            }
        }

        /// The effects that a frozen system does not keep in lists of their own.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct EffectsSpec {
            $($(
                #[doc = $doc]
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub $key: Option<$Frozen>,
            )?)+
            /// Treatment of contacts with the obstacles; the defaults if absent.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub contact: Option<ContactSpec>,
        }

        /// Checks all effects of a frozen system, in the order of the list.
        pub(crate) fn check(spec: &SystemSpec) -> Result<Vec<Box<dyn Checked>>, Violation> {
            let checked = [$(<$Entry as Entry>::check(EffectKind::$Kind, spec)?),+];
            Ok(checked.into_iter().flatten().collect())
        }

        /// Shifts all effects of a system that is frozen after `t` seconds.
        pub(crate) fn advance(spec: &mut SystemSpec, t: f64) {
            $(<$Entry as Entry>::advance(spec, t);)+
        }
    };
}
