//! The energy ledger: the change of the total energy in one step, cause by cause.
//!
//! Let a step move positions by `h w`. It changes velocities by the forces that it used and by a
//! remainder `p`:
//!
//! ```text
//! x₊ = x_n + h w          M (v₊ − v_n) = h Σ_e f_e + h f_damping + p
//! ```
//!
//! `w` is `v_n` for explicit Euler, `v½` for leapfrog and `v₊` for all other one-step methods.
//! `p = A v₊ − b` comes from the method's own matrix and right-hand side: `S p` is the residual of
//! its solve, `(I − S) p` the impulse of pins and contacts. By algebra alone,
//!
//! ```text
//! ΔH = Σ_e [U_e(x₊) − U_e(x_n) + h w·f_e]      gap of each effect
//!    + h w·f_damping                           damping
//!    + w·S p                                   residual
//!    + w·(I − S) p                             constraint
//!    + ½‖v₊ − w‖²_M − ½‖w − v_n‖²_M            inertia; in the directions of constraints impact
//! ```
//!
//! All further changes of positions and velocities are the *correction* of a method: the energy
//! after them minus the energy before. Each term is computed independently, so their sum is a test
//! of all terms.
//!
//! The last line is `−½‖v₊ − v_n‖²_M` for implicit and symplectic Euler, and its negative for
//! explicit Euler. Constraints split this line in two, because they prescribe velocities in their
//! directions. The energy that an inelastic impact takes is not numerical damping.

use crate::{Implicit, Split, TimeStep, lead_pins};
use drape_model::{Effect, Level, State, System, Tangent, Vec3};
use drape_solvers::{Constraints, vector::dot};

/// The change of the total energy in one step, J; a positive term adds energy.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyLedger {
    /// Work of the damping forces that the step used. It is physical.
    pub damping: f64,
    /// `½‖v₊ − w‖²_M − ½‖w − v_n‖²_M` in free directions. It is numerical.
    pub inertia: f64,
    /// The same expression in the directions of constraints: the loss by an impact on an obstacle.
    pub impact: f64,
    /// For each effect, the change of its energy minus the work of the force that the step used for
    /// it. It is numerical.
    pub gaps: Vec<(&'static str, f64)>,
    /// Work of the residual of the solve.
    pub residual: f64,
    /// Work of pins and contacts.
    pub constraint: f64,
    /// Work of all other changes of positions or velocities.
    pub correction: f64,
}

impl EnergyLedger {
    fn terms(&self) -> impl Iterator<Item = f64> {
        let Self { damping, inertia, impact, gaps, residual, constraint, correction } = self;
        let others = [*damping, *inertia, *impact, *residual, *constraint, *correction];
        others.into_iter().chain(gaps.iter().map(|(_, gap)| *gap))
    }

    /// The change of the total energy that the terms account for, J.
    pub fn sum(&self) -> f64 {
        self.terms().sum()
    }

    /// Sum of the magnitudes of the terms, J. It is the scale for the round-off of the sum.
    pub fn magnitude(&self) -> f64 {
        self.terms().map(f64::abs).sum()
    }

    /// Sum of the gaps of all effects, J.
    pub fn gap(&self) -> f64 {
        self.gaps.iter().map(|(_, gap)| *gap).sum()
    }
}

/// Makes the ledger of a step from the forces and impulses that the method reports.
///
/// It is slow: a ledger is a diagnosis that allocates and evaluates forces again.
#[derive(Debug)]
pub struct Bookkeeping<'a> {
    system: &'a System,
    h: f64,
    before: &'a State,
    /// `v_n`, at rest where pinned.
    velocity: Vec<Vec3>,
    /// `w`.
    moving: &'a [Vec3],
    /// Start of the motion, m: `x_n`, or the altered positions.
    start: Vec<Vec3>,
    /// `x₊`.
    end: Vec<Vec3>,
    ledger: EnergyLedger,
}

impl<'a> Bookkeeping<'a> {
    /// Begins the ledger of a step that moves positions by `h w`, where `w` is `moving`, m/s. An
    /// `alteration`, m, is a displacement that the step applied to the positions before.
    pub fn new(
        system: &'a System,
        before: &'a State,
        h: TimeStep,
        moving: &'a [Vec3],
        alteration: Option<&[Vec3]>,
    ) -> Self {
        let mut start = before.x.clone();
        for (x, y) in start.iter_mut().zip(alteration.into_iter().flatten()) {
            *x += y;
        }
        let velocity = as_stepped(system, before, h);
        let h = h.seconds();
        let end: Vec<_> = start.iter().zip(moving).map(|(x, w)| x + w * h).collect();
        let ledger = EnergyLedger {
            damping: 0.0,
            inertia: 0.0,
            impact: 0.0,
            gaps: Vec::new(),
            residual: 0.0,
            // Velocities of pinned particles are set to 0 before the step begins.
            constraint: system.kinetic_energy(&velocity) - system.kinetic_energy(&before.v),
            correction: change(system, &before.x, &start),
        };
        Self { system, h, before, velocity, moving, start, end, ledger }
    }

