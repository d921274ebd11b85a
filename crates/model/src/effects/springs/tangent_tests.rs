//! Blocks and products of a sweep against the readable way through a sink, bit for bit.

use crate::{
    BlockPlanes, BlockSink, Linearised, Mat3, State, System, SystemSpec, Tangent, Vec3, parse,
};
use proptest::prelude::*;
use std::collections::HashMap;

/// The readable way: blocks by their places, and products of each with `w`.
struct Readable<'a> {
    blocks: HashMap<(usize, usize), Mat3>,
    product: Option<(&'a [Vec3], &'a mut [Vec3])>,
}

impl BlockSink for Readable<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if let Some((w, out)) = &mut self.product {
            let force = block * (w[i] - w[j]);
            out[i] += force;
            out[j] -= force;
            return;
        }
        *self.blocks.entry((i, j)).or_default() -= block;
        *self.blocks.entry((i, i)).or_default() += block;
        *self.blocks.entry((j, j)).or_default() += block;
    }

    fn add_general_pair(&mut self, _i: usize, _j: usize, _block: &Mat3) {
        unreachable!("the blocks of springs are symmetric");
    }

    fn add_diagonal(&mut self, _i: usize, _block: &Mat3) {
        unreachable!("the blocks of springs are those of pairs");
    }
}

fn bits(block: &Mat3) -> [u64; 6] {
    [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| block[place].to_bits())
}

fn assert_same_bits(system: &System, state: &State, tangent: Tangent) {
    let n = state.len();
    let effects = || system.effects().filter(|effect| effect.has_jacobian());
    let offsets = system.bands(effects()).unwrap();
    let (stride, lead) = (n + 2 * offsets.last().unwrap() + 16, offsets.last().unwrap() + 3);
    // What was there before is overwritten.
    let mut planes = vec![0.0; 6 * (offsets.len() + 1) * stride];
    planes.chunks_mut(stride).for_each(|plane| plane[lead..lead + n].fill(7.0));
    let at =
        Linearised { x: &state.x, tangent, stiffness_scale: 0.3, damping_scale: 0.7, w: &state.v };
    let (mut fast, mut expected) = (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
    let matrix = BlockPlanes { planes: &mut planes, stride, lead, offsets: &offsets };
    assert!(system.linearise(effects(), &at, matrix, &mut fast));

    let mut readable = Readable { blocks: HashMap::new(), product: None };
    for (i, m) in system.mass().iter().enumerate() {
        readable.blocks.insert((i, i), Mat3::from_diagonal_element(*m));
    }
    for effect in effects() {
        effect.add_stiffness(&state.x, 0.3, tangent, &mut readable);
        effect.add_damping(state.level(), 0.7, &mut readable);
    }
    let mut sink = Readable { blocks: HashMap::new(), product: Some((&state.v, &mut expected)) };
    effects().for_each(|effect| effect.add_stiffness(&state.x, 1.0, tangent, &mut sink));
    let of = |out: &[Vec3]| -> Vec<[u64; 3]> {
        out.iter().map(|v| [0, 1, 2].map(|k| v[k].to_bits())).collect()
    };
    assert_eq!(of(&fast), of(&expected));

    let six = |band: usize, i: usize| {
        [0, 1, 2, 3, 4, 5].map(|c| planes[(6 * band + c) * stride + lead + i].to_bits())
    };
    let band = |o: usize| offsets.iter().position(|offset| *offset == o).unwrap();
    for (&(i, j), block) in &readable.blocks {
        let band = if i == j { 0 } else { 1 + band(j - i) };
        assert_eq!(six(band, i), bits(block), "({i}, {j}) of {n}");
    }
    for (b, o) in offsets.iter().enumerate() {
        let empty = (0..n).filter(|i| !readable.blocks.contains_key(&(*i, i + o)));
        empty.for_each(|i| assert_eq!(six(b + 1, i), [0; 6], "({i}, {i} + {o})"));
    }
}

fn sheet(rows: usize, columns: usize, damping: f64, law: &str) -> (System, State) {
    let text = format!(
        r#"{{"format": "drape-scene/1", "name": "s",
        "cloth": {{"grid": {{"rows": {rows}, "columns": {columns}, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.4}}}},
        "effects": {{
            "tension": {{"stiffness_n_per_m": 9, "damping_n_s_per_m": {damping}}},
            "shear": {{"stiffness_n_per_m": 3, "damping_n_s_per_m": {damping}}},
            "bending": {{"stiffness_n_per_m": 1}},
            "gravity": {{"m_s2": [0, 0, -9.81]}}}},
        "damping": "{law}",
        "time": {{"step_s": 0.01, "duration_s": 1}}}}"#
    );
    let spec: SystemSpec = parse("s.json", &text).unwrap().spec().clone();
    spec.build().unwrap()
}

