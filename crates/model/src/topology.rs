//! Edges that triangles of a cloth share.

/// An edge that exactly two triangles share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InteriorEdge {
    /// Its ends, the lower one first.
    pub(crate) ends: [u32; 2],
    /// The third corners of the two triangles, in the order of the triangles.
    pub(crate) opposite: [u32; 2],
}

/// The interior edges of a list of triangles, by rising ends. Edges with one triangle or more than
/// two are left out. So is the edge of a triangle with its own copy: they have no angle.
pub(crate) fn interior_edges(triangles: &[[u32; 3]]) -> Vec<InteriorEdge> {
    let sides = |&[a, b, c]: &[u32; 3]| [(b, c, a), (c, a, b), (a, b, c)];
    let mut sides: Vec<_> = triangles
        .iter()
        .flat_map(sides)
        .filter(|(a, b, _)| a != b)
        .map(|(a, b, opposite)| ([a.min(b), a.max(b)], opposite))
        .collect();
    sides.sort_by_key(|(ends, _)| *ends);
    let shared = sides.chunk_by(|(a, _), (b, _)| a == b).filter_map(|sides| match *sides {
        [(ends, k), (_, l)] if k != l => Some(InteriorEdge { ends, opposite: [k, l] }),
        _ => None,
    });
    shared.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_share_one_edge_whichever_way_they_turn() {
        let expected = [InteriorEdge { ends: [1, 2], opposite: [0, 3] }];
        for triangles in [[[0, 1, 2], [1, 3, 2]], [[2, 1, 0], [1, 3, 2]], [[1, 2, 0], [2, 1, 3]]] {
            assert_eq!(interior_edges(&triangles), expected, "{triangles:?}");
        }
    }

    #[test]
    fn a_fan_of_three_a_twin_and_a_collapsed_triangle_have_no_hinge() {
        assert!(interior_edges(&[[0, 1, 2], [0, 1, 3], [0, 1, 4]]).is_empty());
        assert!(interior_edges(&[[0, 1, 2], [0, 1, 2]]).is_empty());
        assert!(interior_edges(&[[0, 0, 1], [0, 0, 2]]).is_empty());
        assert!(interior_edges(&[]).is_empty());
    }

    #[test]
    fn a_closed_tetrahedron_has_six() {
        let triangles = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let edges = interior_edges(&triangles);
        assert_eq!(edges.len(), 6);
        assert!(edges.windows(2).all(|pair| pair[0].ends < pair[1].ends));
    }
}
