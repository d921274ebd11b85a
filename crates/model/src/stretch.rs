//! How springs that are not linear are written down: pieces, compression, buckling; for warp and weft apart.

use crate::build::{number, positive, within};
use crate::effects::{Buckling, Curve, TensionLaw};
use crate::error::Violation;
use crate::scene::SpringLaw;
use crate::spec::{MAX_COEFFICIENT, SpringEffect, SpringSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::Arc;

/// Greatest strain at which a piece may end.
const MAX_STRAIN: f64 = 1e6;
/// Most pieces of a spring.
pub(crate) const MAX_PIECES: usize = 64;
/// Stiffness in compression over that of the first piece, where the former is not given: cloth gives way.
const COMPRESSION: f64 = 0.1;

/// A piece of a tension curve that is piecewise linear over the strain `L/ℓ − 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PieceSpec {
    /// Strain at which it ends, above that of the piece before; the last piece has no end, and all others have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_STRAIN))]
    pub up_to_strain: Option<f64>,
    /// Slope of the tension over the length, N/m.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: f64,
}

/// What springs along warp or along weft do when they are stretched.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StretchLaw {
    /// Stiffness, N/m; or else `pieces`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: Option<f64>,
    /// Piecewise-linear tension.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MAX_PIECES))]
    pub pieces: Vec<PieceSpec>,
    /// Stiffness in compression, N/m. If absent: the stiffness, or a tenth of that of the first piece.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub compression_stiffness_n_per_m: Option<f64>,
}

/// What all springs of one effect are like: along warp, along weft.
#[derive(Clone, Debug)]
pub(crate) struct Stretches {
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
    /// A spring along the warp (0) or the weft (1).
    pub(crate) fn spring(
        &self,
        effect: SpringEffect,
        direction: usize,
        (i, j): (u32, u32),
        rest_length_m: f64,
    ) -> SpringSpec {
        let [warp, weft] = &self.directions;
        let stretch = if direction == 0 { warp } else { weft };
        SpringSpec {
            effect,
            i,
            j,
            rest_length_m,
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
            (Some(k), None) => {
                within(format_args!("{path}.stiffness_n_per_m"), k, 0.0, MAX_COEFFICIENT)?
            }
            (None, Some(first)) => {
                check_pieces(path, &self.pieces)?;
                first.stiffness_n_per_m
            }
            (Some(_), Some(_)) => {
                let found = "given twice, as `stiffness_n_per_m` and as `pieces`";
                return Err(Violation::new(path, found, "exactly one of the two"));
            }
            (None, None) => {
                let found = "without a stiffness";
                return Err(Violation::new(
                    path,
                    found,
                    "`stiffness_n_per_m` or `pieces`, one at least",
                ));
            }
        };
        let compression = self.compression_stiffness_n_per_m;
        if let Some(k) = compression {
            let path = format_args!("{path}.compression_stiffness_n_per_m");
            within(path, k, 0.0, MAX_COEFFICIENT)?;
        }
        Ok(Stretch { stiffness, pieces: self.pieces.as_slice().into(), compression })
    }
}

