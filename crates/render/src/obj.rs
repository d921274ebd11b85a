//! Wavefront OBJ files.
//!
//! Numbers have as many digits as a reader of float64 needs to get the same bits. Positions are in
//! metres, and z is up, as in scenes.

use crate::{Solid, Subject};
use drape_model::Vec3;
use std::fmt::Write as _;

/// The cloth at positions `x`, m: one vertex for each particle, in the order of the specification,
/// and its triangles. A cloth without triangles has its lines instead.
pub fn cloth(subject: &Subject, x: &[Vec3]) -> String {
    let mut text = String::from("o cloth\n");
    vertices(&mut text, x);
    if subject.triangles.is_empty() {
        lines(&mut text, &subject.lines);
    } else {
        faces(&mut text, &subject.triangles, 0);
    }
    text
}

/// The obstacles, one object each; empty without obstacles.
pub fn solids(solids: &[Solid]) -> String {
    let mut text = String::new();
    let mut before = 0;
    for solid in solids {
        let _ = writeln!(text, "o {}", solid.name);
        vertices(&mut text, &solid.points);
        faces(&mut text, &solid.triangles, before);
        before += solid.points.len();
    }
    text
}

// Writing to a string cannot fail.

fn vertices(text: &mut String, x: &[Vec3]) {
    for x in x {
        let _ = writeln!(text, "v {} {} {}", x.x, x.y, x.z);
    }
}

/// Indices count from 1, over all objects of a file.
fn faces(text: &mut String, triangles: &[[u32; 3]], before: usize) {
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| i as usize + 1 + before);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
}

fn lines(text: &mut String, lines: &[[u32; 2]]) {
    for line in lines {
        let [a, b] = line.map(|i| i as usize + 1);
        let _ = writeln!(text, "l {a} {b}");
    }
}
