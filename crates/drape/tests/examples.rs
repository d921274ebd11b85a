//! Every example runs and prints the results that its text promises.

#![allow(clippy::unwrap_used)]

use drape_harness::record::Run;
use std::path::Path;
use std::process::Command;

/// What an example prints.
fn output(name: &str) -> String {
    output_of(name, &[])
}

/// What an example prints with these arguments.
fn output_of(name: &str, arguments: &[&str]) -> String {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
    let lines = std::fs::read_to_string(source.with_extension("rs")).unwrap().lines().count();
    assert!(lines < 60, "{name} has {lines} lines");
    let program = Path::new(env!("CARGO_BIN_EXE_drape")).with_file_name("examples").join(name);
    assert!(program.is_file(), "`cargo build --examples -p drape` makes {}", program.display());
    let output = Command::new(program).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The number in the column of a line that starts with these words.
fn number(text: &str, start: &str, column: usize) -> f64 {
    let line = text.lines().find(|line| line.trim_start().starts_with(start)).unwrap();
    line.split_whitespace().nth(column).unwrap().parse().unwrap()
}

#[test]
fn a_hanging_sheet_falls_and_loses_energy() {
    let text = output("hang_a_sheet");
    assert!(text.contains("400 particles, 2 pinned"), "{text}");
    assert!(number(&text, "0.40", 1) < number(&text, "0.20", 1), "{text}");
    assert!(number(&text, "1.00", 2) < 0.0, "{text}");
    assert!(text.contains("100 steps, ") && !text.contains("diverged"), "{text}");
}

/// The method of the example is implicit midpoint: it moves as ours does.
#[test]
fn a_method_of_ones_own_has_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    let mut ends = Vec::new();
    for method in ["my-midpoint", "midpoint:residual=1e-12"] {
        let out = folder.path().join("run.json").display().to_string();
        let scene = ["run", "hanging-textile-1e6", "--dt", "0.01", "--duration", "0.2"];
        let arguments = [&scene[..], &["--method", method, "--out", &out]].concat();
        let text = output_of("write_a_method", &arguments);
        assert!(text.contains("20 steps of 0.01 s"), "{text}");
        let run: Run = drape_report::file::read_json(Path::new(&out)).unwrap();
        ends.push(run.final_state.position_m);
    }
    let pairs = ends[0].iter().zip(&ends[1]);
    let far = pairs.flat_map(|(a, b)| [0, 1, 2].map(|k| (a[k] - b[k]).abs())).fold(0.0, f64::max);
    assert!(far > 0.0 && far < 1e-7, "{far:e}");
    assert!(output_of("write_a_method", &["list", "methods"]).contains("\nmy-midpoint\n"));
}

#[test]
fn a_method_of_ones_own_has_the_studies() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display().to_string();
    let arguments = ["experiment", "order", "--quick", "--methods", "my-midpoint", "--out", &out];
    output_of("write_a_method", &arguments);
    let record = std::fs::read_to_string(folder.path().join("order.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    let rows = record["facts"]["rows"].as_array().unwrap();
    assert!(rows.iter().all(|row| row["label"] == "my-midpoint"), "{rows:?}");
    let smooth = rows.iter().find(|row| row["scene"] == "smooth").unwrap();
    assert_eq!(smooth["accepted"], true);
    assert!((smooth["order"].as_f64().unwrap() - 2.0).abs() < 0.01, "{smooth}");
    assert_eq!(record["command"], "drape experiment order --quick --methods my-midpoint");
    assert!(folder.path().join("report.html").is_file());
}

#[test]
fn a_force_of_ones_own_moves_the_cloth_with_implicit_methods() {
    let text = output("write_an_effect");
    for method in ["backward-euler", "imex-updated"] {
        let lowest = |name: &str| number(&text, &format!("{method}, {name} the magnet"), 7);
        assert!(lowest("with") > lowest("without") + 0.01, "{text}");
    }
}

#[test]
fn two_methods_are_compared_by_energy_iterations_and_motion() {
    let text = output("compare_two");
    let motion = |method: &str| number(&text, method, 5);
    assert!(motion("imex-euler") < 50.0 && motion("imex-updated") > 90.0, "{text}");
    let iterations = |method: &str| number(&text, method, 4);
    assert!(iterations("imex-euler") < iterations("imex-updated"), "{text}");
}
