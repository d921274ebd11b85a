//! Provot's limit on elongation: over-stretched springs are shortened by moving their ends.

use drape_model::{Effect, System, Vec3};

/// In which order the springs are visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SweepOrder {
    /// As the system lists them.
    Forward,
    /// From last to first.
    Backward,
    /// Forward and backward in turn.
    Alternating,
    /// In one fixed random order.
    Shuffled,
}

impl SweepOrder {
    /// The words of the setting.
    pub const WORDS: &[&str] = &["forward", "backward", "alternating", "shuffled"];

    /// Reads one of [`WORDS`](Self::WORDS).
    pub fn read(word: &str) -> Self {
        match word {
            "backward" => Self::Backward,
            "alternating" => Self::Alternating,
            "shuffled" => Self::Shuffled,
            _ => Self::Forward,
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Link {
    i: usize,
    j: usize,
    longest: f64,
}

/// Shortens every tension and shear spring that is longer than `(1 + limit) ℓ` to that length, one after
/// the other (Provot 1995, section 5).
///
/// Both ends move along the spring, by `w_i/(w_i + w_j)` and `w_j/(w_i + w_j)` of the excess with
/// `w = 1/m`, so that the centre of mass stays; a pinned end stays where it is. Shortening one spring stretches
/// its neighbours: the result depends on the order, and for small limits no number of sweeps may
/// suffice. No differential equation stands behind it.
#[derive(Clone, Debug)]
pub struct ElongationLimit {
    links: Vec<Link>,
    order: SweepOrder,
    sweeps: usize,
}

impl ElongationLimit {
    /// Takes up the springs of `system` with `sweeps` sweeps a call; `limit` is the greatest elongation over the
    /// rest length.
    pub fn new(system: &System, limit: f64, sweeps: usize, order: SweepOrder) -> Self {
        let mut links = Vec::new();
        let limited = |effect: &&dyn Effect| matches!(effect.name(), "tension" | "shear");
        for split in system.effects().filter(limited).filter_map(Effect::split) {
            split.visit_rest_lengths(&mut |i, j, rest| {
                links.push(Link { i, j, longest: rest * (1.0 + limit) });
            });
        }
        if order == SweepOrder::Shuffled {
            shuffle(&mut links);
        }
        Self { links, order, sweeps }
    }

    /// Moves positions; returns whether any spring was too long.
    pub fn apply(&self, system: &System, x: &mut [Vec3]) -> bool {
        let inverse_mass = |i: usize| if system.pinned()[i] { 0.0 } else { 1.0 / system.mass()[i] };
        let mut shorten = |&Link { i, j, longest }: &Link| {
            let d = x[i] - x[j];
            let length = d.norm();
            let (w_i, w_j) = (inverse_mass(i), inverse_mass(j));
            let moves = length > longest && w_i + w_j > 0.0;
            if moves {
                let excess = d * ((length - longest) / (length * (w_i + w_j)));
                x[i] -= excess * w_i;
                x[j] += excess * w_j;
            }
            moves
        };
        let mut moved = false;
        for sweep in 0..self.sweeps {
            let backward = match self.order {
                SweepOrder::Forward | SweepOrder::Shuffled => false,
                SweepOrder::Backward => true,
                SweepOrder::Alternating => sweep % 2 == 1,
            };
            let any = if backward {
                self.links.iter().rev().fold(false, |any, link| shorten(link) | any)
            } else {
                self.links.iter().fold(false, |any, link| shorten(link) | any)
            };
            if !any {
                break;
            }
            moved = true;
        }
        moved
    }
}

/// Fisher–Yates with a linear congruential generator (Knuth's MMIX constants) from a fixed seed.
fn shuffle(links: &mut [Link]) {
    let mut state: u64 = 1;
    for last in (1..links.len()).rev() {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        links.swap(last, ((state >> 33) % (last as u64 + 1)) as usize);
    }
}
