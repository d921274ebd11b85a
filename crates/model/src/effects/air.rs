//! The drag of the air on each triangle, at rest or in a wind.
//!
//! A triangle of area `a` with the unit normal `n` moves against the air with
//! `v_r = ⅓ (v_i + v_j + v_k) − w(t)`. The force
//!
//! ```text
//! f = −κ a (n·v_r) n          κ = c, or ½ ρ C |n·v_r|
//! ```
//!
//! goes to its corners in equal parts. It is a damping force `−D (v − w)`, whose matrix `D` is
//! symmetric and positive semi-definite. A method that takes the force at the new velocity keeps
//! `n`, `a`, `w` and the speed in `κ` at an earlier level, which makes the force linear. Without
//! wind the drag dissipates. An explicit step `h` is stable if `h Σ κ a/(3m) < 2` at every
//! particle, where `m` is its mass and the sum is over its triangles. The bound is sharp if
//! neighbours move alike along one normal.
//!
//! The code computes forces for four triangles at a time in vector registers, and adds them one
//! after another. The readable form, [`Air::add_reference`], gives the same bits. It also handles
//! groups of four in which a triangle has no normal.
//!
//! On 52 × 52 particles a triangle takes 9.5 ns, as long as 3.9 springs of a grid (AMD EPYC of family
//! 25, model 17). Four triangles take some 480 instructions in 140 cycles. Most of them read or
//! write memory: a triangle reads six vectors and adds to three, and checks each index. Springs of a
//! grid need no index.

use super::registry::{self, Checked, Weave};
use super::{BlockSink, Effect, EffectClass, EffectKind};
use crate::bounds::{MAX_COEFFICIENT, MAX_COORDINATE, coefficient, is_zero, vector, within};
use crate::error::Violation;
use crate::{Level, SystemSpec, Vec3};
use drape_kernels::lanes::{Four, four_wide, vectorised};
use drape_kernels::triples::{Triple, Triples, add_in_turn};
use drape_kernels::vector::SLOTS;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A triangle has no normal and no drag if its doubled area is at most this fraction of `l²`. Here
/// `l` is the longer edge from its first corner.
const DEGENERATE: f64 = 1e-12;
/// Sines that make up a gust.
const SINES: usize = 4;
/// Ratio of the frequencies of neighbouring sines: the golden ratio, so that the sum never repeats.
const RATIO: f64 = 1.618_033_988_749_895;

/// The air around a cloth: a drag on each of its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AirSpec {
    /// How the drag grows with the speed.
    pub drag: DragSpec,
    /// Motion of the air; at rest if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind: Option<WindSpec>,
}

/// How the drag of a triangle grows with the normal component of its speed relative to the air.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DragSpec {
    /// Force `½ ρ C a |n·v|²`, N.
    Quadratic {
        /// Drag coefficient `C`.
        #[schemars(range(min = 0.0, max = MAX_COORDINATE))]
        coefficient: f64,
        /// Density of the air `ρ`, kg/m³.
        #[serde(default = "density_of_air")]
        #[schemars(range(min = 0.0, max = MAX_COORDINATE))]
        density_kg_m3: f64,
    },
    /// Force `c a |n·v|`, N.
    Linear {
        /// Coefficient `c`, N s/m³.
        #[schemars(range(min = 0.0, max = MAX_COEFFICIENT))]
        coefficient_n_s_per_m3: f64,
    },
}

/// Density of dry air at 20 °C and 1013 hPa, rounded.
fn density_of_air() -> f64 {
    1.2
}

/// Motion of the air, the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindSpec {
    /// Mean velocity, m/s.
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub velocity_m_s: [f64; 3],
    /// Gusts; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gust: Option<GustSpec>,
}

