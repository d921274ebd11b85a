//! Contacts with rigid obstacles by velocity constraints (EEH section 6).
//!
//! A particle that lies inside an obstacle, or within 1e-9 m of its surface, gets its normal velocity
//! prescribed so that it is led back to the surface:
//!
//! ```text
//! n·v_+ = (1/τ) n·(x_s − x*)
//! ```
//!
//! where the step moves `x* → x* + τ v_+`. The paper prints `x_{n+1}` on the right; the penetration
//! is known at the start of the step, and the literal implicit reading would correct half of it
//! only. What the paper leaves open is settled here:
//!
//! * **Release.** After the solve the unfiltered residual `p = A v_+ − b` is the impulse of the
//!   constraints, `p = Σ λ_k n_k`; a contact whose `λ_k` is negative would pull, so the one that pulls
//!   most is dropped and the step solved again, at most three times.
//! * **No chatter.** What touches counts as a contact, from the geometry alone: a particle at rest
//!   stays one whatever the history, also after a restart.
//! * **No pop.** The speed of recovery is limited by the scene, and after the update of positions the
//!   normal velocity is cut back to what the impact left (split impulse): correcting a
//!   penetration gives the particle no kinetic energy.
//! * **Restitution.** A particle that arrives with normal velocity `a < 0` leaves with `−e a`. A flight
//!   that would be over within a few steps is no bounce any more: a particle that was in contact
//!   that shortly before stays. Otherwise every step would undo the rebound of the last by
//!   gravity, and a particle with `e > 0` would never come to rest.
//! * **Several obstacles.** The contacts of a particle are taken in the order of their targets, greatest
//!   first, as far as their normals are independent: one leaves a plane to move in, two a line, three
//!   nothing. A normal that depends on those taken is left out. Where obstacles contradict each other
//!   (opposite normals), the deeper penetration wins.
//!
//! Instead of leading a particle out by its velocity, [`ContactSet::detect_altering`] asks for its position to
//! be altered, as Baraff & Witkin do (1998, section 6): the step then moves `x* → x* + τ v_+ + y`, with `y` the way
//! to the surface, and `v_+` is prescribed as if the particle had been there.
//!
//! A multistep method moves `x* → x* + τ v_+`, and its `x*` holds some of the past motion.
//! [`ContactSet::detect_multistep`] looks for contacts at `x_n` and prescribes the `v_+` that leads where the rules above
//! would lead, with two differences, both so that a bounce neither takes nor gives energy: a rebound moves the
//! particle by the mean of the velocities before and after, as befits a method of order 2, and what leaves
//! an obstacle by itself within a few steps is let go.
//!
//! Speculative detection looks ahead with `v_n`, so that what a particle gains in the step itself
//! may still carry it inside, by `τ²` times its acceleration.

use drape_model::{Detection, System, Vec3};
use drape_solvers::{Constraints, Filter};
use std::convert::Infallible;

/// How far outside the surface a particle still touches it, m.
const TOUCHING: f64 = 1e-9;
/// Most re-solves after releases in one step.
const MAX_RELEASE_PASSES: usize = 3;
/// A normal that lies this close to the span of others depends on them.
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
    /// Mean normal velocity over the step with which the surface is reached, or as much of the way as
    /// is allowed.
    recovery: f64,
    /// Normal velocity of the constraint.
    target: f64,
    /// Greatest normal velocity that the particle may keep after the step.
    keep: f64,
    /// Least normal velocity with which the particle ends the step.
    least: f64,
}

/// A step of a multistep method: within `h` it leads from `(x_n, v_n)` to `x* + τ v_+`.
#[derive(Clone, Copy, Debug)]
pub struct MultistepMotion<'a> {
    /// `x_n` and `v_n`, m and m/s.
    pub from: (&'a [Vec3], &'a [Vec3]),
    /// `h`, s.
    pub h: f64,
    /// `x*`, m.
    pub x_star: &'a [Vec3],
    /// `τ`, s.
    pub tau: f64,
}

