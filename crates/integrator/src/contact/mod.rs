//! Contacts with rigid obstacles by velocity constraints (EEH section 6).
//!
//! A particle inside an obstacle, or within 1e-9 m of its surface, gets a prescribed normal
//! velocity that leads it back to the surface:
//!
//! ```text
//! n·v_+ = (1/τ) n·(x_s − x*)
//! ```
//!
//! `n` is the outward normal, `x_s` the nearest point of the surface, and the step moves the
//! particle `x* → x* + τ v_+`. The paper prints `x_{n+1}` for `x*`: then `v_+` stands on both
//! sides, and only half of the penetration is corrected. The paper leaves these questions open:
//!
//! * **Release.** After the solve the unfiltered residual `p = A v_+ − b` is the impulse of the
//!   constraints, `p = Σ λ_k n_k`. A contact with a negative `λ_k` would pull. The contact that
//!   pulls most is released and the step is solved again, at most three times.
//! * **No chatter.** Without friction and speculation, geometry alone decides whether a particle
//!   touches. A particle at rest therefore stays in contact, whatever its history, even after a
//!   restart.
//! * **No pop.** The scene limits the speed of recovery. After the update of positions the normal
//!   velocity is reduced to the value that the impact left (split impulse). So the correction of a
//!   penetration gives the particle no kinetic energy.
//! * **Restitution.** A particle that arrives with normal velocity `a < 0` leaves with `−e a`. A
//!   flight of a few steps does not count as a bounce: a particle that was in contact a few steps
//!   ago stays in contact. Otherwise gravity would undo the rebound in every step, and a particle
//!   with `e > 0` would never come to rest.
//! * **Several obstacles.** The contacts of a particle are taken in the order of their targets,
//!   greatest first, as long as their normals are independent. One contact leaves the particle a
//!   plane to move in, two contacts a line, three contacts a point. If obstacles contradict each
//!   other (opposite normals), the deeper penetration wins.
//!
//! [`ContactSet::detect_altering`] moves the particle to the surface directly, instead of leading
//! it there by its velocity (Baraff & Witkin 1998, section 6). The step then moves
//! `x* → x* + τ v_+ + y`, where `y` is the displacement to the surface. `v_+` is prescribed as if
//! the particle were already there.
//!
//! The `x*` of a multistep method holds some of the past motion. [`ContactSet::detect_multistep`]
//! finds contacts at `x_n` and prescribes the `v_+` that leads to the same place as the rules
//! above. Two differences prevent a bounce from changing the energy. A rebound moves the particle
//! by the mean of the velocities before and after, as order 2 requires. A particle that leaves an
//! obstacle by itself within a few steps is released.
//!
//! An obstacle on a path is treated in a frame that moves with `v_s`, the obstacle's mean velocity
//! over the step. All velocities above are then relative to the surface. A particle at rest on a
//! moving obstacle is carried along, `n·v_+ = (1/τ) n·(x_s(t_+) − x*)`. A bouncing particle bounces
//! in the frame of the obstacle.
//!
//! Pins on paths get the velocity `z = (path(t_+) − x*)/τ`, which puts them on the path at the end
//! of the step for any `x*`.
//!
//! Friction follows Coulomb's law, by the same constraints.
//!
//! * **Stick.** At first every contact with friction holds its particle, with the velocity of the
//!   surface along it. If the impulse `p` of this constraint lies in the cone `|p_t| ≤ μ λ`, it is
//!   the solution. Particles then do not creep, however long they stick.
//! * **Slide.** Outside the cone the step is solved without friction there, which gives `v_t` along
//!   the surface. It is then solved with `v_s + (1 − μλ/|p_t|) (v_t − v_s)` along the surface. For
//!   a single particle this is exactly Coulomb's law. Particles that slide side by side see in
//!   `p_t` that their neighbours stick, so they meet the cone only approximately. Sliding never
//!   reverses, and friction always takes energy.
//! * **Round surfaces.** A particle that slides along the tangent of a sphere leaves the sphere,
//!   by half the square of its displacement over the radius. If the contact ended there, the
//!   particle would fly for a step without friction, and again after each return: a sheet on a ball
//!   would creep off at large steps. So a contact with friction persists while the gap is at most
//!   `τ|v|`, where `v` is relative to the surface. Its target leads the particle back to the
//!   surface. If the constraint would have to pull the particle back, the contact is released like
//!   every contact that pulls. This is checked as long as any contact is released, and after
//!   sliding. Methods that move positions by the old velocities use the velocity at the end of the
//!   step for this decision ([`hold_gaps`](ContactSet::hold_gaps)), because the old velocity always
//!   leads away from a round surface.
//! * **Several obstacles.** Friction holds the directions that the independent normals leave
//!   free. Its limit is `Σ μ_k λ_k`, and it acts relative to the first obstacle with friction.
//!
//! With speculative detection, a contact also begins if `v_n` would carry the particle inside the
//! obstacle within the step. The velocity that the particle gains during the step may still carry
//! it inside, by `τ²` times its acceleration.

