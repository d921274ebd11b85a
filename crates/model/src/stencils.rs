//! Angles, hinges and air as data, and from there to effects.

use crate::build::{index, vector, within};
use crate::effects::{
    Air, Angle, Angles, DragLaw, EffectKind, Gust, Hinge, Hinges, Wind, dihedral_angle,
};
use crate::error::Violation;
use crate::numbering::Numbering;
use crate::schema::LAST_PARTICLE;
use crate::spec::{MAX_COEFFICIENT, MAX_COORDINATE, is_zero};
use crate::topology::interior_edges;
use crate::{Cloth, Effect, Grid, Scene, SystemSpec, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// The effect that an angle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AngleEffect {
    /// Between warp and weft.
    ShearAngle,
    /// Between the edges of a row or column.
    BendingAngle,
}

impl AngleEffect {
    /// All of them, in the order in which a system holds them.
    pub const ALL: [Self; 2] = [Self::ShearAngle, Self::BendingAngle];

    /// The name under which its energy is reported.
    pub fn name(self) -> &'static str {
        EffectKind::from(self).name()
    }
}

impl From<AngleEffect> for EffectKind {
    fn from(effect: AngleEffect) -> Self {
        match effect {
            AngleEffect::ShearAngle => Self::ShearAngle,
            AngleEffect::BendingAngle => Self::BendingAngle,
        }
    }
}

/// The angle at particle `j` between the edges to `i` and `k`, in a frozen system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngleSpec {
    /// Effect that it belongs to.
    pub effect: AngleEffect,
    /// End of the first edge.
    #[schemars(range(max = LAST_PARTICLE))]
    pub i: u32,
    /// Where the edges meet.
    #[schemars(range(max = LAST_PARTICLE))]
    pub j: u32,
    /// End of the second edge.
    #[schemars(range(max = LAST_PARTICLE))]
    pub k: u32,
    /// Angle at rest, rad.
    #[schemars(range(min = 0.0, max = PI))]
    pub rest_rad: f64,
    /// Stiffness, N m.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_m: f64,
}

/// The dihedral angle between the triangles `(i, j, k)` and `(i, j, l)`, in a frozen system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HingeSpec {
    /// First end of the edge.
    #[schemars(range(max = LAST_PARTICLE))]
    pub i: u32,
    /// Second end of the edge.
    #[schemars(range(max = LAST_PARTICLE))]
    pub j: u32,
    /// Corner on one side.
    #[schemars(range(max = LAST_PARTICLE))]
    pub k: u32,
    /// Corner on the other side.
    #[schemars(range(max = LAST_PARTICLE))]
    pub l: u32,
    /// Angle at rest, rad; 0 is flat.
    #[schemars(range(min = -PI, max = PI))]
    pub rest_rad: f64,
    /// Stiffness `K` of this hinge, N m.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_m: f64,
}

/// Stiffness of angles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngularLaw {
    /// Stiffness, N m.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_m: f64,
}

/// The air around a cloth: a drag on each of its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AirSpec {
    /// How the drag grows with the speed.
    pub drag: DragSpec,
    /// Motion of the air; at rest if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind: Option<WindSpec>,
}

/// How the drag of a triangle grows with the speed at which the air meets it, along its normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DragSpec {
    /// `½ ρ C a |n·v|²`.
    Quadratic {
        /// `C`.
        #[schemars(range(min = 0.0, max = MAX_COORDINATE))]
        coefficient: f64,
        /// `ρ`, kg/m³.
        #[serde(default = "density_of_air")]
        #[schemars(range(min = 0.0, max = MAX_COORDINATE))]
        density_kg_m3: f64,
    },
    /// `c a |n·v|`.
    Linear {
        /// `c`, N s/m³.
        #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
        coefficient_n_s_per_m3: f64,
    },
}

/// Of dry air at 20 °C and 1013 hPa, rounded.
fn density_of_air() -> f64 {
    1.2
}

/// Motion of the air, the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindSpec {
    /// Mean velocity, m/s.
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub velocity_m_s: [f64; 3],
    /// What comes and goes; nothing if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gust: Option<GustSpec>,
}

/// Gusts: a sum of sines that looks irregular and is the same in every run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GustSpec {
    /// Bound of the velocity of the gusts, m/s: they come near it and do not exceed it.
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub amplitude_m_s: [f64; 3],
    /// Period of their slowest part, s.
    #[schemars(range(min = SHORTEST_PERIOD, max = MAX_COORDINATE))]
    pub period_s: f64,
    /// Seed of their phases.
    #[serde(default)]
    #[schemars(range(max = u32::MAX))]
    pub seed: u32,
    /// How long they have blown at the start, s; 0 if absent. A system that is frozen mid-run goes on with its gusts.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = MAX_GUST_START))]
    pub start_s: f64,
}

