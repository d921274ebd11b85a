//! A scene that names a material has the sheet's rigidities on every mesh.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::fabric::{Directions, Disc, Material, MaterialChoice, Strip, Table, Woven};
use drape_model::{Cloth, Scene, SceneFile, System, SystemSpec, Vec3, Violation, load, parse};
use serde_json::{Value, json};

/// A grid of this size, 0.3 m by 0.2 m, with a material.
fn grid(rows: u32, columns: u32, material: Value) -> Value {
    json!({
        "format": "drape-scene/1", "name": "sheet", "material": material,
        "cloth": { "grid": { "rows": rows, "columns": columns, "size_m": [0.3, 0.2],
            "center_m": [0, 0, 0] } },
        "time": { "step_s": 0.001, "duration_s": 1 }
    })
}

fn read(scene: &Value) -> Result<SceneFile, String> {
    parse("file.json", &scene.to_string()).map_err(|error| error.to_string())
}

fn spec(scene: &Value) -> SystemSpec {
    read(scene).unwrap().spec().clone()
}

/// Energy over the area of 0.3 m by 0.2 m after a deformation.
fn energy(spec: &SystemSpec, deform: impl Fn(&Vec3) -> Vec3) -> f64 {
    let (system, state) = spec.build().unwrap();
    energy_of(&system, &state.x.iter().map(deform).collect::<Vec<_>>()) / 0.06
}

fn energy_of(system: &System, x: &[Vec3]) -> f64 {
    system.effects().map(|effect| effect.energy(system.mass(), x)).sum()
}

fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a / b - 1.0).abs() < tolerance, "{a} {b}");
}

#[test]
fn the_bundled_materials_name_their_source_and_read_back() {
    assert_eq!(Material::bundled().count(), 5);
    for name in Material::bundled() {
        let material = Material::load(name).unwrap();
        assert_eq!(material.name, name);
        assert!(material.source.contains("doi:"), "{name}");
        assert!(material.assumed.contains(&"retardation_s".to_owned()), "{name}");
        let text = serde_json::to_string(&material).unwrap();
        assert_eq!(Material::parse(&text, "material").unwrap(), material);
        // Every material works with both models of shear and all models of bending.
        for shear in ["springs", "angles"] {
            for bending in ["hinges", "angles", "buckling"] {
                let choice = json!({ "of": name, "shear_model": shear, "bending_model": bending });
                let (system, _) = spec(&grid(5, 7, choice)).build().unwrap();
                assert_eq!(system.effects().count(), 3, "{name} {shear} {bending}");
            }
        }
    }
}

#[test]
fn a_sheet_has_the_energy_of_its_material_on_every_grid() {
    let denim = Material::load("denim").unwrap();
    let (c, g) = (denim.tension_n_per_m, denim.shear_n_per_m);
    let small = 1e-5;
    for (rows, columns) in [(3, 4), (9, 13), (12, 9), (33, 49)] {
        for model in ["springs", "angles"] {
            let spec = spec(&grid(rows, columns, json!({ "of": "denim", "shear_model": model })));
            let total: f64 = spec.particles.mass_kg.iter().sum();
            near(total, denim.areal_density_kg_m2 * 0.06, 1e-12);
            let along = |axis: usize| {
                energy(&spec, |x| {
                    let mut x = *x;
                    x[axis] *= 1.0 + small;
                    x
                }) / (0.5 * small * small)
            };
            near(along(0), c.warp, 1e-3);
            near(along(1), c.weft, 1e-3);
            let shear = |x: &Vec3| x + Vec3::x() * (small * x.y);
            near(energy(&spec, shear) / (0.5 * small * small), g, 1e-3);
        }
    }
}

#[test]
fn a_cylinder_has_the_energy_of_its_bending_rigidity_on_three_meshes() {
    let denim = Material::load("denim").unwrap();
    let radius = 0.4;
    for model in ["hinges", "angles"] {
        for (axis, rigidity) in [(0, denim.bending_n_m.warp), (1, denim.bending_n_m.weft)] {
            let ratios = [(7, 10), (13, 19), (25, 37)].map(|(rows, columns)| {
                let choice = json!({ "of": "denim", "bending_model": model });
                let mut spec = spec(&grid(rows, columns, choice));
                spec.springs.clear();
                let bent = energy(&spec, |x| {
                    let mut bent = *x;
                    let angle = x[axis] / radius;
                    bent[axis] = radius * angle.sin();
                    bent.z = -radius * angle.cos();
                    bent
                });
                bent / (0.5 * rigidity / (radius * radius))
            });
            // Free ends have no angle: half a mesh width there is flat.
            for (ratio, n) in ratios.iter().zip([[9.0, 6.0], [18.0, 12.0], [36.0, 24.0]]) {
                near(*ratio, 1.0 - 1.0 / n[axis], 2e-3);
            }
        }
    }
}

