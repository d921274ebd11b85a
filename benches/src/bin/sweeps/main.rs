//! Times a sweep of XPBD and one of a public program on the same springs.
//!
//! ```text
//! taskset -c 1 cargo run --release -p drape-benches --bin sweeps -- --python python3
//! ```
//!
//! The public program is `SolverXPBD` of the physics engine Newton, which `programs/newton_xpbd.py`
//! times. Both move the [`HangingSheet`] with damping along the springs, where both have the same
//! formulas, except by lines; `drape_oracle::published` shows that. The time of a *sweep* is a
//! hundredth of the difference between a step of 101 sweeps and a step of one. So it contains neither
//! the prediction nor the start of a program. Beside them stands a sweep over the same springs that
//! adds up their forces: on the grid, there also with full damping, which takes less time, and on
//! the same springs in random order, where nothing shows the grid.
//!
//! The programs take turns. A ratio divides two times of the same round, so both sides see the same
//! machine. Each program uses one thread; `taskset` keeps both on one core.

mod program;

use clap::Parser;
use drape_benches::{HangingSheet, Mesh, STEP_S, origin, provenance};
use drape_harness::methods::Choice;
use drape_integrator::{PhaseClock, TimeStep};
use drape_model::{DampingLaw, SystemSpec, Vec3, Violation};
use drape_report::file::write_atomically;
use drape_report::tell;
use program::Newton;
use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Times sweeps of XPBD and those of the physics engine Newton in turns.
#[derive(Debug, Parser)]
struct Cli {
    /// Python interpreter with the packages newton and warp-lang
    #[arg(long, default_value = "python3")]
    python: PathBuf,
    /// File for the table
    #[arg(long, default_value = "results/sweeps.md")]
    out: PathBuf,
    /// Particles along an edge
    #[arg(long, value_delimiter = ',', default_value = "20,52,100", value_parser = clap::value_parser!(u32).range(4..=300))]
    sides: Vec<u32>,
    /// Turns of each program
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
}

/// Stiffness over mass of the tension springs, 1/s².
const STIFFNESS: f64 = 1e4;
/// Sweeps of a short and of a long step.
const SWEEPS: [u32; 2] = [1, 101];
/// Steps of each that are timed in a turn.
const STEPS: usize = 11;
/// The forms of XPBD beside the public program.
const FORMS: [(&str, &str); 3] = [
    ("as listed", "xpbd:substeps=1"),
    ("by colours", "xpbd:substeps=1,sweep=coloured"),
    ("by lines", LINES),
];
const LINES: &str = "xpbd-lines:substeps=1";
/// The sweeps for forces beside those by lines: name, mesh and damping.
const SUMS: [(&str, Mesh, DampingLaw); 3] = [
    ("forces on the grid", Mesh::Grid, DampingLaw::Projected),
    ("the same with full damping", Mesh::Grid, DampingLaw::Full),
    ("forces in random order", Mesh::General, DampingLaw::Projected),
];
/// Sweeps for forces that are timed together.
const FORCES: u32 = 100;

/// A warning for a build without optimisation.
const CHECKED: &str =
    if cfg!(debug_assertions) { " This time without `--release`: drape is slower so." } else { "" };