/// Shortest period of gusts, s.
const SHORTEST_PERIOD: f64 = 1e-6;
/// Latest start of gusts, s: a thousand of the longest runs one after the other.
const MAX_GUST_START: f64 = 1e12;

impl GustSpec {
    /// The gusts `t` seconds later.
    pub(crate) fn advance(&mut self, t: f64) {
        self.start_s = (self.start_s + t).min(MAX_GUST_START);
    }
}

impl AirSpec {
    fn check(&self) -> Result<(DragLaw, Option<Wind>), Violation> {
        let law = match self.drag {
            DragSpec::Quadratic { coefficient, density_kg_m3 } => {
                let path = "effects.air.drag.quadratic";
                let within = |key: &str, value| {
                    within(format_args!("{path}.{key}"), value, 0.0, MAX_COORDINATE)
                };
                let density = within("density_kg_m3", density_kg_m3)?;
                DragLaw::Quadratic(0.5 * density * within("coefficient", coefficient)?)
            }
            DragSpec::Linear { coefficient_n_s_per_m3: c } => {
                let path = "effects.air.drag.linear.coefficient_n_s_per_m3";
                DragLaw::Linear(within(path, c, 0.0, MAX_COEFFICIENT)?)
            }
        };
        let gust = |gust: GustSpec| {
            let amplitude = vector("effects.air.wind.gust.amplitude_m_s", gust.amplitude_m_s)?;
            let path = "effects.air.wind.gust.period_s";
            let period = within(path, gust.period_s, SHORTEST_PERIOD, MAX_COORDINATE)?;
            let start = within("effects.air.wind.gust.start_s", gust.start_s, 0.0, MAX_GUST_START)?;
            Ok(Gust::new(amplitude, period, gust.seed).started(start))
        };
        let wind = |wind: WindSpec| {
            let velocity = vector("effects.air.wind.velocity_m_s", wind.velocity_m_s)?;
            Ok(Wind { velocity, gust: wind.gust.map(gust).transpose()? })
        };
        Ok((law, self.wind.map(wind).transpose()?))
    }
}

/// Checks that these are indices of `particles`, and all different.
fn corners<const N: usize>(
    path: &str,
    named: [(&str, u32); N],
    particles: usize,
) -> Result<(), Violation> {
    for (c, (key, particle)) in named.iter().enumerate() {
        index(format_args!("{path}.{key}"), *particle, particles)?;
        if let Some((other, _)) = named[..c].iter().find(|(_, p)| p == particle) {
            let expected = format!("another particle than `{other}`, which is {particle}");
            return Err(Violation::new(format!("{path}.{key}"), particle, expected));
        }
    }
    Ok(())
}

type Boxed = Box<dyn Effect>;

/// The effects on more than two particles, checked.
#[derive(Default)]
pub(crate) struct Stencils {
    /// Of each of [`AngleEffect::ALL`].
    angles: [Vec<Angle>; 2],
    hinges: Vec<Hinge>,
    air: Option<Air>,
}

impl Stencils {
    /// Those of a frozen system with so many particles, whose triangles are checked already.
    pub(crate) fn check(spec: &SystemSpec, particles: usize) -> Result<Self, Violation> {
        let mut stencils = Self::default();
        for (position, angle) in spec.angles.iter().enumerate() {
            let AngleSpec { effect, i, j, k, rest_rad, stiffness_n_m } = *angle;
            let path = format!("angles[{position}]");
            corners(&path, [("i", i), ("j", j), ("k", k)], particles)?;
            stencils.angles[effect as usize].push(Angle {
                i,
                j,
                k,
                rest: within(format_args!("{path}.rest_rad"), rest_rad, 0.0, PI)?,
                stiffness: stiffness(&path, stiffness_n_m)?,
            });
        }
        for (position, hinge) in spec.hinges.iter().enumerate() {
            let HingeSpec { i, j, k, l, rest_rad, stiffness_n_m } = *hinge;
            let path = format!("hinges[{position}]");
            corners(&path, [("i", i), ("j", j), ("k", k), ("l", l)], particles)?;
            stencils.hinges.push(Hinge {
                edge: [i, j],
                opposite: [k, l],
                rest: within(format_args!("{path}.rest_rad"), rest_rad, -PI, PI)?,
                stiffness: stiffness(&path, stiffness_n_m)?,
            });
        }
        if let Some(air) = spec.effects.air {
            let (law, wind) = air.check()?;
            if spec.triangles.is_empty() {
                let expected = "a cloth with triangles, on which the air acts";
                return Err(Violation::new("effects.air", "given without triangles", expected));
            }
            stencils.air = Some(Air::new(law, wind, spec.triangles.clone()));
        }
        Ok(stencils)
    }

