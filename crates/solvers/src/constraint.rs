//! Constraints as filters: the free directions of a particle, and the prescribed values in all
//! others.
//!
//! Baraff & Witkin (1998, section 5) constrain a particle by a symmetric projector `S` on its free
//! directions, and give a value `z` for the directions that `S` removes. A vector obeys the
//! constraints when it has the form `S x + (I − S) z`.

use crate::{Mat3, Vec3};

/// The free directions of one particle: an orthogonal projector `S` of rank 3, 2, 1 or 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// `S = I`: moves freely.
    Free,
    /// `S = I − n nᵀ`: moves in the plane with unit normal `n`.
    Plane {
        /// Unit normal of the plane.
        normal: Vec3,
    },
    /// `S = d dᵀ = I − p pᵀ − q qᵀ`: moves along the unit direction `d` only.
    Line {
        /// Unit direction of the line.
        direction: Vec3,
    },
    /// `S = 0`: has no free direction.
    Fixed,
}

impl Filter {
    /// `S v`, the free part of `v`.
    pub fn apply(&self, v: Vec3) -> Vec3 {
        match *self {
            Filter::Free => v,
            Filter::Plane { normal } => v - along(normal, v),
            Filter::Line { direction } => along(direction, v),
            Filter::Fixed => Vec3::zeros(),
        }
    }

    /// `(I − S) v`, the constrained part of `v`.
    pub fn complement(&self, v: Vec3) -> Vec3 {
        match *self {
            Filter::Free => Vec3::zeros(),
            Filter::Plane { normal } => along(normal, v),
            Filter::Line { direction } => v - along(direction, v),
            Filter::Fixed => v,
        }
    }

    /// `S` as a symmetric matrix.
    pub fn matrix(&self) -> Mat3 {
        match *self {
            Filter::Free => Mat3::identity(),
            Filter::Plane { normal } => Mat3::identity() - normal * normal.transpose(),
            Filter::Line { direction } => direction * direction.transpose(),
            Filter::Fixed => Mat3::zeros(),
        }
    }

    /// Whether the filter's direction, if it has one, has length one.
    fn is_projector(&self) -> bool {
        match *self {
            Filter::Plane { normal: d } | Filter::Line { direction: d } => {
                (d.norm_squared() - 1.0).abs() < 1e-9
            }
            Filter::Free | Filter::Fixed => true,
        }
    }
}

/// `d dᵀ v` for a unit vector `d`.
fn along(d: Vec3, v: Vec3) -> Vec3 {
    d * (d.x * v.x + d.y * v.y + d.z * v.z)
}

/// The filters and the prescribed values of `n` particles: `S` and `(I − S) z`.
///
/// [`project`](Self::project) and similar methods visit only the constrained particles. A free
/// particle costs no time and only one index of memory. A separate list holds constraints other
/// than fixed particles.
///
/// ```
/// use drape_solvers::{Constraints, Filter, Vec3};
/// let mut constraints = Constraints::free(2);
/// // Particle 1 glides on a floor that rises by 0.5 m/s.
/// constraints.set(1, Filter::Plane { normal: Vec3::z() }, Vec3::new(0.0, 0.0, 0.5));
/// let mut v = [Vec3::new(1.0, 2.0, 3.0); 2];
/// constraints.impose(&mut v);
/// assert_eq!(v, [Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, 0.5)]);
/// ```
#[derive(Clone, Debug)]
pub struct Constraints {
    /// For each particle [`FREE`], [`HELD`], or an index into `others`.
    slots: Vec<u32>,
    /// The constraints of particles that are neither free nor held.
    others: Vec<Constraint>,
    /// The particles whose filter is not `Free`, in the order in which they were constrained.
    constrained: Vec<u32>,
}

/// The slot of a particle that moves freely.
const FREE: u32 = u32::MAX;
/// The slot of a particle with the filter [`Filter::Fixed`] and the prescribed value 0, such as a
/// pin.
const HELD: u32 = u32::MAX - 1;

#[derive(Clone, Copy, Debug)]
struct Constraint {
    filter: Filter,
    /// `(I − S) z`.
    prescribed: Vec3,
    particle: u32,
}

impl Constraints {
    /// `n` free particles, with room to constrain all of them, so that [`set`](Self::set) never
    /// allocates.
    pub fn free(n: usize) -> Self {
        Self { others: Vec::with_capacity(n), ..Self::free_or_held(n) }
    }

