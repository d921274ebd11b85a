//! Contacts with rigid obstacles by velocity constraints (EEH section 6).
//!
//! A particle that lies inside an obstacle gets its normal velocity prescribed so that it is led
//! back to the surface:
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
//!   constraint; a contact whose `λ = n·p` is negative would pull, so it is dropped and the step
//!   solved again, at most three times.
//! * **No chatter.** A contact that was active stays a candidate while it lies within 1e-9 m of the
//!   surface.
//! * **No pop.** The speed of recovery is limited by the scene, and after the update of positions the
//!   normal velocity is cut back to what the impact left (split impulse): correcting a
//!   penetration gives the particle no kinetic energy.
//! * **Restitution.** A particle that arrives with normal velocity `a < 0` leaves with `−e a`.

use drape_model::{Detection, System, Vec3};
use drape_solvers::{Constraints, Filter};

/// How far outside the surface a contact stays a candidate, m.
const STICKY_DISTANCE: f64 = 1e-9;
/// Most re-solves after releases in one step.
const MAX_RELEASE_PASSES: usize = 3;
/// Normals whose cross product is shorter than this count as parallel.
const PARALLEL: f64 = 1e-6;

#[derive(Clone, Copy, Debug)]
struct Contact {
    particle: u32,
    obstacle: u32,
    normal: Vec3,
    /// Normal velocity of the constraint.
    target: f64,
    /// Greatest normal velocity that the particle may keep after the step.
    keep: f64,
}

/// The contacts of the running step, and which were active in the last one.
#[derive(Clone, Debug, Default)]
pub struct ContactSet {
    obstacles: usize,
    candidates: Vec<Contact>,
    was_active: Vec<bool>,
    is_active: Vec<bool>,
}

impl ContactSet {
    /// Memory for every particle in contact with every obstacle.
    pub fn new(system: &System) -> Self {
        let obstacles = system.obstacles().len();
        let slots = obstacles * system.len();
        Self {
            obstacles,
            candidates: Vec::with_capacity(slots),
            was_active: vec![false; slots],
            is_active: vec![false; slots],
        }
    }

    /// Forgets which contacts were active.
    pub fn restart(&mut self) {
        self.was_active.fill(false);
        self.candidates.clear();
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
        self.candidates.clear();
        if self.obstacles > 0 {
            self.collect(system, x, v, tau);
        }
        self.write(system, constraints);
    }

    fn collect(&mut self, system: &System, x: &[Vec3], v: &[Vec3], tau: f64) {
        let limit = system.contact().recovery_speed_limit;
        let speculative = system.contact().detection == Detection::Speculative;
        for particle in (0..x.len()).filter(|&i| !system.pinned()[i]) {
            for (index, obstacle) in system.obstacles().iter().enumerate() {
                let (distance, normal) = obstacle.distance(&x[particle]);
                let approach = normal.dot(&v[particle]);
                let inside = distance < 0.0 || (speculative && distance + tau * approach < 0.0);
                let resting =
                    self.was_active[self.slot(particle, index)] && distance < STICKY_DISTANCE;
                if inside || resting {
                    let recovery = (-distance / tau).min(limit);
                    let rebound = (-obstacle.restitution * approach).max(0.0);
                    self.candidates.push(Contact {
                        particle: particle as u32,
                        obstacle: index as u32,
                        normal,
                        target: recovery.max(rebound),
                        keep: rebound.max(approach),
                    });
                }
            }
        }
    }

    fn write(&self, system: &System, constraints: &mut Constraints) {
        constraints.clear();
        for particle in (0..system.len()).filter(|&i| system.pinned()[i]) {
            constraints.set(particle, Filter::Fixed, Vec3::zeros());
        }
        for group in self.candidates.chunk_by(|a, b| a.particle == b.particle) {
            let (filter, prescribed) = combine(group);
            constraints.set(group[0].particle as usize, filter, prescribed);
        }
    }

