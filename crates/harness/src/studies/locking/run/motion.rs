//! The hanging sheet: its true motion, and the runs of a method.

use super::law::{lever, swing_lever};
use super::{BACKWARD_EULER, BASE_STEP};
use crate::methods::Choice;
use crate::methods::runs::Variant;
use crate::run::{Runner, Simulation};
use crate::stability::gershgorin;
use crate::studies::finite;
use crate::studies::locking::facts::{self, IMEX_EULER, Run};
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::{HarnessError, system_hash};
use drape_model::{DampingLaw, SystemSpec, TimeSpan, Vec3};
use drape_report::Verdict;

/// Particles along each edge, as in the paper's hanging textile.
pub(super) const SIDE: u32 = 20;
const SHEAR: f64 = 0.1;
/// Damping over mass of the tension springs as in the paper, 1/s.
const DAMPING: f64 = 40.0;
const DURATION: f64 = 1.0;
/// Time between two positions on a path, s.
const STRIDE: f64 = 0.01;
/// Longest step of the reference, s, and its share of the stability limit.
const LONGEST: f64 = 1e-4;
const SAFETY: f64 = 0.25;
/// A run that retains less than this share of the motion counts as locked.
const HALF: f64 = 0.5;
/// Effort after which a run is over budget, in visits of a spring.
pub(super) const BUDGET: f64 = 1.3e9;
/// Time at which an independent prototype took the height, s.
const EARLY: f64 = 0.3;
/// Start of the time over which the late speed of fall is averaged, s.
const LATE: f64 = 0.5;

/// Length of the midpoint's path in one second, m, in an independent prototype without safeguards,
/// at h = 0.01 s and by k/m.
const PROTOTYPE: [(f64, [f64; 4]); 7] = [
    (1e2, [4.947, 4.948, 4.947, 4.947]),
    (1e3, [4.823, 4.859, 4.859, 4.859]),
    (1e4, [2.914, 3.226, 3.229, 3.226]),
    (1e5, [1.071, 2.933, 2.908, 2.933]),
    (1e6, [0.224, 2.664, 2.618, 2.664]),
    (1e7, [0.033, 2.643, 2.294, 2.642]),
    (1e8, [0.003, 4.2, 1.912, 2.635]),
];
/// Labels of the methods in the columns of [`PROTOTYPE`].
const COLUMNS: [&str; 4] = [IMEX_EULER, "imex-updated", "baraff-witkin", BACKWARD_EULER];

fn prototype_path(label: &str, stiffness: f64) -> Option<f64> {
    let column = COLUMNS.iter().position(|known| *known == label)?;
    let row = PROTOTYPE.iter().find(|(k, _)| *k == stiffness)?;
    Some(row.1[column])
}

/// Positions of the midpoint of the free edge, every [`STRIDE`].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Way(Vec<Vec3>);

impl Way {
    pub(super) fn path(&self) -> f64 {
        self.0.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }

    /// Height above the start at a time between the first and the last, m.
    pub(super) fn height(&self, time: f64) -> f64 {
        let place = time / STRIDE;
        let last = self.0.len() - 1;
        let below = (place.floor() as usize).min(last);
        let above = (below + 1).min(last);
        let (low, high) = (self.0[below].z, self.0[above].z);
        low + (place - below as f64) * (high - low) - self.0[0].z
    }

    /// Time at which the midpoint has first fallen half of its greatest fall, s.
    pub(super) fn half_fall(&self) -> f64 {
        let start = self.0[0].z;
        let falls: Vec<f64> = self.0.iter().map(|x| start - x.z).collect();
        let half = 0.5 * falls.iter().copied().fold(0.0, f64::max);
        let after = falls.iter().position(|fall| *fall >= half).unwrap_or(0).max(1);
        let (before, next) = (falls[after - 1], falls[after]);
        let share = if next > before { (half - before) / (next - before) } else { 0.0 };
        (after as f64 - 1.0 + share) * STRIDE
    }
}

/// A hanging sheet with its true motion.
pub(super) struct Setting {
    pub(super) sheet: facts::Sheet,
    pub(super) hash: String,
    simulation: Simulation,
    way: Way,
    /// `E_ref`, J.
    released: f64,
}

/// Makes a run and records the positions of the midpoint, as far as the run comes.
fn follow(
    simulation: &Simulation,
    choice: &Choice,
    step_s: f64,
    limit: Option<f64>,
) -> Result<(crate::Counts, Way), HarnessError> {
    let midpoint = ((SIDE - 1) * SIDE + SIDE / 2) as usize;
    let every = (STRIDE / step_s).round().max(1.0) as u64;
    let mut way = vec![simulation.state.x[midpoint]];
    let time = TimeSpan { step_s, duration_s: DURATION };
    let runner = Runner::new(choice, time).budget(limit).observe(|moment| {
        if moment.step % every == 0 {
            way.push(moment.state.x[midpoint]);
        }
    });
    let counts = runner.count(simulation)?;
    Ok((counts, Way(way)))
}

