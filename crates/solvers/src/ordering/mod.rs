//! The order in which a factorisation eliminates the rows. It decides the number of fill-in
//! entries.
//!
//! Two orders are computed, and the one with fewer entries in the factor is used:
//!
//! * approximate minimum degree (AMD), a greedy order;
//! * nested dissection (George 1973). It eliminates a small separator last and orders the two
//!   halves in the same way. Parts of [`LEAF`] nodes are ordered by minimum degree, with the nodes
//!   around them in view.

mod elimination;
mod graph;
mod separator;

use crate::SolverError;
use crate::pattern::Pattern;
use elimination::EliminationTree;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use graph::Graph;
use separator::{Side, Xorshift, separate};

/// Below this many nodes only minimum degree is tried. On grids dissection saves 3 % of the entries
/// at 10⁴ nodes, 16 % at 10⁵, and takes 30 times as long.
const DISSECTED: usize = 20_000;
/// A part of at most this many nodes is not dissected further.
const LEAF: usize = 256;
/// Words of a bit mask of a part and an equal number of nodes around it.
const WORDS: usize = 2 * LEAF / 64;

/// The nodes in the order of elimination: every subtree of the elimination tree has consecutive
/// positions.
pub(crate) fn fill_reducing(pattern: &Pattern) -> Result<Vec<u32>, SolverError> {
    let greedy = minimum_degree(pattern)?;
    let greedy = EliminationTree::new(pattern, &greedy);
    if pattern.n() < DISSECTED {
        return Ok(greedy.postordered());
    }
    let dissected = nested_dissection(pattern);
    let dissected = EliminationTree::new(pattern, &dissected);
    let best = if dissected.entries() < greedy.entries() { dissected } else { greedy };
    Ok(best.postordered())
}

/// Number of entries in each column of the factor for this order, with the diagonal.
pub(crate) fn column_counts(pattern: &Pattern, order: &[u32]) -> Vec<u32> {
    EliminationTree::new(pattern, order).column_counts()
}

/// The pairs of places that the factor couples below the diagonal, for this order.
pub(crate) fn filled(pattern: &Pattern, order: &[u32]) -> Vec<(usize, usize)> {
    EliminationTree::new(pattern, order).pairs()
}

/// AMD of the whole graph.
fn minimum_degree(pattern: &Pattern) -> Result<Vec<u32>, SolverError> {
    let n = pattern.n();
    let failed =
        |reason| SolverError::Factorisation { size: n, nonzeros: pattern.nonzeros(), reason };
    if u32::try_from(pattern.nonzeros()).is_err() {
        return Err(failed("the matrix has more entries than can be indexed"));
    }
    let starts: Vec<u32> =
        (0..n).map(|i| pattern.row(i).start as u32).chain([pattern.nonzeros() as u32]).collect();
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, pattern.columns());
    let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
    let scratch = amd::order_scratch::<u32>(n, pattern.nonzeros());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| failed("out of memory"))?;
    let stack = MemStack::new(&mut memory);
    amd::order(&mut order, &mut inverse, matrix, amd::Control::default(), stack)
        .map_err(|_| failed("out of memory"))?;
    Ok(order)
}

/// The order of nested dissection.
fn nested_dissection(pattern: &Pattern) -> Vec<u32> {
    let whole = Graph::of_pattern(pattern);
    let n = whole.len();
    let mut number = vec![u32::MAX; n];
    let mut random = Xorshift::new();
    // From the last to the first: separators before the parts that they separate.
    let mut backward: Vec<u32> = Vec::with_capacity(n);
    let mut parts: Vec<Vec<u32>> = whole.components();
    while let Some(part) = parts.pop() {
        if part.len() <= LEAF {
            eliminate_leaf(&whole, &part, &mut number, &mut backward);
            continue;
        }
        let graph = whole.part(&part, &mut number);
        let sides = separate(&graph, &mut random);
        let on = |side| {
            let nodes = part.iter().zip(&sides).filter(move |&(_, &s)| s == side);
            nodes.map(|(&node, _)| node).collect::<Vec<_>>()
        };
        let (left, right, separator) = (on(Side::Left), on(Side::Right), on(Side::Separator));
        if left.is_empty() || right.is_empty() {
            // Nothing separates a dense part: any order fills it.
            backward.extend(part.iter().rev());
            continue;
        }
        backward.extend(separator.iter().rev());
        for nodes in [left, right] {
            let half = whole.part(&nodes, &mut number);
            let pieces = half.components();
            let global = |piece: Vec<u32>| piece.iter().map(|&i| nodes[i as usize]).collect();
            parts.extend(pieces.into_iter().map(global));
        }
    }
    backward.reverse();
    backward
}

/// Exact minimum degree on a part of at most [`LEAF`] nodes, on an elimination graph of bit masks.
/// Up to [`LEAF`] nodes around the part, which are eliminated later, count for the degrees.
fn eliminate_leaf(whole: &Graph, part: &[u32], number: &mut [u32], backward: &mut Vec<u32>) {
    let mut nodes = part.to_vec();
    let limit = 2 * LEAF;
    for (new, &old) in part.iter().enumerate() {
        number[old as usize] = new as u32;
    }
    for &i in part {
        for j in whole.neighbours(i as usize) {
            if number[j] == u32::MAX && nodes.len() < limit {
                number[j] = nodes.len() as u32;
                nodes.push(j as u32);
            }
        }
    }
    let mut masks = vec![[0_u64; WORDS]; nodes.len()];
    for (new, &old) in nodes.iter().enumerate() {
        for j in whole.neighbours(old as usize).filter(|&j| number[j] != u32::MAX) {
            masks[new][number[j] as usize / 64] |= 1 << (number[j] % 64);
        }
    }
    nodes.iter().for_each(|&old| number[old as usize] = u32::MAX);
    let degree = |mask: &[u64; WORDS]| mask.iter().map(|word| word.count_ones()).sum::<u32>();
    let mut left: Vec<usize> = (0..part.len()).collect();
    let first = backward.len();
    while let Some(at) = (0..left.len()).min_by_key(|&at| degree(&masks[left[at]])) {
        let node = left.remove(at);
        let mask = masks[node];
        for word in 0..WORDS {
            let mut bits = mask[word];
            while bits != 0 {
                let j = 64 * word + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                (0..WORDS).for_each(|w| masks[j][w] |= mask[w]);
                masks[j][j / 64] &= !(1 << (j % 64));
                masks[j][node / 64] &= !(1 << (node % 64));
            }
        }
        backward.push(part[node]);
    }
    backward[first..].reverse();
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;
