//! Kernels that adapt to the processor on which they run.
//!
//! The compiler vectorises most loops by itself, but not sums. Their four slots per coordinate (see
//! [`vector`](crate::vector)) are written out as operations on [`Four`] numbers. Sums and products
//! are never fused, so the instruction set changes no bit.

use crate::vector::SLOTS;
use pulp::{Simd, bytemuck};
#[cfg(target_arch = "x86_64")]
use std::any::Any;

/// Number of numbers in the widest vector register.
pub const WIDEST: usize = 8;

/// The coordinates of a particle, and a fourth number that fills the register, usually 0.
pub type Lanes = [f64; SLOTS];

/// Operations on four numbers at once.
pub trait Four: Copy {
    /// The four numbers.
    type Numbers: Copy;

    /// Reads four numbers from memory.
    fn load(self, numbers: [f64; SLOTS]) -> Self::Numbers;

    /// Writes four numbers to memory.
    fn store(self, numbers: Self::Numbers) -> [f64; SLOTS];

    /// `a + b`.
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// `a − b`.
    fn sub(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// `a b`, number by number.
    fn mul(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// `a / b`, number by number.
    fn div(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// `−a`.
    fn neg(self, a: Self::Numbers) -> Self::Numbers;

    /// `√a`, number by number.
    fn sqrt(self, a: Self::Numbers) -> Self::Numbers;

    /// `|a|`, number by number: clears the sign bit.
    fn abs(self, a: Self::Numbers) -> Self::Numbers;

    /// `a`, number by number, with the sign flipped where `s` has the sign bit set.
    fn turn_by_sign(self, a: Self::Numbers, s: Self::Numbers) -> Self::Numbers;

    /// `yes` where `a ≤ b`, else `no`, number by number. `no` also if one of them is NaN.
    fn where_at_most(
        self,
        a: Self::Numbers,
        b: Self::Numbers,
        yes: Self::Numbers,
        no: Self::Numbers,
    ) -> Self::Numbers;

    /// Transposes four registers: number `k` of row `r` becomes number `r` of row `k`.
    #[inline(always)]
    fn transpose(self, rows: [Self::Numbers; SLOTS]) -> [Self::Numbers; SLOTS] {
        let [a, b, c, d] = rows;
        let [a, b, c, d] = [self.store(a), self.store(b), self.store(c), self.store(d)];
        [
            self.load([a[0], b[0], c[0], d[0]]),
            self.load([a[1], b[1], c[1], d[1]]),
            self.load([a[2], b[2], c[2], d[2]]),
            self.load([a[3], b[3], c[3], d[3]]),
        ]
    }

    /// The same number four times.
    #[inline(always)]
    fn splat(self, number: f64) -> Self::Numbers {
        self.load([number; SLOTS])
    }
}

/// Four numbers as an array, without an instruction set; the compiler decides.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Four for Plain {
    type Numbers = [f64; SLOTS];

    #[inline(always)]
    fn load(self, numbers: [f64; SLOTS]) -> [f64; SLOTS] {
        numbers
    }

    #[inline(always)]
    fn store(self, numbers: [f64; SLOTS]) -> [f64; SLOTS] {
        numbers
    }

    #[inline(always)]
    fn add(self, a: [f64; SLOTS], b: [f64; SLOTS]) -> [f64; SLOTS] {
        std::array::from_fn(|s| a[s] + b[s])
    }

    #[inline(always)]
    fn sub(self, a: [f64; SLOTS], b: [f64; SLOTS]) -> [f64; SLOTS] {
        std::array::from_fn(|s| a[s] - b[s])
    }

    #[inline(always)]
    fn mul(self, a: [f64; SLOTS], b: [f64; SLOTS]) -> [f64; SLOTS] {
        std::array::from_fn(|s| a[s] * b[s])
    }

    #[inline(always)]
    fn div(self, a: [f64; SLOTS], b: [f64; SLOTS]) -> [f64; SLOTS] {
        std::array::from_fn(|s| a[s] / b[s])
    }

    #[inline(always)]
    fn neg(self, a: [f64; SLOTS]) -> [f64; SLOTS] {
        a.map(|a| -a)
    }

    #[inline(always)]
    fn sqrt(self, a: [f64; SLOTS]) -> [f64; SLOTS] {
        a.map(f64::sqrt)
    }

    #[inline(always)]
    fn abs(self, a: [f64; SLOTS]) -> [f64; SLOTS] {
        a.map(f64::abs)
    }

    #[inline(always)]
    fn turn_by_sign(self, a: [f64; SLOTS], s: [f64; SLOTS]) -> [f64; SLOTS] {
        std::array::from_fn(|k| if s[k].is_sign_negative() { -a[k] } else { a[k] })
    }

    #[inline(always)]
    fn where_at_most(
        self,
        a: [f64; SLOTS],
        b: [f64; SLOTS],
        yes: [f64; SLOTS],
        no: [f64; SLOTS],
    ) -> [f64; SLOTS] {
        std::array::from_fn(|s| if a[s] <= b[s] { yes[s] } else { no[s] })
    }
}

/// Four numbers in one register of an instruction set.
#[derive(Clone, Copy, Debug)]
pub struct Wide<S>(pub S);

impl<S: Simd> Four for Wide<S> {
    type Numbers = S::f64s;

    #[inline(always)]
    fn load(self, numbers: [f64; SLOTS]) -> S::f64s {
        bytemuck::cast(numbers)
    }

    #[inline(always)]
    fn store(self, numbers: S::f64s) -> [f64; SLOTS] {
        bytemuck::cast(numbers)
    }

    #[inline(always)]
    fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.add_f64s(a, b)
    }

    #[inline(always)]
    fn sub(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.sub_f64s(a, b)
    }

    #[inline(always)]
    fn mul(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.mul_f64s(a, b)
    }

    #[inline(always)]
    fn div(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.div_f64s(a, b)
    }

    #[inline(always)]
    fn neg(self, a: S::f64s) -> S::f64s {
        self.0.xor_f64s(a, self.0.splat_f64s(-0.0))
    }

    #[inline(always)]
    fn sqrt(self, a: S::f64s) -> S::f64s {
        self.0.sqrt_f64s(a)
    }

    #[inline(always)]
    fn abs(self, a: S::f64s) -> S::f64s {
        self.0.abs_f64s(a)
    }

    #[inline(always)]
    fn turn_by_sign(self, a: S::f64s, s: S::f64s) -> S::f64s {
        let sign = self.0.and_f64s(s, self.0.splat_f64s(-0.0));
        self.0.xor_f64s(a, sign)
    }

    #[inline(always)]
    fn where_at_most(self, a: S::f64s, b: S::f64s, yes: S::f64s, no: S::f64s) -> S::f64s {
        // The same operation on floating-point numbers is not always inlined, which costs more than
        // a whole kernel.
        let is_so = self.0.less_than_or_equal_f64s(a, b);
        bytemuck::cast(self.0.select_u64s(is_so, bytemuck::cast(yes), bytemuck::cast(no)))
    }

    /// By eight shuffles of AVX, where the compiler finds twice as many and goes through memory.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn transpose(self, [a, b, c, d]: [S::f64s; SLOTS]) -> [S::f64s; SLOTS] {
        let Some(pulp::x86::V3 { avx, .. }) = (&self.0 as &dyn Any).downcast_ref() else {
            let [a, b, c, d] = [self.store(a), self.store(b), self.store(c), self.store(d)];
            let [a, b, c, d] = Plain.transpose([a, b, c, d]);
            return [self.load(a), self.load(b), self.load(c), self.load(d)];
        };
        let (a, b) = (bytemuck::cast(a), bytemuck::cast(b));
        let (c, d) = (bytemuck::cast(c), bytemuck::cast(d));
        // Columns 0 and 2 of two rows each, and columns 1 and 3.
        let (even_ab, odd_ab) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
        let (even_cd, odd_cd) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
        [
            bytemuck::cast(avx._mm256_permute2f128_pd::<0x20>(even_ab, even_cd)),
            bytemuck::cast(avx._mm256_permute2f128_pd::<0x20>(odd_ab, odd_cd)),
            bytemuck::cast(avx._mm256_permute2f128_pd::<0x31>(even_ab, even_cd)),
            bytemuck::cast(avx._mm256_permute2f128_pd::<0x31>(odd_ab, odd_cd)),
        ]
    }
}

