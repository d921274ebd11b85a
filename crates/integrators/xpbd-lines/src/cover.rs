//! The springs of an effect, cut into lines that go straight on.
//!
//! Two springs that share a particle follow each other in a line if the line turns there by less
//! than 60°. The angle is that of the rest lengths: angles of triangles of springs by the law of
//! cosines, and sums of two of them. No positions take part, so the lines depend on the scene
//! alone.

use std::cmp::Reverse;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::Range;

/// Smallest angle of two springs that follow each other, rad.
const LEAST_ANGLE: f64 = 2.0 * PI / 3.0;
/// Angles are compared in these units, rad: round-off decides nothing.
const GRAIN: f64 = 1e-6;
/// No spring.
const NONE: u32 = u32::MAX;

/// All springs of a system as a graph, with rest lengths.
#[derive(Debug)]
pub(crate) struct Graph {
    /// Where the neighbours of a particle begin in `neighbours`.
    starts: Vec<usize>,
    /// Neighbours of each particle in rising order, and the shortest rest length of springs to
    /// them, m.
    neighbours: Vec<(u32, f64)>,
}

impl Graph {
    /// The graph of springs with their ends and rest lengths (m).
    pub(crate) fn new(particles: usize, springs: impl Iterator<Item = ([u32; 2], f64)>) -> Self {
        let mut directed: Vec<(u32, u32, f64)> =
            springs.flat_map(|([i, j], rest)| [(i, j, rest), (j, i, rest)]).collect();
        directed.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
        directed.dedup_by_key(|(i, j, _)| (*i, *j));
        let mut starts = vec![0; particles + 1];
        for &(i, ..) in &directed {
            starts[i as usize + 1] += 1;
        }
        for i in 0..particles {
            starts[i + 1] += starts[i];
        }
        Self { starts, neighbours: directed.into_iter().map(|(_, j, rest)| (j, rest)).collect() }
    }

    fn of(&self, i: u32) -> &[(u32, f64)] {
        &self.neighbours[self.starts[i as usize]..self.starts[i as usize + 1]]
    }

    fn length(&self, i: u32, j: u32) -> Option<f64> {
        let list = self.of(i);
        list.binary_search_by_key(&j, |(other, _)| *other).ok().map(|place| list[place].1)
    }

    /// The angle at `v` of the triangle `a`, `v`, `b`, if springs form it.
    fn corner(&self, a: u32, v: u32, b: u32) -> Option<f64> {
        let (va, vb, ab) = (self.length(v, a)?, self.length(v, b)?, self.length(a, b)?);
        let cosine = (va * va + vb * vb - ab * ab) / (2.0 * va * vb);
        Some(if cosine.is_finite() { libm::acos(cosine.clamp(-1.0, 1.0)) } else { PI })
    }

    /// The angle at `v` between the springs to `a` and `b`, rad: in the triangle that they form, or
    /// in two triangles side by side; a right angle in a face of four springs, else a straight
    /// line.
    fn angle(&self, a: u32, v: u32, b: u32) -> f64 {
        if let Some(angle) = self.corner(a, v, b) {
            return angle;
        }
        let both = |&(c, _): &(u32, f64)| Some(self.corner(a, v, c)? + self.corner(c, v, b)?);
        let least = self.of(v).iter().filter_map(both).fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            return least.min(PI);
        }
        let is_face = self.of(a).iter().any(|&(c, _)| c != v && self.length(c, b).is_some());
        if is_face { FRAC_PI_2 } else { PI }
    }
}

/// A line of springs: `q_0, …, q_L` with a spring between neighbours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Line {
    /// The springs by their number in the effect.
    pub(crate) springs: Range<usize>,
    /// The particles, one more than springs.
    pub(crate) particles: Range<usize>,
}

/// Lines that hold each spring of an effect once, in families whose lines share no particle.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cover {
    /// Springs, line by line.
    pub(crate) springs: Vec<u32>,
    /// Particles, line by line.
    pub(crate) particles: Vec<u32>,
    /// Family by family.
    pub(crate) lines: Vec<Line>,
    /// The lines of each family.
    pub(crate) families: Vec<Range<usize>>,
}

impl Cover {
    /// Cuts springs with these ends into lines. The result depends on the lists alone.
    pub(crate) fn new(graph: &Graph, particles: usize, ends: &[[u32; 2]]) -> Self {
        let next = partners(graph, particles, ends);
        let walked = walk(particles, ends, &next);
        walked.in_families(particles)
    }