/// Moves and velocities that look random, half of the springs compressed, one collapsed.
fn stir(state: &mut State, seed: u64) {
    let mut number = seed | 1;
    let mut unit = || {
        number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (number >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    for (x, v) in state.x.iter_mut().zip(&mut state.v) {
        *x += 0.05 * Vec3::new(unit(), unit(), unit());
        *v = Vec3::new(unit(), unit(), unit());
    }
    state.x[1] = state.x[0];
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn blocks_and_products_of_grids_are_the_readable_ones(
        rows in 8_usize..40, columns in 8_usize..40, damped in any::<bool>(), seed in any::<u64>(),
    ) {
        let damping = if damped { 0.4 } else { 0.0 };
        let (system, mut state) = sheet(rows, columns, damping, "full");
        stir(&mut state, seed);
        for tangent in [Tangent::Exact, Tangent::Projected] {
            assert_same_bits(&system, &state, tangent);
        }
    }
}

#[test]
fn sheets_longer_than_a_window_and_wider_than_a_group_give_the_same_bits() {
    for (rows, columns) in [(70, 60), (9, 400), (400, 9), (31, 140)] {
        let (mut system, mut state) = sheet(rows, columns, 0.4, "full");
        stir(&mut state, 3);
        let mass: Vec<f64> = (0..state.len()).map(|i| 0.1 + (i % 7) as f64).collect();
        assert!(system.set_mass(&mass));
        assert_same_bits(&system, &state, Tangent::Projected);
    }
}

#[test]
fn what_cannot_be_swept_has_no_bands() {
    let bands = |rows, columns, law| {
        let (system, _) = sheet(rows, columns, 0.4, law);
        system.bands(system.effects().filter(|effect| effect.has_jacobian()))
    };
    assert_eq!(bands(10, 9, "full"), Some(vec![1, 2, 8, 9, 10, 18]));
    assert_eq!(bands(10, 9, "projected"), None, "directions at each spring");
    assert_eq!(bands(4, 4, "full"), None, "too few springs");
    assert_eq!(bands(90, 3, "full"), None, "2 is an offset of shear and of bending");
    let (system, _) = sheet(10, 9, 0.4, "full");
    assert_eq!(system.bands(system.effects()), None, "gravity has none");
}

/// What the sweep for a matrix remembers in a window is forgotten by the next one.
#[test]
fn forces_on_any_number_of_threads_do_not_remember_a_matrix() {
    let text = r#"{ "format": "drape-scene/1", "name": "s", "cloth": { "grid": { "rows": 150, "columns": 150,
        "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 1 } }, "effects": {
        "tension": { "stiffness_over_mass_per_s2": 1e4, "damping_over_mass_per_s": 1 },
        "shear": { "stiffness_over_mass_per_s2": 1e3 }, "bending": { "stiffness_over_mass_per_s2": 1e2 } },
        "time": { "step_s": 0.01, "duration_s": 1 } }"#;
    let (mut system, mut state) = parse("s", text).unwrap().spec().build().unwrap();
    for (i, x) in state.x.iter_mut().enumerate() {
        *x += Vec3::new((i as f64).sin(), (i as f64 * 1.7).cos(), (i as f64 * 0.3).sin()) * 0.01;
    }
    let (n, x) = (state.len(), &state.x);
    let forces = |system: &System| {
        let mut out = vec![Vec3::zeros(); n];
        system.forces(crate::Level { t: 0.0, x, v: x }, &mut out);
        out
    };
    let expected = forces(&system);
    for threads in [1, 3, 8, 16, 32] {
        system.set_threads(std::num::NonZero::new(threads).unwrap());
        let offsets = system.bands(system.effects()).unwrap();
        let reach = *offsets.last().unwrap();
        let (stride, lead) = (n + 2 * reach + 16, reach + 3);
        let mut planes = vec![0.0; 6 * (offsets.len() + 1) * stride];
        let matrix = BlockPlanes { planes: &mut planes, stride, lead, offsets: &offsets };
        let at = Linearised {
            x,
            tangent: Tangent::Exact,
            stiffness_scale: 0.3,
            damping_scale: 0.7,
            w: x,
        };
        assert!(system.linearise(system.effects(), &at, matrix, &mut vec![Vec3::zeros(); n]));
        assert!(forces(&system) == expected, "{threads} threads");
    }
}
