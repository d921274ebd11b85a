//! The distance of two surfaces, from points to triangles.

use drape_model::Vec3;
use drape_model::triangles::{Tree, nearest_point};

/// Triangles in space, and a tree in which a search finds those near a point.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    x: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    tree: Tree,
}

/// Share by which a box may be farther than the best distance, so that rounding leaves out no
/// triangle.
const SLACK: f64 = 1e-6;

impl<'a> Surface<'a> {
    pub(super) fn new(x: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Self {
        Self { x, triangles, tree: Tree::new(x, triangles) }
    }

    /// Square of the distance of a point from a triangle, m².
    fn distance_squared(&self, point: &Vec3, triangle: [u32; 3]) -> f64 {
        let corners = triangle.map(|corner| self.x[corner as usize]);
        (point - nearest_point(point, corners).0).norm_squared()
    }

    /// Distance of a point from the surface, m. `near` is the number of a particle that may be
    /// close.
    fn distance(&self, point: &Vec3, near: usize) -> f64 {
        let mut least = (point - self.x[near]).norm_squared();
        self.tree.search(point, least * (1.0 + SLACK), |t| {
            least = least.min(self.distance_squared(point, self.triangles[t]));
            least * (1.0 + SLACK)
        });
        least.sqrt()
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

    /// Near and far from the surface, to the last bit.
    #[test]
    fn the_search_finds_what_a_search_of_all_finds() {
        let mut random = Random::new(5);
        let (x, triangles) = patch(17, &mut random);
        let surface = Surface::new(&x, &triangles);
        for k in 0..600 {
            let near = k % x.len();
            let point = match k % 3 {
                0 => Vec3::new(8.0, 8.0, 0.0) + random.vector() * 12.0,
                1 => x[near] + random.vector() * 0.5,
                _ => x[near] + Vec3::z() * 1e-9,
            };
            let all = triangles.iter().map(|&t| surface.distance_squared(&point, t));
            let start = (point - x[near]).norm_squared();
            assert_eq!(surface.distance(&point, near), all.fold(start, f64::min).sqrt());
        }
        let lonely = Surface::new(&x[..1], &[]);
        assert_eq!(lonely.distance(&(x[0] + Vec3::x()), 0), 1.0);
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
