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
use drape_harness::studies::work_precision::facts::{Facts, TimingRow};
use drape_harness::studies::work_precision::repriced;
use drape_report::file::{read_json, write_json};
use drape_report::{Record, Timings, tell};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

/// The timed runs of each form.
type Forms = BTreeMap<String, Vec<Sample>>;

const FOLDER: &str = "crates/harness/src/cost";

fn main() -> Result<(), Box<dyn Error>> {
    let results = std::env::args().nth(1).map_or_else(|| PathBuf::from("results"), PathBuf::from);
    let path = results.join("work-precision.json");
    let mut record: Record<Facts> = read_json(&path)?;
    let timings: Timings<TimingRow> = read_json(&results.join("timings/work-precision.json"))?;
    let forms = samples(&record.facts, &timings.rows)?;
    let samples = Samples {
        cpu: timings.provenance.cpu,
        commit: timings.provenance.commit.ok_or("the timings name no commit")?,
        forms,
    };
    let prices = samples.prices();
    for price in &prices.forms {
        tell!("{:60} {:3} runs, within {:.2}", price.method, price.runs, price.within);
    }
    let folder = Path::new(FOLDER);
    std::fs::write(folder.join("samples.json"), serde_json::to_string(&samples)? + "\n")?;
    std::fs::write(folder.join("prices.json"), serde_json::to_string_pretty(&prices)? + "\n")?;
    record.facts = repriced(record.facts, &prices);
    write_json(&path, &record)?;
    find("work-precision")?.reword(&results)?;
    Ok(())
}

/// The timed runs of each form. The quickest repetition counts: what is slower was disturbed.
fn samples(facts: &Facts, timings: &[TimingRow]) -> Result<Forms, String> {
    let scenes: BTreeMap<_, _> = facts.scenes.iter().map(|scene| (&scene.id, scene)).collect();
    let mut runs = BTreeMap::new();
    for row in &facts.rows {
        let key = |value: f64| (&row.scene, &row.label, value.to_bits());
        runs.extend(row.runs.iter().map(|run| (key(run.value), (&row.method, run))));
    }
    let mut by_form = Forms::new();
    for timing in timings {
        let TimingRow { scene, label, value, .. } = timing;
        let found = runs.get(&(scene, label, value.to_bits())).zip(scenes.get(scene));
        let same = found.filter(|((_, run), _)| run.error == Some(timing.error));
        let refuse = |why: &str| format!("the timing of {label} on {scene} at {value} {why}");
        let ((method, run), sheet) =
            same.ok_or_else(|| refuse("is not of a run in this record"))?;
        if !timing.is_verified {
            return Err(refuse("had another result than the run in this record"));
        }
        let work = Counted {
            steps: run.steps,
            force_evaluations: run.force_evaluations,
            matvecs: run.matvecs,
            factorisations: run.factorisations,
            setups: run.setups,
            particles: sheet.particles,
            springs: sheet.springs,
        };
        let quickest = timing.samples_ns.iter().min().ok_or_else(|| refuse("has no sample"))?;
        let sample = Sample { work, seconds: 1e-9 * *quickest as f64 };
        by_form.entry((*method).clone()).or_default().push(sample);
    }
    Ok(by_form)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn a_timing_counts_only_beside_its_own_run() {
        let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("../results");
        let record: Record<Facts> = read_json(&results.join("work-precision.json")).unwrap();
        let timings = results.join("timings/work-precision.json");
        let timings: Timings<TimingRow> = read_json(&timings).unwrap();
        let row = &timings.rows[0];
        let of = |row: &TimingRow| samples(&record.facts, std::slice::from_ref(row));
        let quickest = *row.samples_ns.iter().min().unwrap();
        let forms = of(row).unwrap();
        let sample = forms.values().next().unwrap();
        assert_eq!((forms.len(), sample.len()), (1, 1));
        assert_eq!(sample[0].seconds, 1e-9 * quickest as f64);
        let other = TimingRow { error: 2.0 * row.error, ..row.clone() };
        assert!(of(&other).unwrap_err().contains("is not of a run in this record"));
        let other = TimingRow { is_verified: false, ..row.clone() };
        assert!(of(&other).unwrap_err().contains("had another result"));
        let other = TimingRow { samples_ns: Vec::new(), ..row.clone() };
        assert!(of(&other).unwrap_err().contains("has no sample"));
    }
}
