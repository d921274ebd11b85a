//! Linear springs, a group at a time.
//!
//! # How it goes
//!
//! Springs that share no particle can be projected in any order, or at once. So the springs are cut
//! into groups of [`GROUP`] without a common particle. Four springs of a group are computed at once,
//! as [`springs`](crate::springs) does: the differences of their ends become one register a
//! coordinate, and their impulses one register per spring again.
//!
//! *By colours* the groups are the springs of a colour, one after the other, but for a large cloth
//! region by region, so that threads share them ([`Turns`]). *As listed* a spring goes into the first group with room behind all groups of earlier springs of its particles. Each
//! particle then still meets its springs in the order of the list, and that order alone decides
//! the result. So both forms have the bits of the sweep that goes through the list spring by
//! spring.
//!
//! Numbers of neighbouring groups are mostly the same. They are stored once for each run of equal
//! groups ([`Row`]), so that a sweep reads little from far memory.
//!
//! Nothing is fused, and no division is replaced by a reciprocal, so that the bits stay.

use crate::springs::{COLLAPSED, Damping, Pass, Spring};
use drape_integrator::Colouring;
use drape_model::Vec3;
use drape_solvers::bands::{Divisible, LEAST_FOR_THREADS, in_items};
use drape_solvers::lanes::{Four, Lanes, four_wide, vectorised};
use std::ops::Range;

/// Springs of a group.
pub(crate) const GROUP: usize = 16;

/// A number of each spring of a group.
type Numbers = [f64; GROUP];

/// No spring.
const NONE: u32 = u32::MAX;

/// Particles as registers: vectors of four numbers, the last one 0. They are cut into regions of
/// consecutive particles. Behind each region stands a particle at rest, which fills groups.
#[derive(Debug)]
pub(crate) struct Quads {
    base: Vec<Lanes>,
    way: Vec<Lanes>,
    /// `1/m`, 0 where pinned.
    inverse_mass: Vec<f64>,
    cut: Cut,
    /// Parts of a sweep that threads share.
    bands: usize,
}

/// How the particles are cut into regions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub(crate) particles: usize,
    /// Particles of a region.
    pub(crate) region: usize,
}

/// Fewest particles of a region, if there is more than one.
const LEAST_OF_A_REGION: usize = 2048;
/// Rows of a square grid that a region holds at least. A spring that spans two rows then seldom
/// leads further than to the next region.
const ROWS_OF_A_REGION: usize = 4;

impl Cut {
    /// The regions of so many particles; one if threads would not share them.
    pub(crate) fn new(particles: usize) -> Self {
        let region = match particles < LEAST_FOR_THREADS {
            true => particles,
            false => LEAST_OF_A_REGION.max(ROWS_OF_A_REGION * particles.isqrt()),
        };
        Self { particles, region: region.max(1) }
    }

    fn regions(self) -> usize {
        self.particles.div_ceil(self.region).max(1)
    }

    fn places(self) -> usize {
        self.particles + self.regions()
    }

    fn region_of(self, particle: u32) -> usize {
        particle as usize / self.region
    }

    fn place_of(self, particle: u32) -> usize {
        particle as usize + self.region_of(particle)
    }

    /// The places of some regions.
    fn span(self, regions: Range<usize>) -> Range<usize> {
        let place = |region: usize| (region * (self.region + 1)).min(self.places());
        place(regions.start)..place(regions.end)
    }
}

/// What the regions hold, one after the other.
struct Regions<'a, T> {
    items: &'a mut [T],
    /// Items of a region.
    each: usize,
}

impl<T: Send> Divisible for Regions<'_, T> {
    fn split(self, regions: usize) -> (Self, Self) {
        let Self { items, each } = self;
        let (items, others) = items.split_at_mut((regions * each).min(items.len()));
        (Self { items, each }, Self { items: others, each })
    }
}

impl Quads {
    pub(crate) fn new(cut: Cut) -> Self {
        let zeros = || vec![[0.0; 4]; cut.places()];
        let inverse_mass = vec![0.0; cut.places()];
        Self { base: zeros(), way: zeros(), inverse_mass, cut, bands: 1 }
    }

    /// Sets into how many parts threads divide a sweep.
    pub(crate) fn share(&mut self, bands: usize) {
        self.bands = bands;
    }

