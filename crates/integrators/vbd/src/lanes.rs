//! The block steps of four particles of a colour at a time.
//!
//! Particles of a colour share no spring, so they can move at once. A register holds one number of
//! four particles. The particles of a group meet their springs side by side, the first of each,
//! then the second; a particle that has fewer springs meets itself on a spring that pulls at
//! nothing. Each number has the order of operations of the readable form,
//! [`Problem::descend`], so both give the same bits. Groups with a particle that is pinned, in
//! contact or on a singular block take the readable form.
//!
//! Angles, hinges, springs with a curve and augmented stiffness take it everywhere.

use crate::rows::Rows;
use crate::sweep::{Iterate, Problem};
use crate::terms::{Damping, Terms};
use drape_model::Vec3;
use drape_model::effects::COLLAPSED;
use drape_solvers::lanes::{Four, Lanes, four_wide, vectorised};
use drape_solvers::{Constraints, Filter};

/// Particles of a group.
pub(crate) const GROUP: usize = 4;

/// No spring.
const NONE: u32 = u32::MAX;

/// A spring of each particle of a group.
#[derive(Clone, Copy, Debug)]
struct Arms {
    /// The particles at the other ends.
    others: [u32; GROUP],
    /// `ℓ`, m.
    rest: Lanes,
    /// `k`, N/m.
    stiffness: Lanes,
}

/// The springs of all groups.
#[derive(Debug)]
pub(crate) struct Groups {
    /// The particles; the last group of a colour repeats its last particle.
    particles: Vec<[u32; GROUP]>,
    /// The first group of each colour.
    starts: Vec<usize>,
    /// The arms of a group.
    arms: Rows<Arms>,
    /// The springs of the arms.
    springs: Vec<[u32; GROUP]>,
}

impl Groups {
    /// Groups of the particles of each colour; `None` where a term has no fast form.
    pub(crate) fn new(terms: &Terms, colours: &Rows<u32>) -> Option<Self> {
        if !terms.are_plain() {
            return None;
        }
        let (mut particles, mut starts, mut all) = (Vec::new(), Vec::new(), Vec::new());
        for colour in 0..colours.len() {
            starts.push(particles.len());
            for chunk in colours.row(colour).chunks(GROUP) {
                let group: [u32; GROUP] = std::array::from_fn(|k| chunk[k.min(chunk.len() - 1)]);
                let most = group.iter().map(|&i| terms.springs_of(i as usize).count()).max();
                for arm in 0..most.unwrap_or(0) {
                    let found = group.map(|i| terms.springs_of(i as usize).nth(arm));
                    let others: [u32; GROUP] =
                        std::array::from_fn(|k| found[k].map_or(group[k], |(_, other)| other));
                    let springs = found.map(|found| found.map_or(NONE, |(spring, _)| spring));
                    all.push((particles.len(), (others, springs)));
                }
                particles.push(group);
            }
        }
        let springs = all.iter().map(|(_, (_, springs))| *springs).collect();
        let arms = all.into_iter().map(|(group, (others, _))| {
            (group, Arms { others, rest: [0.0; GROUP], stiffness: [0.0; GROUP] })
        });
        let arms = Rows::new(particles.len(), arms.collect());
        let mut groups = Self { particles, starts, arms, springs };
        groups.refresh(terms);
        Some(groups)
    }

    /// Takes over the numbers of the springs.
    pub(crate) fn refresh(&mut self, terms: &Terms) {
        for (arms, springs) in self.arms.entries_mut().iter_mut().zip(&self.springs) {
            let numbers = springs.map(|spring| terms.numbers(spring));
            arms.rest = numbers.map(|(rest, _)| rest);
            arms.stiffness = numbers.map(|(_, stiffness)| stiffness);
        }
    }

    /// The new velocities of the particles of a colour from place `first` on, a multiple of
    /// [`GROUP`].
    pub(crate) fn descend(
        &self,
        problem: &Problem<'_>,
        (terms, constraints): (&Terms, &Constraints),
        at: &Iterate,
        (colour, first): (usize, usize),
        new: &mut [Vec3],
    ) {
        let first = self.starts[colour] + first / GROUP;
        vectorised!(four_wide(), [four,
            groups: &'k Groups = self,
            problem: &'k Problem<'k> = problem,
            terms: &'k Terms = terms,
            constraints: &'k Constraints = constraints,
            at: &'k Iterate = at,
            first: usize = first,
            new: &'k mut [Vec3] = new,
        ] -> () {
            for (group, new) in (first..).zip(new.chunks_mut(GROUP)) {
                let found = groups.move_four(four, problem, constraints, at, group);
                for (k, new) in new.iter_mut().enumerate() {
                    *new = match &found {
                        Some(quads) => Vec3::new(quads[k][0], quads[k][1], quads[k][2]),
                        None => {
                            let i = groups.particles[group][k] as usize;
                            problem.descend(terms, constraints, at, i)
                        }
                    };
                }
            }
        });
    }

