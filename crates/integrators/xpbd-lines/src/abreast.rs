//! Four lines of a family side by side in vector registers: the fast form of [`crate::chains`].
//!
//! The lines of a family share no particle, so four of them can be solved at once, spring by
//! spring. A shorter line is filled up with springs without stiffness that begin and end at its
//! last particle: they find no direction, and move nothing. The operations of a line are those of
//! the readable form in the same order, so both give the same bits.
//!
//! Several threads share the groups of a family. They write new ways beside the old ones, joint by
//! joint (module [`shared`]), and each particle takes its own when all groups are solved. No group
//! reads what another one moves, so the number of threads changes no bit.

mod shared;

use self::shared::Shared;
use crate::chains::{COLLAPSED, Places, Spring};
use crate::cover::{Cover, Line};
use drape_model::Vec3;
use pulp::{Arch, Simd, WithSimd, bytemuck};
use std::ops::Range;

/// Lines side by side.
const LINES: usize = 4;

/// A number for each of four lines.
type Four = [f64; LINES];

/// Four springs.
#[derive(Clone, Copy, Debug, Default)]
struct Link {
    rest: Four,
    /// `a`, kg.
    pull: Four,
    /// `g = cτ`, kg.
    brake: Four,
    /// Of full damping: the pivot of (L3), inverted, and what elimination leaves right of it.
    pivot: Four,
    after: Four,
}

/// Four particles.
#[derive(Clone, Copy, Debug, Default)]
struct Joint {
    particles: [u32; LINES],
    /// `1/m`, 0 where pinned.
    inverse_mass: Four,
}

/// What elimination remembers of four springs.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    direction: [Four; 3],
    cosine: Four,
    after: Four,
    step: Four,
}

/// All groups of four lines of an effect.
#[derive(Debug)]
pub(crate) struct Abreast {
    arch: Arch,
    links: Vec<Link>,
    /// `λ`, kg m, of each link.
    multipliers: Vec<Four>,
    /// `Λ`, kg m, of each link; empty without full damping, as is their scratch.
    brakes: Vec<[Four; 3]>,
    solved: Vec<[Four; 3]>,
    /// One more than links in each group.
    joints: Vec<Joint>,
    /// Links of each group; its joints begin as many places later as groups come before it.
    groups: Vec<Range<usize>>,
    /// The first line of each group.
    firsts: Vec<usize>,
    /// The groups of each family.
    families: Vec<Range<usize>>,
    rows: Vec<Row>,
    /// For several threads; else `None`.
    shared: Option<Shared>,
}

/// Four numbers a register, if this processor has them.
fn arch() -> Option<Arch> {
    #[cfg(target_arch = "x86_64")]
    if let Some(v3) = pulp::x86::V3::try_new() {
        return Some(Arch::V3(v3));
    }
    None
}

impl Abreast {
    /// Groups lines that follow each other in a family; `None` where registers are too short.
    /// With several threads, `particles` is the number of particles of the system.
    pub(crate) fn new(cover: &Cover, is_full: bool, particles: Option<usize>) -> Option<Self> {
        let arch = arch()?;
        let (mut links, mut joints) = (0, Vec::new());
        let (mut groups, mut firsts, mut families) = (Vec::new(), Vec::new(), Vec::new());
        for family in &cover.families {
            let start = groups.len();
            let whole = family.len() / LINES * LINES;
            for first in (family.start..family.start + whole).step_by(LINES) {
                let lines = &cover.lines[first..first + LINES];
                let longest = lines.iter().map(|line| line.springs.len()).max().unwrap_or(0);
                joints.extend((0..=longest).map(|place| {
                    let particle = |line: &Line| {
                        let members = &cover.particles[line.particles.clone()];
                        members[place.min(members.len() - 1)]
                    };
                    let particles = std::array::from_fn(|k| particle(&lines[k]));
                    Joint { particles, inverse_mass: [0.0; LINES] }
                }));
                groups.push(links..links + longest);
                firsts.push(first);
                links += longest;
            }
            families.push(start..groups.len());
        }
        let longest = groups.iter().map(|group| group.len()).max().unwrap_or(0);
        let shared = particles.map(|n| Shared::new(n, &joints, &groups, &families, is_full));
        Some(Self {
            arch,
            shared,
            links: vec![Link::default(); links],
            multipliers: vec![[0.0; LINES]; links],
            brakes: vec![[[0.0; LINES]; 3]; if is_full { links } else { 0 }],
            solved: vec![[[0.0; LINES]; 3]; if is_full { longest } else { 0 }],
            joints,
            groups,
            firsts,
            families,
            rows: vec![Row::default(); longest],
        })
    }

