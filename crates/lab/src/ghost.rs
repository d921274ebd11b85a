//! A reference solution on a thread of its own, to be laid over panes.
//!
//! It is computed as the true motion of the study `animation`: by the leapfrog method, which is
//! explicit and of second order, at a quarter of its stability limit. Its steps divide the steps of
//! the pane evenly, so it reaches all times of the pane.

use crate::engine::{next, shown};
use crate::files::Files;
use crate::limits;
use crate::setup::{Setup, SetupError, Stage};
use crate::work::{Gate, LATE, Run, Runs, StepEnd, lock, start};
use drape_harness::methods::Choice;
use drape_harness::{Divergence, OrderedSimulation, Steps};
use drape_model::{TimeSpan, Violation};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};

/// The method of the reference.
const METHOD: &str = "leapfrog:damping=explicit";
/// Share of its stability limit at which it runs.
const SAFETY: f64 = 0.25;

/// Positions at the end of a step, m.
type Kept = (f64, Arc<Vec<[f32; 3]>>);

#[derive(Debug, Default)]
struct Inside {
    is_over: bool,
    refusal: Option<String>,
    kept: VecDeque<Kept>,
    /// Step of the panes, s.
    step: f64,
}

#[derive(Debug, Default)]
struct Shared {
    gate: Arc<Gate>,
    inside: Mutex<Inside>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Inside> {
        lock(&self.inside)
    }
}

/// A reference solution. Once the ghost is dropped, its run ends after the present step.
#[derive(Debug)]
pub struct Ghost {
    shared: Arc<Shared>,
}

impl Drop for Ghost {
    fn drop(&mut self) {
        self.shared.gate.close();
    }
}

impl Ghost {
    /// Starts the reference of a set-up, which does not depend on its method. `None` if too many
    /// runs exist.
    pub fn start(setup: &Setup, files: &Arc<Files>, runs: &Runs) -> Option<Self> {
        let ticket = runs.enter()?;
        let shared = Arc::new(Shared::default());
        let (worker, told) = (shared.clone(), shared.clone());
        let setup = Setup { method: METHOD.to_owned(), ..setup.clone() };
        let files = files.clone();
        let end = move |sentence: Option<String>| {
            let mut inside = told.lock();
            inside.is_over = true;
            inside.refusal = sentence.or(inside.refusal.take());
            drop(ticket);
        };
        start(shared.gate.clone(), move || Worker::begin(&setup, &files, worker), end)?;
        Some(Self { shared })
    }

    /// Lets the reference take all steps that end by this simulated time, s.
    pub fn go_until(&self, time: f64) {
        self.shared.gate.go_until(time);
    }

    /// The positions, m, at the end of the step of the panes that ends at `time`, s. `None` unless
    /// they are kept.
    pub fn at(&self, time: f64) -> Option<Arc<Vec<[f32; 3]>>> {
        let inside = self.shared.lock();
        let late = LATE * inside.step;
        let place = inside.kept.partition_point(|(t, _)| *t < time - late);
        let (t, kept) = inside.kept.get(place)?;
        ((t - time).abs() <= late).then(|| kept.clone())
    }

    /// Whether the reference has yet to reach `time`, s.
    pub fn is_behind(&self, time: f64) -> bool {
        let inside = self.shared.lock();
        let reached = inside.kept.back().map_or(f64::NEG_INFINITY, |(t, _)| *t);
        !inside.is_over && reached + inside.step <= time
    }

    /// Why there is no reference, or why it ended early.
    pub fn refusal(&self) -> Option<String> {
        self.shared.lock().refusal.clone()
    }
}

/// Root mean square of the distances of the particles, m. `None` where the numbers of particles
/// differ or are 0.
pub fn distance(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    let square = |(p, q): (&[f32; 3], &[f32; 3])| {
        p.iter().zip(q).map(|(p, q)| f64::from(p - q).powi(2)).sum::<f64>()
    };
    let is_same = a.len() == b.len() && !a.is_empty();
    is_same.then(|| (a.iter().zip(b).map(square).sum::<f64>() / a.len() as f64).sqrt())
}

/// Number of steps of the reference in one step of the pane.
fn substeps(stage: &Stage, simulation: &OrderedSimulation) -> Result<u64, Violation> {
    let step = stage.time.step_s;
    let limit = simulation.explicit_numbers().limit();
    let parts = (step / (SAFETY * limit)).ceil().max(1.0);
    let (whole, _) = stage.time.steps();
    if parts * (whole.max(1) as f64) > limits::STEPS as f64 {
        let expected = format!(
            "at most {} steps of {:.1e} s: a softer cloth or a shorter run",
            limits::STEPS,
            SAFETY * limit
        );
        let value = format!("{:.1e} steps", parts * whole as f64);
        return Err(Violation { path: "reference".to_owned(), value, expected });
    }
    Ok(parts as u64)
}