mod basis;
mod friction;
#[cfg(test)]
mod tests;

use crate::{each_particle, hold_pins};
use basis::Basis;
use drape_model::{Detection, Obstacle, System, Vec3};
use drape_solvers::{Constraints, Filter};
use friction::Slider;
pub use friction::Wanted;
use std::cmp::Ordering;
use std::convert::Infallible;

/// How far outside the surface a particle still touches it, m.
const TOUCHING: f64 = 1e-9;
/// Round-off of a normal velocity, over the speed of the particle or of a moving surface.
const ROUND_OFF: f64 = 1e-9;
/// Most re-solves after releases in one step.
const MAX_RELEASE_PASSES: usize = 3;
/// Most passes in which contacts across a gap are still released. All that are left then end, which
/// costs their friction for a step.
const MAX_GAP_PASSES: usize = 8;
/// A normal this close to the span of others depends on them.
const DEPENDENT: f64 = 1e-3;
/// A contact of at most this many steps ago turns the next impact into rest.
const LEAST_FLIGHT: u8 = 4;

#[derive(Clone, Copy, Debug)]
struct Contact {
    particle: u32,
    obstacle: u32,
    normal: Vec3,
    /// How far along the normal the position is altered, m.
    shift: f64,
    /// Mean normal velocity over the step that leads to the surface, or as near as the limit
    /// allows.
    recovery: f64,
    /// Normal velocity of the constraint.
    target: f64,
    /// Greatest normal velocity that the particle may keep after the step.
    keep: f64,
    /// Least normal velocity with which the particle ends the step.
    least: f64,
    /// A pull below this, kg m/s, is round-off: on a moving surface a resting velocity is not 0.
    slack: f64,
    /// `μ`.
    friction: f64,
    /// `v_s`, where the obstacle moves.
    surface: Option<Vec3>,
    /// Whether it has friction, was active in the last step, and the particle lies on the surface,
    /// up to round-off, or outside.
    goes_on: bool,
    /// The gap across which it goes on because it has friction and was active in the last step, m;
    /// 0 where there is none.
    gap: f64,
    /// Whether [`ContactSet::hold_gaps`] has decided that it stays.
    is_held: bool,
    /// Normal velocity, at most 0, that the constraint of a held contact adds before forces act,
    /// m/s. It stands for a part of what they will do, so friction must not count it twice.
    lent: f64,
}

impl Contact {
    /// A normal velocity relative to the surface, in the frame of the scene.
    fn carried(&self, relative: f64) -> f64 {
        self.surface.map_or(relative, |surface| relative + self.normal.dot(&surface))
    }

    /// Whether it goes on across a gap and may still be released.
    fn is_open(&self) -> bool {
        self.gap >= TOUCHING && !self.is_held
    }

    /// Normal velocity relative to the surface.
    fn relative(&self, v: &Vec3) -> f64 {
        let along = self.normal.dot(v);
        self.surface.map_or(along, |surface| along - self.normal.dot(&surface))
    }
}

/// An obstacle on a path during a step.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// Displacement at the start of the step, m.
    offset: Vec3,
    /// Mean velocity, m/s.
    velocity: Vec3,
}

