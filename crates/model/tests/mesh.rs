//! Cloth from OBJ files. A mesh of quads has the springs and masses of a grid. Messages refuse
//! every broken file by line and name every repair. Pins select particles.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_kernels::testing::Random;
use drape_model::{SceneError, SceneFile, SpringEffect, SystemSpec, load, parse};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// Two quads and a triangle on the second, in three groups.
const STRIP: &str = "\
# a strip
o strip
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 2 0 0 0.1 0.2 0.3
v 2 1 0
v 2.5 0.5 0
vt 0 0
vn 0 0 1
g left
usemtl wool
s 1
f 1/1/1 2/1 3//1 4
g right middle
f 2 5 6 3
g tip
f -3 -1 -2 # between the last three
";

fn scene(file: &str, more: Value) -> Value {
    let mut mesh = json!({ "file": file, "areal_density_kg_m2": 0.2 });
    mesh.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    json!({
        "format": "drape-scene/1", "name": "mesh", "cloth": { "mesh": mesh },
        "effects": {
            "tension": { "stiffness_n_per_m": 100, "damping_n_s_per_m": 1 },
            "shear": { "stiffness_over_mass_per_s2": 10 }, "bending": { "stiffness_n_per_m": 1 }
        },
        "time": { "step_s": 0.01, "duration_s": 1 }
    })
}

/// Writes the files into a folder and loads the scene that names `cloth.obj`.
fn read(obj: &[u8], more: Value, pins: Value) -> Result<SceneFile, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cloth.obj"), obj).unwrap();
    let mut scene = scene("cloth.obj", more);
    scene["pins"] = pins;
    let path = folder.path().join("scene.json");
    std::fs::write(&path, scene.to_string()).unwrap();
    load(&path.display().to_string())
}

fn spec(obj: &str) -> SystemSpec {
    read(obj.as_bytes(), json!({}), json!([])).unwrap().spec().clone()
}

fn pairs(spec: &SystemSpec, effect: SpringEffect) -> BTreeSet<(u32, u32)> {
    let of_effect: Vec<_> = spec.springs.iter().filter(|s| s.effect == effect).collect();
    let pairs: BTreeSet<_> = of_effect.iter().map(|s| (s.i.min(s.j), s.i.max(s.j))).collect();
    assert_eq!(pairs.len(), of_effect.len(), "each spring once");
    pairs
}

#[test]
fn a_mesh_of_quads_has_the_springs_and_masses_of_the_grid() {
    let (rows, columns) = (4_usize, 5_usize);
    let mut obj = String::new();
    for row in 0..rows {
        for column in 0..columns {
            obj += &format!("v {} {} 0.5\n", column as f64 * 0.25 - 0.5, row as f64 * 0.5 - 0.75);
        }
    }
    for row in 1..rows {
        for column in 1..columns {
            let d = row * columns + column + 1;
            obj += &format!("f {} {} {d} {}\n", d - columns - 1, d - columns, d - 1);
        }
    }
    let mesh = spec(&obj);
    let mut grid = scene("", json!({}));
    grid["cloth"] = json!({ "grid": {
        "rows": rows, "columns": columns, "size_m": [1, 1.5], "center_m": [0, 0, 0.5],
        "mass_kg": 0.3
    } });
    let grid = parse("grid", &grid.to_string()).unwrap().spec().clone();
    assert_eq!(mesh.particles.position_m, grid.particles.position_m);
    for effect in SpringEffect::ALL {
        assert_eq!(pairs(&mesh, effect), pairs(&grid, effect), "{}", effect.name());
    }
    for spring in &mesh.springs {
        let twin = |s: &&drape_model::SpringSpec| {
            s.effect == spring.effect && BTreeSet::from([s.i, s.j]) == [spring.i, spring.j].into()
        };
        let twin = grid.springs.iter().find(twin).unwrap();
        assert!((spring.rest_length_m - twin.rest_length_m).abs() < 1e-15);
        let ratio = spring.stiffness_n_per_m / twin.stiffness_n_per_m;
        assert!((ratio - 1.0).abs() < 1e-12, "{ratio}: the mean mass is the grid's");
        assert_eq!(spring.damping_n_s_per_m, twin.damping_n_s_per_m);
    }
    // A corner carries a quarter of a cell, an inner particle a whole one.
    let cell = 0.2 * 0.25 * 0.5;
    assert!((mesh.particles.mass_kg[0] - 0.25 * cell).abs() < 1e-16);
    assert!((mesh.particles.mass_kg[columns + 1] - cell).abs() < 1e-16);
    assert!((mesh.particles.mass_kg.iter().sum::<f64>() - 0.3).abs() < 1e-15);
    assert_eq!(mesh.triangles.len(), grid.triangles.len());
}

