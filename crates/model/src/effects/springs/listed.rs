//! Springs in any order.
//!
//! One array a parameter, so that a batch of springs reads whole cache lines.

use super::Spring;

/// Springs with parameters of their own, in the order of the specification.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Listed {
    /// Both ends.
    pub(crate) ends: Vec<[u32; 2]>,
    /// Rest lengths `ℓ`, m.
    pub(crate) rest_length: Vec<f64>,
    /// Stiffnesses `k`, N/m.
    pub(crate) stiffness: Vec<f64>,
    /// Damping coefficients `c`, N s/m.
    pub(crate) damping: Vec<f64>,
    /// One more than the last particle that has a spring.
    pub(crate) particles: usize,
}

impl Listed {
    pub(crate) fn new(springs: &[Spring]) -> Self {
        let mut listed = Self::default();
        for s in springs {
            listed.ends.push([s.i, s.j]);
            listed.rest_length.push(s.rest_length);
            listed.stiffness.push(s.stiffness);
            listed.damping.push(s.damping);
            listed.particles = listed.particles.max(1 + s.i.max(s.j) as usize);
        }
        listed
    }

    /// Visits the springs in their order.
    #[inline]
    pub(crate) fn each(&self, mut visit: impl FnMut(&Spring)) {
        let parameters = self.rest_length.iter().zip(&self.stiffness).zip(&self.damping);
        for (&[i, j], ((&rest_length, &stiffness), &damping)) in self.ends.iter().zip(parameters) {
            visit(&Spring { i, j, rest_length, stiffness, damping });
        }
    }

    /// Multiplies all stiffnesses and all damping coefficients.
    pub(crate) fn scale(&mut self, stiffness: f64, damping: f64) {
        self.stiffness.iter_mut().for_each(|k| *k *= stiffness);
        self.damping.iter_mut().for_each(|c| *c *= damping);
    }
}