    /// `x₊`, m.
    pub fn end(&self) -> &[Vec3] {
        &self.end
    }

    /// `v_n`, m/s, at rest where pinned.
    pub fn velocity(&self) -> &[Vec3] {
        &self.velocity
    }

    /// Enters the gaps. `used` adds the conservative force, N, that the step used for an effect.
    pub fn forces(&mut self, mut used: impl FnMut(&dyn Effect, &mut [Vec3])) {
        let mut force = vec![Vec3::zeros(); self.system.len()];
        for effect in self.system.effects() {
            force.fill(Vec3::zeros());
            used(effect, &mut force);
            let mass = self.system.mass();
            let energy = effect.energy(mass, &self.end) - effect.energy(mass, &self.start);
            let gap = energy + self.h * dot(&force, self.moving);
            self.ledger.gaps.push((effect.name(), gap));
            self.lead_against(&force);
        }
    }

    /// Enters the damping. `used` adds the damping force, N, that the step used for an effect.
    pub fn damping(&mut self, mut used: impl FnMut(&dyn Effect, &mut [Vec3])) {
        let mut force = vec![Vec3::zeros(); self.system.len()];
        self.system.effects().for_each(|effect| used(effect, &mut force));
        self.damping_force(&force);
    }

    /// Enters the damping force, N, that the step used for all effects together.
    pub fn damping_force(&mut self, force: &[Vec3]) {
        self.ledger.damping += self.h * dot(force, self.moving);
        self.lead_against(force);
    }

    /// Enters the work of pins on paths against a force, N. They follow their paths, so their
    /// impulse is the opposite of the force.
    fn lead_against(&mut self, force: &[Vec3]) {
        for i in self.system.moving_pins().iter().map(|pin| pin.particle) {
            self.ledger.constraint -= self.h * force[i].dot(&self.moving[i]);
        }
    }

    fn is_led(&self, particle: usize) -> bool {
        self.system.moving_pins().iter().any(|pin| pin.particle == particle)
    }

    /// Enters forces and damping of a method that takes both at level `n`.
    pub fn explicit(&mut self) {
        let start = self.at_start();
        let mass = self.system.mass();
        self.forces(|effect, out| effect.add_force(mass, &start.x, out));
        self.damping(|effect, out| effect.add_damping_force(start.level(), out));
    }

    /// Enters forces and damping of backward Euler: implicit effects at the end of the step, except
    /// that the directions of projected damping are those of level `n`.
    pub fn implicit(&mut self, implicit: Implicit) {
        let start = self.at_start();
        let x = &start.x;
        let (mass, end, new) = (self.system.mass(), self.end.clone(), self.moving);
        self.forces(|effect, out| {
            effect.add_force(mass, if implicit.selects(effect) { &end } else { x }, out);
        });
        self.damping(|effect, out| {
            lagged_damping_force(effect, implicit, start.level(), new, out);
        });
    }

    /// Enters forces and damping of a method with the matrix `M + h² L_k + h L_c` of the implicit
    /// effects, solved for `v`, m/s. The force is `F(x̂) − L_k (x_n + h v − x̂)`; the damping is
    /// `−L_c v` with the remainder of projected damping at `v̂`. `hat = (x̂, v̂)` is the level of
    /// the right-hand side; other effects are taken at level `n`.
    pub fn split(&mut self, implicit: Implicit, v: &[Vec3], hat: (&[Vec3], &[Vec3])) {
        self.split_as(Split::Majorant, implicit, v, hat);
    }

    /// As [`split`](Self::split), but the stiffness in the matrix is the one that the [`Split`]
    /// names.
    pub fn split_as(
        &mut self,
        split: Split,
        implicit: Implicit,
        v: &[Vec3],
        (x_hat, v_hat): (&[Vec3], &[Vec3]),
    ) {
        let start = self.at_start();
        let x = &start.x;
        let (mass, h) = (self.system.mass(), self.h);
        let ahead: Vec<_> = (0..x.len()).map(|i| (x[i] - x_hat[i]) + v[i] * h).collect();
        self.forces(|effect, out| {
            if implicit.selects(effect) {
                effect.add_force(mass, x_hat, out);
                match (split, effect.split()) {
                    (Split::Paper, Some(springs)) => springs.visit_slopes(x, &mut |i, j, k, _| {
                        let f = (ahead[i] - ahead[j]) * k;
                        out[i] -= f;
                        out[j] += f;
                    }),
                    _ => subtract_laplacian(effect, |k, _| k, &ahead, out),
                }
            } else {
                effect.add_force(mass, x, out);
            }
        });
        self.damping(|effect, out| match effect.split() {
            Some(split) if implicit.selects(effect) => {
                subtract_laplacian(effect, |_, c| c, v, out);
                split.add_damping_remainder(x, v_hat, out);
            }
            _ => effect.add_damping_force(start.level(), out),
        });
    }