/// A step of a multistep method, which leads from `(x_n, v_n)` to `x* + τ v_+` in `h` seconds.
#[derive(Clone, Copy, Debug)]
pub struct MultistepMotion<'a> {
    /// `x_n` and `v_n`, m and m/s.
    pub from: (&'a [Vec3], &'a [Vec3]),
    /// `h`, s.
    pub h: f64,
    /// `t_+`, the end of the step, s.
    pub end: f64,
    /// `x*`, m.
    pub x_star: &'a [Vec3],
    /// `τ`, s.
    pub tau: f64,
}

/// How a particle inside an obstacle is led out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WayOut {
    /// EEH section 6.
    Velocity,
    /// Baraff & Witkin, section 6.
    Position,
}

/// A particle whose history no longer fits, because a contact began, ended or cut its velocity.
#[derive(Clone, Copy, Debug)]
pub struct Change<'a> {
    /// Index of the particle.
    pub particle: usize,
    /// Velocity after the step, m/s.
    pub velocity: &'a Vec3,
    /// Filter that removes the normal directions of the particle's contacts, with or without
    /// friction. It removes nothing if no contact is left.
    pub filter: Filter,
    /// Velocity of the surfaces along the normals of the contacts, m/s.
    pub surface: Vec3,
}

impl<'a> Change<'a> {
    fn of(particle: usize, velocity: &'a Vec3, basis: &Basis<'_>) -> Self {
        let surface = basis.combine(|contact| contact.carried(0.0));
        Self { particle, velocity, filter: basis.filter(), surface }
    }
}

/// The contacts of the present step, and the number of steps since each was last active.
#[derive(Clone, Debug, Default)]
pub struct ContactSet {
    obstacles: usize,
    /// One for each obstacle, `None` where it is at rest.
    motions: Vec<Option<Motion>>,
    /// Particles led by pins, with their velocities.
    led: Vec<(usize, Vec3)>,
    /// Whether any obstacle has friction.
    rubs: bool,
    sliders: Vec<Slider>,
    candidates: Vec<Contact>,
    /// Steps since the contact was active, 0 for the last step; saturates.
    steps_since: Vec<u8>,
    is_active: Vec<bool>,
    /// Whether a contact of each particle began, ended or cut its velocity in the last step; empty
    /// without obstacles.
    changed: Vec<bool>,
}

impl ContactSet {
    /// Memory for every pair of a particle and an obstacle.
    pub fn new(system: &System) -> Self {
        let obstacles = system.obstacles().len();
        let slots = obstacles * system.len();
        let rubs = system.obstacles().iter().any(|obstacle| obstacle.friction > 0.0);
        let moves = |obstacle: &Obstacle| obstacle.path.as_ref().map(|_| Motion::default());
        Self {
            obstacles,
            motions: system.obstacles().iter().map(moves).collect(),
            rubs,
            sliders: Vec::with_capacity(if rubs { system.len() } else { 0 }),
            candidates: Vec::with_capacity(slots),
            steps_since: vec![u8::MAX; slots],
            is_active: vec![false; slots],
            changed: vec![false; if obstacles == 0 { 0 } else { system.len() }],
            ..Self::for_pins(system)
        }
    }

    /// Memory for pins alone; obstacles are ignored.
    pub fn for_pins(system: &System) -> Self {
        Self { led: Vec::with_capacity(system.moving_pins().len()), ..Self::default() }
    }

    /// Memory for the constraints that [`detect`](Self::detect) writes. Without obstacles it holds
    /// pins only.
    pub fn constraints(system: &System) -> Constraints {
        match system.obstacles() {
            [] if system.moving_pins().is_empty() => Constraints::free_or_held(system.len()),
            _ => Constraints::free(system.len()),
        }
    }

    /// Memory for the impulse, kg m/s, that [`solve`](Self::solve) passes on; empty without
    /// obstacles.
    pub fn impulse(system: &System) -> Vec<Vec3> {
        vec![Vec3::zeros(); if system.obstacles().is_empty() { 0 } else { system.len() }]
    }

    /// Forgets which contacts were active.
    pub fn restart(&mut self) {
        self.steps_since.fill(u8::MAX);
        self.changed.fill(false);
        self.candidates.clear();
    }

    /// Copies another set of the same size without allocating, except the contacts of its present
    /// step.
    pub fn copy_from(&mut self, other: &Self) {
        self.steps_since.copy_from_slice(&other.steps_since);
        self.changed.copy_from_slice(&other.changed);
        self.candidates.clear();
    }

