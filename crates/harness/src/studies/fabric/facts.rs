//! Records of the experiment `fabric`: strips that bend and cloths that drape, at rest.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A specimen is at rest if no force on a particle exceeds this share of the heaviest one's weight.
pub const AT_REST: f64 = 1e-4;

/// Relative error of a strip's drop over reach up to which a model counts as right.
pub(super) const RIGHT: f64 = 0.02;

/// All specimens.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Cantilevers: one for each model, `Γ` and mesh.
    pub bent: Vec<Bent>,
    /// Cantilevers of several widths.
    pub widths: Vec<Width>,
    /// Strips on edge, which buckle to the side.
    pub edgewise: Vec<Edgewise>,
    /// The bundled materials.
    pub cloths: Vec<Cloth>,
    /// Published bands of the drape coefficient.
    pub bands: Vec<Band>,
    /// Drape tests: one for each material, mesh and start.
    pub drapes: Vec<Drape>,
}

/// The model of bending in a strip, and its stiffness for the rigidity `B`.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// Springs for the angle at each particle of a row.
    Angles,
    /// Hinges of stiffness `3 B/8` on equilateral triangles.
    Triangles,
    /// Hinges of stiffness `5 B/12` on squares that are cut along one diagonal.
    Squares,
    /// Hinges of stiffness `B/3` on the same squares. The value is that of a wide sheet.
    SquaresAsSheet,
    /// Springs to the next particle but one, which buckle (Choi and Ko 2002).
    Buckling,
    /// Linear springs to the next particle but one, fitted at one curvature.
    Springs,
}

impl Model {
    /// All models, in the order of figures and tables.
    pub const ALL: [Self; 6] = [
        Self::Angles,
        Self::Triangles,
        Self::Squares,
        Self::SquaresAsSheet,
        Self::Buckling,
        Self::Springs,
    ];

    /// Its name in figures and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Angles => "angles along rows",
            Self::Triangles => "hinges on triangles, k = 3B/8",
            Self::Squares => "hinges on squares, k = 5B/12",
            Self::SquaresAsSheet => "hinges on squares, k = B/3",
            Self::Buckling => "springs that buckle",
            Self::Springs => "linear springs",
        }
    }
}

impl std::fmt::Display for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A strip that is clamped at one end and bends under its weight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bent {
    /// The model of bending.
    pub model: Model,
    /// The load, `Γ = ρ g L³/B`.
    pub gamma: f64,
    /// Number of edges along the free length.
    pub segments: u32,
    /// Number of particles.
    pub particles: usize,
    /// Drop of the free end over its reach, `H/W`; `None` if the reach is not positive.
    pub drop_over_reach: Option<f64>,
    /// Drop over reach of the exact inextensible strip.
    pub exact: f64,
    /// Greatest force on a particle, over the weight of the heaviest.
    pub residual: f64,
    /// Iterations of Newton's method.
    pub iterations: usize,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

impl Bent {
    /// Relative error of the drop over reach; `None` if the strip is not at rest.
    pub fn error(&self) -> Option<f64> {
        let found = self.drop_over_reach.filter(|_| self.residual <= AT_REST)?;
        Some(found / self.exact - 1.0)
    }
}

/// A cantilever with one of several widths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Width {
    /// The model of bending.
    pub model: Model,
    /// `Γ` for the rigidity of the wide sheet.
    pub gamma: f64,
    /// Number of rows of particles across the width.
    pub rows: u32,
    /// Width over free length.
    pub width_over_length: f64,
    /// Drop of the free end over its reach.
    pub drop_over_reach: f64,
    /// The rigidity `B` of the exact strip with the same drop over reach, divided by the model's
    /// stiffness `k`.
    pub rigidity_over_stiffness: f64,
    /// Rigidity over stiffness of a narrow strip, as derived in theory.
    pub narrow: f64,
    /// Rigidity over stiffness of a wide sheet, as derived in theory.
    pub wide: f64,
    /// As in [`Bent::residual`].
    pub residual: f64,
    /// As in [`Bent::iterations`].
    pub iterations: usize,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// A strip on edge, i.e. with its width upright. Above a critical weight it buckles to the side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Edgewise {
    /// The model of bending.
    pub model: Model,
    /// Number of rows of particles across the width.
    pub rows: u32,
    /// Number of edges along the free length.
    pub segments: u32,
    /// Whether the strip is turned over, so that its diagonals rise towards the free end.
    pub turned: bool,
    /// Width over free length.
    pub width_over_length: f64,
    /// `Γ = ρ g L³/B` at which the upright strip stops being a minimum of the energy. `None` if it
    /// is one up to the greatest `Γ` that was tried.
    pub critical_gamma: Option<f64>,
    /// `Γ` at which a slender beam with the strip's rigidities buckles; `None` if they are not
    /// known.
    pub law: Option<f64>,
    /// Greatest residual of the upright rest positions that were tried.
    pub residual: f64,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// A bundled material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cloth {
    /// Name of the material.
    pub name: String,
    /// Mass over area, kg/m².
    pub areal_density_kg_m2: f64,
    /// Bending rigidity of warp and weft, N m.
    pub bending_n_m: [f64; 2],
    /// Bending length `(B/(ρ g))^⅓` of warp and weft, m.
    pub bending_length_m: [f64; 2],
    /// Class of the published band for the material, if it has one.
    pub class: Option<String>,
}

