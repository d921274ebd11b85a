//! The sweeps that fill a matrix, in both layouts, against the reference form through a sink.

use super::diagonals::Diagonals;
use super::sweep::{Law, Pass, Springs, Windows};
use super::{COLLAPSED, pairs, tangent, tests};
use crate::effects::Spring;
use crate::{
    BlockSink, Level, Linearised, Mat3, State, StiffnessProduct, System, SystemSpec, Tangent, Vec3,
    parse,
};
use drape_kernels::blocks::{
    BandPlanes, BlockLayout, Coupling, SIX, SpringBlock, SpringBlocks, six,
};
use drape_kernels::testing::{Random, assert_same_bits};
use drape_kernels::vector::BLOCK;
use proptest::prelude::*;
use std::collections::HashMap;
use std::fmt::Write;

/// The reference form: blocks by their places, the lower particle first, or products with `w`.
struct Reference<'a> {
    blocks: HashMap<(usize, usize), Mat3>,
    product: Option<StiffnessProduct<'a>>,
}

impl BlockSink for Reference<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if let Some(StiffnessProduct { w, out }) = &mut self.product {
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

/// Memory of both layouts, filled with numbers that a sweep overwrites.
struct Memory {
    n: usize,
    offsets: Vec<usize>,
    stride: usize,
    lead: usize,
    planes: Vec<f64>,
    own: Vec<f64>,
    general: Vec<[f64; 6]>,
    springs: Vec<SpringBlock>,
    unit: f64,
    ends: Vec<[u32; 2]>,
    slots: Vec<u32>,
}

impl Memory {
    fn new(system: &System) -> Self {
        let n = system.len();
        let mut list = Vec::new();
        for effect in system.effects() {
            effect.visit_pairs(&mut |i, j| list.push([i.min(j) as u32, i.max(j) as u32]));
        }
        let mut order: Vec<usize> = (0..list.len()).collect();
        order.sort_by_key(|spring| list[*spring]);
        let ends = order.iter().map(|spring| list[*spring]).collect();
        let mut slots = vec![0; list.len()];
        (0..).zip(&order).for_each(|(slot, spring)| slots[*spring] = slot);
        let offsets = match system.coupling(with_jacobian(system)) {
            Coupling::Bands(offsets) => offsets,
            Coupling::Pairs | Coupling::Rows => vec![1],
        };
        let reach = *offsets.last().unwrap();
        let (stride, lead) = (n + 2 * reach + 16, reach + 3);
        let mut planes = vec![0.0; 6 * (offsets.len() + 1) * stride];
        planes.chunks_mut(stride).for_each(|plane| plane[lead..lead + n].fill(7.0));
        let (own, general) = (vec![7.0; n], vec![[7.0; 6]; n]);
        let springs = vec![[7.0; 4]; list.len()];
        let unit = 7.0;
        Self { n, offsets, stride, lead, planes, own, general, springs, unit, ends, slots }
    }

    /// The layout for an effect's springs.
    fn layout(&mut self, coupling: &Coupling) -> BlockLayout<'_> {
        let Self {
            offsets, stride, lead, planes, own, general, springs, unit, ends, slots, ..
        } = self;
        match coupling {
            Coupling::Bands(_) => {
                BlockLayout::Bands(BandPlanes { planes, stride: *stride, lead: *lead, offsets })
            }
            _ => BlockLayout::Pairs(SpringBlocks { own, general, springs, unit, ends, slots }),
        }
    }

    /// The numbers of the block of particles `i ≤ j` along bands.
    fn block(&self, i: usize, j: usize) -> Vec<f64> {
        let band = if i == j { 0 } else { 1 + self.offsets.binary_search(&(j - i)).unwrap() };
        (0..6).map(|c| self.planes[(6 * band + c) * self.stride + self.lead + i]).collect()
    }

    /// All blocks of the springs and masses, summed.
    fn summed(&self) -> HashMap<(usize, usize), Mat3> {
        assert!(self.general.is_empty());
        let mut sums = Reference { blocks: HashMap::new(), product: None };
        for (i, own) in self.own.iter().enumerate() {
            sums.blocks.insert((i, i), Mat3::from_diagonal_element(*own));
        }
        for (&[i, j], spring) in self.ends.iter().zip(&self.springs) {
            let [xx, xy, xz, yy, yz, zz] = six(*spring, self.unit);
            let block = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            sums.add_pair(i as usize, j as usize, &block);
        }
        sums.blocks
    }
}