    /// (V2)–(V4) for the particles of a group; `None` if one of them is not free or its block is
    /// singular.
    #[inline(always)]
    fn move_four<F: Four>(
        &self,
        four: F,
        problem: &Problem<'_>,
        constraints: &Constraints,
        at: &Iterate,
        group: usize,
    ) -> Option<[Lanes; GROUP]> {
        let Problem { system, h, target, damping, .. } = *problem;
        let own = self.particles[group].map(|i| i as usize);
        if own.iter().any(|&i| constraints.filter(i) != Filter::Free) {
            return None;
        }
        let (force, stiffness) = self.springs_at(four, own, group, &at.x);
        let sums = [
            damping.drag(four, own[0], &at.v),
            damping.drag(four, own[1], &at.v),
            damping.drag(four, own[2], &at.v),
            damping.drag(four, own[3], &at.v),
        ];
        let drag = coordinates(four, sums);
        let v = gather(four, own, &at.v);
        let target = gather(four, own, target);
        let mass = system.mass();
        let mass = four.load([mass[own[0]], mass[own[1]], mass[own[2]], mass[own[3]]]);
        let (step, square, zero) = (four.splat(h), four.splat(h * h), four.splat(0.0));
        // g_i = m (v_i − v̂_i) − h f_i + h (D v)_i, (V2)
        let mut gradient = [zero; 3];
        for k in 0..3 {
            let inertia = four.mul(four.sub(v[k], target[k]), mass);
            let forces = four.mul(four.sub(drag[k], force[k]), step);
            gradient[k] = four.add(inertia, forces);
        }
        // H_i = m I + h² K_ii + h D_ii, (V3)
        let viscosity = damping.viscosity(four, own);
        let mut block = [mass, zero, zero, mass, zero, mass];
        for k in 0..6 {
            let implicit = four.add(block[k], four.mul(stiffness[k], square));
            block[k] = four.add(implicit, four.mul(viscosity[k], step));
        }
        let change = solve(four, block, gradient)?; // v_i ← v_i − H⁻¹ g, (V4)
        let new =
            [four.sub(v[0], change[0]), four.sub(v[1], change[1]), four.sub(v[2], change[2]), zero];
        let [a, b, c, d] = four.transpose(new);
        Some([four.store(a), four.store(b), four.store(c), four.store(d)])
    }

    /// `(f_i, K_ii)` of the springs, by coordinates and as the lower triangle by columns.
    #[inline(always)]
    fn springs_at<F: Four>(
        &self,
        four: F,
        own: [usize; GROUP],
        group: usize,
        x: &[Vec3],
    ) -> ([F::Numbers; 3], [F::Numbers; 6]) {
        let zero = four.splat(0.0);
        let (mut force, mut block) = ([zero; 3], [zero; 6]);
        let at = [
            load(four, &x[own[0]]),
            load(four, &x[own[1]]),
            load(four, &x[own[2]]),
            load(four, &x[own[3]]),
        ];
        for Arms { others, rest, stiffness } in self.arms.row(group) {
            let mut quads = at;
            for k in 0..GROUP {
                quads[k] = four.sub(at[k], load(four, &x[others[k] as usize]));
            }
            let d = coordinates(four, quads);
            let plane = four.add(four.mul(d[0], d[0]), four.mul(d[1], d[1]));
            let length = four.sqrt(four.add(plane, four.mul(d[2], d[2])));
            let (rest, k) = (four.load(*rest), four.load(*stiffness));
            let collapsed = four.mul(four.splat(COLLAPSED), rest);
            let quotient = four.div(rest, length);
            let quotient = four.where_at_most(length, collapsed, zero, quotient);
            let secant = four.mul(k, four.sub(four.splat(1.0), quotient));
            let across = four.where_at_most(secant, zero, zero, secant);
            let along = four.sub(k, across);
            let u = [four.div(d[0], length), four.div(d[1], length), four.div(d[2], length)];
            for k in 0..3 {
                force[k] = four.sub(force[k], four.mul(d[k], secant));
            }
            for entry in 0..LOWER.len() {
                let (row, column) = LOWER[entry];
                if row == column {
                    block[entry] = four.add(block[entry], across);
                }
                let found = four.mul(four.mul(u[row], u[column]), along);
                let found = four.where_at_most(length, collapsed, zero, found);
                block[entry] = four.add(block[entry], found);
            }
        }
        (force, block)
    }
}

