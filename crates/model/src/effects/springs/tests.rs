//! The fast kernels against the reference loops, bit for bit.

use super::*;
use crate::{Level, Part, System, SystemSpec};
use drape_kernels::testing::{Bits, Random, assert_same_bits};
use proptest::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

pub(super) const KINDS: [(EffectKind, [(i64, i64); 2]); 3] = [
    (EffectKind::Tension, [(1, 0), (0, 1)]),
    (EffectKind::Shear, [(1, 1), (-1, 1)]),
    (EffectKind::Bending, [(2, 0), (0, 2)]),
];

/// Springs of one kind on a grid, as scenes have them.
pub(super) fn grid(rows: i64, columns: i64, stencil: [(i64, i64); 2], damping: f64) -> Vec<Spring> {
    let mut springs = Vec::new();
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        for (right, down) in stencil {
            let (r, c) = (row + down, column + right);
            if (0..rows).contains(&r) && (0..columns).contains(&c) {
                springs.push(Spring {
                    i: (row * columns + column) as u32,
                    j: (r * columns + c) as u32,
                    rest_length: 0.3 * ((right * right + down * down) as f64).sqrt(),
                    stiffness: 7.3,
                    damping,
                });
            }
        }
    }
    springs
}

/// The effects that scenes have, with this damping, and gravity.
pub(super) fn effects(damping: f64) -> String {
    format!(
        r#""tension": {{ "stiffness_n_per_m": 9, "damping_n_s_per_m": {damping} }},
        "shear": {{ "stiffness_n_per_m": 3, "damping_n_s_per_m": {damping} }},
        "bending": {{ "stiffness_n_per_m": 1 }}, "gravity": {{ "m_s2": [0, 0, -9.81] }}"#
    )
}

/// A sheet of a square metre with these effects, and other keys of a scene.
pub(super) fn sheet(rows: usize, columns: usize, effects: &str, keys: &str) -> SystemSpec {
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "s", "cloth": {{ "grid": {{ "rows": {rows},
        "columns": {columns}, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.4 }} }},
        "effects": {{ {effects} }}, {keys} "time": {{ "step_s": 0.01, "duration_s": 1 }} }}"#
    );
    crate::parse("s.json", &text).unwrap().spec().clone()
}

/// Every kernel call of one effect against its reference form.
fn assert_same_forces(springs: &LinearSprings, n: usize) {
    let mut random = Random::new(n as u64);
    let (mut x, v, start) = (random.vectors(n), random.vectors(n), random.vectors(n));
    // A collapsed spring has no direction.
    x[1] = x[0];
    for far in [0.0, 1e200, f64::INFINITY] {
        // Absent springs between ends that are far apart have no energy.
        let mut x = x.clone();
        x[n / 2] *= 1.0 + far;
        let [fast, reference] = [springs.energy(&[], &x), springs.energy_reference(&x)];
        let is_same = fast.to_bits() == reference.to_bits();
        assert!(is_same || fast.is_nan() && reference.is_nan(), "{fast} {reference}, far {far}");
    }
    for law in Law::ALL {
        let (mut fast, mut reference) = (start.clone(), start.clone());
        springs.add(law, &x, &v, &mut fast);
        springs.add_reference(law, &x, &v, &mut reference);
        assert_same_bits(law, &reference, &fast);
        // Once more with a window that is in use.
        let taken = springs.memory.lock().unwrap();
        let mut contended = start.clone();
        springs.add(law, &x, &v, &mut contended);
        drop(taken);
        assert_same_bits((law, "contended"), &reference, &contended);
    }
}

#[test]
fn springs_of_grids_lie_along_diagonals_and_give_the_same_bits() {
    // Narrow, wide, longer than a window, and with a last group of every length.
    for (rows, columns) in [(8, 9), (20, 20), (3, 700), (700, 3), (52, 52), (33, 129), (31, 1100)] {
        for (kind, stencil) in KINDS {
            let list = grid(rows, columns, stencil, 0.2);
            let springs = LinearSprings::new(kind, list.clone(), DampingLaw::Full);
            assert!(matches!(springs.store, Store::Diagonals(_)), "{kind} {rows}×{columns}");
            let mut visited = Vec::new();
            springs.each(|s| visited.push(*s));
            assert_eq!(visited, list, "{kind} {rows}×{columns}");
            assert_same_forces(&springs, (rows * columns) as usize);
            for halved in [0, 5] {
                let mut list = list.clone();
                // The first spring of a diagonal is whole or half a spring.
                for spring in list.iter_mut().filter(|s| s.i % 7 == halved) {
                    (spring.stiffness, spring.damping) =
                        (0.5 * spring.stiffness, 0.5 * spring.damping);
                }
                let springs = LinearSprings::new(kind, list.clone(), DampingLaw::Full);
                assert!(matches!(springs.store, Store::Diagonals(_)), "{kind} {rows}×{columns}");
                let mut visited = Vec::new();
                springs.each(|s| visited.push(*s));
                assert_eq!(visited, list, "{kind} {rows}×{columns}, halves");
                assert_same_forces(&springs, (rows * columns) as usize);
            }
        }
    }
}

