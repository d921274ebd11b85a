//! The constraints of a system, and the order in which a sweep solves them.

use crate::chains::{Chains, Places, springs_of};
use crate::cover::Graph;
use drape_integrator::{CompliantAngles, change_each, each_particle};
use drape_model::{Revisions, System, Vec3};
use drape_solvers::bands::bands;

/// Lines that share no particle.
#[derive(Clone, Debug)]
struct Family {
    /// Place of its effect among the effects with springs.
    chains: usize,
    /// Its number among the families of that effect.
    family: usize,
    /// Whether its damping acts in all directions.
    is_damped: bool,
    /// `kτ²` of its stiffest spring, kg.
    stiffest: f64,
    /// Its place among the families as they were found; decides between equals.
    number: usize,
}

/// All springs and angles of a system, as constraints that yield.
#[derive(Debug)]
pub(crate) struct Net {
    angles: Vec<CompliantAngles>,
    chains: Vec<Chains>,
    /// From the softest to the stiffest.
    families: Vec<Family>,
    /// `1/m`, 0 where pinned.
    inverse_mass: Vec<f64>,
    /// The system and the `τ` that the numbers are for.
    present: Option<(Revisions, u64)>,
    /// How far springs and angles moved each particle in the last substep, m. Like the next two
    /// empty without full damping.
    pending: Vec<Vec3>,
    /// How far full damping did, m.
    damped: Vec<Vec3>,
    /// Ways before the springs, m.
    before: Vec<Vec3>,
    /// `τ²` of the last substep; 0 if there is none.
    last_square: f64,
}

impl Net {
    /// The constraints of a system.
    pub(crate) fn new(system: &System) -> Self {
        let n = system.len();
        let graph = Graph::new(n, system.effects().flat_map(springs_of));
        let chains = system
            .effects()
            .enumerate()
            .filter_map(|e| Chains::new(e, (n, system.threads()), &graph));
        let chains: Vec<_> = chains.collect();
        let found = chains.iter().enumerate();
        let found = found.flat_map(|(k, list)| (0..list.families()).map(move |f| (k, list, f)));
        let family = |(number, (chains, list, family)): (usize, (usize, &Chains, usize))| {
            let is_damped = list.has_full_damping();
            Family { chains, family, is_damped, stiffest: 0.0, number }
        };
        let families = found.enumerate().map(family).collect();
        let damped = if chains.iter().any(Chains::has_full_damping) { n } else { 0 };
        Self {
            angles: system
                .effects()
                .enumerate()
                .filter_map(|e| CompliantAngles::new(e, n, false))
                .collect(),
            families,
            chains,
            inverse_mass: vec![0.0; n],
            present: None,
            pending: vec![Vec3::zeros(); damped],
            damped: vec![Vec3::zeros(); damped],
            before: vec![Vec3::zeros(); damped],
            last_square: 0.0,
        }
    }

    /// Forgets the last substep.
    pub(crate) fn restart(&mut self) {
        self.last_square = 0.0;
    }

    /// Whether what constraints did in the last substep tells of one with this `τ`.
    pub(crate) fn bridges(&self, tau: f64) -> bool {
        (0.25..=4.0).contains(&(tau * tau / self.last_square))
    }

    /// Follows changes of the system and of `τ`, and expects of the springs what they did in the
    /// last substep.
    pub(crate) fn refresh(&mut self, system: &System, tau: f64) {
        let square = tau * tau;
        let present = Some((system.revisions(), tau.to_bits()));
        let last = std::mem::replace(&mut self.present, present);
        if last.map(|(revisions, _)| revisions) != Some(system.revisions()) {
            self.restart();
        }
        if self.last_square == 0.0 {
            self.expect(0.0);
        } else if self.last_square != square {
            self.expect(square / self.last_square);
        }
        self.last_square = square;
        if last == present {
            return;
        }
        let particles = system.mass().iter().zip(system.pinned());
        for (w, (mass, pinned)) in self.inverse_mass.iter_mut().zip(particles) {
            *w = if *pinned { 0.0 } else { 1.0 / mass };
        }
        for chains in &mut self.chains {
            chains.refresh(system, &self.inverse_mass, tau);
        }
        for family in &mut self.families {
            family.stiffest = self.chains[family.chains].stiffest(family.family);
        }
        let softer = |a: &Family, b: &Family| {
            a.stiffest.total_cmp(&b.stiffest).then(a.number.cmp(&b.number))
        };
        self.families.sort_unstable_by(softer);
    }

    /// Solves every line once: full damping, then angles, then springs from soft to stiff.
    pub(crate) fn sweep(
        &mut self,
        system: &System,
        tau: f64,
        (base, way): (&[Vec3], &mut [Vec3]),
        is_first: bool,
    ) {
        let Self { angles, chains, families, inverse_mass, pending, damped, before, .. } = self;
        if is_first && !damped.is_empty() {
            change_each(system, way, |i, way| *way += damped[i]);
        }
        each_particle(system, damped, |_| Vec3::zeros());
        let bands = bands(system.threads(), system.len());
        let mut places = Places { base, way, inverse_mass, bands };
        for Family { chains: k, family, .. } in families.iter().filter(|family| family.is_damped) {
            let pending = is_first.then_some(&pending[..]);
            chains[*k].brake(*family, &mut places, pending, damped); // (L3)
        }
        if is_first {
            each_particle(system, pending, |_| Vec3::zeros());
        }
        let way = &*places.way;
        each_particle(system, before, |i| way[i]);
        for list in angles {
            list.sweep(system, tau, (base, places.way), inverse_mass, is_first); // (L4)
        }
        for Family { chains: k, family, .. } in &*families {
            chains[*k].pull(*family, system, tau, &mut places, is_first); // (L5), (L6)
        }
        let way = &*places.way;
        change_each(system, pending, |i, pending| *pending += way[i] - before[i]);
    }

    /// Expects of springs and full damping what they did in the last substep, times a factor.
    fn expect(&mut self, factor: f64) {
        for way in self.pending.iter_mut().chain(&mut self.damped) {
            *way = if factor == 0.0 { Vec3::zeros() } else { *way * factor };
        }
        self.chains.iter_mut().for_each(|chains| chains.scale_damping(factor));
    }
}
