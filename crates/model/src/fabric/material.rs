//! Materials as data, and how a scene names one.

use super::{HingeFit, table};
use crate::bounds::{MAX_COEFFICIENT, positive, within};
use crate::error::{Violation, nearest};
use crate::strict::Strict;
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};
use std::fmt::{Formatter, Result as FmtResult};
use std::io::Read as _;
use std::path::Path;
use std::sync::Arc;

/// The value of `format` in a file with a material.
pub(super) const MATERIAL_FORMAT: &str = "drape-material/1";
/// Longest retardation time, s.
const MAX_RETARDATION: f64 = 1e6;
/// Most bytes of a file with a material or a table of materials.
const MAX_FILE: u64 = 16 << 20;

/// A constant with one value along the warp and one along the weft.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Woven {
    /// Along the warp.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub warp: f64,
    /// Along the weft.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub weft: f64,
}

impl Woven {
    /// The same value along warp and weft.
    pub fn even(value: f64) -> Self {
        Self { warp: value, weft: value }
    }

    /// The mean along both.
    pub(super) fn mean(self) -> Self {
        Self::even(0.5 * (self.warp + self.weft))
    }

    fn check(self, path: &str) -> Result<(), Violation> {
        positive(format_args!("{path}.warp"), self.warp, MAX_COEFFICIENT)?;
        positive(format_args!("{path}.weft"), self.weft, MAX_COEFFICIENT).map(drop)
    }
}

/// A cloth's measured constants, as a file of format "drape-material/1" gives them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Always "drape-material/1".
    #[schemars(extend("const" = MATERIAL_FORMAT))]
    pub format: String,
    /// Short name.
    pub name: String,
    /// The cloth, and the publication that gives its numbers.
    #[serde(default)]
    pub source: String,
    /// Keys whose values drape assumed because the source does not state them.
    #[serde(default)]
    pub assumed: Vec<String>,
    /// Mass over area, kg/m².
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub areal_density_kg_m2: f64,
    /// Tensile rigidity: tension per width over strain, N/m.
    pub tension_n_per_m: Woven,
    /// Shear rigidity: shear force per width over the shear angle, N/m.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub shear_n_per_m: f64,
    /// Bending rigidity: moment per width over curvature, N m.
    pub bending_n_m: Woven,
    /// Retardation time `τ` of the springs, s. Every spring is a Kelvin–Voigt element whose damping
    /// is `τ` times its stiffness. Without this key there is no damping.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = MAX_RETARDATION))]
    pub retardation_s: f64,
}

macro_rules! materials {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../materials/", $name, ".json")))),+]
    };
}

/// Name and JSON text of each bundled material.
static MATERIALS: &[(&str, &str)] =
    materials!["denim", "cotton-blend", "tablecloth", "fleece", "ponte"];

