//! An order of the particles that suits the cache.
//!
//! # Why
//!
//! A frozen system may list its particles in any order. Every pass over the springs then reads and
//! writes two places far apart. Once the cloth exceeds the cache, each place costs a trip to main
//! memory for 24 bytes. If all springs are short in the *numbering* (`|i − j|` is small), the next
//! springs use places that the last ones have just used.
//!
//! # Method
//!
//! Reverse Cuthill-McKee (Cuthill and McKee 1969, George 1971) numbers breadth first from an end of
//! the cloth and reverses the order. Neighbours of a particle are numbered by increasing number of
//! springs. Repeated searches find the end of the cloth: each starts from the last particle of the
//! previous search, as long as the searches go deeper (George and Liu 1979). Each component is
//! numbered separately; components follow each other in the order of their first particles. The
//! springs of each effect are then sorted by their lower end, then by their higher end, so that one
//! sweep reads their parameters in order.
//!
//! # The rule
//!
//! | the given order is kept if | because |
//! |---|---|
//! | there are fewer than 1000 particles | all of it lies in the nearest caches, whatever the order |
//! | the springs have at most 16 different `abs(i − j)` | a regular grid: its passes run along diagonals, streams that the hardware foresees however far apart they are |
//! | the mean `abs(i − j)` over the springs would not fall to a fourth | a sheet in a sensible order is within a factor of two or three of the best; only a gain that can be felt is worth another order of summation |
//!
//! Even if the particles keep their order, the springs are sorted if their order alone is bad. It
//! is bad if the lower end jumps, from one spring to the next, four times as far as a spring
//! reaches, on average.
//!
//! The particles of a grid that is numbered row by row or column by column therefore keep their
//! order. Springs in another order than a scene lists them are sorted into that order. The sweep
//! along diagonals can then take them, and the results equal those of the scene bit for bit.
//!
//! # Cost
//!
//! A search visits every spring a few times: `O(springs)` work and two indices of memory for each.
//! The table shows square sheets with particles and springs in disorder, on one thread of a busy
//! machine (Zen 4); trust the ratios more than the times. "Row by row" is the same kernel on the
//! sheet in natural order.
//!
//! | particles | springs | mean span given | row by row | found | forces given, ns a spring | row by row | found | gain | build with it | without |
//! |---|---|---|---|---|---|---|---|---|---|---|
//! | 2500 | 14 502 | 837 | 42 | 45 | 3.5 | 3.2 | 3.8 | 0.9 | 2 ms | 6 ms |
//! | 10⁴ | 59 002 | 3349 | 84 | 89 | 4.8 | 3.4 | 3.4 | 1.4 | 26 ms | 14 ms |
//! | 10⁵ | 595 978 | 33 355 | 264 | 281 | 10.4 | 4.2 | 4.1 | 2.5 | 0.25 s | 0.11 s |
//! | 10⁶ | 5 990 002 | 333 405 | 834 | 889 | 71.6 | 9.7 | 12.9 | 5.5 | 7.3 s | 1.0 s |
//! | 10⁶ | 1 998 000 | 333 508 | 501 | 667 | 92.4 | 17.3 | 11.3 | 8.2 | 2.7 s | 0.5 s |
//!
//! With a million particles the search pays off after some 20 evaluations of the forces. Below 10⁴
//! particles the forces gain nothing: everything fits the second cache.

mod cuthill_mckee;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;

use crate::State;
use crate::effects::Spring;
use crate::effects::diagonals::{Diagonals, MAX_DIAGONALS};
use std::borrow::Cow;

/// Fewest particles for which another order may pay.
const FEWEST: usize = 1000;
/// Most different `|i − j|` of a system that counts as a regular grid.
const REGULAR: usize = 16;
/// Factor by which springs must become shorter in the numbering.
const GAIN: f64 = 4.0;

/// Maps particles of the running system to particles of the specification.
///
/// The *given* order is the order of the specification. The *internal* order is the order of the
/// system that [`build_ordered`](crate::SystemSpec::build_ordered) returns. If both are the same,
/// nothing is stored or copied.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Numbering {
    /// Given index of each particle in the internal order; empty if both orders are the same.
    given: Vec<u32>,
    /// Internal index of each particle in the given order; empty if both orders are the same.
    internal: Vec<u32>,
}

impl Numbering {
    /// The numbering that changes nothing.
    pub fn identity() -> Self {
        Self::default()
    }

    /// Whether both orders are the same.
    pub fn is_identity(&self) -> bool {
        self.given.is_empty()
    }

    /// Internal index of the particle with this given index.
    pub fn internal(&self, given: usize) -> usize {
        self.internal.get(given).map_or(given, |&k| k as usize)
    }

    /// Given index of the particle with this internal index.
    pub fn given(&self, internal: usize) -> usize {
        self.given.get(internal).map_or(internal, |&k| k as usize)
    }

    /// Brings a list with one entry per particle from the given to the internal order.
    pub fn apply<T: Copy>(&self, list: &[T]) -> Vec<T> {
        gather(&self.given, list).unwrap_or_else(|| list.to_vec())
    }