    /// Whether, in the last step, a contact of the particle began, ended or cut its velocity.
    pub fn changed(&self, particle: usize) -> bool {
        self.changed.get(particle).copied().unwrap_or(false)
    }

    /// Whether no contact is active in the present step.
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    fn slot(&self, particle: usize, obstacle: usize) -> usize {
        particle * self.obstacles + obstacle
    }

    /// Finds the contacts of a step `(τ, t_+)` that moves `x → x + τ v_+` and ends at `t_+`. Writes
    /// them and the pins to `constraints`.
    #[doc(alias = "EEH section 6")]
    pub fn detect(
        &mut self,
        system: &System,
        x: &[Vec3],
        v: &[Vec3],
        step: (f64, f64),
        constraints: &mut Constraints,
    ) {
        self.find(system, x, v, step, WayOut::Velocity, constraints);
    }

    fn find(
        &mut self,
        system: &System,
        x: &[Vec3],
        v: &[Vec3],
        step: (f64, f64),
        way_out: WayOut,
        constraints: &mut Constraints,
    ) {
        self.lead(system, x, step);
        self.collect(system, x, v, step, way_out, None);
        self.write(system, constraints);
    }

    /// As [`detect`](Self::detect), for a step of a multistep method: `n·v_+ = (1/τ) n·(x_s − x*)`.
    /// `x_s` is the surface point. If the speed limit does not allow the particle to reach the
    /// surface within the step, `x_s` is the point that it can reach.
    pub fn detect_multistep(
        &mut self,
        system: &System,
        motion: MultistepMotion<'_>,
        constraints: &mut Constraints,
    ) {
        self.find_multistep(system, motion, None, constraints);
    }

    fn find_multistep(
        &mut self,
        system: &System,
        motion: MultistepMotion<'_>,
        free: Option<&[Vec3]>,
        constraints: &mut Constraints,
    ) {
        let MultistepMotion { from: (x, v), h, end, x_star, tau } = motion;
        let way = |free: &[Vec3], i: usize| x_star[i] - x[i] + free[i] * tau;
        let ways = free.map(|free| move |i| way(free, i));
        let ahead = ways.as_ref().map(|way| way as &dyn Fn(usize) -> Vec3);
        self.lead(system, x_star, (tau, end));
        self.collect(system, x, v, (h, end), WayOut::Velocity, ahead);
        // A particle that leaves by itself is let go: else each rebound would end with a lift.
        self.candidates.retain(|contact| {
            let speed = contact.relative(&v[contact.particle as usize]);
            let comes_back = contact.recovery * h < -TOUCHING;
            comes_back
                || contact.gap > 0.0
                || speed * h <= TOUCHING
                || contact.recovery > speed * f64::from(LEAST_FLIGHT)
        });
        for contact in &mut self.candidates {
            let i = contact.particle as usize;
            let approach = contact.relative(&v[i]);
            let mut mean = contact.recovery;
            let kept =
                contact.surface.map_or(contact.keep, |v_s| contact.keep - contact.normal.dot(&v_s));
            if approach < 0.0 && kept > 0.0 {
                contact.least = contact.keep; // the rebound
                mean = (0.5 * (approach + kept)).max(mean.min(0.0));
            }
            contact.target =
                (contact.carried(mean) * h + contact.normal.dot(&(x[i] - x_star[i]))) / tau;
        }
        self.write(system, constraints);
    }

