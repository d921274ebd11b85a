//! A scene with one addition, and its runs.

use super::additions::{Addition, scene};
use super::{DURATION, PAIRS, step};
use crate::HarnessError;
use crate::methods::{Choice, MethodError};
use crate::run::{Outcome, Runner, Simulation};
use crate::studies::Allocated;
use crate::studies::effects::facts::{Cell, Effect, TimingRow};
use drape_integrator::{Implicit, Method, PrepareError, TimeStep};
use drape_model::{State, SystemSpec, TimeSpan};
use drape_report::Verdict;
use std::collections::BTreeSet;

/// A scene with one addition.
pub(super) struct Variant {
    pub(super) effect: Effect,
    pub(super) spec: SystemSpec,
    simulation: Simulation,
}

/// Whether a run was refused because the method does not support the scene.
fn is_refusal(error: &HarnessError) -> bool {
    matches!(error, HarnessError::Prepare(PrepareError::Unsupported { .. }))
}

impl Variant {
    pub(super) fn new(addition: &Addition) -> Result<Self, HarnessError> {
        let spec = scene(addition.name, &addition.adds)?;
        let (system, state) = spec.build()?;
        let mut pairs = BTreeSet::new();
        for effect in Implicit::Everything.effects(&system) {
            effect.visit_pairs(&mut |i, j| {
                pairs.insert((i.min(j), i.max(j)));
            });
        }
        let mut springs = 0;
        Implicit::Springs.visit_weights(&system, &mut |_, _, _, _| springs += 1);
        let effect = Effect {
            name: addition.name.to_owned(),
            adds: addition.adds.to_string(),
            objects: system.effects().count(),
            springs,
            coupled_pairs: pairs.len(),
        };
        Ok(Self { effect, spec, simulation: Simulation { system, state } })
    }

    fn run(&self, choice: &Choice) -> Result<(Outcome, State), HarnessError> {
        let time = TimeSpan { step_s: step(choice.method()), duration_s: DURATION };
        let mut simulation = self.simulation.clone();
        let outcome = Runner::new(choice, time).go(&mut simulation)?;
        Ok((outcome, simulation.state))
    }

    /// Counts of a method's run, and the distance of its sheet at the end from that of `nothing`.
    pub(super) fn cell(
        &self,
        nothing: &Self,
        method: &'static Method,
    ) -> Result<Cell, HarnessError> {
        let choice = Choice::parse(method.id, &[])?;
        let mut cell = Cell {
            effect: self.effect.name.clone(),
            method: method.id.to_owned(),
            step_s: step(method),
            verdict: Verdict::Refused,
            steps: 0,
            cg_iterations: 0,
            newton_iterations: 0,
            matvecs: 0,
            force_evaluations: 0,
            setups: 0,
            change_m: None,
            portable: choice.is_portable(),
        };
        let (Outcome { steps, totals, divergence, .. }, state) = match self.run(&choice) {
            Err(error) if is_refusal(&error) => return Ok(cell),
            run => run?,
        };
        cell.verdict = if divergence.is_some() { Verdict::Diverged } else { Verdict::Completed };
        cell.steps = steps;
        cell.cg_iterations = totals.cg_iterations;
        cell.newton_iterations = totals.newton_iterations;
        cell.matvecs = totals.matvecs;
        cell.force_evaluations = totals.force_evaluations;
        cell.setups = totals.setups;
        let (before, bare) = match nothing.run(&choice) {
            Err(error) if is_refusal(&error) => return Ok(cell), // it asks for the effect
            run => run?,
        };
        if divergence.is_none() && before.divergence.is_none() {
            cell.change_m = Some((distance(&state, &bare) * 1e6).round() * 1e-6);
        }
        Ok(cell)
    }

    /// Times runs with and without the effect in turns. Returns `None` if the method refuses the
    /// effect.
    pub(super) fn time(
        &self,
        nothing: &Self,
        choice: &Choice,
        allocated: Option<Allocated>,
    ) -> Result<Option<TimingRow>, HarnessError> {
        let (mut without_ns, mut with_ns) = (Vec::new(), Vec::new());
        let mut steps = 0;
        for _ in 0..PAIRS {
            let outcome = match self.run(choice) {
                Err(error) if is_refusal(&error) => return Ok(None),
                run => run?.0,
            };
            with_ns.push(outcome.wall.as_nanos() as u64);
            let bare = match nothing.run(choice) {
                Err(error) if is_refusal(&error) => return Ok(None),
                run => run?.0,
            };
            without_ns.push(bare.wall.as_nanos() as u64);
            steps = outcome.steps;
        }
        let least = |samples: &[u64]| samples.iter().min().map_or(f64::NAN, |ns| *ns as f64);
        let bytes = |variant: &Self| {
            allocated.map(|allocated| variant.bytes(choice, allocated)).transpose()
        };
        let bytes = bytes(self)?.zip(bytes(nothing)?);
        Ok(Some(TimingRow {
            effect: self.effect.name.clone(),
            method: choice.method().id.to_owned(),
            steps,
            ratio: least(&with_ns) / least(&without_ns),
            without_ns,
            with_ns,
            system_bytes: bytes.map(|(with, without)| with.0 - without.0),
            method_bytes: bytes.map(|(with, without)| with.1 - without.1),
        }))
    }

    /// Bytes that the allocator holds for the system and for the prepared method.
    fn bytes(&self, choice: &Choice, allocated: Allocated) -> Result<(i64, i64), HarnessError> {
        let start = allocated() as i64;
        let (system, state) = self.spec.build()?;
        drop(state);
        let built = allocated() as i64;
        let mut integrator = choice.build().map_err(MethodError::from)?;
        integrator.prepare(&system, TimeStep::new(step(choice.method()))?)?;
        Ok((built - start, allocated() as i64 - built))
    }
}

/// Root of the mean square of the distances of the particles, m.
fn distance(a: &State, b: &State) -> f64 {
    let squares = a.x.iter().zip(&b.x).map(|(a, b)| (a - b).norm_squared());
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}
