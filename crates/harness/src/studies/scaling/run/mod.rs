//! Experiment `scaling`: how cost grows with the number of particles.

mod bytes;
mod memory;

use crate::facts::{Fact, fact};
use crate::methods::runs::Contender;
use crate::methods::{self, Choice};
use crate::run::{Outcome, Runner, Simulation};
use crate::studies::scaling::facts::{
    Cell, FIXED_MATERIAL, FIXED_QUOTIENT, Facts, RunTiming, TimingRow,
};
use crate::studies::sheet::{GRAVITY, Sheet};
use crate::studies::variant::{is_explicit, or_defaults};
use crate::studies::{Context, Measured, Start, cells, prepared, timed};
use crate::{HarnessError, system_hash};
use drape_model::{DampingLaw, SystemSpec, TimeSpan};
use drape_report::Verdict;
use drape_report::number::median_s;
use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::Instant;

/// Particles along each edge, and number of steps.
const SIZES: [(u32, u64); 6] = [(10, 40), (20, 40), (52, 40), (100, 10), (316, 6), (1000, 3)];
/// A size that is timed but not counted: about a thousand particles.
const TIMED_ONLY: (u32, u64) = (32, 40);
/// Particles along each edge of the sheet whose material is kept.
const BASE: u32 = 20;
/// k/m of that sheet, 1/s².
const STIFFNESS: f64 = 1e4;
/// d/m of that sheet, 1/s.
const DAMPING: f64 = 10.0;
/// Amplitude of the wave with which the sheet starts, m. Without it the sheet starts in free fall,
/// and the solver has nothing to do.
const AMPLITUDE: f64 = 0.01;
/// Time step, s.
const STEP: f64 = 0.01;
/// From this number of particles along each edge on, a run is timed once. Its specification is not
/// hashed, since the text would be too long.
const LARGE: u32 = 100;
/// Largest number of particles along each edge in the quick subset.
const QUICK: u32 = 20;

/// Every method of the registry in its forms, or at its defaults.
fn contenders() -> impl Iterator<Item = Contender> {
    methods::runs().flat_map(|(method, runs)| or_defaults(method, runs.scaling, Contender::usual))
}

/// A sheet of one size in one series.
struct Mesh {
    series: &'static str,
    side: u32,
    steps: u64,
    sheet: Sheet,
    springs: usize,
    simulation: Simulation,
    hash: Option<String>,
}

fn sheet(series: &str, side: u32) -> Sheet {
    let is_material = series == FIXED_MATERIAL;
    let refinement = f64::from(side * side) / f64::from(BASE * BASE);
    let factor = if is_material { refinement } else { 1.0 };
    Sheet {
        side,
        tension: STIFFNESS * factor,
        shear: 0.25 * STIFFNESS * factor,
        damping: DAMPING * factor,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    }
}

/// The system of the sheet with a wave in and out of its plane.
fn waved(sheet: Sheet) -> Result<SystemSpec, HarnessError> {
    let mut spec = sheet.spec()?;
    for position in &mut spec.particles.position_m {
        let [x, y, _] = position.map(|a| 2.0 * std::f64::consts::PI * a);
        position[0] += AMPLITUDE * libm::sin(x) * libm::cos(y);
        position[1] += AMPLITUDE * libm::cos(x) * libm::sin(y);
        position[2] += AMPLITUDE * libm::sin(x + y);
    }
    Ok(spec)
}

fn name(series: &str, side: u32) -> String {
    format!("{series} n={}", side * side)
}

impl Mesh {
    fn new(series: &'static str, side: u32, steps: u64) -> Result<Self, HarnessError> {
        let sheet = sheet(series, side);
        let spec = waved(sheet)?;
        let hash = (side < LARGE).then(|| system_hash(&spec));
        let springs = spec.springs.len();
        let (system, state) = spec.build()?;
        let simulation = Simulation { system, state };
        Ok(Self { series, side, steps, sheet, springs, simulation, hash })
    }

    /// The step, s. For explicit methods it is divided by a power of two to stay within the limit.
    fn step(&self, choice: &Choice) -> f64 {
        if !is_explicit(choice.method()) {
            return STEP;
        }
        let (frequency, damping) = (self.sheet.greatest_frequency(1.0), 10.0 * self.sheet.damping);
        std::iter::successors(Some(STEP), |h| Some(0.5 * h))
            .find(|h| h * h * frequency * frequency + 2.0 * h * damping < 2.0)
            .unwrap_or(STEP)
    }

    fn run(&self, choice: &Choice, phases: bool) -> Result<Outcome, HarnessError> {
        let step_s = self.step(choice);
        let time = TimeSpan { step_s, duration_s: step_s * self.steps as f64 };
        Runner::new(choice, time).phases(phases).go(&mut self.simulation.clone())
    }