    fn push_line(&mut self, springs: &[u32], particles: &[u32]) {
        let (s, p) = (self.springs.len(), self.particles.len());
        self.springs.extend(springs);
        self.particles.extend(particles);
        let line = Line { springs: s..self.springs.len(), particles: p..self.particles.len() };
        self.lines.push(line);
    }

    /// The same lines, family by family: each takes the first family where no line has a particle
    /// of it. In a family the longest lines come first.
    fn in_families(&self, particles: usize) -> Self {
        let mut sorted = Self::default();
        let mut rest: Vec<&Line> = self.lines.iter().collect();
        let mut last_family = vec![0; particles];
        for family in 1.. {
            if rest.is_empty() {
                break;
            }
            let start = sorted.lines.len();
            let (mut taken, members) = (Vec::new(), |line: &Line| line.particles.clone());
            rest.retain(|line| {
                let members = &self.particles[members(line)];
                let is_free = members.iter().all(|&i| last_family[i as usize] != family);
                if is_free {
                    members.iter().for_each(|&i| last_family[i as usize] = family);
                    taken.push(*line);
                }
                !is_free
            });
            taken.sort_by_key(|line| Reverse(line.springs.len()));
            for line in taken {
                let springs = &self.springs[line.springs.clone()];
                sorted.push_line(springs, &self.particles[members(line)]);
            }
            sorted.families.push(start..sorted.lines.len());
        }
        sorted
    }
}

/// The spring that follows each one beyond its first and its second end.
fn partners(graph: &Graph, particles: usize, ends: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut at: Vec<(u32, u32, u32)> =
        (0..).zip(ends).flat_map(|(spring, &[i, j])| [(i, spring, j), (j, spring, i)]).collect();
    at.sort_unstable();
    let mut next = vec![[NONE; 2]; ends.len()];
    let side = |spring: u32, particle: u32| usize::from(ends[spring as usize][0] != particle);
    let mut pairs: Vec<(u64, u32, u32)> = Vec::new();
    let mut start = 0;
    for v in 0..particles as u32 {
        let count = at[start..].iter().take_while(|(i, ..)| *i == v).count();
        let here = &at[start..start + count];
        start += count;
        pairs.clear();
        for (k, &(_, e, a)) in here.iter().enumerate() {
            for &(_, f, b) in here[k + 1..].iter().filter(|(_, _, b)| *b != a) {
                let angle = graph.angle(a, v, b);
                if angle > LEAST_ANGLE {
                    pairs.push((((PI - angle) / GRAIN).round() as u64, e, f));
                }
            }
        }
        pairs.sort_unstable();
        for &(_, e, f) in &pairs {
            let (at_e, at_f) = (side(e, v), side(f, v));
            if next[e as usize][at_e] == NONE && next[f as usize][at_f] == NONE {
                next[e as usize][at_e] = f;
                next[f as usize][at_f] = e;
            }
        }
    }
    next
}

/// Lines along the partners; one ends where it would come to a particle of its own again.
fn walk(particles: usize, ends: &[[u32; 2]], next: &[[u32; 2]]) -> Cover {
    let mut cover = Cover::default();
    let mut is_done = vec![false; ends.len()];
    let mut seen_by = vec![0; particles];
    let (mut springs, mut members) = (Vec::new(), Vec::new());
    let mut line = 0;
    for first in 0..ends.len() as u32 {
        if is_done[first as usize] {
            continue;
        }
        // Back to where the line begins, or once around a ring.
        let (mut spring, mut from) = (first, ends[first as usize][0]);
        loop {
            let [i, j] = ends[spring as usize];
            let back = next[spring as usize][usize::from(i != from)];
            if back == NONE || back == first || is_done[back as usize] {
                break;
            }
            debug_assert!(from == i || from == j);
            let [i, j] = ends[back as usize];
            (spring, from) = (back, if i == from { j } else { i });
        }
        // Forward, line by line.
        while spring != NONE && !is_done[spring as usize] {
            line += 1;
            springs.clear();
            members.clear();
            members.push(from);
            seen_by[from as usize] = line;
            while spring != NONE && !is_done[spring as usize] {
                let [i, j] = ends[spring as usize];
                let to = if i == from { j } else { i };
                if seen_by[to as usize] == line {
                    break;
                }
                seen_by[to as usize] = line;
                is_done[spring as usize] = true;
                springs.push(spring);
                members.push(to);
                spring = next[spring as usize][usize::from(i != to)];
                from = to;
            }
            cover.push_line(&springs, &members);
        }
    }
    cover
}

#[cfg(test)]
mod tests;
