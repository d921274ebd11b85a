//! What the command answers to a user's own scene: verdicts, inspections, tables.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_harness::record::{Judged, Judgement, Run};
use std::path::Path;
use std::process::{Command, Output};

fn drape(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_drape")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Runs a scene; returns the verdict of the record, its line and the messages.
fn verdict(scene: &str, more: &[&str]) -> (Judgement, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [&["run", scene, "--out", "run.json"], more].concat();
    let output = drape(folder.path(), &arguments);
    let said = text(&output.stderr);
    let printed = text(&output.stdout);
    let line = printed.lines().last().unwrap_or_default().to_owned();
    let run: Run = drape_report::file::read_json(&folder.path().join("run.json")).unwrap();
    assert!(line.starts_with(&format!("verdict: {}: ", run.verdict.kind)), "{printed}{said}");
    assert_eq!(line.matches('\n').count(), 0);
    (run.verdict, line, said)
}

/// On a sheet of the hard cases one particle is a million times as heavy, and the paper's stop test
/// sees it alone. The step is not the cause.
#[test]
fn a_stop_test_that_one_heavy_particle_blinds_is_named_as_the_cause() {
    let scene = "hard-cases/H21 one mass × 1e6";
    let with = |method| verdict(scene, &["--method", method, "--dt", "0.01", "--duration", "2"]);
    let (blind, line, said) = with("imex-euler:norm=euclid");
    assert_eq!(blind.kind, Judged::GainedEnergy, "{line}{said}");
    for words in ["1.0·10⁶ times the mass of the lightest", "norm=euclid", "take norm=velocity"]
    {
        assert!(line.contains(words), "{words}: {line}");
    }
    let (sound, line, _) = with("imex-euler");
    assert_eq!(sound.kind, Judged::Stable, "{line}");
}

#[test]
fn a_cloth_that_locks_is_told_before_and_after_the_run() {
    for scene in ["hanging-textile-1e6", "hanging-wool"] {
        let (verdict, line, said) = verdict(scene, &["--method", "imex-euler", "--dt", "0.01"]);
        assert_eq!(verdict.kind, Judged::Locked, "{line}");
        assert!(verdict.share.unwrap() < 0.35 && verdict.expected_share.unwrap() < 0.5, "{line}");
        assert!(said.contains("warning: the cloth will lock: with h²k/m = "), "{said}");
        assert!(said.contains("such as imex-updated"), "{said}");
        assert!(said.contains("take steps of at most "), "{said}");
    }
}

#[test]
fn a_cloth_that_moves_is_stable() {
    for (scene, more) in [
        ("hanging-textile-1e6", &["--method", "imex-updated", "--dt", "0.01"][..]),
        ("hanging-textile-1e4", &["--method", "backward-euler", "--dt", "0.01"]),
        ("hanging-wool", &["--method", "imex-updated", "--dt", "0.01"]),
        ("hanging-textile-1e4", &["--method", "symplectic-euler", "--dt", "1e-3"]),
    ] {
        let (verdict, line, said) = verdict(scene, more);
        assert_eq!(verdict.kind, Judged::Stable, "{line}");
        assert!(verdict.share.unwrap() > 0.75, "{line}");
        assert!(!said.contains("will lock"), "{said}");
    }
}

/// A flag in gusts, on which wind does work all the time: a run that is held back is locked, or says
/// what stands against it, and is never plainly stable.
#[test]
fn a_flag_that_is_held_back_in_the_wind_is_not_stable() {
    let by_scene: &[&str] = &[];
    for more in [by_scene, &["--dt", "0.01"], &["--dt", "0.01", "--duration", "1"]] {
        for method in ["imex-euler", "desbrun"] {
            let (held, line, _) = verdict("flag", &[&["--method", method], more].concat());
            assert!(matches!(held.kind, Judged::Locked | Judged::Unknown), "{line}");
            assert!(line.contains("it moved ") && line.contains("theory expects "), "{line}");
            assert!(held.share.unwrap() < 0.75 && held.expected_share.unwrap() < 0.75, "{line}");
        }
    }
    let (_, line, said) = verdict("flag", &["--method", "imex-euler", "--dt", "0.01"]);
    assert!(line.starts_with("verdict: locked: "), "{line}");
    assert!(said.contains("the cloth will lock"), "{said}");
    for (method, step) in [("imex-updated", "0.01"), ("xpbd", "0.01"), ("leapfrog", "5e-4")] {
        let more = ["--method", method, "--dt", step, "--duration", "0.5"];
        let (moving, line, said) = verdict("flag", &more);
        assert!(matches!(moving.kind, Judged::Stable | Judged::Unknown), "{line}");
        assert!(moving.share.unwrap() > 0.75 && !said.contains("will lock"), "{line}{said}");
    }
}

/// A free sheet that spins: nothing outside may take its angular momentum, so what is lost is the
/// method's doing.
#[test]
fn a_sheet_that_loses_its_spin_is_not_stable() {
    let (lost, line, _) = verdict("spinning-sheet", &["--method", "imex-euler"]);
    assert_eq!(lost.kind, Judged::Locked, "{line}");
    assert!(lost.spin_share.unwrap() < 0.1 && line.contains("it lost its spin: "), "{line}");
    let (kept, line, _) = verdict("spinning-sheet", &["--method", "leapfrog", "--dt", "1e-3"]);
    assert_eq!(kept.kind, Judged::Stable, "{line}");
    assert!((kept.spin_share.unwrap() - 1.0).abs() < 1e-6, "{line}");
    assert!(line.contains("100 % of its spin is left"), "{line}");
    let (pinned, line, _) =
        verdict("hanging-textile-1e4", &["--method", "leapfrog", "--dt", "1e-3"]);
    assert_eq!(pinned.spin_share, None, "{line}");
}

#[test]
fn runs_that_diverge_or_gain_energy_say_so() {
    let diverging = ["--method", "explicit-euler", "--dt", "0.01"];
    let (verdict_of, line, _) = verdict("hanging-textile-1e6", &diverging);
    assert_eq!((verdict_of.kind, verdict_of.share), (Judged::Diverged, None), "{line}");
    let gaining = "imex-updated:paper,implicit=springs,forcing_term=0.1";
    let gaining = ["--method", gaining, "--dt", "0.01", "--duration", "0.3"];
    let (verdict_of, line, said) = verdict("hanging-textile-1e6", &gaining);
    assert_eq!(verdict_of.kind, Judged::GainedEnergy, "{line}");
    assert!(said.contains("warning: the total energy rose by"), "{said}");
}

/// Nothing moves, or nothing holds the particles together: neither is locked.
#[test]
fn a_sheet_at_rest_and_particles_without_springs_are_not_called_locked() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.json");
    let sheet = drape_model::bundled::text("hanging-textile-1e6").unwrap();
    let mut scene: serde_json::Value = serde_json::from_str(sheet).unwrap();
    let run = |scene: &serde_json::Value| {
        std::fs::write(&file, scene.to_string()).unwrap();
        verdict(file.to_str().unwrap(), &["--method", "imex-euler", "--dt", "0.01"])
    };
    scene["effects"].as_object_mut().unwrap().remove("gravity");
    let (at_rest, line, said) = run(&scene);
    assert_eq!((at_rest.kind, at_rest.share), (Judged::Stable, None), "{line}");
    assert!(line.contains("in balance") && !said.contains("warning"), "{line}{said}");
    scene["effects"] = serde_json::json!({ "gravity": { "m_s2": [0, 0, -9.81] } });
    scene["pins"] = serde_json::json!([]);
    let (falling, line, said) = run(&scene);
    assert_eq!(falling.kind, Judged::Stable, "{line}");
    assert!((falling.share.unwrap() - 1.0).abs() < 0.15, "{line}");
    assert!(!said.contains("lock"), "{said}");
}

