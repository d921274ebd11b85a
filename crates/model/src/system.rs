//! The running system: masses, effects, pins, obstacles, with revisions.

use crate::bounds::{MAX_COEFFICIENT, MIN_MASS};
use crate::effects::batch::{self, Quads};
use crate::effects::sweep::{self, Begin, Finish, MAX_PASSES, Windows};
use crate::effects::{Effect, Linearised, Part, Pass, StiffnessProduct, pairs, tangent};
use crate::{ContactSpec, EffectKind, Level, MovingPin, Obstacle, Vec3};
use drape_kernels::blocks::{BlockLayout, Coupling};
use rayon::prelude::*;
use std::num::NonZero;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

/// Stamps of those parts of a system on which cached operators depend. Two systems with the same
/// stamp hold the same data in that part: every change draws a new stamp that was never used
/// before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Revisions {
    /// Masses.
    pub mass: u64,
    /// Stiffnesses and rest lengths.
    pub stiffness: u64,
    /// Damping coefficients.
    pub damping: u64,
    /// The set of pinned particles.
    pub pins: u64,
    /// Which particles are coupled. A change requires a new sparsity pattern.
    pub topology: u64,
}

/// Number of particles that a thread finishes at a time.
const PIECE: usize = 4096;

fn new_stamp() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// A discretised cloth with everything that acts on it. It does not change during a step.
#[derive(Debug)]
pub struct System {
    name: String,
    mass: Vec<f64>,
    effects: Vec<Box<dyn Effect>>,
    pinned: Vec<bool>,
    /// The pinned particles, in increasing order, with room for all.
    pins: Vec<u32>,
    moving_pins: Vec<MovingPin>,
    obstacles: Vec<Obstacle>,
    contact: ContactSpec,
    revisions: Revisions,
    /// Number of threads that kernels may use.
    threads: usize,
    /// Scratch for sweeps over several effects at once.
    memory: Mutex<SweepMemory>,
}

/// Scratch for sweeps over several effects at once, for both kernels. A part that no spring needs
/// is empty.
#[derive(Debug)]
struct SweepMemory {
    windows: Windows,
    quads: Quads,
}

impl SweepMemory {
    fn new(mass: &[f64], effects: &[Box<dyn Effect>], threads: usize) -> Mutex<Self> {
        let passes = || effects.iter().filter_map(|effect| effect.pass(mass, Part::Force));
        let is_listed = passes().any(|pass| matches!(pass, Pass::Listed(_)));
        let springs = passes().filter_map(|pass| pass.springs().map(|springs| springs.diagonals));
        Mutex::new(Self {
            windows: Windows::new(threads, springs),
            quads: Quads::new(if is_listed { mass.len() } else { 0 }),
        })
    }

    /// Whether one sweep can take these passes.
    fn fits<'a>(&self, passes: impl Iterator<Item = &'a Pass<'a>> + Clone) -> bool {
        let is_listed = passes.clone().any(|pass| matches!(pass, Pass::Listed(_)));
        let is_diagonal = passes.clone().any(|pass| matches!(pass, Pass::Springs(_)));
        match (is_listed, is_diagonal) {
            (false, _) => self.windows.fits(passes),
            (true, true) => false,
            (true, false) => passes.into_iter().all(|pass| match pass {
                Pass::Listed(springs) => springs.list.particles <= self.quads.particles(),
                Pass::Field(field) => field.mass.len() == self.quads.particles(),
                Pass::Springs(_) => false,
            }),
        }
    }
}

/// Passes collected for the next sweep.
#[derive(Default)]
struct Passes<'a> {
    list: [Option<Pass<'a>>; MAX_PASSES],
    count: usize,
}

impl<'a> Passes<'a> {
    /// Adds a pass if it can share the sweep.
    fn push(&mut self, pass: Pass<'a>, memory: &SweepMemory) -> bool {
        if self.count == MAX_PASSES {
            return false;
        }
        self.list[self.count] = Some(pass);
        let fits = memory.fits(self.list.iter().flatten());
        if fits {
            self.count += 1;
        } else {
            self.list[self.count] = None;
        }
        fits
    }

    /// Sweeps over the collected passes and forgets them. Returns whether the forces were finished
    /// on the way.
    fn sweep(
        &mut self,
        memory: &mut Option<MutexGuard<'_, SweepMemory>>,
        Level { x, v, .. }: Level<'_>,
        out: &mut [Vec3],
        begin: &mut Begin,
        finish: Option<&Finish<'_>>,
    ) -> bool {
        let passes = &self.list[..self.count];
        let mut is_finished = false;
        match (memory, passes.iter().flatten().any(|pass| matches!(pass, Pass::Listed(_)))) {
            (Some(memory), true) => batch::add(passes, &mut memory.quads, x, v, out, *begin),
            (Some(memory), false) if self.count > 0 => {
                sweep::add(passes, &mut memory.windows, x, v, out, *begin, finish);
                is_finished = finish.is_some();
            }
            _ => return false,
        }
        *begin = Begin::Present;
        *self = Self::default();
        is_finished
    }
}

