//! Matrix and right-hand side from secant stiffnesses.

use drape_integrator::{Implicit, PrepareError, StepError};
use drape_model::{State, System, Vec3};
use drape_solvers::{CompleteLdlt, LinearOperator, ScalarMatrix, constraint_impulse, vector::norm};

/// `A v_{n+1} = b` of one step, (T2).
#[derive(Debug)]
pub(crate) struct SecantSystem {
    clamp: bool,
    matrix: ScalarMatrix,
    factor: CompleteLdlt,
    free: Vec<bool>,
    /// Right-hand side, kg m/s.
    b: Vec<Vec3>,
    damping: Vec<Vec3>,
    residual: Vec<Vec3>,
}

impl SecantSystem {
    /// Memory, sparsity pattern and symbolic factorisation.
    pub(crate) fn new(system: &System, clamp: bool) -> Result<Self, PrepareError> {
        let n = system.len();
        let mut edges = Vec::new();
        Implicit::Springs.visit_weights(system, &mut |i, j, _, _| edges.push((i, j)));
        let matrix = ScalarMatrix::with_pattern(n, edges);
        let factor = CompleteLdlt::new(&matrix)?;
        let zeros = || vec![Vec3::zeros(); n];
        Ok(Self {
            clamp,
            matrix,
            factor,
            free: vec![true; n],
            b: zeros(),
            damping: zeros(),
            residual: zeros(),
        })
    }

    /// `A = M + h² K(x_n) + ½ h L_c` and `b = (M − ½ h D) v_n + h (f_ext − K(x_n) x_n)`, (T2).
    /// Projected damping `D` adds `½ h (L_c − D) v_n` to `b`.
    #[doc(alias = "Terzopoulos-Fleischer 1988")]
    pub(crate) fn assemble(&mut self, system: &System, state: &State, h: f64) {
        let Self { clamp, matrix, free, b, damping, .. } = self;
        let (x, v) = (&state.x, &state.v);
        b.fill(Vec3::zeros());
        damping.fill(Vec3::zeros());
        Implicit::Springs.add_explicit_forces(system, state.level(), b);
        matrix.clear();
        for effect in Implicit::Springs.effects(system) {
            let Some(split) = effect.split() else { continue };
            split.visit_secants(x, &mut |i, j, k| {
                let k = if *clamp { k.max(0.0) } else { k };
                let f = (x[i] - x[j]) * k;
                b[i] -= f;
                b[j] += f;
                matrix.add_edge(i, j, h * h * k);
            });
            if effect.has_damping() {
                split.visit_weights(&mut |i, j, _, c| matrix.add_edge(i, j, 0.5 * h * c));
                effect.add_damping_force(state.level(), damping);
                split.add_damping_remainder(x, v, damping);
            }
        }
        for (i, (&m, pinned)) in system.mass().iter().zip(system.pinned()).enumerate() {
            matrix.add_diagonal(i, m);
            free[i] = !pinned;
            b[i] = v[i] * m + (b[i] + damping[i] * 0.5) * h;
            if *pinned {
                b[i] = Vec3::zeros();
            }
        }
    }

    /// `A = L D Lᵀ`, with pinned particles taken out.
    ///
    /// # Errors
    /// [`StepError::Solver`] where a pivot vanishes or is not finite.
    pub(crate) fn factorise(&mut self) -> Result<(), StepError> {
        Ok(self.factor.update(&self.matrix, Some(&self.free))?)
    }

    /// Weight of a secant stiffness in the matrix, N/m.
    pub(crate) fn weight(&self, secant: f64) -> f64 {
        if self.clamp { secant.max(0.0) } else { secant }
    }

    /// `A v − b`, kg m/s.
    pub(crate) fn left_over(&mut self, v: &[Vec3]) -> &[Vec3] {
        constraint_impulse(&self.matrix, &self.b, v, &mut self.residual);
        &self.residual
    }

    /// Whether the matrix has a negative eigenvalue.
    pub(crate) fn is_indefinite(&self) -> bool {
        self.factor.negative_pivots().is_some_and(|count| count > 0)
    }

    /// Solves with pins on paths: their products with the other rows go to the right-hand side.
    fn solve_led(&mut self, system: &System, known: &[Vec3], v: &mut [Vec3]) {
        let Self { matrix, factor, free, b, damping: right, residual: product, .. } = self;
        v.fill(Vec3::zeros());
        for pin in system.moving_pins() {
            v[pin.particle] = known[pin.particle];
        }
        matrix.multiply(v, product);
        for i in 0..b.len() {
            right[i] = if free[i] { b[i] - product[i] } else { Vec3::zeros() };
        }
        factor.solve(right, v);
        for pin in system.moving_pins() {
            v[pin.particle] = known[pin.particle];
        }
    }

