//! The command as a user meets it: exit codes, messages, files.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_harness::record::{Ending, Run};
use drape_model::{Scene, State, SystemSpec};
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn drape(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_drape")).current_dir(folder).args(arguments).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const SCENE: &str = r#"{
  "format": "drape-scene/1",
  "name": "sheet",
  "cloth": { "grid": { "rows": 3, "columns": 3, "size_m": [1, 1], "center_m": [0, 0, 0],
      "mass_kg": 0.9 } },
  "effects": {
    "tension": { "stiffness_over_mass_per_s2": 1e3, "damping_over_mass_per_s": 4 },
    "gravity": { "m_s2": [0, 0, -9.81] }
  },
  "pins": [ { "row": 0, "column": 0 } ],
  "obstacles": [ { "sphere": { "center_m": [0, 0, -2], "radius_m": 0.5 } } ],
  "time": { "step_s": 0.01, "duration_s": 0.1 }
}"#;

const SYSTEM: &str = r#"{
  "format": "drape-system/1",
  "particles": { "mass_kg": [1, 1], "position_m": [[0, 0, 0], [1, 0, 0]] },
  "springs": [ { "effect": "tension", "i": 0, "j": 1, "rest_length_m": 1,
      "stiffness_n_per_m": 10 } ],
  "pins": [ { "particle": 0 } ]
}"#;

