//! The incremental potential: the function that an implicit stage minimises.

use crate::{Implicit, damping_has_directions, each_particle, lightest_free_mass};
use drape_model::{BlockSink, Effect, Level, Mat3, Part, Revisions, System, Tangent, Vec3};
use drape_solvers::bands::{PerBlock, bands, in_bands, in_items};
use drape_solvers::vector::{BLOCK, weighted_dot_in_bands};
use drape_solvers::{Constraints, SolveStatus};
use std::ops::Range;

/// Round-off of a force over `k |x|`, and of a momentum over `m |v|`.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;
/// A step with a residual above this part of the velocity change by external forces has ignored
/// these forces. No setting of the tolerance allows more.
const IGNORED: f64 = 0.5;

/// Number of effects whose energies threads compute at the same time.
const AT_ONCE: usize = 8;

fn lagged<'a>(t: f64, x: &'a [Vec3], v: &'a [Vec3]) -> Level<'a> {
    Level { t, x, v }
}

/// The two time constants of an implicit stage, `x = x* + τ_x v` and `M (v − v*) = τ_v f`.
///
/// They are equal in backward Euler, BDF and Runge–Kutta methods, and differ in the generalized-α
/// family.
///
/// ```
/// use drape_integrator::Tau;
/// assert_eq!(Tau::from(0.5), Tau { x: 0.5, v: 0.5 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tau {
    /// `τ_x`, s: how far the velocity of the stage moves the positions.
    pub x: f64,
    /// `τ_v`, s: how long the force of the stage acts.
    pub v: f64,
}

impl From<f64> for Tau {
    fn from(tau: f64) -> Self {
        Self { x: tau, v: tau }
    }
}

/// The implicit stage `M (v − v*) = τ_v f(x* + τ_x v, v)` as a minimisation over the velocity:
///
/// ```text
/// Φ(v) = ½‖v − v̂‖²_M + (τ_v/τ_x) U(x* + τ_x v) + (τ_v/2) vᵀ D(x̂) v       v̂ = v* + τ_v M⁻¹ f_frozen
/// ∇Φ   = M (v − v̂) − τ_v f_U(x* + τ_x v) + τ_v D(x̂) v
/// ∇²Φ  = M + τ_x τ_v ∇²U + τ_v D(x̂)
/// ```
///
/// `U` and `D` belong to the implicit effects; everything else is frozen in `v̂`. Projected damping
/// takes its directions at `x̂`, which a method of order `p` must choose within `O(h^p)` of the new
/// positions. Backward Euler is `(τ_x, τ_v, x*, v*, x̂) = (h, h, x_n, v_n, x_n)`. `Φ` is an energy,
/// J.
#[derive(Debug)]
pub struct IncrementalPotential {
    implicit: Implicit,
    tau: Tau,
    x_star: Vec<Vec3>,
    lagged_time: f64,
    directions: Vec<Vec3>,
    /// Velocity of the lagged level, m/s; like the next field empty unless an implicit effect
    /// drags.
    lagged_velocity: Vec<Vec3>,
    /// Force of drags on a cloth at rest, N.
    force_at_rest: Vec<Vec3>,
    target: Vec<Vec3>,
    inverse_mass: Vec<f64>,
    x: Vec<Vec3>,
    force: Vec<Vec3>,
    gradient: Vec<Vec3>,
    candidate: Vec<Vec3>,
    scale: f64,
    /// `√m_min ‖τ_v M⁻¹f_external‖`, √J.
    external: f64,
    /// Sum of the external forces on all particles, N.
    external_force: Vec3,
    round_off: f64,
    row_sums: Vec<f64>,
    /// Parts of a sweep that threads share.
    bands: usize,
    /// Scratch for sums in bands.
    sums: Vec<f64>,
    /// Greatest `k/m` of a row, 1/s².
    stiffest: f64,
    /// `Σ k²/m` over the rows, 1/s⁴ kg, and its system; `None` where it depends on positions.
    squared_stiffness: Option<(Revisions, f64)>,
    evaluations: u32,
}