/// The readable form of the block of a spring.
fn spring_block(s: &Spring, at: &Linearised<'_>, unit: f64, is_damped: bool) -> SpringBlock {
    let (i, j) = s.ends();
    let d = at.x[i] - at.x[j];
    let length = (d.x * d.x + d.y * d.y + d.z * d.z).sqrt();
    let far = length > COLLAPSED * s.rest_length;
    let (u, over) = if far { (d / length, s.rest_length / length) } else { (Vec3::zeros(), 0.0) };
    let across = match at.tangent {
        Tangent::Exact => 1.0 - over,
        Tangent::Projected => (1.0 - over).max(0.0),
    };
    let (stiffness, damping) = (at.stiffness_scale * s.stiffness, at.damping_scale * s.damping);
    let w = u * (stiffness * (1.0 / unit) * (1.0 - across)).sqrt();
    [w.x, w.y, w.z, stiffness * across + if is_damped { damping } else { 0.0 }]
}

fn with_jacobian(system: &System) -> impl Iterator<Item = &dyn crate::Effect> + Clone {
    system.effects().filter(|effect| effect.has_jacobian())
}

fn at<'a>(x: &'a [Vec3], tangent: Tangent) -> Linearised<'a> {
    Linearised { x, tangent, stiffness_scale: 0.3, damping_scale: 0.7 }
}

fn assert_same_matrix(system: &System, state: &State, tangent: Tangent) {
    let (n, coupling) = (state.len(), system.coupling(with_jacobian(system)));
    let mut reference = Reference { blocks: HashMap::new(), product: None };
    for (i, m) in system.mass().iter().enumerate() {
        reference.blocks.insert((i, i), Mat3::from_diagonal_element(*m));
    }
    for effect in with_jacobian(system) {
        effect.add_stiffness(&state.x, 0.3, tangent, &mut reference);
        effect.add_damping(state.level(), 0.7, &mut reference);
    }
    // Sums of listed springs begin with the present value, sums along bands with zero.
    let start = if coupling == Coupling::Pairs { state.x.clone() } else { vec![Vec3::zeros(); n] };
    let (mut expected, mut fast) = (start.clone(), start);
    let product = Some(StiffnessProduct { w: &state.v, out: &mut expected });
    let mut sink = Reference { blocks: HashMap::new(), product };
    with_jacobian(system).for_each(|e| e.add_stiffness(&state.x, 1.0, tangent, &mut sink));

    for with_product in [true, false] {
        let mut memory = Memory::new(system);
        let product = StiffnessProduct { w: &state.v, out: &mut fast };
        let product = with_product.then_some(product);
        let layout = memory.layout(&coupling);
        assert!(system.linearise(with_jacobian(system), &at(&state.x, tangent), layout, product));
        assert_same_bits("product", &expected, &fast);
        if coupling == Coupling::Pairs {
            let (mut slots, mut unit) = (memory.slots.iter(), None);
            for effect in with_jacobian(system) {
                let springs = pairs::listed(effect, system.mass()).unwrap();
                springs.list.each(|s| {
                    let unit = *unit.get_or_insert(0.3 * s.stiffness);
                    let is_damped = springs.law.is_damped();
                    let expected = spring_block(s, &at(&state.x, tangent), unit, is_damped);
                    let block = &memory.springs[*slots.next().unwrap() as usize];
                    assert_same_bits((s.i, s.j), &expected.to_vec(), &block.to_vec());
                });
            }
            let summed = memory.summed();
            for (place, block) in &reference.blocks {
                let distance = (block - summed[place]).norm();
                assert!(distance < 1e-12 * (1.0 + block.norm()), "{place:?}: {distance}");
            }
            continue;
        }
        for (&(i, j), block) in &reference.blocks {
            let expected: Vec<f64> = SIX.iter().map(|place| block[*place]).collect();
            assert_same_bits((i, j), &expected, &memory.block(i, j));
        }
        if let Coupling::Bands(offsets) = &coupling {
            for (i, o) in (0..memory.n).flat_map(|i| offsets.iter().map(move |o| (i, o))) {
                if !reference.blocks.contains_key(&(i, i + o)) {
                    assert_same_bits((i, o), &vec![0.0; 6], &memory.block(i, i + o));
                }
            }
        }
    }
}

