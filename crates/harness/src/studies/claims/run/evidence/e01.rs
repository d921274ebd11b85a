//! What is run for claim C01.

use super::scenes::{build, hanging, matrix, run};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c01::RATIO;
use drape_model::Vec3;
use drape_oracle::Random;
use drape_solvers::vector::{norm, subtract_from};
use drape_solvers::{
    Constraints, Identity, LinearOperator, Norm, PcgSettings, PcgWorkspace, Reference,
    ScalarMatrix, filtered_pcg,
};

pub(super) const TRIAL: Trial = Trial {
    id: "C01",
    scenes: || {
        format!(
            "the matrix of a step of the hanging sheet, n = 100, 400, 1600, h = {STEP} s, k/m = \
             1e6/s² (h²k/m = 100), undamped; right-hand sides of a step after 0.5 s and random \
             ones (seed 1), from zero to 1e-6"
        )
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const TOLERANCE: f64 = 1e-6;
const SIDES: [u32; 3] = [10, 20, 40];
const STEP: f64 = 0.01;
const STIFFNESS: f64 = 1e6;
/// More sweeps are as good as none.
const MOST: usize = 100_000;

/// A stationary iteration, all of which are sweeps over the rows in their order.
#[derive(Clone, Copy)]
enum Sweep {
    Jacobi,
    /// Over-relaxation by a factor; 1 is Gauss-Seidel.
    Relaxed(f64),
}

/// Sweeps from zero until `‖b − A x‖ ≤ 1e-6 ‖b‖`.
fn sweeps(a: &ScalarMatrix, b: &[Vec3], sweep: Sweep) -> usize {
    let goal = TOLERANCE * norm(b);
    let mut x = vec![Vec3::zeros(); b.len()];
    let mut r = x.clone();
    for count in 0..MOST {
        a.multiply(&x, &mut r);
        subtract_from(b, &mut r);
        if norm(&r) <= goal {
            return count;
        }
        match sweep {
            Sweep::Jacobi => (0..x.len()).for_each(|i| x[i] += r[i] / a.diagonal(i)),
            Sweep::Relaxed(omega) => {
                for i in 0..x.len() {
                    let (columns, values) = a.row(i);
                    let products = columns.iter().zip(values).map(|(&j, &w)| x[j as usize] * w);
                    let rest = products.fold(b[i], |rest, product| rest - product);
                    x[i] += rest * (omega / a.diagonal(i));
                }
            }
        }
    }
    MOST
}

fn cg(a: &ScalarMatrix, b: &[Vec3]) -> usize {
    let settings =
        PcgSettings { forcing_term: TOLERANCE, norm: Norm::Euclid, max_iterations: MOST };
    let (free, mut work) = (Constraints::free(b.len()), PcgWorkspace::new(b.len()));
    let mut x = vec![Vec3::zeros(); b.len()];
    let reference = Reference::FilteredRightHandSide;
    filtered_pcg(a, &Identity, &free, b, &mut x, reference, &settings, &mut work).iterations
}

/// The factor with which over-relaxation is fastest on a grid (Young), from the radius of Jacobi's
/// iteration, which is at most `4θ/(1 + 4θ)`.
fn optimal_factor(theta: f64) -> f64 {
    let radius = 4.0 * theta / (1.0 + 4.0 * theta);
    2.0 / (1.0 + (1.0 - radius * radius).sqrt())
}

/// Right-hand sides: what a step in the middle of a fall has, and one without any pattern.
fn right_hand_sides(side: u32) -> Result<(ScalarMatrix, [Vec<Vec3>; 2]), HarnessError> {
    let start = build(&hanging(side, STIFFNESS, 0.0).spec()?)?;
    let method = "imex-euler:norm=euclid,forcing_term=1e-10,implicit=springs";
    let state = run(&start, method, STEP, 0.5, None)?.state;
    let system = &start.system;
    let mut load = vec![Vec3::zeros(); system.len()];
    system.forces(state.level(), &mut load);
    for ((b, v), m) in load.iter_mut().zip(&state.v).zip(system.mass()) {
        *b = *b * STEP + v * *m;
    }
    let mut random = Random::new(1);
    let noise = (0..system.len()).map(|_| random.vector()).collect();
    Ok((matrix(system, STEP), [load, noise]))
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for side in SIDES {
        let (a, sides) = right_hand_sides(side)?;
        for (b, name) in sides.iter().zip(["of a step", "random"]) {
            let jacobi = sweeps(&a, b, Sweep::Jacobi) as f64;
            let seidel = sweeps(&a, b, Sweep::Relaxed(1.0)) as f64;
            let factor = optimal_factor(STEP * STEP * STIFFNESS);
            let relaxed = sweeps(&a, b, Sweep::Relaxed(factor)) as f64;
            let cg = cg(&a, b) as f64;
            let at = format!("n = {}, right-hand side {name}", side * side);
            numbers.push(Number::new(format!("CG iterations, {at}"), cg, ""));
            numbers.push(Number::new(format!("Jacobi sweeps, {at}"), jacobi, ""));
            numbers.push(Number::new(format!("Gauss-Seidel sweeps, {at}"), seidel, ""));
            let ratio = jacobi / cg;
            numbers.push(Number::new(format!("Jacobi / CG, {at}"), ratio, "").against(RATIO));
            let what = format!("over-relaxed sweeps with the best factor, {at}");
            numbers.push(Number::new(what, relaxed, ""));
        }
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One row, no coupling: each iteration is exact at once. Two rows with a known radius `w/(1 +
    /// w)`.
    #[test]
    fn sweeps_are_counted_as_theory_has_them() {
        let mut a = ScalarMatrix::with_pattern(2, [(0, 1)]);
        a.add_diagonal(0, 1.0);
        a.add_diagonal(1, 1.0);
        let b = [Vec3::x(), Vec3::x()];
        assert_eq!(sweeps(&a, &b, Sweep::Jacobi), 1);
        a.add_edge(0, 1, 9.0);
        // r falls by 0.9 a sweep: 0.9¹³² < 1e-6 < 0.9¹³¹; Gauss-Seidel's falls by 0.81.
        assert_eq!(sweeps(&a, &b, Sweep::Jacobi), 132);
        assert!((60..70).contains(&sweeps(&a, &b, Sweep::Relaxed(1.0))));
        assert_eq!(cg(&a, &b), 1);
    }
}
