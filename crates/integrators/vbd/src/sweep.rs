//! Block descent: one Newton step for each particle, colour by colour.

use crate::lanes::Groups;
use crate::rows::Rows;
use crate::settings::VbdSettings;
use crate::terms::{Damping, Terms};
use drape_model::{Mat3, System, Vec3};
use drape_solvers::bands::{bands, in_bands};
use drape_solvers::{Constraints, Filter};
use nalgebra::Cholesky;

/// The unknowns of a step, with the iterates that Chebyshev's acceleration combines.
#[derive(Debug)]
pub(crate) struct Iterate {
    /// Positions `x_n + h v`, m.
    pub(crate) x: Vec<Vec3>,
    /// Velocities, m/s.
    pub(crate) v: Vec<Vec3>,
    /// `v` one sweep and two sweeps before, m/s.
    before: [Vec<Vec3>; 2],
    /// New velocities of one colour, m/s.
    colour: Vec<Vec3>,
}

/// What a sweep reads and does not change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Problem<'a> {
    pub(crate) system: &'a System,
    /// `h`, s.
    pub(crate) h: f64,
    /// `x_n`, m.
    pub(crate) from: &'a [Vec3],
    /// `v̂`, m/s.
    pub(crate) target: &'a [Vec3],
    pub(crate) damping: &'a Damping,
    pub(crate) colours: &'a Rows<u32>,
    /// The fast form; without it particles move one by one.
    pub(crate) groups: Option<&'a Groups>,
}

/// The solution of the symmetric system `a d = b`. As Chen et al. do, it leaves the particle alone
/// where the block is singular to round-off. NaN and infinities stay visible.
fn solve(a: Mat3, b: &Vec3) -> Vec3 {
    let is_finite = a.iter().all(|number| number.is_finite());
    let otherwise = if is_finite { Vec3::zeros() } else { Vec3::repeat(f64::NAN) };
    Cholesky::new(a).map_or(otherwise, |factor| factor.solve(b))
}

impl Problem<'_> {
    /// The velocity that one Newton step gives particle `i`, (V2)–(V4); all others keep theirs.
    #[doc(alias = "vertex block")]
    pub(crate) fn descend(
        &self,
        terms: &Terms,
        constraints: &Constraints,
        at: &Iterate,
        i: usize,
    ) -> Vec3 {
        let Self { system, h, target, damping, .. } = *self;
        let filter = constraints.filter(i);
        if filter == Filter::Fixed {
            return at.v[i];
        }
        let mass = system.mass()[i];
        let (force, stiffness) = terms.at(system, i, &at.x);
        let (drag, viscosity) = damping.at(i, &at.v);
        let drag = drag - damping.force_at_rest(i);
        // g_i = m (v_i − v̂_i) − h f_i + h (D v)_i, (V2)
        let gradient = (at.v[i] - target[i]) * mass + (drag - force) * h;
        // H_i = m I + h² K_ii + h D_ii, (V3)
        let inertia = Mat3::from_diagonal_element(mass);
        let block = inertia + stiffness * (h * h) + viscosity * h;
        // v_i ← v_i − (S H S + m (I − S))⁻¹ S g, (V4)
        let change = match filter {
            Filter::Free => solve(block, &gradient),
            _ => {
                let s = filter.matrix();
                let filtered = s * block * s + inertia - s * mass;
                filter.apply(solve(filtered, &filter.apply(gradient)))
            }
        };
        at.v[i] - change
    }

    /// One sweep over all particles. Particles of a colour do not feel each other, so their order
    /// does not matter, nor does the number of threads.
    fn sweep(&self, terms: &Terms, constraints: &Constraints, at: &mut Iterate) {
        let bands = bands(self.system.threads(), self.system.len());
        let mut new = std::mem::take(&mut at.colour);
        for colour in 0..self.colours.len() {
            let particles = self.colours.row(colour);
            let count = particles.len();
            in_bands(bands, count, &mut new[..count], &|range, new: &mut [Vec3]| {
                if let Some(groups) = self.groups {
                    let place = (colour, range.start);
                    return groups.descend(self, (terms, constraints), at, place, new);
                }
                for (new, i) in new.iter_mut().zip(&particles[range]) {
                    *new = self.descend(terms, constraints, at, *i as usize);
                }
            });
            for (new, &i) in new.iter().zip(particles) {
                let i = i as usize;
                (at.v[i], at.x[i]) = (*new, self.from[i] + new * self.h);
            }
        }
        at.colour = new;
    }

    /// All sweeps of a solve from `at.v`.
    pub(crate) fn minimise(
        &self,
        settings: &VbdSettings,
        terms: &mut Terms,
        constraints: &Constraints,
        at: &mut Iterate,
    ) {
        constraints.impose(&mut at.v);
        at.place(self.from, self.h);
        let mut omega = 1.0;
        for sweep in 1..=settings.sweeps {
            if settings.chebyshev > 0.0 {
                at.remember();
            }
            self.sweep(terms, constraints, at);
            if settings.chebyshev > 0.0 && sweep > 1 {
                omega = next_weight(omega, settings.chebyshev, sweep);
                at.extrapolate(omega);
                at.place(self.from, self.h);
            }
            if settings.augmented {
                terms.stiffen(&at.x, settings.beta);
            }
        }
    }
}

/// `ω_2 = 2/(2 − ρ²)`, `ω_{s+1} = 4/(4 − ρ² ω_s)` (Wang 2015).
#[doc(alias = "Chebyshev")]
#[doc(alias = "Wang 2015")]
fn next_weight(omega: f64, rho: f64, sweep: u32) -> f64 {
    if sweep == 2 { 2.0 / (2.0 - rho * rho) } else { 4.0 / (4.0 - rho * rho * omega) }
}

impl Iterate {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || vec![Vec3::zeros(); n];
        Self { x: zeros(), v: zeros(), before: [zeros(), zeros()], colour: zeros() }
    }

    /// `x = x_n + h v`.
    fn place(&mut self, from: &[Vec3], h: f64) {
        for ((x, from), v) in self.x.iter_mut().zip(from).zip(&self.v) {
            *x = from + v * h;
        }
    }

    fn remember(&mut self) {
        self.before.swap(0, 1);
        self.before[0].copy_from_slice(&self.v);
    }

    /// `v^{(s)} ← ω (v̄ − v^{(s−2)}) + v^{(s−2)}`.
    fn extrapolate(&mut self, omega: f64) {
        for (v, older) in self.v.iter_mut().zip(&self.before[1]) {
            *v = older + (*v - older) * omega;
        }
    }
}
