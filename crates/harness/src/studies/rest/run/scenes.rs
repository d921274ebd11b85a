//! Cloth on tables: its scenes, its rest shapes, and the runs of a method.

use super::{ALWAYS, LOOKS_PER_S, SHARES, STEPS};
use crate::cost::{Counted, prices};
use crate::film::{Camera, Seen, threads};
use crate::methods::Choice;
use crate::methods::runs::{Film, Substeps};
use crate::run::{Counts, Moment, Runner, Simulation};
use crate::stability::{gershgorin, reference_energy};
use crate::studies::animation::run::forms;
use crate::studies::clocked::{Taken, samples};
use crate::studies::filmed::{Counters, LONG_S, Stage};
use crate::studies::finite;
use crate::studies::rest::facts::{
    Accepted, End, Minimum, Motion, RIGHT, Run, Scene, THERE, TimingRow,
};
use crate::studies::sheet::cut;
use crate::{HarnessError, system_hash};
use drape_integrator::PrepareError;
use drape_model::fabric::{Disc, Material, MaterialChoice};
use drape_model::{AirSpec, DampingLaw, DragSpec, PinSpec, SystemSpec, Vec3};
use drape_oracle::Random;
use drape_oracle::statics::{is_minimum, residual, rest};
use drape_report::Verdict;
use serde_json::json;
use std::cell::RefCell;
use std::rc::Rc;

/// Seed of the random velocities at the start.
pub(super) const SEED: u64 = 21;
/// Greatest vertical speed of a particle at the start, m/s. It breaks the symmetry without stress.
pub(super) const NUDGE: f64 = 0.01;
/// Rate at which air slows cloth along its normal, 1/s, and damping over stiffness of the springs,
/// s: both on the round table.
pub(super) const AIR: f64 = 10.0;
pub(super) const RETARDATION: f64 = 1e-4;
/// Radii of cloth and round table, m.
const RADII: [f64; 2] = [0.15, 0.09];
/// Stiffness and damping over mass on the square table, 1/s² and 1/s.
pub(super) const STIFFNESS: f64 = 1e6;
pub(super) const DAMPING: f64 = 40.0;
/// Shares of [`STIFFNESS`] that shear and bending springs have.
const SHEAR: f64 = 0.1;
const BENDING: f64 = 0.01;
/// A run ends when the cloth is at rest: greatest force on a particle over the heaviest one's
/// weight, and speed, m/s.
pub(super) const RESIDUAL: f64 = 0.01;
pub(super) const SPEED: f64 = 1e-3;
/// A cloth that has come less than this share of its way is locked.
pub(super) const LOCKED: f64 = 0.5;
/// Tolerance and largest number of iterations of Newton's method.
const TOLERANCE: f64 = 1e-6;
const MOST: usize = 400;
/// Two rest shapes count as one if their energies differ by at most this share of the released
/// energy.
const ALIKE: f64 = 1e-6;
/// Numbers of waves of the starts of the static search.
pub(super) const WAVES: [u32; 4] = [2, 3, 4, 5];
/// Largest work of a run, in visits of a spring.
pub(super) const BUDGET: f64 = 1e8;

/// The method of the true motions, and its numbers of steps over the number within the limit. It has
/// the same bits on every machine.
pub(super) const TRUE: &str = "leapfrog:damping=explicit";
pub(super) const FINE: [u32; 2] = [2, 4];
/// Seeds of the noise on the starts of further true motions, and its size along each axis, m.
pub(super) const NOISY: [u64; 3] = [1, 2, 3];
pub(super) const NOISE: f64 = 1e-6;

/// The table, with the cloth on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Table {
    /// The drape test of a bundled material, with this number of squares across.
    Round(&'static str, u32),
    /// A grid of springs with this number of particles a side. Its middle square, of half the side,
    /// is held.
    Square(u32),
}

/// A scene, before its system is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Case {
    table: Table,
    /// Longest simulated time, s.
    span_s: f64,
    is_quick: bool,
}