/// Gusts: a sum of sines that looks irregular but is the same in every run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GustSpec {
    /// Bound on each component of the velocity of the gusts, m/s. The gusts approach it and never
    /// exceed it.
    #[schemars(inner(range(min = -MAX_COORDINATE, max = MAX_COORDINATE)))]
    pub amplitude_m_s: [f64; 3],
    /// Period of the slowest sine, s.
    #[schemars(range(min = SHORTEST_PERIOD, max = MAX_COORDINATE))]
    pub period_s: f64,
    /// Seed of the phases.
    #[serde(default)]
    #[schemars(range(max = u32::MAX))]
    pub seed: u32,
    /// Age of the gusts at the start, s; 0 if absent. A system that was frozen during a run
    /// continues its gusts from this age.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = MAX_GUST_START))]
    pub start_s: f64,
}

/// Shortest period of gusts, s.
const SHORTEST_PERIOD: f64 = 1e-6;
/// Greatest age of gusts at the start, s: a thousand of the longest runs in a row.
const MAX_GUST_START: f64 = 1e12;

impl AirSpec {
    fn check(&self) -> Result<(DragLaw, Option<Wind>), Violation> {
        let law = match self.drag {
            DragSpec::Quadratic { coefficient, density_kg_m3 } => {
                let path = "effects.air.drag.quadratic";
                let within = |key: &str, value| {
                    within(format_args!("{path}.{key}"), value, 0.0, MAX_COORDINATE)
                };
                let density = within("density_kg_m3", density_kg_m3)?;
                DragLaw::Quadratic(0.5 * density * within("coefficient", coefficient)?)
            }
            DragSpec::Linear { coefficient_n_s_per_m3: c } => {
                let path = "effects.air.drag.linear.coefficient_n_s_per_m3";
                DragLaw::Linear(coefficient(path, c)?)
            }
        };
        let gust = |gust: GustSpec| {
            let amplitude = vector("effects.air.wind.gust.amplitude_m_s", gust.amplitude_m_s)?;
            let path = "effects.air.wind.gust.period_s";
            let period = within(path, gust.period_s, SHORTEST_PERIOD, MAX_COORDINATE)?;
            let start = within("effects.air.wind.gust.start_s", gust.start_s, 0.0, MAX_GUST_START)?;
            Ok(Gust::new(amplitude, period, gust.seed).started(start))
        };
        let wind = |wind: WindSpec| {
            let velocity = vector("effects.air.wind.velocity_m_s", wind.velocity_m_s)?;
            Ok(Wind { velocity, gust: wind.gust.map(gust).transpose()? })
        };
        Ok((law, self.wind.map(wind).transpose()?))
    }
}

/// How the force grows with the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DragLaw {
    /// `κ = ½ ρ C |n·v_r|`; the number is `½ ρ C`, kg/m³.
    Quadratic(f64),
    /// `κ = c`, N s/m³.
    Linear(f64),
}

/// Velocity of the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// Mean, m/s.
    pub velocity: Vec3,
    /// Gusts; `None` for a steady wind.
    pub gust: Option<Gust>,
}

/// A smooth function of time that looks irregular: `A Σ_s (2^−s/W) sin(2π φ^s t/T + ψ_s)` over four
/// sines, `φ` the golden ratio, `W` the sum of the `2^−s`, and phases from a seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gust {
    /// `A`, m/s.
    amplitude: Vec3,
    /// Angular frequency of the slowest sine, rad/s.
    frequency: f64,
    phases: [f64; SINES],
    /// Age at time 0 of the state, s.
    start: f64,
    /// Period of the slowest sine, s, and the seed, as they were given.
    origin: (f64, u32),
}

impl Gust {
    /// A gust with the bound `amplitude` on its velocity (m/s) and the period of its slowest sine
    /// (s). The seed determines the phases.
    pub fn new(amplitude: Vec3, period: f64, seed: u32) -> Self {
        let mut state = u64::from(seed);
        // SplitMix64 (Steele, Lea and Flood 2014).
        let mut phase = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 * (std::f64::consts::TAU / (1_u64 << 53) as f64)
        };
        let phases = [(); SINES].map(|()| phase());
        let frequency = std::f64::consts::TAU / period;
        Self { amplitude, frequency, phases, start: 0.0, origin: (period, seed) }
    }

    /// The same gust with an age of `start` seconds at time 0 of the state.
    #[must_use]
    pub fn started(self, start: f64) -> Self {
        Self { start, ..self }
    }

    fn velocity(&self, t: f64) -> Vec3 {
        let t = self.start + t;
        let (mut sum, mut total) = (0.0, 0.0);
        let (mut weight, mut frequency) = (1.0, self.frequency);
        for phase in self.phases {
            sum += weight * libm::sin(frequency * t + phase);
            total += weight;
            weight *= 0.5;
            frequency *= RATIO;
        }
        self.amplitude * (sum / total)
    }
}