    /// As [`detect`](Self::detect) for a step that moves `x → x + τ v_+ + y`. `y`, m, puts
    /// particles inside an obstacle on its surface, at any depth, and their normal velocity becomes
    /// 0. For a rebound, `y` covers only the part of the displacement that the rebound leaves. A
    /// full `y` would lift the particle against gravity, and the particle would bounce higher each
    /// time.
    ///
    /// A contact that is released later keeps its `y`: geometry decides where a particle may be,
    /// forces decide whether the contact holds it.
    #[doc(alias = "Baraff-Witkin section 6")]
    pub fn detect_altering(
        &mut self,
        system: &System,
        x: &[Vec3],
        v: &[Vec3],
        step: (f64, f64),
        constraints: &mut Constraints,
        y: &mut [Vec3],
    ) {
        self.find(system, x, v, step, WayOut::Position, constraints);
        y.fill(Vec3::zeros());
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            y[group[0].particle as usize] = Basis::of(group).combine(|contact| contact.shift);
        }
    }

    /// As [`detect_multistep`](Self::detect_multistep), for methods that project positions. A
    /// contact also begins if the velocities `free` (m/s), which the step found without contacts,
    /// would end the step inside the obstacle. So no particle penetrates by more than the curvature
    /// of the surface allows.
    pub fn detect_predicted(
        &mut self,
        system: &System,
        motion: MultistepMotion<'_>,
        free: &[Vec3],
        constraints: &mut Constraints,
    ) {
        self.find_multistep(system, motion, Some(free), constraints);
    }

    /// Finds the velocities of the pins on paths, which lead them to their places at `end`.
    fn lead(&mut self, system: &System, x_star: &[Vec3], (tau, end): (f64, f64)) {
        self.led.clear();
        self.led.extend(
            system
                .moving_pins()
                .iter()
                .map(|pin| (pin.particle, (pin.position(end) - x_star[pin.particle]) / tau)),
        );
    }

    /// With `ahead`, the way of a particle in the step (m), that way decides which particles
    /// arrive, else the old velocity if detection is speculative.
    fn collect(
        &mut self,
        system: &System,
        x: &[Vec3],
        v: &[Vec3],
        (tau, end): (f64, f64),
        way_out: WayOut,
        ahead: Option<&dyn Fn(usize) -> Vec3>,
    ) {
        self.candidates.clear();
        if self.obstacles == 0 {
            return;
        }
        for (motion, obstacle) in self.motions.iter_mut().zip(system.obstacles()) {
            if let (Some(motion), Some(path)) = (motion, &obstacle.path) {
                motion.offset = path.offset(end - tau);
                motion.velocity = (path.offset(end) - motion.offset) / tau;
            }
        }
        let limit = system.contact().recovery_speed_limit_m_s;
        let speculative = ahead.is_some() || system.contact().detection == Detection::Speculative;
        for particle in (0..x.len()).filter(|&i| !system.pinned()[i]) {
            let first = self.candidates.len();
            for (index, obstacle) in system.obstacles().iter().enumerate() {
                let motion = &self.motions[index];
                let (x, v) = match motion {
                    None => (x[particle], v[particle]),
                    Some(motion) => (x[particle] - motion.offset, v[particle] - motion.velocity),
                };
                let rubbed =
                    obstacle.friction > 0.0 && self.steps_since[self.slot(particle, index)] == 0;
                let surface = motion.map_or(Vec3::zeros(), |motion| motion.velocity);
                let way = ahead.map(|way| way(particle) - surface * tau);
                let far = way.map_or(0.0, |way| way.norm()).max(tau * v.norm());
                let looks_ahead = speculative || rubbed;
                let reach = if looks_ahead { TOUCHING + far } else { TOUCHING };
                let Some((distance, normal)) = obstacle.distance_within(&x, reach) else {
                    continue;
                };
                let approach = normal.dot(&v);
                let closer = way.map_or(tau * approach, |way| normal.dot(&way));
                let arrives = speculative && distance + closer < 0.0;
                if distance < TOUCHING || arrives || rubbed {
                    let recovery = (-distance / tau).min(limit);
                    let bounces = self.steps_since[self.slot(particle, index)] >= LEAST_FLIGHT;
                    let restitution = if bounces { obstacle.restitution } else { 0.0 };
                    let rebound = (-restitution * approach).max(0.0);
                    let (shift, target) = match way_out {
                        WayOut::Position if distance < 0.0 => {
                            ((-distance - tau * rebound).max(0.0), rebound)
                        }
                        // A particle outside may come as far as the surface.
                        _ if rebound > 0.0 => (0.0, recovery.max(rebound)),
                        _ => (0.0, recovery),
                    };
                    let mut contact = Contact {
                        particle: particle as u32,
                        obstacle: index as u32,
                        normal,
                        shift,
                        recovery,
                        target,
                        keep: rebound.max(approach),
                        least: f64::NEG_INFINITY,
                        slack: motion.map_or(0.0, |motion| {
                            ROUND_OFF * system.mass()[particle] * motion.velocity.norm()
                        }),
                        friction: obstacle.friction,
                        surface: motion.map(|motion| motion.velocity),
                        goes_on: rubbed && distance > -TOUCHING,
                        gap: if rubbed { distance.max(0.0) } else { 0.0 },
                        is_held: false,
                        lent: 0.0,
                    };
                    contact.target = contact.carried(contact.target);
                    contact.keep = contact.carried(contact.keep);
                    self.candidates.push(contact);
                }
            }
            self.candidates[first..].sort_unstable_by(|a, b| {
                let deepest = b.shift.total_cmp(&a.shift).then(b.target.total_cmp(&a.target));
                deepest.then(a.obstacle.cmp(&b.obstacle))
            });
        }
    }

    /// Calls `look` with constraints of the present contacts and pins that omit friction, then
    /// restores the friction.
    pub fn without_friction<T>(
        &mut self,
        system: &System,
        constraints: &mut Constraints,
        look: impl FnOnce(&Constraints) -> T,
    ) -> T {
        if !self.rubs {
            return look(constraints);
        }
        self.rubs = false;
        self.write(system, constraints);
        let seen = look(constraints);
        self.rubs = true;
        self.write(system, constraints);
        seen
    }

    /// Writes the pins and the remaining contacts to `constraints`, for a further stage of the same
    /// step. All particles with friction are at rest on their surfaces.
    pub fn write(&self, system: &System, constraints: &mut Constraints) {
        constraints.clear();
        hold_pins(system, constraints);
        for &(particle, z) in &self.led {
            constraints.set(particle, Filter::Fixed, z);
        }
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let basis = Basis::of(group);
            let (filter, prescribed) = (basis.filter(), basis.combine(|contact| contact.target));
            let particle = group[0].particle as usize;
            match basis.surface().filter(|_| self.rubs) {
                None => constraints.set(particle, filter, prescribed),
                Some(v_s) => {
                    constraints.set(particle, Filter::Fixed, prescribed + filter.apply(v_s));
                }
            }
        }
    }

    /// Solves a step under its constraints. Repeats the solve if contacts are released or slide.
    ///
    /// `solve` is called with the constraints. Where there are contacts, it also gets the memory of
    /// `impulse` for the wanted part of the solution.
    ///
    /// # Errors
    /// The first error that `solve` returns.
    pub fn solve<E>(
        &mut self,
        system: &System,
        constraints: &mut Constraints,
        impulse: &mut [Vec3],
        mut solve: impl FnMut(&Constraints, Wanted<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        for pass in 1..=MAX_GAP_PASSES {
            let checks_all = pass <= MAX_RELEASE_PASSES;
            if self.is_empty() || !(checks_all || self.has_open_gaps()) {
                break;
            }
            solve(constraints, Wanted::Impulse(impulse))?;
            let released = self.release(impulse, |contact| checks_all || contact.is_open());
            if !released && !self.slide(constraints, impulse, &mut solve)? {
                return Ok(());
            }
            if pass == MAX_GAP_PASSES {
                self.candidates.retain(|contact| !contact.is_open());
            }
            self.write(system, constraints);
        }
        if self.rubs && !self.is_empty() {
            solve(constraints, Wanted::Impulse(impulse))?;
            self.slide(constraints, impulse, solve)?;
            return Ok(());
        }
        solve(constraints, Wanted::Nothing)
    }

    /// Whether a contact goes on across a gap and may still be released.
    fn has_open_gaps(&self) -> bool {
        self.candidates.iter().any(Contact::is_open)
    }

    /// Drops the contact of each particle that pulls most among those that `may_end`, given the
    /// unfiltered residual `p = A v_+ − b` (kg m/s). Returns whether any was dropped.
    fn release(&mut self, impulse: &[Vec3], may_end: impl Fn(&Contact) -> bool) -> bool {
        let before = self.candidates.len();
        let (mut kept, mut start) = (0, 0);
        while start < before {
            let particle = self.candidates[start].particle;
            let group = self.candidates[start..].iter().take_while(|c| c.particle == particle);
            let end = start + group.count();
            let basis = Basis::of(&self.candidates[start..end]);
            let may_end = |contact: &Contact| may_end(contact) && !contact.is_held;
            let pulling = basis.pulling(&impulse[particle as usize], may_end);
            for position in start..end {
                let contact = self.candidates[position];
                // Two contacts with the same wall are dropped in one pass.
                let drop = pulling.is_some_and(|n| (n - contact.normal).norm() < DEPENDENT);
                if !drop {
                    self.candidates[kept] = contact;
                    kept += 1;
                }
            }
            start = end;
        }
        self.candidates.truncate(kept);
        kept < before
    }

    /// Decides about contacts with friction, also across a gap, for methods that move positions by
    /// the old velocities `v`, m/s. Such velocities lead away from a round surface, and by
    /// round-off also from a plane. `end` gives the velocity that a particle would have at the end
    /// of the step without the contact. If that velocity leads away, the contact ends; otherwise
    /// the contact stays, whatever [`project`](Self::project) finds. Particles with several
    /// contacts are left to `project`.
    ///
    /// Call it after [`detect`](Self::detect).
    pub fn hold_gaps(
        &mut self,
        system: &System,
        v: &[Vec3],
        end: impl Fn(usize) -> Vec3,
        constraints: &mut Constraints,
    ) {
        if !self.candidates.iter().any(|contact| contact.goes_on) {
            return;
        }
        let mut last = u32::MAX;
        for position in 0..self.candidates.len() {
            let particle = self.candidates[position].particle;
            let next = self.candidates.get(position + 1).map(|next| next.particle);
            let is_alone = last != particle && next != Some(particle);
            last = particle;
            let contact = &mut self.candidates[position];
            if is_alone && contact.goes_on {
                contact.is_held = true;
                contact.lent =
                    (contact.target - contact.normal.dot(&v[particle as usize])).min(0.0);
            }
        }
        let mass = system.mass();
        self.candidates.retain(|contact| {
            let i = contact.particle as usize;
            let multiplier = mass[i] * (contact.target - contact.normal.dot(&end(i)));
            !contact.is_held || multiplier + contact.slack >= 0.0
        });
        self.write(system, constraints);
    }

    /// Ends a step. It reduces the normal velocities to those that the impacts left, and records
    /// which contacts were active. It calls `changed` for each particle whose history no longer
    /// fits, because a contact began, ended or cut its velocity.
    pub fn settle(&mut self, v: &mut [Vec3], mut changed: impl FnMut(Change<'_>)) {
        if self.obstacles == 0 {
            return;
        }
        self.is_active.fill(false);
        self.changed.fill(false);
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let particle = group[0].particle as usize;
            for contact in group {
                self.is_active[particle * self.obstacles + contact.obstacle as usize] = true;
            }
            let basis = Basis::of(group);
            let velocity = v[particle];
            let along = |contact: &Contact| contact.normal.dot(&velocity);
            let is_cut = |c: &Contact| {
                // With friction a cut rewrites the past along the surface, too: ignore round-off.
                let slack = if c.friction > 0.0 { ROUND_OFF * velocity.norm() } else { 0.0 };
                along(c) > c.keep + slack || along(c) < c.least - slack
            };
            if basis.contacts().any(is_cut) {
                let kept = basis.combine(|c| along(c).max(c.least).min(c.keep));
                v[particle] = basis.filter().apply(velocity) + kept;
                self.changed[particle] = true;
                changed(Change::of(particle, &v[particle], &basis));
            }
        }
        let mut rest = &self.candidates[..];
        for (slot, (steps, is_active)) in
            self.steps_since.iter_mut().zip(&self.is_active).enumerate()
        {
            let was_active = *steps == 0;
            *steps = if *is_active { 0 } else { steps.saturating_add(1) };
            if was_active != *is_active {
                let particle = slot / self.obstacles;
                self.changed[particle] = true;
                let is_of = |c: &Contact, order| (c.particle as usize).cmp(&particle) == order;
                rest = &rest[rest.partition_point(|c| is_of(c, Ordering::Less))..];
                let group = &rest[..rest.partition_point(|c| is_of(c, Ordering::Equal))];
                changed(Change::of(particle, &v[particle], &Basis::of(group)));
            }
        }
    }
}

