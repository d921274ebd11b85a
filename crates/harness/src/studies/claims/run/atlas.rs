//! The stability atlas: step sizes × stiffnesses × dampings on several scenes, judged by energy.

use super::scenes::{build, hanging, shake, spinning};
use crate::HarnessError;
use crate::methods::Choice;
use crate::run::{Runner, Simulation};
use crate::schedule::Schedule;
use crate::stability::{judge, reference};
use crate::studies::sheet::Sheet;
use drape_model::TimeSpan;
use drape_report::Verdict;
use rayon::prelude::*;

/// Particles along an edge.
const SIDE: u32 = 10;
const STEPS: [f64; 4] = [1e-3, 1e-2, 1.0 / 15.0, 0.1];
const STIFFNESSES: [f64; 4] = [1e2, 1e4, 1e6, 1e8];
const DAMPINGS: [f64; 2] = [0.0, 40.0];
/// Greatest stiffness over mass whose true motion is computed for `E_ref`, 1/s²: stiffer sheets set
/// free the same.
const TAME: f64 = 1e5;
/// Most visits of a spring in a run: about 0.2 s.
const BUDGET: f64 = 4e7;

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scene {
    /// The sheet falls from the horizontal and swings.
    Hanging,
    /// The same from 0.7 times its size, crumpled at random: most springs are compressed at first.
    Squeezed,
    /// A free sheet turns over and over at 5/s.
    Spinning,
}

/// A place of the atlas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) scene: Scene,
    pub(super) step: f64,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    /// Seed of the perturbation.
    pub(super) seed: u64,
}

/// What the energy of a run did.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    pub(super) verdict: Verdict,
    /// Greatest rise above the start over `E_ref`.
    pub(super) gain: f64,
    /// Steps in which it rose by more than round-off.
    pub(super) rises: u64,
    pub(super) steps: u64,
    pub(super) is_over_budget: bool,
}

/// All places.
pub(super) fn places() -> Vec<Place> {
    let mut places = Vec::new();
    for scene in [Scene::Hanging, Scene::Squeezed, Scene::Spinning] {
        for step in STEPS {
            for stiffness in STIFFNESSES {
                for (seed, damping) in (1..).zip(DAMPINGS) {
                    places.push(Place { scene, step, stiffness, damping, seed });
                }
            }
        }
    }
    places
}

impl Place {
    fn start(&self, stiffness: f64) -> Result<Simulation, HarnessError> {
        let mesh = 1.0 / f64::from(SIDE - 1);
        let sheet = Sheet { shear: 0.1 * stiffness, ..hanging(SIDE, stiffness, self.damping) };
        let mut start = match self.scene {
            Scene::Spinning => {
                let mut start = spinning(SIDE, stiffness, 5.0)?;
                if self.damping > 0.0 {
                    let sheet = Sheet { is_pinned: false, gravity: [0.0; 3], ..sheet };
                    start.system = build(&sheet.spec()?)?.system;
                }
                start
            }
            Scene::Hanging | Scene::Squeezed => build(&sheet.spec()?)?,
        };
        if self.scene == Scene::Squeezed {
            start.state.x.iter_mut().for_each(|x| *x *= 0.7);
            shake(&mut start, 0.1 * mesh, self.seed);
        } else {
            // So little that it stores no energy worth mentioning in the stiffest springs.
            shake(&mut start, 1e-7 * mesh, self.seed);
        }
        Ok(start)
    }

    /// Runs a method here for at least 2 s and 200 steps.
    pub(super) fn run(&self, method: &str) -> Result<Survey, HarnessError> {
        let choice = Choice::parse(method, &[])?;
        let duration_s = (200.0 * self.step).max(2.0);
        let schedule = Schedule::steady(TimeSpan { step_s: self.step, duration_s });
        let start = self.start(self.stiffness)?;
        // Squeezed springs store k: their scene sets free more the stiffer it is, at once.
        let first = Schedule::steady(TimeSpan { step_s: 0.01, duration_s: 2.0 });
        let tame = self.stiffness.min(TAME);
        let scale = if self.scene == Scene::Squeezed { self.stiffness / tame } else { 1.0 };
        let available = scale * reference(&self.start(tame)?, &first)?.energy;
        let runner = Runner::by(&choice, &schedule).reference(available).budget(BUDGET);
        let run = runner.count(&start)?;
        let verdict = match run.outcome.divergence {
            Some(_) => Verdict::Diverged,
            None => judge(&run.energy, run.rule, available),
        };
        Ok(Survey {
            verdict,
            gain: run.energy.gain / available,
            rises: run.energy.rises,
            steps: run.outcome.steps,
            is_over_budget: run.outcome.is_over_budget,
        })
    }
}

/// Runs a method at all places.
pub(super) fn survey(method: &str) -> Result<Vec<Survey>, HarnessError> {
    places().par_iter().with_max_len(1).map(|place| place.run(method)).collect()
}

/// What was run, in prose.
pub(super) const SCENES: &str = "sheets of 10 × 10 with shear springs of 0.1 k: hanging, squeezed \
                                 to 0.7 of their size and crumpled, spinning freely at 5/s; h = \
                                 0.001, 0.01, 1/15, 0.1 s × k/m = 1e2, 1e4, 1e6, 1e8/s² × d/m = 0, \
                                 40/s; at least 2 s and 200 steps each";