#[test]
fn triangles_give_thirds_of_their_mass_and_bending_across_inner_edges() {
    let spec = spec(STRIP);
    let masses = &spec.particles.mass_kg;
    let expected = [0.05, 0.1, 0.1, 0.05, 0.05 + 0.05 / 3.0, 0.05 + 0.05 / 3.0, 0.05 / 3.0];
    for (found, expected) in masses.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-15, "{masses:?}");
    }
    let tension = [(0, 1), (1, 2), (2, 3), (0, 3), (1, 4), (4, 5), (2, 5), (4, 6), (5, 6)];
    assert_eq!(pairs(&spec, SpringEffect::Tension), tension.into());
    assert_eq!(pairs(&spec, SpringEffect::Shear), [(0, 2), (1, 3), (1, 5), (2, 4)].into());
    // Along the strip, then from the second quad to the tip.
    assert_eq!(pairs(&spec, SpringEffect::Bending), [(0, 4), (3, 5), (1, 6), (2, 6)].into());
    assert_eq!(spec.triangles.len(), 5);
    let mut folded = STRIP.replace("v 2.5 0.5 0", "v 2 0.5 0.5");
    folded += "v 3 3 3\nf 5 8 7\n";
    // Two triangles at an edge: their far corners.
    assert!(pairs(&mended(&folded), SpringEffect::Bending).contains(&(5, 7)));
}