    /// Takes the inverse masses, 1/kg.
    pub(crate) fn weigh(&mut self, inverse_mass: &[f64]) {
        for (i, w) in (0..).zip(inverse_mass) {
            self.inverse_mass[self.cut.place_of(i)] = *w;
        }
    }

    /// Takes `x*` for the sweeps of a substep, m.
    pub(crate) fn start(&mut self, base: &[Vec3]) {
        widen((self.cut, self.bands), base, &mut self.base);
    }

    /// Takes the ways, m.
    pub(crate) fn read(&mut self, way: &[Vec3]) {
        widen((self.cut, self.bands), way, &mut self.way);
    }

    /// Hands the ways back, m.
    pub(crate) fn write(&self, way: &mut [Vec3]) {
        let Self { way: quads, cut, bands, .. } = self;
        let part = Regions { items: way, each: cut.region };
        in_items(*bands, cut.regions(), part, &|regions, way: Regions<'_, Vec3>| {
            let quads = &quads[cut.span(regions)];
            for (way, quads) in way.items.chunks_mut(cut.region).zip(quads.chunks(cut.region + 1)) {
                for (way, quad) in way.iter_mut().zip(quads) {
                    *way = Vec3::new(quad[0], quad[1], quad[2]);
                }
            }
        });
    }
}

fn widen((cut, bands): (Cut, usize), from: &[Vec3], to: &mut [Lanes]) {
    let part = Regions { items: to, each: cut.region + 1 };
    in_items(bands, cut.regions(), part, &|regions: Range<usize>, to: Regions<'_, Lanes>| {
        let from = from[regions.start * cut.region..].chunks(cut.region);
        for (to, from) in to.items.chunks_mut(cut.region + 1).zip(from) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = [from.x, from.y, from.z, 0.0];
            }
        }
    });
}

/// Springs without a common particle.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// The particles at the first ends, then at the second ends, counted from the first of the part.
    ends: [[u32; GROUP]; 2],
    /// Where its numbers are.
    row: u32,
}

/// The numbers of the springs of a group, as in [`Spring`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    rest: Numbers,
    /// Lengths up to this one have no direction, m.
    collapsed: Numbers,
    pull: Numbers,
    brake: Numbers,
    share: Numbers,
    pass: Numbers,
    mobility: Numbers,
}

/// `Λ` of a group, by coordinates.
type Brakes = [Numbers; 3];

/// Consecutive groups, and the particles that they move.
#[derive(Clone, Debug)]
struct Part {
    groups: Range<usize>,
    /// Places of the particles. The last one is a particle at rest.
    places: Range<usize>,
}

/// The groups in the order of a sweep, in turns. The parts of a turn move different particles, so
/// that threads share them. Parts and their particles follow each other in memory.
///
/// A colour takes up to three turns. In the first one, a part holds the springs inside of two
/// neighbouring regions: the first and the second, the third and the fourth, and so on. In the
/// second turn the pairs begin one region later. The last turn has the springs that no pair holds.
/// No two springs of a colour share a particle, so their order has no influence on the result.
#[derive(Debug, Default)]
struct Turns {
    parts: Vec<Part>,
    /// Parts of each turn.
    turns: Vec<Range<usize>>,
}

/// The pair of regions that holds a spring, by the turn and the first region.
type Pair = (u32, usize);

impl Turns {
    /// The pair of a spring.
    fn pair(cut: Cut, spring: &Spring) -> Pair {
        let [i, j] = spring.ends.map(|end| cut.region_of(end));
        let (low, high) = (i.min(j), i.max(j));
        match (low / 2 == high / 2, low + 1 == high) {
            (true, _) => (0, low / 2 * 2),
            (false, true) => (1, low),
            (false, false) => (2, 0),
        }
    }

    fn places(cut: Cut, (turn, first): Pair) -> Range<usize> {
        if turn == 2 { 0..cut.places() } else { cut.span(first..first + 2) }
    }

