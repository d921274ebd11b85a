use super::*;
use crate::{ObstacleSpec, PinSpec, SceneFile, SystemSpec, Vec3, parse};
use drape_kernels::testing::Random;
use proptest::prelude::*;

fn spring(i: u32, j: u32) -> Spring {
    Spring { i, j, rest_length: 1.0, stiffness: 1.0, damping: 0.0 }
}

/// A sheet with tension, shear and bending springs, rows first.
fn sheet(rows: u32, columns: u32) -> SystemSpec {
    let text = format!(
        r#"{{ "format": "drape-scene/1", "name": "sheet", "cloth": {{ "grid": {{ "rows": {rows},
            "columns": {columns},
        "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 1, "velocity_m_s": [0, 0, 1] }} }},
        "effects": {{ "tension": {{ "stiffness_n_per_m": 9 }},
            "shear": {{ "stiffness_n_per_m": 5 }},
        "bending": {{ "stiffness_n_per_m": 1, "damping_n_s_per_m": 0.1 }},
            "gravity": {{ "m_s2": [0, 0, -1] }} }},
        "pins": [{{ "row": 0, "column": 0 }}], "time": {{ "step_s": 0.1, "duration_s": 1 }} }}"#
    );
    match parse("sheet", &text).unwrap() {
        SceneFile::Scene(_, spec) | SceneFile::System(spec) => spec,
    }
}

/// A permutation without a pattern, the same on every machine.
fn permutation(n: usize, seed: u64) -> Vec<u32> {
    let mut list: Vec<u32> = (0..n as u32).collect();
    let mut random = Random::new(seed);
    for last in (1..n).rev() {
        list.swap(last, random.below(last + 1));
    }
    list
}

/// Particle `i` becomes `new[i]`; the springs are shuffled too.
fn shuffled(spec: &SystemSpec, new: &[u32]) -> SystemSpec {
    let mut out = spec.clone();
    for (i, &k) in new.iter().enumerate() {
        let (k, particles) = (k as usize, &mut out.particles);
        particles.mass_kg[k] = spec.particles.mass_kg[i];
        particles.position_m[k] = spec.particles.position_m[i];
        particles.velocity_m_s[k] = spec.particles.velocity_m_s[i];
    }
    let order = permutation(spec.springs.len(), 7);
    for (slot, &k) in out.springs.iter_mut().zip(&order) {
        *slot = spec.springs[k as usize].clone();
        (slot.i, slot.j) = (new[slot.i as usize], new[slot.j as usize]);
    }
    out.pins.iter_mut().for_each(|pin| pin.particle = new[pin.particle as usize]);
    out.triangles.iter_mut().flatten().for_each(|i| *i = new[*i as usize]);
    out
}

/// Mean `|i − j|` of the springs that a system runs with.
fn span(system: &crate::System) -> f64 {
    let mut edges = Vec::new();
    for effect in system.effects() {
        effect.visit_pairs(&mut |i, j| edges.push([i as u32, j as u32]));
    }
    mean_span(edges.into_iter())
}

/// Numbers these springs and checks that the result is a permutation both ways.
fn choose(n: usize, edges: impl Iterator<Item = (u32, u32)>) -> (Numbering, Vec<Spring>) {
    let mut springs: Vec<_> = edges.map(|(i, j)| spring(i, j)).collect();
    let numbering = Numbering::choose(n, &mut [Strands { springs: &mut springs, law_of: None }]);
    let identity: Vec<usize> = (0..n).collect();
    let there: Vec<usize> = numbering.apply(&identity);
    assert_eq!(*numbering.restore_list(&there), identity);
    assert!((0..n).all(|i| numbering.internal(numbering.given(i)) == i));
    let mut sorted = there;
    sorted.sort_unstable();
    assert_eq!(sorted, identity);
    (numbering, springs)
}

