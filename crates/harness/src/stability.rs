//! Verdicts on stability, by energy.
//!
//! A run is judged by its total energy `H_n`: kinetic and potential energy, less the work that
//! changes of the system from outside have done. The unit of comparison is `E_ref`, the energy that
//! the scene sets free: `max(H_0 − min U, max T)` over a [reference trajectory](reference_energy).
//! Bounded positions prove nothing: the explicit part of a spring's force is bounded, so unstable
//! runs saturate.
//!
//! | rule | stable | marginal | unstable |
//! |---|---|---|---|
//! | [`Rule::Dissipative`] | `max(H_n − H_0) ≤ 0.02 E_ref` | up to `0.5 E_ref` | above |
//! | [`Rule::Symplectic`] | `max abs(H_n − H_0) ≤ 0.5 E_ref`, secular drift ≤ `0.05 E_ref` | the former only | neither |
//!
//! The symplectic rule is for methods of that [class](StabilityClass), where neither damping nor
//! contacts dissipate. There the energy may oscillate with the step size, but must not drift. The
//! secular drift is the slope of the straight line through the energies of the last half of the
//! run, times the duration.
//!
//! Moving pins, moving obstacles and wind do work that this rule does not count. While they act,
//! the scene is not closed, and nothing is judged. The watch starts at the end of the step in which
//! the last of them comes to rest. `H_0` is the energy there, without the kinetic energy of the
//! pins. The watch does not see energy that a method gained before. A scene that is open until its
//! end gets the verdict `open`. A run that [diverges](crate::Divergence) gets `diverged` under
//! either rule.

use crate::HarnessError;
use crate::methods::Choice;
use crate::run::{Counts, Moment, Runner, Simulation};
use crate::schedule::Schedule;
use drape_integrator::{Implicit, StabilityClass};
use drape_model::{Effect, Level, MovingPin, Path, Revisions, State, System, TimeSpan, Vec3};
use drape_report::Verdict;

/// A run is stable if its energy rises by at most this share of the energy that the scene sets free.
pub const STABLE: f64 = 0.02;
const MARGINAL: f64 = 0.5;
const SECULAR: f64 = 0.05;
/// Fraction of the stability limit at which the reference runs.
const SAFETY: f64 = 0.25;
/// A step raises the energy if it adds more than this fraction of `E_ref` and more than round-off.
const RISE: f64 = 1e-9;
const ROUND_OFF: f64 = 1e-14;
/// A step that begins at most this part of a step before a path ends counts as beginning at its
/// end, because of round-off.
const EARLY: f64 = 1e-6;

/// How the energy of a run is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The energy must not rise above its start.
    Dissipative,
    /// The energy may oscillate, but not drift.
    Symplectic,
}

impl Rule {
    /// The rule for a class of methods on a system.
    pub fn of(class: StabilityClass, system: &System) -> Self {
        let is_damped = system.effects().any(Effect::has_damping);
        match class {
            StabilityClass::Symplectic if !is_damped && system.obstacles().is_empty() => {
                Self::Symplectic
            }
            _ => Self::Dissipative,
        }
    }
}

/// The changes of the total energy of a run. They are infinite after a divergence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Greatest rise above the start, J.
    pub gain: f64,
    /// Greatest rise above the least energy before, J.
    pub climb: f64,
    /// Greatest distance from the start, J.
    pub swing: f64,
    /// Slope of the straight line through the energies of the last half, times the duration, J.
    pub drift: f64,
    /// Number of steps that raised the energy by more than round-off; 0 without a reference energy.
    pub rises: u64,
    /// Greatest allowance for round-off in that count, J.
    pub round_off: f64,
    /// Energy that was set free, J: the greatest of `H_0 − U_n` and of the kinetic energy.
    pub released: f64,
    /// Whether energy could flow in from outside until the end, so that nothing was watched.
    pub is_open: bool,
}

/// Watches the energy of a run in constant memory.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    track: Track,
    springs: Springs,
    /// Time at which the last pin or obstacle stops moving, s.
    open_until: f64,
    /// Forces of the air on a cloth at rest, N; empty where there is none.
    push: Vec<Vec3>,
    /// Whether there was a wind at the end of the last step.
    is_blown: bool,
}

