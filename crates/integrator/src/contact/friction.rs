//! Coulomb friction by constraints.

use super::basis::Basis;
use super::{Contact, ContactSet};
use drape_model::Vec3;
use drape_solvers::{Constraints, Filter};

/// The part of a solution that [`ContactSet::solve`] asks for, with memory for it.
#[derive(Debug)]
pub enum Wanted<'a> {
    /// Nothing.
    Nothing,
    /// The unfiltered residual `p = A v_+ − b`, kg m/s; one entry per particle.
    Impulse(&'a mut [Vec3]),
    /// The velocity `v_+`, m/s; one entry per particle.
    Velocity(&'a mut [Vec3]),
}

impl Wanted<'_> {
    /// Copies `velocity` if the velocity is wanted; calls `impulse` to write the residual if that
    /// is wanted.
    pub fn fill(self, velocity: &[Vec3], impulse: impl FnOnce(&mut [Vec3])) {
        match self {
            Self::Nothing => {}
            Self::Impulse(out) => impulse(out),
            Self::Velocity(out) => out.copy_from_slice(velocity),
        }
    }
}

/// A particle that its contacts cannot hold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slider {
    /// Its contacts are `first..end` of all.
    first: u32,
    end: u32,
    /// `1 − μλ/|p_t|`.
    share: f64,
}

impl Slider {
    fn contacts<'a>(&self, all: &'a [Contact]) -> &'a [Contact] {
        &all[self.first as usize..self.end as usize]
    }
}

impl ContactSet {
    /// Ends a solve in which every contact with friction stuck and took `impulse` (kg m/s). Where
    /// some of them slide it solves again, first without their friction, then with the velocity
    /// that friction leaves. Returns whether contacts across a gap pull after that; these are
    /// released, and the step must be solved again.
    pub(super) fn slide<E>(
        &mut self,
        constraints: &mut Constraints,
        impulse: &mut [Vec3],
        mut solve: impl FnMut(&Constraints, super::Wanted<'_>) -> Result<(), E>,
    ) -> Result<bool, E> {
        if !self.rubs {
            return Ok(false);
        }
        self.find_sliders(impulse);
        if self.sliders.is_empty() {
            return Ok(false);
        }
        for slider in &self.sliders {
            let group = slider.contacts(&self.candidates);
            let basis = Basis::of(group);
            let target = basis.combine(|contact| contact.target);
            constraints.set(group[0].particle as usize, basis.filter(), target);
        }
        let velocity = impulse;
        solve(constraints, Wanted::Velocity(&mut *velocity))?;
        for slider in &self.sliders {
            let group = slider.contacts(&self.candidates);
            let (basis, particle) = (Basis::of(group), group[0].particle as usize);
            let v_s = basis.surface().unwrap_or_default();
            let target = basis.combine(|contact| contact.target);
            let slip = (velocity[particle] - v_s) * slider.share;
            let along = basis.filter().apply(v_s + slip);
            constraints.set(particle, Filter::Fixed, target + along);
        }
        if !self.has_open_gaps() {
            solve(constraints, Wanted::Nothing)?;
            return Ok(false);
        }
        let impulse = velocity;
        solve(constraints, Wanted::Impulse(&mut *impulse))?;
        Ok(self.release(impulse, Contact::is_open))
    }

    fn find_sliders(&mut self, impulse: &[Vec3]) {
        self.sliders.clear();
        let mut first = 0;
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let end = first + group.len() as u32;
            let basis = Basis::of(group);
            if basis.surface().is_some() {
                let p = &impulse[group[0].particle as usize];
                let limit: f64 = basis.multipliers(p).map(|(c, l)| c.friction * l.max(0.0)).sum();
                let needed = basis.filter().apply(*p).norm();
                if needed > limit {
                    self.sliders.push(Slider { first, end, share: 1.0 - limit / needed });
                }
            }
            first = end;
        }
    }
}

impl Basis<'_> {
    /// Velocity of the rough surface, if there is one: friction is relative to it.
    pub(super) fn surface(&self) -> Option<Vec3> {
        let rough = self.contacts().find(|contact| contact.friction > 0.0)?;
        Some(rough.surface.unwrap_or_default())
    }

    /// The velocity along the surface that friction leaves of `along`, m/s, where the contacts
    /// raise the normal velocity from `before` to `after`.
    pub(super) fn rub(&self, before: &Vec3, along: Vec3, after: impl Fn(&Contact) -> f64) -> Vec3 {
        let Some(v_s) = self.surface() else { return along };
        let gained = |contact: &Contact| (after(contact) - contact.normal.dot(before)).max(0.0);
        let limit: f64 = self.contacts().map(|contact| contact.friction * gained(contact)).sum();
        let carried = self.filter().apply(v_s);
        let slip = along - carried;
        let length = slip.norm();
        if length <= limit { carried } else { carried + slip * (1.0 - limit / length) }
    }
}
