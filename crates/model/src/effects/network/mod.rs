//! Springs as data: tension, shear and bending of a cloth, from a scene to linear or
//! piecewise-linear springs.

mod fabric;
mod law;

pub use fabric::Fabric;
pub use law::{PieceSpec, SpringLaw, StretchLaw};

use super::registry::{self, Checked, Weave};
use super::{
    Buckling, Curve, Effect, EffectClass, EffectKind, LinearSprings, PiecewiseSprings, Spring,
    TensionLaw,
};
use crate::bounds::{
    LAST_PARTICLE, MAX_COEFFICIENT, MAX_COORDINATE, coefficient, index, number, within,
};
use crate::error::Violation;
use crate::numbering::Strands;
use crate::{Cloth, SystemSpec};
use law::{COMPRESSION, MAX_PIECES, check_pieces, check_rigidity};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::Arc;

/// The effect that a spring belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpringEffect {
    /// Along warp and weft. These springs are the stiff part.
    #[default]
    Tension,
    /// Along the diagonals of the cells.
    Shear,
    /// From each particle to the next but one.
    Bending,
}

impl SpringEffect {
    /// All kinds, in the order in which a system holds them.
    pub const ALL: [SpringEffect; 3] = [Self::Tension, Self::Shear, Self::Bending];

    /// The name under which its energy is reported.
    pub fn name(self) -> &'static str {
        EffectKind::from(self).name()
    }
}

impl From<SpringEffect> for EffectKind {
    fn from(effect: SpringEffect) -> Self {
        match effect {
            SpringEffect::Tension => Self::Tension,
            SpringEffect::Shear => Self::Shear,
            SpringEffect::Bending => Self::Bending,
        }
    }
}

/// How the damping of the springs acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DampingLaw {
    /// `f_i = −c (v_i − v_j)`: linear, as in the paper. This law also damps rigid rotation.
    #[default]
    Full,
    /// `f_i = −c ûûᵀ (v_i − v_j)`: along the spring only. It does not damp rigid rotation.
    Projected,
}

/// One spring of a frozen system. It is linear unless one of the keys after `damping_n_s_per_m` is
/// given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringSpec {
    /// Effect that the spring belongs to.
    pub effect: SpringEffect,
    /// First end.
    #[schemars(range(max = LAST_PARTICLE))]
    pub i: u32,
    /// Second end.
    #[schemars(range(max = LAST_PARTICLE))]
    pub j: u32,
    /// Rest length, m; 0 is allowed.
    #[schemars(range(min = 0.0, max = MAX_COORDINATE))]
    pub rest_length_m: f64,
    /// Stiffness, N/m. If there are pieces, it is the stiffness of the first one.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_per_m: f64,
    /// Damping coefficient, N s/m.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub damping_n_s_per_m: f64,
    /// Piecewise-linear tension; empty for a spring without pieces. Springs of one law share one
    /// list.
    #[serde(default, skip_serializing_if = "<[_]>::is_empty")]
    #[schemars(length(max = MAX_PIECES))]
    pub pieces: Arc<[PieceSpec]>,
    /// Stiffness in compression, N/m. If absent, it is the stiffness, or a tenth of it if there are
    /// pieces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub compression_stiffness_n_per_m: Option<f64>,
    /// Flexural rigidity, N m², of the strip of cloth that a bending spring stands for. The strip
    /// buckles when compressed (Choi and Ko 2002). Before it buckles, the spring has its stiffness
    /// in compression.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub buckling_rigidity_n_m2: Option<f64>,
}

/// Two particles of a cloth that a spring joins.
pub(crate) struct Strand {
    /// 0 along the warp, 1 along the weft; 0 if the cloth states neither.
    pub(crate) direction: usize,
    pub(crate) ends: [u32; 2],
    /// Rest length, m.
    pub(crate) length: f64,
}

/// Effects of springs.
pub(crate) struct Entry;

impl registry::Entry for Entry {
    type Value = SpringLaw;
    const CLASS: EffectClass = EffectClass::Springs;
    const PIECES: [u64; 2] = [2, 3];

