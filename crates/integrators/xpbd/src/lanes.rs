//! Linear springs, a group at a time.
//!
//! # How it goes
//!
//! Springs that share no particle can be projected in any order, or at once. So the springs are cut
//! into groups of [`GROUP`] without a common particle. A group reads the differences of its ends
//! into one array a coordinate, computes as [`springs`](crate::springs) does in loops that the
//! compiler turns into vector operations, and adds the impulses.
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
use drape_solvers::bands::{bands, in_bands};
use drape_solvers::lanes::{Lanes, four_wide, vectorised};
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

/// Multipliers of a group: `λ`, then `Λ` by coordinates.
type Left = [Numbers; 4];

/// What a thread writes of a colour: multipliers, impulses.
type Part<'a> = (&'a mut [Left], &'a mut [[Numbers; 3]]);

/// The springs of an effect in groups.
#[derive(Debug)]
pub(crate) struct Groups {
    /// Places in the list of springs.
    places: Vec<[u32; GROUP]>,
    groups: Vec<Group>,
    rows: Vec<Row>,
    left: Vec<Left>,
    /// Where colours end, in groups; empty where springs go as listed.
    colours: Vec<usize>,
    /// Impulses of one colour for several threads, kg m; else empty.
    impulses: Vec<[Numbers; 3]>,
}

