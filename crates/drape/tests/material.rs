//! `drape material`: bundled materials, and rows of a table of fabrics.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::fabric::Material;
use std::path::Path;
use std::process::{Command, Output};

fn drape(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_drape")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const TABLE: &str = "name,density[kg.m-2],linear warp[SI*1e9],linear weft[SI*1e9]\n\
                     a,0.2,9000,7000\n\
                     b,0.15,12500,3000\n";

#[test]
fn a_bundled_material_is_printed_with_its_source_and_listed() {
    let folder = tempfile::tempdir().unwrap();
    let listed = text(&drape(folder.path(), &["list", "materials"]).stdout);
    for name in Material::bundled() {
        let output = drape(folder.path(), &["material", name]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let material = Material::parse(&text(&output.stdout), "printed").unwrap();
        assert_eq!(material, Material::load(name).unwrap());
        assert!(material.source.contains("2011") && listed.contains(&material.source), "{listed}");
        assert!(listed.lines().any(|line| line == name), "{listed}");
    }
}

#[test]
fn a_row_of_a_table_becomes_a_material_that_a_scene_can_name() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cloths.csv"), TABLE).unwrap();
    let row = ["material", "cloths.csv", "--row", "2", "--like", "denim"];
    let written = [&row[..], &["--name", "mine", "--out", "mine.json"]].concat();
    let output = drape(folder.path(), &written);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("assumed to be those of denim"), "{told}");
    let path = folder.path().join("mine.json");
    let material = Material::load(path.to_str().unwrap()).unwrap();
    let denim = Material::load("denim").unwrap();
    assert_eq!(material.name, "mine");
    assert_eq!(material.areal_density_kg_m2, 0.15);
    assert!((material.bending_n_m.warp - 1.25e-5).abs() < 1e-18);
    assert!((material.bending_n_m.weft - 3e-6).abs() < 1e-18);
    assert_eq!(material.tension_n_per_m, denim.tension_n_per_m);
    assert_eq!(material.shear_n_per_m, denim.shear_n_per_m);
    assert_eq!(material.assumed, ["tension_n_per_m", "shear_n_per_m", "retardation_s"]);
    assert!(material.source.starts_with("Row 2 of cloths.csv."), "{}", material.source);
    // Without --out it is printed; its name is that of file and row.
    let printed = Material::parse(&text(&drape(folder.path(), &row).stdout), "printed").unwrap();
    assert_eq!(Material { name: "mine".to_owned(), ..printed.clone() }, material);
    assert_eq!(printed.name, "cloths-2");
    // A scene takes the file.
    let hanging = drape_model::bundled::text("hanging-denim").unwrap();
    let scene = hanging.replacen("\"denim\"", "\"mine.json\"", 1);
    assert_ne!(scene, hanging);
    std::fs::write(folder.path().join("scene.json"), scene).unwrap();
    let output = drape(folder.path(), &["system", "scene.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn what_is_wrong_is_named_by_place_value_and_expectation() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cloths.csv"), TABLE).unwrap();
    std::fs::write(folder.path().join("broken.csv"), TABLE.replace("12500", "stiff")).unwrap();
    std::fs::write(folder.path().join("other.csv"), "a,b\n1,2\n").unwrap();
    std::fs::write(folder.path().join("broken.json"), "{\"format\": 3}").unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["silk"], &["`material`", "\"silk\"", "expected one of the materials denim"]),
        (&["none.csv", "--row", "1"], &["`table`", "none.csv", "expected a table of fabrics"]),
        (&["cloths.csv"], &["`--row` is missing", "from 1 to 2"]),
        (&["cloths.csv", "--row", "0"], &["`--row` is 0", "from 1 to 2"]),
        (&["cloths.csv", "--row", "3"], &["`--row` is 3", "from 1 to 2"]),
        (&["cloths.csv", "--row", "-1"], &["`--row` is -1", "from 1 to 2"]),
        (&["cloths.csv", "--row", "1", "--like", "silk"], &["`--like`", "\"silk\"", "expected"]),
        (&["broken.csv", "--row", "1"], &["`broken.csv, line 3, linear warp`", "stiff"]),
        (&["other.csv", "--row", "1"], &["`other.csv, line 1`", "without density", "expected"]),
        (&["broken.json"], &["`broken.json, format`", "expected a material of format"]),
        (&["denim", "--row", "1"], &["`--row` is 1", "expected no such option"]),
        (
            &["cloths.csv", "--row", "1", "--out", "cloths.csv"],
            &["`--out` is `cloths.csv`", "expected another file than the input"],
        ),
        (
            &["cloths.csv", "--row", "1", "--out", "x.txt"],
            &["`--out` is `x.txt`", "expected a name that ends in .json"],
        ),
    ];
    for (arguments, parts) in cases {
        let output = drape(folder.path(), &[&["material"], *arguments].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        for part in *parts {
            assert!(message.contains(part), "{arguments:?}: no `{part}` in {message}");
        }
    }
    let kept = std::fs::read_to_string(folder.path().join("cloths.csv")).unwrap();
    assert_eq!(kept, TABLE, "a refused command changes no file");
}

