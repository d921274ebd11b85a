//! The constraints of a system.

use crate::lanes::{Cut, Quads};
use crate::settings::Sweep;
use crate::springs::{Pass, Places, Springs};
use drape_integrator::CompliantAngles;
use drape_model::{Revisions, System, Vec3};
use drape_solvers::bands::bands;

/// All springs and angles of a system, as constraints that yield.
#[derive(Debug)]
pub(crate) struct Net {
    springs: Vec<Springs>,
    bends: Vec<CompliantAngles>,
    /// `1/m`, 0 where pinned.
    inverse_mass: Vec<f64>,
    /// The particles as registers.
    quads: Quads,
    /// The system and the `τ` that the numbers are for.
    present: Option<(Revisions, u64)>,
}

impl Net {
    /// The constraints of a system in the order of a sweep.
    pub(crate) fn new(system: &System, sweep: Sweep) -> Self {
        let (n, is_coloured) = (system.len(), sweep == Sweep::Coloured);
        let effects = || system.effects().enumerate();
        let cut = Cut::new(n);
        Self {
            springs: effects().filter_map(|e| Springs::new(e, cut, is_coloured)).collect(),
            bends: effects().filter_map(|e| CompliantAngles::new(e, n, is_coloured)).collect(),
            inverse_mass: vec![0.0; n],
            quads: Quads::new(cut),
            present: None,
        }
    }

    /// Follows changes of the system and of `τ`.
    pub(crate) fn refresh(&mut self, system: &System, tau: f64) {
        let present = Some((system.revisions(), tau.to_bits()));
        if std::mem::replace(&mut self.present, present) == present {
            return;
        }
        let particles = system.mass().iter().zip(system.pinned());
        for (w, (mass, pinned)) in self.inverse_mass.iter_mut().zip(particles) {
            *w = if *pinned { 0.0 } else { 1.0 / mass };
        }
        self.quads.weigh(&self.inverse_mass);
        for springs in &mut self.springs {
            springs.refresh(system, &self.inverse_mass, tau);
        }
    }

    /// Projects every constraint once, effect by effect: the springs, then the angles.
    pub(crate) fn sweep(
        &mut self,
        system: &System,
        tau: f64,
        (base, way): (&[Vec3], &mut [Vec3]),
        pass: Pass,
    ) {
        let Self { springs, bends, inverse_mass, quads, .. } = self;
        if pass.is_first {
            quads.share(bands(system.threads(), base.len()));
            quads.start(base);
        }
        let mut places = Places { base, way, inverse_mass, quads, is_wide: false };
        springs.iter_mut().for_each(|list| list.sweep(system, tau, &mut places, pass));
        places.narrow();
        for list in bends {
            list.sweep(system, tau, (base, places.way), inverse_mass, pass.is_first);
        }
    }
}