fn sheet(rows: usize, columns: usize, damping: f64, law: &str) -> (System, State) {
    let law = format!(r#""damping": "{law}","#);
    tests::sheet(rows, columns, &tests::effects(damping), &law).build().unwrap()
}

/// Random moves and velocities: half of the springs compressed, one collapsed.
fn stir(state: &mut State, seed: u64) {
    let mut random = Random::new(seed);
    for (x, v) in state.x.iter_mut().zip(&mut state.v) {
        *x += 0.05 * random.vector();
        *v = random.vector();
    }
    state.x[1] = state.x[0];
}

/// Random springs of three effects between `n` particles, some pairs in several of them, the last
/// particle without one.
fn mesh(n: usize, count: usize, damping: f64, law: &str, random: &mut Random) -> (System, State) {
    let (system, mut state) = mesh_spec(n, count, damping, law, random).build().unwrap();
    state.v.iter_mut().for_each(|v| *v = random.vector());
    state.x[1] = state.x[0];
    (system, state)
}

fn mesh_spec(n: usize, count: usize, damping: f64, law: &str, random: &mut Random) -> SystemSpec {
    let mut springs = String::new();
    for k in 0..count {
        let i = random.below(n - 1);
        let j = (i + 1 + random.below(n - 2)) % (n - 1);
        let effect = ["tension", "shear", "bending"][3 * k / count];
        let (length, stiffness) = (1.2 + random.unit(), 3.0 + random.unit());
        let comma = if k > 0 { "," } else { "" };
        let damping = if effect == "shear" { 0.0 } else { damping * (1.5 + random.unit()) };
        write!(
            springs,
            r#"{comma}{{"effect": "{effect}", "i": {i}, "j": {j}, "rest_length_m": {length},
            "stiffness_n_per_m": {stiffness}, "damping_n_s_per_m": {damping}}}"#
        )
        .unwrap();
    }
    let mass: Vec<f64> = (0..n).map(|_| 2.0 + random.unit()).collect();
    let position: Vec<[f64; 3]> = (0..n).map(|_| random.vector().into()).collect();
    let text = format!(
        r#"{{"format": "drape-system/1", "damping": "{law}", "springs": [{springs}],
        "particles": {{"mass_kg": {mass:?}, "position_m": {position:?}}}}}"#
    );
    parse("m.json", &text).unwrap().spec().clone()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(50))]
    #[test]
    fn matrices_of_grids_are_the_reference(
        rows in 8_usize..40, columns in 8_usize..40, damped in any::<bool>(), seed in any::<u64>(),
    ) {
        let damping = if damped { 0.4 } else { 0.0 };
        let (system, mut state) = sheet(rows, columns, damping, "full");
        stir(&mut state, seed);
        for tangent in [Tangent::Exact, Tangent::Projected] {
            assert_same_matrix(&system, &state, tangent);
        }
    }

    #[test]
    fn matrices_of_meshes_are_the_reference(
        n in 4_usize..60, count in 6_usize..400, damped in any::<bool>(), seed in any::<u64>(),
    ) {
        let damping = if damped { 0.4 } else { 0.0 };
        let (system, state) = mesh(n, count, damping, "full", &mut Random::new(seed));
        prop_assume!(system.coupling(system.effects()) == Coupling::Pairs);
        for tangent in [Tangent::Exact, Tangent::Projected] {
            assert_same_matrix(&system, &state, tangent);
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
        assert_same_matrix(&system, &state, Tangent::Projected);
    }
}

#[test]
fn sheets_with_half_springs_at_the_border_give_the_same_bits() {
    for (rows, columns) in [(9, 12), (31, 140)] {
        let keys = r#""damping": "full","#;
        let mut spec = tests::sheet(rows, columns, &tests::effects(0.4), keys);
        let (last, columns) = (rows as u32 - 1, columns as u32);
        for s in &mut spec.springs {
            let is_border = |end: u32| [0, last].contains(&(end / columns));
            if is_border(s.i) && is_border(s.j) {
                s.stiffness_n_per_m *= 0.5;
                s.damping_n_s_per_m *= 0.5;
            }
        }
        let (system, mut state) = spec.build().unwrap();
        assert!(matches!(system.coupling(with_jacobian(&system)), Coupling::Bands(_)));
        stir(&mut state, 4);
        for tangent in [Tangent::Exact, Tangent::Projected] {
            assert_same_matrix(&system, &state, tangent);
        }
    }
}

