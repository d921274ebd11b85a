//! How much of the motion a run kept, measured with a reference and without any theory.
//!
//! The check looks at up to three *windows* of a few steps each: at the start of the run, after a
//! third and after two thirds. After the run, symplectic Euler at less than half of its stability
//! limit moves the cloth again from the state at the beginning of each window. In a window of
//! length `τ`
//!
//! ```text
//! d = x(t + τ) − x(t) − τ v(t)        share = Σ m d_run·d_ref / Σ m d_ref·d_ref
//! ```
//!
//! where the sums run over the free particles and all windows. `d` is the effect of the forces on
//! the motion. A locked run moves at its terminal speed, so `d_run ≈ 0`. But its cloth is not in
//! balance: `d_ref ≈ ½ a τ²`. Fast vibrations, which implicit methods damp, hardly show in `d`,
//! because `d` integrates the forces twice.
//!
//! A window counts where the reference moves: `d_ref` is at least a tenth of the way that gravity
//! and air give free particles, and at least a hundredth of the way `τ v`. A cloth at rest has no
//! such window.
//!
//! **Cost.** The references take at most 5 % of the counted effort of the run, or 10⁷
//! visits of a spring (some hundredths of a second) if that is more. Where three windows of eight
//! steps do not fit, the check takes fewer windows or shorter ones of two steps. Where these do not
//! fit either, the share is unknown.

use crate::methods::Choice;
use crate::motion::{loads, size};
use crate::run::{Moment, Runner, Simulation};
use crate::spin::Spin;
use crate::stability::{gershgorin, round_off};
use crate::work::is_driven;
use drape_integrator::ExplicitNumbers;
use drape_model::{Effect, State, System, TimeSpan, Vec3};

/// Steps of a window.
const LONG: u64 = 8;
const SHORT: u64 = 2;
/// Number of windows of a run. A run with more than [`MANY`] particles has one, to save memory.
const WINDOWS: u64 = 3;
const MANY: usize = 50_000;
/// Share of the run's counted effort that the references may take.
const SHARE: f64 = 0.05;
/// Visits of a spring that the references may always take.
const FLOOR: f64 = 1e7;
/// Share of the stability limit at which the reference runs.
const SAFETY: f64 = 0.4;
/// A window counts from these shares on: of the free motion, and of the way at constant speed.
const LEAST: (f64, f64) = (0.1, 0.01);
/// Ways below this share of the size of the cloth are round-off.
const ROUND_OFF: f64 = 1e-10;
/// The energy of the reference may swing up by this share of its greatest kinetic energy.
const GAIN: f64 = 0.5;

/// How much of the motion a run kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kept {
    /// This share, in so many windows.
    Share {
        /// 1 is the motion of the reference.
        share: f64,
        /// Windows in which the cloth moves.
        windows: usize,
        /// Steps of each.
        steps: u64,
    },
    /// The cloth moves in no window.
    Still,
    /// The reference gives no answer.
    Unknown(Silent),
}

/// Why the reference gives no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Silent {
    /// The run has fewer steps than a window.
    Short,
    /// The reference would take too much work.
    Costly,
    /// The reference does not support the scene.
    Refused,
    /// The reference gained energy itself.
    Unsound,
    /// Pins, obstacles or wind drive the cloth, but its forces are in balance in all windows.
    Balanced,
}

impl std::fmt::Display for Silent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Short => "the run is too short to be checked",
            Self::Costly => "a reference would take more than 5 % of the work of the run",
            Self::Refused => "the reference, symplectic Euler, does not support the scene",
            Self::Unsound => "the reference gained energy itself",
            Self::Balanced => {
                "the driven cloth is in balance in every window that was checked, which a locked \
                 one is too"
            }
        })
    }
}

/// Some steps of a run.
#[derive(Clone, Debug)]
struct Window {
    first: u64,
    start: Option<State>,
    /// Time and positions after [`SHORT`] and [`LONG`] steps.
    ends: [Option<(f64, Vec<Vec3>)>; 2],
}