    /// The springs of each colour by pairs of regions; `ends` are the places where colours end.
    /// Also returns the groups.
    fn by_colours(cut: Cut, list: &[Spring], ends: &[usize]) -> (Self, Vec<[u32; GROUP]>) {
        let (mut turns, mut groups) = (Self::default(), Vec::new());
        for range in Colouring::ranges(ends) {
            let springs = range.map(|place| (Self::pair(cut, &list[place]), place as u32));
            let mut springs: Vec<_> = springs.collect();
            springs.sort_by_key(|(pair, _)| *pair); // keeps the order within a pair
            for turn in springs.chunk_by(|a, b| a.0.0 == b.0.0) {
                let first = turns.parts.len();
                for part in turn.chunk_by(|a, b| a.0 == b.0) {
                    let start = groups.len();
                    groups.extend(part.chunks(GROUP).map(|springs| {
                        std::array::from_fn(|k| springs.get(k).map_or(NONE, |spring| spring.1))
                    }));
                    let places = Self::places(cut, part[0].0);
                    turns.parts.push(Part { groups: start..groups.len(), places });
                }
                turns.turns.push(first..turns.parts.len());
            }
        }
        (turns, groups)
    }

    /// A single part.
    fn one(cut: Cut, groups: usize) -> Self {
        let part = Part { groups: 0..groups, places: 0..cut.places() };
        Self { parts: vec![part], turns: std::iter::once(0..1).collect() }
    }
}

/// What a thread writes: ways and multipliers of some parts of a turn.
#[derive(Debug)]
struct Share<'a> {
    parts: &'a [Part],
    /// Ways from the first place of the first part on.
    way: &'a mut [Lanes],
    /// Multipliers from its first group on.
    lambda: &'a mut [Numbers],
    /// Where damping is full, else empty.
    brake: &'a mut [Brakes],
}

impl Divisible for Share<'_> {
    fn split(self, count: usize) -> (Self, Self) {
        let Self { parts, way, lambda, brake } = self;
        let (first, next) = (&parts[0], &parts[count]);
        let (before, after) = parts.split_at(count);
        let (way, other_way) = way.split_at_mut(next.places.start - first.places.start);
        let groups = next.groups.start - first.groups.start;
        let (lambda, other_lambda) = lambda.split_at_mut(groups);
        let (brake, other_brake) = brake.split_at_mut(groups.min(brake.len()));
        let after = Self { parts: after, way: other_way, lambda: other_lambda, brake: other_brake };
        (Self { parts: before, way, lambda, brake }, after)
    }
}

/// The springs of an effect in groups.
#[derive(Debug)]
pub(crate) struct Groups {
    /// Places in the list of springs.
    places: Vec<[u32; GROUP]>,
    groups: Vec<Group>,
    rows: Vec<Row>,
    /// `λ`, kg m.
    lambda: Vec<Numbers>,
    /// `Λ`, kg m, where damping is full, else empty.
    brake: Vec<Brakes>,
    turns: Turns,
}

impl Groups {
    /// Groups for springs in the order of a sweep; `colours` are the places where colours end. All
    /// of them are damped alike.
    /// `None` where so few springs are independent that groups would not gain anything.
    pub(crate) fn new(
        list: &[Spring],
        cut: Cut,
        damping: Damping,
        colours: Option<&[usize]>,
    ) -> Option<Self> {
        let (turns, places) = match colours {
            Some(ends) => Turns::by_colours(cut, list, ends),
            None => {
                let places = as_listed(list, cut.particles);
                (Turns::one(cut, places.len()), places)
            }
        };
        if places.len() * GROUP > 4 * list.len() && colours.is_none() {
            return None;
        }
        let mut groups = Vec::with_capacity(places.len());
        for part in &turns.parts {
            let rest = part.places.len() - 1;
            let end = |place: u32, k: usize| {
                let spring = list.get(place as usize);
                let end = spring.map_or(rest, |s| cut.place_of(s.ends[k]) - part.places.start);
                end as u32
            };
            groups.extend(places[part.groups.clone()].iter().map(|places| Group {
                ends: [0, 1].map(|k| places.map(|place| end(place, k))),
                row: 0,
            }));
        }
        Some(Self {
            groups,
            rows: Vec::with_capacity(places.len()),
            lambda: vec![[0.0; GROUP]; places.len()],
            brake: match damping {
                Damping::Along => Vec::new(),
                Damping::Full => vec![[[0.0; GROUP]; 3]; places.len()],
            },
            places,
            turns,
        })
    }

