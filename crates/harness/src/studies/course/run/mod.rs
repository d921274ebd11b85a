//! Experiment `course`: from explicit Euler to two-step IMEX, each method on the same cloth.

use super::lessons::{HEADLINE, LESSONS, Plan};
use crate::cost::prices;
use crate::facts::{Fact, fact};
use crate::methods::{self, Choice};
use crate::run::{Counts, Runner, Simulation};
use crate::scenes::{build, bundled, free_edge_midpoint};
use crate::stability::{Rule, gershgorin, judge};
use crate::studies::course::facts::{Facts, Lesson, Run, Scene, Support};
use crate::studies::{Context, Measured, Start, cells, prepared};
use crate::{HarnessError, system_hash};
use drape_integrator::Method;
use drape_model::{Effect, State, System, TimeSpan};
use drape_report::Verdict;
use serde_json::json;

const SCENES: [&str; 2] = ["hanging-textile-sheared-1e4", "hanging-textile-sheared-1e6"];
/// The scene of the quick subset.
const QUICK: &str = SCENES[0];
const STEP: f64 = 0.01;
/// Simulated time, s. Verdicts need at least 200 steps.
const DURATION: f64 = 2.0;
/// Span over which the motion is compared, s. Two references with different steps agree until then.
const COMPARED: f64 = 1.0;
/// Number of steps between recorded heights.
const STRIDE: u64 = 5;
/// Step of the reference, as a share of the stability limit.
const SAFETY: f64 = 0.25;
/// Effort after which a run is over budget, in visits of a spring: some seconds.
const BUDGET: f64 = 3e9;

/// The cloth at one stiffness, with its true motion.
struct Setting {
    id: &'static str,
    simulation: Simulation,
    tracked: usize,
    hash: String,
    scene: Scene,
}

/// Records the free edge's midpoint and the greatest elongation of the springs.
struct Sight {
    tracked: usize,
    /// Number of the run's steps in one step of length [`STEP`].
    division: u64,
    last: drape_model::Vec3,
    path: f64,
    heights: Vec<f64>,
    stretch: f64,
}

/// Greatest elongation of a spring, over its rest length.
fn stretch(system: &System, state: &State) -> f64 {
    let mut greatest = 0.0_f64;
    for split in system.effects().filter_map(Effect::split) {
        split.visit_rest_lengths(&mut |i, j, rest| {
            greatest = greatest.max((state.x[i] - state.x[j]).norm() / rest - 1.0);
        });
    }
    greatest
}

impl Sight {
    fn new(simulation: &Simulation, tracked: usize, division: u64) -> Self {
        let last = simulation.state.x[tracked];
        Self { tracked, division, last, path: 0.0, heights: vec![last.z], stretch: 0.0 }
    }

    /// Looks at the end of a step.
    fn look(&mut self, step: u64, system: &System, state: &State) {
        if !step.is_multiple_of(self.division) || !state.is_finite() {
            return;
        }
        let step = step / self.division;
        let x = state.x[self.tracked];
        if step as f64 * STEP <= COMPARED * (1.0 + 1e-9) {
            self.path += (x - self.last).norm();
        }
        self.last = x;
        self.stretch = self.stretch.max(stretch(system, state));
        if step.is_multiple_of(STRIDE) {
            self.heights.push(x.z);
        }
    }
}