/// Looks at the windows of a run, and at the spin of a free cloth.
#[derive(Clone, Debug)]
pub struct MotionCheck {
    windows: Vec<Window>,
    /// Number of steps of the whole run.
    steps: u64,
    spin: Option<Spin>,
    /// The share of the spin at the end.
    spin_share: Option<f64>,
}

/// The result of a reference in a window.
enum Finding {
    /// `Σ m d_run·d_ref` and `Σ m d_ref·d_ref`.
    Moves(f64, f64),
    Still,
    Unsound,
}

impl MotionCheck {
    /// Starts to watch a run of so many steps, at its start.
    pub fn new(system: &System, state: &State, steps: u64) -> Self {
        let most = if state.len() > MANY { 1 } else { WINDOWS };
        let mut windows: Vec<Window> = Vec::new();
        for part in 0..most {
            let first = steps * part / most;
            let is_apart = windows.last().is_none_or(|last| last.first + LONG <= first);
            if is_apart && first + SHORT <= steps {
                windows.push(Window { first, start: None, ends: [None, None] });
            }
        }
        let spin = Spin::of(system, state);
        let mut check = Self { windows, steps, spin, spin_share: None };
        check.see(0, state);
        check
    }

    /// Looks at the end of a step.
    pub fn look(&mut self, moment: &Moment<'_>) {
        self.see(moment.step, moment.state);
        if moment.step == self.steps {
            self.spin_share = self.spin.map(|spin| spin.share(moment.system, moment.state));
        }
    }

    /// The share of its angular momentum about the centre of mass that a free, spinning cloth has
    /// at the end. `None` before the end, and where the cloth does not spin or a torque may act on
    /// it.
    pub fn spin_share(&self) -> Option<f64> {
        self.spin_share
    }

    fn see(&mut self, step: u64, state: &State) {
        for window in &mut self.windows {
            if step == window.first {
                window.start = Some(state.clone());
            }
            for (end, length) in window.ends.iter_mut().zip([SHORT, LONG]) {
                if step == window.first + length {
                    *end = Some((state.t, state.x.clone()));
                }
            }
        }
    }

    /// Runs the references and returns the share of the motion that the run kept. `effort` is the
    /// number of visits of a spring that the run took.
    pub fn finish(&self, system: &System, effort: f64) -> Kept {
        let Ok(choice) = Choice::parse("symplectic-euler", &[]) else {
            return Kept::Unknown(Silent::Refused);
        };
        if choice.method().check(system).is_err() {
            return Kept::Unknown(Silent::Refused);
        }
        let mut springs = 0;
        let mut count = |_: usize, _: usize, _: f64, _: f64| springs += 1;
        for split in system.effects().filter_map(Effect::split) {
            split.visit_weights(&mut count);
        }
        let sweep = f64::from(springs) + 5.0 * system.len() as f64;
        let budget = (SHARE * effort).max(FLOOR);
        let Some(limit) = self.windows.first().and_then(|w| w.start.as_ref()).map(|start| {
            // The power iterations for other effects take work, too.
            step_limit(system, start)
        }) else {
            return Kept::Unknown(Silent::Short);
        };
        let mut is_costly = false;
        for (place, length) in [(1, LONG), (0, SHORT)] {
            let whole: Vec<_> =
                self.windows.iter().filter_map(|window| window.view(place)).collect();
            let middle = whole.get(whole.len() / 2).into_iter().copied().collect();
            for views in [whole, middle] {
                let steps = |view: &View<'_>| (view.time / limit).ceil().max(2.0 * length as f64);
                let cost: f64 = views.iter().map(steps).sum::<f64>() * sweep;
                if views.is_empty() {
                    continue;
                }
                if cost > budget {
                    is_costly = true;
                    continue;
                }
                let compare =
                    |view: &View<'_>| view.compare(system, &choice, view.time / steps(view));
                return match judge(views.iter().map(compare), length) {
                    Kept::Still if is_driven(system) => Kept::Unknown(Silent::Balanced),
                    kept => kept,
                };
            }
        }
        Kept::Unknown(if is_costly { Silent::Costly } else { Silent::Short })
    }
}