/// A sheet of quads or of their halves, with texture coordinates turned by `quarter` turns.
fn mesh(cells: usize, triangles: bool, quarter: bool, texture: bool) -> String {
    let (mut text, n) = (String::new(), cells + 1);
    for j in 0..n {
        for i in 0..n {
            let [x, y] = [i as f64 * 0.3 / cells as f64, j as f64 * 0.2 / cells as f64];
            text += &format!("v {x} {y} 0\n");
            let [u, v] = if quarter { [y, -x] } else { [7.0 * x, 7.0 * y + 1.0] };
            text += &if texture { format!("vt {u} {v}\n") } else { String::new() };
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let at = |i: usize, j: usize| {
                let k = j * n + i + 1;
                if texture { format!("{k}/{k}") } else { k.to_string() }
            };
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            text += &if triangles {
                format!("f {a} {b} {c}\nf {a} {c} {d}\n")
            } else {
                format!("f {a} {b} {c} {d}\n")
            };
        }
    }
    text
}

fn mesh_scene(text: &str, choice: MaterialChoice) -> Result<SystemSpec, Violation> {
    let mut scene: Scene = serde_json::from_value(json!({
        "format": "drape-scene/1", "name": "sheet",
        "cloth": { "mesh": { "file": "sheet.obj" } },
        "time": { "step_s": 0.001, "duration_s": 1 }
    }))
    .unwrap();
    let Cloth::Mesh(mesh) = &mut scene.cloth else { panic!("a mesh") };
    mesh.read(text.as_bytes())?;
    scene.material = Some(choice);
    scene.discretise()
}

#[test]
fn texture_coordinates_say_where_the_warp_of_a_mesh_is() {
    let denim = Material::load("denim").unwrap();
    let (c, g) = (denim.tension_n_per_m, denim.shear_n_per_m);
    let small = 1e-5;
    for triangles in [false, true] {
        for quarter in [false, true] {
            for cells in [3, 8] {
                let text = mesh(cells, triangles, quarter, true);
                let spec = mesh_scene(&text, MaterialChoice::named("denim")).unwrap();
                let total: f64 = spec.particles.mass_kg.iter().sum();
                near(total, denim.areal_density_kg_m2 * 0.06, 1e-9);
                let along = |axis: usize| {
                    energy(&spec, |x| {
                        let mut x = *x;
                        x[axis] *= 1.0 + small;
                        x
                    }) / (0.5 * small * small)
                };
                let [x, y] = if quarter { [c.weft, c.warp] } else { [c.warp, c.weft] };
                near(along(0), x, 1e-3);
                near(along(1), y, 1e-3);
                let shear = |x: &Vec3| x + Vec3::x() * (small * x.y);
                near(energy(&spec, shear) / (0.5 * small * small), g, 1e-3);
            }
        }
    }
    // The rigidity of a fold, too, belongs to the direction across it.
    let spec = mesh_scene(&mesh(4, true, true, true), MaterialChoice::named("denim")).unwrap();
    let fold = |i: u32, j: u32| {
        let hinge = spec.hinges.iter().find(|hinge| (hinge.i, hinge.j) == (i, j)).unwrap();
        hinge.stiffness_n_m
    };
    let [dx, dy] = [0.3 / 4.0, 0.2 / 4.0];
    near(fold(6, 7), denim.bending_n_m.warp * dx / dy, 1e-9);
    near(fold(6, 11), denim.bending_n_m.weft * dy / dx, 1e-9);
}

