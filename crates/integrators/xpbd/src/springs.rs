//! Springs as constraints that yield.
//!
//! The constraint of a spring is `C = |p_i − p_j| − ℓ`, its gradient the direction `u`. XPBD
//! divides by the compliance `α̃ = 1/(kτ²)`. Here everything is multiplied by `a = 1/α̃ = kτ²`
//! instead, so that a spring without stiffness needs no special case. `w = w_i + w_j` is the sum of
//! the inverse masses, `r` the way that the ends have gone apart in the substep, `g = cτ`:
//!
//! ```text
//! projected damping:  Δλ = −(λ + a C + g u·r) / (1 + (a + g) w)                             (X4)
//! full damping:       μ  = −(Λ + g r) s      s = 1/(1 + g w)      p_i − p_j moves by w μ
//!                     Δλ = −(λ + a C) / (1 + a w s)      impulse  μ + s Δλ u                (X5)
//! ```
//!
//! (X5) is (X4) beside a second constraint, `r = 0` with the compliance `1/g`, whose multiplier `Λ`
//! has three components. Both are solved at once: `μ` is what the damping does alone, and `s` is
//! the share of a pull that it lets pass. A spring that is not linear has `a C = τ²T(L)` and
//! `a = τ²T'(L)`: the secant of its present piece, which is a linear spring with the stiffness of
//! the piece and the rest length at which the piece would have no tension.

use crate::lanes::{Cut, Groups, Quads};
use drape_integrator::Colouring;
use drape_model::{Effect, LinearSplit, System, Vec3};

/// A spring shorter than this fraction of its rest length has no direction.
pub(crate) const COLLAPSED: f64 = 1e-12;

/// How the springs of an effect are damped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Damping {
    /// Along the springs, or not at all.
    Along,
    /// In all directions.
    Full,
}

/// What a projection reads of a spring. Numbers with `τ` in them hold for the present `τ`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spring {
    pub(crate) ends: [u32; 2],
    /// Its place in the list of the effect.
    number: u32,
    /// `ℓ`, m.
    pub(crate) rest: f64,
    /// `w = w_i + w_j`, 1/kg.
    pub(crate) mobility: f64,
    /// `a = kτ²`, kg.
    pub(crate) pull: f64,
    /// `g = cτ`, kg.
    pub(crate) brake: f64,
    /// `s = 1/(1 + g w)`; 1 where damping acts along the spring only.
    pub(crate) pass: f64,
    /// `1/(1 + (a + g) w)` or `1/(1 + a w s)`, where `a` is constant.
    pub(crate) share: f64,
}

/// What sweeps leave of a spring for the next sweep of the substep.
#[derive(Clone, Copy, Debug, Default)]
struct Multiplier {
    /// `λ`, kg m: `τ²` times the tension, with the opposite sign.
    pull: f64,
    /// `Λ`, kg m; only full damping uses it.
    brake: Vec3,
}

/// Place of a sweep among those of its substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pass {
    /// It starts from `λ = 0`.
    pub(crate) is_first: bool,
    /// It need not leave its multipliers: with one sweep they cost no memory traffic.
    pub(crate) is_last: bool,
}

/// Positions in a substep: `p = x* + q`, m.
///
/// Sweeps move the ways `q`. They are small beside positions, so the velocity `q/τ` keeps its
/// digits however short the substep is.
#[derive(Debug)]
pub(crate) struct Places<'a> {
    pub(crate) base: &'a [Vec3],
    pub(crate) way: &'a mut [Vec3],
    /// `1/m`, 0 where pinned.
    pub(crate) inverse_mass: &'a [f64],
    /// The same as registers.
    pub(crate) quads: &'a mut Quads,
    /// Whether the registers hold the present ways, and `way` does not.
    pub(crate) is_wide: bool,
}