/// What is replaced in a good file, by what, and the path that the message must name.
const BROKEN_SCENES: &[(&str, &str, &str)] = &[
    (r#""mass_kg": 0.9"#, r#""mass_kg": -0.9"#, "cloth.grid.mass_kg"),
    (r#""mass_kg": 0.9"#, r#""mass_kg": 0"#, "cloth.grid.mass_kg"),
    (r#""mass_kg": 0.9"#, r#""mass_kg": "heavy""#, "cloth.grid.mass_kg"),
    (r#""mass_kg": 0.9"#, r#""mass_kg": NaN"#, "cloth.grid.mass_kg"),
    (r#""mass_kg": 0.9"#, r#""mass_kg": 1e999"#, "cloth.grid.mass_kg"),
    (r#""mass_kg": 0.9"#, r#""mass_kg": null"#, "cloth.grid.mass_kg"),
    (r#""rows": 3"#, r#""rows": 0"#, "cloth.grid.rows"),
    (r#""rows": 3"#, r#""rows": -3"#, "cloth.grid.rows"),
    (r#""rows": 3"#, r#""rows": 4000000000"#, "cloth.grid"),
    (r#""size_m": [1, 1]"#, r#""size_m": [1]"#, "cloth.grid.size_m"),
    (r#""size_m": [1, 1]"#, r#""size_m": [1, 0]"#, "cloth.grid.size_m[1]"),
    (r#""name": "sheet""#, r#""nome": "sheet""#, "nome"),
    (r#""tension": {"#, r#""tensoin": {"#, "effects.tensoin"),
    (r#""row": 0"#, r#""row": 3"#, "pins[0].row"),
    (r#""row": 0"#, r#""particle": 1"#, "pins[0]"),
    (r#""radius_m": 0.5"#, r#""radius_m": 0"#, "obstacles[0].sphere.radius_m"),
    (r#""sphere""#, r#""spehre""#, "obstacles[0]"),
    (r#""step_s": 0.01"#, r#""step_s": 0"#, "time.step_s"),
    (r#""step_s": 0.01"#, r#""step_s": -1"#, "time.step_s"),
    (r#""step_s": 0.01"#, r#""step_s": 1e-12"#, "time.step_s"),
    (r#""duration_s": 0.1"#, r#""duration_s": 0"#, "time.duration_s"),
    (r#""duration_s": 0.1"#, r#""duration_s": true"#, "time.duration_s"),
    (r#""drape-scene/1""#, r#""drape-scene/99""#, "format"),
    (r#""stiffness_over_mass_per_s2": 1e3,"#, "", "effects.tension"),
    (r#"1e3,"#, r#"1e3, "stiffness_n_per_m": 4,"#, "effects.tension"),
    (r#"1e3,"#, r#"-1e3,"#, "effects.tension.stiffness_over_mass_per_s2"),
];

const BROKEN_SYSTEMS: &[(&str, &str, &str)] = &[
    (r#""mass_kg": [1, 1]"#, r#""mass_kg": [1, -1]"#, "particles.mass_kg[1]"),
    (r#""mass_kg": [1, 1]"#, r#""mass_kg": [1]"#, "particles.position_m"),
    (r#""mass_kg": [1, 1]"#, r#""mass_kg": []"#, "particles.mass_kg"),
    (r#""j": 1"#, r#""j": 2"#, "springs[0].j"),
    (r#""j": 1"#, r#""j": 0"#, "springs[0].j"),
    (r#""rest_length_m": 1"#, r#""rest_length_m": -1"#, "springs[0].rest_length_m"),
    (r#""effect": "tension""#, r#""effect": "magic""#, "springs[0].effect"),
    (r#""particle": 0"#, r#""particle": 7"#, "pins[0].particle"),
    (r#"[1, 0, 0]]"#, r#"[1, 0]]"#, "particles.position_m[1]"),
];

fn refused(folder: &Path, content: &str, path: &str) {
    std::fs::write(folder.join("broken.json"), content).unwrap();
    let run = ["run", "broken.json", "--method", "imex-euler", "--out", "run.json"];
    let frozen = content.contains("drape-system");
    let time: &[&str] = if frozen { &["--dt", "0.01", "--duration", "0.1"] } else { &[] };
    for arguments in [[&run[..], time].concat(), vec!["system", "broken.json"]] {
        let output = drape(folder, &arguments);
        let message = text(&output.stderr);
        assert_eq!(code(&output), 2, "{content}\n{message}");
        assert!(output.stdout.is_empty(), "{content}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(message.starts_with("drape: broken.json: "), "{message}");
        assert!(message.contains(path), "{path} is not named: {message}");
        assert!(message.contains("expected"), "{message}");
        assert!(!message.contains("panicked"), "{message}");
    }
    let left: Vec<_> = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(left, ["broken.json"], "a refused run leaves no file behind");
}

#[test]
fn broken_scenes_and_systems_are_refused_by_path_with_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    for (base, cases) in [(SCENE, BROKEN_SCENES), (SYSTEM, BROKEN_SYSTEMS)] {
        for (from, to, path) in cases {
            assert_eq!(base.matches(from).count(), 1, "{from} must be unique");
            refused(folder.path(), &base.replacen(from, to, 1), path);
        }
    }
}

#[test]
fn what_a_method_does_not_support_is_refused_by_file_and_key() {
    let folder = tempfile::tempdir().unwrap();
    let rough = SCENE.replace(r#""radius_m": 0.5"#, r#""radius_m": 0.5, "friction": 0.3"#);
    std::fs::write(folder.path().join("rough.json"), rough).unwrap();
    let output = drape(folder.path(), &["run", "rough.json", "--method", "imex-cnlf"]);
    let message = text(&output.stderr);
    assert_eq!(code(&output), 2, "{message}");
    let expected = "drape: rough.json: `obstacles[0].sphere.friction`: imex-cnlf does not support";
    assert!(message.starts_with(expected) && message.lines().count() == 1, "{message}");
}

#[test]
fn files_that_are_no_json_are_refused_with_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let deep = format!("{{\"format\": {}", "[".repeat(100_000));
    for content in ["", "  \n", "not json", "{", "[]", "3", &SCENE[..200], &deep, "{} {}"] {
        refused(folder.path(), content, "");
    }
}

#[test]
fn unknown_methods_settings_scenes_and_time_steps_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let run =
        |rest: &[&str]| drape(folder.path(), &[&["run", "hanging-textile-1e4"], rest].concat());
    let cases: &[(&[&str], &str)] = &[
        (&["--method", "imex"], "imex-euler"),
        (&["--method", "imex-euler:forcing=1"], "forcing_term"),
        (&["--method", "imex-euler", "--set", "forcing_term=0.6"], "5e-1"),
        (&["--method", "imex-euler", "--set", "forcing_term=NaN"], "NaN"),
        (&["--method", "imex-euler", "--set", "start"], "key=value"),
        (&["--method", "imex-euler:start=last,start=last"], "twice"),
        (&["--method", "explicit-euler:start=last"], "none"),
        (&["--method", "imex-euler", "--dt", "0"], "--dt"),
        (&["--method", "imex-euler", "--dt", "-0.1"], "--dt"),
        (&["--method", "imex-euler", "--dt", "nan"], "--dt"),
        (&["--method", "imex-euler", "--dt", "1e-15"], "1e9 steps"),
        (&["--method", "imex-euler", "--duration", "inf"], "--duration"),
    ];
    for (arguments, named) in cases {
        let output = run(arguments);
        let message = text(&output.stderr);
        assert_eq!(code(&output), 2, "{arguments:?}: {message}");
        assert!(message.contains(named) && message.contains("expected"), "{message}");
    }
    let missing = drape(folder.path(), &["run", "no-such-scene", "--method", "imex-euler"]);
    assert_eq!(code(&missing), 2);
    assert!(text(&missing.stderr).contains("hanging-textile-1e4"));
    for (arguments, like) in [
        (["run", "curtian", "--method", "xpbd"].as_slice(), "curtain"),
        (&["experiment", "tabels"], "tables"),
        (&["inspect", "order/smoth-projected"], "smooth-projected"),
        (&["list", "methods", "xpdb"], "xpbd"),
        (&["scene", "skrit"], "skirt"),
        (&["material", "denimm"], "denim"),
    ] {
        let output = drape(folder.path(), arguments);
        let message = text(&output.stderr);
        assert_eq!(code(&output), 2, "{arguments:?}: {message}");
        assert!(message.contains(&format!("(nearest: `{like}`)")), "{message}");
    }
    assert_eq!(code(&drape(folder.path(), &["experiment", "nothing"])), 2);
    let claim = drape(folder.path(), &["claim", "C99"]);
    assert_eq!(code(&claim), 2);
    assert!(text(&claim.stderr).contains("C01, C02") && claim.stdout.is_empty());
    assert_eq!(code(&drape(folder.path(), &["report", "."])), 2);
    assert_eq!(code(&drape(folder.path(), &["frobnicate"])), 2);
}

#[test]
fn the_scenes_of_the_docs_run() {
    let folder = tempfile::tempdir().unwrap();
    let blocks = include_str!("../docs/scenes.md").split("```json\n").skip(1);
    let scenes = blocks.filter_map(|block| block.split("```").next());
    let whole: Vec<_> = scenes.filter(|scene| scene.contains("\"format\"")).collect();
    assert_eq!(whole.len(), 2);
    for scene in whole {
        std::fs::write(folder.path().join("scene.json"), scene).unwrap();
        let run = ["run", "scene.json", "--method", "xpbd-lines", "--duration", "0.05"];
        let output = drape(folder.path(), &run);
        assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    }
}

#[test]
fn a_frozen_scene_reads_back_bit_for_bit_and_runs_alike() {
    let folder = tempfile::tempdir().unwrap();
    for scene in drape_model::bundled::names() {
        let printed = drape(folder.path(), &["system", scene]);
        assert_eq!(code(&printed), 0);
        std::fs::write(folder.path().join("frozen.json"), &printed.stdout).unwrap();
        let again = drape(folder.path(), &["system", "frozen.json"]);
        assert!(printed.stdout == again.stdout, "{scene} changes when read back");
    }
    let time = ["--dt", "0.01", "--duration", "0.2", "--method", "imex-euler", "--out"];
    let frozen = drape(folder.path(), &["system", "hanging-textile-1e4"]);
    std::fs::write(folder.path().join("frozen.json"), &frozen.stdout).unwrap();
    for (input, out) in [("hanging-textile-1e4", "a.json"), ("frozen.json", "b.json")] {
        let output = drape(folder.path(), &[&["run", input], &time[..], &[out]].concat());
        assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    }
    let read =
        |name: &str| -> Run { drape_report::file::read_json(&folder.path().join(name)).unwrap() };
    let (a, b) = (read("a.json"), read("b.json"));
    assert_eq!(a.scene_hash, b.scene_hash);
    assert_eq!(a.series, b.series);
    assert_eq!(a.final_state, b.final_state);
}

#[test]
fn a_run_record_continues_where_it_ended() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        ["run", "hanging-textile-1e4", "--method", "imex-euler", "--phases", "--out", "run.json"];
    assert_eq!(code(&drape(folder.path(), &arguments)), 0);
    let run: Run = drape_report::file::read_json(&folder.path().join("run.json")).unwrap();
    assert_eq!(run.steps, 100);
    assert_eq!(run.ending, Ending::Completed { unconverged_steps: 0 });
    assert_eq!(run.series.len(), 101);
    assert!(run.phases_seconds.is_some());
    assert_eq!(run.settings["forcing_term"], "1e-3");
    for sample in &run.series {
        let parts = ["kinetic", "tension", "gravity"].map(|name| sample.energy_j[name]);
        let total = sample.energy_j["total"];
        assert!((parts.iter().sum::<f64>() - total).abs() <= 1e-12 * (1.0 + total.abs()));
    }
    // The final state stands in the record with every bit: a frozen system made of it is accepted.
    let input = drape_model::load("hanging-textile-1e4").unwrap();
    let vectors = |list: &[[f64; 3]]| list.iter().map(|&v| v.into()).collect();
    let state = State {
        t: run.final_state.time_s,
        x: vectors(&run.final_state.position_m),
        v: vectors(&run.final_state.velocity_m_s),
    };
    let frozen: SystemSpec = input.spec().clone().with_state(&state);
    assert_eq!(frozen.build().unwrap().1.x, state.x);
}

#[test]
fn any_number_of_threads_gives_the_same_run() {
    let folder = tempfile::tempdir().unwrap();
    // More particles than one thread computes alone.
    let sheet = SCENE
        .replace(r#""rows": 3, "columns": 3"#, r#""rows": 131, "columns": 137"#)
        .replace(r#""gravity""#, r#""shear": { "stiffness_over_mass_per_s2": 1e2 }, "gravity""#)
        .replace("[0, 0, -2]", "[0.4, 0.1, -0.505]"); // touched from the first step on
    std::fs::write(folder.path().join("sheet.json"), sheet).unwrap();
    let method = "imex-euler:implicit=tension,preconditioner=jacobi";
    let runs = ["1", "2", "3"].map(|threads| {
        let arguments = ["run", "sheet.json", "--method", method, "--duration", "0.05"];
        let arguments = [&arguments[..], &["--threads", threads, "--out", "run.json"]].concat();
        assert_eq!(code(&drape(folder.path(), &arguments)), 0);
        drape_report::file::read_json::<Run>(&folder.path().join("run.json")).unwrap()
    });
    assert!(runs[0].totals.cg_iterations > 5);
    for run in &runs[1..] {
        assert_eq!(run.totals.cg_iterations, runs[0].totals.cg_iterations);
        assert!(run.series == runs[0].series);
        let bits = |list: &[[f64; 3]]| list.as_flattened().iter().map(|x| x.to_bits()).collect();
        let [ours, theirs]: [[Vec<u64>; 2]; 2] = [run, &runs[0]]
            .map(|run| [bits(&run.final_state.position_m), bits(&run.final_state.velocity_m_s)]);
        assert!(ours == theirs);
    }
}

#[test]
fn a_number_of_threads_that_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for bad in ["0", "-1", "two", "1025"] {
        let threads = format!("--threads={bad}");
        let arguments = ["run", "hanging-textile-1e4", "--method", "imex-euler", &threads];
        let output = drape(folder.path(), &arguments);
        assert_eq!(code(&output), 2, "{bad}");
        assert!(text(&output.stderr).contains("--threads"), "{}", text(&output.stderr));
    }
}

#[test]
fn a_diverging_run_exits_with_3_and_keeps_what_was_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let output = drape(
        folder.path(),
        &[
            "run",
            "hanging-textile-1e6",
            "--method",
            "explicit-euler",
            "--dt",
            "0.01",
            "--out",
            "x.json",
        ],
    );
    let message = text(&output.stderr);
    assert_eq!(code(&output), 3, "{message}");
    assert!(message.contains("diverged at step") && message.contains("farther than"), "{message}");
    let run: Run = drape_report::file::read_json(&folder.path().join("x.json")).unwrap();
    let Ending::Diverged { step, .. } = run.ending else { panic!("{:?}", run.ending) };
    assert_eq!(step, run.steps);
    assert!(run.series.len() as u64 >= step, "every finite sample is kept");
}

#[test]
fn a_run_names_the_settings_of_its_method_where_it_has_any() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "hanging-textile-1e4", "--dt", "1e-4", "--duration", "1e-3", "--method"];
    for (method, named) in [
        ("explicit-euler", "with explicit-euler: 10 steps"),
        ("adams-bashforth2:steps=3", "with adams-bashforth2 (steps=3): 10 steps"),
    ] {
        let output = drape(folder.path(), &[&run[..], &[method]].concat());
        let printed = text(&output.stderr) + &text(&output.stdout);
        assert!(printed.contains(named), "{printed}");
    }
}

#[test]
fn a_duration_that_is_no_multiple_of_the_step_ends_with_a_shorter_step() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "run",
        "hanging-textile-1e4",
        "--method",
        "imex-euler",
        "--dt",
        "0.01",
        "--duration",
        "0.025",
        "--out",
        "run.json",
    ];
    assert_eq!(code(&drape(folder.path(), &arguments)), 0);
    let run: Run = drape_report::file::read_json(&folder.path().join("run.json")).unwrap();
    assert_eq!(run.steps, 3);
    assert_eq!(run.final_state.time_s, 0.025);
}

#[test]
fn schemas_and_lists_are_printed() {
    let folder = tempfile::tempdir().unwrap();
    for format in ["scene", "system", "run"] {
        let output = drape(folder.path(), &["schema", format]);
        let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(schema["additionalProperties"], false, "{format} refuses unknown keys");
    }
    for (what, named) in [
        ("scenes", "square-table-2704-1e6"),
        ("methods", "safeguard=robust"),
        ("methods", "imex-euler:paper    stands for imex-euler:norm=euclid,split=paper;"),
        ("methods", "desbrun:paper    stands for desbrun:inverse=dense,torque=literal,"),
        ("experiments", "cg-vs-stiffness"),
        ("claims", "criterion: margin of every row = m_i exactly"),
        ("claims", "C17 (§5): the extrapolated start helps"),
        ("claims", "M02 (expectation about methods of Macklin et al. 2019): XPBD"),
        ("experiments", "lessons: explicit-euler → leapfrog → provot"),
    ] {
        assert!(text(&drape(folder.path(), &["list", what]).stdout).contains(named));
    }
    // One name alone.
    let one = text(&drape(folder.path(), &["list", "methods", "xpbd"]).stdout);
    assert!(one.starts_with("xpbd\n") && !one.contains("\nxpbd-lines\n"), "{one}");
    let starts = text(&drape(folder.path(), &["list", "study-scenes", "order"]).stdout);
    assert!(
        !starts.is_empty() && starts.lines().all(|line| line.starts_with("order/")),
        "{starts}"
    );
    let unknown = drape(folder.path(), &["list", "claims", "C99"]);
    assert_eq!(code(&unknown), 2);
    let message = text(&unknown.stderr);
    let expected = "drape: `NAME` is \"C99\"; expected one of the names in the list: C01, C02";
    assert!(message.starts_with(expected), "{message}");
    // A bundled scene is printed as it is stored, and runs from a file.
    let flag = drape_model::bundled::text("flag").unwrap();
    assert_eq!(text(&drape(folder.path(), &["scene", "flag"]).stdout), flag);
    assert_eq!(code(&drape(folder.path(), &["scene", "flag", "--out", "my.json"])), 0);
    let run = ["run", "my.json", "--method", "xpbd-lines", "--duration", "0.05"];
    assert_eq!(code(&drape(folder.path(), &run)), 0);
    assert_eq!(code(&drape(folder.path(), &["scene", "flag", "--out", "my.txt"])), 2);
    // Bundled scenes are scenes.
    let scene: Scene =
        serde_json::from_str(drape_model::bundled::text("hanging-textile-1e4").unwrap()).unwrap();
    assert_eq!(scene.time.step_s, 0.01);
}

#[test]
fn a_claim_is_tested_alone_and_prints_verdict_numbers_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    let output = drape(folder.path(), &["claim", "c08"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    for part in [
        "C08 (§3)",
        "criterion:",
        "since:     commit ",
        "overturned by: ",
        "verdict:   holds",
        "limit",
        "reason:",
        "scenes:",
    ] {
        assert!(printed.contains(part), "`{part}` is missing: {printed}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "it writes no file");
}

#[test]
fn the_quick_reproduction_writes_records_figures_and_page() {
    let folder = tempfile::tempdir().unwrap();
    // .ci/run reproduces all studies.
    let only = "tables,cg-vs-stiffness";
    let output = drape(folder.path(), &["reproduce", "--quick", "--out", "out", "--only", only]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    for file in ["tables.json", "cg-vs-stiffness.json", "README.md", "report.html"] {
        assert!(folder.path().join("out").join(file).is_file(), "{file}");
    }
    assert!(text(&output.stderr).contains("cells"), "progress is told in plain lines");
}

#[test]
fn a_run_that_gains_energy_is_warned_about_and_one_that_does_not_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let warned = |method: &str| {
        let run =
            ["run", "hanging-textile-1e6", "--dt", "0.01", "--duration", "0.3", "--method", method];
        let output = drape(folder.path(), &run);
        assert_eq!(code(&output), 0, "{method}");
        text(&output.stderr).contains("warning: the total energy rose by")
    };
    assert!(warned("imex-updated:paper,implicit=springs,forcing_term=0.1"));
    assert!(!warned("imex-euler"));
}

/// Runs a scene whose energy rises enough for the energy warning, and returns what was said.
fn said_of_a_rise(scene: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.json"), scene).unwrap();
    let run = ["run", "scene.json", "--method", "imex-euler", "--out", "run.json"];
    let output = drape(folder.path(), &run);
    let run: Run = drape_report::file::read_json(&folder.path().join("run.json")).unwrap();
    let greatest = |name: &str| run.series.iter().map(|s| s.energy_j[name]).fold(0.0, f64::max);
    let rise = greatest("total") - run.series[0].energy_j["total"];
    assert!(rise > 0.02 * greatest("kinetic"), "{rise:e} J: nothing to overlook");
    text(&output.stderr).to_owned()
}

#[test]
fn energy_that_a_led_pin_brings_in_is_not_warned_about() {
    let path = r#""column": 0, "path": [{ "time_s": 0.1, "offset_m": [0, 0, 0.1] }]"#;
    let said = said_of_a_rise(&SCENE.replace(r#""column": 0"#, path));
    assert!(!said.contains("energy"), "{said}");
}

#[test]
fn energy_that_a_method_gains_beside_a_led_pin_is_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    let text_of = drape_model::bundled::text("hanging-textile-1e6").unwrap();
    let mut scene: serde_json::Value = serde_json::from_str(text_of).unwrap();
    scene["pins"][0]["path"] = serde_json::json!([{ "time_s": 1.0, "offset_m": [0, 0, 0] }]);
    std::fs::write(folder.path().join("led.json"), scene.to_string()).unwrap();
    let said = |method: &str| {
        let run = ["run", "led.json", "--dt", "0.01", "--duration", "0.3", "--method", method];
        let output = drape(folder.path(), &run);
        assert_eq!(code(&output), 0, "{method}");
        text(&output.stderr)
    };
    let gained = said("imex-updated:paper,forcing_term=0.1");
    let beside = "above its start and the work of pins, obstacles and wind";
    assert!(gained.contains("warning: the total energy rose by"), "{gained}");
    assert!(gained.contains(beside), "{gained}");
    assert!(!said("imex-euler").contains("energy"), "{}", said("imex-euler"));
}

#[test]
fn an_obstacle_that_passes_the_cloth_in_one_step_is_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    let said = |speed: u32| {
        // From 2 m below the cloth to 8 m above it.
        let end = 10.0 / f64::from(speed);
        let path =
            format!(r#""radius_m": 0.5, "path": [{{ "time_s": {end}, "offset_m": [0, 0, 10] }}]"#);
        let scene = SCENE.replace(r#""radius_m": 0.5"#, &path);
        std::fs::write(folder.path().join("sheet.json"), scene).unwrap();
        let output = drape(folder.path(), &["run", "sheet.json", "--method", "imex-euler"]);
        text(&output.stderr)
    };
    let fast = said(1000);
    assert!(fast.contains("warning: in the step to t = 0.0100 s particle"), "{fast}");
    assert!(fast.contains("obstacles[0] (a sphere) moved 1.000e1 m past each other"), "{fast}");
    assert!(fast.contains("1.000e0 m thick"), "{fast}");
    assert!(fast.contains("take steps of at most 5.0e-4 s"), "{fast}");
    assert!(!said(50).contains("past each other"), "{}", said(50));
}

#[test]
fn a_small_piece_in_free_fall_does_not_diverge() {
    let folder = tempfile::tempdir().unwrap();
    let scene = r#"{ "format": "drape-scene/1", "name": "piece", "cloth": { "grid": { "rows": 3,
        "columns": 3, "size_m": [0.005, 0.005], "center_m": [0, 0, 0], "mass_kg": 1e-5 } },
        "effects": { "tension": { "stiffness_over_mass_per_s2": 1e4 },
            "gravity": { "m_s2": [0, 0, -9.81] } },
        "time": { "step_s": 0.01, "duration_s": 3 } }"#;
    std::fs::write(folder.path().join("piece.json"), scene).unwrap();
    let output = drape(folder.path(), &["run", "piece.json", "--method", "imex-euler"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
}

#[test]
fn steps_whose_solver_stopped_early_are_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sheet.json"), SCENE).unwrap();
    let warned = |method: &str| {
        let output = drape(folder.path(), &["run", "sheet.json", "--method", method]);
        assert_eq!(code(&output), 0, "{method}");
        text(&output.stderr).contains("of 10 steps the solver stopped before its tolerance")
    };
    assert!(warned("backward-euler:max_iterations=1"));
    assert!(!warned("backward-euler"));
}

#[test]
fn a_reader_that_closes_the_pipe_early_is_no_failure() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    let command = command.args(["system", "hanging-textile-1e4"]).stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

/// A message that nobody can read changes neither the work nor the exit code.
#[test]
fn a_standard_error_that_cannot_be_written_does_not_change_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sheet.json"), SCENE).unwrap();
    let run = ["run", "sheet.json", "--method", "imex-euler", "--out", "run.json"];
    let long = ["run", "hanging-textile-1e6", "--method", "explicit-euler", "--dt", "0.01"];
    let only = ["reproduce", "--quick", "--only", "tables", "--out", "out"];
    let cases: [(&[&str], i32); 5] = [
        (&run, 0),
        (&only, 0),
        (&["run", "nothing.json", "--method", "imex-euler"], 2),
        (&["frobnicate"], 2),
        (&long, 3),
    ];
    let command = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
        command.current_dir(folder.path()).args(arguments).stdout(Stdio::null());
        command
    };
    for (arguments, expected) in cases {
        // The reader leaves before the first message.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let status = command(arguments).stderr(writer).status().unwrap();
        assert_eq!(status.code(), Some(expected), "{arguments:?} into a closed pipe");
        if let Ok(full) = std::fs::File::options().write(true).open("/dev/full") {
            let status = command(arguments).stderr(full).status().unwrap();
            assert_eq!(status.code(), Some(expected), "{arguments:?} onto a full disk");
        }
    }
    assert!(
        folder.path().join("out/report.html").is_file() && folder.path().join("run.json").is_file()
    );
}

/// What stands in a folder: names, kinds and contents.
fn listing(folder: &Path) -> Vec<(String, bool, Option<Vec<u8>>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let (name, path) = entry.map(|e| (e.file_name(), e.path())).unwrap();
            let content = path.is_file().then(|| std::fs::read(&path).unwrap());
            (name.into_string().unwrap(), path.is_symlink(), content)
        })
        .collect();
    files.sort();
    files
}

/// A run, a picture and an animation; the place of the result is the last word.
const OUTPUTS: [&[&str]; 3] = [
    &["run", "sheet.json", "--method", "imex-euler", "--out"],
    &["picture", "sheet.json", "--out"],
    &["run", "sheet.json", "--method", "imex-euler", "--animation"],
];

#[cfg(unix)]
#[test]
fn an_output_that_is_no_regular_file_or_an_input_is_refused_before_the_run() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("sheet.json"), SCENE).unwrap();
    for (name, original) in [("scene", "sheet.json"), ("pipe", "a-pipe"), ("in-circles", "")] {
        for extension in ["png", "glb", "json"] {
            let link = at(&format!("{name}.{extension}"));
            let own = link.file_name().unwrap().to_owned();
            let original = if original.is_empty() { own } else { original.into() };
            symlink(original, link).unwrap();
        }
    }
    assert!(Command::new("mkfifo").arg(at("a-pipe")).status().unwrap().success());
    for extension in ["png", "glb", "json"] {
        std::fs::create_dir(at(&format!("folder.{extension}"))).unwrap();
        std::fs::hard_link(at("sheet.json"), at(&format!("hard.{extension}"))).unwrap();
    }
    let before = listing(folder.path());
    for (output, extension) in OUTPUTS.into_iter().zip(["json", "png", "glb"]) {
        for (name, reason) in [
            ("scene", "another file than the input `sheet.json`"),
            ("hard", "another file than the input `sheet.json`"),
            ("pipe", "no regular file"),
            ("in-circles", "links"),
            ("folder", "it is a folder"),
            ("sheet.json/x", "expected a file that can be written"),
            ("nowhere/..", "that can be written"),
        ] {
            let file = format!("{name}.{extension}");
            let file = if name.ends_with("..") { name } else { &file };
            let refused = drape(folder.path(), &[output, &[file]].concat());
            let said = text(&refused.stderr);
            if name.ends_with("..") && extension != "json" {
                assert_eq!(code(&refused), 2, "{said}"); // it does not end in .png
                continue;
            }
            assert_eq!(code(&refused), 2, "{file}: {said}");
            assert!(
                said.contains(reason) && said.contains(output.last().unwrap()),
                "{file}: {said}"
            );
            assert_eq!(said.trim_end().lines().count(), 1, "{said}");
            assert!(refused.stdout.is_empty(), "it ran: {file}");
        }
    }
    assert_eq!(listing(folder.path()), before);
}

#[test]
fn a_mesh_is_not_overwritten_by_the_run_that_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    std::fs::write(folder.path().join("square.obj"), mesh).unwrap();
    let cloth = r#""mesh": { "file": "square.obj", "areal_density_kg_m2": 0.1 } },"#;
    let (before, rest) = SCENE.split_once(r#""grid""#).unwrap();
    let (_, rest) = rest.split_once("} },").unwrap();
    let scene =
        format!("{before}{cloth}{rest}").replace(r#""row": 0, "column": 0"#, r#""particle": 0"#);
    std::fs::write(folder.path().join("sheet.json"), scene).unwrap();
    let run = ["run", "sheet.json", "--method", "imex-euler", "--out"];
    let refused = drape(folder.path(), &[&run[..], &["./square.obj"]].concat());
    assert_eq!(code(&refused), 2, "{}", text(&refused.stderr));
    assert!(text(&refused.stderr).contains("another file than the input `square.obj`"));
    assert_eq!(std::fs::read_to_string(folder.path().join("square.obj")).unwrap(), mesh);
    let written = drape(folder.path(), &[&run[..], &["run.json"]].concat());
    assert_eq!(code(&written), 0, "{}", text(&written.stderr));
}

#[cfg(unix)]
#[test]
fn an_output_is_written_through_links_and_into_pipes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("sheet.json"), SCENE).unwrap();
    std::fs::create_dir(at("far")).unwrap();
    // The second link is relative to its own folder, and leads to a file that is not there yet.
    std::os::unix::fs::symlink("far/link.json", at("near.json")).unwrap();
    std::os::unix::fs::symlink("run.json", at("far/link.json")).unwrap();
    let run = |out: &str| drape(folder.path(), &[OUTPUTS[0], &[out]].concat());
    for _ in 0..2 {
        let output = run("near.json");
        assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    }
    assert!(at("near.json").is_symlink() && at("far/link.json").is_symlink());
    let state = |bytes: &[u8]| serde_json::from_slice::<Run>(bytes).unwrap().final_state;
    let expected = state(&std::fs::read(at("far/run.json")).unwrap());
    for out in ["-", "/dev/stdout", "/dev/fd/1"] {
        let output = run(out);
        assert_eq!(code(&output), 0, "{}", text(&output.stderr));
        assert!(state(&output.stdout) == expected, "{out}: the record alone");
        assert!(text(&output.stderr).contains("total energy"), "{out}: and the summary beside it");
    }
    // A pipe that the shell made.
    let shell = r#""$0" run sheet.json --method imex-euler --out /dev/fd/3 3>&1 >/dev/null | cat"#;
    let piped = Command::new("sh")
        .args(["-c", shell, env!("CARGO_BIN_EXE_drape")])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(state(&piped.stdout) == expected, "{}", text(&piped.stderr));
    let picture = drape(folder.path(), &[OUTPUTS[1], &["-"]].concat());
    assert!(code(&picture) == 0 && picture.stdout.starts_with(b"\x89PNG"));
    let two = drape(folder.path(), &[OUTPUTS[1], &["-", "--time", "0", "--time", "0.1"]].concat());
    assert!(code(&two) == 2 && text(&two.stderr).contains("2 pictures need a file each"));
    let both = drape(folder.path(), &[OUTPUTS[0], &["-", "--animation", "-"]].concat());
    assert!(code(&both) == 2 && text(&both.stderr).contains("another file than --out"));
    let same = [OUTPUTS[0], &["x.glb", "--animation", "./x.glb"]].concat();
    assert!(code(&drape(folder.path(), &same)) == 2);
    assert!(!at("-").exists() && !at("x.glb").exists());
}

/// A reader that closes the pipe early does not hide how the run ended.
#[test]
fn a_record_that_nobody_reads_does_not_hide_a_divergence() {
    let arguments = ["run", "hanging-textile-1e6", "--method", "explicit-euler", "--dt", "0.01"];
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    let command = command.args(arguments).args(["--out", "-"]).stdout(writer);
    assert_eq!(code(&command.output().unwrap()), 3);
}

#[test]
fn results_that_cannot_be_written_are_refused_before_the_work_with_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "mine").unwrap();
    for command in [&["reproduce", "--quick", "--out"][..], &["experiment", "tables", "--out"]] {
        for out in ["file", "file/below"] {
            let output = drape(folder.path(), &[command, &[out]].concat());
            let said = text(&output.stderr);
            assert_eq!(code(&output), 2, "{out}: {said}");
            assert!(said.contains("`--out`") && said.contains("a folder that can be written"));
            assert_eq!(said.trim_end().lines().count(), 1, "{said}");
        }
    }
    assert_eq!(listing(folder.path()).len(), 1);
}

#[test]
fn a_matrix_that_cannot_be_set_up_is_told_with_file_and_keys() {
    let folder = tempfile::tempdir().unwrap();
    // Nothing holds the pair, and beside the stiffness its mass is round-off.
    let pair = SYSTEM.replace("[1, 1]", "[1e-12, 1e-12]").replace(": 10 }", ": 1e10 }");
    let pair = pair.replace(r#"{ "particle": 0 }"#, "");
    std::fs::write(folder.path().join("pair.json"), pair).unwrap();
    let time = ["--dt", "1", "--duration", "2"];
    for command in ["run", "picture"] {
        let arguments = [&[command, "pair.json", "--method", "desbrun"], &time[..]].concat();
        let output = drape(folder.path(), &arguments);
        let said = text(&output.stderr);
        assert_eq!(code(&output), 2, "{said}");
        assert!(said.starts_with("drape: pair.json: with its masses and stiffnesses"), "{said}");
        assert!(said.contains("`time.step_s` or --dt") && said.contains("row 1"), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
}

/// Names come from files, and files from anywhere.
#[test]
fn names_reach_the_terminal_without_its_commands() {
    let folder = tempfile::tempdir().unwrap();
    let named = SCENE.replace(r#""sheet""#, r#""\u001b]0;owned\u0007\u001b[31mred\nfree 0 J""#);
    std::fs::write(folder.path().join("named.json"), named).unwrap();
    let run = drape(folder.path(), &["run", "named.json", "--method", "imex-euler"]);
    let said = text(&run.stdout);
    assert_eq!(code(&run), 0, "{said}");
    assert!(
        said.starts_with(r"\u{1b}]0;owned\u{7}\u{1b}[31mred\nfree 0 J with imex-euler"),
        "{said}"
    );
    // Run, counts, energy, verdict.
    assert_eq!(said.lines().count(), 4, "{said}");
    let piped = ["run", "named.json", "--method", "imex-euler", "--out", "-"];
    assert!(!text(&drape(folder.path(), &piped).stderr).contains('\u{1b}'));
    let absent = drape(folder.path(), &["run", "\u{1b}[2Ja\nb.json", "--method", "imex-euler"]);
    let said = text(&absent.stderr);
    assert!(code(&absent) == 2 && said.contains(r"`\u{1b}[2Ja\nb.json`"), "{said}");
    assert!(said.ends_with('\n') && !said.trim_end().contains(char::is_control), "{said}");
}

#[test]
fn a_record_that_is_no_text_is_refused_with_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tables.json"), b"{\"format\": \"\xff\xfe\"}").unwrap();
    let output = drape(folder.path(), &["report", "."]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 2, "{said}");
    assert!(said.contains("tables.json: not a record") && said.contains("drape experiment"));
}

/// Runs with so little address space that the stacks of many threads do not fit. The stacks are so
/// large that the space left when one is refused always suffices for the message.
#[cfg(target_os = "linux")]
fn drape_in_little_space(folder: &Path, arguments: &[&str]) -> Output {
    Command::new("sh")
        .args(["-c", r#"ulimit -v 1500000; exec "$0" "$@""#, env!("CARGO_BIN_EXE_drape")])
        .args(arguments)
        .current_dir(folder)
        .env("RAYON_NUM_THREADS", "1024")
        .env("RUST_MIN_STACK", "500000000")
        .output()
        .unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_the_system_refuses_are_told_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let sheet = SCENE.replace(r#""rows": 3, "columns": 3"#, r#""rows": 131, "columns": 137"#);
    std::fs::write(folder.path().join("sheet.json"), sheet).unwrap();
    let run = ["run", "sheet.json", "--method", "imex-euler", "--threads", "1024"];
    let study = ["experiment", "tables", "--quick", "--out", "out"];
    let cases: [(&[&str], &str); 3] = [
        (&run, "`--threads` is 1024; expected fewer threads"),
        (&study, "set the variable RAYON_NUM_THREADS to a smaller number"),
        (&["claim", "C08"], "set the variable RAYON_NUM_THREADS to a smaller number"),
    ];
    for (arguments, told) in cases {
        let output = drape_in_little_space(folder.path(), arguments);
        let said = text(&output.stderr);
        assert_eq!(code(&output), 2, "{arguments:?}: {said}");
        assert!(said.contains(told), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
}

/// Ends a run that waits or reads without end, and lets it take 2 GB of addresses at most.
#[cfg(target_os = "linux")]
fn drape_within_bounds(folder: &Path, arguments: &[&str]) -> Output {
    Command::new("sh")
        .args(["-c", r#"ulimit -v 2000000; exec timeout 60 "$0" "$@""#])
        .arg(env!("CARGO_BIN_EXE_drape"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn an_input_that_is_no_regular_file_is_refused_and_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    for pipe in ["pipe", "tables.json"] {
        let made = Command::new("mkfifo").arg(folder.path().join(pipe)).status().unwrap();
        assert!(made.success());
    }
    let sparse = std::fs::File::create(folder.path().join("long.json")).unwrap();
    sparse.set_len((4 << 30) + 1).unwrap();
    for (scene, found) in
        [("pipe", "no regular file"), ("/dev/zero", "no regular file"), (".", "no regular file")]
            .into_iter()
            .chain([("long.json", "4294967297 bytes long")])
    {
        for command in [&["system"][..], &["run", "--method", "imex-euler"], &["picture"]] {
            let output = drape_within_bounds(folder.path(), &[command, &[scene]].concat());
            let said = text(&output.stderr);
            assert_eq!(code(&output), 2, "{scene}: {said}");
            assert!(said.starts_with(&format!("drape: {scene}: ")), "{said}");
            assert!(said.contains(found) && said.contains("at most 4 GiB"), "{said}");
            assert_eq!(said.trim_end().lines().count(), 1, "{said}");
        }
    }
    let report = drape_within_bounds(folder.path(), &["report", "."]);
    let said = text(&report.stderr);
    assert_eq!(code(&report), 2, "{said}");
    assert!(said.contains("tables.json: no regular file; expected"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn memory_is_estimated_before_it_is_taken_and_refused_above_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    let grid = |side: u32| {
        let shear = r#""shear": { "stiffness_over_mass_per_s2": 1e3 }, "gravity""#;
        SCENE
            .replace(r#""rows": 3, "columns": 3"#, &format!(r#""rows": {side}, "columns": {side}"#))
            .replace(r#""gravity""#, shear)
            .replace(r#""duration_s": 0.1"#, r#""duration_s": 0.01"#)
    };
    for (name, side) in [("huge.json", 2000), ("large.json", 150)] {
        std::fs::write(folder.path().join(name), grid(side)).unwrap();
    }
    let limited = |arguments: &[&str], scene: &str, limit: &str| {
        let more = [scene, "--max-memory", limit];
        let output = drape_within_bounds(folder.path(), &[arguments, &more].concat());
        (code(&output), text(&output.stderr))
    };
    let run = |method| ["run", "--method", method];
    // The address space would not hold it.
    for command in [&["system"][..], &run("imex-euler"), &["picture"]] {
        let (code, said) = limited(command, "huge.json", "1500");
        assert_eq!(code, 2, "{said}");
        let named = ["huge.json", "`--max-memory` is 1500 MiB", "4000000 particles, 16000000"];
        assert!(named.iter().all(|part| said.contains(part)), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
    // The text itself is counted before it is read.
    let (refused, said) = limited(&["system"], "long.json", "100");
    assert!(refused == 2 && said.contains("no scene"), "{said}");
    let sparse = std::fs::File::create(folder.path().join("long.json")).unwrap();
    sparse.set_len(1 << 30).unwrap();
    let (refused, said) = limited(&["system"], "long.json", "100");
    assert!(refused == 2 && said.contains("the estimate for 1073741824 bytes of text"), "{said}");
    // A method that factors its matrix takes many times as much.
    let (refused, said) = limited(&run("backward-euler:solver=cholesky"), "large.json", "150");
    assert!(refused == 2 && said.contains("springs with backward-euler"), "{said}");
    let (done, said) = limited(&run("imex-euler"), "large.json", "150");
    assert!(done == 0 && said.contains("large.json: 22500 particles"), "{said}");
    let (done, said) = limited(&run("backward-euler:solver=cholesky"), "large.json", "1000");
    assert!(done == 0 && said.contains("floating-point operations"), "{said}");
    let small = drape(folder.path(), &["run", "hanging-textile-1e4", "--method", "imex-euler"]);
    assert!(!text(&small.stderr).contains("memory"), "a small run tells no estimate");
}

#[test]
fn a_step_that_needs_too_many_substeps_is_refused_and_the_cap_named() {
    let folder = tempfile::tempdir().unwrap();
    let stiff = SCENE.replace("1e3", "1e18");
    std::fs::write(folder.path().join("stiff.json"), stiff).unwrap();
    for method in ["leapfrog:step=auto", "leapfrog:step=bound"] {
        for command in ["run", "picture"] {
            let output = drape(folder.path(), &[command, "stiff.json", "--method", method]);
            let said = text(&output.stderr);
            let said = said.trim_end().lines().last().unwrap();
            assert_eq!(code(&output), 2, "{said}");
            assert!(said.starts_with("drape: stiff.json: ") && said.contains("--dt"), "{said}");
            assert!(said.contains("at most 100000 are taken"), "{said}");
        }
    }
}

/// Writes a frozen sheet, and the same with its particles in disorder. Returns the new index of
/// each particle.
fn sheet_and_shuffled(folder: &Path) -> Vec<usize> {
    let scene = SCENE
        .replace(r#""rows": 3, "columns": 3"#, r#""rows": 40, "columns": 30"#)
        .replace("0.9 }", "0.9, \"velocity_m_s\": [0.1, 0.2, 0] }");
    std::fs::write(folder.join("scene.json"), scene).unwrap();
    let natural: SystemSpec = drape_model::load(folder.join("scene.json").to_str().unwrap())
        .map(|input| input.spec().clone())
        .unwrap();
    let n = natural.particles.mass_kg.len();
    // 787 and 1200 have no common factor.
    let new: Vec<usize> = (0..n).map(|i| i * 787 % n).collect();
    let mut shuffled = natural.clone();
    for (i, &k) in new.iter().enumerate() {
        shuffled.particles.position_m[k] = natural.particles.position_m[i];
        shuffled.particles.velocity_m_s[k] = natural.particles.velocity_m_s[i];
    }
    let place = |i: &mut u32| *i = new[*i as usize] as u32;
    for spring in &mut shuffled.springs {
        place(&mut spring.i);
        place(&mut spring.j);
    }
    shuffled.pins.iter_mut().for_each(|pin| place(&mut pin.particle));
    shuffled.triangles.iter_mut().flatten().for_each(place);
    for (name, spec) in [("natural.json", &natural), ("shuffled.json", &shuffled)] {
        std::fs::write(folder.join(name), serde_json::to_string(spec).unwrap()).unwrap();
    }
    new
}

#[test]
fn a_frozen_system_in_disorder_is_recorded_in_its_own_order() {
    let folder = tempfile::tempdir().unwrap();
    let new = sheet_and_shuffled(folder.path());
    let run = |input: &str| -> Run {
        let arguments = [
            "run",
            input,
            "--method",
            "imex-euler:forcing_term=1e-14",
            "--dt",
            "0.01",
            "--duration",
            "0.1",
            "--out",
            "run.json",
        ];
        let output = drape(folder.path(), &arguments);
        assert_eq!(code(&output), 0, "{}", text(&output.stderr));
        drape_report::file::read_json(&folder.path().join("run.json")).unwrap()
    };
    let (natural, shuffled) = (run("natural.json"), run("shuffled.json"));
    let apart = |a: [f64; 3], b: [f64; 3]| {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    for (i, &k) in new.iter().enumerate() {
        let (a, b) = (&natural.final_state, &shuffled.final_state);
        assert!(apart(a.position_m[i], b.position_m[k]) < 1e-9, "particle {i}");
        assert!(apart(a.velocity_m_s[i], b.velocity_m_s[k]) < 1e-7, "particle {i}");
    }
    assert_ne!(natural.scene_hash, shuffled.scene_hash);
    for (a, b) in natural.series.iter().zip(&shuffled.series) {
        assert!((a.energy_j["total"] - b.energy_j["total"]).abs() < 1e-9);
    }
}

/// The warnings of a run with a sheet `height` m above a plane.
fn warnings_of_a_sheet_on_a_plane(height: f64) -> String {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!(
        r#"{{ "format": "drape-scene/1", "name": "rest", "cloth": {{ "grid": {{ "rows": 9,
            "columns": 7, "size_m": [1, 0.7],
        "center_m": [0.1, 0.3, {height}], "mass_kg": 0.064 }} }}, "effects": {{
        "tension": {{ "stiffness_over_mass_per_s2": 1e6 }},
            "gravity": {{ "m_s2": [0, 0, -9.81] }} }},
        "obstacles": [{{ "plane": {{ "point_m": [0, 0, 0.7], "normal": [0.28, 0, 0.96] }} }}],
        "time": {{ "step_s": 0.01, "duration_s": 0.2 }} }}"#
    );
    std::fs::write(folder.path().join("rest.json"), scene).unwrap();
    let output = drape(folder.path(), &["run", "rest.json", "--method", "imex-euler"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    text(&output.stderr).to_owned()
}

#[test]
fn a_cloth_that_starts_inside_an_obstacle_is_named_as_a_cause_of_energy() {
    let warnings = warnings_of_a_sheet_on_a_plane(0.5);
    assert!(warnings.contains("63 particles start inside an obstacle"), "{warnings}");
    assert!(!warnings_of_a_sheet_on_a_plane(1.5).contains("warning"));
}

/// Far from the origin round-off moves a sheet at rest, and all of that motion raises the energy.
#[test]
fn a_sheet_at_rest_is_not_warned_about_for_its_round_off() {
    let scene = r#"{ "format": "drape-scene/1", "name": "rest", "cloth": { "grid": { "rows": 9,
        "columns": 7,
        "size_m": [1, 0.7], "center_m": [100.123, 37.3, 0.7], "mass_kg": 0.064 } }, "effects": {
        "tension": { "stiffness_over_mass_per_s2": 1e6 } }, "time": { "step_s": 0.01,
            "duration_s": 0.2 } }"#;
    let said = said_of_a_rise(scene);
    assert!(!said.contains("warning"), "{said}");
}

#[test]
fn an_animation_under_another_name_than_glb_is_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["x.gltf", "x"] {
        let run = ["run", "hanging-textile-1e4", "--method", "imex-euler", "--animation", file];
        let output = drape(folder.path(), &run);
        assert_eq!(code(&output), 2);
        let said = text(&output.stderr);
        assert!(
            said.contains(file) && said.contains(".glb") && said.contains("--animation"),
            "{said}"
        );
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "it writes no file");
}

#[test]
fn a_step_too_long_for_a_speed_that_comes_later_is_told_then() {
    let folder = tempfile::tempdir().unwrap();
    let scene = r#"{ "format": "drape-scene/1", "name": "fall", "cloth": { "grid": { "rows": 5,
        "columns": 5, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 0.025 } }, "effects": {
        "tension": { "stiffness_over_mass_per_s2": 1e4 }, "gravity": { "m_s2": [0, 0, -9.81] },
        "air": { "drag": { "quadratic": { "coefficient": 1.2 } } } }, "time": { "step_s": 0.01,
            "duration_s": 1 } }"#;
    std::fs::write(folder.path().join("fall.json"), scene).unwrap();
    let warnings = |step: &str| {
        let run = ["run", "fall.json", "--method", "imex-euler", "--dt", step];
        text(&drape(folder.path(), &run).stderr).to_owned()
    };
    let long = warnings("0.08");
    assert!(long.contains("the drag of the air") && long.contains("fastest"), "{long}");
    assert!(!warnings("0.01").contains("warning"));
    let diverged = warnings("0.1");
    assert!(diverged.contains("diverged at step"), "{diverged}");
    let told =
        diverged.lines().find(|line| line.contains("the drag of the air")).unwrap_or_default();
    assert!(told.contains("fastest before it diverges"), "{diverged}");
    let times: f64 =
        told.rsplit(" is ").next().unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((1.0..10.0).contains(&times), "the speeds of the blow-up are left out: {told}");
}

#[test]
fn masses_that_differ_by_more_than_was_tested_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for (masses, is_warned) in
        [("[1e-5, 1e14, 1e-5]", false), ("[1e-30, 1, 1e14]", false), ("[1e-30, 1e-8, 1e-5]", true)]
    {
        let system = format!(
            r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": {masses},
            "position_m": [[0, 0, 0], [1, 0, 0], [2, 0, 0]] }}, "springs": [],
            "pins": [ {{ "particle": {} }} ] }}"#,
            if is_warned { 1 } else { 0 }
        );
        std::fs::write(folder.path().join("uneven.json"), system).unwrap();
        let arguments =
            ["run", "uneven.json", "--method", "imex-euler", "--dt", "0.01", "--duration", "0.02"];
        let output = drape(folder.path(), &arguments);
        let told = text(&output.stderr);
        assert_eq!(code(&output), 0, "{told}");
        let named = ["particles.mass_kg[2]", "particles.mass_kg[0]", "1e20"];
        assert_eq!(named.iter().all(|name| told.contains(name)), is_warned, "{masses}: {told}");
    }
}
