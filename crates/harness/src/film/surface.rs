//! The distance of two surfaces, from points to triangles.

use drape_model::Vec3;

/// Triangles in space, sorted so that a search finds those near a point.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    x: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    /// Coordinate along which the triangles are sorted.
    axis: usize,
    /// The triangles; their middles along the axis rise.
    sorted: Vec<Ball>,
    /// Greatest distance along the axis from a triangle's middle to its corners, m.
    reach: f64,
}

/// A triangle and a ball that holds it.
#[derive(Debug)]
struct Ball {
    /// Middle of the triangle along the axis, m.
    along: f64,
    centre: Vec3,
    /// A little more than the distance of the corners from the centre, m.
    radius: f64,
    number: u32,
}

/// Share by which a ball is larger than it has to be, so that rounding leaves out no triangle.
const SLACK: f64 = 1e-6;

impl<'a> Surface<'a> {
    pub(super) fn new(x: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Self {
        let extent = |axis: usize| {
            let of = x.iter().map(|x| x[axis]);
            of.clone().fold(f64::NEG_INFINITY, f64::max) - of.fold(f64::INFINITY, f64::min)
        };
        let axis =
            (1..3).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best });
        let along = |corner: u32| x[corner as usize][axis];
        let middle = |t: &[u32; 3]| t.iter().map(|&corner| along(corner)).sum::<f64>() / 3.0;
        let ball = |(n, t): (usize, &[u32; 3])| {
            let corners = t.map(|corner| x[corner as usize]);
            let centre = corners.iter().sum::<Vec3>() / 3.0;
            let radius = corners.iter().map(|corner| (corner - centre).norm()).fold(0.0, f64::max);
            Ball { along: middle(t), centre, radius: radius * (1.0 + SLACK), number: n as u32 }
        };
        let mut sorted: Vec<_> = triangles.iter().enumerate().map(ball).collect();
        sorted.sort_unstable_by(|a, b| a.along.total_cmp(&b.along).then(a.number.cmp(&b.number)));
        let off = |t: &[u32; 3]| {
            t.iter().map(|&corner| (along(corner) - middle(t)).abs()).fold(0.0, f64::max)
        };
        let reach = triangles.iter().map(off).fold(0.0, f64::max);
        Self { x, triangles, axis, sorted, reach }
    }

    /// Distance of a point from the surface, m. `near` is the number of a particle that may be
    /// close.
    fn distance(&self, point: &Vec3, near: usize) -> f64 {
        let mut best = (point - self.x[near]).norm_squared();
        let mut least = best.sqrt() * (1.0 + SLACK);
        let place = point[self.axis];
        let start = self.sorted.partition_point(|ball| ball.along < place);
        let mut look = |ball: &Ball| {
            let gap = (ball.along - place).abs() - self.reach;
            if gap > 0.0 && gap * gap > best {
                return false;
            }
            let far = ball.radius + least;
            if (point - ball.centre).norm_squared() > far * far {
                return true;
            }
            let corners = self.triangles[ball.number as usize];
            let [a, b, c] = corners.map(|corner| self.x[corner as usize]);
            let square = (point - nearest(point, a, b, c)).norm_squared();
            if square < best {
                (best, least) = (square, square.sqrt() * (1.0 + SLACK));
            }
            true
        };
        let _above = self.sorted[start..].iter().all(&mut look);
        let _below = self.sorted[..start].iter().rev().all(&mut look);
        best.sqrt()
    }

    /// Mean distance of the points `x` from this surface, m.
    fn mean_distance(&self, x: &[Vec3]) -> f64 {
        let sum: f64 = x.iter().enumerate().map(|(i, x)| self.distance(x, i)).sum();
        sum / x.len() as f64
    }

    /// Mean distance of the particles of each surface from the other surface, m. Both surfaces have
    /// the same number of particles.
    pub(super) fn apart(&self, other: &Self) -> f64 {
        0.5 * (self.mean_distance(other.x) + other.mean_distance(self.x))
    }
}

/// The point of a triangle that is nearest to a point: Ericson, Real-Time Collision Detection
/// (2004), section 5.1.5.
fn nearest(p: &Vec3, a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let whole = va + vb + vc;
    a + ab * (vb / whole) + ac * (vc / whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_oracle::Random;

    /// A patch of `n` × `n` particles with random heights.
    fn patch(n: u32, random: &mut Random) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let place = |k: u32| Vec3::new(f64::from(k / n), f64::from(k % n), 0.0);
        let x = (0..n * n).map(|k| place(k) + random.vector() * 0.4).collect();
        let cells = (0..(n - 1) * (n - 1)).map(|k| k / (n - 1) * n + k % (n - 1));
        (x, cells.flat_map(|k| [[k, k + 1, k + n], [k + 1, k + n + 1, k + n]]).collect())
    }

    #[test]
    fn the_sorted_search_finds_what_a_search_of_all_finds() {
        let mut random = Random::new(5);
        let (x, triangles) = patch(7, &mut random);
        let surface = Surface::new(&x, &triangles);
        for k in 0..200 {
            let point = Vec3::new(3.0, 3.0, 0.0) + random.vector() * 4.0;
            let all = triangles.iter().map(|t| {
                let [a, b, c] = t.map(|corner| x[corner as usize]);
                (point - nearest(&point, a, b, c)).norm()
            });
            let least = all.fold(f64::INFINITY, f64::min);
            assert!((surface.distance(&point, k % x.len()) - least).abs() < 1e-14);
        }
    }

    /// The nearest point is the best of many points of the triangle.
    #[test]
    fn no_point_of_a_triangle_is_nearer_than_the_nearest() {
        let mut random = Random::new(6);
        for _ in 0..300 {
            let [a, b, c, p] = [(); 4].map(|()| random.vector());
            let found = (p - nearest(&p, a, b, c)).norm();
            let mut least = f64::INFINITY;
            for i in 0..=40 {
                for j in 0..=40 - i {
                    let (u, v) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                    least = least.min((p - (a + (b - a) * u + (c - a) * v)).norm());
                }
            }
            assert!(found <= least + 1e-12 && found > least - 0.1, "{found}, {least}");
        }
    }

    #[test]
    fn a_surface_is_apart_from_a_parallel_one_by_the_gap_wherever_the_vertices_lie() {
        let mut random = Random::new(7);
        let (mut x, triangles) = patch(6, &mut random);
        x.iter_mut().for_each(|x| x.z = 0.0);
        // Within the plane the vertices may lie anywhere.
        let middle = Vec3::new(2.5, 2.5, 0.0);
        let other: Vec<_> = x.iter().map(|x| middle + (x - middle) * 0.9).collect();
        let lifted: Vec<_> = other.iter().map(|x| x + Vec3::z() * 0.125).collect();
        let (flat, above) = (Surface::new(&x, &triangles), Surface::new(&lifted, &triangles));
        assert!((flat.mean_distance(&lifted) - 0.125).abs() < 1e-12);
        assert!(flat.apart(&above) >= 0.125 && flat.apart(&above) < 0.2);
    }
}
