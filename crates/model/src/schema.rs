//! Bounds that the JSON schema of a type does not tell by itself. The attributes of `schemars` know no bound that is excluded for
//! the numbers of a list; these types stand for such numbers.

use crate::spec::{MAX_COEFFICIENT, MAX_COORDINATE, MAX_PARTICLES};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use std::borrow::Cow;

/// Greatest index of a particle.
pub(crate) const LAST_PARTICLE: u32 = MAX_PARTICLES as u32 - 1;

macro_rules! positive {
    ($($(#[$about:meta])+ $name:ident, $most:expr);+ $(;)?) => {
        $($(#[$about])+
        pub(crate) enum $name {}

        impl JsonSchema for $name {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({
                    "type": "number", "format": "double", "exclusiveMinimum": 0, "maximum": $most
                })
            }
        })+
    };
}

positive! {
    /// A length, m.
    Length, MAX_COORDINATE;
    /// A mass, kg.
    Mass, MAX_COEFFICIENT;
}
