//! An order of rows in which a triangular solve need not wait.
//!
//! In sequence, each row of a substitution waits some ten cycles for the row before: a
//! multiplication, a subtraction and another multiplication. On a mesh numbered line by line, the
//! rows of several lines can take turns instead, each line some columns behind the line before.
//! Every row still computes the same numbers in the same order, so no bit changes.

/// Number of lines that take turns.
const LINES: usize = 8;

/// Columns that a line stays behind the line before. The least serves a mesh with diagonals, and
/// springs over two columns.
const LAGS: std::ops::RangeInclusive<usize> = 2..=4;

/// A line shorter than this is not worth the turns.
const SHORTEST: usize = 2 * LINES;

/// The order: by groups of [`LINES`] lines, in a group by time `column + lag · line`, at a time by
/// line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wavefront {
    n: usize,
    /// Rows of a line.
    line: usize,
    lag: usize,
}

impl Wavefront {
    /// The order for a lower triangle with the columns `row(i)` left of the diagonal in row `i`.
    /// Rows are in sequence unless the pattern lets lines take turns.
    pub(super) fn new<'a>(n: usize, row: impl Fn(usize) -> &'a [u32]) -> Self {
        let sequence = Self { n, line: n.max(1), lag: 0 };
        // The most frequent offset that is not short may be the length of a line.
        let mut counts = vec![0_u32; n];
        (0..n).for_each(|i| row(i).iter().for_each(|&j| counts[i - j as usize] += 1));
        let Some(line) = (SHORTEST..n).max_by_key(|&offset| (counts[offset], offset)) else {
            return sequence;
        };
        LAGS.map(|lag| Self { n, line, lag }).find(|order| order.suits(&row)).unwrap_or(sequence)
    }

    /// Whether every row comes after the rows of its columns, and rows with a common column stay in
    /// sequence, so that subtractions from that column's entry keep their order.
    fn suits<'a>(self, row: &impl Fn(usize) -> &'a [u32]) -> bool {
        let mut last = vec![None; self.n];
        (0..self.n).all(|i| {
            row(i).iter().all(|&j| {
                let j = j as usize;
                let before = last[j].replace(i).unwrap_or(j);
                self.place(before) < self.place(i)
            })
        })
    }

    /// The key of the order.
    fn place(self, i: usize) -> (usize, usize, usize) {
        let (line, column) = (i / self.line, i % self.line);
        (line / LINES, column + self.lag * (line % LINES), line)
    }

    /// Visits the rows in this order. A plain loop is inlined into the function that has the
    /// instruction set; folds of iterators may not be.
    #[inline(always)]
    pub(super) fn forward(self, mut visit: impl FnMut(usize)) {
        for first in self.groups() {
            for time in 0..self.times() {
                let (from, to) = self.turns(first, time);
                for line in from..to {
                    visit(self.row(first, time, line));
                }
            }
        }
    }

    /// Visits the rows in the opposite order.
    #[inline(always)]
    pub(super) fn backward(self, mut visit: impl FnMut(usize)) {
        for first in self.groups().rev() {
            for time in (0..self.times()).rev() {
                let (from, to) = self.turns(first, time);
                for line in (from..to).rev() {
                    visit(self.row(first, time, line));
                }
            }
        }
    }

    /// First rows of the groups.
    #[inline(always)]
    fn groups(self) -> impl DoubleEndedIterator<Item = usize> {
        let rows = if self.lag == 0 { self.line } else { LINES * self.line };
        (0..self.n.div_ceil(rows)).map(move |group| group * rows)
    }

    /// Times in a group.
    #[inline(always)]
    fn times(self) -> usize {
        self.line + self.lag * (LINES - 1)
    }

    /// The lines of a group that have a row at a time.
    #[inline(always)]
    fn turns(self, first: usize, time: usize) -> (usize, usize) {
        if self.lag == 0 {
            return (0, 1);
        }
        // time − lag · line is a column of the line, and the row is one of the n.
        let from = (time + self.lag).saturating_sub(self.line) / self.lag;
        let by_time = time / self.lag + 1;
        let step = self.line - self.lag;
        let by_rows =
            if first + time < self.n { (self.n - 1 - first - time) / step + 1 } else { 0 };
        let to = by_time.min(by_rows).min(LINES);
        (from.min(to), to)
    }

    #[inline(always)]
    fn row(self, first: usize, time: usize, line: usize) -> usize {
        first + time + line * (self.line - self.lag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lower columns of a mesh with springs to particles so many rows up and columns to the left.
    fn lower(rows: usize, columns: usize, steps: &[(usize, isize)]) -> Vec<Vec<u32>> {
        let mut lower = vec![Vec::new(); rows * columns];
        for (i, row) in lower.iter_mut().enumerate() {
            for &(up, left) in steps {
                let column = (i % columns) as isize - left;
                if up <= i / columns && (0..columns as isize).contains(&column) {
                    row.push(((i / columns - up) * columns) as u32 + column as u32);
                }
            }
            row.sort_unstable();
        }
        lower
    }

    #[test]
    fn meshes_are_visited_in_turns_once_each_and_after_what_they_need() {
        let springs = [(0, 1), (1, 0), (1, 1), (1, -1), (0, 2), (2, 0)];
        for (rows, columns) in [(1, 40), (3, 17), (8, 20), (9, 33), (30, 40)] {
            for (count, lag) in [(2, 2), (4, 2), (6, 3)] {
                let lower = lower(rows, columns, &springs[..count]);
                let order = Wavefront::new(lower.len(), |i| &lower[i]);
                if rows > 1 {
                    assert_eq!((order.line, order.lag), (columns, lag), "{rows} {columns} {count}");
                }
                let mut visited = Vec::new();
                order.forward(|i| visited.push(i));
                let mut back = Vec::new();
                order.backward(|i| back.push(i));
                back.reverse();
                assert_eq!(visited, back);
                let mut place = vec![usize::MAX; lower.len()];
                visited.iter().enumerate().for_each(|(at, &i)| place[i] = at);
                assert_eq!(visited.len(), lower.len());
                assert!(place.iter().all(|&at| at < lower.len()));
                for (i, row) in lower.iter().enumerate() {
                    assert!(row.iter().all(|&j| place[j as usize] < place[i]));
                }
            }
        }
    }

    #[test]
    fn rows_that_cannot_take_turns_stay_in_sequence() {
        // A chain with far couplings backwards, against every lag.
        let lower: Vec<Vec<u32>> = (0..100_u32)
            .map(|i| [i.checked_sub(20), i.checked_sub(14), i.checked_sub(1)])
            .map(|columns| columns.into_iter().flatten().collect())
            .collect();
        let order = Wavefront::new(100, |i| &lower[i]);
        assert_eq!(order.lag, 0);
        let mut visited = Vec::new();
        order.forward(|i| visited.push(i));
        assert_eq!(visited, (0..100).collect::<Vec<_>>());
    }
}