/// Sums up the findings of windows of `steps` steps.
fn judge(findings: impl Iterator<Item = Finding>, steps: u64) -> Kept {
    let (mut product, mut square, mut windows, mut is_unsound) = (0.0, 0.0, 0, false);
    for finding in findings {
        match finding {
            Finding::Moves(p, s) => {
                product += p;
                square += s;
                windows += 1;
            }
            Finding::Unsound => is_unsound = true,
            Finding::Still => {}
        }
    }
    match (windows, is_unsound) {
        (0, true) => Kept::Unknown(Silent::Unsound),
        (0, false) => Kept::Still,
        _ => Kept::Share { share: (product / square).max(0.0), windows, steps },
    }
}

/// A step with which symplectic Euler is stable at a state, s. It is below the limit by the
/// springs, and below the limit by all other effects at that state.
fn step_limit(system: &System, state: &State) -> f64 {
    let (stiffness, damping) = gershgorin(system);
    let springs = 4.0 / (damping + (damping * damping + 4.0 * stiffness).sqrt()).max(1e-300);
    let is_other = |effect: &dyn Effect| effect.split().is_none();
    let others = ExplicitNumbers::new(system, state, &is_other).limit();
    SAFETY * springs.min(others)
}

/// A window of one length.
#[derive(Clone, Copy)]
struct View<'a> {
    start: &'a State,
    time: f64,
    end: &'a [Vec3],
}

impl Window {
    fn view(&self, place: usize) -> Option<View<'_>> {
        let start = self.start.as_ref()?;
        let (t, end) = self.ends[place].as_ref()?;
        Some(View { start, time: t - start.t, end })
    }
}

impl View<'_> {
    fn compare(&self, system: &System, choice: &Choice, step_s: f64) -> Finding {
        let state = self.start.clone();
        let mut reference = Simulation { system: system.clone(), state };
        let begin = total(system, self.start);
        let (mut kinetic, mut top) = (system.kinetic_energy(&self.start.v), begin);
        let time = TimeSpan { step_s, duration_s: self.time };
        let runner = Runner::new(choice, time).observe(|moment| {
            kinetic = moment.system.kinetic_energy(&moment.state.v).max(kinetic);
            top = total(moment.system, moment.state).max(top);
        });
        let is_complete = runner.go(&mut reference).is_ok_and(|o| o.divergence.is_none());
        if !is_complete || !reference.state.is_finite() {
            return Finding::Unsound;
        }
        let gained = top - begin > GAIN * kinetic + round_off(system, begin.abs() + kinetic);
        let load = loads(system, self.start);
        let (mut product, mut square, mut free, mut inert, mut mass) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for i in (0..system.len()).filter(|&i| !system.pinned()[i]) {
            let (m, way) = (system.mass()[i], self.start.v[i] * self.time);
            let run = self.end[i] - self.start.x[i] - way;
            let true_way = reference.state.x[i] - self.start.x[i] - way;
            product += m * run.dot(&true_way);
            square += m * true_way.norm_squared();
            free += m * (load[i] * (0.5 * self.time * self.time)).norm_squared();
            inert += m * way.norm_squared();
            mass += m;
        }
        let smallest = ROUND_OFF * size(&self.start.x);
        let least = (LEAST.0 * LEAST.0 * free)
            .max(LEAST.1 * LEAST.1 * inert)
            .max(mass * smallest * smallest);
        match square > least {
            false => Finding::Still,
            true if gained && !is_driven(system) => Finding::Unsound,
            true => Finding::Moves(product, square),
        }
    }
}

fn total(system: &System, state: &State) -> f64 {
    system.kinetic_energy(&state.v) + system.potential_energy(&state.x)
}

#[cfg(test)]
#[path = "kept_tests.rs"]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests;