/// The system of the sheet at its start.
pub(super) fn spec(stiffness: f64) -> Result<SystemSpec, HarnessError> {
    Sheet {
        side: SIDE,
        tension: stiffness,
        shear: SHEAR * stiffness,
        damping: DAMPING,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    }
    .spec()
}

impl Setting {
    pub(super) fn new(stiffness: f64) -> Result<Self, HarnessError> {
        let spec = spec(stiffness)?;
        let (system, state) = spec.build()?;
        let simulation = Simulation { system, state };
        let (bound, damping) = gershgorin(&simulation.system);
        let limit = 4.0 / (damping + (damping * damping + 4.0 * bound).sqrt());
        // A whole number of steps, even of doubled steps, must lead from one position to the next.
        let half_steps = (STRIDE / (2.0 * (SAFETY * limit).min(LONGEST))).ceil();
        let step = STRIDE / (2.0 * half_steps);
        let choice = Choice::parse("symplectic-euler", &[])?;
        let (counts, way) = follow(&simulation, &choice, step, None)?;
        let (_, coarse) = follow(&simulation, &choice, 2.0 * step, None)?;
        let midpoint = ((SIDE - 1) * SIDE + SIDE / 2) as usize;
        let sheet = facts::Sheet {
            stiffness_over_mass_per_s2: stiffness,
            damping_over_mass_per_s: DAMPING,
            side: SIDE,
            path_m: way.path(),
            path_error_m: (way.path() - coarse.path()).abs(),
            half_fall_s: way.half_fall(),
            reference_step_s: step,
            lever: lever(&simulation.system, stiffness)[midpoint],
            swing_lever: swing_lever(SIDE),
            portable: true,
        };
        let released = counts.energy.released;
        Ok(Self { sheet, hash: system_hash(&spec), simulation, way, released })
    }

    pub(super) fn stiffness(&self) -> f64 {
        self.sheet.stiffness_over_mass_per_s2
    }

    /// Terminal speed of the law at a step, m/s.
    fn law(&self, step: f64) -> f64 {
        -GRAVITY[2] * self.sheet.lever / (step * self.stiffness())
    }

    pub(super) fn run(&self, variant: &Variant, step: f64) -> Result<Run, HarnessError> {
        let choice = Choice::parse(variant.method, &[])?;
        let (counts, way) = follow(&self.simulation, &choice, step, Some(BUDGET))?;
        let is_whole = counts.outcome.divergence.is_none() && !counts.outcome.is_over_budget;
        let retained = way.path() / self.sheet.path_m;
        let judged = counts.verdict(self.released);
        let verdict = match judged {
            Verdict::Stable | Verdict::Marginal if counts.outcome.is_over_budget => {
                Verdict::OverBudget
            }
            Verdict::Stable if retained < HALF => Verdict::Locked,
            other => other,
        };
        let half = self.sheet.half_fall_s;
        Ok(Run {
            label: variant.label.to_owned(),
            method: choice.full_id(),
            stiffness_over_mass_per_s2: self.stiffness(),
            step_s: step,
            path_m: is_whole.then(|| way.path()),
            retained: is_whole.then_some(retained),
            retained_beside_backward_euler: None,
            retained_fall: is_whole.then(|| way.height(half) / self.way.height(half)),
            height_m: is_whole.then(|| way.height(EARLY)),
            prototype_path_m: (step == BASE_STEP)
                .then(|| prototype_path(variant.label, self.stiffness()))
                .flatten(),
            late_speed_m_s: is_whole
                .then(|| (way.height(LATE) - way.height(DURATION)) / (DURATION - LATE)),
            law_m_s: self.law(step),
            verdict,
            gain: finite(counts.energy.gain / self.released),
            unconverged_steps: counts.outcome.unconverged,
            portable: choice.is_portable(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(heights: &[f64]) -> Way {
        Way(heights.iter().map(|z| Vec3::new(1.0, 0.0, *z)).collect())
    }

    #[test]
    fn path_height_and_half_of_the_fall_are_read_off_the_positions() {
        let way = way(&[2.0, 1.0, 0.0, -2.0, -1.0]);
        assert_eq!(way.path(), 5.0);
        assert!((way.height(0.025) + 3.0).abs() < 1e-12);
        assert_eq!(way.height(0.04), -3.0);
        assert!((way.half_fall() - 0.02).abs() < 1e-12, "{}", way.half_fall());
    }
}
