//! Experiment `cg-vs-stiffness`: conjugate-gradient iterations against stiffness.

use crate::facts::{Fact, fact};
use crate::run::Simulation;
use crate::scenes::{
    build, bundled, free_edge_midpoint, with_damping_scaled, with_particles_a_side, with_stiffness,
};
use crate::studies::cg_vs_stiffness::facts::{
    Cell, FORCING_TERM, Facts, IMPLICIT, Motion, PLAIN_MOTION, TENSION_ONLY, UPDATED_MOTION,
};
use crate::studies::{Context, Measured, Start, cells, counts, finite, prepared};
use crate::{HarnessError, reference_energy, system_hash};
use drape_model::Scene;
use std::collections::BTreeMap;

const SCENE: &str = "hanging-textile-1e4";
const MOTION_SCENE: &str = "hanging-textile-sheared-1e6";
/// Simulated time of each count, s.
const DURATION: f64 = 1.0;
/// Simulated time of the fall, s. The reference sheet is still falling at its end.
const FALL_TIME: f64 = 0.3;
/// The base point, from which one factor at a time varies: step size (s) and forcing term.
const STEP: f64 = 0.01;
const SIDES: [u32; 2] = [20, 52];
const STIFFNESSES: [f64; 7] = [1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8];
/// Greatest stiffness over mass of the reference that gives the released energy, 1/s².
const REFERENCE_STIFFNESS: f64 = 1e7;
const FIXED_MATERIAL: &str = "fixed-material";
const STEPS: [f64; 6] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05];
const FORCING_TERMS: [f64; 7] = [0.2, 0.1, 0.05, 0.01, 1e-3, 1e-4, 1e-6];
/// Largest stiffness over mass of the robust form on the larger sheet, 1/s². For θ > 100 it turns
/// to Newton, which would factorise 8112 unknowns. That is another experiment.
const ROBUST_LIMIT_LARGE: f64 = 1e6;

#[derive(Clone, Copy, Debug)]
struct Point {
    series: &'static str,
    material: &'static str,
    side: u32,
    stiffness: f64,
    step: f64,
    variant: &'static str,
    preconditioner: &'static str,
    start: &'static str,
    forcing_term: f64,
}

/// The base point with another stiffness.
fn base(series: &'static str, side: u32, stiffness: f64, variant: &'static str) -> Point {
    Point {
        series,
        material: "fixed-k-over-m",
        side,
        stiffness,
        step: STEP,
        variant,
        preconditioner: "ic0",
        start: if variant == "updated-robust" { "best" } else { "extrapolated" },
        forcing_term: FORCING_TERM,
    }
}

impl Point {
    fn method(&self) -> String {
        let Self { preconditioner, start, forcing_term, .. } = self;
        let common =
            format!("forcing_term={forcing_term},preconditioner={preconditioner},start={start}");
        match self.variant {
            "plain" => format!("imex-euler:{common},norm=euclid"),
            "updated-paper" => format!("imex-updated:{common},norm=euclid,safeguard=paper"),
            _ => format!("imex-updated:{common},safeguard=robust"),
        }
    }
}

/// A star of points around the base point, with one factor varied at a time.
fn star(quick: bool) -> Vec<Point> {
    let mut points = Vec::new();
    let sides: &[u32] = if quick { &SIDES[..1] } else { &SIDES };
    for &side in sides {
        for stiffness in STIFFNESSES {
            for variant in ["plain", "updated-paper"] {
                for preconditioner in ["none", "jacobi", "ic0"] {
                    for start in ["last", "extrapolated"] {
                        let point = base("stiffness", side, stiffness, variant);
                        points.push(Point { preconditioner, start, ..point });
                    }
                }
            }
            if !quick && (side == SIDES[0] || stiffness <= ROBUST_LIMIT_LARGE) {
                points.push(base("stiffness", side, stiffness, "updated-robust"));
            }
            if side != SIDES[0] {
                // The same fabric on the finer mesh: k stays the same, and m is smaller.
                let plain = base("stiffness", side, stiffness * refinement(side), "plain");
                points.push(Point { material: FIXED_MATERIAL, ..plain });
            }
        }
    }
    if quick {
        return points;
    }
    for stiffness in [1e4, 1e6] {
        for variant in ["plain", "updated-paper"] {
            for step in STEPS {
                points.push(Point { step, ..base("step", SIDES[0], stiffness, variant) });
            }
            for forcing_term in FORCING_TERMS {
                let point = base("forcing-term", SIDES[0], stiffness, variant);
                points.push(Point { forcing_term, ..point });
            }
        }
    }
    points
}