/// The scenes: a small one for the quick subset, a firm and a soft fabric on a round table, and
/// springs alone on a square one.
pub(super) fn cases() -> Vec<Case> {
    let round = |fabric| Case { table: Table::Round(fabric, 12), span_s: 3.0, is_quick: false };
    vec![
        Case { table: Table::Round("ponte", 8), span_s: 2.0, is_quick: true },
        round("denim"),
        round("ponte"),
        Case { table: Table::Square(20), span_s: 3.0, is_quick: false },
    ]
}

impl Case {
    /// Whether the quick subset has this case.
    pub(super) fn is_quick(&self) -> bool {
        self.is_quick
    }

    pub(super) fn id(&self) -> String {
        match self.table {
            Table::Round(fabric, cells) => format!("round table, {fabric}, {cells} squares"),
            Table::Square(side) => format!("square table, springs, n={}", side * side),
        }
    }

    /// The system at its start: flat, without stress, and with small vertical velocities.
    pub(super) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        let mut spec = match self.table {
            Table::Round(fabric, cells) => round(fabric, cells)?,
            Table::Square(side) => square(side)?,
        };
        spec.name = self.id();
        let mut random = Random::new(SEED);
        let held: Vec<u32> = spec.pins.iter().map(|pin| pin.particle).collect();
        let velocity = |i: u32| {
            let speed = random.between(-NUDGE, NUDGE);
            [0.0, 0.0, if held.contains(&i) { 0.0 } else { speed }]
        };
        spec.particles.velocity_m_s =
            (0..spec.particles.mass_kg.len() as u32).map(velocity).collect();
        Ok(spec)
    }
}

fn round(fabric: &str, cells: u32) -> Result<SystemSpec, HarnessError> {
    let [radius_m, support_m] = RADII;
    let material =
        MaterialChoice { retardation_s: Some(RETARDATION), ..MaterialChoice::named(fabric) };
    let mut scene = Disc { radius_m, support_m, cells, warp_deg: 0.0, material }.scene()?;
    // Full damping would resist every turn of a stiff spring, so the cloth would creep.
    scene.damping = DampingLaw::Projected;
    let drag = AIR * Material::load(fabric)?.areal_density_kg_m2;
    let drag = DragSpec::Linear { coefficient_n_s_per_m3: drag };
    scene.effects.air = Some(AirSpec { drag, wind: None });
    Ok(scene.discretise()?)
}

fn square(side: u32) -> Result<SystemSpec, HarnessError> {
    let springs = |share: f64| {
        json!({ "stiffness_over_mass_per_s2": share * STIFFNESS,
                "damping_over_mass_per_s": share * DAMPING })
    };
    let scene = json!({
        "format": "drape-scene/1",
        "name": "square table",
        "cloth": { "grid": { "rows": side, "columns": side, "size_m": [1, 1],
                             "center_m": [0, 0, 0], "mass_kg": 0.4 } },
        "effects": { "tension": springs(1.0), "shear": springs(SHEAR), "bending": springs(BENDING),
                     "gravity": { "m_s2": [0, 0, -9.81] } },
        "damping": "full",
        "time": { "step_s": 0.01, "duration_s": 1.0 },
    });
    let mut spec = drape_model::parse("square table", &scene.to_string())?.spec().clone();
    let is_held = |x: &[f64; 3]| x[0].abs().max(x[1].abs()) <= 0.25;
    let held = (0_u32..).zip(&spec.particles.position_m).filter(|(_, x)| is_held(x));
    spec.pins = held.map(|(i, _)| PinSpec::still(i)).collect();
    Ok(spec)
}

/// A scene with its rest shapes.
pub(super) struct Setting {
    pub(super) scene: Scene,
    pub(super) hash: String,
    simulation: Simulation,
    camera: Camera,
}

/// Results of a run before its judgement.
struct Shown {
    counts: Counts,
    seen: Seen,
    /// Work up to each look.
    work: Vec<Counted>,
    /// Force and speed at the last look.
    residual: f64,
    speed: f64,
}

