//! Whether a step is short enough for the forces that a method takes at the old time level.

use crate::assembly::subtract_stiffness_product;
use crate::random::Random;
use drape_model::{BlockSink, Effect, Mat3, State, System, Tangent, Vec3};
use drape_solvers::vector::{dot, weighted_dot};

/// Products of the power iteration: it ends within a few per cent of the largest eigenvalue.
const PRODUCTS: usize = 100;

/// How far a step is from the limits of its explicit forces; above 1 the motion is expected to blow up.
///
/// With the stiffness groups `θ = h² λ`, a mode with `θ_E` from explicit effects and `θ_I` from springs in the matrix of an
/// implicit-explicit method obeys `(1 + θ_I) z² − (2 − θ_E) z + 1 = 0`, which is stable for `θ_E < 4 + θ_I`. An explicit drag that
/// takes the momentum `κ a/3` per velocity from each corner of its triangles is stable for `h Σ κ a/(3 m) < 2`.
///
/// Both are estimates at one state: stiffnesses of angles, areas and speeds change with the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExplicitNumbers {
    /// `θ_E/(4 + θ_I)` of the stiffest mode of the explicit effects; 0 if none is stiff.
    pub stiffness: f64,
    /// The greatest `h Σ κ a/(3 m)/2` of a particle; 0 without explicit drag.
    pub drag: f64,
}

impl ExplicitNumbers {
    /// The numbers of a step of `h` seconds. It allocates: one call a run is meant.
    pub fn new(
        system: &System,
        state: &State,
        is_explicit: &dyn Fn(&dyn Effect) -> bool,
        h: f64,
    ) -> Self {
        let (stiff, mode) = stiffest_mode(system, state, is_explicit);
        let mut implicit = 0.0;
        if stiff > 0.0 {
            let splits = system.effects().filter(|effect| !is_explicit(*effect));
            for split in splits.filter_map(Effect::split) {
                split.visit_weights(&mut |i, j, k, _| {
                    implicit += k * (mode[i] - mode[j]).norm_squared();
                });
            }
            implicit /= weighted_dot(system.mass(), &mode, &mode);
        }
        Self {
            stiffness: h * h * stiff / (4.0 + h * h * implicit),
            drag: 0.5 * h * largest_drag(system, state, is_explicit),
        }
    }

    /// The greater one.
    pub fn worst(&self) -> f64 {
        self.stiffness.max(self.drag)
    }
}

/// The largest eigenvalue of `M⁻¹ K` of the explicit effects, 1/s², and its mode; pinned particles at rest.
fn stiffest_mode(
    system: &System,
    state: &State,
    is_explicit: &dyn Fn(&dyn Effect) -> bool,
) -> (f64, Vec<Vec3>) {
    let explicit = || system.effects().filter(|effect| is_explicit(*effect));
    if !explicit().any(|effect| effect.has_jacobian() && !effect.is_drag()) {
        return (0.0, Vec::new());
    }
    let mut random = Random::new();
    let free = |i: usize| if system.pinned()[i] { 0.0 } else { 1.0 };
    let start = |i: usize| Vec3::from_fn(|_, _| random.signed()) * free(i);
    let mut mode: Vec<_> = (0..system.len()).map(start).collect();
    let mut product = vec![Vec3::zeros(); system.len()];
    let mut value = 0.0;
    for _ in 0..PRODUCTS {
        product.fill(Vec3::zeros());
        for effect in explicit() {
            let (x, tangent) = (&state.x, Tangent::Projected);
            subtract_stiffness_product(effect, x, tangent, &mode, &mut product);
        }
        for (i, (p, m)) in product.iter_mut().zip(system.mass()).enumerate() {
            *p *= -free(i) / m; // M⁻¹ K w
        }
        let inertia = weighted_dot(system.mass(), &mode, &mode);
        let weighted: f64 =
            system.mass().iter().zip(&mode).zip(&product).map(|((m, w), p)| m * w.dot(p)).sum();
        let size = dot(&product, &product).sqrt();
        if !(inertia > 0.0 && size > 0.0 && size.is_finite()) {
            break;
        }
        value = weighted / inertia;
        for (w, p) in mode.iter_mut().zip(&product) {
            *w = p / size;
        }
    }
    (value, mode)
}