#[test]
fn a_mesh_without_texture_takes_the_mean_only_if_told_so() {
    let text = mesh(4, false, false, false);
    let violation = mesh_scene(&text, MaterialChoice::named("denim")).unwrap_err();
    assert_eq!(violation.path, "material.directions");
    let mean = MaterialChoice { directions: Directions::Mean, ..MaterialChoice::named("denim") };
    let spec = mesh_scene(&text, mean.clone()).unwrap();
    let denim = Material::load("denim").unwrap().tension_n_per_m;
    let small = 1e-5;
    let stretch = |x: &Vec3| Vec3::new(x.x * (1.0 + small), x.y, x.z);
    let found = energy(&spec, stretch) / (0.5 * small * small);
    near(found, 0.5 * (denim.warp + denim.weft), 1e-3);
    // Triangles are isotropic on the whole: no turn changes C₁₁ + C₂₂ + 2 G.
    let spec = mesh_scene(&mesh(4, true, false, false), mean).unwrap();
    let measured = |deform: &dyn Fn(&Vec3) -> Vec3| energy(&spec, deform) / (0.5 * small * small);
    let sum = measured(&stretch)
        + measured(&|x| Vec3::new(x.x, x.y * (1.0 + small), x.z))
        + 2.0 * measured(&|x| x + Vec3::x() * (small * x.y));
    near(sum, 8.0 / 3.0 * 0.5 * (denim.warp + denim.weft), 1e-3);
    // A texture without area at one face is found.
    let broken = mesh(4, false, false, true).replacen("f 1/1 2/2 7/7 6/6", "f 1/1 2/1 7/1 6/1", 1);
    let violation = mesh_scene(&broken, MaterialChoice::named("denim")).unwrap_err();
    assert!(violation.path.ends_with("(face 1)"), "{violation}");
    // Nothing else changes: texture that makes no sense is skipped as before.
    let odd = mesh(4, false, false, true).replace("vt 0 1\n", "vt nothing\n");
    assert!(mesh_scene(&odd, MaterialChoice::named("denim")).is_err());
    let mean = MaterialChoice { directions: Directions::Mean, ..MaterialChoice::named("denim") };
    assert!(mesh_scene(&odd, mean).is_ok());
}

#[test]
fn warp_and_weft_of_springs_follow_the_texture_of_a_mesh() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("sheet.obj"), mesh(3, false, true, true)).unwrap();
    let scene = json!({
        "format": "drape-scene/1", "name": "sheet",
        "cloth": { "mesh": { "file": "sheet.obj", "areal_density_kg_m2": 0.2 } },
        "effects": { "tension": { "warp": { "stiffness_n_per_m": 3 },
            "weft": { "stiffness_n_per_m": 5 } } },
        "time": { "step_s": 0.001, "duration_s": 1 }
    });
    let file = dir.path().join("scene.json");
    std::fs::write(&file, scene.to_string()).unwrap();
    let spec = load(file.to_str().unwrap()).unwrap().spec().clone();
    for spring in &spec.springs {
        let [a, b] = [spring.i, spring.j].map(|i| spec.particles.position_m[i as usize]);
        // The texture is turned: the warp is y.
        let expected = if (a[0] - b[0]).abs() < 1e-9 { 3.0 } else { 5.0 };
        assert_eq!(spring.stiffness_n_per_m, expected);
    }
}

#[test]
fn effects_that_the_scene_names_replace_those_of_the_material() {
    let names = |effects: Value| {
        let mut scene = grid(4, 5, json!("denim"));
        scene["effects"] = effects;
        let (system, _) = spec(&scene).build().unwrap();
        system.effects().map(|effect| effect.name()).collect::<Vec<_>>()
    };
    assert_eq!(names(json!({})), ["tension", "shear", "bending_hinge"]);
    let angles = json!({ "shear_angle": { "stiffness_n_m": 1 },
        "bending_angle": { "stiffness_n_m": 1 } });
    assert_eq!(names(angles), ["tension", "shear_angle", "bending_angle"]);
    let mut scene = grid(4, 5, json!("denim"));
    scene["effects"] = json!({ "tension": { "stiffness_n_per_m": 7 } });
    let spec = spec(&scene);
    let tension = spec.springs.iter().filter(|spring| spring.damping_n_s_per_m == 0.0);
    assert_eq!(tension.filter(|spring| spring.stiffness_n_per_m == 7.0).count(), 31);
}