impl Material {
    /// Names of the bundled materials.
    pub fn bundled() -> impl Iterator<Item = &'static str> {
        MATERIALS.iter().map(|(name, _)| *name)
    }

    /// The JSON text of a bundled material; `None` for an unknown name.
    pub fn text(name: &str) -> Option<&'static str> {
        MATERIALS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// Loads a bundled material by name, or a material from a file in the JSON format
    /// "drape-material/1".
    ///
    /// # Errors
    /// A [`Violation`] whose path is `of` if the name is unknown, the file cannot be read, or its
    /// text is broken. A [`Violation`] at the key of the material if a value is out of range.
    ///
    /// ```
    /// let denim = drape_model::fabric::Material::load("denim")?;
    /// assert_eq!(denim.areal_density_kg_m2, 0.324);
    /// # Ok::<(), drape_model::Violation>(())
    /// ```
    pub fn load(of: &str) -> Result<Self, Violation> {
        Self::find(of, None, "of")
    }

    /// As [`load`](Self::load), by a path from `folder`; messages call the key `path`.
    fn find(of: &str, folder: Option<&Path>, path: &str) -> Result<Self, Violation> {
        match Self::text(of) {
            Some(text) => Self::parse(text, path),
            None => Self::parse(&read_text(of, folder, path)?, path),
        }
    }

    /// Reads a material from JSON text. In messages, `path` stands for the key that named the text.
    ///
    /// # Errors
    /// A [`Violation`]: the place in the text, the value found and the expected values.
    pub fn parse(text: &str, path: &str) -> Result<Self, Violation> {
        let mut json = serde_json::Deserializer::from_str(text);
        let outcome: Result<Self, _> = serde_path_to_error::deserialize(Strict(&mut json));
        let material = outcome.map_err(|error| {
            let at = format!("{path}, {}", error.path());
            let expected = format!("a material of format {MATERIAL_FORMAT:?}");
            Violation::new(at, format!("not readable: {}", error.inner()), expected)
        })?;
        if material.format != MATERIAL_FORMAT {
            let found = format!("{:?}", material.format);
            let expected = format!("{MATERIAL_FORMAT:?}");
            return Err(Violation::new(format!("{path}, format"), found, expected));
        }
        material.check(&format!("{path}, "))?;
        Ok(material)
    }

    /// Checks all constants; `before` stands before each key in messages.
    pub(super) fn check(&self, before: &str) -> Result<(), Violation> {
        let positive_at = |key: &str, value| {
            positive(format_args!("{before}{key}"), value, MAX_COEFFICIENT).map(drop)
        };
        positive_at("areal_density_kg_m2", self.areal_density_kg_m2)?;
        self.tension_n_per_m.check(&format!("{before}tension_n_per_m"))?;
        positive_at("shear_n_per_m", self.shear_n_per_m)?;
        self.bending_n_m.check(&format!("{before}bending_n_m"))?;
        let path = format!("{before}retardation_s");
        within(path, self.retardation_s, 0.0, MAX_RETARDATION).map(drop)
    }
}

/// Reads a file of the user that a scene in `folder` names.
fn read_text(of: &str, folder: Option<&Path>, path: &str) -> Result<String, Violation> {
    let known: Vec<_> = Material::bundled().collect();
    let from = if folder.is_some() { " from the scene's folder" } else { "" };
    let expected = format!(
        "one of the materials {}{}, or a file of at most {} MiB by its path{from}",
        known.join(", "),
        nearest(of, known.iter().copied()),
        MAX_FILE >> 20
    );
    read_within(of, folder, path, &expected)
}

/// Reads a file of the user; a refusal says what was `expected`.
pub(super) fn read_within(
    of: &str,
    folder: Option<&Path>,
    path: &str,
    expected: &str,
) -> Result<String, Violation> {
    let refuse = |reason: String| Violation::new(path, format!("{of:?}, {reason}"), expected);
    let file = folder.unwrap_or(Path::new("")).join(of);
    // Opening a pipe would wait for a writer.
    let kind = file.metadata().map_err(|error| refuse(format!("unreadable: {error}")))?;
    if !kind.is_file() || kind.len() > MAX_FILE {
        return Err(refuse("no regular file of that size".to_owned()));
    }
    let reader =
        std::fs::File::open(&file).map_err(|error| refuse(format!("unreadable: {error}")))?;
    let mut text = String::new();
    let read = reader.take(MAX_FILE).read_to_string(&mut text);
    read.map_err(|error| refuse(format!("unreadable: {error}")))?;
    Ok(text)
}

/// The element that resists shear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ShearModel {
    /// Springs along the diagonals of the cells: effect `shear`.
    #[default]
    Springs,
    /// Angles between warp and weft, on a grid: effect `shear_angle`.
    Angles,
}

/// The element that resists bending.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BendingModel {
    /// Hinges between triangles: effect `bending_hinge`.
    #[default]
    Hinges,
    /// Angles along rows and columns, on a grid: effect `bending_angle`.
    Angles,
    /// Springs that buckle, on a grid: effect `bending`.
    Buckling,
}