/// Greatest difference between two series of heights within the compared span, m.
fn height_error(heights: &[f64], others: &[f64]) -> f64 {
    let compared = (COMPARED / (STEP * STRIDE as f64)).round() as usize + 1;
    let pairs = heights.iter().zip(others).take(compared);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The result of a run.
struct Seen {
    sight: Sight,
    outcome: crate::run::Outcome,
    energy: crate::stability::Energy,
    energy_change: f64,
    rule: Rule,
}

/// Runs a method over the whole duration. Each step of [`STEP`] is divided into `division` parts.
fn watch(
    simulation: &Simulation,
    tracked: usize,
    choice: &Choice,
    division: u64,
) -> Result<Seen, HarnessError> {
    let time = TimeSpan { step_s: STEP / division as f64, duration_s: DURATION };
    let mut sight = Sight::new(simulation, tracked, division);
    let runner = Runner::new(choice, time).budget(BUDGET);
    let runner = runner.observe(|moment| sight.look(moment.step, moment.system, moment.state));
    let Counts { outcome, energy, rule, state: end } = runner.count(simulation)?;
    let Simulation { system, state } = simulation;
    Ok(Seen {
        sight,
        energy,
        energy_change: system.total_energy(&end) - system.total_energy(state),
        rule,
        outcome,
    })
}

impl Setting {
    fn new(id: &&'static str) -> Result<Self, HarnessError> {
        let scene = bundled(id)?;
        let tracked = free_edge_midpoint(&scene).unwrap_or_default();
        let tension = scene.effects.tension.as_ref().and_then(|law| law.stiffness_over_mass_per_s2);
        let (spec, simulation) = build(&scene)?;
        let (stiffness, damping) = gershgorin(&simulation.system);
        // Symplectic Euler is stable for h²λ + 2hδ < 4.
        let limit = 4.0 / (damping + (damping * damping + 4.0 * stiffness).sqrt());
        let division = ((STEP / (SAFETY * limit)).ceil() as u64).next_power_of_two();
        let choice = Choice::parse("symplectic-euler", &[])?;
        let coarse = watch(&simulation, tracked, &choice, division)?;
        let fine = watch(&simulation, tracked, &choice, 2 * division)?;
        let released = fine.energy.released;
        let samples = 0..fine.sight.heights.len() as u64;
        let scene = Scene {
            id: (*id).to_owned(),
            stiffness_over_mass_per_s2: tension.unwrap_or_default(),
            particles: simulation.system.len(),
            step_s: STEP,
            duration_s: DURATION,
            compared_s: COMPARED,
            released_energy_j: released,
            time_s: samples.map(|n| (n * STRIDE) as f64 * STEP).collect(),
            path_m: fine.sight.path,
            energy_change: fine.energy_change / released,
            greatest_stretch: fine.sight.stretch,
            reference_step_s: STEP / (2 * division) as f64,
            reference_error_m: height_error(&fine.sight.heights, &coarse.sight.heights),
            height_m: fine.sight.heights,
            portable: true,
        };
        Ok(Self { id, simulation, tracked, hash: system_hash(&spec), scene })
    }

    fn run(&self, plan: &Plan) -> Result<Run, HarnessError> {
        let Scene { released_energy_j: released, path_m, .. } = self.scene;
        let choice = Choice::parse(plan.method, &[])?;
        let Seen { sight, outcome, energy, energy_change, rule } =
            watch(&self.simulation, self.tracked, &choice, 1)?;
        let verdict = match &outcome.divergence {
            Some(_) => Verdict::Diverged,
            None if outcome.is_over_budget => Verdict::OverBudget,
            None => judge(&energy, rule, released),
        };
        let is_stable = verdict == Verdict::Stable;
        let has_ended_well = outcome.divergence.is_none();
        let error = height_error(&sight.heights, &self.scene.height_m);
        let totals = outcome.totals;
        Ok(Run {
            scene: self.id.to_owned(),
            settings: choice.full_id(),
            verdict,
            reached_s: outcome.divergence.map_or(outcome.steps as f64 * STEP, |end| end.time),
            steps: outcome.steps,
            retained_motion: is_stable.then_some(sight.path / path_m),
            height_error_m: is_stable.then_some(error),
            energy_gain: has_ended_well.then_some(energy.gain / released),
            energy_change: has_ended_well.then_some(energy_change / released),
            greatest_stretch: is_stable.then_some(sight.stretch),
            force_evaluations: totals.force_evaluations,
            matvecs: totals.matvecs,
            cg_iterations: totals.cg_iterations,
            newton_iterations: totals.newton_iterations,
            factorisations: totals.factorisations,
            modelled_s: outcome.counted.seconds(prices().of(&choice.full_id())),
            height_m: sight.heights,
            portable: choice.is_portable(),
        })
    }
}

/// How the facts are measured.
pub(super) fn method() -> String {
    "A sheet of 20 × 20 particles, 1 m × 1 m, hangs by two corners and swings down from the \
     horizontal. Tension springs have k/m = 10⁴ or 10⁶ s⁻² and d/m = 40 s⁻¹; shear springs are a \
     tenth as stiff. Every method takes 200 steps of 0.01 s, at its defaults unless the lesson \
     states other settings; leapfrog divides the step. A run is stable if the total energy never \
     rises by more than 2 % of E_ref, the energy that the fall sets free. Symplectic Euler at \
     less than a quarter of its limit computes the true motion. Retained motion R is the path of \
     the free edge's midpoint in the first second over the true one. Work is modelled time: the \
     counted work times the prices of the method."
        .to_owned()
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    SCENES.map(|id| Start::new(id, move || Ok(bundled(id)?.discretise()?))).into()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let chosen: Vec<_> =
        SCENES.into_iter().filter(|scene| !context.quick || *scene == QUICK).collect();
    let settings = prepared(context, "true motion", &chosen, Setting::new)?;
    let pairs: Vec<_> = LESSONS
        .iter()
        .flat_map(|plan| settings.iter().map(move |setting| (plan, setting)))
        .collect();
    let mut runs =
        cells(context, "lessons", &pairs, |(plan, setting)| setting.run(plan))?.all()?.into_iter();
    let mut lessons: Vec<Lesson> = Vec::new();
    let scenes: Vec<_> = settings.iter().map(|setting| setting.scene.clone()).collect();
    for plan in &LESSONS {
        let runs = runs.by_ref().take(settings.len()).collect();
        let name = Choice::parse(plan.method, &[])?.method().name;
        let lesson = super::words::lesson(plan, name, runs, &scenes, lessons.last());
        lessons.push(lesson);
    }
    let headline = HEADLINE.map(str::to_owned).into();
    let facts = Facts { scenes, lessons, headline, support: support() };
    let (facts, scenes, seed) =
        (facts, settings.iter().map(|s| (s.id.to_owned(), s.hash.clone())).collect(), None);
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// Method ids in the order of the lessons.
pub(crate) fn lessons() -> Vec<&'static str> {
    LESSONS.iter().map(Plan::id).collect()
}

/// The treatment by each method of every effect that some method knows.
fn support() -> Vec<Support> {
    let mut known: Vec<&str> = Vec::new();
    for support in methods::all().flat_map(Method::supports) {
        if !known.contains(&support.effect) {
            known.push(support.effect);
        }
    }
    let row = |method: &Method| {
        let treatment = |effect: &str| {
            let support = method.supports().find(|support| support.effect == effect);
            support.map_or("refused", |support| support.treatment.name())
        };
        let effects = known.iter().map(|&e| (e.to_owned(), treatment(e).to_owned())).collect();
        Support { method: method.id.to_owned(), effects }
    };
    methods::all().map(row).collect()
}

/// The study's facts in the form in which two records are compared. If a library's factorisation
/// takes part, its round-off depends on the machine, and two seconds of motion magnify it. Then
/// only the verdict is the same everywhere.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let Facts { scenes, lessons, support, .. } = facts;
    let scenes = scenes.iter().map(|scene| fact(format!("scene {}", scene.id), true, scene));
    let support = support.iter().map(|row| fact(format!("support {}", row.method), true, row));
    let runs = lessons.iter().flat_map(|lesson| {
        lesson.runs.iter().map(|run| {
            let key = format!("{} {}", run.scene, lesson.method);
            if run.portable {
                return fact(key, true, run);
            }
            fact(key, false, &json!({ "settings": run.settings, "verdict": run.verdict }))
        })
    });
    scenes.chain(support).chain(runs).collect()
}

#[cfg(test)]
mod tests;
