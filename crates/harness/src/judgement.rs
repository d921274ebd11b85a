//! The verdict on a run: stable, locked, energy gained, diverged or unknown.

use crate::methods::Choice;
use crate::record::{Judged, Judgement, Sample};
use crate::{
    Kept, LOCKED, Lever, Moment, MotionCheck, OrderedSimulation, Outcome, Rule, Unforeseen,
    WorkBalance,
};
use drape_integrator::Supports;
use drape_model::TimeSpan;
use drape_report::number::trimmed;

/// A run that keeps at least this share of the motion keeps it well.
const WELL: f64 = 0.75;
/// Below this measured share a cloth is locked, whatever theory says.
const SURELY_LOCKED: f64 = 0.35;

/// The prediction of theory about the motion that a run keeps.
#[derive(Clone, Copy, Debug)]
pub enum Expected {
    /// This share of the motion, computed from the lever.
    Share(Lever, f64),
    /// The method takes its springs at the old level, which slows no motion down.
    Explicit,
    /// Nothing, for this reason.
    Nothing(&'static str),
    /// Nothing, for this reason in the scene.
    Unforeseen(Unforeseen),
}

/// A share as per cent.
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        tiny if tiny < 0.1 => "less than 0.1 %".to_owned(),
        small if small < 1.0 => format!("{small:.1} %"),
        large => format!("{large:.0} %"),
    }
}

impl Expected {
    /// The prediction for a run from the present state.
    pub fn of(simulation: &OrderedSimulation, choice: &Choice, time: TimeSpan) -> Self {
        Self::by(|| simulation.lever(time.duration_s), choice, time)
    }

    /// The same, but computes the [lever](Lever) only where the method has implicit springs.
    pub(crate) fn by(
        lever: impl FnOnce() -> Result<Lever, Unforeseen>,
        choice: &Choice,
        time: TimeSpan,
    ) -> Self {
        if choice.method().supports == Supports::Explicit {
            return Self::Explicit;
        }
        match lever() {
            Err(reason) => Self::Unforeseen(reason),
            Ok(lever) => match lever.share(choice, time.step_s) {
                Some(share) => Self::Share(lever, share),
                None => Self::Nothing("the method blows up on a single spring"),
            },
        }
    }

    /// The share of the motion, where theory predicts one.
    pub fn share(&self) -> Option<f64> {
        match self {
            Self::Share(_, share) => Some(*share),
            Self::Explicit | Self::Nothing(_) | Self::Unforeseen(_) => None,
        }
    }

    /// The warning for a cloth that will lock.
    pub fn warning(
        &self,
        simulation: &OrderedSimulation,
        choice: &Choice,
        step: f64,
    ) -> Option<String> {
        let Self::Share(lever, share) = self else { return None };
        if *share >= LOCKED {
            return None;
        }
        let mut ways = Vec::new();
        if let Some(shorter) = lever.step_that_keeps_half(choice, step) {
            ways.push(format!("take steps of at most {shorter} s"));
        }
        if let Some(id) = simulation.lively_method(lever, step) {
            ways.push(format!("take a method that keeps the motion, such as {id}"));
        }
        let ways = match ways.join(", or ") {
            none if none.is_empty() => "take shorter steps".to_owned(),
            ways => ways,
        };
        Some(format!(
            "the cloth will lock: with h²k/m = {}, {} keeps {} of the motion by theory; {ways}",
            trimmed(simulation.theta(step), 2),
            choice.method().id,
            percent(*share)
        ))
    }

    /// The part of a reason that theory adds.
    fn told(&self) -> String {
        match self {
            Self::Share(_, share) => format!("theory expects {}", percent(*share)),
            Self::Explicit => "explicit methods do not lock".to_owned(),
            Self::Nothing(reason) => format!("theory says nothing: {reason}"),
            Self::Unforeseen(reason) => format!("theory says nothing: {reason}"),
        }
    }
}

/// Greatest rise of the total energy, over the greatest kinetic energy, without a warning: for
/// dissipative and for symplectic methods. Verdicts use the same limits.
const RISE: [f64; 2] = [0.02, 0.5];

