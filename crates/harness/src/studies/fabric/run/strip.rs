//! Strips that bend under their own weight.

use super::super::facts::{Bent, Edgewise, Model, Width};
use crate::HarnessError;
use drape_model::fabric::{
    BendingModel, Cell, HingeFit, MaterialChoice, ShearModel, Strip, TriangleStrip, Woven,
};
use drape_model::{GravitySpec, SpringEffect, SpringSpec, State, System, SystemSpec, Vec3};
use drape_oracle::elastica::{Cantilever, cantilever};
use drape_oracle::statics::{is_minimum, rest};

/// Areal density, kg/m², bending rigidity, N m, and gravity, m/s².
pub(super) const DENSITY: f64 = 0.2;
pub(super) const BENDING: f64 = 2e-5;
const GRAVITY: f64 = 9.81;
/// Tensile and shear rigidity, N/m. The strips hardly stretch.
pub(super) const TENSION: f64 = 5e4;
const SHEAR: f64 = 5e3;
/// `Γ` at whose curvature the linear springs store the energy of the cloth.
pub(super) const FITTED_GAMMA: f64 = 4.0;
/// Residual at which the search stops, and its largest number of iterations.
pub(super) const TOLERANCE: f64 = 1e-7;
const MOST: usize = 400;
/// Number of times that the interval of the critical weight is halved.
const HALVINGS: usize = 24;
/// Least and greatest `Γ` that are tried for a strip on edge.
pub(super) const EDGEWISE: [f64; 2] = [0.01, 1e4];
/// Load at which a slender cantilever on edge buckles: the weight per length times the cube of the
/// length, over the root of the product of bending and torsion rigidities (Timoshenko and Gere
/// 1961, art. 6.3).
pub(super) const SLENDER: f64 = 12.85;

/// Free length at which the cloth has this `Γ`, m.
fn length_of(gamma: f64) -> f64 {
    libm::cbrt(gamma * BENDING / (DENSITY * GRAVITY))
}

/// A specimen in its undeformed shape.
struct Specimen {
    spec: SystemSpec,
    length_m: f64,
    width_m: f64,
    /// Stiffness of a hinge over the rigidity; 1 for other models.
    fit: f64,
}

/// Makes a specimen of rows of squares or of equilateral triangles.
fn specimen(
    model: Model,
    gamma: f64,
    segments: u32,
    rows: u32,
    fit: HingeFit,
) -> Result<Specimen, HarnessError> {
    let length_m = length_of(gamma);
    let material = MaterialChoice {
        areal_density_kg_m2: Some(DENSITY),
        tension_n_per_m: Some(Woven::even(TENSION)),
        shear_n_per_m: Some(SHEAR),
        bending_n_m: Some(Woven::even(BENDING)),
        shear_model: ShearModel::Angles,
        bending_model: match model {
            Model::Angles => BendingModel::Angles,
            Model::Buckling | Model::Springs => BendingModel::Buckling,
            Model::Triangles | Model::Squares | Model::SquaresAsSheet => BendingModel::default(),
        },
        hinge_fit: fit,
        ..MaterialChoice::default()
    };
    if model == Model::Triangles {
        let strip = TriangleStrip { length_m, segments, rows, material };
        let (spec, width_m) = (strip.scene()?.discretise()?, strip.width_m());
        return Ok(Specimen { spec, length_m, width_m, fit: fit.factor() });
    }
    let mut strip = Strip { length_m, width_m: 0.0, segments, rows, material };
    let h = strip.spacing_m();
    strip.width_m = f64::from(rows - 1) * h;
    let mut spec = strip.scene().discretise()?;
    if model == Model::Springs {
        make_linear(&mut spec, h, segments + 1, rows);
    }
    let has_hinges = matches!(model, Model::Squares | Model::SquaresAsSheet);
    let fit = if has_hinges { fit.factor() } else { 1.0 };
    Ok(Specimen { spec, length_m, width_m: strip.width_m, fit })
}

/// Replaces bending springs by linear ones that store the energy of the cloth at one curvature.
fn make_linear(spec: &mut SystemSpec, h: f64, columns: u32, rows: u32) {
    let cell = Cell { warp_m: h, weft_m: h };
    let k = cell.linear_spring(Woven::even(BENDING), fitted_curvature()).warp;
    let bending = |spring: &&mut SpringSpec| spring.effect == SpringEffect::Bending;
    for spring in spec.springs.iter_mut().filter(bending) {
        // A spring at the border stands for one cell, any other spring for the two beside it.
        let is_along_row = spring.i / columns == spring.j / columns;
        let (place, last) = if is_along_row {
            (spring.i / columns, rows - 1)
        } else {
            (spring.i % columns, columns - 1)
        };
        let cells = if place == 0 || place == last { 1.0 } else { 2.0 };
        spring.stiffness_n_per_m = cells * k;
        spring.compression_stiffness_n_per_m = None;
        spring.buckling_rigidity_n_m2 = None;
    }
}