#[test]
fn an_inspection_fits_a_screen_and_is_the_same_in_json() {
    let folder = tempfile::tempdir().unwrap();
    let printed = drape(folder.path(), &["inspect", "hanging-textile-1e6"]);
    assert_eq!(printed.status.code(), Some(0), "{}", text(&printed.stderr));
    let printed = text(&printed.stdout);
    let (facts, table) = printed.split_once("\n\n").unwrap();
    assert!(facts.lines().count() <= 24, "{facts}");
    for part in ["400; pinned 2", "1.000e6", "0.4000 kg/m²", "ζ = ", "symplectic-euler "] {
        assert!(facts.contains(part), "{part} is missing: {facts}");
    }
    let row = |id: &str| table.lines().find(|line| line.starts_with(id)).unwrap().to_owned();
    assert!(row("imex-euler ").contains("locked, "), "{}", row("imex-euler "));
    assert!(row("explicit-euler ").contains("unstable"), "{}", row("explicit-euler "));
    let json = drape(folder.path(), &["inspect", "hanging-textile-1e6", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["format"], "drape-inspection/1");
    assert_eq!(json["particles"], 400);
    let methods = json["methods"].as_array().unwrap();
    let euler = methods.iter().find(|method| method["id"] == "imex-euler").unwrap();
    assert_eq!(euler["steps"][1]["verdict"], "locked");
}

#[test]
fn a_mesh_alone_is_inspected_and_its_unit_is_doubted() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "v 0 0 0\nv 55 0 0\nv 55 55 0\nv 0 55 0\nf 1 2 3\nf 1 3 4\n";
    std::fs::write(folder.path().join("skirt.obj"), mesh).unwrap();
    let output = drape(folder.path(), &["inspect", "skirt.obj"]);
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(printed.contains("assumed"), "{printed}");
    assert!(printed.contains("doubtful") && printed.contains("lengths are in m"), "{printed}");
    let missing = drape(folder.path(), &["inspect", "none.obj"]);
    assert_eq!(missing.status.code(), Some(2), "{}", text(&missing.stderr));
    assert_eq!(text(&missing.stderr).lines().count(), 1);
}