/// A published band of the drape coefficient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Band {
    /// The class of materials.
    pub class: String,
    /// Least coefficient.
    pub least: f64,
    /// Greatest coefficient.
    pub greatest: f64,
}

/// A drape test: a cloth of 30 cm on a table of 18 cm (BS 5058).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drape {
    /// Name of the material.
    pub cloth: String,
    /// Number of squares across the diameter.
    pub cells: u32,
    /// Number of waves around the circumference at the start.
    pub waves: u32,
    /// Number of particles.
    pub particles: usize,
    /// The drape coefficient: the share of the overhang that the shadow covers.
    pub coefficient: f64,
    /// As in [`Bent::residual`].
    pub residual: f64,
    /// Whether the rest position is a minimum of the energy, not a saddle.
    pub is_minimum: bool,
    /// As in [`Bent::iterations`].
    pub iterations: usize,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

impl Drape {
    /// Whether the cloth is at rest and in a minimum of the energy.
    pub fn is_at_rest(&self) -> bool {
        self.residual <= AT_REST && self.is_minimum
    }
}

impl Facts {
    /// The numbers of edges along the free length, ascending.
    pub(super) fn meshes(&self) -> Vec<u32> {
        let mut meshes: Vec<u32> = self.bent.iter().map(|bent| bent.segments).collect();
        meshes.sort_unstable();
        meshes.dedup();
        meshes
    }

    /// The values of `Γ`, ascending.
    pub(super) fn gammas(&self) -> Vec<f64> {
        let mut gammas: Vec<f64> = self.bent.iter().map(|bent| bent.gamma).collect();
        gammas.sort_by(f64::total_cmp);
        gammas.dedup();
        gammas
    }

    /// The cantilever of a model with this `Γ` and number of edges, if the record has it.
    pub(super) fn bent(&self, model: Model, gamma: f64, segments: u32) -> Option<&Bent> {
        let is_it = |b: &&Bent| (b.model, b.gamma, b.segments) == (model, gamma, segments);
        self.bent.iter().find(is_it)
    }

    /// Observed order of convergence to the exact strip, from the two finest meshes at rest. `None`
    /// if the error does not fall.
    pub(super) fn order(&self, model: Model, gamma: f64) -> Option<f64> {
        let errors = self.meshes().into_iter().filter_map(|segments| {
            let error = self.bent(model, gamma, segments)?.error()?;
            Some((f64::from(segments), libm::fabs(error)))
        });
        let errors: Vec<_> = errors.collect();
        let [.., (coarse, before), (fine, after)] = errors[..] else { return None };
        let order = libm::log2(before / after) / libm::log2(fine / coarse);
        (order.is_finite() && order > 0.0).then_some(order)
    }

    /// Least and greatest drape coefficient of a material at rest, over meshes and starts.
    pub(super) fn spread(&self, cloth: &str) -> Option<[f64; 2]> {
        let own = self.drapes.iter().filter(|drape| drape.cloth == cloth && drape.is_at_rest());
        own.map(|drape| drape.coefficient).fold(None, |spread: Option<[f64; 2]>, c| {
            let [least, greatest] = spread.unwrap_or([c, c]);
            Some([least.min(c), greatest.max(c)])
        })
    }

    /// The band of a material's class.
    pub(super) fn band(&self, cloth: &Cloth) -> Option<&Band> {
        let class = cloth.class.as_ref()?;
        self.bands.iter().find(|band| band.class == *class)
    }
}
