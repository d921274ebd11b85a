//! Angles between two edges that meet in a particle: shear between warp and weft, bending along
//! rows and columns.
//!
//! With `a = x_i − x_j`, `b = x_k − x_j` and the angle `φ` between them,
//!
//! ```text
//! U = ½ k (φ − φ₀)²
//! ```
//!
//! Formulas use `c = cos φ`. Its gradient `∇_a c = (b̂ − c â)/|a|` is smooth if neither edge has
//! length 0. Its factor is `g = dU/dc = k (δ − δ₀)/sin δ` with `δ = π − φ`. If the angle at rest is
//! straight, `g` is smooth at the straight angle, because `(π − φ)/sin φ → 1` (Eberhardt, Weber and
//! Straßer 1996 bend cloth in this way). If the angle at rest is not straight, angles of 0 and π
//! give the force no direction, and the force is 0.

use super::elements::{self, Element, Elements, Turn};
use super::registry::{self, Checked, Weave};
use super::{BlockSink, EffectClass, EffectKind, Tangent};
use crate::bounds::{LAST_PARTICLE, MAX_COEFFICIENT, coefficient};
use crate::error::Violation;
use crate::{Cloth, Grid, Mat3, SystemSpec, Vec3};
use drape_kernels::angle::atan2;
use drape_kernels::lanes::{Four, Lanes};
use drape_kernels::triples::{Triple, Triples, add_in_turn};
use drape_kernels::vector::SLOTS;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// An edge shorter than this fraction of the other one has no direction.
const COLLAPSED: f64 = 1e-12;
/// An edge must be longer than this to have a direction, m.
const SHORTEST: f64 = 1e-100;
/// `sin φ` below which the plane of the edges is lost in round-off.
const SINGULAR: f64 = 1e-12;
/// `sin φ` below which an angle counts as straight in the projected stiffness.
const STRAIGHT: f64 = 1e-8;
/// `sin φ` below which a series gives the curvature at the straight angle.
const SERIES: f64 = 3e-3;

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
    /// All kinds, in the order in which a system holds them.
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
    /// Effect that the angle belongs to.
    pub effect: AngleEffect,
    /// End of the first edge.
    #[schemars(range(max = LAST_PARTICLE))]
    pub i: u32,
    /// Particle at which the edges meet.
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

/// Stiffness of angles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngularLaw {
    /// Stiffness, N m.
    #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
    pub stiffness_n_m: f64,
}

impl AngularLaw {
    /// The stiffness, N m, if it is in range.
    pub(super) fn check(&self, kind: EffectKind) -> Result<f64, Violation> {
        coefficient(format_args!("effects.{kind}.stiffness_n_m"), self.stiffness_n_m)
    }
}

/// All angles of one kind.
pub type Angles = Elements<AngleSpec>;

/// Two edges with a direction.
struct Corner {
    /// `â`, `b̂`.
    u: [Vec3; 2],
    /// `|a|`, `|b|`, m.
    length: [f64; 2],
    cos: f64,
    sin: f64,
}

/// Lengths of edges that are usual, and the least quotient of two: far above [`COLLAPSED`].
const USUAL: (f64, f64) = (1e-90, 1e90);
const USUAL_QUOTIENT: f64 = 1e-11;

/// Four angles in registers.
struct Corners<F: Four> {
    /// The particles `i`, `j`, `k` of the four.
    places: [[usize; SLOTS]; 3],
    stiffness: F::Numbers,
    /// `δ₀` and `δ`.
    turn: [F::Numbers; 2],
    u: [Triple<F>; 2],
    length: [F::Numbers; 2],
    cos: F::Numbers,
    sin: F::Numbers,
}

