//! Energy → force → Jacobian, by central differences.
//!
//! | of an effect | must be |
//! |---|---|
//! | force `f` | `−∂U/∂x` of its energy |
//! | stiffness | `−∂f/∂x` |
//! | damping | `−∂f_D/∂v` of its damping force |
//!
//! [`check`] takes differences at several widths. Truncation falls with the square of the width;
//! round-off rises as the width falls. The best width is used.

use drape_model::{BlockSink, Effect, Level, Mat3, Tangent, Vec3};
use nalgebra::{DMatrix, DVector};

/// Widths of the differences, relative to the extent of the positions or velocities.
const WIDTHS: [f64; 6] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];

/// Relative deviations for a range of widths.
#[derive(Clone, Debug, PartialEq)]
pub struct WidthSweep {
    /// Width of the difference (m or m/s) and relative deviation, from the widest to the narrowest.
    pub deviations: Vec<(f64, f64)>,
}

impl WidthSweep {
    /// Smallest deviation of the sweep.
    pub fn best(&self) -> f64 {
        self.deviations.iter().map(|(_, deviation)| *deviation).fold(f64::INFINITY, f64::min)
    }
}

/// Findings of [`check`], each as norm of the deviation over norm of the quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Differences {
    /// Force against `−∂U/∂x`.
    pub force: WidthSweep,
    /// Stiffness (exact tangent) against `−∂f/∂x`.
    pub stiffness: WidthSweep,
    /// Damping against `−∂f_D/∂v`.
    pub damping: WidthSweep,
}

impl Differences {
    /// The worst of the three deviations, each at its best width.
    pub fn worst(&self) -> f64 {
        self.force.best().max(self.stiffness.best()).max(self.damping.best())
    }
}

/// A dense `3n × 3n` matrix that collects blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Dense(pub DMatrix<f64>);

impl Dense {
    /// The zero matrix for `n` particles.
    pub fn zeros(n: usize) -> Self {
        Self(DMatrix::zeros(3 * n, 3 * n))
    }
}

impl BlockSink for Dense {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        for (row, column, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
            let mut part = self.0.fixed_view_mut::<3, 3>(3 * row, 3 * column);
            part += block * sign;
        }
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        let transpose = block.transpose();
        for (row, column, part) in
            [(i, i, *block), (j, j, transpose), (i, j, -block), (j, i, -transpose)]
        {
            let mut view = self.0.fixed_view_mut::<3, 3>(3 * row, 3 * column);
            view += part;
        }
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        let mut view = self.0.fixed_view_mut::<3, 3>(3 * i, 3 * i);
        view += block;
    }
}

fn flat(vectors: &[Vec3]) -> DVector<f64> {
    DVector::from_iterator(3 * vectors.len(), vectors.iter().flat_map(|a| a.iter().copied()))
}

/// `max |a|`, or 1 where all are 0.
fn extent(vectors: &[Vec3]) -> f64 {
    let largest = vectors.iter().map(Vec3::norm).fold(0.0, f64::max);
    if largest > 0.0 { largest } else { 1.0 }
}

/// `‖a − b‖/‖a‖`; 0 where both are 0.
fn relative(exact: &DMatrix<f64>, difference: &DMatrix<f64>) -> f64 {
    let deviation = (exact - difference).norm();
    if deviation == 0.0 { 0.0 } else { deviation / exact.norm() }
}

/// Central differences of a function of positions or velocities, one column a coordinate.
fn differentiate(at: &[Vec3], width: f64, f: &dyn Fn(&[Vec3]) -> DVector<f64>) -> DMatrix<f64> {
    let mut moved = at.to_vec();
    let mut columns = Vec::new();
    for i in 0..at.len() {
        for axis in 0..3 {
            moved[i][axis] = at[i][axis] + width;
            let (high, above) = (moved[i][axis], f(&moved));
            moved[i][axis] = at[i][axis] - width;
            let (low, below) = (moved[i][axis], f(&moved));
            moved[i][axis] = at[i][axis];
            columns.push((above - below) / (high - low));
        }
    }
    DMatrix::from_columns(&columns)
}

fn sweep(
    exact: &DMatrix<f64>,
    at: &[Vec3],
    sign: f64,
    f: &dyn Fn(&[Vec3]) -> DVector<f64>,
) -> WidthSweep {
    let deviation = |width: &f64| {
        let width = width * extent(at);
        (width, relative(exact, &(differentiate(at, width, f) * sign)))
    };
    WidthSweep { deviations: WIDTHS.iter().map(deviation).collect() }
}

