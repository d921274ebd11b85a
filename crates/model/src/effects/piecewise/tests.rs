//! Curves of tension, and the forces that follow from them.

use super::buckling::polynomial;
use super::*;
use crate::SystemSpec;
use drape_kernels::lanes::Plain;
use drape_kernels::testing::{Random, assert_same_bits};
use proptest::prelude::*;

const REST: f64 = 0.3;

/// Compression slope 2, then 20 to 2 %, 200 to 5 %, 2000.
fn kawabata() -> TensionLaw {
    TensionLaw::new(2.0, Curve::new([(20.0, 0.02), (200.0, 0.05), (2000.0, f64::INFINITY)]))
}

/// Softer when stretched more.
fn softening() -> TensionLaw {
    TensionLaw::new(5.0, Curve::new([(100.0, 0.1), (1.0, f64::INFINITY)]))
}

/// Buckles at about 0.9 of its length.
fn buckled() -> TensionLaw {
    TensionLaw::new(50.0, Curve::new([(50.0, f64::INFINITY)]))
        .buckling(Buckling::new(50.0, 0.01, REST))
}

/// Pushes so hard once it buckles that it never does.
fn never_buckles() -> TensionLaw {
    TensionLaw::new(50.0, Curve::new([(50.0, f64::INFINITY)]))
        .buckling(Buckling::new(50.0, 1.0, REST))
}

fn laws() -> Vec<TensionLaw> {
    vec![kawabata(), softening(), buckled(), never_buckles()]
}

/// Random positions of a few particles, and springs between all of them.
fn net(seed: u64, law: DampingLaw) -> (PiecewiseSprings, Vec<Vec3>, Vec<Vec3>) {
    let mut random = Random::new(seed);
    let x: Vec<Vec3> = random.vectors(6).iter().map(|x| x * 0.25).collect();
    let v = random.vectors(6);
    let pairs = (0..6_u32).flat_map(|j| (0..j).map(move |i| (i, j)));
    let springs: Vec<_> = pairs
        .map(|(i, j)| Spring { i, j, rest_length: REST, stiffness: 0.0, damping: 0.3 })
        .collect();
    let law_of = (0..springs.len() as u32).map(|k| k % 4).collect();
    (PiecewiseSprings::new(EffectKind::Tension, springs, law_of, laws(), law), x, v)
}

#[derive(Default)]
struct Blocks(Vec<(usize, usize, Mat3)>);

impl BlockSink for Blocks {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.0.push((i, j, *block));
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        assert_eq!(*block, block.transpose());
        self.add_pair(i, j, block);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        assert!(*block == Mat3::zeros(), "springs act between particles, not on {i} alone");
    }
}

impl Blocks {
    /// `−K w`.
    fn force(&self, w: &[Vec3]) -> Vec<Vec3> {
        let mut out = vec![Vec3::zeros(); w.len()];
        for (i, j, block) in &self.0 {
            let f = block * (w[*i] - w[*j]);
            out[*i] -= f;
            out[*j] += f;
        }
        out
    }
}

fn force(springs: &PiecewiseSprings, x: &[Vec3]) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); x.len()];
    springs.add_force(&[], x, &mut out);
    out
}

fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>().sqrt()
}

fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

#[test]
fn a_curve_has_the_tensions_and_energies_that_its_pieces_add_up_to() {
    let law = kawabata();
    let at = |strain: f64| REST * (1.0 + strain);
    for (strain, tension) in [(-0.5, -0.3), (0.0, 0.0), (0.01, 0.06), (0.02, 0.12), (0.05, 1.92)] {
        assert!((law.tension(REST, at(strain)) - tension).abs() < 1e-12, "{strain}");
    }
    // Areas below the tension: triangles and trapezoids.
    for (strain, energy) in [(0.02, 0.00036), (0.05, 0.00954), (-0.5, 0.0225), (0.06, 0.0243)] {
        let found = law.energy(REST, at(strain));
        assert!((found - energy).abs() < 1e-12, "{strain}: {found}");
    }
    assert_eq!(law.slope(REST, at(0.03)), 200.0);
    assert_eq!(law.steepest(), 2000.0);
    assert_eq!(softening().steepest(), 100.0);
}

