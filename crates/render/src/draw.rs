//! A picture of a cloth among obstacles.

use crate::surface::{area_normal, edges, normals};
use crate::{Camera, Colour, Image, Subject};
use drape_model::Vec3;
use retrofire_core::geom::{Edge, Tri, Vertex, vertex};
use retrofire_core::math::mat::viewport;
use retrofire_core::math::{Color3f, ProjVec3, pt2, rgb};
use retrofire_core::render::target::{Colorbuf, Framebuf};
use retrofire_core::render::{Context, Frag, render, shader};
use retrofire_core::util::pixfmt::Rgb888;
use retrofire_core::util::{Buf2, Dims};

/// Samples a pixel along each side.
const SAMPLES: u32 = 3;
/// Width of a margin around the picture that is cut off, in samples. Clipping at its rim may round
/// a shape across the rim.
const MARGIN: u32 = 4;

/// A colour of light, each component from 0 to 1.
type Tint = [f64; 3];

/// Colours of the two sides of the cloth. The first is the side from which its triangles run
/// counter-clockwise.
const SIDES: [Tint; 2] = [[0.36, 0.58, 0.86], [0.93, 0.70, 0.40]];
const SOLID: Tint = [0.80, 0.80, 0.83];
/// Share of the light of a surface that lines on it keep: on cloth, and on obstacles.
const ON_SURFACE: f64 = 0.76;
const ON_SOLID: f64 = 0.90;
/// Colour of the rim of the cloth and of its contour.
const OUTLINE: Tint = [0.13, 0.15, 0.20];

/// Pins: radius of the dot and of its light middle, in pixels, and their colours.
const PIN: [(f64, Tint); 2] = [(4.0, OUTLINE), (2.2, [0.97, 0.97, 0.98])];
/// Colours of groups. Those of marks are darker.
const GROUPS: [Tint; 6] = [
    [0.55, 0.72, 0.92],
    [0.95, 0.78, 0.50],
    [0.60, 0.84, 0.62],
    [0.93, 0.66, 0.70],
    [0.78, 0.70, 0.92],
    [0.80, 0.80, 0.62],
];
const MARKS: [Tint; 6] = [
    [0.80, 0.10, 0.15],
    [0.05, 0.35, 0.75],
    [0.05, 0.50, 0.20],
    [0.55, 0.15, 0.60],
    [0.75, 0.40, 0.00],
    [0.00, 0.50, 0.55],
];

/// The colours of a group and of a mark of that number. After six numbers the colours repeat.
pub fn colours(number: usize) -> [Colour; 2] {
    let displayed = |tint: Tint| Colour(tint.map(|c| (255.0 * c).round() as u8));
    [GROUPS, MARKS].map(|tints| displayed(tints[number % tints.len()]))
}

/// Radius of a mark, pixels.
const MARK: f64 = 3.0;
/// Number of corners of a dot.
const DOT: u32 = 20;

/// Obstacles are drawn farther away by this part of the distance of the scene, so that cloth on
/// them lies in front.
const BEHIND: f64 = 4e-3;
/// Lines are drawn nearer by this part of the distance of the scene.
const IN_FRONT: f64 = 3e-3;

type Corner = Vertex<ProjVec3, Color3f>;

/// The colour of the cloth at a particle, on the visible side.
fn tint(subject: &Subject, particle: u32, is_front: bool) -> Tint {
    let group = subject.groups.get(particle as usize);
    group.map_or(SIDES[usize::from(!is_front)], |group| GROUPS[group % GROUPS.len()])
}

/// Triangles and lines before rasterisation.
struct Sketch<'a> {
    camera: &'a Camera,
    /// Directions to the key light and to the fill light.
    lights: [Vec3; 2],
    corners: Vec<Corner>,
    faces: Vec<Tri<usize>>,
    lines: Vec<Edge<usize>>,
    /// Size of a sample in the picture's coordinates.
    sample: [f64; 2],
}

