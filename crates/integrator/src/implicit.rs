//! The effects that a method integrates implicitly.

use crate::Word;
use drape_model::{Effect, Level, LinearSplit, Part, State, System, Vec3};
use drape_solvers::bands::{bands, in_bands};
use drape_solvers::vector::weighted_scale_add;
use std::ops::Range;

/// Which effects are implicit; all others stay at level `n`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Implicit {
    /// Springs along warp and weft only, as in the paper (section 4).
    Tension,
    /// All effects with a linear split, that is, all springs. They fit into the scalar matrix.
    Springs,
    /// All effects with a Jacobian. They fit into a matrix of 3×3 blocks.
    Everything,
}

impl Word for Implicit {
    const WORDS: &'static [(&'static str, Self)] =
        &[("tension", Self::Tension), ("springs", Self::Springs), ("everything", Self::Everything)];
}

impl Implicit {
    /// Whether the effect is implicit.
    pub fn selects(self, effect: &dyn Effect) -> bool {
        match self {
            Self::Tension => effect.split().is_some() && effect.name() == "tension",
            Self::Springs => effect.split().is_some(),
            Self::Everything => effect.has_jacobian(),
        }
    }

    /// The implicit effects of a system.
    pub fn effects(self, system: &System) -> impl Iterator<Item = &dyn Effect> + Clone {
        system.effects().filter(move |effect| self.selects(*effect))
    }

    /// The implicit effects with a linear split.
    fn splits(self, system: &System) -> impl Iterator<Item = &dyn Effect> + Clone {
        self.effects(system).filter(|effect| effect.split().is_some())
    }

    /// Adds the forces of the explicit effects at one level, N, to `out`: explicit springs with
    /// their damping, and external forces.
    pub fn add_explicit_forces(self, system: &System, at: Level<'_>, out: &mut [Vec3]) {
        let explicit = system.effects().filter(|effect| !self.selects(*effect));
        system.add_forces(explicit.map(|effect| (effect, Part::All)), at, out);
    }

    /// Adds the conservative force of the implicit effects at `x`, N, to `out`.
    pub fn add_implicit_forces(self, system: &System, x: &[Vec3], out: &mut [Vec3]) {
        let implicit = self.effects(system).map(|effect| (effect, Part::Force));
        let at = Level { t: 0.0, x, v: x }; // Part::Force reads only the positions
        system.add_forces(implicit, at, out);
    }

    /// Writes all forces at level `n` except the damping of the implicit effects, N, to `out`. It
    /// adds [`add_explicit_forces`](Self::add_explicit_forces) first, then
    /// [`add_implicit_forces`](Self::add_implicit_forces).
    pub fn forces_but_implicit_damping(self, system: &System, state: &State, out: &mut [Vec3]) {
        system.write_forces(self.all_but_implicit_damping(system), state.level(), out);
    }

    fn all_but_implicit_damping(
        self,
        system: &System,
    ) -> impl Iterator<Item = (&dyn Effect, Part)> {
        let explicit = system.effects().filter(move |effect| !self.selects(*effect));
        let explicit = explicit.map(|effect| (effect, Part::All));
        explicit.chain(self.effects(system).map(|effect| (effect, Part::Force)))
    }

    /// Writes `M v_n + h F`, kg m/s, to `out`. `F` holds all forces at level `n` except the linear
    /// damping `−L_c v` of the implicit effects. The result is the right-hand side of EEH (21),
    /// since `F2 − L_k x` is the force of the springs.
    #[doc(alias = "EEH 21")]
    pub fn write_impulse(self, system: &System, state: &State, h: f64, out: &mut [Vec3]) {
        let momentum = |band: Range<usize>, f: &mut [Vec3]| {
            weighted_scale_add(&system.mass()[band.clone()], &state.v[band], h, f);
        };
        let has_remainder =
            |effect: &dyn Effect| effect.split().is_some_and(LinearSplit::has_damping_remainder);
        if self.effects(system).any(has_remainder) {
            self.forces_but_implicit_damping(system, state, out);
            self.add_damping_remainders(system, &state.x, &state.v, out);
            let bands = bands(system.threads(), system.len());
            return in_bands(bands, out.len(), out, &momentum);
        }
        let (at, terms) = (state.level(), self.all_but_implicit_damping(system));
        system.write_forces_and(terms, at, out, &momentum);
    }

    /// Adds `F2` of the implicit effects at `x`, EEH (13), N, to `out`.
    pub fn add_nonlinear_forces(self, system: &System, x: &[Vec3], out: &mut [Vec3]) {
        let nonlinear = self.splits(system).map(|effect| (effect, Part::Nonlinear));
        system.add_forces(nonlinear, Level { t: 0.0, x, v: x }, out);
    }