/// Compares an effect's force with its energy, its stiffness with its force, and its damping with
/// its damping force, at positions `x` (m) and velocities `v` (m/s).
///
/// # Panics
/// If `mass`, `x` and `v` differ in length, or there is no particle.
pub fn check(effect: &dyn Effect, mass: &[f64], x: &[Vec3], v: &[Vec3]) -> Differences {
    assert!(!x.is_empty() && [x.len(), v.len()] == [mass.len(); 2], "one of each a particle");
    let zeros = || vec![Vec3::zeros(); x.len()];
    let force = |x: &[Vec3]| {
        let mut out = zeros();
        effect.add_force(mass, x, &mut out);
        flat(&out)
    };
    let lagged = Level { t: 0.0, x, v };
    let damping_force = |v: &[Vec3]| {
        let mut out = zeros();
        effect.add_lagged_damping_force(lagged, v, &mut out);
        flat(&out)
    };
    let energy = |x: &[Vec3]| DVector::from_element(1, effect.energy(mass, x));
    let (mut stiffness, mut damping) = (Dense::zeros(x.len()), Dense::zeros(x.len()));
    effect.add_stiffness(x, 1.0, Tangent::Exact, &mut stiffness);
    effect.add_damping(lagged, 1.0, &mut damping);
    let exact_force = DMatrix::from_rows(&[force(x).transpose()]);
    Differences {
        force: sweep(&exact_force, x, -1.0, &energy),
        stiffness: sweep(&stiffness.0, x, -1.0, &force),
        damping: sweep(&damping.0, v, -1.0, &damping_force),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use drape_model::effects::{LinearSprings, Spring};
    use drape_model::{DampingLaw, EffectKind};

    /// A spring with one part of it spoilt.
    #[derive(Debug, Clone)]
    struct Spoilt {
        spring: LinearSprings,
        force: f64,
        stiffness: f64,
        damping: f64,
    }

    impl Effect for Spoilt {
        fn kind(&self) -> EffectKind {
            self.spring.kind()
        }
        fn energy(&self, mass: &[f64], x: &[Vec3]) -> f64 {
            self.spring.energy(mass, x)
        }
        fn add_force(&self, mass: &[f64], x: &[Vec3], out: &mut [Vec3]) {
            self.spring.add_force(mass, x, out);
            out[0].x *= self.force;
        }
        fn has_damping(&self) -> bool {
            self.spring.has_damping()
        }
        fn add_damping_force(&self, at: Level<'_>, out: &mut [Vec3]) {
            self.spring.add_damping_force(at, out);
        }
        fn add_stiffness(
            &self,
            x: &[Vec3],
            scale: f64,
            tangent: Tangent,
            sink: &mut dyn BlockSink,
        ) {
            self.spring.add_stiffness(x, scale * self.stiffness, tangent, sink);
        }
        fn add_damping(&self, lagged: Level<'_>, scale: f64, sink: &mut dyn BlockSink) {
            self.spring.add_damping(lagged, scale * self.damping, sink);
        }
        fn boxed_clone(&self) -> Box<dyn Effect> {
            Box::new(self.clone())
        }
    }

    fn spoilt(force: f64, stiffness: f64, damping: f64) -> Differences {
        let spring = Spring { i: 0, j: 1, rest_length: 0.7, stiffness: 3.0, damping: 0.2 };
        let spring = LinearSprings::new(EffectKind::Tension, vec![spring], DampingLaw::Projected);
        let mut random = Random::new(1);
        let [x, v] = [(); 2].map(|()| [random.vector(), random.vector()]);
        check(&Spoilt { spring, force, stiffness, damping }, &[1.0, 2.0], &x, &v)
    }

    #[test]
    fn a_consistent_effect_passes() {
        let found = spoilt(1.0, 1.0, 1.0);
        assert!(found.worst() < 1e-8, "{found:?}");
        // Truncation falls with the square of the width.
        let [(_, wide), (_, narrow)] = [0, 1].map(|k| found.force.deviations[k]);
        assert!((90.0..110.0).contains(&(wide / narrow)), "{found:?}");
    }

    #[test]
    fn a_wrong_force_stiffness_or_damping_is_found() {
        let found = spoilt(1.001, 1.0, 1.0);
        assert!(found.force.best() > 1e-5 && found.stiffness.best() > 1e-5, "{found:?}");
        let found = spoilt(1.0, 0.999, 1.0);
        assert!(found.stiffness.best() > 1e-4 && found.force.best() < 1e-8, "{found:?}");
        let found = spoilt(1.0, 1.0, -1.0);
        assert!(found.damping.best() > 1.0 && found.stiffness.best() < 1e-8, "{found:?}");
    }
}