impl Setting {
    /// The scene with its rest shapes.
    pub(super) fn new(case: &Case) -> Result<Self, HarnessError> {
        let mut setting = Self::staged(case)?;
        setting.find_shapes(case)?;
        Ok(setting)
    }

    /// The scene without its rest shapes and energies. Its runs can be timed, but not judged.
    pub(super) fn staged(case: &Case) -> Result<Self, HarnessError> {
        let spec = case.spec()?;
        let (system, state) = spec.build()?;
        let simulation = Simulation { system, state };
        let triangles = match case.table {
            Table::Round(..) => spec.triangles.clone(),
            Table::Square(side) => cut(side),
        };
        let rate = f64::from(LOOKS_PER_S);
        let frames = (case.span_s * rate).round() as u32;
        let threads = threads(&spec);
        let camera = Camera { triangles, threads, tracked: Vec::new(), rate, frames, stride: 1 };
        let (bound, damping) = gershgorin(&simulation.system);
        let explicit = 4.0 / (damping + (damping * damping + 4.0 * bound).sqrt());
        let scene = Scene {
            id: case.id(),
            particles: simulation.system.len(),
            springs: spec.springs.len(),
            is_priced: matches!(case.table, Table::Square(_)),
            span_s: case.span_s,
            limit_steps: (1.0 / (rate * explicit)).ceil() as u32,
            released_j: 0.0,
            prestress: 0.0,
            minima: Vec::new(),
            motions: Vec::new(),
            accepted: Vec::new(),
            portable: true,
        };
        Ok(Self { scene, hash: system_hash(&spec), simulation, camera })
    }

    /// Computes the energies of the scene, its rest shapes and its true motions.
    fn find_shapes(&mut self, case: &Case) -> Result<(), HarnessError> {
        let released = reference_energy(&self.simulation, case.span_s)?;
        let stores = |name: &str| name != "gravity";
        let energies = self.simulation.system.energies(&self.simulation.state.x);
        let stored: f64 = energies.filter(|(name, _)| stores(name)).map(|(_, e)| e).sum();
        self.scene.released_j = released;
        self.scene.prestress = stored / released;
        self.scene.minima = WAVES.map(|waves| minimum(&self.simulation, waves)).to_vec();
        self.scene.motions = self.motions()?;
        self.accept();
        Ok(())
    }

    /// The true motions. Noise far below any error of a method shows whether another fold is as
    /// natural an end.
    fn motions(&self) -> Result<Vec<Motion>, HarnessError> {
        let mut motions = vec![self.motion("true motion".to_owned(), &self.simulation)?];
        for seed in NOISY {
            let mut start = self.simulation.clone();
            let mut random = Random::new(seed);
            for (x, is_pinned) in start.state.x.iter_mut().zip(start.system.pinned()) {
                let way = random.vector() * NOISE;
                if !is_pinned {
                    *x += way;
                }
            }
            motions.push(self.motion(format!("true motion, noise {seed}"), &start)?);
        }
        Ok(motions)
    }

    /// A true motion from a start, with each of its steps.
    fn motion(&self, from: String, start: &Simulation) -> Result<Motion, HarnessError> {
        let choice = Choice::parse(TRUE, &[])?;
        let end = |times: u32| {
            let steps = times * self.scene.limit_steps;
            let shown = self.watch(&choice, start, steps)?;
            Ok::<_, HarnessError>(End { steps, energy_j: self.end(&shown) })
        };
        let ends = FINE.into_iter().map(end).collect::<Result<Vec<_>, _>>()?;
        let first = ends.first().and_then(|end| end.energy_j);
        let is_converged = ends.iter().all(|End { energy_j: energy, .. }| {
            first.zip(*energy).is_some_and(|(a, b)| self.excess(a, b).abs() <= RIGHT)
        });
        Ok(Motion { from, ends, is_converged })
    }

