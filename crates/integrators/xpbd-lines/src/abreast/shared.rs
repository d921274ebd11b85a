//! The groups of a family shared among threads.

use super::{Abreast, Brake, Four, Group, Joint, LINES, Link, Pull, Row, Ways, gather};
use crate::chains::Places;
use drape_model::Vec3;
use drape_solvers::bands::{Divisible, in_bands, in_items};
use pulp::Arch;
use std::ops::Range;

/// A particle without a line in a family.
const NONE: u32 = u32::MAX;

/// Memory of threads.
#[derive(Debug)]
pub(super) struct Shared {
    /// For each family and particle the number among the new ways of the family.
    numbers: Vec<Vec<u32>>,
    /// As many as links in the family with most of them.
    rows: Vec<Row>,
    /// New ways, joint by joint.
    ways: Vec<[Four; 3]>,
    /// The same by full damping, and its scratch; empty without it.
    damped: Vec<[Four; 3]>,
    solved: Vec<[Four; 3]>,
}

impl Shared {
    pub(super) fn new(
        particles: usize,
        joints: &[Joint],
        groups: &[Range<usize>],
        families: &[Range<usize>],
        is_full: bool,
    ) -> Self {
        let (mut most_links, mut most_joints) = (0, 0);
        let mut numbers = Vec::new();
        for family in families {
            let mut number = vec![NONE; particles];
            let (links, all) = of_family(groups, family);
            // Where a line is filled up, its last particle takes what is written last: its first
            // place.
            for (place, joint) in joints[all.clone()].iter().enumerate().rev() {
                for (k, &i) in joint.particles.iter().enumerate() {
                    number[i as usize] = (place * LINES + k) as u32;
                }
            }
            most_links = most_links.max(links.len());
            most_joints = most_joints.max(all.len());
            numbers.push(number);
        }
        let if_full = |count| vec![[[0.0; LINES]; 3]; if is_full { count } else { 0 }];
        Self {
            numbers,
            rows: vec![Row::default(); most_links],
            ways: vec![[[0.0; LINES]; 3]; most_joints],
            damped: if_full(most_joints),
            solved: if_full(most_links),
        }
    }
}

/// The links and the joints of a family.
fn of_family(groups: &[Range<usize>], family: &Range<usize>) -> (Range<usize>, Range<usize>) {
    match &groups[family.clone()] {
        [first, .., last] | [first @ last] => {
            (first.start..last.end, first.start + family.start..last.end + family.end)
        }
        [] => (0..0, 0..0),
    }
}

/// Old ways, and new ones beside them: joint by joint of a group.
struct Beside<'a> {
    old: &'a [Vec3],
    new: &'a mut [[Four; 3]],
}

impl Ways for Beside<'_> {
    #[inline(always)]
    fn all(&self) -> &[Vec3] {
        self.old
    }

    #[inline(always)]
    fn put(&mut self, place: usize, _joint: &Joint, ways: [Four; 3]) {
        self.new[place] = ways;
    }

    #[inline(always)]
    fn behind(&self, joint: &Joint, next: &Joint, ways: &[Four; 3]) -> [Four; 3] {
        let mut behind = gather(self.old, &joint.particles);
        for k in 0..LINES {
            if joint.particles[k] == next.particles[k] {
                for (behind, way) in behind.iter_mut().zip(ways) {
                    behind[k] = way[k];
                }
            }
        }
        behind
    }
}

/// Some groups that follow each other in a family, and what a thread writes for them.
struct Part<'a> {
    groups: &'a [Range<usize>],
    joints: &'a [Joint],
    links: &'a [Link],
    multipliers: &'a mut [Four],
    brakes: &'a mut [[Four; 3]],
    rows: &'a mut [Row],
    ways: &'a mut [[Four; 3]],
    damped: &'a mut [[Four; 3]],
    solved: &'a mut [[Four; 3]],
}

/// The first `count` items and the rest; all of few.
fn cut<T>(list: &mut [T], count: usize) -> (&mut [T], &mut [T]) {
    list.split_at_mut(count.min(list.len()))
}