impl ContactSet {
    /// Imposes pins and contacts on the velocity of a step that was computed without them, particle
    /// by particle. It is for methods whose velocities do not solve a linear system. Contacts that
    /// would pull are released.
    pub fn project(
        &mut self,
        system: &System,
        constraints: &mut Constraints,
        free: &[Vec3],
        velocity: &mut [Vec3],
        impulse: &mut [Vec3],
    ) {
        let outcome = self.solve(system, constraints, impulse, |constraints, wanted| {
            velocity.copy_from_slice(free);
            constraints.impose(velocity);
            wanted.fill(velocity, |impulse| {
                for (i, m) in system.mass().iter().enumerate() {
                    impulse[i] = (velocity[i] - free[i]) * *m;
                }
            });
            Ok::<(), Infallible>(())
        });
        match outcome {
            Ok(()) => {}
            Err(never) => match never {},
        }
    }

    /// As [`project`](Self::project), in place; `free` is scratch. Without obstacles only the
    /// constraints act.
    pub fn project_in_place(
        &mut self,
        system: &System,
        constraints: &mut Constraints,
        free: &mut [Vec3],
        velocity: &mut [Vec3],
        impulse: &mut [Vec3],
    ) {
        if self.obstacles == 0 {
            return constraints.impose(velocity);
        }
        each_particle(system, free, |i| velocity[i]);
        self.project(system, constraints, free, velocity, impulse);
    }