    /// The energy of the minimum in which a run ends; `None` if it does not end near one.
    fn end(&self, shown: &Shown) -> Option<f64> {
        let system = &self.simulation.system;
        let last = shown.seen.looks.last()?;
        let mut x = last.x.clone();
        let found = rest(system, &mut x, TOLERANCE, MOST);
        let is_there = found.residual <= RESIDUAL && self.camera.distance(&last.x, &x) <= THERE;
        (is_there && is_minimum(system, &x)).then(|| finite(system.potential_energy(&x)))
    }

    /// Lists the minima that count as right: the least known, and the ends of converged true
    /// motions.
    fn accept(&mut self) {
        let scene = &self.scene;
        let least = self.least();
        let known = scene.minima.iter().filter(|minimum| minimum.is_minimum);
        let known = known.map(|minimum| (minimum.energy_j, &minimum.from));
        let known = known.filter(|(energy, _)| self.excess(*energy, least) <= ALIKE);
        let ends = scene.motions.iter().filter(|motion| motion.is_converged).filter_map(|motion| {
            // The shortest step is nearest to the truth.
            Some((motion.ends.last()?.energy_j?, &motion.from))
        });
        let mut accepted: Vec<Accepted> = Vec::new();
        for (energy_j, from) in known.chain(ends) {
            let is_it =
                |other: &&mut Accepted| self.excess(energy_j, other.energy_j).abs() <= ALIKE;
            match accepted.iter_mut().find(is_it) {
                Some(other) => other.from.push(from.clone()),
                None => accepted.push(Accepted {
                    energy_j,
                    excess_energy: self.excess(energy_j, least),
                    from: vec![from.clone()],
                }),
            }
        }
        self.scene.accepted = accepted;
    }

    /// The energy of the accepted minimum that is nearest to this energy, J. An energy below all of
    /// them counts as the least known: such a run may be better than its record can repeat.
    fn reached(&self, energy: f64) -> Option<f64> {
        let all = self.scene.accepted.iter().map(|accepted| accepted.energy_j);
        let is_below = all.clone().all(|other| energy < other);
        let off = |other: &f64| self.excess(energy, *other).abs();
        let nearest = all.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (is_below || off(&nearest) <= RIGHT).then_some(nearest)
    }

    /// Runs a method from a start until the cloth is at rest or its time is over.
    fn watch(
        &self,
        choice: &Choice,
        start: &Simulation,
        steps: u32,
    ) -> Result<Shown, HarnessError> {
        let is_look = move |moment: &Moment<'_>| moment.step.is_multiple_of(u64::from(steps));
        let measured = Rc::new(RefCell::new((Vec::new(), f64::MAX, f64::MAX)));
        let mass: f64 = self.simulation.system.mass().iter().sum();
        let kept = Rc::clone(&measured);
        let runner = Runner::new(choice, self.camera.span(steps, self.camera.frames))
            .reference(self.scene.released_j)
            .budget(BUDGET)
            .stop(move |moment| {
                if !is_look(moment) {
                    return false;
                }
                let force = residual(moment.system, &moment.state.x);
                let speed = (2.0 * moment.system.kinetic_energy(&moment.state.v) / mass).sqrt();
                let mut kept = kept.borrow_mut();
                kept.0.push(moment.counted);
                (kept.1, kept.2) = (finite(force), finite(speed));
                force <= RESIDUAL && speed <= SPEED
            });
        let (counts, seen) = self.camera.film(runner, start, &start.state.x, steps)?;
        let (work, residual, speed) = measured.take();
        Ok(Shown { counts, seen, work, residual, speed })
    }

