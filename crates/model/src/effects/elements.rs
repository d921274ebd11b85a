//! Effects that sum an energy over many small elements. Angles and hinges share this code.
//!
//! A sweep takes four elements at a time in vector registers and adds their forces one after
//! another, in the order of the list. It computes each number in the order of operations of the
//! readable form, [`Element::add_force`], so both give the same bits. If one of four elements is
//! unusual, such as one without an angle, the sweep takes the readable form for all four.

use super::registry::Checked;
use super::{BlockSink, Effect, EffectKind, Tangent};
use crate::bounds::{coefficient, index, within};
use crate::error::Violation;
use crate::{Mat3, SystemSpec, Vec3};
use drape_kernels::lanes::{Four, Lanes, Plain, Wide, four_wide};
use drape_kernels::vector::SLOTS;
use pulp::{Simd, WithSimd};
use std::fmt::Debug;

/// Most particles of an element.
const MOST: usize = 4;

/// An energy `½ K (θ − θ₀)²` of a few particles, as a frozen system lists it.
pub(crate) trait Element: Copy + Debug + Send + Sync + 'static {
    /// Name of the list in a frozen system.
    const LIST: &'static str;
    /// Least and greatest angle at rest, rad.
    const REST: (f64, f64);

    /// The list in a frozen system.
    fn list(spec: &SystemSpec) -> &[Self];
    /// The same list, to be extended.
    fn list_mut(spec: &mut SystemSpec) -> &mut Vec<Self>;
    fn kind(&self) -> EffectKind;
    /// Its particles, each with its key.
    fn particles(&mut self) -> impl Iterator<Item = (&'static str, &mut u32)>;
    /// `θ₀`, rad.
    fn rest(&self) -> f64;
    /// `K`, N m.
    fn stiffness(&mut self) -> &mut f64;
    /// The energy at `x`, J; `None` where the angle is not defined.
    fn energy(&self, x: &[Vec3]) -> Option<f64>;
    /// Adds the force at `x`, N.
    fn add_force(&self, x: &[Vec3], out: &mut [Vec3]);
    /// As [`add_force`](Self::add_force) for four elements, one after the other; `false` where one
    /// of them is unusual, and nothing is added.
    fn add_forces<F: Four>(four: F, group: &[Self; SLOTS], x: &[Vec3], out: &mut [Vec3]) -> bool;
    /// The four energies at `x`, J; `None` where an element is unusual.
    fn energies<F: Four>(four: F, group: &[Self; SLOTS], x: &[Vec3]) -> Option<Lanes>;
    /// Its angle with its particles at `x`, in the order of [`particles`](Self::particles); `None`
    /// where the angle has no gradient.
    fn turn(&self, x: &[Vec3; 4]) -> Option<Turn>;
    /// Visits all pairs of its particles.
    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize));
    /// Adds `scale · (−∂f/∂x)`, N/m.
    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink);
    /// As [`add_stiffness`](Self::add_stiffness) for four elements, one after the other; `false`
    /// where one of them is unusual or there is no such form, and nothing is added.
    fn add_stiffnesses<F: Four>(
        _four: F,
        _group: &[Self; SLOTS],
        _x: &[Vec3],
        _scale: f64,
        _tangent: Tangent,
        _sink: &mut dyn BlockSink,
    ) -> bool {
        false
    }

    /// Force on the particle at a place, N, and its diagonal block of `−∂f/∂x`, N/m,
    /// [projected](Tangent::Projected), of an element whose particles are `0..` in their order.
    fn local(&self, place: usize, x: &[Vec3; MOST]) -> (Vec3, Mat3) {
        whole(self, place, x)
    }
}

/// As [`Element::local`], from all forces and blocks of the element.
pub(super) fn whole<E: Element>(element: &E, place: usize, x: &[Vec3; MOST]) -> (Vec3, Mat3) {
    let mut force = [Vec3::zeros(); MOST];
    element.add_force(x, &mut force);
    let mut sink = OneBlock { place, block: Mat3::zeros() };
    element.add_stiffness(x, 1.0, Tangent::Projected, &mut sink);
    (force[place], sink.block)
}

/// How far an angle of three or four particles is from its angle at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// `θ − θ₀`, rad.
    pub excess: f64,
    /// `∇θ` for each of the particles, 1/m; 0 beyond the last.
    pub gradient: [Vec3; 4],
    /// Stiffness `K`, N m.
    pub stiffness: f64,
}

/// The angles of an effect, one by one. Methods use it that treat each angle as a constraint, or
/// that move one particle at a time.
pub trait Stencils {
    /// Calls `visit` with the indices of the three or four particles of each angle. The position of
    /// a call in this sequence is the angle's place.
    fn visit(&self, visit: &mut dyn FnMut(&[u32]));

