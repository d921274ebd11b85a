//! Kernels for the processor that they run on.
//!
//! The compiler vectorises most loops by itself, but not sums. Their four slots per coordinate (see
//! [`vector`](crate::vector)) are spelled out as operations on [`Four`] numbers. Sums and products
//! are never fused, so the instruction set changes no bit.

use crate::vector::SLOTS;
use pulp::{Simd, bytemuck};

/// Numbers of the widest vector registers.
pub const WIDEST: usize = 8;

/// The coordinates of a particle, and a fourth number that fills the register, usually 0.
pub type Lanes = [f64; SLOTS];

/// Operations on four numbers at once.
pub trait Four: Copy {
    /// The four numbers.
    type Numbers: Copy;

    /// From memory.
    fn load(self, numbers: [f64; SLOTS]) -> Self::Numbers;

    /// To memory.
    fn store(self, numbers: Self::Numbers) -> [f64; SLOTS];

    /// `a + b`.
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// `a − b`.
    fn sub(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// `a b`, number by number.
    fn mul(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;

    /// The same number four times.
    #[inline(always)]
    fn splat(self, number: f64) -> Self::Numbers {
        self.load([number; SLOTS])
    }
}

/// One by one, as the compiler sees fit.
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
}

/// In one register of an instruction set whose registers hold four numbers.
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
