//! Edges of a surface, and the springs that they give.

use super::obj::Face;
use crate::SpringEffect;

/// One side of a face. Sorted, the sides of one edge stand together, in the order of the faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// The edge's ends, the lower first.
    pub(super) ends: [u32; 2],
    /// Place of the face in the list.
    pub(super) face: u32,
    /// Which corner of the face the side starts from.
    corner: u8,
}

impl Side {
    /// Whether the face goes round from the lower end to the higher one.
    pub(super) fn rises(self, faces: &[Face]) -> bool {
        faces[self.face as usize].corners()[usize::from(self.corner)] == self.ends[0]
    }

    /// The corners next to the side's ends in its face, away from the side; the neighbour of the
    /// lower end first. In a triangle both are the apex.
    fn beyond(self, faces: &[Face]) -> [u32; 2] {
        let corners = faces[self.face as usize].corners();
        let (n, start) = (corners.len(), usize::from(self.corner));
        let pair = [corners[(start + n - 1) % n], corners[(start + 2) % n]];
        if self.rises(faces) { pair } else { [pair[1], pair[0]] }
    }
}

/// All sides of all faces, sorted.
pub(super) fn sides(faces: &[Face]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(4 * faces.len());
    for (place, face) in faces.iter().enumerate() {
        let corners = face.corners();
        for (corner, &from) in corners.iter().enumerate() {
            let to = corners[(corner + 1) % corners.len()];
            let ends = [from.min(to), from.max(to)];
            sides.push(Side { ends, face: place as u32, corner: corner as u8 });
        }
    }
    sides.sort_unstable();
    sides
}

/// Pairs of vertices, each with the lower first, sorted, each once.
type Pairs = Vec<[u32; 2]>;

fn sorted(mut pairs: Pairs) -> Pairs {
    pairs.iter_mut().for_each(|pair| pair.sort_unstable());
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// The ends of the springs of one effect.
pub(super) fn springs(effect: SpringEffect, faces: &[Face], sides: &[Side]) -> Pairs {
    match effect {
        SpringEffect::Tension => sorted(sides.iter().map(|side| side.ends).collect()),
        SpringEffect::Shear => {
            let diagonals = |face: &Face| match *face.corners() {
                [a, b, c, d] => vec![[a, c], [b, d]],
                _ => Vec::new(),
            };
            sorted(faces.iter().flat_map(diagonals).collect())
        }
        SpringEffect::Bending => {
            let mut bending = Vec::new();
            for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
                if let &[first, second] = edge {
                    let (a, b) = (first.beyond(faces), second.beyond(faces));
                    bending.extend([[a[0], b[0]], [a[1], b[1]]]);
                }
            }
            // Around a vertex of three edges the opposite corners are neighbours already.
            let joined = [SpringEffect::Tension, SpringEffect::Shear];
            let joined = joined.map(|effect| springs(effect, faces, sides));
            let mut bending = sorted(bending);
            bending.retain(|pair| {
                pair[0] != pair[1] && joined.iter().all(|pairs| pairs.binary_search(pair).is_err())
            });
            bending
        }
    }
}