/// The springs of one effect.
#[derive(Debug)]
pub(crate) struct Springs {
    /// Place of the effect in the system.
    effect: usize,
    damping: Damping,
    is_linear: bool,
    /// In the order of a sweep.
    list: Vec<Spring>,
    /// Where the spring of a number stands in the list.
    place_of: Vec<u32>,
    /// Of the sweep spring by spring.
    multipliers: Vec<Multiplier>,
    /// The same springs four at a time, if they are linear and enough of them are independent.
    groups: Option<Groups>,
}

impl Springs {
    /// The springs of an effect; `None` if it has none.
    pub(crate) fn new(
        (place, effect): (usize, &dyn Effect),
        cut: Cut,
        is_coloured: bool,
    ) -> Option<Self> {
        let split = effect.split()?;
        let mut ends = Vec::new();
        split.visit_weights(&mut |i, j, _, _| ends.push([i as u32, j as u32]));
        let colouring = match is_coloured {
            true => Colouring::greedy(cut.particles, &ends),
            false => Colouring::list(ends.len()),
        };
        let mut place_of = vec![0; ends.len()];
        for (place, &number) in (0..).zip(&colouring.order) {
            place_of[number as usize] = place;
        }
        let spring = |&number: &u32| Spring {
            ends: ends[number as usize],
            number,
            rest: 0.0,
            mobility: 0.0,
            pull: 0.0,
            brake: 0.0,
            pass: 1.0,
            share: 1.0,
        };
        let is_full = effect.has_damping() && !split.has_damping_remainder();
        let list: Vec<_> = colouring.order.iter().map(spring).collect();
        let colours = is_coloured.then_some(&colouring.ends[..]);
        let damping = if is_full { Damping::Full } else { Damping::Along };
        let groups = split.has_one_slope().then(|| Groups::new(&list, cut, damping, colours));
        Some(Self {
            effect: place,
            damping,
            is_linear: split.has_one_slope(),
            multipliers: vec![Multiplier::default(); list.len()],
            groups: groups.flatten(),
            list,
            place_of,
        })
    }

    /// Takes over what changes with the system and with `τ`.
    pub(crate) fn refresh(&mut self, system: &System, inverse_mass: &[f64], tau: f64) {
        let Some(split) = system.effects().nth(self.effect).and_then(Effect::split) else { return };
        let Self { damping, list, place_of, .. } = self;
        let mut places = place_of.iter();
        split.visit_rest_lengths(&mut |_, _, rest| {
            if let Some(&place) = places.next() {
                list[place as usize].rest = rest;
            }
        });
        let mut places = place_of.iter();
        split.visit_weights(&mut |i, j, k, c| {
            let Some(&place) = places.next() else { return };
            let spring = &mut list[place as usize];
            let w = inverse_mass[i] + inverse_mass[j];
            let (a, g) = (k * tau * tau, c * tau);
            let (pass, stiffness) = match damping {
                Damping::Along => (1.0, a + g),
                Damping::Full => (1.0 / (1.0 + g * w), a),
            };
            spring.mobility = w;
            spring.pull = a;
            spring.brake = g;
            spring.pass = pass;
            spring.share = 1.0 / (1.0 + stiffness * w * pass);
        });
        if let Some(groups) = &mut self.groups {
            groups.refresh(&self.list);
        }
    }

    /// Projects all springs once.
    #[doc(alias = "Gauss-Seidel")]
    pub(crate) fn sweep(&mut self, system: &System, tau: f64, places: &mut Places<'_>, pass: Pass) {
        if let Some(groups) = &mut self.groups {
            return groups.sweep(places.widen(), pass);
        }
        self.reference(system, tau, places, pass);
    }