/// Which direction of a cloth is its warp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Directions {
    /// Along the rows of a grid; along the first texture coordinate of a mesh.
    #[default]
    Woven,
    /// No direction. The cloth takes the mean of warp and weft in all directions.
    Mean,
}

/// The material of a scene's cloth: the name of a bundled one, or an object with these keys. Keys
/// with constants replace those of the material that `of` names. Without `of` all constants are
/// required.
///
/// The material gives the mass, and the effects tension, shear and bending of the cloth. An effect
/// that the scene names replaces the material's effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct MaterialChoice {
    /// Name of a bundled material, or path of a file from the scene's folder: JSON of format
    /// "drape-material/1", or a table of measured bending rigidities (CSV).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// Row of a table, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = table::MAX_ROWS))]
    pub row: Option<u32>,
    /// Mass over area, kg/m².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub areal_density_kg_m2: Option<f64>,
    /// Tensile rigidity, N/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tension_n_per_m: Option<Woven>,
    /// Shear rigidity, N/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = MAX_COEFFICIENT))]
    pub shear_n_per_m: Option<f64>,
    /// Bending rigidity, N m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bending_n_m: Option<Woven>,
    /// Damping over stiffness of the springs, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_RETARDATION))]
    pub retardation_s: Option<f64>,
    /// Element that resists shear.
    #[serde(default, skip_serializing_if = "is_default")]
    pub shear_model: ShearModel,
    /// Element that resists bending.
    #[serde(default, skip_serializing_if = "is_default")]
    pub bending_model: BendingModel,
    /// How hinges fit the bending rigidity.
    #[serde(default, skip_serializing_if = "is_default")]
    pub hinge_fit: HingeFit,
    /// Where the cloth has its warp.
    #[serde(default, skip_serializing_if = "is_default")]
    pub directions: Directions,
    /// The content of the file that `of` names, once it is read; the default before.
    #[serde(skip)]
    #[schemars(skip)]
    pub base: Loaded,
}

/// Content of the file that a [`MaterialChoice`] names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loaded(Option<Arc<table::Base>>);

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// The key in the schema.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[allow(dead_code, reason = "only its schema is used")]
pub(crate) enum MaterialKey {
    /// Name of a bundled material, or path of a file.
    Name(String),
    /// A material with keys of its own.
    Keys(MaterialChoice),
}

impl Serialize for MaterialChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.of {
            Some(of) if *self == Self { base: self.base.clone(), ..Self::named(of) } => {
                serializer.serialize_str(of)
            }
            _ => Self::serialize(self, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for MaterialChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ChoiceVisitor)
    }
}

struct ChoiceVisitor;

impl<'de> Visitor<'de> for ChoiceVisitor {
    type Value = MaterialChoice;

    fn expecting(&self, out: &mut Formatter<'_>) -> FmtResult {
        out.write_str("the name of a material in quotes or an object")
    }

    fn visit_str<E: Error>(self, of: &str) -> Result<MaterialChoice, E> {
        Ok(MaterialChoice::named(of))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MaterialChoice, A::Error> {
        MaterialChoice::deserialize(Strict(MapAccessDeserializer::new(map)))
    }
}

impl MaterialChoice {
    /// A choice by `of`: the name of a bundled material, or the path of a file.
    pub fn named(of: &str) -> Self {
        Self { of: Some(of.to_owned()), ..Self::default() }
    }

    /// A choice that gives all constants of `material`.
    pub fn given(material: &Material) -> Self {
        Self {
            areal_density_kg_m2: Some(material.areal_density_kg_m2),
            tension_n_per_m: Some(material.tension_n_per_m),
            shear_n_per_m: Some(material.shear_n_per_m),
            bending_n_m: Some(material.bending_n_m),
            retardation_s: Some(material.retardation_s),
            ..Self::default()
        }
    }