/// The springs of all these effects, if one sweep can take them together with their damping.
fn tangent_passes<'a>(
    effects: impl Iterator<Item = &'a dyn Effect>,
    mass: &'a [f64],
    memory: &SweepMemory,
) -> Option<Passes<'a>> {
    let mut passes = Passes::default();
    for effect in effects {
        let pass = effect.pass(mass, Part::All)?;
        let taken = pass.springs().is_some() && passes.push(pass, memory);
        taken.then_some(())?;
    }
    Some(passes)
}

/// The pinned particles. The list has room for all particles, so pinning another one never
/// allocates.
fn pins(pinned: &[bool]) -> Vec<u32> {
    let mut pins = Vec::with_capacity(pinned.len());
    pins.extend((0..).zip(pinned).filter_map(|(i, pinned)| pinned.then_some(i)));
    pins
}

impl Clone for System {
    fn clone(&self) -> Self {
        let effects: Vec<_> = self.effects.iter().map(|effect| effect.boxed_clone()).collect();
        Self {
            name: self.name.clone(),
            mass: self.mass.clone(),
            memory: SweepMemory::new(&self.mass, &effects, self.threads),
            threads: self.threads,
            effects,
            pinned: self.pinned.clone(),
            pins: pins(&self.pinned),
            moving_pins: self.moving_pins.clone(),
            obstacles: self.obstacles.clone(),
            contact: self.contact,
            revisions: self.revisions,
        }
    }
}

impl System {
    /// Assembles a system. [`crate::SystemSpec::build`] checks the values first.
    pub(crate) fn new(
        name: String,
        mass: Vec<f64>,
        effects: Vec<Box<dyn Effect>>,
        (pinned, moving_pins): (Vec<bool>, Vec<MovingPin>),
        obstacles: Vec<Obstacle>,
        contact: ContactSpec,
    ) -> Self {
        let stamp = new_stamp();
        let revisions = Revisions {
            mass: stamp,
            stiffness: stamp,
            damping: stamp,
            pins: stamp,
            topology: stamp,
        };
        let memory = SweepMemory::new(&mass, &effects, 1);
        Self {
            name,
            mass,
            effects,
            pins: pins(&pinned),
            pinned,
            moving_pins,
            obstacles,
            contact,
            revisions,
            threads: 1,
            memory,
        }
    }

