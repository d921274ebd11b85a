//! Lists of unequal lengths in one array, and the colours of particles.

/// One list a particle, all in one array (compressed rows).
#[derive(Clone, Debug)]
pub(crate) struct Rows<T> {
    /// Row `i` is `entries[starts[i]..starts[i + 1]]`.
    starts: Vec<usize>,
    entries: Vec<T>,
}

impl<T: Copy> Rows<T> {
    /// `n` rows of the entries with their rows, in the order in which they come.
    pub(crate) fn new(n: usize, mut all: Vec<(usize, T)>) -> Self {
        all.sort_by_key(|(row, _)| *row); // stable
        let starts = (0..=n).map(|row| all.partition_point(|(of, _)| *of < row)).collect();
        Self { starts, entries: all.into_iter().map(|(_, entry)| entry).collect() }
    }

    /// Where row `i` lies among all entries.
    pub(crate) fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }

    pub(crate) fn row(&self, i: usize) -> &[T] {
        &self.entries[self.range(i)]
    }

    /// All entries, row by row.
    pub(crate) fn entries_mut(&mut self) -> &mut [T] {
        &mut self.entries
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of all entries.
    pub(crate) fn entries(&self) -> usize {
        self.entries.len()
    }
}

/// The neighbours of each of `n` particles, rising, each once.
pub(crate) fn neighbours(n: usize, pairs: &[(usize, usize)]) -> Rows<u32> {
    let both = pairs.iter().flat_map(|&(i, j)| [(i, j as u32), (j, i as u32)]);
    let mut all: Vec<_> = both.filter(|(i, j)| *i != *j as usize).collect();
    all.sort_unstable();
    all.dedup();
    Rows::new(n, all)
}

/// Particles by colour: each takes the least colour that no neighbour of a lower index has (greedy
/// colouring). Rows are colours; within a colour indices rise. A grid with springs along both
/// diagonals of its cells gets four colours.
#[doc(alias = "greedy colouring")]
pub(crate) fn colours(neighbours: &Rows<u32>) -> Rows<u32> {
    let mut colour: Vec<usize> = Vec::with_capacity(neighbours.len());
    let mut taken = Vec::new();
    for i in 0..neighbours.len() {
        let lower = neighbours.row(i).iter().map(|&j| j as usize).take_while(|j| *j < i);
        taken.clear();
        taken.extend(lower.map(|j| colour[j]));
        let free = (0..=taken.len()).find(|c| !taken.contains(c));
        colour.push(free.unwrap_or(taken.len()));
    }
    let count = colour.iter().max().map_or(0, |last| last + 1);
    Rows::new(count, colour.into_iter().zip(0..).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_with_diagonals_takes_four_colours_and_no_neighbours_share_one() {
        let (rows, columns) = (7, 5);
        let mut pairs = Vec::new();
        for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            for (down, right) in [(0, 1), (1, 0), (1, 1), (1, -1)] {
                let (r2, c2) = (r + down, c + right);
                if r2 < rows && (0..columns).contains(&c2) {
                    pairs.push(((r * columns + c) as usize, (r2 * columns + c2) as usize));
                }
            }
        }
        let graph = neighbours(35, &pairs);
        let colours = colours(&graph);
        assert_eq!((colours.len(), colours.entries()), (4, 35));
        for colour in 0..4 {
            let members = colours.row(colour);
            assert!(members.is_sorted() && members.len() >= 6, "{members:?}");
            for i in members {
                let clash = graph.row(*i as usize).iter().find(|j| members.contains(j));
                assert_eq!(clash, None, "beside {i}");
            }
        }
    }

    #[test]
    fn lonely_particles_share_a_colour_and_nobody_needs_none() {
        assert_eq!(colours(&neighbours(3, &[(1, 1)])).row(0), [0, 1, 2]);
        assert_eq!(colours(&neighbours(0, &[])).len(), 0);
    }
}
