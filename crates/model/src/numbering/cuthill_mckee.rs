//! Reverse Cuthill-McKee.

/// Most searches for an end of a component; sheets take two or three.
const MOST_SEARCHES: u32 = 5;

/// The springs as lists of neighbours; a pair with two springs counts twice.
struct Graph {
    /// Begin of each particle's list, and the end of the last.
    begin: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Graph {
    fn new<I: Iterator<Item = [u32; 2]>>(particles: usize, edges: impl Fn() -> I) -> Self {
        let mut begin = vec![0; particles + 1];
        for end in edges().flatten() {
            begin[end as usize + 1] += 1;
        }
        for i in 0..particles {
            begin[i + 1] += begin[i];
        }
        let mut next = begin.clone();
        let mut neighbours = vec![0; begin[particles]];
        let mut add = |i: u32, j: u32| {
            let slot = &mut next[i as usize];
            neighbours[*slot] = j;
            *slot += 1;
        };
        for [i, j] in edges() {
            add(i, j);
            add(j, i);
        }
        Self { begin, neighbours }
    }

    fn degree(&self, i: u32) -> usize {
        self.begin[i as usize + 1] - self.begin[i as usize]
    }

    fn neighbours(&self, i: u32) -> &[u32] {
        &self.neighbours[self.begin[i as usize]..self.begin[i as usize + 1]]
    }
}

/// A search breadth first, and its memory.
struct Search<'a> {
    graph: &'a Graph,
    /// The last search that reached each particle, from 1.
    reached: Vec<u32>,
    round: u32,
    queue: Vec<u32>,
}

impl Search<'_> {
    /// Depth of the component as seen from `start`, and a particle of fewest springs among those
    /// farthest away.
    fn farthest(&mut self, start: u32) -> (u32, u32) {
        self.round += 1;
        self.queue.clear();
        self.queue.push(start);
        self.reached[start as usize] = self.round;
        let (mut depth, mut level) = (0, 0..1);
        loop {
            for k in level.clone() {
                for &j in self.graph.neighbours(self.queue[k]) {
                    if self.reached[j as usize] != self.round {
                        self.reached[j as usize] = self.round;
                        self.queue.push(j);
                    }
                }
            }
            if self.queue.len() == level.end {
                let last = self.queue[level].iter().copied();
                return (depth, last.min_by_key(|&i| self.graph.degree(i)).unwrap_or(start));
            }
            level = level.end..self.queue.len();
            depth += 1;
        }
    }

    /// A particle at an end of the component of `start`.
    fn end(&mut self, start: u32) -> u32 {
        let (mut depth, mut end) = self.farthest(start);
        for _ in 1..MOST_SEARCHES {
            let (deeper, other) = self.farthest(end);
            if deeper <= depth {
                break;
            }
            (depth, end) = (deeper, other);
        }
        end
    }
}

/// The particles in reverse Cuthill-McKee order, component by component.
pub(super) fn reverse<I: Iterator<Item = [u32; 2]>>(
    particles: usize,
    edges: impl Fn() -> I,
) -> Vec<u32> {
    let graph = Graph::new(particles, edges);
    let mut search =
        Search { graph: &graph, reached: vec![0; particles], round: 0, queue: Vec::new() };
    let mut order: Vec<u32> = Vec::with_capacity(particles);
    let mut is_placed = vec![false; particles];
    for first in 0..particles as u32 {
        if is_placed[first as usize] {
            continue;
        }
        let begin = order.len();
        let end = search.end(first);
        is_placed[end as usize] = true;
        order.push(end);
        let mut k = begin;
        while let Some(&i) = order.get(k) {
            let next = order.len();
            for &j in graph.neighbours(i) {
                if !is_placed[j as usize] {
                    is_placed[j as usize] = true;
                    order.push(j);
                }
            }
            order[next..].sort_by_key(|&j| graph.degree(j));
            k += 1;
        }
        order[begin..].reverse();
    }
    order
}
