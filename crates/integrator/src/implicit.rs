//! Which effects are integrated implicitly.

use drape_model::{Effect, Level, Part, State, System, Vec3};

/// Which effects are implicit; whatever is not stays at level `n`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Implicit {
    /// Springs along warp and weft only: the paper's reading (section 4).
    Tension,
    /// All effects with a linear split, that is all springs: what can stand in the scalar matrix.
    Springs,
    /// All effects with a Jacobian: what a method with 3×3 blocks can take.
    Everything,
}

impl Implicit {
    /// Reads the setting `implicit`.
    pub fn read(word: &str) -> Self {
        if word == "tension" { Self::Tension } else { Self::Springs }
    }

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

    /// Adds to `out` everything that is not implicit, N: explicit springs with their damping and
    /// external forces, at one level, and the part of projected damping that is not `−L_c v`.
    pub fn add_explicit_forces(self, system: &System, at: Level<'_>, out: &mut [Vec3]) {
        let explicit = system.effects().filter(|effect| !self.selects(*effect));
        system.add_forces(explicit.map(|effect| (effect, Part::All)), at, out);
    }

    /// Adds the conservative force of the implicit effects at `x`, N, to `out`.
    pub fn add_implicit_forces(self, system: &System, x: &[Vec3], out: &mut [Vec3]) {
        let implicit = self.effects(system).map(|effect| (effect, Part::Force));
        let at = Level { t: 0.0, x, v: x }; // of which Part::Force takes the positions alone
        system.add_forces(implicit, at, out);
    }

    /// Writes the force of everything at level `n`, N, but for the implicit effects' damping: first what
    /// [`add_explicit_forces`](Self::add_explicit_forces) adds, then [`add_implicit_forces`](Self::add_implicit_forces).
    pub fn forces_but_implicit_damping(self, system: &System, state: &State, out: &mut [Vec3]) {
        let explicit = system.effects().filter(|effect| !self.selects(*effect));
        let explicit = explicit.map(|effect| (effect, Part::All));
        let implicit = self.effects(system).map(|effect| (effect, Part::Force));
        system.write_forces(explicit.chain(implicit), state.level(), out);
    }

    /// Adds `F2` of the implicit effects at `x`, EEH (13), N, to `out`.
    pub fn add_nonlinear_forces(self, system: &System, x: &[Vec3], out: &mut [Vec3]) {
        for split in self.effects(system).filter_map(Effect::split) {
            split.add_nonlinear_force(x, out);
        }
    }

    /// Adds what is left of the implicit effects' damping at `(x, v)` when `−L_c v` is taken out.
    pub fn add_damping_remainders(self, system: &System, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]) {
        for split in self.effects(system).filter_map(Effect::split) {
            split.add_damping_remainder(x, v, out);
        }
    }

    /// Adds `−L_k x`, the linear part of the implicit springs' force: the negative of EEH (12), N, to `out`.
    #[doc(alias = "EEH 12")]
    pub fn add_linear_spring_forces(self, system: &System, x: &[Vec3], out: &mut [Vec3]) {
        for split in self.effects(system).filter_map(Effect::split) {
            split.add_linear_force(x, out);
        }
    }

    /// Adds `−L_c v`, the linear part of the implicit springs' damping: the negative of EEH (14), N, to `out`.
    pub fn add_linear_damping_forces(self, system: &System, v: &[Vec3], out: &mut [Vec3]) {
        for split in self.effects(system).filter_map(Effect::split) {
            split.add_linear_damping(v, out);
        }
    }

    /// Calls `visit(i, j, k, c)` for each implicit spring.
    pub fn visit_weights(self, system: &System, visit: &mut dyn FnMut(usize, usize, f64, f64)) {
        for split in self.effects(system).filter_map(Effect::split) {
            split.visit_weights(visit);
        }
    }

    /// The greatest `k (1/m_i + 1/m_j)/2` of an implicit spring, 1/s²: times `h²` it is the
    /// stiffness group θ.
    pub fn max_stiffness_over_mass(self, system: &System) -> f64 {
        let mass = system.mass();
        let mut max: f64 = 0.0;
        self.visit_weights(system, &mut |i, j, k, _| {
            max = max.max(0.5 * k * (1.0 / mass[i] + 1.0 / mass[j]));
        });
        max
    }
}
