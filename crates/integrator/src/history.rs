//! The past of a multistep method.

use drape_model::{Revisions, System, Vec3};
use drape_solvers::bands::{bands, in_bands};
use std::ops::RangeInclusive;

#[derive(Clone, Debug)]
struct Entry<const FIELDS: usize> {
    fields: [Vec<Vec3>; FIELDS],
    step: f64,
}

/// The last levels of a multistep method, newest first. A level has `FIELDS` block vectors (say
/// positions and velocities), and the length of the step that led away from it.
///
/// The present level, from which the next step starts, is not stored. The caller pushes it when it
/// takes the step.
///
/// ```
/// use drape_integrator::History;
/// use drape_model::Vec3;
/// let mut history = History::<1>::new(1, 2);
/// for x in 1..=3 {
///     history.push(0.1 * f64::from(x), [&[Vec3::x() * f64::from(x)]]);
/// }
/// assert_eq!(history.len(), 2); // only two levels are kept
/// assert_eq!((history.field(0, 0)[0].x, history.field(1, 0)[0].x), (3.0, 2.0));
/// assert_eq!(history.step(1), 0.2);
/// ```
#[derive(Clone, Debug)]
pub struct History<const FIELDS: usize> {
    levels: Vec<Entry<FIELDS>>,
    len: usize,
    revisions: Option<Revisions>,
    /// Parts of an update that threads share.
    bands: usize,
}

impl<const FIELDS: usize> History<FIELDS> {
    /// Memory for `depth` levels of `n` particles; empty. A depth of 0 keeps nothing.
    pub fn new(n: usize, depth: usize) -> Self {
        let level = || Entry { fields: std::array::from_fn(|_| vec![Vec3::zeros(); n]), step: 0.0 };
        let levels = (0..depth).map(|_| level()).collect();
        Self { levels, len: 0, revisions: None, bands: 1 }
    }

