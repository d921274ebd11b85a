//! Linear springs, a group at a time.
//!
//! # How it goes
//!
//! Springs that share no particle can be projected in any order, or at once. So the springs are cut
//! into groups of [`GROUP`] without a common particle. Four springs of a group are computed at once,
//! as [`springs`](crate::springs) does: the differences of their ends become one register a
//! coordinate, and their impulses one register per spring again.
//!
//! *By colours* the groups are the springs of a colour, one after the other. *As listed* a spring
//! goes into the first group with room behind all groups of earlier springs of its particles. Each
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
use drape_solvers::bands::{Divisible, bands, in_bands};
use drape_solvers::lanes::{Four, Lanes, four_wide, vectorised};
use std::ops::Range;

/// Springs of a group.
pub(crate) const GROUP: usize = 16;

/// A number of each spring of a group.
type Numbers = [f64; GROUP];

/// No spring.
const NONE: u32 = u32::MAX;

/// Particles as registers: vectors of four numbers, the last one 0. Behind the last particle stands
/// one at rest, which fills groups.
#[derive(Debug)]
pub(crate) struct Quads {
    base: Vec<Lanes>,
    way: Vec<Lanes>,
    /// `1/m`, 0 where pinned.
    inverse_mass: Vec<f64>,
}

impl Quads {
    pub(crate) fn new(particles: usize) -> Self {
        let zeros = || vec![[0.0; 4]; particles + 1];
        Self { base: zeros(), way: zeros(), inverse_mass: vec![0.0; particles + 1] }
    }

    /// Takes the inverse masses, 1/kg.
    pub(crate) fn weigh(&mut self, inverse_mass: &[f64]) {
        self.inverse_mass[..inverse_mass.len()].copy_from_slice(inverse_mass);
    }

    /// Takes `x*` for the sweeps of a substep, m.
    pub(crate) fn start(&mut self, base: &[Vec3]) {
        widen(base, &mut self.base);
    }

    /// Takes the ways, m.
    pub(crate) fn read(&mut self, way: &[Vec3]) {
        widen(way, &mut self.way);
    }

    /// Hands the ways back, m.
    pub(crate) fn write(&self, way: &mut [Vec3]) {
        for (way, quad) in way.iter_mut().zip(&self.way) {
            *way = Vec3::new(quad[0], quad[1], quad[2]);
        }
    }
}

fn widen(from: &[Vec3], to: &mut [Lanes]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = [from.x, from.y, from.z, 0.0];
    }
}

/// Springs without a common particle.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// The particles at the first ends, then at the second ends.
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

/// Multipliers of some groups.
#[derive(Debug)]
struct Left<'a> {
    lambda: &'a mut [Numbers],
    /// Where damping is full, else empty.
    brake: &'a mut [Brakes],
}

impl Divisible for Left<'_> {
    fn split(self, blocks: usize) -> (Self, Self) {
        let (lambda, more) = self.lambda.split(blocks);
        let (brake, rest) = match self.brake.is_empty() {
            true => self.brake.split_at_mut(0),
            false => self.brake.split(blocks),
        };
        (Left { lambda, brake }, Left { lambda: more, brake: rest })
    }
}

/// What a thread writes of a colour: multipliers, impulses.
type Part<'a> = (Left<'a>, &'a mut [[Numbers; 3]]);

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
    /// Where colours end, in groups; empty where springs go as listed.
    colours: Vec<usize>,
    /// Impulses of one colour for several threads, kg m; else empty.
    impulses: Vec<[Numbers; 3]>,
}

