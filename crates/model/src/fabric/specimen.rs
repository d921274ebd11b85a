//! Specimens of textile tests as scenes.

use super::MaterialChoice;
use crate::error::Violation;
use crate::{Cloth, DampingLaw, Effects, GravitySpec, Grid, MeshCloth, Pin, Scene, TimeSpan};
use std::fmt::Write as _;

/// Gravity of the specimens, m/s².
pub(super) const GRAVITY: f64 = 9.81;

/// Distance, in mesh widths, within which a particle goes to the edge of the support.
const SNAP: f64 = 0.3;

/// A strip that is clamped at one end and hangs under its weight: the cantilever test (Peirce 1930;
/// BS 3356; ASTM D1388). Its warp is along the strip.
///
/// Two columns of particles are held. The clamp is in the middle between them, at `x = 0`. From
/// there on, the angles and hinges at the second column stand for cloth. The free end is at
/// `x = length`.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Free length, m.
    pub length_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Number of edges along the strip. Half of the first edge is behind the clamp, so the free
    /// length is `segments − ½` edges.
    pub segments: u32,
    /// Number of particles across, at least 2.
    pub rows: u32,
    /// Material of the strip.
    pub material: MaterialChoice,
}

impl Strip {
    /// Distance of the particles along the strip, m.
    pub fn spacing_m(&self) -> f64 {
        self.length_m / (f64::from(self.segments) - 0.5)
    }

    /// The scene of the test. The strip is horizontal, along x from the clamp at 0, and has
    /// particle `row · columns + column`.
    pub fn scene(&self) -> Scene {
        let h = self.spacing_m();
        let columns = self.segments.saturating_add(1);
        let column = |column| Pin { column: Some(column), ..Pin::default() };
        let grid = Grid {
            rows: self.rows,
            columns,
            size_m: [h * f64::from(self.segments), self.width_m],
            center_m: [0.5 * h * f64::from(self.segments) - 0.5 * h, 0.0, 0.0],
            mass_kg: None,
            rotation: None,
            velocity_m_s: [0.0; 3],
        };
        let pins = vec![column(0), column(1)];
        Scene { pins, ..scene("cantilever", self.material.clone(), Cloth::Grid(grid)) }
    }

    /// `Γ = ρ g L³/B`. It alone determines how far an inextensible strip bends.
    ///
    /// # Errors
    /// As [`MaterialChoice::resolve`].
    pub fn gamma(&self) -> Result<f64, Violation> {
        let material = self.material.resolve()?;
        let weight = material.areal_density_kg_m2 * GRAVITY * self.length_m.powi(3);
        Ok(weight / material.bending_n_m.warp)
    }
}

/// A disc of cloth that hangs over a smaller one: the drape test of Cusick (1965) and BS 5058. Use
/// [`projected_area`](crate::projected_area) and [`drape_coefficient`](crate::drape_coefficient) on
/// the state at rest.
///
/// The particles on the inner disc are held.
#[derive(Clone, Debug, PartialEq)]
pub struct Disc {
    /// Radius of the cloth, m; 0.15 in the standard.
    pub radius_m: f64,
    /// Radius of the disc that holds it, m; 0.09 in the standard.
    pub support_m: f64,
    /// Number of squares across the diameter, at least 4.
    pub cells: u32,
    /// Angle between the warp and the x axis, degrees. The mesh is rotated, but the outline is not.
    pub warp_deg: f64,
    /// Material of the cloth.
    pub material: MaterialChoice,
}

impl Disc {
    /// The mesh as the text of an OBJ file, with texture coordinates along warp and weft. The held
    /// faces are in the group `support`, the others in `overhang`.
    pub fn obj(&self) -> String {
        let n = self.cells.max(4) as usize;
        let h = 2.0 * self.radius_m / n as f64;
        let at = |k: usize| (k as f64 - 0.5 * n as f64) * h;
        let is_cell = |i: usize, j: usize| {
            i < n && j < n && libm::hypot(at(i) + 0.5 * h, at(j) + 0.5 * h) < self.radius_m
        };
        let cells_of = |i: usize, j: usize| {
            let pairs = [
                (i, j),
                (i.wrapping_sub(1), j),
                (i, j.wrapping_sub(1)),
                (i.wrapping_sub(1), j.wrapping_sub(1)),
            ];
            pairs.into_iter().filter(|&(i, j)| is_cell(i, j)).count()
        };
        let (sine, cosine) =
            (libm::sin(self.warp_deg.to_radians()), libm::cos(self.warp_deg.to_radians()));
        let mut text = String::from("# A disc of squares along warp and weft.\n");
        let mut numbers = vec![0_usize; (n + 1) * (n + 1)];
        let mut count = 0;
        let mut held = Vec::new();
        for j in 0..=n {
            for i in 0..=n {
                let cells = cells_of(i, j);
                if cells == 0 {
                    continue;
                }
                let (x, y) = (at(i), at(j));
                // Particles at the border go to the circle.
                // So do those near the edge of the support, unless two could meet there.
                let radius = libm::hypot(x, y);
                let stretch = if cells < 4 {
                    self.radius_m / radius
                } else if (radius - self.support_m).abs() < SNAP * h {
                    self.support_m / radius
                } else {
                    1.0
                };
                let (x, y) = (x * stretch, y * stretch);
                count += 1;
                numbers[j * (n + 1) + i] = count;
                held.push(libm::hypot(x, y) <= self.support_m * (1.0 + 1e-9));
                // Writing to a string cannot fail.
                let _ = writeln!(text, "v {} {} 0", cosine * x - sine * y, sine * x + cosine * y);
                let _ = writeln!(text, "vt {x} {y}");
            }
        }
        let mut groups = [String::from("g support\n"), String::from("g overhang\n")];
        for j in 0..n {
            for i in (0..n).filter(|&i| is_cell(i, j)) {
                let corner = |i: usize, j: usize| numbers[j * (n + 1) + i];
                let corners =
                    [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                let is_held = corners.iter().all(|&corner| held[corner - 1]);
                let group = &mut groups[usize::from(!is_held)];
                let words: Vec<_> = corners.iter().map(|c| format!("{c}/{c}")).collect();
                let _ = writeln!(group, "f {}", words.join(" "));
            }
        }
        groups.iter().for_each(|group| text.push_str(group));
        text
    }

    /// The scene of the test. The cloth starts flat and horizontal at `z = 0`, with gravity and the
    /// held particles.
    ///
    /// # Errors
    /// A [`Violation`] if the mesh is refused, for example because squares at the border lose their
    /// area.
    pub fn scene(&self) -> Result<Scene, Violation> {
        let mut mesh = MeshCloth::of_file("disc.obj");
        mesh.read(self.obj().as_bytes())?;
        let support = Pin { name: Some("support".to_owned()), ..Pin::default() };
        let pins = vec![support];
        Ok(Scene { pins, ..scene("drape", self.material.clone(), Cloth::Mesh(mesh)) })
    }
}

pub(super) fn scene(name: &str, material: MaterialChoice, cloth: Cloth) -> Scene {
    Scene {
        format: crate::scene::SCENE_FORMAT.to_owned(),
        name: name.to_owned(),
        description: String::new(),
        assumed: Vec::new(),
        cloth,
        material: Some(material),
        effects: Effects {
            gravity: Some(GravitySpec { m_s2: [0.0, 0.0, -GRAVITY] }),
            ..Effects::default()
        },
        damping: DampingLaw::Full,
        pins: Vec::new(),
        obstacles: Vec::new(),
        time: TimeSpan { step_s: 0.001, duration_s: 3.0 },
    }
}