/// The energies of a run, one after the other.
#[derive(Clone, Debug)]
struct Track {
    start: f64,
    last: f64,
    least: f64,
    duration: f64,
    energy: Energy,
    line: Line,
    /// `E_ref` of the scene, J; infinite where rises are not counted.
    reference: f64,
}

/// Sums of a fit by a straight line.
#[derive(Clone, Copy, Debug, Default)]
struct Line {
    n: f64,
    t: f64,
    y: f64,
    tt: f64,
    ty: f64,
}

impl Line {
    fn add(&mut self, t: f64, y: f64) {
        self.n += 1.0;
        self.t += t;
        self.y += y;
        self.tt += t * t;
        self.ty += t * y;
    }

    fn slope(&self) -> f64 {
        let spread = self.n * self.tt - self.t * self.t;
        if spread > 0.0 { (self.n * self.ty - self.t * self.y) / spread } else { 0.0 }
    }
}

/// Two numbers that measure the round-off of the energy.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Springs {
    /// `½ Σ k ℓ²`, J.
    rest_energy: f64,
    /// Greatest `k/m`, 1/s².
    stiffness_over_mass: f64,
    revisions: Revisions,
}

impl Springs {
    fn of(system: &System) -> Self {
        let mut stiffness = Vec::new();
        let mut rest = Vec::new();
        for split in system.effects().filter_map(Effect::split) {
            split.visit_weights(&mut |_, _, k, _| stiffness.push(k));
            split.visit_rest_lengths(&mut |_, _, length| rest.push(length));
        }
        let energies = stiffness.iter().zip(&rest).map(|(k, length)| 0.5 * k * length * length);
        Self {
            rest_energy: energies.sum(),
            stiffness_over_mass: Implicit::Springs.max_stiffness_over_mass(system),
            revisions: system.revisions(),
        }
    }

    fn round_off(&self, h: f64, kinetic: f64) -> f64 {
        let theta = h * h * self.stiffness_over_mass;
        ROUND_OFF * (1.0 + theta) * (self.rest_energy + kinetic)
    }
}

/// Allowance for round-off of a total energy, J: from the springs, and from `energy`, J.
pub(crate) fn round_off(system: &System, energy: f64) -> f64 {
    ROUND_OFF * (Springs::of(system).rest_energy + energy)
}

impl Watch {
    /// Starts to watch a run of `duration` seconds. `reference` is `E_ref`, J; without it, rises
    /// are not counted.
    pub(crate) fn new(simulation: &Simulation, duration: f64, reference: Option<f64>) -> Self {
        let Simulation { system, state } = simulation;
        let kinetic = system.kinetic_energy(&state.v);
        let potential = system.potential_energy(&state.x);
        let track = Track::new([kinetic, potential, 0.0], duration, reference);
        let pins = system.moving_pins().iter().map(MovingPin::stops);
        let paths = system.obstacles().iter().filter_map(|obstacle| obstacle.path.as_ref());
        let open_until = pins.chain(paths.map(Path::end)).fold(0.0, f64::max);
        let has_drag = system.effects().any(Effect::is_drag);
        let push = vec![Vec3::zeros(); if has_drag { system.len() } else { 0 }];
        let mut watch =
            Self { track, springs: Springs::of(system), open_until, push, is_blown: false };
        watch.is_blown = watch.blows(system, state);
        watch
    }

    /// Whether wind pushes the cloth. Still air only takes energy from it; wind pushes even a cloth
    /// at rest.
    fn blows(&mut self, system: &System, state: &State) -> bool {
        if self.push.is_empty() {
            return false;
        }
        self.push.fill(Vec3::zeros());
        let rest = vec![Vec3::zeros(); system.len()];
        for drag in system.effects().filter(|effect| effect.is_drag()) {
            drag.add_damping_force(Level { v: &rest, ..state.level() }, &mut self.push);
        }
        self.push.iter().any(|force| *force != Vec3::zeros())
    }

