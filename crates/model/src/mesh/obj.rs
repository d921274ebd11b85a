//! Reading the polygons of a Wavefront OBJ file, line by line and within fixed bounds of memory.
//!
//! The reader takes `v`, `f`, `g` and `o`, and `vt`, which says where the warp is. It skips
//! normals, materials, smoothing, lines and points (`vn`, `usemtl`, `mtllib`, `s`, `l`, `p`), which
//! do not describe the cloth, and refuses everything else. It refuses a broken texture coordinate
//! only if the coordinate is needed. The vertices keep the file's order, also across groups, so a
//! seam that two groups share stays one seam.

use crate::bounds::number;
use crate::bounds::{MAX_COORDINATE, MAX_PARTICLES};
use crate::error::{Violation, shorten};
use std::collections::BTreeMap;
use std::io::{BufRead, Read};
use std::ops::Range;

/// Most bytes in a line.
const MAX_LINE: usize = 64 * 1024;
/// Most faces: twice as many as vertices, as a closed surface of triangles has.
const MAX_FACES: usize = 2 * MAX_PARTICLES;
/// Most texture coordinates; further ones are not used.
const MAX_TEXTURES: usize = 4 * MAX_PARTICLES;
/// Most names of groups and objects.
const MAX_NAMES: usize = 65_536;
/// Most bytes in a name.
const MAX_NAME: usize = 256;
/// Most changes of the name of the faces that follow.
const MAX_STRETCHES: usize = 1_000_000;

/// Fourth corner of a triangle.
const NONE: u32 = u32::MAX;

/// A triangle or quad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Face {
    corners: [u32; 4],
    /// Place among the faces of the file, from 0.
    pub(super) number: u32,
    /// Line of the file, from 1.
    pub(super) line: u32,
}

impl Face {
    /// Three or four vertices.
    pub(super) fn corners(&self) -> &[u32] {
        &self.corners[..if self.corners[3] == NONE { 3 } else { 4 }]
    }

    /// The corners in ascending order, alike for faces with the same ones.
    pub(super) fn sorted(&self) -> [u32; 4] {
        let mut sorted = self.corners;
        sorted.sort_unstable();
        sorted
    }

    /// The same face with other corners, three or four.
    pub(super) fn with(self, corners: &[u32]) -> Self {
        let mut all = [NONE; 4];
        all[..corners.len()].copy_from_slice(corners);
        Self { corners: all, ..self }
    }
}

/// The polygons of a file.
#[derive(Debug, Default)]
pub(super) struct Obj {
    pub(super) vertices: Vec<[f64; 3]>,
    /// Line of each vertex, from 1.
    pub(super) lines: Vec<u32>,
    pub(super) faces: Vec<Face>,
    /// Texture coordinates; not numbers where the file has none.
    pub(super) textures: Vec<[f64; 2]>,
    /// Texture of each face's corners; empty if the file has none.
    pub(super) face_textures: Vec<[u32; 4]>,
    /// Stretches of the file's faces, by number, under each name of a group or object.
    pub(super) names: BTreeMap<String, Vec<Range<u32>>>,
}

/// A line of the file, as messages name it.
pub(super) fn place(file: &str, line: u32) -> String {
    format!("cloth.mesh.file, {} line {line}", shorten(file))
}

struct Scan<'a> {
    file: &'a str,
    line: u32,
    obj: Obj,
    /// Names of the faces that follow: the object, then the groups.
    current: Vec<String>,
    /// Number of the first face under these names.
    since: u32,
    stretches: usize,
}

/// Reads a file, which messages call `file`.
pub(super) fn read(file: &str, mut reader: impl BufRead) -> Result<Obj, Violation> {
    let (obj, current) = (Obj::default(), Vec::new());
    let mut scan = Scan { file, line: 0, obj, current, since: 0, stretches: 0 };
    let mut line = Vec::new();
    loop {
        line.clear();
        scan.line = scan.line.saturating_add(1);
        // One byte more than a line may have: enough to notice a longer line without reading all of
        // it.
        let bounded = reader.by_ref().take(MAX_LINE as u64 + 1).read_until(b'\n', &mut line);
        match bounded {
            Err(error) => {
                let found = format!("not readable: {error}");
                return Err(scan.refuse(found, "a file that can be read to its end"));
            }
            Ok(0) => break,
            Ok(_) if line.len() > MAX_LINE => {
                let expected = format!("lines of at most {MAX_LINE} bytes");
                return Err(scan.refuse("a longer line", expected));
            }
            Ok(_) => scan.statement(&line)?,
        }
    }
    scan.finish()
}

