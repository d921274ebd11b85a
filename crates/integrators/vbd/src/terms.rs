//! The forces on one particle, and their blocks on the diagonal.

use crate::rows::Rows;
use drape_integrator::Implicit;
use drape_model::effects::COLLAPSED;
use drape_model::{BlockSink, Effect, Level, LinearSplit, Mat3, System, Vec3};
use drape_solvers::lanes::Lanes;

/// A spring, as the sweep reads it.
#[derive(Clone, Copy, Debug)]
struct Spring {
    ends: [u32; 2],
    /// `ℓ`, m.
    rest: f64,
    /// `k`, N/m, of a linear spring.
    stiffness: f64,
    /// `k̄ ≤ k`, N/m: the stiffness of the present sweep (AVBD).
    penalty: f64,
    /// Where its law is, if it is not linear: its effect among all, its place in that effect.
    law: Option<(u32, u32)>,
}

/// A spring at one of its ends.
#[derive(Clone, Copy, Debug)]
struct Arm {
    other: u32,
    spring: u32,
}

/// A stencil at one of its particles.
#[derive(Clone, Copy, Debug)]
struct Corner {
    effect: u32,
    stencil: u32,
    place: u32,
}

/// The conservative forces of all springs, angles and hinges, particle by particle.
#[derive(Debug)]
pub(crate) struct Terms {
    springs: Vec<Spring>,
    arms: Rows<Arm>,
    corners: Rows<Corner>,
    /// Stamp of the stiffnesses in `springs`.
    stamp: u64,
    /// Whether springs have their penalty in place of their stiffness.
    pub(crate) are_augmented: bool,
}

/// `T/L` and `T'` of a spring, N/m.
struct Response {
    secant: f64,
    slope: f64,
}

impl Terms {
    pub(crate) fn new(system: &System, are_augmented: bool) -> Self {
        let (mut springs, mut corners) = (Vec::new(), Vec::new());
        for (effect, index) in system.effects().zip(0..) {
            if let Some(split) = effect.split() {
                let mut place = 0;
                split.visit_rest_lengths(&mut |i, j, rest| {
                    let law = split.law(place as usize).map(|_| (index, place));
                    let ends = [i as u32, j as u32];
                    springs.push(Spring { ends, rest, stiffness: 0.0, penalty: 0.0, law });
                    place += 1;
                });
            }
            if let Some(stencils) = effect.stencils() {
                let mut stencil = 0;
                stencils.visit(&mut |particles| {
                    for (&i, place) in particles.iter().zip(0..) {
                        corners.push((i as usize, Corner { effect: index, stencil, place }));
                    }
                    stencil += 1;
                });
            }
        }
        let arms = (0..).zip(&springs).flat_map(|(spring, Spring { ends: [i, j], .. })| {
            [(*i as usize, Arm { other: *j, spring }), (*j as usize, Arm { other: *i, spring })]
        });
        let arms = Rows::new(system.len(), arms.filter(|(i, a)| *i != a.other as usize).collect());
        let corners = Rows::new(system.len(), corners);
        let mut terms = Self { springs, arms, corners, stamp: 0, are_augmented };
        terms.read_stiffness(system);
        terms
    }

    /// Follows changes of stiffnesses; says whether there were any.
    pub(crate) fn refresh(&mut self, system: &System) -> bool {
        let is_stale = self.stamp != system.revisions().stiffness;
        if is_stale {
            self.read_stiffness(system);
        }
        is_stale
    }

    /// Whether all terms are linear springs of constant stiffness.
    pub(crate) fn are_plain(&self) -> bool {
        let is_linear = self.springs.iter().all(|spring| spring.law.is_none());
        is_linear && self.corners.entries() == 0 && !self.are_augmented
    }

    /// The springs of a particle with the particles at their other ends.
    pub(crate) fn springs_of(&self, i: usize) -> impl Iterator<Item = (u32, u32)> {
        self.arms.row(i).iter().map(|arm| (arm.spring, arm.other))
    }

    /// `ℓ` and `k` of a spring, m and N/m; 0 where there is none.
    pub(crate) fn numbers(&self, spring: u32) -> (f64, f64) {
        self.springs.get(spring as usize).map_or((0.0, 0.0), |s| (s.rest, s.stiffness))
    }