/// A sheet with a size and a stiffness, and the energy that it sets free.
struct Sheet {
    material: &'static str,
    side: u32,
    stiffness: f64,
    simulation: Simulation,
    hash: String,
    reference_energy: f64,
}

/// The scene of the hanging textile with this size and stiffness.
fn scene(material: &str, side: u32, stiffness: f64) -> Result<Scene, HarnessError> {
    let mut scene = with_particles_a_side(bundled(SCENE)?, side);
    if material == FIXED_MATERIAL {
        // The damping coefficient stays the same too, on lighter particles.
        scene = with_damping_scaled(scene, refinement(side));
    }
    Ok(with_stiffness(scene, stiffness))
}

/// The sheets of the points, without repetition.
fn sizes(points: &[Point]) -> Vec<(&'static str, u32, f64)> {
    let mut sizes: Vec<_> = points.iter().map(key).collect();
    sizes.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    sizes.dedup();
    sizes
}

fn key(point: &Point) -> (&'static str, u32, f64) {
    (point.material, point.side, point.stiffness)
}

fn name(material: &str, side: u32, stiffness: f64) -> String {
    format!("{material} n={} k/m={stiffness:e}", side * side)
}

impl Sheet {
    fn new(material: &'static str, side: u32, stiffness: f64) -> Result<Self, HarnessError> {
        let scene = scene(material, side, stiffness)?;
        let (spec, simulation) = build(&scene)?;
        // The reference is explicit. Beyond this stiffness it would take too many steps, and the
        // sheet hardly stretches.
        let reference = with_stiffness(scene, stiffness.min(REFERENCE_STIFFNESS));
        let reference_energy = reference_energy(&build(&reference)?.1, DURATION)?;
        let hash = system_hash(&spec);
        Ok(Self { material, side, stiffness, simulation, hash, reference_energy })
    }
}

/// Number of particles over that of the smaller sheet.
fn refinement(side: u32) -> f64 {
    f64::from(side * side) / f64::from(SIDES[0] * SIDES[0])
}

fn cell(point: &Point, sheet: &Sheet) -> Result<Cell, HarnessError> {
    let (choice, run) = counts(&sheet.simulation, &point.method(), point.step, DURATION)?;
    let totals = run.outcome.totals;
    let steps = run.outcome.steps;
    Ok(Cell {
        series: point.series.to_owned(),
        material: point.material.to_owned(),
        particles: sheet.simulation.system.len(),
        stiffness_over_mass_per_s2: point.stiffness,
        step_s: point.step,
        theta: point.step * point.step * point.stiffness,
        variant: point.variant.to_owned(),
        preconditioner: point.preconditioner.to_owned(),
        start: point.start.to_owned(),
        forcing_term: point.forcing_term,
        method: choice.full_id(),
        steps,
        cg_iterations: totals.cg_iterations,
        cg_per_step: totals.cg_iterations as f64 / steps as f64,
        outer_passes: totals.outer_passes,
        newton_iterations: totals.newton_iterations,
        idle_steps: run.outcome.idle,
        unconverged_steps: run.outcome.unconverged,
        energy_gain_j: finite(run.energy.gain),
        energy_climb: finite(run.energy.climb / sheet.reference_energy),
        verdict: run.verdict(sheet.reference_energy),
        portable: choice.is_portable(),
    })
}

/// Labels and methods of the runs that measure the fall.
const FALLING: [(&str, &str); 4] = [
    (PLAIN_MOTION, "imex-euler:norm=euclid"),
    (UPDATED_MOTION, "imex-updated"),
    (TENSION_ONLY, "imex-updated:implicit=tension"),
    (IMPLICIT, "backward-euler:solver=cholesky"),
];