/// The curvature at which springs are fitted, 1/m. It is the root of `∫κ⁴/∫κ²`, with which the
/// springs store the energy of the exact strip.
pub(super) fn fitted_curvature() -> f64 {
    let shape = cantilever(FITTED_GAMMA);
    let steps = (shape.slope.len() - 1) as f64;
    let (mut square, mut fourth) = (0.0, 0.0);
    for pair in shape.slope.windows(2) {
        let curvature = (pair[1] - pair[0]) * steps;
        let s = curvature * curvature;
        square += s;
        fourth += s * s;
    }
    (fourth / square).sqrt() / length_of(FITTED_GAMMA)
}

/// The rest position of a strip.
struct Rested {
    particles: usize,
    drop_over_reach: Option<f64>,
    residual: f64,
    iterations: usize,
}

/// Finds the rest position, starting from the shape of the exact inextensible strip.
fn bend(specimen: &Specimen, shape: &Cantilever) -> Result<Rested, HarnessError> {
    let length = specimen.length_m;
    let (system, mut state) = specimen.spec.build()?;
    let is_end = |x: &Vec3| x.x > length * (1.0 - 1e-6);
    let end: Vec<usize> = (0..state.len()).filter(|&i| is_end(&state.x[i])).collect();
    for (x, pinned) in state.x.iter_mut().zip(system.pinned()) {
        if !pinned {
            let [reach, height] = shape.at(x.x / length);
            (x.x, x.z) = (reach * length, height * length);
        }
    }
    let found = rest(&system, &mut state.x, TOLERANCE, MOST);
    let sum = |axis: usize| end.iter().map(|&i| state.x[i][axis]).sum::<f64>();
    let ratio = -sum(2) / sum(0);
    Ok(Rested {
        particles: state.len(),
        drop_over_reach: Some(ratio).filter(|ratio| ratio.is_finite() && *ratio > 0.0),
        residual: found.residual,
        iterations: found.iterations,
    })
}

fn fit_of(model: Model) -> HingeFit {
    match model {
        Model::Triangles => HingeFit::Strip,
        Model::Squares => HingeFit::DiagonalStrip,
        _ => HingeFit::Sheet,
    }
}

/// A cantilever with three rows of particles.
pub(super) fn cantilevered(
    model: Model,
    gamma: f64,
    segments: u32,
    rows: u32,
) -> Result<Bent, HarnessError> {
    let specimen = specimen(model, gamma, segments, rows, fit_of(model))?;
    let shape = cantilever(gamma);
    let rested = bend(&specimen, &shape)?;
    Ok(Bent {
        model,
        gamma,
        segments,
        particles: rested.particles,
        drop_over_reach: rested.drop_over_reach,
        exact: shape.drop_over_reach(),
        residual: rested.residual,
        iterations: rested.iterations,
        portable: true,
    })
}

/// The `Γ` at which the exact strip has this drop over reach. The secant method runs on logarithms.
pub(super) fn gamma_of(ratio: f64, near: f64) -> f64 {
    let target = libm::log(ratio);
    let at = |log: f64| libm::log(cantilever(libm::exp(log)).drop_over_reach()) - target;
    let (mut a, mut b) = (libm::log(near), libm::log(near) + 0.1);
    let (mut fa, mut fb) = (at(a), at(b));
    for _ in 0..12 {
        if libm::fabs(fb) < 1e-12 || fa == fb {
            break;
        }
        let next = b - fb * (b - a) / (fb - fa);
        (a, fa) = (b, fb);
        (b, fb) = (next, at(next));
    }
    libm::exp(b)
}

/// Rigidity over stiffness of a narrow strip and of a wide sheet, as derived in theory.
pub(super) fn limits(model: Model) -> [f64; 2] {
    match model {
        Model::Triangles => [8.0 / 3.0, 3.0],
        Model::Squares | Model::SquaresAsSheet => [12.0 / 5.0, 3.0],
        Model::Angles | Model::Buckling | Model::Springs => [1.0, 1.0],
    }
}

