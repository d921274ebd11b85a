//! The schedule of a run: its step sizes, and the changes of stiffness.

use drape_model::{SpringEffect, System, TimeSpan, Vec3};

/// A change of all springs' stiffness from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Change {
    /// Time from the start, s. The step that begins nearest to it is the first with the new
    /// stiffness.
    pub(crate) time_s: f64,
    /// Factor on the stiffness; positive.
    pub(crate) factor: f64,
}

impl Change {
    /// Makes the change at positions `x`; returns the work that it did on the springs, J.
    pub(crate) fn apply(self, system: &mut System, x: &[Vec3]) -> f64 {
        let before = system.potential_energy(x);
        for effect in SpringEffect::ALL {
            // An effect that the scene does not name has nothing to change.
            let _named = system.scale_stiffness(effect, self.factor);
        }
        system.potential_energy(x) - before
    }
}

/// Step sizes and changes of a run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Schedule {
    /// Step and duration. With a pattern, the duration is a whole number of its cycles.
    pub(crate) time: TimeSpan,
    /// Factors on the step, one for each step in turn, over and over; empty where all steps are
    /// alike.
    pub(crate) pattern: &'static [f64],
    /// Changes of the stiffness, in the order of their times.
    pub(crate) changes: &'static [Change],
}

impl Schedule {
    /// A schedule with steps of one length and no change.
    pub(crate) fn steady(time: TimeSpan) -> Self {
        Self { time, pattern: &[], changes: &[] }
    }

    /// Duration of one cycle of the pattern in steps of `time.step_s`.
    fn cycle(&self) -> f64 {
        self.pattern.iter().sum()
    }

    /// Number of steps.
    pub(crate) fn steps(&self) -> u64 {
        if self.pattern.is_empty() {
            let (whole, rest) = self.time.steps();
            return whole + u64::from(rest.is_some());
        }
        let cycles = (self.time.duration_s / (self.time.step_s * self.cycle())).round();
        cycles as u64 * self.pattern.len() as u64
    }

    /// Length of a step, s; steps count from 1.
    pub(crate) fn step(&self, step: u64) -> f64 {
        if self.pattern.is_empty() {
            let (whole, rest) = self.time.steps();
            return rest.filter(|_| step > whole).unwrap_or(self.time.step_s);
        }
        self.time.step_s * self.pattern[((step - 1) % self.pattern.len() as u64) as usize]
    }

    /// Time from the start after a number of steps, s. Multiples of `h` do not drift, as sums
    /// would.
    pub(crate) fn elapsed(&self, steps: u64) -> f64 {
        if self.pattern.is_empty() {
            let is_last = steps == self.steps();
            return if is_last { self.time.duration_s } else { steps as f64 * self.time.step_s };
        }
        let length = self.pattern.len() as u64;
        let begun: f64 = self.pattern[..(steps % length) as usize].iter().sum();
        self.time.step_s * ((steps / length) as f64 * self.cycle() + begun)
    }

    /// The greatest factor of the stiffness over the run, at least that of the start, 1.
    pub(crate) fn greatest_stiffness(&self) -> f64 {
        let (mut now, mut greatest) = (1.0, 1.0_f64);
        for change in self.changes {
            now *= change.factor;
            greatest = greatest.max(now);
        }
        greatest
    }

    /// Number of the changes that are due when `elapsed` seconds have passed.
    pub(crate) fn due(&self, elapsed: f64) -> usize {
        let half = 0.5 * self.time.step_s;
        self.changes.iter().take_while(|change| change.time_s < elapsed + half).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_fill_the_duration() {
        let time = |step_s, duration_s| TimeSpan { step_s, duration_s };
        let cases = [
            (Schedule::steady(time(0.01, 2.0)), 200),
            (Schedule::steady(time(0.3, 1.0)), 4),
            (
                Schedule { pattern: &[1.0, 2.0, 1.0, 0.5], ..Schedule::steady(time(0.01, 2.25)) },
                200,
            ),
        ];
        for (schedule, steps) in cases {
            assert_eq!(schedule.steps(), steps, "{schedule:?}");
            let mut sum = 0.0;
            for step in 1..=steps {
                sum += schedule.step(step);
                assert!((schedule.elapsed(step) - sum).abs() < 1e-12, "{schedule:?} at {step}");
            }
            assert!((sum - schedule.time.duration_s).abs() < 1e-12, "{schedule:?}: {sum}");
        }
    }

    #[test]
    fn a_change_is_due_at_the_step_that_begins_next_to_it() {
        const ON_STEPS: [Change; 2] =
            [Change { time_s: 0.7, factor: 100.0 }, Change { time_s: 1.4, factor: 0.01 }];
        const BESIDE_STEPS: [Change; 2] =
            [Change { time_s: 0.704, factor: 100.0 }, Change { time_s: 1.396, factor: 0.01 }];
        let time = TimeSpan { step_s: 0.01, duration_s: 2.0 };
        for changes in [&ON_STEPS, &BESIDE_STEPS] {
            let schedule = Schedule { changes, ..Schedule::steady(time) };
            let due = [0, 69, 70, 139, 140, 199].map(|n| schedule.due(schedule.elapsed(n)));
            assert_eq!(due, [0, 0, 1, 1, 2, 2], "{schedule:?}");
        }
    }

    #[test]
    fn changes_of_the_stiffness_multiply() {
        const CHANGES: [Change; 3] = [
            Change { time_s: 0.1, factor: 10.0 },
            Change { time_s: 0.2, factor: 20.0 },
            Change { time_s: 0.3, factor: 0.001 },
        ];
        let schedule = Schedule {
            changes: &CHANGES,
            ..Schedule::steady(TimeSpan { step_s: 0.01, duration_s: 1.0 })
        };
        assert_eq!(schedule.greatest_stiffness(), 200.0);
    }
}