fn motion(stiffness: f64, label: &str, method: &str) -> Result<Motion, HarnessError> {
    let scene = with_stiffness(bundled(MOTION_SCENE)?, stiffness);
    let tracked = free_edge_midpoint(&scene).unwrap_or_default();
    let (_, simulation) = build(&scene)?;
    let reference = build(&with_stiffness(scene, stiffness.min(REFERENCE_STIFFNESS)))?.1;
    let reference_energy = reference_energy(&reference, FALL_TIME)?;
    let (choice, run) = counts(&simulation, method, STEP, FALL_TIME)?;
    Ok(Motion {
        stiffness_over_mass_per_s2: stiffness,
        step_s: STEP,
        label: label.to_owned(),
        method: choice.full_id(),
        fall_m: finite(run.state.x[tracked].z - simulation.state.x[tracked].z),
        unconverged_steps: run.outcome.unconverged,
        energy_gain_j: finite(run.energy.gain),
        verdict: run.verdict(reference_energy),
        portable: choice.is_portable(),
    })
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "The hanging textile (structural springs, d/m = 40 s⁻¹) runs for one second; the record sums \
     the CG iterations. One factor varies at a time around a base point: h = 0.01 s, ε = 0.05, \
     IC(0), extrapolated start. To measure the motion, the study adds shear springs of a tenth of \
     the stiffness and runs at default settings; it takes the fall of the free edge's midpoint \
     after 0.3 s. Verdicts are as in the study `tables`, but above k/m = 10⁷ s⁻² they use the \
     energy that is released at 10⁷ s⁻². Above h²k/m = 100 the robust form uses Newton's method; \
     its CG count is 0 there."
        .to_owned()
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let start = |(material, side, stiffness)| {
        Start::new(name(material, side, stiffness), move || {
            Ok(scene(material, side, stiffness)?.discretise()?)
        })
    };
    sizes(&star(false)).into_iter().map(start).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let points = star(context.quick);
    let sizes = sizes(&points);
    let sheets = prepared(context, "scenes", &sizes, |&(material, side, stiffness)| {
        Sheet::new(material, side, stiffness)
    })?;
    let pairs: Vec<_> = points
        .iter()
        .filter_map(|point| {
            let fits = |sheet: &&Sheet| (sheet.material, sheet.side, sheet.stiffness) == key(point);
            sheets.iter().find(fits).map(|sheet| (point, sheet))
        })
        .collect();
    let counted = cells(context, "counts", &pairs, |(point, sheet)| cell(point, sheet))?;
    let falls: Vec<_> = STIFFNESSES
        .into_iter()
        .filter(|&stiffness| !context.quick || stiffness == 1e4 || stiffness == 1e6)
        .flat_map(|stiffness| FALLING.map(|(label, method)| (stiffness, label, method)))
        .filter(|(_, label, _)| !context.quick || *label != TENSION_ONLY)
        .collect();
    let fallen = cells(context, "motion", &falls, |&(k, label, method)| motion(k, label, method))?;
    let facts = Facts { cells: counted.all()?, motion: fallen.all()? };
    let hashes: BTreeMap<_, _> = sheets
        .iter()
        .map(|sheet| {
            let Sheet { material, side, stiffness, hash, .. } = sheet;
            (name(material, *side, *stiffness), hash.clone())
        })
        .collect();
    let (facts, scenes, seed) = (facts, hashes, None);
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let cells = facts.cells.iter().map(|c| {
        let key = format!(
            "{} {} n={} k/m={:e} h={} {} {} {} ε={}",
            c.series,
            c.material,
            c.particles,
            c.stiffness_over_mass_per_s2,
            c.step_s,
            c.variant,
            c.preconditioner,
            c.start,
            c.forcing_term
        );
        fact(key, c.portable, c)
    });
    let motion = facts.motion.iter().map(|m| {
        let key = format!("motion k/m={:e} {}", m.stiffness_over_mass_per_s2, m.label);
        fact(key, m.portable, m)
    });
    cells.chain(motion).collect()
}