    fn run(&self, film: &Film, steps: u32) -> Result<Run, HarnessError> {
        let choice = Choice::parse(film.form.method, &[])?;
        let mut run = Run {
            scene: self.scene.id.clone(),
            label: film.form.label.to_owned(),
            method: choice.full_id(),
            steps,
            is_limited: film.substeps == Substeps::Limit,
            verdict: Verdict::Refused,
            arrival_s: None,
            shape_error_m: None,
            residual: None,
            speed_m_s: None,
            rest_energy_j: None,
            is_minimum: None,
            excess_energy: None,
            reached_j: None,
            gain: 0.0,
            effort: None,
            modelled_s: None,
            counts: Counters::default(),
            portable: choice.is_portable(),
        };
        let shown = match self.watch(&choice, &self.simulation, steps) {
            Ok(shown) => shown,
            Err(HarnessError::Prepare(PrepareError::Unsupported { .. })) => return Ok(run),
            Err(error) => return Err(error),
        };
        run.counts = Counters::of(&shown.counts.outcome);
        run.gain = finite(shown.counts.energy.gain / self.scene.released_j);
        run.verdict = shown.counts.verdict(self.scene.released_j);
        if matches!(run.verdict, Verdict::Diverged | Verdict::Unstable) {
            return Ok(run);
        }
        self.judge(&mut run, &shown, &choice);
        Ok(run)
    }

    /// Compares a run with the rest shape that is nearest to its end.
    fn judge(&self, run: &mut Run, shown: &Shown, choice: &Choice) {
        let system = &self.simulation.system;
        let Some(last) = shown.seen.looks.last() else { return };
        let mut x = last.x.clone();
        let found = rest(system, &mut x, TOLERANCE, MOST);
        let is_rest = found.residual <= RESIDUAL;
        let apart = |look: &[Vec3]| self.camera.distance(look, &x);
        let error = apart(&last.x);
        run.shape_error_m = Some(error);
        run.residual = Some(shown.residual);
        run.speed_m_s = Some(shown.speed);
        let energy = finite(system.potential_energy(&x));
        let excess = self.excess(energy, self.least());
        run.rest_energy_j = Some(energy);
        run.excess_energy = Some(excess);
        run.reached_j = self.reached(energy);
        if is_rest && excess < -ALIKE {
            run.is_minimum = Some(is_minimum(system, &x));
        }
        let looks = &shown.seen.looks;
        let away = looks.iter().rposition(|look| apart(&look.x) > THERE);
        let first = away.map_or(0, |last_away| last_away + 1);
        let is_at_rest = shown.residual <= RESIDUAL && shown.speed <= SPEED;
        let has_time = looks.len() - first >= SETTLED || is_at_rest;
        if is_rest && first < looks.len() && has_time {
            run.arrival_s = Some((first + 1) as f64 / f64::from(LOOKS_PER_S));
            let work = &shown.work[first];
            run.effort = Some(work.visits());
            let price = prices().own(&choice.full_id()).filter(|_| self.scene.is_priced);
            run.modelled_s = price.map(|price| work.seconds(price));
        } else if run.verdict < Verdict::Marginal {
            let is_cut = shown.counts.outcome.is_over_budget && !is_at_rest;
            let is_locked = error > LOCKED * apart(&self.simulation.state.x);
            run.verdict = match (is_cut, is_locked) {
                (true, _) => Verdict::OverBudget,
                (_, true) => Verdict::Locked,
                (_, false) => Verdict::Open,
            };
        }
    }

    /// The least known energy of a rest shape, J.
    fn least(&self) -> f64 {
        let least = self.scene.minima.iter().filter(|minimum| minimum.is_minimum);
        least.map(|minimum| minimum.energy_j).fold(f64::INFINITY, f64::min)
    }

    /// Adds the best rest shape to which a run came, and judges the shapes of all runs anew.
    pub(super) fn learn(&mut self, runs: &mut [Run]) {
        let better = runs.iter().filter(|run| run.portable && run.is_minimum == Some(true));
        let better = better.filter_map(|run| Some((run.rest_energy_j?, run)));
        if let Some((energy_j, run)) = better.min_by(|a, b| a.0.total_cmp(&b.0)) {
            self.scene.minima.push(Minimum {
                from: format!("{}, {} steps", run.label, run.steps),
                energy_j,
                // The search began at the end of the run.
                residual: TOLERANCE,
                is_minimum: true,
            });
        }
        self.accept();
        let least = self.least();
        for run in runs {
            run.excess_energy = run.rest_energy_j.map(|energy| self.excess(energy, least));
            run.reached_j = run.rest_energy_j.and_then(|energy| self.reached(energy));
        }
    }