impl<F: Four> Corners<F> {
    /// `None` where an edge of one of them has no direction, or is too near to that.
    #[inline(always)]
    fn new(four: F, group: &[AngleSpec; SLOTS], x: &[Vec3]) -> Option<Self> {
        let [a, b, c, d] = group;
        let places = [
            [a.i as usize, b.i as usize, c.i as usize, d.i as usize],
            [a.j as usize, b.j as usize, c.j as usize, d.j as usize],
            [a.k as usize, b.k as usize, c.k as usize, d.k as usize],
        ];
        let middle = four.gather(x, places[1]);
        let one = four.minus(four.gather(x, places[0]), middle);
        let other = four.minus(four.gather(x, places[2]), middle);
        let length = [four.sqrt(four.dot(one, one)), four.sqrt(four.dot(other, other))];
        let u = [four.over(one, length[0]), four.over(other, length[1])];
        let cos = four.dot(u[0], u[1]);
        let normal = four.cross(u[0], u[1]);
        let sin = four.sqrt(four.dot(normal, normal));

        let mut usual = four.splat(1.0);
        for side in 0..2 {
            let (own, other) = (length[side], length[1 - side]);
            usual = four.if_at_most(four.splat(USUAL.0), own, usual);
            usual = four.if_at_most(own, four.splat(USUAL.1), usual);
            usual = four.if_at_most(four.mul(own, four.splat(USUAL_QUOTIENT)), other, usual);
        }
        let (turn, usual) = atan2(four, sin, four.neg(cos), usual);
        let rest = four.load([a.rest_rad, b.rest_rad, c.rest_rad, d.rest_rad]);
        four.are_ones(usual).then_some(Self {
            places,
            stiffness: four.load([
                a.stiffness_n_m,
                b.stiffness_n_m,
                c.stiffness_n_m,
                d.stiffness_n_m,
            ]),
            turn: [four.sub(four.splat(PI), rest), turn],
            u,
            length,
            cos,
            sin,
        })
    }

    /// `(δ − δ₀)/sin δ`, or its limit.
    #[inline(always)]
    fn slope(&self, four: F) -> F::Numbers {
        let (zero, one) = (four.splat(0.0), four.splat(1.0));
        let [at_rest, turn] = self.turn;
        let is_straight_rest = four.if_at_most(four.abs(at_rest), zero, one);
        let limit = four.where_at_most(zero, self.cos, zero, is_straight_rest);
        let quotient = four.div(four.sub(turn, at_rest), self.sin);
        four.where_at_most(self.sin, four.splat(SINGULAR), limit, quotient)
    }
}

/// The stiffness over `(a, b)`: the blocks `aa`, `ab`, `bb`, N/m.
struct Blocks {
    aa: Mat3,
    ab: Mat3,
    bb: Mat3,
}

impl AngleSpec {
    fn places(&self) -> [usize; 3] {
        [self.i, self.j, self.k].map(|i| i as usize)
    }

    fn corner(&self, x: &[Vec3]) -> Option<Corner> {
        Corner::new(self.places().map(|i| x[i]))
    }

    /// `δ₀ = π − φ₀`.
    fn rest_turn(&self) -> f64 {
        PI - self.rest_rad
    }

    /// Whether the angle is straight at rest, and the corner is nearer to straight than to folded.
    fn is_near_straight_rest(&self, corner: &Corner) -> bool {
        self.rest_turn() == 0.0 && corner.cos < 0.0
    }

    /// `(δ − δ₀)/sin δ`, or its limit.
    fn slope(&self, corner: &Corner) -> f64 {
        if corner.sin > SINGULAR {
            (corner.turn() - self.rest_turn()) / corner.sin
        } else if self.is_near_straight_rest(corner) {
            1.0
        } else {
            0.0
        }
    }

    /// `g ∇²c + g' ∇c ∇cᵀ` with `g = dU/dc`, `g' = (k + g c)/sin²φ`.
    fn exact(&self, corner: &Corner) -> Blocks {
        let Corner { u: [a, b], length: [la, lb], cos, sin } = *corner;
        let (k, slope) = (self.stiffness_n_m, self.slope(corner));
        let curvature = if self.is_near_straight_rest(corner) && sin < SERIES {
            1.0 / 3.0 + sin * sin * (2.0 / 15.0)
        } else if sin > SINGULAR {
            (1.0 + slope * cos) / (sin * sin)
        } else {
            0.0
        };
        let [ga, gb] = corner.gradient();
        let mixed = b * a.transpose() + a * b.transpose();
        let along = |u: &Vec3, length: f64| {
            let bent = u * u.transpose() * (3.0 * cos) - mixed - Mat3::from_diagonal_element(cos);
            bent * (slope / (length * length))
        };
        let across = |u: &Vec3| Mat3::identity() - u * u.transpose();
        Blocks {
            aa: (along(&a, la) + ga * ga.transpose() * curvature) * k,
            ab: (across(&a) * across(&b) * (slope / (la * lb)) + ga * gb.transpose() * curvature)
                * k,
            bb: (along(&b, lb) + gb * gb.transpose() * curvature) * k,
        }
    }