impl Sketch<'_> {
    /// Adds a corner and returns its index. Its distance from the eye is changed by `shift`, m.
    /// `None` where the corner cannot be drawn.
    fn corner(&mut self, point: &Vec3, shift: f64, colour: Tint) -> Option<usize> {
        let [x, y, z, w] = self.camera.project(point);
        let far = 1e4 * self.camera.distance();
        let size = x.abs() + y.abs() + w.abs();
        if size.is_nan() || size >= far {
            return None;
        }
        // One factor for all four keeps the place in the picture and changes the depth.
        let factor = if w > 0.0 { (w + shift).max(0.01 * w) / w } else { 1.0 };
        let position = [x, y, z, w].map(|c| (c * factor) as f32);
        let [r, g, b] = colour.map(|c| c.clamp(0.0, 1.0) as f32);
        self.corners.push(vertex(position.into(), rgb(r, g, b)));
        Some(self.corners.len() - 1)
    }

    /// Colour of a surface at a point. The normal points to the visible side.
    fn shade(&self, tint: Tint, point: &Vec3, normal: &Vec3) -> Tint {
        let eye = self.camera.towards_eye(point);
        let [key, fill] = self.lights.map(|light| normal.dot(&light).max(0.0));
        let facing = normal.dot(&eye).max(0.0);
        let sky = 0.5 + 0.5 * normal.z;
        let light = (0.40 + 0.12 * sky + 0.50 * key + 0.22 * fill) * (0.78 + 0.22 * facing);
        tint.map(|c| c * light + 0.05 * key * key * key * key)
    }

    fn line(&mut self, ends: [&Vec3; 2], shift: f64, colours: [Tint; 2], is_bold: bool) {
        let ends = [0, 1].map(|n| self.corner(ends[n], shift, colours[n]));
        let [Some(a), Some(b)] = ends else { return };
        self.lines.push(Edge(a, b));
        if !is_bold {
            return;
        }
        // A bold line is four thin lines side by side.
        for (right, down) in [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let [a, b] = [a, b].map(|n| {
                let Vertex { pos, attrib } = self.corners[n];
                let [x, y, z, w] = pos.0;
                let moved = |c: f32, by: f64| c + (by * f64::from(w)) as f32;
                let position =
                    [moved(x, right * self.sample[0]), moved(y, down * self.sample[1]), z, w];
                self.corners.push(vertex(position.into(), attrib));
                self.corners.len() - 1
            });
            self.lines.push(Edge(a, b));
        }
    }

    fn cloth(&mut self, subject: &Subject, x: &[Vec3]) {
        let normals = normals(x, &subject.triangles);
        let is_seen_from_front = |triangle: [u32; 3]| {
            let normal = area_normal(x, triangle);
            normal.dot(&self.camera.towards_eye(&x[triangle[0] as usize])) >= 0.0
        };
        let front: Vec<bool> = subject.triangles.iter().map(|&t| is_seen_from_front(t)).collect();
        for (&triangle, &is_front) in subject.triangles.iter().zip(&front) {
            let corners = triangle.map(|i| {
                let tint = tint(subject, i, is_front);
                // The triangle decides which side is visible. Near the contour, the normal of a
                // corner may lean away from the eye. If it were turned round, the corner would be
                // lit from behind.
                let (point, normal) = (&x[i as usize], normals[i as usize]);
                let colour = self.shade(tint, point, &if is_front { normal } else { -normal });
                self.corner(point, 0.0, colour)
            });
            if let [Some(a), Some(b), Some(c)] = corners {
                self.faces.push(Tri([a, b, c]));
            }
        }
        let nearer = -IN_FRONT * self.camera.distance();
        let edges = edges(&subject.triangles);
        for line in &subject.lines {
            let ends = line.map(|i| &x[i as usize]);
            let sides = edges.get(line).map_or(&[][..], Vec::as_slice);
            let Some(&side) = sides.first() else {
                self.line(ends, nearer, [OUTLINE; 2], true);
                continue;
            };
            let colours = line.map(|i| {
                let tint = tint(subject, i, front[side]);
                let normal = normals[i as usize];
                let normal = if front[side] { normal } else { -normal };
                let shade = self.shade(tint, &x[i as usize], &normal);
                shade.map(|c| c * ON_SURFACE)
            });
            self.line(ends, nearer, colours, false);
        }
        // The rim, and where the cloth turns from one side to the other.
        for (edge, sides) in &edges {
            let is_outline = match sides[..] {
                [one, other] => front[one] != front[other],
                _ => true,
            };
            if is_outline {
                self.line(edge.map(|i| &x[i as usize]), nearer, [OUTLINE; 2], true);
            }
        }
    }

    fn solids(&mut self, subject: &Subject) {
        let behind = BEHIND * self.camera.distance();
        for solid in &subject.solids {
            let exact = (&solid.points, &solid.triangles);
            let (x, triangles) = solid.softened.as_ref().map_or(exact, |(x, t)| (x, t));
            let normals = normals(x, triangles);
            for &triangle in triangles {
                let seen = area_normal(x, triangle);
                let is_front = seen.dot(&self.camera.towards_eye(&x[triangle[0] as usize])) >= 0.0;
                let corners = triangle.map(|i| {
                    let normal = normals[i as usize];
                    let normal = if is_front { normal } else { -normal };
                    let colour = self.shade(SOLID, &x[i as usize], &normal);
                    self.corner(&x[i as usize], behind, colour)
                });
                if let [Some(a), Some(b), Some(c)] = corners {
                    self.faces.push(Tri([a, b, c]));
                }
            }
            if solid.softened.is_none() {
                let shift = behind - IN_FRONT * self.camera.distance();
                for line in &solid.lines {
                    let ends = line.map(|i| &solid.points[i as usize]);
                    self.line(ends, shift, [SOLID.map(|c| c * ON_SOLID); 2], false);
                }
            }
        }
    }
}