    /// Solves for `v`; pinned particles take their velocity from `known`, m/s. Returns
    /// `‖b − A v‖/‖b‖` over the others.
    pub(crate) fn solve(&mut self, system: &System, known: &[Vec3], v: &mut [Vec3]) -> f64 {
        if system.moving_pins().is_empty() {
            self.factor.solve(&self.b, v);
        } else {
            self.solve_led(system, known, v);
        }
        self.matrix.multiply(v, &mut self.residual);
        for (i, r) in self.residual.iter_mut().enumerate() {
            *r = if self.free[i] { self.b[i] - *r } else { Vec3::zeros() };
        }
        let residual = norm(&self.residual);
        if residual > 0.0 { residual / norm(&self.b) } else { residual }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::parse;
    use drape_oracle::Random;
    use nalgebra::DMatrix;

    const H: f64 = 0.1;

    /// Three particles on two springs with the given law of damping, in motion.
    fn scene(damping: &str) -> (System, State) {
        let text = format!(
            r#"{{ "format": "drape-system/1", "damping": "{damping}",
            "particles": {{ "mass_kg": [1, 2, 0.5],
            "position_m": [[0, 0, 0], [0.5, 0, 0.25], [2, 1, 0]],
            "velocity_m_s": [[0, 1, 0], [1, 0, -1], [0.5, 0.25, 2]] }},
            "effects": {{ "gravity": {{ "m_s2": [0, 0, -10] }} }},
            "springs": [
              {{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
                "stiffness_n_per_m": 50, "damping_n_s_per_m": 3 }},
              {{ "effect": "shear", "i": 1, "j": 2, "rest_length_m": 1,
                "stiffness_n_per_m": 20, "damping_n_s_per_m": 2 }}
            ] }}"#
        );
        parse("test", &text).expect("valid").spec().build().expect("valid")
    }

    /// The published form, for the positions, dense and coordinate by coordinate.
    #[test]
    fn the_velocity_form_is_the_published_one() {
        let (system, state) = scene("full");
        let n = state.len();
        let (mut stiffness, mut damping) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        let springs = [(0, 1, 1.0, 50.0, 3.0), (1, 2, 1.0, 20.0, 2.0)];
        for (i, j, rest, k, c) in springs {
            let secant = k * (1.0 - rest / (state.x[i] - state.x[j]).norm());
            for (matrix, weight) in [(&mut stiffness, secant), (&mut damping, c)] {
                matrix[(i, i)] += weight;
                matrix[(j, j)] += weight;
                matrix[(i, j)] -= weight;
                matrix[(j, i)] -= weight;
            }
        }
        assert!(stiffness[(0, 1)] > 0.0, "one spring is compressed");
        let mass = DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(system.mass()));
        let left = &stiffness + &mass / (H * H) + &damping / (2.0 * H);
        let mut secant = SecantSystem::new(&system, false).expect("small");
        secant.assemble(&system, &state, H);
        let mut v = state.v.clone();
        secant.factorise().expect("regular");
        assert!(secant.solve(&system, &state.v, &mut v) < 1e-12);
        for axis in 0..3 {
            let pick = |vectors: &[Vec3]| {
                nalgebra::DVector::from_iterator(n, vectors.iter().map(|a| a[axis]))
            };
            let gravity = if axis == 2 { -10.0 } else { 0.0 };
            let right = (&mass / (H * H) + &damping / (2.0 * H)) * pick(&state.x)
                + (&mass / H - &damping / 2.0) * pick(&state.v)
                + &mass * nalgebra::DVector::from_element(n, gravity);
            let expected = left.clone().lu().solve(&right).expect("regular");
            let found = pick(&state.x) + pick(&v) * H;
            assert!((expected - found).norm() < 1e-13, "axis {axis}");
        }
    }

    /// Half of the projected damping is implicit, as far as it is linear. Where the velocity does
    /// not change, both halves add up to the whole damping force.
    #[test]
    fn projected_damping_is_complete_where_the_velocity_does_not_change() {
        let (system, state) = scene("projected");
        let mut secant = SecantSystem::new(&system, false).expect("small");
        secant.assemble(&system, &state, H);
        let mut force = vec![Vec3::zeros(); state.len()];
        system.forces(state.level(), &mut force);
        // A v_n − b = −h f + h² K v_n; a small step makes the last term negligible.
        let small = 1e-7;
        secant.assemble(&system, &state, small);
        let mut product = state.v.clone();
        secant.matrix.multiply(&state.v, &mut product);
        for i in 0..state.len() {
            let found = (secant.b[i] - product[i]) / small;
            assert!((found - force[i]).norm() < 1e-4, "{found} {}", force[i]);
        }
    }

    /// A compressed spring pushes in the default form, but not in the clamped one. The matrix is
    /// indefinite only in the default form.
    #[test]
    fn clamping_silences_compressed_springs() {
        let (system, mut state) = scene("full");
        state.x = vec![Vec3::zeros(), Vec3::x() * 0.1, Vec3::x() * 0.2];
        state.v.fill(Vec3::zeros());
        let mut random = Random::new(1);
        for (clamp, pushes) in [(false, true), (true, false)] {
            let mut secant = SecantSystem::new(&system, clamp).expect("small");
            secant.assemble(&system, &state, H);
            let mut v: Vec<Vec3> = (0..3).map(|_| random.vector()).collect();
            secant.factorise().expect("regular");
            secant.solve(&system, &state.v, &mut v);
            assert_eq!((v[2] - v[0]).x.abs() > 1e-3, pushes, "{v:?}");
            assert_eq!(secant.is_indefinite(), !clamp);
        }
    }
}