impl Wind {
    /// Velocity of the air at time `t` (s), m/s.
    pub fn at(&self, t: f64) -> Vec3 {
        self.gust.map_or(self.velocity, |gust| self.velocity + gust.velocity(t))
    }
}

/// Drag on the triangles of a cloth.
#[derive(Clone, Debug)]
pub struct Air {
    law: DragLaw,
    /// `None`: the air is at rest.
    wind: Option<Wind>,
    triangles: Vec<[u32; 3]>,
}

impl Wind {
    fn spec(&self) -> WindSpec {
        let gust = |gust: Gust| GustSpec {
            amplitude_m_s: gust.amplitude.into(),
            period_s: gust.origin.0,
            seed: gust.origin.1,
            start_s: gust.start,
        };
        WindSpec { velocity_m_s: self.velocity.into(), gust: self.gust.map(gust) }
    }
}

impl Air {
    /// Drag with this law and wind on `triangles`, which hold particle indices.
    pub fn new(law: DragLaw, wind: Option<Wind>, triangles: Vec<[u32; 3]>) -> Self {
        Self { law, wind, triangles }
    }

    fn wind(&self, t: f64) -> Vec3 {
        self.wind.map_or_else(Vec3::zeros, |wind| wind.at(t))
    }

    /// Visits the corners, `n` and `κ a` (N s/m) of each triangle that has a normal, at a level in
    /// the wind `w`.
    fn each(
        law: DragLaw,
        triangles: &[[u32; 3]],
        at: Level<'_>,
        w: Vec3,
        mut visit: impl FnMut([usize; 3], Vec3, f64),
    ) {
        for corners in triangles {
            let corners = corners.map(|i| i as usize);
            let [p, q, r] = corners.map(|i| at.x[i]);
            let (a, b) = (q - p, r - p);
            let normal = a.cross(&b);
            let doubled = normal.norm();
            let longest = a.norm_squared().max(b.norm_squared());
            // A NaN has no normal either.
            if doubled <= DEGENERATE * longest || doubled.is_nan() {
                continue;
            }
            let n = normal / doubled;
            let coefficient = match law {
                DragLaw::Linear(c) => c,
                DragLaw::Quadratic(density) => density * n.dot(&(mean(corners, at.v) - w)).abs(),
            };
            visit(corners, n, coefficient * (0.5 * doubled));
        }
    }