    fn cell(&self, contender: &Contender) -> Result<Cell, HarnessError> {
        let choice = Choice::parse(contender.method, &[])?;
        let Outcome { totals, steps, unconverged, divergence, .. } = self.run(&choice, false)?;
        Ok(Cell {
            series: self.series.to_owned(),
            side: self.side,
            particles: self.simulation.system.len(),
            springs: self.springs,
            stiffness_over_mass_per_s2: self.sheet.tension,
            damping_over_mass_per_s: self.sheet.damping,
            step_s: self.step(&choice),
            steps,
            label: contender.label.to_owned(),
            method: choice.full_id(),
            cg_per_step: totals.cg_iterations as f64 / steps as f64,
            matvecs: totals.matvecs,
            force_evaluations: totals.force_evaluations,
            newton_iterations: totals.newton_iterations,
            unconverged_steps: unconverged,
            verdict: if divergence.is_some() { Verdict::Diverged } else { Verdict::Completed },
            portable: choice.is_portable(),
        })
    }

    fn time(&self, contender: &Contender) -> Result<TimingRow, HarnessError> {
        let choice = Choice::parse(contender.method, &[])?;
        let repetitions = if self.side < LARGE { 3 } else { 1 };
        let mut samples_ns = Vec::new();
        for _ in 0..repetitions {
            samples_ns.push(self.run(&choice, false)?.wall.as_nanos() as u64);
        }
        let phased = self.run(&choice, true)?;
        let particles = self.simulation.system.len();
        let iterations = phased.totals.cg_iterations as f64 / phased.steps as f64;
        Ok(TimingRow::Run(RunTiming {
            series: self.series.to_owned(),
            particles,
            label: contender.label.to_owned(),
            steps: phased.steps,
            ns_per_particle_step: 1e9 * median_s(&samples_ns)
                / (particles as f64 * phased.steps as f64),
            samples_ns,
            least_bytes: bytes::least(contender.label, iterations),
            prepare_s: phased.totals.prepare_seconds,
            phases_s: phased.phases.unwrap_or_default(),
        }))
    }
}

/// Sizes of both series. The base size is in both.
fn sizes(quick: bool) -> Vec<(&'static str, u32, u64)> {
    let sizes = SIZES.into_iter().filter(|(side, _)| !quick || *side <= QUICK);
    sizes
        .flat_map(|(side, steps)| [FIXED_QUOTIENT, FIXED_MATERIAL].map(|s| (s, side, steps)))
        .collect()
}

/// The meshes with the methods that run on them.
fn pairs(meshes: &[Mesh]) -> Vec<(&Mesh, Contender)> {
    let fits = |mesh: &Mesh, contender: &Contender| mesh.side <= contender.largest;
    let of_mesh = move |mesh| contenders().filter(move |c| fits(mesh, c)).map(move |c| (mesh, c));
    meshes.iter().flat_map(of_mesh).collect()
}

/// How the timings are taken.
pub(super) fn timing() -> String {
    "One run at a time on one thread, with k/m fixed and the phase clock off: three repetitions \
     below 10⁴ particles, one from there on. One more run with the clock on gives the phases. The \
     time of a step excludes set-up. The bandwidth is that of the triad a = b + s·c over three \
     arrays of 64 MiB on one thread: the shortest of ten passes, with 24 bytes an element. The \
     least bytes of a step are counted kernel by kernel for a grid whose couplings need no \
     storage. Memory is what the allocator holds for system, state and prepared method, on the \
     same sheet with bending springs like its shear springs."
        .to_owned()
}

