//! The sheet for the tests of the step and its linear system.

use drape_model::{DampingLaw, SpringEffect, SystemSpec, Vec3};
use drape_oracle::Random;
use drape_oracle::scenes::{gravity, particles, pin, spring};

/// A sheet of `side × side` particles of unequal masses, displaced at random by `disorder` mesh
/// widths and in random motion, with tension, shear and bending springs; two corners are pinned.
pub(crate) fn rough_sheet(
    side: usize,
    stiffness: f64,
    disorder: f64,
    law: DampingLaw,
) -> SystemSpec {
    let mut random = Random::new(5);
    let width = 1.0 / (side - 1) as f64;
    let (mut mass, mut x, mut v) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..side * side {
        mass.push(random.between(0.5e-3, 1.5e-3));
        let (row, column) = ((i / side) as f64, (i % side) as f64);
        x.push(Vec3::new(column, row, 0.0) * width + random.vector() * (disorder * width));
        v.push(random.vector());
    }
    let mut spec = particles(&mass, &x, &v);
    spec.damping = law;
    let diagonal = width * 2.0_f64.sqrt();
    let steps = [
        (SpringEffect::Tension, 0, 1, width, 1.0),
        (SpringEffect::Tension, 1, 0, width, 1.0),
        (SpringEffect::Shear, 1, 1, diagonal, 0.3),
        (SpringEffect::Bending, 0, 2, 2.0 * width, 0.1),
        (SpringEffect::Bending, 2, 0, 2.0 * width, 0.1),
    ];
    for (effect, down, right, rest, part) in steps {
        for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
            if row + down < side && column + right < side {
                let ends = (row * side + column, (row + down) * side + column + right);
                let k = 1e-3 * stiffness * part;
                spec.springs.push(spring(effect, ends, rest, k, 5e-3 * part));
            }
        }
    }
    spec.pins = vec![pin(0), pin(side - 1)];
    spec.effects.gravity = gravity();
    spec
}
