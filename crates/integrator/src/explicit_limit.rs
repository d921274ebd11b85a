//! Whether a step is short enough for the explicit forces of a method.

use crate::assembly::subtract_stiffness_product;
use crate::random::Lcg;
use drape_model::{Effect, Mat3, State, System, Tangent, Vec3};
use drape_solvers::vector::{dot, weighted_dot};
use drape_solvers::{BlockMatrix, Coupling, LinearOperator};

/// Most products of one power iteration.
const PRODUCTS: usize = 100;
/// A power iteration ends when this many products change its quotient by less than this part.
const SETTLED: (usize, f64) = (10, 1e-6);
/// Half the difference of the velocities at which a drag is differentiated, over the greatest
/// velocity or 1 m/s.
const DIFFERENCE: f64 = 1e-6;
/// Most particles of a stiffness that is assembled. The matrix takes some hundred bytes a particle.
const ASSEMBLED: usize = 262_144;

/// The numbers that limit the step of explicit forces at one state. They change with the motion, as
/// stiffnesses of angles, areas and speeds do.
///
/// An implicit-explicit method has the Laplacian `L` of its springs in the matrix, whatever their
/// directions. Two forces are taken at the old level: the whole force of these springs, with the
/// stiffness `K_S`, and the explicit effects, with the stiffness `K_E`. With `θ = h² λ`, a mode of
/// all three obeys
///
/// ```text
/// (1 + θ_L) z² − (2 + θ_L − θ_S − θ_E) z + 1 = 0
/// ```
///
/// and is stable for `θ_E < 4 + 2 θ_L − θ_S`. Along springs `θ_S = θ_L`, and the limit is
/// `4 + θ_L`. Across springs at rest, where sheets bend, the limit is `4 + 2 θ_L`. The largest
/// eigenvalue of `M⁻¹(K_E + K_S − 2 L)` belongs to the mode that sets the limit.
///
/// An explicit drag with the Jacobian `−D` is stable for `h λ_max(M⁻¹ D) < 2`. If the force grows
/// with the square of the speed `u`, its slope `2 c u` counts and not its coefficient `c u`. A
/// steady flow is then stable for `h c u/m < 1`, although a decaying flow may start at twice that
/// value.
///
/// All three numbers are Rayleigh quotients at the end of a power iteration, which approaches the
/// largest eigenvalue from below. So the true limits may be somewhat shorter, and much stiffer
/// parts of the sheet may hide a mode. The limit may be shorter still for methods other than
/// symplectic and IMEX Euler, or with damping beside the stiffness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExplicitNumbers {
    /// `λ_E`: the stiffness of the explicit effects over the mass, in the mode that sets the limit,
    /// 1/s².
    pub explicit_stiffness: f64,
    /// `λ_I = 2 λ_L − λ_S`: how much the springs in the matrix counteract `λ_E` in the same mode,
    /// 1/s².
    pub implicit_stiffness: f64,
    /// The largest eigenvalue of `M⁻¹ D`, 1/s; 0 without explicit drag.
    pub drag: f64,
}

impl ExplicitNumbers {
    /// Computes the numbers at a state. `is_explicit` selects the explicit effects. It allocates, and
    /// assembles two matrices on grids, so call it only a few times per run.
    pub fn new(system: &System, state: &State, is_explicit: &dyn Fn(&dyn Effect) -> bool) -> Self {
        let (explicit_stiffness, implicit_stiffness) = stiffnesses(system, state, is_explicit);
        let drag = drag(system, state, is_explicit);
        Self { explicit_stiffness, implicit_stiffness, drag }
    }

    /// Whether the bound `2 Σ k/m` of the eigenvalues of explicit springs allows a step of `h`
    /// seconds at all positions. It returns `false` if an explicit effect drags, or has a Jacobian
    /// but no linear split. If it returns `true`, [`new`](Self::new) is not needed.
    pub fn surely_allow(
        system: &System,
        is_explicit: &dyn Fn(&dyn Effect) -> bool,
        h: f64,
    ) -> bool {
        let mut explicit = system.effects().filter(|effect| is_explicit(*effect));
        explicit.all(|e| !e.is_drag() && (e.split().is_some() || !e.has_jacobian()))
            && h * h * Laplacian::of(system, is_explicit).bound(system) < 4.0
    }

    /// Longest step that the stiffness allows, `2/√(λ_E − λ_I)`, s; infinite if `λ_I` is not
    /// smaller than `λ_E`.
    pub fn stiffness_limit(&self) -> f64 {
        let excess = self.explicit_stiffness - self.implicit_stiffness;
        if excess > 0.0 { 2.0 / excess.sqrt() } else { f64::INFINITY }
    }

