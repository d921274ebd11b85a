//! Trajectories of public programs, and the steps of those programs written out.
//!
//! A comparison with another program is inconclusive while the programs differ in several things at
//! once. So this module states each difference as a [`Descent`] or a [`Relaxation`]: plain loops
//! that follow the formulas of one program or the other, and that share no code with the methods. A
//! test then shows two things. The loop with the other program's formulas gives its positions up to
//! single precision, and the loop with the method's formulas gives the method's positions up to
//! round-off. The difference between the two loops is therefore the whole difference between the
//! programs.
//!
//! The positions were computed with the physics engine Newton 1.8.0 (warp-lang 1.19.0) by
//! `data/newton_reference.py`. What its solvers and ours have in common, on springs:
//!
//! | | Newton | drape |
//! |---|---|---|
//! | `SolverVBD`: start of the sweeps | `x_n + h v_n + h² g` | the same with `start=inertial` |
//! | block of a spring | `k [ûûᵀ + (1 − ℓ/L)(I − ûûᵀ)]`, indefinite in compression | `1 − ℓ/L` no less than 0 |
//! | damping of a spring | `−(c/h)(L − L_n) û`, with `û` of the present iterate | `−c û_n û_n·(v_i − v_j)` |
//! | colours | given by the user, or by its own algorithm | the least that is free, in the order of the particles |
//! | `SolverXPBD`: a sweep | adds up the corrections of all springs (Jacobi) | one spring after the other |
//! | `λ`, damping along springs | from 0 in each step, `γ = c/(kh)` | the same |

use crate::scenes;
use drape_model::{DampingLaw, GravitySpec, State, System, Vec3};
use nalgebra::Matrix3;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A sheet of springs, and where a public program moved it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// The program with its version.
    pub package: String,
    /// Time step, s.
    pub step_s: f64,
    /// Acceleration of gravity, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Mass of each particle, kg.
    pub mass_kg: f64,
    /// Positions at the start, m.
    pub position_m: Vec<[f64; 3]>,
    /// Velocities at the start, m/s.
    pub velocity_m_s: Vec<[f64; 3]>,
    /// Indices of the particles that do not move.
    pub pins: Vec<usize>,
    /// Indices of the particles at the ends of each spring.
    pub springs: Vec<[usize; 2]>,
    /// The runs.
    pub cases: Vec<Case>,
}

/// A run of a public program.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the case.
    pub name: String,
    /// `vbd` or `xpbd`.
    pub solver: String,
    /// Sweeps in a step.
    pub iterations: usize,
    /// Rest length of each spring, m.
    pub rest_length_m: Vec<f64>,
    /// Stiffness of all springs, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping of all springs, N s/m.
    pub damping_n_s_per_m: f64,
    /// Particles by colour, in the order of a sweep; empty where the solver needs none.
    pub colours: Vec<Vec<usize>>,
    /// Positions after the given numbers of steps, m.
    pub position_after_m: BTreeMap<usize, Vec<[f64; 3]>>,
}

/// The trajectories of the physics engine Newton.
///
/// # Panics
/// If the file `newton.json` is broken.
pub fn newton() -> Published {
    let text = include_str!("../data/newton.json");
    serde_json::from_str(text).unwrap_or_else(|error| panic!("newton.json: {error}"))
}

/// Formulas of a vertex block descent on springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Descent {
    /// Whether the transverse part of a block is clamped to be at least 0.
    pub is_clamped: bool,
    /// Whether damping has the direction of a spring at the start of the step and acts on relative
    /// velocities. Otherwise it acts on the change of the length over the step, along the spring of
    /// the present iterate.
    pub is_damping_lagged: bool,
}

/// How a sweep of XPBD combines the corrections of springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relaxation {
    /// All springs use the same positions.
    Jacobi,
    /// Each spring uses the positions that the springs before it have moved.
    GaussSeidel,
}

impl Published {
    /// The case with this name.
    ///
    /// # Panics
    /// If there is no such case.
    pub fn case(&self, name: &str) -> &Case {
        let found = self.cases.iter().find(|case| case.name == name);
        found.unwrap_or_else(|| panic!("newton.json has no case `{name}`"))
    }

    /// The system of a case, with damping along its springs, and its start.
    pub fn build(&self, case: &Case) -> (System, State) {
        let [x, v] = [&self.position_m, &self.velocity_m_s].map(|rows| vectors(rows));
        let mut spec = scenes::particles(&vec![self.mass_kg; x.len()], &x, &v);
        spec.damping = DampingLaw::Projected;
        spec.effects.gravity = Some(GravitySpec { m_s2: self.gravity_m_s2 });
        spec.pins = self.pins.iter().map(|&particle| scenes::pin(particle)).collect();
        let (k, c) = (case.stiffness_n_per_m, case.damping_n_s_per_m);
        let springs = self.springs.iter().zip(&case.rest_length_m);
        spec.springs = springs.map(|(&[i, j], &l)| scenes::tension((i, j), l, k, c)).collect();
        scenes::build(&spec)
    }

