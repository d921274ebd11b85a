//! Triangles in space: the point of one that is nearest to another point, and a search for those
//! near a point.

use crate::Vec3;

/// The part of a triangle on which a point lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feature {
    /// Within the triangle.
    Face,
    /// The edge from this corner to the next.
    Edge(usize),
    /// One of the corners 0, 1 and 2.
    Corner(usize),
}

/// Most triangles of a leaf.
const LEAF: usize = 4;
/// More than the depth of any tree that halves `u32::MAX` triangles.
const DEPTH: usize = 64;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    fn of(points: impl Iterator<Item = Vec3>) -> Self {
        let (low, high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        points.fold(Self { low, high }, |bounds, point| Self {
            low: bounds.low.inf(&point),
            high: bounds.high.sup(&point),
        })
    }

    /// Square of the distance, m², 0 inside.
    fn distance_squared(&self, x: &Vec3) -> f64 {
        (self.low - x).sup(&(x - self.high)).sup(&Vec3::zeros()).norm_squared()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: Bounds,
    /// The first triangle of a leaf in `order`, or the second child; the first child follows its
    /// parent.
    next: u32,
    /// Triangles of a leaf; 0 for others.
    count: u32,
}

/// A tree of bounding boxes over triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// The root; empty without triangles.
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Tree {
    /// The tree of triangles, each given by the numbers of its corners.
    ///
    /// # Panics
    /// If a corner is not one of the vertices.
    pub fn new(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let corners = |t: u32| triangles[t as usize].map(|i| vertices[i as usize]);
        let along = |axis: usize| {
            let key = move |t: u32| corners(t).iter().map(|corner| corner[axis]).sum::<f64>();
            move |&a: &u32, &b: &u32| key(a).total_cmp(&key(b)).then(a.cmp(&b))
        };
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes: Vec<Node> = Vec::new();
        // Ranges of `order` that wait for their node. Beside each stand its parent, if it is the
        // second child, and the axis along which the parent was halved.
        let mut waiting = Vec::new();
        if !order.is_empty() {
            waiting.push((0, order.len(), None, None));
        }
        while let Some((first, end, parent, halved)) = waiting.pop() {
            let this = nodes.len();
            if let Some(parent) = parent {
                let parent: &mut Node = &mut nodes[parent];
                parent.next = this as u32;
            }
            let range = &mut order[first..end];
            let bounds = Bounds::of(range.iter().flat_map(|&t| corners(t)));
            let count = end - first;
            if count <= LEAF {
                if let Some(axis) = halved {
                    range.sort_unstable_by(along(axis));
                }
                nodes.push(Node { bounds, next: first as u32, count: count as u32 });
                continue;
            }
            let axis = (bounds.high - bounds.low).imax();
            let middle = first + count / 2;
            range.select_nth_unstable_by(count / 2, along(axis));
            nodes.push(Node { bounds, next: 0, count: 0 });
            waiting.push((middle, end, Some(this), Some(axis)));
            waiting.push((first, middle, None, Some(axis)));
        }
        Self { nodes, order }
    }

    /// Length of the diagonal of the outermost box, m.
    pub(crate) fn size(&self) -> f64 {
        let Bounds { low, high } = self.nodes[0].bounds;
        (high - low).norm()
    }

    pub(crate) fn is_near(&self, x: &Vec3, reach: f64) -> bool {
        self.nodes[0].bounds.distance_squared(x) <= reach * reach
    }

    /// Visits the triangles in all boxes that are near enough to `x`, nearer boxes first. A box is
    /// near enough if the square of its distance is below a bound, m²: first `bound`, and after a
    /// visit what that visit returns.
    pub fn search(&self, x: &Vec3, mut bound: f64, mut visit: impl FnMut(usize) -> f64) {
        let Some(root) = self.nodes.first() else { return };
        let mut waiting = [(0_u32, 0.0); DEPTH];
        let mut depth = 1;
        waiting[0].1 = root.bounds.distance_squared(x);
        while depth > 0 {
            depth -= 1;
            let (index, distance) = waiting[depth];
            if distance >= bound {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for &t in &self.order[node.next as usize..(node.next + node.count) as usize] {
                    bound = visit(t as usize);
                }
                continue;
            }
            let children = [index + 1, node.next]
                .map(|child| (child, self.nodes[child as usize].bounds.distance_squared(x)));
            let farther = usize::from(children[1].1 >= children[0].1);
            waiting[depth] = children[farther];
            waiting[depth + 1] = children[1 - farther];
            depth += 2;
        }
    }
}

/// The point of a triangle nearest to `x`, and the part on which it lies (Ericson 2005,
/// section 5.1.5).
pub fn nearest_point(x: &Vec3, [a, b, c]: [Vec3; 3]) -> (Vec3, Feature) {
    let (ab, ac, ax) = (b - a, c - a, x - a);
    let (d1, d2) = (ab.dot(&ax), ac.dot(&ax));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Feature::Corner(0));
    }
    let bx = x - b;
    let (d3, d4) = (ab.dot(&bx), ac.dot(&bx));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Feature::Corner(1));
    }
    let cx = x - c;
    let (d5, d6) = (ab.dot(&cx), ac.dot(&cx));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Feature::Corner(2));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Feature::Edge(0));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (b + (c - b) * share, Feature::Edge(1));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Feature::Edge(2));
    }
    let sum = va + vb + vc;
    (a + ab * (vb / sum) + ac * (vc / sum), Feature::Face)
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_kernels::testing::Random;

    /// The nearest point is the best of many points of the triangle, and lies on the part named.
    #[test]
    fn no_point_of_a_triangle_is_nearer_than_the_nearest() {
        let mut random = Random::new(6);
        let mut seen = [false; 3];
        for _ in 0..300 {
            let [a, b, c, p] = [(); 4].map(|()| random.vector());
            let (point, part) = nearest_point(&p, [a, b, c]);
            let found = (p - point).norm();
            let mut least = f64::INFINITY;
            for i in 0..=40 {
                for j in 0..=40 - i {
                    let (u, v) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                    least = least.min((p - (a + (b - a) * u + (c - a) * v)).norm());
                }
            }
            assert!(found <= least + 1e-12 && found > least - 0.1, "{found}, {least}");
            let corners = [a, b, c];
            let off = match part {
                Feature::Face => {
                    seen[0] = true;
                    (b - a).dot(&(p - point)).abs().max((c - a).dot(&(p - point)).abs())
                }
                Feature::Edge(k) => {
                    seen[1] = true;
                    let (from, to) = (corners[k], corners[(k + 1) % 3]);
                    (point - from).cross(&(to - from)).norm()
                }
                Feature::Corner(k) => {
                    seen[2] = true;
                    (point - corners[k]).norm()
                }
            };
            assert!(off < 1e-12, "{part:?}: {off}");
        }
        assert_eq!(seen, [true; 3]);
    }

    /// A search that finds two triangles equally near takes the first in its leaf, so the order in
    /// a leaf decides bits: it is along the axis in which the parent was halved.
    #[test]
    fn leaves_keep_the_order_of_a_tree_that_sorts_all_its_ranges() {
        fn sort(triangles: &mut [u32], corners: &[Vec3]) {
            if triangles.len() <= LEAF {
                return;
            }
            let of = |t: u32| &corners[3 * t as usize..3 * t as usize + 3];
            let bounds = Bounds::of(triangles.iter().flat_map(|&t| of(t).iter().copied()));
            let axis = (bounds.high - bounds.low).imax();
            let key = |t: u32| of(t).iter().map(|corner| corner[axis]).sum::<f64>();
            triangles.sort_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
            let (low, high) = triangles.split_at_mut(triangles.len() / 2);
            sort(low, corners);
            sort(high, corners);
        }
        let mut random = Random::new(8);
        for n in [3, 4, 5, 9, 200] {
            let corners = random.vectors(3 * n as usize);
            let triangles: Vec<_> = (0..n).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            let mut expected: Vec<_> = (0..n).collect();
            sort(&mut expected, &corners);
            assert_eq!(Tree::new(&corners, &triangles).order, expected);
        }
    }

    /// With a bound that never falls, the search visits every triangle once, and none without one.
    #[test]
    fn a_search_without_a_bound_visits_every_triangle_once() {
        let mut random = Random::new(7);
        for n in [0, 1, 4, 5, 100] {
            let corners = random.vectors(3 * n as usize);
            let triangles: Vec<_> = (0..n).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            let tree = Tree::new(&corners, &triangles);
            let visited = |bound: f64| {
                let mut visited = Vec::new();
                tree.search(&Vec3::zeros(), bound, |t| {
                    visited.push(t as u32);
                    bound
                });
                visited.sort_unstable();
                visited
            };
            assert_eq!(visited(f64::INFINITY), (0..n).collect::<Vec<_>>());
            assert!(visited(0.0).is_empty());
        }
    }
}
