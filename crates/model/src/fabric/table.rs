//! Tables of measured bending rigidities: the format of the 618 fabrics of X. Feng, W. Huang, W. Xu
//! and H. Wang (2022, *Learning-based bending stiffness parameter estimation by a drape tester*, ACM
//! Transactions on Graphics 41(6), 221, doi:10.1145/3550454.3555464).
//!
//! drape does not ship that table: it has no licence. [`Table::load`] reads it from the user's
//! disk. The first line names the columns, with their units in brackets:
//!
//! | column | meaning | here |
//! |---|---|---|
//! | `density[kg.m-2]` | areal density | kg/m² |
//! | `linear warp[SI*1e9]`, `weft`, `diag` | bending rigidity at small curvature | times 1e-9: N m |
//! | `nonlinear warp[SI*1e12]`, `weft`, `diag` | its change with the curvature | not used |
//!
//! The columns may stand in any order, and others are skipped. The table has no tension or shear,
//! so a scene must give both. The nonlinear terms let rigidities fall as the curvature grows. Their
//! unit is not stated, so drape leaves them out.

use super::material::read_within;
use super::{Material, Woven};
use crate::bounds::{MAX_COEFFICIENT, number, positive};
use crate::error::{Violation, shorten};

/// Most rows.
pub(super) const MAX_ROWS: u32 = 1_000_000;

/// A fabric of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Mass over area, kg/m².
    pub areal_density_kg_m2: f64,
    /// Bending rigidity, N m.
    pub bending_n_m: Woven,
    /// Bending rigidity at 45° to both, N m, if the table has it.
    pub diagonal_n_m: Option<f64>,
}

impl Row {
    /// A material with the density and the bending rigidities of this fabric. Tension, shear and
    /// retardation come from `like`: their keys are listed in `assumed`, and `source` names that
    /// material.
    pub fn material(&self, name: &str, source: &str, like: &Material) -> Material {
        Material {
            name: name.to_owned(),
            source: format!(
                "{source}. Areal density and bending are measured; tension, shear and retardation \
                 are those of {}.",
                like.name
            ),
            assumed: ["tension_n_per_m", "shear_n_per_m", "retardation_s"]
                .map(str::to_owned)
                .into(),
            areal_density_kg_m2: self.areal_density_kg_m2,
            bending_n_m: self.bending_n_m,
            ..like.clone()
        }
    }
}

/// A table of fabrics, as read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The fabrics, in the order of the file.
    pub rows: Vec<Row>,
}

/// What a scene's material starts from.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Base {
    /// All constants.
    Material(Material),
    /// Those of a table.
    Row(Row),
}

/// The columns that drape reads, by the start of their names; with the factor to SI units.
const COLUMNS: [(&str, &str, f64); 4] = [
    ("density", "[kg.m-2]", 1.0),
    ("linear warp", "[SI*1e9]", 1e-9),
    ("linear weft", "[SI*1e9]", 1e-9),
    ("linear diag", "[SI*1e9]", 1e-9),
];
/// The first so many of them must be there.
const NEEDED: usize = 3;

impl Table {
    /// Reads a table from a file. Messages name the file.
    ///
    /// # Errors
    /// A [`Violation`] if the file cannot be read or is too long, or as in [`parse`](Self::parse).
    pub fn load(file: &str) -> Result<Self, Violation> {
        let expected = "a table of fabrics (CSV) of at most 16 MiB";
        Self::parse(&read_within(file, None, "table", expected)?, file)
    }

    /// Reads a table from its text. In messages, `path` stands for the key that named the text.
    ///
    /// # Errors
    /// The first [`Violation`], with the number of the line.
    ///
    /// ```
    /// let text = "density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9]\n0.2, 9000, 7000\n";
    /// let table = drape_model::fabric::Table::parse(text, "table")?;
    /// assert!((table.rows[0].bending_n_m.warp - 9e-6).abs() < 1e-18);
    /// # Ok::<(), drape_model::Violation>(())
    /// ```
    pub fn parse(text: &str, path: &str) -> Result<Self, Violation> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines = text.lines().zip(1_u32..);
        let (header, _) = lines.next().unwrap_or_default();
        let names: Vec<&str> = header.split(',').map(str::trim).collect();
        let mut places = [None; COLUMNS.len()];
        for (place, (name, unit, _)) in places.iter_mut().zip(COLUMNS) {
            *place = names.iter().position(|known| *known == format!("{name}{unit}"));
        }
        if let Some(gone) = places[..NEEDED].iter().position(Option::is_none) {
            let (name, unit, _) = COLUMNS[gone];
            let found = format!("{:?}, without {name}{unit}", shorten(header));
            let expected = "a first line that names the columns density[kg.m-2], \
                            linear warp[SI*1e9] and linear weft[SI*1e9], parted by commas";
            return Err(Violation::new(format!("{path}, line 1"), found, expected));
        }
        let mut rows = Vec::new();
        for (line, place) in lines.filter(|(line, _)| !line.trim().is_empty()) {
            if rows.len() == MAX_ROWS as usize {
                let expected = format!("at most {MAX_ROWS} rows");
                return Err(Violation::new(format!("{path}, line {place}"), "one more", expected));
            }
            rows.push(Self::line(line, &places, &format!("{path}, line {place}"))?);
        }
        if rows.is_empty() {
            return Err(Violation::new(path, "a table without rows", "at least one row"));
        }
        Ok(Self { rows })
    }

    fn line(line: &str, places: &[Option<usize>; 4], at: &str) -> Result<Row, Violation> {
        let values: Vec<&str> = line.split(',').map(str::trim).collect();
        let value = |column: usize| -> Result<Option<f64>, Violation> {
            let Some(place) = places[column] else { return Ok(None) };
            let (name, _, factor) = COLUMNS[column];
            let path = format!("{at}, {name}");
            let Some(word) = values.get(place) else {
                let expected = format!("a number in column {}", place + 1);
                return Err(Violation::new(path, "missing", expected));
            };
            let Ok(number) = word.parse::<f64>() else {
                return Err(Violation::new(path, format!("{word:?}"), "a number above 0"));
            };
            Ok(Some(positive(path, number, MAX_COEFFICIENT)? * factor))
        };
        let needed = |column| value(column).map(Option::unwrap_or_default);
        Ok(Row {
            areal_density_kg_m2: needed(0)?,
            bending_n_m: Woven { warp: needed(1)?, weft: needed(2)? },
            diagonal_n_m: value(3)?,
        })
    }

    /// The fabric of a row, counted from 1.
    ///
    /// # Errors
    /// A [`Violation`] at `path` if there is no such row.
    pub fn row(&self, row: u32, path: &str) -> Result<Row, Violation> {
        let place = (row as usize).checked_sub(1);
        place.and_then(|place| self.rows.get(place)).copied().ok_or_else(|| {
            let expected = format!("a row of the table, from 1 to {}", self.rows.len());
            Violation::new(path, number(f64::from(row)), expected)
        })
    }
}
