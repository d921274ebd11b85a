//! Lines of springs as systems of equations with three diagonals.
//!
//! The line `q_0, …, q_L` has the springs `s = 0, …, L − 1` between `q_s` and `q_{s+1}`. Spring `s`
//! has the direction `u_s`, from `q_{s+1}` to `q_s`, the constraint `C_s = |p_s − p_{s+1}| − ℓ_s`,
//! the multiplier `λ_s`, and `r_s = q_s − q_{s+1}`, the way that its ends went apart. As in
//! `drape-xpbd` everything is multiplied by `a = 1/α̃ = kτ²`, and `g = cτ`:
//!
//! ```text
//! d_s + b_s u_s·(δq_s − δq_{s+1}) = −(λ_s + a_s C_s + g_s u_s·r_s)     b = a + g           (L5)
//! δq_s = w_s (u_s d_s − u_{s−1} d_{s−1})     λ_s += d_s                                   (L6)
//! ```
//!
//! Each row has the unknowns `d_{s−1}`, `d_s`, `d_{s+1}`, and its diagonal outweighs the others:
//! `1 + b_s (w_s + w_{s+1})` against `−b_s w_s u_{s−1}·u_s` and `−b_s w_{s+1} u_s·u_{s+1}`. So
//! elimination needs no pivots. `g` counts here for damping along the springs only. Full damping
//! has rows of its own, the same for all three coordinates and constant while `τ` is:
//!
//! ```text
//! D_s + g_s (δq_s − δq_{s+1}) = −(Λ_s + g_s (r_s + r⁻_s))     Λ_s += D_s                  (L3)
//! δq_s = w_s (D_s − D_{s−1})
//! ```

use crate::abreast::Abreast;
use crate::cover::{Cover, Graph, Line};
use drape_model::{Effect, LinearSplit, System, Vec3};
use std::ops::Range;

/// A spring shorter than this fraction of its rest length has no direction.
pub(crate) const COLLAPSED: f64 = 1e-12;

/// What a solve reads of a spring. Numbers with `τ` in them hold for the present `τ`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spring {
    /// Its place in the list of the effect.
    number: u32,
    /// `ℓ`, m.
    pub(crate) rest: f64,
    /// `a = kτ²`, kg.
    pub(crate) pull: f64,
    /// `g = cτ`, kg.
    pub(crate) brake: f64,
    /// The pivot of (L3), inverted, and what elimination leaves right of the diagonal.
    pub(crate) pivot: f64,
    pub(crate) after: f64,
}

/// What sweeps leave of a spring for the next sweep of the substep.
#[derive(Clone, Copy, Debug, Default)]
struct Multiplier {
    /// `λ`, kg m: `τ²` times the tension, with the opposite sign.
    pull: f64,
    /// `Λ`, kg m; only full damping uses it.
    brake: Vec3,
}

/// What elimination remembers of a spring until it is solved.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    /// `u_s`.
    direction: Vec3,
    /// `u_{s−1}·u_s`.
    cosine: f64,
    /// What elimination leaves right of the diagonal, over `u_s·u_{s+1}`.
    after: f64,
    /// The right-hand side, then the solution `d`, kg m.
    step: f64,
}

/// Positions in a substep: `p = x* + q`, m.
#[derive(Debug)]
pub(crate) struct Places<'a> {
    pub(crate) base: &'a [Vec3],
    pub(crate) way: &'a mut [Vec3],
    /// `1/m`, 0 where pinned.
    pub(crate) inverse_mass: &'a [f64],
    /// Into how many bands threads cut a sweep; 1 for one thread.
    pub(crate) bands: usize,
}

impl Places<'_> {
    /// Moves the ends of a spring by an impulse (kg m) on the first and its opposite on the second.
    fn push(&mut self, ends: &[u32], impulse: &Vec3) {
        let [i, j] = [ends[0] as usize, ends[1] as usize];
        self.way[i] += impulse * self.inverse_mass[i];
        self.way[j] -= impulse * self.inverse_mass[j];
    }
}

/// The springs of one effect, line by line.
#[derive(Debug)]
pub(crate) struct Chains {
    /// Place of the effect in the system.
    effect: usize,
    /// Whether damping acts in all directions; else along the springs, if at all.
    is_full: bool,
    is_linear: bool,
    cover: Cover,
    /// Linear springs, four lines at a time.
    abreast: Option<Abreast>,
    /// In the order of the cover, as are the multipliers.
    springs: Vec<Spring>,
    /// Where the spring of a number stands in the cover.
    place_of: Vec<u32>,
    multipliers: Vec<Multiplier>,
    /// Scratch for the longest line.
    rows: Vec<Row>,
    /// Scratch for (L3).
    brakes: Vec<Vec3>,
}

