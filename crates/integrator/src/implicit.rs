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

    /// Those of the implicit effects that have a linear split.
    fn splits(self, system: &System) -> impl Iterator<Item = &dyn Effect> + Clone {
        self.effects(system).filter(|effect| effect.split().is_some())
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
        let nonlinear = self.splits(system).map(|effect| (effect, Part::Nonlinear));
        system.add_forces(nonlinear, Level { t: 0.0, x, v: x }, out);
    }

    /// Writes everything that is not linear and stiff, the `f` of EEH (6) as forces of one level, N: first what
    /// [`add_explicit_forces`](Self::add_explicit_forces) adds, then [`add_nonlinear_forces`](Self::add_nonlinear_forces), then
    /// [`add_damping_remainders`](Self::add_damping_remainders).
    #[doc(alias = "EEH 6")]
    pub fn forces_but_linear(self, system: &System, at: Level<'_>, out: &mut [Vec3]) {
        let explicit = system.effects().filter(|effect| !self.selects(*effect));
        let explicit = explicit.map(|effect| (effect, Part::All));
        let nonlinear = self.splits(system).map(|effect| (effect, Part::Nonlinear));
        system.write_forces(explicit.chain(nonlinear), at, out);
        self.add_damping_remainders(system, at.x, at.v, out);
    }

    /// Writes what is linear and stiff, the `g` of EEH (6) as forces of one level, N: `−L_k x`, then `−L_c v` of the implicit effects.
    #[doc(alias = "EEH 6")]
    pub fn linear_forces(self, system: &System, at: Level<'_>, out: &mut [Vec3]) {
        let stiffness = self.splits(system).map(|effect| (effect, Part::Linear));
        let damping = self.splits(system).map(|effect| (effect, Part::LinearDamping));
        system.write_forces(stiffness.chain(damping), at, out);
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
        let linear = self.splits(system).map(|effect| (effect, Part::Linear));
        system.add_forces(linear, Level { t: 0.0, x, v: x }, out);
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