#[test]
fn a_scene_with_a_material_reads_back() {
    for material in [
        json!("denim"),
        json!({ "of": "denim", "shear_n_per_m": 40.0, "bending_model": "angles" }),
        json!({ "areal_density_kg_m2": 0.2, "tension_n_per_m": { "warp": 100.0, "weft": 90.0 },
            "shear_n_per_m": 20.0, "bending_n_m": { "warp": 1e-5, "weft": 2e-5 },
            "retardation_s": 0.001, "shear_model": "angles", "hinge_fit": "strip",
            "directions": "mean" }),
    ] {
        let file = read(&grid(4, 5, material.clone())).unwrap();
        let text = serde_json::to_value(file.scene().unwrap()).unwrap();
        assert_eq!(text["material"], material);
        assert_eq!(read(&text).unwrap(), file);
        let frozen = serde_json::to_string(file.spec()).unwrap();
        let SceneFile::System(back) = parse("frozen", &frozen).unwrap() else { panic!() };
        assert_eq!(&back, file.spec());
    }
}

#[test]
fn files_of_materials_and_tables_lie_beside_the_scene() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
    write("mine.json", &Material::text("fleece").unwrap().replace("\"fleece\"", "\"mine\""));
    write(
        "table.csv",
        "density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9], linear diag[SI*1e9], \
         nonlinear warp[SI*1e12]\n0.1, 1000.0, 2000.0, 1500.0, -7\n0.3,30000,20000,25000,-5\n\n",
    );
    let open = |material: Value| {
        let file = dir.path().join("scene.json");
        std::fs::write(&file, grid(4, 5, material).to_string()).unwrap();
        load(file.to_str().unwrap()).map_err(|error| error.to_string())
    };
    let resolved = |material: Value| {
        open(material).unwrap().scene().unwrap().material.as_ref().unwrap().resolve().unwrap()
    };
    assert_eq!(resolved(json!("mine.json")).name, "mine");
    let rest = json!({ "of": "table.csv", "row": 2, "shear_n_per_m": 30.0,
        "tension_n_per_m": { "warp": 500.0, "weft": 400.0 } });
    let material = resolved(rest.clone());
    near(material.areal_density_kg_m2, 0.3, 1e-12);
    near(material.bending_n_m.warp, 3e-5, 1e-12);
    near(material.bending_n_m.weft, 2e-5, 1e-12);
    let fails = |material: Value, words: &[&str]| {
        let message = open(material).unwrap_err();
        words.iter().for_each(|word| assert!(message.contains(word), "{word}: {message}"));
    };
    let without = |key: &str| {
        let mut value = rest.clone();
        value.as_object_mut().unwrap().remove(key);
        value
    };
    fails(without("row"), &["material.row", "missing", "1 to 2"]);
    fails(without("shear_n_per_m"), &["material.shear_n_per_m", "missing", "column"]);
    let mut beyond = rest.clone();
    beyond["row"] = json!(3);
    fails(beyond, &["material.row", "is 3", "1 to 2"]);
    fails(json!("gone.json"), &["material.of", "gone.json", "denim", "ponte"]);
    fails(json!({ "of": "denim", "row": 1 }), &["material.row", "only a table"]);
    write("broken.json", "{ \"format\": \"drape-material/1\" }");
    fails(json!("broken.json"), &["material.of", "missing field", "drape-material/1"]);
    write("zero.json", &Material::text("denim").unwrap().replace("0.324", "0"));
    fails(json!("zero.json"), &["areal_density_kg_m2", "is 0", "above 0"]);
    write("broken.csv", "a,b\n1,2\n");
    fails(json!({ "of": "broken.csv", "row": 1 }), &["line 1", "density[kg.m-2]"]);
}

#[test]
fn a_table_refuses_what_is_no_number() {
    let head = "density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9]\n";
    let fails = |text: &str, words: &[&str]| {
        let message = Table::parse(text, "table").unwrap_err().to_string();
        words.iter().for_each(|word| assert!(message.contains(word), "{word}: {message}"));
    };
    fails("", &["line 1", "density"]);
    fails(head, &["without rows"]);
    fails(&format!("{head}0.1,1,2\n0.1,x,2\n"), &["line 3, linear warp", "\"x\"", "a number"]);
    fails(&format!("{head}0.1,1\n"), &["line 2, linear weft", "missing", "column 3"]);
    fails(&format!("{head}0.1,-1,2\n"), &["line 2, linear warp", "-1", "above 0"]);
    fails(&format!("{head}nan,1,2\n"), &["line 2, density", "NaN", "above 0"]);
    let swapped =
        "linear weft[SI*1e9], more, density[kg.m-2], linear warp[SI*1e9]\r\n2,-,0.1,1\r\n";
    let row = Table::parse(swapped, "table").unwrap().rows[0];
    near(row.bending_n_m.weft, 2e-9, 1e-12);
    assert_eq!((row.areal_density_kg_m2, row.diagonal_n_m), (0.1, None));
}

