//! What is run for claim C22.

use super::runs::{free_edge, track, true_motion, walk};
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c22::LOCKED;
use crate::run::Simulation;
use crate::studies::sheet::pair;
use drape_integrator::{Implicit, StepError, hold_pins};
use drape_model::{Level, Mat3, State, Vec3};
use drape_solvers::{
    BlockJacobi, BlockMatrix, Constraints, Norm, PcgSettings, PcgWorkspace, Reference, filtered_pcg,
};

pub(super) const TRIAL: Trial = Trial {
    id: "C22",
    scenes: || {
        "two particles that turn on a spring at rest length, along an axis and at 45°, one step; a \
         hanging sheet of 256 particles, 1 s; k/m = 1e6, h = 0.01 s"
            .to_owned()
    },
    portable: true,
    is_quick: true,
    run: evidence,
    seconds: None,
};

const STEP: f64 = 0.01;
/// Share of the transverse stiffness that the coupled variant keeps in its matrix.
const HALF: f64 = 0.5;
const STIFFNESS: f64 = 1e6;

/// What stands for a spring along `û` in the matrix, over `k`.
#[derive(Clone, Copy)]
enum Block {
    /// `ûûᵀ + t (I − ûûᵀ)`: with `t = 1` that of IMEX Euler, which couples nothing, with `t < 1`
    /// one that couples the coordinates of every oblique spring.
    Across(f64),
    /// The diagonal of `ûûᵀ`, the exact Hessian at rest length without its coupling.
    Uncoupled,
}

impl Block {
    fn matrix(self, u: Vec3) -> Mat3 {
        match self {
            Self::Across(t) => u * u.transpose() * (1.0 - t) + Mat3::from_diagonal_element(t),
            Self::Uncoupled => Mat3::from_diagonal(&u.component_mul(&u)),
        }
    }
}

/// A step of the split with other blocks in its matrix.
///
/// `(M + h² Σ k B + h L_c) v_{n+1} = M v_n + h F(x_n)`, where `F` is the force of springs and
/// gravity.
fn block_step(
    start: &Simulation,
    state: &mut State,
    h: f64,
    block: Block,
) -> Result<(), HarnessError> {
    let system = &start.system;
    let n = system.len();
    let (mut weights, mut constraints) = (Vec::new(), Constraints::free(n));
    Implicit::Springs.visit_weights(system, &mut |i, j, k, c| weights.push((i, j, k, c)));
    let mut a = BlockMatrix::with_pattern(n, weights.iter().map(|&(i, j, ..)| (i, j)));
    for &(i, j, k, c) in &weights {
        let u = (state.x[i] - state.x[j]).normalize();
        let damping = Mat3::from_diagonal_element(h * c);
        a.add_pair(i, j, &(block.matrix(u) * (h * h * k) + damping));
    }
    let mut b = vec![Vec3::zeros(); n];
    system.forces(Level { v: &vec![Vec3::zeros(); n], ..state.level() }, &mut b);
    for (i, &mass) in system.mass().iter().enumerate() {
        a.add_diagonal(i, &Mat3::from_diagonal_element(mass));
        b[i] = b[i] * h + state.v[i] * mass;
    }
    hold_pins(system, &mut constraints);
    let mut preconditioner = BlockJacobi::new(&a);
    preconditioner.update(&a).map_err(StepError::from)?;
    let settings = PcgSettings { forcing_term: 1e-8, norm: Norm::Euclid, max_iterations: 10_000 };
    let reference = Reference::FilteredRightHandSide;
    let mut workspace = PcgWorkspace::new(n);
    let v = &mut state.v;
    filtered_pcg(&a, &preconditioner, &constraints, &b, v, reference, &settings, &mut workspace);
    for (x, v) in state.x.iter_mut().zip(&state.v) {
        *x += v * h;
    }
    Ok(())
}

/// Two particles that turn about their middle, on a spring along `u` at rest length.
fn turning(u: Vec3, across: Vec3) -> Result<Simulation, HarnessError> {
    let mut start = build(&pair(STIFFNESS))?;
    for (i, side) in [-0.5, 0.5].into_iter().enumerate() {
        start.state.x[i] = u * side;
        // So slow that the spring keeps its direction within the step.
        start.state.v[i] = across * (1e-3 * side);
    }
    Ok(start)
}

