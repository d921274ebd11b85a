//! Springs that lie along few diagonals of the matrix of couplings.
//!
//! The particles of a sheet may be numbered row by row. Then every spring of one kind joins
//! particle `i` to `i + o` with one of two offsets `o`, and has the same rest length, stiffness and
//! damping. At the border of a fabric it stands for half as much cloth, so that stiffness and
//! damping are half as large. One byte per particle and offset then describes a spring, instead of
//! 32 bytes. A sweep needs no index, because the far ends of neighbouring springs are neighbours
//! too.

use super::Spring;
use super::sweep::MAX_OFFSET;

/// Most offsets of one kind of spring.
pub(crate) const MAX_DIAGONALS: usize = 4;
/// Fewest springs that are worth the start of a sweep.
const FEWEST: usize = 64;
/// Least share of the places along the diagonals that must have a spring.
const LEAST_FILL: f64 = 0.6;
/// Particles beyond the last one that a kernel may load.
pub(crate) const PADDING: usize = 16;

/// The springs `(i, i + offset)` with the same parameters, but for springs with half the stiffness
/// and half the damping.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Diagonal {
    /// `j − i`, above 0.
    pub(crate) offset: usize,
    /// Rest length `ℓ`, m.
    pub(crate) rest_length: f64,
    /// Stiffness `k` of the weakest spring, N/m.
    pub(crate) stiffness: f64,
    /// Its damping coefficient `c`, N s/m.
    pub(crate) damping: f64,
    /// How many times the weakest spring the one from particle `i` to `i + offset` is: 1 or 2, and 0
    /// where there is none; padded by zeros.
    pub(crate) multiple: Vec<u8>,
    /// The particles without a spring, rising.
    pub(crate) absent: Vec<u32>,
    /// The particles whose spring is half the strongest, rising.
    pub(crate) halves: Vec<u32>,
}

impl Diagonal {
    /// A diagonal without springs, with the parameters of the first one.
    fn new(s: &Spring, offset: usize, particles: usize) -> Self {
        Self {
            offset,
            rest_length: s.rest_length,
            stiffness: s.stiffness,
            damping: s.damping,
            multiple: vec![0; particles + PADDING],
            absent: Vec::new(),
            halves: Vec::new(),
        }
    }

    /// The largest multiple.
    pub(crate) fn most(&self) -> f64 {
        if self.halves.is_empty() { 1.0 } else { 2.0 }
    }

    /// Takes up a spring; `false` if its parameters do not fit. Twice and half of a number are
    /// exact.
    fn push(&mut self, s: &Spring) -> bool {
        let is = |multiple: f64| {
            let [k, c] = [self.stiffness, self.damping].map(|a| (a * multiple).to_bits());
            k == s.stiffness.to_bits() && c == s.damping.to_bits()
        };
        let multiple = match [is(1.0), is(2.0), is(0.5)] {
            [true, ..] => 1,
            [_, true, _] => 2,
            [_, _, true] if !self.multiple.contains(&2) => {
                self.multiple.iter_mut().for_each(|multiple| *multiple *= 2);
                (self.stiffness, self.damping) = (s.stiffness, s.damping);
                1
            }
            _ => return false,
        };
        self.multiple[s.i as usize] = multiple;
        s.rest_length.to_bits() == self.rest_length.to_bits()
    }

    /// Lists the places that a sweep treats apart.
    fn list_places(&mut self, particles: usize) {
        let places = |wanted: u8| -> Vec<u32> {
            (0..particles as u32).filter(|i| self.multiple[*i as usize] == wanted).collect()
        };
        let (absent, singles) = (places(0), places(1));
        self.absent = absent;
        self.halves = if self.multiple.contains(&2) { singles } else { Vec::new() };
    }
}

/// Springs of one kind along at most [`MAX_DIAGONALS`] diagonals, in the order of the first end
/// and, at one particle, of the diagonals.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Diagonals {
    /// The diagonals, in the order in which a particle's own springs come.
    pub(crate) list: Vec<Diagonal>,
    /// Their indices by falling offset: the order in which springs from earlier particles come.
    pub(crate) incoming: Vec<usize>,
    /// One more than the last particle that has a spring.
    pub(crate) particles: usize,
}

impl Diagonals {
    /// Finds the diagonals of a list of springs; `None` if it has another structure, another order,
    /// or too few springs to matter.
    pub(crate) fn detect(springs: &[Spring]) -> Option<Self> {
        if springs.len() < FEWEST {
            return None;
        }
        let particles = 1 + springs.iter().map(|s| s.j.max(s.i)).max()? as usize;
        let mut list: Vec<Diagonal> = Vec::new();
        let (mut last, mut last_diagonal) = (0, None);
        for s in springs {
            let (i, offset) = (s.i as usize, (s.j as usize).checked_sub(s.i as usize)?);
            let slot = list.iter().position(|d| d.offset == offset);
            let slot = match slot {
                Some(slot) => slot,
                None if list.len() == MAX_DIAGONALS => return None,
                None => {
                    list.push(Diagonal::new(s, offset, particles));
                    list.len() - 1
                }
            };
            // Rising first ends; at one particle the diagonals in their order, each once.
            let in_order = i > last || (i == last && last_diagonal.is_none_or(|l| l < slot));
            if offset == 0 || offset > MAX_OFFSET || !in_order || !list[slot].push(s) {
                return None;
            }
            (last, last_diagonal) = (i, Some(slot));
        }
        if (springs.len() as f64) < LEAST_FILL * (list.len() * particles) as f64 {
            return None;
        }
        for d in &mut list {
            d.list_places(particles);
        }
        let mut incoming: Vec<usize> = (0..list.len()).collect();
        incoming.sort_by_key(|&d| std::cmp::Reverse(list[d].offset));
        Some(Self { list, incoming, particles })
    }

    /// The largest offset.
    pub(crate) fn reach(&self) -> usize {
        self.list.iter().map(|d| d.offset).max().unwrap_or(0)
    }

    /// Visits the springs in their order.
    #[inline]
    pub(crate) fn each(&self, mut visit: impl FnMut(&Spring)) {
        for i in 0..self.particles {
            for d in self.list.iter().filter(|d| d.multiple[i] > 0) {
                let multiple = f64::from(d.multiple[i]);
                visit(&Spring {
                    i: i as u32,
                    j: (i + d.offset) as u32,
                    rest_length: d.rest_length,
                    stiffness: multiple * d.stiffness,
                    damping: multiple * d.damping,
                });
            }
        }
    }

    /// Multiplies all stiffnesses and all damping coefficients.
    pub(crate) fn scale(&mut self, stiffness: f64, damping: f64) {
        for d in &mut self.list {
            d.stiffness *= stiffness;
            d.damping *= damping;
        }
    }
}
