//! Angles between two edges that meet in a particle: shear between warp and weft, bending along rows and columns.
//!
//! With `a = x_i − x_j`, `b = x_k − x_j` and the angle `φ` between them,
//!
//! ```text
//! U = ½ k (φ − φ₀)²
//! ```
//!
//! Everything is written in terms of `c = cos φ`, whose gradient `∇_a c = (b̂ − c â)/|a|` is smooth wherever both edges
//! have a length. `g = dU/dc = k (δ − δ₀)/sin δ` with `δ = π − φ` is smooth at the straight angle where that is
//! the angle at rest: `(π − φ)/sin φ → 1` (Eberhardt, Weber and Straßer 1996 bend cloth so). At angles of 0 and
//! π that are not the one at rest no direction of the force is distinguished: there it is 0.

use super::{BlockSink, Effect, EffectKind, Tangent};
use crate::{Mat3, Vec3};
use std::f64::consts::PI;

/// An edge shorter than this fraction of the other one has no direction.
const COLLAPSED: f64 = 1e-12;
/// No edge is shorter than this, m, if it has a direction.
const SHORTEST: f64 = 1e-100;
/// `sin φ` below which the plane of the edges is lost in round-off.
const SINGULAR: f64 = 1e-12;
/// `sin φ` below which an angle counts as straight in the projected stiffness.
const STRAIGHT: f64 = 1e-8;
/// `sin φ` below which the curvature at the straight angle is taken from its series.
const SERIES: f64 = 3e-3;

/// The angle at particle `j` between the edges to `i` and `k`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle {
    /// End of the first edge.
    pub i: u32,
    /// Where the edges meet.
    pub j: u32,
    /// End of the second edge.
    pub k: u32,
    /// Angle at rest `φ₀`, 0 to π, rad.
    pub rest: f64,
    /// Stiffness `k`, N m.
    pub stiffness: f64,
}

/// Two edges with a direction.
struct Corner {
    /// `â`, `b̂`.
    u: [Vec3; 2],
    /// `|a|`, `|b|`, m.
    length: [f64; 2],
    cos: f64,
    sin: f64,
}

/// The stiffness over `(a, b)`: the blocks `aa`, `ab`, `bb`, N/m.
struct Blocks {
    aa: Mat3,
    ab: Mat3,
    bb: Mat3,
}

impl Angle {
    fn corner(&self, x: &[Vec3]) -> Option<Corner> {
        let [i, j, k] = [self.i, self.j, self.k].map(|i| x[i as usize]);
        let (a, b) = (i - j, k - j);
        let length = [a.norm(), b.norm()];
        let (short, long) = (length[0].min(length[1]), length[0].max(length[1]));
        (short > COLLAPSED * long && short > SHORTEST).then(|| {
            let u = [a / length[0], b / length[1]];
            Corner { u, length, cos: u[0].dot(&u[1]), sin: u[0].cross(&u[1]).norm() }
        })
    }

    /// `δ₀ = π − φ₀`.
    fn rest_turn(&self) -> f64 {
        PI - self.rest
    }

    /// Whether the straight angle is the one at rest, and the corner is nearer to it than to the fold.
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

    /// `½ k (φ − φ₀)²`, J; 0 where an edge has no direction.
    fn energy(&self, x: &[Vec3]) -> f64 {
        self.corner(x).map_or(0.0, |corner| {
            let excess = corner.turn() - self.rest_turn();
            0.5 * self.stiffness * excess * excess
        })
    }

    fn blocks(&self, corner: &Corner, tangent: Tangent) -> Blocks {
        match tangent {
            Tangent::Exact => self.exact(corner),
            Tangent::Projected => self.projected(corner),
        }
    }

    /// `g ∇²c + g' ∇c ∇cᵀ` with `g = dU/dc`, `g' = (k + g c)/sin²φ`.
    fn exact(&self, corner: &Corner) -> Blocks {
        let Corner { u: [a, b], length: [la, lb], cos, sin } = *corner;
        let (k, slope) = (self.stiffness, self.slope(corner));
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

    /// `k ∇φ ∇φᵀ`, and the part of the exact stiffness that turns the edges out of their plane against each other, where it is
    /// positive: `k (δ − δ₀) ½ cot(δ/2) r rᵀ` with `r = (n/|a|, n/|b|)`, `n` the normal of the plane. Without that a straight row would
    /// have no stiffness.
    fn projected(&self, corner: &Corner) -> Blocks {
        let Corner { u: [a, b], length: [la, lb], cos, sin } = *corner;
        let k = self.stiffness;
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

/// All angles of one effect.
#[derive(Clone, Debug)]
pub struct Angles {
    kind: EffectKind,
    list: Vec<Angle>,
}

impl Angles {
    /// Angles of one kind.
    pub fn new(kind: EffectKind, list: Vec<Angle>) -> Self {
        Self { kind, list }
    }
}

impl Effect for Angles {
    fn kind(&self) -> EffectKind {
        self.kind
    }

    fn energy(&self, _mass: &[f64], x: &[Vec3]) -> f64 {
        self.list.iter().map(|angle| angle.energy(x)).sum()
    }

    /// `f_i = −g ∇_a c`, `f_k = −g ∇_b c`, and the opposite of both on the particle between.
    fn add_force(&self, _mass: &[f64], x: &[Vec3], out: &mut [Vec3]) {
        for angle in &self.list {
            let Some(corner) = angle.corner(x) else { continue };
            let g = angle.stiffness * angle.slope(&corner);
            let [fa, fb] = corner.gradient().map(|gradient| gradient * -g);
            out[angle.i as usize] += fa;
            out[angle.k as usize] += fb;
            out[angle.j as usize] -= fa + fb;
        }
    }

    fn has_jacobian(&self) -> bool {
        true
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        for angle in &self.list {
            let [i, j, k] = [angle.i, angle.j, angle.k].map(|i| i as usize);
            visit(i, j);
            visit(k, j);
            visit(i, k);
        }
    }

    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink) {
        for angle in &self.list {
            let Some(corner) = angle.corner(x) else { continue };
            let Blocks { aa, ab, bb } = angle.blocks(&corner, tangent);
            let [i, j, k] = [angle.i, angle.j, angle.k].map(|i| i as usize);
            sink.add_general_pair(i, j, &((aa + ab) * scale));
            sink.add_general_pair(k, j, &((bb + ab.transpose()) * scale));
            sink.add_general_pair(i, k, &(ab * -scale));
        }
    }

    fn scale_stiffness(&mut self, factor: f64) -> bool {
        self.list.iter_mut().for_each(|angle| angle.stiffness *= factor);
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