impl Sketch<'_> {
    /// The ground, with the shadow of the cloth and the obstacles.
    fn ground(&mut self, subject: &Subject, x: &[Vec3]) {
        let Some(ground) = subject.ground.filter(|ground| self.camera.is_above(ground.height()))
        else {
            return;
        };
        let cloth = subject.triangles.iter().map(|t| t.map(|i| &x[i as usize]));
        let solids = subject.solids.iter().filter(|solid| !solid.is_endless);
        let solids = solids
            .flat_map(|solid| solid.triangles.iter().map(|t| t.map(|i| &solid.points[i as usize])));
        let lines = subject.lines.iter().map(|line| line.map(|i| &x[i as usize]));
        let shadow = ground.shadow(cloth.chain(solids), lines);
        let side = shadow.points.len().isqrt() as u32;
        let background = Colour::BACKGROUND.0.map(|c| f64::from(c) / 255.0);
        let behind = BEHIND * self.camera.distance();
        let corners: Vec<_> = shadow
            .points
            .iter()
            .zip(&shadow.light)
            .map(|(point, light)| self.corner(point, behind, background.map(|c| c * light)))
            .collect();
        for triangle in crate::subject::grid(side, side).0 {
            if let [Some(a), Some(b), Some(c)] = triangle.map(|i| corners[i as usize]) {
                self.faces.push(Tri([a, b, c]));
            }
        }
    }

    /// Marks and pins, as dots that face the eye; pins lie above marks.
    fn dots(&mut self, subject: &Subject, x: &[Vec3]) {
        let nearer = -IN_FRONT * self.camera.distance();
        for &(i, number) in &subject.marks {
            let tint = MARKS[number % MARKS.len()];
            self.dot(&x[i as usize], 1.5 * nearer, MARK, tint);
        }
        for &i in &subject.pins {
            for (shift, (radius, tint)) in (2..).zip(PIN) {
                self.dot(&x[i as usize], f64::from(shift) * nearer, radius, tint);
            }
        }
    }

    /// A dot of a radius in pixels.
    fn dot(&mut self, point: &Vec3, shift: f64, radius: f64, tint: Tint) {
        let Some(middle) = self.corner(point, shift, tint) else { return };
        let Vertex { pos, attrib } = self.corners[middle];
        let [x, y, z, w] = pos.0;
        let first = self.corners.len();
        for n in 0..DOT {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(n) / f64::from(DOT));
            let reach = radius * f64::from(SAMPLES) * f64::from(w);
            let moved =
                |c: f32, part: f64, axis: usize| c + (part * reach * self.sample[axis]) as f32;
            let position = [moved(x, cos, 0), moved(y, sin, 1), z, w];
            self.corners.push(vertex(position.into(), attrib));
        }
        let dot = DOT as usize;
        let rim = |n: usize| first + n % dot;
        self.faces.extend((0..dot).map(|n| Tri([middle, rim(n), rim(n + 1)])));
    }
}

