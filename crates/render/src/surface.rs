//! Normals and edges of triangle meshes.

use drape_model::Vec3;
use std::collections::BTreeMap;

/// Normal of a triangle; its length is twice the area of the triangle, m².
pub(crate) fn area_normal(x: &[Vec3], [a, b, c]: [u32; 3]) -> Vec3 {
    let [a, b, c] = [a, b, c].map(|i| x[i as usize]);
    (b - a).cross(&(c - a))
}

/// Unit normals of the points of a mesh, weighted by the areas of the triangles around them. A
/// normal points upward where no triangle has an area.
pub(crate) fn normals(x: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); x.len()];
    for &triangle in triangles {
        let normal = area_normal(x, triangle);
        for corner in triangle {
            normals[corner as usize] += normal;
        }
    }
    for normal in &mut normals {
        let length = normal.norm();
        let is_usable = length > 0.0 && length.is_finite();
        *normal = if is_usable { *normal / length } else { Vec3::z() };
    }
    normals
}

/// The triangles on both sides of each edge. An edge on the rim has one triangle.
pub(crate) fn edges(triangles: &[[u32; 3]]) -> BTreeMap<[u32; 2], Vec<usize>> {
    let mut edges: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (number, &[a, b, c]) in triangles.iter().enumerate() {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            edges.entry([a.min(b), a.max(b)]).or_default().push(number);
        }
    }
    edges
}