#[test]
fn grids_in_their_natural_order_and_small_systems_are_left_alone() {
    for (rows, columns) in [(40, 40), (2, 2000), (2000, 2), (5, 500), (1, 3000), (31, 33)] {
        let spec = sheet(rows, columns);
        let transposed: Vec<u32> =
            (0..rows * columns).map(|i| i % columns * rows + i / columns).collect();
        let mut by_columns = shuffled(&spec, &transposed);
        by_columns.springs.sort_by_key(|s| (s.i.min(s.j), s.i.max(s.j)));
        for (is_scene, spec) in [(true, spec), (false, by_columns)] {
            let (system, state) = spec.build().unwrap();
            let (ordered, start, numbering) = spec.build_ordered().unwrap();
            assert!(numbering.is_identity(), "{rows} × {columns}");
            assert_eq!(start, state);
            // Column by column shear springs may come in another order at a particle.
            let is_same = effects(&ordered) == effects(&system);
            assert!(is_same || !is_scene, "{rows} × {columns}");
        }
    }
    let small = sheet(30, 30);
    let spec = shuffled(&small, &permutation(900, 1));
    assert!(spec.build_ordered().unwrap().2.is_identity());
}

fn effects(system: &crate::System) -> String {
    format!("{:?}", system.effects().collect::<Vec<_>>())
}

/// The list by particle and not by effect, warp before weft, the far end first, and in disorder.
#[test]
fn a_grid_whose_springs_are_listed_in_another_order_runs_as_the_scene() {
    for (rows, columns) in [(20, 20), (40, 52), (52, 40)] {
        let scene = sheet(rows, columns);
        let [mut by_particle, mut by_direction, mut turned] = [(); 3].map(|()| scene.clone());
        by_particle.springs.sort_by_key(|s| s.i);
        by_direction.springs.sort_by_key(|s| (s.i.abs_diff(s.j), s.i));
        for s in turned.springs.iter_mut().step_by(3) {
            (s.i, s.j) = (s.j, s.i);
        }
        let same: Vec<u32> = (0..rows * columns).collect();
        let disorder = shuffled(&scene, &same);
        assert_ne!(by_particle.springs, scene.springs);
        let (expected, state, _) = scene.build_ordered().unwrap();
        assert_eq!(
            effects(&expected).matches("Diagonals(Diagonals").count(),
            3,
            "the scene is a grid"
        );
        for (name, spec) in [
            ("by particle", by_particle),
            ("by direction", by_direction),
            ("turned", turned),
            ("in disorder", disorder),
        ] {
            let (system, start, numbering) = spec.build_ordered().unwrap();
            assert!(numbering.is_identity() && start == state, "{name}");
            assert!(effects(&system) == effects(&expected), "{name}, {rows} × {columns}");
        }
    }
}

#[test]
fn a_shuffled_sheet_gets_springs_about_as_short_as_row_by_row() {
    for (rows, columns) in [(40, 40), (100, 100), (60, 300), (300, 60), (4, 1000)] {
        let spec = sheet(rows, columns);
        let shuffled = shuffled(&spec, &permutation((rows * columns) as usize, 3));
        let (system, _, numbering) = shuffled.build_ordered().unwrap();
        assert!(!numbering.is_identity());
        let short = f64::from(rows.min(columns));
        assert!(span(&system) <= 1.5 * short, "{rows} × {columns}: {}", span(&system));
        let (given, _) = shuffled.build().unwrap();
        assert!(span(&given) > 0.3 * f64::from(rows * columns));
        let mut last = (0, 0);
        system.effects().next().unwrap().visit_pairs(&mut |i, j| {
            assert!(i < j && last < (i, j), "springs are sorted");
            last = (i, j);
        });
    }
}

#[test]
fn everything_follows_its_particle() {
    let spec = sheet(50, 40);
    let mut spec = shuffled(&spec, &permutation(2000, 5));
    for (i, particle) in spec.particles.mass_kg.iter_mut().enumerate() {
        *particle = 1.0 + i as f64;
        spec.particles.velocity_m_s[i] = [i as f64, 0.0, 1.0];
    }
    spec.pins = vec![PinSpec::still(17), PinSpec::still(1999)];
    spec.obstacles = vec![ObstacleSpec::sphere([0.0; 3], 1.0, 0.0)];
    let (given, state) = spec.build().unwrap();
    let (system, start, numbering) = spec.build_ordered().unwrap();
    assert!(!numbering.is_identity());
    assert_eq!(*numbering.restore(&start), state);
    assert_eq!(&*numbering.restore_list(system.mass()), given.mass());
    assert_eq!(&*numbering.restore_list(system.pinned()), given.pinned());
    assert!(system.pinned()[numbering.internal(17)] && given.pinned()[17]);
    assert_eq!(system.obstacles(), given.obstacles());
    let forces = |system: &crate::System, state: &State| {
        let mut out = vec![Vec3::zeros(); 2000];
        system.forces(state.level(), &mut out);
        out
    };
    let (wanted, found) = (forces(&given, &state), forces(&system, &start));
    for (a, b) in wanted.iter().zip(numbering.restore_list(&found).iter()) {
        assert!((a - b).norm() <= 1e-12 * (1.0 + a.norm()), "{a:?} {b:?}");
    }
}

