//! Where a mesh has its warp: the direction in which the first texture coordinate grows.

use super::obj::Obj;
use super::surface::Surface;
use crate::Vec3;

/// Determinant of two texture edges over their lengths, below which they span no area.
const DEGENERATE: f64 = 1e-9;

/// A face, with the places of its corners along warp and weft from its first corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Patch {
    corners: [u32; 4],
    /// In units of the file times its scale, m.
    places: [[f64; 2]; 4],
    count: usize,
}

impl Patch {
    /// Three or four particles.
    pub(crate) fn corners(&self) -> &[u32] {
        &self.corners[..self.count]
    }

    /// The places of its corners along warp and weft, m.
    pub(crate) fn places(&self) -> &[[f64; 2]] {
        &self.places[..self.count]
    }
}

/// The direction of the warp in each face of a file, a unit vector; none where the texture spans no
/// area. Empty if the file has no texture.
pub(super) fn warps(vertices: &[Vec3], obj: &Obj) -> Vec<Option<Vec3>> {
    let of = |(face, textures): (&super::obj::Face, &[u32; 4])| {
        let x = |k: usize| vertices[face.corners()[k] as usize];
        let last = face.corners().len() - 1;
        let texture = |k: usize| obj.textures.get(textures[k] as usize).copied();
        // Two edges of a triangle, the diagonals of a quad.
        let (e, f) =
            if last == 2 { (x(1) - x(0), x(2) - x(0)) } else { (x(2) - x(0), x(3) - x(1)) };
        let ([a, b], [c, d]) = if last == 2 { ([0, 1], [0, 2]) } else { ([0, 2], [1, 3]) };
        let difference = |from: usize, to: usize| {
            let ([u0, v0], [u1, v1]) = (texture(from)?, texture(to)?);
            Some((u1 - u0, v1 - v0))
        };
        let ((eu, ev), (fu, fv)) = (difference(a, b)?, difference(c, d)?);
        let determinant = eu * fv - fu * ev;
        let size = (eu.hypot(ev) * fu.hypot(fv)).max(f64::MIN_POSITIVE);
        let spans = determinant.abs() > DEGENERATE * size;
        let warp = (e * fv - f * ev) / determinant;
        spans
            .then(|| warp.try_normalize(0.0))
            .flatten()
            .filter(|warp| warp.iter().all(|w| w.is_finite()))
    };
    obj.faces.iter().zip(&obj.face_textures).map(of).collect()
}

/// The faces of a surface in their planes; an error is the place of a face without a direction.
/// With `mean` the warp is the first edge of each face.
pub(super) fn patches(surface: &Surface, scale: f64, mean: bool) -> Result<Vec<Patch>, usize> {
    let patch = |(place, face): (usize, &super::obj::Face)| {
        let corners = face.corners();
        let x = |k: usize| surface.vertices[corners[k] as usize];
        let last = corners.len() - 1;
        let normal = (x(2) - x(0)).cross(&(x(last) - x(1))).normalize();
        let warp = if mean {
            Some(x(1) - x(0))
        } else {
            surface.warps.get(face.number as usize).copied().flatten()
        };
        let warp = warp.and_then(|warp| (warp - normal * normal.dot(&warp)).try_normalize(1e-9));
        let Some(warp) = warp else { return Err(place) };
        let weft = normal.cross(&warp);
        let mut patch = Patch { corners: [0; 4], places: [[0.0; 2]; 4], count: corners.len() };
        for (k, &corner) in corners.iter().enumerate() {
            let from_first = (x(k) - x(0)) * scale;
            patch.corners[k] = corner;
            patch.places[k] = [from_first.dot(&warp), from_first.dot(&weft)];
        }
        Ok(patch)
    };
    surface.faces.iter().enumerate().map(patch).collect()
}