    /// Copies another history of the same size and depth without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        for (level, other) in self.levels.iter_mut().zip(&other.levels) {
            level.step = other.step;
            for (field, other) in level.fields.iter_mut().zip(&other.fields) {
                field.copy_from_slice(other);
            }
        }
        (self.len, self.revisions) = (other.len, other.revisions);
        self.bands = other.bands;
    }

    /// Forgets all levels.
    pub fn restart(&mut self) {
        self.len = 0;
    }

    /// Forgets all levels that a step of `h` seconds cannot use. The past ends if any part of the
    /// system has changed since the last call, because velocities then have a kink and
    /// accelerations a jump. It also ends if the ratio of step sizes lies outside of `ratios`.
    pub fn refresh(&mut self, system: &System, h: f64, ratios: RangeInclusive<f64>) {
        self.bands = bands(system.threads(), system.len());
        let revisions = Some(system.revisions());
        let changed = std::mem::replace(&mut self.revisions, revisions) != revisions;
        if changed || (self.len > 0 && !ratios.contains(&(h / self.step(0)))) {
            self.restart();
        }
    }

    /// Number of known levels.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether no level is known.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// A field of a level; `age` 0 is the newest level.
    ///
    /// # Panics
    /// If there is no such level or field.
    pub fn field(&self, age: usize, field: usize) -> &[Vec3] {
        &self.levels[..self.len][age].fields[field]
    }

    /// The length of the step that led from a level to the next one, s.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn step(&self, age: usize) -> f64 {
        self.levels[..self.len][age].step
    }

    /// Weighted mean `Σ_j w_j y_j` of a field over the last levels, oldest first. The last weight
    /// belongs to `present`. The weights sum to 1; weights of unknown levels are ignored.
    ///
    /// The sum is computed as `present + Σ_j w_j (y_j − present)`. So a constant is its own mean to
    /// the last bit, and a particle at rest stays at rest.
    ///
    /// # Panics
    /// If there is no such field.
    pub fn mean(&self, field: usize, present: &[Vec3], weights: &[f64], out: &mut [Vec3]) {
        in_bands(self.bands, out.len(), out, &|band, out: &mut [Vec3]| {
            let present = &present[band.clone()];
            out.copy_from_slice(present);
            let older = weights.iter().rev().skip(1);
            for (level, &weight) in self.levels[..self.len].iter().zip(older) {
                let past = &level.fields[field][band.clone()];
                for ((out, y), present) in out.iter_mut().zip(past).zip(present) {
                    *out += (y - present) * weight;
                }
            }
        });
    }

    /// Stores the level that a step of `h` seconds is about to leave. Drops the oldest level if
    /// there is no room.
    pub fn push(&mut self, h: f64, fields: [&[Vec3]; FIELDS]) {
        if let Some(oldest) = self.levels.last_mut() {
            oldest.step = h;
            for (kept, field) in oldest.fields.iter_mut().zip(fields) {
                in_bands(self.bands, kept.len(), &mut kept[..], &|band, kept: &mut [Vec3]| {
                    kept.copy_from_slice(&field[band]);
                });
            }
            self.levels.rotate_right(1);
            self.len = (self.len + 1).min(self.levels.len());
        }
    }

    /// Replaces the past of one particle in all levels, say after a contact changed its velocity.
    /// `past` receives the age of a level, s, counted back from the end of the newest level's step.
    pub fn rewrite(&mut self, particle: usize, past: impl Fn(f64) -> [Vec3; FIELDS]) {
        let mut age = 0.0;
        for level in &mut self.levels[..self.len] {
            age += level.step;
            for (field, value) in level.fields.iter_mut().zip(past(age)) {
                field[particle] = value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_model::{EffectKind, parse};

    fn pair() -> System {
        let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [1, 1],
            "position_m": [[0, 0, 0], [1, 0, 0]] }, "springs": [
            { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
             "stiffness_n_per_m": 1, "damping_n_s_per_m": 1 }] }"#;
        parse("pair", text).expect("valid").spec().build().expect("valid").0
    }

    fn filled(depth: usize, steps: &[f64]) -> History<2> {
        let mut history = History::new(2, depth);
        for (level, &h) in steps.iter().enumerate() {
            let x = [Vec3::x() * level as f64, Vec3::y()];
            history.push(h, [&x, &[Vec3::z() * h; 2]]);
        }
        history
    }

    #[test]
    fn levels_are_kept_newest_first_with_all_their_fields_up_to_the_depth() {
        for depth in 0..4 {
            let history = filled(depth, &[0.1, 0.2, 0.3, 0.4, 0.5]);
            assert_eq!((history.len(), history.is_empty()), (depth, depth == 0));
            for age in 0..depth {
                let h = [0.5, 0.4, 0.3][age];
                assert_eq!(history.step(age), h);
                assert_eq!(history.field(age, 0), [Vec3::x() * (4 - age) as f64, Vec3::y()]);
                assert_eq!(history.field(age, 1), [Vec3::z() * h; 2]);
            }
        }
    }

    #[test]
    fn a_restart_forgets_all_levels_and_starts_to_count_anew() {
        let mut history = filled(3, &[0.1, 0.2, 0.3]);
        history.restart();
        assert!(history.is_empty());
        history.push(0.7, [&[Vec3::zeros(); 2]; 2]);
        assert_eq!((history.len(), history.step(0)), (1, 0.7));
    }

    #[test]
    fn a_mean_takes_the_weights_oldest_first_and_the_last_for_the_present() {
        let history = filled(3, &[0.5, 0.25, 2.0]);
        let mut out = [Vec3::zeros(); 2];
        history.mean(1, &[Vec3::x(); 2], &[1.0, 2.0, 4.0, -6.0], &mut out);
        assert_eq!(out, [Vec3::new(-6.0, 0.0, 0.5 + 2.0 * 0.25 + 4.0 * 2.0); 2]);
        // A level that is not known leaves its weight to the present.
        let history = filled(1, &[0.5, 0.25]);
        history.mean(1, &[Vec3::x(); 2], &[0.5, 0.25, 0.25], &mut out);
        assert_eq!(out, [Vec3::new(0.75, 0.0, 0.0625); 2]);
        history.mean(1, &[Vec3::x(); 2], &[1.0], &mut out);
        assert_eq!(out, [Vec3::x(); 2]);
    }

    #[test]
    fn the_mean_of_what_rests_is_the_same_to_the_last_bit() {
        let x = [Vec3::new(0.1, 1.0 / 3.0, -7.0e5)];
        let mut history = History::new(1, 2);
        history.push(0.1, [&x]);
        history.push(0.1, [&x]);
        let mut out = [Vec3::zeros()];
        history.mean(0, &x, &[5.0 / 12.0, -16.0 / 12.0, 23.0 / 12.0], &mut out);
        assert_eq!(out, x);
    }

    #[test]
    fn rewriting_reaches_all_levels_of_one_particle_at_their_ages() {
        let mut history = filled(3, &[0.5, 0.25, 2.0]);
        let before = history.clone();
        history.rewrite(1, |age| [Vec3::x() * age, Vec3::y() * -age]);
        for (level, age) in [2.0, 2.25, 2.75].into_iter().enumerate() {
            assert_eq!(history.field(level, 0)[1], Vec3::x() * age);
            assert_eq!(history.field(level, 1)[1], Vec3::y() * -age);
            assert_eq!(history.field(level, 0)[0], before.field(level, 0)[0]);
            assert_eq!(history.field(level, 1)[0], before.field(level, 1)[0]);
        }
    }

    #[test]
    fn levels_survive_until_the_system_or_the_step_size_changes_too_much() {
        let mut system = pair();
        let kept = |history: &mut History<2>, system: &System, h: f64| {
            history.refresh(system, h, 0.5..=2.0);
            let kept = !history.is_empty();
            history.push(h, [&[Vec3::zeros(); 2]; 2]);
            kept
        };
        let mut history = History::new(2, 2);
        assert!(!kept(&mut history, &system, 1.0), "there is no past");
        for (h, expected) in [(1.0, true), (2.0, true), (1.0, true), (0.49, false), (0.99, false)] {
            assert_eq!(kept(&mut history, &system, h), expected, "h = {h}");
        }
        let changes: [fn(&mut System) -> bool; 4] = [
            |system| system.scale_stiffness(EffectKind::Tension, 2.0),
            |system| system.scale_damping(EffectKind::Tension, 2.0),
            |system| system.set_mass(&[1.0, 2.0]),
            |system| system.set_pinned(0, true),
        ];
        for (number, change) in changes.iter().enumerate() {
            assert!(kept(&mut history, &system, 0.99) && change(&mut system));
            assert!(!kept(&mut history, &system, 0.99), "change {number}");
        }
    }
}