impl Groups {
    /// Groups for springs in the order of a sweep; `colours` are the places where colours end.
    /// `None` where so few springs are independent that groups would not gain anything.
    pub(crate) fn new(
        list: &[Spring],
        particles: usize,
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
            left: vec![[[0.0; GROUP]; 4]; places.len()],
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
    pub(crate) fn sweep(
        &mut self,
        quads: &mut Quads,
        damping: Damping,
        pass: Pass,
        threads: usize,
    ) {
        let Self { groups, rows, left, colours, impulses, .. } = self;
        let springs =
            colours.iter().scan(0, |start, &end| Some(end - std::mem::replace(start, end)));
        let most = springs.max().unwrap_or(0) * GROUP;
        if bands(threads, most) == 1 {
            let rows = &rows[..];
            return vectorised!(four_wide(), [_four,
                groups: &'k [Group] = groups,
                rows: &'k [Row] = rows,
                left: &'k mut [Left] = left,
                quads: &'k mut Quads = quads,
                damping: Damping = damping,
                pass: Pass = pass,
            ] -> () {
                in_turn(groups, rows, left, quads, damping, pass);
            });
        }
        for range in Colouring::ranges(colours) {
            let (groups, left) = (&groups[range.clone()], &mut left[range]);
            let (rows, count) = (&rows[..], groups.len());
            let impulses = &mut impulses[..count];
            let read = &*quads;
            let sweep = |band: Range<usize>, (left, impulses): Part<'_>| {
                vectorised!(four_wide(), [_four,
                    groups: &'k [Group] = &groups[band],
                    rows: &'k [Row] = rows,
                    part: Part<'k> = (left, impulses),
                    quads: &'k Quads = read,
                    damping: Damping = damping,
                    pass: Pass = pass,
                ] -> () {
                    at_once(groups, rows, part, quads, damping, pass);
                });
            };
            let part = (left, &mut *impulses);
            in_bands(bands(threads, count * GROUP), count, part, &sweep);
            vectorised!(four_wide(), [_four,
                groups: &'k [Group] = groups,
                impulses: &'k [[Numbers; 3]] = impulses,
                quads: &'k mut Quads = quads,
            ] -> () {
                let Quads { way, inverse_mass, .. } = quads;
                for (group, impulses) in groups.iter().zip(impulses) {
                    push(group, impulses, way, inverse_mass);
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

/// Projects group after group.
#[inline(always)]
fn in_turn(
    groups: &[Group],
    rows: &[Row],
    left: &mut [Left],
    quads: &mut Quads,
    damping: Damping,
    pass: Pass,
) {
    let Quads { base, way, inverse_mass } = quads;
    // One check of a particle's index serves all three.
    let n = way.len();
    let (base, inverse_mass) = (&base[..n], &inverse_mass[..n]);
    for (group, left) in groups.iter().zip(left) {
        let seen = Seen::new(group, base, way);
        let impulses = seen.project(&rows[group.row as usize], left, damping, pass);
        push(group, &impulses, way, inverse_mass);
    }
}

/// Computes the impulses of all groups from the same positions.
#[inline(always)]
fn at_once(
    groups: &[Group],
    rows: &[Row],
    (left, out): Part<'_>,
    quads: &Quads,
    damping: Damping,
    pass: Pass,
) {
    let way = &quads.way[..];
    let base = &quads.base[..way.len()];
    for ((group, left), out) in groups.iter().zip(left).zip(out) {
        let seen = Seen::new(group, base, way);
        *out = seen.project(&rows[group.row as usize], left, damping, pass);
    }
}

/// Moves the ends of springs: `q_i += w_i I`, `q_j −= w_j I`.
#[inline(always)]
fn push(group: &Group, impulses: &[Numbers; 3], way: &mut [Lanes], inverse_mass: &[f64]) {
    for t in 0..GROUP {
        let (i, j) = (group.ends[0][t] as usize, group.ends[1][t] as usize);
        let (w_i, w_j) = (inverse_mass[i], inverse_mass[j]);
        let [x, y, z] = [impulses[0][t], impulses[1][t], impulses[2][t]];
        let at = way[i];
        way[i] = [at[0] + x * w_i, at[1] + y * w_i, at[2] + z * w_i, 0.0];
        let at = way[j];
        way[j] = [at[0] - x * w_j, at[1] - y * w_j, at[2] - z * w_j, 0.0];
    }
}

/// `p_i − p_j` and `q_i − q_j` of a group, by coordinates, m.
struct Seen {
    d: [Numbers; 3],
    apart: [Numbers; 3],
}

impl Seen {
    #[inline(always)]
    fn new(group: &Group, base: &[Lanes], way: &[Lanes]) -> Self {
        let zeros = [[0.0; GROUP]; 3];
        let mut seen = Self { d: zeros, apart: zeros };
        for t in 0..GROUP {
            let (i, j) = (group.ends[0][t] as usize, group.ends[1][t] as usize);
            let (base_i, base_j, way_i, way_j) = (&base[i], &base[j], &way[i], &way[j]);
            for k in 0..3 {
                let apart = way_i[k] - way_j[k];
                seen.apart[k][t] = apart;
                seen.d[k][t] = (base_i[k] - base_j[k]) + apart;
            }
        }
        seen
    }

    /// The impulses on the first ends, kg m.
    #[inline(always)]
    fn project(&self, row: &Row, left: &mut Left, damping: Damping, pass: Pass) -> [Numbers; 3] {
        let mut own = if pass.is_first { [[0.0; GROUP]; 4] } else { *left };
        let impulses = match damping {
            Damping::Along => self.along(row, &mut own),
            Damping::Full => self.full(row, &mut own),
        };
        if !pass.is_last {
            *left = own;
        }
        impulses
    }

    /// (X4).
    #[inline(always)]
    fn along(&self, row: &Row, left: &mut Left) -> [Numbers; 3] {
        let Self { d: [dx, dy, dz], apart: [rx, ry, rz] } = self;
        let [mut x, mut y, mut z] = [[0.0; GROUP]; 3];
        let lambda = &mut left[0];
        for t in 0..GROUP {
            let length = (dx[t] * dx[t] + dy[t] * dy[t] + dz[t] * dz[t]).sqrt();
            let is_collapsed = length <= row.collapsed[t];
            let (ux, uy, uz) = (dx[t] / length, dy[t] / length, dz[t] / length);
            let speed = ux * rx[t] + uy * ry[t] + uz * rz[t];
            let pull = row.pull[t] * (length - row.rest[t]);
            let step = -(lambda[t] + pull + row.brake[t] * speed) * row.share[t];
            x[t] = if is_collapsed { 0.0 } else { ux * step };
            y[t] = if is_collapsed { 0.0 } else { uy * step };
            z[t] = if is_collapsed { 0.0 } else { uz * step };
            lambda[t] = if is_collapsed { lambda[t] } else { lambda[t] + step };
        }
        [x, y, z]
    }

    /// (X5).
    #[inline(always)]
    fn full(&self, row: &Row, left: &mut Left) -> [Numbers; 3] {
        let Self { d: [dx, dy, dz], apart: [rx, ry, rz] } = self;
        let [mut x, mut y, mut z] = [[0.0; GROUP]; 3];
        let [lambda, bx, by, bz] = left;
        for t in 0..GROUP {
            let (g, s, w) = (row.brake[t], row.pass[t], row.mobility[t]);
            let mx = -(bx[t] + rx[t] * g) * s;
            let my = -(by[t] + ry[t] * g) * s;
            let mz = -(bz[t] + rz[t] * g) * s;
            let (dx, dy, dz) = (dx[t] + mx * w, dy[t] + my * w, dz[t] + mz * w);
            let length = (dx * dx + dy * dy + dz * dz).sqrt();
            let is_collapsed = length <= row.collapsed[t];
            let (ux, uy, uz) = (dx / length, dy / length, dz / length);
            let pull = row.pull[t] * (length - row.rest[t]);
            let step = -(lambda[t] + pull) * row.share[t];
            let passed = s * step;
            let (ix, iy, iz) = (mx + ux * passed, my + uy * passed, mz + uz * passed);
            x[t] = if is_collapsed { mx } else { ix };
            y[t] = if is_collapsed { my } else { iy };
            z[t] = if is_collapsed { mz } else { iz };
            bx[t] += if is_collapsed { mx } else { ix - ux * step };
            by[t] += if is_collapsed { my } else { iy - uy * step };
            bz[t] += if is_collapsed { mz } else { iz - uz * step };
            lambda[t] = if is_collapsed { lambda[t] } else { lambda[t] + step };
        }
        [x, y, z]
    }
}