    /// Reads the file that the scene names; `folder` is the folder of the scene. A bundled material
    /// needs no file.
    pub(crate) fn load(&mut self, folder: Option<&Path>) -> Result<(), Violation> {
        let Some(of) = &self.of else { return Ok(()) };
        let path = "material.of";
        if Material::text(of).is_some() {
            return Ok(());
        }
        let text = read_text(of, folder, path)?;
        let is_table = Path::new(of).extension().is_some_and(|end| end.eq_ignore_ascii_case("csv"));
        let base = if is_table {
            let rows = table::Table::parse(&text, path)?;
            let Some(row) = self.row else {
                let expected =
                    format!("the number of a row of the table, from 1 to {}", rows.rows.len());
                return Err(Violation::new("material.row", "missing", expected));
            };
            table::Base::Row(rows.row(row, "material.row")?)
        } else {
            table::Base::Material(Material::parse(&text, path)?)
        };
        self.base = Loaded(Some(Arc::new(base)));
        Ok(())
    }

    /// All constants of the chosen material.
    ///
    /// # Errors
    /// A [`Violation`] if a constant is missing or out of range, if a name is unknown, or if the
    /// file was not read.
    pub fn resolve(&self) -> Result<Material, Violation> {
        let bundled = match &self.of {
            Some(of) if self.base.0.is_none() => {
                Some(table::Base::Material(match Material::text(of) {
                    Some(text) => Material::parse(text, "material.of")?,
                    None => {
                        let known: Vec<_> = Material::bundled().collect();
                        let expected = format!(
                            "one of the materials {}, or a file of a scene from `load` or `parse`",
                            known.join(", ")
                        );
                        return Err(Violation::new("material.of", format!("{of:?}"), expected));
                    }
                }))
            }
            _ => None,
        };
        let base = bundled.as_ref().or(self.base.0.as_deref());
        if let (Some(row), false) = (self.row, matches!(base, Some(table::Base::Row(_)))) {
            let expected = "no such key: only a table (CSV) has rows";
            return Err(Violation::new("material.row", row, expected));
        }
        let (whole, row) = match base {
            Some(table::Base::Material(material)) => (Some(material), None),
            Some(table::Base::Row(row)) => (None, Some(row)),
            None => (None, None),
        };
        let missing = |key: &str| {
            let expected = match (&self.of, row) {
                (Some(_), _) => "this key: the table has no such column",
                (None, _) => "this key, or `of` with the name of a material",
            };
            Violation::new(format!("material.{key}"), "missing", expected)
        };
        let density = self.areal_density_kg_m2.or(row.map(|row| row.areal_density_kg_m2));
        let bending = self.bending_n_m.or(row.map(|row| row.bending_n_m));
        let material = Material {
            format: MATERIAL_FORMAT.to_owned(),
            name: whole.map_or_else(|| "own".to_owned(), |whole| whole.name.clone()),
            source: whole.map_or_else(String::new, |whole| whole.source.clone()),
            assumed: whole.map_or_else(Vec::new, |whole| whole.assumed.clone()),
            areal_density_kg_m2: density
                .or(whole.map(|whole| whole.areal_density_kg_m2))
                .ok_or_else(|| missing("areal_density_kg_m2"))?,
            tension_n_per_m: self
                .tension_n_per_m
                .or(whole.map(|whole| whole.tension_n_per_m))
                .ok_or_else(|| missing("tension_n_per_m"))?,
            shear_n_per_m: self
                .shear_n_per_m
                .or(whole.map(|whole| whole.shear_n_per_m))
                .ok_or_else(|| missing("shear_n_per_m"))?,
            bending_n_m: bending
                .or(whole.map(|whole| whole.bending_n_m))
                .ok_or_else(|| missing("bending_n_m"))?,
            retardation_s: self
                .retardation_s
                .or(whole.map(|whole| whole.retardation_s))
                .unwrap_or(0.0),
        };
        material.check("material.")?;
        Ok(material)
    }
}