    /// The angle at this place in the order of [`visit`](Self::visit), with its particles at `x`,
    /// m. If the angle has three particles, the fourth position is ignored. `None` if the angle has
    /// no gradient.
    fn turn(&self, place: usize, x: &[Vec3; 4]) -> Option<Turn>;

    /// Force, N, of the angle at this place in the order of [`visit`](Self::visit) on one of its
    /// particles, and that particle's diagonal block of `−∂f/∂x`, N/m,
    /// [projected](Tangent::Projected). `x` holds the positions of all particles, m.
    fn local(&self, place: usize, particle: usize, x: &[Vec3]) -> (Vec3, Mat3);
}

/// All elements of one kind.
#[derive(Clone, Debug)]
pub struct Elements<E> {
    kind: EffectKind,
    list: Vec<E>,
}

impl<E> Elements<E> {
    /// The elements in `list`, as an effect of this kind. Their values must be in range.
    pub fn new(kind: EffectKind, list: Vec<E>) -> Self {
        Self { kind, list }
    }
}

/// Checks the elements of one kind in a frozen system.
pub(super) fn check<E: Element>(
    kind: EffectKind,
    spec: &SystemSpec,
) -> Result<Option<Box<dyn Checked>>, Violation> {
    let mut list: Vec<E> = Vec::new();
    for (position, element) in E::list(spec).iter().enumerate() {
        if element.kind() != kind {
            continue;
        }
        let mut element = *element;
        let path = format!("{}[{position}]", E::LIST);
        let mut before: Vec<(&str, u32)> = Vec::new();
        for (key, particle) in element.particles() {
            index(format_args!("{path}.{key}"), *particle, spec.particles.mass_kg.len())?;
            if let Some((other, _)) = before.iter().find(|(_, other)| other == particle) {
                let expected = format!("another particle than `{other}`, which is {particle}");
                return Err(Violation::new(format!("{path}.{key}"), particle, expected));
            }
            before.push((key, *particle));
        }
        within(format_args!("{path}.rest_rad"), element.rest(), E::REST.0, E::REST.1)?;
        coefficient(format_args!("{path}.stiffness_n_m"), *element.stiffness())?;
        list.push(element);
    }
    Ok((!list.is_empty()).then(|| Box::new(Elements { kind, list }) as Box<dyn Checked>))
}

impl<E: Element> Checked for Elements<E> {
    fn visit_particles(&mut self, visit: &mut dyn FnMut(&mut u32)) {
        for element in &mut self.list {
            element.particles().for_each(|(_, particle)| visit(particle));
        }
    }

    fn assemble(self: Box<Self>) -> Box<dyn Effect> {
        self
    }
}

impl<E: Element> Effect for Elements<E> {
    fn kind(&self) -> EffectKind {
        self.kind
    }

    fn energy(&self, _mass: &[f64], x: &[Vec3]) -> f64 {
        four_wide().dispatch(Energy { list: &self.list, x })
    }

    fn add_force(&self, _mass: &[f64], x: &[Vec3], out: &mut [Vec3]) {
        four_wide().dispatch(Forces { list: &self.list, x, out });
    }

    fn has_jacobian(&self) -> bool {
        true
    }

    fn visit_pairs(&self, visit: &mut dyn FnMut(usize, usize)) {
        self.list.iter().for_each(|element| element.visit_pairs(visit));
    }

    fn add_stiffness(&self, x: &[Vec3], scale: f64, tangent: Tangent, sink: &mut dyn BlockSink) {
        four_wide().dispatch(Stiffness { list: &self.list, x, scale, tangent, sink });
    }

    fn stencils(&self) -> Option<&dyn Stencils> {
        Some(self)
    }

    fn scale_stiffness(&mut self, factor: f64) -> bool {
        self.list.iter_mut().for_each(|element| *element.stiffness() *= factor);
        true
    }

    fn describe(&self, spec: &mut SystemSpec) -> bool {
        E::list_mut(spec).extend_from_slice(&self.list);
        true
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

/// Adds the forces of all elements.
struct Forces<'a, E> {
    list: &'a [E],
    x: &'a [Vec3],
    out: &'a mut [Vec3],
}

impl<E: Element> Forces<'_, E> {
    fn reference(self) {
        self.list.iter().for_each(|element| element.add_force(self.x, self.out));
    }

    #[inline(always)]
    fn fast<F: Four>(self, four: F) {
        let Self { list, x, out } = self;
        let (groups, rest) = list.as_chunks();
        for group in groups {
            if !E::add_forces(four, group, x, out) {
                Forces { list: group, x, out }.reference();
            }
        }
        Forces { list: rest, x, out }.reference();
    }
}

