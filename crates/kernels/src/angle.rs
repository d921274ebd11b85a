//! The angle of a point, four at a time, with the bits of `libm::atan2`.
//!
//! `libm` is FreeBSD's library in Rust. Its `atan` moves the argument near 0 by one of five
//! formulas, then sums a polynomial. Here numerator, denominator and the two parts of the constant
//! are chosen number by number; the operations that follow are the same for all.

use crate::lanes::Four;
use crate::triples::Triples;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// `π` beyond its nearest number, as `atan2` has it.
const PI_LOW: f64 = 1.224_646_799_147_353_2e-16;

/// Arguments from which a formula holds, the values of the angle there in two parts.
const FROM: [f64; 4] = [0.4375, 0.6875, 1.1875, 2.4375];
const HIGH: [f64; 4] = [4.636_476_090_008_061e-1, FRAC_PI_4, 9.827_937_232_473_29e-1, FRAC_PI_2];
const LOW: [f64; 4] = [
    2.269_877_745_296_168_7e-17,
    3.061_616_997_868_383e-17,
    1.390_331_103_123_099_8e-17,
    6.123_233_995_736_766e-17,
];

/// Coefficients of the even and the odd powers.
const EVEN: [f64; 6] = [
    3.333_333_333_333_293e-1,
    1.428_571_427_250_346_6e-1,
    9.090_887_133_436_507e-2,
    6.661_073_137_387_531e-2,
    4.976_877_994_615_932e-2,
    1.628_582_011_536_578_2e-2,
];
const ODD: [f64; 5] = [
    -1.999_999_999_987_648_3e-1,
    -1.111_111_040_546_235_6e-1,
    -7.691_876_205_044_83e-2,
    -5.833_570_133_790_573_5e-2,
    -3.653_157_274_421_691_6e-2,
];

/// A quotient of arguments below this needs no case of its own: 2⁶³.
const STEEPEST: f64 = 9.223_372_036_854_776e18;

/// `atan2(y, x)`, and `usual` with zeros where the arguments are unusual: infinite, not a number,
/// both zero, or with a quotient of about 2⁶³ or more. For unusual arguments the angle is not that
/// of `libm`.
#[inline(always)]
pub fn atan2<F: Four>(
    four: F,
    y: F::Numbers,
    x: F::Numbers,
    usual: F::Numbers,
) -> (F::Numbers, F::Numbers) {
    let zero = four.splat(0.0);
    let (height, width) = (four.abs(y), four.abs(x));
    let is_finite = four.if_at_most(height, four.splat(f64::MAX), usual);
    let is_finite = four.if_at_most(width, four.splat(f64::MAX), is_finite);
    let is_moderate = four.if_at_most(height, four.mul(width, four.splat(STEEPEST)), is_finite);
    let is_upright = four.where_at_most(height, zero, zero, is_finite);
    let usual = four.where_at_most(width, zero, is_upright, is_moderate);
    let first = atan(four, four.div(height, width));
    let second = four.sub(four.splat(PI), four.sub(first, four.splat(PI_LOW)));
    // `−0 ≥ 0`, but it is no width.
    let angle = four.where_at_most(zero, x, first, second);
    let angle = four.where_at_most(width, zero, four.splat(FRAC_PI_2), angle);
    (four.turn_by_sign(angle, y), usual)
}