    /// Positions after `steps` steps of vertex block descent with the colours of the case, m.
    pub fn descend(&self, case: &Case, formulas: Descent, steps: usize) -> Vec<Vec3> {
        self.run(steps, |from, predicted| {
            let mut x = predicted.to_vec();
            for _ in 0..case.iterations {
                for &i in case.colours.iter().flatten().filter(|i| !self.pins.contains(i)) {
                    let change = self.newton_step(case, formulas, i, from, predicted, &x);
                    x[i] += change;
                }
            }
            x
        })
    }

    /// How far one step of Newton's method moves particle `i`, m.
    fn newton_step(
        &self,
        case: &Case,
        formulas: Descent,
        i: usize,
        from: &[Vec3],
        predicted: &[Vec3],
        x: &[Vec3],
    ) -> Vec3 {
        let h = self.step_s;
        let (k, c) = (case.stiffness_n_per_m, case.damping_n_s_per_m);
        let inertia = self.mass_kg / (h * h);
        let mut force = (predicted[i] - x[i]) * inertia;
        let mut block = Matrix3::from_diagonal_element(inertia);
        for (ends, rest) in self.springs.iter().zip(&case.rest_length_m) {
            let j = match *ends {
                [a, b] if a == i => b,
                [a, b] if b == i => a,
                _ => continue,
            };
            let (d, before) = (x[i] - x[j], from[i] - from[j]);
            let (length, u) = (d.norm(), d.normalize());
            let across = 1.0 - rest / length;
            let across = if formulas.is_clamped { across.max(0.0) } else { across };
            force -= u * (k * (length - rest));
            let along = u * u.transpose();
            block += (along + (Matrix3::identity() - along) * across) * k;
            let (u, rate) = match formulas.is_damping_lagged {
                true => (before.normalize(), before.normalize().dot(&(d - before)) / h),
                false => (u, (length - before.norm()) / h),
            };
            force -= u * (c * rate);
            block += u * u.transpose() * (c / h);
        }
        block.lu().solve(&force).unwrap_or_else(|| panic!("the block of particle {i} is singular"))
    }

    /// Positions after `steps` steps of XPBD with damping along the springs, m.
    pub fn relax(&self, case: &Case, relaxation: Relaxation, steps: usize) -> Vec<Vec3> {
        let (h, k) = (self.step_s, case.stiffness_n_per_m);
        let (alpha, gamma) = (1.0 / (k * h * h), case.damping_n_s_per_m / (k * h));
        let w = |i: usize| if self.pins.contains(&i) { 0.0 } else { 1.0 / self.mass_kg };
        self.run(steps, |from, predicted| {
            let mut x = predicted.to_vec();
            let mut lambda = vec![0.0; self.springs.len()];
            for _ in 0..case.iterations {
                let mut seen = x.clone();
                let springs = self.springs.iter().zip(&case.rest_length_m);
                for ((&[i, j], rest), lambda) in springs.zip(&mut lambda) {
                    let (d, before) = (seen[i] - seen[j], from[i] - from[j]);
                    let (length, u) = (d.norm(), d.normalize());
                    let stretch = length - rest + alpha * *lambda + gamma * u.dot(&(d - before));
                    let step = -stretch / ((1.0 + gamma) * (w(i) + w(j)) + alpha);
                    *lambda += step;
                    x[i] += u * (w(i) * step);
                    x[j] -= u * (w(j) * step);
                    if relaxation == Relaxation::GaussSeidel {
                        (seen[i], seen[j]) = (x[i], x[j]);
                    }
                }
            }
            x
        })
    }

    /// Goes so many steps from the positions of free motion.
    fn run(&self, steps: usize, step: impl Fn(&[Vec3], &[Vec3]) -> Vec<Vec3>) -> Vec<Vec3> {
        let [mut x, mut v] = [&self.position_m, &self.velocity_m_s].map(|rows| vectors(rows));
        let (h, gravity) = (self.step_s, Vec3::from(self.gravity_m_s2));
        for _ in 0..steps {
            let free = |i: usize| match self.pins.contains(&i) {
                true => x[i],
                false => x[i] + (v[i] + gravity * h) * h,
            };
            let predicted: Vec<_> = (0..x.len()).map(free).collect();
            let next = step(&x, &predicted);
            v = next.iter().zip(&x).map(|(next, x)| (next - x) / h).collect();
            x = next;
        }
        x
    }
}

/// Rows of three numbers as vectors.
pub fn vectors(rows: &[[f64; 3]]) -> Vec<Vec3> {
    rows.iter().map(|row| Vec3::from(*row)).collect()
}