    /// Writes the `f` of EEH (6), N, to `out`: all forces of one level except the linear stiff
    /// part. It adds [`add_explicit_forces`](Self::add_explicit_forces), then
    /// [`add_nonlinear_forces`](Self::add_nonlinear_forces), then
    /// [`add_damping_remainders`](Self::add_damping_remainders).
    #[doc(alias = "EEH 6")]
    pub fn forces_but_linear(self, system: &System, at: Level<'_>, out: &mut [Vec3]) {
        let explicit = system.effects().filter(|effect| !self.selects(*effect));
        let explicit = explicit.map(|effect| (effect, Part::All));
        let nonlinear = self.splits(system).map(|effect| (effect, Part::Nonlinear));
        system.write_forces(explicit.chain(nonlinear), at, out);
        self.add_damping_remainders(system, at.x, at.v, out);
    }

    /// Writes the linear stiff part `g` of EEH (6) at one level, N, to `out`: `−L_k x`, then
    /// `−L_c v`, of the implicit effects.
    #[doc(alias = "EEH 6")]
    pub fn linear_forces(self, system: &System, at: Level<'_>, out: &mut [Vec3]) {
        let stiffness = self.splits(system).map(|effect| (effect, Part::Linear));
        let damping = self.splits(system).map(|effect| (effect, Part::LinearDamping));
        system.write_forces(stiffness.chain(damping), at, out);
    }

    /// Adds the damping of the implicit effects at `(x, v)` without `−L_c v`, N, to `out`.
    pub fn add_damping_remainders(self, system: &System, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]) {
        for split in self.effects(system).filter_map(Effect::split) {
            split.add_damping_remainder(x, v, out);
        }
    }

    /// Adds `−L_k x`, the linear part of the implicit springs' force: the negative of EEH (12), N,
    /// to `out`.
    #[doc(alias = "EEH 12")]
    pub fn add_linear_spring_forces(self, system: &System, x: &[Vec3], out: &mut [Vec3]) {
        let linear = self.splits(system).map(|effect| (effect, Part::Linear));
        system.add_forces(linear, Level { t: 0.0, x, v: x }, out);
    }

    /// Calls `visit(i, j, k, c)` for each implicit spring, with its ends, stiffness (N/m) and
    /// damping (N s/m).
    pub fn visit_weights(self, system: &System, visit: &mut dyn FnMut(usize, usize, f64, f64)) {
        for split in self.effects(system).filter_map(Effect::split) {
            split.visit_weights(visit);
        }
    }

    /// The greatest `k (1/m_i + 1/m_j)/2` of an implicit spring, 1/s². Multiplied by `h²` it is the
    /// stiffness number θ.
    pub fn max_stiffness_over_mass(self, system: &System) -> f64 {
        let mass = system.mass();
        let mut max: f64 = 0.0;
        self.visit_weights(system, &mut |i, j, k, _| {
            max = max.max(0.5 * k * (1.0 / mass[i] + 1.0 / mass[j]));
        });
        max
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use drape_kernels::testing::assert_same_bits;
    use drape_model::parse;

    #[test]
    fn the_impulse_is_that_of_its_definition() {
        for (rows, damping) in [(9, "full"), (9, "projected"), (150, "full"), (150, "projected")] {
            let text = format!(
                r#"{{"format": "drape-scene/1", "name": "s",
                "cloth": {{"grid": {{"rows": {rows}, "columns": 121,
                "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.4}}}},
                "effects": {{"tension": {{"stiffness_n_per_m": 9, "damping_n_s_per_m": 0.2}},
                "shear": {{"stiffness_n_per_m": 2, "damping_n_s_per_m": 0.1}},
                "gravity": {{"m_s2": [0, 0, -9.81]}}}}, "damping": "{damping}",
                "time": {{"step_s": 0.01, "duration_s": 1}}}}"#
            );
            let (mut system, mut state) = parse("test", &text).unwrap().spec().build().unwrap();
            for (i, (x, v)) in state.x.iter_mut().zip(&mut state.v).enumerate() {
                x.z += 1e-3 * (0.7 * i as f64).sin();
                *v = Vec3::new((0.3 * i as f64).cos(), (1.1 * i as f64).sin(), 0.5);
            }
            for implicit in [Implicit::Tension, Implicit::Springs] {
                let mut expected = vec![Vec3::repeat(f64::NAN); system.len()];
                implicit.forces_but_implicit_damping(&system, &state, &mut expected);
                implicit.add_damping_remainders(&system, &state.x, &state.v, &mut expected);
                weighted_scale_add(system.mass(), &state.v, 0.01, &mut expected);
                for threads in [3, 1] {
                    system.set_threads(std::num::NonZero::new(threads).unwrap());
                    let mut out = vec![Vec3::repeat(f64::NAN); system.len()];
                    implicit.write_impulse(&system, &state, 0.01, &mut out);
                    assert_same_bits((rows, damping, threads), &expected, &out);
                }
            }
        }
    }
}
