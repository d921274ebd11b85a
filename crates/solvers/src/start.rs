//! Start values of iterative solves.

use crate::Vec3;
use crate::vector::extrapolate;
use std::ops::Range;

/// Where a solve starts.
#[derive(Clone, Copy, Debug)]
pub enum StartValue<'a> {
    /// At the present value of the solution vector.
    Given,
    /// At a copy of this vector.
    At(&'a [Vec3]),
    /// At the next term of an arithmetic progression, `2 last − before`.
    Extrapolated {
        /// The last term.
        last: &'a [Vec3],
        /// The term before the last one.
        before: &'a [Vec3],
    },
}

impl StartValue<'_> {
    /// The part of the start value that belongs to these particles.
    ///
    /// # Panics
    /// If the range ends beyond the particles.
    pub fn part(self, particles: Range<usize>) -> Self {
        match self {
            Self::Given => Self::Given,
            Self::At(start) => Self::At(&start[particles]),
            Self::Extrapolated { last, before } => {
                Self::Extrapolated { last: &last[particles.clone()], before: &before[particles] }
            }
        }
    }

    /// Writes the start value to the solution vector.
    ///
    /// # Panics
    /// When the lengths differ.
    pub fn write(self, x: &mut [Vec3]) {
        match self {
            Self::Given => {}
            Self::At(start) => x.copy_from_slice(start),
            Self::Extrapolated { last, before } => extrapolate(last, before, x),
        }
    }

    /// Whether the start value has `n` particles.
    pub(crate) fn fits(self, n: usize) -> bool {
        match self {
            Self::Given => true,
            Self::At(start) => start.len() == n,
            Self::Extrapolated { last, before } => [last.len(), before.len()] == [n; 2],
        }
    }
}
