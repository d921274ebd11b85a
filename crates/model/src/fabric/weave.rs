//! Springs, angles and hinges of a scene's material on its cloth.

use super::{BendingModel, Cell, Directions, Material, MaterialChoice, ShearModel, Woven, convert};
use crate::bounds::number;
use crate::effects::{grid_angles, hinges};
use crate::error::Violation;
use crate::mesh::{Patch, cosine};
use crate::{
    AngleEffect, Cloth, Effects, Grid, MeshCloth, SpringEffect, SpringSpec, SystemSpec, Vec3,
};

/// About how many springs, angles or hinges a material makes for each particle of a grid and of a
/// mesh.
pub(crate) const PIECES: [u64; 2] = [7, 9];

/// Curvature at which springs buckle, 1/m; below it a row is limp.
const BUCKLING_CURVATURE: f64 = 5.0;

/// Places along a row and along a column, as the stencils of grids count them.
const ALONG_WARP: usize = 0;

/// Adds the effects of a material that the scene does not name itself.
pub(crate) fn weave(
    choice: &MaterialChoice,
    material: &Material,
    cloth: &Cloth,
    own: &Effects,
    spec: &mut SystemSpec,
) -> Result<(), Violation> {
    let mut material = material.clone();
    if choice.directions == Directions::Mean {
        material.tension_n_per_m = material.tension_n_per_m.mean();
        material.bending_n_m = material.bending_n_m.mean();
    }
    let wanted = Wanted {
        tension: own.tension.is_none(),
        shear: (own.shear.is_none() && own.shear_angle.is_none()).then_some(choice.shear_model),
        bending: (own.bending.is_none()
            && own.bending_angle.is_none()
            && own.bending_hinge.is_none())
        .then_some(choice.bending_model),
    };
    match cloth {
        Cloth::Grid(grid) => on_grid(choice, &material, wanted, grid, spec),
        Cloth::Mesh(mesh) => on_mesh(choice, &material, wanted, mesh, spec),
        Cloth::Particles(_) => {
            let found = "given beside explicit particles";
            let expected = "no such key: `cloth.particles` carries its own masses and springs";
            Err(Violation::new("material", found, expected))
        }
    }
}

/// The groups of effects that the material gives.
#[derive(Clone, Copy)]
struct Wanted {
    tension: bool,
    shear: Option<ShearModel>,
    bending: Option<BendingModel>,
}

impl Material {
    /// A spring with this material's damping.
    fn spring(&self, effect: SpringEffect, ends: [u32; 2], length: f64, k: f64) -> SpringSpec {
        SpringSpec {
            effect,
            i: ends[0],
            j: ends[1],
            rest_length_m: length,
            stiffness_n_per_m: k,
            damping_n_s_per_m: self.retardation_s * k,
            ..SpringSpec::default()
        }
    }
}

/// Refuses a sheet whose diagonal springs alone are stiffer than its tension.
fn too_stiff(shear: f64, cell: Cell, tension: Woven) -> Violation {
    let ratio = cell.weft_m / cell.warp_m;
    let most = (tension.warp * ratio * ratio).min(tension.weft / (ratio * ratio));
    let found = format!(
        "{} N/m on cells of {} m by {} m",
        number(shear),
        number(cell.warp_m),
        number(cell.weft_m)
    );
    let expected = format!(
        "at most {} N/m, because the diagonal springs that carry the shear also resist tension; or \
         `shear_model` = \"angles\" on a grid; or cells nearer to squares",
        number(most)
    );
    Violation::new("material.shear_n_per_m", found, expected)
}