#[test]
fn tension_and_energy_are_continuous_and_vanish_at_the_rest_length() {
    for law in laws() {
        assert_eq!((law.tension(REST, REST), law.energy(REST, REST)), (0.0, 0.0));
        // The strip may buckle anywhere.
        for kink in (1..12_000).map(|k| 1e-4 * f64::from(k)) {
            let (below, above) = (REST * (kink - 1e-12), REST * (kink + 1e-12));
            let jump = |f: fn(&TensionLaw, f64, f64) -> f64| {
                (f(&law, REST, above) - f(&law, REST, below)).abs()
            };
            assert!(jump(TensionLaw::tension) < 1e-8, "{law:?} at {kink}");
            assert!(jump(TensionLaw::energy) < 1e-10, "{law:?} at {kink}");
        }
    }
}

/// `T = U'` and `T' = dT/dL`, and neither `T'` nor `T/L` is ever above the steepest slope.
#[test]
fn tension_is_the_slope_of_the_energy_and_the_steepest_slope_bounds_both_tangents() {
    for law in laws() {
        for k in 1..4000 {
            let length = REST * (k as f64 + 0.35) * 5e-4;
            let h = 1e-7;
            let slope = |f: fn(&TensionLaw, f64, f64) -> f64| {
                (f(&law, REST, length + h) - f(&law, REST, length - h)) / (2.0 * h)
            };
            let (tension, tangent) = (law.tension(REST, length), law.slope(REST, length));
            assert!((slope(TensionLaw::energy) - tension).abs() < 1e-6 * (1.0 + tension.abs()));
            assert!((slope(TensionLaw::tension) - tangent).abs() < 2e-3 * (1.0 + tangent));
            assert!(tangent >= 0.0 && tangent <= law.steepest());
            assert!(law.secant(REST, length) <= law.steepest());
        }
    }
}

/// The polynomial against the arc of a circle that it stands for, and a strip that is squeezed:
/// linear, then buckled.
#[test]
fn a_strip_buckles_as_an_arc_of_a_circle() {
    for k in 1..200 {
        let y = std::f64::consts::PI * f64::from(k) / 200.0; // half of the angle
        let sinc = libm::sin(y) / y;
        let exact = y * y / (libm::cos(y) - sinc);
        assert!((polynomial(sinc) - exact).abs() < 0.16, "{sinc}: {exact}");
    }
    let law = buckled();
    let load = 4.0 * 0.01 / (REST * REST);
    assert_eq!(law.tension(REST, 0.5 * REST), load * polynomial(0.5));
    assert_eq!(law.tension(REST, 0.99 * REST), 50.0 * (0.99 * REST - REST));
    assert_eq!(law.slope(REST, 0.99 * REST), 50.0);
    assert!(law.slope(REST, 0.5 * REST) < 50.0);
    assert_eq!(never_buckles().tension(REST, 0.1 * REST), 50.0 * (0.1 * REST - REST));
}