    fn freeze(
        law: &SpringLaw,
        kind: EffectKind,
        Weave { cloth, mass }: Weave<'_>,
        spec: &mut SystemSpec,
    ) -> Result<(), Violation> {
        let effects =
            SpringEffect::ALL.into_iter().filter(|&effect| EffectKind::from(effect) == kind);
        for effect in effects {
            let (law, strands) = match cloth {
                Cloth::Grid(grid) => {
                    (law.of_fabric(effect, grid.spacing_m())?, grid.strands(effect))
                }
                Cloth::Mesh(mesh) => {
                    law.refuse_directions(effect, mesh.has_directions())?;
                    (
                        law.clone(),
                        mesh.strands(effect, &spec.particles.position_m, law.warp.is_some())?,
                    )
                }
                // Explicit springs have their own stiffness, which a law would contradict.
                Cloth::Particles(_) => {
                    let found = "given beside explicit springs";
                    let expected =
                        "no such key: `cloth.particles.springs` carry their own stiffness";
                    return Err(Violation::new(format!("effects.{kind}"), found, expected));
                }
            };
            let stretches = law.stretches(effect, mass)?;
            spec.springs.extend(strands.iter().map(|strand| stretches.spring(effect, strand)));
        }
        Ok(())
    }

    fn check(kind: EffectKind, spec: &SystemSpec) -> Result<Option<Box<dyn Checked>>, Violation> {
        let n = spec.particles.mass_kg.len();
        let springs = spec.springs.iter().enumerate();
        let own = || springs.clone().filter(|(_, spring)| EffectKind::from(spring.effect) == kind);
        let mut laws = own().any(|(_, spring)| spring.is_piecewise()).then(Laws::default);
        let mut list = Vec::new();
        for (position, spring) in own() {
            list.push(spring.check(position, n)?);
            if let Some(laws) = &mut laws {
                laws.push(spring, position)?;
            }
        }
        let network = Network { kind, springs: list, laws, damping: spec.damping };
        Ok((!network.springs.is_empty()).then(|| Box::new(network) as Box<dyn Checked>))
    }
}

/// The springs of one effect, checked.
struct Network {
    kind: EffectKind,
    springs: Vec<Spring>,
    /// Their laws, if one of the springs is not linear.
    laws: Option<Laws>,
    damping: DampingLaw,
}

impl Checked for Network {
    fn springs(&mut self) -> Option<Strands<'_>> {
        let law_of = self.laws.as_mut().map(|laws| laws.of.as_mut_slice());
        Some(Strands { springs: &mut self.springs, law_of })
    }

    fn visit_particles(&mut self, _visit: &mut dyn FnMut(&mut u32)) {}

    fn assemble(self: Box<Self>) -> Box<dyn Effect> {
        let Self { kind, springs, laws, damping } = *self;
        match laws {
            None => Box::new(LinearSprings::new(kind, springs, damping)),
            Some(Laws { list, of, .. }) => {
                Box::new(PiecewiseSprings::new(kind, springs, of, list, damping))
            }
        }
    }
}

impl SpringSpec {
    /// Whether its tension is more than a stiffness times its stretch.
    fn is_piecewise(&self) -> bool {
        !self.pieces.is_empty()
            || self.compression_stiffness_n_per_m.is_some()
            || self.buckling_rigidity_n_m2.is_some()
    }

    /// Checks the values that every spring has. Only an error formats a path, since a cloth may
    /// have millions of springs.
    fn check(&self, position: usize, particles: usize) -> Result<Spring, Violation> {
        index(format_args!("springs[{position}].i"), self.i, particles)?;
        index(format_args!("springs[{position}].j"), self.j, particles)?;
        if self.i == self.j {
            let expected = format!("another particle than `i`, which is {}", self.i);
            return Err(Violation::new(format!("springs[{position}].j"), self.j, expected));
        }
        let value = |key: &str, value, high| {
            within(format_args!("springs[{position}].{key}"), value, 0.0, high)
        };
        Ok(Spring {
            i: self.i,
            j: self.j,
            rest_length: value("rest_length_m", self.rest_length_m, MAX_COORDINATE)?,
            stiffness: value("stiffness_n_per_m", self.stiffness_n_per_m, MAX_COEFFICIENT)?,
            damping: value("damping_n_s_per_m", self.damping_n_s_per_m, MAX_COEFFICIENT)?,
        })
    }