    /// Longest step that the drag allows, s; infinite without drag.
    pub fn drag_limit(&self) -> f64 {
        if self.drag > 0.0 { 2.0 / self.drag } else { f64::INFINITY }
    }

    /// The shorter of the two limits, s.
    pub fn limit(&self) -> f64 {
        self.stiffness_limit().min(self.drag_limit())
    }
}

/// The operator `M⁻¹ A + shift`, by products with `A`.
struct Operator<'a> {
    system: &'a System,
    /// Writes the product of `A` with a vector.
    multiply: &'a mut dyn FnMut(&[Vec3], &mut [Vec3]),
    /// Added to all eigenvalues, so that the largest is also the largest in magnitude.
    shift: f64,
}

impl Operator<'_> {
    /// A random vector, 0 for pinned particles.
    fn start(&self) -> Vec<Vec3> {
        let mut random = Lcg::new();
        let mut part = |i: usize| Vec3::from_fn(|_, _| random.signed()) * self.is_free(i);
        (0..self.system.len()).map(&mut part).collect()
    }

    fn is_free(&self, i: usize) -> f64 {
        if self.system.pinned()[i] { 0.0 } else { 1.0 }
    }

    /// Power iteration from `mode`, which becomes the eigenvector. Returns the last Rayleigh
    /// quotient of `M⁻¹ A`.
    fn largest(&mut self, mode: &mut [Vec3]) -> f64 {
        let mass = self.system.mass();
        let mut product = vec![Vec3::zeros(); mode.len()];
        let (mut quotient, mut before) = (0.0_f64, f64::INFINITY);
        for product_count in 1..=PRODUCTS {
            (self.multiply)(mode, &mut product);
            let inertia = weighted_dot(mass, mode, mode);
            let work = dot(mode, &product);
            for (i, (p, m)) in product.iter_mut().zip(mass).enumerate() {
                *p = (*p / *m + mode[i] * self.shift) * self.is_free(i);
            }
            let size = dot(&product, &product).sqrt();
            if !(inertia > 0.0 && size > 0.0 && size.is_finite()) {
                break;
            }
            quotient = work / inertia;
            for (w, p) in mode.iter_mut().zip(&product) {
                *w = p / size;
            }
            if product_count % SETTLED.0 == 0 {
                if (quotient - before).abs() <= SETTLED.1 * quotient.abs() {
                    break;
                }
                before = quotient;
            }
        }
        quotient
    }
}

/// `λ_E` and `λ_I` in the mode with the greatest difference, 1/s².
fn stiffnesses(
    system: &System,
    state: &State,
    is_explicit: &dyn Fn(&dyn Effect) -> bool,
) -> (f64, f64) {
    let is_explicit = |effect: &dyn Effect| is_explicit(effect) && is_stiff(effect);
    if !system.effects().any(is_explicit) {
        return (0.0, 0.0);
    }
    let of_explicit = Stiffness::new(system, &state.x, &is_explicit, None);
    let mut multiply = |w: &[Vec3], out: &mut [Vec3]| of_explicit.multiply(w, out);
    let mut operator = Operator { system, multiply: &mut multiply, shift: 0.0 };
    let mut mode = operator.start();
    let stiffest = operator.largest(&mut mode);
    let springs = Laplacian::of(system, &|effect| !is_explicit(effect));
    if springs.0.is_empty() {
        return (stiffest, 0.0);
    }
    // Next, the mode with the greatest difference, which springs in the matrix resist less. Start
    // from the stiffest mode and a random vector.
    let is_either = |effect: &dyn Effect| is_explicit(effect) || effect.split().is_some();
    let difference = Stiffness::new(system, &state.x, &is_either, Some(&springs));
    let mut multiply = |w: &[Vec3], out: &mut [Vec3]| difference.multiply(w, out);
    let shift = 2.0 * springs.bound(system);
    let mut operator = Operator { system, multiply: &mut multiply, shift };
    let anywhere = operator.start();
    let share = 0.5 * (dot(&mode, &mode) / dot(&anywhere, &anywhere)).sqrt();
    mode.iter_mut().zip(&anywhere).for_each(|(w, a)| *w += a * share);
    let excess = operator.largest(&mut mode);
    let mut product = vec![Vec3::zeros(); mode.len()];
    of_explicit.multiply(&mode, &mut product);
    let explicit = dot(&mode, &product) / weighted_dot(system.mass(), &mode, &mode);
    (explicit, explicit - excess)
}