    /// Takes over the numbers of the springs.
    pub(crate) fn refresh(&mut self, list: &[Spring]) {
        self.rows.clear();
        for (group, places) in self.groups.iter_mut().zip(&self.places) {
            let row = Row::new(places.map(|place| list.get(place as usize)));
            if self.rows.last() != Some(&row) {
                self.rows.push(row);
            }
            group.row = self.rows.len() as u32 - 1;
        }
    }

    /// Projects all springs once.
    pub(crate) fn sweep(&mut self, quads: &mut Quads, pass: Pass) {
        let Self { groups, rows, lambda, brake, turns, .. } = self;
        let Quads { base, way, inverse_mass, bands, .. } = quads;
        let (groups, rows) = (&groups[..], &rows[..]);
        let (base, inverse_mass) = (&base[..], &inverse_mass[..]);
        let sweep = |_: Range<usize>, mut share: Share<'_>| {
            while let [part, others @ ..] = share.parts {
                let places = part.places.clone();
                vectorised!(four_wide(), [four,
                    groups: &'k [Group] = &groups[part.groups.clone()],
                    rows: &'k [Row] = rows,
                    particles: Particles<'k> = Particles {
                        base: &base[places.clone()],
                        inverse_mass: &inverse_mass[places.clone()],
                        way: &mut share.way[..places.len()],
                    },
                    lambda: &'k mut [Numbers] = &mut *share.lambda,
                    brake: &'k mut [Brakes] = &mut *share.brake,
                    pass: Pass = pass,
                ] -> () {
                    in_turn(four, groups, rows, (lambda, brake), particles, pass);
                });
                if others.is_empty() {
                    break;
                }
                share = share.split(1).1;
            }
        };
        for turn in &turns.turns {
            let parts = &turns.parts[turn.clone()];
            let (place, group) = (parts[0].places.start, parts[0].groups.start);
            let share = Share {
                parts,
                way: &mut way[place..],
                lambda: &mut lambda[group..],
                brake: if brake.is_empty() { &mut [] } else { &mut brake[group..] },
            };
            in_items(*bands, parts.len(), share, &sweep);
        }
    }
}

/// Groups in which each particle meets its springs in the order of the list.
fn as_listed(list: &[Spring], particles: usize) -> Vec<[u32; GROUP]> {
    let mut groups: Vec<([u32; GROUP], usize)> = Vec::new();
    // The first group that may take a spring of a particle, and the next with room behind a group.
    let (mut earliest, mut next) = (vec![0; particles], Vec::new());
    for (place, Spring { ends: [i, j], .. }) in (0..).zip(list) {
        let [i, j] = [*i as usize, *j as usize];
        let mut found = earliest[i].max(earliest[j]);
        let start = found;
        while found < next.len() && next[found] != found {
            found = next[found];
        }
        while found >= groups.len() {
            next.push(groups.len());
            groups.push(([NONE; GROUP], 0));
        }
        let mut passed = start;
        while passed < found {
            passed = std::mem::replace(&mut next[passed], found);
        }
        let (group, count) = &mut groups[found];
        group[*count] = place;
        *count += 1;
        if *count == GROUP {
            next[found] = found + 1;
        }
        earliest[i] = found + 1;
        earliest[j] = found + 1;
    }
    groups.into_iter().filter(|(_, count)| *count > 0).map(|(group, _)| group).collect()
}

impl Row {
    /// An absent spring pulls at nothing.
    fn new(springs: [Option<&Spring>; GROUP]) -> Self {
        let of = |number: fn(&Spring) -> f64| springs.map(|spring| spring.map_or(0.0, number));
        Self {
            rest: of(|s| s.rest),
            collapsed: of(|s| COLLAPSED * s.rest),
            pull: of(|s| s.pull),
            brake: of(|s| s.brake),
            share: of(|s| s.share),
            pass: of(|s| s.pass),
            mobility: of(|s| s.mobility),
        }
    }
}

/// Where the fours of a group begin.
const FOURS: [usize; GROUP / 4] = [0, 4, 8, 12];

/// Particles of a part.
struct Particles<'a> {
    base: &'a [Lanes],
    inverse_mass: &'a [f64],
    way: &'a mut [Lanes],
}