    /// The readable form: spring by spring.
    fn reference(&mut self, system: &System, tau: f64, places: &mut Places<'_>, pass: Pass) {
        let Some(split) = system.effects().nth(self.effect).and_then(Effect::split) else { return };
        places.narrow();
        let square = tau * tau;
        let law = |spring: &Spring, length| match self.is_linear {
            true => linear(spring, length),
            false => curved(split, square, spring, length),
        };
        for (spring, multiplier) in self.list.iter().zip(&mut self.multipliers) {
            let seen = Seen::new(spring, places.base, places.way, multiplier, pass);
            let (impulse, left) = match self.damping {
                Damping::Along => along(spring, seen, law),
                Damping::Full => full(spring, seen, law),
            };
            places.push(spring, &impulse);
            if !pass.is_last {
                *multiplier = left;
            }
        }
    }
}

impl Places<'_> {
    /// The present ways as registers.
    fn widen(&mut self) -> &mut Quads {
        if !std::mem::replace(&mut self.is_wide, true) {
            self.quads.read(self.way);
        }
        self.quads
    }

    /// Brings `way` up to date.
    pub(crate) fn narrow(&mut self) {
        if std::mem::replace(&mut self.is_wide, false) {
            self.quads.write(self.way);
        }
    }

    /// Moves the ends of a spring by an impulse (kg m) on the first and its opposite on the second.
    fn push(&mut self, spring: &Spring, impulse: &Vec3) {
        let [i, j] = spring.ends.map(|end| end as usize);
        self.way[i] += impulse * self.inverse_mass[i];
        self.way[j] -= impulse * self.inverse_mass[j];
    }
}

/// A spring as a sweep finds it.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// `p_i − p_j`, m.
    d: Vec3,
    /// `r = q_i − q_j`, m.
    apart: Vec3,
    /// What earlier sweeps have left.
    multiplier: Multiplier,
}

impl Seen {
    fn new(
        spring: &Spring,
        base: &[Vec3],
        way: &[Vec3],
        multiplier: &Multiplier,
        pass: Pass,
    ) -> Self {
        let [i, j] = spring.ends.map(|end| end as usize);
        let apart = way[i] - way[j];
        let multiplier = if pass.is_first { Multiplier::default() } else { *multiplier };
        Self { d: (base[i] - base[j]) + apart, apart, multiplier }
    }
}

/// `a C` and `1/(1 + (a + g) w)` of a linear spring.
fn linear(spring: &Spring, length: f64) -> (f64, f64) {
    (spring.pull * (length - spring.rest), spring.share)
}

/// The same of a spring with a curve: `a C = τ²T(L)`, `a = τ²T'(L)`.
fn curved(split: &dyn LinearSplit, square: f64, spring: &Spring, length: f64) -> (f64, f64) {
    let Some(law) = split.law(spring.number as usize) else { return linear(spring, length) };
    let slope = square * law.slope(spring.rest, length);
    let stiffness = if spring.pass < 1.0 { slope } else { slope + spring.brake };
    let share = 1.0 / (1.0 + stiffness * spring.mobility * spring.pass);
    (square * law.tension(spring.rest, length), share)
}

/// (X4): the impulse on the first end, and the new multiplier.
fn along(
    spring: &Spring,
    Seen { d, apart, multiplier: Multiplier { pull: lambda, .. } }: Seen,
    law: impl Fn(&Spring, f64) -> (f64, f64),
) -> (Vec3, Multiplier) {
    let length = d.norm();
    if length <= COLLAPSED * spring.rest {
        return (Vec3::zeros(), Multiplier { pull: lambda, brake: Vec3::zeros() });
    }
    let u = d / length;
    let (pull, share) = law(spring, length);
    let step = -(lambda + pull + spring.brake * u.dot(&apart)) * share;
    (u * step, Multiplier { pull: lambda + step, brake: Vec3::zeros() })
}