/// The ends and rest lengths of the springs of an effect.
pub(crate) fn springs_of(effect: &dyn Effect) -> Vec<([u32; 2], f64)> {
    let mut springs = Vec::new();
    if let Some(split) = effect.split() {
        split.visit_rest_lengths(&mut |i, j, rest| springs.push(([i as u32, j as u32], rest)));
    }
    springs
}

impl Chains {
    /// The springs of an effect; `None` if it has none.
    pub(crate) fn new(
        (place, effect): (usize, &dyn Effect),
        (particles, threads): (usize, usize),
        graph: &Graph,
    ) -> Option<Self> {
        let shared = (threads > 1).then_some(particles);
        let split = effect.split()?;
        let ends: Vec<_> = springs_of(effect).into_iter().map(|(ends, _)| ends).collect();
        let cover = Cover::new(graph, particles, &ends);
        let mut place_of = vec![0; ends.len()];
        for (place, &number) in (0..).zip(&cover.springs) {
            place_of[number as usize] = place;
        }
        let spring = |&number: &u32| Spring { number, ..Spring::default() };
        let longest = cover.lines.iter().map(|line| line.springs.len()).max().unwrap_or(0);
        let is_full = effect.has_damping() && !split.has_damping_remainder();
        Some(Self {
            effect: place,
            is_full,
            is_linear: split.has_one_slope(),
            abreast: split.has_one_slope().then(|| Abreast::new(&cover, is_full, shared)).flatten(),
            springs: cover.springs.iter().map(spring).collect(),
            multipliers: vec![Multiplier::default(); ends.len()],
            rows: vec![Row::default(); longest],
            brakes: vec![Vec3::zeros(); if is_full { longest } else { 0 }],
            place_of,
            cover,
        })
    }

    /// Number of families.
    pub(crate) fn families(&self) -> usize {
        self.cover.families.len()
    }

    /// Whether damping acts in all directions.
    pub(crate) fn has_full_damping(&self) -> bool {
        self.is_full
    }

    /// `kτ²` of the stiffest spring of a family, kg.
    pub(crate) fn stiffest(&self, family: usize) -> f64 {
        let lines = &self.cover.lines[self.cover.families[family].clone()];
        let springs = lines.iter().flat_map(|line| &self.springs[line.springs.clone()]);
        springs.map(|spring| spring.pull).fold(0.0, f64::max)
    }

    /// Takes over what changes with the system and with `τ`.
    pub(crate) fn refresh(&mut self, system: &System, inverse_mass: &[f64], tau: f64) {
        let Some(split) = system.effects().nth(self.effect).and_then(Effect::split) else { return };
        let Self { cover, springs, place_of, .. } = self;
        let mut places = place_of.iter();
        split.visit_rest_lengths(&mut |_, _, rest| {
            if let Some(&place) = places.next() {
                springs[place as usize].rest = rest;
            }
        });
        let mut places = place_of.iter();
        split.visit_weights(&mut |_, _, k, c| {
            if let Some(&place) = places.next() {
                let spring = &mut springs[place as usize];
                (spring.pull, spring.brake) = (k * tau * tau, c * tau);
            }
        });
        for line in cover.lines.iter().filter(|_| self.is_full) {
            let members = &cover.particles[line.particles.clone()];
            let mut after = 0.0;
            for (ends, spring) in members.windows(2).zip(&mut springs[line.springs.clone()]) {
                let [w, w_next] = [ends[0], ends[1]].map(|i| inverse_mass[i as usize]);
                let g = spring.brake;
                spring.pivot = 1.0 / (1.0 + g * (w + w_next) + g * w * after);
                after = -g * w_next * spring.pivot;
                spring.after = after;
            }
        }
        if let Some(abreast) = &mut self.abreast {
            abreast.refresh(cover, springs, inverse_mass);
        }
    }

    /// The lines of a family that the fast form leaves over, after `fast` has taken the others.
    fn left_over(&mut self, family: usize, mut fast: impl FnMut(&mut Abreast)) -> Range<usize> {
        let mut lines = self.cover.families[family].clone();
        if let Some(abreast) = &mut self.abreast {
            fast(abreast);
            lines.start += abreast.covered(family);
        }
        lines
    }

