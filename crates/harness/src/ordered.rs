//! Runs systems that list their particles in any order.

use crate::kept::{Kept, MotionCheck};
use crate::methods::Choice;
use crate::motion::{Lever, Unforeseen};
use crate::run::{Moment, Outcome, Progress, Runner, Simulation};
use crate::tunnel::Tunnels;
use crate::work::{WorkBalance, is_driven};
use crate::{HarnessError, Rule};
use drape_integrator::{ExplicitNumbers, Implicit, Integrator, lightest_free_mass};
use drape_model::{
    Effect, Numbering, Obstacle, State, System, SystemSpec, TimeSpan, Vec3, Violation,
};
use std::borrow::Cow;
use std::num::NonZero;

/// A simulation that computes in the order that suits the cache, and hands out everything in the
/// order of the specification.
///
/// Energies and momenta are sums over the particles, so another order changes them by round-off.
/// The simulation keeps the given order where it is good ([`Numbering`] has the rule), and where
/// the result depends on it ([`Choice::follows_springs`]). Then a run equals that of a [`Runner`]
/// on the given system, bit for bit.
///
/// ```
/// use drape_harness::{OrderedSimulation, methods::Choice};
/// let input = drape_model::load("hanging-textile-1e4")?;
/// let choice = Choice::parse("imex-euler", &[])?;
/// let mut simulation = OrderedSimulation::new(input.spec(), &choice)?;
/// let time = drape_model::TimeSpan { step_s: 0.01, duration_s: 0.02 };
/// let outcome = simulation.simulate(time, |runner| {
///     runner.observe(|moment| assert_eq!(moment.moving().state().t, 0.01 * moment.step as f64))
/// })?;
/// assert_eq!(outcome.steps, 2);
/// assert_eq!(simulation.state().t, 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct OrderedSimulation {
    simulation: Simulation,
    numbering: Numbering,
    choice: Choice,
}

/// The state of a run at the end of a step.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a> {
    system: &'a System,
    state: &'a State,
    numbering: &'a Numbering,
    /// Total energy, J, where it is known already.
    total_j: Option<f64>,
}

impl<'a> Moving<'a> {
    /// The state in the order of the specification; copied only if the run has another order.
    pub fn state(&self) -> Cow<'a, State> {
        self.numbering.restore(self.state)
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.state.t
    }

    /// Total energy, J.
    pub fn energy(&self) -> f64 {
        self.total_j.unwrap_or_else(|| self.system.total_energy(self.state))
    }

    /// Kinetic energy, the energy of each effect, and their sum, by name, J.
    pub fn energies(&self) -> Vec<(String, f64)> {
        let kinetic = self.system.kinetic_energy(&self.state.v);
        let effects = self.system.energies(&self.state.x);
        let mut energies = vec![("kinetic".to_owned(), kinetic)];
        energies.extend(effects.map(|(name, energy)| (name.to_owned(), energy)));
        let total = energies.iter().map(|(_, energy)| energy).sum();
        energies.push(("total".to_owned(), total));
        energies
    }

    /// Whether every coordinate of the state is a finite number.
    pub fn is_finite(&self) -> bool {
        self.state.is_finite()
    }

    /// Positions to draw ([`System::display_positions`]), m, in the order of the specification.
    pub fn display_positions(&self) -> Vec<Vec3> {
        let shown = self.system.display_positions(&self.state.x, self.state.t);
        self.numbering.restore_list(&shown).into_owned()
    }
}

impl Moment<'_> {
    /// The state as [`OrderedSimulation::moving`] shows it.
    pub fn moving(&self) -> Moving<'_> {
        let Self { system, state, numbering, total_j, .. } = *self;
        Moving { system, state, numbering, total_j }
    }
}

/// The state of the greatest kinetic energy among the states that were given to it.
#[derive(Clone, Debug, Default)]
pub struct Peak {
    energy: f64,
    state: Option<State>,
    /// Total energy at the start, J; `None` where states that gained energy count, too.
    start: Option<f64>,
}

/// A run blows up once its total energy has risen by more than this share of its kinetic energy.
const BLOWN: f64 = 0.5;

impl Peak {
    /// The peak before a blow-up. It leaves out states whose total energy exceeds `energy`, the
    /// total energy at the start, J, by more than half of their kinetic energy. The peak means
    /// nothing where pins, obstacles or wind do work.
    pub fn before_a_rise_above(energy: f64) -> Self {
        Self { start: Some(energy), ..Self::default() }
    }

