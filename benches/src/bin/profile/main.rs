//! The time of each method's step by phase, beside the least time that the machine allows.
//!
//! ```text
//! cargo run --release -p drape-benches --bin profile
//! ```
//!
//! Every method takes steps of the hanging sheet of [`HangingSheet`], 52 × 52 and 100 × 100
//! particles row by row, k/m = 1e4/s², with its default settings, on one thread; so do [`FORMS`].
//! The table lists the median time of a step, whole and by springs, the share of each [`Phase`] in
//! another run, the counts of a step, and its *bound*. The bound is the least time of the
//! [kernels](bound) that the step counts. It follows from the speeds of this processor's arithmetic
//! and caches, which the program measures first. Methods that are more than twice above their bound
//! have a reason beside them. A last table compares the time of one hinge, one angle and one
//! triangle in the air with that of a spring.

mod bound;
mod elements;
mod table;

use clap::Parser;
use drape_benches::{HangingSheet, Machine, Mesh, STEP_S, origin, provenance};
use drape_harness::methods::{self, Choice};
use drape_integrator::{Integrator, Phase, PhaseClock, StepReport, TimeStep};
use drape_model::{State, System};
use drape_report::file::write_atomically;
use drape_report::number::median;
use drape_report::tell;
use std::error::Error;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Profiles the step of every method and compares it with the least time of its kernels.
#[derive(Debug, Parser)]
struct Cli {
    /// File for the table
    #[arg(long, default_value = "results/profile.md")]
    out: PathBuf,
    /// Particles along an edge
    #[arg(long, value_delimiter = ',', default_value = "52,100")]
    sides: Vec<u32>,
    /// Particles along an edge of the large sheet, on which two methods run at k/m = 1e6/s²
    #[arg(long, default_value_t = 316)]
    large: u32,
    /// Least time that a method is stepped, s
    #[arg(long, default_value_t = 0.3)]
    seconds: f64,
    /// Turns of all methods; the least of their medians counts
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
}

/// k/m of the tension springs, 1/s².
const STIFFNESS: f64 = 1e4;
/// Step of methods that are explicit in all springs, s.
const EXPLICIT_STEP_S: f64 = 1e-3;
/// Settings with other kernels than the default, shown below the method.
const FORMS: [&str; 1] = ["leapfrog:damping=explicit"];
/// A linearised step, and ways to solve the linear systems of a converged one.
const CONVERGED: [&str; 11] = [
    "baraff-witkin",
    "backward-euler:solver=cholesky",
    "backward-euler:jacobian=saved",
    "backward-euler:solver=cg,forcing=eisenstat-walker",
    "backward-euler:jacobian=saved,solver=cg,forcing=eisenstat-walker",
    "backward-euler:solver=multigrid,forcing=eisenstat-walker",
    "backward-euler",
    "bdf2",
    "midpoint",
    "generalized-alpha",
    "dirk",
];
/// Stiffnesses over mass of those, 1/s².
const CONVERGED_STIFFNESS: [f64; 3] = [1e4, 1e6, 1e8];
/// On the large sheet.
const LARGE: [&str; 2] = ["baraff-witkin", "backward-euler"];
/// Its stiffness over mass, 1/s².
const LARGE_STIFFNESS: f64 = 1e6;
/// Steps before any is timed.
const WARM_UP: u32 = 5;

/// What steps of one method took and counted, a step.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    method: &'static str,
    side: u32,
    stiffness: f64,
    springs: usize,
    /// Median, s.
    step: f64,
    /// Shares of the phases, in the order of [`PHASES`].
    shares: [f64; 5],
    counts: Counts,
}

/// Means over the steps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    force_evaluations: f64,
    products: f64,
    iterations: f64,
    newton: f64,
    factorisations: f64,
    setups: f64,
}

/// The phases, in the order of the table.
const PHASES: [Phase; 5] =
    [Phase::Forces, Phase::MatrixSetup, Phase::Solve, Phase::Contact, Phase::Update];

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell!("profile: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(cli: &Cli) -> Result<(), Box<dyn Error>> {
    let provenance = provenance();
    let profiles = rounds(cli, &rows(), STIFFNESS)?;
    let mut converged = Vec::new();
    for stiffness in CONVERGED_STIFFNESS {
        converged.extend(rounds(cli, &CONVERGED, stiffness)?);
    }
    let elements = elements::measure(&cli.sides)?;
    for id in LARGE {
        converged.push(profile(id, cli.large, LARGE_STIFFNESS, cli.seconds)?);
    }
    let mut text = table::text(&Machine::measure(), &profiles, &provenance.cpu);
    text += &table::converged(&converged, peak_memory());
    text += &elements::text(&elements);
    text += &format!("\n{}.\n", origin(&provenance));
    write_atomically(&cli.out, text.as_bytes())?;
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// The rows of the first table: all methods, with [`FORMS`] below their own.
fn rows() -> Vec<&'static str> {
    let of = |id: &'static str| {
        let own = move |form: &&str| form.split(':').next() == Some(id);
        std::iter::once(id).chain(FORMS.into_iter().filter(own))
    };
    methods::all().flat_map(|method| of(method.id)).collect()
}