/// Whether an effect resists displacements.
fn is_stiff(effect: &dyn Effect) -> bool {
    effect.has_jacobian() && !effect.is_drag()
}

/// The stiffness `K` of some effects, less `2 L` of some springs.
struct Stiffness<'a> {
    system: &'a System,
    x: &'a [Vec3],
    selects: &'a dyn Fn(&dyn Effect) -> bool,
    springs: Option<&'a Laplacian>,
    /// The whole matrix, on grids. A product then takes a fraction of the time of one that goes
    /// through the effects, and uses the threads of the system. Other layouts would take more memory
    /// than many a run.
    matrix: Option<BlockMatrix>,
}

impl<'a> Stiffness<'a> {
    fn new(
        system: &'a System,
        x: &'a [Vec3],
        selects: &'a dyn Fn(&dyn Effect) -> bool,
        springs: Option<&'a Laplacian>,
    ) -> Self {
        let effects = || system.effects().filter(|effect| selects(*effect));
        let coupling = system.coupling(effects());
        let is_small = matches!(coupling, Coupling::Bands(_)) && system.len() <= ASSEMBLED;
        let matrix = is_small.then(|| {
            let mut matrix = BlockMatrix::new(system.len(), &coupling, std::iter::empty());
            matrix.set_threads(system.threads());
            for effect in effects() {
                effect.add_stiffness(x, 1.0, Tangent::Projected, &mut matrix);
            }
            springs.inspect(|springs| springs.subtract_twice(&mut matrix));
            matrix
        });
        Self { system, x, selects, springs, matrix }
    }

    /// Writes the product with `w`.
    fn multiply(&self, w: &[Vec3], out: &mut [Vec3]) {
        if let Some(matrix) = &self.matrix {
            return matrix.multiply(w, out);
        }
        out.fill(Vec3::zeros());
        for effect in self.system.effects().filter(|effect| (self.selects)(*effect)) {
            subtract_stiffness_product(effect, self.x, Tangent::Projected, w, out);
        }
        self.springs.inspect(|springs| springs.add(2.0, w, out));
        out.iter_mut().for_each(|p| *p = -*p);
    }
}

/// Springs: ends and stiffness, N/m.
struct Laplacian(Vec<(usize, usize, f64)>);

impl Laplacian {
    /// The springs of the selected effects.
    fn of(system: &System, selects: &dyn Fn(&dyn Effect) -> bool) -> Self {
        let mut springs = Vec::new();
        let selected = system.effects().filter(|effect| selects(*effect));
        for split in selected.filter_map(Effect::split) {
            split.visit_weights(&mut |i, j, k, _| springs.push((i, j, k)));
        }
        Self(springs)
    }

    /// Adds `factor · L w`.
    fn add(&self, factor: f64, w: &[Vec3], out: &mut [Vec3]) {
        for &(i, j, k) in &self.0 {
            let force = (w[i] - w[j]) * (factor * k);
            out[i] += force;
            out[j] -= force;
        }
    }

    /// Subtracts `2 L` from a matrix.
    fn subtract_twice(&self, matrix: &mut BlockMatrix) {
        for &(i, j, k) in &self.0 {
            matrix.add_pair(i, j, &Mat3::from_diagonal_element(-2.0 * k));
        }
    }

    /// Bound of the eigenvalues of `M⁻¹ L`, 1/s²: by Gershgorin, the greatest `2 Σ k/m` of a free
    /// particle.
    fn bound(&self, system: &System) -> f64 {
        let mut rows = vec![0.0; system.len()];
        for &(i, j, k) in &self.0 {
            rows[i] += 2.0 * k;
            rows[j] += 2.0 * k;
        }
        let rows = rows.iter().zip(system.mass()).zip(system.pinned());
        rows.filter(|(_, pinned)| !**pinned).map(|((k, m), _)| k / m).fold(0.0, f64::max)
    }
}

