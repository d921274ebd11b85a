//! The incremental potential: the function that an implicit stage minimises.

use crate::{Implicit, lightest_free_mass};
use drape_model::{BlockSink, Effect, Level, Mat3, Part, Revisions, System, Tangent, Vec3};
use drape_solvers::{Constraints, SolveStatus, vector::weighted_dot};

/// Round-off of a force over `k |x|`, and of a momentum over `m |v|`.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;
/// A step with a residual above this part of the velocity change by external forces has ignored
/// these forces. No setting of the tolerance allows more.
const IGNORED: f64 = 0.5;

fn lagged<'a>(t: f64, x: &'a [Vec3], v: &'a [Vec3]) -> Level<'a> {
    Level { t, x, v }
}

/// The implicit stage `M (v − v*) = τ f(x* + τ v, v)` as a minimisation over the velocity:
///
/// ```text
/// Φ(v) = ½‖v − v̂‖²_M + U(x* + τ v) + (τ/2) vᵀ D(x̂) v        v̂ = v* + τ M⁻¹ f_frozen
/// ∇Φ   = M (v − v̂) − τ f_U(x* + τ v) + τ D(x̂) v
/// ```
///
/// `U` and `D` belong to the implicit effects; everything else is frozen in `v̂`. Projected damping
/// takes its directions at `x̂`, which a method of order `p` must choose within `O(h^p)` of the new
/// positions. Backward Euler is `(τ, x*, v*, x̂) = (h, x_n, v_n, x_n)`. `Φ` is an energy, J.
#[derive(Debug)]
pub struct IncrementalPotential {
    implicit: Implicit,
    tau: f64,
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
    /// `√m_min ‖τM⁻¹f_external‖`, √J.
    external: f64,
    /// Sum of the external forces on all particles, N.
    external_force: Vec3,
    round_off: f64,
    row_sums: Vec<f64>,
    /// `Σ k²/m` over the rows, 1/s⁴ kg, and its system; `None` where it depends on positions.
    squared_stiffness: Option<(Revisions, f64)>,
    evaluations: u32,
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
    let effects = implicit.effects(system);
    let is_linear = |effect: &dyn Effect| {
        !effect.has_damping() || effect.pass(system.mass(), Part::Damping).is_some()
    };
    if effects.clone().all(is_linear) {
        let damping = |effect: &dyn Effect| effect.has_damping().then_some(Part::Damping);
        let parts = |effect| [Some(Part::Force), damping(effect)].into_iter().flatten();
        let terms = effects.flat_map(|effect| parts(effect).map(move |part| (effect, part)));
        return system.add_forces(terms, Level { t: lagged.t, x, v }, out);
    }
    for effect in effects {
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
            tau: 0.0,
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
            squared_stiffness: None,
            evaluations: 0,
        }
    }

    /// Begins a stage. `frozen` is the force of the explicit effects, N. `lagged` is the level with
    /// the positions `x̂` for the directions of projected damping and the coefficients of drag.
    pub fn begin(
        &mut self,
        system: &System,
        tau: f64,
        (x_star, v_star): (&[Vec3], &[Vec3]),
        lagged: Level<'_>,
        frozen: &[Vec3],
    ) {
        self.tau = tau;
        self.evaluations = 0;
        self.x_star.copy_from_slice(x_star);
        self.directions.copy_from_slice(lagged.x);
        self.lagged_time = lagged.t;
        if !self.force_at_rest.is_empty() {
            self.lagged_velocity.copy_from_slice(lagged.v);
            self.force_at_rest.fill(Vec3::zeros());
            self.candidate.fill(Vec3::zeros());
            for effect in self.implicit.effects(system).filter(|effect| effect.is_drag()) {
                effect.add_lagged_damping_force(lagged, &self.candidate, &mut self.force_at_rest);
            }
        }
        for (inverse, m) in self.inverse_mass.iter_mut().zip(system.mass()) {
            *inverse = 1.0 / m;
        }
        for i in 0..system.len() {
            self.target[i] = v_star[i] + frozen[i] * (tau * self.inverse_mass[i]);
        }
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
        let reach = largest(&self.x_star) + self.tau * largest(&self.target);
        let mut inertia = 0.0;
        for (m, v) in system.mass().iter().zip(&self.target) {
            inertia += m * v.norm_squared();
        }
        let magnitude = self.tau * reach * springs.sqrt() + inertia.sqrt();
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
        for (m, k) in system.mass().iter().zip(&self.row_sums) {
            sum += k * k / m;
        }
        self.squared_stiffness = is_constant.then_some((now, sum));
        sum
    }

    /// `√m_min ‖τ M⁻¹ f‖` over the particles that are not pinned, √J, with the lightest of their
    /// masses.
    fn velocity_change(&self, system: &System) -> f64 {
        let (mut sum, lightest) = (0.0, lightest_free_mass(system));
        for (i, f) in self.force.iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
            sum += f.norm_squared() * self.inverse_mass[i] * (lightest / system.mass()[i]);
        }
        self.tau * sum.sqrt()
    }

    /// The scale of residuals, √J: the change of velocity that the forces at the start would make
    /// in the stage, `√m_min max(‖τM⁻¹f(x*, v*)‖, ‖τM⁻¹f_external‖)`. The second term keeps a scale
    /// for a sheet that hangs at rest. The lightest free mass stands for all: by its own mass a
    /// heavy particle would hide the residuals of the light ones. The scale does not depend on the
    /// frame: if it contained the velocity itself, a sheet that moves fast as a whole would be
    /// solved loosely.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Sum over all particles of the forces without a Jacobian, such as gravity, at the start, N.
    pub fn external_force(&self) -> Vec3 {
        self.external_force
    }

    /// Round-off of residuals, √J: forces carry an error of some `ε_mach k |x|`, whatever the
    /// strain.
    pub fn round_off(&self) -> f64 {
        self.round_off
    }

    /// The status of a solve that ended with `residual`, √J, where the settings asked for `wanted`.
    /// It is `Stagnated` instead of `Converged` where the residual passed only as round-off and is
    /// as large as the effect of the external forces. With `h = 0.01 s` and coordinates of a metre
    /// this happens from some `k/m = 1e15/s²` on, where a sheet would stand in the air.
    pub fn status(&self, status: SolveStatus, residual: f64, wanted: f64) -> SolveStatus {
        let is_ignored = residual > wanted && residual > IGNORED * self.external;
        match status {
            SolveStatus::Converged if is_ignored && self.external > 0.0 => SolveStatus::Stagnated,
            status => status,
        }
    }

    /// A residual over the scale; infinite where the scale is 0.
    pub fn relative(&self, residual: f64) -> f64 {
        if residual > 0.0 { residual / self.scale } else { residual }
    }

    /// Length of the stage, s.
    pub fn tau(&self) -> f64 {
        self.tau
    }

    /// Level of the directions and coefficients of damping; without velocities unless an implicit
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

    /// Force evaluations since the stage began, energies counted too.
    pub fn evaluations(&self) -> u32 {
        self.evaluations
    }

    /// `x* + τ v`, m.
    pub fn positions(&mut self, v: &[Vec3]) -> &[Vec3] {
        for ((x, x_star), v) in self.x.iter_mut().zip(&self.x_star).zip(v) {
            *x = x_star + v * self.tau;
        }
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
        let mut value = 0.0;
        for ((m, v), target) in system.mass().iter().zip(v).zip(&self.target) {
            value += 0.5 * m * (v - target).norm_squared();
        }
        self.force.fill(Vec3::zeros());
        let lagged = lagged(self.lagged_time, &self.directions, &self.lagged_velocity);
        for effect in self.implicit.effects(system) {
            value += effect.energy(system.mass(), &self.x);
            effect.add_lagged_damping_force(lagged, v, &mut self.force);
        }
        let power = |force: &[Vec3]| v.iter().zip(force).map(|(v, f)| v.dot(f)).sum::<f64>();
        let dissipation = power(&self.force);
        value -= 0.5 * self.tau * dissipation;
        if !self.force_at_rest.is_empty() {
            // ½ vᵀDv − vᵀDw = −½ vᵀ(f_D(v) + f_D(0))
            value -= 0.5 * self.tau * power(&self.force_at_rest);
        }
        value
    }

    /// `∇Φ(v)`, kg m/s, unfiltered.
    pub fn gradient(&mut self, system: &System, v: &[Vec3]) -> &[Vec3] {
        self.evaluations += 1;
        self.positions(v);
        self.force.fill(Vec3::zeros());
        let lagged = lagged(self.lagged_time, &self.directions, &self.lagged_velocity);
        add_forces(self.implicit, system, lagged, (&self.x, v), &mut self.force);
        for i in 0..v.len() {
            self.gradient[i] =
                (v[i] - self.target[i]) * system.mass()[i] - self.force[i] * self.tau;
        }
        &self.gradient
    }

    /// `‖S r‖` in the norm of `M⁻¹`, √J.
    pub fn filtered_norm(&self, constraints: &Constraints, residual: &mut [Vec3]) -> f64 {
        constraints.project(residual);
        weighted_dot(&self.inverse_mass, residual, residual).sqrt()
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