impl Groups {
    /// Groups for springs in the order of a sweep; `colours` are the places where colours end. All
    /// of them are damped alike.
    /// `None` where so few springs are independent that groups would not gain anything.
    pub(crate) fn new(
        list: &[Spring],
        particles: usize,
        damping: Damping,
        colours: Option<&[usize]>,
    ) -> Option<Self> {
        let (places, colours) = match colours {
            Some(ends) => by_colours(ends),
            None => (as_listed(list, particles), Vec::new()),
        };
        if places.len() * GROUP > 4 * list.len() && colours.is_empty() {
            return None;
        }
        let longest =
            colours.iter().scan(0, |start, &end| Some(end - std::mem::replace(start, end)));
        let longest = longest.max().unwrap_or(0);
        let end =
            |place: u32, k: usize| list.get(place as usize).map_or(particles as u32, |s| s.ends[k]);
        let group = |places: &[u32; GROUP]| Group {
            ends: [0, 1].map(|k| places.map(|p| end(p, k))),
            row: 0,
        };
        Some(Self {
            groups: places.iter().map(group).collect(),
            rows: Vec::with_capacity(places.len()),
            lambda: vec![[0.0; GROUP]; places.len()],
            brake: match damping {
                Damping::Along => Vec::new(),
                Damping::Full => vec![[[0.0; GROUP]; 3]; places.len()],
            },
            impulses: vec![[[0.0; GROUP]; 3]; longest],
            places,
            colours,
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
    pub(crate) fn sweep(&mut self, quads: &mut Quads, pass: Pass, threads: usize) {
        let Self { groups, rows, lambda, brake, colours, impulses, .. } = self;
        let springs =
            colours.iter().scan(0, |start, &end| Some(end - std::mem::replace(start, end)));
        let most = springs.max().unwrap_or(0) * GROUP;
        if bands(threads, most) == 1 {
            let (rows, left) = (&rows[..], Left { lambda, brake });
            return vectorised!(four_wide(), [four,
                groups: &'k [Group] = groups,
                rows: &'k [Row] = rows,
                left: Left<'k> = left,
                quads: &'k mut Quads = quads,
                pass: Pass = pass,
            ] -> () {
                in_turn(four, groups, rows, left, quads, pass);
            });
        }
        for range in Colouring::ranges(colours) {
            let brake = if brake.is_empty() { &mut [][..] } else { &mut brake[range.clone()] };
            let left = Left { lambda: &mut lambda[range.clone()], brake };
            let groups = &groups[range];
            let (rows, count) = (&rows[..], groups.len());
            let impulses = &mut impulses[..count];
            let read = &*quads;
            let sweep = |band: Range<usize>, (left, impulses): Part<'_>| {
                vectorised!(four_wide(), [four,
                    groups: &'k [Group] = &groups[band],
                    rows: &'k [Row] = rows,
                    part: Part<'k> = (left, impulses),
                    quads: &'k Quads = read,
                    pass: Pass = pass,
                ] -> () {
                    at_once(four, groups, rows, part, quads, pass);
                });
            };
            let part = (left, &mut *impulses);
            in_bands(bands(threads, count * GROUP), count, part, &sweep);
            vectorised!(four_wide(), [four,
                groups: &'k [Group] = groups,
                impulses: &'k [[Numbers; 3]] = impulses,
                quads: &'k mut Quads = quads,
            ] -> () {
                let Quads { way, inverse_mass, .. } = quads;
                for (group, impulses) in groups.iter().zip(impulses) {
                    for t in FOURS {
                        let [x, y, z] = impulses;
                        let impulse = [take(four, x, t), take(four, y, t), take(four, z, t)];
                        push(four, group, t, impulse, way, inverse_mass);
                    }
                }
            });
        }
    }
}

/// The springs of each colour one after the other, and the groups at which the colours end.
fn by_colours(ends: &[usize]) -> (Vec<[u32; GROUP]>, Vec<usize>) {
    let (mut places, mut colours) = (Vec::new(), Vec::new());
    for range in Colouring::ranges(ends) {
        for start in range.clone().step_by(GROUP) {
            let place = |k: usize| if start + k < range.end { (start + k) as u32 } else { NONE };
            places.push(std::array::from_fn(place));
        }
        colours.push(places.len());
    }
    (places, colours)
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

/// Projects group after group.
#[inline(always)]
fn in_turn<F: Four>(
    four: F,
    groups: &[Group],
    rows: &[Row],
    left: Left<'_>,
    quads: &mut Quads,
    pass: Pass,
) {
    let Quads { base, way, inverse_mass } = quads;
    // One check of a particle's index serves all three.
    let n = way.len();
    let (base, inverse_mass) = (&base[..n], &inverse_mass[..n]);
    let Left { lambda, brake } = left;
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

/// Computes the impulses of all groups from the same positions.
#[inline(always)]
fn at_once<F: Four>(
    four: F,
    groups: &[Group],
    rows: &[Row],
    (left, out): Part<'_>,
    quads: &Quads,
    pass: Pass,
) {
    let way = &quads.way[..];
    let base = &quads.base[..way.len()];
    let Left { lambda, brake } = left;
    let mut brake = brake.iter_mut();
    for ((group, lambda), out) in groups.iter().zip(lambda).zip(out) {
        let (row, mut brake) = (&rows[group.row as usize], brake.next());
        for t in FOURS {
            let seen = Seen::new(four, group, t, base, way);
            let impulse = seen.project(four, row, t, (lambda, brake.as_deref_mut()), pass);
            keep(four, &mut out[0], t, impulse[0]);
            keep(four, &mut out[1], t, impulse[1]);
            keep(four, &mut out[2], t, impulse[2]);
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
