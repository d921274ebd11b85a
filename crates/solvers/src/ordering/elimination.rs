//! The elimination tree and the size of the factor for an order of elimination.

use crate::pattern::Pattern;

const NONE: u32 = u32::MAX;

/// The elimination tree of a pattern in an order: `parent[k]` is the row of the first entry below
/// the diagonal in column `k` of the factor (Liu 1986).
pub(super) struct EliminationTree<'a> {
    pattern: &'a Pattern,
    order: &'a [u32],
    position: Vec<u32>,
    parent: Vec<u32>,
}

impl<'a> EliminationTree<'a> {
    pub(super) fn new(pattern: &'a Pattern, order: &'a [u32]) -> Self {
        let n = order.len();
        let mut position = vec![0; n];
        for (k, &i) in order.iter().enumerate() {
            position[i as usize] = k as u32;
        }
        let mut tree = Self { pattern, order, position, parent: vec![NONE; n] };
        let mut ancestor = vec![NONE; n];
        for k in 0..n {
            for slot in pattern.row(order[k] as usize) {
                let mut j = tree.position[pattern.column(slot)] as usize;
                // Climb from each earlier neighbour, shortening the path for the next climber.
                while j < k {
                    let next = std::mem::replace(&mut ancestor[j], k as u32);
                    if next == NONE {
                        tree.parent[j] = k as u32;
                        break;
                    }
                    j = next as usize;
                }
            }
        }
        tree
    }

    /// An order with every subtree in consecutive positions, which changes no entry of the factor.
    pub(super) fn postordered(&self) -> Vec<u32> {
        let n = self.parent.len();
        let (mut child, mut sibling) = (vec![NONE; n + 1], vec![NONE; n]);
        for k in (0..n).rev() {
            let parent = if self.parent[k] == NONE { n } else { self.parent[k] as usize };
            sibling[k] = std::mem::replace(&mut child[parent], k as u32);
        }
        let mut postorder = Vec::with_capacity(n);
        let mut path = vec![n];
        while let Some(&node) = path.last() {
            match child[node] {
                NONE => {
                    path.pop();
                    if node < n {
                        postorder.push(self.order[node]);
                    }
                }
                first => {
                    child[node] = sibling[first as usize];
                    path.push(first as usize);
                }
            }
        }
        postorder
    }

    /// Number of entries in each column of the factor, with the diagonal. Row `k` has entries on
    /// the paths from its earlier neighbours up to it.
    pub(super) fn column_counts(&self) -> Vec<u32> {
        let n = self.parent.len();
        let mut reached = vec![NONE; n];
        let mut counts = vec![1; n];
        for k in 0..n {
            for slot in self.pattern.row(self.order[k] as usize) {
                let mut j = self.position[self.pattern.column(slot)] as usize;
                while j < k && reached[j] != k as u32 {
                    reached[j] = k as u32;
                    counts[j] += 1;
                    j = self.parent[j] as usize;
                }
            }
        }
        counts
    }

    /// The entries of the factor below the diagonal, as (column, row).
    pub(super) fn pairs(&self) -> Vec<(usize, usize)> {
        let n = self.parent.len();
        let mut reached = vec![NONE; n];
        let mut pairs = Vec::new();
        for k in 0..n {
            for slot in self.pattern.row(self.order[k] as usize) {
                let mut j = self.position[self.pattern.column(slot)] as usize;
                while j < k && reached[j] != k as u32 {
                    reached[j] = k as u32;
                    pairs.push((j, k));
                    j = self.parent[j] as usize;
                }
            }
        }
        pairs
    }

    /// Number of entries of the factor.
    pub(super) fn entries(&self) -> u64 {
        self.column_counts().iter().map(|&count| u64::from(count)).sum()
    }
}