#[test]
fn springs_that_alone_are_shuffled_are_sorted() {
    let mut spec = sheet(40, 50);
    let natural = spec.build().unwrap().0;
    let springs = spec.springs.clone();
    for (slot, k) in spec.springs.iter_mut().zip(permutation(springs.len(), 2)) {
        *slot = springs[k as usize].clone();
    }
    let (system, _, numbering) = spec.build_ordered().unwrap();
    assert!(numbering.is_identity());
    let pairs = |system: &crate::System| {
        let mut pairs = Vec::new();
        for effect in system.effects() {
            let from = pairs.len();
            effect.visit_pairs(&mut |i, j| pairs.push([i.min(j), i.max(j)]));
            pairs[from..].sort_unstable();
        }
        pairs
    };
    assert_eq!(pairs(&system), pairs(&natural));
    system.effects().next().unwrap().visit_pairs(&mut |i, j| assert!(i < j));
    let mut last = 0;
    system.effects().next().unwrap().visit_pairs(&mut |i, _| {
        assert!(last <= i);
        last = i;
    });
}

#[test]
fn paths_stars_components_and_lone_particles_are_numbered() {
    let n = 5000_u32;
    let new = permutation(n as usize, 9);
    let (numbering, springs) =
        choose(n as usize, (1..n).map(|i| (new[i as usize - 1], new[i as usize])));
    assert!(!numbering.is_identity());
    assert!(springs.iter().all(|s| s.j == s.i + 1), "a path becomes 0, 1, 2, …");
    // No order of a star's rim is better than another.
    let (numbering, springs) = choose(n as usize, (1..n).map(|i| (0, i)));
    assert!(numbering.is_identity() && springs[0] == spring(0, 1));
    // Every other particle lies on one of two paths, the rest has no spring.
    let edges = (1..n / 4).flat_map(|k| {
        let at = |k: u32| new[2 * k as usize];
        [(at(k - 1), at(k)), (at(n / 4 + k - 1), at(n / 4 + k))]
    });
    let (numbering, springs) = choose(n as usize, edges);
    assert!(!numbering.is_identity());
    assert!(springs.iter().all(|s| s.j == s.i + 1));
    // No spring at all, and none that could become shorter.
    assert!(choose(n as usize, std::iter::empty()).0.is_identity());
}

#[test]
fn a_violation_names_the_index_of_the_specification() {
    let mut spec = shuffled(&sheet(40, 40), &permutation(1600, 4));
    spec.springs[77].stiffness_n_per_m = -1.0;
    let violation = spec.build_ordered().unwrap_err();
    assert_eq!(violation.path, "springs[77].stiffness_n_per_m");
    assert_eq!(violation, spec.build().unwrap_err());
    spec.particles.position_m[1234][1] = f64::NAN;
    assert_eq!(spec.build_ordered().unwrap_err().path, "particles.position_m[1234][1]");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn any_springs_give_a_permutation_with_the_same_springs(
        n in 1000_usize..1500,
        ends in prop::collection::vec((0_u32..1000, 1_u32..1000), 0..3000),
        is_local in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let new = permutation(n, seed);
        let edges: Vec<_> = ends.iter().filter_map(|&(i, k)| {
            let j = if is_local { i + 1 + k % 3 } else { k };
            (i != j && (j as usize) < n).then(|| (new[i as usize], new[j as usize]))
        }).collect();
        let (numbering, springs) = choose(n, edges.iter().copied());
        let pair = |i: u32, j: u32| [i.min(j), i.max(j)];
        let mut before: Vec<_> = edges.iter().map(|&(i, j)| pair(i, j)).collect();
        let given = |i: u32| numbering.given(i as usize) as u32;
        let mut after: Vec<_> = springs.iter().map(|s| pair(given(s.i), given(s.j))).collect();
        before.sort_unstable();
        after.sort_unstable();
        prop_assert_eq!(before, after);
        let after = mean_span(springs.iter().map(|s| [s.i, s.j]));
        let before = mean_span(edges.iter().map(|&(i, j)| [i, j]));
        prop_assert!(numbering.is_identity() || GAIN * after <= before);
    }
}