    /// Name of the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.mass.len()
    }

    /// Whether the system has no particles.
    pub fn is_empty(&self) -> bool {
        self.mass.is_empty()
    }

    /// Masses, kg; one per particle.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// The effects that the scene names, in a fixed order.
    pub fn effects(&self) -> impl Iterator<Item = &dyn Effect> + Clone {
        self.effects.iter().map(AsRef::as_ref)
    }

    /// Adds an effect after all others, for example one that a user wrote. Cached operators are
    /// then rebuilt.
    pub fn add_effect(&mut self, effect: Box<dyn Effect>) {
        self.effects.push(effect);
        self.memory = SweepMemory::new(&self.mass, &self.effects, self.threads);
        let stamp = new_stamp();
        let Revisions { stiffness, damping, topology, .. } = &mut self.revisions;
        [*stiffness, *damping, *topology] = [stamp; 3];
    }

    /// Whether each particle is pinned.
    pub fn pinned(&self) -> &[bool] {
        &self.pinned
    }

    /// The indices of the pinned particles, in increasing order.
    pub fn pins(&self) -> &[u32] {
        &self.pins
    }

    /// Sets the vectors of the pinned particles to zero. `vectors` has one entry per particle.
    pub fn clear_pinned(&self, vectors: &mut [Vec3]) {
        self.pins.iter().for_each(|&pin| vectors[pin as usize] = Vec3::zeros());
    }

    /// The pinned particles that follow paths.
    pub fn moving_pins(&self) -> &[MovingPin] {
        &self.moving_pins
    }

    /// The obstacles.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// How contacts are treated.
    pub fn contact(&self) -> &ContactSpec {
        &self.contact
    }

    /// The stamps that serve as keys of cached operators.
    pub fn revisions(&self) -> Revisions {
        self.revisions
    }

    /// How many threads the kernels of this system may use.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Sets how many threads of the current [`rayon`] pool the kernels may use. They use several
    /// threads only if there are enough particles. The number of threads does not change any bit of
    /// the results. The change takes effect in an integrator's next step.
    pub fn set_threads(&mut self, threads: NonZero<usize>) {
        self.threads = threads.get();
        self.memory = SweepMemory::new(&self.mass, &self.effects, self.threads);
    }

    /// Writes the total force of all effects, conservative and damping, N, to `out`.
    pub fn forces(&self, at: Level<'_>, out: &mut [Vec3]) {
        self.write_forces(self.effects().map(|effect| (effect, Part::All)), at, out);
    }

    /// As [`add_forces`](Self::add_forces), but overwrites `out`.
    pub fn write_forces<'a>(
        &'a self,
        terms: impl Iterator<Item = (&'a dyn Effect, Part)>,
        at: Level<'_>,
        out: &mut [Vec3],
    ) {
        self.sum_forces(terms, at, out, Begin::Zero, None);
    }

    /// As [`write_forces`](Self::write_forces), but also calls `finish` once with the force of
    /// every particle. Each call gets some particles, if possible while their forces are in a
    /// cache. With several [threads](Self::threads), calls may come from any of them. `finish` must
    /// not hand work to other threads.
    pub fn write_forces_and<'a>(
        &'a self,
        terms: impl Iterator<Item = (&'a dyn Effect, Part)>,
        at: Level<'_>,
        out: &mut [Vec3],
        finish: &(dyn Fn(Range<usize>, &mut [Vec3]) + Sync),
    ) {
        self.sum_forces(terms, at, out, Begin::Zero, Some(finish));
    }

    /// Adds the given parts of the effects' forces at one level, N, to `out`, effect by effect in
    /// the given order. Neighbours in that order share a sweep if possible; sharing does not change
    /// any bit.
    pub fn add_forces<'a>(
        &'a self,
        terms: impl Iterator<Item = (&'a dyn Effect, Part)>,
        at: Level<'_>,
        out: &mut [Vec3],
    ) {
        self.sum_forces(terms, at, out, Begin::Present, None);
    }

    fn sum_forces<'a>(
        &'a self,
        terms: impl Iterator<Item = (&'a dyn Effect, Part)>,
        at: Level<'_>,
        out: &mut [Vec3],
        mut begin: Begin,
        finish: Option<&Finish<'_>>,
    ) {
        let mut memory = self.memory.try_lock().ok();
        let mut pending = Passes::default();
        for (effect, part) in terms {
            let pass = memory.as_ref().and(effect.pass(&self.mass, part));
            let is_taken =
                |pending: &mut Passes<'a>, memory: &Option<MutexGuard<'_, SweepMemory>>| {
                    pass.zip(memory.as_ref())
                        .is_some_and(|(pass, memory)| pending.push(pass, memory))
                };
            if is_taken(&mut pending, &memory) {
                continue;
            }
            pending.sweep(&mut memory, at, out, &mut begin, None);
            if !is_taken(&mut pending, &memory) {
                begin.clear(out);
                effect.add_part(part, &self.mass, at, out);
            }
        }
        let is_finished = pending.sweep(&mut memory, at, out, &mut begin, finish);
        begin.clear(out);
        if let (Some(finish), false) = (finish, is_finished) {
            self.finish_all(finish, out);
        }
    }

    /// Finishes all forces after the sweeps.
    fn finish_all(&self, finish: &Finish<'_>, out: &mut [Vec3]) {
        if self.threads == 1 || out.len() < PIECE {
            return finish(0..out.len(), out);
        }
        out.par_chunks_mut(PIECE).enumerate().for_each(|(k, out)| {
            finish(k * PIECE..k * PIECE + out.len(), out);
        });
    }

    /// The matrix layout that suits the Jacobians of these effects. [`linearise`](Self::linearise)
    /// can fill two layouts: bands, for springs of regular grids with distinct offsets, and pairs,
    /// for springs in any order. Both require full damping or none.
    pub fn coupling<'a>(
        &'a self,
        effects: impl Iterator<Item = &'a dyn Effect> + Clone,
    ) -> Coupling {
        if let Some(offsets) = self.bands(effects.clone()) {
            return Coupling::Bands(offsets);
        }
        if self.are_listed(effects) { Coupling::Pairs } else { Coupling::Rows }
    }

    /// The offsets `j − i` of all pairs, if a sweep can take all effects.
    fn bands<'a>(&'a self, effects: impl Iterator<Item = &'a dyn Effect>) -> Option<Vec<usize>> {
        let memory = self.memory.try_lock().ok()?;
        let passes = tangent_passes(effects, &self.mass, &memory)?;
        let springs = passes.list.iter().flatten().filter_map(Pass::springs);
        let diagonals = springs.flat_map(|springs| &springs.diagonals.list);
        let mut offsets: Vec<usize> = diagonals.map(|d| d.offset).collect();
        let count = offsets.len();
        offsets.sort_unstable();
        offsets.dedup();
        (offsets.len() == count).then_some(offsets)
    }

    fn are_listed<'a>(&'a self, mut effects: impl Iterator<Item = &'a dyn Effect>) -> bool {
        effects.all(|effect| pairs::listed(effect, &self.mass).is_some())
    }

    /// Overwrites `matrix` with `M + σ K + τ D` of the effects and adds `K w` to `product`, if it
    /// is given. It sums effect by effect in the given order, and gives the same bits as
    /// [`Effect::add_stiffness`] and [`Effect::add_damping`]; the blocks of springs in any order are
    /// the same numbers up to rounding. The matrix must have the layout that
    /// [`coupling`](Self::coupling) returns.
    ///
    /// Returns `false` and does nothing in four cases: a sweep cannot take these effects, another
    /// thread is sweeping, the matrix was made for other springs, or `σ` is negative and the springs
    /// are in any order.
    ///
    /// # Panics
    /// If a vector does not have one entry per particle.
    #[must_use = "false means that nothing was computed"]
    pub fn linearise<'a>(
        &'a self,
        effects: impl Iterator<Item = &'a dyn Effect> + Clone,
        at: &Linearised<'_>,
        matrix: BlockLayout<'_>,
        product: Option<StiffnessProduct<'_>>,
    ) -> bool {
        let matrix = match matrix {
            BlockLayout::Bands(matrix) => matrix,
            BlockLayout::Pairs(matrix) => {
                let springs = effects.clone().filter_map(|e| pairs::listed(e, &self.mass));
                return self.are_listed(effects)
                    && pairs::add(springs, &self.mass, at, matrix, product);
            }
        };
        let Ok(memory) = self.memory.try_lock() else { return false };
        let Some(passes) = tangent_passes(effects, &self.mass, &memory) else { return false };
        let passes = &passes.list[..passes.count];
        tangent::add(passes, &memory.windows, &self.mass, at, matrix, product);
        true
    }

    /// Replaces the masses, kg. Returns `false` and changes nothing if the list has another length,
    /// or if a value is not from 1e-30 to 1e30.
    #[must_use = "false means that nothing was changed"]
    pub fn set_mass(&mut self, mass: &[f64]) -> bool {
        if mass.len() != self.len()
            || !mass.iter().all(|m| (MIN_MASS..=MAX_COEFFICIENT).contains(m))
        {
            return false;
        }
        self.mass.copy_from_slice(mass);
        self.revisions.mass = new_stamp();
        true
    }

    /// Multiplies all stiffnesses of the effect of this kind. Returns `false` and changes nothing
    /// if there is no such effect, if it has no stiffness, or if the factor is not positive and
    /// finite.
    #[must_use = "false means that nothing was changed"]
    pub fn scale_stiffness(&mut self, kind: impl Into<EffectKind>, factor: f64) -> bool {
        let changed = self.scale(kind.into(), factor, |effect| effect.scale_stiffness(factor));
        if changed {
            self.revisions.stiffness = new_stamp();
        }
        changed
    }

    /// As [`scale_stiffness`](Self::scale_stiffness), but for all damping coefficients.
    #[must_use = "false means that nothing was changed"]
    pub fn scale_damping(&mut self, kind: impl Into<EffectKind>, factor: f64) -> bool {
        let changed = self.scale(kind.into(), factor, |effect| effect.scale_damping(factor));
        if changed {
            self.revisions.damping = new_stamp();
        }
        changed
    }

    /// Lets `apply` scale the first effect of this kind that it can.
    fn scale(
        &mut self,
        kind: EffectKind,
        factor: f64,
        apply: impl Fn(&mut dyn Effect) -> bool,
    ) -> bool {
        let mut same = self.effects.iter_mut().filter(|effect| effect.kind() == kind);
        factor > 0.0 && factor.is_finite() && same.any(|effect| apply(effect.as_mut()))
    }

    /// Pins or frees one particle. Returns `false` if the index is out of range. A freed particle
    /// leaves its path permanently.
    #[must_use = "false means that nothing was changed"]
    pub fn set_pinned(&mut self, particle: usize, pinned: bool) -> bool {
        let Some(slot) = self.pinned.get_mut(particle) else { return false };
        if *slot != pinned {
            *slot = pinned;
            match self.pins.binary_search(&(particle as u32)) {
                Ok(place) => drop(self.pins.remove(place)),
                Err(place) => self.pins.insert(place, particle as u32),
            }
            self.moving_pins.retain(|pin| pin.particle != particle);
            self.revisions.pins = new_stamp();
        }
        true
    }
}