    /// `k ∇φ ∇φᵀ`, and one term of the exact stiffness if it is positive:
    /// `k (δ − δ₀) ½ cot(δ/2) r rᵀ` with `r = (n/|a|, n/|b|)` and the normal `n` of the plane. This
    /// term resists turning the edges out of their plane against each other. Without it a straight
    /// row would have no stiffness.
    fn projected(&self, corner: &Corner) -> Blocks {
        let Corner { u: [a, b], length: [la, lb], cos, sin } = *corner;
        let k = self.stiffness_n_m;
        if self.is_near_straight_rest(corner) && sin < STRAIGHT {
            let across = (Mat3::identity() - a * a.transpose()) * k;
            return Blocks {
                aa: across / (la * la),
                ab: across / (la * lb),
                bb: across / (lb * lb),
            };
        }
        if sin <= SINGULAR {
            return Blocks { aa: Mat3::zeros(), ab: Mat3::zeros(), bb: Mat3::zeros() };
        }
        let [ta, tb] = corner.gradient().map(|g| g / sin);
        let n = a.cross(&b) / sin;
        let weight = 0.5 * (1.0 - cos) * self.slope(corner).max(0.0);
        let normal = n * n.transpose() * weight;
        Blocks {
            aa: (ta * ta.transpose() + normal / (la * la)) * k,
            ab: (ta * tb.transpose() + normal / (la * lb)) * k,
            bb: (tb * tb.transpose() + normal / (lb * lb)) * k,
        }
    }
}

impl Corner {
    fn new([i, j, k]: [Vec3; 3]) -> Option<Self> {
        let (a, b) = (i - j, k - j);
        let length = [a.norm(), b.norm()];
        let (short, long) = (length[0].min(length[1]), length[0].max(length[1]));
        (short > COLLAPSED * long && short > SHORTEST).then(|| {
            let u = [a / length[0], b / length[1]];
            Self { u, length, cos: u[0].dot(&u[1]), sin: u[0].cross(&u[1]).norm() }
        })
    }

    /// `δ = π − φ`, rad.
    fn turn(&self) -> f64 {
        libm::atan2(self.sin, -self.cos)
    }

    /// `∇_a cos φ`, `∇_b cos φ`, 1/m.
    fn gradient(&self) -> [Vec3; 2] {
        let Self { u: [a, b], length: [la, lb], cos, .. } = self;
        [(b - a * *cos) / *la, (a - b * *cos) / *lb]
    }
}

impl Element for AngleSpec {
    const LIST: &'static str = "angles";
    const REST: (f64, f64) = (0.0, PI);

    fn list(spec: &SystemSpec) -> &[Self] {
        &spec.angles
    }

    fn list_mut(spec: &mut SystemSpec) -> &mut Vec<Self> {
        &mut spec.angles
    }

    fn kind(&self) -> EffectKind {
        self.effect.into()
    }

    fn particles(&mut self) -> impl Iterator<Item = (&'static str, &mut u32)> {
        [("i", &mut self.i), ("j", &mut self.j), ("k", &mut self.k)].into_iter()
    }

    fn rest(&self) -> f64 {
        self.rest_rad
    }

    fn stiffness(&mut self) -> &mut f64 {
        &mut self.stiffness_n_m
    }

    fn energy(&self, x: &[Vec3]) -> Option<f64> {
        let excess = self.corner(x)?.turn() - self.rest_turn();
        Some(0.5 * self.stiffness_n_m * excess * excess)
    }

    /// `f_i = −g ∇_a c`, `f_k = −g ∇_b c`, and the opposite of both on the particle between.
    fn add_force(&self, x: &[Vec3], out: &mut [Vec3]) {
        let Some(corner) = self.corner(x) else { return };
        let g = self.stiffness_n_m * self.slope(&corner);
        let [fa, fb] = corner.gradient().map(|gradient| gradient * -g);
        let [i, j, k] = self.places();
        out[i] += fa;
        out[k] += fb;
        out[j] -= fa + fb;
    }

    #[inline(always)]
    fn add_forces<F: Four>(four: F, group: &[Self; SLOTS], x: &[Vec3], out: &mut [Vec3]) -> bool {
        let Some(corners) = Corners::new(four, group, x) else { return false };
        let g = four.neg(four.mul(corners.stiffness, corners.slope(four)));
        let Corners { places, u: [a, b], length, cos, .. } = corners;
        let of_a = four.over(four.minus(b, four.times(a, cos)), length[0]);
        let of_b = four.over(four.minus(a, four.times(b, cos)), length[1]);
        let (fa, fb) = (four.times(of_a, g), four.times(of_b, g));
        let sum = four.plus(fa, fb);
        let opposite = [four.neg(sum[0]), four.neg(sum[1]), four.neg(sum[2])];
        add_in_turn(places, &[four.apart(fa), four.apart(opposite), four.apart(fb)], out);
        true
    }