#[test]
fn a_quad_is_cut_along_its_shorter_diagonal() {
    let triangles = |third: &str, fourth: &str| {
        let obj = format!("v 0 0 0\nv 1 0 0\nv {third}\nv {fourth}\nf 1 2 3 4\n");
        spec(&obj).triangles
    };
    assert_eq!(triangles("1 1 0", "-1 2 0"), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(triangles("2 2 0", "0 1 0"), [[0, 1, 3], [1, 2, 3]]);
}

fn mended(obj: &str) -> SystemSpec {
    read(obj.as_bytes(), json!({ "repair": true }), json!([])).unwrap().spec().clone()
}

#[test]
fn scale_rotation_translation_and_spin_act_in_this_order() {
    let more = json!({
        "scale": 0.5, "rotation": { "axis": [0, 0, 2], "angle_deg": 90 },
        "translation_m": [0, 0, 3], "velocity_m_s": [0, 0, 1], "spin_rad_s": [0, 0, 2]
    });
    let input = read(STRIP.as_bytes(), more, json!([])).unwrap();
    let particles = &input.spec().particles;
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-14);
    assert!(near(particles.position_m[4], [0.0, 1.0, 3.0]), "{:?}", particles.position_m[4]);
    assert!((input.spec().springs[0].rest_length_m - 0.5).abs() < 1e-15);
    let total: f64 = particles.mass_kg.iter().sum();
    assert!((total - 0.2 * 2.25 * 0.25).abs() < 1e-15, "{total}");
    let mut momentum = [0.0; 3];
    for (mass, v) in particles.mass_kg.iter().zip(&particles.velocity_m_s) {
        (0..3).for_each(|k| momentum[k] += mass * v[k]);
    }
    assert!(near(momentum, [0.0, 0.0, total]), "the spin carries no momentum: {momentum:?}");
    let [a, b] = [particles.velocity_m_s[0], particles.velocity_m_s[4]];
    assert!(near([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [-2.0, 0.0, 0.0]), "{a:?}, {b:?}");
}

#[test]
fn particles_are_selected_by_place_name_and_boundary() {
    let ring = "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nv 1 1 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\n\
                f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    for (obj, pin, expected) in [
        (STRIP, json!({ "near_m": [2.4, 0.4, 9] }), vec![6]),
        (STRIP, json!({ "within_m": [[1, 0, -1], [2, 0.5, 1]] }), vec![1, 4]),
        (STRIP, json!({ "name": "left" }), vec![0, 1, 2, 3]),
        (STRIP, json!({ "name": "middle" }), vec![1, 2, 4, 5]),
        (STRIP, json!({ "name": "tip" }), vec![4, 5, 6]),
        (STRIP, json!({ "boundary": 0 }), vec![0, 1, 2, 3, 4, 5, 6]),
        (ring, json!({ "boundary": 0 }), vec![0, 1, 2, 3]),
        (ring, json!({ "boundary": 1 }), vec![4, 5, 6, 7]),
        (ring, json!({ "particle": 3 }), vec![3]),
    ] {
        let input = read(obj.as_bytes(), json!({}), json!([pin])).unwrap();
        let pins: Vec<_> = input.spec().pins.iter().map(|pin| pin.particle).collect();
        assert_eq!(pins, expected, "{pin}");
    }
    for (pin, path, expected) in [
        (json!({ "name": "hem" }), "pins[0].name", "left, middle, right, tip"),
        (json!({ "boundary": 1 }), "pins[0].boundary", "0 to 0"),
        (json!({ "row": 0 }), "pins[0]", "of a grid"),
        (json!({ "particle": 7 }), "pins[0].particle", "0 to 6"),
        (json!({ "within_m": [[9, 9, 9], [9, 9, 9]] }), "pins[0].within_m", "at least one"),
    ] {
        let message = read(STRIP.as_bytes(), json!({}), json!([pin])).unwrap_err().to_string();
        assert!(message.contains(path) && message.contains(expected), "{message}");
    }
    let grid = scene("", json!({}));
    let mut grid = grid;
    grid["cloth"] = json!({ "grid": {
        "rows": 3, "columns": 2, "size_m": [1, 1], "center_m": [0, 0, 0], "mass_kg": 1
    } });
    grid["pins"] =
        json!([{ "row": 2 }, { "column": 1 }, { "near_m": [-9, -9, 0] }, { "boundary": 0 }]);
    let pins = parse("grid", &grid.to_string()).unwrap().spec().pins.clone();
    let pins: Vec<_> = pins.iter().map(|pin| pin.particle).collect();
    assert_eq!(pins, [4, 5, 1, 3, 5, 0, 0, 1, 2, 3, 4, 5]);
}

/// The message, which must have the form of every other.
fn refused(obj: &[u8], more: Value) -> String {
    let message = read(obj, more, json!([])).unwrap_err().to_string();
    assert!(message.contains("scene.json: ") && message.contains("expected"), "{message}");
    assert!(message.contains("cloth.mesh.") && message.chars().count() < 420, "{message}");
    assert!(!message.contains(['\n', '\0']), "{message}");
    message
}

