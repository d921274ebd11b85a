//! What is run for claim C13.

use super::meshes::Mesh;
use super::scenes::{build, error, greatest, hanging, least, run};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c13::TOLERANCE;
use crate::studies::sheet::Sheet;
use drape_model::{State, SystemSpec};

pub(super) const TRIAL: Trial = Trial {
    id: "C13",
    scenes: || {
        format!(
            "hanging sheets of 10 × 10 with shear springs and triangle meshes, d/m = 10/s, h = \
             {STEP} s, {DURATION} s; symplectic Euler and leapfrog at k/m = 1e3/s², IMEX Euler, \
             updated CG, Baraff-Witkin and Kang at 1e4 and 1e6 (Jacobi's preconditioner or none, \
             and IC(0)); factors 2⁻¹⁰, 2, 2²⁰ and 0.1, 3, 7.3, 1000"
        )
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const STEP: f64 = 0.01;
const DURATION: f64 = 0.3;
const POWERS: [f64; 3] = [1.0 / 1024.0, 2.0, 1_048_576.0];
const OTHERS: [f64; 4] = [0.1, 3.0, 7.3, 1000.0];
/// Method and stiffness over mass: explicit ones below their limit, implicit ones far above it.
const RUNS: [(&str, f64); 10] = [
    ("symplectic-euler", 1e3),
    ("leapfrog:solver=cg", 1e3),
    ("imex-euler:norm=euclid,forcing_term=1e-12,preconditioner=jacobi", 1e4),
    ("imex-euler:norm=euclid,forcing_term=1e-12,preconditioner=jacobi", 1e6),
    (
        "imex-updated:norm=euclid,safeguard=paper,start=last,forcing_term=1e-12,preconditioner=jacobi",
        1e4,
    ),
    ("baraff-witkin:forcing_term=1e-12,preconditioner=none,norm=euclid", 1e4),
    ("baraff-witkin:forcing_term=1e-12,preconditioner=none,norm=euclid", 1e6),
    ("kang", 1e4),
    ("imex-euler:norm=euclid,forcing_term=1e-12,preconditioner=ic0", 1e4),
    (
        "imex-updated:norm=euclid,safeguard=paper,start=last,forcing_term=1e-12,preconditioner=ic0",
        1e4,
    ),
];

/// Whether a run scaled by a power of two must have the same bits: IC(0) takes square roots, and
/// `√(2ⁿ a)` has the digits of `√a` for even `n` only.
fn is_exact(method: &str, factor: f64) -> bool {
    !method.contains("preconditioner=ic0") || libm::log2(factor) % 2.0 == 0.0
}

/// Mass, stiffness and damping multiplied.
fn scaled(mut spec: SystemSpec, factor: f64) -> SystemSpec {
    spec.particles.mass_kg.iter_mut().for_each(|m| *m *= factor);
    for spring in &mut spec.springs {
        spring.stiffness_n_per_m *= factor;
        spring.damping_n_s_per_m *= factor;
    }
    spec
}

fn scenes(stiffness: f64) -> Result<[SystemSpec; 2], HarnessError> {
    let sheet = Sheet { shear: 0.1 * stiffness, ..hanging(10, stiffness, 10.0) };
    Ok([sheet.spec()?, Mesh::Triangles.hanging(8, stiffness, 10.0)?])
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let (mut differing, mut runs, mut roots) = (0, 0, 0.0_f64);
    let (mut others, mut stiffer) = (Vec::new(), Vec::new());
    for (method, stiffness) in RUNS {
        for spec in scenes(stiffness)? {
            let start = build(&spec)?;
            let end = |spec: &SystemSpec| -> Result<State, HarnessError> {
                Ok(run(&build(spec)?, method, STEP, DURATION, None)?.state)
            };
            let base = end(&spec)?;
            for factor in POWERS {
                let state = end(&scaled(spec.clone(), factor))?;
                if is_exact(method, factor) {
                    differing += usize::from(state.x != base.x || state.v != base.v);
                    runs += 1;
                } else {
                    let change = error(&start, &base, &state);
                    roots = roots.max(change);
                    others.push(change);
                }
            }
            for factor in OTHERS {
                others.push(error(&start, &base, &end(&scaled(spec.clone(), factor))?));
            }
            let mut half = spec.clone();
            half.springs.iter_mut().for_each(|spring| spring.stiffness_n_per_m *= 0.5);
            stiffer.push(error(&start, &base, &end(&half)?));
        }
    }
    Ok(numbers(differing, runs, &others, &stiffer, roots))
}

fn numbers(
    differing: usize,
    runs: usize,
    others: &[f64],
    control: &[f64],
    roots: f64,
) -> Vec<Number> {
    let (worst, control) = (greatest(others.iter().copied()), least(control.iter().copied()));
    vec![
        Number::new("runs scaled by a power of two that differ in a bit", differing as f64, "")
            .against(0.0),
        Number::new("runs scaled by a power of two", runs as f64, ""),
        Number::new("greatest change over the motion, other factors", worst, "").against(TOLERANCE),
        Number::new("runs scaled by other factors", others.len() as f64, ""),
        Number::new(
            "change over the motion by a factor of 2, with the square roots of IC(0)",
            roots,
            "",
        ),
        Number::new("least change over the motion when k alone is halved", control, ""),
    ]
}
