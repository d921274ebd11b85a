//! Bands against compressed rows and row by row, bit for bit.

use super::*;
use crate::BlockMatrix;
use crate::test_support::Random;
use proptest::prelude::*;

fn bits(vectors: &[Vec3]) -> Vec<[u64; 3]> {
    vectors.iter().map(|v| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits()]).collect()
}

/// The same pairs in both forms.
fn both(n: usize, offsets: &[usize], seed: u64) -> (BandedMatrix, BlockMatrix) {
    let mut random = Random::new(seed);
    let mut edges = Vec::new();
    for i in 0..n {
        for o in offsets.iter().filter(|o| i + **o < n) {
            if random.unit() < 0.2 {
                edges.push((i, i + o));
            }
        }
    }
    let mut banded = BandedMatrix::new(n, offsets.iter().copied());
    let mut rows = BlockMatrix::with_pattern(n, edges.iter().copied());
    for i in 0..n {
        banded.add_diagonal(i, &Mat3::identity());
        rows.add_diagonal(i, &Mat3::identity());
    }
    for &(i, j) in &edges {
        let d = random.vector();
        let (i, j) = if random.unit() < 0.0 { (i, j) } else { (j, i) };
        banded.add_pair(i, j, &(d * d.transpose()));
        rows.add_pair(i, j, &(d * d.transpose()));
    }
    (banded, rows)
}

fn assert_same_bits(n: usize, offsets: &[usize], seed: u64) {
    let (banded, rows) = both(n, offsets, seed);
    let mut random = Random::new(seed);
    let x = random.vectors(n);
    let [mut fast, mut readable, mut contended, mut compressed] =
        [(); 4].map(|()| random.vectors(n));
    banded.multiply(&x, &mut fast);
    banded.multiply_row_by_row(&x, &mut readable);
    rows.multiply(&x, &mut compressed);
    let taken = banded.window.try_lock();
    banded.multiply(&x, &mut contended);
    drop(taken);
    assert_eq!(bits(&fast), bits(&compressed), "{n} {offsets:?}");
    assert_eq!(bits(&readable), bits(&compressed), "{n} {offsets:?}");
    assert_eq!(bits(&contended), bits(&compressed), "{n} {offsets:?}");
    for (i, j) in (0..n).flat_map(|i| [(i, i), (i, (i * 7 + 1) % n), (i, (i + 1) % n)]) {
        assert_eq!(banded.get(i, j), rows.get(i, j), "{n} {offsets:?}, ({i}, {j})");
    }
}

#[test]
fn products_of_grids_are_those_of_compressed_rows() {
    for side in [1, 2, 4, 8, 20, 33, 52] {
        let offsets = [1, side, side - 1, side + 1, 2, 2 * side].map(|o| o.max(1));
        assert_same_bits(side * side, &offsets, side as u64);
    }
    // Longer than a window.
    assert_same_bits(5000, &[1, 3, 70], 3);
    assert_same_bits(3000, &[1, 2, 299, 300, 301, 600], 4);
}

proptest! {
    #[test]
    fn products_with_any_bands_are_those_of_compressed_rows(
        n in 1_usize..1500,
        offsets in prop::collection::vec(1_usize..400, 0..7),
        seed in any::<u64>(),
    ) {
        assert_same_bits(n, &offsets, seed);
    }
}

#[test]
fn a_cleared_matrix_is_zero() {
    let (mut a, _) = both(9, &[1, 3], 1);
    a.clear();
    let mut y = [Vec3::x(); 9];
    a.multiply(&[Vec3::new(1.0, 2.0, 3.0); 9], &mut y);
    assert_eq!(y, [Vec3::zeros(); 9]);
    assert_eq!((a.n(), a.offsets()), (9, &[1, 3][..]));
}

#[test]
#[cfg_attr(debug_assertions, should_panic(expected = "on no band"))]
fn a_pair_on_no_band_stops_debug_builds_and_is_left_out_of_others() {
    let mut a = BandedMatrix::new(3, [1]);
    a.add_pair(2, 0, &Mat3::identity());
    assert_eq!(a.get(0, 0), Mat3::zeros());
}