/// Projects group after group.
#[inline(always)]
fn in_turn<F: Four>(
    four: F,
    groups: &[Group],
    rows: &[Row],
    (lambda, brake): (&mut [Numbers], &mut [Brakes]),
    Particles { base, inverse_mass, way }: Particles<'_>,
    pass: Pass,
) {
    // One check of a particle's index serves all three.
    let n = way.len();
    let (base, inverse_mass) = (&base[..n], &inverse_mass[..n]);
    let mut brake = brake.iter_mut();
    for (group, lambda) in groups.iter().zip(lambda) {
        let (row, mut brake) = (&rows[group.row as usize], brake.next());
        for t in FOURS {
            let seen = Seen::new(four, group, t, base, way);
            let impulse = seen.project(four, row, t, (lambda, brake.as_deref_mut()), pass);
            push(four, group, t, impulse, way, inverse_mass);
        }
    }
}

#[inline(always)]
fn keep<F: Four>(four: F, to: &mut Numbers, t: usize, numbers: F::Numbers) {
    to[t..t + 4].copy_from_slice(&four.store(numbers));
}

#[inline(always)]
fn take<F: Four>(four: F, from: &Numbers, t: usize) -> F::Numbers {
    four.load([from[t], from[t + 1], from[t + 2], from[t + 3]])
}

/// Moves the ends of four springs: `q_i += w_i I`, `q_j −= w_j I`.
#[inline(always)]
fn push<F: Four>(
    four: F,
    group: &Group,
    t: usize,
    [x, y, z]: [F::Numbers; 3],
    way: &mut [Lanes],
    inverse_mass: &[f64],
) {
    let impulses = four.transpose([x, y, z, four.splat(0.0)]);
    for (s, impulse) in impulses.into_iter().enumerate() {
        let (i, j) = (group.ends[0][t + s] as usize, group.ends[1][t + s] as usize);
        let (w_i, w_j) = (four.splat(inverse_mass[i]), four.splat(inverse_mass[j]));
        way[i] = four.store(four.add(four.load(way[i]), four.mul(impulse, w_i)));
        way[j] = four.store(four.sub(four.load(way[j]), four.mul(impulse, w_j)));
    }
}

/// `p_i − p_j` and `q_i − q_j` of four springs, by coordinates, m.
struct Seen<N> {
    d: [N; 3],
    apart: [N; 3],
}

/// Both of one spring.
#[inline(always)]
fn between<F: Four>(
    four: F,
    group: &Group,
    t: usize,
    base: &[Lanes],
    way: &[Lanes],
) -> (F::Numbers, F::Numbers) {
    let (i, j) = (group.ends[0][t] as usize, group.ends[1][t] as usize);
    let apart = four.sub(four.load(way[i]), four.load(way[j]));
    (four.add(four.sub(four.load(base[i]), four.load(base[j])), apart), apart)
}

impl<N: Copy> Seen<N> {
    #[inline(always)]
    fn new<F: Four<Numbers = N>>(
        four: F,
        group: &Group,
        t: usize,
        base: &[Lanes],
        way: &[Lanes],
    ) -> Self {
        let (d_0, r_0) = between(four, group, t, base, way);
        let (d_1, r_1) = between(four, group, t + 1, base, way);
        let (d_2, r_2) = between(four, group, t + 2, base, way);
        let (d_3, r_3) = between(four, group, t + 3, base, way);
        let [dx, dy, dz, _] = four.transpose([d_0, d_1, d_2, d_3]);
        let [rx, ry, rz, _] = four.transpose([r_0, r_1, r_2, r_3]);
        Self { d: [dx, dy, dz], apart: [rx, ry, rz] }
    }

    /// The impulses on the first ends, kg m.
    #[inline(always)]
    fn project<F: Four<Numbers = N>>(
        &self,
        four: F,
        row: &Row,
        t: usize,
        (lambda, brake): (&mut Numbers, Option<&mut Brakes>),
        pass: Pass,
    ) -> [N; 3] {
        match brake {
            None => self.along(four, row, t, lambda, pass),
            Some(brake) => self.full(four, row, t, (lambda, brake), pass),
        }
    }