    /// How many lines of a family, from its first, stand in groups.
    pub(crate) fn covered(&self, family: usize) -> usize {
        self.families[family].len() * LINES
    }

    /// Takes over the numbers of springs, which are in the order of the cover.
    pub(crate) fn refresh(&mut self, cover: &Cover, springs: &[Spring], inverse_mass: &[f64]) {
        for joint in &mut self.joints {
            joint.inverse_mass = joint.particles.map(|i| inverse_mass[i as usize]);
        }
        for (group, &first) in self.groups.iter().zip(&self.firsts) {
            for (k, line) in cover.lines[first..first + LINES].iter().enumerate() {
                for (link, spring) in
                    self.links[group.clone()].iter_mut().zip(&springs[line.springs.clone()])
                {
                    link.rest[k] = spring.rest;
                    link.pull[k] = spring.pull;
                    link.brake[k] = spring.brake;
                    (link.pivot[k], link.after[k]) = (spring.pivot, spring.after);
                }
            }
        }
    }

    /// Calls `work` with each group of a family and its joints.
    fn visit(&mut self, family: usize, mut work: impl FnMut(Arch, Group<'_>)) {
        let Self {
            arch, links, joints, groups, families, multipliers, rows, brakes, solved, ..
        } = self;
        for number in families[family].clone() {
            let group = groups[number].clone();
            let of_group = if brakes.is_empty() { 0..0 } else { group.clone() };
            work(
                *arch,
                Group {
                    joints: &joints[group.start + number..group.end + number + 1],
                    links: &links[group.clone()],
                    multipliers: &mut multipliers[group.clone()],
                    brakes: &mut brakes[of_group],
                    rows: &mut rows[..group.len()],
                    solved,
                },
            );
        }
    }

    /// Solves (L5) for the groups of a family, and moves their particles, (L6).
    pub(crate) fn pull(
        &mut self,
        family: usize,
        places: &mut Places<'_>,
        is_full: bool,
        is_first: bool,
    ) {
        if is_first {
            self.start(family);
        }
        if self.shares(places.bands) {
            return self.pull_by_threads(family, places, is_full);
        }
        let base = places.base;
        self.visit(family, |arch, group| {
            arch.dispatch(Pull { group, is_full, base, ways: InPlace(places.way) });
        });
    }

    /// Sets `λ` of the groups of a family to 0.
    fn start(&mut self, family: usize) {
        let groups = &self.groups[self.families[family].clone()];
        if let [first, .., last] | [first @ last] = groups {
            self.multipliers[first.start..last.end].fill([0.0; LINES]);
        }
    }

    /// `Λ` of all groups.
    pub(crate) fn brakes_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.brakes.iter_mut().flatten().flatten()
    }

    /// Solves (L3) for the groups of a family.
    pub(crate) fn brake(
        &mut self,
        family: usize,
        places: &mut Places<'_>,
        pending: Option<&[Vec3]>,
        damped: &mut [Vec3],
    ) {
        if self.shares(places.bands) {
            return self.brake_by_threads(family, places, pending, damped);
        }
        self.visit(family, |arch, group| {
            let (ways, damped) = (InPlace(places.way), InPlace(damped));
            arch.dispatch(Brake { group, pending, ways, damped });
        });
    }
}

/// Four lines, and scratch for them.
struct Group<'a> {
    joints: &'a [Joint],
    links: &'a [Link],
    multipliers: &'a mut [Four],
    brakes: &'a mut [[Four; 3]],
    rows: &'a mut [Row],
    solved: &'a mut [[Four; 3]],
}

/// Ways of the particles of a group, which it reads and then moves, from its last joint to its
/// first.
trait Ways {
    /// The ways as they stand.
    fn all(&self) -> &[Vec3];

    /// Moves the particles of a joint, by its place in the group.
    fn put(&mut self, place: usize, joint: &Joint, ways: [Four; 3]);

    /// The ways of the particles of a joint after those of the next one have gone to `ways`: both
    /// have the same particle where a line is filled up.
    fn behind(&self, joint: &Joint, next: &Joint, ways: &[Four; 3]) -> [Four; 3];
}

/// Ways that are moved where they stand.
struct InPlace<'a>(&'a mut [Vec3]);