impl SpringLaw {
    /// What the springs of `effect` are like, for particles of mass `mass` (kg).
    pub(crate) fn stretches(
        &self,
        effect: SpringEffect,
        mass: f64,
    ) -> Result<Stretches, Violation> {
        let path = &format!("effects.{}", effect.name());
        let buckling = self.buckling_rigidity_n_m2;
        if let Some(rigidity) = buckling {
            check_rigidity(format!("{path}.buckling_rigidity_n_m2"), rigidity, effect)?;
        }
        let compression = self.compression_stiffness_n_per_m;
        let damping = self.resolve_damping(path, mass)?;
        let both = |stretch: Stretch| [stretch.clone(), stretch];
        let directions = match (&self.warp, &self.weft) {
            (None, None) if self.pieces.is_empty() => {
                let (stiffness, _) = self.resolve(path, mass)?;
                if let Some(k) = compression {
                    let path = format_args!("{path}.compression_stiffness_n_per_m");
                    within(path, k, 0.0, MAX_COEFFICIENT)?;
                }
                both(Stretch { stiffness, pieces: Arc::default(), compression })
            }
            (None, None) => {
                self.refuse_stiffness(path, "beside `pieces`")?;
                let pieces = self.pieces.clone();
                let law = StretchLaw {
                    pieces,
                    compression_stiffness_n_per_m: compression,
                    ..StretchLaw::default()
                };
                both(law.resolve(path)?)
            }
            (Some(_), Some(_)) if effect == SpringEffect::Shear => {
                let found = "given for springs along the diagonals";
                return Err(Violation::new(format!("{path}.warp"), found, "one law for both"));
            }
            (Some(warp), Some(weft)) => {
                let beside = "beside `warp` and `weft`";
                self.refuse_stiffness(path, beside)?;
                let others = [
                    ("pieces", !self.pieces.is_empty()),
                    ("compression_stiffness_n_per_m", compression.is_some()),
                ];
                if let Some((key, _)) = others.into_iter().find(|(_, given)| *given) {
                    let found = format!("given {beside}");
                    let expected = "this key in `warp` and in `weft`, or none of the two";
                    return Err(Violation::new(format!("{path}.{key}"), found, expected));
                }
                let resolve = |law: &StretchLaw, key: &str| law.resolve(&format!("{path}.{key}"));
                [resolve(warp, "warp")?, resolve(weft, "weft")?]
            }
            (warp, _) => {
                let (missing, other) =
                    if warp.is_some() { ("weft", "warp") } else { ("warp", "weft") };
                let expected = format!("this key beside `{other}`");
                return Err(Violation::new(format!("{path}.{missing}"), "missing", expected));
            }
        };
        Ok(Stretches { directions, damping, buckling })
    }

    /// A stiffness of the effect as a whole contradicts what else is given.
    fn refuse_stiffness(&self, path: &str, beside: &str) -> Result<(), Violation> {
        let keys = [
            ("stiffness_n_per_m", self.stiffness_n_per_m),
            ("stiffness_over_mass_per_s2", self.stiffness_over_mass_per_s2),
        ];
        match keys.into_iter().find(|(_, value)| value.is_some()) {
            None => Ok(()),
            Some((key, _)) => {
                let found = format!("given {beside}");
                Err(Violation::new(format!("{path}.{key}"), found, "one of the two only"))
            }
        }
    }
}

/// Pieces follow each other, and all but the last one end.
fn check_pieces(path: &str, pieces: &[PieceSpec]) -> Result<(), Violation> {
    if pieces.len() > MAX_PIECES {
        let found = format!("of length {}", pieces.len());
        let expected = format!("at most {MAX_PIECES} pieces");
        return Err(Violation::new(format!("{path}.pieces"), found, expected));
    }
    let mut from = 0.0;
    for (position, piece) in pieces.iter().enumerate() {
        let key = |key: &str| format!("{path}.pieces[{position}].{key}");
        let stiffness = piece.stiffness_n_per_m;
        within(key("stiffness_n_per_m"), stiffness, 0.0, MAX_COEFFICIENT)?;
        match (piece.up_to_strain, position + 1 == pieces.len()) {
            (None, true) => {}
            (Some(strain), false) if strain > from && strain <= MAX_STRAIN => from = strain,
            (Some(strain), false) => {
                let expected =
                    format!("a number above {}, at most {}", number(from), number(MAX_STRAIN));
                return Err(Violation::new(key("up_to_strain"), number(strain), expected));
            }
            (Some(strain), true) => {
                let expected = "no such key: the last piece has no end";
                return Err(Violation::new(key("up_to_strain"), number(strain), expected));
            }
            (None, false) => {
                let expected = "this key: only the last piece has no end";
                return Err(Violation::new(key("up_to_strain"), "missing", expected));
            }
        }
    }
    Ok(())
}

