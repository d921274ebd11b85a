//! Provot's limit on elongation: over-stretched springs are shortened by moving their ends.

use crate::random::Lcg;
use crate::{Word, settings};
use drape_model::{Effect, System, Vec3};

/// Order in which the springs are visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SweepOrder {
    /// As the system lists them.
    Forward,
    /// From last to first.
    Backward,
    /// Forward and backward in turn. Each call begins forward, so with one sweep per call this
    /// equals [`Forward`](Self::Forward).
    Alternating,
    /// In one random order, which is the same in each sweep and each run.
    Shuffled,
}

impl Word for SweepOrder {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("forward", Self::Forward),
        ("backward", Self::Backward),
        ("alternating", Self::Alternating),
        ("shuffled", Self::Shuffled),
    ];
}

settings! {
    /// How far, how often and in which order springs are shortened.
    pub struct ElongationSettings {
        /// greatest elongation of a tension or shear spring over its rest length
        limit: f64 in 1e-4..=10.0 = 0.1,
        /// most sweeps over the springs in a step; they end early when no spring is too long
        sweeps: usize in 1..=1000 = 1,
        /// order in which a sweep visits the springs; alternating: every second sweep of a step
        /// backward
        order: SweepOrder [Forward, Backward, Alternating, Shuffled] = Forward,
    }
}

#[derive(Clone, Copy, Debug)]
struct Link {
    i: usize,
    j: usize,
    longest: f64,
}

/// Shortens every tension and shear spring above `(1 + limit) ℓ` to that length, one after the
/// other (Provot 1995, section 5).
///
/// Both ends move along the spring, by `w_i/(w_i + w_j)` and `w_j/(w_i + w_j)` of the excess with
/// `w = 1/m`, so the centre of mass stays. A pinned end does not move; the other end then moves by
/// the whole excess. Springs of rest length 0 are skipped.
///
/// Shortening one spring stretches its neighbours. The result therefore depends on the order, and
/// for small limits no number of sweeps may suffice. The correction does not solve a differential
/// equation.
#[derive(Clone, Debug)]
pub struct ElongationLimit {
    links: Vec<Link>,
    order: SweepOrder,
    sweeps: usize,
    /// Positions before the correction.
    uncorrected: Vec<Vec3>,
}

impl ElongationLimit {
    /// Reads the springs and rest lengths of `system`. Masses and pins are read again in each call
    /// of [`correct`](Self::correct).
    pub fn new(system: &System, settings: ElongationSettings) -> Self {
        let ElongationSettings { limit, sweeps, order } = settings;
        let mut links = Vec::new();
        let limited = |effect: &&dyn Effect| matches!(effect.name(), "tension" | "shear");
        for split in system.effects().filter(limited).filter_map(Effect::split) {
            split.visit_rest_lengths(&mut |i, j, rest| {
                if rest > 0.0 {
                    links.push(Link { i, j, longest: rest * (1.0 + limit) });
                }
            });
        }
        if order == SweepOrder::Shuffled {
            Lcg::new().shuffle(&mut links);
        }
        Self { links, order, sweeps, uncorrected: vec![Vec3::zeros(); system.len()] }
    }

    /// Corrects the positions at the end of a step of `h` seconds. If velocities are given, each
    /// changes by its particle's correction over `h`, so that `v = (x_{n+1} − x_n)/h` still holds.
    /// Returns the largest distance that a particle moved, m.
    pub fn correct(
        &mut self,
        system: &System,
        h: f64,
        x: &mut [Vec3],
        v: Option<&mut [Vec3]>,
    ) -> f64 {
        self.uncorrected.copy_from_slice(x);
        if !self.shorten(system, x) {
            return 0.0;
        }
        let displacements = || x.iter().zip(&self.uncorrected).map(|(x, before)| x - before);
        if let Some(v) = v {
            v.iter_mut().zip(displacements()).for_each(|(v, moved)| *v += moved / h);
        }
        displacements().fold(0.0, |largest, moved| largest.max(moved.norm()))
    }

    /// Sweeps until one finds nothing to do; returns whether any position moved.
    fn shorten(&self, system: &System, x: &mut [Vec3]) -> bool {
        let mut moved = false;
        for sweep in 0..self.sweeps {
            let backward = match self.order {
                SweepOrder::Forward | SweepOrder::Shuffled => false,
                SweepOrder::Backward => true,
                SweepOrder::Alternating => sweep % 2 == 1,
            };
            let shorten = |any, link: &Link| link.shorten(system, x) | any;
            let any = if backward {
                self.links.iter().rev().fold(false, shorten)
            } else {
                self.links.iter().fold(false, shorten)
            };
            if !any {
                break;
            }
            moved = true;
        }
        moved
    }
}