    /// Keeps a finite state if its kinetic energy is greater than that of all states before.
    pub fn look(&mut self, moving: Moving<'_>) {
        let energy = moving.system.kinetic_energy(&moving.state.v);
        let is_sound = || self.start.is_none_or(|start| moving.energy() - start <= BLOWN * energy);
        if energy > self.energy && energy.is_finite() && is_sound() {
            self.energy = energy;
            match &mut self.state {
                Some(state) => state.copy_from(moving.state),
                None => self.state = Some(moving.state.clone()),
            }
        }
    }
}

impl OrderedSimulation {
    /// A simulation of a system from its start, to be run by this method.
    ///
    /// # Errors
    /// [`Violation`] for the first value that is refused.
    pub fn new(spec: &SystemSpec, choice: &Choice) -> Result<Self, Violation> {
        let (system, state, numbering) = if choice.follows_springs() {
            let (system, state) = spec.build()?;
            (system, state, Numbering::identity())
        } else {
            spec.build_ordered()?
        };
        Ok(Self { simulation: Simulation { system, state }, numbering, choice: choice.clone() })
    }

    /// Sets the number of threads of the current `rayon` pool that kernels use. Results do not
    /// depend on it.
    pub fn set_threads(&mut self, threads: NonZero<usize>) {
        self.simulation.system.set_threads(threads);
    }

    /// The correspondence between the particles of the run and those of the specification.
    pub fn numbering(&self) -> &Numbering {
        &self.numbering
    }

