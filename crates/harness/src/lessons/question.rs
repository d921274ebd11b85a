//! The questions of lessons, and the marks for answers.

use super::{Lesson, Setting};
use crate::methods::Choice;
use crate::scenes::bundled;
use drape_report::number::significant;

/// A spectral radius above 1 by no more than this is round-off: a double root is accurate only to
/// the square root of the precision.
const ROUND_OFF: f64 = 1e-6;
/// Least and greatest step of the search for the longest stable one, s.
const STEPS_S: (f64, f64) = (1e-4, 10.0);
/// Ratio of two successive steps of that search.
const RATIO: f64 = 1.005;

/// What a lesson asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The longest step at which no oscillation grows, s.
    LongestStep,
    /// The share of the energy at the start that is left at the end, %.
    EnergyLeft,
    /// The energy lost until the end, over the energy lost with half of the step.
    LossRatio,
    /// The period of the oscillation, s.
    Period,
    /// The greatest elongation of the spring, %.
    GreatestStretch,
    /// The speed of the loaded particle at the end, mm/s.
    Speed,
}

/// The mark for an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Whether it is accepted.
    pub is_right: bool,
    /// The answer that theory gives, or a hint.
    pub sentence: String,
}

impl Question {
    /// Greatest relative error of an accepted answer.
    pub fn tolerance(self) -> f64 {
        match self {
            Self::EnergyLeft | Self::Period => 0.03,
            Self::GreatestStretch => 0.02,
            Self::LongestStep | Self::LossRatio | Self::Speed => 0.05,
        }
    }

    /// The unit of the answer; empty for a plain number.
    pub fn unit(self) -> &'static str {
        match self {
            Self::LongestStep | Self::Period => "s",
            Self::EnergyLeft | Self::GreatestStretch => "%",
            Self::LossRatio => "",
            Self::Speed => "mm/s",
        }
    }

    /// The question about a setting.
    pub fn text(self, setting: &Setting) -> String {
        let Setting { methods, stiffness, damping, step, duration, .. } = setting;
        let id = methods.first().copied().unwrap_or_default();
        let spring = match *damping {
            0.0 => format!("k/m = {stiffness} 1/s² without damping"),
            damping => format!("k/m = {stiffness} 1/s² and d/m = {damping} 1/s"),
        };
        match self {
            Self::LongestStep => {
                format!("With {spring}: what is the longest step, in s, at which {id} is stable?")
            }
            Self::EnergyLeft => format!(
                "With {spring} and steps of {step} s: how much of its energy has {id} left after \
                 {duration} s, in %?"
            ),
            Self::LossRatio => format!(
                "With {spring}: {id} loses energy in {duration} s. How many times as much does it \
                 lose with steps of {step} s as with steps of {} s?",
                0.5 * step
            ),
            Self::Period => format!(
                "With {spring} and steps of {step} s: how long does {id} take for one \
                 oscillation, in s?"
            ),
            Self::GreatestStretch => format!(
                "With {spring} and steps of {step} s: what is the greatest stretch of the spring \
                 with {id}, in %?"
            ),
            Self::Speed => format!(
                "With {spring} and steps of {step} s: how fast does the particle fall with {id} \
                 after {duration} s, in mm/s?"
            ),
        }
    }

    /// How to find the answer in the lab.
    pub fn way(self) -> &'static str {
        match self {
            Self::LongestStep => {
                "Change the time step h and let the panes run. Beyond the limit the total energy \
                 grows; halve the interval between a stable step and an unstable one."
            }
            Self::EnergyLeft => {
                "Play to the end and read the total energy of the first pane. It starts with 1 J, \
                 so the number in joules is the share."
            }
            Self::LossRatio => {
                "Play to the end, note the total energy and subtract it from 1 J. Halve the step \
                 and do it again. Divide the two losses."
            }
            Self::Period => {
                "Press Step and count: after how many steps does the greatest stretch of the \
                 first pane come back, on its way from shorter to longer?"
            }
            Self::GreatestStretch => {
                "Play, and watch the greatest stretch of the first pane. Then go back in time to \
                 its largest value."
            }
            Self::Speed => {
                "Play to the end and read the kinetic energy of the first pane. The particle has \
                 2 kg, so its speed in m/s is the square root of the energy in joules."
            }
        }
    }
}

impl Lesson {
    /// The right answer, in the unit of the question; NaN if theory has none.
    pub fn answer(&self) -> f64 {
        let setting = &self.setting;
        let (theta, eta) = setting.numbers(setting.step);
        let steps = setting.steps();
        match self.question {
            Question::LongestStep => self.longest_step(),
            Question::EnergyLeft => self.law.left(setting),
            Question::LossRatio => {
                let (less, slower) = setting.numbers(0.5 * setting.step);
                let loss = 1.0 - self.law.energy(theta, eta, steps);
                loss / (1.0 - self.law.energy(less, slower, 2 * steps))
            }
            Question::Period => std::f64::consts::TAU * setting.step / self.law.angle(theta, eta),
            Question::GreatestStretch => {
                let choice = Choice::parse(setting.methods.first().unwrap_or(&""), &[]);
                choice.map_or(f64::NAN, |choice| 100.0 * choice.settings().number("limit"))
            }
            Question::Speed => {
                let fall = setting.step * gravity(setting.scene);
                let law = self.load.map(|law| law.speed(theta, steps));
                1e3 * fall * law.unwrap_or(f64::NAN)
            }
        }
    }

    /// The last step below which no oscillation grows, s.
    fn longest_step(&self) -> f64 {
        let is_stable = |h: f64| {
            let (theta, eta) = self.setting.numbers(h);
            self.law.radius(theta, eta) <= 1.0 + ROUND_OFF
        };
        let (least, most) = STEPS_S;
        let mut stable = least;
        let mut unstable = least;
        while is_stable(unstable) {
            if unstable > most {
                return f64::INFINITY;
            }
            (stable, unstable) = (unstable, RATIO * unstable);
        }
        for _ in 0..50 {
            let middle = 0.5 * (stable + unstable);
            if is_stable(middle) { stable = middle } else { unstable = middle }
        }
        stable
    }

    /// Marks an answer in the unit of the question.
    ///
    /// # Errors
    /// A sentence, where the answer is not a finite number.
    pub fn mark(&self, given: f64) -> Result<Mark, String> {
        if !given.is_finite() {
            return Err(format!("value: {given}; expected a finite number"));
        }
        let (answer, tolerance) = (self.answer(), self.question.tolerance());
        let is_near = |value: f64| (given - value).abs() <= tolerance * value.abs();
        if is_near(answer) {
            let (number, unit) = (significant(answer, 3), self.question.unit());
            let space = if unit.is_empty() { "" } else { " " };
            let sentence = format!(
                "Right: theory gives {number}{space}{unit}. Answers within {} % are accepted.",
                100.0 * tolerance
            );
            return Ok(Mark { is_right: true, sentence });
        }
        let trap = self.traps.iter().find(|trap| is_near((trap.value)(&self.setting)));
        let hint = match trap {
            Some(trap) => trap.hint,
            None if given < answer => self.low,
            None => self.high,
        };
        Ok(Mark { is_right: false, sentence: format!("Not yet. {hint}") })
    }
}

/// The acceleration of gravity in a bundled scene, m/s²; 0 where it has none.
pub(crate) fn gravity(scene: &str) -> f64 {
    let gravity = bundled(scene).ok().and_then(|scene| scene.effects.gravity);
    gravity.map_or(0.0, |gravity| gravity.m_s2.iter().map(|a| a * a).sum::<f64>().sqrt())
}
