//! Small sets of nodes that cut a graph in two halves.
//!
//! A multilevel method (Hendrickson and Leland 1995, Karypis and Kumar 1998) coarsens the graph
//! until it is small and cuts it there. On each finer graph it refines the cut by the method of
//! Fiduccia and Mattheyses (1982) for separators of nodes (Ashcraft and Liu 1997).

use super::graph::Graph;
use std::collections::BinaryHeap;

/// The side of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    Separator,
}

impl Side {
    const BOTH: [Self; 2] = [Self::Left, Self::Right];

    fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
            Self::Separator => Self::Separator,
        }
    }
}

/// A graph of at most this many nodes is not coarsened.
const COARSEST: usize = 96;
/// Coarsening ends when a graph keeps more than this part of its nodes.
const LEAST_COARSENING: f64 = 0.9;
/// Starts that are tried on the coarsest graph.
const STARTS: usize = 8;
/// A side may weigh this part of what both would weigh without a separator.
const HEAVIEST: f64 = 0.6;
/// Passes of refinement on a graph, at most.
const PASSES: usize = 8;
/// A pass ends after so many moves without a better separator.
const PATIENCE: usize = 300;

/// A side for each node of a connected graph; no edge joins left and right.
pub(super) fn separate(graph: &Graph, random: &mut Xorshift) -> Vec<Side> {
    if graph.len() > COARSEST {
        let (coarse, coarse_of) = graph.coarsen(&random.order(graph.len()));
        if (coarse.len() as f64) < LEAST_COARSENING * graph.len() as f64 {
            let sides = separate(&coarse, random);
            let fine = coarse_of.iter().map(|&c| sides[c as usize]).collect();
            return Cut::new(graph, fine).refine();
        }
    }
    let mut best: Option<Cut<'_>> = None;
    for _ in 0..STARTS {
        let mut cut = Cut::new(graph, grow(graph, random.below(graph.len())));
        cut.improve();
        if best.as_ref().is_none_or(|best| cut.quality() < best.quality()) {
            best = Some(cut);
        }
    }
    best.map_or_else(Vec::new, |cut| cut.sides)
}

/// The nodes nearest to the start, with half of the weight, form one side. Those with a neighbour
/// in the other side separate.
fn grow(graph: &Graph, start: usize) -> Vec<Side> {
    let half = graph.total_weight() / 2;
    let mut sides = vec![Side::Right; graph.len()];
    let (mut queue, mut weight) = (vec![start], graph.weight(start));
    sides[start] = Side::Left;
    let mut next = 0;
    while weight < half && next < queue.len() {
        for j in graph.neighbours(queue[next]) {
            if sides[j] == Side::Right && weight < half {
                sides[j] = Side::Left;
                weight += graph.weight(j);
                queue.push(j);
            }
        }
        next += 1;
    }
    for &i in &queue {
        if graph.neighbours(i).any(|j| sides[j] == Side::Right) {
            sides[i] = Side::Separator;
        }
    }
    sides
}

/// A separator under refinement.
struct Cut<'a> {
    graph: &'a Graph,
    sides: Vec<Side>,
    /// Weights of left, right and separator.
    weights: [i64; 3],
    heaviest: i64,
}

/// One move: a node went from the separator to a side, and nodes of the other side entered the
/// separator.
struct Move {
    node: usize,
    to: Side,
    /// Start of the nodes that entered the separator, which end at the next move's.
    drawn: usize,
}

impl<'a> Cut<'a> {
    fn new(graph: &'a Graph, sides: Vec<Side>) -> Self {
        let mut weights = [0; 3];
        for (i, &side) in sides.iter().enumerate() {
            weights[side as usize] += graph.weight(i);
        }
        let heaviest = (HEAVIEST * graph.total_weight() as f64) as i64;
        Self { graph, sides, weights, heaviest }
    }

    fn refine(mut self) -> Vec<Side> {
        self.improve();
        self.sides
    }

    /// The quantities to minimise: excess of the heavier side, weight of the separator, imbalance.
    fn quality(&self) -> (i64, i64, i64) {
        let [left, right, separator] = self.weights;
        ((left.max(right) - self.heaviest).max(0), separator, (left - right).abs())
    }

