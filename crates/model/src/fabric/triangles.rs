//! A strip of equilateral triangles, on which hinges bend alike in all directions.

use super::{Directions, MaterialChoice, ShearModel, specimen};
use crate::error::Violation;
use crate::{Cloth, MeshCloth, Pin, Scene};
use std::fmt::Write as _;

/// A strip of equilateral triangles that is clamped at one end: the cantilever test for hinges.
///
/// The rows of particles run along the strip; both ends are straight, so every second row has a
/// shorter edge at each end. The clamp is at `x = 0`, in the middle of the held triangles; the free
/// end is at `x = length`.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleStrip {
    /// Free length, m.
    pub length_m: f64,
    /// Number of edges along the free length, at least 1.
    pub segments: u32,
    /// Number of rows of particles across, at least 2.
    pub rows: u32,
    /// Material of the strip. The mesh has no directions, so it takes the mean of warp and weft.
    /// Its edges resist shear.
    pub material: MaterialChoice,
}

impl TriangleStrip {
    /// Length of an edge, m.
    pub fn spacing_m(&self) -> f64 {
        self.length_m / f64::from(self.segments)
    }

    /// Width, m.
    pub fn width_m(&self) -> f64 {
        f64::from(self.rows.saturating_sub(1)) * self.spacing_m() * 0.75_f64.sqrt()
    }

    /// The mesh as the text of an OBJ file.
    pub fn obj(&self) -> String {
        let (a, edges) = (self.spacing_m(), self.segments);
        let mut text = String::from("# A strip of equilateral triangles.\n");
        // Number of the first particle of each row, from 1, and of the particles in it.
        let mut starts: Vec<(u32, u32)> = Vec::new();
        let mut first = 1;
        for row in 0..self.rows {
            let y = f64::from(row) * a * 0.75_f64.sqrt();
            let inner =
                |count: u32, before: f64| (0..count).map(move |k| (f64::from(k) - before) * a);
            let x: Vec<f64> = if row % 2 == 0 {
                inner(edges + 2, 1.0).collect()
            } else {
                [-a].into_iter().chain(inner(edges + 1, 0.5)).chain([self.length_m]).collect()
            };
            starts.push((first, x.len() as u32));
            first += x.len() as u32;
            for x in x {
                // Writing to a string cannot fail.
                let _ = writeln!(text, "v {x} {y} 0");
            }
        }
        for (row, pair) in starts.windows(2).enumerate() {
            let is_even_below = row % 2 == 0;
            let ((even, count), (odd, _)) =
                if is_even_below { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
            let mut face = |i: u32, j: u32, k: u32| {
                let [i, j] = if is_even_below { [i, j] } else { [j, i] };
                let _ = writeln!(text, "f {i} {j} {k}");
            };
            for k in 0..count {
                face(odd + k + 1, odd + k, even + k);
                if k + 1 < count {
                    face(even + k, even + k + 1, odd + k + 1);
                }
            }
        }
        text
    }

    /// The scene of the test. The strip is horizontal, along x from the clamp at 0.
    ///
    /// # Errors
    /// A [`Violation`] if the mesh is refused.
    pub fn scene(&self) -> Result<Scene, Violation> {
        let mut mesh = MeshCloth::of_file("strip.obj");
        mesh.read(self.obj().as_bytes())?;
        let material = MaterialChoice {
            directions: Directions::Mean,
            shear_model: ShearModel::Springs,
            ..self.material.clone()
        };
        let wide = 2.0 * self.width_m() + self.length_m;
        let near = 0.51 * self.spacing_m();
        let held =
            Pin { within_m: Some([[-wide, -wide, -wide], [near, wide, wide]]), ..Pin::default() };
        let scene = specimen::scene("cantilever", material, Cloth::Mesh(mesh));
        Ok(Scene { pins: vec![held], ..scene })
    }

    /// `Γ = ρ g L³/B`, where `B` is the mean of the bending rigidities.
    ///
    /// # Errors
    /// As [`MaterialChoice::resolve`].
    pub fn gamma(&self) -> Result<f64, Violation> {
        let material = self.material.resolve()?;
        let weight = material.areal_density_kg_m2 * specimen::GRAVITY * self.length_m.powi(3);
        Ok(weight / material.bending_n_m.mean().warp)
    }
}