fn check_rigidity(path: String, rigidity: f64, effect: SpringEffect) -> Result<(), Violation> {
    if effect != SpringEffect::Bending {
        let found = format!("given for {}", effect.name());
        return Err(Violation::new(path, found, "this key with bending springs only"));
    }
    positive(path, rigidity, MAX_COEFFICIENT).map(drop)
}

impl SpringSpec {
    /// Whether its tension is more than a stiffness times its stretch.
    pub(crate) fn is_piecewise(&self) -> bool {
        !self.pieces.is_empty()
            || self.compression_stiffness_n_per_m.is_some()
            || self.buckling_rigidity_n_m2.is_some()
    }

    /// Checks what makes it differ from a linear spring, less its pieces.
    fn check_law(&self, position: usize) -> Result<(), Violation> {
        let path = format!("springs[{position}]");
        if let Some(k) = self.compression_stiffness_n_per_m {
            within(format_args!("{path}.compression_stiffness_n_per_m"), k, 0.0, MAX_COEFFICIENT)?;
        }
        if self.rest_length_m == 0.0 && self.is_piecewise() {
            let expected = "above 0: strain is relative to it";
            return Err(Violation::new(format!("{path}.rest_length_m"), 0, expected));
        }
        if let Some(rigidity) = self.buckling_rigidity_n_m2 {
            let key = format!("{path}.buckling_rigidity_n_m2");
            check_rigidity(key.clone(), rigidity, self.effect)?;
            let steepest = Buckling::new(1.0, rigidity, self.rest_length_m).steepest_buckled();
            if steepest.is_nan() || steepest > MAX_COEFFICIENT {
                let expected = format!(
                    "so little that a spring of {} m has a stiffness of at most {}",
                    number(self.rest_length_m),
                    number(MAX_COEFFICIENT)
                );
                return Err(Violation::new(key, number(rigidity), expected));
            }
        }
        Ok(())
    }

    /// Checks its pieces, for the spring at `position` of the specification.
    fn check_curve(&self, position: usize) -> Result<(), Violation> {
        let path = format!("springs[{position}]");
        check_pieces(&path, &self.pieces)?;
        match self.pieces.first().map(|first| first.stiffness_n_per_m) {
            Some(first) if first != self.stiffness_n_per_m => {
                let expected = format!("{}, that of the first piece", number(first));
                let found = number(self.stiffness_n_per_m);
                Err(Violation::new(format!("{path}.stiffness_n_per_m"), found, expected))
            }
            _ => Ok(()),
        }
    }

    /// Its tension when stretched; valid values only.
    fn curve(&self) -> Curve {
        let ends = |p: &PieceSpec| (p.stiffness_n_per_m, p.up_to_strain.unwrap_or(f64::INFINITY));
        match &*self.pieces {
            [] => Curve::new([(self.stiffness_n_per_m, f64::INFINITY)]),
            pieces => Curve::new(pieces.iter().map(ends)),
        }
    }

    /// Its tension over its length; valid values only.
    fn law(&self, curve: Curve) -> TensionLaw {
        let stiffness = self.stiffness_n_per_m;
        let default = if self.pieces.is_empty() { stiffness } else { COMPRESSION * stiffness };
        let compression = self.compression_stiffness_n_per_m.unwrap_or(default);
        let law = TensionLaw::new(compression, curve);
        match self.buckling_rigidity_n_m2 {
            Some(b) => law.buckling(Buckling::new(compression, b, self.rest_length_m)),
            None => law,
        }
    }

    /// Everything that [`curve`](Self::curve) depends on.
    fn curve_key(&self) -> Vec<u64> {
        let of_piece =
            |piece: &PieceSpec| [piece.stiffness_n_per_m.to_bits(), bits(piece.up_to_strain)];
        match &*self.pieces {
            [] => vec![self.stiffness_n_per_m.to_bits()],
            pieces => pieces.iter().flat_map(of_piece).collect(),
        }
    }