/// How the facts are measured.
pub(super) fn method() -> String {
    let (sides, steps): (Vec<_>, Vec<_>) =
        SIZES.iter().map(|(side, steps)| (side.to_string(), steps.to_string())).unzip();
    format!(
        "A sheet of 1 m × 1 m has tension springs, shear springs of a quarter of their stiffness \
         and two pinned corners. It starts with a wave of 0.01 m in and out of its plane, so that \
         springs pull everywhere, and falls. One series has k/m = {STIFFNESS:e}/s² and d/m = \
         {DAMPING}/s on every mesh, so a finer sheet is a softer cloth. The other series has the \
         same material on every mesh: k/m and d/m grow with the number of particles and equal the \
         first series at 20 × 20. The step is h = {STEP} s; explicit methods halve it until it is \
         within their limit. Sheets with sides of {} particles take {} steps from the start. \
         Every method runs, except on meshes on which a step takes seconds.",
        sides.join(", "),
        steps.join(", "),
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let start =
        |(series, side, _)| Start::new(name(series, side), move || waved(sheet(series, side)));
    let (side, steps) = TIMED_ONLY;
    let timed = (FIXED_QUOTIENT, side, steps);
    let bending = |side| {
        let name = format!("{}, bending springs", name(FIXED_QUOTIENT, side));
        Start::new(name, move || memory::system(&sheet(FIXED_QUOTIENT, side)))
    };
    let measured = memory::SIZES.into_iter().map(bending);
    sizes(false).into_iter().chain([timed]).map(start).chain(measured).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts, TimingRow>, HarnessError> {
    let sizes = sizes(context.quick);
    let meshes = prepared(context, "meshes", &sizes, |&(series, side, steps)| {
        Mesh::new(series, side, steps)
    })?;
    let pairs = pairs(&meshes);
    let cells =
        cells(context, "counts", &pairs, |(mesh, contender)| mesh.cell(contender))?.all()?;
    let facts = Facts { cells };
    let hashes: BTreeMap<_, _> = meshes
        .iter()
        .filter_map(|mesh| Some((name(mesh.series, mesh.side), mesh.hash.clone()?)))
        .collect();
    let mut timings = None;
    if !context.quick {
        // Times of one series suffice: a step of the other series differs only by its iterations.
        let (side, steps) = TIMED_ONLY;
        let between = [Mesh::new(FIXED_QUOTIENT, side, steps)?];
        let chosen: Vec<_> = self::pairs(&between)
            .into_iter()
            .chain(pairs.iter().copied().filter(|(mesh, _)| mesh.series == FIXED_QUOTIENT))
            .collect();
        let mut rows =
            timed(context, "timings", &chosen, |(mesh, contender)| mesh.time(contender))?.all()?;
        rows.extend(timed(context, "bandwidth", &[()], |()| Ok(triad()))?.all()?);
        if let Some(allocated) = context.allocated {
            let sheet = |side| Sheet { side, ..between[0].sheet };
            rows.extend(
                timed(context, "memory", &memory::SIZES, |&side| {
                    memory::measure(&sheet(side), allocated).map(TimingRow::Memory)
                })?
                .all()?,
            );
        }
        timings = Some(rows);
    }
    Ok(Measured { facts, timings, scenes: hashes, seed: None })
}

/// Passes of the triad over arrays that are much larger than the caches.
fn triad() -> TimingRow {
    const LENGTH: usize = 8 << 20;
    const PASSES: usize = 10;
    let (mut a, b, c) = (vec![0.0; LENGTH], vec![1.0; LENGTH], vec![2.0; LENGTH]);
    let mut samples_ns = Vec::new();
    for pass in 0..PASSES {
        let factor = black_box(pass as f64);
        let begin = Instant::now();
        for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
            *a = b + factor * c;
        }
        black_box(&mut a);
        samples_ns.push(begin.elapsed().as_nanos() as u64);
    }
    let bytes = (3 * LENGTH * size_of::<f64>()) as u64;
    let shortest = samples_ns.iter().min().map_or(1, |ns| (*ns).max(1));
    TimingRow::Triad { bytes, samples_ns, bytes_per_s: 1e9 * bytes as f64 / shortest as f64 }
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let cells = facts.cells.iter();
    cells
        .map(|cell| {
            let mut values = serde_json::to_value(cell).unwrap_or_default();
            // The sweeps of a line search depend on the machine, like Newton's iterations.
            if let Some(values) = values.as_object_mut().filter(|_| !cell.portable) {
                values.remove("force_evaluations");
            }
            let key = format!("{} n={} {}", cell.series, cell.particles, cell.label);
            fact(key, cell.portable, &values)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_series_meet_at_the_base_size_and_part_elsewhere() {
        let mesh = |series, side| Mesh::new(series, side, 1).expect("a valid sheet");
        let quotient = |series, side| mesh(series, side).sheet.tension;
        assert_eq!(quotient(FIXED_QUOTIENT, 20), quotient(FIXED_MATERIAL, 20));
        assert_eq!(quotient(FIXED_MATERIAL, 10), 0.25 * STIFFNESS);
        assert_eq!(quotient(FIXED_QUOTIENT, 10), STIFFNESS);
    }

    #[test]
    fn explicit_methods_take_a_step_within_their_limit_and_stay_finite() {
        let mesh = Mesh::new(FIXED_MATERIAL, 52, 40).expect("a valid sheet");
        for contender in contenders() {
            let choice = Choice::parse(contender.method, &[]).expect("a method");
            if !is_explicit(choice.method()) {
                continue;
            }
            assert!(mesh.step(&choice) * mesh.sheet.greatest_frequency(1.0) < 2.0);
            let cell = mesh.cell(&contender).expect("a run");
            let expected = (contender.label, 40, Verdict::Completed);
            assert_eq!((contender.label, cell.steps, cell.verdict), expected);
        }
    }

    #[test]
    fn the_quick_subset_has_small_meshes_and_a_dear_method_no_large_one() {
        let all = sizes(false);
        let quick = sizes(true);
        assert_eq!((all.len(), quick.len()), (12, 4));
        assert!(quick.iter().all(|size| size.1 <= QUICK && all.contains(size)));
        let meshes = [52, 100].map(|side| Mesh::new(FIXED_QUOTIENT, side, 1).expect("a sheet"));
        let dear = contenders().find(|contender| contender.largest == 52).expect("a dear method");
        let own = pairs(&meshes).into_iter().filter(|(_, contender)| contender.label == dear.label);
        assert_eq!(own.map(|(mesh, _)| mesh.side).collect::<Vec<_>>(), [52]);
    }
}
