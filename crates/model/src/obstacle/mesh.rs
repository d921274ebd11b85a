//! A solid bounded by a closed triangle mesh.
//!
//! A tree of bounding boxes finds the nearest point of the surface. The angle-weighted normal of
//! the face, edge or vertex at that point tells whether `x` lies inside (Bærentzen & Aanæs 2005).
//! The normal of one face alone is wrong if the nearest point lies on an edge.

use super::shells;
use crate::Vec3;
use crate::error::Violation;
use crate::triangles::{Feature, Tree, nearest_point};
use std::collections::BTreeMap;

/// Most triangles.
pub(crate) const MAX_TRIANGLES: usize = 1_000_000;
/// Within this distance of an edge or vertex, over the size of the mesh, its own normal replaces
/// the direction to it.
pub(super) const ON_THE_SURFACE: f64 = 1e-9;

/// A closed, consistently oriented triangle mesh: seen from outside, corners run counter-clockwise.
/// It may have several connected parts: separate solids, and walls of cavities in them. Corners of
/// such a wall run clockwise as seen from outside the solid. Parts must not intersect themselves or
/// each other; this is not checked.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedMesh {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// Unit normals.
    faces: Vec<Vec3>,
    /// Normals of each triangle's edges, from corner `k` to the next. Not of unit length.
    edges: Vec<[Vec3; 3]>,
    /// Normals of the vertices. Not of unit length.
    corners: Vec<Vec3>,
    tree: Tree,
    /// [`ON_THE_SURFACE`] times the size of the mesh, m.
    near: f64,
}

impl ClosedMesh {
    /// Vertices, m.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Triangles, counter-clockwise as seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Checks the mesh; `at` is where it stands in the file.
    ///
    /// # Errors
    /// The first [`Violation`]: a value out of range, or the triangle at which the surface is not
    /// closed, not a surface or not oriented as its neighbours.
    pub(crate) fn check(
        at: &str,
        vertices: Vec<Vec3>,
        triangles: &[[u32; 3]],
    ) -> Result<Self, Violation> {
        let path = |t: usize| format!("{at}.triangles[{t}]");
        let found = |t: usize| format!("{:?}", triangles[t]);
        if triangles.len() < 4 || triangles.len() > MAX_TRIANGLES {
            let found = format!("of length {}", triangles.len());
            let expected = format!("4 to {MAX_TRIANGLES} triangles");
            return Err(Violation::new(format!("{at}.triangles"), found, expected));
        }
        let mut faces = Vec::with_capacity(triangles.len());
        for (t, triangle) in triangles.iter().enumerate() {
            for (k, &corner) in triangle.iter().enumerate() {
                if corner as usize >= vertices.len() {
                    let expected = format!("a vertex index below {}", vertices.len());
                    return Err(Violation::new(format!("{}[{k}]", path(t)), corner, expected));
                }
            }
            let [a, b, c] = triangle.map(|i| vertices[i as usize]);
            let normal = (b - a).cross(&(c - a));
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            let is_flat = normal.norm() <= 1e-12 * longest * longest;
            let Some(normal) = normal.try_normalize(0.0).filter(|_| !is_flat) else {
                return Err(Violation::new(path(t), found(t), "a triangle with an area"));
            };
            faces.push(normal);
        }
        let across = neighbours(triangles).map_err(|(t, problem)| {
            let expected = format!("a closed surface with one orientation: {problem}");
            Violation::new(path(t), found(t), expected)
        })?;
        if let Some((vertex, t)) = pinched(vertices.len(), triangles, &across) {
            let expected = format!("triangles at vertex {vertex} that form one fan");
            return Err(Violation::new(path(t), found(t), expected));
        }
        shells::check(&vertices, triangles, &across)
            .map_err(|(t, found, expected)| Violation::new(path(t), found, expected))?;
        Ok(Self::new(vertices, triangles.to_vec(), faces, &across))
    }