/// Row sums of the drag, N s/m.
struct DragSums(Vec<f64>);

impl BlockSink for DragSums {
    fn add_pair(&mut self, _i: usize, _j: usize, _block: &Mat3) {} // cancels in the sum of a row

    fn add_general_pair(&mut self, _i: usize, _j: usize, _block: &Mat3) {}

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.0[i] += block.norm();
    }
}

/// The greatest `Σ κ a/(3 m)` of a free particle, 1/s.
fn largest_drag(system: &System, state: &State, is_explicit: &dyn Fn(&dyn Effect) -> bool) -> f64 {
    let drags = || system.effects().filter(|effect| effect.is_drag() && is_explicit(*effect));
    if drags().next().is_none() {
        return 0.0;
    }
    let mut sums = DragSums(vec![0.0; system.len()]);
    for effect in drags() {
        effect.add_damping(state.level(), 1.0, &mut sums);
    }
    let rates = sums.0.iter().zip(system.mass()).zip(system.pinned());
    rates.filter(|(_, pinned)| !**pinned).fold(0.0, |most: f64, ((sum, m), _)| most.max(sum / m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::parse;

    fn system(more: &str) -> (System, State) {
        let text = format!(
            r#"{{ "format": "drape-system/1", {more} "triangles": [[0, 1, 2]],
            "particles": {{ "mass_kg": [0.1, 0.1, 0.1], "position_m": [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]] }} }}"#
        );
        parse("row", &text).expect("valid").spec().build().expect("valid")
    }

    const ANGLE: &str = r#""angles": [{ "effect": "bending_angle", "i": 0, "j": 1, "k": 2,
        "rest_rad": 3.141592653589793, "stiffness_n_m": 2 }],"#;

    #[test]
    fn an_explicit_angle_alone_is_compared_with_four() {
        let (system, state) = system(ANGLE);
        let numbers = ExplicitNumbers::new(&system, &state, &|_| true, 0.1);
        let expected = 0.01 * 6.0 * 2.0 / (0.25 * 0.1) / 4.0;
        assert!((numbers.stiffness / expected - 1.0).abs() < 1e-9, "{numbers:?}");
        assert_eq!(numbers.drag, 0.0);
        assert_eq!(ExplicitNumbers::new(&system, &state, &|_| false, 0.1).worst(), 0.0);
    }

    #[test]
    fn implicit_springs_raise_the_limit() {
        let springs = r#""springs": [
            { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 0.5, "stiffness_n_per_m": 7 },
            { "effect": "tension", "i": 1, "j": 2, "rest_length_m": 0.5, "stiffness_n_per_m": 7 }],"#;
        let (system, state) = system(&format!("{springs} {ANGLE}"));
        let is_explicit = |effect: &dyn Effect| effect.name() != "tension";
        let numbers = ExplicitNumbers::new(&system, &state, &is_explicit, 0.1);
        // The mode (1, −2, 1) has wᵀ L w = 7 (9 + 9) and wᵀ w = 6.
        let expected = 0.01 * 480.0 / (4.0 + 0.01 * 7.0 * 18.0 / 0.6);
        assert!((numbers.stiffness / expected - 1.0).abs() < 1e-9, "{numbers:?}");
    }

    #[test]
    fn drag_is_compared_with_two_over_the_step() {
        let air =
            r#""effects": { "air": { "drag": { "linear": { "coefficient_n_s_per_m3": 3 } } } },"#;
        let text = format!(
            r#"{{ "format": "drape-system/1", {air} "triangles": [[0, 1, 2], [1, 3, 2]],
            "particles": {{ "mass_kg": [0.1, 0.1, 0.1, 0.1],
                "position_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]] }} }}"#
        );
        let (system, state) = parse("air", &text).expect("valid").spec().build().expect("valid");
        let numbers = ExplicitNumbers::new(&system, &state, &|_| true, 0.02);
        // Two triangles of ½ m² meet in particle 1: κ a/3 = ½ each.
        assert!((numbers.drag - 0.5 * 0.02 * 1.0 / 0.1).abs() < 1e-15, "{numbers:?}");
        assert_eq!(numbers.stiffness, 0.0);
    }
}