#[test]
fn materials_that_make_no_sense_are_refused() {
    let fails = |scene: Value, path: &str, words: &[&str]| {
        let message = read(&scene).unwrap_err();
        assert!(message.contains(&format!("`{path}`")), "{message}");
        words.iter().for_each(|word| assert!(message.contains(word), "{word}: {message}"));
    };
    let of = |material| grid(4, 5, material);
    fails(of(json!("silk")), "material.of", &["\"silk\"", "denim"]);
    fails(of(json!(5)), "material", &["5", "name of a material"]);
    fails(of(json!({ "off": "denim" })), "material.off", &["unknown", "`of`"]);
    fails(of(json!({})), "material.areal_density_kg_m2", &["missing", "`of`"]);
    let zero = json!({ "of": "denim", "bending_n_m": { "warp": 0, "weft": 1 } });
    fails(of(zero), "material.bending_n_m.warp", &["is 0", "above 0"]);
    let half = json!({ "of": "denim", "tension_n_per_m": { "warp": 1 } });
    fails(of(half), "material.tension_n_per_m.weft", &["missing"]);
    fails(of(json!({ "of": "denim", "retardation_s": -1 })), "material.retardation_s", &["-1"]);
    fails(of(json!({ "of": "denim", "hinge_fit": "x" })), "material.hinge_fit", &["sheet"]);
    fails(grid(1, 5, json!("denim")), "cloth.grid.mass_kg", &["missing", "no area"]);
    // Long cells: the diagonals would be stiffer than the warp.
    fails(grid(40, 4, json!("denim")), "material.shear_n_per_m", &["diagonal", "angles"]);
    assert!(read(&grid(40, 4, json!({ "of": "denim", "shear_model": "angles" }))).is_ok());
    let mut particles = of(json!("denim"));
    particles["cloth"] = json!({ "particles": { "particles": { "mass_kg": [1],
        "position_m": [[0, 0, 0]] } } });
    fails(particles, "material", &["explicit particles"]);
    let mut none = of(json!("denim"));
    none.as_object_mut().unwrap().remove("material");
    fails(none, "cloth.grid.mass_kg", &["missing", "`material`"]);
    let mut sheet = of(json!({ "of": "denim", "directions": "mean", "bending_model": "angles" }));
    sheet["cloth"] = json!({ "mesh": { "file": "bundled:sheet.obj" } });
    fails(sheet.clone(), "material.bending_model", &["mesh"]);
    sheet["material"] = json!("denim");
    fails(sheet.clone(), "material.directions", &["texture", "mean"]);
    sheet.as_object_mut().unwrap().remove("material");
    fails(sheet, "cloth.mesh.areal_density_kg_m2", &["missing", "`material`"]);
}

