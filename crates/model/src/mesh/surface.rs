//! Checks and repairs of the faces of a file.

use super::edges::{Side, sides};
use super::obj::{Face, Obj, place};
use crate::Vec3;
use crate::error::Violation;
use std::collections::BTreeMap;
use std::ops::Range;

/// Area over squared longest edge below which a face counts as degenerate.
const DEGENERATE: f64 = 1e-12;

/// A surface with one or two faces at each edge, all oriented alike.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surface {
    pub(super) vertices: Vec<Vec3>,
    pub(super) faces: Vec<Face>,
    pub(super) sides: Vec<Side>,
    names: BTreeMap<String, Vec<Range<u32>>>,
    /// Direction of the warp in each face of the file, by number; empty if it says nothing.
    pub(super) warps: Vec<Option<Vec3>>,
    /// The repairs, in words.
    pub(super) repairs: Vec<String>,
}

/// Area of a face, m². For a quad that is not plane, the area of its projection along its mean
/// normal.
pub(super) fn area(vertices: &[Vec3], corners: &[u32]) -> f64 {
    let at = |k: usize| vertices[corners[k] as usize];
    let last = corners.len() - 1;
    // The diagonals of a quad, two edges of a triangle.
    let (a, b) = (at(2) - at(0), at(last) - at(1));
    0.5 * a.cross(&b).norm()
}

fn is_degenerate(vertices: &[Vec3], corners: &[u32]) -> bool {
    let edge = |k: usize| {
        let next = corners[(k + 1) % corners.len()] as usize;
        (vertices[next] - vertices[corners[k] as usize]).norm_squared()
    };
    let lengths = || (0..corners.len()).map(edge);
    let longest = lengths().fold(0.0, f64::max);
    lengths().any(|length| length == 0.0) || area(vertices, corners) <= DEGENERATE * longest
}

struct Check<'a> {
    file: &'a str,
    repair: bool,
    repairs: Vec<String>,
}

impl Surface {
    /// Checks a file's faces; with `repair`, mends them if possible.
    pub(super) fn new(file: &str, obj: Obj, repair: bool) -> Result<Self, Violation> {
        let mut check = Check { file, repair, repairs: Vec::new() };
        let mut vertices: Vec<Vec3> = obj.vertices.iter().copied().map(Vec3::from).collect();
        let warps = super::warp::warps(&vertices, &obj);
        let Obj { lines, faces, names, .. } = obj;
        let mut faces = check.degenerate(&vertices, faces)?;
        check.doubled(&mut faces)?;
        let mut sides = sides(&faces);
        check.manifold(&faces, &sides)?;
        if check.orient(&mut faces, &sides)? {
            sides = super::edges::sides(&faces);
        }
        if check.unused(&mut vertices, &mut faces, &lines)? {
            sides = super::edges::sides(&faces);
        }
        if faces.is_empty() {
            let expected = "at least one face that is not degenerate";
            return Err(Violation::new("cloth.mesh.file", "without a face", expected));
        }
        Ok(Self { vertices, faces, sides, names, warps, repairs: check.repairs })
    }

    /// The vertices of the faces under a name of a group or object, sorted; an error lists the
    /// names.
    pub(super) fn named(&self, name: &str) -> Result<Vec<u32>, String> {
        let Some(stretches) = self.names.get(name) else {
            let known: Vec<_> = self.names.keys().take(8).map(String::as_str).collect();
            return Err(match known.as_slice() {
                [] => "another selection: the file names no group or object".to_owned(),
                known => format!("one of the file's groups and objects: {}", known.join(", ")),
            });
        };
        let is_in = |face: &&Face| {
            let after = stretches.partition_point(|stretch| stretch.start <= face.number);
            after > 0 && stretches[after - 1].contains(&face.number)
        };
        let named = self.faces.iter().filter(is_in).flat_map(|face| face.corners().iter().copied());
        let mut named: Vec<_> = named.collect();
        named.sort_unstable();
        named.dedup();
        if named.is_empty() {
            return Err("a name with faces: `repair` dropped all that this one had".to_owned());
        }
        Ok(named)
    }

    /// The faces as triangles: a quad is cut along its shorter diagonal.
    pub(super) fn triangles(&self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for face in &self.faces {
            match *face.corners() {
                [a, b, c, d] => {
                    let length = |i: u32, j: u32| {
                        (self.vertices[i as usize] - self.vertices[j as usize]).norm_squared()
                    };
                    if length(a, c) <= length(b, d) {
                        triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        triangles.extend([[a, b, d], [b, c, d]]);
                    }
                }
                [a, b, c] => triangles.push([a, b, c]),
                _ => {}
            }
        }
        triangles
    }
}