    /// Looks at the end of a step.
    pub(crate) fn look(&mut self, moment: &Moment<'_>) {
        let Moment { h, elapsed, outside_work: work, system, state, .. } = *moment;
        if self.springs.revisions != system.revisions() {
            self.springs = Springs::of(system);
        }
        let kinetic = system.kinetic_energy(&state.v);
        let potential = system.potential_energy(&state.x);
        let blew = std::mem::replace(&mut self.is_blown, false);
        self.is_blown = self.blows(system, state);
        if blew || self.is_blown || state.t - h < self.open_until - EARLY * h {
            let led = system.moving_pins().iter().map(|pin| pin.particle);
            let led: f64 = led.map(|i| 0.5 * system.mass()[i] * state.v[i].norm_squared()).sum();
            let Track { duration, reference, .. } = self.track;
            let reference = reference.is_finite().then_some(reference);
            self.track = Track::new([kinetic - led, potential, work], duration, reference);
            self.track.energy.is_open = true;
            return;
        }
        let round_off = self.springs.round_off(h, kinetic);
        let released = (self.track.start + work - potential).max(kinetic);
        self.track.energy.released = self.track.energy.released.max(released);
        self.track.add(elapsed, kinetic + potential - work, round_off);
    }

    /// The changes of the energy so far.
    pub(crate) fn energy(&self, has_diverged: bool) -> Energy {
        self.track.energy(has_diverged)
    }
}

impl Track {
    /// Begins with the kinetic and potential energy and the work from outside so far, J.
    fn new([kinetic, potential, work]: [f64; 3], duration: f64, reference: Option<f64>) -> Self {
        let start = kinetic + potential - work;
        Self {
            start,
            last: start,
            least: start,
            duration,
            energy: Energy {
                released: (start + work - potential).max(kinetic),
                ..Energy::default()
            },
            line: Line::default(),
            reference: reference.unwrap_or(f64::INFINITY),
        }
    }

    /// Adds the energy `total`, J, after `elapsed` seconds. It is accurate to within `round_off`,
    /// J.
    fn add(&mut self, elapsed: f64, total: f64, round_off: f64) {
        // The difference of two infinities counts as a gain.
        let total = if total.is_nan() { f64::INFINITY } else { total };
        let gain = total - self.start;
        self.energy.is_open = false;
        self.energy.gain = self.energy.gain.max(gain);
        self.energy.swing = self.energy.swing.max(gain.abs());
        self.least = self.least.min(total);
        self.energy.climb = self.energy.climb.max(total - self.least);
        self.energy.round_off = self.energy.round_off.max(round_off);
        self.energy.rises += u64::from(total > self.last + RISE * self.reference + round_off);
        self.last = total;
        if elapsed >= 0.5 * self.duration {
            // Time counts from the middle of the last half, so that the sums lose the fewest
            // digits.
            self.line.add(elapsed - 0.75 * self.duration, gain);
        }
    }

    fn energy(&self, has_diverged: bool) -> Energy {
        let mut energy = Energy { drift: self.line.slope() * self.duration, ..self.energy };
        if has_diverged {
            let all = f64::INFINITY;
            energy = Energy { gain: all, climb: all, swing: all, drift: all, ..energy };
        }
        energy
    }
}

/// Energies of the true motion of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reference {
    /// `E_ref`, J.
    pub(crate) energy: f64,
    /// Energy that contacts add by pushing particles out of obstacles, J.
    pub(crate) gain: f64,
}

/// Gershgorin's bounds of the eigenvalues of `M⁻¹L_k`, 1/s², and `M⁻¹L_c`, 1/s: twice the greatest
/// diagonal elements.
pub(crate) fn gershgorin(system: &System) -> (f64, f64) {
    let mut rows = vec![(0.0_f64, 0.0_f64); system.len()];
    Implicit::Springs.visit_weights(system, &mut |i, j, k, c| {
        for end in [i, j] {
            rows[end].0 += 2.0 * k / system.mass()[end];
            rows[end].1 += 2.0 * c / system.mass()[end];
        }
    });
    rows.iter().fold((0.0, 0.0), |(k, c), row| (row.0.max(k), row.1.max(c)))
}

