//! The last mean velocities, from which Newton's method starts.

use drape_model::Vec3;

/// The mean velocities of the last two steps of one length.
///
/// Stiff springs that nothing damps ring: `v_n` changes its sign from step to step, and `v̄` is
/// what is smooth. An extrapolation of `v_n` turns springs over and leads Newton to another
/// solution.
#[derive(Debug)]
pub(crate) struct MeanVelocities {
    last: Vec<Vec3>,
    before: Vec<Vec3>,
    known: u32,
    step_bits: u64,
}

impl MeanVelocities {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self { last: zeros(), before: zeros(), known: 0, step_bits: 0 }
    }

    pub(crate) fn restart(&mut self) {
        self.known = 0;
    }

    /// Writes `2 v̄ − v̄'` of the last two steps, m/s, or what comes next to it: the last `v̄`, or
    /// `v_n` after another step size.
    pub(crate) fn extrapolate(&self, v: &[Vec3], h: f64, out: &mut [Vec3]) {
        match if self.step_bits == h.to_bits() { self.known } else { 0 } {
            0 => out.copy_from_slice(v),
            1 => out.copy_from_slice(&self.last),
            _ => {
                for i in 0..out.len() {
                    out[i] = self.last[i] * 2.0 - self.before[i];
                }
            }
        }
    }

    /// Remembers the mean velocity of a step of `h` seconds, m/s.
    pub(crate) fn remember(&mut self, mean: &[Vec3], h: f64) {
        let is_same = self.step_bits == h.to_bits();
        self.known = if is_same { (self.known + 1).min(2) } else { 1 };
        self.step_bits = h.to_bits();
        std::mem::swap(&mut self.last, &mut self.before);
        self.last.copy_from_slice(mean);
    }

    /// Sets one particle's past to its new velocity, m/s, after a contact changed it.
    pub(crate) fn forget(&mut self, particle: usize, v: &Vec3) {
        self.last[particle] = *v;
        self.before[particle] = *v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_of_another_size_is_the_first_of_a_new_past() {
        let mut past = MeanVelocities::new(1);
        let mut expect = |h: f64, mean: f64, guess: f64| {
            past.remember(&[Vec3::x() * mean], h);
            let mut out = [Vec3::zeros()];
            past.extrapolate(&[Vec3::y()], h, &mut out);
            assert_eq!(out[0], Vec3::x() * guess);
            past.extrapolate(&[Vec3::y()], 0.5 * h, &mut out);
            assert_eq!(out[0], Vec3::y(), "the next step has another size");
        };
        expect(0.1, 1.0, 1.0);
        expect(0.1, 3.0, 5.0);
        expect(0.3, 4.0, 4.0);
        expect(0.3, 7.0, 10.0);
    }
}
