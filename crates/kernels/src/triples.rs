//! Vectors of three coordinates, four at a time: one register per coordinate.
//!
//! Each operation rounds as the one of the same name on a [`Vec3`], coordinate by coordinate, so a
//! kernel on [`Triple`]s gives the bits of the readable form.

use crate::Vec3;
use crate::lanes::{Four, Lanes};
use crate::vector::SLOTS;

/// Four vectors, by coordinates.
pub type Triple<F> = [<F as Four>::Numbers; 3];

/// Operations on four vectors at once.
pub trait Triples: Four {
    /// A vector with a fourth number 0.
    #[inline(always)]
    fn widen(self, vector: &Vec3) -> Self::Numbers {
        self.load([vector.x, vector.y, vector.z, 0.0])
    }

    /// Four vectors with a fourth number as one register per coordinate.
    #[inline(always)]
    fn coordinates(self, quads: [Self::Numbers; SLOTS]) -> Triple<Self> {
        let [x, y, z, _] = self.transpose(quads);
        [x, y, z]
    }

    /// The vectors at four places.
    #[inline(always)]
    fn gather(self, from: &[Vec3], [a, b, c, d]: [usize; SLOTS]) -> Triple<Self> {
        let (a, b) = (self.widen(&from[a]), self.widen(&from[b]));
        let (c, d) = (self.widen(&from[c]), self.widen(&from[d]));
        self.coordinates([a, b, c, d])
    }

    /// The four vectors one by one, each with a fourth number 0.
    #[inline(always)]
    fn apart(self, [x, y, z]: Triple<Self>) -> [Lanes; SLOTS] {
        let [a, b, c, d] = self.transpose([x, y, z, self.splat(0.0)]);
        [self.store(a), self.store(b), self.store(c), self.store(d)]
    }

    /// The same vector four times.
    #[inline(always)]
    fn same(self, vector: &Vec3) -> Triple<Self> {
        [self.splat(vector.x), self.splat(vector.y), self.splat(vector.z)]
    }

    /// `a + b`.
    #[inline(always)]
    fn plus(self, a: Triple<Self>, b: Triple<Self>) -> Triple<Self> {
        [self.add(a[0], b[0]), self.add(a[1], b[1]), self.add(a[2], b[2])]
    }

    /// `a − b`.
    #[inline(always)]
    fn minus(self, a: Triple<Self>, b: Triple<Self>) -> Triple<Self> {
        [self.sub(a[0], b[0]), self.sub(a[1], b[1]), self.sub(a[2], b[2])]
    }

    /// `a s`.
    #[inline(always)]
    fn times(self, a: Triple<Self>, s: Self::Numbers) -> Triple<Self> {
        [self.mul(a[0], s), self.mul(a[1], s), self.mul(a[2], s)]
    }

    /// `a / s`.
    #[inline(always)]
    fn over(self, a: Triple<Self>, s: Self::Numbers) -> Triple<Self> {
        [self.div(a[0], s), self.div(a[1], s), self.div(a[2], s)]
    }

    /// `a · b`.
    #[inline(always)]
    fn dot(self, a: Triple<Self>, b: Triple<Self>) -> Self::Numbers {
        let plane = self.add(self.mul(a[0], b[0]), self.mul(a[1], b[1]));
        self.add(plane, self.mul(a[2], b[2]))
    }

    /// `a × b`.
    #[inline(always)]
    fn cross(self, a: Triple<Self>, b: Triple<Self>) -> Triple<Self> {
        [
            self.sub(self.mul(a[1], b[2]), self.mul(a[2], b[1])),
            self.sub(self.mul(a[2], b[0]), self.mul(a[0], b[2])),
            self.sub(self.mul(a[0], b[1]), self.mul(a[1], b[0])),
        ]
    }