/// Rows and columns of the lower triangle.
const LOWER: [(usize, usize); 6] = [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)];

/// A vector with a fourth number 0.
#[inline(always)]
fn load<F: Four>(four: F, vector: &Vec3) -> F::Numbers {
    four.load([vector.x, vector.y, vector.z, 0.0])
}

/// Four vectors as one register per coordinate.
#[inline(always)]
fn coordinates<F: Four>(four: F, quads: [F::Numbers; GROUP]) -> [F::Numbers; 3] {
    let [x, y, z, _] = four.transpose(quads);
    [x, y, z]
}

/// `from − a b`.
#[inline(always)]
fn minus<F: Four>(four: F, from: F::Numbers, a: F::Numbers, b: F::Numbers) -> F::Numbers {
    four.add(four.mul(four.neg(a), b), from)
}

/// The vectors of four particles as one register per coordinate.
#[inline(always)]
fn gather<F: Four>(four: F, own: [usize; GROUP], all: &[Vec3]) -> [F::Numbers; 3] {
    let (a, b) = (load(four, &all[own[0]]), load(four, &all[own[1]]));
    let (c, d) = (load(four, &all[own[2]]), load(four, &all[own[3]]));
    coordinates(four, [a, b, c, d])
}

/// `A v` with a matrix by columns.
#[inline(always)]
fn product<F: Four>(four: F, columns: &[Lanes; 3], v: &Vec3) -> F::Numbers {
    let x = four.mul(four.load(columns[0]), four.splat(v.x));
    let y = four.mul(four.load(columns[1]), four.splat(v.y));
    let z = four.mul(four.load(columns[2]), four.splat(v.z));
    four.add(four.add(x, y), z)
}

/// Four vectors from memory as one register per coordinate.
#[inline(always)]
fn columns<F: Four>(four: F, [a, b, c, d]: [Lanes; GROUP]) -> [F::Numbers; 3] {
    coordinates(four, [four.load(a), four.load(b), four.load(c), four.load(d)])
}

/// Solves four systems `a d = b` by Cholesky factors, in the order of operations of `nalgebra`;
/// `None` if a matrix is not positive definite.
#[inline(always)]
fn solve<F: Four>(four: F, a: [F::Numbers; 6], b: [F::Numbers; 3]) -> Option<[F::Numbers; 3]> {
    let [a00, a10, a20, a11, a21, a22] = a;
    let l00 = four.sqrt(a00);
    let (l10, l20) = (four.div(a10, l00), four.div(a20, l00));
    let p11 = minus(four, a11, l10, l10);
    let l11 = four.sqrt(p11);
    let l21 = four.div(minus(four, a21, l10, l20), l11);
    let p22 = minus(four, minus(four, a22, l20, l20), l21, l21);
    let l22 = four.sqrt(p22);
    let pivots = [four.store(a00), four.store(p11), four.store(p22)];
    if !pivots.as_flattened().iter().all(|pivot| *pivot > 0.0) {
        return None;
    }
    let c0 = four.div(b[0], l00);
    let c1 = four.div(minus(four, b[1], c0, l10), l11);
    let c2 = four.div(minus(four, minus(four, b[2], c0, l20), c1, l21), l22);
    let zero = four.splat(0.0);
    let d2 = four.div(four.sub(c2, zero), l22);
    let d1 = four.div(four.sub(c1, four.add(zero, four.mul(l21, d2))), l11);
    let sum = four.add(four.add(zero, four.mul(l10, d1)), four.mul(l20, d2));
    Some([four.div(four.sub(c0, sum), l00), d1, d2])
}

impl Damping {
    /// `(D v)_i` less the force of drags at rest, N.
    #[inline(always)]
    fn drag<F: Four>(&self, four: F, i: usize, v: &[Vec3]) -> F::Numbers {
        let (diagonal, row) = self.columns(i);
        let mut sum = product(four, diagonal, &v[i]);
        for (j, columns) in row {
            sum = four.add(sum, product(four, columns, &v[j as usize]));
        }
        four.sub(sum, load(four, &self.force_at_rest(i)))
    }

    /// `D_ii` of four particles as the lower triangle by columns, N s/m.
    #[inline(always)]
    fn viscosity<F: Four>(&self, four: F, own: [usize; GROUP]) -> [F::Numbers; 6] {
        let own = own.map(|i| self.columns(i).0);
        let column = |k: usize| [own[0][k], own[1][k], own[2][k], own[3][k]];
        let [a, b, c] = columns(four, column(0));
        let [_, d, e] = columns(four, column(1));
        let [_, _, f] = columns(four, column(2));
        [a, b, c, d, e, f]
    }
}