/// The run of the reference.
struct Worker {
    shared: Arc<Shared>,
    simulation: OrderedSimulation,
    steps: Option<Steps>,
    time: TimeSpan,
    /// Number of its steps in one step of the pane.
    parts: u64,
    /// Most times whose positions are kept.
    most: usize,
    /// Time at the end of its last step, s.
    now: f64,
}

impl Worker {
    fn begin(setup: &Setup, files: &Files, shared: Arc<Shared>) -> Result<Self, SetupError> {
        let stage = setup.stage_with(files)?;
        let choice = Choice::parse(METHOD, &[])?;
        let mut simulation = OrderedSimulation::new(&stage.spec, &choice)?;
        let parts = substeps(&stage, &simulation)?;
        let time = TimeSpan { step_s: stage.time.step_s / parts as f64, ..stage.time };
        let most = (limits::GHOST_BYTES / (12 * stage.spec.particles.mass_kg.len().max(1))).max(2);
        let steps = Some(simulation.begin(time, |runner| runner)?);
        shared.lock().step = stage.time.step_s;
        let worker = Self { shared, simulation, steps, time, parts, most, now: 0.0 };
        worker.keep();
        Ok(worker)
    }

    fn keep(&self) {
        let shown = Arc::new(shown(&self.simulation.moving().display_positions()));
        let mut inside = self.shared.lock();
        if inside.kept.len() >= self.most {
            inside.kept.pop_front();
        }
        inside.kept.push_back((self.now, shown));
    }
}

impl Run for Worker {
    fn next(&self) -> Option<StepEnd> {
        self.steps.as_ref().map(|_| StepEnd(next(self.now, self.time), self.time.step_s))
    }

    fn step(&mut self) -> Result<(), SetupError> {
        let Some(mut steps) = self.steps.take() else { return Ok(()) };
        let mut done = 0;
        let goes_on = self.simulation.step(&mut steps, |moment| {
            (done, self.now) = (moment.step, moment.state.t);
        })?;
        if done > 0 && (done.is_multiple_of(self.parts) || !goes_on) {
            self.keep();
        }
        if goes_on {
            self.steps = Some(steps);
        } else if let Some(Divergence { time, criterion, .. }) = steps.end().divergence {
            let refusal = format!("the reference diverged at t = {time:.3} s: {criterion}");
            self.shared.lock().refusal = Some(refusal);
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    #[test]
    fn a_distance_is_the_root_of_the_mean_square() {
        let (a, b) = ([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], [[3.0, 4.0, 0.0], [1.0, 1.0, 1.0]]);
        assert_eq!(distance(&a, &b), Some(12.5_f64.sqrt()));
        assert_eq!(distance(&a, &b[..1]), None);
    }

    #[test]
    fn the_reference_has_the_times_of_the_pane_and_moves() {
        let setup = Setup {
            scene: "hanging-textile-1e4".to_owned(),
            step: Some(0.01),
            duration: Some(0.105),
            ..Setup::default()
        };
        let ghost = Ghost::start(&setup, &Arc::default(), &Runs::default()).unwrap();
        ghost.go_until(1.0);
        let begin = Instant::now();
        while ghost.at(0.105).is_none() {
            assert!(begin.elapsed() < Duration::from_secs(60), "{:?}", ghost.refusal());
            std::thread::sleep(Duration::from_millis(2));
        }
        let (start, end) = (ghost.at(0.0).unwrap(), ghost.at(0.1).unwrap());
        // Free fall in 0.1 s is 0.049 m, and most of the cloth falls freely.
        let fallen = distance(&start, &end).unwrap();
        assert!((0.04..0.05).contains(&fallen), "{fallen}");
        assert!(ghost.at(0.055).is_none(), "no step of the pane ends there");
        assert_eq!(ghost.refusal(), None);
    }

    #[test]
    fn a_reference_of_too_many_steps_is_refused() {
        let setup = Setup {
            scene: "hanging-textile-1e4".to_owned(),
            stiffness: Some(1e10),
            duration: Some(3600.0),
            ..Setup::default()
        };
        let ghost = Ghost::start(&setup, &Arc::default(), &Runs::default()).unwrap();
        let begin = Instant::now();
        let refusal = loop {
            if let Some(refusal) = ghost.refusal() {
                break refusal;
            }
            assert!(begin.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(2));
        };
        assert!(refusal.contains("reference") && refusal.contains("softer cloth"), "{refusal}");
    }
}
