//! Which stiffness the scalar matrix contains for springs with several slopes.

use crate::{Declared, Implicit, Word, declare};
use drape_model::{Effect, System, Vec3};

/// The split `f = −L_K x + F2(x)` of springs with piecewise-linear tension. Any `K` is consistent,
/// because `F2` holds the rest. For linear springs both variants are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// The steepest slope of each spring: the matrix is constant, and the energy theorem holds.
    Majorant,
    /// The slope of each spring at the start of the step, as in EEH section 5. The matrix changes
    /// whenever a spring reaches another piece. If that piece is steeper, no bound on the energy
    /// holds.
    Paper,
}

impl Word for Split {
    const WORDS: &'static [(&'static str, Self)] =
        &[("majorant", Self::Majorant), ("paper", Self::Paper)];
}

impl Split {
    /// The setting `split`.
    pub const SETTING: Declared<Self> = declare!(
        split: Split [Majorant, Paper] = Majorant,
        "stiffness in the matrix of springs with piecewise-linear tension: the steepest slope, or \
         the slope of the present piece, with a new matrix whenever a spring changes piece"
    );
}

/// The slopes of the implicit springs at the start of a step, in the order of
/// [`Implicit::visit_weights`].
#[derive(Clone, Debug)]
pub struct Slopes {
    implicit: Implicit,
    /// N/m.
    list: Vec<f64>,
}

impl Slopes {
    /// Memory for a system; `None` if the split does not need slopes, or if every spring has only
    /// one.
    pub fn new(system: &System, implicit: Implicit, split: Split) -> Option<Self> {
        let varies = |effect: &dyn Effect| effect.split().is_some_and(|s| !s.has_one_slope());
        (split == Split::Paper && implicit.effects(system).any(varies)).then(|| {
            let mut list = Vec::new();
            implicit.visit_weights(system, &mut |_, _, k, _| list.push(k));
            Self { implicit, list }
        })
    }

    /// Evaluates the slopes at `x`, m. Returns whether one has changed.
    pub fn update(&mut self, system: &System, x: &[Vec3]) -> bool {
        let mut places = self.list.iter_mut();
        let mut changed = false;
        for split in self.implicit.effects(system).filter_map(Effect::split) {
            split.visit_slopes(x, &mut |_, _, slope, _| {
                if let Some(place) = places.next() {
                    changed |= *place != slope;
                    *place = slope;
                }
            });
        }
        changed
    }

    /// As [`Implicit::visit_weights`], with the slopes in place of the stiffnesses.
    pub fn visit_weights(&self, system: &System, visit: &mut dyn FnMut(usize, usize, f64, f64)) {
        let mut slopes = self.list.iter();
        self.implicit.visit_weights(system, &mut |i, j, k, c| {
            visit(i, j, slopes.next().copied().unwrap_or(k), c);
        });
    }

    /// Adds `F2 = F + L_K x`, N, to `out`: the force of the implicit springs at `x` without the
    /// linear part of these slopes.
    pub fn add_nonlinear_forces(&self, system: &System, x: &[Vec3], out: &mut [Vec3]) {
        self.implicit.add_implicit_forces(system, x, out);
        self.visit_weights(system, &mut |i, j, k, _| {
            let f = (x[i] - x[j]) * k;
            out[i] += f;
            out[j] -= f;
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::State;

    fn pair(stretch: f64) -> (System, State) {
        let text = format!(
            r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [1, 1],
                "position_m": [[0, 0, 0], [{}, 0, 0]] }},
            "springs": [{{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
                "stiffness_n_per_m": 10, "pieces": [
                    {{ "up_to_strain": 0.1, "stiffness_n_per_m": 10 }},
                    {{ "stiffness_n_per_m": 1000 }}] }}] }}"#,
            1.0 + stretch
        );
        drape_model::parse("pair", &text).expect("valid").spec().build().expect("valid")
    }

    #[test]
    fn slopes_follow_the_pieces_and_split_the_force_without_a_rest() {
        let (system, _) = pair(0.0);
        let mut slopes = Slopes::new(&system, Implicit::Tension, Split::Paper).expect("pieces");
        assert!(Slopes::new(&system, Implicit::Tension, Split::Majorant).is_none());
        for (stretch, slope, changes) in
            [(0.05, 10.0, true), (0.09, 10.0, false), (0.2, 1000.0, true), (-0.5, 1.0, true)]
        {
            let x = pair(stretch).1.x;
            assert_eq!(slopes.update(&system, &x), changes, "{stretch}");
            slopes.visit_weights(&system, &mut |_, _, k, _| assert_eq!(k, slope));
            let (mut f, mut f2) = (vec![Vec3::zeros(); 2], vec![Vec3::zeros(); 2]);
            Implicit::Tension.add_implicit_forces(&system, &x, &mut f);
            slopes.add_nonlinear_forces(&system, &x, &mut f2);
            let linear = (x[0] - x[1]) * slope;
            assert!((f2[0] - linear - f[0]).norm() < 1e-12, "{stretch}");
        }
    }
}