#[test]
fn a_table_of_other_springs_is_refused_and_nothing_is_written() {
    let (system, state) = mesh(9, 40, 0.4, "full", &mut Random::new(5));
    let Memory { slots, .. } = Memory::new(&system);
    let mut swapped = slots.clone();
    let other = swapped.iter().position(|slot| *slot != swapped[0]).unwrap();
    swapped.swap(0, other);
    let longer: Vec<u32> = slots.iter().copied().chain([0]).collect();
    for wrong in [swapped, longer, slots[1..].to_vec(), vec![u32::MAX; slots.len()]] {
        let mut memory = Memory { slots: wrong, ..Memory::new(&system) };
        let mut out = state.x.clone();
        let layout = memory.layout(&Coupling::Pairs);
        let product = Some(StiffnessProduct { w: &state.v, out: &mut out });
        let at = at(&state.x, Tangent::Exact);
        assert!(!system.linearise(system.effects(), &at, layout, product));
        assert_eq!((out, memory.own), (state.x.clone(), vec![7.0; 9]));
        assert_eq!(memory.general, vec![[7.0; 6]; 9]);
        assert!(memory.springs.iter().flatten().all(|number| *number == 7.0));
    }
}

/// Twice the mass, stiffness and damping give twice the matrix, and so the same motion, to the last
/// bit, although blocks hold square roots.
#[test]
fn a_power_of_two_changes_no_digit_of_a_matrix_of_a_mesh() {
    for factor in [2.0, 0.125] {
        let [(once, unit), (scaled, scaled_unit)] = [1.0, factor].map(|factor| {
            let mut spec = mesh_spec(9, 40, 0.4, "full", &mut Random::new(5));
            spec.particles.mass_kg.iter_mut().for_each(|m| *m *= factor);
            for s in &mut spec.springs {
                s.stiffness_n_per_m *= factor;
                s.damping_n_s_per_m *= factor;
            }
            let (system, state) = spec.build().unwrap();
            let mut memory = Memory::new(&system);
            let layout = memory.layout(&Coupling::Pairs);
            assert!(system.linearise(
                system.effects(),
                &at(&state.x, Tangent::Exact),
                layout,
                None
            ));
            let own = memory.own.iter().map(|own| own / factor).collect::<Vec<_>>();
            let blocks = memory.springs.iter().map(|[x, y, z, a]| [*x, *y, *z, a / factor]);
            ((own, blocks.collect::<Vec<_>>()), memory.unit / factor)
        });
        assert_eq!((once, unit), (scaled, scaled_unit));
    }
}

#[test]
fn the_unit_is_the_first_stiffness_whose_inverse_is_a_number() {
    for (first, second, unit) in [(0.0, 2.0, 0.3 * 2.0), (1e-310, 2.0, 1.0), (0.0, 0.0, 1.0)] {
        let mut spec = mesh_spec(9, 40, 0.4, "full", &mut Random::new(5));
        spec.springs.iter_mut().for_each(|s| s.stiffness_n_per_m = second);
        spec.springs[0].stiffness_n_per_m = first;
        let (system, state) = spec.build().unwrap();
        let mut memory = Memory::new(&system);
        let layout = memory.layout(&Coupling::Pairs);
        assert!(system.linearise(system.effects(), &at(&state.x, Tangent::Exact), layout, None));
        assert_eq!(memory.unit, unit);
        assert!(memory.springs.iter().flatten().all(|number| number.is_finite()));
    }
}

/// No real vector has a square below zero.
#[test]
fn a_negative_factor_of_the_stiffness_is_refused_on_meshes() {
    let (system, state) = mesh(9, 40, 0.4, "full", &mut Random::new(5));
    let mut memory = Memory::new(&system);
    let at = Linearised { stiffness_scale: -0.3, ..at(&state.x, Tangent::Exact) };
    assert!(!system.linearise(system.effects(), &at, memory.layout(&Coupling::Pairs), None));
    assert!(memory.springs.iter().flatten().all(|number| *number == 7.0));
}

#[test]
fn the_layout_follows_the_springs() {
    let of_sheet = |rows, columns, law| {
        let (system, _) = sheet(rows, columns, 0.4, law);
        system.coupling(with_jacobian(&system))
    };
    assert_eq!(of_sheet(10, 9, "full"), Coupling::Bands(vec![1, 2, 8, 9, 10, 18]));
    assert_eq!(of_sheet(10, 9, "projected"), Coupling::Rows, "directions at each spring");
    assert_eq!(of_sheet(4, 4, "full"), Coupling::Pairs, "too few springs");
    assert_eq!(of_sheet(90, 3, "full"), Coupling::Rows, "2 is an offset of shear and of bending");
    let (system, _) = sheet(10, 9, 0.4, "full");
    assert_eq!(system.coupling(system.effects()), Coupling::Rows, "gravity has no blocks");
    for (law, coupling) in [("full", Coupling::Pairs), ("projected", Coupling::Rows)] {
        let (system, _) = mesh(9, 40, 0.4, law, &mut Random::new(5));
        assert_eq!(system.coupling(system.effects()), coupling);
    }
}