    /// Checks the other values, except the pieces.
    fn check_law(&self, position: usize) -> Result<(), Violation> {
        let path = format!("springs[{position}]");
        if let Some(k) = self.compression_stiffness_n_per_m {
            coefficient(format_args!("{path}.compression_stiffness_n_per_m"), k)?;
        }
        if self.rest_length_m == 0.0 && self.is_piecewise() {
            let expected = "above 0: strain is relative to it";
            return Err(Violation::new(format!("{path}.rest_length_m"), 0, expected));
        }
        if let Some(rigidity) = self.buckling_rigidity_n_m2 {
            let key = format!("{path}.buckling_rigidity_n_m2");
            check_rigidity(&key, rigidity, self.effect)?;
            let steepest = Buckling::new(1.0, rigidity, self.rest_length_m).steepest_buckled();
            if steepest.is_nan() || steepest > MAX_COEFFICIENT {
                let expected = format!(
                    "small enough that a spring of {} m has a stiffness of at most {}",
                    number(self.rest_length_m),
                    number(MAX_COEFFICIENT)
                );
                return Err(Violation::new(key, number(rigidity), expected));
            }
        }
        Ok(())
    }

    /// Checks the pieces.
    fn check_curve(&self, position: usize) -> Result<(), Violation> {
        let path = format!("springs[{position}]");
        check_pieces(&path, &self.pieces)?;
        match self.pieces.first().map(|first| first.stiffness_n_per_m) {
            Some(first) if first != self.stiffness_n_per_m => {
                let expected = format!("{}, the stiffness of the first piece", number(first));
                let found = number(self.stiffness_n_per_m);
                Err(Violation::new(format!("{path}.stiffness_n_per_m"), found, expected))
            }
            _ => Ok(()),
        }
    }

    /// Its tension when stretched. Its values must be valid.
    fn curve(&self) -> Curve {
        let ends = |p: &PieceSpec| (p.stiffness_n_per_m, p.up_to_strain.unwrap_or(f64::INFINITY));
        match &*self.pieces {
            [] => Curve::new([(self.stiffness_n_per_m, f64::INFINITY)]),
            pieces => Curve::new(pieces.iter().map(ends)),
        }
    }

    /// Its tension over its length. Its values must be valid.
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

    /// Everything that [`law`](Self::law) depends on besides the curve.
    fn compression_key(&self) -> [u64; 3] {
        let buckling = self.buckling_rigidity_n_m2;
        let rest_length = buckling.map(|_| self.rest_length_m);
        [self.compression_stiffness_n_per_m, buckling, rest_length].map(bits)
    }
}

/// A distinct bit pattern for each value, including `None`.
fn bits(value: Option<f64>) -> u64 {
    value.map_or(u64::MAX, f64::to_bits)
}

/// The different laws of the springs of one effect, and the law of each spring. Laws share their
/// curves: a strip that buckles has a law of its own for each rest length.
#[derive(Debug, Default)]
struct Laws {
    known_curves: HashMap<Vec<u64>, u32>,
    /// By first use.
    curves: Vec<Curve>,
    /// Pieces and bits of the stiffness of the last spring, and its curve.
    last: Option<(Arc<[PieceSpec]>, u64, u32)>,
    known: HashMap<(u32, [u64; 3]), u32>,
    /// By first use.
    list: Vec<TensionLaw>,
    /// A law for each spring.
    of: Vec<u32>,
}

impl Laws {
    /// Adds the next spring, which stands at `position` in the specification.
    fn push(&mut self, spec: &SpringSpec, position: usize) -> Result<(), Violation> {
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

    /// The place of a spring's curve in the list. Pieces that the spring shares with the one before
    /// are not checked again.
    fn curve(&mut self, spec: &SpringSpec, position: usize) -> Result<u32, Violation> {
        let stiffness = spec.stiffness_n_per_m.to_bits();
        if let Some((pieces, bits, curve)) = &self.last
            && Arc::ptr_eq(pieces, &spec.pieces)
            && *bits == stiffness
        {
            return Ok(*curve);
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