impl Ways for InPlace<'_> {
    #[inline(always)]
    fn all(&self) -> &[Vec3] {
        self.0
    }

    #[inline(always)]
    fn put(&mut self, _place: usize, joint: &Joint, [x, y, z]: [Four; 3]) {
        for (k, &i) in joint.particles.iter().enumerate() {
            self.0[i as usize] = Vec3::new(x[k], y[k], z[k]);
        }
    }

    #[inline(always)]
    fn behind(&self, joint: &Joint, _next: &Joint, _ways: &[Four; 3]) -> [Four; 3] {
        gather(self.0, &joint.particles)
    }
}

/// (L5) and (L6) for a group.
struct Pull<'a, W> {
    group: Group<'a>,
    is_full: bool,
    base: &'a [Vec3],
    ways: W,
}

/// (L3) for a group.
struct Brake<'a, W> {
    group: Group<'a>,
    pending: Option<&'a [Vec3]>,
    ways: W,
    damped: W,
}

#[inline(always)]
fn gather(from: &[Vec3], particles: &[u32; LINES]) -> [Four; 3] {
    let [a, b, c, d] = particles.map(|i| from[i as usize]);
    [[a.x, b.x, c.x, d.x], [a.y, b.y, c.y, d.y], [a.z, b.z, c.z, d.z]]
}

/// `q`, or `q` with what is pending.
#[inline(always)]
fn goal(way: &[Vec3], pending: Option<&[Vec3]>, particles: &[u32; LINES]) -> [Four; 3] {
    let mut goal = gather(way, particles);
    if let Some(pending) = pending {
        for (goal, pending) in goal.iter_mut().zip(gather(pending, particles)) {
            for (goal, pending) in goal.iter_mut().zip(pending) {
                *goal += pending;
            }
        }
    }
    goal
}

impl<W: Ways> WithSimd for Pull<'_, W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::F64_LANES != LINES {
            return; // `arch` has chosen registers of four
        }
        let Self { group, is_full, base, mut ways } = self;
        let Group { joints, links, multipliers, rows, .. } = group;
        let load = |numbers: Four| -> S::f64s { bytemuck::cast(numbers) };
        let store = |numbers: S::f64s| -> Four { bytemuck::cast(numbers) };
        let add = |a, b| simd.add_f64s(a, b);
        let sub = |a, b| simd.sub_f64s(a, b);
        let mul = |a, b| simd.mul_f64s(a, b);
        let div = |a, b| simd.div_f64s(a, b);
        let dot = |a: [S::f64s; 3], b: [S::f64s; 3]| {
            add(add(mul(a[0], b[0]), mul(a[1], b[1])), mul(a[2], b[2]))
        };
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let collapsed = simd.splat_f64s(COLLAPSED);

        let (mut direction, mut after, mut step) = ([zero; 3], zero, zero);
        let Some(first) = joints.first() else { return };
        let way = ways.all();
        let mut here = [gather(base, &first.particles), gather(way, &first.particles)]
            .map(|place| place.map(load));
        let mut w = load(first.inverse_mass);
        let rest = links.iter().zip(&joints[1..]).zip(&*multipliers).zip(&mut *rows);
        for (((link, joint), multiplier), row) in rest {
            let next = [gather(base, &joint.particles), gather(way, &joint.particles)]
                .map(|place| place.map(load));
            let w_next = load(joint.inverse_mass);
            let apart: [_; 3] = std::array::from_fn(|k| sub(here[1][k], next[1][k]));
            let difference: [_; 3] =
                std::array::from_fn(|k| add(sub(here[0][k], next[0][k]), apart[k]));
            let length = simd.sqrt_f64s(dot(difference, difference));
            let rest = load(link.rest);
            let has_direction = simd.greater_than_f64s(length, mul(collapsed, rest));
            let only = |value| simd.select_f64s(has_direction, value, zero);
            let inverse = div(one, length);
            let u: [_; 3] = std::array::from_fn(|k| only(mul(difference[k], inverse)));
            let pull = load(link.pull);
            let brake = if is_full { zero } else { load(link.brake) };
            let tension = mul(pull, sub(length, rest));
            let stiffness = only(add(pull, brake));
            let excess = add(add(load(*multiplier), tension), mul(brake, dot(u, apart)));
            let right = only(simd.neg_f64s(excess));
            let cosine = dot(direction, u);
            let negative = simd.neg_f64s(stiffness);
            let left = mul(mul(negative, w), cosine);
            let diagonal = add(one, mul(stiffness, add(w, w_next)));
            let pivot = div(one, sub(diagonal, mul(left, mul(after, cosine))));
            step = mul(sub(right, mul(left, step)), pivot);
            after = mul(mul(negative, w_next), pivot);
            direction = u;
            *row = Row {
                direction: u.map(store),
                cosine: store(cosine),
                after: store(after),
                step: store(step),
            };
            (here, w) = (next, w_next);
        }

        let (mut d, mut cosine) = (zero, zero);
        let mut later = here[1];
        let rest = joints.windows(2).zip(&mut *multipliers).zip(&*rows).enumerate().rev();
        for (place, ((ends, multiplier), row)) in rest {
            let [i, j] = [&ends[0], &ends[1]];
            d = sub(load(row.step), mul(mul(load(row.after), cosine), d));
            cosine = load(row.cosine);
            *multiplier = store(add(load(*multiplier), d));
            let impulse = row.direction.map(|u| mul(load(u), d));
            let (w, w_next) = (load(i.inverse_mass), load(j.inverse_mass));
            let moved: [_; 3] = std::array::from_fn(|k| sub(later[k], mul(impulse[k], w_next)));
            let moved = moved.map(store);
            ways.put(place + 1, j, moved);
            let before = ways.behind(i, j, &moved).map(load);
            later = std::array::from_fn(|k| add(before[k], mul(impulse[k], w)));
        }
        ways.put(0, first, later.map(store));
    }
}