/// Whether no damping of the implicit effects has directions, so that they share sweeps.
fn share_sweeps(implicit: Implicit, system: &System) -> bool {
    !implicit.effects(system).any(|effect| damping_has_directions(system, effect))
}

/// Force and damping of the implicit effects, effect by effect.
fn terms(implicit: Implicit, system: &System) -> impl Iterator<Item = (&dyn Effect, Part)> {
    let damping = |effect: &dyn Effect| effect.has_damping().then_some(Part::Damping);
    let parts = move |effect| [Some(Part::Force), damping(effect)].into_iter().flatten();
    implicit.effects(system).flat_map(move |effect| parts(effect).map(move |part| (effect, part)))
}

/// Adds force and damping of the implicit effects, N, effect by effect. Effects whose damping has
/// no directions share sweeps.
fn add_forces(
    implicit: Implicit,
    system: &System,
    lagged: Level<'_>,
    (x, v): (&[Vec3], &[Vec3]),
    out: &mut [Vec3],
) {
    if share_sweeps(implicit, system) {
        return system.add_forces(terms(implicit, system), Level { t: lagged.t, x, v }, out);
    }
    for effect in implicit.effects(system) {
        effect.add_force(system.mass(), x, out);
        effect.add_lagged_damping_force(lagged, v, out);
    }
}

/// Adds up the sizes of the blocks of each particle, N/m.
struct RowSums<'a>(&'a mut [f64]);

impl BlockSink for RowSums<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        let size = block.norm();
        self.0[i] += size;
        self.0[j] += size;
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_pair(i, j, block);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.0[i] += block.norm();
    }
}

