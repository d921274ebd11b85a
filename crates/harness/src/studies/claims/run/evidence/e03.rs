//! What is run for claim C03.

use super::general::{Elimination, bicgstab};
use super::scenes::{build, hanging, matrix, run};
use super::{Number, Timed, Trial};
use crate::HarnessError;
use crate::claims::c03::{EQUAL, RATIO};
use crate::studies::claims::facts::TimedCase;
use drape_model::{System, Vec3};
use drape_solvers::vector::norm;
use drape_solvers::{LinearOperator, ScalarMatrix};
use std::time::Instant;

pub(super) const TRIAL: Trial = Trial {
    id: "C03",
    scenes: || {
        format!(
            "one step of hanging sheets of 8 × 8, 12 × 12 and 20 × 20 after 0.2 s, h = {STEP} s, \
             h²k/m = 1, 10, 100, with and without damping, equal and unequal masses; velocities by \
             dense elimination of both systems, refined; cost by BiCGStab without preconditioner \
             to 1e-10 (counted multiplications)"
        )
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: Some(seconds),
};

const STEP: f64 = 0.01;
/// Residual, relative, of a solve whose cost is counted.
const TOLERANCE: f64 = 1e-10;

/// The system of section 2.3 for `(Δx, Δv)`, its lower rows multiplied by the masses:
/// `(I, −τ I; τ L_k, M + τ L_c)`.
struct Coupled {
    tau: f64,
    /// `L_k`.
    stiffness: ScalarMatrix,
    /// `M + τ L_c`.
    damped_mass: ScalarMatrix,
}

impl Coupled {
    fn new(system: &System, tau: f64) -> Self {
        let mut edges = Vec::new();
        drape_integrator::Implicit::Springs
            .visit_weights(system, &mut |i, j, k, c| edges.push((i, j, k, c)));
        let pattern = || edges.iter().map(|&(i, j, ..)| (i, j));
        let mut stiffness = ScalarMatrix::with_pattern(system.len(), pattern());
        let mut damped_mass = stiffness.clone();
        for (i, &m) in system.mass().iter().enumerate() {
            damped_mass.add_diagonal(i, m);
        }
        for &(i, j, k, c) in &edges {
            stiffness.add_edge(i, j, k);
            damped_mass.add_edge(i, j, tau * c);
        }
        Self { tau, stiffness, damped_mass }
    }

    /// Multiplications of one product, per coordinate.
    fn work(&self) -> usize {
        self.stiffness.nonzeros() + self.damped_mass.nonzeros() + self.stiffness.n()
    }
}

impl LinearOperator for Coupled {
    fn size(&self) -> usize {
        2 * self.stiffness.n()
    }

    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]) {
        let n = self.stiffness.n();
        let ((dx, dv), (upper, lower)) = (x.split_at(n), y.split_at_mut(n));
        let mut push = vec![Vec3::zeros(); n];
        self.stiffness.multiply(dx, &mut push);
        self.damped_mass.multiply(dv, lower);
        for i in 0..n {
            upper[i] = dx[i] - dv[i] * self.tau;
            lower[i] += push[i] * self.tau;
        }
    }
}

/// The two systems of one step.
struct Step {
    name: String,
    coupled: Coupled,
    reduced: ScalarMatrix,
    /// `(r_x, r_v)`, the latter multiplied by the masses.
    coupled_side: Vec<Vec3>,
    /// `r_v + τ A_x r_x`, likewise.
    reduced_side: Vec<Vec3>,
}

impl Step {
    /// The step after 0.2 s of the fall of a sheet, from `Δ = 0`: `r_x = τ v`, `r_v = τ M⁻¹ f`.
    fn new(side: u32, stiffness: f64, damping: f64, uneven: bool) -> Result<Self, HarnessError> {
        let mut spec = hanging(side, stiffness, damping).spec()?;
        let masses = spec.particles.mass_kg.iter_mut().enumerate();
        masses.filter(|_| uneven).for_each(|(i, m)| *m *= 1.0 + (i % 7) as f64);
        let start = build(&spec)?;
        let method = "imex-euler:norm=euclid,forcing_term=1e-6,implicit=springs";
        let state = run(&start, method, STEP, 0.2, None)?.state;
        let system = &start.system;
        let n = system.len();
        let mut force = vec![Vec3::zeros(); n];
        system.forces(state.level(), &mut force);
        let mut coupled_side: Vec<_> = state.v.iter().map(|v| v * STEP).collect();
        coupled_side.extend(force.iter().map(|f| f * STEP));
        let coupled = Coupled::new(system, STEP);
        let mut reduced_side = vec![Vec3::zeros(); n];
        coupled.stiffness.multiply(&coupled_side[..n], &mut reduced_side);
        for (b, f) in reduced_side.iter_mut().zip(&force) {
            *b = f * STEP - *b * STEP;
        }
        let even = if uneven { ", masses 1 : 7" } else { "" };
        Ok(Self {
            name: format!(
                "n = {n}, h²k/m = {}, hd/m = {}{even}",
                STEP * STEP * stiffness,
                STEP * damping
            ),
            coupled,
            reduced: matrix(system, STEP),
            coupled_side,
            reduced_side,
        })
    }