    /// Adds the lagged drag of some triangles, N, one after the other.
    fn add_reference(
        law: DragLaw,
        triangles: &[[u32; 3]],
        (lagged, v): (Level<'_>, &[Vec3]),
        w: Vec3,
        out: &mut [Vec3],
    ) {
        Self::each(law, triangles, lagged, w, |corners, n, drag| {
            let speed = n.dot(&(mean(corners, v) - w));
            let share = n * (drag * speed / 3.0);
            corners.into_iter().for_each(|i| out[i] -= share);
        });
    }
}

/// Squares of edges that are usual: no product of two leaves the range of numbers.
const USUAL: f64 = 1e150;

/// Adds the lagged drag of four triangles, one after the other; `false` where one of them has no
/// normal, and nothing is added.
#[inline(always)]
fn add_four<F: Four>(
    four: F,
    law: DragLaw,
    [a, b, c, d]: &[[u32; 3]; SLOTS],
    (lagged, v): (Level<'_>, &[Vec3]),
    w: Triple<F>,
    out: &mut [Vec3],
) -> bool {
    let corners = [
        [a[0] as usize, b[0] as usize, c[0] as usize, d[0] as usize],
        [a[1] as usize, b[1] as usize, c[1] as usize, d[1] as usize],
        [a[2] as usize, b[2] as usize, c[2] as usize, d[2] as usize],
    ];
    let from = four.gather(lagged.x, corners[0]);
    let one = four.minus(four.gather(lagged.x, corners[1]), from);
    let other = four.minus(four.gather(lagged.x, corners[2]), from);
    let normal = four.cross(one, other);
    let doubled = four.sqrt(four.dot(normal, normal));
    let squares = [four.dot(one, one), four.dot(other, other)];
    let longest = four.where_at_most(squares[0], squares[1], squares[1], squares[0]);
    let degenerate = four.mul(four.splat(DEGENERATE), longest);
    let (none, all) = (four.splat(0.0), four.splat(1.0));
    let usual = four.where_at_most(doubled, degenerate, none, all);
    // No NaN is at most a number.
    let usual = four.if_at_most(doubled, four.splat(USUAL), usual);
    if !four.are_ones(four.if_at_most(longest, four.splat(USUAL), usual)) {
        return false;
    }
    let n = four.over(normal, doubled);
    let speed = four.dot(n, four.minus(mean_of_four(four, corners, v), w));
    let coefficient = match law {
        DragLaw::Linear(c) => four.splat(c),
        DragLaw::Quadratic(density) => {
            let met = if std::ptr::eq(lagged.v, v) {
                speed
            } else {
                four.dot(n, four.minus(mean_of_four(four, corners, lagged.v), w))
            };
            four.mul(four.splat(density), four.abs(met))
        }
    };
    let drag = four.mul(coefficient, four.mul(four.splat(0.5), doubled));
    let size = four.div(four.mul(drag, speed), four.splat(3.0));
    let share = four.apart(four.times(n, four.neg(size)));
    add_in_turn(corners, &[share; 3], out);
    true
}

/// As [`mean`], for four triangles.
#[inline(always)]
fn mean_of_four<F: Four>(four: F, corners: [[usize; SLOTS]; 3], v: &[Vec3]) -> Triple<F> {
    let [i, j, k] = corners;
    let two = four.plus(four.gather(v, i), four.gather(v, j));
    four.over(four.plus(two, four.gather(v, k)), four.splat(3.0))
}

fn mean(corners: [usize; 3], v: &[Vec3]) -> Vec3 {
    let [i, j, k] = corners;
    (v[i] + v[j] + v[k]) / 3.0
}

impl Effect for Air {
    fn kind(&self) -> EffectKind {
        EffectKind::Air
    }

    /// 0: the air has no potential.
    fn energy(&self, _mass: &[f64], _x: &[Vec3]) -> f64 {
        0.0
    }

    fn add_force(&self, _mass: &[f64], _x: &[Vec3], _out: &mut [Vec3]) {}

    fn has_damping(&self) -> bool {
        true
    }

    fn is_drag(&self) -> bool {
        true
    }

    fn changes_with_time(&self) -> bool {
        self.wind.is_some_and(|wind| wind.gust.is_some())
    }

    fn medium_velocity(&self, t: f64) -> Vec3 {
        self.wind(t)
    }

    fn greatest_medium_speed(&self) -> f64 {
        let gust = |wind: Wind| wind.gust.map_or(0.0, |gust| gust.amplitude.norm());
        self.wind.map_or(0.0, |wind| wind.velocity.norm() + gust(wind))
    }

    fn add_damping_force(&self, at: Level<'_>, out: &mut [Vec3]) {
        self.add_lagged_damping_force(at, at.v, out);
    }

    fn add_lagged_damping_force(&self, lagged: Level<'_>, v: &[Vec3], out: &mut [Vec3]) {
        let Self { law, triangles, .. } = self;
        vectorised!(four_wide(), [four,
            law: DragLaw = *law,
            triangles: &'k [[u32; 3]] = triangles,
            lagged: Level<'k> = lagged,
            v: &'k [Vec3] = v,
            w: Vec3 = self.wind(lagged.t),
            out: &'k mut [Vec3] = out,
        ] -> () {
            let (groups, rest) = triangles.as_chunks();
            let (at, wind) = ((lagged, v), four.same(&w));
            for group in groups {
                if !add_four(four, law, group, at, wind, out) {
                    Air::add_reference(law, group, at, w, out);
                }
            }
            Air::add_reference(law, rest, at, w, out);
        });
    }

    fn has_jacobian(&self) -> bool {
        true
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        for [i, j, k] in self.triangles.iter().map(|t| t.map(|i| i as usize)) {
            visit(i, j);
            visit(j, k);
            visit(k, i);
        }
    }

    /// `κ a n nᵀ/9` for every pair of corners of a triangle, also for a corner with itself.
    fn add_damping(&self, lagged: Level<'_>, scale: f64, sink: &mut dyn BlockSink) {
        let w = self.wind(lagged.t);
        Self::each(self.law, &self.triangles, lagged, w, |corners, n, drag| {
            let ninth = n * n.transpose() * (scale * drag / 9.0);
            let [i, j, k] = corners;
            for (a, b) in [(i, j), (j, k), (k, i)] {
                sink.add_pair(a, b, &-ninth);
            }
            corners.into_iter().for_each(|i| sink.add_diagonal(i, &(ninth * 3.0)));
        });
    }

    fn scale_damping(&mut self, factor: f64) -> bool {
        match &mut self.law {
            DragLaw::Quadratic(coefficient) | DragLaw::Linear(coefficient) => {
                *coefficient *= factor
            }
        }
        true
    }

    fn describe(&self, spec: &mut SystemSpec) -> bool {
        let drag = match self.law {
            // `½ ρ C` with `ρ = 2`: the same bits.
            DragLaw::Quadratic(half) => {
                DragSpec::Quadratic { coefficient: half, density_kg_m3: 2.0 }
            }
            DragLaw::Linear(c) => DragSpec::Linear { coefficient_n_s_per_m3: c },
        };
        spec.effects.air = Some(AirSpec { drag, wind: self.wind.as_ref().map(Wind::spec) });
        spec.triangles.clone_from(&self.triangles);
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

/// The effect of the air.
pub(crate) struct Entry;

impl registry::Entry for Entry {
    type Value = AirSpec;
    const CLASS: EffectClass = EffectClass::Drag;

    fn freeze(
        law: &AirSpec,
        _kind: EffectKind,
        _cloth: Weave<'_>,
        spec: &mut SystemSpec,
    ) -> Result<(), Violation> {
        spec.effects.air = Some(*law);
        Ok(())
    }

    fn check(_kind: EffectKind, spec: &SystemSpec) -> Result<Option<Box<dyn Checked>>, Violation> {
        let Some(air) = spec.effects.air else { return Ok(None) };
        let (law, wind) = air.check()?;
        if spec.triangles.is_empty() {
            let expected = "a cloth with triangles, on which the air acts";
            return Err(Violation::new("effects.air", "given without triangles", expected));
        }
        Ok(Some(Box::new(Air::new(law, wind, spec.triangles.clone()))))
    }

    /// Continues the gusts.
    fn advance(spec: &mut SystemSpec, t: f64) {
        let wind = spec.effects.air.as_mut().and_then(|air| air.wind.as_mut());
        if let Some(gust) = wind.and_then(|wind| wind.gust.as_mut()) {
            gust.start_s = (gust.start_s + t).min(MAX_GUST_START);
        }
    }
}

impl Checked for Air {
    fn visit_particles(&mut self, visit: &mut dyn FnMut(&mut u32)) {
        self.triangles.iter_mut().flatten().for_each(visit);
    }

    fn assemble(self: Box<Self>) -> Box<dyn Effect> {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_kernels::testing::{Random, assert_same_bits};

    /// Triangles of every count, some without a normal, in a level that is that of the velocities
    /// or another one.
    #[test]
    fn four_triangles_at_a_time_give_the_bits_of_one_after_the_other() {
        let mut random = Random::new(3);
        for count in (0..12).chain([100]) {
            let n = 3 + 2 * count;
            let corner = |k: usize| [k, (k * 7 + 1) % n, (k * 3 + 2) % n].map(|i| i as u32);
            let triangles: Vec<_> = (0..count).map(corner).collect();
            let [mut x, v, before, start] = [(); 4].map(|()| random.vectors(n));
            for degenerate in 0..3 {
                match degenerate {
                    1 => x[triangles.first().map_or(0, |t| t[1] as usize)] = x[0],
                    2 => x[n / 2] = Vec3::repeat(f64::NAN),
                    _ => {}
                }
                for law in [DragLaw::Linear(0.7), DragLaw::Quadratic(0.6)] {
                    let wind = Wind { velocity: random.vector(), gust: None };
                    let air = Air::new(law, Some(wind), triangles.clone());
                    for lagged in [&v, &before] {
                        let level = Level { t: 0.0, x: &x, v: lagged };
                        let [mut slow, mut fast] = [(); 2].map(|()| start.clone());
                        let at = (level, &v[..]);
                        Air::add_reference(law, &triangles, at, wind.velocity, &mut slow);
                        air.add_lagged_damping_force(level, &v, &mut fast);
                        // Which NaN comes out of a sum is no part of the promise.
                        let plain = |f: &Vec3| f.map(|x| if x.is_nan() { 0.5 } else { x });
                        let [slow, fast] = [slow, fast].map(|all| all.iter().map(plain).collect());
                        let (slow, fast): (Vec<_>, Vec<_>) = (slow, fast);
                        assert_same_bits((count, degenerate, law), &slow, &fast);
                        assert!(count < 4 || slow != start);
                    }
                }
            }
        }
    }

    #[test]
    fn a_gust_is_smooth_bounded_seeded_and_has_no_mean() {
        let gust = |seed| Gust::new(Vec3::new(3.0, 0.0, -1.0), 2.0, seed);
        let at = |t: f64| gust(7).velocity(t);
        let mut sum = Vec3::zeros();
        let steps = 100_000;
        for step in 0..steps {
            let t = f64::from(step) * 0.01;
            let (v, next) = (at(t), at(t + 1e-4));
            assert!(v.x.abs() <= 3.0 && (v.z + v.x / 3.0).abs() < 1e-12, "{v:?}");
            // At most Σ weight · frequency: (1 + φ/2 + φ²/4 + φ³/8)/1.875 · 2π/2 s.
            assert!((next - v).norm() <= 1e-4 * v.norm().max(3.2) * 5.1, "{t}");
            sum += v;
        }
        assert!((sum / f64::from(steps)).norm() < 0.02, "{sum:?}");
        assert_eq!(gust(7), gust(7));
        assert!((0..10).all(|seed| gust(seed).velocity(0.3) != gust(seed + 1).velocity(0.3)));
    }

    /// Each sine is half as strong and φ times as fast as the one before.
    #[test]
    fn a_gust_is_the_sum_of_its_sines() {
        let gust = Gust::new(Vec3::new(3.0, 0.0, -1.0), 2.0, 7).started(0.4);
        for t in [0.0, 0.3, 2.0, 17.5] {
            let sine = |k: i32| {
                let angle = std::f64::consts::PI * RATIO.powi(k) * (t + 0.4);
                0.5_f64.powi(k) * (angle + gust.phases[k as usize]).sin()
            };
            let expected = gust.amplitude * ((0..4).map(sine).sum::<f64>() / 1.875);
            assert!((gust.velocity(t) - expected).norm() < 1e-12, "{t}");
        }
    }

    #[test]
    fn the_greatest_speed_of_the_air_is_that_of_the_wind_and_its_gusts() {
        let greatest =
            |wind| Air::new(DragLaw::Linear(1.0), wind, Vec::new()).greatest_medium_speed();
        let velocity = Vec3::new(3.0, 0.0, 4.0);
        let gust = Some(Gust::new(Vec3::new(0.0, 0.0, 2.0), 1.0, 0));
        assert_eq!(greatest(None), 0.0);
        assert_eq!(greatest(Some(Wind { velocity, gust: None })), 5.0);
        assert_eq!(greatest(Some(Wind { velocity, gust })), 7.0);
    }
}
