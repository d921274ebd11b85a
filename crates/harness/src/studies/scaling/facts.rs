//! Records of the experiment `scaling`: how cost grows with the number of particles.

use crate::record::Phases;
use drape_report::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// [`Cell::series`] with the same stiffness over mass on every mesh.
pub(super) const FIXED_QUOTIENT: &str = "k/m fixed";
/// [`Cell::series`] with the same cloth on every mesh.
pub(super) const FIXED_MATERIAL: &str = "material fixed";

/// Counts over all sizes and methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// One cell for each series, size and method.
    pub cells: Vec<Cell>,
}

/// Counts of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// `k/m fixed` or `material fixed`. In the latter, `k` and `d` are those of the sheet of 400
    /// particles, and masses shrink with the mesh.
    pub series: String,
    /// Particles along each edge.
    pub side: u32,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Stiffness over mass of the tension springs, 1/s².
    pub stiffness_over_mass_per_s2: f64,
    /// Damping over mass of the tension springs, 1/s.
    pub damping_over_mass_per_s: f64,
    /// Time step, s.
    pub step_s: f64,
    /// Number of steps.
    pub steps: u64,
    /// Short name for legends.
    pub label: String,
    /// Method id with all settings.
    pub method: String,
    /// Number of CG iterations a step.
    pub cg_per_step: f64,
    /// Number of products of the matrix with a block vector.
    pub matvecs: u64,
    /// Number of sweeps over all springs that evaluated forces or energies.
    pub force_evaluations: u64,
    /// Number of Newton iterations.
    pub newton_iterations: u64,
    /// Number of steps whose solver stopped before its tolerance.
    pub unconverged_steps: u64,
    /// `completed` or `diverged`.
    pub verdict: Verdict,
    /// Whether the record has the same bits on every machine.
    pub portable: bool,
}

/// A measurement of time or memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum TimingRow {
    /// The time of a cell of the facts.
    Run(RunTiming),
    /// What the allocator holds for a prepared method.
    Memory(Memory),
    /// The triad `a = b + s·c` over arrays much larger than the caches.
    Triad {
        /// Bytes moved by one pass over the three arrays.
        bytes: u64,
        /// Nanoseconds of each pass.
        samples_ns: Vec<u64>,
        /// Bytes over the shortest pass, byte/s.
        bytes_per_s: f64,
    },
}

/// Times of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunTiming {
    /// As in [`Cell::series`].
    pub series: String,
    /// Number of particles.
    pub particles: usize,
    /// As in [`Cell::label`].
    pub label: String,
    /// Number of steps.
    pub steps: u64,
    /// Nanoseconds in all `step` calls together with the phase clock off: one entry for each
    /// repetition.
    pub samples_ns: Vec<u64>,
    /// Median of the samples over particles and steps, ns.
    pub ns_per_particle_step: f64,
    /// Bytes that a step must move for each particle if the arrays are larger than the caches.
    /// Absent if they are not counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_bytes: Option<f64>,
    /// Seconds before the first step: allocation, pattern, and first build of matrix and
    /// preconditioner.
    pub prepare_s: f64,
    /// Times of the phases in a separate pass with the phase clock on, s.
    pub phases_s: Phases,
}

/// Memory of a prepared method, and the time to build it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Number of particles.
    pub particles: usize,
    /// Number of springs: tension, shear and bending.
    pub springs: usize,
    /// As in [`Cell::label`].
    pub label: String,
    /// Bytes of the system.
    pub system_bytes: u64,
    /// Bytes of the state.
    pub state_bytes: u64,
    /// Bytes of the method after `prepare`.
    pub integrator_bytes: u64,
    /// Seconds to check the specification and to build the system from it.
    pub build_s: f64,
    /// Seconds of `prepare`.
    pub prepare_s: f64,
}

/// The smallest and the largest mesh of a method in a series.
pub(super) struct Growth<'a> {
    pub(super) first: &'a Cell,
    pub(super) last: &'a Cell,
}

impl Growth<'_> {
    /// The mean power of the number of particles with which the CG iterations a step grow.
    pub(super) fn power(&self) -> f64 {
        let sizes = libm::log(self.last.particles as f64 / self.first.particles as f64);
        libm::log(self.last.cg_per_step / self.first.cg_per_step) / sizes
    }
}

/// The growth of each series and method with iterations on at least two meshes. Explicit methods
/// are left out, since they take shorter steps.
pub(super) fn growths(facts: &Facts) -> Vec<Growth<'_>> {
    let step = facts.cells.iter().map(|cell| cell.step_s).fold(0.0, f64::max);
    let mut growths: Vec<Growth<'_>> = Vec::new();
    for cell in facts.cells.iter().filter(|cell| cell.cg_per_step > 0.0 && cell.step_s == step) {
        let of = |other: &&Cell| (&other.series, &other.label) == (&cell.series, &cell.label);
        match growths.iter_mut().find(|growth| of(&growth.first)) {
            Some(growth) if cell.particles > growth.last.particles => growth.last = cell,
            Some(growth) if cell.particles < growth.first.particles => growth.first = cell,
            Some(_) => {}
            None => growths.push(Growth { first: cell, last: cell }),
        }
    }
    growths.retain(|growth| growth.last.particles > growth.first.particles);
    growths
}

impl Facts {
    /// Number of pairs of a series and a method with iterations on at least two meshes.
    pub(super) fn labels_with_iterations(&self) -> usize {
        let iterates = |cell: &&Cell| cell.cg_per_step > 0.0;
        let key = |cell: &'_ Cell| (cell.series.clone(), cell.label.clone());
        let mut keys: Vec<_> = self.cells.iter().filter(iterates).map(key).collect();
        keys.sort();
        keys.dedup_by(|a, b| a == b);
        let at_two = |of: &&(String, String)| {
            self.cells.iter().filter(iterates).filter(|cell| key(cell) == **of).count() > 1
        };
        keys.iter().filter(at_two).count()
    }
}
