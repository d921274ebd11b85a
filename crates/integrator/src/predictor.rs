//! Start values for solves.

use crate::Word;
use drape_model::Vec3;
use drape_solvers::StartValue;
use drape_solvers::bands::in_bands;

/// Where an iterative solve starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// At `v_n`.
    Last,
    /// At the extrapolated velocity `2 v_n − v_{n−1}`, EEH (22).
    Extrapolated,
    /// At the candidate with the lower incremental potential.
    Best,
}

impl Word for Start {
    const WORDS: &'static [(&'static str, Self)] =
        &[("last", Self::Last), ("extrapolated", Self::Extrapolated), ("best", Self::Best)];
}

/// Stores the previous velocity and extrapolates from it.
#[derive(Clone, Debug, Default)]
pub struct Predictor {
    previous: Vec<Vec3>,
    step_bits: Option<u64>,
}

impl Predictor {
    /// Memory for `n` particles, without history.
    pub fn new(n: usize) -> Self {
        Self { previous: vec![Vec3::zeros(); n], step_bits: None }
    }

    /// Forgets the history: the next extrapolation returns the last velocity.
    pub fn restart(&mut self) {
        self.step_bits = None;
    }

    /// Copies another history of the same size without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.previous.copy_from_slice(&other.previous);
        self.step_bits = other.step_bits;
    }

    /// Writes `2 v_n − v_{n−1}`, m/s, to `out`, in the given number of
    /// [`bands`](drape_solvers::bands). Writes `v_n` if there is no history, or if the step size
    /// changed.
    #[doc(alias = "EEH 22")]
    pub fn extrapolate(&self, v: &[Vec3], h: f64, bands: usize, out: &mut [Vec3]) {
        let start = self.start(Start::Extrapolated, v, h);
        in_bands(bands, v.len(), out, &|band, out: &mut [Vec3]| start.part(band).write(out));
    }

    /// The start value of a solve for the velocity, m/s: `v_n` or its
    /// [extrapolation](Self::extrapolate).
    pub fn start<'a>(&'a self, start: Start, v: &'a [Vec3], h: f64) -> StartValue<'a> {
        if start == Start::Last || self.step_bits != Some(h.to_bits()) {
            StartValue::At(v)
        } else {
            StartValue::Extrapolated { last: v, before: &self.previous } // EEH (22)
        }
    }

    /// Stores `v_n`, m/s. Call it before a step of `h` seconds replaces the velocity.
    pub fn remember(&mut self, v: &[Vec3], h: f64) {
        self.previous.copy_from_slice(v);
        self.step_bits = Some(h.to_bits());
    }

    /// As [`remember`](Self::remember), but without a copy. Afterwards `v` holds an older velocity,
    /// and the caller must overwrite all of it.
    pub fn take(&mut self, v: &mut Vec<Vec3>, h: f64) {
        std::mem::swap(&mut self.previous, v);
        self.step_bits = Some(h.to_bits());
    }

    /// Sets the history of one particle to its new velocity, m/s, after a contact changed it.
    pub fn forget(&mut self, particle: usize, v: &Vec3) {
        self.previous[particle] = *v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_particle_that_met_an_obstacle_is_not_extrapolated_through_it() {
        let (before, last) = ([-Vec3::z(); 2], [Vec3::z() * 2.0; 2]);
        let mut predictor = Predictor::new(2);
        predictor.remember(&before, 0.1);
        predictor.forget(1, &last[1]);
        let mut out = [Vec3::zeros(); 2];
        predictor.extrapolate(&last, 0.1, 1, &mut out);
        assert_eq!(out, [Vec3::z() * 5.0, Vec3::z() * 2.0]);
        predictor.extrapolate(&last, 0.2, 1, &mut out);
        assert_eq!(out, last, "the step has another size");
        predictor.restart();
        predictor.extrapolate(&last, 0.1, 1, &mut out);
        assert_eq!(out, last, "there is no history");
    }
}
