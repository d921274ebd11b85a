//! Makes the OBJ files of the bundled scenes: `cargo run -p drape-model --example meshes` in the
//! folder of the workspace.

use std::fmt::Write;

/// Text of an OBJ file in the making.
struct Obj {
    text: String,
    vertices: usize,
}

impl Obj {
    fn new(about: &str) -> Self {
        Self { text: format!("# {about}\n"), vertices: 0 }
    }

    /// Adds a vertex, to a micrometre; returns its number, from 1.
    fn vertex(&mut self, x: f64, y: f64, z: f64) -> usize {
        let rounded = |v: f64| (v * 1e6).round() / 1e6 + 0.0;
        self.line(&format!("v {} {} {}", rounded(x), rounded(y), rounded(z)));
        self.vertices += 1;
        self.vertices
    }

    fn face(&mut self, corners: &[usize]) {
        let corners: Vec<_> = corners.iter().map(ToString::to_string).collect();
        self.line(&format!("f {}", corners.join(" ")));
    }

    fn line(&mut self, line: &str) {
        let _ = writeln!(self.text, "{line}");
    }
}

/// A point at an angle given as a part of the full turn.
fn on_circle(radius: f64, part: f64) -> (f64, f64) {
    let angle = 2.0 * std::f64::consts::PI * part;
    (radius * libm::cos(angle), radius * libm::sin(angle))
}

/// A plane sheet of quads in the plane z = 0: 1.5 m along x, 1 m along y, 30 × 20 cells.
fn sheet() -> String {
    let (columns, rows) = (30, 20);
    let mut obj = Obj::new("A sheet of 1.5 m by 1 m in the plane z = 0, quads of 5 cm");
    for row in 0..=rows {
        for column in 0..=columns {
            obj.vertex(0.05 * f64::from(column) - 0.75, 0.05 * f64::from(row) - 0.5, 0.0);
        }
    }
    let at = |row: usize, column: usize| row * (columns as usize + 1) + column + 1;
    for row in 0..rows as usize {
        for column in 0..columns as usize {
            let (near, far) = (at(row, column), at(row + 1, column));
            obj.face(&[near, near + 1, far + 1, far]);
        }
    }
    obj.text
}

/// A plane disc of 30 cm in diameter, triangles between rings of 1 cm; the faces within 9 cm are
/// the group `support`, the rest `overhang`.
fn round_cloth() -> String {
    let rings = 15;
    let mut obj =
        Obj::new("A disc of 30 cm across, rings of triangles of 1 cm; support: the inner 18 cm");
    let mut first = vec![obj.vertex(0.0, 0.0, 0.0)];
    for ring in 1..=rings {
        let count = 6 * ring;
        for k in 0..count {
            let (x, y) = on_circle(0.01 * ring as f64, k as f64 / count as f64);
            let vertex = obj.vertex(x, y, 0.0);
            if k == 0 {
                first.push(vertex);
            }
        }
    }
    for ring in 1..=rings {
        match ring {
            1 => obj.line("g support"),
            10 => obj.line("g overhang"),
            _ => {}
        }
        let (inner, outer) = (6 * (ring - 1), 6 * ring);
        let within = |k: usize| first[ring - 1] + if inner == 0 { 0 } else { k % inner };
        let without = |k: usize| first[ring] + k % outer;
        for sector in 0..6 {
            for k in 0..ring {
                let (a, b) = (sector * (ring - 1) + k, sector * ring + k);
                obj.face(&[without(b), without(b + 1), within(a)]);
                if k + 1 < ring {
                    obj.face(&[within(a), without(b + 1), within(a + 1)]);
                }
            }
        }
    }
    obj.text
}

/// A skirt, cut as a cone from a waist of 12 cm radius at z = 0 to a hem of 28 cm radius at z =
/// −0.5 m, triangles with alternating diagonals; the uppermost row of faces is the group
/// `waistband`, the rest `panel`.
fn skirt() -> String {
    let (around, rows) = (48, 20);
    let mut obj = Obj::new(
        "A skirt: a cone of triangles, 0.5 m high, hem of 28 cm radius; waist of 12 cm radius",
    );
    for row in 0..=rows {
        let down = row as f64 / rows as f64;
        for k in 0..around {
            let (x, y) = on_circle(0.12 + 0.16 * down, k as f64 / around as f64);
            obj.vertex(x, y, -0.5 * down);
        }
    }
    obj.line("g waistband");
    for row in 0..rows {
        if row == 1 {
            obj.line("g panel");
        }
        let at = |row: usize, k: usize| row * around + k % around + 1;
        for k in 0..around {
            let [a, b] = [at(row, k), at(row, k + 1)];
            let [c, d] = [at(row + 1, k), at(row + 1, k + 1)];
            if (row + k) % 2 == 0 {
                obj.face(&[a, c, d]);
                obj.face(&[a, d, b]);
            } else {
                obj.face(&[a, c, b]);
                obj.face(&[b, c, d]);
            }
        }
    }
    obj.text
}

/// Name and text of every bundled mesh.
pub(crate) fn all() -> [(&'static str, String); 3] {
    [("round-cloth.obj", round_cloth()), ("sheet.obj", sheet()), ("skirt.obj", skirt())]
}

#[allow(dead_code, reason = "the test of the bundled meshes includes this file")]
fn main() -> std::io::Result<()> {
    for (name, text) in all() {
        std::fs::write(format!("crates/model/scenes/{name}"), text)?;
    }
    Ok(())
}