impl Link {
    /// Shortens the spring if it is too long; returns whether it did.
    fn shorten(&self, system: &System, x: &mut [Vec3]) -> bool {
        let Self { i, j, longest } = *self;
        let d = x[i] - x[j];
        let length = d.norm();
        let inverse_mass = |i: usize| if system.pinned()[i] { 0.0 } else { 1.0 / system.mass()[i] };
        let (w_i, w_j) = (inverse_mass(i), inverse_mass(j));
        let moves = length > longest && w_i + w_j > 0.0;
        if moves {
            let excess = d * ((length - longest) / (length * (w_i + w_j)));
            x[i] -= excess * w_i;
            x[j] += excess * w_j;
        }
        moves
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::net;
    use drape_model::State;

    fn limit(system: &System, sweeps: usize, order: SweepOrder) -> ElongationLimit {
        ElongationLimit::new(system, ElongationSettings { limit: LIMIT, sweeps, order })
    }

    const LIMIT: f64 = 0.1;

    /// Particles joined in a row by springs of rest length 1.
    fn row(effect: &str, mass: &[f64], x: &[Vec3], pinned: &[usize]) -> (System, State) {
        let springs: Vec<_> = (1..mass.len()).map(|j| (j - 1, j, 100.0, 1.0)).collect();
        net(effect, mass, x, &springs, pinned)
    }

    /// Four particles of unequal mass, every spring between them too long.
    fn stretched(pinned: &[usize]) -> (System, State) {
        let x = [[0.0, 0.0, 0.0], [1.5, 0.2, 0.0], [2.9, -0.4, 0.3], [4.6, 0.1, 0.9]];
        row("tension", &[1.0, 3.0, 0.5, 2.0], &x.map(Vec3::from), pinned)
    }

    fn limited(
        system: &System,
        state: &State,
        sweeps: usize,
        order: SweepOrder,
    ) -> (bool, Vec<Vec3>) {
        let mut x = state.x.clone();
        let moved = limit(system, sweeps, order).shorten(system, &mut x);
        (moved, x)
    }

    fn centre_of_mass(system: &System, x: &[Vec3]) -> Vec3 {
        let total: f64 = system.mass().iter().sum();
        x.iter().zip(system.mass()).fold(Vec3::zeros(), |sum, (x, m)| sum + x * (m / total))
    }

    #[test]
    fn a_spring_that_is_too_long_ends_at_the_limit_and_the_centre_of_mass_stays() {
        let x = [Vec3::new(0.3, -0.2, 0.1), Vec3::new(1.5, 0.9, -0.7)];
        let (system, state) = row("shear", &[1.0, 3.0], &x, &[]);
        let (moved, after) = limited(&system, &state, 1, SweepOrder::Forward);
        assert!(moved);
        let (before, d) = (x[0] - x[1], after[0] - after[1]);
        assert!((d.norm() - (1.0 + LIMIT)).abs() < 1e-15);
        assert!(d.cross(&before).norm() < 1e-15, "along the spring");
        let drift = centre_of_mass(&system, &after) - centre_of_mass(&system, &x);
        assert!(drift.norm() < 1e-15);
        // Three times the mass, a third of the way.
        let ways = [0, 1].map(|i: usize| (after[i] - x[i]).norm());
        assert!((ways[0] - 3.0 * ways[1]).abs() < 1e-14 && ways[1] > 0.1);
    }

    #[test]
    fn a_pinned_end_leaves_the_way_to_the_other_and_two_leave_the_spring_alone() {
        let x = [Vec3::zeros(), Vec3::new(0.0, 1.2, 1.6)];
        for pinned in [0, 1] {
            let (system, state) = row("tension", &[1.0, 3.0], &x, &[pinned]);
            let (moved, after) = limited(&system, &state, 1, SweepOrder::Forward);
            assert!(moved && after[pinned] == x[pinned]);
            assert!(((after[0] - after[1]).norm() - (1.0 + LIMIT)).abs() < 1e-15);
        }
        let (system, state) = row("tension", &[1.0, 3.0], &x, &[0, 1]);
        assert_eq!(limited(&system, &state, 3, SweepOrder::Forward), (false, state.x));
    }

    #[test]
    fn springs_within_the_limit_stay_and_so_do_those_that_have_none() {
        for length in [0.0, 0.3, 1.0, 1.0999] {
            let (system, state) =
                row("tension", &[1.0, 2.0], &[Vec3::zeros(), Vec3::x() * length], &[]);
            assert_eq!(limited(&system, &state, 1, SweepOrder::Forward), (false, state.x));
        }
        let far = [Vec3::zeros(), Vec3::x() * 5.0];
        let (system, state) = row("bending", &[1.0, 2.0], &far, &[]);
        assert_eq!(limited(&system, &state, 1, SweepOrder::Forward), (false, state.x));
        let (system, state) = net("tension", &[1.0; 2], &far, &[(0, 1, 1.0, 0.0)], &[]);
        assert_eq!(limited(&system, &state, 1, SweepOrder::Forward), (false, state.x));
    }

    #[test]
    fn each_order_visits_the_springs_as_it_says() {
        let (system, state) = stretched(&[0]);
        let sweep = |order| limited(&system, &state, 1, order).1;
        let forward = sweep(SweepOrder::Forward);
        // Spring by spring: the first has a pinned end.
        let shorten = |x: &mut [Vec3], i: usize, w: [f64; 2]| {
            let d = x[i] - x[i + 1];
            let excess = d * ((d.norm() - 1.1) / d.norm() / (w[0] + w[1]));
            x[i] -= excess * w[0];
            x[i + 1] += excess * w[1];
        };
        let inverse = [0.0, 1.0 / 3.0, 2.0, 0.5];
        let by_hand = |order: [usize; 3]| {
            let mut x = state.x.clone();
            for i in order {
                shorten(&mut x, i, [inverse[i], inverse[i + 1]]);
            }
            x
        };
        let agree = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).all(|(a, b)| (a - b).norm() < 1e-14);
        assert!(agree(&forward, &by_hand([0, 1, 2])));
        let backward = sweep(SweepOrder::Backward);
        assert!(agree(&backward, &by_hand([2, 1, 0])) && !agree(&backward, &forward));
        let shuffled = sweep(SweepOrder::Shuffled);
        let permutations = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        assert!(permutations.into_iter().any(|order| agree(&shuffled, &by_hand(order))));
        assert_eq!(shuffled, sweep(SweepOrder::Shuffled), "the same each time");
        assert_eq!(sweep(SweepOrder::Alternating), forward);
        let there_and_back = limited(&system, &state, 2, SweepOrder::Alternating).1;
        let mut expected = forward;
        limit(&system, 1, SweepOrder::Backward).shorten(&system, &mut expected);
        assert_eq!(there_and_back, expected);
    }

