//! Selecting particles of a cloth by index, place, name or boundary.

use crate::bounds::LAST_PARTICLE;
use crate::bounds::{MAX_COORDINATE, MAX_PARTICLES};
use crate::bounds::{index, vector, within};
use crate::error::Violation;
use crate::path::Extent;
use crate::{Cloth, KeyframeSpec, ParticlesSpec, Path, PinSpec, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Most keyframes of all pins together. Each particle of a selection has its own.
const MAX_KEYFRAMES: usize = 1_000_000;

/// Most particles of all selections together. A particle may be in several.
const MAX_PINS: usize = 2 * MAX_PARTICLES;

/// A selection of particles, by exactly one criterion. The selected particles stand still or follow
/// a path.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pin {
    /// Index of a particle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = LAST_PARTICLE))]
    pub particle: Option<u32>,
    /// Row of a grid; the whole row unless a column is given too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = LAST_PARTICLE))]
    pub row: Option<u32>,
    /// Column of a grid; the whole column unless a row is given too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = LAST_PARTICLE))]
    pub column: Option<u32>,
    /// The particle that starts nearest to this point, m. If several are equally near, the one with
    /// the least index.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub near_m: Option<[f64; 3]>,
    /// All particles that start in the box between these two corners, the lower first, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE))))]
    pub within_m: Option<[[f64; 3]; 2]>,
    /// All particles of a group or object of a mesh's file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// All particles of this connected part of the boundary. Parts are numbered from 0, in the
    /// order of their least particle index.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = LAST_PARTICLE))]
    pub boundary: Option<u32>,
    /// Path of each selected particle, as displacements from its starting place. Without keyframes
    /// the particles stand still.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = crate::path::MAX_KEYFRAMES))]
    pub path: Vec<KeyframeSpec>,
}

/// A cloth with its particles and triangles.
pub(crate) struct Selectable<'a> {
    pub(crate) cloth: &'a Cloth,
    pub(crate) particles: &'a ParticlesSpec,
    pub(crate) triangles: &'a [[u32; 3]],
}