    /// Removes the velocity into the obstacle from particles in contact. It is for methods whose
    /// forces act after the constraint; otherwise weight would show as a speed of `g h` at rest.
    /// Friction reduces the velocity along the surface.
    pub fn stop(&self, v: &mut [Vec3]) {
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let velocity = &mut v[group[0].particle as usize];
            let basis = Basis::of(group);
            let inward = *velocity;
            let borne = |contact: &Contact| contact.carried(0.0);
            if basis.contacts().any(|contact| contact.normal.dot(&inward) < borne(contact)) {
                let kept = basis.combine(|contact| contact.normal.dot(&inward).max(borne(contact)));
                let along = basis.filter().apply(inward);
                let gained = |contact: &Contact| borne(contact) + contact.lent;
                let along = if self.rubs { basis.rub(&inward, along, gained) } else { along };
                *velocity = along + kept;
            }
        }
    }

    /// Writes the velocity `v`, m/s, as an impact leaves it, for methods whose forces act
    /// afterwards. Call it after [`project`](Self::project), whose contacts it uses.
    pub fn strike(
        &self,
        system: &System,
        constraints: &mut Constraints,
        v: &[Vec3],
        velocity: &mut [Vec3],
    ) {
        if self.rubs {
            self.write(system, constraints); // without the friction of forces
        }
        velocity.copy_from_slice(v);
        constraints.impose(velocity);
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let (basis, particle) = (Basis::of(group), group[0].particle as usize);
            if basis.surface().is_some() {
                let along = basis.filter().apply(v[particle]);
                let after = |c: &Contact| if c.is_held { c.target } else { c.keep };
                let along = basis.rub(&v[particle], along, after);
                velocity[particle] = basis.combine(|contact| contact.target) + along;
            }
        }
    }

    /// Removes the part along the normals from the accelerations of particles that stay in contact,
    /// m/s². The obstacle bears that part. It is for methods that extrapolate accelerations.
    /// Particles that leave the surface within the next `h` seconds, say after a rebound, keep
    /// their acceleration. With friction the whole acceleration is removed, because such a particle
    /// moves by its velocity alone.
    pub fn support(&self, h: f64, a: &mut [Vec3]) {
        let stays = |contact: &Contact| match contact.surface {
            None => contact.keep * h <= TOUCHING,
            Some(v_s) => (contact.keep - contact.normal.dot(&v_s)) * h <= TOUCHING,
        };
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let acceleration = &mut a[group[0].particle as usize];
            let basis = Basis::of(group);
            if self.rubs && basis.contacts().any(|contact| contact.friction > 0.0 && stays(contact))
            {
                *acceleration = Vec3::zeros();
                continue;
            }
            let along = |contact: &Contact| contact.normal.dot(acceleration);
            let kept = basis.combine(|contact| if stays(contact) { 0.0 } else { along(contact) });
            *acceleration = basis.filter().apply(*acceleration) + kept;
        }
    }
}