/// `atan(a)` for `a` from 0 to 2⁶⁴.
#[inline(always)]
fn atan<F: Four>(four: F, a: F::Numbers) -> F::Numbers {
    let (zero, one, half3) = (four.splat(0.0), four.splat(1.0), four.splat(1.5));
    // (2a − 1)/(2 + a), (a − 1)/(a + 1), (a − 3/2)/(1 + 3a/2), −1/a
    let above = [
        (four.sub(four.mul(four.splat(2.0), a), one), four.add(four.splat(2.0), a)),
        (four.sub(a, one), four.add(a, one)),
        (four.sub(a, half3), four.add(one, four.mul(half3, a))),
        (four.splat(-1.0), a),
    ];
    let (mut over, mut under, mut high, mut low) = (a, one, zero, zero);
    for k in 0..4 {
        let from = four.splat(FROM[k]);
        over = four.where_at_most(from, a, above[k].0, over);
        under = four.where_at_most(from, a, above[k].1, under);
        high = four.where_at_most(from, a, four.splat(HIGH[k]), high);
        low = four.where_at_most(from, a, four.splat(LOW[k]), low);
    }
    let near = four.div(over, under);
    let z = four.mul(near, near);
    let w = four.mul(z, z);
    let mut even = four.splat(EVEN[5]);
    for k in (0..5).rev() {
        even = four.add(four.splat(EVEN[k]), four.mul(w, even));
    }
    let mut odd = four.splat(ODD[4]);
    for k in (0..4).rev() {
        odd = four.add(four.splat(ODD[k]), four.mul(w, odd));
    }
    let sum = four.mul(near, four.add(four.mul(z, even), four.mul(w, odd)));
    let small = four.sub(near, sum);
    let large = four.sub(high, four.sub(four.sub(sum, low), near));
    four.where_at_most(four.splat(FROM[0]), a, large, small)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Lanes, four_wide, vectorised};
    use crate::testing::{Random, assert_same_bits};

    /// Angles, and which arguments were usual.
    fn fast(y: Lanes, x: Lanes) -> [Lanes; 2] {
        vectorised!(four_wide(), [four, y: Lanes = y, x: Lanes = x] -> [Lanes; 2] {
            let one = four.splat(1.0);
            let (angle, usual) = atan2(four, four.load(y), four.load(x), one);
            [four.store(angle), four.store(usual)]
        })
    }

    fn check(y: Lanes, x: Lanes) -> usize {
        let [angles, usual] = fast(y, x);
        let mut count = 0;
        for k in (0..4).filter(|&k| usual[k] == 1.0) {
            count += 1;
            assert_same_bits((y[k], x[k]), &libm::atan2(y[k], x[k]), &angles[k]);
        }
        count
    }

    #[test]
    fn angles_have_the_bits_of_the_library() {
        let mut random = Random::new(63);
        for _ in 0..200_000 {
            let mut draw = || {
                let mantissa = random.unit();
                let power = random.unit();
                mantissa * 2.0_f64.powi((power * power * power * 40.0) as i32)
            };
            let [y, x] = [(); 2].map(|()| std::array::from_fn(|_| draw()));
            // A quotient of 2⁶³ takes two draws at the ends of the range.
            assert!(check(y, x) > 0, "{y:?} {x:?}");
        }
    }

    #[test]
    fn angles_at_the_ends_of_formulas_and_on_axes_have_the_bits_of_the_library() {
        let at = |k: usize| [f64::next_down, |a| a, f64::next_up].map(|to| to(FROM[k]));
        let ends = [0, 1, 2, 3].map(at).concat();
        for [sign_y, sign_x] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            for four in ends.as_chunks::<4>().0 {
                assert_eq!(check(four.map(|y| sign_y * y), [sign_x; 4]), 4);
            }
            // Zeros of both signs, a tiny number, a great quotient.
            assert_eq!(check([0.0, 1e-30, 1.0, 1e15].map(|y| sign_y * y), [sign_x; 4]), 4);
            assert_eq!(check([sign_y; 4], [0.0, 1e-300, 1.0, 1e200].map(|x| sign_x * x)), 3);
        }
    }

    #[test]
    fn arguments_without_a_usual_angle_are_named() {
        let cases = [
            (0.0, 0.0),
            (f64::NAN, 1.0),
            (1.0, f64::NAN),
            (f64::INFINITY, 1.0),
            (1.0, f64::NEG_INFINITY),
            (1.0, -1e-20),
            (f64::INFINITY, 0.0),
        ];
        for (y, x) in cases {
            assert_eq!(fast([y; 4], [x; 4])[1], [0.0; 4], "{y} {x}");
        }
    }
}