impl Divisible for Part<'_> {
    /// Cuts behind so many groups.
    fn split(self, groups: usize) -> (Self, Self) {
        let (first, second) = self.groups.split_at(groups);
        let links = first.iter().map(|group| group.len()).sum();
        let joints = links + groups;
        let (left_links, right_links) = self.links.split_at(links);
        let (left_joints, right_joints) = self.joints.split_at(joints);
        let (left_multipliers, right_multipliers) = cut(self.multipliers, links);
        let (left_brakes, right_brakes) = cut(self.brakes, links);
        let (left_rows, right_rows) = cut(self.rows, links);
        let (left_ways, right_ways) = cut(self.ways, joints);
        let (left_damped, right_damped) = cut(self.damped, joints);
        let (left_solved, right_solved) = cut(self.solved, links);
        let left = Self {
            groups: first,
            joints: left_joints,
            links: left_links,
            multipliers: left_multipliers,
            brakes: left_brakes,
            rows: left_rows,
            ways: left_ways,
            damped: left_damped,
            solved: left_solved,
        };
        let right = Self {
            groups: second,
            joints: right_joints,
            links: right_links,
            multipliers: right_multipliers,
            brakes: right_brakes,
            rows: right_rows,
            ways: right_ways,
            damped: right_damped,
            solved: right_solved,
        };
        (left, right)
    }
}

impl Part<'_> {
    /// Calls `work` with each group, its new ways, and those by damping. All groups use the same
    /// scratch, so that it stays in a near cache.
    fn each(mut self, mut work: impl FnMut(Group<'_>, &mut [[Four; 3]], &mut [[Four; 3]])) {
        let (rows, solved) = (std::mem::take(&mut self.rows), std::mem::take(&mut self.solved));
        let mut rest = self;
        while !rest.groups.is_empty() {
            let (first, others) = rest.split(1);
            let Part { joints, links, multipliers, brakes, ways, damped, .. } = first;
            let (rows, solved) = (&mut rows[..links.len()], &mut *solved);
            work(Group { joints, links, multipliers, brakes, rows, solved }, ways, damped);
            rest = others;
        }
    }
}

impl Abreast {
    /// Whether threads share a sweep of so many bands.
    pub(super) fn shares(&self, bands: usize) -> bool {
        bands > 1 && self.shared.is_some()
    }

    /// The groups of a family.
    fn part(&mut self, family: usize) -> Option<(Part<'_>, Arch)> {
        let Self { arch, links, multipliers, brakes, joints, groups, families, shared, .. } = self;
        let Shared { rows, ways, damped, solved, .. } = shared.as_mut()?;
        let family = &families[family];
        let (own, all) = of_family(groups, family);
        let of_full = if brakes.is_empty() { 0..0 } else { own.clone() };
        let part = Part {
            groups: &groups[family.clone()],
            joints: &joints[all],
            links: &links[own.clone()],
            multipliers: &mut multipliers[own],
            brakes: &mut brakes[of_full],
            rows,
            ways,
            damped,
            solved,
        };
        Some((part, *arch))
    }

    /// As [`pull`](Self::pull), by several threads.
    pub(super) fn pull_by_threads(
        &mut self,
        family: usize,
        places: &mut Places<'_>,
        is_full: bool,
    ) {
        let Places { base, way, bands, .. } = places;
        let Some((part, arch)) = self.part(family) else { return };
        let old = &**way;
        let pull = |_: Range<usize>, part: Part<'_>| {
            part.each(|group, new, _| {
                arch.dispatch(Pull { group, is_full, base, ways: Beside { old, new } });
            });
        };
        in_items(*bands, part.groups.len(), part, &pull);
        let Some(Shared { numbers, ways, .. }) = &self.shared else { return };
        take(&numbers[family], ways, way, *bands);
    }

    /// As [`brake`](Self::brake), by several threads.
    pub(super) fn brake_by_threads(
        &mut self,
        family: usize,
        places: &mut Places<'_>,
        pending: Option<&[Vec3]>,
        damped: &mut [Vec3],
    ) {
        let Places { way, bands, .. } = places;
        let Some((part, arch)) = self.part(family) else { return };
        let old = (&**way, &*damped);
        let brake = |_: Range<usize>, part: Part<'_>| {
            part.each(|group, ways, damped| {
                let (ways, damped) =
                    (Beside { old: old.0, new: ways }, Beside { old: old.1, new: damped });
                arch.dispatch(Brake { group, pending, ways, damped });
            });
        };
        in_items(*bands, part.groups.len(), part, &brake);
        let Some(Shared { numbers, ways, damped: new, .. }) = &self.shared else { return };
        take(&numbers[family], ways, way, *bands);
        take(&numbers[family], new, damped, *bands);
    }
}

/// Each particle takes its new way.
fn take(numbers: &[u32], new: &[[Four; 3]], ways: &mut [Vec3], bands: usize) {
    in_bands(bands, ways.len(), ways, &|particles, ways: &mut [Vec3]| {
        for (way, &number) in ways.iter_mut().zip(&numbers[particles]) {
            if number != NONE {
                let (place, k) = (number as usize / LINES, number as usize % LINES);
                let [x, y, z] = new[place];
                *way = Vec3::new(x[k], y[k], z[k]);
            }
        }
    });
}