#[test]
fn a_rotated_grid_is_the_same_sheet_elsewhere() {
    let mut scene = grid(6, 9, json!("denim"));
    scene["cloth"]["grid"]["center_m"] = json!([0.1, 0.2, 0.3]);
    let flat = spec(&scene);
    scene["cloth"]["grid"]["rotation"] = json!({ "axis": [1, 0, 0], "angle_deg": 90 });
    let file = read(&scene).unwrap();
    let turned = file.spec();
    let text = serde_json::to_value(file.scene().unwrap()).unwrap();
    assert_eq!(read(&text).unwrap(), file);
    for (flat, turned) in flat.particles.position_m.iter().zip(&turned.particles.position_m) {
        // y goes to z about the centre.
        let expected = [flat[0], 0.2, 0.3 + (flat[1] - 0.2)];
        let far = [0, 1, 2].map(|k| (turned[k] - expected[k]).abs());
        assert!(far.iter().all(|far| *far < 1e-15), "{turned:?} {expected:?}");
    }
    assert_eq!(flat.springs, turned.springs);
    assert_eq!(flat.particles.mass_kg, turned.particles.mass_kg);
    assert_eq!(flat.triangles, turned.triangles);
    let hinges = flat.hinges.iter().zip(&turned.hinges);
    hinges.for_each(|(a, b)| near(a.stiffness_n_m, b.stiffness_n_m, 1e-12));
    for (key, value, word) in
        [("axis", json!([0, 0, 0]), "longer than"), ("angle_deg", json!(361), "from -360 to 360")]
    {
        let mut broken = scene.clone();
        broken["cloth"]["grid"]["rotation"][key] = value;
        let message = read(&broken).unwrap_err();
        assert!(message.contains(&format!("`cloth.grid.rotation.{key}`")), "{message}");
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn specimens_are_scenes() {
    let material = MaterialChoice::named("denim");
    let strip =
        Strip { length_m: 0.1, width_m: 0.02, segments: 20, rows: 3, material: material.clone() };
    let spec = strip.scene().discretise().unwrap();
    // The clamp is in the middle of the held edge, at x = 0.
    let x: Vec<f64> = spec.particles.position_m.iter().map(|x| x[0]).collect();
    near(x[20], 0.1, 1e-12);
    near(x[1], -x[0], 1e-9);
    assert_eq!(spec.pins.len(), 6);
    near(strip.gamma().unwrap(), 0.324 * 9.81 * 1e-3 / 6.094e-5, 1e-12);
    for (cells, warp_deg) in [(10, 0.0), (20, 30.0), (41, 45.0)] {
        let disc =
            Disc { radius_m: 0.15, support_m: 0.09, cells, warp_deg, material: material.clone() };
        let spec = disc.scene().unwrap().discretise().unwrap();
        let total: f64 = spec.particles.mass_kg.iter().sum();
        let area = std::f64::consts::PI * 0.15 * 0.15;
        // An inscribed polygon is smaller.
        let ratio = total / (0.324 * area);
        assert!(ratio < 1.0 && ratio > 1.0 - 2.0 / f64::from(cells), "{cells}: {ratio}");
        assert!(!spec.pins.is_empty());
        let support = |x: &[f64; 3]| x[0].hypot(x[1]) <= 0.09 * (1.0 + 1e-6);
        assert!(
            spec.pins.iter().all(|pin| support(&spec.particles.position_m[pin.particle as usize]))
        );
    }
    let given = MaterialChoice::given(&Material::load("denim").unwrap());
    assert_eq!(given.tension_n_per_m, Some(Woven { warp: 205.4, weft: 1014.0 }));
}

/// Energy per area, over `½ k`, of hinges of stiffness `k` on a sheet with the curvatures
/// `κ₁, κ₂, κ₁₂`, as a symmetric matrix; from the hinges whose edges are in the window.
fn bending_matrix(spec: &SystemSpec, window: [f64; 4], area: f64) -> [[f64; 3]; 3] {
    let flat: Vec<Vec3> = spec.particles.position_m.iter().map(|x| Vec3::from(*x)).collect();
    let mut inside = spec.clone();
    inside.springs.clear();
    inside.hinges.retain(|hinge| {
        let middle = (flat[hinge.i as usize] + flat[hinge.j as usize]) * 0.5;
        (window[0]..window[1]).contains(&middle.x) && (window[2]..window[3]).contains(&middle.y)
    });
    let (system, _) = inside.build().unwrap();
    let small = 1e-4;
    let of = |k: [f64; 3]| {
        let height = |x: &Vec3| 0.5 * (k[0] * x.x * x.x + k[1] * x.y * x.y) + k[2] * x.x * x.y;
        let x: Vec<Vec3> = flat.iter().map(|x| Vec3::new(x.x, x.y, small * height(x))).collect();
        energy_of(&system, &x) / (0.5 * small * small * area)
    };
    let unit = |i: usize, j: usize| {
        let mut k = [0.0; 3];
        k[i] += 1.0;
        k[j] += 1.0;
        of(k)
    };
    let single = |i: usize| 0.25 * unit(i, i);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if i == j { single(i) } else { 0.5 * (unit(i, j) - single(i) - single(j)) }
        })
    })
}

/// Rigidity of a narrow strip: the least energy over the other curvatures.
fn of_strip(d: [[f64; 3]; 3]) -> f64 {
    let determinant = d[1][1] * d[2][2] - d[1][2] * d[1][2];
    let [a, b] = [d[0][1], d[0][2]];
    let less = (a * a * d[2][2] - 2.0 * a * b * d[1][2] + b * b * d[1][1]) / determinant;
    d[0][0] - less
}

