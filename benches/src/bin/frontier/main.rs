//! How many substeps position-based methods need before they gain no energy.
//!
//! ```text
//! cargo run --release -p drape-benches --bin frontier
//! ```
//!
//! The [`HangingSheet`] without bending springs, as one fabric in coarse and fine meshes: stiffness
//! over mass grows with the square of the number of particles along an edge. At the end of each
//! frame of 10 ms the energy is compared with that of the start. The page has a table, the figure
//! beside it has a curve for each mesh.

use clap::Parser;
use drape_benches::{HangingSheet, Mesh, STEP_S, origin, provenance};
use drape_harness::methods::Choice;
use drape_harness::{Runner, STABLE, Simulation};
use drape_model::{SpringEffect, SystemSpec, TimeSpan, Violation};
use drape_report::file::write_atomically;
use drape_report::number::significant;
use drape_report::plot::{At, Axis, Draft, Drawing, Look, Point, Rule, Series, State, panels_of};
use drape_report::tell;
use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Finds how many substeps position-based methods need before they gain no energy.
#[derive(Debug, Parser)]
struct Cli {
    /// File for the table; the figure stands beside it, with the ending `svg`
    #[arg(long, default_value = "results/frontier.md")]
    out: PathBuf,
    /// Particles along an edge
    #[arg(long, value_delimiter = ',', default_value = "20,40,100", value_parser = clap::value_parser!(u32).range(4..=300))]
    sides: Vec<u32>,
    /// Substeps of a frame
    #[arg(long, value_delimiter = ',', default_value = "5,10,15,20,30,40,80,160", value_parser = clap::value_parser!(u32).range(1..))]
    substeps: Vec<u32>,
    /// Simulated time, s
    #[arg(long, default_value_t = 2.0)]
    seconds: f64,
}

/// The method of each curve, and the finest mesh on which it is run.
const METHODS: [(&str, u32); 2] = [("xpbd-lines", u32::MAX), ("xpbd", 20)];
/// Stiffness over mass of the tension springs on 20 × 20 particles, 1/s².
const STIFFNESSES: [f64; 2] = [1e8, 1e10];
/// Particles along an edge to which the stiffnesses belong.
const COARSE: u32 = 20;

/// A sheet, by its stiffness over mass at [`COARSE`] (1/s²) and whether it is damped.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cloth {
    stiffness: f64,
    is_damped: bool,
}

impl Cloth {
    fn all() -> impl Iterator<Item = Self> {
        let of = |stiffness| [true, false].map(|is_damped| Self { stiffness, is_damped });
        STIFFNESSES.into_iter().flat_map(of)
    }

    fn name(self) -> String {
        let damping = if self.is_damped { "damped" } else { "undamped" };
        format!("k/m = {:e} s⁻², {damping}", self.stiffness)
    }

    /// The sheet with `side × side` particles.
    fn spec(self, side: u32) -> Result<SystemSpec, Violation> {
        // Half as far apart, particles weigh a quarter, and springs have the same constants.
        let finer = (f64::from(side) / f64::from(COARSE)).powi(2);
        let mut spec = HangingSheet::new(side, finer * self.stiffness, Mesh::Grid)?.spec;
        spec.springs.retain(|spring| spring.effect != SpringEffect::Bending);
        for spring in &mut spec.springs {
            spring.damping_n_s_per_m *= if self.is_damped { finer } else { 0.0 };
        }
        Ok(spec)
    }
}

/// A run: greatest rise of the energy above its start, and the energy set free, J. Both are infinite
/// if the run diverged.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    substeps: u32,
    gain: f64,
    released: f64,
}

/// All runs of a method on a cloth with so many particles along an edge, coarsest first.
struct Curve {
    cloth: Cloth,
    method: &'static str,
    side: u32,
    runs: Vec<Run>,
}