#[test]
fn broken_files_are_refused_by_line() {
    for (obj, line, found) in [
        ("v 0 0 nan\n", 1, "nan"),
        ("v 0 0 0\nv 0 inf 0\n", 2, "inf"),
        ("v 0 0 1e999\n", 1, "1e999"),
        ("v 0 0 2e9\n", 1, "2e9"),
        ("v 0 0\n", 1, "2 numbers"),
        ("v 0 0 0 1 1\n", 1, "5 numbers"),
        ("v 0 0 x\n", 1, "\"x\""),
        ("v 0 0 0\nf 0 1 1\n", 2, "vertex 0"),
        ("v 0 0 0\n\nf 1 2 3\n", 3, "vertex 2"),
        ("v 0 0 0\nf -1 -2 -1\n", 2, "vertex -2, of 1 so far"),
        ("v 0 0 0\nf 1 1 99999999999999999999\n", 2, "99999999999999999999"),
        ("v 0 0 0\nf 1 1 4000001\n", 2, "vertex 4000001"),
        ("v 0 0 0\nf 1/2/3/4 1 1\n", 2, "1/2/3/4"),
        ("v 0 0 0\nf 1 1\n", 2, "2 corners"),
        ("v 0 0 0\nf 1 1 1 1 1\n", 2, "5 corners"),
        ("v 0 0 0\nf 1.5 1 1\n", 2, "1.5"),
        ("v 0 0 0\ncurv 0 1 1 2\n", 2, "curv"),
        ("{ \"format\": 1 }", 1, "format"),
        ("f 1 2 3\n", 1, "which has none"),
    ] {
        let message = refused(obj.as_bytes(), json!({}));
        assert!(message.contains(&format!("cloth.obj line {line}")), "{message}");
        assert!(message.contains(found), "{found} in {message}");
    }
    for obj in ["", "# nothing\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"] {
        assert!(refused(obj.as_bytes(), json!({})).contains("no face"));
    }
    let binary = refused(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\xff\xfe", json!({}));
    assert!(binary.contains("line 1") && binary.contains("UTF-8"), "{binary}");
    let long_name = format!("o {}\n{STRIP}", "n".repeat(300));
    assert!(refused(long_name.as_bytes(), json!({})).contains("a name of 300 bytes"));
}

#[test]
fn a_line_without_end_is_refused_unread() {
    let long = [b"v 0 0 0\nv 0 0 0".as_slice(), &vec![b'0'; 100_000]].concat();
    let message = refused(&long, json!({}));
    assert!(message.contains("line 2") && message.contains("65536 bytes"), "{message}");
    let SceneFile::Scene(mut scene, _) = read(STRIP.as_bytes(), json!({}), json!([])).unwrap()
    else {
        panic!("a scene")
    };
    let drape_model::Cloth::Mesh(mesh) = &mut scene.cloth else { panic!("a mesh") };
    let endless = std::io::BufReader::new(std::io::repeat(b'7'));
    assert!(mesh.read(endless).unwrap_err().to_string().contains("65536 bytes"));
}

#[test]
fn files_that_cannot_be_read_are_refused() {
    for (file, found) in [
        ("missing.obj", "missing.obj"),
        ("", "unreadable"),
        (".", "no file"),
        ("a\0b", "unreadable"),
    ] {
        let message = parse("scene.json", &scene(file, json!({})).to_string()).unwrap_err();
        let message = message.to_string();
        assert!(message.contains("cloth.mesh.file") && message.contains(found), "{message}");
    }
    let message = parse("x", &scene("bundled:shirt.obj", json!({})).to_string()).unwrap_err();
    assert!(message.to_string().contains("skirt.obj"), "{message}");
    if Path::new("/dev/zero").exists() {
        let message = parse("x", &scene("/dev/zero", json!({})).to_string()).unwrap_err();
        assert!(message.to_string().contains("which is no file"), "{message}");
    }
}

#[test]
fn values_out_of_range_are_refused() {
    for (key, bad) in [
        ("areal_density_kg_m2", json!(0)),
        ("areal_density_kg_m2", json!(-1)),
        ("areal_density_kg_m2", json!(1e31)),
        ("areal_density_kg_m2", json!(5e-324)),
        ("scale", json!(0)),
        ("scale", json!(1e9)),
        ("scale", json!(1e-170)),
        ("translation_m", json!([0, 0, 1e10])),
        ("translation_m", json!([0, 0, 1e9])),
        ("velocity_m_s", json!([0, 1e10, 0])),
        ("spin_rad_s", json!([0, 0, 1e9])),
    ] {
        let mut more = serde_json::Map::new();
        more.insert(key.to_owned(), bad);
        refused(STRIP.as_bytes(), more.into());
    }
    let turn =
        |axis: Value, angle: f64| json!({ "rotation": { "axis": axis, "angle_deg": angle } });
    assert!(refused(STRIP.as_bytes(), turn(json!([0, 0, 0]), 1.0)).contains("rotation.axis"));
    assert!(refused(STRIP.as_bytes(), turn(json!([0, 0, 1]), 361.0)).contains("angle_deg"));
    let message = read(STRIP.as_bytes(), json!({ "centre": 1 }), json!([])).unwrap_err();
    assert!(message.to_string().contains("cloth.mesh.centre"), "{message}");
}

#[test]
fn faults_of_the_surface_are_refused_by_face_and_mended_on_request() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
    for (fault, line, face, found, repair) in [
        ("f 2 2 3\n", 7, 3, "corner 2 twice", "1 degenerate faces dropped"),
        ("v 0.5 0 0\nf 1 5 2\n", 8, 3, "without area", "1 degenerate faces dropped"),
        ("f 2 3 1\n", 7, 3, "the corners of face 1", "1 doubled faces dropped"),
        ("v 2 0 0\nf 2 3 5\n", 8, 3, "turned the other way", "1 faces turned over"),
        ("v 2 0 0\nf 2 5 5 3\n", 8, 3, "corner 5 twice", "1 quads with a doubled corner"),
    ] {
        let obj = format!("{square}{fault}");
        let message = refused(obj.as_bytes(), json!({}));
        assert!(message.contains(&format!("line {line} (face {face})")), "{message}");
        assert!(message.contains(found) && message.contains("`repair`"), "{message}");
        let input = read(obj.as_bytes(), json!({ "repair": true }), json!([])).unwrap();
        assert!(
            input.repairs().iter().any(|text| text.starts_with(repair)),
            "{:?}",
            input.repairs()
        );
        let turned = input.spec().triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let turned: Vec<_> = turned.collect();
        let distinct: BTreeSet<_> = turned.iter().collect();
        assert_eq!(turned.len(), distinct.len(), "no edge twice in the same direction");
    }
    let unused = format!("v 9 9 9\n{}", square.replace("f 1 2 3\nf 1 3 4", "f 2 3 4\nf 2 4 5"));
    let message = refused(unused.as_bytes(), json!({}));
    assert!(message.contains("line 1") && message.contains("belongs to no face"), "{message}");
    let clean = read(unused.as_bytes(), json!({ "repair": true }), json!([])).unwrap();
    assert_eq!(clean.repairs(), ["1 vertices without a face dropped"]);
    let plain = read(square.as_bytes(), json!({}), json!([])).unwrap();
    assert_eq!(clean.spec(), plain.spec());
    assert!(plain.repairs().is_empty());

    // No repair can mend three faces at an edge, one side only, or an empty surface.
    let fin = format!("{square}v 0 0 1\nf 1 3 5\n");
    let band = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nv 0 0 1\n\
                f 1 2 3\nf 2 3 4\nf 3 4 5\nf 4 5 1\nf 5 1 2\n";
    for (obj, found) in [
        (fin.as_str(), "at most two faces"),
        (band, "a surface with two sides"),
        ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "not degenerate"),
    ] {
        let message = refused(obj.as_bytes(), json!({ "repair": true }));
        assert!(message.contains(found), "{message}");
    }
}