impl IncrementalPotential {
    /// Memory for the potential of `system`.
    pub fn new(system: &System, implicit: Implicit) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        let has_drag = implicit.effects(system).any(Effect::is_drag);
        let of_drag = || if has_drag { zeros() } else { Vec::new() };
        Self {
            implicit,
            tau: Tau::from(0.0),
            x_star: zeros(),
            lagged_time: 0.0,
            directions: zeros(),
            lagged_velocity: of_drag(),
            force_at_rest: of_drag(),
            target: zeros(),
            inverse_mass: vec![0.0; system.len()],
            x: zeros(),
            force: zeros(),
            gradient: zeros(),
            candidate: zeros(),
            scale: 0.0,
            external: 0.0,
            external_force: Vec3::zeros(),
            round_off: 0.0,
            row_sums: vec![0.0; system.len()],
            bands: 1,
            sums: vec![0.0; system.len().div_ceil(BLOCK)],
            stiffest: 0.0,
            squared_stiffness: None,
            evaluations: 0,
        }
    }

    /// Begins a stage. `frozen` is the force of the explicit effects, N. `lagged` is the level
    /// whose positions `x̂` give the directions of projected damping and the coefficients of drag.
    pub fn begin(
        &mut self,
        system: &System,
        tau: impl Into<Tau>,
        (x_star, v_star): (&[Vec3], &[Vec3]),
        lagged: Level<'_>,
        frozen: &[Vec3],
    ) {
        let tau = tau.into();
        self.tau = tau;
        self.bands = bands(system.threads(), system.len());
        self.evaluations = 0;
        each_particle(system, &mut self.x_star, |i| x_star[i]);
        each_particle(system, &mut self.directions, |i| lagged.x[i]);
        self.lagged_time = lagged.t;
        if !self.force_at_rest.is_empty() {
            self.lagged_velocity.copy_from_slice(lagged.v);
            self.force_at_rest.fill(Vec3::zeros());
            self.candidate.fill(Vec3::zeros());
            for effect in self.implicit.effects(system).filter(|effect| effect.is_drag()) {
                effect.add_lagged_damping_force(lagged, &self.candidate, &mut self.force_at_rest);
            }
        }
        let Self { inverse_mass, target, .. } = self;
        each_particle(system, inverse_mass, |i| 1.0 / system.mass()[i]);
        each_particle(system, target, |i| v_star[i] + frozen[i] * (tau.v * inverse_mass[i]));
        self.measure(system, v_star, frozen);
    }

    /// Computes the scale of residuals, and their round-off.
    fn measure(&mut self, system: &System, v_star: &[Vec3], frozen: &[Vec3]) {
        self.force.fill(Vec3::zeros());
        for effect in system.effects().filter(|effect| !effect.has_jacobian()) {
            effect.add_force(system.mass(), &self.x_star, &mut self.force);
        }
        let external = self.velocity_change(system);
        self.external_force = self.force.iter().sum();
        self.force.copy_from_slice(frozen);
        let lagged = lagged(self.lagged_time, &self.directions, &self.lagged_velocity);
        add_forces(self.implicit, system, lagged, (&self.x_star, v_star), &mut self.force);
        self.evaluations += 1;
        self.scale = self.velocity_change(system).max(external);
        self.external = external;
        let springs = self.squared_stiffness(system);
        let largest = |vectors: &[Vec3]| vectors.iter().fold(0.0, |a: f64, v| a.max(v.amax()));
        let reach = largest(&self.x_star) + self.tau.x * largest(&self.target);
        let mut inertia = 0.0;
        for (m, v) in system.mass().iter().zip(&self.target) {
            inertia += m * v.norm_squared();
        }
        let magnitude = self.tau.v * reach * springs.sqrt() + inertia.sqrt();
        self.round_off = ROUND_OFF * magnitude;
    }

    /// `Σ k²/m` over the particles; `k` sums the stiffnesses of all effects on a particle.
    fn squared_stiffness(&mut self, system: &System) -> f64 {
        let now = system.revisions();
        if let Some((then, sum)) = self.squared_stiffness
            && then == now
        {
            return sum;
        }
        self.row_sums.fill(0.0);
        let rows = &mut self.row_sums;
        self.implicit.visit_weights(system, &mut |i, j, k, _| {
            rows[i] += k;
            rows[j] += k;
        });
        let mut is_constant = true;
        for effect in self.implicit.effects(system).filter(|effect| effect.split().is_none()) {
            let mut sums = RowSums(&mut self.row_sums);
            effect.add_stiffness(&self.x_star, 1.0, Tangent::Projected, &mut sums);
            is_constant = false;
        }
        let mut sum = 0.0;
        self.stiffest = 0.0;
        for (m, k) in system.mass().iter().zip(&self.row_sums) {
            sum += k * k / m;
            self.stiffest = self.stiffest.max(k / m);
        }
        self.squared_stiffness = is_constant.then_some((now, sum));
        sum
    }

    /// `√m_min ‖τ_v M⁻¹ f‖` over the particles that are not pinned, √J, with the lightest of their
    /// masses.
    fn velocity_change(&self, system: &System) -> f64 {
        let (mut sum, lightest) = (0.0, lightest_free_mass(system));
        for (i, f) in self.force.iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
            sum += f.norm_squared() * self.inverse_mass[i] * (lightest / system.mass()[i]);
        }
        self.tau.v * sum.sqrt()
    }

    /// The scale of residuals, √J: the change of velocity that the forces at the start would cause
    /// in the stage, `√m_min max(‖τ_v M⁻¹f(x*, v*)‖, ‖τ_v M⁻¹f_external‖)`. The second term keeps
    /// the scale above 0 for a sheet that hangs at rest. The lightest free mass is used for all
    /// particles, because the mass of a heavy particle would hide the residuals of light ones. The
    /// scale does not depend on the frame. If it contained the velocity, a fast sheet would be
    /// solved too loosely.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Sum over all particles of the forces without a Jacobian, such as gravity, at the start, N.
    pub fn external_force(&self) -> Vec3 {
        self.external_force
    }

    /// Round-off of residuals, √J. Forces carry an error of about `ε_mach k |x|`, whatever the
    /// strain.
    pub fn round_off(&self) -> f64 {
        self.round_off
    }

    /// The status of a solve that ended with `residual`, √J, where the settings required `wanted`.
    /// The status is `Stagnated` instead of `Converged` if the residual passed only as round-off
    /// and is as large as the effect of the external forces. With `h = 0.01 s` and coordinates of a
    /// metre, this happens from about `k/m = 1e15/s²` on. Such a sheet would hang in the air.
    pub fn status(&self, status: SolveStatus, residual: f64, wanted: f64) -> SolveStatus {
        let is_ignored = residual > wanted && residual > IGNORED * self.external;
        match status {
            SolveStatus::Converged if is_ignored && self.external > 0.0 => SolveStatus::Stagnated,
            status => status,
        }
    }

    /// A residual, √J, divided by the scale; infinite if the scale is 0.
    pub fn relative(&self, residual: f64) -> f64 {
        if residual > 0.0 { residual / self.scale } else { residual }
    }

    /// Time constants of the stage, s.
    pub fn tau(&self) -> Tau {
        self.tau
    }

    /// The greatest `τ_x τ_v k/m` of a particle, where `k` sums the stiffnesses of all effects on
    /// it.
    pub fn stiffness(&self) -> f64 {
        self.tau.x * self.tau.v * self.stiffest
    }

    /// Level of the directions and coefficients of damping. It has no velocities unless an implicit
    /// effect drags.
    pub fn lagged(&self) -> Level<'_> {
        lagged(self.lagged_time, &self.directions, &self.lagged_velocity)
    }

    /// Inertial target `v̂`, m/s.
    pub fn target(&self) -> &[Vec3] {
        &self.target
    }

    /// Which effects are implicit.
    pub fn implicit(&self) -> Implicit {
        self.implicit
    }

    /// Number of evaluations of forces or energies since the stage began.
    pub fn evaluations(&self) -> u32 {
        self.evaluations
    }

    /// `x* + τ_x v`, m.
    pub fn positions(&mut self, v: &[Vec3]) -> &[Vec3] {
        let Self { bands, x, x_star, tau, .. } = self;
        in_bands(*bands, v.len(), &mut x[..], &|band, x: &mut [Vec3]| {
            for ((x, x_star), v) in x.iter_mut().zip(&x_star[band.clone()]).zip(&v[band]) {
                *x = x_star + v * tau.x;
            }
        });
        &self.x
    }

    /// The positions of the last evaluation, m.
    pub fn last_positions(&self) -> &[Vec3] {
        &self.x
    }

    /// `Φ(v)`, J.
    pub fn value(&mut self, system: &System, v: &[Vec3]) -> f64 {
        self.evaluations += 1;
        self.positions(v);
        let ratio = self.tau.v / self.tau.x; // exactly 1 where both are the same
        let mut value = 0.0;
        for ((m, v), target) in system.mass().iter().zip(v).zip(&self.target) {
            value += 0.5 * m * (v - target).norm_squared();
        }
        let mut energies = [0.0; AT_ONCE];
        let first = self.first_energies(system, &mut energies);
        let others = self.implicit.effects(system).skip(first.len());
        let others = others.map(|effect| effect.energy(system.mass(), &self.x));
        for energy in first.iter().copied().chain(others) {
            value += ratio * energy;
        }
        self.write_damping_forces(system, v);
        let power = |force: &[Vec3]| v.iter().zip(force).map(|(v, f)| v.dot(f)).sum::<f64>();
        let dissipation = power(&self.force);
        value -= 0.5 * self.tau.v * dissipation;
        if !self.force_at_rest.is_empty() {
            // ½ vᵀDv − vᵀDw = −½ vᵀ(f_D(v) + f_D(0))
            value -= 0.5 * self.tau.v * power(&self.force_at_rest);
        }
        value
    }

    /// Energies of the first implicit effects at the last positions, J. Threads share the effects.
    fn first_energies<'a>(&self, system: &System, energies: &'a mut [f64]) -> &'a [f64] {
        let count = self.implicit.effects(system).count().min(energies.len());
        let energies = &mut energies[..count];
        let bands = if self.bands > 1 { count } else { 1 };
        in_items(bands, count, PerBlock(&mut *energies), &|effects, PerBlock(energies)| {
            let effects = self.implicit.effects(system).skip(effects.start);
            for (energy, effect) in energies.iter_mut().zip(effects) {
                *energy = effect.energy(system.mass(), &self.x);
            }
        });
        energies
    }

    /// Writes the damping forces of the implicit effects to `force`, N.
    fn write_damping_forces(&mut self, system: &System, v: &[Vec3]) {
        let lagged = lagged(self.lagged_time, &self.directions, &self.lagged_velocity);
        let damped = self.implicit.effects(system).filter(|effect| effect.has_damping());
        if share_sweeps(self.implicit, system) {
            let at = Level { v, ..lagged };
            let terms = damped.map(|effect| (effect, Part::Damping));
            return system.write_forces(terms, at, &mut self.force);
        }
        self.force.fill(Vec3::zeros());
        for effect in damped {
            effect.add_lagged_damping_force(lagged, v, &mut self.force);
        }
    }

    /// `∇Φ(v)`, kg m/s, unfiltered.
    pub fn gradient(&mut self, system: &System, v: &[Vec3]) -> &[Vec3] {
        self.evaluations += 1;
        self.positions(v);
        let lagged = lagged(self.lagged_time, &self.directions, &self.lagged_velocity);
        let Self { implicit, tau, x, target, gradient, bands, .. } = self;
        let from_force = |range: Range<usize>, gradient: &mut [Vec3]| {
            let mass = &system.mass()[range.clone()];
            let velocities = v[range.clone()].iter().zip(&target[range]);
            for ((g, (v, target)), m) in gradient.iter_mut().zip(velocities).zip(mass) {
                *g = (v - target) * *m - *g * tau.v;
            }
        };
        if share_sweeps(*implicit, system) {
            let (terms, at) = (terms(*implicit, system), Level { t: lagged.t, x, v });
            system.write_forces_and(terms, at, gradient, &from_force);
        } else {
            gradient.fill(Vec3::zeros());
            add_forces(*implicit, system, lagged, (x, v), gradient);
            in_bands(*bands, v.len(), &mut gradient[..], &from_force);
        }
        &self.gradient
    }

    /// `‖S r‖` in the norm of `M⁻¹`, √J.
    pub fn filtered_norm(&mut self, constraints: &Constraints, residual: &mut [Vec3]) -> f64 {
        constraints.project(residual);
        let Self { bands, inverse_mass, sums, .. } = self;
        weighted_dot_in_bands(*bands, inverse_mass, residual, residual, sums).sqrt()
    }

    /// As [`choose_start`](Self::choose_start) with the inertial target, but by the least residual.
    pub fn choose_start_by_residual(
        &mut self,
        system: &System,
        constraints: &Constraints,
        v: &mut [Vec3],
        other: &[Vec3],
    ) {
        constraints.impose(v);
        let mut best = self.residual(system, constraints, v);
        let mut candidate = std::mem::take(&mut self.candidate);
        for is_target in [false, true] {
            candidate.copy_from_slice(if is_target { &self.target } else { other });
            constraints.impose(&mut candidate);
            let residual = self.residual(system, constraints, &candidate);
            if residual < best {
                best = residual;
                v.copy_from_slice(&candidate);
            }
        }
        self.candidate = candidate;
    }

    /// `‖S∇Φ(v)‖_{M⁻¹}`, √J.
    fn residual(&mut self, system: &System, constraints: &Constraints, v: &[Vec3]) -> f64 {
        self.gradient(system, v);
        let mut gradient = std::mem::take(&mut self.gradient);
        let norm = self.filtered_norm(constraints, &mut gradient);
        self.gradient = gradient;
        norm
    }

    /// Sets `v` to the candidate with the lowest potential under the constraints: `v` itself,
    /// `others` and, on request, the inertial target.
    pub fn choose_start(
        &mut self,
        system: &System,
        constraints: &Constraints,
        v: &mut [Vec3],
        others: &[&[Vec3]],
        with_target: bool,
    ) {
        constraints.impose(v);
        let mut best = self.value(system, v);
        let mut candidate = std::mem::take(&mut self.candidate);
        for k in 0..others.len() + usize::from(with_target) {
            candidate.copy_from_slice(others.get(k).copied().unwrap_or(&self.target));
            constraints.impose(&mut candidate);
            let value = self.value(system, &candidate);
            if value < best {
                best = value;
                v.copy_from_slice(&candidate);
            }
        }
        self.candidate = candidate;
    }
}