impl Scan<'_> {
    fn refuse(&self, found: impl ToString, expected: impl Into<String>) -> Violation {
        Violation::new(place(self.file, self.line), found, expected)
    }

    fn statement(&mut self, line: &[u8]) -> Result<(), Violation> {
        let line = line.strip_prefix(b"\xef\xbb\xbf").filter(|_| self.line == 1).unwrap_or(line);
        if line.trim_ascii_start().first() == Some(&b'#') {
            return Ok(());
        }
        let Ok(text) = str::from_utf8(line) else {
            let found = format!("{:?}", String::from_utf8_lossy(line));
            return Err(self.refuse(found, "the text of an OBJ file, in UTF-8"));
        };
        let text = text.split('#').next().unwrap_or_default();
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("vt") => {
                self.texture(words);
                Ok(())
            }
            None | Some("vn" | "usemtl" | "mtllib" | "s" | "l" | "p") => Ok(()),
            Some("v") => self.vertex(words),
            Some("f") => self.face(words),
            Some("o") => {
                let name = words.collect::<Vec<_>>().join(" ");
                self.rename(vec![name])
            }
            Some("g") => self.rename(words.map(str::to_owned).collect()),
            Some(_) => {
                let expected = "one of v, vt, vn, f, g, o, s, usemtl, mtllib, l, p, or a comment #";
                Err(self.refuse(format!("{:?}", shorten(text)), expected))
            }
        }
    }

    /// Coordinates; a weight or a colour that follows is not used.
    fn vertex<'t>(&mut self, words: impl Iterator<Item = &'t str>) -> Result<(), Violation> {
        let mut vertex = [0.0; 3];
        let mut count = 0;
        for word in words {
            let value = word.parse::<f64>().ok().filter(|value| value.abs() <= MAX_COORDINATE);
            let Some(value) = value else {
                let most = number(MAX_COORDINATE);
                let expected = format!("a coordinate from -{most} to {most}");
                return Err(self.refuse(format!("{word:?}"), expected));
            };
            if let Some(coordinate) = vertex.get_mut(count) {
                *coordinate = value;
            }
            count += 1;
        }
        // x y z, then nothing, a weight, a colour, or both.
        if !matches!(count, 3 | 4 | 6 | 7) {
            return Err(self.refuse(format!("a vertex of {count} numbers"), "three coordinates"));
        }
        if self.obj.vertices.len() == MAX_PARTICLES {
            let expected = format!("at most {MAX_PARTICLES} vertices");
            return Err(self.refuse("one vertex more", expected));
        }
        self.obj.vertices.push(vertex);
        self.obj.lines.push(self.line);
        Ok(())
    }

    /// The first two coordinates of a texture.
    fn texture<'t>(&mut self, mut words: impl Iterator<Item = &'t str>) {
        let mut next =
            || words.next().and_then(|word| word.parse::<f64>().ok()).unwrap_or(f64::NAN);
        let texture = [next(), next()];
        if self.obj.textures.len() < MAX_TEXTURES {
            self.obj.textures.push(texture);
        }
    }

    /// The texture of a corner, whose index `finish` need not check.
    fn corner_texture(&self, word: &str) -> u32 {
        let index = word.split('/').nth(1).and_then(|part| part.parse::<i64>().ok()).unwrap_or(0);
        let known = self.obj.textures.len() as i64;
        let place = if index < 0 { known + index } else { index - 1 };
        u32::try_from(place).unwrap_or(NONE)
    }

    fn face<'t>(&mut self, words: impl Iterator<Item = &'t str>) -> Result<(), Violation> {
        let (mut corners, mut textures) = ([NONE; 4], [NONE; 4]);
        let mut count = 0;
        for word in words {
            let corner = self.corner(word)?;
            if let Some(place) = corners.get_mut(count) {
                *place = corner;
                textures[count] = self.corner_texture(word);
            }
            count += 1;
        }
        if !matches!(count, 3 | 4) {
            let expected = "a triangle or a quad: cut larger polygons before the export";
            return Err(self.refuse(format!("a face of {count} corners"), expected));
        }
        if self.obj.faces.len() == MAX_FACES {
            return Err(self.refuse("one face more", format!("at most {MAX_FACES} faces")));
        }
        let number = self.obj.faces.len() as u32;
        if textures[0] != NONE || !self.obj.face_textures.is_empty() {
            self.obj.face_textures.resize(self.obj.faces.len(), [NONE; 4]);
            self.obj.face_textures.push(textures);
        }
        self.obj.faces.push(Face { corners, number, line: self.line });
        Ok(())
    }

    /// Index of a corner, from 0. `finish` checks that the vertex exists.
    fn corner(&self, word: &str) -> Result<u32, Violation> {
        let mut parts = word.split('/');
        let index = parts.next().and_then(|part| part.parse::<i64>().ok());
        let is_reference = |part: &str| part.is_empty() || part.parse::<i64>().is_ok();
        let rest = parts.by_ref().take(2).all(is_reference) && parts.next().is_none();
        let Some(index) = index.filter(|_| rest) else {
            let expected = "a corner: v, v/vt, v//vn or v/vt/vn in whole numbers";
            return Err(self.refuse(format!("{word:?}"), expected));
        };
        let known = self.obj.vertices.len();
        let place = match index {
            0 => None,
            1.. => usize::try_from(index - 1).ok().filter(|&place| place < MAX_PARTICLES),
            _ => {
                usize::try_from(index.unsigned_abs()).ok().and_then(|back| known.checked_sub(back))
            }
        };
        let expected = "1 and up, or -1 and down from the last vertex before the face";
        match place {
            Some(place) => Ok(place as u32),
            None => Err(self.refuse(format!("vertex {index}, of {known} so far"), expected)),
        }
    }

    /// Sets the names of the faces that follow.
    fn rename(&mut self, names: Vec<String>) -> Result<(), Violation> {
        self.close()?;
        for name in &names {
            if name.len() > MAX_NAME {
                let expected = format!("at most {MAX_NAME} bytes");
                return Err(self.refuse(format!("a name of {} bytes", name.len()), expected));
            }
        }
        self.current = names;
        self.current.sort();
        self.current.dedup();
        Ok(())
    }

    /// Ends the stretch of faces under the current names.
    fn close(&mut self) -> Result<(), Violation> {
        let stretch = self.since..self.obj.faces.len() as u32;
        self.since = stretch.end;
        if stretch.is_empty() {
            return Ok(());
        }
        for name in std::mem::take(&mut self.current) {
            self.stretches += 1;
            if self.stretches > MAX_STRETCHES {
                let expected = format!("at most {MAX_STRETCHES} stretches of named faces");
                return Err(self.refuse("one stretch more", expected));
            }
            self.obj.names.entry(name).or_default().push(stretch.clone());
        }
        if self.obj.names.len() > MAX_NAMES {
            return Err(self.refuse("one name more", format!("at most {MAX_NAMES} names")));
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Obj, Violation> {
        self.close()?;
        let (path, count) = ("cloth.mesh.file", self.obj.vertices.len());
        if self.obj.faces.is_empty() {
            let found = format!("{:?}, with {count} vertices and no face", shorten(self.file));
            return Err(Violation::new(path, found, "an OBJ file with triangles or quads"));
        }
        for face in &self.obj.faces {
            if let Some(corner) = face.corners().iter().find(|&&c| c as usize >= count) {
                let found = format!("vertex {}", corner + 1);
                let expected = match count {
                    0 => "a vertex of the file, which has none".to_owned(),
                    _ => format!("1 to {count}, the number of vertices"),
                };
                return Err(Violation::new(place(self.file, face.line), found, expected));
            }
        }
        Ok(self.obj)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn places_count_up_from_the_first_or_down_from_the_last() {
        let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
        for face in ["f 1/1 2/2 3/3", "f -3/-3 -2/-2 -1/-1"] {
            let obj = read("a.obj", format!("{points}{face}\n").as_bytes()).unwrap();
            assert_eq!(obj.faces[0].corners(), [0, 1, 2], "{face}");
            assert_eq!(obj.face_textures[0][..3], [0, 1, 2], "{face}");
        }
    }
}
