//! Experiment `fabric`: simulated cloth against exact solutions and against measured cloth.

mod drape;
mod strip;
#[cfg(test)]
mod tests;

use super::facts::{AT_REST, Facts, Model};
use crate::facts::{Fact, fact};
use crate::studies::{Context, Measured, Start, cells};
use crate::{HarnessError, system_hash};
use drape_model::fabric::Material;
use std::collections::BTreeMap;

/// Values of `Γ` of the cantilevers. The last one is a heavy strip that hangs almost upright.
const GAMMAS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 64.0];
/// Numbers of edges along the cantilevers' free length, and of rows across.
const SEGMENTS: [u32; 4] = [10, 20, 40, 80];
const ROWS: u32 = 3;
/// Models, `Γ`, rows and edges of the strips of several widths.
const WIDE_MODELS: [Model; 3] = [Model::Angles, Model::Triangles, Model::SquaresAsSheet];
const WIDE_GAMMAS: [f64; 2] = [1.0, 8.0];
const WIDE_ROWS: [u32; 4] = [3, 7, 15, 25];
const WIDE_SEGMENTS: u32 = 30;
/// Models, edges and rows of the strips on edge.
const EDGE_MODELS: [Model; 3] = [Model::Angles, Model::Triangles, Model::Squares];
const EDGE_MESHES: [(u32, u32); 3] = [(20, 3), (40, 3), (40, 5)];
/// Numbers of squares across the cloths of the drape test, and of waves at the start.
const CELLS: [u32; 5] = [16, 24, 32, 40, 48];
const WAVES: [u32; 4] = [2, 3, 4, 5];

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "Newton's method on the energy brings every specimen to rest, with the exact tangent \
         where that is positive definite and without a time step. The residual is the greatest \
         force on a particle over the weight of the heaviest one; a specimen is at rest if its \
         residual is at most {AT_REST:e}. Cantilevers have {} kg/m², B = {:e} N m, {ROWS} rows \
         and a free length that gives Γ = ρ g L³/B. They are nearly inextensible ({:e} N/m) and \
         start from the exact shape. Linear springs are fitted at one curvature, {:.0}/m, the \
         mean curvature of the exact strip of Γ = {}. Widths: strips of {WIDE_SEGMENTS} edges \
         with the stiffness of the sheet; the rigidity is that of the exact strip with the same \
         drop over reach. Strips on edge: gravity acts along the width; the critical Γ is where \
         the tangent at the upright rest position stops being positive definite. Drape test (BS \
         5058): a cloth of {} cm lies on a table of {} cm and bends by this model: {}, along warp \
         and weft. The table holds it, and it starts with {WAVES:?} waves. It counts as at rest \
         only in a minimum of the energy.",
        strip::DENSITY,
        strip::BENDING,
        strip::TENSION,
        strip::fitted_curvature(),
        strip::FITTED_GAMMA,
        200.0 * drape::RADII[0],
        200.0 * drape::RADII[1],
        Model::SquaresAsSheet,
    )
}