    /// Difference of the solutions for `Δv` over their norm.
    fn difference(&self) -> f64 {
        let whole = Elimination::new(&self.coupled).solve(&self.coupled, &self.coupled_side);
        let half = Elimination::new(&self.reduced).solve(&self.reduced, &self.reduced_side);
        let apart: Vec<_> = whole[half.len()..].iter().zip(&half).map(|(a, b)| a - b).collect();
        norm(&apart) / norm(&half)
    }

    /// Multiplications of an iteration of BiCGStab: two products with the matrix, and ten updates
    /// and dot products.
    fn iteration(&self) -> (f64, f64) {
        let count = |entries: usize, n: usize| 2.0 * entries as f64 + 10.0 * n as f64;
        let whole = count(self.coupled.work(), self.coupled.size());
        (whole, count(self.reduced.nonzeros(), self.reduced.n()))
    }

    /// Work of the solve with 6n unknowns over that with 3n, both by BiCGStab; infinite where the
    /// former fails, 0 where the latter does.
    fn ratio(&self) -> f64 {
        let mut x = self.coupled_side.clone();
        let whole = bicgstab(&self.coupled, &self.coupled_side, &mut x, TOLERANCE);
        x.truncate(self.reduced_side.len());
        let half = bicgstab(&self.reduced, &self.reduced_side, &mut x, TOLERANCE);
        let (of_whole, of_half) = self.iteration();
        match (whole, half) {
            (Some(whole), Some(half)) => whole as f64 * of_whole / (half as f64 * of_half),
            (None, Some(_)) => f64::INFINITY,
            (_, None) => 0.0,
        }
    }
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for (side, stiffness, damping, uneven) in [
        (8, 1e4, 0.0, false),
        (8, 1e4, 40.0, true),
        (12, 1e5, 40.0, false),
        (12, 1e6, 0.0, true),
        (20, 1e5, 10.0, false),
    ] {
        let step = Step::new(side, stiffness, damping, uneven)?;
        let (difference, ratio, (whole, half)) =
            (step.difference(), step.ratio(), step.iteration());
        let at = &step.name;
        numbers.push(Number::new(format!("difference of Δv, {at}"), difference, "").against(EQUAL));
        let what = format!("work of 6n over that of 3n, BiCGStab, {at}");
        numbers.push(Number::new(what, ratio, "").against(RATIO));
        let what = format!("the same of one iteration, {at}");
        numbers.push(Number::new(what, whole / half, "").against(RATIO));
    }
    Ok(numbers)
}

/// Both solves on the clock.
fn seconds() -> Result<Timed, HarnessError> {
    let step = Step::new(20, 1e5, 10.0, false)?;
    let time = |what: &str, solve: &mut dyn FnMut()| {
        let sample = |_| {
            let begin = Instant::now();
            solve();
            u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX)
        };
        TimedCase { what: what.to_owned(), samples_ns: (0..9).map(sample).collect() }
    };
    let (mut x, mut y) = (step.coupled_side.clone(), step.reduced_side.clone());
    let whole = time("6n unknowns", &mut || {
        let _products = bicgstab(&step.coupled, &step.coupled_side, &mut x, TOLERANCE);
    });
    let half = time("3n unknowns", &mut || {
        let _products = bicgstab(&step.reduced, &step.reduced_side, &mut y, TOLERANCE);
    });
    let ratio = whole.median_s() / half.median_s();
    let number = Number::new(format!("seconds of 6n over those of 3n, {}", step.name), ratio, "")
        .against(RATIO);
    Ok((vec![whole, half], number))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn the_coupled_system_is_that_of_section_2_3_and_a_wrong_side_shows() {
        let mut step = Step::new(5, 1e4, 10.0, true).unwrap();
        assert!(step.difference() < 1e-12);
        step.coupled_side[7].x *= 1.01;
        assert!(step.difference() > 1e-6);
    }
}
