//! Weighted graphs and their coarser versions.

use crate::pattern::Pattern;

/// An undirected graph in compressed rows, without loops.
#[derive(Debug)]
pub(super) struct Graph {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
    edge_weights: Vec<u32>,
    node_weights: Vec<u32>,
}

impl Graph {
    /// The off-diagonal part of a pattern.
    pub(super) fn of_pattern(pattern: &Pattern) -> Self {
        let mut graph = Self::empty(pattern.n(), pattern.nonzeros());
        for i in 0..pattern.n() {
            let row = pattern.columns()[pattern.row(i)].iter().copied();
            graph.push(1, row.filter(|&j| j as usize != i).map(|j| (j, 1)));
        }
        graph
    }

    /// The subgraph of the given nodes, numbered in their order. `number` is scratch memory with
    /// one entry for each node, all `u32::MAX` before and after.
    pub(super) fn part(&self, nodes: &[u32], number: &mut [u32]) -> Self {
        for (new, &old) in nodes.iter().enumerate() {
            number[old as usize] = new as u32;
        }
        let mut part = Self::empty(nodes.len(), 0);
        for &old in nodes {
            let edges = self.edges(old as usize).map(|(j, weight)| (number[j], weight));
            let kept = edges.filter(|&(j, _)| j != u32::MAX);
            part.push(self.node_weights[old as usize], kept);
        }
        nodes.iter().for_each(|&old| number[old as usize] = u32::MAX);
        part
    }

    fn empty(nodes: usize, edges: usize) -> Self {
        let mut starts = Vec::with_capacity(nodes + 1);
        starts.push(0);
        Self {
            starts,
            neighbours: Vec::with_capacity(edges),
            edge_weights: Vec::with_capacity(edges),
            node_weights: Vec::with_capacity(nodes),
        }
    }

    /// Adds the next node.
    fn push(&mut self, weight: u32, edges: impl Iterator<Item = (u32, u32)>) {
        for (j, edge_weight) in edges {
            self.neighbours.push(j);
            self.edge_weights.push(edge_weight);
        }
        self.starts.push(self.neighbours.len());
        self.node_weights.push(weight);
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.node_weights.len()
    }

    /// Weight of a node: the number of nodes of the finest graph that it represents.
    pub(super) fn weight(&self, i: usize) -> i64 {
        i64::from(self.node_weights[i])
    }

    /// Weight of all nodes.
    pub(super) fn total_weight(&self) -> i64 {
        self.node_weights.iter().map(|&weight| i64::from(weight)).sum()
    }

    /// Neighbours of a node.
    pub(super) fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> {
        self.neighbours[self.starts[i]..self.starts[i + 1]].iter().map(|&j| j as usize)
    }

    /// Neighbours of a node with the weights of the edges.
    fn edges(&self, i: usize) -> impl Iterator<Item = (usize, u32)> {
        let range = self.starts[i]..self.starts[i + 1];
        self.neighbours(i).zip(self.edge_weights[range].iter().copied())
    }

    /// The connected components, each in breadth-first order.
    pub(super) fn components(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.len()];
        let mut components = Vec::new();
        for start in 0..self.len() {
            if seen[start] {
                continue;
            }
            seen[start] = true;
            let mut component = vec![start as u32];
            let mut next = 0;
            while next < component.len() {
                for j in self.neighbours(component[next] as usize) {
                    if !std::mem::replace(&mut seen[j], true) {
                        component.push(j as u32);
                    }
                }
                next += 1;
            }
            components.push(component);
        }
        components
    }

    /// The coarse graph of pairs joined by heavy edges (Karypis and Kumar 1998, section 3.1), taken
    /// in the given order, and the coarse node of each node.
    pub(super) fn coarsen(&self, order: &[u32]) -> (Self, Vec<u32>) {
        const NONE: u32 = u32::MAX;
        let mut coarse_of = vec![NONE; self.len()];
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for &i in order {
            let i = i as usize;
            if coarse_of[i] != NONE {
                continue;
            }
            let free = self.edges(i).filter(|&(j, _)| coarse_of[j] == NONE);
            // The first of the heaviest edges, and among these the lightest neighbour.
            let mate = free
                .reduce(|best, next| {
                    let better = (next.1, -self.weight(next.0)) > (best.1, -self.weight(best.0));
                    if better { next } else { best }
                })
                .map_or(i, |(j, _)| j);
            coarse_of[i] = pairs.len() as u32;
            coarse_of[mate] = pairs.len() as u32;
            pairs.push((i as u32, mate as u32));
        }
        let mut coarse = Self::empty(pairs.len(), self.neighbours.len() / 2);
        let mut slot_of = vec![NONE; pairs.len()];
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for (c, &(i, mate)) in pairs.iter().enumerate() {
            edges.clear();
            let (i, mate) = (i as usize, mate as usize);
            let both = [Some(i), (mate != i).then_some(mate)];
            for fine in both.into_iter().flatten() {
                for (j, weight) in self.edges(fine) {
                    let d = coarse_of[j];
                    match slot_of[d as usize] {
                        _ if d as usize == c => (),
                        NONE => {
                            slot_of[d as usize] = edges.len() as u32;
                            edges.push((d, weight));
                        }
                        slot => edges[slot as usize].1 += weight,
                    }
                }
            }
            edges.iter().for_each(|&(d, _)| slot_of[d as usize] = NONE);
            let weight = both.into_iter().flatten().map(|fine| self.node_weights[fine]).sum();
            coarse.push(weight, edges.iter().copied());
        }
        (coarse, coarse_of)
    }
}
