//! The public program as a process that answers over two pipes.

use drape_model::SystemSpec;
use serde_json::json;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The reason why the program gave no time.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ProgramError {
    /// It did not start.
    #[error("`{}` cannot be started: {source}; name a Python with --python", path.display())]
    Start { path: PathBuf, source: std::io::Error },
    /// A pipe broke.
    #[error("the public program ended early: {0}; does this Python have newton and warp-lang?")]
    Pipe(#[from] std::io::Error),
    /// Its answer is no time.
    #[error(
        "the public program: expected a time in µs, found `{0}`; does this Python have newton and warp-lang?"
    )]
    Answer(String),
}

/// Where the program is.
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/programs/newton_xpbd.py");

/// The running program with a sheet.
pub(crate) struct Newton {
    /// Its name and version.
    pub(crate) package: String,
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Newton {
    /// Starts it with a sheet.
    pub(crate) fn start(python: &Path, spec: &SystemSpec, step: f64) -> Result<Self, ProgramError> {
        let mut command = Command::new(python);
        command.arg(SCRIPT).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let start = |source| ProgramError::Start { path: python.to_owned(), source };
        let mut child = command.spawn().map_err(start)?;
        let missing = || std::io::Error::other("a pipe is missing");
        let to = child.stdin.take().ok_or_else(missing)?;
        let from = BufReader::new(child.stdout.take().ok_or_else(missing)?);
        let mut newton = Self { package: String::new(), child, to, from };
        newton.package = newton.ask(&sheet(spec, step))?;
        if newton.package.is_empty() {
            return Err(ProgramError::Answer(String::new()));
        }
        Ok(newton)
    }

    /// Median time of steps of so many sweeps from the start, µs.
    pub(crate) fn time(&mut self, sweeps: u32, steps: usize) -> Result<f64, ProgramError> {
        let answer = self.ask(&format!("{sweeps} {steps}"))?;
        let time = answer.parse::<f64>().ok().filter(|time| time.is_finite() && *time > 0.0);
        time.ok_or(ProgramError::Answer(answer))
    }

    fn ask(&mut self, line: &str) -> Result<String, ProgramError> {
        writeln!(self.to, "{line}")?;
        self.to.flush()?;
        let mut answer = String::new();
        self.from.read_line(&mut answer)?;
        Ok(answer.trim().to_owned())
    }
}

impl Drop for Newton {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The sheet as the program reads it. Pinned particles have the mass 0.
fn sheet(spec: &SystemSpec, step: f64) -> String {
    let mut mass = spec.particles.mass_kg.clone();
    for pin in &spec.pins {
        mass[pin.particle as usize] = 0.0;
    }
    let of = |value: fn(&drape_model::SpringSpec) -> f64| -> Vec<f64> {
        spec.springs.iter().map(value).collect()
    };
    json!({
        "step_s": step,
        "mass_kg": mass,
        "position_m": spec.particles.position_m,
        "springs": spec.springs.iter().map(|s| [s.i, s.j]).collect::<Vec<_>>(),
        "rest_length_m": of(|s| s.rest_length_m),
        "stiffness": of(|s| s.stiffness_n_per_m),
        "damping": of(|s| s.damping_n_s_per_m),
    })
    .to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_benches::{HangingSheet, Mesh, STEP_S};

    #[test]
    fn the_sheet_has_all_springs_and_its_pins_no_mass() {
        let spec = HangingSheet::new(4, 1e4, Mesh::Grid).expect("a sheet").spec;
        let text = sheet(&spec, STEP_S);
        let read: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let length = |key: &str| read[key].as_array().map(Vec::len);
        for key in ["springs", "rest_length_m", "stiffness", "damping"] {
            assert_eq!(length(key), Some(spec.springs.len()), "{key}");
        }
        let masses = read["mass_kg"].as_array().expect("masses");
        let still = masses.iter().filter(|mass| mass.as_f64() == Some(0.0)).count();
        assert_eq!((masses.len(), still), (16, 2));
    }

    #[test]
    fn a_program_that_is_none_is_named_with_what_to_do() {
        let spec = HangingSheet::new(4, 1e4, Mesh::Grid).expect("a sheet").spec;
        let refused = |python: &str| {
            let started = Newton::start(Path::new(python), &spec, STEP_S);
            started.err().expect("refused").to_string()
        };
        assert!(refused("/no/such/python").contains("--python"));
        // It answers nothing at all.
        assert!(refused("true").contains("newton and warp-lang"));
    }
}