/// The fields of a line of RFC 4180.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            letter => fields.last_mut().unwrap().push(letter),
        }
    }
    fields
}

#[test]
fn records_are_exported_as_tables_that_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results");
    let results = results.to_str().unwrap();
    let export = ["export", results, "--out", "tables", "--only", "locking,claims"];
    let output = drape(folder.path(), &export);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let read = |name: &str| {
        let text = std::fs::read_to_string(folder.path().join("tables").join(name)).unwrap();
        text.lines().map(fields).collect::<Vec<_>>()
    };
    let locking = read("locking.csv");
    let dictionary = read("dictionary.csv");
    assert!(locking.iter().all(|row| row.len() == locking[0].len()));
    let column = |name: &str| locking[0].iter().position(|column| column == name).unwrap();
    let record: serde_json::Value =
        drape_report::file::read_json(&Path::new(results).join("locking.json")).unwrap();
    let runs = record["facts"]["runs"].as_array().unwrap();
    let told: Vec<f64> = runs.iter().filter_map(|run| run["retained"].as_f64()).collect();
    let is_retained = |row: &&Vec<String>| row[column("metric")] == "retained";
    let rows: Vec<_> = locking.iter().filter(is_retained).collect();
    let values: Vec<f64> = rows.iter().map(|row| row[column("value")].parse().unwrap()).collect();
    assert_eq!(values, told);
    assert!(rows.iter().any(|row| row[column("method")] == "imex-euler"
        && row[column("settings")].starts_with("forcing_term=")
        && row[column("verdict")] == "locked"));
    for row in &locking[1..] {
        let metric = &row[column("metric")];
        let is_time =
            metric.ends_with("_s") && !metric.ends_with("m_s") && !metric.ends_with("per_s");
        assert_eq!(row[column("unit")] == "s", is_time, "{row:?}");
    }
    assert!(dictionary.iter().any(|line| line[0] == "retained" && line[1] == "metric"));
    let again = drape(folder.path(), &export);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("--force"), "{}", text(&again.stderr));
    let forced = drape(folder.path(), &[&export[..], &["--force"]].concat());
    assert_eq!(forced.status.code(), Some(0));
}