#[test]
fn a_group_that_a_repair_emptied_pins_nothing_and_is_refused() {
    let obj = format!("{STRIP}g lost\nf 2 2 3\ng left lost\nf 1 2 3 4\n");
    let pinned =
        |name: &str| read(obj.as_bytes(), json!({ "repair": true }), json!([{ "name": name }]));
    assert_eq!(pinned("left").unwrap().spec().pins.len(), 4);
    let message = pinned("lost").unwrap_err().to_string();
    assert!(message.contains("pins[0].name") && message.contains("\"lost\""), "{message}");
    assert!(message.contains("`repair` dropped all"), "{message}");
}

#[test]
fn slivers_are_cloth() {
    let spec = spec("v 0 0 0\nv 1 0 0\nv 0.5 1e-6 0\nv 0.5 1 0\nf 1 2 3\nf 1 3 4\n");
    assert!(spec.build().is_ok());
}

#[test]
fn random_text_never_panics() {
    let words =
        ["v", "f", "g", "o", "1", "-1", "0", "2/3", "\n", "\n", " ", "1e400", "é", "#", "9"];
    let mut random = Random::new(1);
    for _ in 0..300 {
        let mut text = STRIP.to_owned();
        for _ in 0..30 {
            text += words[random.below(words.len())];
            text.push(' ');
        }
        let repair = random.below(2) == 1;
        let _ = read(text.as_bytes(), json!({ "repair": repair }), json!([]));
    }
}