/// From this ratio of masses on, a stop test that adds up forces sees only the heaviest particle.
const BLINDING: f64 = 1e3;

/// The numbers about the start of a run that the energy warning needs.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// A rise of the energy up to this is round-off, J.
    round_off: f64,
    /// Number of particles inside an obstacle.
    inside: usize,
    /// Mass of the heaviest free particle over that of the lightest.
    mass_ratio: f64,
}

impl Start {
    /// The numbers at the start of a simulation.
    pub fn of(simulation: &OrderedSimulation) -> Self {
        Self {
            round_off: simulation.energy_round_off(),
            inside: simulation.particles_inside_obstacles(),
            mass_ratio: simulation.mass_ratio(),
        }
    }
}

/// The energies of a run that decide whether it gained any.
#[derive(Clone, Copy, Debug)]
pub struct Extremes {
    /// Total energy at the start, J.
    pub start: f64,
    /// Greatest total energy, J.
    pub top: f64,
    /// Greatest kinetic energy, J.
    pub kinetic: f64,
}

impl Extremes {
    /// The extremes of a recorded series; `None` where it is empty.
    pub fn of(series: &[Sample]) -> Option<Self> {
        let of = |sample: &Sample, name: &str| sample.energy_j.get(name).copied().unwrap_or(0.0);
        let greatest = |name: &str| series.iter().map(|s| of(s, name)).fold(0.0, f64::max);
        let start = of(series.first()?, "total");
        let top = series.iter().map(|s| of(s, "total")).fold(start, f64::max);
        Some(Self { start, top, kinetic: greatest("kinetic") })
    }
}

/// A rise of the energy beyond what came in and what is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct Rise {
    /// What rose, how much and why, in a sentence.
    pub told: String,
    /// Whether the run gained this energy. If not, the work that came in is not known well enough.
    pub is_sure: bool,
}

impl Rise {
    /// The sentence if the rise is sure, since only then it is a warning.
    pub fn warning(self) -> Option<String> {
        self.is_sure.then_some(self.told)
    }
}

/// The rise of the energy, J, that is no gain, for a greatest kinetic energy, J.
pub(crate) fn allowed_rise(rule: Rule, kinetic: f64) -> f64 {
    let share = match rule {
        Rule::Dissipative => RISE[0],
        Rule::Symplectic => RISE[1],
    };
    share * kinetic
}

/// The rise of the energy of a run that did not diverge; `None` where it gained none. Where pins,
/// obstacles or wind do work, `balance` subtracts that work.
pub fn energy_gain(
    Extremes { start, top, kinetic }: Extremes,
    choice: &Choice,
    rule: Rule,
    known: Start,
    balance: Option<&WorkBalance>,
) -> Option<Rise> {
    let id = choice.method().id;
    let is_blinded = known.mass_ratio > BLINDING && choice.settings().get("norm") == Some("euclid");
    let cause = match known.inside {
        0 if is_blinded => format!(
            "the heaviest particle has {} times the mass of the lightest, and with norm=euclid the \
             solver stops once the residual is small beside its weight: the others are not solved \
             for; take norm=velocity",
            trimmed(known.mass_ratio, 2)
        ),
        0 => format!("the step is probably too long for {id}"),
        inside => format!(
            "{inside} particles start inside an obstacle and are pushed out, \
             or the step is too long for {id}"
        ),
    };
    let (rise, sure, beside) = match balance {
        None => (top - start, top - start, ""),
        Some(balance) => {
            (balance.excess()?, balance.sure_excess()?, " and the work of pins, obstacles and wind")
        }
    };
    let allowed = allowed_rise(rule, kinetic) + known.round_off;
    let is_sure = sure > allowed;
    let why = if is_sure {
        cause
    } else {
        "within a step the forces change so much that this work is not known as well as that; \
         shorter steps show whether energy is gained"
            .to_owned()
    };
    (rise > allowed).then(|| Rise {
        told: format!(
            "the total energy rose by {rise:.3e} J above its start{beside}; \
             the greatest kinetic energy is {kinetic:.3e} J: {why}"
        ),
        is_sure,
    })
}