    fn new(
        vertices: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        faces: Vec<Vec3>,
        across: &[[u32; 3]],
    ) -> Self {
        let edges = (0..triangles.len())
            .map(|t| across[t].map(|other| faces[t] + faces[other as usize]))
            .collect();
        let mut corners = vec![Vec3::zeros(); vertices.len()];
        for (triangle, face) in triangles.iter().zip(&faces) {
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|j| vertices[triangle[(k + j) % 3] as usize]);
                let (to_b, to_c) = (b - a, c - a);
                let angle = libm::atan2(to_b.cross(&to_c).norm(), to_b.dot(&to_c));
                corners[triangle[k] as usize] += face * angle;
            }
        }
        let tree = Tree::new(&vertices, &triangles);
        let near = ON_THE_SURFACE * tree.size();
        Self { vertices, triangles, faces, edges, corners, tree, near }
    }

    /// Signed distance, m, and unit normal at `x`.
    pub(super) fn distance(&self, x: &Vec3) -> (f64, Vec3) {
        let (t, point, feature) = self.nearest(x);
        let (face, away) = (self.faces[t], x - point);
        let normal = match feature {
            Feature::Face => return (face.dot(&away), face),
            Feature::Edge(k) => self.edges[t][k],
            Feature::Corner(k) => self.corners[self.triangles[t][k] as usize],
        };
        let length = away.norm();
        let side = if normal.dot(&away) < 0.0 { -1.0 } else { 1.0 };
        if length <= self.near {
            return (side * length, normal.try_normalize(0.0).unwrap_or(face));
        }
        (side * length, away * (side / length))
    }

    /// The triangle nearest to `x`, its nearest point, and the part on which that point lies.
    fn nearest(&self, x: &Vec3) -> (usize, Vec3, Feature) {
        let (mut best, mut least) = ((0, Vec3::zeros(), Feature::Face), f64::INFINITY);
        self.tree.search(x, least, |t| {
            let corners = self.triangles[t].map(|i| self.vertices[i as usize]);
            let (point, feature) = nearest_point(x, corners);
            let distance = (x - point).norm_squared();
            if distance < least {
                (least, best) = (distance, (t, point, feature));
            }
            least
        });
        best
    }

    /// Whether `x` may lie within `reach` of the solid, m.
    pub(super) fn is_near(&self, x: &Vec3, reach: f64) -> bool {
        self.tree.is_near(x, reach)
    }
}

/// The triangles across the edges of each triangle, or the first triangle with a problem.
fn neighbours(triangles: &[[u32; 3]]) -> Result<Vec<[u32; 3]>, (usize, String)> {
    let edge = |t: usize, k: usize| (triangles[t][k], triangles[t][(k + 1) % 3]);
    let mut owner = BTreeMap::new();
    for t in 0..triangles.len() {
        for (a, b) in [0, 1, 2].map(|k| edge(t, k)) {
            if let Some(other) = owner.insert((a, b), t as u32) {
                let problem = format!("its edge from {a} to {b} is one of triangle {other} too");
                return Err((t, problem));
            }
        }
    }
    let mut across = Vec::with_capacity(triangles.len());
    for t in 0..triangles.len() {
        let mut others = [0; 3];
        for (k, other) in others.iter_mut().enumerate() {
            let (a, b) = edge(t, k);
            let problem = || (t, format!("no triangle has the edge from {b} to {a} beside it"));
            *other = *owner.get(&(b, a)).ok_or_else(problem)?;
        }
        across.push(others);
    }
    Ok(across)
}

/// A vertex whose triangles form more than one fan, and one of these triangles.
fn pinched(vertices: usize, triangles: &[[u32; 3]], across: &[[u32; 3]]) -> Option<(u32, usize)> {
    let mut count = vec![0_u32; vertices];
    let mut first = vec![None; vertices];
    for (t, triangle) in triangles.iter().enumerate() {
        for &vertex in triangle {
            count[vertex as usize] += 1;
            first[vertex as usize].get_or_insert(t);
        }
    }
    let corner = |t: usize, vertex: u32| triangles[t].iter().position(|&other| other == vertex);
    (0_u32..).zip(&first).find_map(|(vertex, &first)| {
        let (start, count) = (first?, count[vertex as usize]);
        let (mut t, mut seen) = (start, 0);
        while seen <= count {
            seen += 1;
            t = across[t][corner(t, vertex)?] as usize;
            if t == start {
                break;
            }
        }
        (seen != count).then_some((vertex, start))
    })
}