fn on_grid(
    choice: &MaterialChoice,
    material: &Material,
    wanted: Wanted,
    grid: &Grid,
    spec: &mut SystemSpec,
) -> Result<(), Violation> {
    if grid.rows < 2 || grid.columns < 2 {
        let found = "given for a single row or column";
        let expected = "a grid of at least 2 rows and 2 columns, which has an area";
        return Err(Violation::new("material", found, expected));
    }
    let [dx, dy] = grid.spacing_m();
    let cell = Cell { warp_m: dx, weft_m: dy };
    // An edge along a row has the cells above and below it.
    let cells = |particle: u32, direction: usize| {
        let beside = grid.cells_beside(particle / grid.columns, particle % grid.columns);
        f64::from(beside[1 - direction])
    };
    let strands = |effect| grid.strands(effect).into_iter();
    let shear = material.shear_n_per_m;
    if wanted.tension {
        let carried = if wanted.shear == Some(ShearModel::Springs) { shear } else { 0.0 };
        let k = cell.tension(material.tension_n_per_m, carried);
        if !(k.warp > 0.0 && k.weft > 0.0) {
            return Err(too_stiff(shear, cell, material.tension_n_per_m));
        }
        spec.springs.extend(strands(SpringEffect::Tension).map(|strand| {
            let share = if strand.direction == ALONG_WARP { k.warp } else { k.weft };
            let k = share * cells(strand.ends[0], strand.direction);
            material.spring(SpringEffect::Tension, strand.ends, strand.length, k)
        }));
    }
    match wanted.shear {
        Some(ShearModel::Springs) => {
            let k = cell.diagonal(shear);
            spec.springs.extend(
                strands(SpringEffect::Shear).map(|strand| {
                    material.spring(SpringEffect::Shear, strand.ends, strand.length, k)
                }),
            );
        }
        Some(ShearModel::Angles) => {
            // The stencil of shear gives each angle a fourth.
            let k = 4.0 * cell.shear_angle(shear);
            spec.angles.extend(grid_angles(grid, AngleEffect::ShearAngle, |_, _, _| k));
        }
        None => {}
    }
    match wanted.bending {
        Some(BendingModel::Hinges) => {
            let fit = choice.hinge_fit.factor();
            let columns = grid.columns;
            let square = dx * dx / (dx * dx + dy * dy);
            let stiffness = |[i, j]: [u32; 2]| {
                // The hinge bends across its edge.
                let across = match (i / columns == j / columns, i % columns == j % columns) {
                    (true, _) => 0.0,
                    (_, true) => 1.0,
                    _ => 1.0 - square,
                };
                fit * convert::bending_along(material.bending_n_m, across)
            };
            hinges(spec, "material.bending_model", stiffness)?;
        }
        Some(BendingModel::Angles) => {
            let k = cell.bending_angle(material.bending_n_m);
            let stiffness = |row: u32, column: u32, direction: usize| {
                let share = if direction == ALONG_WARP { k.warp } else { k.weft };
                share * cells(grid.index(row, column), direction)
            };
            spec.angles.extend(grid_angles(grid, AngleEffect::BendingAngle, stiffness));
        }
        Some(BendingModel::Buckling) => {
            let rigidity = cell.buckling(material.bending_n_m);
            let before = cell.before_buckling(material.bending_n_m, BUCKLING_CURVATURE);
            spec.springs.extend(strands(SpringEffect::Bending).map(|strand| {
                let [b, k] = if strand.direction == ALONG_WARP {
                    [rigidity.warp, before.warp]
                } else {
                    [rigidity.weft, before.weft]
                };
                let share = cells(strand.ends[0], strand.direction);
                SpringSpec {
                    compression_stiffness_n_per_m: Some(share * k),
                    buckling_rigidity_n_m2: Some(share * b),
                    ..material.spring(SpringEffect::Bending, strand.ends, strand.length, 0.0)
                }
            }));
        }
        None => {}
    }
    Ok(())
}

/// Shares of springs by their ends.
#[derive(Default)]
struct Shares(Vec<([u32; 2], f64)>);

impl Shares {
    fn add(&mut self, i: u32, j: u32, k: f64) {
        self.0.push(([i.min(j), i.max(j)], k));
    }

    /// The springs, by rising ends, with the sum of their shares.
    fn springs(mut self, effect: SpringEffect, material: &Material, spec: &mut SystemSpec) {
        self.0.sort_by_key(|(ends, _)| *ends);
        let x = |i: u32| Vec3::from(spec.particles.position_m[i as usize]);
        let spring = |same: &[([u32; 2], f64)]| {
            let ends = same[0].0;
            let k = same.iter().map(|(_, k)| k).sum();
            material.spring(effect, ends, (x(ends[0]) - x(ends[1])).norm(), k)
        };
        let springs: Vec<_> = self.0.chunk_by(|a, b| a.0 == b.0).map(spring).collect();
        spec.springs.extend(springs);
    }
}

/// The cell of a quad whose edges lie along warp and weft, and whether its first edge is along the
/// warp. `None` if it has no such edges.
fn cell(patch: &Patch) -> Option<(Cell, bool)> {
    let places = patch.places();
    let side = |k: usize| {
        let [a, b] = [places[k], places[(k + 1) % 4]];
        [b[0] - a[0], b[1] - a[1]]
    };
    let sides = [0, 1, 2, 3].map(side);
    // Nearer to the direction than 30°: in between, the diagonals are as good.
    let along = sides.map(|[x, y]| x * x > 3.0 * y * y);
    let across = sides.map(|[x, y]| y * y > 3.0 * x * x);
    let is_first = along[0] && across[1] && along[2] && across[3];
    let is_second = across[0] && along[1] && across[2] && along[3];
    let norm = |[x, y]: [f64; 2]| libm::hypot(x, y);
    let length = |k: usize| 0.5 * (norm(sides[k]) + norm(sides[k + 2]));
    if is_first {
        Some((Cell { warp_m: length(0), weft_m: length(1) }, true))
    } else {
        is_second.then(|| (Cell { warp_m: length(1), weft_m: length(0) }, false))
    }
}