    /// `n` free particles, with room to hold all of them by [`Filter::Fixed`] with the prescribed
    /// value 0, as pins do. Any other constraint allocates memory.
    pub fn free_or_held(n: usize) -> Self {
        Self { slots: vec![FREE; n], others: Vec::new(), constrained: Vec::with_capacity(n) }
    }

    /// Number of particles, constrained or not.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Frees all particles.
    pub fn clear(&mut self) {
        for &i in &self.constrained {
            self.slots[i as usize] = FREE;
        }
        self.others.clear();
        self.constrained.clear();
    }

    /// Sets all prescribed values to 0; the filters stay.
    pub fn bring_to_rest(&mut self) {
        for constraint in &mut self.others {
            constraint.prescribed = Vec3::zeros();
        }
    }

    /// Replaces the constraint of one particle. Only the part `(I − S) z` of `prescribed` is used.
    ///
    /// # Panics
    /// If there is no such particle. In debug builds also if a normal or a direction is not a unit
    /// vector.
    pub fn set(&mut self, particle: usize, filter: Filter, prescribed: Vec3) {
        debug_assert!(filter.is_projector(), "not a unit vector: {filter:?}");
        let was_free = self.slots[particle] == FREE;
        let is_free = filter == Filter::Free;
        if was_free && !is_free {
            self.constrained.push(particle as u32);
        } else if !was_free && is_free {
            self.constrained.retain(|&i| i as usize != particle);
        }
        self.drop_other(particle);
        let prescribed = filter.complement(prescribed);
        self.slots[particle] = match filter {
            Filter::Free => FREE,
            Filter::Fixed if prescribed.iter().all(|z| z.to_bits() == 0) => HELD,
            _ => {
                self.others.push(Constraint { filter, prescribed, particle: particle as u32 });
                self.others.len() as u32 - 1
            }
        };
    }

    /// Takes a particle's entry out of `others`, if it has one there.
    fn drop_other(&mut self, particle: usize) {
        let slot = self.slots[particle] as usize;
        if slot < self.others.len() {
            self.others.swap_remove(slot);
            if let Some(moved) = self.others.get(slot) {
                self.slots[moved.particle as usize] = slot as u32;
            }
        }
    }

    /// The filter of particle `i`.
    pub fn filter(&self, i: usize) -> Filter {
        self.get(i).0
    }

    /// `(I − S) z` of particle `i`; zero where it is free.
    pub fn prescribed(&self, i: usize) -> Vec3 {
        self.get(i).1
    }

    fn get(&self, i: usize) -> (Filter, Vec3) {
        match self.slots[i] {
            FREE => (Filter::Free, Vec3::zeros()),
            HELD => (Filter::Fixed, Vec3::zeros()),
            slot => {
                let Constraint { filter, prescribed, .. } = self.others[slot as usize];
                (filter, prescribed)
            }
        }
    }

    /// The constrained particles, each once, in the order in which they were constrained.
    pub fn constrained(&self) -> &[u32] {
        &self.constrained
    }

    /// Whether some prescribed value `(I − S) z` is not zero.
    pub fn has_prescribed_motion(&self) -> bool {
        self.others.iter().any(|constraint| constraint.prescribed != Vec3::zeros())
    }

    /// Projects the vectors on the free directions: `x ← S x`.
    ///
    /// # Panics
    /// When `x` is not as long as there are particles.
    pub fn project(&self, x: &mut [Vec3]) {
        assert_eq!(x.len(), self.len(), "one vector a particle");
        for (i, filter, _) in self.each() {
            x[i] = filter.apply(x[i]);
        }
    }

    /// Makes the vectors obey the constraints: `x ← S x + (I − S) z`.
    ///
    /// # Panics
    /// When `x` is not as long as there are particles.
    pub fn impose(&self, x: &mut [Vec3]) {
        assert_eq!(x.len(), self.len(), "one vector a particle");
        for (i, filter, prescribed) in self.each() {
            x[i] = filter.apply(x[i]) + prescribed;
        }
    }

    /// Writes the prescribed values: `out ← (I − S) z`, zero in all free directions.
    ///
    /// # Panics
    /// When `out` is not as long as there are particles.
    pub fn prescribed_only(&self, out: &mut [Vec3]) {
        assert_eq!(out.len(), self.len(), "one vector a particle");
        out.fill(Vec3::zeros());
        for (i, _, prescribed) in self.each() {
            out[i] = prescribed;
        }
    }