/// The specimens to compute.
struct Plan {
    bent: Vec<(Model, f64, u32)>,
    wide: Vec<(Model, f64, u32)>,
    edgewise: Vec<(Model, u32, u32, bool)>,
    drapes: Vec<(&'static str, u32, u32)>,
}

impl Plan {
    fn new(quick: bool) -> Self {
        let is_kept =
            |gamma: f64, segments: u32| !quick || ([1.0, 8.0].contains(&gamma) && segments <= 20);
        let mut plan =
            Self { bent: Vec::new(), wide: Vec::new(), edgewise: Vec::new(), drapes: Vec::new() };
        for model in Model::ALL {
            for gamma in GAMMAS {
                let meshes = SEGMENTS.into_iter().filter(|&segments| is_kept(gamma, segments));
                plan.bent.extend(meshes.map(|segments| (model, gamma, segments)));
            }
        }
        let rows = if quick { &WIDE_ROWS[..2] } else { &WIDE_ROWS[..] };
        for model in WIDE_MODELS {
            for gamma in WIDE_GAMMAS.into_iter().filter(|gamma| !quick || *gamma > 1.0) {
                plan.wide.extend(rows.iter().map(|&rows| (model, gamma, rows)));
            }
        }
        let meshes = if quick { &EDGE_MESHES[..1] } else { &EDGE_MESHES[..] };
        // Angles take the longest time, so the quick subset leaves them out.
        for model in EDGE_MODELS.into_iter().skip(usize::from(quick)) {
            for &(segments, rows) in meshes {
                plan.edgewise.extend([false, true].map(|turned| (model, segments, rows, turned)));
            }
        }
        for name in Material::bundled().filter(|name| !quick || *name == "denim") {
            for cells in CELLS.into_iter().filter(|cells| !quick || *cells == CELLS[0]) {
                let waves = WAVES.into_iter().filter(|waves| !quick || *waves == WAVES[0]);
                plan.drapes.extend(waves.map(|waves| (name, cells, waves)));
            }
        }
        plan
    }
}

fn strip_name(model: Model, gamma: f64, segments: u32) -> String {
    format!("cantilever, {model}, Γ = {gamma}, {segments} edges")
}

fn drape_name(cloth: &str, cells: u32) -> String {
    format!("drape test, {cloth}, {cells} squares")
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let plan = Plan::new(false);
    let bent = plan.bent.into_iter().map(|(model, gamma, segments)| {
        let name = strip_name(model, gamma, segments);
        Start::new(name, move || strip::system(model, gamma, segments, ROWS))
    });
    let wide = plan.wide.into_iter().map(|(model, gamma, rows)| {
        let name = format!("{}, {rows} rows", strip_name(model, gamma, WIDE_SEGMENTS));
        Start::new(name, move || strip::wide_system(model, gamma, WIDE_SEGMENTS, rows))
    });
    let edgewise = plan.edgewise.into_iter().map(|(model, segments, rows, turned)| {
        let over = if turned { ", turned over" } else { "" };
        let name = format!("strip on edge, {model}, {segments} edges, {rows} rows{over}");
        Start::new(name, move || strip::edge_system(model, segments, rows, turned))
    });
    let mut starts: Vec<Start> = bent.chain(wide).chain(edgewise).collect();
    for (name, cells, _) in plan.drapes {
        let start = Start::new(drape_name(name, cells), move || drape::system(name, cells));
        if starts.iter().all(|other| other.name() != start.name()) {
            starts.push(start);
        }
    }
    starts
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let plan = Plan::new(context.quick);
    let bent = cells(context, "cantilevers", &plan.bent, |&(model, gamma, segments)| {
        strip::cantilevered(model, gamma, segments, ROWS)
    })?;
    let widths = cells(context, "widths", &plan.wide, |&(model, gamma, rows)| {
        strip::wide(model, gamma, WIDE_SEGMENTS, rows)
    })?;
    let edgewise = cells(context, "strips on edge", &plan.edgewise, |&cell| {
        let (model, segments, rows, turned) = cell;
        strip::edgewise(model, segments, rows, turned)
    })?;
    let drapes = cells(context, "drape tests", &plan.drapes, |&(name, cells, waves)| {
        drape::drape(name, cells, waves)
    })?;
    let (bent, widths, edgewise) = (bent.all()?, widths.all()?, edgewise.all()?);
    let drapes = drapes.all()?;
    let mut scenes = BTreeMap::new();
    for model in Model::ALL {
        let spec = strip::system(model, 8.0, SEGMENTS[1], ROWS)?;
        scenes.insert(strip_name(model, 8.0, SEGMENTS[1]), system_hash(&spec));
    }
    for &(name, cells, _) in &plan.drapes {
        let spec = drape::system(name, cells)?;
        scenes.insert(drape_name(name, cells), system_hash(&spec));
    }
    let cloths = Material::bundled().map(drape::cloth).collect::<Result<_, _>>()?;
    let facts = Facts { bent, widths, edgewise, cloths, bands: drape::bands(), drapes };
    Ok(Measured { facts, timings: None, scenes, seed: None })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let bent = facts.bent.iter().map(|bent| {
        let key =
            format!("cantilever, {}, Γ = {}, {} edges", bent.model, bent.gamma, bent.segments);
        fact(key, bent.portable, bent)
    });
    let widths = facts.widths.iter().map(|width| {
        let key = format!("width, {}, Γ = {}, {} rows", width.model, width.gamma, width.rows);
        fact(key, width.portable, width)
    });
    let edgewise = facts.edgewise.iter().map(|edge| {
        let (model, turned) = (edge.model, if edge.turned { ", turned" } else { "" });
        let key = format!("on edge, {model}, {} edges, {} rows{turned}", edge.segments, edge.rows);
        fact(key, edge.portable, edge)
    });
    let cloths = facts.cloths.iter().map(|cloth| fact(cloth.name.clone(), true, cloth));
    let bands = facts.bands.iter().map(|band| fact(format!("band {}", band.class), true, band));
    let drapes = facts.drapes.iter().map(|drape| {
        let key = format!("drape, {}, {} squares, {} waves", drape.cloth, drape.cells, drape.waves);
        fact(key, drape.portable, drape)
    });
    bent.chain(widths).chain(edgewise).chain(cloths).chain(bands).chain(drapes).collect()
}