#[test]
fn forces_and_tangents_are_derivatives_of_the_energy_at_random_states() {
    let mut seen = 0;
    for seed in 0..40 {
        let (springs, x, w) = net(seed, DampingLaw::Full);
        let h = 1e-7;
        let shifted = |sign: f64| -> Vec<Vec3> {
            x.iter().zip(&w).map(|(x, w)| x + w * (sign * h)).collect()
        };
        let (ahead, behind) = (shifted(1.0), shifted(-1.0));
        let f = force(&springs, &x);
        let work = (springs.energy(&[], &behind) - springs.energy(&[], &ahead)) / (2.0 * h);
        assert!((dot(&f, &w) - work).abs() < 1e-6 * (1.0 + work.abs()), "{seed}: {work}");
        // Away from kinks: no slope changes on the way.
        let slopes = |x: &[Vec3]| {
            let mut list = Vec::new();
            springs.visit_slopes(x, &mut |_, _, k, _| list.push((k * 1e3).round()));
            list
        };
        if slopes(&ahead) != slopes(&behind) {
            continue;
        }
        seen += 1;
        let mut blocks = Blocks::default();
        springs.add_stiffness(&x, 2.0, Tangent::Exact, &mut blocks);
        let difference: Vec<Vec3> = force(&springs, &ahead)
            .iter()
            .zip(&force(&springs, &behind))
            .map(|(a, b)| (a - b) / h)
            .collect();
        let exact = blocks.force(&w);
        let size = dot(&exact, &exact).sqrt();
        assert!(distance(&exact, &difference) < 1e-5 * size, "{seed}");
        let mut projected = Blocks::default();
        springs.add_stiffness(&x, 1.0, Tangent::Projected, &mut projected);
        for (_, _, block) in &projected.0 {
            assert!(block.symmetric_eigenvalues().min() > -1e-9 * block.norm());
        }
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn forces_turn_and_move_with_the_cloth_and_conserve_both_momenta() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    for seed in 0..20 {
        let (springs, x, _) = net(seed, DampingLaw::Full);
        let moved: Vec<_> = x.iter().map(|x| turn * x + Vec3::new(1.0, -2.0, 0.5)).collect();
        let f = force(&springs, &x);
        let turned: Vec<_> = f.iter().map(|f| turn * f).collect();
        let scale = 1e-9 * dot(&f, &f).sqrt();
        assert!(distance(&force(&springs, &moved), &turned) < scale);
        assert!(f.iter().sum::<Vec3>().norm() < scale);
        let torque: Vec3 = x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum();
        assert!(torque.norm() < scale);
        let (here, there) = (springs.energy(&[], &x), springs.energy(&[], &moved));
        assert!((here - there).abs() < 1e-9 * here);
    }
}

/// `F1 + F2 = F` for the constant split, `−(T/L) d = F`, and the convex function that stands behind
/// the energy theorem.
#[test]
fn the_split_adds_up_and_its_majorant_is_convex() {
    for seed in 0..40 {
        let (springs, x, y) = net(seed, DampingLaw::Full);
        let f = force(&springs, &x);
        let mut sum = vec![Vec3::zeros(); x.len()];
        springs.add_nonlinear_force(&x, &mut sum);
        springs.add_linear_force(&x, &mut sum);
        assert!(distance(&f, &sum) < 1e-9 * (1.0 + dot(&f, &f).sqrt()));
        let mut secant = vec![Vec3::zeros(); x.len()];
        springs.visit_secants(&x, &mut |i, j, k| {
            let f = (x[i] - x[j]) * k;
            secant[i] -= f;
            secant[j] += f;
        });
        assert_eq!(f, secant);
        // ψ = ½ K |d|² − U is convex: (∇ψ(y) − ∇ψ(x))·(y − x) ≥ 0, and ∇ψ is F2.
        let y: Vec<_> = x.iter().zip(&y).map(|(x, y)| x + y * 0.2).collect();
        let gradient = |x: &[Vec3]| {
            let mut out = vec![Vec3::zeros(); x.len()];
            springs.add_nonlinear_force(x, &mut out);
            out
        };
        let way: Vec<_> = y.iter().zip(&x).map(|(y, x)| y - x).collect();
        let rise: Vec<_> = gradient(&y).iter().zip(&gradient(&x)).map(|(b, a)| b - a).collect();
        assert!(dot(&rise, &way) >= -1e-9, "{seed}");
        let (mut weights, mut slopes) = (Vec::new(), Vec::new());
        springs.visit_weights(&mut |i, j, k, c| weights.push((i, j, k, c)));
        springs.visit_slopes(&x, &mut |i, j, k, c| slopes.push((i, j, k, c)));
        for (a, b) in weights.iter().zip(&slopes) {
            assert!((a.0, a.1, a.3) == (b.0, b.1, b.3) && a.2 >= b.2);
        }
    }
}

#[test]
fn damping_is_that_of_linear_springs() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let (springs, x, v) = net(3, law);
        let linear = springs.majorant.clone();
        let zeros = vec![Vec3::zeros(); x.len()];
        let both = |add: &dyn Fn(&dyn Effect, &mut Vec<Vec3>)| {
            let (mut a, mut b) = (zeros.clone(), zeros.clone());
            add(&springs, &mut a);
            add(&linear, &mut b);
            assert_eq!(a, b, "{law:?}");
            a
        };
        let f = both(&|effect, out| effect.add_damping_force(Level { t: 0.0, x: &x, v: &v }, out));
        assert!(dot(&f, &v) < -0.1);
        both(&|effect, out| effect.split().unwrap().add_linear_damping(&v, out));
        both(&|effect, out| effect.split().unwrap().add_damping_remainder(&x, &v, out));
    }
}

#[test]
fn scaling_multiplies_energies_forces_and_slopes() {
    let (mut springs, x, _) = net(5, DampingLaw::Full);
    let (energy, f) = (springs.energy(&[], &x), force(&springs, &x));
    assert!(springs.scale_stiffness(4.0));
    assert_eq!(springs.energy(&[], &x), 4.0 * energy);
    assert_eq!(force(&springs, &x), f.iter().map(|f| f * 4.0).collect::<Vec<_>>());
    let mut steepest: f64 = 0.0;
    springs.visit_weights(&mut |_, _, k, _| steepest = steepest.max(k));
    assert_eq!(steepest, 8000.0);
}