impl<E: Element> WithSimd for Forces<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::F64_LANES == SLOTS { self.fast(Wide(simd)) } else { self.fast(Plain) }
    }
}

/// Adds the blocks of all elements.
struct Stiffness<'a, E> {
    list: &'a [E],
    x: &'a [Vec3],
    scale: f64,
    tangent: Tangent,
    sink: &'a mut dyn BlockSink,
}

impl<E: Element> Stiffness<'_, E> {
    fn reference(self) {
        let Self { list, x, scale, tangent, sink } = self;
        list.iter().for_each(|element| element.add_stiffness(x, scale, tangent, sink));
    }

    #[inline(always)]
    fn fast<F: Four>(self, four: F) {
        let Self { list, x, scale, tangent, sink } = self;
        let (groups, rest) = list.as_chunks();
        for group in groups {
            if !E::add_stiffnesses(four, group, x, scale, tangent, sink) {
                Stiffness { list: group, x, scale, tangent, sink }.reference();
            }
        }
        Stiffness { list: rest, x, scale, tangent, sink }.reference();
    }
}

impl<E: Element> WithSimd for Stiffness<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::F64_LANES == SLOTS { self.fast(Wide(simd)) } else { self.fast(Plain) }
    }
}

/// Sums the energies of all elements, J.
#[derive(Clone, Copy)]
struct Energy<'a, E> {
    list: &'a [E],
    x: &'a [Vec3],
}

impl<E: Element> Energy<'_, E> {
    /// Adds the energies to `sum`.
    fn reference(self, sum: f64) -> f64 {
        self.list.iter().filter_map(|element| element.energy(self.x)).fold(sum, |sum, u| sum + u)
    }

    #[inline(always)]
    fn fast<F: Four>(self, four: F) -> f64 {
        let Self { list, x } = self;
        let (groups, rest) = list.as_chunks();
        let mut sum = -0.0;
        for group in groups {
            sum = match E::energies(four, group, x) {
                Some([a, b, c, d]) => sum + a + b + c + d,
                None => Energy { list: group, x }.reference(sum),
            };
        }
        Energy { list: rest, x }.reference(sum)
    }
}

impl<E: Element> WithSimd for Energy<'_, E> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        if S::F64_LANES == SLOTS { self.fast(Wide(simd)) } else { self.fast(Plain) }
    }
}

impl<E: Element> Stencils for Elements<E> {
    fn visit(&self, visit: &mut dyn FnMut(&[u32])) {
        for element in &self.list {
            let (mut element, mut particles, mut count) = (*element, [0; MOST], 0);
            for (slot, (_, particle)) in particles.iter_mut().zip(element.particles()) {
                *slot = *particle;
                count += 1;
            }
            visit(&particles[..count]);
        }
    }

    /// Evaluates the element on copies of its particles.
    fn local(&self, stencil: usize, place: usize, x: &[Vec3]) -> (Vec3, Mat3) {
        let mut element = self.list[stencil];
        let mut near = [Vec3::zeros(); MOST];
        for ((slot, own), (_, particle)) in near.iter_mut().zip(0..).zip(element.particles()) {
            *slot = x[*particle as usize];
            *particle = own;
        }
        element.local(place, &near)
    }

    fn turn(&self, place: usize, x: &[Vec3; 4]) -> Option<Turn> {
        self.list.get(place)?.turn(x)
    }
}

/// Keeps one block of the diagonal.
struct OneBlock {
    place: usize,
    block: Mat3,
}

impl BlockSink for OneBlock {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_general_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_diagonal(i, block);
        self.add_diagonal(j, &block.transpose());
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        if i == self.place {
            self.block += block;
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{AngleEffect, AngleSpec};
    use drape_kernels::testing::{Random, assert_same_bits};
    use std::f64::consts::{FRAC_PI_2, PI};

    /// All blocks in their order.
    #[derive(Default)]
    struct Pairs {
        places: Vec<[usize; 2]>,
        numbers: Vec<f64>,
    }

    impl BlockSink for Pairs {
        fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
            self.add_general_pair(i, j, block);
        }

        fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
            self.places.push([i, j]);
            self.numbers.extend(block.iter().map(|a| if a.is_nan() { f64::NAN } else { *a }));
        }

