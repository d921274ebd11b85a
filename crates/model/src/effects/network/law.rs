//! Laws of springs in a scene: stiffness, pieces, compression and buckling, for all springs or for
//! warp and weft apart.

use super::{Fabric, SpringEffect, SpringSpec, Strand};
use crate::bounds::{MAX_COEFFICIENT, at_most, coefficient, number, positive, refuse, within};
use crate::error::Violation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Greatest strain at which a piece may end.
const MAX_STRAIN: f64 = 1e6;
/// Most pieces of a spring.
pub(super) const MAX_PIECES: usize = 64;
/// Default ratio of the stiffness in compression to the stiffness of the first piece: cloth gives
/// way.
pub(super) const COMPRESSION: f64 = 0.1;

/// A piece of a tension curve that is piecewise linear over the strain `L/ℓ − 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PieceSpec {
    /// Strain at which the piece ends. It lies above the end of the previous piece. Only the last
    /// piece has no end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_STRAIN))]
    pub up_to_strain: Option<f64>,
    /// Slope of the tension over the length, N/m.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: f64,
}

/// The tension of springs along warp or along weft.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StretchLaw {
    /// Stiffness, N/m. Give either this or `pieces`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: Option<f64>,
    /// Piecewise-linear tension.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MAX_PIECES))]
    pub pieces: Vec<PieceSpec>,
    /// Stiffness in compression, N/m. If absent, it is the stiffness, or a tenth of the first
    /// piece's stiffness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub compression_stiffness_n_per_m: Option<f64>,
}

/// Stiffness and damping of one kind of spring. Each is given either absolutely or divided by the
/// mass of a particle. Piecewise-linear tension may replace the stiffness: one curve for all
/// springs, one curve each for warp and weft, or a fabric.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringLaw {
    /// Stiffness `k`, N/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: Option<f64>,
    /// Stiffness over particle mass `k/m`, 1/s² (the paper's quotient).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_over_mass_per_s2: Option<f64>,
    /// Damping coefficient, N s/m; none if both keys are absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub damping_n_s_per_m: Option<f64>,
    /// Damping over particle mass, 1/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub damping_over_mass_per_s: Option<f64>,
    /// Piecewise-linear tension, instead of a stiffness.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MAX_PIECES))]
    pub pieces: Vec<PieceSpec>,
    /// Stiffness in compression, N/m. If absent, it is the stiffness, or a tenth of the first
    /// piece's stiffness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub compression_stiffness_n_per_m: Option<f64>,
    /// A fabric with measured tension, instead of a stiffness. It is allowed for tension on a grid
    /// only, whose warp is x. Every spring carries the tension of a strip as wide as the distance
    /// between the springs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fabric: Option<Fabric>,
    /// Law of the springs along the warp (x on a grid), instead of a stiffness. It requires `weft`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warp: Option<StretchLaw>,
    /// Law of the springs along the weft (y on a grid). It requires `warp`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weft: Option<StretchLaw>,
    /// Flexural rigidity, N m², of the strips of cloth that bending springs stand for. The strips
    /// buckle when compressed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub buckling_rigidity_n_m2: Option<f64>,
}

/// The springs of one effect, checked: along warp, along weft.
#[derive(Clone, Debug)]
pub(super) struct Stretches {
    directions: [Stretch; 2],
    damping: f64,
    buckling: Option<f64>,
}

#[derive(Clone, Debug)]
struct Stretch {
    stiffness: f64,
    pieces: Arc<[PieceSpec]>,
    compression: Option<f64>,
}

impl Stretches {
    pub(super) fn spring(&self, effect: SpringEffect, strand: &Strand) -> SpringSpec {
        let [warp, weft] = &self.directions;
        let stretch = if strand.direction == 0 { warp } else { weft };
        let [i, j] = strand.ends;
        SpringSpec {
            effect,
            i,
            j,
            rest_length_m: strand.length,
            stiffness_n_per_m: stretch.stiffness,
            damping_n_s_per_m: self.damping,
            pieces: Arc::clone(&stretch.pieces),
            compression_stiffness_n_per_m: stretch.compression,
            buckling_rigidity_n_m2: self.buckling,
        }
    }
}