/// How a particle inside an obstacle gets out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WayOut {
    /// EEH section 6.
    Velocity,
    /// Baraff & Witkin, section 6.
    Position,
}

/// The contacts of the running step, and how long ago each was active.
#[derive(Clone, Debug, Default)]
pub struct ContactSet {
    obstacles: usize,
    candidates: Vec<Contact>,
    /// Steps since the contact was active, 0 for the last step; saturates.
    steps_since: Vec<u8>,
    is_active: Vec<bool>,
    /// Particles whose contact began, ended or cut their velocity in the last step; empty without obstacles.
    changed: Vec<bool>,
}

impl ContactSet {
    /// Memory for every particle in contact with every obstacle.
    pub fn new(system: &System) -> Self {
        let obstacles = system.obstacles().len();
        let slots = obstacles * system.len();
        Self {
            obstacles,
            candidates: Vec::with_capacity(slots),
            steps_since: vec![u8::MAX; slots],
            is_active: vec![false; slots],
            changed: vec![false; if obstacles == 0 { 0 } else { system.len() }],
        }
    }

    /// Memory for what [`detect`](Self::detect) writes: without obstacles, for pins alone.
    pub fn constraints(system: &System) -> Constraints {
        match system.obstacles() {
            [] => Constraints::free_or_held(system.len()),
            _ => Constraints::free(system.len()),
        }
    }

    /// Memory for the impulse that [`solve`](Self::solve) lends: none without obstacles.
    pub fn impulse(system: &System) -> Vec<Vec3> {
        vec![Vec3::zeros(); if system.obstacles().is_empty() { 0 } else { system.len() }]
    }

    /// Forgets which contacts were active.
    pub fn restart(&mut self) {
        self.steps_since.fill(u8::MAX);
        self.changed.fill(false);
        self.candidates.clear();
    }

    /// Copies another set of the same size without allocating, the contacts of the running step left out.
    pub fn copy_from(&mut self, other: &Self) {
        self.steps_since.copy_from_slice(&other.steps_since);
        self.changed.copy_from_slice(&other.changed);
        self.candidates.clear();
    }

    /// Whether a contact of the particle began, ended or cut its velocity in the last step.
    pub fn changed(&self, particle: usize) -> bool {
        self.changed.get(particle).copied().unwrap_or(false)
    }

    /// Whether no contact is active.
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    fn slot(&self, particle: usize, obstacle: usize) -> usize {
        particle * self.obstacles + obstacle
    }

    /// Finds the contacts of a step that moves `x → x + τ v_+`, and writes them and the pins to `constraints`.
    #[doc(alias = "EEH section 6")]
    pub fn detect(
        &mut self,
        system: &System,
        x: &[Vec3],
        v: &[Vec3],
        tau: f64,
        constraints: &mut Constraints,
    ) {
        self.collect(system, x, v, tau, WayOut::Velocity);
        self.write(system, constraints);
    }

    /// As [`detect`](Self::detect) for a step of a multistep method: `n·v_+ = (1/τ) n·(x_s − x*)`, where `x_s` is
    /// the surface or the point before it to which a particle may be led within the step.
    pub fn detect_multistep(
        &mut self,
        system: &System,
        motion: MultistepMotion<'_>,
        constraints: &mut Constraints,
    ) {
        let MultistepMotion { from: (x, v), h, x_star, tau } = motion;
        self.collect(system, x, v, h, WayOut::Velocity);
        // Were what leaves by itself led out, each rebound would end with a lift.
        self.candidates.retain(|contact| {
            let speed = contact.normal.dot(&v[contact.particle as usize]);
            speed * h <= TOUCHING || contact.recovery > speed * f64::from(LEAST_FLIGHT)
        });
        for contact in &mut self.candidates {
            let i = contact.particle as usize;
            let approach = contact.normal.dot(&v[i]);
            let mut mean = contact.recovery;
            if approach < 0.0 && contact.keep > 0.0 {
                contact.least = contact.keep; // the rebound
                mean = (0.5 * (approach + contact.keep)).max(mean.min(0.0));
            }
            contact.target = (mean * h + contact.normal.dot(&(x[i] - x_star[i]))) / tau;
        }
        self.write(system, constraints);
    }