    /// Solves a step under its constraints, and again after contacts were released.
    ///
    /// `solve` gets the constraints and, where there are contacts, the slice that it must fill with
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
                return solve(constraints, None);
            }
            solve(constraints, Some(impulse))?;
            if !self.release(system, impulse, constraints) {
                return Ok(());
            }
        }
        solve(constraints, None)
    }

    /// Drops the contacts that would pull, given the unfiltered residual `p = A v_+ − b`
    /// (kg m/s), and rewrites the constraints. Returns whether any was dropped.
    fn release(
        &mut self,
        system: &System,
        impulse: &[Vec3],
        constraints: &mut Constraints,
    ) -> bool {
        let before = self.candidates.len();
        let mut kept = 0;
        let mut start = 0;
        while start < before {
            let particle = self.candidates[start].particle;
            let length =
                self.candidates[start..].iter().take_while(|c| c.particle == particle).count();
            let weakest = weakest(&self.candidates[start..start + length], &impulse[particle as usize]);
            for position in start..start + length {
                if Some(position - start) != weakest {
                    self.candidates[kept] = self.candidates[position];
                    kept += 1;
                }
            }
            start += length;
        }
        self.candidates.truncate(kept);
        if kept < before {
            self.write(system, constraints);
        }
        kept < before
    }

    /// Ends a step: cuts the normal velocities back to what the impacts left, calls `changed` for
    /// each particle whose history no longer fits (a contact began, ended or cut its velocity), and
    /// remembers which contacts were active.
    pub fn settle(&mut self, v: &mut [Vec3], mut changed: impl FnMut(usize, &Vec3)) {
        if self.obstacles == 0 {
            return;
        }
        self.is_active.fill(false);
        for contact in &self.candidates {
            let particle = contact.particle as usize;
            self.is_active[particle * self.obstacles + contact.obstacle as usize] = true;
            let excess = contact.normal.dot(&v[particle]) - contact.keep;
            if excess > 0.0 {
                v[particle] -= contact.normal * excess;
                changed(particle, &v[particle]);
            }
        }
        for (slot, (was, is)) in self.was_active.iter().zip(&self.is_active).enumerate() {
            if was != is {
                let particle = slot / self.obstacles;
                changed(particle, &v[particle]);
            }
        }
        std::mem::swap(&mut self.was_active, &mut self.is_active);
    }
}

/// Filter and prescribed velocity of all contacts of one particle.
fn combine(group: &[Contact]) -> (Filter, Vec3) {
    let first = &group[0];
    let single = (Filter::Plane { normal: first.normal }, first.normal * first.target);
    let Some(second) = group[1..].iter().find(|c| first.normal.cross(&c.normal).norm() > PARALLEL)
    else {
        return single;
    };
    let along = first.normal.cross(&second.normal);
    let third = group.iter().find(|c| along.dot(&c.normal).abs() > PARALLEL * along.norm());
    // Solves n_k · z = target_k; without a third independent normal z has no part along the line.
    let (row, target) = third.map_or((along, 0.0), |c| (c.normal, c.target));
    let rows = nalgebra::Matrix3::from_rows(&[
        first.normal.transpose(),
        second.normal.transpose(),
        row.transpose(),
    ]);
    let targets = Vec3::new(first.target, second.target, target);
    match rows.try_inverse() {
        Some(inverse) if third.is_some() => (Filter::Fixed, inverse * targets),
        Some(inverse) => (Filter::Line { direction: along.normalize() }, inverse * targets),
        None => single,
    }
}

/// The contact of one particle that pulls hardest, if any pulls.
fn weakest(group: &[Contact], impulse: &Vec3) -> Option<usize> {
    let multiplier = |k: usize| match group {
        [_] => group[k].normal.dot(impulse),
        [a, b] => {
            // p = λ_a n_a + λ_b n_b in the plane of the two normals.
            let c = a.normal.dot(&b.normal);
            let determinant = 1.0 - c * c;
            let (pa, pb) = (a.normal.dot(impulse), b.normal.dot(impulse));
            if determinant < PARALLEL {
                [pa, pb][k]
            } else {
                [(pa - c * pb) / determinant, (pb - c * pa) / determinant][k]
            }
        }
        _ => group[k].normal.dot(impulse),
    };
    (0..group.len())
        .map(|k| (k, multiplier(k)))
        .filter(|(_, lambda)| *lambda < 0.0)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(k, _)| k)
}