/// The matrix and the product of one band are those that the tests above compare with the
/// reference form.
#[test]
fn threads_change_no_bit() {
    // Above the size from which threads are used, with bands that end in the middle of a row, and
    // with offsets beyond a narrow window.
    for (rows, columns) in [(131, 137), (19, 900), (900, 19), (13, 2500)] {
        for (damping, law) in [(0.4, Law::DampedSpring), (0.0, Law::Spring)] {
            for tangent in [Tangent::Exact, Tangent::Projected] {
                assert_any_number_of_bands((rows, columns), (damping, law), tangent);
            }
        }
    }
}

fn assert_any_number_of_bands(
    (rows, columns): (i64, i64),
    (damping, law): (f64, Law),
    tangent: Tangent,
) {
    // Two particles at the end have no spring.
    let n = (rows * columns) as usize + 2;
    let mut random = Random::new(columns as u64);
    let (mut x, w, start) = (random.vectors(n), random.vectors(n), random.vectors(n));
    x[1] = x[0];
    let mass: Vec<f64> = (0..n).map(|_| 1.0 + random.unit()).collect();
    let kinds = tests::KINDS.map(|(_, stencil)| {
        Diagonals::detect(&tests::grid(rows, columns, stencil, damping)).unwrap()
    });
    let pass = |diagonals| Some(Pass::Springs(Springs { diagonals, law }));
    let passes = kinds.each_ref().map(pass);
    let mut offsets: Vec<usize> =
        kinds.iter().flat_map(|kind| &kind.list).map(|d| d.offset).collect();
    offsets.sort_unstable();
    let (stride, lead) = (n + 5020, 5003);
    let matrix = |threads, bands: Option<usize>, with_product: bool| {
        let windows = Windows::new(threads, kinds.iter());
        let mut out = start.clone();
        let mut planes = vec![0.0; 6 * (offsets.len() + 1) * stride];
        planes.chunks_mut(stride).for_each(|plane| plane[lead..lead + n].fill(7.0));
        // Twice: what a window remembers from before must not matter.
        for x in [&w, &x] {
            let most = n / ((2 * columns as usize).next_multiple_of(8) + BLOCK);
            let bands = bands.map_or_else(|| windows.bands(n), |bands| bands.min(most));
            let offsets = &offsets;
            let layout = BandPlanes { planes: &mut planes, stride, lead, offsets };
            let product = StiffnessProduct { w: &w, out: &mut out };
            let product = with_product.then_some(product);
            let at = at(x, tangent);
            tangent::add_in_bands(bands, &passes, &windows, &mass, &at, layout, product);
        }
        (planes, out)
    };
    let (planes, out) = matrix(1, Some(1), true);
    // These numbers of bands, short ones too, and the usual number.
    for (threads, bands) in [(2, Some(2)), (3, Some(3)), (2, Some(9)), (3, Some(25)), (5, None)] {
        let (other_planes, other_out) = matrix(threads, bands, true);
        let case = (rows, columns, law, tangent, threads, bands);
        assert_same_bits(("matrix", case), &planes, &other_planes);
        assert_same_bits(("product", case), &out, &other_out);
    }
    assert_same_bits("without a product", &planes, &matrix(2, Some(9), false).0);
}

/// A sweep for a matrix leaves forces in a window; the next sweep ignores them.
#[test]
fn forces_on_any_number_of_threads_do_not_remember_a_matrix() {
    let (mut system, mut state) = sheet(150, 150, 1.0, "full");
    stir(&mut state, 1);
    let (n, x) = (state.len(), &state.x);
    let forces = |system: &System| {
        let mut out = vec![Vec3::zeros(); n];
        system.forces(Level { t: 0.0, x, v: x }, &mut out);
        out
    };
    let expected = forces(&system);
    for threads in [1, 3, 8, 16, 32] {
        system.set_threads(std::num::NonZero::new(threads).unwrap());
        let coupling = system.coupling(with_jacobian(&system));
        let mut memory = Memory::new(&system);
        let (at, layout) = (at(x, Tangent::Exact), memory.layout(&coupling));
        assert!(system.linearise(with_jacobian(&system), &at, layout, None));
        assert_same_bits(threads, &expected, &forces(&system));
    }
}
