//! The connected parts of a closed mesh: surfaces of solids, and walls of cavities in them.
//!
//! The nearest triangle tells on which side a point lies. This is correct only if surfaces of
//! solids and walls of cavities alternate on the way in from infinity. A part turned outward must
//! lie outside all solids, and a part turned inward must lie inside one.

use super::mesh::ON_THE_SURFACE;
use crate::Vec3;
use crate::triangles::nearest_point;
use std::f64::consts::TAU;

/// Most parts: all are compared with all.
const MAX_SHELLS: usize = 100;
/// Number of points of a part that are tested. They lie on one side of the other parts, unless
/// parts cut each other a little.
const SAMPLES: usize = 4;
/// Most points of a part that are tried, to find some that lie on no other part.
const MAX_TRIED: usize = 16;

struct Shell {
    triangles: Vec<u32>,
    /// m³; negative where corners run clockwise seen from outside.
    volume: f64,
    low: Vec3,
    high: Vec3,
}

/// Checks how the parts are oriented; `across` has the neighbours of each triangle.
///
/// # Errors
/// A triangle of the faulty part, what was found and what was expected.
pub(super) fn check(
    vertices: &[Vec3],
    triangles: &[[u32; 3]],
    across: &[[u32; 3]],
) -> Result<(), (usize, String, String)> {
    let corners = |t: u32| triangles[t as usize].map(|i| vertices[i as usize]);
    let shells: Vec<_> = parts(across).into_iter().map(|part| Shell::new(part, corners)).collect();
    if shells.len() > MAX_SHELLS {
        let first = shells[MAX_SHELLS].triangles[0] as usize;
        let found = format!("in part {} of {}", MAX_SHELLS + 1, shells.len());
        let expected = format!("at most {MAX_SHELLS} parts that are not connected");
        return Err((first, found, expected));
    }
    for (place, shell) in shells.iter().enumerate() {
        let others = || shells.iter().enumerate().filter(|(other, _)| *other != place);
        // Number of solids around a point. A point on another part, where two touch, is on neither
        // side.
        let depth = |x: Vec3| {
            others().map(|(_, other)| other.turns_around(&x, corners)).sum::<Option<f64>>()
        };
        let depths = shell.samples(corners).filter_map(depth).take(SAMPLES);
        let mut sides = depths.map(|depth| depth > 0.5).peekable();
        let touches_all_over = sides.peek().is_none();
        let mut is_any = |side: bool| touches_all_over || sides.any(|is_inside| is_inside == side);
        let expected = match shell.volume {
            volume if volume > 0.0 && is_any(false) => continue,
            volume if volume > 0.0 => {
                "corners that run clockwise, as in the wall of a cavity: \
                 the part lies inside another one"
            }
            volume if volume < 0.0 && is_any(true) => continue,
            _ => "corners that run counter-clockwise seen from outside",
        };
        let found = format!("in a part with a volume of {:e} m³", shell.volume);
        return Err((shell.triangles[0] as usize, found, expected.to_owned()));
    }
    Ok(())
}

/// The triangles of each connected part.
fn parts(across: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut is_seen = vec![false; across.len()];
    let mut parts = Vec::new();
    for start in 0..across.len() {
        if std::mem::replace(&mut is_seen[start], true) {
            continue;
        }
        let mut part = vec![start as u32];
        let mut next = 0;
        while let Some(&t) = part.get(next) {
            next += 1;
            for other in across[t as usize] {
                if !std::mem::replace(&mut is_seen[other as usize], true) {
                    part.push(other);
                }
            }
        }
        parts.push(part);
    }
    parts
}

impl Shell {
    fn new(triangles: Vec<u32>, corners: impl Fn(u32) -> [Vec3; 3]) -> Self {
        let [origin, ..] = corners(triangles[0]);
        let (mut low, mut high, mut volume) = (origin, origin, 0.0);
        for &t in &triangles {
            for corner in corners(t) {
                (low, high) = (low.inf(&corner), high.sup(&corner));
            }
            let [a, b, c] = corners(t).map(|corner| corner - origin);
            volume += a.dot(&b.cross(&c)) / 6.0;
        }
        Self { triangles, volume, low, high }
    }

    /// Centroids of a few triangles from all over the list.
    fn samples(&self, corners: impl Fn(u32) -> [Vec3; 3]) -> impl Iterator<Item = Vec3> {
        let count = MAX_TRIED.min(self.triangles.len());
        let spread = (0..count).map(move |k| self.triangles[k * self.triangles.len() / count]);
        spread.map(move |t| corners(t).iter().sum::<Vec3>() / 3.0)
    }

    /// Winding number around `x`, from the solid angles of its triangles (van Oosterom and
    /// Strackee 1983): 1 or −1 inside, by orientation, 0 outside. `None` if `x` lies on it.
    fn turns_around(&self, x: &Vec3, corners: impl Fn(u32) -> [Vec3; 3]) -> Option<f64> {
        let near = ON_THE_SURFACE * (self.high - self.low).norm();
        if (0..3).any(|axis| x[axis] < self.low[axis] || x[axis] > self.high[axis]) {
            return Some(0.0);
        }
        let half_angle = |&t: &u32| {
            if (nearest_point(x, corners(t)).0 - x).norm() <= near {
                return None;
            }
            let [a, b, c] = corners(t).map(|corner| corner - x);
            let (p, q, r) = (a.norm(), b.norm(), c.norm());
            let below = p * q * r + a.dot(&b) * r + b.dot(&c) * p + c.dot(&a) * q;
            Some(libm::atan2(a.dot(&b.cross(&c)), below))
        };
        let angle = self.triangles.iter().map(half_angle).sum::<Option<f64>>()?;
        Some(angle / TAU)
    }
}