fn on_mesh(
    choice: &MaterialChoice,
    material: &Material,
    wanted: Wanted,
    mesh: &MeshCloth,
    spec: &mut SystemSpec,
) -> Result<(), Violation> {
    let refuse = |key: &str, found: &str| {
        let expected = "another model: a mesh has no rows and columns";
        Err(Violation::new(format!("material.{key}"), format!("{found:?} for a mesh"), expected))
    };
    if wanted.shear == Some(ShearModel::Angles) {
        return refuse("shear_model", "angles");
    }
    match wanted.bending {
        Some(BendingModel::Angles) => return refuse("bending_model", "angles"),
        Some(BendingModel::Buckling) => return refuse("bending_model", "buckling"),
        _ => {}
    }
    let is_mean = choice.directions == Directions::Mean;
    if !is_mean && !mesh.has_directions() {
        let found = "\"woven\" for a mesh without texture coordinates";
        let expected =
            "a file with texture coordinates (vt), the first along the warp; or \"mean\"";
        return Err(Violation::new("material.directions", found, expected));
    }
    if wanted.tension || wanted.shear.is_some() {
        let (mut edges, mut diagonals) = (Shares::default(), Shares::default());
        for patch in mesh.patches(is_mean)? {
            shares(&patch, material, wanted, is_mean, &mut edges, &mut diagonals)?;
        }
        if wanted.tension {
            edges.springs(SpringEffect::Tension, material, spec);
        }
        if wanted.shear.is_some() {
            diagonals.springs(SpringEffect::Shear, material, spec);
        }
    }
    if wanted.bending.is_some() {
        let cosines = if is_mean { Vec::new() } else { mesh.cosines(false)? };
        let fit = choice.hinge_fit.factor();
        hinges(spec, "material.bending_model", |ends| {
            // The hinge bends across its edge.
            let across = 1.0 - cosine(&cosines, ends).unwrap_or(0.0);
            fit * convert::bending_along(material.bending_n_m, across)
        })?;
    }
    Ok(())
}

/// Adds the springs of one face.
fn shares(
    patch: &Patch,
    material: &Material,
    wanted: Wanted,
    is_mean: bool,
    edges: &mut Shares,
    diagonals: &mut Shares,
) -> Result<(), Violation> {
    let (corners, places) = (patch.corners(), patch.places());
    let (tension, shear) = (material.tension_n_per_m, material.shear_n_per_m);
    if corners.len() == 4
        && let Some((cell, is_first)) = cell(patch)
    {
        let carried = if wanted.shear.is_some() { shear } else { 0.0 };
        let k = cell.tension(tension, carried);
        if k.warp > 0.0 && k.weft > 0.0 {
            for side in 0..4 {
                let along_warp = (side % 2 == 0) == is_first;
                let k = if along_warp { k.warp } else { k.weft };
                edges.add(corners[side], corners[(side + 1) % 4], k);
            }
            let k = cell.diagonal(shear);
            diagonals.add(corners[0], corners[2], k);
            diagonals.add(corners[1], corners[3], k);
            return Ok(());
        }
    }
    // A quad that lies askew, or is so long that its diagonals would be too stiff, counts as two
    // pairs of triangles, each with half the weight.
    let all: [([usize; 3], f64); 4] = [
        ([0, 1, 2], if corners.len() == 4 { 0.5 } else { 1.0 }),
        ([0, 2, 3], 0.5),
        ([0, 1, 3], 0.5),
        ([1, 2, 3], 0.5),
    ];
    let triangles = if corners.len() == 4 { &all[..] } else { &all[..1] };
    for (triangle, weight) in triangles {
        let at = triangle.map(|k| places[k]);
        let springs = if is_mean {
            convert::isotropic_springs(at, tension.warp)
        } else {
            convert::triangle_springs(at, tension, shear)
        };
        let Some(k) = springs else {
            let found = format!("{} N/m in triangles", number(shear));
            let most = number((tension.warp * tension.weft).sqrt());
            let expected = format!("below {most} N/m, the mean of the tensile rigidities");
            return Err(Violation::new("material.shear_n_per_m", found, expected));
        };
        for (opposite, k) in k.into_iter().enumerate() {
            let ends = [1, 2].map(|step| triangle[(opposite + step) % 3]);
            let is_diagonal = corners.len() == 4 && ends[0].abs_diff(ends[1]) == 2;
            let list = if is_diagonal { &mut *diagonals } else { &mut *edges };
            list.add(corners[ends[0]], corners[ends[1]], weight * k);
        }
    }
    Ok(())
}
