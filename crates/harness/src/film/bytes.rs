//! Positions as text: base64 of the bytes of their coordinates, in little-endian order. Decimals with
//! every bit would be longer.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use drape_model::Vec3;
use serde::de::Error as _;
use serde::{Deserialize as _, Deserializer, Serializer};
use std::borrow::Cow;

const COORDINATE: usize = size_of::<f64>();

/// Writes positions.
pub(super) fn serialize<S: Serializer>(x: &[Vec3], serializer: S) -> Result<S::Ok, S::Error> {
    let coordinates = x.iter().flat_map(|x| [x.x, x.y, x.z]);
    let bytes: Vec<u8> = coordinates.flat_map(f64::to_le_bytes).collect();
    serializer.serialize_str(&STANDARD.encode(bytes))
}

/// Reads positions.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(de: D) -> Result<Vec<Vec3>, D::Error> {
    let text = Cow::<'_, str>::deserialize(de)?;
    let bytes = STANDARD.decode(text.as_bytes()).map_err(D::Error::custom)?;
    let (coordinates, rest) = bytes.as_chunks::<COORDINATE>();
    let (positions, more) = coordinates.as_chunks::<3>();
    if !(rest.is_empty() && more.is_empty()) {
        let whole = 3 * COORDINATE;
        return Err(D::Error::custom(format!("{} bytes, not a multiple of {whole}", bytes.len())));
    }
    Ok(positions.iter().map(|x| Vec3::from(x.map(f64::from_le_bytes))).collect())
}