    #[inline(always)]
    fn energies<F: Four>(four: F, group: &[Self; SLOTS], x: &[Vec3]) -> Option<Lanes> {
        let Corners { stiffness, turn: [at_rest, turn], .. } = Corners::new(four, group, x)?;
        let excess = four.sub(turn, at_rest);
        let half = four.mul(four.splat(0.5), stiffness);
        Some(four.store(four.mul(four.mul(half, excess), excess)))
    }

    /// `∇φ = −∇c/sin φ`, of length `1/|a|` for the first edge however straight the angle is.
    fn turn(&self, &[i, j, k, _]: &[Vec3; 4]) -> Option<Turn> {
        let corner = Corner::new([i, j, k]).filter(|corner| corner.sin > SINGULAR)?;
        let [a, b] = corner.gradient().map(|gradient| gradient / -corner.sin);
        let excess = self.rest_turn() - corner.turn();
        let gradient = [a, -(a + b), b, Vec3::zeros()];
        Some(Turn { excess, gradient, stiffness: self.stiffness_n_m })
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        let [i, j, k] = self.places();
        visit(i, j);
        visit(k, j);
        visit(i, k);
    }

    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink) {
        let Some(corner) = self.corner(x) else { return };
        let Blocks { aa, ab, bb } = match tangent {
            Tangent::Exact => self.exact(&corner),
            Tangent::Projected => self.projected(&corner),
        };
        let [i, j, k] = self.places();
        sink.add_general_pair(i, j, &((aa + ab) * scale));
        sink.add_general_pair(k, j, &((bb + ab.transpose()) * scale));
        sink.add_general_pair(i, k, &(ab * -scale));
    }
}

/// Effects of angles.
pub(crate) struct Entry;

impl registry::Entry for Entry {
    type Value = AngularLaw;
    const CLASS: EffectClass = EffectClass::Stencils;
    const PIECES: [u64; 2] = [2, 0];

    fn freeze(
        law: &AngularLaw,
        kind: EffectKind,
        weave: Weave<'_>,
        spec: &mut SystemSpec,
    ) -> Result<(), Violation> {
        let stiffness = law.check(kind)?;
        let Cloth::Grid(grid) = weave.cloth else {
            let found = "given for a cloth without rows and columns";
            let expected = "a grid: other cloths do not state warp and weft";
            return Err(Violation::new(format!("effects.{kind}"), found, expected));
        };
        let effect =
            AngleEffect::ALL.into_iter().filter(|&effect| EffectKind::from(effect) == kind);
        effect.for_each(|effect| {
            spec.angles.extend(grid_angles(grid, effect, |_, _, _| stiffness));
        });
        Ok(())
    }

    fn check(kind: EffectKind, spec: &SystemSpec) -> Result<Option<Box<dyn Checked>>, Violation> {
        elements::check::<AngleSpec>(kind, spec)
    }
}

/// The angles of a grid. Shear takes the four angles around each particle, each with a fourth of
/// the stiffness. A sheared sheet then has `½ k (φ − π/2)²` at each inner particle. Bending takes
/// the angles between a particle's neighbours in its row and in its column. `stiffness` is asked
/// with row, column and place in the list of arms: for bending, 0 in a row and 1 in a column.
pub(crate) fn grid_angles(
    grid: &Grid,
    effect: AngleEffect,
    stiffness: impl Fn(u32, u32, usize) -> f64,
) -> Vec<AngleSpec> {
    let arms: &[[(i64, i64); 2]] = match effect {
        AngleEffect::ShearAngle => {
            &[[(1, 0), (0, 1)], [(-1, 0), (0, 1)], [(-1, 0), (0, -1)], [(1, 0), (0, -1)]]
        }
        AngleEffect::BendingAngle => &[[(-1, 0), (1, 0)], [(0, -1), (0, 1)]],
    };
    let (rest_rad, share) = match effect {
        AngleEffect::ShearAngle => (FRAC_PI_2, 0.25),
        AngleEffect::BendingAngle => (PI, 1.0),
    };
    let mut angles = Vec::new();
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            for (place, [one, other]) in arms.iter().enumerate() {
                let end = |(right, down): &(i64, i64)| grid.neighbour(row, column, *right, *down);
                let Some((i, k)) = end(one).zip(end(other)) else { continue };
                let j = grid.index(row, column);
                let stiffness_n_m = share * stiffness(row, column, place);
                angles.push(AngleSpec { effect, i, j, k, rest_rad, stiffness_n_m });
            }
        }
    }
    angles
}
