//! Fits the prices of counted work to the timings of the study `work-precision`, and writes them
//! and the timed runs into the source: `cargo run --release -p drape-tests --bin prices [RESULTS]`.
//! The record of the study in RESULTS gets the modelled times, fronts and winners by these prices.
//!
//! Before it, `drape experiment work-precision --timings --rounds 8` takes the timings. After it,
//! `trajectory`, `rest`, `course`, `regret` and `claims` run again, since they are priced while they
//! run, and then the binary `auto`.

use drape_harness::cost::Counted;
use drape_harness::cost::fit::{Sample, Samples};
use drape_harness::studies::find;
use drape_harness::studies::work_precision::facts::Facts;
use drape_harness::studies::work_precision::repriced;
use drape_report::file::{read_json, write_json};
use drape_report::{Record, tell};
use serde_json::Value;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

/// The timed runs of each form.
type Forms = BTreeMap<String, Vec<Sample>>;

const FOLDER: &str = "crates/harness/src/cost";

fn main() -> Result<(), Box<dyn Error>> {
    let results = std::env::args().nth(1).map_or_else(|| PathBuf::from("results"), PathBuf::from);
    let record = read(&results.join("work-precision.json"))?;
    let timings = read(&results.join("timings/work-precision.json"))?;
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let samples = Samples {
        cpu: text(&timings["provenance"]["cpu"]),
        commit: text(&timings["provenance"]["commit"]),
        forms: samples(&record["facts"], &timings["rows"]).ok_or("a field is missing")??,
    };
    let prices = samples.prices();
    for price in &prices.forms {
        tell!("{:60} {:3} runs, within {:.2}", price.method, price.runs, price.within);
    }
    let folder = Path::new(FOLDER);
    std::fs::write(folder.join("samples.json"), serde_json::to_string(&samples)? + "\n")?;
    std::fs::write(folder.join("prices.json"), serde_json::to_string_pretty(&prices)? + "\n")?;
    let path = results.join("work-precision.json");
    let mut record: Record<Facts> = read_json(&path)?;
    record.facts = repriced(record.facts, &prices);
    write_json(&path, &record)?;
    find("work-precision")?.reword(&results)?;
    Ok(())
}

fn read(path: &Path) -> Result<Value, Box<dyn Error>> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?)
}

/// The timed runs of each form. The quickest repetition counts: what is slower was disturbed.
fn samples(facts: &Value, timings: &Value) -> Option<Result<Forms, String>> {
    let scenes: BTreeMap<&str, &Value> = facts["scenes"]
        .as_array()?
        .iter()
        .map(|scene| Some((scene["id"].as_str()?, scene)))
        .collect::<Option<_>>()?;
    let mut runs = BTreeMap::new();
    for row in facts["rows"].as_array()? {
        for run in row["runs"].as_array()? {
            let key = (row["scene"].as_str()?, row["label"].as_str()?, run["value"].to_string());
            runs.insert(key, (row["method"].as_str()?, run));
        }
    }
    let mut by_form = Forms::new();
    for timing in timings.as_array()? {
        let key =
            (timing["scene"].as_str()?, timing["label"].as_str()?, timing["value"].to_string());
        let (method, run) = runs.get(&key)?;
        let scene = scenes.get(key.0)?;
        let count = |of: &Value, name: &str| of[name].as_u64();
        let size = |name: &str| scene[name].as_u64().and_then(|n| usize::try_from(n).ok());
        let work = Counted {
            steps: count(run, "steps")?,
            force_evaluations: count(run, "force_evaluations")?,
            matvecs: count(run, "matvecs")?,
            factorisations: count(run, "factorisations")?,
            setups: count(run, "setups")?,
            particles: size("particles")?,
            springs: size("springs")?,
        };
        if timing["is_verified"] != true || timing["error"] != run["error"] {
            return Some(Err(format!("the timing of {key:?} is not of the run in this record")));
        }
        let samples = timing["samples_ns"].as_array()?;
        let quickest = samples.iter().filter_map(Value::as_f64).fold(f64::INFINITY, f64::min);
        let sample = Sample { work, seconds: 1e-9 * quickest };
        by_form.entry((*method).to_owned()).or_default().push(sample);
    }
    Some(Ok(by_form))
}
