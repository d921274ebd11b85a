//! The distance of two surfaces, from points to triangles.

use drape_model::Vec3;

/// Triangles in space, and a tree of boxes in which a search finds those near a point.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    x: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    /// The root, and after each node with children the first of them.
    nodes: Vec<Node>,
    /// The triangles in the order of the leaves.
    order: Vec<u32>,
}

/// A box that holds some triangles.
#[derive(Debug)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// The first triangle of a leaf in the order, or the number of the second child.
    next: u32,
    /// Number of triangles of a leaf; 0 for others.
    count: u32,
}

/// Most triangles of a leaf.
const LEAF: usize = 4;
/// Share by which a box may be farther than the best distance, so that rounding leaves out no
/// triangle.
const SLACK: f64 = 1e-6;

impl Node {
    /// Square of the distance of a point from the box, m².
    fn distance_squared(&self, point: &Vec3) -> f64 {
        (self.low - point).sup(&(point - self.high)).sup(&Vec3::zeros()).norm_squared()
    }
}

impl<'a> Surface<'a> {
    pub(super) fn new(x: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Self {
        let order = (0..triangles.len() as u32).collect();
        let mut surface = Self { x, triangles, nodes: Vec::new(), order };
        if !triangles.is_empty() {
            surface.grow(0, triangles.len());
        }
        surface
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|corner| self.x[corner as usize])
    }

    /// Adds the node of the triangles from `first` to before `end` in the order, and all below it.
    fn grow(&mut self, first: usize, end: usize) {
        let corners = || self.order[first..end].iter().flat_map(|&t| self.corners(t));
        let low = corners().fold(Vec3::repeat(f64::INFINITY), |low, x| low.inf(&x));
        let high = corners().fold(Vec3::repeat(f64::NEG_INFINITY), |high, x| high.sup(&x));
        let count = end - first;
        if count <= LEAF {
            self.nodes.push(Node { low, high, next: first as u32, count: count as u32 });
            return;
        }
        let axis = (high - low).imax();
        let mut order = std::mem::take(&mut self.order);
        let key = |t: u32| self.corners(t).iter().map(|corner| corner[axis]).sum::<f64>();
        let before = |a: &u32, b: &u32| key(*a).total_cmp(&key(*b)).then(a.cmp(b));
        order[first..end].select_nth_unstable_by(count / 2, before);
        self.order = order;
        let this = self.nodes.len();
        let middle = first + count / 2;
        self.nodes.push(Node { low, high, next: 0, count: 0 });
        self.grow(first, middle);
        self.nodes[this].next = self.nodes.len() as u32;
        self.grow(middle, end);
    }

    /// Distance of a point from the surface, m. `near` is the number of a particle that may be
    /// close.
    fn distance(&self, point: &Vec3, near: usize) -> f64 {
        let mut best = (point - self.x[near]).norm_squared();
        if let Some(root) = self.nodes.first() {
            self.search(point, (0, root.distance_squared(point)), &mut best);
        }
        best.sqrt()
    }

    /// Lowers `best`, the square of a distance, m², as far as the triangles of a node allow. The
    /// node is given by its number and the square of its distance.
    fn search(&self, point: &Vec3, (number, far): (u32, f64), best: &mut f64) {
        if far > *best * (1.0 + SLACK) {
            return;
        }
        let node = &self.nodes[number as usize];
        if node.count > 0 {
            let first = node.next as usize;
            for &triangle in &self.order[first..first + node.count as usize] {
                let [a, b, c] = self.corners(triangle);
                *best = best.min((point - nearest(point, a, b, c)).norm_squared());
            }
            return;
        }
        let child = |number: u32| (number, self.nodes[number as usize].distance_squared(point));
        let mut children = [child(number + 1), child(node.next)];
        if children[1].1 < children[0].1 {
            children.reverse();
        }
        children.into_iter().for_each(|child| self.search(point, child, best));
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
            let all = triangles.iter().map(|t| {
                let [a, b, c] = t.map(|corner| x[corner as usize]);
                (point - nearest(&point, a, b, c)).norm_squared()
            });
            let start = (point - x[near]).norm_squared();
            assert_eq!(surface.distance(&point, near), all.fold(start, f64::min).sqrt());
        }
        let lonely = Surface::new(&x[..1], &[]);
        assert_eq!(lonely.distance(&(x[0] + Vec3::x()), 0), 1.0);
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
