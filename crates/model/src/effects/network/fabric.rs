//! Fabrics with measured tension, and their springs.

use super::{PieceSpec, SpringEffect, SpringLaw, StretchLaw};
use crate::error::Violation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A fabric with measured tension along warp and weft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fabric {
    /// A woven wool cloth of 0.15 kg/m²: force-strain tests as tabulated in `Materials.h` of R.
    /// Strohkorb's cloth simulation, every fourth sample.
    Wool,
}

/// Tension per width, N/m, at equal steps of the strain from 0.
struct Curve {
    step: f64,
    tension: [f64; 8],
}

/// Every fourth of 29 samples, which lie 0.00048614 apart.
const WOOL_WARP: Curve = Curve {
    step: 4.0 * 0.00048614,
    tension: [
        0.0,
        33.93213573,
        79.6812749,
        198.8071571,
        476.1904762,
        1069.306931,
        1897.233202,
        2998.027613,
    ],
};

/// Every fourth of 29 samples, which lie 0.004078 apart.
const WOOL_WEFT: Curve = Curve {
    step: 4.0 * 0.004078,
    tension: [
        0.0,
        14.76377953,
        48.4496124,
        95.41984733,
        211.4661654,
        365.7407407,
        656.9343066,
        1052.158273,
    ],
};

impl Curve {
    /// The law of springs of this length, m, each standing for a strip of cloth of this width, m.
    /// It is linear between the samples and keeps the last slope beyond them.
    fn springs(&self, length: f64, width: f64) -> StretchLaw {
        let last = self.tension.len() - 1;
        let piece = |k: usize| PieceSpec {
            up_to_strain: (k < last).then_some(k as f64 * self.step),
            stiffness_n_per_m: (self.tension[k] - self.tension[k - 1]) / self.step
                * (width / length),
        };
        StretchLaw { pieces: (1..=last).map(piece).collect(), ..StretchLaw::default() }
    }
}

impl SpringLaw {
    /// Replaces the name of a fabric by its curves. Every spring of a grid stands for a strip as
    /// wide as the mesh, also at the border. So a sheet of `n` rows is stiffer than `n − 1` strips
    /// by one part in `n − 1`. `spacing` is the distance of the particles along x (the warp) and y,
    /// m; 0 along a direction with a single particle.
    pub(super) fn of_fabric(
        &self,
        effect: SpringEffect,
        spacing: [f64; 2],
    ) -> Result<Self, Violation> {
        let Some(fabric) = self.fabric else { return Ok(self.clone()) };
        let path = format!("effects.{}.fabric", effect.name());
        if effect != SpringEffect::Tension {
            let found = format!("given for {}", effect.name());
            return Err(Violation::new(path, found, "this key with tension springs only"));
        }
        let others = [
            ("stiffness_n_per_m", self.stiffness_n_per_m.is_some()),
            ("stiffness_over_mass_per_s2", self.stiffness_over_mass_per_s2.is_some()),
            ("pieces", !self.pieces.is_empty()),
            ("compression_stiffness_n_per_m", self.compression_stiffness_n_per_m.is_some()),
            ("warp", self.warp.is_some()),
            ("weft", self.weft.is_some()),
        ];
        if let Some((key, _)) = others.into_iter().find(|(_, is_given)| *is_given) {
            let found = format!("given beside `{key}`");
            return Err(Violation::new(path, found, "one of the two only"));
        }
        let [dx, dy] = spacing;
        if dx == 0.0 || dy == 0.0 {
            let found = "given for a single row or column";
            let expected =
                "a grid of at least 2 rows and 2 columns, whose springs stand for strips between";
            return Err(Violation::new(path, found, expected));
        }
        let [warp, weft] = match fabric {
            Fabric::Wool => [WOOL_WARP, WOOL_WEFT],
        };
        let (warp, weft) = (warp.springs(dx, dy), weft.springs(dy, dx));
        Ok(Self { fabric: None, warp: Some(warp), weft: Some(weft), ..self.clone() })
    }
}
