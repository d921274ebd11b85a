//! Springs that lie along few diagonals of the matrix of couplings.
//!
//! The particles of a sheet may be numbered row by row. Then every spring of one kind joins
//! particle `i` to `i + o` with one of two offsets `o`, and has the same rest length, stiffness and
//! damping. One byte per particle and offset then tells whether there is a spring, instead of 32
//! bytes per spring. A sweep needs no index, because the far ends of neighbouring springs are
//! neighbours too.

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

/// The springs `(i, i + offset)` with the same parameters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Diagonal {
    /// `j − i`, above 0.
    pub(crate) offset: usize,
    /// Rest length `ℓ`, m.
    pub(crate) rest_length: f64,
    /// Stiffness `k`, N/m.
    pub(crate) stiffness: f64,
    /// Damping coefficient `c`, N s/m.
    pub(crate) damping: f64,
    /// 1 where particle `i` has a spring to `i + offset`, else 0; padded by zeros.
    pub(crate) present: Vec<u8>,
    /// The particles without one, rising.
    pub(crate) absent: Vec<u32>,
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
                    list.push(Diagonal {
                        offset,
                        rest_length: s.rest_length,
                        stiffness: s.stiffness,
                        damping: s.damping,
                        present: vec![0; particles + PADDING],
                        absent: Vec::new(),
                    });
                    list.len() - 1
                }
            };
            let d = &mut list[slot];
            let bits = |a: f64, b: f64, c: f64| [a, b, c].map(f64::to_bits);
            let same = bits(d.rest_length, d.stiffness, d.damping)
                == bits(s.rest_length, s.stiffness, s.damping);
            // Rising first ends; at one particle the diagonals in their order, each once.
            let in_order = i > last || (i == last && last_diagonal.is_none_or(|l| l < slot));
            if offset == 0 || offset > MAX_OFFSET || !same || !in_order {
                return None;
            }
            (last, last_diagonal) = (i, Some(slot));
            d.present[i] = 1;
        }
        if (springs.len() as f64) < LEAST_FILL * (list.len() * particles) as f64 {
            return None;
        }
        for d in &mut list {
            d.absent = (0..particles as u32).filter(|i| d.present[*i as usize] == 0).collect();
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
            for d in self.list.iter().filter(|d| d.present[i] == 1) {
                visit(&Spring {
                    i: i as u32,
                    j: (i + d.offset) as u32,
                    rest_length: d.rest_length,
                    stiffness: d.stiffness,
                    damping: d.damping,
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