#[test]
fn probes_write_series_that_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "hanging-textile-1e4", "--method", "backward-euler", "--duration", "0.2"];
    let probes = ["--probe", "399", "--probe", "stretch", "--probe", "pins", "--probe", "lowest"];
    let files = ["--probe", "energy", "--probe-out", "p.csv", "--out", "run.json"];
    let output = drape(folder.path(), &[&run[..], &probes, &files].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let record: Run = drape_report::file::read_json(&folder.path().join("run.json")).unwrap();
    let table = std::fs::read_to_string(folder.path().join("p.csv")).unwrap();
    let table: Vec<_> = table.lines().map(fields).collect();
    assert_eq!(table.len(), 22, "a header, the start and 20 steps");
    let last = |name: &str| {
        let column = table[0].iter().position(|column| column == name).unwrap();
        table.last().unwrap()[column].parse::<f64>().unwrap()
    };
    let end = &record.final_state.position_m;
    assert_eq!(last("time_s"), 0.2);
    assert_eq!(last("particle_399_z_m"), end[399][2]);
    assert_eq!(last("pins_z_m"), 0.0);
    assert_eq!(last("lowest_z_m"), end.iter().map(|x| x[2]).fold(f64::INFINITY, f64::min));
    let total = record.series.last().unwrap().energy_j["total"];
    assert!((last("energy_total_j") - total).abs() <= 1e-12 * (1.0 + total.abs()));
    assert!(last("stretch_greatest") > last("stretch_mean"));
    let json = [&run[..], &["--probe", "lowest", "--probe-out", "p.json"]].concat();
    assert_eq!(drape(folder.path(), &json).status.code(), Some(0));
    let json: serde_json::Value =
        drape_report::file::read_json(&folder.path().join("p.json")).unwrap();
    assert_eq!(json["rows"].as_array().unwrap().len(), 21);
    let series = [&run[..], &["--out", "series.csv"]].concat();
    assert_eq!(drape(folder.path(), &series).status.code(), Some(0));
    let series = std::fs::read_to_string(folder.path().join("series.csv")).unwrap();
    assert!(series.starts_with("time_s,energy_gravity_j,") && series.lines().count() == 22);
}

