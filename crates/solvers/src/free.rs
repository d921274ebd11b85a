//! The rows that take part in a factorisation.

/// All rows, or those that a mask marks as free. The others are pinned and keep their diagonal
/// entry alone.
#[derive(Clone, Copy)]
pub(crate) struct FreeRows<'a>(Option<&'a [bool]>);

impl<'a> FreeRows<'a> {
    pub(crate) fn new(free: Option<&'a [bool]>, n: usize) -> Self {
        if let Some(mask) = free {
            assert_eq!(mask.len(), n, "one flag a row");
        }
        Self(free)
    }

    /// Whether row `i` is free.
    pub(crate) fn free(self, i: usize) -> bool {
        self.0.is_none_or(|free| free[i])
    }

    /// Whether the coupling of rows `i` and `j` is kept.
    pub(crate) fn coupled(self, i: usize, j: usize) -> bool {
        self.free(i) && self.free(j)
    }

    /// Whether entry (i, j) is kept: it is a coupling of free rows or on the diagonal.
    pub(crate) fn kept(self, i: usize, j: usize) -> bool {
        i == j || self.coupled(i, j)
    }
}