#[test]
fn a_collapsed_spring_has_no_direction_and_no_force() {
    let law = kawabata();
    let spring = Spring { i: 0, j: 1, rest_length: REST, stiffness: 0.0, damping: 0.0 };
    let springs = PiecewiseSprings::new(
        EffectKind::Tension,
        vec![spring],
        vec![0],
        vec![law],
        DampingLaw::Full,
    );
    let x = [Vec3::zeros(); 2];
    assert_eq!(force(&springs, &x), [Vec3::zeros(); 2]);
    let mut out = [Vec3::zeros(); 2];
    springs.add_nonlinear_force(&x, &mut out);
    assert_eq!(out, [Vec3::zeros(); 2]);
    let mut blocks = Blocks::default();
    springs.add_stiffness(&x, 1.0, Tangent::Exact, &mut blocks);
    assert_eq!(blocks.0[0].2, Mat3::from_diagonal_element(2.0));
}

/// Particles in a row, every spring piecewise, of two kinds, in an order that makes the system
/// renumber them.
fn scattered(n: u32) -> SystemSpec {
    let key = |k: u32| ((k * k * 31 + k * 7919) % 10_007, k);
    let mut row: Vec<u32> = (0..n).collect();
    row.sort_by_key(|k| key(*k));
    let mut place = vec![0; n as usize];
    for (at, &k) in row.iter().enumerate() {
        place[k as usize] = at;
    }
    let springs: Vec<_> = row
        .windows(2)
        .enumerate()
        .map(|(k, ends)| {
            let soft = if k % 3 == 0 { 10.0 } else { 20.0 };
            format!(
                r#"{{ "effect": "tension", "i": {}, "j": {}, "rest_length_m": 0.9,
                    "stiffness_n_per_m": {soft},
                "pieces": [{{ "up_to_strain": 0.05, "stiffness_n_per_m": {soft} }},
                    {{ "stiffness_n_per_m": 300 }}] }}"#,
                ends[1], ends[0]
            )
        })
        .collect();
    let position: Vec<_> = place.iter().map(|at| format!("[{at}, 0, 0]")).collect();
    let text = format!(
        r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [{}], "position_m": [{}] }},
            "springs": [{}] }}"#,
        vec!["1"; n as usize].join(","),
        position.join(","),
        springs.join(",")
    );
    crate::parse("scattered", &text).unwrap().spec().clone()
}

#[test]
fn renumbering_carries_the_laws_along() {
    let spec = scattered(2000);
    let (system, state) = spec.build().unwrap();
    let (ordered, moved, numbering) = spec.build_ordered().unwrap();
    assert!(!numbering.is_identity());
    let forces = |system: &crate::System, state: &crate::State| {
        let mut out = vec![Vec3::zeros(); state.len()];
        system.forces(state.level(), &mut out);
        out
    };
    let (given, internal) = (forces(&system, &state), forces(&ordered, &moved));
    assert!(distance(&given, &numbering.restore_list(&internal)) < 1e-9);
    assert!(dot(&given, &given) > 1.0);
}

proptest! {
    #[test]
    fn any_curve_rises_and_starts_from_nothing(
        compression in 0.0..10.0_f64,
        pieces in prop::collection::vec((0.0..100.0_f64, 1e-3..0.5_f64), 1..6),
        length in 0.0..3.0_f64,
    ) {
        let mut strain = 0.0;
        let end = |(k, width): &(f64, f64)| { strain += width; (*k, strain) };
        let curve: Vec<_> = pieces.iter().map(end).collect();
        let law = TensionLaw::new(compression, Curve::new(curve));
        let (t, k) = (law.tension(1.0, length), law.steepest());
        prop_assert!(law.energy(1.0, length) >= 0.0);
        prop_assert!(t * (length - 1.0) >= 0.0);
        prop_assert!(t.abs() <= k * (length - 1.0).abs() * (1.0 + 1e-12));
        prop_assert!(law.tension(1.0, length + 0.01) >= t - 1e-12);
    }
}

