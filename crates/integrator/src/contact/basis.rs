//! The independent contacts of a particle.

use super::{Contact, DEPENDENT};
use drape_model::Vec3;
use drape_solvers::Filter;

/// The contacts of one particle with independent normals, one to three.
pub(super) struct Basis<'a> {
    contacts: [Option<&'a Contact>; 3],
    /// Orthonormal; the first `k` span the first `k` normals, for each `k`.
    axes: [Vec3; 3],
    pub(super) len: usize,
}

impl<'a> Basis<'a> {
    pub(super) fn of(group: &'a [Contact]) -> Self {
        let mut basis = Self { contacts: [None; 3], axes: [Vec3::zeros(); 3], len: 0 };
        for contact in group {
            let mut rest = contact.normal;
            for axis in &basis.axes[..basis.len] {
                rest -= axis * axis.dot(&rest);
            }
            let distance = rest.norm();
            if basis.len < 3 && distance > DEPENDENT {
                basis.axes[basis.len] = rest / distance;
                basis.contacts[basis.len] = Some(contact);
                basis.len += 1;
            }
        }
        basis
    }

    pub(super) fn contacts(&self) -> impl Iterator<Item = &'a Contact> {
        self.contacts.iter().flatten().copied()
    }

    pub(super) fn filter(&self) -> Filter {
        match self.len {
            0 => Filter::Free,
            1 => Filter::Plane { normal: self.axes[0] },
            2 => Filter::Line { direction: self.axes[0].cross(&self.axes[1]).normalize() },
            _ => Filter::Fixed,
        }
    }

    /// The velocity `z` in the span of the normals with `n_k·z` as given. Normals at a flat angle
    /// would ask for a long `z`; it is cut to the length that orthogonal normals would give.
    pub(super) fn combine(&self, normal_velocity: impl Fn(&Contact) -> f64) -> Vec3 {
        let (mut z, mut squares) = (Vec3::zeros(), 0.0);
        for (contact, axis) in self.contacts().zip(&self.axes) {
            let wanted = normal_velocity(contact);
            z += axis * ((wanted - contact.normal.dot(&z)) / contact.normal.dot(axis));
            squares += wanted * wanted;
        }
        let longest = squares.sqrt();
        let length = z.norm();
        if length > longest { z * (longest / length) } else { z }
    }

    /// The contacts, last first, with their `λ_k` of `p = Σ λ_k n_k + S p`.
    pub(super) fn multipliers(&self, impulse: &Vec3) -> impl Iterator<Item = (&'a Contact, f64)> {
        let mut rest = *impulse;
        let contacts = self.contacts[..self.len].iter().zip(&self.axes).rev();
        contacts.filter_map(move |(contact, axis)| {
            // Of the remaining contacts only this one has a part along its axis.
            let contact = (*contact)?;
            let multiplier = axis.dot(&rest) / axis.dot(&contact.normal);
            rest -= contact.normal * multiplier;
            Some((contact, multiplier))
        })
    }

    /// The normal of the contact with the least `λ_k` among those that `may_end`, if that is
    /// negative.
    pub(super) fn pulling(
        &self,
        impulse: &Vec3,
        may_end: impl Fn(&Contact) -> bool,
    ) -> Option<Vec3> {
        let mut worst = None;
        let mut least = 0.0;
        for (contact, multiplier) in self.multipliers(impulse) {
            if may_end(contact) && multiplier + contact.slack < least {
                least = multiplier;
                worst = Some(contact.normal);
            }
        }
        worst
    }
}