    /// The present state, in the order of the specification.
    pub fn state(&self) -> Cow<'_, State> {
        self.numbering.restore(&self.simulation.state)
    }

    /// The present state as [`simulate`](Self::simulate) shows it.
    pub fn moving(&self) -> Moving<'_> {
        let Simulation { system, state } = &self.simulation;
        Moving { system, state, numbering: &self.numbering, total_j: None }
    }

    /// The obstacles.
    pub fn obstacles(&self) -> &[Obstacle] {
        self.simulation.system.obstacles()
    }

    /// The rule by which the energy of a run is judged.
    pub fn rule(&self) -> Rule {
        Rule::of(self.choice.method().class, &self.simulation.system)
    }

    /// Greatest rise of the total energy that may be round-off, J. It grows with the energies of
    /// the springs, and with the present forces times the distances from the origin.
    pub fn energy_round_off(&self) -> f64 {
        let Simulation { system, state } = &self.simulation;
        energy_round_off(system, state)
    }

    /// Mass of the heaviest free particle over that of the lightest; 0 where none is free.
    pub fn mass_ratio(&self) -> f64 {
        let system = &self.simulation.system;
        let free = system.mass().iter().zip(system.pinned()).filter(|(_, pinned)| !**pinned);
        free.fold(0.0, |most: f64, (mass, _)| most.max(*mass)) / lightest_free_mass(system)
    }

    /// Number of particles, pins aside, that lie inside an obstacle at the start.
    pub fn particles_inside_obstacles(&self) -> usize {
        let Simulation { system, state } = &self.simulation;
        particles_inside_obstacles(system, state)
    }

    /// Whether an effect damps or drags the cloth.
    pub fn has_damping(&self) -> bool {
        self.simulation.system.effects().any(|effect| effect.has_damping())
    }

    /// Watches the energy of a run in which pins, obstacles or wind do work; `None` where none of
    /// them does.
    pub fn work_balance(&self) -> Option<WorkBalance> {
        let Simulation { system, state } = &self.simulation;
        is_driven(system).then(|| WorkBalance::new(system, state))
    }

    /// Watches a run for particles that pass through obstacles.
    pub fn tunnels(&self) -> Tunnels {
        let Simulation { system, state } = &self.simulation;
        Tunnels::new(system, state)
    }

    /// Watches how much of the motion a run of so many steps keeps.
    pub fn motion_check(&self, steps: u64) -> MotionCheck {
        let Simulation { system, state } = &self.simulation;
        MotionCheck::new(system, state, steps)
    }

    /// The share of the motion that a run kept beside references. `effort` is the number of visits
    /// of a spring that the run took.
    pub fn kept(&self, check: &MotionCheck, effort: f64) -> Kept {
        check.finish(&self.simulation.system, effort)
    }

    /// The numbers that decide how much motion the method keeps in `duration` seconds from the
    /// present state.
    ///
    /// # Errors
    /// [`Unforeseen`], the reason why theory predicts nothing.
    pub fn lever(&self, duration: f64) -> Result<Lever, Unforeseen> {
        let Simulation { system, state } = &self.simulation;
        Lever::of(system, state, crate::motion::implicit_springs(&self.choice), duration)
    }

    /// The greatest `h²k/m` of the springs at a step of `h` seconds.
    pub fn theta(&self, h: f64) -> f64 {
        h * h * Implicit::Springs.max_stiffness_over_mass(&self.simulation.system)
    }

    /// A method that supports the system and keeps its motion at a step of `h` seconds, by theory.
    pub fn lively_method(&self, lever: &Lever, h: f64) -> Option<&'static str> {
        crate::motion::lively_method(&self.simulation.system, lever, h)
    }

    /// Whether a cheap bound shows that the step is within the limits of the method's explicit
    /// effects, whatever the state.
    pub fn surely_allows(&self, step_s: f64) -> bool {
        let (method, settings) = (self.choice.method(), self.choice.settings());
        let is_explicit = |effect: &dyn Effect| method.is_explicit(effect, settings);
        ExplicitNumbers::surely_allow(&self.simulation.system, &is_explicit, step_s)
    }

    /// The numbers that limit the step at the present state, by the effects that the method takes
    /// at the old time level.
    pub fn explicit_numbers(&self) -> ExplicitNumbers {
        self.explicit_numbers_at(&self.simulation.state)
    }

    /// The time, s, and the same numbers at the peak of a run; `None` where the peak has no state.
    pub fn explicit_numbers_at_peak(&self, peak: &Peak) -> Option<(f64, ExplicitNumbers)> {
        peak.state.as_ref().map(|state| (state.t, self.explicit_numbers_at(state)))
    }

    fn explicit_numbers_at(&self, state: &State) -> ExplicitNumbers {
        let (method, settings) = (self.choice.method(), self.choice.settings());
        let is_explicit = |effect: &dyn Effect| method.is_explicit(effect, settings);
        ExplicitNumbers::new(&self.simulation.system, state, &is_explicit)
    }

    /// Makes a run; `set` adds records and observers to the [`Runner`].
    ///
    /// # Errors
    /// As [`Runner::go`].
    pub fn simulate<'a>(
        &'a mut self,
        time: TimeSpan,
        set: impl FnOnce(Runner<'a>) -> Runner<'a>,
    ) -> Result<Outcome, HarnessError> {
        let Self { simulation, numbering, choice } = self;
        set(Runner::new(choice, time).numbered(numbering)).go(simulation)
    }

    /// Prepares a run that is then taken [step by step](Self::step). `set` adds records to the
    /// [`Runner`]; it must not add an observer or a stop.
    ///
    /// # Errors
    /// As [`Runner::go`].
    pub fn begin(
        &mut self,
        time: TimeSpan,
        set: impl FnOnce(Runner<'_>) -> Runner<'_>,
    ) -> Result<Steps, HarnessError> {
        let Self { simulation, choice, .. } = self;
        let mut integrator = choice.build().map_err(crate::methods::MethodError::from)?;
        let runner = set(Runner::new(choice, time));
        let progress = runner.begin(simulation, integrator.as_mut())?;
        Ok(Steps { integrator, progress })
    }

    /// Takes the next step of the run that was [begun](Self::begin) last, and shows its end.
    /// Returns whether another step follows.
    ///
    /// # Errors
    /// As [`Runner::go`].
    pub fn step(
        &mut self,
        Steps { integrator, progress }: &mut Steps,
        mut look: impl FnMut(&Moment<'_>),
    ) -> Result<bool, HarnessError> {
        let Self { simulation, numbering, .. } = self;
        progress.step(integrator.as_mut(), simulation, numbering, &mut |moment| {
            look(moment);
            false
        })
    }
}

/// A run that is taken step by step.
#[derive(Debug)]
pub struct Steps {
    integrator: Box<dyn Integrator>,
    progress: Progress,
}

impl Steps {
    /// The outcome of the steps so far.
    pub fn end(self) -> Outcome {
        self.progress.end()
    }
}

/// As [`OrderedSimulation::energy_round_off`].
pub(crate) fn energy_round_off(system: &System, state: &State) -> f64 {
    let mut work = 0.0;
    for effect in system.effects() {
        let mut force = vec![Vec3::zeros(); system.len()];
        effect.add_force(system.mass(), &state.x, &mut force);
        work += force.iter().zip(&state.x).map(|(f, x)| f.norm() * x.norm()).sum::<f64>();
    }
    crate::stability::round_off(system, work)
}

/// As [`OrderedSimulation::particles_inside_obstacles`].
pub(crate) fn particles_inside_obstacles(system: &System, state: &State) -> usize {
    let is_inside = |x: &Vec3| {
        let deep =
            |obstacle: &Obstacle| obstacle.distance_within(&(x - obstacle.offset(state.t)), 0.0);
        let distances = system.obstacles().iter().filter_map(deep);
        distances.fold(f64::INFINITY, |least, (distance, _)| least.min(distance)) < 0.0
    };
    let free = state.x.iter().zip(system.pinned()).filter(|(_, pinned)| !**pinned);
    free.filter(|(x, _)| is_inside(x)).count()
}

#[cfg(test)]
#[path = "ordered_tests.rs"]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;