impl Selectable<'_> {
    /// All selected particles, each with the path of its selection.
    pub(crate) fn pins(&self, pins: &[Pin]) -> Result<Vec<PinSpec>, Violation> {
        let (mut found, mut keyframes) = (Vec::new(), 0);
        let mut moves = BTreeMap::new();
        for (position, pin) in pins.iter().enumerate() {
            let at = format!("pins[{position}]");
            let selected = self.select(&at, pin)?;
            if found.len() + selected.len() > MAX_PINS {
                let value = format!("{} particles after {}", selected.len(), found.len());
                let expected = format!("at most {MAX_PINS} particles in all selections together");
                return Err(Violation::new(at, value, expected));
            }
            let led = Extent::of(selected.iter().map(|&particle| self.position(particle)));
            let is_led = Path::check(&format!("{at}.path"), &pin.path, led)?.is_some();
            keyframes += selected.len() * pin.path.len();
            if keyframes > MAX_KEYFRAMES {
                let value = format!("{} keyframes for {}", pin.path.len(), selected.len());
                let expected =
                    format!("at most {MAX_KEYFRAMES} keyframes for all particles together");
                return Err(Violation::new(format!("{at}.path"), value, expected));
            }
            for particle in selected {
                if moves.insert(particle, is_led).is_some_and(|other| other || is_led) {
                    let value = format!("particle {particle}");
                    let expected = "each particle once where a pin has a path";
                    return Err(Violation::new(at, value, expected));
                }
                found.push(PinSpec { particle, path: pin.path.clone() });
            }
        }
        Ok(found)
    }

    /// The selected particles, at least one. Messages call the selection `path`.
    pub(crate) fn select(&self, path: &str, pin: &Pin) -> Result<Vec<u32>, Violation> {
        let keys = [
            pin.particle.is_some(),
            pin.row.is_some() || pin.column.is_some(),
            pin.near_m.is_some(),
            pin.within_m.is_some(),
            pin.name.is_some(),
            pin.boundary.is_some(),
        ];
        let is_single = keys.iter().filter(|&&is_given| is_given).count() == 1;
        match (pin, self.cloth) {
            _ if !is_single => {}
            (&Pin { particle: Some(particle), .. }, _) => {
                let count = self.particles.mass_kg.len();
                index(format_args!("{path}.particle"), particle, count)?;
                return Ok(vec![particle]);
            }
            (&Pin { near_m: Some(point), .. }, _) => return self.nearest(path, point),
            (&Pin { within_m: Some(corners), .. }, _) => return self.inside(path, corners),
            (&Pin { boundary: Some(part), .. }, _) => return self.boundary(path, part),
            (Pin { name: Some(name), .. }, Cloth::Mesh(mesh)) => {
                return mesh.named(&format!("{path}.name"), name);
            }
            (&Pin { row, column, name: None, .. }, Cloth::Grid(grid)) => {
                let range = |key: &str, value: Option<u32>, count: u32| match value {
                    None => Ok(0..count),
                    Some(value) if value < count => Ok(value..value + 1),
                    Some(value) => {
                        let expected = format!("a number from 0 to {}", count - 1);
                        Err(Violation::new(format!("{path}.{key}"), value, expected))
                    }
                };
                let rows = range("row", row, grid.rows)?;
                let columns = range("column", column, grid.columns)?;
                let of_row = |row| columns.clone().map(move |column| grid.index(row, column));
                return Ok(rows.flat_map(of_row).collect());
            }
            _ => {}
        }
        let place = Pin { path: Vec::new(), ..pin.clone() };
        let found = serde_json::to_string(&place).unwrap_or_default();
        let expected = "exactly one of `particle`, `near_m`, `within_m`, `boundary`, or `row` and \
                        `column` of a grid cloth, or `name` in a mesh's file";
        Err(Violation::new(path, found, expected))
    }

    fn position(&self, particle: u32) -> Vec3 {
        Vec3::from(self.particles.position_m[particle as usize])
    }

    fn positions(&self) -> impl Iterator<Item = (u32, Vec3)> {
        (0..).zip(self.particles.position_m.iter().map(|&x| Vec3::from(x)))
    }

    fn nearest(&self, path: &str, point: [f64; 3]) -> Result<Vec<u32>, Violation> {
        let point = vector(format_args!("{path}.near_m"), point)?;
        let off = |x: Vec3| (x - point).norm_squared();
        let nearest = self.positions().min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
        Ok(nearest.into_iter().map(|(particle, _)| particle).collect())
    }

    fn inside(&self, path: &str, [low, high]: [[f64; 3]; 2]) -> Result<Vec<u32>, Violation> {
        let path = format!("{path}.within_m");
        let lower = vector(format_args!("{path}[0]"), low)?;
        let upper = vector(format_args!("{path}[1]"), high)?;
        for axis in 0..3 {
            let most = MAX_COORDINATE;
            within(format_args!("{path}[1][{axis}]"), upper[axis], lower[axis], most)?;
        }
        let is_in = |x: &Vec3| (0..3).all(|axis| x[axis] >= lower[axis] && x[axis] <= upper[axis]);
        let inside = self.positions().filter(|(_, x)| is_in(x)).map(|(particle, _)| particle);
        let inside: Vec<_> = inside.collect();
        if inside.is_empty() {
            let found = format!("[{low:?}, {high:?}], without a particle");
            return Err(Violation::new(path, found, "a box with at least one particle"));
        }
        Ok(inside)
    }

    fn boundary(&self, path: &str, part: u32) -> Result<Vec<u32>, Violation> {
        let mut parts = boundary_parts(self.triangles);
        if (part as usize) < parts.len() {
            return Ok(parts.swap_remove(part as usize));
        }
        let expected = match parts.len() {
            0 => "another selection: the cloth has no boundary".to_owned(),
            count => format!("a part of the boundary from 0 to {}", count - 1),
        };
        Err(Violation::new(format!("{path}.boundary"), part, expected))
    }
}

/// The connected parts of the boundary: edges with one triangle only. Each part is sorted, and
/// parts are in the order of their first particles.
fn boundary_parts(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let sides = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)];
    let mut edges: Vec<_> =
        triangles.iter().flat_map(sides).map(|(a, b)| (a.min(b), a.max(b))).collect();
    edges.sort_unstable();
    let single = edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
    let mut links: Vec<_> = single.flatten().flat_map(|&(a, b)| [(a, b), (b, a)]).collect();
    links.sort_unstable();
    let mut is_seen = vec![false; links.len()];
    let first = |particle: u32| links.partition_point(|link| link.0 < particle);
    let mut parts = Vec::new();
    for start in 0..links.len() {
        // A particle is marked at the first of its links.
        let start = first(links[start].0);
        if is_seen[start] {
            continue;
        }
        is_seen[start] = true;
        let (mut part, mut open) = (Vec::new(), vec![links[start].0]);
        while let Some(particle) = open.pop() {
            part.push(particle);
            let own = links[first(particle)..].iter().take_while(|link| link.0 == particle);
            for &(_, other) in own {
                if !std::mem::replace(&mut is_seen[first(other)], true) {
                    open.push(other);
                }
            }
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}