/// A cantilever of some width with the stiffness of the wide sheet.
pub(super) fn wide(
    model: Model,
    gamma: f64,
    segments: u32,
    rows: u32,
) -> Result<Width, HarnessError> {
    let specimen = specimen(model, gamma, segments, rows, HingeFit::Sheet)?;
    let rested = bend(&specimen, &cantilever(gamma))?;
    let ratio = rested.drop_over_reach.unwrap_or(0.0);
    let [narrow, wide] = limits(model);
    let rigidity = if ratio > 0.0 { gamma / gamma_of(ratio, gamma) } else { 0.0 };
    Ok(Width {
        model,
        gamma,
        rows,
        width_over_length: specimen.width_m / specimen.length_m,
        drop_over_reach: ratio,
        rigidity_over_stiffness: rigidity / specimen.fit,
        narrow,
        wide,
        residual: rested.residual,
        iterations: rested.iterations,
        portable: true,
    })
}

/// The strip of `Γ` = 1 under a multiple of gravity along its width. A negative multiple acts
/// upwards.
fn on_edge(specimen: &SystemSpec, multiple: f64) -> SystemSpec {
    let mut spec = specimen.clone();
    spec.effects.gravity = Some(GravitySpec { m_s2: [0.0, -GRAVITY * multiple, 0.0] });
    spec
}

/// The residual of an upright strip, and whether the position is a minimum of the energy.
fn upright(specimen: &SystemSpec, multiple: f64) -> Result<(f64, bool), HarnessError> {
    let spec = on_edge(specimen, multiple);
    let (system, state): (System, State) = spec.build()?;
    let mut x = state.x;
    let found = rest(&system, &mut x, TOLERANCE, MOST);
    Ok((found.residual, is_minimum(&system, &x)))
}

/// Finds the weight at which a strip on edge buckles, i.e. its upright rest position stops being a
/// minimum of the energy. With `turned` the strip is turned over, so that its diagonals run the
/// other way.
pub(super) fn edgewise(
    model: Model,
    segments: u32,
    rows: u32,
    turned: bool,
) -> Result<Edgewise, HarnessError> {
    let specimen = specimen(model, 1.0, segments, rows, fit_of(model))?;
    let mut residual: f64 = 0.0;
    let mut holds = |gamma: f64| -> Result<bool, HarnessError> {
        let (found, is_minimum) = upright(&specimen.spec, if turned { -gamma } else { gamma })?;
        residual = residual.max(found);
        Ok(is_minimum)
    };
    // Doubles the weight until the strip buckles, then bisects the interval on a logarithmic scale.
    let [least, greatest] = EDGEWISE;
    let mut gamma = least;
    while gamma < greatest && holds(gamma)? {
        gamma *= 2.0;
    }
    let mut critical = (gamma < greatest).then_some(gamma);
    if gamma > least && gamma < greatest {
        let (mut low, mut high) = (libm::log(0.5 * gamma), libm::log(gamma));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if holds(libm::exp(middle))? { low = middle } else { high = middle }
        }
        critical = Some(libm::exp(0.5 * (low + high)));
    }
    // The strip is isotropic with ν = −1/3: bending D (1 − ν²) w, torsion 2 (1 − ν) D w.
    let law = (model == Model::Triangles).then(|| SLENDER * 3.0_f64.sqrt());
    Ok(Edgewise {
        model,
        rows,
        segments,
        turned,
        width_over_length: specimen.width_m / specimen.length_m,
        critical_gamma: critical,
        law,
        residual,
        portable: true,
    })
}

/// The system of a cantilever with the stiffness of the wide sheet.
pub(super) fn wide_system(
    model: Model,
    gamma: f64,
    segments: u32,
    rows: u32,
) -> Result<SystemSpec, HarnessError> {
    Ok(specimen(model, gamma, segments, rows, HingeFit::Sheet)?.spec)
}

/// The system of a strip on edge with `Γ` = 1. The search then increases gravity.
pub(super) fn edge_system(
    model: Model,
    segments: u32,
    rows: u32,
    turned: bool,
) -> Result<SystemSpec, HarnessError> {
    let specimen = specimen(model, 1.0, segments, rows, fit_of(model))?;
    Ok(on_edge(&specimen.spec, if turned { -1.0 } else { 1.0 }))
}

/// The system of a cantilever.
pub(super) fn system(
    model: Model,
    gamma: f64,
    segments: u32,
    rows: u32,
) -> Result<SystemSpec, HarnessError> {
    Ok(specimen(model, gamma, segments, rows, fit_of(model))?.spec)
}