impl<W: Ways> WithSimd for Brake<'_, W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::F64_LANES != LINES {
            return; // `arch` has chosen registers of four
        }
        let Self { group, pending, mut ways, mut damped } = self;
        let Group { joints, links, brakes, solved, .. } = group;
        let solved = &mut solved[..links.len()];
        let load = |numbers: Four| -> S::f64s { bytemuck::cast(numbers) };
        let store = |numbers: S::f64s| -> Four { bytemuck::cast(numbers) };
        let add = |a, b| simd.add_f64s(a, b);
        let sub = |a, b| simd.sub_f64s(a, b);
        let mul = |a, b| simd.mul_f64s(a, b);
        let zero = simd.splat_f64s(0.0);
        let Some(first) = joints.first() else { return };

        let mut before = [zero; 3];
        let way = ways.all();
        let mut here = goal(way, pending, &first.particles).map(load);
        let rest = links.iter().zip(joints.windows(2)).zip(&*brakes).zip(&mut *solved);
        for (((link, ends), brake), solved) in rest {
            let next = goal(way, pending, &ends[1].particles).map(load);
            let (g, pivot) = (load(link.brake), load(link.pivot));
            let left = mul(g, load(ends[0].inverse_mass));
            let pulled: [_; 3] = std::array::from_fn(|k| mul(sub(here[k], next[k]), g));
            let right: [_; 3] =
                std::array::from_fn(|k| simd.neg_f64s(add(load(brake[k]), pulled[k])));
            before = std::array::from_fn(|k| mul(add(right[k], mul(before[k], left)), pivot));
            *solved = before.map(store);
            here = next;
        }

        let mut next = [zero; 3];
        let last = joints.last().unwrap_or(first);
        let mut later = gather(ways.all(), &last.particles).map(load);
        let mut later_damped = gather(damped.all(), &last.particles).map(load);
        let rest = links.iter().zip(joints.windows(2)).zip(&mut *brakes).zip(&*solved);
        for (place, (((link, ends), brake), solved)) in rest.enumerate().rev() {
            let [i, j] = [&ends[0], &ends[1]];
            let after = load(link.after);
            next = std::array::from_fn(|k| sub(load(solved[k]), mul(next[k], after)));
            let whole: [_; 3] = std::array::from_fn(|k| add(load(brake[k]), next[k]));
            *brake = whole.map(store);
            let (w, w_next) = (load(i.inverse_mass), load(j.inverse_mass));
            let moved: [_; 3] = std::array::from_fn(|k| sub(later[k], mul(next[k], w_next)));
            let moved = moved.map(store);
            ways.put(place + 1, j, moved);
            let before = ways.behind(i, j, &moved).map(load);
            later = std::array::from_fn(|k| add(before[k], mul(next[k], w)));
            let moved: [_; 3] =
                std::array::from_fn(|k| sub(later_damped[k], mul(whole[k], w_next)));
            let moved = moved.map(store);
            damped.put(place + 1, j, moved);
            let before = damped.behind(i, j, &moved).map(load);
            later_damped = std::array::from_fn(|k| add(before[k], mul(whole[k], w)));
        }
        ways.put(0, first, later.map(store));
        damped.put(0, first, later_damped.map(store));
    }
}