    /// The constrained particles with their filters and prescribed values.
    fn each(&self) -> impl Iterator<Item = (usize, Filter, Vec3)> {
        self.constrained.iter().map(|&i| {
            let (filter, prescribed) = self.get(i as usize);
            (i as usize, filter, prescribed)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{Random, random_filter};

    #[test]
    fn filters_are_symmetric_projectors_that_match_their_matrices() {
        let mut random = Random::new(3);
        for _ in 0..200 {
            let filter = random_filter(&mut random);
            let v = random.vector();
            let s = filter.matrix();
            assert!((s - s.transpose()).norm() == 0.0);
            assert!((s * s - s).norm() < 1e-14);
            assert!((filter.apply(v) - s * v).norm() < 1e-14);
            assert!((filter.apply(v) + filter.complement(v) - v).norm() < 1e-14);
        }
    }

    #[test]
    fn setting_and_freeing_keeps_each_particle_once() {
        let mut constraints = Constraints::free(4);
        constraints.set(2, Filter::Fixed, Vec3::x());
        constraints.set(0, Filter::Fixed, Vec3::zeros());
        constraints.set(2, Filter::Plane { normal: Vec3::x() }, Vec3::zeros());
        assert_eq!(constraints.constrained(), [2, 0]);
        assert!(!constraints.has_prescribed_motion());
        constraints.set(2, Filter::Free, Vec3::x());
        assert_eq!(constraints.constrained(), [0]);
        assert_eq!(constraints.prescribed(2), Vec3::zeros());
        constraints.set(0, Filter::Fixed, Vec3::y());
        assert!(constraints.has_prescribed_motion());
        constraints.clear();
        assert_eq!(constraints.filter(0), Filter::Free);
        assert_eq!(constraints.prescribed(0), Vec3::zeros());
        assert!(constraints.constrained().is_empty() && !constraints.is_empty());
    }

    #[test]
    fn imposing_splits_a_vector_into_its_free_and_its_prescribed_part() {
        let mut random = Random::new(4);
        let n = 30;
        let mut constraints = Constraints::free(n);
        let z = random.vectors(n);
        for i in 0..n {
            constraints.set(i, random_filter(&mut random), z[i]);
        }
        let x = random.vectors(n);
        let (mut imposed, mut projected, mut rest) = (x.clone(), x.clone(), x.clone());
        constraints.impose(&mut imposed);
        constraints.project(&mut projected);
        constraints.prescribed_only(&mut rest);
        for i in 0..n {
            let s = constraints.filter(i).matrix();
            assert!((projected[i] - s * x[i]).norm() < 1e-14);
            assert!((rest[i] - (z[i] - s * z[i])).norm() < 1e-14);
            assert!((imposed[i] - (projected[i] + rest[i])).norm() < 1e-14);
        }
    }

    /// Compares with a plain list of filters and values through a random sequence of changes.
    #[test]
    fn the_compact_lists_hold_what_was_set_last() {
        let (mut random, n) = (Random::new(5), 12);
        for mut constraints in [Constraints::free(n), Constraints::free_or_held(n)] {
            let mut plain = vec![(Filter::Free, Vec3::zeros()); n];
            for change in 0..2000 {
                let i = (random.vector().x.abs() * 1e6) as usize % n;
                let filter = random_filter(&mut random);
                let z = if change % 3 == 0 { Vec3::zeros() } else { random.vector() };
                constraints.set(i, filter, z);
                plain[i] = (filter, filter.complement(z));
                match change % 501 {
                    500 => {
                        constraints.clear();
                        plain.fill((Filter::Free, Vec3::zeros()));
                    }
                    250 => {
                        constraints.bring_to_rest();
                        plain.iter_mut().for_each(|(_, z)| *z = Vec3::zeros());
                    }
                    _ => {}
                }
                let found = (0..n).map(|i| (constraints.filter(i), constraints.prescribed(i)));
                assert!(found.eq(plain.iter().copied()), "after {change} changes");
                let mut listed = constraints.constrained().to_vec();
                listed.sort_unstable();
                let bound = (0..n as u32).filter(|&i| plain[i as usize].0 != Filter::Free);
                assert!(listed.into_iter().eq(bound), "after {change} changes");
                let moves = plain.iter().any(|(_, z)| *z != Vec3::zeros());
                assert_eq!(constraints.has_prescribed_motion(), moves);
            }
        }
    }
}