    /// As [`detect`](Self::detect) for a step that moves `x → x + τ v_+ + y`: particles inside an obstacle are
    /// put on its surface by `y`, m, whatever the depth, and their normal velocity becomes 0. Of what rebounds, `y`
    /// covers that part of the way which the rebound leaves: the whole of it would lift the particle
    /// against gravity and let it bounce higher each time.
    ///
    /// A contact that is released later keeps its `y`: where a particle may be is a matter of geometry, what
    /// holds it one of forces.
    #[doc(alias = "Baraff-Witkin section 6")]
    pub fn detect_altering(
        &mut self,
        system: &System,
        x: &[Vec3],
        v: &[Vec3],
        tau: f64,
        constraints: &mut Constraints,
        y: &mut [Vec3],
    ) {
        self.collect(system, x, v, tau, WayOut::Position);
        self.write(system, constraints);
        y.fill(Vec3::zeros());
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            y[group[0].particle as usize] = Basis::of(group).combine(|contact| contact.shift);
        }
    }

    fn collect(&mut self, system: &System, x: &[Vec3], v: &[Vec3], tau: f64, way_out: WayOut) {
        self.candidates.clear();
        if self.obstacles == 0 {
            return;
        }
        let limit = system.contact().recovery_speed_limit;
        let speculative = system.contact().detection == Detection::Speculative;
        for particle in (0..x.len()).filter(|&i| !system.pinned()[i]) {
            let first = self.candidates.len();
            for (index, obstacle) in system.obstacles().iter().enumerate() {
                let (distance, normal) = obstacle.distance(&x[particle]);
                let approach = normal.dot(&v[particle]);
                let arrives = speculative && distance + tau * approach < 0.0;
                if distance < TOUCHING || arrives {
                    let recovery = (-distance / tau).min(limit);
                    let bounces = self.steps_since[self.slot(particle, index)] >= LEAST_FLIGHT;
                    let restitution = if bounces { obstacle.restitution } else { 0.0 };
                    let rebound = (-restitution * approach).max(0.0);
                    let (shift, target) = match way_out {
                        WayOut::Position if distance < 0.0 => {
                            ((-distance - tau * rebound).max(0.0), rebound)
                        }
                        // What is still outside may come as far as the surface.
                        _ if rebound > 0.0 => (0.0, recovery.max(rebound)),
                        _ => (0.0, recovery),
                    };
                    self.candidates.push(Contact {
                        particle: particle as u32,
                        obstacle: index as u32,
                        normal,
                        shift,
                        recovery,
                        target,
                        keep: rebound.max(approach),
                        least: f64::NEG_INFINITY,
                    });
                }
            }
            self.candidates[first..].sort_unstable_by(|a, b| {
                let deepest = b.shift.total_cmp(&a.shift).then(b.target.total_cmp(&a.target));
                deepest.then(a.obstacle.cmp(&b.obstacle))
            });
        }
    }

    fn write(&self, system: &System, constraints: &mut Constraints) {
        constraints.clear();
        for particle in (0..system.len()).filter(|&i| system.pinned()[i]) {
            constraints.set(particle, Filter::Fixed, Vec3::zeros());
        }
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let basis = Basis::of(group);
            let prescribed = basis.combine(|contact| contact.target);
            constraints.set(group[0].particle as usize, basis.filter(), prescribed);
        }
    }

    /// Solves a step under its constraints, and again after contacts were released.
    ///
    /// `solve` gets the constraints and, where there are contacts, `impulse`, which it must fill with
    /// the unfiltered residual `p = A v_+ − b`.
    ///
    /// # Errors
    /// The first error of `solve`.
    pub fn solve<E>(
        &mut self,
        system: &System,
        constraints: &mut Constraints,
        impulse: &mut [Vec3],
        mut solve: impl FnMut(&Constraints, Option<&mut [Vec3]>) -> Result<(), E>,
    ) -> Result<(), E> {
        for _ in 0..MAX_RELEASE_PASSES {
            if self.is_empty() {
                break;
            }
            solve(constraints, Some(impulse))?;
            if !self.release(impulse) {
                return Ok(());
            }
            self.write(system, constraints);
        }
        solve(constraints, None)
    }

    /// Drops from each particle the contact that pulls most, given the unfiltered residual
    /// `p = A v_+ − b` (kg m/s), and returns whether any was dropped.
    fn release(&mut self, impulse: &[Vec3]) -> bool {
        let before = self.candidates.len();
        let (mut kept, mut start) = (0, 0);
        while start < before {
            let particle = self.candidates[start].particle;
            let group = self.candidates[start..].iter().take_while(|c| c.particle == particle);
            let end = start + group.count();
            let pulling =
                Basis::of(&self.candidates[start..end]).pulling(&impulse[particle as usize]);
            for position in start..end {
                let contact = self.candidates[position];
                // The same wall twice must not need two passes.
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

    /// Ends a step: brings the normal velocities back to what the impacts left, calls `changed` for
    /// each particle whose history no longer fits (a contact began, ended or cut its velocity), and
    /// remembers which contacts were active.
    pub fn settle(&mut self, v: &mut [Vec3], mut changed: impl FnMut(usize, &Vec3)) {
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
            if basis.contacts().any(|c| along(c) > c.keep || along(c) < c.least) {
                let kept = basis.combine(|c| along(c).max(c.least).min(c.keep));
                v[particle] = basis.filter().apply(velocity) + kept;
                self.changed[particle] = true;
                changed(particle, &v[particle]);
            }
        }
        for (slot, (steps, is_active)) in
            self.steps_since.iter_mut().zip(&self.is_active).enumerate()
        {
            let was_active = *steps == 0;
            *steps = if *is_active { 0 } else { steps.saturating_add(1) };
            if was_active != *is_active {
                let particle = slot / self.obstacles;
                self.changed[particle] = true;
                changed(particle, &v[particle]);
            }
        }
    }
}

impl ContactSet {
    /// Imposes pins and contacts on the velocity that a step without them would give, particle by particle: for
    /// methods whose velocities are not the solution of a linear system. Contacts that would pull are
    /// released.
    pub fn project(
        &mut self,
        system: &System,
        constraints: &mut Constraints,
        free: &[Vec3],
        velocity: &mut [Vec3],
        impulse: &mut [Vec3],
    ) {
        let outcome = self.solve(system, constraints, impulse, |constraints, impulse| {
            velocity.copy_from_slice(free);
            constraints.impose(velocity);
            if let Some(impulse) = impulse {
                for (i, m) in system.mass().iter().enumerate() {
                    impulse[i] = (velocity[i] - free[i]) * *m;
                }
            }
            Ok::<(), Infallible>(())
        });
        match outcome {
            Ok(()) => {}
            Err(never) => match never {},
        }
    }

    /// Takes from particles in contact the velocity that points into the obstacle: for methods
    /// whose forces act after the constraint, where weight would show as a speed of `g h` at rest.
    pub fn stop(&self, v: &mut [Vec3]) {
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let velocity = &mut v[group[0].particle as usize];
            let basis = Basis::of(group);
            let inward = *velocity;
            if basis.contacts().any(|contact| contact.normal.dot(&inward) < 0.0) {
                let kept = basis.combine(|contact| contact.normal.dot(&inward).max(0.0));
                *velocity = basis.filter().apply(inward) + kept;
            }
        }
    }

    /// Takes from particles that stay in contact the part along the normals: from accelerations, for methods that
    /// extrapolate them, since the obstacle bears that part. Particles that the next `h` seconds lead away,
    /// say after a rebound, keep theirs.
    pub fn support(&self, h: f64, a: &mut [Vec3]) {
        let stays = |contact: &Contact| contact.keep * h <= TOUCHING;
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let acceleration = &mut a[group[0].particle as usize];
            let basis = Basis::of(group);
            let along = |contact: &Contact| contact.normal.dot(acceleration);
            let kept = basis.combine(|contact| if stays(contact) { 0.0 } else { along(contact) });
            *acceleration = basis.filter().apply(*acceleration) + kept;
        }
    }
}