/// Watches a run from its start, and judges it at its end.
#[derive(Debug)]
pub struct Judge {
    expected: Expected,
    start: Start,
    /// The work of wind, moving pins and moving obstacles; `None` where nothing does work.
    balance: Option<WorkBalance>,
    check: MotionCheck,
}

impl Judge {
    /// Starts to watch a run over `time`, from its start.
    pub fn of(simulation: &OrderedSimulation, choice: &Choice, time: TimeSpan) -> Self {
        let (whole, rest) = time.steps();
        Self {
            expected: Expected::of(simulation, choice, time),
            start: Start::of(simulation),
            balance: simulation.work_balance(),
            check: simulation.motion_check(whole + u64::from(rest.is_some())),
        }
    }

    /// The prediction of theory about the motion.
    pub fn expected(&self) -> &Expected {
        &self.expected
    }

    /// Whether pins, obstacles or wind do work on the cloth. Then the run needs the
    /// [ledger](crate::Runner::ledger) of its steps.
    pub fn is_driven(&self) -> bool {
        self.balance.is_some()
    }

    /// Looks at the end of a step.
    pub fn look(&mut self, moment: &Moment<'_>) {
        if let Some(balance) = &mut self.balance {
            balance.look(moment);
        }
        self.check.look(moment);
    }

    /// The rise of the energy of a run that recorded its series; `None` where it gained none.
    pub fn gain(
        &self,
        simulation: &OrderedSimulation,
        choice: &Choice,
        outcome: &Outcome,
    ) -> Option<Rise> {
        let balance = self.balance.as_ref();
        let extremes = Extremes::of(&outcome.series).filter(|_| outcome.divergence.is_none())?;
        energy_gain(extremes, choice, simulation.rule(), self.start, balance)
    }

    /// The verdict on a run whose energy [rose](Self::gain) so.
    pub fn verdict(
        &self,
        simulation: &OrderedSimulation,
        outcome: &Outcome,
        gain: Option<&Rise>,
    ) -> Judgement {
        let is_judged = self.balance.as_ref().is_none_or(|balance| balance.excess().is_some());
        let is_whole = outcome.divergence.is_none();
        let kept = is_whole.then(|| simulation.kept(&self.check, outcome.effort));
        judge(outcome, gain, is_judged, (kept, self.check.spin_share()), &self.expected)
    }
}

/// The verdict on a run. `gain` is the rise of its energy, and `is_judged` says whether one would
/// have been seen. `kept` is the share of the motion that the run kept, unless it
/// diverged; `spin_share` is its share of the [spin](MotionCheck::spin_share).
pub fn judge(
    outcome: &Outcome,
    gain: Option<&Rise>,
    is_judged: bool,
    (kept, spin_share): (Option<Kept>, Option<f64>),
    expected: &Expected,
) -> Judgement {
    let share = match kept {
        Some(Kept::Share { share, .. }) => Some(share),
        _ => None,
    };
    let (kind, reason) = match (&outcome.divergence, gain, kept) {
        (Some(divergence), ..) => {
            (Judged::Diverged, format!("at step {}: {}", divergence.step, divergence.criterion))
        }
        (_, Some(gain), _) => {
            let kind = if gain.is_sure { Judged::GainedEnergy } else { Judged::Unknown };
            (kind, gain.told.clone())
        }
        (None, None, _) if outcome.is_over_budget => {
            let why = format!("interrupted after {} steps, so it was not measured", outcome.steps);
            (Judged::Unknown, format!("{why}; {}", expected.told()))
        }
        (None, None, kept) => {
            let (kind, reason) = spun(motion(kept, expected), spin_share);
            if kind == Judged::Stable && !is_judged {
                let why = "a correction moves particles beside pins, obstacles or wind that do \
                           work, so a gain of energy cannot be seen";
                (Judged::Unknown, format!("{why}; {reason}"))
            } else {
                (kind, reason)
            }
        }
    };
    Judgement { kind, share, expected_share: expected.share(), spin_share, reason }
}