impl StretchLaw {
    fn resolve(&self, path: &str) -> Result<Stretch, Violation> {
        let stiffness = match (self.stiffness_n_per_m, self.pieces.first()) {
            (Some(k), None) => coefficient(format_args!("{path}.stiffness_n_per_m"), k)?,
            (None, Some(first)) => {
                check_pieces(path, &self.pieces)?;
                first.stiffness_n_per_m
            }
            (Some(_), Some(_)) => {
                return Err(given_twice(
                    path,
                    ["stiffness_n_per_m", "pieces"],
                    "exactly one of the two",
                ));
            }
            (None, None) => {
                let expected = "`stiffness_n_per_m`, or `pieces` with at least one piece";
                return Err(Violation::new(path, "without a stiffness", expected));
            }
        };
        let compression = self.compression_stiffness_n_per_m;
        if let Some(k) = compression {
            coefficient(format_args!("{path}.compression_stiffness_n_per_m"), k)?;
        }
        Ok(Stretch { stiffness, pieces: self.pieces.as_slice().into(), compression })
    }
}

fn given_twice(path: &str, [a, b]: [&str; 2], expected: &str) -> Violation {
    Violation::new(path, format!("given twice, as `{a}` and as `{b}`"), expected)
}

/// A coefficient, given directly or over the mass of a particle.
fn absolute(
    path: &str,
    [key, over_mass]: [(&str, Option<f64>); 2],
    mass: f64,
    expected: &str,
) -> Result<Option<f64>, Violation> {
    match (key.1, over_mass.1) {
        (None, None) => Ok(None),
        (Some(value), None) => coefficient(format_args!("{path}.{}", key.0), value).map(Some),
        (None, Some(quotient)) => {
            // A quotient in range times a mass in range may still be out of range.
            let high = MAX_COEFFICIENT.min(MAX_COEFFICIENT / mass);
            let path = format_args!("{path}.{}", over_mass.0);
            Ok(Some(within(path, quotient, 0.0, high)? * mass))
        }
        (Some(_), Some(_)) => Err(given_twice(path, [key.0, over_mass.0], expected)),
    }
}

impl SpringLaw {
    /// The springs of `effect`, for particles of mass `mass` (kg).
    pub(super) fn stretches(
        &self,
        effect: SpringEffect,
        mass: f64,
    ) -> Result<Stretches, Violation> {
        let path = &format!("effects.{}", effect.name());
        let buckling = self.buckling_rigidity_n_m2;
        if let Some(rigidity) = buckling {
            check_rigidity(&format!("{path}.buckling_rigidity_n_m2"), rigidity, effect)?;
        }
        let damping = [
            ("damping_n_s_per_m", self.damping_n_s_per_m),
            ("damping_over_mass_per_s", self.damping_over_mass_per_s),
        ];
        let damping = absolute(path, damping, mass, "at most one of the two")?.unwrap_or(0.0);
        let directions = match (&self.warp, &self.weft) {
            (None, None) => {
                let stretch = self.uniform(path, mass)?;
                [stretch.clone(), stretch]
            }
            (Some(_), Some(_)) if effect == SpringEffect::Shear => {
                let found = "given for springs along the diagonals";
                return Err(Violation::new(format!("{path}.warp"), found, "one law for both"));
            }
            (Some(warp), Some(weft)) => {
                let found = "given beside `warp` and `weft`";
                self.refuse_stiffness(path, found)?;
                let others = [
                    ("pieces", !self.pieces.is_empty()),
                    ("compression_stiffness_n_per_m", self.compression_stiffness_n_per_m.is_some()),
                ];
                let expected = "this key in `warp` and in `weft`, or in neither of them";
                refuse(path, &others, found, expected)?;
                let resolve = |law: &StretchLaw, key: &str| law.resolve(&format!("{path}.{key}"));
                [resolve(warp, "warp")?, resolve(weft, "weft")?]
            }
            (warp, _) => {
                let [missing, other] =
                    if warp.is_some() { ["weft", "warp"] } else { ["warp", "weft"] };
                let expected = format!("this key beside `{other}`");
                return Err(Violation::new(format!("{path}.{missing}"), "missing", expected));
            }
        };
        Ok(Stretches { directions, damping, buckling })
    }

