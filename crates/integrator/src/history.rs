//! The past of a multistep method.

use drape_model::Vec3;

#[derive(Clone, Debug)]
struct Level<const FIELDS: usize> {
    fields: [Vec<Vec3>; FIELDS],
    step: f64,
}

/// The last levels of a multistep method, newest first: `FIELDS` block vectors a level (say positions and
/// velocities), and the step that led away from it.
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
    levels: Vec<Level<FIELDS>>,
    len: usize,
}

impl<const FIELDS: usize> History<FIELDS> {
    /// Memory for `depth` levels of `n` particles; empty.
    pub fn new(n: usize, depth: usize) -> Self {
        let level = || Level { fields: std::array::from_fn(|_| vec![Vec3::zeros(); n]), step: 0.0 };
        Self { levels: (0..depth).map(|_| level()).collect(), len: 0 }
    }

    /// Forgets all levels.
    pub fn restart(&mut self) {
        self.len = 0;
    }

    /// Number of levels that are known.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether no level is known.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// A field of a level, `age` 0 being the newest.
    ///
    /// # Panics
    /// When there is no such level or field.
    pub fn field(&self, age: usize, field: usize) -> &[Vec3] {
        &self.levels[..self.len][age].fields[field]
    }

    /// The step that led from a level to the one after it, s.
    ///
    /// # Panics
    /// When there is no such level.
    pub fn step(&self, age: usize) -> f64 {
        self.levels[..self.len][age].step
    }

    /// Remembers the level that a step of length `h` (s) is about to leave, and drops the oldest where
    /// there is no room.
    pub fn push(&mut self, h: f64, fields: [&[Vec3]; FIELDS]) {
        self.levels.rotate_right(1);
        self.len = (self.len + 1).min(self.levels.len());
        if let Some(newest) = self.levels.first_mut() {
            newest.step = h;
            for (kept, field) in newest.fields.iter_mut().zip(fields) {
                kept.copy_from_slice(field);
            }
        }
    }

    /// Replaces what all levels hold of one particle, say after a contact changed its velocity: `past` is
    /// given how long ago a level was, s, counted from the end of the newest level's step.
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