#[test]
fn other_springs_are_kept_one_by_one() {
    let (_, stencil) = KINDS[0];
    let regular = grid(20, 20, stencil, 0.2);
    let is_regular = |springs: Vec<Spring>| Diagonals::detect(&springs).is_some();
    assert!(is_regular(regular.clone()));
    assert!(is_regular(regular[..400].to_vec()));
    let edited = |edit: &dyn Fn(&mut Vec<Spring>)| {
        let mut springs = regular.clone();
        edit(&mut springs);
        is_regular(springs)
    };
    assert!(!edited(&|s| s.truncate(40)), "too few");
    assert!(!edited(&|s| s.swap(3, 4)), "another order at one particle");
    assert!(!edited(&|s| s.swap(3, 40)), "another order of particles");
    let edit_one = |factor: [f64; 2]| {
        edited(&|s| {
            s[17].stiffness *= factor[0];
            s[17].damping *= factor[1];
        })
    };
    assert!(edit_one([2.0, 2.0]) && edit_one([0.5, 0.5]), "twice or half a spring");
    assert!(!edit_one([4.0, 4.0]) && !edit_one([2.0, 1.0]) && !edit_one([1.0, 0.5]));
    assert!(!edited(&|s| s[17].rest_length *= 1.5), "a longer one");
    assert!(!edited(&|s| s[17].stiffness = 0.0), "a soft one");
    assert!(!edited(&|s| s[17].damping = 0.0), "an undamped one");
    assert!(!edited(&|s| (s[17].i, s[17].j) = (s[17].j, s[17].i)), "backwards");
    assert!(!edited(&|s| s.insert(17, s[17])), "a double one");
    assert!(!edited(&|s| s.retain(|s| s.i % 2 == 0)), "sparse");
    let (_, bending) = KINDS[2];
    assert!(is_regular(grid(4, 2500, bending, 0.2)));
    assert!(!is_regular(grid(4, 2501, bending, 0.2)), "ends too far apart for a window");
}

/// Both ends, rest length, stiffness, damping.
type Parameters = (u32, u32, f64, f64, f64);

fn mesh() -> impl Strategy<Value = (usize, Vec<Parameters>)> {
    (2_u32..90).prop_flat_map(|n| {
        let spring = (0..n, 0..n, 0.0..1.0, 0.0..9.0, 0.0..1.0);
        (Just(n as usize), prop::collection::vec(spring, 1..300))
    })
}

proptest! {
    #[test]
    fn springs_in_any_order_give_the_same_bits((n, springs) in mesh()) {
        let springs: Vec<_> = springs
            .into_iter()
            .filter(|s| s.0 != s.1)
            .map(|(i, j, rest_length, stiffness, damping)| {
                Spring { i, j, rest_length, stiffness, damping }
            })
            .collect();
        assert_same_forces(&LinearSprings::new(EffectKind::Tension, springs, DampingLaw::Full), n);
    }

    /// Any set of places along any diagonals, not of a grid only.
    #[test]
    fn springs_along_any_diagonals_give_the_same_bits(
        offsets in prop::collection::btree_set(1_usize..300, 1..5),
        n in 301_usize..900,
        seed in any::<u64>(),
    ) {
        let mut random = Random::new(seed);
        let mut springs = Vec::new();
        for i in 0..n {
            for &offset in offsets.iter().filter(|o| i + **o < n) {
                if random.unit() < 0.9 {
                    let (i, j) = (i as u32, (i + offset) as u32);
                    let rest_length = offset as f64;
                    springs.push(Spring { i, j, rest_length, stiffness: 2.0, damping: 0.1 });
                }
            }
        }
        assert_same_forces(&LinearSprings::new(EffectKind::Tension, springs, DampingLaw::Full), n);
    }
}

