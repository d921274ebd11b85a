//! Effects: the forces that a scene can name.
//!
//! Each call sweeps a whole array, so dynamic dispatch happens once per effect, not once per
//! spring. An effect does not depend on other effects or on solvers. It offers its energy, its
//! forces, its Jacobian blocks through a [`BlockSink`] and, if it has one, its split into a linear
//! stiff part and a remainder ([`LinearSplit`]).
//!
//! Forces are restoring. EEH print `F_1 = k(x_i − x_j)` and `F_2 = −kℓ(x_i − x_j)/|x_i − x_j|`
//! (their (11)–(15)): taken literally, a stretched spring would push its ends apart, and
//! `F_D = d(v_i − v_j)` would add energy. Every formula here is the negative of the printed one.
//! Then (21) has a positive definite matrix, which conjugate gradients need.
//!
//! # How to add an effect
//!
//! Write a file here with the keys and bounds of its data, its [`Effect`], and its `Entry`, which
//! turns a value in a scene into the running effect. Then add its `mod` line, export its types, and
//! add one line to `effects!` below. That line defines the key in scenes, the [`EffectKind`] and
//! its name.

#[macro_use]
mod registry;

mod air;
mod angle;
mod elements;
mod gravity;
mod hinge;
mod network;
mod piecewise;
mod springs;

pub use air::{Air, AirSpec, DragLaw, DragSpec, Gust, GustSpec, Wind, WindSpec};
pub(crate) use angle::grid_angles;
pub use angle::{AngleEffect, AngleSpec, Angles, AngularLaw};
pub use elements::{Stencils, Turn};
pub use gravity::{Gravity, GravitySpec};
pub(crate) use hinge::hinges;
pub use hinge::{HingeSpec, Hinges};
pub(crate) use network::Strand;
pub use network::{DampingLaw, Fabric, PieceSpec, SpringEffect, SpringLaw, SpringSpec, StretchLaw};
use piecewise::{Buckling, Curve};
pub use piecewise::{PiecewiseSprings, TensionLaw};
pub use registry::EffectClass;
pub(crate) use registry::{Checked, Weave};
pub use springs::sweep::{Field, ListedSprings, Pass, Springs};
pub use springs::tangent::{Linearised, StiffnessProduct};
pub use springs::{COLLAPSED, LinearSprings, Spring};
pub(crate) use springs::{batch, diagonals, pairs, sweep, tangent};

use crate::error::Violation;
use crate::{ContactSpec, Level, SystemSpec, Vec3};
pub use drape_kernels::blocks::BlockSink;
use registry::Entry;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Debug;

// One line for each effect, in the order in which a system sums the forces.
effects! {
    /// Springs between neighbours in a row or column. They are the stiff part.
    Tension tension: SpringLaw => network::Entry;
    /// Springs along both diagonals of each cell.
    Shear shear: SpringLaw => network::Entry;
    /// Springs from each particle to the next but one in a row or column.
    Bending bending: SpringLaw => network::Entry;
    /// Angles between warp and weft, which shear changes. Grids only.
    ShearAngle shear_angle: AngularLaw => angle::Entry;
    /// Angles between the edges of a row or column, which bending changes. Grids only.
    BendingAngle bending_angle: AngularLaw => angle::Entry;
    /// Angles between triangles with a common edge, which bending changes.
    BendingHinge bending_hinge: AngularLaw => hinge::Entry;
    /// Uniform gravity.
    Gravity gravity: GravitySpec, frozen GravitySpec => gravity::Entry;
    /// The air around the cloth, at rest or in motion.
    Air air: AirSpec, frozen AirSpec => air::Entry;
}

/// Which second derivative of the energy a method uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tangent {
    /// The exact Hessian. It is indefinite where springs are compressed.
    Exact,
    /// The Hessian made positive semi-definite element by element. A spring gives
    /// `k [ûûᵀ + max(0, 1 − ℓ/L)(I − ûûᵀ)]`. An angle gives `k ∇θ ∇θᵀ` and those further terms that
    /// are certainly positive.
    Projected,
}

/// A part of an effect's forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The conservative force and the damping.
    All,
    /// The conservative force alone.
    Force,
    /// The damping alone.
    Damping,
    /// `F2`, EEH (13): the conservative force without `−L_k x`. An effect without a
    /// [split](Effect::split) gives its whole conservative force.
    Nonlinear,
    /// `−L_k x`, the negative of EEH (12), from the positions alone; 0 for an effect without a
    /// split.
    Linear,
    /// `−L_c v`, the negative of EEH (14), from the velocities alone; 0 for an effect without a
    /// split.
    LinearDamping,
}

/// A kind of force: its energy, forces, Jacobians and, if it has one, its linear split.
pub trait Effect: Debug + Send + Sync {
    /// The kind of force.
    fn kind(&self) -> EffectKind;