    fn read_stiffness(&mut self, system: &System) {
        self.stamp = system.revisions().stiffness;
        let mut springs = self.springs.iter_mut();
        Implicit::Springs.visit_weights(system, &mut |_, _, k, _| {
            if let Some(spring) = springs.next() {
                spring.stiffness = k;
            }
        });
    }

    /// `(f_i, K_ii)` at `x`, N and N/m, with the blocks of springs
    /// `k [ûûᵀ + max(0, 1 − ℓ/L)(I − ûûᵀ)]` or, for other laws,
    /// `T' ûûᵀ + max(0, T/L)(I − ûûᵀ)`.
    pub(crate) fn at(&self, system: &System, i: usize, x: &[Vec3]) -> (Vec3, Mat3) {
        let (mut force, mut block) = (Vec3::zeros(), Mat3::zeros());
        for arm in self.arms.row(i) {
            let spring = &self.springs[arm.spring as usize];
            let d = x[i] - x[arm.other as usize];
            let length = d.norm();
            let has_direction = length > COLLAPSED * spring.rest;
            let Response { secant, slope } = self.response(system, spring, length, has_direction);
            let is_augmented = self.are_augmented && spring.law.is_none();
            let across = if is_augmented { secant.abs() } else { secant.max(0.0) };
            force -= d * secant;
            block += Mat3::from_diagonal_element(across);
            if has_direction {
                let u = d / length;
                block += u * u.transpose() * (slope - across);
            }
        }
        for corner in self.corners.row(i) {
            let effect = system.effects().nth(corner.effect as usize);
            if let Some(stencils) = effect.and_then(Effect::stencils) {
                let (pull, stiffness) =
                    stencils.local(corner.stencil as usize, corner.place as usize, x);
                force += pull;
                block += stiffness;
            }
        }
        (force, block)
    }

    fn response(&self, system: &System, s: &Spring, length: f64, has_direction: bool) -> Response {
        let law = s.law.and_then(|(effect, place)| {
            let split = system.effects().nth(effect as usize)?.split()?;
            LinearSplit::law(split, place as usize)
        });
        if let Some(law) = law {
            let slope = law.slope(s.rest, length);
            let secant = if has_direction { law.secant(s.rest, length) } else { slope };
            return Response { secant, slope };
        }
        let k = if self.are_augmented { s.penalty } else { s.stiffness };
        let rest_over_length = if has_direction { s.rest / length } else { 0.0 };
        Response { secant: k * (1.0 - rest_over_length), slope: k }
    }

    /// AVBD, start of a step: `k̄ ← min(max(γ k̄, k̄_min), k)`, (V7), with `k̄_min = m/h²` of the
    /// lighter end, which a step resolves by inertia alone; `k̄_min` itself without history.
    pub(crate) fn soften(&mut self, mass: &[f64], h: f64, gamma: Option<f64>) {
        for Spring { ends: [i, j], stiffness, penalty, .. } in &mut self.springs {
            let least = mass[*i as usize].min(mass[*j as usize]) / (h * h);
            *penalty = (gamma.unwrap_or(0.0) * *penalty).max(least).min(*stiffness);
        }
    }

    /// AVBD, end of a sweep: `k̄ ← min(k̄ + β k |L − ℓ|/max(L, ℓ), k)`, (V8).
    pub(crate) fn stiffen(&mut self, x: &[Vec3], beta: f64) {
        for Spring { ends: [i, j], rest, stiffness, penalty, .. } in &mut self.springs {
            let length = (x[*i as usize] - x[*j as usize]).norm();
            let longer = length.max(*rest);
            if longer > 0.0 {
                let strain = (length - *rest).abs() / longer;
                *penalty = (*penalty + beta * *stiffness * strain).min(*stiffness);
            }
        }
    }
}

