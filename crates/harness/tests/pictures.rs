//! Pictures of cloth, drawn from a synthetic record.

#![allow(clippy::unwrap_used)]

use crate::common;

use drape_harness::studies::pictures::facts::{Facts, METHODS, PAPER, Scene, Shot, Table};
use drape_harness::studies::{draw, find};
use std::path::Path;

/// A sheet of 5 × 5 particles in the plane, and one below it.
fn facts() -> Facts {
    let table = Table { center_m: [0.0, 0.0, -0.25], size_m: [0.5, 0.5, 0.5] };
    let scene = |id: &str, table| Scene {
        id: id.to_owned(),
        rows: 5,
        columns: 5,
        stiffness_over_mass_per_s2: 1e4,
        table,
        portable: true,
    };
    let shot = |series: &str, scene: &str, label: &str, time_s: f64, is_lost: bool| {
        let at = |n: u32| f64::from(n) * 0.25 - 0.5;
        let points = (0..25).flat_map(|n| [at(n % 5), at(n / 5), -0.3 * time_s * f64::from(n / 5)]);
        Shot {
            series: series.to_owned(),
            scene: scene.to_owned(),
            label: label.to_owned(),
            method: "leapfrog".to_owned(),
            step_s: 0.01,
            time_s,
            diverged_at_s: is_lost.then_some(0.05),
            position_m: points.filter(|_| !is_lost).collect(),
            portable: true,
        }
    };
    let mut shots = vec![shot(PAPER, "table", "square table", 0.1, false)];
    shots.push(shot(PAPER, "hanging", "hanging textile", 1.0, false));
    for (label, is_lost) in [("reference", false), ("explicit-euler", true), ("imex-euler", false)]
    {
        shots.extend([0.1, 1.0].map(|t| shot(METHODS, "hanging", label, t, is_lost)));
    }
    Facts { scenes: vec![scene("table", Some(table)), scene("hanging", None)], shots }
}

fn write(folder: &Path, facts: Facts) {
    let record = common::record("pictures", false, facts);
    drape_report::file::write_json(&folder.join("pictures.json"), &record).unwrap();
}

fn png(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).unwrap();
    assert!(bytes.starts_with(b"\x89PNG"), "{}", path.display());
    bytes
}

#[test]
fn pictures_stand_in_files_of_their_own_and_in_the_page() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), facts());
    draw(folder.path()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let index = std::fs::read_to_string(folder.path().join("README.md")).unwrap();
    let figures = find("pictures").unwrap().figures();
    assert_eq!(page.matches("data:image/png;base64,").count(), figures.len());
    let pictures: Vec<_> = figures
        .iter()
        .map(|figure| {
            assert!(index.contains(&format!("(figures/{})", figure.file)));
            assert!(page.contains(&format!("figure-{}", figure.file.trim_end_matches(".png"))));
            png(&folder.path().join("figures").join(&figure.file))
        })
        .collect();
    assert!(page.contains("diverged at 0.050 s"));
    draw(folder.path()).unwrap();
    for (figure, before) in figures.iter().zip(pictures) {
        assert_eq!(png(&folder.path().join("figures").join(&figure.file)), before, "redrawn");
    }
}

#[test]
fn positions_that_do_not_fit_their_scene_leave_a_picture_out_and_do_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let mut facts = facts();
    for shot in &mut facts.shots {
        shot.position_m.pop();
    }
    write(folder.path(), facts);
    draw(folder.path()).unwrap();
    assert!(!folder.path().join("figures/pictures-paper.png").exists());
    png(&folder.path().join("figures/pictures-methods.png"));
    let mut facts = self::facts();
    facts.shots.retain(|shot| shot.label == "hanging textile");
    write(folder.path(), facts);
    draw(folder.path()).unwrap();
    png(&folder.path().join("figures/pictures-paper.png"));
}