#[test]
fn hinges_bend_as_derived_on_squares_and_on_equilateral_triangles() {
    let even = |shear: f64| MaterialChoice {
        areal_density_kg_m2: Some(0.1),
        tension_n_per_m: Some(Woven::even(100.0)),
        shear_n_per_m: Some(shear),
        // So that the law's k is 1.
        bending_n_m: Some(Woven::even(3.0)),
        directions: Directions::Mean,
        ..MaterialChoice::default()
    };
    let compare = |found: [[f64; 3]; 3], expected: [[f64; 3]; 3], strip: f64| {
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found.abs() - expected).abs() < 1e-4, "{found:?} {expected:?}");
        }
        near(of_strip(found), strip, 1e-5);
    };
    // Squares of 1 m, cut along one diagonal.
    let mut scene = grid(11, 11, serde_json::to_value(even(10.0)).unwrap());
    scene["cloth"]["grid"]["size_m"] = json!([10, 10]);
    let d = bending_matrix(&spec(&scene), [-2.99, 3.01, -2.99, 3.01], 36.0);
    compare(d, [[3.0, 0.0, 3.0], [0.0, 3.0, 3.0], [3.0, 3.0, 18.0]], 12.0 / 5.0);
    // Equilateral triangles with edges of 1 m.
    let (mut text, n, height) = (String::new(), 14, 0.75_f64.sqrt());
    for row in 0..n {
        for column in 0..n {
            let x = f64::from(column) - 7.0 + 0.5 * f64::from(row % 2);
            text += &format!("v {x} {} 0\n", height * (f64::from(row) - 7.0));
        }
    }
    for row in 0..n - 1 {
        for column in 0..n - 1 {
            let at = |row: i32, column: i32| row * n + column + 1;
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            text += &if row % 2 == 0 {
                format!("f {a} {b} {c}\nf {b} {d} {c}\n")
            } else {
                format!("f {a} {d} {c}\nf {a} {b} {d}\n")
            };
        }
    }
    let spec = mesh_scene(&text, even(100.0 / 3.0)).unwrap();
    let window = [-3.01, 2.99, height * -4.01, height * 3.99];
    let d = bending_matrix(&spec, window, 6.0 * 8.0 * height);
    // D = 3 k, ν = −1/3: D, ν D, and 2 (1 − ν) D for the twist.
    compare(d, [[3.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 8.0]], 8.0 / 3.0);
    near(d[0][1], -1.0, 1e-4);
}

#[test]
fn linear_bending_springs_have_no_rigidity() {
    let mut scene = grid(9, 13, json!(null));
    scene.as_object_mut().unwrap().remove("material");
    scene["cloth"]["grid"]["mass_kg"] = json!(0.01);
    scene["effects"] = json!({ "bending": { "stiffness_n_per_m": 1 } });
    let spec = spec(&scene);
    let bent = |radius: f64| {
        energy(&spec, |x| {
            Vec3::new(radius * (x.x / radius).sin(), x.y, radius * (x.x / radius).cos())
        })
    };
    // Half the curvature has a sixteenth of the energy; an elastic sheet would have a fourth. The
    // chord of an arc is shorter than that of a polygon, which changes the factor alone.
    let order = (bent(0.5) / bent(1.0)).log2();
    assert!((order - 4.0).abs() < 0.01, "{order}");
}

#[test]
fn springs_that_have_buckled_bend_with_the_rigidity_of_the_cloth() {
    let bending = Woven { warp: 6e-5, weft: 3e-5 };
    let choice = json!({ "of": "denim", "bending_n_m": bending, "bending_model": "buckling" });
    let mut spec = spec(&grid(9, 13, choice));
    spec.springs.retain(|spring| spring.buckling_rigidity_n_m2.is_some());
    let a = 0.3 / 12.0;
    // Rows as polygons that turn by the same angle at each particle and keep their lengths.
    let bent = |turn: f64| {
        let mut places = vec![[0.0, 0.0]];
        for k in 0..12 {
            let [x, z]: [f64; 2] = places[k];
            let angle = turn * k as f64;
            places.push([x + a * angle.cos(), z + a * angle.sin()]);
        }
        energy(&spec, |x| {
            let [place, height] = places[((x.x + 0.15) / a).round() as usize];
            Vec3::new(place, x.y, height)
        })
    };
    // Energy per area ½ B κ², but for a constant and the two half cells at the free ends.
    let [one, two] = [0.2, 0.3];
    let found = (bent(two) - bent(one)) / (two * two - one * one);
    near(found, 0.5 * bending.warp / (a * a) * (11.0 / 12.0), 0.01);
}