/// Times of a sweep, µs, round by round.
struct Times {
    side: u32,
    springs: usize,
    /// Of the public program.
    newton: Vec<f64>,
    /// Of each form.
    forms: [Vec<f64>; FORMS.len()],
    /// Of each sum of forces.
    forces: [Vec<f64>; SUMS.len()],
    /// Of the sweep by lines with full damping.
    full: Vec<f64>,
}

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell!("sweeps: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(cli: &Cli) -> Result<(), Box<dyn Error>> {
    let provenance = provenance();
    let mut all = Vec::new();
    let mut package = String::new();
    for &side in &cli.sides {
        let spec = sheet(side, Mesh::Grid, DampingLaw::Projected)?;
        let others = SUMS.map(|(_, mesh, damping)| sheet(side, mesh, damping));
        let others = others.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut newton = Newton::start(&cli.python, &spec, STEP_S)?;
        let (forms, forces) = Default::default();
        let springs = spec.springs.len();
        let mut times =
            Times { side, springs, newton: Vec::new(), forms, forces, full: Vec::new() };
        let full = sheet(side, Mesh::Grid, DampingLaw::Full)?;
        for _ in 0..cli.rounds {
            times.newton.push(a_sweep(|sweeps| Ok(newton.time(sweeps, STEPS)?))?);
            for (times, (_, method)) in times.forms.iter_mut().zip(FORMS) {
                times.push(a_sweep(|sweeps| time(&spec, method, sweeps))?);
            }
            for (times, spec) in times.forces.iter_mut().zip(&others) {
                times.push(sum_of_forces(spec)?);
            }
            times.full.push(a_sweep(|sweeps| time(&full, LINES, sweeps))?);
        }
        package = newton.package.clone();
        all.push(times);
    }
    let mut text = table(&all, &package, &provenance.cpu, cli.rounds);
    let _ = writeln!(text, "\n{}.", origin(&provenance));
    write_atomically(&cli.out, text.as_bytes())?;
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// The sheet on a mesh, with this damping.
fn sheet(side: u32, mesh: Mesh, damping: DampingLaw) -> Result<SystemSpec, Violation> {
    Ok(SystemSpec { damping, ..HangingSheet::new(side, STIFFNESS, mesh)?.spec })
}

/// What one sweep takes, µs, by what steps of few and of many take.
fn a_sweep(
    mut step: impl FnMut(u32) -> Result<f64, Box<dyn Error>>,
) -> Result<f64, Box<dyn Error>> {
    let [few, many] = SWEEPS;
    Ok((step(many)? - step(few)?) / f64::from(many - few))
}

/// Median time of a step of so many sweeps from the start, µs.
fn time(spec: &SystemSpec, method: &str, sweeps: u32) -> Result<f64, Box<dyn Error>> {
    let (system, mut state) = spec.build()?;
    let h = TimeStep::new(STEP_S)?;
    let mut integrator = Choice::parse(method, &[format!("iterations={sweeps}")])?.build()?;
    integrator.prepare(&system, h)?;
    let mut clock = PhaseClock::off();
    let mut times = Vec::with_capacity(STEPS);
    for _ in 0..STEPS {
        let begin = Instant::now();
        integrator.step(&system, &mut state, h, &mut clock)?;
        times.push(1e6 * begin.elapsed().as_secs_f64());
    }
    Ok(middle(times))
}

/// Median time of a sweep for the forces of all springs, µs.
fn sum_of_forces(spec: &SystemSpec) -> Result<f64, Box<dyn Error>> {
    let (system, state) = spec.build()?;
    let mut out = vec![Vec3::zeros(); state.x.len()];
    let mut times = Vec::with_capacity(STEPS);
    for _ in 0..STEPS {
        let begin = Instant::now();
        for _ in 0..FORCES {
            system.forces(black_box(state.level()), &mut out);
            black_box(&mut out);
        }
        times.push(1e6 * begin.elapsed().as_secs_f64() / f64::from(FORCES));
    }
    Ok(middle(times))
}

/// Median, least and greatest of the ratios of two series.
fn ratios(above: &[f64], below: &[f64]) -> [f64; 3] {
    let mut ratios: Vec<_> = above.iter().zip(below).map(|(a, b)| a / b).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    [ratios[ratios.len() / 2], ratios[0], ratios[ratios.len() - 1]]
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

fn table(all: &[Times], package: &str, cpu: &str, rounds: u32) -> String {
    let mut text = format!(
        "# A sweep of XPBD beside that of a public program\n\n\
         The hanging sheet, N × N particles row by row, with tension, shear and bending springs, k/m = 1e4/s², damping along \
         the springs. `SolverXPBD` of {package} adds up the corrections of all springs, in single precision; drape takes the \
         springs one after the other, or a line of them at once (*by lines*, which solves other equations), in \
         double precision. Time of one sweep, µs, and the public program's time over that of \
         drape: median of {rounds} rounds, in brackets the least and the greatest. {cpu}, one thread. \
         `taskset -c 1 cargo run --release -p drape-benches --bin sweeps -- --python PYTHON` makes this page.{CHECKED}\n\n\
         | N | springs | public program, µs |"
    );
    for (name, _) in FORMS {
        let _ = write!(text, " drape, {name}, µs | times as fast |");
    }
    text += "\n|---|---|---|---|---|---|---|---|---|\n";
    for Times { side, springs, newton, forms, .. } in all {
        let _ = write!(text, "| {side} | {springs} | {:.1} |", middle(newton.clone()));
        for form in forms {
            let [ratio, least, most] = ratios(newton, form);
            let us = middle(form.clone());
            let _ = write!(text, " {us:.1} | {ratio:.2} ({least:.2}–{most:.2}) |");
        }
        text += "\n";
    }
    text += "\nA sweep by lines beside one that adds up the forces of the same springs:\n\n\
             | N | by lines, µs |";
    for (name, ..) in SUMS {
        let _ = write!(text, " {name}, µs | by lines over this |");
    }
    text += " by lines with full damping, µs | over forces with full damping |";
    text += "\n|---|---|---|---|---|---|---|---|---|---|\n";
    for Times { side, forms, forces, full, .. } in all {
        let [.., lines] = forms;
        let _ = write!(text, "| {side} | {:.1} |", middle(lines.clone()));
        for sweep in forces {
            let [ratio, least, most] = ratios(lines, sweep);
            let us = middle(sweep.clone());
            let _ = write!(text, " {us:.1} | {ratio:.2} ({least:.2}–{most:.2}) |");
        }
        let [_, forces, _] = forces;
        let ([ratio, least, most], us) = (ratios(full, forces), middle(full.clone()));
        let _ = writeln!(text, " {us:.1} | {ratio:.2} ({least:.2}–{most:.2}) |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_is_what_more_sweeps_take_more() {
        let found = a_sweep(|sweeps| Ok(7.0 + 3.0 * f64::from(sweeps))).expect("times");
        assert!((found - 3.0).abs() < 1e-12, "{found}");
        let spec = sheet(8, Mesh::Grid, DampingLaw::Projected).expect("a sheet");
        assert!(sum_of_forces(&spec).expect("forces") > 0.0);
        for (_, method) in FORMS {
            assert!(time(&spec, method, 3).expect("a run") > 0.0);
        }
    }

    #[test]
    fn the_table_has_the_ratios_of_each_round() {
        let times = Times {
            side: 4,
            springs: 10,
            newton: vec![4.0, 9.0, 6.0],
            forms: [vec![2.0, 3.0, 1.0], vec![1.0; 3], vec![2.0; 3]],
            forces: [vec![1.0, 4.0, 2.0], vec![8.0; 3], vec![4.0; 3]],
            full: vec![16.0; 3],
        };
        let text = table(&[times], "newton", "cpu", 3);
        assert!(text.contains("| 4 | 10 | 6.0 | 2.0 | 3.00 (2.00–6.00) | 1.0 |"), "{text}");
        let line = "| 4 | 2.0 | 2.0 | 1.00 (0.50–2.00) | 8.0 | 0.25 (0.25–0.25) | 4.0 |";
        assert!(text.contains(line), "{text}");
        assert!(text.ends_with(" 16.0 | 2.00 (2.00–2.00) |\n"), "{text}");
    }
}
