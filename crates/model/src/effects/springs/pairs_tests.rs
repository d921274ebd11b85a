//! Blocks and products of listed springs against the readable way through a sink, bit for bit.

use crate::{
    BlockSink, Linearised, Mat3, PairBlocks, State, System, SystemSpec, Tangent, Vec3, parse,
};
use proptest::prelude::*;
use std::collections::HashMap;
use std::fmt::Write;

/// The readable way: blocks by their places, the lower particle first, and products of each with `w`.
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
        *self.blocks.entry((i.min(j), i.max(j))).or_default() -= block;
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

/// A small generator of numbers between −1 and 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    fn below(&mut self, n: usize) -> usize {
        (((0.5 * self.next() + 0.5) * n as f64) as usize).min(n - 1)
    }
}

/// Random springs of three effects between `n` particles, some pairs in several of them, the last particle without one.
fn mesh(n: usize, count: usize, damping: f64, law: &str, numbers: &mut Numbers) -> (System, State) {
    let mut springs = String::new();
    for k in 0..count {
        let i = numbers.below(n - 1);
        let j = (i + 1 + numbers.below(n - 2)) % (n - 1);
        let effect = ["tension", "shear", "bending"][3 * k / count];
        let (length, stiffness) = (1.2 + numbers.next(), 3.0 + numbers.next());
        let comma = if k > 0 { "," } else { "" };
        let damping = if effect == "shear" { 0.0 } else { damping * (1.5 + numbers.next()) };
        write!(
            springs,
            r#"{comma}{{"effect": "{effect}", "i": {i}, "j": {j}, "rest_length_m": {length},
            "stiffness_n_per_m": {stiffness}, "damping_n_s_per_m": {damping}}}"#
        )
        .unwrap();
    }
    let mass: Vec<f64> = (0..n).map(|_| 2.0 + numbers.next()).collect();
    let position: Vec<[f64; 3]> = (0..n).map(|_| numbers.vector().into()).collect();
    let text = format!(
        r#"{{"format": "drape-system/1", "damping": "{law}", "springs": [{springs}],
        "particles": {{"mass_kg": {mass:?}, "position_m": {position:?}}}}}"#
    );
    let spec: SystemSpec = parse("m.json", &text).unwrap().spec().clone();
    let (system, mut state) = spec.build().unwrap();
    state.v.iter_mut().for_each(|v| *v = numbers.vector());
    state.x[1] = state.x[0];
    (system, state)
}

/// Coupled pairs, rising, and the table of the springs.
fn table(system: &System) -> (Vec<[u32; 2]>, Vec<u32>) {
    let mut list = Vec::new();
    for effect in system.effects() {
        effect.visit_pairs(&mut |i, j| list.push([i.min(j) as u32, i.max(j) as u32]));
    }
    let mut ends = list.clone();
    ends.sort_unstable();
    ends.dedup();
    let slots = list.iter().map(|pair| ends.binary_search(pair).unwrap() as u32).collect();
    (ends, slots)
}

fn line(block: &Mat3) -> [u64; 8] {
    [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (0, 1), (1, 1), (1, 2)]
        .map(|place| block[place].to_bits())
}

fn vector_bits(out: &[Vec3]) -> Vec<[u64; 3]> {
    out.iter().map(|v| [0, 1, 2].map(|k| v[k].to_bits())).collect()
}

fn assert_same_bits(system: &System, state: &State, tangent: Tangent) {
    let n = state.len();
    let (ends, slots) = table(system);
    // What was there before is overwritten in the matrix, and added to in the product.
    let (mut diagonal, mut pairs) = (vec![[7.0; 8]; n], vec![[7.0; 8]; ends.len()]);
    let (mut fast, mut expected) = (state.x.clone(), state.x.clone());
    let at =
        Linearised { x: &state.x, tangent, stiffness_scale: 0.3, damping_scale: 0.7, w: &state.v };
    let matrix =
        PairBlocks { diagonal: &mut diagonal, pairs: &mut pairs, ends: &ends, slots: &slots };
    assert!(system.linearise_listed(system.effects(), &at, matrix, &mut fast));

    let mut readable = Readable { blocks: HashMap::new(), product: None };
    for (i, m) in system.mass().iter().enumerate() {
        readable.blocks.insert((i, i), Mat3::from_diagonal_element(*m));
    }
    for effect in system.effects() {
        effect.add_stiffness(&state.x, 0.3, tangent, &mut readable);
        effect.add_damping(state.level(), 0.7, &mut readable);
    }
    let mut sink = Readable { blocks: HashMap::new(), product: Some((&state.v, &mut expected)) };
    system.effects().for_each(|effect| effect.add_stiffness(&state.x, 1.0, tangent, &mut sink));
    assert_eq!(vector_bits(&fast), vector_bits(&expected));
    for (i, diagonal) in diagonal.iter().enumerate() {
        assert_eq!(diagonal.map(f64::to_bits), line(&readable.blocks[&(i, i)]), "{i}");
    }
    for (&[i, j], pair) in ends.iter().zip(&pairs) {
        let block = &readable.blocks[&(i as usize, j as usize)];
        assert_eq!(pair.map(f64::to_bits), line(block), "({i}, {j})");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn blocks_and_products_of_meshes_are_the_readable_ones(
        n in 4_usize..60, count in 6_usize..400, damped in any::<bool>(), seed in any::<u64>(),
    ) {
        let damping = if damped { 0.4 } else { 0.0 };
        let (system, state) = mesh(n, count, damping, "full", &mut Numbers(seed));
        prop_assume!(system.are_listed(system.effects()));
        for tangent in [Tangent::Exact, Tangent::Projected] {
            assert_same_bits(&system, &state, tangent);
        }
    }
}

#[test]
fn a_table_of_other_springs_is_refused_and_nothing_is_written() {
    let (system, state) = mesh(9, 40, 0.4, "full", &mut Numbers(5));
    let (ends, slots) = table(&system);
    let mut swapped = slots.clone();
    let other = swapped.iter().position(|slot| *slot != swapped[0]).unwrap();
    swapped.swap(0, other);
    let longer: Vec<u32> = slots.iter().copied().chain([0]).collect();
    for wrong in [&swapped, &longer, &slots[1..].to_vec(), &vec![u32::MAX; slots.len()]] {
        let (mut diagonal, mut pairs) = (vec![[7.0; 8]; 9], vec![[7.0; 8]; ends.len()]);
        let mut out = state.x.clone();
        let (x, w, tangent) = (&state.x[..], &state.v[..], Tangent::Exact);
        let at = Linearised { x, tangent, stiffness_scale: 0.3, damping_scale: 0.7, w };
        let matrix =
            PairBlocks { diagonal: &mut diagonal, pairs: &mut pairs, ends: &ends, slots: wrong };
        assert!(!system.linearise_listed(system.effects(), &at, matrix, &mut out));
        assert_eq!((out, diagonal), (state.x.clone(), vec![[7.0; 8]; 9]));
        assert!(pairs.iter().flatten().all(|number| *number == 7.0));
    }
}

#[test]
fn directions_at_each_spring_are_no_listed_springs() {
    let are_listed = |law| {
        let (system, _) = mesh(9, 40, 0.4, law, &mut Numbers(5));
        system.are_listed(system.effects())
    };
    assert!(are_listed("full") && !are_listed("projected"));
}