/// The damping of a step, `D(x̂) v` less the force of a wind, with all coefficients and directions
/// at one lagged level.
#[derive(Debug)]
pub(crate) struct Damping {
    neighbours: Rows<u32>,
    /// `D_ij`, N s/m, in the order of `neighbours`.
    beside: Vec<Mat3>,
    /// `D_ii`, N s/m.
    diagonal: Vec<Mat3>,
    /// Force of drags on a cloth at rest, N; empty without drags.
    at_rest: Vec<Vec3>,
    zeros: Vec<Vec3>,
    /// The columns of `beside` and `diagonal` as registers, with a fourth number 0.
    beside_columns: Vec<[Lanes; 3]>,
    diagonal_columns: Vec<[Lanes; 3]>,
}

fn damped(system: &System) -> impl Iterator<Item = &dyn Effect> {
    Implicit::Everything.effects(system).filter(|effect| effect.has_damping())
}

/// The columns of blocks as registers.
fn widen(blocks: &[Mat3], columns: &mut [[Lanes; 3]]) {
    for (columns, block) in columns.iter_mut().zip(blocks) {
        *columns = [0, 1, 2].map(|k| [block[(0, k)], block[(1, k)], block[(2, k)], 0.0]);
    }
}

impl Damping {
    pub(crate) fn new(system: &System) -> Self {
        let mut pairs = Vec::new();
        for effect in damped(system) {
            effect.visit_pairs(&mut |i, j| pairs.push((i, j)));
        }
        let neighbours = crate::rows::neighbours(system.len(), &pairs);
        let drags = if damped(system).any(Effect::is_drag) { system.len() } else { 0 };
        Self {
            beside: vec![Mat3::zeros(); neighbours.entries()],
            beside_columns: vec![[[0.0; 4]; 3]; neighbours.entries()],
            diagonal_columns: vec![[[0.0; 4]; 3]; system.len()],
            diagonal: vec![Mat3::zeros(); system.len()],
            neighbours,
            at_rest: vec![Vec3::zeros(); drags],
            zeros: vec![Vec3::zeros(); drags],
        }
    }

    /// Takes `D` at a level.
    pub(crate) fn assemble(&mut self, system: &System, lagged: Level<'_>) {
        self.beside.fill(Mat3::zeros());
        self.diagonal.fill(Mat3::zeros());
        for effect in damped(system) {
            effect.add_damping(lagged, 1.0, self);
        }
        self.at_rest.fill(Vec3::zeros());
        for effect in damped(system).filter(|effect| effect.is_drag()) {
            effect.add_lagged_damping_force(lagged, &self.zeros, &mut self.at_rest);
        }
        widen(&self.beside, &mut self.beside_columns);
        widen(&self.diagonal, &mut self.diagonal_columns);
    }

    /// `D_ii` by columns, and the neighbours of particle `i` with `D_ij` by columns.
    pub(crate) fn columns(
        &self,
        i: usize,
    ) -> (&[Lanes; 3], impl Iterator<Item = (u32, &[Lanes; 3])>) {
        let row = self.neighbours.row(i).iter().copied();
        (&self.diagonal_columns[i], row.zip(&self.beside_columns[self.neighbours.range(i)]))
    }

    /// Force of drags on particle `i` at rest, N.
    pub(crate) fn force_at_rest(&self, i: usize) -> Vec3 {
        self.at_rest.get(i).copied().unwrap_or_default()
    }

    /// `((D v)_i, D_ii)`, N and N s/m.
    pub(crate) fn at(&self, i: usize, v: &[Vec3]) -> (Vec3, Mat3) {
        let row = self.neighbours.row(i).iter().zip(&self.beside[self.neighbours.range(i)]);
        let sum = row.fold(self.diagonal[i] * v[i], |sum, (&j, block)| sum + block * v[j as usize]);
        (sum, self.diagonal[i])
    }

    fn subtract(&mut self, i: usize, j: usize, block: &Mat3) {
        if let Ok(place) = self.neighbours.row(i).binary_search(&(j as u32)) {
            self.beside[self.neighbours.range(i).start + place] -= block;
        }
    }
}

impl BlockSink for Damping {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_general_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if i == j {
            return;
        }
        let transposed = block.transpose();
        self.diagonal[i] += block;
        self.diagonal[j] += transposed;
        self.subtract(i, j, block);
        self.subtract(j, i, &transposed);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.diagonal[i] += block;
    }
}