/// The energies of the true motion, from symplectic Euler well below its stability limit. They have
/// the same bits on every machine. The run makes the changes of `schedule`, but takes shorter steps
/// of one length.
///
/// # Errors
/// As [`Runner::count`].
pub(crate) fn reference(
    simulation: &Simulation,
    schedule: &Schedule,
) -> Result<Reference, HarnessError> {
    let run = reference_run(simulation, schedule, |runner| runner)?;
    let has_contacts = !simulation.system.obstacles().is_empty();
    let gain = if has_contacts { run.energy.gain } else { 0.0 };
    Ok(Reference { energy: run.energy.released, gain })
}

/// The run of [`reference`], after `adapt` has changed its runner.
///
/// # Errors
/// As [`Runner::count`].
pub(crate) fn reference_run(
    simulation: &Simulation,
    schedule: &Schedule,
    adapt: impl for<'a> FnOnce(Runner<'a>) -> Runner<'a>,
) -> Result<Counts, HarnessError> {
    let (stiffness, damping) = gershgorin(&simulation.system);
    let stiffness = stiffness * schedule.greatest_stiffness();
    // Symplectic Euler is stable for h²λ + 2hδ < 4.
    let limit = 4.0 / (damping + (damping * damping + 4.0 * stiffness).sqrt()).max(1e-300);
    let duration_s = schedule.time.duration_s;
    let step_s = (SAFETY * limit).min(0.001).min(duration_s);
    let schedule =
        Schedule { changes: schedule.changes, ..Schedule::steady(TimeSpan { step_s, duration_s }) };
    let choice = Choice::parse("symplectic-euler", &[])?;
    adapt(Runner::by(&choice, &schedule)).count(simulation)
}

/// `E_ref` of a closed scene over `duration` seconds, J. It comes from symplectic Euler well below
/// its stability limit, which follows the true motion. It has the same bits on every machine.
///
/// # Errors
/// As [`Runner::count`].
pub fn reference_energy(simulation: &Simulation, duration: f64) -> Result<f64, HarnessError> {
    let time = TimeSpan { step_s: duration, duration_s: duration };
    Ok(reference(simulation, &Schedule::steady(time))?.energy)
}