/// Draws a cloth with its obstacles, its pins and the ground. `x` are the positions, m, one for
/// each particle in the order of the subject. `size` is the width and the height of the picture,
/// pixels. Leaves out particles that are not finite or far out of the scene.
///
/// # Panics
/// If the subject's triangles, lines, marks or pins name a particle that has no position in `x`, or
/// if a side of the picture is 0.
pub fn draw(subject: &Subject, x: &[Vec3], camera: &Camera, size: [u32; 2]) -> Image {
    let inner = size.map(|side| side * SAMPLES);
    let mut sketch = Sketch {
        camera,
        lights: camera.lights(),
        corners: Vec::new(),
        faces: Vec::new(),
        lines: Vec::new(),
        sample: inner.map(|side| 2.0 / f64::from(side)),
    };
    sketch.ground(subject, x);
    sketch.solids(subject);
    sketch.cloth(subject, x);
    sketch.dots(subject, x);
    let Sketch { corners, faces, lines, .. } = sketch;

    let dims = Dims(inner[0] + 2 * MARGIN, inner[1] + 2 * MARGIN);
    let background = Colour::BACKGROUND.0;
    let mut target = Framebuf {
        color_buf: Colorbuf { buf: Buf2::new_with(dims, |_, _| background), fmt: Rgb888 },
        // Depths are reciprocals of distances, so 0 is infinitely far away.
        depth_buf: Buf2::new_with(dims, |_, _| 0.0_f32),
    };
    let shader = shader::new(
        |corner: Corner, (): ()| corner,
        |fragment: Frag<Color3f>, (): ()| fragment.var.to_color4(),
    );
    let context = Context { face_cull: None, ..Context::default() };
    let window = viewport(pt2(MARGIN, MARGIN)..pt2(MARGIN + inner[0], MARGIN + inner[1]));
    render(&faces, &corners, &shader, (), window, &mut target, &context);
    render(&lines, &corners, &shader, (), window, &mut target, &context);
    let samples = target.color_buf.buf.data();
    Image::averaged(size, SAMPLES, |x, y| samples[((y + MARGIN) * dims.0 + x + MARGIN) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::View;

    /// A dome whose contour lies between its points: near it some normals lean away from the eye.
    #[test]
    fn beside_the_contour_no_corner_of_a_triangle_is_lit_from_the_other_side() {
        const SIDE: u32 = 14;
        let at = |n: u32| 2.0 * f64::from(n) / f64::from(SIDE - 1) - 1.0;
        let places = (0..SIDE * SIDE).map(|n| (at(n % SIDE), at(n / SIDE)));
        let x: Vec<Vec3> = places.map(|(x, y)| Vec3::new(x, y, -0.4 * (x * x + y * y))).collect();
        let subject = Subject::grid(SIDE, SIDE, &[], &x);
        for view in ["auto", "front", "20,-10"] {
            let camera = Camera::fit(view.parse::<View>().expect("a view"), &x, 1.0);
            let mut sketch = Sketch {
                camera: &camera,
                lights: camera.lights(),
                corners: Vec::new(),
                faces: Vec::new(),
                lines: Vec::new(),
                sample: [0.01; 2],
            };
            sketch.cloth(&subject, &x);
            assert_eq!(sketch.faces.len(), subject.triangles.len());
            for Tri(corners) in &sketch.faces {
                let blue = corners.map(|i| sketch.corners[i].attrib.b());
                let [low, high] = [f32::min, f32::max].map(|f| blue.into_iter().fold(blue[0], f));
                assert!(low > 0.6 * high, "{view}: {low} beside {high}");
            }
        }
    }
}