impl Curve {
    fn new(
        cloth: Cloth,
        method: &'static str,
        side: u32,
        Cli { substeps, seconds, .. }: &Cli,
    ) -> Result<Self, Box<dyn Error>> {
        let (system, state) = cloth.spec(side)?.build()?;
        let simulation = Simulation { system, state };
        let time = TimeSpan { step_s: STEP_S, duration_s: *seconds };
        let mut runs = Vec::new();
        for &substeps in substeps {
            let choice = Choice::parse(method, &[format!("substeps={substeps}")])?;
            let energy = Runner::new(&choice, time).count(&simulation)?.energy;
            runs.push(Run { substeps, gain: energy.gain, released: energy.released });
        }
        Ok(Self { cloth, method, side, runs })
    }

    fn label(&self) -> String {
        format!("{}, {} × {}", self.method, self.side, self.side)
    }

    /// Energy that the sheet sets free, J, by the finest run.
    fn released(&self) -> f64 {
        self.runs.last().map_or(f64::INFINITY, |run| run.released)
    }
}

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell!("frontier: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(cli: &Cli) -> Result<(), Box<dyn Error>> {
    let mut curves = Vec::new();
    for cloth in Cloth::all() {
        for (method, finest) in METHODS {
            for &side in cli.sides.iter().filter(|side| **side <= finest) {
                let curve = Curve::new(cloth, method, side, cli)?;
                tell!("{}: {}", cloth.name(), curve.label());
                curves.push(curve);
            }
        }
    }
    let figure = cli.out.with_extension("svg");
    let name = figure.file_name().map_or_else(String::new, |name| name.to_string_lossy().into());
    let mut text = page(&curves, cli, &name);
    let _ = writeln!(text, "\n{}.", origin(&provenance()));
    draw(&curves, &figure)?;
    Ok(write_atomically(&cli.out, text.as_bytes())?)
}

const TITLE: &str = "How many substeps keep the energy of a stiff sheet";
const CAPTION: &str = "To the right of the place where a curve falls below the line, the method \
    keeps the energy. Upwards: greatest rise of the energy above its start, over the energy that \
    the sheet sets free. Across: substeps of a frame of 10 ms.";

/// Draws the curves, a panel for each cloth.
fn draw(curves: &[Curve], file: &Path) -> Result<(), Box<dyn Error>> {
    let labels: BTreeSet<String> = curves.iter().map(Curve::label).collect();
    let draft = |cloth: Cloth| -> Draft {
        let own = curves.iter().filter(|curve| curve.cloth == cloth);
        let series = own.filter_map(|curve| {
            let label = curve.label();
            let look = labels.iter().position(|other| *other == label).unwrap_or(0);
            let point = |run: &Run| Point {
                x: f64::from(run.substeps),
                y: run.gain / curve.released(),
                state: State::Stable,
            };
            let points = curve.runs.iter().filter(|run| run.gain.is_finite()).map(point);
            Series::path(label, Look::number(look), points.collect())
        });
        let stable = Rule { label: "stable".to_owned(), at: At::Y(STABLE) };
        (vec![cloth.name()], series.collect(), vec![stable])
    };
    let sheet = panels_of(
        Cloth::all().map(draft).collect(),
        |xs| Axis::log("substeps a frame", xs),
        |ys| {
            Axis::log_with_zero("energy gained (share of that set free)", &[ys, &[STABLE]].concat())
        },
    );
    let Some(sheet) = sheet else { return Ok(()) };
    Ok(write_atomically(file, sheet.svg(TITLE, CAPTION)?.as_bytes())?)
}