/// The verdict on the energy of a run that did not diverge. `reference_energy` is `E_ref`, J.
pub fn judge(energy: &Energy, rule: Rule, reference_energy: f64) -> Verdict {
    let within = |value: f64, share: f64| value <= share * reference_energy;
    match rule {
        _ if energy.is_open => Verdict::Open,
        Rule::Dissipative if within(energy.gain, STABLE) => Verdict::Stable,
        Rule::Dissipative if within(energy.gain, MARGINAL) => Verdict::Marginal,
        Rule::Symplectic if within(energy.swing, MARGINAL) => {
            if within(energy.drift.abs(), SECULAR) { Verdict::Stable } else { Verdict::Marginal }
        }
        _ => Verdict::Unstable,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::schedule::Change;
    use drape_model::{DampingLaw, KeyframeSpec, PinSpec, SpringEffect, SpringSpec, SystemSpec};

    const STEPS: usize = 4000;

    /// The verdicts of both rules on a series of energies over one second, `E_ref` = 1 J.
    fn verdicts(energy: impl Fn(f64) -> f64) -> [Verdict; 2] {
        let mut track = Track::new([0.0, energy(0.0), 0.0], 1.0, Some(1.0));
        for step in 1..=STEPS {
            let t = step as f64 / STEPS as f64;
            track.add(t, energy(t), 0.0);
        }
        let energy = track.energy(false);
        [Rule::Dissipative, Rule::Symplectic].map(|rule| judge(&energy, rule, 1.0))
    }

    #[test]
    fn an_energy_that_falls_is_stable_but_a_symplectic_method_must_not_lose_it() {
        use Verdict::{Marginal, Stable};
        assert_eq!(verdicts(|_| 3.0), [Stable, Stable]);
        assert_eq!(verdicts(|t| 3.0 - 0.04 * t), [Stable, Stable]);
        assert_eq!(verdicts(|t| 3.0 - 0.3 * t), [Stable, Marginal]);
    }

    #[test]
    fn a_rise_is_stable_marginal_or_unstable_by_its_size() {
        use Verdict::{Marginal, Stable, Unstable};
        let bump = |height: f64| move |t: f64| if (t - 0.25).abs() < 0.01 { height } else { 0.0 };
        assert_eq!(verdicts(bump(0.019)), [Stable, Stable]);
        assert_eq!(verdicts(bump(0.021)), [Marginal, Stable]);
        assert_eq!(verdicts(bump(0.49)), [Marginal, Stable]);
        assert_eq!(verdicts(bump(0.51)), [Unstable, Unstable]);
        assert_eq!(verdicts(bump(f64::INFINITY)), [Unstable, Unstable]);
        assert_eq!(verdicts(bump(f64::NAN)), [Unstable, Unstable]);
    }

    #[test]
    fn an_energy_that_oscillates_is_stable_for_symplectic_methods_unless_it_drifts() {
        use Verdict::{Marginal, Stable, Unstable};
        let wave = |t: f64| 0.4 * (800.0 * std::f64::consts::PI * t).sin();
        assert_eq!(verdicts(wave), [Marginal, Stable]);
        assert_eq!(verdicts(|t| 1.6 * wave(t)), [Unstable, Unstable]);
        assert_eq!(verdicts(|t| 0.5 * wave(t) + 0.2 * t), [Marginal, Marginal]);
        // A change in the first half is a transient.
        assert_eq!(verdicts(|t| 0.2 * t.min(0.4)), [Marginal, Stable]);
    }

    #[test]
    fn rises_above_round_off_are_counted_one_by_one() {
        let mut track = Track::new([0.0, 1.0, 0.0], 1.0, Some(1.0));
        for (step, energy) in
            [0.9, 0.9 + 1e-10, 0.9 + 1e-8, 0.5, 0.6, 0.7, 0.1].into_iter().enumerate()
        {
            track.add(step as f64, energy, 1e-12);
        }
        assert_eq!(track.energy(false).rises, 3);
        let mut blind = Track::new([0.0, 1.0, 0.0], 1.0, None);
        blind.add(0.5, 2.0, 0.0);
        assert_eq!(blind.energy(false).rises, 0);
    }

    #[test]
    fn a_divergence_is_an_infinite_gain() {
        let track = Track::new([0.0, 1.0, 0.0], 1.0, None);
        assert_eq!(track.energy(true).gain, f64::INFINITY);
        assert!(Verdict::Diverged > Verdict::Unstable && Verdict::Unstable > Verdict::Marginal);
    }

    #[test]
    fn the_symplectic_rule_is_for_closed_undamped_scenes() {
        let rule = |damping: f64, obstacles: bool| {
            let mut spec = stretched_pair();
            spec.springs[0].damping_n_s_per_m = damping;
            if obstacles {
                let (center_m, radius_m) = ([9.0, 0.0, 0.0], 1.0);
                let ball = drape_model::ObstacleSpec::sphere(center_m, radius_m, 0.0);
                spec.obstacles.push(ball);
            }
            Rule::of(StabilityClass::Symplectic, &spec.build().unwrap().0)
        };
        assert_eq!(rule(0.0, false), Rule::Symplectic);
        assert_eq!(rule(1e-3, false), Rule::Dissipative);
        assert_eq!(rule(0.0, true), Rule::Dissipative);
        let (system, _) = stretched_pair().build().unwrap();
        assert_eq!(Rule::of(StabilityClass::Dissipative, &system), Rule::Dissipative);
    }

    /// Two particles on a spring of 1 m that is stretched by a tenth.
    fn stretched_pair() -> SystemSpec {
        SystemSpec {
            format: "drape-system/1".to_owned(),
            name: "pair".to_owned(),
            particles: drape_model::ParticlesSpec {
                mass_kg: vec![1e-3; 2],
                position_m: vec![[0.0; 3], [1.1, 0.0, 0.0]],
                velocity_m_s: Vec::new(),
            },
            springs: vec![SpringSpec {
                effect: SpringEffect::Tension,
                i: 0,
                j: 1,
                rest_length_m: 1.0,
                stiffness_n_per_m: 0.1,
                damping_n_s_per_m: 0.0,
                ..SpringSpec::default()
            }],
            angles: Vec::new(),
            hinges: Vec::new(),
            damping: DampingLaw::Full,
            triangles: Vec::new(),
            pins: Vec::new(),
            effects: drape_model::EffectsSpec::default(),
            obstacles: Vec::new(),
        }
    }

    /// A pin that pulls the spring brings in energy, and the method is not at fault.
    #[test]
    fn what_a_pin_brings_in_until_it_stops_is_no_gain_but_available() {
        let led = |time_s: f64| {
            let mut spec = stretched_pair();
            let frame = KeyframeSpec { time_s, offset_m: [-2.0, 0.0, 0.0] };
            spec.pins = vec![PinSpec { particle: 0, path: vec![frame] }];
            spec.particles.mass_kg[0] = 1.0; // 8 J on its way, which are not the cloth's
            let (system, state) = spec.build().unwrap();
            Simulation { system, state }
        };
        let schedule = Schedule::steady(TimeSpan { step_s: 0.01, duration_s: 2.0 });
        let choice = Choice::parse("imex-euler:solver=cholesky,implicit=springs", &[]).unwrap();
        let run = |simulation: &Simulation| {
            Runner::by(&choice, &schedule).reference(1e-3).count(simulation).unwrap().energy
        };
        let held = run(&pair()).released;
        // 0.1 N/m · (2 m)²/2 at most; less as soon as the other end moves.
        let led = run(&led(0.5));
        assert!(led.released > 10.0 * held && led.released < 0.25, "{led:?}");
        assert_eq!((led.rises, led.gain), (0, 0.0));
    }

    fn verdict_of(spec: &SystemSpec, end: f64) -> Verdict {
        let (system, state) = spec.build().unwrap();
        let time = TimeSpan { step_s: 0.01, duration_s: end };
        let choice = Choice::parse("backward-euler", &[]).unwrap();
        let run = Runner::new(&choice, time).count(&Simulation { system, state }).unwrap();
        run.verdict(1e-4)
    }

    /// A table that lifts the pair by 2 m until t = 1 s, and so brings in 40 mJ.
    #[test]
    fn what_an_obstacle_on_a_path_brings_in_is_no_gain() {
        let mut spec = stretched_pair();
        spec.effects.gravity = Some(drape_model::GravitySpec { m_s2: [0.0, 0.0, -9.81] });
        spec.obstacles.push(drape_model::ObstacleSpec::Plane {
            point_m: [0.0, 0.0, -1e-9],
            normal: [0.0, 0.0, 1.0],
            restitution: 0.0,
            friction: 0.0,
            path: vec![KeyframeSpec { time_s: 1.0, offset_m: [0.0, 0.0, 2.0] }],
        });
        assert_eq!(verdict_of(&spec, 0.9), Verdict::Open);
        assert_ne!(verdict_of(&spec, 2.0), Verdict::Open);
    }

    #[test]
    fn a_run_in_a_wind_is_not_judged_and_one_in_still_air_is() {
        let mut spec = stretched_pair();
        spec.particles.position_m.push([0.0, 1.0, 0.0]);
        spec.particles.mass_kg.push(1e-3);
        spec.triangles = vec![[0, 1, 2]];
        let drag = drape_model::DragSpec::Linear { coefficient_n_s_per_m3: 1e-3 };
        let mut air = drape_model::AirSpec { drag, wind: None };
        spec.effects.air = Some(air);
        assert_eq!(verdict_of(&spec, 2.0), Verdict::Stable);
        let velocity_m_s = [0.0, 0.0, 5.0];
        air.wind = Some(drape_model::WindSpec { velocity_m_s, gust: None });
        spec.effects.air = Some(air);
        assert_eq!(verdict_of(&spec, 2.0), Verdict::Open);
    }

    fn pair() -> Simulation {
        let (system, state) = stretched_pair().build().unwrap();
        Simulation { system, state }
    }

    /// Stiffening a stretched spring a hundredfold brings in energy, and the method is not at
    /// fault.
    #[test]
    fn work_of_the_outside_is_taken_out_and_counts_as_available() {
        const STIFFER: [Change; 1] = [Change { time_s: 0.3, factor: 100.0 }];
        let time = TimeSpan { step_s: 0.01, duration_s: 2.0 };
        let schedule = Schedule { changes: &STIFFER, ..Schedule::steady(time) };
        let choice = Choice::parse("imex-euler:solver=cholesky,implicit=springs", &[]).unwrap();
        let run = |schedule: &Schedule| {
            Runner::by(&choice, schedule).reference(1e-3).count(&pair()).unwrap()
        };
        let (steady, changed) = (run(&Schedule::steady(time)), run(&schedule));
        assert_eq!(steady.energy.rises + changed.energy.rises, 0);
        assert_eq!((steady.energy.gain, changed.energy.gain), (0.0, 0.0));
        let stiffness = |run: &crate::run::Counts| run.energy.released;
        assert!(stiffness(&changed) > 2.0 * stiffness(&steady), "{changed:?}");
        let reference = reference(&pair(), &schedule).unwrap();
        assert!(reference.energy > 2.0 * 0.5e-3, "{reference:?}");
    }

    #[test]
    fn the_budget_ends_a_run_at_the_same_step_every_time() {
        let time = TimeSpan { step_s: 0.01, duration_s: 2.0 };
        let choice = Choice::parse("backward-euler", &[]).unwrap();
        let run =
            |limit: f64| Runner::new(&choice, time).budget(limit).count(&pair()).unwrap().outcome;
        let all = run(f64::INFINITY);
        assert!(!all.is_over_budget && all.steps == 200);
        let half = run(0.5 * all.effort);
        assert!(half.is_over_budget && half.divergence.is_none());
        assert!((50..150).contains(&half.steps), "{}", half.steps);
        assert_eq!(half.steps, run(0.5 * all.effort).steps);
        assert!(!run(all.effort).is_over_budget, "a run that just fits is complete");
    }

    /// A symplectic method must not lose energy for a while either; for others that is damping.
    #[test]
    fn a_swing_is_a_rise_or_a_fall() {
        use Verdict::{Stable, Unstable};
        let dip = |depth: f64| move |t: f64| if (t - 0.25).abs() < 0.01 { -depth } else { 0.0 };
        assert_eq!(verdicts(dip(0.49)), [Stable, Stable]);
        assert_eq!(verdicts(dip(0.51)), [Stable, Unstable]);
    }

    #[test]
    fn the_bounds_of_a_pair_are_twice_its_coefficients_over_the_mass() {
        let mut spec = stretched_pair();
        spec.springs[0].damping_n_s_per_m = 0.3;
        spec.particles.mass_kg[1] = 1.0;
        let (stiffness, damping) = gershgorin(&spec.build().unwrap().0);
        assert!((stiffness - 200.0).abs() < 1e-9 && (damping - 600.0).abs() < 1e-9);
    }

    /// With the step for the spring at the start the reference would diverge.
    #[test]
    fn the_reference_steps_for_the_stiffest_spring_to_come() {
        const STIFFENED: [Change; 1] = [Change { time_s: 0.1, factor: 1e6 }];
        let time = TimeSpan { step_s: 0.01, duration_s: 0.2 };
        let schedule = Schedule { changes: &STIFFENED, ..Schedule::steady(time) };
        let found = reference(&pair(), &schedule).unwrap();
        // ½ · 0.1 N/m · 1e6 · (0.1 m)² is the most that the spring can hold.
        assert!(found.energy > 0.0 && found.energy < 501.0, "{found:?}");
    }
}