/// The work of the mean forces on the way is exactly `−ΔU`, whatever the way: short or long, on one
/// piece or across kinks. `g'` is the derivative of `g`, and at no distance the forces are those of
/// the place.
#[test]
fn discrete_gradients_do_the_work_of_the_energy() {
    for (seed, way) in (0..30).flat_map(|seed| [1e-12, 1e-6, 0.01, 1.0].map(|w| (seed, w))) {
        let (springs, x, w) = net(seed, DampingLaw::Full);
        let end = |by: f64| -> Vec<Vec3> { x.iter().zip(&w).map(|(x, w)| x + w * by).collect() };
        let to = end(way);
        let (mut work, mut size) = (0.0, 0.0);
        springs.visit_discrete_gradients(&x, &to, &mut |i, j, g, _| {
            let (d, new) = (x[i] - x[j], to[i] - to[j]);
            let part = -g * (d + new).dot(&(new - d));
            (work, size) = (work + part, size + part.abs());
        });
        let change = springs.energy(&[], &to) - springs.energy(&[], &x);
        let bound = 1e-12 * size + 1e-13 * springs.energy(&[], &x);
        assert!((work + change).abs() < bound, "{seed}, {way}: {work:e} {change:e}");
        // By differences of lengths, away from kinks.
        let (ahead, behind) = (end(way + 1e-6), end(way - 1e-6));
        let list = |to: &[Vec3]| {
            let mut list = Vec::new();
            springs.visit_discrete_gradients(&x, to, &mut |_, _, g, slope| list.push((g, slope)));
            list
        };
        let lengths = |to: &[Vec3]| {
            let mut list = Vec::new();
            springs.each(to, |s| list.push((s.length, s.slope())));
            list
        };
        let ([a, b], [la, lb]) =
            ([&ahead, &behind].map(|to| list(to)), [lengths(&ahead), lengths(&behind)]);
        for (k, (_, slope)) in list(&to).into_iter().enumerate() {
            let ((longer, k_longer), (shorter, k_shorter)) = (la[k], lb[k]);
            let difference = longer - shorter;
            if way >= 0.01 && k_longer == k_shorter && difference.abs() > 1e-7 {
                let found = (a[k].0 - b[k].0) / difference;
                assert!((found - slope).abs() < 1e-3 * (1.0 + slope.abs()), "{seed}, {way}, {k}");
            }
        }
    }
    let (springs, x, _) = net(1, DampingLaw::Full);
    let mut mean = Vec::new();
    springs.visit_discrete_gradients(&x, &x, &mut |_, _, g, _| mean.push(2.0 * g));
    let mut k = 0;
    springs.visit_secants(&x, &mut |_, _, secant| {
        assert!((secant - mean[k]).abs() < 1e-12 * (1.0 + secant.abs()));
        k += 1;
    });
}

/// Curves of different lengths side by side, stretched, pressed and collapsed; those that buckle
/// take the readable form.
#[test]
fn four_curves_at_a_time_give_the_bits_of_one_after_the_other() {
    let mut random = Random::new(4);
    for count in (0..9).chain([64, 65, 131]) {
        for kinds in [2, 4] {
            let n = count + 4;
            let springs: Vec<_> = (0..count)
                .map(|k| Spring {
                    i: k as u32,
                    j: ((k * 5 + 3) % n) as u32,
                    rest_length: REST,
                    stiffness: 0.0,
                    damping: 0.1,
                })
                .filter(|spring| spring.i != spring.j)
                .collect();
            let law_of = (0..springs.len() as u32).map(|k| k % kinds).collect();
            let law = DampingLaw::Full;
            let all = PiecewiseSprings::new(EffectKind::Tension, springs, law_of, laws(), law);
            let mut x: Vec<Vec3> = random.vectors(n).iter().map(|x| x * 0.25).collect();
            let start = random.vectors(n);
            for round in 0..2 {
                for is_remainder in [false, true] {
                    let [mut slow, mut fast] = [(); 2].map(|()| start.clone());
                    let kernel = Bent { all: &all, is_remainder, x: &x };
                    let each = |visit: &mut dyn FnMut(&Spring)| all.majorant.each(visit);
                    quartets::add_reference(each, &kernel, &mut slow);
                    all.add(is_remainder, &x, &mut fast);
                    assert_same_bits((count, kinds, round), &slow, &fast);
                }
                x[n / 2] = x[0];
            }
        }
    }
}

/// Curves without buckling are taken four at a time.
#[test]
fn only_springs_that_buckle_take_the_readable_form() {
    let quartet =
        Quartet { ends: [[0, 1, 2, 3], [1, 2, 3, 0]], rest: [REST; 4], stiffness: [1.0; 4] };
    let x = Random::new(1).vectors(4);
    for (law_of, is_fast) in [([0, 1, 0, 1], true), ([0, 1, 2, 1], false)] {
        let springs = (0..4).map(|i| Spring {
            i,
            j: (i + 1) % 4,
            rest_length: REST,
            stiffness: 0.0,
            damping: 0.0,
        });
        let (springs, law) = (springs.collect(), DampingLaw::Full);
        let all = PiecewiseSprings::new(EffectKind::Tension, springs, law_of.to_vec(), laws(), law);
        let kernel = Bent { all: &all, is_remainder: false, x: &x };
        assert_eq!(kernel.four(Plain, &quartet, 0).is_some(), is_fast);
    }
}