    /// (X4).
    #[inline(always)]
    fn along<F: Four<Numbers = N>>(
        &self,
        four: F,
        row: &Row,
        t: usize,
        left: &mut Numbers,
        pass: Pass,
    ) -> [N; 3] {
        let Self { d: [dx, dy, dz], apart: [rx, ry, rz] } = *self;
        let zero = four.splat(0.0);
        let lambda = if pass.is_first { zero } else { take(four, left, t) };
        let length = norm(four, [dx, dy, dz]);
        let collapsed = take(four, &row.collapsed, t);
        let (ux, uy, uz) = (four.div(dx, length), four.div(dy, length), four.div(dz, length));
        let speed = dot(four, [ux, uy, uz], [rx, ry, rz]);
        let pull = four.mul(take(four, &row.pull, t), four.sub(length, take(four, &row.rest, t)));
        let brake = four.mul(take(four, &row.brake, t), speed);
        let all = four.add(four.add(lambda, pull), brake);
        let step = four.mul(four.neg(all), take(four, &row.share, t));
        if !pass.is_last {
            let next = four.add(lambda, step);
            keep(four, left, t, four.where_at_most(length, collapsed, lambda, next));
        }
        let (x, y, z) = (four.mul(ux, step), four.mul(uy, step), four.mul(uz, step));
        [
            four.where_at_most(length, collapsed, zero, x),
            four.where_at_most(length, collapsed, zero, y),
            four.where_at_most(length, collapsed, zero, z),
        ]
    }

    /// (X5).
    #[inline(always)]
    fn full<F: Four<Numbers = N>>(
        &self,
        four: F,
        row: &Row,
        t: usize,
        (left, brakes): (&mut Numbers, &mut Brakes),
        pass: Pass,
    ) -> [N; 3] {
        let Self { d: [dx, dy, dz], apart: [rx, ry, rz] } = *self;
        let zero = four.splat(0.0);
        let [bx, by, bz] = brakes;
        let [lambda, b_x, b_y, b_z] = match pass.is_first {
            true => [zero; 4],
            false => [take(four, left, t), take(four, bx, t), take(four, by, t), take(four, bz, t)],
        };
        let (g, s) = (take(four, &row.brake, t), take(four, &row.pass, t));
        let mx = four.mul(four.neg(four.add(b_x, four.mul(rx, g))), s);
        let my = four.mul(four.neg(four.add(b_y, four.mul(ry, g))), s);
        let mz = four.mul(four.neg(four.add(b_z, four.mul(rz, g))), s);
        let w = take(four, &row.mobility, t);
        let dx = four.add(dx, four.mul(mx, w));
        let dy = four.add(dy, four.mul(my, w));
        let dz = four.add(dz, four.mul(mz, w));
        let length = norm(four, [dx, dy, dz]);
        let collapsed = take(four, &row.collapsed, t);
        let (ux, uy, uz) = (four.div(dx, length), four.div(dy, length), four.div(dz, length));
        let pull = four.mul(take(four, &row.pull, t), four.sub(length, take(four, &row.rest, t)));
        let step = four.mul(four.neg(four.add(lambda, pull)), take(four, &row.share, t));
        let passed = four.mul(s, step);
        let ix = four.add(mx, four.mul(ux, passed));
        let iy = four.add(my, four.mul(uy, passed));
        let iz = four.add(mz, four.mul(uz, passed));
        if !pass.is_last {
            let next = four.add(lambda, step);
            keep(four, left, t, four.where_at_most(length, collapsed, lambda, next));
            let nx = four.sub(ix, four.mul(ux, step));
            let ny = four.sub(iy, four.mul(uy, step));
            let nz = four.sub(iz, four.mul(uz, step));
            keep(four, bx, t, four.add(b_x, four.where_at_most(length, collapsed, mx, nx)));
            keep(four, by, t, four.add(b_y, four.where_at_most(length, collapsed, my, ny)));
            keep(four, bz, t, four.add(b_z, four.where_at_most(length, collapsed, mz, nz)));
        }
        [
            four.where_at_most(length, collapsed, mx, ix),
            four.where_at_most(length, collapsed, my, iy),
            four.where_at_most(length, collapsed, mz, iz),
        ]
    }
}

#[inline(always)]
fn dot<F: Four>(four: F, a: [F::Numbers; 3], b: [F::Numbers; 3]) -> F::Numbers {
    four.add(four.add(four.mul(a[0], b[0]), four.mul(a[1], b[1])), four.mul(a[2], b[2]))
}

#[inline(always)]
fn norm<F: Four>(four: F, a: [F::Numbers; 3]) -> F::Numbers {
    four.sqrt(dot(four, a, a))
}
