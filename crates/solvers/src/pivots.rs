//! The check of pivots in a factorisation without pivoting.
//!
//! `A = L D Lᵀ` with pivots in a fixed order exists for most indefinite matrices, but nothing
//! bounds its entries. The size of `|L| |D| |Lᵀ|` bounds the rounding errors of the factorisation
//! (Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd edition, theorem 11.3). Its
//! largest entry is on its diagonal, where row `i` has `Σₖ lᵢₖ² |dₖ|`.

/// Greatest term of `|L| |D| |Lᵀ|` over the largest entry of `A`: 1/√ε. Up to this limit the
/// factors belong to a matrix that agrees with `A` in half of the digits.
const GROWTH_LIMIT: f64 = 67_108_864.0;

/// A pivot is a difference of terms. Below this part of the terms it has no correct digit, not even
/// its sign.
const LOST: f64 = 64.0 * f64::EPSILON;

/// A pivot that must not be divided by.
#[derive(Debug, PartialEq)]
pub(crate) struct BadPivot {
    /// Row in the order of elimination.
    pub(crate) row: usize,
    pub(crate) pivot: f64,
}

/// Reads a factor column by column in the order of elimination.
pub(crate) struct PivotCheck<'a> {
    /// `Σₖ lᵢₖ² |dₖ|` over the columns `k < i` read so far.
    sums: &'a mut [f64],
    largest_term: f64,
    negative: usize,
}

impl<'a> PivotCheck<'a> {
    /// A check for a matrix whose largest entry has the modulus `largest_entry`; `sums` has one
    /// number for each row.
    pub(crate) fn new(sums: &'a mut [f64], largest_entry: f64) -> Self {
        sums.fill(0.0);
        Self { sums, largest_term: GROWTH_LIMIT * largest_entry, negative: 0 }
    }

    /// Reads column `k`: the pivot `dₖ`, then the entries of `L` below it, which are in `rows`.
    pub(crate) fn column(
        &mut self,
        k: usize,
        column: &[f64],
        rows: impl Iterator<Item = usize>,
    ) -> Result<(), BadPivot> {
        let pivot = column[0];
        let bad = BadPivot { row: k, pivot };
        if pivot.abs() <= LOST * self.sums[k] {
            return Err(bad);
        }
        for (&l, i) in column[1..].iter().zip(rows) {
            let term = l * l * pivot.abs();
            if term > self.largest_term || term.is_nan() {
                return Err(bad);
            }
            self.sums[i] += term;
        }
        self.negative += usize::from(pivot < 0.0);
        Ok(())
    }

    /// Number of negative pivots read.
    pub(crate) fn negative(&self) -> usize {
        self.negative
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads the factor of `[[a, 1], [1, c]]`.
    fn read(a: f64, c: f64) -> Result<usize, BadPivot> {
        let mut sums = [f64::NAN; 2];
        let mut check = PivotCheck::new(&mut sums, 1_f64.max(a.abs()).max(c.abs()));
        check.column(0, &[a, 1.0 / a], [1].into_iter())?;
        check.column(1, &[c - 1.0 / a], [].into_iter())?;
        Ok(check.negative())
    }

    #[test]
    fn negative_pivots_are_counted() {
        assert_eq!(read(2.0, 2.0), Ok(0));
        assert_eq!(read(2.0, -2.0), Ok(1));
        assert_eq!(read(-2.0, -2.0), Ok(2));
        assert_eq!(read(0.01, 0.01), Ok(1));
    }

    #[test]
    fn a_small_pivot_is_bad_when_it_swamps_the_row_below() {
        assert_eq!(read(1e-7, 1.0), Ok(1));
        assert_eq!(read(1e-8, 1.0), Err(BadPivot { row: 0, pivot: 1e-8 }));
        assert_eq!(read(1e-320, 1.0), Err(BadPivot { row: 0, pivot: 1e-320 }));
    }

    #[test]
    fn a_pivot_is_bad_when_it_is_the_rounding_error_of_a_difference() {
        let c = 1.0 / 3.0;
        assert_eq!(read(3.0, c + 1e-12), Ok(0));
        assert_eq!(read(3.0, c - 1e-12), Ok(1));
        assert!(matches!(read(3.0, c + 1e-15), Err(BadPivot { row: 1, .. })));
        assert!(matches!(read(3.0, c), Err(BadPivot { row: 1, .. })));
    }

    #[test]
    fn a_small_pivot_of_a_row_that_couples_to_none_is_good() {
        let mut sums = [0.0; 2];
        let mut check = PivotCheck::new(&mut sums, 1.0);
        assert_eq!(check.column(0, &[1e-300], [].into_iter()), Ok(()));
        assert_eq!(check.column(1, &[1.0], [].into_iter()), Ok(()));
    }
}