/// Those contacts of one particle whose normals are independent, one to three.
struct Basis<'a> {
    contacts: [Option<&'a Contact>; 3],
    /// Orthonormal: the span of the first `k` normals for each `k`.
    axes: [Vec3; 3],
    len: usize,
}

impl<'a> Basis<'a> {
    fn of(group: &'a [Contact]) -> Self {
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

    fn contacts(&self) -> impl Iterator<Item = &'a Contact> {
        self.contacts.iter().flatten().copied()
    }

    fn filter(&self) -> Filter {
        match self.len {
            0 => Filter::Free,
            1 => Filter::Plane { normal: self.axes[0] },
            2 => Filter::Line { direction: self.axes[0].cross(&self.axes[1]).normalize() },
            _ => Filter::Fixed,
        }
    }

    /// The velocity `z` in the span of the normals with `n_k·z` as given. Normals at a flat angle would ask
    /// for a long `z`; it gets no longer than orthogonal ones would make it.
    fn combine(&self, normal_velocity: impl Fn(&Contact) -> f64) -> Vec3 {
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

    /// The normal of the contact with the least `λ_k` of `p = Σ λ_k n_k`, if that is negative.
    fn pulling(&self, impulse: &Vec3) -> Option<Vec3> {
        let mut rest = *impulse;
        let mut worst = None;
        let mut least = 0.0;
        for k in (0..self.len).rev() {
            // Of those not yet taken out, only contact k reaches along axis k.
            let normal = self.contacts[k]?.normal;
            let multiplier = self.axes[k].dot(&rest) / self.axes[k].dot(&normal);
            rest -= normal * multiplier;
            if multiplier < least {
                least = multiplier;
                worst = Some(normal);
            }
        }
        worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::{State, parse};

    fn contact(normal: Vec3, target: f64) -> Contact {
        let (normal, shift, keep) = (normal.normalize(), 0.0, 0.0);
        let (recovery, least) = (target, f64::NEG_INFINITY);
        Contact { particle: 0, obstacle: 0, normal, shift, recovery, target, keep, least }
    }

    fn spread(count: usize) -> Vec<Contact> {
        let normals =
            [Vec3::new(0.1, 0.2, 1.0), Vec3::new(1.0, -0.1, 0.3), Vec3::new(0.2, 1.0, 0.1)];
        let contacts = normals.iter().zip([0.7, 0.4, 0.2]);
        contacts.take(count).map(|(&normal, target)| contact(normal, target)).collect()
    }

    #[test]
    fn the_combined_velocity_has_the_target_along_every_normal() {
        for count in 1..=3 {
            let group = spread(count);
            let basis = Basis::of(&group);
            let z = basis.combine(|contact| contact.target);
            for contact in &group {
                assert!((contact.normal.dot(&z) - contact.target).abs() < 1e-12, "{count}: {z:?}");
            }
            assert!(basis.filter().apply(z).norm() < 1e-12, "z has a free part");
        }
    }

    #[test]
    fn the_contact_with_the_most_negative_multiplier_pulls() {
        for count in 1..=3 {
            let group = spread(count);
            let basis = Basis::of(&group);
            for worst in 0..count {
                let impulse = |factor: f64| {
                    group.iter().enumerate().fold(Vec3::zeros(), |p, (k, contact)| {
                        p + contact.normal * if k == worst { factor } else { 0.5 - 0.1 * k as f64 }
                    })
                };
                assert_eq!(basis.pulling(&impulse(-0.9)), Some(group[worst].normal));
                assert_eq!(basis.pulling(&impulse(1e-3)), None);
            }
        }
    }

    #[test]
    fn dependent_normals_are_left_out_and_flat_angles_do_not_shoot() {
        let twice = [contact(Vec3::z(), 1.0), contact(Vec3::z(), 0.5)];
        assert_eq!(Basis::of(&twice).combine(|c| c.target), Vec3::z());
        let opposite = [contact(Vec3::z(), 1.0), contact(-Vec3::z(), 0.5)];
        assert_eq!(Basis::of(&opposite).len, 1);
        let fan = [
            contact(Vec3::x(), 1.0),
            contact(Vec3::y(), 1.0),
            contact(Vec3::new(1.0, 1.0, 0.0), 1.0),
        ];
        assert_eq!(Basis::of(&fan).len, 2);
        let groove =
            [contact(Vec3::new(1.0, 0.0, 0.01), 1.0), contact(Vec3::new(-1.0, 0.0, 0.01), 1.0)];
        let z = Basis::of(&groove).combine(|c| c.target);
        assert!(z.norm() <= 2.0_f64.sqrt() + 1e-12 && z.z > 1.0, "{z:?}");
    }

    fn ball_on_plane(e: f64, z: f64, v: f64) -> (System, State) {
        let text = format!(
            r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [1],
            "position_m": [[0, 0, {z}]], "velocity_m_s": [[0, 0, {v}]] }},
            "obstacles": [{{ "plane": {{ "point_m": [0, 0, 0], "normal": [0, 0, 1], "restitution": {e} }} }}] }}"#
        );
        parse("test", &text).expect("valid").spec().build().expect("valid")
    }

    /// One step of symplectic Euler under gravity; returns whether the contact ended up active.
    fn step(set: &mut ContactSet, system: &System, state: &mut State, h: f64, g: f64) -> bool {
        let mut constraints = Constraints::free(1);
        set.detect(system, &state.x, &state.v, h, &mut constraints);
        let free = state.v[0] + Vec3::z() * (h * g);
        let mut impulse = [Vec3::zeros()];
        let v = &mut state.v;
        set.solve(system, &mut constraints, &mut impulse, |constraints, impulse| {
            v[0] = free;
            constraints.impose(v);
            if let Some(impulse) = impulse {
                impulse[0] = v[0] - free;
            }
            Ok::<(), ()>(())
        })
        .expect("never fails");
        state.x[0] += state.v[0] * h;
        set.settle(&mut state.v, |_, _| ());
        !set.is_empty()
    }

    #[test]
    fn a_resting_contact_is_active_in_every_step() {
        let (system, mut state) = ball_on_plane(0.6, 0.3, 0.0);
        let mut set = ContactSet::new(&system);
        for k in 0..2000 {
            let active = step(&mut set, &system, &mut state, 0.01, -9.81);
            assert!(k < 500 || (active && state.v[0].norm() == 0.0), "step {k}: {:?}", state.v[0]);
            if k % 100 == 99 {
                set.restart();
            }
        }
    }

    #[test]
    fn recovery_over_many_steps_keeps_what_the_impact_left_and_no_more() {
        for (e, left) in [(0.0, 0.0), (0.05, 0.5), (0.5, 5.0)] {
            let (system, mut state) = ball_on_plane(e, -0.09, -10.0);
            let mut set = ContactSet::new(&system);
            while state.x[0].z < 0.0 {
                let before = state.x[0].z;
                step(&mut set, &system, &mut state, 0.01, 0.0);
                let speed = (state.x[0].z - before) / 0.01;
                assert!(speed <= f64::max(1.0, left) + 1e-9, "e = {e}: led out at {speed}");
                assert!((state.v[0].z - left).abs() < 1e-12, "e = {e}: {:?}", state.v[0]);
            }
        }
    }

    #[test]
    fn an_obstacle_bears_what_rests_on_it_and_not_what_leaves_it() {
        for (e, speed, rests) in [(0.0, -1.0, true), (0.5, -1.0, false), (0.0, 1.0, false)] {
            let (system, state) = ball_on_plane(e, 0.0, speed);
            let mut set = ContactSet::new(&system);
            set.detect(&system, &state.x, &state.v, 0.01, &mut Constraints::free(1));
            for a in [Vec3::new(1.0, 2.0, -9.81), Vec3::new(1.0, 2.0, 0.5)] {
                let mut left = [a];
                set.support(0.01, &mut left);
                let expected = if rests { Vec3::new(1.0, 2.0, 0.0) } else { a };
                assert_eq!(left[0], expected, "e = {e}, at {speed} m/s");
            }
        }
    }

    /// One step of a multistep method that moves from `(x, v)` to `x* + τ v_+`: where it ends, and with which
    /// velocity, if there is a contact.
    fn multistep(e: f64, (x, v): (f64, f64), ahead: f64, tau: f64) -> Option<(f64, f64)> {
        let (system, state) = ball_on_plane(e, x, v);
        let (mut set, mut constraints) = (ContactSet::new(&system), Constraints::free(1));
        let x_star = [Vec3::new(3.0, -2.0, x + ahead)];
        let from = (&state.x[..], &state.v[..]);
        set.detect_multistep(
            &system,
            MultistepMotion { from, h: 0.01, x_star: &x_star, tau },
            &mut constraints,
        );
        let mut v = [Vec3::new(1.0, 2.0, -9.0)];
        constraints.impose(&mut v);
        let z = x_star[0].z + tau * v[0].z;
        set.settle(&mut v, |_, _| ());
        assert_eq!(v[0].xy(), Vec3::new(1.0, 2.0, 0.0).xy(), "the plane is smooth");
        (!set.is_empty()).then_some((z, v[0].z))
    }

    #[test]
    fn a_multistep_contact_ends_the_step_where_a_one_step_contact_would() {
        for (ahead, tau) in [(0.0, 0.01), (-0.01, 0.005), (-0.003, 0.02 / 3.0)] {
            let close = |found: Option<(f64, f64)>, (z, v): (f64, f64)| {
                let (found_z, found_v) = found.expect("a contact");
                let off = (found_z - z).abs().max((found_v - v).abs());
                assert!(off < 1e-15, "x* = x + {ahead}, τ = {tau}: {found_z}, {found_v}");
            };
            let step = |e, from| multistep(e, from, ahead, tau);
            close(step(0.0, (-0.004, -1.0)), (0.0, 0.0)); // on the surface, at rest
            close(step(0.0, (-0.3, 0.0)), (-0.29, 0.0)); // not faster than the limit of 1 m/s
            close(step(1.0, (-0.004, -2.0)), (-0.004, 2.0)); // reflected where it is
            assert_eq!(step(1.0, (-0.004, 2.0)), None, "it leaves by itself");
            assert_eq!(step(0.0, (0.004, -2.0)), None, "it is outside");
        }
    }

    #[test]
    fn settling_reports_contacts_that_begin_and_end() {
        let (system, mut state) = ball_on_plane(0.0, -1e-3, -1.0);
        let mut set = ContactSet::new(&system);
        let mut constraints = Constraints::free(1);
        for (x, expected) in [(-1e-3, true), (0.0, false), (0.5, true), (0.6, false)] {
            state.x[0].z = x;
            set.detect(&system, &state.x, &state.v, 0.01, &mut constraints);
            let mut calls = 0;
            state.v[0] = Vec3::zeros();
            set.settle(&mut state.v, |_, _| calls += 1);
            assert_eq!(calls > 0, expected, "at {x}");
        }
    }
}