/// The largest eigenvalue of `M⁻¹ D` of the explicit drags at the velocities of the state, 1/s.
fn drag(system: &System, state: &State, is_explicit: &dyn Fn(&dyn Effect) -> bool) -> f64 {
    let drags = || system.effects().filter(|effect| effect.is_drag() && is_explicit(*effect));
    if drags().next().is_none() {
        return 0.0;
    }
    let largest = |vectors: &[Vec3]| vectors.iter().fold(0.0, |most: f64, v| most.max(v.amax()));
    let step = DIFFERENCE * largest(&state.v).max(1.0);
    let mut v = state.v.clone();
    let mut multiply = |w: &[Vec3], out: &mut [Vec3]| {
        out.fill(Vec3::zeros());
        let reach = step / largest(w).max(f64::MIN_POSITIVE);
        // −∂f/∂v w by a central difference, which is exact up to the second power of the speed.
        for sign in [-1.0, 1.0] {
            for ((v, start), w) in v.iter_mut().zip(&state.v).zip(w) {
                *v = start + w * (sign * reach);
            }
            for effect in drags() {
                effect.add_damping_force(drape_model::Level { v: &v, ..state.level() }, out);
            }
            if sign < 0.0 {
                out.iter_mut().for_each(|p| *p = -*p);
            }
        }
        out.iter_mut().for_each(|p| *p *= -0.5 / reach);
    };
    let mut operator = Operator { system, multiply: &mut multiply, shift: 0.0 };
    let mut mode = operator.start();
    operator.largest(&mut mode).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::parse;

    fn system_of(more: &str) -> (System, State) {
        let text = format!(
            r#"{{ "format": "drape-system/1", {more} "triangles": [[0, 1, 2]],
            "particles": {{ "mass_kg": [0.1, 0.1, 0.1],
                "position_m": [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]] }} }}"#
        );
        parse("row", &text).expect("valid").spec().build().expect("valid")
    }

    /// On a grid the products are those of the assembled matrix, which must be the same matrix.
    #[test]
    fn an_assembled_stiffness_is_that_of_the_effects() {
        let sheet = drape_model::load("hanging-textile-sheared-1e6").expect("bundled");
        let (system, mut state) = sheet.spec().build().expect("valid");
        let mut random = Lcg::new();
        let mut vector = || Vec3::from_fn(|_, _| random.signed());
        state.x.iter_mut().for_each(|x| *x += vector() * 0.01);
        let w: Vec<Vec3> = state.x.iter().map(|_| vector()).collect();
        let is_explicit = |effect: &dyn Effect| effect.name() == "shear";
        let is_any = |effect: &dyn Effect| is_stiff(effect);
        let springs = Laplacian::of(&system, &|effect| !is_explicit(effect));
        let check = |selects: &dyn Fn(&dyn Effect) -> bool, springs: Option<&Laplacian>| {
            let fast = Stiffness::new(&system, &state.x, selects, springs);
            let by_effects =
                Stiffness { system: &system, x: &state.x, selects, springs, matrix: None };
            assert!(fast.matrix.is_some());
            let product = |stiffness: &Stiffness<'_>| {
                let mut out = vec![Vec3::repeat(1.0); w.len()];
                stiffness.multiply(&w, &mut out);
                out
            };
            let (one, other) = (product(&fast), product(&by_effects));
            let size = other.iter().fold(0.0, |most: f64, p| most.max(p.amax()));
            let off =
                one.iter().zip(&other).fold(0.0, |most: f64, (p, q)| most.max((p - q).amax()));
            assert!(size > 0.0 && off <= 1e-13 * size, "{off} of {size}");
        };
        check(&is_explicit, None);
        check(&is_any, None);
        check(&is_any, Some(&springs));
    }

    const ANGLE: &str = r#""angles": [{ "effect": "bending_angle", "i": 0, "j": 1, "k": 2,
        "rest_rad": 3.141592653589793, "stiffness_n_m": 2 }],"#;

    #[test]
    fn an_explicit_angle_alone_is_compared_with_four() {
        let (system, state) = system_of(ANGLE);
        let numbers = ExplicitNumbers::new(&system, &state, &|_| true);
        let expected = 6.0 * 2.0 / (0.25 * 0.1);
        assert!((numbers.explicit_stiffness / expected - 1.0).abs() < 1e-9, "{numbers:?}");
        assert!((numbers.limit() * (expected / 4.0).sqrt() - 1.0).abs() < 1e-9, "{numbers:?}");
        assert_eq!((numbers.implicit_stiffness, numbers.drag), (0.0, 0.0));
        assert_eq!(ExplicitNumbers::new(&system, &state, &|_| false).limit(), f64::INFINITY);
    }

    #[test]
    fn implicit_springs_raise_the_limit() {
        let springs = r#""springs": [
            { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 0.5,
              "stiffness_n_per_m": 7 },
            { "effect": "tension", "i": 1, "j": 2, "rest_length_m": 0.5,
              "stiffness_n_per_m": 7 }],"#;
        let (system, state) = system_of(&format!("{springs} {ANGLE}"));
        let is_explicit = |effect: &dyn Effect| effect.name() != "tension";
        let numbers = ExplicitNumbers::new(&system, &state, &is_explicit);
        // The mode (1, −2, 1) across the springs has wᵀ L w = 7 (9 + 9), wᵀ K_S w = 0 and wᵀ w = 6.
        assert!((numbers.explicit_stiffness / 480.0 - 1.0).abs() < 1e-4, "{numbers:?}");
        assert!((numbers.implicit_stiffness / 420.0 - 1.0).abs() < 1e-4, "{numbers:?}");
        assert!((numbers.limit() * 60.0_f64.sqrt() / 2.0 - 1.0).abs() < 1e-3, "{numbers:?}");
        let stiffer = springs.replace(": 7", ": 17");
        let (system, state) = system_of(&format!("{stiffer} {ANGLE}"));
        let numbers = ExplicitNumbers::new(&system, &state, &is_explicit);
        assert_eq!(numbers.limit(), f64::INFINITY, "{numbers:?}");
    }

    /// The mode of the stiffest angle is not the mode that springs in the matrix resist least.
    #[test]
    fn the_limit_is_set_by_the_mode_with_the_greatest_difference() {
        let text = r#"{ "format": "drape-system/1",
            "springs": [
                { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 0.5,
                  "stiffness_n_per_m": 50 },
                { "effect": "tension", "i": 1, "j": 2, "rest_length_m": 0.5,
                  "stiffness_n_per_m": 50 }],
            "angles": [
                { "effect": "bending_angle", "i": 0, "j": 1, "k": 2,
                  "rest_rad": 3.141592653589793, "stiffness_n_m": 2 },
                { "effect": "bending_angle", "i": 3, "j": 4, "k": 5,
                  "rest_rad": 3.141592653589793, "stiffness_n_m": 1 }],
            "particles": { "mass_kg": [0.1, 0.1, 0.1, 0.1, 0.1, 0.1], "position_m":
                [[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 1, 0], [1, 1, 0]] } }"#;
        let (system, state) = parse("rows", text).expect("valid").spec().build().expect("valid");
        let is_explicit = |effect: &dyn Effect| effect.name() != "tension";
        let numbers = ExplicitNumbers::new(&system, &state, &is_explicit);
        assert!((numbers.explicit_stiffness / 240.0 - 1.0).abs() < 1e-3, "{numbers:?}");
        assert!(numbers.implicit_stiffness.abs() < 0.1, "{numbers:?}");
    }

    fn squares(law: &str, velocity: f64) -> (System, State) {
        let text = format!(
            r#"{{ "format": "drape-system/1", "effects": {{ "air": {{ "drag": {law} }} }},
            "triangles": [[0, 1, 2], [1, 3, 2]], "particles": {{ "mass_kg": [0.1, 0.1, 0.1, 0.1],
                "position_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]],
                "velocity_m_s": [[0, 0, {velocity}], [0, 0, {velocity}],
                    [0, 0, {velocity}], [0, 0, {velocity}]] }} }}"#
        );
        parse("air", &text).expect("valid").spec().build().expect("valid")
    }

    #[test]
    fn drag_is_compared_with_two_over_the_step() {
        let (system, state) = squares(r#"{ "linear": { "coefficient_n_s_per_m3": 3 } }"#, 0.0);
        let numbers = ExplicitNumbers::new(&system, &state, &|_| true);
        // Two triangles with κ a/9 = 1/6 meet in two particles: the eigenvalue of the mode (1, 2,
        // 2, 1) is 5/6 over the mass.
        assert!((numbers.drag * 6.0 * 0.1 / 5.0 - 1.0).abs() < 1e-6, "{numbers:?}");
        assert_eq!(numbers.limit(), 2.0 / numbers.drag);
        assert_eq!(numbers.stiffness_limit(), f64::INFINITY);
    }

    #[test]
    fn a_drag_with_the_square_of_the_speed_counts_by_its_slope() {
        let law = r#"{ "quadratic": { "coefficient": 2, "density_kg_m3": 1.5 } }"#;
        let (system, state) = squares(law, -2.0);
        let numbers = ExplicitNumbers::new(&system, &state, &|_| true);
        // ½ ρ C u² has the slope 6: twice the coefficient 3 above.
        assert!((numbers.drag * 6.0 * 0.1 / 10.0 - 1.0).abs() < 1e-6, "{numbers:?}");
        let (system, state) = squares(law, 0.0);
        let numbers = ExplicitNumbers::new(&system, &state, &|_| true);
        assert!(numbers.limit() > 1e4, "still air has no slope: {numbers:?}");
    }
}