    /// Brings a list with one entry per particle back from the internal to the given order.
    pub fn restore_list<'a, T: Copy>(&self, list: &'a [T]) -> Cow<'a, [T]> {
        gather(&self.internal, list).map_or(Cow::Borrowed(list), Cow::Owned)
    }

    /// Brings a state back from the internal to the given order.
    pub fn restore<'a>(&self, state: &'a State) -> Cow<'a, State> {
        match (gather(&self.internal, &state.x), gather(&self.internal, &state.v)) {
            (Some(x), Some(v)) => Cow::Owned(State { t: state.t, x, v }),
            _ => Cow::Borrowed(state),
        }
    }

    /// Chooses the internal order of a system, and brings its springs to it.
    pub(crate) fn choose(particles: usize, effects: &mut [Strands<'_>]) -> Self {
        if particles < FEWEST {
            effects.iter_mut().for_each(Strands::align);
            return Self::identity();
        }
        let numbering = Self::shorter(particles, effects).unwrap_or_default();
        if numbering.is_identity() {
            effects.iter_mut().for_each(Strands::align);
        } else {
            for s in effects.iter_mut().flat_map(|effect| effect.springs.iter_mut()) {
                s.i = numbering.internal[s.i as usize];
                s.j = numbering.internal[s.j as usize];
            }
        }
        if !numbering.is_identity() {
            effects.iter_mut().for_each(Strands::sort);
        } else if are_scattered(effects) {
            effects.iter_mut().filter(|effect| !effect.is_grid()).for_each(Strands::sort);
        }
        numbering
    }

    /// Reverse Cuthill-McKee, if the rule asks for it.
    fn shorter(particles: usize, effects: &[Strands<'_>]) -> Option<Self> {
        let edges = || springs(effects).map(|s| [s.i, s.j]);
        if is_regular(edges()) {
            return None;
        }
        let given = cuthill_mckee::reverse(particles, edges);
        let mut internal = vec![0; particles];
        for (k, &i) in (0_u32..).zip(&given) {
            internal[i as usize] = k;
        }
        let after = mean_span(edges().map(|ends| ends.map(|i| internal[i as usize])));
        (GAIN * after <= mean_span(edges())).then_some(Self { given, internal })
    }
}

/// The springs of one effect.
pub(crate) struct Strands<'a> {
    pub(crate) springs: &'a mut [Spring],
    /// The law of each spring, if there are several.
    pub(crate) law_of: Option<&'a mut [u32]>,
}

impl Strands<'_> {
    /// Whether the springs lie along diagonals, in an order that a sweep takes.
    fn is_grid(&self) -> bool {
        self.law_of.is_none() && Diagonals::detect(self.springs).is_some()
    }

    /// Brings the springs of a grid that are listed in another order, or from their higher end,
    /// into the order in which a scene would list them; leaves others alone.
    fn align(&mut self) {
        if self.law_of.is_some() || self.is_grid() || !has_few_offsets(self.springs) {
            return;
        }
        // Diagonals that go right come first at each particle: shear has them by falling offset.
        for sign in [1, -1] {
            let mut sorted = self.springs.to_vec();
            for s in &mut sorted {
                (s.i, s.j) = (s.i.min(s.j), s.i.max(s.j));
            }
            sorted.sort_by_key(|s| (s.i, sign * (i64::from(s.j) - i64::from(s.i))));
            if Diagonals::detect(&sorted).is_some() {
                return self.springs.copy_from_slice(&sorted);
            }
        }
    }

    /// Sorts springs by their lower, then by their higher end. Equal ones keep their order, and
    /// laws go with their springs. Afterwards every spring starts at its lower end.
    fn sort(&mut self) {
        let low_high = |s: &Spring| (s.i.min(s.j), s.i.max(s.j));
        if let Some(law_of) = &mut self.law_of {
            let mut order: Vec<usize> = (0..self.springs.len()).collect();
            order.sort_by_key(|&k| low_high(&self.springs[k]));
            let sorted: Vec<u32> = order.into_iter().map(|k| law_of[k]).collect();
            law_of.copy_from_slice(&sorted);
        }
        for s in self.springs.iter_mut() {
            (s.i, s.j) = low_high(s);
        }
        self.springs.sort_by_key(|s| (s.i, s.j));
    }
}

/// Whether the springs have no more different `|i − j|` than a sweep takes.
fn has_few_offsets(springs: &[Spring]) -> bool {
    let mut known = Vec::with_capacity(MAX_DIAGONALS);
    springs.iter().all(|s| {
        let offset = s.i.abs_diff(s.j);
        let is_new = !known.contains(&offset);
        if is_new && known.len() < MAX_DIAGONALS {
            known.push(offset);
        }
        known.contains(&offset)
    })
}

/// The springs of all effects, effect by effect.
fn springs<'a>(effects: &'a [Strands<'_>]) -> impl Iterator<Item = &'a Spring> {
    effects.iter().flat_map(|effect| effect.springs.iter())
}

/// The entries at these places; `None` without places.
fn gather<T: Copy>(places: &[u32], list: &[T]) -> Option<Vec<T>> {
    (!places.is_empty()).then(|| places.iter().map(|&k| list[k as usize]).collect())
}

/// Whether the springs have at most [`REGULAR`] different `|i − j|`.
fn is_regular(edges: impl Iterator<Item = [u32; 2]>) -> bool {
    let mut known = Vec::with_capacity(REGULAR);
    for [i, j] in edges {
        let span = i.abs_diff(j);
        if !known.contains(&span) {
            if known.len() == REGULAR {
                return false;
            }
            known.push(span);
        }
    }
    true
}

/// Mean `|i − j|` over the springs.
fn mean_span(edges: impl Iterator<Item = [u32; 2]>) -> f64 {
    let (mut sum, mut count) = (0_u64, 0_u64);
    for [i, j] in edges {
        sum += u64::from(i.abs_diff(j));
        count += 1;
    }
    sum as f64 / count.max(1) as f64
}

/// Whether from one spring to the next the lower end jumps much farther than a spring reaches.
fn are_scattered(effects: &[Strands<'_>]) -> bool {
    let low = |s: &Spring| s.i.min(s.j);
    let pairs = effects.iter().flat_map(|effect| effect.springs.windows(2));
    let steps = pairs.map(|s| [low(&s[0]), low(&s[1])]);
    mean_span(steps) > GAIN * mean_span(springs(effects).map(|s| [s.i, s.j]))
}