/// The instruction set for kernels whose registers hold four numbers.
///
/// With wider registers the compiler would not see that the slots of a sum fit half a register.
pub fn four_wide() -> pulp::Arch {
    #[cfg(target_arch = "x86_64")]
    if let Some(v3) = pulp::x86::V3::try_new() {
        return pulp::Arch::V3(v3);
    }
    pulp::Arch::new()
}

/// Runs a block compiled for an instruction set, such as [`four_wide`](crate::lanes::four_wide).
///
/// The list names each value that the block uses with its type (and the lifetime `'k`), like the
/// captures of a closure. A closure itself might not be inlined into the function that has the
/// instruction set. Every function that the block calls must be `#[inline(always)]`.
#[macro_export]
macro_rules! vectorised {
    (
        $arch:expr,
        [$four:ident $(, $name:ident: $type:ty = $value:expr)* $(,)?] -> $output:ty $body:block
    ) => {{
        struct Kernel<'k> {
            $($name: $type,)*
            lifetime: ::std::marker::PhantomData<&'k ()>,
        }
        impl<'k> $crate::pulp::WithSimd for Kernel<'k> {
            type Output = $output;

            #[inline(always)]
            fn with_simd<S: $crate::pulp::Simd>(self, simd: S) -> $output {
                let Self { $($name,)* lifetime: _ } = self;
                if S::F64_LANES == $crate::vector::SLOTS {
                    let $four = $crate::lanes::Wide(simd);
                    $body
                } else {
                    let $four = $crate::lanes::Plain;
                    $body
                }
            }
        }
        $arch.dispatch(Kernel { $($name: $value,)* lifetime: ::std::marker::PhantomData })
    }};
}