    /// Multiplies the `Λ` of the last substep by a factor; 0 also ends numbers that are not finite.
    pub(crate) fn scale_damping(&mut self, factor: f64) {
        let fast = self.abreast.iter_mut().flat_map(Abreast::brakes_mut);
        let slow = self.multipliers.iter_mut().flat_map(|multiplier| multiplier.brake.iter_mut());
        fast.chain(slow)
            .for_each(|brake| *brake = if factor == 0.0 { 0.0 } else { *brake * factor });
    }

    /// Solves (L3) for each line of a family. `pending` is `r⁻` particle by particle: how far the
    /// springs are expected to move it in this substep, m; none in later sweeps. All that full
    /// damping has moved each particle in the substep is added to `damped`, m.
    pub(crate) fn brake(
        &mut self,
        family: usize,
        places: &mut Places<'_>,
        pending: Option<&[Vec3]>,
        damped: &mut [Vec3],
    ) {
        let lines = self.left_over(family, |fast| fast.brake(family, places, pending, damped));
        let Self { cover, springs, multipliers, brakes, .. } = self;
        for Line { springs: range, particles } in &cover.lines[lines] {
            let members = &cover.particles[particles.clone()];
            let (springs, multipliers) = (&springs[range.clone()], &mut multipliers[range.clone()]);
            let way = &*places.way;
            let goal = |i: usize| pending.map_or(way[i], |pending| way[i] + pending[i]);
            let mut before = Vec3::zeros();
            let links = members.windows(2).zip(springs).zip(&*multipliers);
            for (((ends, spring), multiplier), solved) in links.zip(&mut *brakes) {
                let [i, j] = [ends[0] as usize, ends[1] as usize];
                let g = spring.brake;
                let right = -(multiplier.brake + (goal(i) - goal(j)) * g);
                before = (right + before * (g * places.inverse_mass[i])) * spring.pivot;
                *solved = before;
            }
            let mut next = Vec3::zeros();
            let links = members.windows(2).zip(springs).zip(multipliers);
            for (((ends, spring), multiplier), solved) in links.zip(&*brakes).rev() {
                next = solved - next * spring.after;
                multiplier.brake += next;
                places.push(ends, &next);
                let [i, j] = [ends[0] as usize, ends[1] as usize];
                damped[i] += multiplier.brake * places.inverse_mass[i];
                damped[j] -= multiplier.brake * places.inverse_mass[j];
            }
        }
    }

    /// Solves (L5) for each line of a family, and moves its particles, (L6).
    pub(crate) fn pull(
        &mut self,
        family: usize,
        system: &System,
        tau: f64,
        places: &mut Places<'_>,
        is_first: bool,
    ) {
        let Some(split) = system.effects().nth(self.effect).and_then(Effect::split) else { return };
        let is_full = self.is_full;
        let lines = self.left_over(family, |fast| fast.pull(family, places, is_full, is_first));
        if self.is_linear {
            self.pull_by(lines, places, is_first, |spring, length| {
                (spring.pull * (length - spring.rest), spring.pull)
            });
        } else {
            let law = |spring: &Spring, length| curved(split, tau * tau, spring, length);
            self.pull_by(lines, places, is_first, law);
        }
    }

    fn pull_by(
        &mut self,
        lines: Range<usize>,
        places: &mut Places<'_>,
        is_first: bool,
        law: impl Fn(&Spring, f64) -> (f64, f64),
    ) {
        let Self { cover, springs, multipliers, rows, is_full, .. } = self;
        for Line { springs: range, particles } in &cover.lines[lines] {
            let members = &cover.particles[particles.clone()];
            let (springs, multipliers) = (&springs[range.clone()], &mut multipliers[range.clone()]);
            if is_first {
                multipliers.iter_mut().for_each(|multiplier| multiplier.pull = 0.0);
            }
            let rows = &mut rows[..springs.len()];
            eliminate(members, springs, multipliers, rows, places, *is_full, &law);
            substitute(members, multipliers, rows, places);
        }
    }
}

/// `a C` and `a` of a spring with a curve: `τ²T(L)` and `τ²T'(L)`.
fn curved(split: &dyn LinearSplit, square: f64, spring: &Spring, length: f64) -> (f64, f64) {
    match split.law(spring.number as usize) {
        None => (spring.pull * (length - spring.rest), spring.pull),
        Some(law) => {
            (square * law.tension(spring.rest, length), square * law.slope(spring.rest, length))
        }
    }
}

