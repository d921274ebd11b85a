//! Bounds of all values, and the checks against them. An error names the place, the value and the
//! bounds.
//!
//! The types at the end describe numbers in the published schemas, because attributes of `schemars`
//! cannot exclude a bound for the numbers in a list.

use crate::Vec3;
use crate::error::Violation;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use std::borrow::Cow;
use std::fmt::Display;

/// Most particles that a system may have.
pub(crate) const MAX_PARTICLES: usize = 4_000_000;
/// Greatest index of a particle.
pub(crate) const LAST_PARTICLE: u32 = MAX_PARTICLES as u32 - 1;
/// Greatest magnitude of a coordinate, velocity or acceleration.
pub(crate) const MAX_COORDINATE: f64 = 1e9;
/// Greatest stiffness, damping coefficient or mass.
pub(crate) const MAX_COEFFICIENT: f64 = 1e30;

/// Least mass of a particle, kg. For smaller masses, products of two masses underflow, and the
/// sheet would stand still without an error.
pub(crate) const MIN_MASS: f64 = 1e-30;

/// Standard acceleration of gravity, m/s².
pub(crate) const STANDARD_GRAVITY: f64 = 9.806_65;

/// Whether serde leaves a number out because 0 is its default.
pub(crate) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The index of one of `count` particles.
pub(crate) fn index(path: impl Display, value: u32, count: usize) -> Result<usize, Violation> {
    if (value as usize) < count {
        return Ok(value as usize);
    }
    let expected = match count {
        0 => "no index at all: there is no particle".to_owned(),
        _ => format!("a particle index from 0 to {}", count - 1),
    };
    Err(Violation::new(path.to_string(), value, expected))
}

/// Prints a value or a bound in few characters, whatever its size.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || (1e-4..1e7).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// A number from `low` to `high`.
pub(crate) fn within(
    path: impl Display,
    value: f64,
    low: f64,
    high: f64,
) -> Result<f64, Violation> {
    if value >= low && value <= high {
        return Ok(value);
    }
    let expected = format!("a number from {} to {}", number(low), number(high));
    Err(Violation::new(path.to_string(), number(value), expected))
}

/// A stiffness or a damping coefficient.
pub(crate) fn coefficient(path: impl Display, value: f64) -> Result<f64, Violation> {
    within(path, value, 0.0, MAX_COEFFICIENT)
}

/// A mass of a particle, kg.
pub(crate) fn mass(path: impl Display, value: f64) -> Result<f64, Violation> {
    within(path, value, MIN_MASS, MAX_COEFFICIENT)
}

/// A number above 0, at most `high`.
pub(crate) fn positive(path: impl Display, value: f64, high: f64) -> Result<f64, Violation> {
    if value > 0.0 && value <= high {
        return Ok(value);
    }
    let expected = format!("a number above 0, at most {}", number(high));
    Err(Violation::new(path.to_string(), number(value), expected))
}

/// A vector whose components are in range.
pub(crate) fn vector(path: impl Display, value: [f64; 3]) -> Result<Vec3, Violation> {
    for (axis, component) in value.into_iter().enumerate() {
        within(format_args!("{path}[{axis}]"), component, -MAX_COORDINATE, MAX_COORDINATE)?;
    }
    Ok(Vec3::from(value))
}

/// The unit vector along a vector.
pub(crate) fn direction(path: impl Display, value: [f64; 3]) -> Result<Vec3, Violation> {
    vector(&path, value)?.try_normalize(1e-12).ok_or_else(|| {
        Violation::new(path.to_string(), format!("{value:?}"), "a vector longer than 1e-12")
    })
}

/// Refuses a list with more entries than `most`; `what` names the entries.
pub(crate) fn at_most(
    path: impl Display,
    length: usize,
    most: usize,
    what: &str,
) -> Result<(), Violation> {
    if length <= most {
        return Ok(());
    }
    let expected = format!("at most {most} {what}");
    Err(Violation::new(path.to_string(), format!("of length {length}"), expected))
}

/// Refuses these keys of the object at `path`. Each key comes with whether it is given; the error
/// names the first one that is given.
pub(crate) fn refuse(
    path: &str,
    keys: &[(&str, bool)],
    found: &str,
    expected: &str,
) -> Result<(), Violation> {
    match keys.iter().find(|(_, is_given)| *is_given) {
        None => Ok(()),
        Some((key, _)) => Err(Violation::new(format!("{path}.{key}"), found, expected)),
    }
}

macro_rules! positive {
    ($($(#[$about:meta])+ $name:ident, $low:literal, $least:expr, $most:expr);+ $(;)?) => {
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
                    "type": "number", "format": "double", $low: $least, "maximum": $most
                })
            }
        })+
    };
}

positive! {
    /// A length, m.
    Length, "exclusiveMinimum", 0.0, MAX_COORDINATE;
    /// A mass of a particle, kg.
    Mass, "minimum", MIN_MASS, MAX_COEFFICIENT;
}