    /// The name of the effect's kind. It is the key in scenes and the name of the energy in
    /// records.
    fn name(&self) -> &'static str {
        self.kind().name()
    }

    /// Potential energy at the positions `x` (m), J. `mass` (kg) and `x` have one entry per
    /// particle.
    fn energy(&self, mass: &[f64], x: &[Vec3]) -> f64;

    /// Adds the conservative force at the positions `x` (m) to `out`, N.
    fn add_force(&self, mass: &[f64], x: &[Vec3], out: &mut [Vec3]);

    /// Whether the effect also dissipates. If it returns `false`, callers never ask for a damping
    /// force.
    fn has_damping(&self) -> bool {
        false
    }

    /// Whether the damping acts against a medium and not between particles. If so, its coefficients
    /// may depend on time and velocity, and a cloth at rest may feel a force.
    fn is_drag(&self) -> bool {
        false
    }

    /// Whether the forces of the effect depend on time itself, and not only through the motion.
    fn changes_with_time(&self) -> bool {
        self.is_drag()
    }

    /// Velocity at time `t` (s) of the medium against which the effect drags, m/s; 0 if there is no
    /// medium.
    fn medium_velocity(&self, _t: f64) -> Vec3 {
        Vec3::zeros()
    }

    /// A speed that the medium never exceeds, m/s.
    fn greatest_medium_speed(&self) -> f64 {
        0.0
    }

    /// Adds the damping force at this level, N, to `out`.
    fn add_damping_force(&self, _at: Level<'_>, _out: &mut [Vec3]) {}

    /// Adds a part of the forces, N, to `out`.
    fn add_part(&self, part: Part, mass: &[f64], at: Level<'_>, out: &mut [Vec3]) {
        let split = self.split();
        match (part, split) {
            (Part::All, _) => {
                self.add_force(mass, at.x, out);
                if self.has_damping() {
                    self.add_damping_force(at, out);
                }
            }
            (Part::Force, _) | (Part::Nonlinear, None) => self.add_force(mass, at.x, out),
            (Part::Damping, _) => self.add_damping_force(at, out),
            (Part::Nonlinear, Some(split)) => split.add_nonlinear_force(at.x, out),
            (Part::Linear, Some(split)) => split.add_linear_force(at.x, out),
            (Part::LinearDamping, Some(split)) => split.add_linear_damping(at.v, out),
            (Part::Linear | Part::LinearDamping, None) => {}
        }
    }

    /// Adds the damping force for the velocities `v` (m/s) with coefficients taken at `lagged`, N,
    /// to `out`. The force is linear in `v`, with the matrix of [`add_damping`](Self::add_damping).
    fn add_lagged_damping_force(&self, lagged: Level<'_>, v: &[Vec3], out: &mut [Vec3]) {
        self.add_damping_force(Level { v, ..lagged }, out);
    }

    /// Adds the derivative of the damping force with respect to the positions, in the direction `w`
    /// (m), to `out`, N. Forces whose directions turn with the cloth, such as projected damping,
    /// have such a derivative. Drag leaves out the derivatives of its coefficients.
    fn add_damping_turn(&self, _at: Level<'_>, _w: &[Vec3], _out: &mut [Vec3]) {}

    /// Whether [`add_damping_turn`](Self::add_damping_turn) adds anything.
    fn has_damping_turn(&self) -> bool {
        false
    }

    /// A part of the forces in a form that one sweep can add together with other effects. `None` if
    /// no such form exists.
    fn pass<'a>(&'a self, _mass: &'a [f64], _part: Part) -> Option<Pass<'a>> {
        None
    }

    /// Whether the effect offers Jacobians, so that a method can integrate it implicitly.
    fn has_jacobian(&self) -> bool {
        false
    }

    /// Calls `visit` with each pair of particles that the Jacobians couple.
    fn visit_pairs(&self, _visit: &mut dyn FnMut(usize, usize)) {}

    /// Adds `scale · (−∂f/∂x)` of the conservative force at `x`, N/m times `scale`, to `sink`.
    fn add_stiffness(
        &self,
        _x: &[Vec3],
        _scale: f64,
        _tangent: Tangent,
        _sink: &mut dyn BlockSink,
    ) {
    }

    /// Adds `scale · (−∂f/∂v)`, N s/m times `scale`, to `sink`. Coefficients and directions are
    /// taken at `lagged`.
    fn add_damping(&self, _lagged: Level<'_>, _scale: f64, _sink: &mut dyn BlockSink) {}

    /// The split into a linear stiff part and a remainder, if the effect has one.
    fn split(&self) -> Option<&dyn LinearSplit> {
        None
    }

    /// Access to the angles one by one. `None` unless the energy is a sum `Σ ½ K (θ − θ₀)²` over
    /// angles.
    fn stencils(&self) -> Option<&dyn Stencils> {
        None
    }

    /// Multiplies every stiffness by `factor`. Returns `false` if the effect has no stiffness.
    fn scale_stiffness(&mut self, _factor: f64) -> bool {
        false
    }

    /// Multiplies every damping coefficient by `factor`. Returns `false` if the effect has no
    /// damping.
    fn scale_damping(&mut self, _factor: f64) -> bool {
        false
    }

    /// Adds the effect's data to a frozen system. Returns `false` if a frozen system cannot hold
    /// them.
    #[must_use = "false means that nothing was added"]
    fn describe(&self, _spec: &mut SystemSpec) -> bool {
        false
    }

    /// A copy behind a box.
    fn boxed_clone(&self) -> Box<dyn Effect>;
}

/// A visitor of springs. It receives the two ends, the stiffness, N/m, and the tension, N, as a
/// function of the length, m.
pub type TensionVisitor<'a> = dyn FnMut(usize, usize, f64, &dyn Fn(f64) -> f64) + 'a;

/// The split of EEH section 4: `f = −L_k x + F2(x)` with the weighted graph Laplacian
/// `(L_k x)_i = Σ_j k_ij (x_i − x_j)`, and likewise `−L_c v` plus a remainder for the damping. A
/// spring's *place* is its position in the sequence of [`visit_weights`](Self::visit_weights).
pub trait LinearSplit {
    /// Calls `visit(i, j, k, c)` with the stiffness (N/m) and damping (N s/m) of each spring: the
    /// weights of the graph Laplacians, EEH (16) and (17).
    fn visit_weights(&self, visit: &mut dyn FnMut(usize, usize, f64, f64));

    /// Whether the slope of every spring equals its stiffness at any length.
    fn has_one_slope(&self) -> bool {
        true
    }

    /// The curve of the spring at this place. `None` for a linear spring, whose tension is
    /// `k (L − ℓ)`.
    fn law(&self, _spring: usize) -> Option<&TensionLaw> {
        None
    }

    /// As [`visit_weights`](Self::visit_weights), in the same order, but with the slope `T'` of
    /// each spring at the positions `x`, N/m. The slope replaces the constant that bounds it from
    /// above.
    fn visit_slopes(&self, _x: &[Vec3], visit: &mut dyn FnMut(usize, usize, f64, f64)) {
        self.visit_weights(visit);
    }

    /// Calls `visit(i, j, ℓ)` with the rest length of each spring, m.
    fn visit_rest_lengths(&self, visit: &mut dyn FnMut(usize, usize, f64));

    /// Calls `visit(i, j, k̃)` with the secant stiffness of each spring at the positions `x`, N/m:
    /// `k̃ = T/L`, or `k (1 − ℓ/L)` if the spring is linear. `k̃` is negative in compression. The
    /// force is exactly `−k̃ (x_i − x_j)`.
    fn visit_secants(&self, x: &[Vec3], visit: &mut dyn FnMut(usize, usize, f64));

    /// Calls `visit(i, j, k, T)` with the stiffness of each spring, N/m, and its tension `T(L)` as
    /// a function of the length, N; in the order of [`visit_weights`](Self::visit_weights). The
    /// stiffness bounds the slope `T'`.
    fn visit_tensions(&self, visit: &mut TensionVisitor<'_>);

    /// Calls `visit(i, j, g, g')` with the discrete gradient of each spring between the positions
    /// `from` and `to` (Gonzalez 1996), N/m and N/m². With `d = x_i − x_j` and `L = |d|`,
    ///
    /// ```text
    /// g = ΔU/ΔL / (L_from + L_to)        f_i = −g (d_from + d_to)        g' = ∂g/∂L_to
    /// ```
    ///
    /// The forces `f_i` and `f_j` do exactly the work `−ΔU` on the way. At `from = to`, `f_i` is
    /// the force of the spring. A linear spring has `g = k (1/2 − ℓ/(L_from + L_to))`, without a
    /// division by `ΔL`.
    #[doc(alias = "Gonzalez 1996")]
    #[doc(alias = "LaBudde-Greenspan 1974")]
    fn visit_discrete_gradients(
        &self,
        from: &[Vec3],
        to: &[Vec3],
        visit: &mut dyn FnMut(usize, usize, f64, f64),
    );

    /// Adds `F2`, EEH (13), N, to `out`: the conservative force without `−L_k x`.
    fn add_nonlinear_force(&self, x: &[Vec3], out: &mut [Vec3]);

    /// Adds `−L_k x`, N, to `out`: the linear part of the force, the negative of EEH (12).
    fn add_linear_force(&self, x: &[Vec3], out: &mut [Vec3]);

    /// Adds `−L_c v`, N, to `out`: the linear part of the damping, the negative of EEH (14).
    fn add_linear_damping(&self, v: &[Vec3], out: &mut [Vec3]);

    /// Whether damping has a nonlinear part. Full damping has none.
    fn has_damping_remainder(&self) -> bool;

    /// Adds the damping force without `−L_c v`, N, to `out`. Call it only if the effect
    /// [has this remainder](Self::has_damping_remainder).
    fn add_damping_remainder(&self, x: &[Vec3], v: &[Vec3], out: &mut [Vec3]);
}