pub use crate::vectorised;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Random, assert_same_bits};

    /// All operations on registers, one after the other.
    fn registers(a: Lanes, b: Lanes) -> [Lanes; 13] {
        vectorised!(four_wide(), [four, a: Lanes = a, b: Lanes = b] -> [Lanes; 13] {
            operations(four, a, b)
        })
    }

    #[inline(always)]
    fn operations<F: Four>(four: F, a: Lanes, b: Lanes) -> [Lanes; 13] {
        let (a, b) = (four.load(a), four.load(b));
        let [t, u, v, w] = four.transpose([a, b, b, a]);
        let results = [
            four.add(a, b),
            four.sub(a, b),
            four.mul(a, b),
            four.div(a, b),
            four.neg(a),
            four.sqrt(four.mul(a, a)),
            four.abs(a),
            four.turn_by_sign(a, b),
            four.where_at_most(a, b, a, b),
            t,
            u,
            v,
            w,
        ];
        results.map(|numbers| four.store(numbers))
    }

    #[test]
    fn registers_give_the_bits_of_numbers_one_by_one() {
        let mut random = Random::new(4);
        for round in 0..50 {
            let [a, mut b] = [(); 2].map(|()| std::array::from_fn(|_| random.unit()));
            match round {
                1 => b = a,
                2 => b = [0.0, -0.0, f64::INFINITY, f64::NAN],
                _ => {}
            }
            let [found, expected] = [registers(a, b), operations(Plain, a, b)];
            // Which NaN comes out of a sum is no part of the promise.
            let [found, expected] = [found, expected]
                .map(|all| all.map(|r| r.map(|x| if x.is_nan() { 0.5 } else { x })));
            assert_same_bits(round, &expected, &found);
        }
    }

    #[test]
    fn rows_become_columns_and_a_comparison_with_nan_is_false() {
        let rows = [0.0, 4.0, 8.0, 12.0].map(|r| [r, r + 1.0, r + 2.0, r + 3.0]);
        let columns = [0.0, 1.0, 2.0, 3.0].map(|k| [k, k + 4.0, k + 8.0, k + 12.0]);
        assert_eq!(Plain.transpose(rows), columns);
        let found = Plain.where_at_most([1.0, 2.0, 3.0, f64::NAN], [2.0; 4], [1.0; 4], [0.0; 4]);
        assert_eq!(found, [1.0, 1.0, 0.0, 0.0]);
    }
}