/// The verdict, with the share of the spin that a free cloth kept.
fn spun((kind, reason): (Judged, String), spin_share: Option<f64>) -> (Judged, String) {
    let Some(share) = spin_share else { return (kind, reason) };
    let left = percent(share.max(0.0));
    if share < LOCKED {
        let lost = format!(
            "it lost its spin: {left} of the angular momentum about its centre of mass is left, \
             and nothing outside takes any"
        );
        (Judged::Locked, format!("{lost}; {reason}"))
    } else {
        (kind, format!("{reason}; {left} of its spin is left"))
    }
}

/// Whether a run that gained no energy is locked. Where the check cannot decide, theory does.
pub(crate) fn is_locked(kept: Kept, expected: impl FnOnce() -> Expected) -> bool {
    match kept {
        Kept::Share { share, .. } if share >= LOCKED => false,
        Kept::Share { .. } => motion(Some(kept), &expected()).0 == Judged::Locked,
        Kept::Still => false,
        Kept::Unknown(_) => expected().share().is_some_and(|share| share < LOCKED),
    }
}

/// The verdict on the motion of a run that gained no energy.
fn motion(kept: Option<Kept>, expected: &Expected) -> (Judged, String) {
    let told = expected.told();
    let foresees_locking = expected.share().is_some_and(|share| share < LOCKED);
    let foresees_motion = match expected {
        Expected::Share(_, share) => *share >= WELL,
        Expected::Explicit => true,
        Expected::Nothing(_) | Expected::Unforeseen(_) => false,
    };
    match kept {
        Some(Kept::Share { share, windows, steps }) => {
            let measured = format!(
                "it moved {} as far as a reference in {windows} {} of {steps} steps; {told}",
                percent(share),
                if windows == 1 { "window" } else { "windows" }
            );
            let is_locked = share < SURELY_LOCKED || (share < LOCKED && foresees_locking);
            let is_well = share >= WELL || (share >= LOCKED && !foresees_locking);
            match (is_locked, is_well) {
                (true, _) => (Judged::Locked, measured),
                (false, true) => (Judged::Stable, measured),
                (false, false) => (Judged::Unknown, measured),
            }
        }
        Some(Kept::Still) if foresees_locking => {
            (Judged::Unknown, format!("the cloth moves in no window that was checked; {told}"))
        }
        Some(Kept::Still) => (
            Judged::Stable,
            "no gain of energy; the cloth is in balance in every window that was checked, so \
             there is no motion to lose"
                .to_owned(),
        ),
        Some(Kept::Unknown(silent)) if foresees_motion => {
            (Judged::Stable, format!("no gain of energy; {told}; not measured: {silent}"))
        }
        Some(Kept::Unknown(silent)) => {
            (Judged::Unknown, format!("no gain of energy, but {silent}; {told}"))
        }
        None => (Judged::Unknown, told),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    /// Between the limits theory and measurement must agree; beyond them the measurement decides.
    #[test]
    fn a_share_between_the_limits_needs_the_word_of_theory() {
        for (share, foreseen, verdict) in [
            (0.3, 0.9, Judged::Locked),
            (0.4, 0.9, Judged::Unknown),
            (0.4, 0.2, Judged::Locked),
            (0.6, 0.9, Judged::Stable),
            (0.6, 0.2, Judged::Unknown),
            (0.8, 0.2, Judged::Stable),
        ] {
            let kept = Kept::Share { share, windows: 1, steps: 100 };
            let lever = Lever { lever: 1.0, time: 1.0, freedom: 1.0 };
            let (found, reason) = motion(Some(kept), &Expected::Share(lever, foreseen));
            assert_eq!(found, verdict, "{share} kept, {foreseen} foreseen: {reason}");
        }
    }

    /// A cloth at rest has no kinetic energy that a rise could be small beside.
    #[test]
    fn a_rise_within_round_off_is_no_gain() {
        let choice = Choice::parse("imex-euler", &[]).unwrap();
        let extremes = Extremes { start: 1.0, top: 1.0 + 1e-9, kinetic: 0.0 };
        for (round_off, gains) in [(1e-8, false), (1e-10, true)] {
            let start = Start { round_off, inside: 0, mass_ratio: 1.0 };
            let gain = energy_gain(extremes, &choice, Rule::Dissipative, start, None);
            assert_eq!(gain.is_some(), gains, "{gain:?}");
        }
    }
}
