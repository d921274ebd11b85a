//! A tree of bounding boxes over triangles.

use super::mesh::Feature;
use crate::Vec3;

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

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Tree {
    pub(super) fn new(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let corners = |t: u32| triangles[t as usize].map(|i| vertices[i as usize]);
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = Vec::new();
        // Ranges of `order` that wait for their node, with the parent whose second child they are.
        let mut waiting = vec![(0, order.len(), None)];
        while let Some((first, end, parent)) = waiting.pop() {
            let this = nodes.len();
            if let Some(parent) = parent.map(|parent: usize| &mut nodes[parent]) {
                let parent: &mut Node = parent;
                parent.next = this as u32;
            }
            let range = &mut order[first..end];
            let bounds = Bounds::of(range.iter().flat_map(|&t| corners(t)));
            let count = end - first;
            if count <= LEAF {
                nodes.push(Node { bounds, next: first as u32, count: count as u32 });
                continue;
            }
            let axis = (bounds.high - bounds.low).imax();
            let key = |t: u32| corners(t).iter().map(|corner| corner[axis]).sum::<f64>();
            range.sort_unstable_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
            let middle = first + count / 2;
            nodes.push(Node { bounds, next: 0, count: 0 });
            waiting.push((middle, end, Some(this)));
            waiting.push((first, middle, None));
        }
        Self { nodes, order }
    }

    /// Length of the diagonal of the outermost box, m.
    pub(super) fn size(&self) -> f64 {
        let Bounds { low, high } = self.nodes[0].bounds;
        (high - low).norm()
    }

    pub(super) fn is_near(&self, x: &Vec3, reach: f64) -> bool {
        self.nodes[0].bounds.distance_squared(x) <= reach * reach
    }

    /// The triangle nearest to `x`, its nearest point, and the part on which that point lies.
    /// `on_triangle` finds point and part for one triangle.
    pub(super) fn nearest(
        &self,
        x: &Vec3,
        on_triangle: impl Fn(usize) -> (Vec3, Feature),
    ) -> (usize, Vec3, Feature) {
        let mut best = (0, Vec3::zeros(), Feature::Face);
        let mut least = f64::INFINITY;
        let mut waiting = [(0_u32, 0.0); DEPTH];
        let mut depth = 1;
        waiting[0].1 = self.nodes[0].bounds.distance_squared(x);
        while depth > 0 {
            depth -= 1;
            let (index, distance) = waiting[depth];
            if distance >= least {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for &t in &self.order[node.next as usize..(node.next + node.count) as usize] {
                    let (point, feature) = on_triangle(t as usize);
                    let distance = (x - point).norm_squared();
                    if distance < least {
                        (least, best) = (distance, (t as usize, point, feature));
                    }
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
        best
    }
}
