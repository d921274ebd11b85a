//! Time series of a run: `--probe` and `--probe-out`.

use super::refusal;
use crate::cli::output::{Sink, csv_line, is_stream};
use drape_harness::record::Sample;
use drape_harness::{Moment, OrderedSimulation, boundaries, groups};
use drape_model::{State, SystemSpec, Vec3, Violation};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct ProbeArguments {
    /// Quantity to record over time; may be repeated. One of: the index of a particle; pins (their
    /// mean); group:N or boundary:N (the mean of a connected group or of a part of the boundary,
    /// numbered as by drape inspect); stretch (greatest and mean strain of the springs); lowest
    /// (the lowest particle); energy
    #[arg(long = "probe", value_name = "WHAT")]
    probes: Vec<String>,
    /// Write the recorded quantities into this file: .csv or .json (format "drape-probe/1"), with
    /// at most 1000 times after the start
    #[arg(long, value_name = "FILE")]
    probe_out: Option<PathBuf>,
}

/// Most times after the start.
const MOST_TIMES: u64 = 1000;

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    Csv,
    Json,
}

impl Form {
    /// The form that the extension of a file names. JSON where it is a pipe.
    pub(crate) fn of(key: &str, file: &Path) -> Result<Self, Violation> {
        let extension = file.extension().unwrap_or_default().to_ascii_lowercase();
        match extension.to_str() {
            Some("csv") => Ok(Self::Csv),
            Some("json") => Ok(Self::Json),
            _ if is_stream(file) => Ok(Self::Json),
            _ => {
                let value = format_args!("`{}`", file.display());
                Err(refusal(key, value, "a name that ends in .csv or .json"))
            }
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Probe {
    Particle(usize),
    /// The mean of some particles, at least one, under this name.
    Mean(String, Vec<u32>),
    Stretch,
    Lowest,
    Energy,
}

fn refuse(path: &str, value: &str, expected: String) -> Violation {
    refusal(path, format_args!("`{value}`"), expected)
}

impl Probe {
    fn parse(text: &str, spec: &SystemSpec) -> Result<Self, Violation> {
        let lacks = |what: &str| {
            let expected = format!("something else: the scene has no {what}");
            Err(refuse("--probe", text, expected))
        };
        match text {
            "pins" if spec.pins.is_empty() => return lacks("pins"),
            "stretch" if spec.springs.is_empty() => return lacks("springs"),
            "pins" => {
                let pins = spec.pins.iter().map(|pin| pin.particle);
                return Ok(Self::Mean("pins".to_owned(), pins.collect()));
            }
            "stretch" => return Ok(Self::Stretch),
            "lowest" => return Ok(Self::Lowest),
            "energy" => return Ok(Self::Energy),
            _ => {}
        }
        if let Some(number) = text.strip_prefix("group:") {
            return Self::part("group", number, group_members(spec))
                .map_err(|expected| refuse("--probe", text, expected));
        }
        if let Some(number) = text.strip_prefix("boundary:") {
            let parts = boundaries(&spec.triangles);
            if parts.is_empty() {
                return lacks("boundaries");
            }
            return Self::part("boundary", number, parts)
                .map_err(|expected| refuse("--probe", text, expected));
        }
        let n = spec.particles.mass_kg.len();
        text.parse::<usize>().ok().filter(|index| *index < n).map(Self::Particle).ok_or_else(|| {
            let expected = format!(
                "pins, stretch, lowest, energy, group:N, boundary:N or a particle from 0 to {}",
                n - 1
            );
            refuse("--probe", text, expected)
        })
    }

    /// One of the groups or boundaries of a scene; else what is expected in its place.
    fn part(kind: &str, number: &str, mut parts: Vec<Vec<u32>>) -> Result<Self, String> {
        match number.parse::<usize>() {
            Ok(number) if number < parts.len() => {
                Ok(Self::Mean(format!("{kind}_{number}"), parts.swap_remove(number)))
            }
            _ => Err(format!(
                "{kind}:N with N from 0 to {}: of this kind the scene has {}",
                parts.len() - 1,
                parts.len()
            )),
        }
    }
}

/// The particles of each connected group.
fn group_members(spec: &SystemSpec) -> Vec<Vec<u32>> {
    let mut members: Vec<Vec<u32>> = Vec::new();
    // Groups are numbered by their first particles, so a new number is the next one.
    for (particle, group) in (0..).zip(groups(spec)) {
        if group == members.len() {
            members.push(Vec::new());
        }
        members[group].push(particle);
    }
    members
}

/// Follows a run.
pub(crate) struct Probes<'a> {
    spec: &'a SystemSpec,
    probes: Vec<Probe>,
    sink: Sink,
    form: Form,
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
    every: u64,
    steps: u64,
}

impl<'a> Probes<'a> {
    /// Checks the options and takes the start. `None` if the user follows nothing. `inputs` are the
    /// files of the scene, `record` is where the record goes.
    pub(crate) fn begin(
        arguments: &ProbeArguments,
        spec: &'a SystemSpec,
        simulation: &OrderedSimulation,
        steps: u64,
        (inputs, record): (&[PathBuf], Option<&Sink>),
    ) -> Result<Option<Self>, Violation> {
        let file = match (arguments.probes.first(), &arguments.probe_out) {
            (None, None) => return Ok(None),
            (Some(_), Some(file)) => file,
            (Some(probe), None) => {
                return Err(refuse("--probe", probe, "`--probe-out FILE` beside it".to_owned()));
            }
            (None, Some(file)) => {
                let file = file.display().to_string();
                return Err(refuse("--probe-out", &file, "`--probe WHAT` beside it".to_owned()));
            }
        };
        let probes = arguments.probes.iter().map(|text| Probe::parse(text, spec));
        let probes = probes.collect::<Result<Vec<_>, _>>()?;
        let form = Form::of("--probe-out", file)?;
        let sink = Sink::check("--probe-out", file, inputs)?;
        record.map_or(Ok(()), |record| sink.check_apart("--probe-out", record, "--out"))?;
        let moving = simulation.moving();
        let energies: Vec<_> = moving.energies().into_iter().map(|(name, _)| name).collect();
        let mut columns = vec!["time_s".to_owned()];
        for probe in &probes {
            let names = match probe {
                Probe::Particle(i) => ["x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s"]
                    .map(|name| format!("particle_{i}_{name}"))
                    .to_vec(),
                Probe::Mean(of, _) => {
                    ["x_m", "y_m", "z_m"].map(|name| format!("{of}_{name}")).to_vec()
                }
                Probe::Stretch => {
                    ["stretch_greatest".to_owned(), "stretch_mean".to_owned()].to_vec()
                }
                Probe::Lowest => ["lowest_z_m".to_owned(), "lowest_particle".to_owned()].to_vec(),
                Probe::Energy => energies.iter().map(|name| format!("energy_{name}_j")).collect(),
            };
            columns.extend(names);
        }
        let every = steps.div_ceil(MOST_TIMES).max(1);
        let mut all = Self { spec, probes, sink, form, columns, rows: Vec::new(), every, steps };
        all.add(&moving.state(), &moving.energies());
        Ok(Some(all))
    }

    /// Looks at the end of a step.
    pub(crate) fn look(&mut self, moment: &Moment<'_>) {
        let moving = moment.moving();
        if (moment.step.is_multiple_of(self.every) || moment.step == self.steps)
            && moving.is_finite()
        {
            self.add(&moving.state(), &moving.energies());
        }
    }

    fn add(&mut self, state: &State, energies: &[(String, f64)]) {
        let mut row = vec![state.t];
        for probe in &self.probes {
            match probe {
                Probe::Particle(i) => row.extend(state.x[*i].iter().chain(&state.v[*i])),
                Probe::Mean(_, particles) => {
                    let sum: Vec3 = particles.iter().map(|&i| state.x[i as usize]).sum();
                    row.extend(&(sum / particles.len() as f64));
                }
                Probe::Stretch => {
                    let strain =
                        self.spec.springs.iter().filter(|s| s.rest_length_m > 0.0).map(|s| {
                            let way = state.x[s.i as usize] - state.x[s.j as usize];
                            way.norm() / s.rest_length_m - 1.0
                        });
                    let (count, sum, greatest) = strain
                        .fold((0.0, 0.0, f64::NEG_INFINITY), |(n, sum, most), strain| {
                            (n + 1.0, sum + strain, f64::max(most, strain))
                        });
                    let is_empty = count == 0.0;
                    row.extend(if is_empty { [0.0; 2] } else { [greatest, sum / count] });
                }
                Probe::Lowest => {
                    let heights = state.x.iter().map(|x| x.z).enumerate();
                    let lowest = heights.min_by(|a, b| a.1.total_cmp(&b.1));
                    row.extend(lowest.map_or([0.0; 2], |(i, z)| [z, i as f64]));
                }
                Probe::Energy => row.extend(energies.iter().map(|(_, energy)| *energy)),
            }
        }
        self.rows.push(row);
    }

    /// Whether the series go to standard output.
    pub(crate) fn is_standard(&self) -> bool {
        self.sink.is_standard()
    }

    /// Writes the series.
    pub(crate) fn finish(&self) -> anyhow::Result<()> {
        let text = match self.form {
            Form::Csv => csv(&self.columns, &self.rows),
            Form::Json => {
                let table = serde_json::json!({
                    "format": "drape-probe/1",
                    "scene": self.spec.name,
                    "columns": self.columns,
                    "rows": self.rows,
                });
                serde_json::to_string(&table)? + "\n"
            }
        };
        self.sink.write(text.as_bytes())
    }
}

fn csv(columns: &[String], rows: &[Vec<f64>]) -> String {
    let mut text = csv_line(columns.iter().map(String::as_str));
    for row in rows {
        let numbers: Vec<_> = row.iter().map(|number| format!("{number:?}")).collect();
        text += &csv_line(numbers.iter().map(String::as_str));
    }
    text
}

/// The series of a run as CSV: time, energies and momenta.
pub(crate) fn series(samples: &[Sample]) -> String {
    let names: Vec<&String> = samples.first().into_iter().flat_map(|s| s.energy_j.keys()).collect();
    let mut columns = vec!["time_s".to_owned()];
    columns.extend(names.iter().map(|name| format!("energy_{name}_j")));
    for (quantity, unit) in [("momentum", "kg_m_s"), ("angular_momentum", "kg_m2_s")] {
        columns.extend(["x", "y", "z"].map(|axis| format!("{quantity}_{axis}_{unit}")));
    }
    let rows: Vec<_> = samples
        .iter()
        .map(|sample| {
            let energy = |name: &&String| sample.energy_j.get(*name).copied().unwrap_or(f64::NAN);
            let mut row = vec![sample.time_s];
            row.extend(names.iter().map(energy));
            row.extend(sample.momentum.iter().chain(&sample.angular_momentum));
            row
        })
        .collect();
    csv(&columns, &rows)
}
