//! A kick with damping that needs no solve.

use crate::{StepReport, change_each, each_particle, kick};
use drape_model::{Effect, Level, Part, State, System, Vec3};
use drape_solvers::Constraints;

/// Whether any effect of the system dissipates.
pub fn is_damped(system: &System) -> bool {
    system.effects().any(|effect| effect.has_damping())
}

/// Whether the effect dissipates along directions, which turn with the positions, or in another way
/// than a sweep takes.
pub fn damping_has_directions(system: &System, effect: &dyn Effect) -> bool {
    let is_swept = || effect.pass(system.mass(), Part::Damping).is_some();
    effect.has_damping() && (effect.has_damping_turn() || !is_swept())
}

/// Writes the damping force of all effects at one level, N, to `out`: `−D(x) v` for springs.
/// `report` counts it as one product with a matrix.
pub fn write_damping_force(
    system: &System,
    at: Level<'_>,
    out: &mut [Vec3],
    report: &mut StepReport,
) {
    let damped = system.effects().filter(|effect| effect.has_damping());
    system.write_forces(damped.map(|effect| (effect, Part::Damping)), at, out);
    report.matvecs += 1;
}

/// Solves `M v' = F − D(x) v` over a kick of `τ` seconds, at fixed `x` and `F`, by Heun's method:
///
/// ```text
/// g₁ = F − D v      g₂ = F − D (v + τ M⁻¹ g₁)      v ← v + τ M⁻¹ ½ (g₁ + g₂)
/// ```
///
/// If the damping is linear in `v`, these are the first terms of the series of the exact kick:
/// `e^{−y} ≈ 1 − y + ½y²`, `y = τδ`. Their sum is at least ½, so no velocity is reversed. The kick
/// is stable for `y < 2`.
#[derive(Debug)]
pub struct ExplicitKick {
    /// `½ (g₁ + g₂) − F` of the last kick, N; `n` × 3.
    pub damping: Vec<Vec3>,
    slope: Vec<Vec3>,
    predicted: Vec<Vec3>,
}

impl ExplicitKick {
    /// Memory for a system.
    pub fn new(system: &System) -> Self {
        let zeros = || vec![Vec3::zeros(); system.len()];
        Self { damping: zeros(), slope: zeros(), predicted: zeros() }
    }

    /// Kicks `state.v` by the force `F`, N, and the damping at the state over `tau` seconds. The
    /// inner prediction obeys `pins`; the result does not.
    pub fn kick(
        &mut self,
        system: &System,
        tau: f64,
        force: &[Vec3],
        state: &mut State,
        pins: &Constraints,
        report: &mut StepReport,
    ) {
        let Self { damping, slope, predicted } = self;
        write_damping_force(system, state.level(), slope, report); // g₁ − F
        let (v, mass) = (&state.v, system.mass());
        let predict = |i| v[i] + (force[i] + slope[i]) * (tau / mass[i]);
        each_particle(system, predicted, predict); // v + τ M⁻¹ g₁
        kick(system, tau, force, &mut state.v);
        pins.impose(predicted);
        write_damping_force(system, Level { v: predicted, ..state.level() }, damping, report);
        let mean = |i, damping: &mut Vec3| *damping = (*damping + slope[i]) * 0.5;
        change_each(system, damping, mean); // ½ (g₁ + g₂) − F
        kick(system, tau, damping, &mut state.v);
    }
}