    /// What [`law`](Self::law) depends on besides the curve.
    fn compression_key(&self) -> [u64; 3] {
        let buckling = self.buckling_rigidity_n_m2;
        let rest_length = buckling.map(|_| self.rest_length_m);
        [self.compression_stiffness_n_per_m, buckling, rest_length].map(bits)
    }
}

/// A number that is no other one's, also where there is none.
fn bits(value: Option<f64>) -> u64 {
    value.map_or(u64::MAX, f64::to_bits)
}

/// The different laws of the springs of one effect, and which of them each spring has. Laws share their curves: a strip
/// that buckles has a law of its own for each rest length.
#[derive(Debug, Default)]
pub(crate) struct Laws {
    known_curves: HashMap<Vec<u64>, u32>,
    /// By first use.
    curves: Vec<Curve>,
    /// Pieces and bits of the stiffness of the last spring, and its curve.
    last: Option<(Arc<[PieceSpec]>, u64, u32)>,
    known: HashMap<(u32, [u64; 3]), u32>,
    /// By first use.
    pub(crate) list: Vec<TensionLaw>,
    /// A law a spring.
    pub(crate) of: Vec<u32>,
}

impl Laws {
    /// Takes up the next spring, at `position` of the specification.
    pub(crate) fn push(&mut self, spec: &SpringSpec, position: usize) -> Result<(), Violation> {
        let curve = self.curve(spec, position)?;
        spec.check_law(position)?;
        let next = self.list.len() as u32;
        let law = *self.known.entry((curve, spec.compression_key())).or_insert_with(|| {
            self.list.push(spec.law(self.curves[curve as usize].clone()));
            next
        });
        self.of.push(law);
        Ok(())
    }

    /// The place of a spring's curve in the list. A spring that shares its pieces with the one before is not looked at
    /// again.
    fn curve(&mut self, spec: &SpringSpec, position: usize) -> Result<u32, Violation> {
        let stiffness = spec.stiffness_n_per_m.to_bits();
        match &self.last {
            Some((pieces, bits, curve))
                if Arc::ptr_eq(pieces, &spec.pieces) && *bits == stiffness =>
            {
                return Ok(*curve);
            }
            _ => {}
        }
        spec.check_curve(position)?;
        let next = self.curves.len() as u32;
        let curve = *self.known_curves.entry(spec.curve_key()).or_insert_with(|| {
            self.curves.push(spec.curve());
            next
        });
        self.last = Some((Arc::clone(&spec.pieces), stiffness, curve));
        Ok(curve)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strips(count: u32) -> Laws {
        let piece = |up_to_strain| PieceSpec { up_to_strain, stiffness_n_per_m: 2.0 };
        let pieces: Arc<[PieceSpec]> = [piece(Some(0.1)), piece(None)].into();
        let mut laws = Laws::default();
        for k in 0..count {
            // Every third one with a list of its own, as in a file.
            let own: Arc<[PieceSpec]> = pieces.to_vec().into();
            let spec = SpringSpec {
                effect: SpringEffect::Bending,
                rest_length_m: 1.0 + f64::from(k % 50),
                stiffness_n_per_m: 2.0,
                pieces: if k % 3 == 0 { own } else { Arc::clone(&pieces) },
                buckling_rigidity_n_m2: Some(1.0),
                ..SpringSpec::default()
            };
            laws.push(&spec, k as usize).expect("valid");
        }
        laws
    }

    #[test]
    fn strips_of_many_lengths_share_one_curve() {
        let laws = strips(100);
        assert_eq!((laws.curves.len(), laws.list.len(), laws.of.len()), (1, 50, 100));
        assert_eq!(laws.of[..50], laws.of[50..]);
    }
}