/// Share of the speed across the spring that a step keeps: with IMEX Euler, with the exact Hessian,
/// with the coupled variant, with the exact Hessian without its coupling.
fn kept_by_a_spring(u: Vec3, across: Vec3) -> Result<[f64; 4], HarnessError> {
    let start = turning(u, across)?;
    let share = |state: &State| across.dot(&state.v[1]) / across.dot(&start.state.v[1]);
    let step = |method: &str| walk(&start, method, STEP, 1, |_, _| (), |_, _, _| ());
    let mut coupled = start.state.clone();
    block_step(&start, &mut coupled, STEP, Block::Across(HALF))?;
    let mut uncoupled = start.state.clone();
    block_step(&start, &mut uncoupled, STEP, Block::Uncoupled)?;
    Ok([
        share(&step("imex-euler:norm=euclid,forcing_term=1e-14")?),
        share(&step("baraff-witkin:forcing_term=1e-14")?),
        share(&coupled),
        share(&uncoupled),
    ])
}

/// Retained motion of the hanging sheet within a second, with the first three.
fn kept_by_a_sheet() -> Result<[f64; 3], HarnessError> {
    let spec = hanging(16, STIFFNESS, 40.0).spec()?;
    let (start, tracked) = (build(&spec)?, free_edge(&spec));
    let exact = true_motion(&start, 1.0, tracked)?.path;
    let kept = |method: &str| {
        Ok::<_, HarnessError>(track(&start, method, STEP, 1.0, tracked)?.path / exact)
    };
    let (mut state, mut path) = (start.state.clone(), 0.0);
    for _ in 0..100 {
        let last = state.x[tracked];
        block_step(&start, &mut state, STEP, Block::Across(HALF))?;
        path += (state.x[tracked] - last).norm();
    }
    Ok([kept("imex-euler:norm=euclid")?, kept("baraff-witkin")?, path / exact])
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let (x, z) = (Vec3::x(), Vec3::z());
    let half = 0.5_f64.sqrt();
    let aligned = kept_by_a_spring(x, z)?;
    let oblique = kept_by_a_spring((x + z) * half, (z - x) * half)?;
    Ok(numbers(aligned, oblique, kept_by_a_sheet()?))
}

/// In each triple: IMEX Euler's matrix (no coupling, stiff across), the exact Hessian (coupled
/// unless aligned, soft across), the variant (coupled unless aligned, half as stiff across).
fn numbers(aligned: [f64; 4], oblique: [f64; 4], sheet: [f64; 3]) -> Vec<Number> {
    let matrices = [
        "matrix of IMEX Euler",
        "exact Hessian",
        "coupled, half as stiff across",
        "exact Hessian without coupling",
    ];
    let mut numbers = Vec::new();
    for (what, kept) in
        [("aligned spring", &aligned[..]), ("spring at 45°", &oblique), ("sheet", &sheet)]
    {
        for (matrix, kept) in matrices.into_iter().zip(kept) {
            numbers.push(Number::new(format!("kept, {what}, {matrix}"), *kept, "").against(LOCKED));
        }
    }
    numbers
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn the_variant_that_keeps_all_stiffness_is_imex_euler() {
        let mut start = build(&hanging(5, 1e5, 40.0).spec().unwrap()).unwrap();
        start.state = track(&start, "imex-euler:norm=euclid", STEP, 0.3, 0).unwrap().state;
        let expected = walk(
            &start,
            "imex-euler:norm=euclid,forcing_term=1e-14",
            STEP,
            1,
            |_, _| (),
            |_, _, _| (),
        );
        let expected = expected.unwrap();
        let mut found = start.state.clone();
        block_step(&start, &mut found, STEP, Block::Across(1.0)).unwrap();
        for (a, b) in found.x.iter().zip(&expected.x) {
            assert!((a - b).norm() < 1e-8, "{a} {b}");
        }
    }
}
