//! The list of all effects: one line each.
//!
//! A line gives the kind, the key under which a scene names the effect, the type of the value there, and, where a frozen
//! system holds the effect under the same key, the type of that value. From it follow [`EffectKind`], [`Effects`] and
//! [`EffectsSpec`]. The order of the lines is the order in which a system sums its forces.

use super::gravity::GravitySpec;
use crate::scene::SpringLaw;
use crate::spec::ContactSpec;
use crate::stencils::{AirSpec, AngularLaw};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

macro_rules! effects {
    ($(#[doc = $doc:literal] $Kind:ident $key:ident: $Law:ty $(, frozen $Frozen:ty)?;)+) => {
        /// A kind of force. Its name is the word under which scenes, records and messages know it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum EffectKind {
            $(#[doc = $doc] $Kind,)+
        }

        impl EffectKind {
            /// All kinds, in the order in which a system sums them.
            pub const ALL: &'static [Self] = &[$(Self::$Kind),+];

            /// The word for it, such as `bending_hinge`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$Kind => stringify!($key),)+
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
                pub $key: Option<$Law>,
            )+
            /// Treatment of contacts with the obstacles.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub contact: Option<ContactSpec>,
        }

        /// The effects that a frozen system does not hold in lists of its own.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    };
}

effects! {
    /// Springs between neighbours in a row or column: the stiff part.
    Tension tension: SpringLaw;
    /// Springs along both diagonals of each cell.
    Shear shear: SpringLaw;
    /// Springs from each particle to the next but one in a row or column.
    Bending bending: SpringLaw;
    /// Angles between warp and weft, which shear changes; on a grid.
    ShearAngle shear_angle: AngularLaw;
    /// Angles between the edges of a row or column, which bending changes; on a grid.
    BendingAngle bending_angle: AngularLaw;
    /// Angles between triangles with a common edge, which bending changes.
    BendingHinge bending_hinge: AngularLaw;
    /// Uniform gravity.
    Gravity gravity: GravitySpec, frozen GravitySpec;
    /// The air around the cloth, at rest or in motion.
    Air air: AirSpec, frozen AirSpec;
}

impl fmt::Display for EffectKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}