fn page(curves: &[Curve], cli: &Cli, figure: &str) -> String {
    let mut text = format!(
        "# {TITLE}\n\n![The energy gained against the number of substeps]({figure})\n\n\
         *{CAPTION}*\n\n\
         The hanging sheet with tension and shear springs, {} s, frames of 10 ms. k/m is that of \
         {COARSE} × {COARSE} particles; finer meshes are the same fabric, so their k/m grows with the \
         square of the number along an edge. Damped: d/m = 40 s⁻¹ at {COARSE} × {COARSE}. The table \
         has the greatest rise of the energy above its start, J; a run is stable up to {} % of the \
         energy that the sheet sets free by the finest run. A substep of `xpbd-lines` counts as three \
         evaluations of the forces. `cargo run --release -p drape-benches --bin frontier` makes this \
         page.\n\n\
         | cloth | method | set free, J |",
        cli.seconds,
        100.0 * STABLE
    );
    for substeps in &cli.substeps {
        let _ = write!(text, " {substeps} |");
    }
    text += " stable from |\n|---|---|---|";
    text += &"---|".repeat(cli.substeps.len() + 1);
    text += "\n";
    for curve in curves {
        let released = curve.released();
        let _ = write!(
            text,
            "| {} | {} | {} |",
            curve.cloth.name(),
            curve.label(),
            significant(released, 3)
        );
        for run in &curve.runs {
            let gain = match run.gain {
                gain if !gain.is_finite() => "diverged".to_owned(),
                gain if gain <= 0.0 => "none".to_owned(),
                gain => significant(gain, 2),
            };
            let _ = write!(text, " {gain} |");
        }
        // All finer runs must be stable, too.
        let stable = |run: &&Run| run.gain <= STABLE * released;
        let first = curve.runs.iter().rev().take_while(stable).last();
        let first = first.map_or_else(|| "never".to_owned(), |run| run.substeps.to_string());
        let _ = writeln!(text, " {first} |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finer_sheet_is_the_same_fabric() {
        let cloth = Cloth { stiffness: 1e8, is_damped: true };
        let [coarse, fine] = [20, 40].map(|side| cloth.spec(side).expect("a sheet"));
        let of = |spec: &SystemSpec| {
            let spring = &spec.springs[0];
            (spring.stiffness_n_per_m, spring.damping_n_s_per_m)
        };
        let (coarse, fine) = (of(&coarse), of(&fine));
        assert!((fine.0 / coarse.0 - 1.0).abs() < 1e-9, "{coarse:?} {fine:?}");
        assert!((fine.1 / coarse.1 - 1.0).abs() < 1e-9, "{coarse:?} {fine:?}");
        let bare = Cloth { is_damped: false, ..cloth }.spec(20).expect("a sheet");
        assert!(bare.springs.iter().all(|spring| spring.damping_n_s_per_m == 0.0));
        assert!(bare.springs.iter().all(|spring| spring.effect != SpringEffect::Bending));
    }

    #[test]
    fn more_substeps_gain_less_and_the_page_says_from_where_a_run_is_stable() {
        let out = PathBuf::from("frontier.md");
        let cli = Cli { out, sides: vec![8], substeps: vec![1, 40], seconds: 0.5 };
        let cloth = Cloth { stiffness: 1e8, is_damped: true };
        let curve = Curve::new(cloth, "xpbd-lines", 8, &cli).expect("runs");
        assert!(curve.runs[1].gain < 0.1 * curve.runs[0].gain, "{:?}", curve.runs);
        let run = |substeps, gain| Run { substeps, gain, released: 2.0 };
        let runs = vec![run(1, 0.01), run(2, f64::INFINITY), run(5, 0.04), run(9, 0.0)];
        let curves = [Curve { cloth, method: "xpbd", side: 8, runs }];
        let cli = Cli { substeps: vec![1, 2, 5, 9], ..cli };
        let text = page(&curves, &cli, "frontier.svg");
        let cells = "2.00 | 0.010 | diverged | 0.040 | none | 5 |";
        let line = format!("| k/m = 1e8 s⁻², damped | xpbd, 8 × 8 | {cells}");
        assert!(text.contains(&line), "{text}");
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("frontier.svg");
        draw(&curves, &file).expect("a figure");
        let svg = std::fs::read_to_string(file).expect("a file");
        assert!(svg.contains("xpbd, 8 × 8") && svg.contains("substeps a frame"), "{svg}");
    }
}
