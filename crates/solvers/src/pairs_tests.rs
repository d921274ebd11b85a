//! Pairs against compressed rows, bit for bit.

use super::*;
use crate::BlockMatrix;
use crate::test_support::{Random, graph};
use proptest::prelude::*;

fn bits(vectors: &[Vec3]) -> Vec<[u64; 3]> {
    vectors.iter().map(|v| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits()]).collect()
}

/// Edges of a row to itself are harmless, and so is what a line of the last column of the last block reads beyond it.
#[test]
fn a_matrix_without_pairs_is_its_diagonal() {
    let mut a = PairMatrix::new(2, [(1, 1)]);
    a.add_pair(1, 1, &Mat3::identity());
    a.add_diagonal(1, &Mat3::from_diagonal_element(2.0));
    let mut y = [Vec3::zeros(); 2];
    a.multiply(&[Vec3::x(), Vec3::new(1.0, 2.0, 3.0)], &mut y);
    assert_eq!(y, [Vec3::zeros(), Vec3::new(2.0, 4.0, 6.0)]);
    assert_eq!((a.n(), a.nonzeros(), a.get(0, 1)), (2, 2, Mat3::zeros()));
}

proptest! {
    #[test]
    fn products_and_blocks_are_those_of_compressed_rows(
        (n, edges) in graph(60), seed in any::<u64>(),
    ) {
        let mut random = Random::new(seed);
        let mut pairs = PairMatrix::new(n, edges.iter().copied());
        let mut rows = BlockMatrix::with_pattern(n, edges.iter().copied());
        for round in 0..2 {
            pairs.clear();
            rows.clear();
            for i in 0..n {
                pairs.add_diagonal(i, &Mat3::from_diagonal_element(random.unit()));
                let block = pairs.get(i, i);
                rows.add_diagonal(i, &block);
            }
            for &(i, j) in &edges {
                let d = random.vector();
                pairs.add_pair(i, j, &(d * d.transpose()));
                rows.add_pair(i, j, &(d * d.transpose()));
            }
            let x = random.vectors(n);
            let [mut fast, mut readable] = [(); 2].map(|()| random.vectors(n));
            pairs.multiply(&x, &mut fast);
            rows.multiply(&x, &mut readable);
            prop_assert_eq!(bits(&fast), bits(&readable), "round {}", round);
            for &(i, j) in &edges {
                prop_assert_eq!(pairs.get(j, i), rows.get(j, i));
            }
            prop_assert_eq!(pairs.nonzeros(), rows.nonzeros());
        }
    }

    /// What is written into the lines at the place that an edge remembers is the block of that edge.
    #[test]
    fn every_edge_remembers_its_pair((n, edges) in graph(30)) {
        let mut pairs = PairMatrix::new(n, edges.iter().copied());
        let PairLines { diagonal, pairs: lines, ends, slots } = pairs.lines_mut();
        prop_assert_eq!((diagonal.len(), lines.len(), slots.len()), (n, ends.len(), edges.len()));
        for (&(i, j), &slot) in edges.iter().zip(slots).filter(|((i, j), _)| i != j) {
            prop_assert_eq!(ends[slot as usize], [i.min(j) as u32, i.max(j) as u32]);
            let tag = (i.min(j) * n + i.max(j)) as f64;
            lines[slot as usize] = [0.0, 1.0, 2.0, 3.0, 4.0, 1.0, 5.0, 3.0].map(|a| a + tag);
        }
        for &(i, j) in edges.iter().filter(|(i, j)| i != j) {
            let tag = (i.min(j) * n + i.max(j)) as f64;
            let expected = Mat3::new(0.0, 1.0, 2.0, 1.0, 5.0, 3.0, 2.0, 3.0, 4.0).add_scalar(tag);
            prop_assert_eq!(pairs.get(i, j), expected);
            prop_assert_eq!(pairs.get(j, i), expected);
        }
    }
}
