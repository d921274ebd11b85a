//! Records of a run's energy: samples, dissipation and the ledger.

use crate::run::{Moment, Simulation};
use crate::studies::energy::facts::Ledger;
use drape_integrator::EnergyLedger;
use drape_model::{Level, System, Vec3};
use std::collections::BTreeMap;

/// A sample beyond this many reference energies is left out, and so are all samples after it.
const FARTHEST: f64 = 10.0;

/// Sums over the steps of a run.
#[derive(Debug)]
pub(super) struct Flow {
    /// `E_ref`, J.
    reference: f64,
    start: f64,
    last: f64,
    /// Power of the damping at the end of the last step, W.
    power: f64,
    /// `∫ vᵀ D v dt`, J.
    dissipated: f64,
    /// `(H − H_0)/E_ref` at the samples.
    pub(super) energy: Vec<f64>,
    is_beyond: bool,
    /// Sums of the ledgers of the steps, J.
    ledger: Option<Ledger>,
    /// Sums of the errors and of the magnitudes of the ledgers, J.
    defect: f64,
    magnitude: f64,
}

/// `vᵀ D v`, W.
fn power(system: &System, at: Level<'_>) -> f64 {
    let mut force = vec![Vec3::zeros(); at.v.len()];
    system.effects().for_each(|effect| effect.add_damping_force(at, &mut force));
    -force.iter().zip(at.v).map(|(f, v)| f.dot(v)).sum::<f64>()
}

impl Flow {
    pub(super) fn new(simulation: &Simulation, reference: f64) -> Self {
        let Simulation { system, state } = simulation;
        let start = system.total_energy(state);
        Self {
            reference,
            start,
            last: start,
            power: power(system, state.level()),
            dissipated: 0.0,
            energy: vec![0.0],
            is_beyond: false,
            ledger: None,
            defect: 0.0,
            magnitude: 0.0,
        }
    }

    /// Looks at the end of a step.
    pub(super) fn look(&mut self, moment: &Moment<'_>, is_sample: bool) {
        let Moment { h, system, state, ref ledger, .. } = *moment;
        let energy = system.total_energy(state);
        let power = power(system, state.level());
        self.dissipated += 0.5 * h * (self.power + power);
        self.power = power;
        if let Some(step) = ledger {
            self.enter(step, energy - self.last);
        }
        self.last = energy;
        if is_sample {
            let gained = (energy - self.start) / self.reference;
            // A value that is not a number counts as beyond.
            self.is_beyond |= gained.is_nan() || gained.abs() > FARTHEST;
            if !self.is_beyond {
                self.energy.push(gained);
            }
        }
    }

    /// Adds the ledger of a step that changed the energy by `change`, J.
    fn enter(&mut self, step: &EnergyLedger, change: f64) {
        let sums = self.ledger.get_or_insert_with(|| Ledger {
            damping: 0.0,
            inertia: 0.0,
            gaps: BTreeMap::new(),
            residual: 0.0,
            constraint: 0.0,
            correction: 0.0,
        });
        sums.damping += step.damping;
        sums.inertia += step.inertia;
        for (effect, gap) in &step.gaps {
            *sums.gaps.entry((*effect).to_owned()).or_default() += gap;
        }
        sums.residual += step.residual;
        sums.constraint += step.constraint + step.impact;
        sums.correction += step.correction;
        self.defect += (step.sum() - change).abs();
        self.magnitude += step.magnitude();
    }

    /// Drift: `(H_N − H_0)/E_ref`.
    pub(super) fn drift(&self) -> f64 {
        (self.last - self.start) / self.reference
    }

    /// Excess dissipation: `(H_0 − H_N − ∫ vᵀ D v dt)/E_ref`.
    pub(super) fn excess_dissipation(&self) -> f64 {
        (self.start - self.last - self.dissipated) / self.reference
    }

    /// The sums of the ledger, over `E_ref`.
    pub(super) fn ledger(&self) -> Option<Ledger> {
        let share = |energy: f64| energy / self.reference;
        self.ledger.as_ref().map(|sums| Ledger {
            damping: share(sums.damping),
            inertia: share(sums.inertia),
            gaps: sums.gaps.iter().map(|(name, gap)| (name.clone(), share(*gap))).collect(),
            residual: share(sums.residual),
            constraint: share(sums.constraint),
            correction: share(sums.correction),
        })
    }

    /// Sum of the steps' absolute errors, over the magnitudes of their terms.
    pub(super) fn closure_defect(&self) -> Option<f64> {
        self.ledger
            .as_ref()
            .map(|_| if self.defect == 0.0 { 0.0 } else { self.defect / self.magnitude })
    }
}
