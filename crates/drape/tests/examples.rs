//! Every example runs and prints the results that its text promises.

#![allow(clippy::unwrap_used)]

use drape_harness::record::Run;
use serde_json::Value;
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

/// A comparison weighs it against ours, and its page has a row of it.
#[test]
fn a_method_of_ones_own_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display().to_string();
    let scene = ["compare", "hanging-textile-1e4", "--duration", "0.1", "--budget", "60s"];
    let more = ["--methods", "leapfrog,my-midpoint", "--out", &out];
    let said = output_of("write_a_method", &[&scene[..], &more].concat());
    assert!(said.contains("\ntake "), "{said}");
    let facts = facts(folder.path(), "compare");
    let forms = facts["forms"].as_array().unwrap();
    let place = forms.iter().position(|form| form["label"] == "my-midpoint").unwrap();
    assert_eq!(forms[place]["end"], "good", "{}", forms[place]);
    let runs = rows(&facts, "runs", "form", place);
    assert!(runs.iter().any(|run| run["verdict"] == "stable"), "{runs:?}");
    let page = std::fs::read_to_string(folder.path().join("compare.html")).unwrap();
    assert!(page.contains(">my-midpoint</td>"));
}

/// The facts of a record in a folder.
fn facts(folder: &Path, name: &str) -> Value {
    let record = std::fs::read_to_string(folder.join(name).with_extension("json")).unwrap();
    serde_json::from_str::<Value>(&record).unwrap()["facts"].take()
}

/// The rows of facts that name this method, or whatever else the key stands for.
fn rows<'a, V>(facts: &'a Value, list: &str, key: &str, named: V) -> Vec<&'a Value>
where
    Value: PartialEq<V>,
{
    facts[list].as_array().unwrap().iter().filter(|row| row[key] == named).collect()
}

/// The rows of the example's method in a study, which it computes beside `midpoint`. What theory says
/// of the one holds for the other: rows of the same setting have the same verdict.
fn rows_beside_ours(folder: &Path, study: &str, list: &str, key: &str) -> Vec<Value> {
    let out = folder.display().to_string();
    let arguments = ["experiment", study, "--quick", "--methods", "my-midpoint,midpoint"];
    output_of("write_a_method", &[&arguments[..], &["--out", &out]].concat());
    let facts = facts(folder, study);
    let (own, ours) = (rows(&facts, list, key, "my-midpoint"), rows(&facts, list, key, "midpoint"));
    let settings = ["scene", "case", "is_damped", "stiffness_over_mass_per_s2", "step_s"];
    for row in &own {
        let is_same = |other: &&&Value| settings.iter().all(|name| row[name] == other[name]);
        let other = ours.iter().find(is_same).unwrap_or_else(|| panic!("{study}: no other {row}"));
        assert_eq!(row["verdict"], other["verdict"], "{study}: {row}");
    }
    own.into_iter().cloned().collect()
}

fn float(row: &Value, name: &str) -> f64 {
    row[name].as_f64().unwrap_or_else(|| panic!("no number `{name}` in {row}"))
}

/// What theory says of implicit midpoint is what the studies find of the example's, with no edit of
/// ours, and the pages show its rows.
#[test]
fn a_method_of_ones_own_has_the_studies_and_the_pages() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let out = folder.display().to_string();
    let arguments = ["experiment", "order", "--quick", "--methods", "my-midpoint", "--out", &out];
    output_of("write_a_method", &arguments);
    let record = std::fs::read_to_string(folder.join("order.json")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    let orders = record["facts"]["rows"].as_array().unwrap();
    assert!(orders.iter().all(|row| row["label"] == "my-midpoint"), "{orders:?}");
    let smooth = orders.iter().find(|row| row["scene"] == "smooth").unwrap();
    assert_eq!(smooth["accepted"], true);
    assert!((float(smooth, "order") - 2.0).abs() < 0.01, "{smooth}");
    assert_eq!(record["command"], "drape experiment order --quick --methods my-midpoint");

    // It is A-stable on linear problems: at h² k/m = 10 and 100, where every explicit method has
    // long failed, the hanging sheet gains no energy. At larger steps the sheet is not linear.
    let cells = rows_beside_ours(folder, "stability", "cells", "label");
    let is_held = |cell: &&Value| float(cell, "step_s") < 0.11;
    let held: Vec<_> = cells.iter().filter(is_held).collect();
    assert_eq!((cells.len(), held.len()), (4, 2), "{cells:?}");
    for cell in held {
        let squared = float(cell, "step_s").powi(2) * float(cell, "stiffness_over_mass_per_s2");
        assert!(squared > 9.9, "{cell}");
        assert!(cell["verdict"] == "stable" && float(cell, "gain") < 1e-9, "{cell}");
    }

    // It keeps momentum and spin to rounding.
    let drifts = rows_beside_ours(folder, "momentum", "rows", "label");
    assert_eq!(drifts.len(), 3, "{drifts:?}");
    for row in &drifts {
        assert!(row["states_momentum"] == true && row["verdict"] == "completed", "{row}");
        assert!(float(row, "momentum_drift") < 1e-12, "{row}");
        assert!(float(row, "angular_momentum_drift") < 1e-12, "{row}");
        assert!((float(row, "final_spin") - 1.0).abs() < 1e-10, "{row}");
    }

    // It is symplectic: without damping the energy stays near its start, with damping it only falls.
    // It refuses contact, so the spinning sheet is the one scene for it.
    let energies = rows_beside_ours(folder, "energy", "rows", "label");
    assert_eq!(energies.len(), 2, "{energies:?}");
    for row in &energies {
        assert_eq!(row["verdict"], "stable", "{row}");
        let (drift, gain) = (float(row, "drift"), float(row, "gain"));
        if row["scene"] == "spinning-1e4 undamped" {
            assert!(drift.abs() < 1e-3 && gain < 1e-3, "{row}");
        } else {
            assert!(drift < -0.99 && gain < 1e-9, "{row}");
        }
    }

    // Nothing is known of it beforehand but what holds for every method.
    let cases = rows_beside_ours(folder, "hard-cases", "cells", "method");
    assert_eq!(cases.len(), 6, "{cases:?}");
    for cell in &cases {
        assert_eq!(cell["differs"], false, "{cell}");
        let is_known = cell["case"].as_str().unwrap().starts_with("H17");
        assert_eq!(cell["expected"], if is_known { "stable" } else { "no theorem" }, "{cell}");
        assert!(!is_known || cell["verdict"] == "stable", "{cell}");
    }

    // The pages are drawn from the records alone, each part with rows of the method.
    let page = folder.join("report.html");
    std::fs::remove_file(&page).unwrap();
    output_of("write_a_method", &["report", &out]);
    let page = std::fs::read_to_string(page).unwrap();
    for study in ["order", "stability", "momentum", "energy", "hard-cases"] {
        let (_, part) = page.split_once(&format!("<h3 id=\"{study}-heading\"")).unwrap();
        let part = part.split("<h3 id=\"").next().unwrap();
        assert!(part.contains(">my-midpoint</td>"), "{study}");
    }
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