    /// Enters forces and damping of a method that linearises the implicit effects about level `n`.
    pub fn linearised(&mut self, implicit: Implicit, tangent: Tangent) {
        let start = self.at_start();
        let x = &start.x;
        let (mass, new) = (self.system.mass(), self.moving);
        let way: Vec<_> = self.end.iter().zip(x).map(|(end, x)| end - x).collect();
        self.forces(|effect, out| {
            effect.add_force(mass, x, out);
            if implicit.selects(effect) {
                crate::assembly::subtract_stiffness_product(effect, x, tangent, &way, out);
            }
        });
        self.damping(|effect, out| {
            lagged_damping_force(effect, implicit, start.level(), new, out);
        });
    }

    /// Enters the unfiltered residual `p = A v₊ − b`, kg m/s. The forces account for pins on paths.
    pub fn impulse(&mut self, constraints: &Constraints, p: &[Vec3]) {
        for (i, (p, w)) in p.iter().zip(self.moving).enumerate() {
            if self.is_led(i) {
                continue;
            }
            let filter = constraints.filter(i);
            self.ledger.residual += filter.apply(*p).dot(w);
            self.ledger.constraint += filter.complement(*p).dot(w);
        }
    }

    /// Enters the residual of a solve, kg m/s, for all particles but the pinned ones.
    pub fn residual(&mut self, p: &[Vec3]) {
        let rows = p.iter().zip(self.moving).zip(self.system.pinned());
        let free = rows.filter(|(_, pinned)| !**pinned);
        self.ledger.residual += free.map(|((p, w), _)| p.dot(w)).sum::<f64>();
    }

    /// Enters an impulse that belongs to no force, kg m/s.
    pub fn correction(&mut self, p: &[Vec3]) {
        self.ledger.correction += dot(p, self.moving);
    }

    /// Ends the ledger. It enters inertia and impact of a step that ended at [`end`](Self::end)
    /// with the velocity `solved`, m/s, and the correction from there to the state `after`.
    pub fn finish(
        mut self,
        constraints: &Constraints,
        solved: &[Vec3],
        after: &State,
    ) -> EnergyLedger {
        for (i, m) in self.system.mass().iter().enumerate() {
            let filter = constraints.filter(i);
            let (late, early) = (solved[i] - self.moving[i], self.moving[i] - self.velocity[i]);
            let square = |part: fn(&drape_solvers::Filter, Vec3) -> Vec3| {
                part(&filter, late).norm_squared() - part(&filter, early).norm_squared()
            };
            self.ledger.inertia += 0.5 * m * square(drape_solvers::Filter::apply);
            self.ledger.impact += 0.5 * m * square(drape_solvers::Filter::complement);
        }
        let kinetic = self.system.kinetic_energy(&after.v) - self.system.kinetic_energy(solved);
        self.ledger.correction += kinetic + change(self.system, &self.end, &after.x);
        self.ledger
    }

    /// Level `n` with the velocities of pins that the step used.
    fn at_start(&self) -> State {
        State { t: self.before.t, x: self.before.x.clone(), v: self.velocity.clone() }
    }
}

/// Adds the damping force at level `n`, N; implicit effects take the velocities `new` at the end of
/// the step.
fn lagged_damping_force(
    effect: &dyn Effect,
    implicit: Implicit,
    start: Level<'_>,
    new: &[Vec3],
    out: &mut [Vec3],
) {
    if implicit.selects(effect) {
        effect.add_lagged_damping_force(start, new, out);
    } else {
        effect.add_damping_force(start, out);
    }
}

/// Velocities that a step of length `h` uses, m/s. A pinned particle stands still or follows its
/// path.
pub fn as_stepped(system: &System, before: &State, h: TimeStep) -> Vec<Vec3> {
    let rows = before.v.iter().zip(system.pinned());
    let mut v: Vec<_> = rows.map(|(v, pinned)| if *pinned { Vec3::zeros() } else { *v }).collect();
    lead_pins(system, before.t, h.seconds(), &before.x, &mut v);
    v
}

/// Change of the potential energy between two positions, J; exactly 0 where they are the same.
fn change(system: &System, from: &[Vec3], to: &[Vec3]) -> f64 {
    let mass = system.mass();
    system.effects().map(|effect| effect.energy(mass, to) - effect.energy(mass, from)).sum()
}

/// Subtracts `L w` from `out`. `L` is the graph Laplacian of an effect's springs. `weight` computes
/// the weight of a spring from its stiffness and its damping coefficient.
pub fn subtract_laplacian(
    effect: &dyn Effect,
    weight: impl Fn(f64, f64) -> f64,
    w: &[Vec3],
    out: &mut [Vec3],
) {
    let Some(split) = effect.split() else { return };
    split.visit_weights(&mut |i, j, k, c| {
        let f = (w[i] - w[j]) * weight(k, c);
        out[i] -= f;
        out[j] += f;
    });
}

/// `M (a − b)`, kg m/s.
pub fn momentum_between(system: &System, a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    let rows = system.mass().iter().zip(a).zip(b);
    rows.map(|((m, a), b)| (a - b) * *m).collect()
}