/// Two pieces, each with a particle inside its boundary.
#[test]
fn probes_follow_the_groups_and_boundaries_that_an_inspection_counts() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = String::new();
    for x in [0.0, 3.0] {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        for (dx, y) in corners {
            mesh += &format!("v {} {y} 0\n", x + dx);
        }
        mesh += &format!("v {} 0.5 0.1\n", x + 0.5);
    }
    for first in [1, 6] {
        for corner in 0..4 {
            let (a, b) = (first + corner, first + (corner + 1) % 4);
            mesh += &format!("f {a} {b} {}\n", first + 4);
        }
    }
    let scene = serde_json::json!({
        "format": "drape-scene/1", "name": "two", "description": "", "assumed": [],
        "cloth": { "mesh": { "file": "two.obj", "areal_density_kg_m2": 0.2 } },
        "effects": {
            "tension": { "stiffness_n_per_m": 50 },
            "gravity": { "m_s2": [0, 0, -9.81] }
        },
        "pins": [{ "near_m": [0, 0, 0] }],
        "time": { "step_s": 0.001, "duration_s": 0.2 }
    });
    std::fs::write(folder.path().join("two.obj"), mesh).unwrap();
    std::fs::write(folder.path().join("two.json"), scene.to_string()).unwrap();
    let inspected = drape(folder.path(), &["inspect", "two.json", "--json"]);
    let inspected: serde_json::Value = serde_json::from_slice(&inspected.stdout).unwrap();
    assert_eq!(inspected["groups"], 2);
    assert_eq!(inspected["boundaries"], 2);
    let run = ["run", "two.json", "--method", "leapfrog", "--out", "run.json"];
    let parts = ["group:0", "group:1", "boundary:0", "boundary:1"];
    let probes = parts.map(|part| ["--probe", part]).concat();
    let output = drape(folder.path(), &[&run[..], &probes[..], &["--probe-out", "p.csv"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let record: Run = drape_report::file::read_json(&folder.path().join("run.json")).unwrap();
    let table = std::fs::read_to_string(folder.path().join("p.csv")).unwrap();
    let table: Vec<_> = table.lines().map(fields).collect();
    assert_eq!(table[0].len(), 1 + 3 * parts.len());
    let end = &record.final_state.position_m;
    for (part, particles) in parts.iter().zip([0..5_usize, 5..10, 0..4, 5..9]) {
        for (axis, name) in ["x_m", "y_m", "z_m"].iter().enumerate() {
            let name = format!("{}_{name}", part.replace(':', "_"));
            let column = table[0].iter().position(|column| *column == name).unwrap();
            let told: f64 = table.last().unwrap()[column].parse().unwrap();
            let sum: f64 = particles.clone().map(|i| end[i][axis]).sum();
            let mean = sum / particles.len() as f64;
            assert!((told - mean).abs() < 1e-12, "{name}: {told} {mean}");
        }
    }
    for (part, said) in [
        ("group:2", "group:N with N from 0 to 1: of this kind the scene has 2"),
        ("boundary:2", "boundary:N with N from 0 to 1: of this kind the scene has 2"),
    ] {
        let probe = ["--probe", part, "--probe-out", "q.csv"];
        let output = drape(folder.path(), &[&run[..], &probe].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(said), "{message}");
    }
}

/// The heights of the free edge's midpoint in the record of `course` come from a user's own run,
/// for methods whose bits are the same on every machine.
#[test]
fn a_probe_redraws_the_heights_that_the_course_records() {
    let folder = tempfile::tempdir().unwrap();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results/course.json");
    let record: serde_json::Value = drape_report::file::read_json(&file).unwrap();
    let rows = |value: &serde_json::Value| value.as_array().unwrap().clone();
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        rows(value).iter().map(|number| number.as_f64().unwrap()).collect()
    };
    let (scenes, lessons) = (rows(&record["facts"]["scenes"]), rows(&record["facts"]["lessons"]));
    for (id, name) in [
        ("imex-euler", "hanging-textile-sheared-1e4"),
        ("imex-euler", "hanging-textile-sheared-1e6"),
        ("leapfrog", "hanging-textile-sheared-1e4"),
    ] {
        let scene = scenes.iter().find(|scene| scene["id"] == name).unwrap();
        let lesson = lessons.iter().find(|lesson| lesson["id"] == id).unwrap();
        let runs = rows(&lesson["runs"]);
        let recorded = runs.iter().find(|run| run["scene"] == name).unwrap();
        assert_eq!(recorded["portable"], true);
        let sheet = drape_harness::bundled(name).unwrap();
        let middle = drape_harness::free_edge_midpoint(&sheet).unwrap().to_string();
        let time = ["step_s", "duration_s"].map(|key| scene[key].to_string());
        let (start, method) = (format!("course/{name}"), lesson["method"].as_str().unwrap());
        let run = ["run", &start, "--method", method, "--dt", &time[0], "--duration", &time[1]];
        let probe = ["--probe", &middle, "--probe-out", "p.csv"];
        let output = drape(folder.path(), &[&run[..], &probe].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let table = std::fs::read_to_string(folder.path().join("p.csv")).unwrap();
        let table: Vec<_> = table.lines().map(fields).collect();
        let height = format!("particle_{middle}_z_m");
        let height = table[0].iter().position(|column| *column == height).unwrap();
        let rows: Vec<[f64; 2]> =
            table[1..].iter().map(|row| [0, height].map(|i| row[i].parse().unwrap())).collect();
        let (times, heights) = (numbers(&scene["time_s"]), numbers(&recorded["height_m"]));
        assert_eq!((times.len(), heights.len()), (41, 41));
        for (time, height) in times.iter().zip(heights) {
            let row = rows.iter().find(|row| (row[0] - time).abs() < 1e-9).unwrap();
            assert!((row[1] - height).abs() < 1e-9, "{id} at {time} s: {} {height}", row[1]);
        }
    }
}

/// The ending of the file chooses what is written, so another ending is no choice.
#[test]
fn a_record_is_refused_where_its_ending_names_no_format() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "hanging-textile-1e4", "--method", "imex-euler", "--out"];
    for out in ["x.txt", "x", "x.json.bak", ".json"] {
        let output = drape(folder.path(), &[&run[..], &[out]].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        let expected = format!("`--out` is `{out}`; expected a name that ends in .csv or .json");
        assert!(said.contains(&expected) && said.trim_end().lines().count() == 1, "{said}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn probes_that_cannot_be_are_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "hanging-textile-1e4", "--method", "imex-euler"];
    for (more, named) in [
        (&["--probe", "400", "--probe-out", "p.csv"][..], "a particle from 0 to 399"),
        (&["--probe", "colour", "--probe-out", "p.csv"], "pins, stretch, lowest, energy"),
        (&["--probe", "group:1", "--probe-out", "p.csv"], "0 to 0: of this kind the scene has 1"),
        (&["--probe", "boundary:x", "--probe-out", "p.csv"], "boundary:N with N from 0 to 0"),
        (&["--probe", "pins"], "`--probe-out FILE` beside it"),
        (&["--probe-out", "p.csv"], "`--probe WHAT` beside it"),
        (&["--probe", "pins", "--probe-out", "p.txt"], "ends in .csv or .json"),
        (&["--probe", "pins", "--probe-out", "p.csv", "--out", "p.csv"], "another file than --out"),
    ] {
        let output = drape(folder.path(), &[&run[..], more].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(named) && said.trim_end().lines().count() == 1, "{said}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