    #[test]
    fn shuffling_keeps_every_spring() {
        let mut list: Vec<usize> = (0..50).collect();
        Lcg::new().shuffle(&mut list);
        assert_ne!(list, (0..50).collect::<Vec<_>>());
        list.sort_unstable();
        assert_eq!(list, (0..50).collect::<Vec<_>>());
    }

    #[test]
    fn sweeps_approach_the_limit_where_it_can_be_met_and_only_there() {
        let longest = |x: &[Vec3]| x.windows(2).map(|x| (x[0] - x[1]).norm()).fold(0.0, f64::max);
        let order = SweepOrder::Alternating;
        let (system, state) = stretched(&[0]);
        let lengths =
            [1, 4, 40, 1000].map(|sweeps| longest(&limited(&system, &state, sweeps, order).1));
        assert!(lengths.windows(2).all(|pair| pair[1] < pair[0] + 1e-15), "{lengths:?}");
        assert!(lengths[0] > 1.2 && (lengths[3] - 1.1).abs() < 1e-12, "{lengths:?}");
        // Both ends held farther apart than the springs may reach.
        let (system, state) = stretched(&[0, 3]);
        let length = longest(&limited(&system, &state, 1000, order).1);
        assert!(length > 1.3, "{length}");
    }

    #[test]
    fn masses_and_pins_are_those_of_the_moment() {
        let (mut system, state) = stretched(&[]);
        let limit = limit(&system, 1, SweepOrder::Forward);
        assert!(system.set_mass(&[2.0, 1.0, 1.0, 5.0]) && system.set_pinned(1, true));
        let mut kept = state.x.clone();
        limit.shorten(&system, &mut kept);
        assert_eq!(kept, limited(&system, &state, 1, SweepOrder::Forward).1);
        assert_eq!(kept[1], state.x[1]);
    }

    #[test]
    fn every_word_names_an_order_of_its_own() {
        let orders: Vec<_> = SweepOrder::WORDS.iter().map(|(_, order)| *order).collect();
        assert_eq!(orders[0], ElongationSettings::default().order);
        for (i, order) in orders.iter().enumerate() {
            assert!(!orders[..i].contains(order), "{order:?}");
        }
    }
}