    /// `at` where `a ≤ b`, number by number, else 0. A chain of such calls, begun with ones, tells
    /// whether all comparisons hold: see [`are_ones`](Self::are_ones).
    #[inline(always)]
    fn if_at_most(self, a: Self::Numbers, b: Self::Numbers, at: Self::Numbers) -> Self::Numbers {
        self.where_at_most(a, b, at, self.splat(0.0))
    }

    /// Whether all four numbers are 1.
    #[inline(always)]
    fn are_ones(self, numbers: Self::Numbers) -> bool {
        self.store(numbers) == [1.0; SLOTS]
    }
}

impl<F: Four> Triples for F {}

/// Adds the vectors of four elements, each with a fourth number, one element after the other:
/// vector `n` of element `k` is `vectors[n][k]`, and goes to `places[n][k]`.
#[inline(always)]
pub fn add_in_turn<const N: usize>(
    places: [[usize; SLOTS]; N],
    vectors: &[[Lanes; SLOTS]; N],
    out: &mut [Vec3],
) {
    for k in 0..SLOTS {
        for n in 0..N {
            let ([x, y, z, _], sum) = (vectors[n][k], &mut out[places[n][k]]);
            *sum = Vec3::new(sum.x + x, sum.y + y, sum.z + z);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{four_wide, vectorised};
    use crate::testing::{Random, assert_same_bits};

    /// Plain operations on vectors, and the same four at a time.
    #[test]
    fn four_vectors_at_a_time_give_the_bits_of_vectors_one_by_one() {
        let mut random = Random::new(20);
        let (a, b) = (random.vectors(9), random.vectors(9));
        let places = [7, 0, 3, 3];
        let slow = places.map(|i| {
            let (a, b) = (a[i], b[i]);
            let dot = a.dot(&b);
            [a + b, a - b, a * dot, a / dot, a.cross(&b), Vec3::repeat(a.norm_squared())]
        });
        let fast = vectorised!(four_wide(), [four,
            a: &'k [Vec3] = &a, b: &'k [Vec3] = &b, places: [usize; 4] = places,
        ] -> [[Lanes; 4]; 6] {
            let (a, b) = (four.gather(a, places), four.gather(b, places));
            let dot = four.dot(a, b);
            let results = [
                four.plus(a, b), four.minus(a, b), four.times(a, dot), four.over(a, dot),
                four.cross(a, b), [four.dot(a, a); 3],
            ];
            results.map(|triple| four.apart(triple))
        });
        for (operation, fast) in fast.iter().enumerate() {
            let slow = [0, 1, 2, 3].map(|k| slow[k][operation]);
            let fast = fast.map(|v| Vec3::new(v[0], v[1], v[2]));
            assert_same_bits(operation, &slow, &fast);
        }
    }

    /// The second vector of the first element comes before the first one of the second element.
    #[test]
    fn sums_at_one_place_come_element_after_element() {
        let lanes = |x: f64| [x, 1.0, 0.0, 0.0];
        let vectors = [[1e16, 1.0, 0.0, 0.0].map(lanes), [-1e16, 0.0, 0.0, 3.0].map(lanes)];
        let mut out = vec![Vec3::zeros(); 2];
        add_in_turn([[1; 4], [1, 1, 1, 0]], &vectors, &mut out);
        assert_eq!(out, [Vec3::new(3.0, 1.0, 0.0), Vec3::new(1.0, 7.0, 0.0)]);
    }

    #[test]
    fn a_chain_of_comparisons_sees_each_number() {
        let one = crate::lanes::Plain.splat(1.0);
        for k in 0..4 {
            for bad in [2.0, f64::NAN] {
                let mut a = [0.5; 4];
                a[k] = bad;
                let found = crate::lanes::Plain.if_at_most(a, one, one);
                assert!(!crate::lanes::Plain.are_ones(found), "{k} {bad}");
            }
        }
        assert!(crate::lanes::Plain.are_ones(crate::lanes::Plain.if_at_most(one, one, one)));
    }
}