    /// Brings them to the internal order of particles.
    pub(crate) fn renumber(&mut self, numbering: &Numbering) {
        let new = |i: &mut u32| *i = numbering.internal(*i as usize) as u32;
        for Angle { i, j, k, .. } in self.angles.iter_mut().flatten() {
            [i, j, k].into_iter().for_each(new);
        }
        for Hinge { edge, opposite, .. } in &mut self.hinges {
            edge.iter_mut().chain(opposite).for_each(new);
        }
        if let Some(air) = &mut self.air {
            air.corners_mut().for_each(new);
        }
    }

    /// The angles and hinges as effects, and the air.
    pub(crate) fn into_effects(self) -> (Vec<Boxed>, Option<Boxed>) {
        let mut elastic: Vec<Boxed> = Vec::new();
        for (effect, list) in AngleEffect::ALL.into_iter().zip(self.angles) {
            if !list.is_empty() {
                elastic.push(Box::new(Angles::new(effect.into(), list)));
            }
        }
        if !self.hinges.is_empty() {
            elastic.push(Box::new(Hinges::new(self.hinges)));
        }
        (elastic, self.air.map(|air| Box::new(air) as Boxed))
    }
}

fn stiffness(path: &str, value: f64) -> Result<f64, Violation> {
    within(format_args!("{path}.stiffness_n_m"), value, 0.0, MAX_COEFFICIENT)
}

/// Adds to a valid system the angles and hinges that its scene names.
pub(crate) fn add(scene: &Scene, spec: &mut SystemSpec) -> Result<(), Violation> {
    let effects = &scene.effects;
    let laws = [effects.shear_angle, effects.bending_angle];
    for (effect, law) in AngleEffect::ALL.into_iter().zip(laws) {
        let Some(AngularLaw { stiffness_n_m }) = law else { continue };
        let path = format!("effects.{}", effect.name());
        let k = stiffness(&path, stiffness_n_m)?;
        let Cloth::Grid(grid) = &scene.cloth else {
            let expected = "a grid: of another cloth warp and weft are not known";
            return Err(Violation::new(
                path,
                "given for a cloth without rows and columns",
                expected,
            ));
        };
        spec.angles.extend(grid_angles(grid, effect, k));
    }
    if let Some(AngularLaw { stiffness_n_m }) = effects.bending_hinge {
        let k = stiffness("effects.bending_hinge", stiffness_n_m)?;
        spec.hinges = hinges(spec, k)?;
    }
    Ok(())
}

/// The angles of a grid. Shear: the four angles around each particle, a fourth of the stiffness each, so that a sheared sheet has
/// `½ k (φ − π/2)²` at each particle inside. Bending: between each particle's neighbours in its row, and in its column.
fn grid_angles(grid: &Grid, effect: AngleEffect, stiffness: f64) -> Vec<AngleSpec> {
    let arms: &[[(i64, i64); 2]] = match effect {
        AngleEffect::ShearAngle => {
            &[[(1, 0), (0, 1)], [(-1, 0), (0, 1)], [(-1, 0), (0, -1)], [(1, 0), (0, -1)]]
        }
        AngleEffect::BendingAngle => &[[(-1, 0), (1, 0)], [(0, -1), (0, 1)]],
    };
    let (rest_rad, stiffness_n_m) = match effect {
        AngleEffect::ShearAngle => (FRAC_PI_2, 0.25 * stiffness),
        AngleEffect::BendingAngle => (PI, stiffness),
    };
    let mut angles = Vec::new();
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            for [one, other] in arms {
                let end = |(right, down): &(i64, i64)| grid.neighbour(row, column, *right, *down);
                let Some((i, k)) = end(one).zip(end(other)) else { continue };
                let j = grid.index(row, column);
                angles.push(AngleSpec { effect, i, j, k, rest_rad, stiffness_n_m });
            }
        }
    }
    angles
}

/// The hinges over the interior edges of the triangles, at rest as the particles lie: `K = 3 k |E|²/(A₁ + A₂)`
/// (Grinspun et al. 2003).
fn hinges(spec: &SystemSpec, stiffness: f64) -> Result<Vec<HingeSpec>, Violation> {
    let x = |i: u32| Vec3::from(spec.particles.position_m[i as usize]);
    let hinge = |edge: crate::topology::InteriorEdge| {
        let ([i, j], [k, l]) = (edge.ends, edge.opposite);
        let corners = [i, j, k, l].map(x);
        let Some(rest_rad) = dihedral_angle(corners) else {
            let found = format!("given for triangles without area at the edge from {i} to {j}");
            return Err(Violation::new("effects.bending_hinge", found, "triangles with an area"));
        };
        let [a, b, c, d] = corners;
        let e = b - a;
        let doubled_area = e.cross(&(c - a)).norm() + e.cross(&(d - a)).norm();
        let stiffness_n_m = stiffness * (6.0 * e.norm_squared() / doubled_area);
        Ok(HingeSpec { i, j, k, l, rest_rad, stiffness_n_m })
    };
    interior_edges(&spec.triangles).into_iter().map(hinge).collect()
}