    /// Energy above the least one, over the released energy.
    fn excess(&self, energy: f64, least: f64) -> f64 {
        finite((energy - least) / self.scene.released_j)
    }
}

impl Stage for Setting {
    type Run = Run;
    type Row = TimingRow;

    fn hash(&self) -> &str {
        &self.hash
    }

    fn films(&self) -> Vec<Film> {
        forms()
    }

    /// All runs of a form, with rising numbers of steps until one arrives.
    fn runs(&self, film: &Film) -> Result<Vec<Run>, HarnessError> {
        match film.substeps {
            Substeps::Ladder => {
                let mut runs: Vec<Run> = Vec::new();
                for (n, steps) in STEPS.into_iter().enumerate() {
                    if n >= ALWAYS && runs.iter().any(|run| run.is_right() || run.is_refused()) {
                        break;
                    }
                    runs.push(self.run(film, steps)?);
                }
                Ok(runs)
            }
            Substeps::Limit => {
                let mut last = Vec::new();
                for share in SHARES {
                    let steps = (share * f64::from(self.scene.limit_steps)).ceil() as u32;
                    let run = self.run(film, steps)?;
                    let is_over = run.arrival_s.is_some() || run.is_refused();
                    last = vec![run];
                    if is_over {
                        break;
                    }
                }
                Ok(last)
            }
        }
    }

    fn scene(run: &Run) -> &str {
        &run.scene
    }

    fn is_timed(run: &Run) -> bool {
        run.is_right()
    }

    fn seconds(row: &TimingRow) -> f64 {
        row.seconds
    }

    fn time(&self, run: &Run) -> Result<TimingRow, HarnessError> {
        let choice = Choice::parse(&run.method, &[])?;
        let looks = run.arrival_s.unwrap_or(self.scene.span_s) * f64::from(LOOKS_PER_S);
        let time = self.camera.span(run.steps, looks.round() as u32);
        let Taken { samples_s, seconds, probe_s } = samples(LONG_S, || {
            let runner = Runner::new(&choice, time).processor();
            Ok(runner.go(&mut self.simulation.clone())?.seconds())
        })?;
        Ok(TimingRow {
            scene: run.scene.clone(),
            label: run.label.clone(),
            steps: run.steps,
            samples_s,
            seconds,
            probe_s: Some(probe_s),
        })
    }
}

impl Run {
    fn is_refused(&self) -> bool {
        self.verdict == Verdict::Refused
    }
}

/// Number of looks for which a cloth must stay near its rest shape.
pub(super) const SETTLED: usize = 3;

/// The rest shape that Newton's method finds from a start with this number of waves around the
/// table.
fn minimum(simulation: &Simulation, waves: u32) -> Minimum {
    let Simulation { system, state } = simulation;
    let mut x = state.x.clone();
    let held = x.iter().zip(system.pinned()).filter(|(_, pinned)| **pinned);
    let support = held.map(|(x, _)| libm::hypot(x.x, x.y)).fold(0.0, f64::max);
    let reach = x.iter().map(|x| libm::hypot(x.x, x.y)).fold(0.0, f64::max);
    for (x, pinned) in x.iter_mut().zip(system.pinned()) {
        if !pinned {
            let (radius, angle) = (libm::hypot(x.x, x.y), libm::atan2(x.y, x.x));
            let beyond = (radius - support).max(0.0) / reach;
            let wave = 1.0 + 0.5 * libm::cos(f64::from(waves) * angle + PHASE);
            x.z = -0.6 * reach * beyond * beyond * wave;
        }
    }
    let found = rest(system, &mut x, TOLERANCE, MOST);
    Minimum {
        from: format!("{waves} waves"),
        energy_j: system.potential_energy(&x),
        residual: finite(found.residual),
        is_minimum: found.residual <= RESIDUAL && is_minimum(system, &x),
    }
}

/// Phase of the waves, rad. With it no start is symmetric about warp or weft.
const PHASE: f64 = 0.3;
