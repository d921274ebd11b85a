//! Every example runs and prints the results that its text promises.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

/// What an example prints.
fn output(name: &str) -> String {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
    let lines = std::fs::read_to_string(source.with_extension("rs")).unwrap().lines().count();
    assert!(lines < 60, "{name} has {lines} lines");
    let program = Path::new(env!("CARGO_BIN_EXE_drape")).with_file_name("examples").join(name);
    assert!(program.is_file(), "`cargo build --examples -p drape` makes {}", program.display());
    let output = Command::new(program).output().unwrap();
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

#[test]
fn a_method_of_ones_own_is_judged() {
    let text = output("write_a_method");
    assert!(text.contains("h = 0.001 s: stable, 500 steps"), "{text}");
    assert!(text.contains("h = 0.02 s: diverged, "), "{text}");
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