/// From the first spring of a line to its last: ends what (L5) has left of the diagonal.
fn eliminate(
    members: &[u32],
    springs: &[Spring],
    multipliers: &[Multiplier],
    rows: &mut [Row],
    Places { base, way, inverse_mass, .. }: &Places<'_>,
    is_full: bool,
    law: &impl Fn(&Spring, f64) -> (f64, f64),
) {
    let mut before = Row::default();
    for (((ends, spring), multiplier), row) in
        members.windows(2).zip(springs).zip(multipliers).zip(rows)
    {
        let [i, j] = [ends[0] as usize, ends[1] as usize];
        let [w, w_next] = [inverse_mass[i], inverse_mass[j]];
        let apart = way[i] - way[j];
        let difference = (base[i] - base[j]) + apart;
        let length = difference.norm();
        let has_direction = length > COLLAPSED * spring.rest;
        let u = if has_direction { difference * (1.0 / length) } else { Vec3::zeros() };
        let (tension, pull) = law(spring, length);
        let brake = if is_full { 0.0 } else { spring.brake };
        let stiffness = if has_direction { pull + brake } else { 0.0 };
        let excess = multiplier.pull + tension + brake * u.dot(&apart);
        let right = if has_direction { -excess } else { 0.0 };
        let cosine = before.direction.dot(&u);
        let left = -stiffness * w * cosine;
        let pivot = 1.0 / (1.0 + stiffness * (w + w_next) - left * (before.after * cosine));
        let step = (right - left * before.step) * pivot;
        before = Row { direction: u, cosine, after: -stiffness * w_next * pivot, step };
        *row = before;
    }
}

/// From the last spring of a line to its first: `d`, and the impulses (L6).
fn substitute(
    members: &[u32],
    multipliers: &mut [Multiplier],
    rows: &[Row],
    places: &mut Places<'_>,
) {
    let (mut next, mut cosine) = (0.0, 0.0);
    for ((ends, multiplier), row) in members.windows(2).zip(multipliers).zip(rows).rev() {
        next = row.step - row.after * cosine * next;
        cosine = row.cosine;
        multiplier.pull += next;
        places.push(ends, &(row.direction * next));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::{DampingLaw, State};
    use drape_oracle::bits;
    use drape_oracle::scenes::{Sheet, stir, uneven};

    /// Ways, and those by damping, after three sweeps over a stirred sheet.
    fn swept(law: DampingLaw, side: u32, is_fast: bool, bands: usize) -> State {
        let sheet =
            Sheet { side, tension: 1e6, shear: 1e5, damping: 50.0, law, ..Sheet::default() };
        let (system, state) = uneven(stir(sheet.build(), 0.02, 1.0));
        let n = system.len();
        let graph = Graph::new(n, system.effects().flat_map(springs_of));
        let mass = system.mass().iter().zip(system.pinned());
        let inverse_mass: Vec<_> = mass.map(|(m, p)| if *p { 0.0 } else { 1.0 / m }).collect();
        let (base, tau) = (&state.x[..], 1e-3);
        let mut way: Vec<Vec3> = state.v.iter().map(|v| v * tau).collect();
        let pending: Vec<Vec3> = state.v.iter().map(|v| v.zxy() * tau).collect();
        let mut damped = vec![Vec3::zeros(); n];
        let mut places = Places { base, way: &mut way, inverse_mass: &inverse_mass, bands };
        for effect in system.effects().enumerate() {
            let Some(mut chains) = Chains::new(effect, (n, bands), &graph) else { continue };
            let fast = chains.abreast.as_ref().map(|fast| fast.covered(0));
            assert!(fast.is_none_or(|covered| covered + 4 > chains.cover.families[0].len()));
            chains.abreast = chains.abreast.filter(|_| is_fast);
            chains.refresh(&system, &inverse_mass, tau);
            for (sweep, family) in (0..3).flat_map(|s| (0..2).map(move |f| (s, f))) {
                let is_first = sweep == 0;
                if chains.has_full_damping() {
                    let pending = is_first.then_some(&pending[..]);
                    chains.brake(family, &mut places, pending, &mut damped);
                    chains.scale_damping(0.5);
                }
                chains.pull(family, &system, tau, &mut places, is_first);
            }
        }
        State { x: way, v: damped, ..state }
    }

    /// Groups of four lines, of different lengths, and lines left over.
    #[test]
    fn four_lines_abreast_give_the_bits_of_one_after_the_other() {
        for (law, side) in [DampingLaw::Full, DampingLaw::Projected]
            .iter()
            .flat_map(|&law| [3, 4, 5, 11, 40].map(|side| (law, side)))
        {
            let slow = swept(law, side, false, 1);
            for bands in [1, 2, 3, 8] {
                let fast = swept(law, side, true, bands);
                assert!(bits(&slow) == bits(&fast), "{law:?}, {side}, {bands}");
            }
        }
    }
}