/// (X5): the impulse on the first end, and the new multipliers.
fn full(
    spring: &Spring,
    Seen { d, apart, multiplier: Multiplier { pull: lambda, brake } }: Seen,
    law: impl Fn(&Spring, f64) -> (f64, f64),
) -> (Vec3, Multiplier) {
    let damping = -(brake + apart * spring.brake) * spring.pass;
    let d = d + damping * spring.mobility;
    let length = d.norm();
    if length <= COLLAPSED * spring.rest {
        return (damping, Multiplier { pull: lambda, brake: brake + damping });
    }
    let u = d / length;
    let (pull, share) = law(spring, length);
    let step = -(lambda + pull) * share;
    let impulse = damping + u * (spring.pass * step);
    (impulse, Multiplier { pull: lambda + step, brake: brake + (impulse - u * step) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::DampingLaw;
    use drape_oracle::Random;
    use drape_oracle::scenes::{Sheet, build, stir, uneven};

    /// Three sweeps over all springs of a system in so many bands, or spring by spring. Also
    /// returns how many effects are swept in groups.
    fn swept(
        system: &System,
        is_coloured: bool,
        region: usize,
        bands: Option<usize>,
    ) -> (Vec<Vec3>, usize) {
        let mut random = Random::new(7);
        let n = system.len();
        let mut vectors = || -> Vec<Vec3> { (0..n).map(|_| random.vector()).collect() };
        let (mut base, mut way) = (vectors(), vectors());
        (base[1], way[1]) = (base[0], way[0]); // a spring without a length
        let inverse_mass: Vec<f64> = (system.mass().iter().zip(system.pinned()))
            .map(|(m, pinned)| if *pinned { 0.0 } else { 1.0 / m })
            .collect();
        let cut = Cut { particles: n, region };
        let mut quads = Quads::new(cut);
        quads.share(bands.unwrap_or(1));
        quads.weigh(&inverse_mass);
        quads.start(&base);
        let (tau, mut grouped) = (0.01, 0);
        let effects = system.effects().enumerate();
        let mut all: Vec<_> = effects.filter_map(|e| Springs::new(e, cut, is_coloured)).collect();
        for springs in &mut all {
            springs.refresh(system, &inverse_mass, tau);
            grouped += usize::from(springs.groups.is_some());
        }
        for sweep in 0..3 {
            let pass = Pass { is_first: sweep == 0, is_last: sweep == 2 };
            let (inverse_mass, quads) = (&inverse_mass[..], &mut quads);
            let mut places =
                Places { base: &base, way: &mut way, inverse_mass, quads, is_wide: false };
            for springs in &mut all {
                match bands {
                    Some(_) => springs.sweep(system, tau, &mut places, pass),
                    None => springs.reference(system, tau, &mut places, pass),
                }
            }
            places.narrow();
        }
        (way, grouped)
    }

    /// Grids with pins and masses that differ, and one whose springs are in disorder.
    fn systems(law: DampingLaw) -> Vec<System> {
        let sheet = |side| Sheet { side, tension: 1e5, shear: 1e4, law, ..Sheet::default() };
        let mut systems: Vec<System> = [2, 3, 7, 20]
            .into_iter()
            .map(|side| uneven(stir(sheet(side).build(), 0.02, 1.0)).0)
            .collect();
        let (mut spec, mut random) = (sheet(12).spec(), Random::new(3));
        for last in (1..spec.springs.len()).rev() {
            spec.springs.swap(last, random.below(last + 1));
        }
        systems.push(build(&spec).0);
        systems
    }

    /// Regions of a few particles, so that a spring lies within a pair of either kind or within
    /// none, and of more than all.
    #[test]
    fn groups_give_the_bits_of_the_sweep_spring_by_spring() {
        for law in [DampingLaw::Full, DampingLaw::Projected] {
            for (place, system) in systems(law).iter().enumerate() {
                for is_coloured in [false, true] {
                    let (expected, _) = swept(system, is_coloured, 9999, None);
                    for (region, bands) in [(9999, 1), (9999, 3), (45, 1), (45, 3), (7, 9)] {
                        let (found, grouped) = swept(system, is_coloured, region, Some(bands));
                        assert!(place < 2 || grouped > 0, "system {place} is swept in groups");
                        let case = format!("system {place}, {is_coloured}, {region}, {bands}");
                        assert!(found == expected, "{law:?}, {case}");
                    }
                }
            }
        }
    }
}
