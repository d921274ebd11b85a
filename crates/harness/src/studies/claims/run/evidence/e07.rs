//! What is run for claim C07.

use super::meshes::Mesh;
use super::runs::{free_edge, track, true_motion};
use super::scenes::{build, error, hanging, matrix, run};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c07::{GAIN, LEFT};
use crate::run::Simulation;
use crate::stability::reference_energy;
use drape_integrator::Implicit;
use drape_model::{Effect, System, SystemSpec, Vec3};
use drape_solvers::vector::{norm, subtract_from};
use drape_solvers::{LinearOperator, ScalarMatrix};

pub(super) const TRIAL: Trial = Trial {
    id: "C07",
    scenes: || {
        format!(
            "hanging sheets (grids of 10 × 10 and 20 × 20, triangles), d/m = 10/s, h = {STEP} s, \
             h²k/m = 1, 10, 100, 1000; residual of the printed sweep in a step after 0.1, 0.3 and \
             1 s of {IMEX}; positions after 0.3 and 1 s against symplectic Euler at a quarter of \
             its limit; energy over 1 s"
        )
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const STEP: f64 = 0.01;
const STIFFNESSES: [f64; 4] = [1e4, 1e5, 1e6, 1e7];
/// When the state is taken that the sweep is tried on, and when errors are.
const MOMENTS: [f64; 3] = [0.1, 0.3, 1.0];
/// How long the energy is watched, s.
const WATCH: f64 = 1.0;
const IMEX: &str = "imex-euler:norm=euclid,forcing_term=1e-8,implicit=springs";

/// What Kang's sweep leaves of the right-hand side `h (F_int − h L_k v)`: a sweep from zero is
/// division by the diagonal, the correction by the neighbours is the second.
fn residual(a: &ScalarMatrix, b: &[Vec3]) -> f64 {
    let mut x: Vec<_> = b.iter().enumerate().map(|(i, b)| b / a.diagonal(i)).collect();
    let mut r = vec![Vec3::zeros(); b.len()];
    a.multiply(&x, &mut r);
    subtract_from(b, &mut r);
    x.iter_mut().zip(&r).enumerate().for_each(|(i, (x, r))| *x += r / a.diagonal(i));
    a.multiply(&x, &mut r);
    subtract_from(b, &mut r);
    norm(&r) / norm(b)
}

/// The residual in a step from a state on the way.
fn left(start: &Simulation, moment: f64) -> Result<f64, HarnessError> {
    let state = run(start, IMEX, STEP, moment, None)?.state;
    let system = &start.system;
    let mut b = vec![Vec3::zeros(); system.len()];
    Implicit::Springs.add_linear_spring_forces(system, &state.v, &mut b);
    b.iter_mut().for_each(|b| *b *= STEP);
    Implicit::Springs.add_implicit_forces(system, &state.x, &mut b);
    Ok(residual(&matrix(system, STEP), &b))
}

/// Lengths of all springs over their rest lengths, less 1.
fn elongation(system: &System, x: &[Vec3]) -> f64 {
    let (mut length, mut rest) = (0.0, 0.0);
    for split in system.effects().filter_map(Effect::split) {
        split.visit_rest_lengths(&mut |i, j, rest_length| {
            length += (x[i] - x[j]).norm();
            rest += rest_length;
        });
    }
    length / rest - 1.0
}

fn scenes(stiffness: f64) -> Result<[(&'static str, SystemSpec); 3], HarnessError> {
    Ok([
        ("grid of 10 × 10", hanging(10, stiffness, 10.0).spec()?),
        ("grid of 20 × 20", hanging(20, stiffness, 10.0).spec()?),
        ("triangles", Mesh::Triangles.hanging(9, stiffness, 10.0)?),
    ])
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for stiffness in STIFFNESSES {
        for (name, spec) in scenes(stiffness)? {
            let start = build(&spec)?;
            for moment in MOMENTS {
                let left = left(&start, moment)?;
                let at = format!("{name}, h²k/m = {}, t = {moment} s", STEP * STEP * stiffness);
                numbers.push(Number::new(format!("residual left, {at}"), left, "").against(LEFT));
            }
            for moment in &MOMENTS[1..] {
                let truth = true_motion(&start, *moment, free_edge(&spec))?.state;
                let of = |method: &str| run(&start, method, STEP, *moment, None);
                let (kang, imex) = (of("kang")?.state, of(IMEX)?.state);
                let [off, imex_off] = [&kang, &imex].map(|state| error(&start, &truth, state));
                let at = format!("{name}, h²k/m = {}, t = {moment} s", STEP * STEP * stiffness);
                let what = format!("error over motion, Kang, {at}");
                numbers.push(Number::new(what, off, "").against(imex_off));
                let what = format!("mean elongation of the springs, Kang, {at}");
                numbers.push(Number::new(what, elongation(&start.system, &kang.x), ""));
                let what = format!("mean elongation of the springs, truth, {at}");
                numbers.push(Number::new(what, elongation(&start.system, &truth.x), ""));
            }
            let kang = track(&start, "kang", STEP, WATCH, 0)?;
            let gain = kang.gain / reference_energy(&start, WATCH)?;
            let what = format!(
                "energy gained over energy set free, Kang, {name}, h²k/m = {}",
                STEP * STEP * stiffness
            );
            numbers.push(Number::new(what, gain, "").against(GAIN));
        }
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two particles on a spring, `w = h²k/m`: pulled apart, the Jacobi eigenvalue is −w/(1 + w),
    /// and two sweeps leave its square.
    #[test]
    fn the_residual_of_two_sweeps_is_the_square_of_the_jacobi_eigenvalue() {
        let mut a = ScalarMatrix::with_pattern(2, [(0, 1)]);
        a.add_diagonal(0, 1.0);
        a.add_diagonal(1, 1.0);
        a.add_edge(0, 1, 4.0);
        assert!((residual(&a, &[Vec3::x(), -Vec3::x()]) - 0.64).abs() < 1e-15);
    }
}