impl Check<'_> {
    fn refuse(&self, face: &Face, found: String, expected: &str) -> Violation {
        let path = format!("{} (face {})", place(self.file, face.line), face.number + 1);
        Violation::new(path, found, expected)
    }

    fn mended(&mut self, count: usize, what: &str) {
        if count > 0 {
            self.repairs.push(format!("{count} {what}"));
        }
    }

    /// Drops faces without an area. A quad that repeats a corner in a row becomes a triangle.
    fn degenerate(&mut self, vertices: &[Vec3], faces: Vec<Face>) -> Result<Vec<Face>, Violation> {
        let mut kept = Vec::with_capacity(faces.len());
        let (mut cut, mut dropped) = (0, 0);
        for face in faces {
            let corners = face.corners();
            let repeated = (1..corners.len()).find(|&k| corners[..k].contains(&corners[k]));
            if repeated.is_none() && !is_degenerate(vertices, corners) {
                kept.push(face);
                continue;
            }
            if !self.repair {
                let found = match repeated {
                    Some(k) => format!("a face that has corner {} twice", corners[k] + 1),
                    None => "a face without area, or with an edge without length".to_owned(),
                };
                let expected = "distinct corners that span an area (`repair` drops such faces)";
                return Err(self.refuse(&face, found, expected));
            }
            let mut corners = corners.to_vec();
            corners.dedup();
            if corners.len() > 1 && corners.first() == corners.last() {
                corners.pop();
            }
            let is_distinct = (1..corners.len()).all(|k| !corners[..k].contains(&corners[k]));
            if is_distinct && corners.len() == 3 && !is_degenerate(vertices, &corners) {
                kept.push(face.with(&corners));
                cut += 1;
            } else {
                dropped += 1;
            }
        }
        self.mended(cut, "quads with a doubled corner read as triangles");
        self.mended(dropped, "degenerate faces dropped");
        Ok(kept)
    }

    /// Drops every face that has the corners of one before it.
    fn doubled(&mut self, faces: &mut Vec<Face>) -> Result<(), Violation> {
        let mut keys: Vec<_> = faces.iter().map(|face| (face.sorted(), face.number)).collect();
        keys.sort_unstable();
        let mut doubles = Vec::new();
        for same in keys.chunk_by(|a, b| a.0 == b.0) {
            doubles.extend(same[1..].iter().map(|&(_, number)| (number, same[0].1)));
        }
        doubles.sort_unstable();
        if let (Some(&(second, first)), false) = (doubles.first(), self.repair) {
            let found = format!("a face with the corners of face {}", first + 1);
            let expected = "each face once (`repair` drops the later one)";
            let face = faces.iter().find(|face| face.number == second);
            return Err(self.refuse(face.unwrap_or(&faces[0]), found, expected));
        }
        faces.retain(|f| doubles.binary_search_by_key(&f.number, |&(number, _)| number).is_err());
        self.mended(doubles.len(), "doubled faces dropped");
        Ok(())
    }

    fn manifold(&self, faces: &[Face], sides: &[Side]) -> Result<(), Violation> {
        for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
            if edge.len() > 2 {
                let [a, b] = edge[0].ends;
                let found = format!("face {} at the edge {}-{}", edge.len(), a + 1, b + 1);
                let face = &faces[edge[2].face as usize];
                return Err(self.refuse(face, found, "at most two faces at an edge"));
            }
        }
        Ok(())
    }

    /// Turns faces over so that neighbours go through their edge in opposite directions. Returns
    /// whether that was necessary.
    fn orient(&mut self, faces: &mut [Face], sides: &[Side]) -> Result<bool, Violation> {
        // Neighbours of each face over its edges, and whether the two are oriented alike.
        let mut links: Vec<(u32, u32, bool)> = Vec::new();
        for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
            if let &[a, b] = edge {
                let alike = a.rises(faces) != b.rises(faces);
                links.extend([(a.face, b.face, alike), (b.face, a.face, alike)]);
            }
        }
        let Some(&(_, second, _)) = links.iter().find(|link| !link.2) else { return Ok(false) };
        if !self.repair {
            let found = "a face turned the other way than its neighbour".to_owned();
            let expected = "one orientation of all faces (`repair` turns faces over)";
            return Err(self.refuse(&faces[second as usize], found, expected));
        }
        links.sort_unstable();
        let mut turned: Vec<Option<bool>> = vec![None; faces.len()];
        let mut open = Vec::new();
        for start in 0..faces.len() {
            if turned[start].is_none() {
                turned[start] = Some(false);
                open.push(start as u32);
            }
            while let Some(face) = open.pop() {
                let own = turned[face as usize] == Some(true);
                let first = links.partition_point(|link| link.0 < face);
                for &(_, other, alike) in links[first..].iter().take_while(|link| link.0 == face) {
                    let needed = own == alike;
                    match turned[other as usize] {
                        None => {
                            turned[other as usize] = Some(needed);
                            open.push(other);
                        }
                        Some(found) if found != needed => {
                            let found = "part of a surface with one side only".to_owned();
                            let expected = "a surface with two sides";
                            return Err(self.refuse(&faces[other as usize], found, expected));
                        }
                        Some(_) => {}
                    }
                }
            }
        }
        let mut count = 0;
        for (face, turned) in faces.iter_mut().zip(turned) {
            if turned == Some(true) {
                let mut corners = face.corners().to_vec();
                corners[1..].reverse();
                *face = face.with(&corners);
                count += 1;
            }
        }
        self.mended(count, "faces turned over");
        Ok(true)
    }

    /// Drops vertices without a face and renumbers the others in the same order. Returns whether
    /// that was necessary.
    fn unused(
        &mut self,
        vertices: &mut Vec<Vec3>,
        faces: &mut [Face],
        lines: &[u32],
    ) -> Result<bool, Violation> {
        let mut is_used = vec![false; vertices.len()];
        faces.iter().flat_map(Face::corners).for_each(|&corner| is_used[corner as usize] = true);
        let Some(first) = is_used.iter().position(|&used| !used) else { return Ok(false) };
        if !self.repair {
            let found = format!("vertex {}, which belongs to no face", first + 1);
            let expected = "vertices with faces (`repair` drops the others)";
            return Err(Violation::new(place(self.file, lines[first]), found, expected));
        }
        let mut next = 0;
        let numbers: Vec<u32> = is_used
            .iter()
            .map(|&used| {
                next += u32::from(used);
                next.saturating_sub(1)
            })
            .collect();
        for face in faces {
            let corners: Vec<_> =
                face.corners().iter().map(|&corner| numbers[corner as usize]).collect();
            *face = face.with(&corners);
        }
        let before = vertices.len();
        let mut used = is_used.iter();
        vertices.retain(|_| used.next() == Some(&true));
        self.mended(before - vertices.len(), "vertices without a face dropped");
        Ok(true)
    }
}