/// Each method on each sheet, in turns: what else the machine does is in some rounds only.
fn rounds(
    cli: &Cli,
    ids: &[&'static str],
    stiffness_over_mass: f64,
) -> Result<Vec<Profile>, Box<dyn Error>> {
    let mut best: Vec<Profile> = Vec::new();
    for round in 0..cli.rounds {
        let places = cli.sides.iter().flat_map(|side| ids.iter().map(move |id| (*id, *side)));
        for (place, (id, side)) in places.enumerate() {
            let profile = profile(id, side, stiffness_over_mass, cli.seconds)?;
            if round == 0 {
                best.push(profile);
            } else if profile.step < best[place].step {
                best[place] = profile;
            }
        }
    }
    Ok(best)
}

/// The most memory that this process has held, MiB; `None` where the system does not tell.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kib / 1024)
}

fn profile(
    id: &'static str,
    side: u32,
    stiffness_over_mass: f64,
    seconds: f64,
) -> Result<Profile, Box<dyn Error>> {
    let spec = HangingSheet::new(side, stiffness_over_mass, Mesh::Grid)?.spec;
    let springs = spec.springs.len();
    let (system, start) = spec.build()?;
    let choice = Choice::parse(id, &[])?;
    let h = TimeStep::new(if bound::is_explicit(id) { EXPLICIT_STEP_S } else { STEP_S })?;
    let run = |clock: &mut PhaseClock| -> Result<(Vec<f64>, Counts), Box<dyn Error>> {
        let mut integrator = choice.build()?;
        integrator.prepare(&system, h)?;
        steps(integrator.as_mut(), &system, start.clone(), h, clock, seconds)
    };
    let (times, counts) = run(&mut PhaseClock::off())?;
    let mut clock = PhaseClock::on();
    run(&mut clock)?;
    let phases = PHASES.map(|phase| clock.seconds(phase));
    let total: f64 = phases.iter().sum();
    Ok(Profile {
        method: id,
        side,
        stiffness: stiffness_over_mass,
        springs,
        step: median(times).unwrap_or(f64::NAN),
        shares: phases.map(|phase| phase / total),
        counts,
    })
}

/// Times of steps until they are enough, at least ten, and what they counted.
fn steps(
    integrator: &mut dyn Integrator,
    system: &System,
    mut state: State,
    h: TimeStep,
    clock: &mut PhaseClock,
    seconds: f64,
) -> Result<(Vec<f64>, Counts), Box<dyn Error>> {
    let mut off = PhaseClock::off();
    for _ in 0..WARM_UP {
        integrator.step(system, &mut state, h, &mut off)?;
    }
    let (mut times, mut total) = (Vec::new(), Counts::default());
    // A hundred steps are long before any method's sheet has fallen to where it is in another
    // regime.
    while times.len() < 10 || (times.len() < 100 && times.iter().sum::<f64>() < seconds) {
        let begin = Instant::now();
        let report = integrator.step(system, &mut state, h, clock)?;
        times.push(begin.elapsed().as_secs_f64());
        total.add(&report);
    }
    let count = times.len() as f64;
    Ok((times, total.over(count)))
}

impl Counts {
    fn add(&mut self, report: &StepReport) {
        self.force_evaluations += f64::from(report.force_evaluations);
        self.products += f64::from(report.matvecs);
        self.iterations += f64::from(report.cg_iterations);
        self.newton += f64::from(report.newton_iterations);
        self.factorisations += f64::from(report.factorisations);
        self.setups += f64::from(report.setups.total());
    }

    fn over(self, steps: f64) -> Self {
        Self {
            force_evaluations: self.force_evaluations / steps,
            products: self.products / steps,
            iterations: self.iterations / steps,
            newton: self.newton / steps,
            factorisations: self.factorisations / steps,
            setups: self.setups / steps,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_a_profile_and_a_bound_below_it() {
        // As fast as no processor is: bounds are below any measurement, debug builds' too.
        let machine = Machine { root_and_quotient_s: 1e-11, flops_per_s: 1e13, bytes_per_s: 1e13 };
        let rows = rows();
        assert!(FORMS.iter().all(|form| rows.contains(form)), "{rows:?}");
        for id in rows {
            let profile = profile(id, 8, STIFFNESS, 0.0).expect("a run");
            let bound = bound::seconds(&machine, &profile);
            assert!(0.0 < bound && bound < profile.step, "{profile:?} {bound}");
            assert!(bound::reason(id).is_some(), "{id}: no reason is written");
            let sum: f64 = profile.shares.iter().sum();
            assert!((sum - 1.0).abs() < 1e-9 && profile.step > 0.0, "{profile:?}");
        }
    }
}
