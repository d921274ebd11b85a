//! The incremental potential: the function that an implicit stage minimises.

use crate::Implicit;
use drape_model::{System, Vec3};
use drape_solvers::{Constraints, vector::weighted_dot};

/// Round-off of a force over `k |x|`, and of a momentum over `m |v|`.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

/// The implicit stage `M (v − v*) = τ f(x* + τ v, v)` as a minimisation over the velocity:
///
/// ```text
/// Φ(v) = ½‖v − v̂‖²_M + U(x* + τ v) + (τ/2) vᵀ D(x̂) v        v̂ = v* + τ M⁻¹ f_frozen
/// ∇Φ   = M (v − v̂) − τ f_U(x* + τ v) + τ D(x̂) v
/// ```
///
/// `U` and `D` are those of the implicit effects, everything else is frozen in `v̂`; projected
/// damping takes its directions at `x̂`, which a method of order `p` must choose within `O(h^p)` of the
/// new positions. Backward Euler is `(τ, x*, v*, x̂) = (h, x_n, v_n, x_n)`. `Φ` is an energy, J.
#[derive(Debug)]
pub struct IncrementalPotential {
    implicit: Implicit,
    tau: f64,
    x_star: Vec<Vec3>,
    directions: Vec<Vec3>,
    target: Vec<Vec3>,
    inverse_mass: Vec<f64>,
    x: Vec<Vec3>,
    force: Vec<Vec3>,
    gradient: Vec<Vec3>,
    candidate: Vec<Vec3>,
    scale: f64,
    round_off: f64,
    row_sums: Vec<f64>,
    evaluations: u32,
}

impl IncrementalPotential {
    /// Memory for the potential of `system`.
    pub fn new(system: &System, implicit: Implicit) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Self {
            implicit,
            tau: 0.0,
            x_star: zeros(),
            directions: zeros(),
            target: zeros(),
            inverse_mass: vec![0.0; system.len()],
            x: zeros(),
            force: zeros(),
            gradient: zeros(),
            candidate: zeros(),
            scale: 0.0,
            round_off: 0.0,
            row_sums: vec![0.0; system.len()],
            evaluations: 0,
        }
    }

    /// Begins a stage. `frozen` is the force of everything that is not implicit, N; `directions` are the
    /// positions `x̂` at which projected damping takes its directions, m.
    pub fn begin(
        &mut self,
        system: &System,
        tau: f64,
        (x_star, v_star): (&[Vec3], &[Vec3]),
        directions: &[Vec3],
        frozen: &[Vec3],
    ) {
        self.tau = tau;
        self.evaluations = 0;
        self.x_star.copy_from_slice(x_star);
        self.directions.copy_from_slice(directions);
        for (inverse, m) in self.inverse_mass.iter_mut().zip(system.mass()) {
            *inverse = 1.0 / m;
        }
        for i in 0..system.len() {
            self.target[i] = v_star[i] + frozen[i] * (tau * self.inverse_mass[i]);
        }
        self.measure(system, v_star, frozen);
    }

    /// Sets the scale that residuals are compared with, and their round-off.
    fn measure(&mut self, system: &System, v_star: &[Vec3], frozen: &[Vec3]) {
        self.force.fill(Vec3::zeros());
        for effect in system.effects().filter(|effect| !effect.has_jacobian()) {
            effect.add_force(system.mass(), &self.x_star, &mut self.force);
        }
        let external = self.velocity_change(system);
        self.force.copy_from_slice(frozen);
        for effect in self.implicit.effects(system) {
            effect.add_force(system.mass(), &self.x_star, &mut self.force);
            effect.add_damping_force(&self.directions, v_star, &mut self.force);
        }
        self.evaluations += 1;
        self.scale = self.velocity_change(system).max(external);
        self.row_sums.fill(0.0);
        let rows = &mut self.row_sums;
        self.implicit.visit_weights(system, &mut |i, j, k, _| {
            rows[i] += k;
            rows[j] += k;
        });
        let largest = |vectors: &[Vec3]| vectors.iter().fold(0.0, |a: f64, v| a.max(v.amax()));
        let reach = largest(&self.x_star) + self.tau * largest(&self.target);
        let (mut springs, mut inertia) = (0.0, 0.0);
        for ((m, k), v) in system.mass().iter().zip(&self.row_sums).zip(&self.target) {
            springs += k * k / m;
            inertia += m * v.norm_squared();
        }
        let magnitude = self.tau * reach * springs.sqrt() + inertia.sqrt();
        self.round_off = ROUND_OFF * magnitude;
    }

    /// `‖τ M⁻¹ f‖_M` over the particles that are not pinned, √J.
    fn velocity_change(&self, system: &System) -> f64 {
        let mut sum = 0.0;
        for (i, f) in self.force.iter().enumerate().filter(|(i, _)| !system.pinned()[*i]) {
            sum += f.norm_squared() * self.inverse_mass[i];
        }
        self.tau * sum.sqrt()
    }

    /// What residuals are compared with, √J: the change of velocity that the forces at the start
    /// would make in the stage, `max(‖τM⁻¹f(x*, v*)‖_M, ‖τM⁻¹f_external‖_M)`. The second keeps a scale
    /// for a sheet that hangs at rest. It does not depend on the frame: were the velocity itself part of it, a sheet
    /// that moves fast as a whole would be solved loosely.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Residual below which round-off rules, √J: forces carry an error of some `ε_mach k |x|`, whatever
    /// the strain.
    pub fn round_off(&self) -> f64 {
        self.round_off
    }

    /// A residual over the scale; infinite where there is no scale.
    pub fn relative(&self, residual: f64) -> f64 {
        if residual > 0.0 { residual / self.scale } else { residual }
    }

    /// Length of the stage, s.
    pub fn tau(&self) -> f64 {
        self.tau
    }

    /// Where projected damping takes its directions, m.
    pub fn directions(&self) -> &[Vec3] {
        &self.directions
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
        for effect in self.implicit.effects(system) {
            value += effect.energy(system.mass(), &self.x);
            effect.add_damping_force(&self.directions, v, &mut self.force);
        }
        let dissipation: f64 = v.iter().zip(&self.force).map(|(v, f)| v.dot(f)).sum();
        value - 0.5 * self.tau * dissipation
    }

    /// `∇Φ(v)`, kg m/s, unfiltered.
    pub fn gradient(&mut self, system: &System, v: &[Vec3]) -> &[Vec3] {
        self.evaluations += 1;
        self.positions(v);
        self.force.fill(Vec3::zeros());
        for effect in self.implicit.effects(system) {
            effect.add_force(system.mass(), &self.x, &mut self.force);
            effect.add_damping_force(&self.directions, v, &mut self.force);
        }
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

    /// Puts into `v` whichever of itself, `others` and the inertial target (if asked for) has the
    /// lowest potential once the constraints are imposed.
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