        fn add_diagonal(&mut self, i: usize, block: &Mat3) {
            self.add_general_pair(i, i, block);
        }
    }

    /// Compares forces, energies and blocks of both forms, at random positions and at some without an
    /// angle; returns how many groups of four took the fast form.
    pub(in crate::effects) fn compare<E: Element>(
        list: &[E],
        random: &mut Random,
        positions: &[Vec3],
    ) -> usize {
        let start = random.vectors(positions.len());
        let [mut slow, mut fast, mut plain] = [(); 3].map(|()| start.clone());
        let x = positions;
        Forces { list, x, out: &mut slow }.reference();
        four_wide().dispatch(Forces { list, x, out: &mut fast });
        Forces { list, x, out: &mut plain }.fast(Plain);
        assert_same_bits("forces", &numbers(&slow), &numbers(&fast));
        assert_same_bits("forces, one by one", &numbers(&slow), &numbers(&plain));
        let energy = Energy { list, x };
        let [slow, fast] = [energy.reference(-0.0), four_wide().dispatch(energy)];
        assert!(slow.to_bits() == fast.to_bits() || slow.is_nan() && fast.is_nan());
        for tangent in [Tangent::Exact, Tangent::Projected] {
            let [mut slow, mut fast, mut plain] = [(); 3].map(|()| Pairs::default());
            let scale = 0.7;
            Stiffness { list, x, scale, tangent, sink: &mut slow }.reference();
            four_wide().dispatch(Stiffness { list, x, scale, tangent, sink: &mut fast });
            Stiffness { list, x, scale, tangent, sink: &mut plain }.fast(Plain);
            assert_eq!((&slow.places, &slow.places), (&fast.places, &plain.places));
            assert_same_bits(("blocks", tangent), &slow.numbers, &fast.numbers);
            assert_same_bits(("blocks, one by one", tangent), &slow.numbers, &plain.numbers);
        }
        let mut out = start;
        let groups = list.as_chunks().0.iter();
        groups.filter(|group| E::add_forces(Plain, group, x, &mut out)).count()
    }

    /// Which NaN comes out of a sum is no part of the promise.
    fn numbers(forces: &[Vec3]) -> Vec<Vec3> {
        forces.iter().map(|f| f.map(|x| if x.is_nan() { 0.5 } else { x })).collect()
    }

    /// Positions at random, in a plane, with two particles at one place, with one that is nowhere,
    /// far apart and near to each other.
    pub(in crate::effects) fn positions(random: &mut Random, n: usize) -> [Vec<Vec3>; 7] {
        let any = random.vectors(n);
        let flat: Vec<_> = any.iter().map(|x| Vec3::new(x.x, x.y, 0.0)).collect();
        let straight: Vec<_> = (0..n).map(|i| Vec3::new(i as f64, 0.0, 0.0)).collect();
        let (mut double, mut nowhere) = (any.clone(), any.clone());
        double[n / 2] = double[n / 3];
        nowhere[n / 2].y = f64::NAN;
        let scaled = |s: f64| any.iter().map(|x| x * s).collect();
        [scaled(1e140), scaled(1e-60), any.clone(), flat, straight, double, nowhere]
    }

    #[test]
    fn four_angles_at_a_time_give_the_bits_of_one_after_the_other() {
        let mut random = Random::new(9);
        let mut fast = 0;
        for count in (0..10).chain([60]) {
            let n = 4 + count;
            let list: Vec<_> = (0..count)
                .map(|place| {
                    let [i, j, k] = [0, 1, 2].map(|step| ((place * 3 + step) % n) as u32);
                    let rest_rad = [PI, FRAC_PI_2, 0.0, 1.0][place % 4];
                    let effect = AngleEffect::ALL[place % 2];
                    AngleSpec { effect, i, j, k, rest_rad, stiffness_n_m: 0.3 + f64::from(k) }
                })
                .collect();
            for x in positions(&mut random, n) {
                fast += compare(&list, &mut random, &x);
            }
        }
        assert!(fast > 60, "{fast}");
    }

    /// A flat sheet of two rows of three particles.
    pub(in crate::effects) fn sheet() -> Vec<Vec3> {
        (0..6).map(|i| Vec3::new((i % 3) as f64, (i / 3) as f64, 0.0)).collect()
    }

    /// A flat sheet at rest, its right angles and its straight rows are usual.
    #[test]
    fn a_sheet_at_rest_takes_the_fast_form() {
        let x = sheet();
        let angle = |i, j, k, rest_rad| AngleSpec {
            effect: AngleEffect::BendingAngle,
            i,
            j,
            k,
            rest_rad,
            stiffness_n_m: 1.0,
        };
        let angles = [angle(0, 1, 2, PI), angle(3, 4, 5, PI), angle(0, 1, 4, FRAC_PI_2)];
        let angles = [angles[0], angles[1], angles[2], angle(2, 5, 4, FRAC_PI_2)];
        let mut random = Random::new(1);
        assert_eq!(compare(&angles, &mut random, &x), 1);
    }
}
