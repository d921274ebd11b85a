//! C07: one Jacobi sweep is too little for stiff systems.

use super::meshes::Mesh;
use super::runs::{free_edge, true_motion};
use super::scenes::{build, error, hanging, least, matrix, run};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::experiments::short;
use crate::run::Simulation;
use drape_integrator::Implicit;
use drape_model::{SystemSpec, Vec3};
use drape_solvers::vector::{norm, subtract_from};
use drape_solvers::{LinearOperator, ScalarMatrix};

pub(super) const CLAIM: Claim = Claim {
    id: "C07",
    section: "3",
    says: "one Jacobi sweep is too little for stiff systems",
    criterion: "residual left > 10 % at h²k/m ≥ 1, and error worse than that of IMEX Euler at equal h",
    is_quick: false,
    test,
    seconds: None,
};

const LEFT: f64 = 0.1;
const STEP: f64 = 0.01;
const STIFFNESSES: [f64; 4] = [1e4, 1e5, 1e6, 1e7];
/// When the state is taken that the sweep is tried on, and when errors are.
const MOMENTS: [f64; 2] = [0.1, 0.3];
const IMEX: &str = "imex-euler:forcing_term=1e-8,implicit=springs";

/// What Kang's sweep leaves of the right-hand side `h (F_int − h L_k v)`: a sweep from zero is division by the
/// diagonal, the correction by the neighbours is the second.
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

fn scenes(stiffness: f64) -> Result<[(&'static str, SystemSpec); 3], HarnessError> {
    Ok([
        ("grid of 10 × 10", hanging(10, stiffness, 0.0).spec()?),
        ("grid of 20 × 20", hanging(20, stiffness, 0.0).spec()?),
        ("triangles", Mesh::Triangles.hanging(9, stiffness, 0.0)?),
    ])
}

fn test() -> Result<Finding, HarnessError> {
    let (mut residuals, mut errors, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
    for stiffness in STIFFNESSES {
        for (name, spec) in scenes(stiffness)? {
            let start = build(&spec)?;
            for moment in MOMENTS {
                let left = left(&start, moment)?;
                let at = format!("{name}, h²k/m = {}, t = {moment} s", STEP * STEP * stiffness);
                numbers.push(Number::new(format!("residual left, {at}"), left, "").against(LEFT));
                residuals.push(left);
            }
            let span = MOMENTS[MOMENTS.len() - 1];
            let truth = true_motion(&start, span, free_edge(&spec))?.state;
            let of = |method: &str| -> Result<f64, HarnessError> {
                Ok(error(&start, &truth, &run(&start, method, STEP, span, None)?.state))
            };
            let (kang, imex) = (of("kang")?, of(IMEX)?);
            let at = format!("{name}, h²k/m = {}", STEP * STEP * stiffness);
            numbers.push(
                Number::new(format!("error over motion, Kang, {at}"), kang, "").against(imex),
            );
            numbers.push(Number::new(format!("error over motion, IMEX Euler, {at}"), imex, ""));
            errors.push((kang, imex));
        }
    }
    Ok(judge(&residuals, &errors, numbers))
}

fn judge(residuals: &[f64], errors: &[(f64, f64)], numbers: Vec<Number>) -> Finding {
    let least_left = least(residuals.iter().copied());
    let worse = errors.iter().filter(|(kang, imex)| kang > imex).count();
    let (kang_low, kang_high) = errors
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(low, high), (kang, _)| (low.min(*kang), high.max(*kang)));
    Finding {
        verdict: Verdict::of(least_left > LEFT && worse == errors.len()),
        numbers,
        reason: format!(
            "The sweep leaves at least {} of the right-hand side, and its positions are farther from the truth than those of IMEX \
             Euler at the same step in {worse} of {} scenes (its error is {} to {} of the motion). Two Jacobi sweeps from zero \
             carry a force to the second neighbour only, so that a smooth stretch of the whole sheet is hardly resisted.",
            short(least_left),
            errors.len(),
            short(kang_low),
            short(kang_high)
        ),
        repair: None,
        scenes: format!(
            "hanging sheets (grids of 10 × 10 and 20 × 20, triangles), undamped, h = {STEP} s, h²k/m = 1, 10, 100, 1000; residual of \
             the printed sweep in a step after 0.1 and 0.3 s of {IMEX}; positions after 0.3 s against leapfrog at a quarter of its limit"
        ),
        see: "work-precision.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_halves_of_the_criterion_must_hold_everywhere() {
        let verdict =
            |left, kang| judge(&[0.9, left], &[(0.5, 0.1), (kang, 0.1)], Vec::new()).verdict;
        assert_eq!(verdict(0.2, 0.2), Verdict::Confirmed);
        assert_eq!(verdict(0.05, 0.2), Verdict::Refuted);
        assert_eq!(verdict(0.2, 0.05), Verdict::Refuted);
    }

    /// Two particles on a spring, `w = h²k/m`: pulled apart, the Jacobi eigenvalue is −w/(1 + w), and two sweeps leave its
    /// square.
    #[test]
    fn the_residual_of_two_sweeps_is_the_square_of_the_jacobi_eigenvalue() {
        let mut a = ScalarMatrix::with_pattern(2, [(0, 1)]);
        a.add_diagonal(0, 1.0);
        a.add_diagonal(1, 1.0);
        a.add_edge(0, 1, 4.0);
        assert!((residual(&a, &[Vec3::x(), -Vec3::x()]) - 0.64).abs() < 1e-15);
    }
}