    /// Weight that the separator loses when the node goes to a side.
    fn gain(&self, node: usize, to: Side) -> i64 {
        let drawn = self.graph.neighbours(node).filter(|&j| self.sides[j] == to.other());
        self.graph.weight(node) - drawn.map(|j| self.graph.weight(j)).sum::<i64>()
    }

    fn put(&mut self, node: usize, side: Side) {
        let weight = self.graph.weight(node);
        self.weights[self.sides[node] as usize] -= weight;
        self.weights[side as usize] += weight;
        self.sides[node] = side;
    }

    /// Repeats passes until one does not help.
    fn improve(&mut self) {
        let mut moved = vec![false; self.graph.len()];
        for _ in 0..PASSES {
            if !self.pass(&mut moved) {
                break;
            }
        }
    }

    /// Moves each node at most once, the best one first, and takes back the moves after the best
    /// separator. Returns whether that one is better than before.
    fn pass(&mut self, moved: &mut [bool]) -> bool {
        moved.fill(false);
        let (mut moves, mut drawn): (Vec<Move>, Vec<usize>) = (Vec::new(), Vec::new());
        let (mut best, mut kept) = (self.quality(), 0);
        // Entries out of date are skipped when they come up.
        let mut heaps = [BinaryHeap::new(), BinaryHeap::new()];
        for i in 0..self.graph.len() {
            if self.sides[i] == Side::Separator {
                for to in Side::BOTH {
                    heaps[to as usize].push((self.gain(i, to), i));
                }
            }
        }
        while moves.len() < kept + PATIENCE {
            let Some((node, to)) = self.choose(&mut heaps, moved) else { break };
            moved[node] = true;
            moves.push(Move { node, to, drawn: drawn.len() });
            let first = drawn.len();
            drawn.extend(self.graph.neighbours(node).filter(|&j| self.sides[j] == to.other()));
            self.put(node, to);
            drawn[first..].iter().for_each(|&j| self.put(j, Side::Separator));
            // Separator nodes next to a moved node have new gains.
            for &changed in drawn[first..].iter().chain([&node]) {
                for i in self.graph.neighbours(changed).chain([changed]) {
                    if self.sides[i] == Side::Separator && !moved[i] {
                        for to in Side::BOTH {
                            heaps[to as usize].push((self.gain(i, to), i));
                        }
                    }
                }
            }
            if self.quality() < best {
                (best, kept) = (self.quality(), moves.len());
            }
        }
        let improved = kept > 0;
        for undone in moves.drain(kept..).rev() {
            self.put(undone.node, Side::Separator);
            drawn.drain(undone.drawn..).for_each(|j| self.put(j, undone.to.other()));
        }
        improved
    }

    /// The move of greatest gain that does not make its side too heavy, or that goes to the lighter
    /// side.
    fn choose(
        &self,
        heaps: &mut [BinaryHeap<(i64, usize)>; 2],
        moved: &[bool],
    ) -> Option<(usize, Side)> {
        let mut best: Option<(i64, i64, usize, Side)> = None;
        for to in Side::BOTH {
            let heap = &mut heaps[to as usize];
            while let Some(&(gain, node)) = heap.peek() {
                let valid = self.sides[node] == Side::Separator
                    && !moved[node]
                    && gain == self.gain(node, to);
                if !valid {
                    heap.pop();
                    continue;
                }
                let (weight, other) =
                    (self.weights[to as usize], self.weights[to.other() as usize]);
                let fits = weight + self.graph.weight(node) <= self.heaviest || weight < other;
                if fits && best.is_none_or(|best| (gain, other - weight) > (best.0, best.1)) {
                    best = Some((gain, other - weight, node, to));
                }
                break;
            }
        }
        best.map(|(_, _, node, to)| (node, to))
    }
}

/// Reproducible pseudo-random numbers (Marsaglia's xorshift).
pub(super) struct Xorshift(u64);

impl Xorshift {
    pub(super) fn new() -> Self {
        Self(0x9e37_79b9_7f4a_7c15)
    }

    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((u128::from(self.0) * n as u128) >> 64) as usize
    }

    /// A permutation (Fisher and Yates).
    fn order(&mut self, n: usize) -> Vec<u32> {
        let mut order: Vec<u32> = (0..n as u32).collect();
        for i in (1..n).rev() {
            order.swap(i, self.below(i + 1));
        }
        order
    }
}