#[test]
fn readings_of_instruments_replace_the_constants_of_a_material() {
    let folder = tempfile::tempdir().unwrap();
    let base = ["material", "cotton-blend", "--name", "mine", "--out", "mine.json"];
    let made = |readings: &[&str]| {
        let _ = std::fs::remove_file(folder.path().join("mine.json"));
        let options = readings.iter().flat_map(|reading| ["--reading", reading]);
        let arguments: Vec<_> = base.into_iter().chain(options).collect();
        let output = drape(folder.path(), &arguments);
        let told = text(&output.stderr);
        match output.status.code() {
            Some(0) => {
                Ok(Material::load(folder.path().join("mine.json").to_str().unwrap()).unwrap())
            }
            Some(2) => Err(told),
            other => panic!("{other:?}: {told}"),
        }
    };
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    let kes = made(&["density=0.2", "kes-b=0.1,0.05", "kes-g=1", "kes-emt=5,10"]).unwrap();
    near(kes.areal_density_kg_m2, 0.2);
    near(kes.bending_n_m.warp, 9.80665e-6);
    near(kes.bending_n_m.weft, 4.903325e-6);
    near(kes.shear_n_per_m, 0.980665 * 180.0 / std::f64::consts::PI);
    near(kes.tension_n_per_m.warp, 9806.65);
    near(kes.tension_n_per_m.weft, 4903.325);
    assert!(kes.source.ends_with("Readings: density=0.2; kes-b=0.1,0.05; kes-g=1; kes-emt=5,10."));
    // 20 mm at 0.2 kg/m²: ρ g c³. The order of the readings does not matter.
    let fast = made(&["fast-c=20", "fast-e100=3,5", "fast-e20=1", "fast-eb5=4.1", "density=0.2"]);
    let fast = fast.unwrap();
    near(fast.bending_n_m.warp, 0.2 * 9.80665 * 8e-6);
    near(fast.tension_n_per_m.warp, 80.0 * 0.980665 / 0.02);
    near(fast.tension_n_per_m.weft, 80.0 * 0.980665 / 0.04);
    near(fast.shear_n_per_m, 30.0);
    for (readings, expected) in [
        (&["kes-b"][..], "KEY=VALUE"),
        (&["kes-x=1"], "kes-emt"),
        (&["kes-b=0"], "above 0"),
        (&["kes-b=1,-2"], "gf cm²/cm"),
        (&["kes-b=1", "fast-c=20"], "one reading that sets bending_n_m"),
        (&["kes-g=1", "kes-g=2"], "one reading that sets shear_n_per_m"),
        (&["fast-e20=1"], "fast-e100 beside it"),
        (&["fast-e100=1"], "fast-e20 beside it"),
        (&["fast-e20=3", "fast-e100=2"], "greater extensions"),
        (&["kes-b=1e300"], "bending_n_m"),
    ] {
        let told = made(readings).unwrap_err();
        assert!(told.contains(expected), "{readings:?}: {told}");
    }
}