    /// One law for all springs.
    fn uniform(&self, path: &str, mass: f64) -> Result<Stretch, Violation> {
        let (stiffness, over_mass) = ("stiffness_n_per_m", "stiffness_over_mass_per_s2");
        let stiffness_n_per_m = if self.pieces.is_empty() {
            let keys =
                [(stiffness, self.stiffness_n_per_m), (over_mass, self.stiffness_over_mass_per_s2)];
            let Some(k) = absolute(path, keys, mass, "exactly one of the two")? else {
                let expected = format!(
                    "one of `{stiffness}` and `{over_mass}`, or `pieces` with at least one piece, \
                     or `warp` and `weft`"
                );
                return Err(Violation::new(path, "without a stiffness", expected));
            };
            Some(k)
        } else {
            self.refuse_stiffness(path, "given beside `pieces`")?;
            None
        };
        let law = StretchLaw {
            stiffness_n_per_m,
            pieces: self.pieces.clone(),
            compression_stiffness_n_per_m: self.compression_stiffness_n_per_m,
        };
        law.resolve(path)
    }

    /// Refuses a stiffness of the whole effect, which contradicts another key.
    fn refuse_stiffness(&self, path: &str, found: &str) -> Result<(), Violation> {
        let keys = [
            ("stiffness_n_per_m", self.stiffness_n_per_m.is_some()),
            ("stiffness_over_mass_per_s2", self.stiffness_over_mass_per_s2.is_some()),
        ];
        refuse(path, &keys, found, "one of the two only")
    }

    /// Refuses keys that need warp and weft, which a mesh without texture does not state, and a
    /// fabric, which needs rows and columns.
    pub(super) fn refuse_directions(
        &self,
        effect: SpringEffect,
        is_woven: bool,
    ) -> Result<(), Violation> {
        let is_woven = is_woven && effect == SpringEffect::Tension;
        let keys = [
            ("warp", self.warp.is_some() && !is_woven),
            ("weft", self.weft.is_some() && !is_woven),
            ("fabric", self.fabric.is_some()),
        ];
        let expected = "one law for all springs: the file says nothing of warp and weft";
        refuse(&format!("effects.{}", effect.name()), &keys, "given for a mesh", expected)
    }
}

/// Checks that the pieces follow each other, and that all except the last one end.
pub(super) fn check_pieces(path: &str, pieces: &[PieceSpec]) -> Result<(), Violation> {
    at_most(format_args!("{path}.pieces"), pieces.len(), MAX_PIECES, "pieces")?;
    let mut from = 0.0;
    for (position, piece) in pieces.iter().enumerate() {
        let key = |key: &str| format!("{path}.pieces[{position}].{key}");
        coefficient(key("stiffness_n_per_m"), piece.stiffness_n_per_m)?;
        let (found, expected) = match (piece.up_to_strain, position + 1 == pieces.len()) {
            (None, true) => continue,
            (Some(strain), false) if strain > from && strain <= MAX_STRAIN => {
                from = strain;
                continue;
            }
            (Some(strain), false) => {
                let bounds = [from, MAX_STRAIN].map(number);
                let expected = format!("a number above {}, at most {}", bounds[0], bounds[1]);
                (number(strain), expected)
            }
            (Some(strain), true) => {
                (number(strain), "no such key: the last piece has no end".to_owned())
            }
            (None, false) => {
                ("missing".to_owned(), "this key: only the last piece has no end".to_owned())
            }
        };
        return Err(Violation::new(key("up_to_strain"), found, expected));
    }
    Ok(())
}

/// Checks the rigidity of springs that buckle.
pub(super) fn check_rigidity(
    path: &str,
    rigidity: f64,
    effect: SpringEffect,
) -> Result<(), Violation> {
    if effect != SpringEffect::Bending {
        let found = format!("given for {}", effect.name());
        return Err(Violation::new(path, found, "this key with bending springs only"));
    }
    positive(path, rigidity, MAX_COEFFICIENT).map(drop)
}