#[test]
fn effects_that_share_a_sweep_give_the_same_bits_as_one_after_the_other() {
    for (side, damping) in [(8, 0.3), (20, 0.3), (20, 0.0), (47, 0.3)] {
        let (system, state) = sheet(side, side, &effects(damping), "").build().unwrap();
        let mut random = Random::new(side as u64);
        let n = state.len();
        let (x, v) = (random.vectors(n), random.vectors(n));
        let [mut shared, mut apart, mut contended] = [(); 3].map(|()| vec![Vec3::zeros(); n]);
        system.forces(Level { t: 0.0, x: &x, v: &v }, &mut shared);
        for effect in system.effects() {
            let at = Level { t: 0.0, x: &x, v: &v };
            effect.add_part(Part::All, system.mass(), at, &mut apart);
        }
        assert_same_bits(side, &apart, &shared);
        // In another order, and part of them only.
        let start = random.vectors(n);
        (shared, apart, contended) = (start.clone(), start.clone(), contended);
        let effects: Vec<_> = system.effects().collect();
        let terms =
            [(1, Part::All), (2, Part::All), (3, Part::All), (0, Part::Force), (0, Part::Force)];
        system.add_forces(
            terms.iter().map(|&(e, p)| (effects[e], p)),
            Level { t: 0.0, x: &x, v: &v },
            &mut shared,
        );
        for (e, part) in terms {
            let at = Level { t: 0.0, x: &x, v: &v };
            effects[e].add_part(part, system.mass(), at, &mut apart);
        }
        assert_same_bits(side, &apart, &shared);
        // A copy of the system has windows of its own.
        let copy = system.clone();
        copy.forces(Level { t: 0.0, x: &x, v: &v }, &mut contended);
        system.forces(Level { t: 0.0, x: &x, v: &v }, &mut shared);
        assert_same_bits(side, &contended, &shared);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    // Above the size from which threads are used, with bands that end in the middle of a row.
    for (rows, columns) in [(131, 137), (19, 900), (13, 2500)] {
        assert_any_number_of_threads(rows, columns);
    }
}

fn assert_any_number_of_threads(rows: i64, columns: i64) {
    let n = (rows * columns) as usize;
    let mut random = Random::new(7);
    let (x, v, start) = (random.vectors(n), random.vectors(n), random.vectors(n));
    let kinds =
        KINDS.map(|(_, stencil)| Diagonals::detect(&grid(rows, columns, stencil, 0.2)).unwrap());
    let passes = kinds
        .each_ref()
        .map(|diagonals| Some(Pass::Springs(Springs { diagonals, law: Law::DampedSpring })));
    // These numbers of bands, short ones too, and the usual number.
    let sums = [(1, Some(1)), (2, Some(2)), (3, Some(3)), (2, Some(9)), (3, Some(25)), (5, None)];
    let sums = sums.map(|(threads, bands)| {
        let mut windows = Windows::new(threads, kinds.iter());
        let mut out = start.clone();
        // Twice: forces that a window remembers from before must not matter.
        for (x, v) in [(&v, &x), (&x, &v)] {
            let most = n / (2 * columns as usize).next_multiple_of(8);
            let bands = bands.map_or_else(|| windows.bands(n), |bands| bands.min(most));
            let (windows, begin) = (&mut windows, Begin::Present);
            sweep::add_in_bands(bands, &passes, windows, x, v, &mut out, begin, None);
        }
        out.bits()
    });
    for other in &sums[1..] {
        assert!(*other == sums[0]);
    }
}

#[test]
fn forces_that_are_written_do_not_depend_on_what_was_there() {
    for effects in [
        // Grids, springs in any order, effects that take no part in a sweep, and none at all.
        &effects(0.2)[..],
        r#""bending_hinge": { "stiffness_n_m": 1e-3 }"#,
        "",
    ] {
        let spec = sheet(7, 9, effects, "");
        for shuffle in [false, true] {
            let mut spec = spec.clone();
            // A particle without springs after the last that has any.
            spec.particles.mass_kg.push(0.1);
            spec.particles.position_m.push([5.0; 3]);
            if shuffle {
                spec.springs.reverse();
                let third = spec.springs.len() / 3;
                spec.springs.rotate_left(third);
            }
            let (system, state) = spec.build().unwrap();
            let mut random = Random::new(3);
            let x = random.vectors(state.len());
            let v = random.vectors(state.len());
            let at = Level { t: 0.0, x: &x, v: &v };
            let mut onto_zero = vec![Vec3::zeros(); state.len()];
            system.add_forces(system.effects().map(|e| (e, Part::All)), at, &mut onto_zero);
            let mut written = random.vectors(state.len());
            written[3] = Vec3::repeat(f64::NAN);
            system.forces(at, &mut written);
            assert_same_bits(effects, &onto_zero, &written);
            finish_once(&system, at, &onto_zero);
        }
    }
}

/// Every force is finished once, when it is complete. Returns in how many pieces.
fn finish_once(system: &System, at: Level<'_>, forces: &[Vec3]) -> u32 {
    let pieces = AtomicU32::new(0);
    let finished: Vec<_> = forces.iter().map(|_| AtomicU32::new(0)).collect();
    let mut out = vec![Vec3::repeat(f64::NAN); forces.len()];
    let terms = system.effects().map(|effect| (effect, Part::All));
    system.write_forces_and(terms, at, &mut out, &|particles, f| {
        pieces.fetch_add(1, Ordering::Relaxed);
        for (i, f) in particles.zip(f) {
            finished[i].fetch_add(1, Ordering::Relaxed);
            assert_same_bits(i, &forces[i], f);
            f.x += 1.0;
        }
    });
    assert!(finished.iter().all(|times| times.load(Ordering::Relaxed) == 1));
    assert!(out.iter().zip(forces).all(|(out, f)| out.x == f.x + 1.0));
    pieces.into_inner()
}

#[test]
fn forces_are_finished_once_on_any_number_of_threads() {
    // Without a field there may be a particle without springs behind all others; with a field it
    // would be a sweep of its own.
    let springs = r#""tension": { "stiffness_n_per_m": 9, "damping_n_s_per_m": 0.2 },
        "bending": { "stiffness_n_per_m": 1 }"#;
    let gravity = r#", "gravity": { "m_s2": [0, 0, -9.81] }"#;
    for (field, loose, listed) in
        [(gravity, false, false), ("", true, false), (gravity, true, false), ("", true, true)]
    {
        let mut spec = sheet(131, 137, &format!("{springs}{field}"), "");
        if loose {
            spec.particles.mass_kg.push(0.1);
            spec.particles.position_m.push([5.0; 3]);
        }
        if listed {
            spec.springs.reverse();
        }
        let (mut system, state) = spec.build().unwrap();
        let mut random = Random::new(9);
        let (x, v) = (random.vectors(state.len()), random.vectors(state.len()));
        let at = Level { t: 0.0, x: &x, v: &v };
        let mut forces = vec![Vec3::zeros(); state.len()];
        system.forces(at, &mut forces);
        for threads in [1, 2, 3, 7] {
            system.set_threads(std::num::NonZero::new(threads).unwrap());
            let pieces = finish_once(&system, at, &forces);
            let is_shared = !(listed || loose && field == gravity);
            assert!(pieces > if is_shared { 10 } else { 0 }, "{pieces} pieces");
            // The caller that finishes holds the memory of the sweep.
            let again = AtomicU32::new(0);
            let terms = || system.effects().map(|effect| (effect, Part::All));
            let mut out = forces.clone();
            system.write_forces_and(terms(), at, &mut out, &|_, _| {
                if again.fetch_add(1, Ordering::Relaxed) == 0 {
                    finish_once(&system, at, &forces);
                }
            });
            assert_same_bits("out", &forces, &out);
        }
    }
}

#[test]
fn parts_that_share_a_sweep_give_the_same_bits_as_one_after_the_other() {
    for law in ["full", "projected"] {
        let spec = sheet(7, 9, &effects(0.2), &format!(r#""damping": "{law}","#));
        for shuffle in [false, true] {
            let mut spec = spec.clone();
            if shuffle {
                spec.springs.reverse();
            }
            let (system, state) = spec.build().unwrap();
            let mut random = Random::new(5);
            let (x, v) = (random.vectors(state.len()), random.vectors(state.len()));
            let at = Level { t: 0.0, x: &x, v: &v };
            let add = |effect: &dyn Effect, part, out: &mut [Vec3]| match (part, effect.split()) {
                (Part::All, _) => effect.add_part(part, system.mass(), at, out),
                (Part::Damping, _) => effect.add_damping_force(at, out),
                (Part::Nonlinear, Some(split)) => split.add_nonlinear_force(&x, out),
                (Part::Linear, Some(split)) => split.add_linear_force(&x, out),
                (Part::LinearDamping, Some(split)) => split.add_linear_damping(&v, out),
                (Part::Linear | Part::LinearDamping, None) => {}
                (Part::Force, _) | (Part::Nonlinear, None) => {
                    effect.add_force(system.mass(), &x, out);
                }
            };
            let parts = [Part::Nonlinear, Part::Linear, Part::LinearDamping, Part::Damping];
            for part in parts.into_iter().chain([Part::Force, Part::All]) {
                let mut expected = vec![Vec3::zeros(); state.len()];
                system.effects().for_each(|effect| add(effect, part, &mut expected));
                let mut written = random.vectors(state.len());
                system.write_forces(system.effects().map(|e| (e, part)), at, &mut written);
                assert_same_bits((law, part, shuffle), &expected, &written);
            }
        }
    }
}

#[test]
fn the_list_of_pins_follows_what_is_pinned() {
    let (mut system, _) = pinned_sheet();
    let listed = |system: &crate::System| {
        let pinned = system.pinned().iter().enumerate().filter(|(_, pinned)| **pinned);
        let expected: Vec<u32> = pinned.map(|(i, _)| i as u32).collect();
        assert_eq!(system.pins(), expected);
        assert_eq!(system.clone().pins(), expected);
        expected.len()
    };
    assert_eq!(listed(&system), 2);
    for (particle, pinned, count) in
        [(40, true, 3), (3, true, 4), (3, true, 4), (40, false, 3), (0, false, 2), (0, false, 2)]
    {
        assert!(system.set_pinned(particle, pinned));
        assert_eq!(listed(&system), count);
    }
    assert!(!system.set_pinned(10_000, true));
    assert_eq!(listed(&system), 2);
}

fn pinned_sheet() -> (crate::System, crate::State) {
    let pins = r#""pins": [{ "row": 0, "column": 0 }, { "row": 6, "column": 8 }],"#;
    sheet(7, 9, "", pins).build().unwrap()
}

/// Of linear springs, in any state of stretch and far apart.
#[test]
fn discrete_gradients_do_the_work_of_the_energy_and_turns_are_derivatives() {
    let mut random = Random::new(9);
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let list = (0..8_u32).flat_map(|j| (0..j).map(move |i| (i, j)));
        let springs = list.map(|(i, j)| Spring {
            i,
            j,
            rest_length: 0.1 * f64::from(j),
            stiffness: 20.0,
            damping: 0.5,
        });
        let springs = LinearSprings::new(EffectKind::Tension, springs.collect(), law);
        let (from, to, v) = (random.vectors(8), random.vectors(8), random.vectors(8));
        let mut work = 0.0;
        springs.visit_discrete_gradients(&from, &to, &mut |i, j, g, slope| {
            let (d, new) = (from[i] - from[j], to[i] - to[j]);
            work -= g * (d + new).dot(&(new - d));
            let sum = d.norm() + new.norm();
            let rest = (0.5 - g / 20.0) * sum;
            assert!((slope - 20.0 * rest / (sum * sum)).abs() < 1e-12);
        });
        let change = springs.energy(&[], &to) - springs.energy(&[], &from);
        assert!((work + change).abs() < 1e-12 * springs.energy(&[], &from), "{work} {change}");

        let h = 1e-6;
        let damping = |by: f64| {
            let x: Vec<Vec3> = from.iter().zip(&to).map(|(x, w)| x + w * by).collect();
            let mut out = vec![Vec3::zeros(); 8];
            springs.add_damping_force(Level { t: 0.0, x: &x, v: &v }, &mut out);
            out
        };
        let mut turned = vec![Vec3::zeros(); 8];
        springs.add_damping_turn(Level { t: 0.0, x: &from, v: &v }, &to, &mut turned);
        assert_eq!(turned.iter().any(|f| *f != Vec3::zeros()), springs.has_damping_turn());
        let (ahead, behind) = (damping(h), damping(-h));
        for i in 0..8 {
            let expected = (ahead[i] - behind[i]) / (2.0 * h);
            assert!((turned[i] - expected).norm() < 1e-7 * (1.0 + expected.norm()), "{law:?}, {i}");
        }
    }
}

#[test]
fn projected_damping_of_broken_springs_has_the_bits_of_the_readable_form() {
    for (rows, columns) in [(1, 2), (2, 2), (3, 5), (9, 11)] {
        for (kind, stencil) in KINDS {
            let springs =
                LinearSprings::new(kind, grid(rows, columns, stencil, 0.4), DampingLaw::Projected);
            let n = (rows * columns) as usize;
            let mut random = Random::new(n as u64);
            let (mut x, v, start) = (random.vectors(n), random.vectors(n), random.vectors(n));
            for broken in [None, Some(Vec3::zeros()), Some(Vec3::repeat(f64::NAN))] {
                if let Some(shift) = broken {
                    x[n - 1] = x[0] + shift;
                }
                let [mut slow, mut fast] = [(); 2].map(|()| start.clone());
                springs.add_reference(Law::Projected, &x, &v, &mut slow);
                springs.add_damping_force(Level { t: 0.0, x: &x, v: &v }, &mut fast);
                assert_same_bits((kind, rows, columns), &slow, &fast);
            }
        }
    }
}
